//! Equilibria of the staggered rod by one step of infinite length.

use crate::common::{Elastica, HeavyRod, chain, planar_clamp, scaled};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use rapunzel_fiber::Fiber;
use rapunzel_oracles::cases;
use rapunzel_rod_dynamic::{
    End, Instant, Load, Rod, RodIntegrator, RodState, Staggered, equilibrium,
};
use rapunzel_rod_static::{Chain, Piece, Properties};
use std::f64::consts::PI;

fn natural(fiber: &Fiber) -> (Rod, RodState) {
    let rod = Rod::new(fiber.clone());
    let state = Staggered::new(rod.clone()).expect("a valid rod").state();
    (rod, state)
}

/// The tip of the equilibrium that the natural shape falls into.
fn tip(fiber: &Fiber, conditions: &Instant) -> Vector3<f64> {
    let (rod, start) = natural(fiber);
    let (state, _) = equilibrium(&rod, conditions, &start).expect("an equilibrium");
    state.positions[fiber.segments()].coords
}

/// All cases, S1 and S6 among them. The joint at the clamp stands for half a segment but takes its
/// moment from the end of that, so the rod's angle there is off by `kappa' h^2 / 8`, which the
/// boundary layer of length `1 / sqrt(G)` turns into `sqrt(G) h^2 / 8` at the tip; chords and
/// lumped loads add as much at most, and `h^2 / 12` times what natural curvature varies by.
/// Extrapolated from 200 and 400 segments, 1e-6 remain. Upright rods fall either way, the mirror
/// image counts too, and a rod in space may fall out of the plane.
#[test]
fn heavy_planar_rods_hang_as_the_reference() {
    let cases: Vec<Elastica> = cases("b_heavy_elastica_planar.json").expect("the oracle");
    for case in &cases {
        let kappa0 = |s: f64| case.natural_curvature(s);
        let root = planar_clamp(case.clamp_angle_deg.to_radians());
        let hang = |segments: usize| {
            let fiber = chain(segments, |s| {
                let mut node = scaled(1.0 / case.g, 1.0 / case.g);
                node.natural_curvature.x = kappa0(s);
                node
            });
            let tip =
                tip(&fiber.with_root(root), &Instant::clamped(root, Vector3::new(0.0, -1.0, 0.0)));
            if case.clamp_angle_deg == 90.0 {
                Vector3::new(tip.x.hypot(tip.z), tip.y, 0.0)
            } else {
                tip
            }
        };
        let (coarse, raw, fine) = (hang(100), hang(200), hang(400));
        let extrapolated = (4.0 * fine - raw) / 3.0;
        let off = |tip: &Vector3<f64>| {
            let stable = case.equilibria.iter().filter(|e| e.stable);
            let exact = stable.map(|e| {
                let x = if case.clamp_angle_deg == 90.0 { e.tip[0].abs() } else { e.tip[0] };
                Vector3::new(x, e.tip[1], 0.0)
            });
            exact.map(|exact| (tip - exact).norm()).fold(f64::MAX, f64::min)
        };
        let variation = (0..=100)
            .map(|i| f64::from(i) / 100.0)
            .map(|s| kappa0(s).powi(2) + (kappa0(s + 1e-4) - kappa0(s)).abs() / 1e-4)
            .fold(0.0, f64::max);
        let near = case.sensitivity();
        let bound = 1e-4 * near * (2.0 * case.g.max(1.0).sqrt() / 8.0 + variation / 12.0);
        assert!(off(&coarse) < bound, "{}: {:e} of {bound:e}", case.name, off(&coarse));
        assert!(off(&extrapolated) < 1e-6 * near, "{}: {:e}", case.name, off(&extrapolated));
    }
}

/// All cases, followed from no gravity to all of it. Chords lie `(kappa h)^2 / 24` inside a helix.
#[test]
fn heavy_curled_rods_hang_as_the_reference() {
    let cases: Vec<HeavyRod> = cases("b_heavy_rod_3d.json").expect("the oracle");
    for case in &cases {
        let hang = |segments: usize| {
            let fiber = case.fiber(segments);
            let (rod, mut state) = natural(&fiber);
            for part in 1..=10 {
                let g = Vector3::new(0.0, 0.0, -case.g * f64::from(part) / 10.0);
                let conditions = Instant::clamped(*fiber.root(), g);
                state = equilibrium(&rod, &conditions, &state).expect("an equilibrium").0;
            }
            state.positions[segments].coords
        };
        let (coarse, raw, fine) = (hang(100), hang(200), hang(400));
        let exact = Vector3::from(case.tip);
        let bound =
            1e-4 * (1.5 * case.g.sqrt() / 8.0 + Vector3::from(case.kappa0).norm_squared() / 24.0);
        let error = (coarse - exact).norm();
        assert!(error < bound, "{}: {error:e} of {bound:e}", case.name);
        let extrapolated = ((4.0 * fine - raw) / 3.0 - exact).norm();
        assert!(extrapolated < 1e-6, "{}: {extrapolated:e}", case.name);
    }
}

/// S2: the cantilever under a dead end load, elliptic integrals (Bisshopp and Drucker 1945).
#[test]
fn dead_tip_load() {
    for (a, shortening, drop) in [
        (1.0, 0.056_433_24, 0.301_720_77),
        (2.0, 0.160_641_72, 0.493_457_48),
        (5.0, 0.387_628_36, 0.713_791_52),
        (10.0, 0.554_995_60, 0.810_609_02),
    ] {
        let fiber = chain(100, |_| scaled(1.0, 1.0)).with_root(planar_clamp(0.0));
        let force = Load::World(Vector3::new(0.0, -a, 0.0));
        let pulled = Instant {
            tip: End::Loaded { force, moment: Load::ZERO },
            ..Instant::clamped(*fiber.root(), Vector3::zeros())
        };
        let error = (tip(&fiber, &pulled) - Vector3::new(1.0 - shortening, -drop, 0.0)).norm();
        assert!(error < 1e-4, "load {a}: tip off by {error:e}");
    }
}

/// S3: an end moment of 2 pi B / L bends the rod to a closed circle, exactly.
#[test]
fn end_moment_closes_a_circle() {
    let fiber = chain(100, |_| scaled(1.0, 1.0)).with_root(planar_clamp(0.0));
    let (rod, mut state) = natural(&fiber);
    for part in 1..=8 {
        let moment = Load::World(Vector3::new(0.0, 0.0, 2.0 * PI * f64::from(part) / 8.0));
        let bent = Instant {
            tip: End::Loaded { force: Load::ZERO, moment },
            ..Instant::clamped(*fiber.root(), Vector3::zeros())
        };
        state = equilibrium(&rod, &bent, &state).expect("an equilibrium").0;
    }
    let gap = (state.positions[100] - state.positions[0]).norm();
    assert!(gap < 1e-12, "open by {gap:e}");
}

/// Rods that hang straight down and curl in one plane, where they may have no minimum: the stable
/// equilibrium of the static chain, to the order of the segments.
#[test]
fn curls_that_hang_come_to_rest() {
    for (g, k, segments) in
        [(40.0, 8.0, 100), (60.0, 10.0, 50), (100.0, 10.0, 50), (100.0, 10.0, 100), (80.0, 9.0, 70)]
    {
        let down = UnitQuaternion::from_scaled_axis(Vector3::x() * PI);
        let root = Isometry3::from_parts(Vector3::zeros().into(), down);
        let mut node = scaled(1.0, 1.0);
        node.natural_curvature.x = k;
        let fiber = chain(segments, |_| node).with_root(root);
        let hang = Instant::clamped(root, Vector3::new(0.0, 0.0, -g));
        let (rod, start) = natural(&fiber);
        let (state, _) = equilibrium(&rod, &hang, &start).expect("an equilibrium");
        let properties = Properties {
            stiffness: node.stiffness,
            natural_curvature: node.natural_curvature,
            load: hang.gravity,
        };
        let exact = Chain::new(&root, &[Piece::uniform(1.0, properties)], segments);
        let rest = exact.expect("a chain").solve().expect("a minimum");
        let tip = rest.shape.positions()[segments];
        // The mirror image is an equilibrium too.
        let off = [1.0, -1.0].map(|side| {
            let own = state.positions[segments];
            (own - Point3::new(side * tip.x, tip.y, tip.z)).norm()
        });
        let h = 1.0 / segments as f64;
        let bound = (k * k / 8.0 + g.sqrt()) * h * h;
        assert!(off[0].min(off[1]) < bound, "{g} {k} {segments}: {off:?} of {bound:e}");
    }
}
