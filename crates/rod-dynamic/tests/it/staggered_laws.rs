//! Sections with laws: the linear one gives the rod without, a law that stiffens its closed form,
//! one with memory its checkpoint, and the ledger closes.

use nalgebra::{Matrix3, Translation3, Vector3};
use rapunzel_fiber::{Fiber, LinearLaw, Material, Section, SectionLaw, SectionResponse};
use rapunzel_rod_dynamic::{
    BoxIntegrator, BoxOptions, Conditions, End, Instant, Load, Rod, RodError, RodStepReport,
    SectionLaws, StaggeredBatch, Steady,
};
use std::sync::Arc;

const SEGMENTS: usize = 20;

fn fiber(curl: Vector3<f64>) -> Fiber {
    let section = Section::Ellipse { a: 45e-6, b: 30e-6 };
    Fiber::uniform(0.1, SEGMENTS, section, &Material::HAIR)
        .and_then(|f| f.with_natural_curvature(|_| curl))
        .expect("valid")
        .with_root(crate::common::planar_clamp(0.4))
}

fn with_law(fiber: Fiber, law: impl SectionLaw + 'static) -> Rod {
    Rod { laws: SectionLaws::Same(Arc::new(law)), ..Rod::new(fiber) }
}

/// `m = K (1 + c |e|^2) e`: not affine, and its tangent is not diagonal.
#[derive(Debug)]
struct Stiffening {
    stiffness: f64,
    factor: f64,
}

impl SectionLaw for Stiffening {
    fn memory(&self) -> usize {
        0
    }
    fn response(&self, _: &[Vector3<f64>], strain: &Vector3<f64>, _: f64) -> SectionResponse {
        let (k, c, square) = (self.stiffness, self.factor, strain.norm_squared());
        SectionResponse {
            moment: k * (1.0 + c * square) * strain,
            tangent: k
                * ((1.0 + c * square) * Matrix3::identity()
                    + 2.0 * c * strain * strain.transpose()),
            potential: self.stored_energy(&[], strain),
        }
    }
    fn commit(&self, _: &mut [Vector3<f64>], _: &Vector3<f64>, _: f64) {}
    fn dissipated(&self, _: &[Vector3<f64>], _: &Vector3<f64>, _: f64) -> f64 {
        0.0
    }
    fn stored_energy(&self, _: &[Vector3<f64>], strain: &Vector3<f64>) -> f64 {
        let square = strain.norm_squared();
        0.5 * self.stiffness * square * (1.0 + 0.5 * self.factor * square)
    }
}

/// A Maxwell element beside a spring, by the implicit rule: `q' = K (q + e' - e) / (1 + dt / tau)`.
#[derive(Debug)]
struct Solid {
    stiffness: f64,
    time: f64,
}

impl SectionLaw for Solid {
    fn memory(&self) -> usize {
        2
    }
    fn is_affine(&self) -> bool {
        true
    }
    fn response(&self, memory: &[Vector3<f64>], strain: &Vector3<f64>, dt: f64) -> SectionResponse {
        let left = 1.0 / (1.0 + dt / self.time);
        let q = left * (memory[1] + strain - memory[0]);
        let slope = self.stiffness * (1.0 + left);
        let rise = strain - memory[0];
        let moment = self.stiffness * (strain + q);
        SectionResponse {
            moment,
            tangent: slope * Matrix3::identity(),
            potential: (moment - 0.5 * slope * rise).dot(&rise),
        }
    }
    fn commit(&self, memory: &mut [Vector3<f64>], strain: &Vector3<f64>, dt: f64) {
        let q = (memory[1] + strain - memory[0]) / (1.0 + dt / self.time);
        memory.copy_from_slice(&[*strain, q]);
    }
    fn dissipated(&self, memory: &[Vector3<f64>], strain: &Vector3<f64>, dt: f64) -> f64 {
        let rise = strain - memory[0];
        let q = (memory[1] + rise) / (1.0 + dt / self.time);
        let mean = 0.5 * (q + memory[1]);
        self.stiffness * mean.dot(&(rise - (q - memory[1])))
    }
    fn stored_energy(&self, memory: &[Vector3<f64>], strain: &Vector3<f64>) -> f64 {
        0.5 * self.stiffness * (strain.norm_squared() + memory[1].norm_squared())
    }
}

fn bending() -> f64 {
    Material::HAIR.youngs_modulus * Section::Circle { radius: 35e-6 }.second_moments()[0]
}

/// A clamp that is shaken, gravity, and a force that follows the tip.
fn shaken(t: f64) -> Instant {
    let root =
        Translation3::new(0.005 * (9.0 * t).sin(), 0.0, 0.0) * crate::common::planar_clamp(0.4);
    let force = Load::Follower(Vector3::new(1e-7, 0.0, 2e-7));
    Instant {
        root: End::Held(root),
        tip: End::Loaded { force, moment: Load::ZERO },
        ..Instant::clamped(root, crate::common::GRAVITY)
    }
}

fn run(batch: &mut StaggeredBatch, steps: usize, conditions: &dyn Conditions) {
    let conditions = vec![conditions; batch.rods().len()];
    let mut reports = vec![RodStepReport::default(); conditions.len()];
    for _ in 0..steps {
        batch.step(0.01, &conditions, &mut reports).expect("a step");
    }
}

#[test]
fn the_linear_law_gives_the_rod_without_a_law_to_rounding() {
    let plain = fiber(Vector3::new(3.0, 10.0, 20.0));
    let law = LinearLaw { stiffness: plain.nodes()[0].stiffness };
    let [mut a, mut b] = [Rod::new(plain.clone()), with_law(plain, law)]
        .map(|rod| StaggeredBatch::new(vec![rod], 0.3).expect("valid"));
    run(&mut a, 100, &shaken);
    run(&mut b, 100, &shaken);
    let (a, b) = (a.state(0), b.state(0));
    let off = a.positions.iter().zip(&b.positions).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    // Newton's tolerance of 1e-13 rad in each of 100 steps, over the length of 0.1 m.
    assert!(off < 1e-12, "{off:e}");
}

#[test]
fn a_rod_that_stiffens_bends_as_its_law_says() {
    // A moment at the tip alone: the curvature is the root of k (1 + c k^2) = M / K everywhere.
    let (stiffness, factor, kappa) = (bending(), 4e-4, 60.0);
    let moment = stiffness * (1.0 + factor * kappa * kappa) * kappa;
    let straight = fiber(Vector3::zeros());
    let root = *straight.root();
    let mut conditions = Instant::clamped(root, Vector3::zeros());
    conditions.tip =
        End::Loaded { force: Load::ZERO, moment: Load::Follower(moment * Vector3::x()) };
    let rod = with_law(straight, Stiffening { stiffness, factor });
    let mut batch = StaggeredBatch::backward_euler(vec![rod]).expect("valid");
    let mut reports = [RodStepReport::default()];
    for _ in 0..3 {
        // Long steps: only the equilibrium is left.
        batch.step(10.0, &[&Steady(conditions)], &mut reports).expect("a step");
    }
    for (j, curvature) in batch.state(0).curvatures.iter().enumerate().take(SEGMENTS) {
        // Chords of joints that turn by 0.3 rad: exact, since a joint has the turn of its arc.
        assert!((curvature - kappa * Vector3::x()).norm() < 1e-8 * kappa, "{j} {curvature}");
    }
}

#[test]
fn the_ledger_of_a_law_closes() {
    let curl = Vector3::new(3.0, 10.0, 20.0);
    let solid = Solid { stiffness: bending(), time: 0.05 };
    let stiffening = Stiffening { stiffness: bending(), factor: 1e-3 };
    for (rod, loses) in
        [(with_law(fiber(curl), solid), true), (with_law(fiber(curl), stiffening), false)]
    {
        for rho in [None, Some(0.3)] {
            let rods = vec![rod.clone()];
            let mut batch = match rho {
                None => StaggeredBatch::backward_euler(rods),
                Some(rho) => StaggeredBatch::new(rods, rho),
            }
            .expect("valid");
            batch.keep_ledgers(true);
            let zero = Vector3::zeros();
            let (mut worst, mut damping): (f64, f64) = (0.0, 0.0);
            for _ in 0..60 {
                let before = batch.energy(0, &zero);
                run(&mut batch, 1, &shaken);
                let after = batch.energy(0, &zero);
                let ledger = batch.ledger(0).expect("kept");
                let scale = ledger.kinetic.abs()
                    + ledger.elastic.abs()
                    + ledger.gravity.abs()
                    + ledger.integrator.abs()
                    + ledger.supports.abs()
                    + after.elastic;
                worst = worst.max((ledger.gain() - ledger.work()).abs() / scale);
                let elastic = after.elastic - before.elastic;
                let kinetic = after.kinetic - before.kinetic;
                worst = worst.max((ledger.elastic - elastic).abs() / scale);
                worst = worst.max((ledger.kinetic - kinetic).abs() / scale);
                assert!(ledger.damping <= 0.0, "{}", ledger.damping);
                damping += ledger.damping;
            }
            // Rounding of the energies of 60 numbers.
            assert!(worst < 1e-11, "{rho:?}: {worst:e}");
            assert_eq!(damping < 0.0, loses, "{damping}");
        }
    }
}

#[test]
fn memory_is_saved_and_company_changes_nothing() {
    let rods = || {
        let curl = Vector3::new(3.0, 10.0, 20.0);
        let solid = with_law(fiber(curl), Solid { stiffness: bending(), time: 0.05 });
        let stiffening = Stiffening { stiffness: bending(), factor: 1e-3 };
        vec![solid, Rod::new(fiber(curl)), with_law(fiber(curl), stiffening)]
    };
    let bits = |batch: &StaggeredBatch, i: usize| -> Vec<u64> {
        batch.state(i).positions.iter().flat_map(|p| p.coords.map(f64::to_bits).data.0[0]).collect()
    };
    let mut together = StaggeredBatch::new(rods(), 0.3).expect("valid");
    run(&mut together, 30, &shaken);
    let mut numbers = Vec::new();
    together.save(&mut numbers);
    run(&mut together, 30, &shaken);
    let mut resumed = StaggeredBatch::new(rods(), 0.3).expect("valid");
    resumed.restore(&numbers).expect("the same rods");
    run(&mut resumed, 30, &shaken);
    for (i, rod) in rods().into_iter().enumerate() {
        let mut alone = StaggeredBatch::new(vec![rod], 0.3).expect("valid");
        run(&mut alone, 60, &shaken);
        assert_eq!(bits(&together, i), bits(&resumed, i));
        assert_eq!(bits(&together, i), bits(&alone, 0), "rod {i}");
    }
}

#[test]
fn a_rod_that_is_set_bent_is_bent_at_once() {
    // Both springs of the solid: twice the energy of one.
    let stiffness = bending();
    let rod = with_law(fiber(Vector3::zeros()), Solid { stiffness, time: 1e-3 });
    let mut batch = StaggeredBatch::new(vec![rod.clone()], 0.3).expect("valid");
    let bent = StaggeredBatch::new(vec![Rod::new(fiber(Vector3::new(20.0, 0.0, 0.0)))], 0.3)
        .expect("valid")
        .state(0);
    batch.set_state(0, &bent).expect("it fits");
    let energy = batch.energy(0, &Vector3::zeros()).elastic;
    let expected = 0.5 * 2.0 * stiffness * 20.0_f64.powi(2) * 0.1;
    assert!((energy / expected - 1.0).abs() < 1e-12, "{energy} {expected}");
}

#[test]
fn laws_that_do_not_fit_are_refused() {
    let law: Arc<dyn SectionLaw> = Arc::new(Solid { stiffness: 1e-9, time: 1.0 });
    let of = |laws, damping_time| Rod { laws, damping_time, ..Rod::new(fiber(Vector3::zeros())) };
    let few = of(SectionLaws::Each(vec![Arc::clone(&law); SEGMENTS]), 0.0);
    let refused = StaggeredBatch::new(vec![few], 0.3);
    assert!(matches!(refused, Err(RodError::Length { what: "laws", .. })));
    let damped = of(SectionLaws::Same(Arc::clone(&law)), 0.1);
    assert!(StaggeredBatch::new(vec![damped], 0.3).is_err());
    let fine = of(SectionLaws::Each(vec![Arc::clone(&law); SEGMENTS + 1]), 0.0);
    assert!(BoxIntegrator::new(fine.clone(), BoxOptions::default()).is_err());
    let mut batch = StaggeredBatch::new(vec![fine], 0.3).expect("one a node");
    assert!(batch.set_laws(0, SectionLaws::Linear).is_err(), "it remembers less");
    assert!(batch.set_laws(0, SectionLaws::Same(law)).is_ok());
}
