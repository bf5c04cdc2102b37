//! Minima of the energy of chains against exact rods.

use crate::common::Random;
use crate::common::reference::{Elastica, HeavyRod};
use nalgebra::{Isometry3, Point3, Vector3};
use proptest::prelude::*;
use rapunzel_oracles::cases;
use rapunzel_rod_static::{
    Chain, EndCondition, Piece, Problem, Properties, Rest, StaticError, Target,
};
use std::f64::consts::{FRAC_PI_2, PI};

fn chain(clamp: &Isometry3<f64>, piece: &Piece, count: usize) -> Chain {
    Chain::new(clamp, std::slice::from_ref(piece), count).expect("a chain")
}

fn tip(rest: &Rest) -> Point3<f64> {
    *rest.shape.positions().last().expect("a tip")
}

/// Level rods under any load. A segment's mean curvature is off by `kappa'' h^2 / 24`; where the
/// rod turns by a right angle over the length `1 / sqrt(G)`, that moves the tip by `pi / 48 sqrt(G)
/// h^2`. Twice that, and that of the unit rod, are allowed.
#[test]
fn heavy_cantilevers_are_as_exact_as_segments_can_be() {
    let level = |case: &Elastica| case.clamp_angle_deg == 0.0 && case.kappa0 == "0";
    let cases = cases::<Elastica>("b_heavy_elastica_planar.json").expect("the oracle");
    for case in cases.iter().filter(|c| level(c)) {
        let rest = chain(&case.clamp(), &case.piece(), 100).solve().expect("a minimum");
        let error = (tip(&rest) - case.lowest().tip()).norm();
        let allowed = PI / 24.0 * (1.0 + case.g.sqrt()) * 1e-4;
        assert!(error < allowed, "{}: {error:e} of {allowed:e}", case.name);
    }
}

/// From the natural shape a stable equilibrium of the list is reached, upright rods leave their
/// saddle, and the error falls with the square of the segments' length.
#[test]
fn planar_chains_find_a_stable_equilibrium() {
    for case in cases::<Elastica>("b_heavy_elastica_planar.json").expect("the oracle") {
        let rests = [100, 200].map(|count| {
            let chain = chain(&case.clamp(), &case.piece(), count);
            let rest = chain.solve().unwrap_or_else(|e| panic!("{}: {e}", case.name));
            let moment = chain.states(&rest)[0].moment.z;
            (rest, moment)
        });
        let ends = rests.each_ref().map(|(rest, _)| tip(rest));
        // The plane of an upright rod that buckles is any.
        let upright = case.clamp_angle_deg == 90.0;
        let error = |tip: &Point3<f64>, at: &Point3<f64>| {
            if upright { (tip.y - at.y).abs() } else { (tip - at).norm() }
        };
        let nearest = |tip: &Point3<f64>| {
            let stable = case.equilibria.iter().filter(|e| e.stable);
            stable.min_by(|a, b| error(tip, &a.tip()).total_cmp(&error(tip, &b.tip())))
        };
        let found = ends.each_ref().map(|tip| nearest(tip).expect("a stable equilibrium"));
        let (length, name) = (1.0 / 200.0_f64, &case.name);
        let [coarse, fine] = [0, 1].map(|i| error(&ends[i], &found[i].tip()));
        assert!(coarse < 16.0 * length * length * (1.0 + case.g.sqrt()), "{name}: {coarse:e}");
        assert!(fine < 4.0 * length * length * (1.0 + case.g.sqrt()), "{name}: {fine:e}");
        // A rod almost upright may fall to either side.
        if found[0].energy == found[1].energy && coarse > 1e-9 {
            let ratio = coarse / fine;
            assert!((3.5..4.6).contains(&ratio), "{name}: {coarse:e} {fine:e}");
        }
        let moment = (rests[1].1.abs() - found[1].root_moment.abs()).abs();
        assert!(moment < 100.0 * length * length * (1.0 + case.g), "{name}: {moment:e}");
    }
}

#[test]
fn heavy_chains_of_the_reference() {
    for case in cases::<HeavyRod>("b_heavy_rod_3d.json").expect("the oracle") {
        let exact = case.stations.last().expect("a tip");
        let solve = |count| chain(&case.clamp(), &case.piece(), count).solve().expect("a minimum");
        let [coarse, fine] = [100, 200].map(solve);
        let error = |tip: Point3<f64>| (tip - Point3::from(exact.r)).norm();
        let (first, second) = (error(tip(&coarse)), error(tip(&fine)));
        assert!((3.5..4.5).contains(&(first / second)), "{}: {first:e} {second:e}", case.name);
        let better = coarse.shape.extrapolated(&fine.shape).expect("twice as many");
        let third = error(better[100]);
        assert!(third < 0.02 * second, "{}: {second:e}, extrapolated {third:e}", case.name);
        // The moment at the clamp to second order too.
        let chain = chain(&case.clamp(), &case.piece(), 200);
        let moment = chain.states(&fine)[0].moment - Vector3::from(case.stations[0].m_fixed);
        assert!(moment.norm() < 1e-3 * (1.0 + case.g), "{}: {}", case.name, moment.norm());
    }
}

/// A round rod that stands exactly upright under more than Greenhill's load may lean any way: it
/// leans as far as a flat one, which can only lean across its flat side. Below that load it stands.
#[test]
fn round_upright_rods_buckle() {
    let height = |across: f64, torsion: f64, load: f64, count: usize| {
        let piece = Piece::uniform(
            1.0,
            Properties {
                stiffness: Vector3::new(1.0, across, torsion),
                natural_curvature: Vector3::zeros(),
                load: Vector3::new(0.0, 0.0, -load),
            },
        );
        let rest = chain(&Isometry3::identity(), &piece, count).solve();
        tip(&rest.unwrap_or_else(|e| panic!("{count} segments, load {load}: {e}"))).z
    };
    for (count, most) in [(20, 100.0), (50, 1e3), (200, 1e4)] {
        for torsion in [0.3, 0.75, 1.0] {
            assert!((height(1.0, torsion, 7.0, count) - 1.0).abs() < 1e-13);
            let loads = [7.9, 8.0, 20.0, 55.0, 100.0, 300.0, 1e3, 1e4];
            for load in loads.into_iter().filter(|load| *load <= most) {
                let round = height(1.0, torsion, load, count);
                let flat = height(8.0, torsion, load, count);
                let error = (round - flat).abs();
                assert!(error < 1e-8 && round < 0.99, "{count}, {load}: {round} {flat}");
            }
        }
    }
}

/// The least natural curvature tells a round rod where to lean: along a circle of shapes of nearly
/// one energy it comes there.
#[test]
fn almost_straight_upright_rods_lean_as_they_are_curved() {
    for load in [8.0, 20.0, 100.0, 219.0, 1e3] {
        for curvature in [1e-7, 3e-6, 1e-4, 1e-2] {
            for torsion in [0.3, 0.7, 1.0] {
                let piece = Piece::uniform(
                    1.0,
                    Properties {
                        stiffness: Vector3::new(1.0, 1.0, torsion),
                        natural_curvature: curvature * Vector3::new(0.3, 1.0, 0.0),
                        load: Vector3::new(0.0, 0.0, -load),
                    },
                );
                let rest = chain(&Isometry3::identity(), &piece, 100).solve().expect("a minimum");
                let tip = tip(&rest);
                let off = (tip.y / tip.x + 0.3).abs();
                // Newton's last step is below 1e-8, but the circle is almost flat.
                assert!(tip.x > 0.0 && off < 1e-3, "{load}, {curvature}, {torsion}: {tip}");
                assert!(rest.iterations < 50, "{load}, {curvature}: {}", rest.iterations);
            }
        }
    }
}

fn uniform(load: Vector3<f64>) -> Piece {
    Piece::uniform(
        1.0,
        Properties {
            stiffness: Vector3::new(1.0, 0.8, 0.75),
            natural_curvature: Vector3::new(0.0, 2.0, 1.0),
            load,
        },
    )
}

/// A tip that is held is a ball joint: the boundary value of the same rod.
#[test]
fn a_held_tip_is_a_ball_joint() {
    let piece = uniform(Vector3::new(0.0, 0.0, -3.0));
    for place in [Point3::new(0.3, 0.1, 0.7), Point3::new(-0.2, 0.0, 0.6), Point3::origin()] {
        let end = EndCondition::Position(place);
        let exact = Problem::new(&Isometry3::identity(), vec![piece.clone()], end)
            .and_then(|problem| problem.solve())
            .expect("a solution");
        let [coarse, fine] = [100, 200].map(|count| {
            let mut chain = chain(&Isometry3::identity(), &piece, count);
            chain.set_targets(&[Target::held(count, place)]).expect("a target");
            let rest = chain.solve().unwrap_or_else(|e| panic!("{place}: {e}"));
            assert!((tip(&rest) - place).norm() < 1e-12, "{place}");
            (rest.pulls[0] - exact.tip().force).norm()
        });
        let ratio = coarse / fine;
        assert!((3.5..4.5).contains(&ratio), "{place}: {coarse:e} {fine:e}");
    }
}

/// Fig. 3.12: a wound fiber of 50 cm in gravity nestles against two places; the stiffer the
/// springs the nearer, and held in the limit.
#[test]
fn springs_pull_a_wound_fiber_to_two_places() {
    let piece = Piece::uniform(
        0.5,
        Properties {
            stiffness: Vector3::new(1e-4, 1e-4, 7.5e-5),
            natural_curvature: Vector3::new(0.0, 25.0, 6.0),
            load: Vector3::new(0.0, 0.0, -0.01),
        },
    );
    let places = [Point3::new(0.12, 0.02, 0.02), Point3::new(0.22, -0.03, 0.1)];
    let mut missed = Vec::new();
    for stiffness in [0.1, 1.0, 10.0, f64::INFINITY] {
        let mut chain = chain(&Isometry3::identity(), &piece, 150);
        let target = |node, i: usize| Target { node, place: places[i], stiffness };
        chain.set_targets(&[target(75, 0), target(150, 1)]).expect("targets");
        let rest = chain.solve().unwrap_or_else(|e| panic!("{stiffness}: {e}"));
        let at = rest.shape.positions();
        let off = (at[75] - places[0]).norm().max((at[150] - places[1]).norm());
        if stiffness.is_finite() {
            let gradient = chain.gradient(&rest.shape).expect("a gradient");
            assert!(gradient.iter().all(|g| g.norm() < 1e-13), "{stiffness}");
        }
        missed.push(off);
    }
    assert!(missed.is_sorted_by(|a, b| a > b), "{missed:?}");
    assert!(missed[3] < 1e-12, "{missed:?}");
}

/// Straight and curled rods under small and large loads, free and held at their tips: almost all
/// are found, and they are in balance.
#[test]
fn random_rods_come_to_rest() {
    let mut random = Random::new(5);
    let (mut tried, mut found) = (0, 0);
    for (size, curl) in [10.0, 300.0, 1e4].into_iter().flat_map(|s| [(s, 0.0), (s, 6.0), (s, 30.0)])
    {
        for i in 0..40 {
            let properties = Properties {
                stiffness: Vector3::new(1.0, 0.7, 0.75),
                natural_curvature: random.direction() * curl,
                load: random.direction() * size,
            };
            let piece = Piece::uniform(1.0, properties).with_end_load(random.direction() * size);
            let mut chain = chain(&Isometry3::identity(), &piece, 100);
            let place = Point3::from(random.direction() * (0.9 * random.unit()));
            if i % 2 == 0 {
                chain.set_targets(&[Target::held(100, place)]).expect("a target");
            }
            tried += 1;
            let Ok(rest) = chain.solve() else { continue };
            found += 1;
            let states = chain.states(&rest);
            assert!(states[100].moment.norm() < 1e-10 * (1.0 + size), "{}", states[100].moment);
            assert!(i % 2 == 1 || (tip(&rest) - place).norm() < 1e-12, "{}", tip(&rest));
        }
    }
    assert!(f64::from(found) >= 0.995 * f64::from(tried), "{found} of {tried}");
}

/// A mass on the way bends the rod as a force on the same place does.
#[test]
fn masses_hang_on_the_way() {
    let half = |weight: f64| {
        let properties = Properties {
            stiffness: Vector3::new(1.0, 1.0, 0.75),
            natural_curvature: Vector3::zeros(),
            load: Vector3::zeros(),
        };
        Piece::uniform(0.5, properties).with_end_load(Vector3::new(0.0, 0.0, -weight))
    };
    let level = Isometry3::new(Vector3::zeros(), Vector3::y() * FRAC_PI_2);
    let pieces = [half(4.0), half(2.0)];
    let chain = Chain::new(&level, &pieces, 100).expect("a chain");
    let rest = chain.solve().expect("a minimum");
    let exact = Problem::new(&level, pieces.to_vec(), EndCondition::FREE).and_then(|p| p.solve());
    let error = (tip(&rest) - exact.expect("a solution").tip().position).norm();
    assert!(error < 2e-5, "{error:e}");
}

#[test]
fn many_chains_are_relaxed_as_one_by_one() {
    let piece = uniform(Vector3::new(0.0, 0.0, -10.0));
    let mut chains = vec![chain(&Isometry3::identity(), &piece, 50); 20];
    let starts: Vec<_> = chains.iter().map(|c| c.solve().expect("a minimum").shape).collect();
    for (i, chain) in chains.iter_mut().enumerate() {
        let mut forces = chain.forces().to_vec();
        forces[50].x += 0.1 * i as f64;
        chain.set_forces(&forces).expect("forces");
    }
    let all = Chain::relax_all(&chains, &starts).expect("as many starts");
    for ((chain, start), found) in chains.iter().zip(&starts).zip(all) {
        let one = chain.relax(start).expect("a minimum");
        let found = found.expect("a minimum");
        assert_eq!(found.shape, one.shape);
        assert!(found.iterations <= 5, "{}", found.iterations);
        let cold = chain.solve().expect("a minimum");
        assert!((tip(&cold) - tip(&found)).norm() < 1e-9);
    }
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Any load is carried; the result is a minimum: no rotation of the nodes lowers the energy.
    #[test]
    fn loads_are_carried(load in vector(60.0), force in vector(30.0), moved in vector(2.0),
                         place in vector(5.0), by in prop::collection::vec(vector(1.0), 40)) {
        let piece = uniform(load).with_end_load(force);
        let chain = chain(&Isometry3::identity(), &piece, 40);
        let rest = chain.solve().map_err(|e| TestCaseError::fail(e.to_string()))?;
        let gradient = chain.gradient(&rest.shape).expect("a gradient");
        let scale = 1.0 + load.norm() + force.norm();
        prop_assert!(gradient.iter().all(|g| g.norm() < 1e-11 * scale));
        let curved: f64 = chain.hessian_product(&rest.shape, &by).expect("a product")
            .iter().zip(&by).map(|(a, b)| a.dot(b)).sum();
        prop_assert!(curved > 0.0, "{}", curved);
        // Moved and turned as a whole, with its loads, it lies the same.
        let motion = Isometry3::new(place, moved);
        let turned = Piece::uniform(1.0, Properties { load: motion * load, ..uniform_properties() })
            .with_end_load(motion * force);
        let other = Chain::new(&motion, &[turned], 40).expect("a chain");
        let again = other.solve().map_err(|e| TestCaseError::fail(e.to_string()))?;
        for (a, b) in rest.shape.positions().iter().zip(again.shape.positions()) {
            prop_assert!((motion * a - b).norm() < 1e-8, "{} {}", motion * a, b);
        }
        // The Pi groups: in other units of length and stiffness it has the same shape.
        let (length, unit) = (0.03, 2e-7);
        let Properties { stiffness, natural_curvature, .. } = uniform_properties();
        let small = Properties {
            stiffness: stiffness * unit,
            natural_curvature: natural_curvature / length,
            load: load * unit / length.powi(3),
        };
        let small = Piece::uniform(length, small).with_end_load(force * unit / length.powi(2));
        let other = Chain::new(&Isometry3::identity(), &[small], 40).expect("a chain");
        let again = other.solve().map_err(|e| TestCaseError::fail(e.to_string()))?;
        for (a, b) in rest.shape.positions().iter().zip(again.shape.positions()) {
            prop_assert!((a.coords * length - b.coords).norm() < 1e-9 * length);
        }
    }
}

fn uniform_properties() -> Properties {
    Properties {
        stiffness: Vector3::new(1.0, 0.8, 0.75),
        natural_curvature: Vector3::new(0.0, 2.0, 1.0),
        load: Vector3::zeros(),
    }
}

#[test]
fn nonsense_is_refused() {
    let piece = uniform(Vector3::zeros());
    let new = |count| Chain::new(&Isometry3::identity(), std::slice::from_ref(&piece), count);
    assert!(matches!(new(0), Err(StaticError::NoSegments)));
    let curled = Properties { natural_curvature: Vector3::x() * 20.0, ..uniform_properties() };
    let curled = Chain::new(&Isometry3::identity(), &[Piece::uniform(1.0, curled)], 6);
    assert!(matches!(curled, Err(StaticError::TooCoarse { segment: 0, .. })));
    let mut chain = new(10).expect("a chain");
    let forces = chain.set_forces(&[Vector3::zeros(); 10]);
    assert!(matches!(forces, Err(StaticError::WrongCount { given: 10, nodes: 11, .. })));
    let forces = chain.set_forces(&[Vector3::x() * f64::NAN; 11]);
    assert!(matches!(forces, Err(StaticError::NotFinite { .. })));
    let far = Target::held(5, Point3::new(0.0, 0.6, 0.0));
    assert!(matches!(chain.set_targets(&[far]), Err(StaticError::OutOfReach { .. })));
    let apart =
        [Target::held(5, Point3::new(0.0, 0.4, 0.0)), Target::held(6, Point3::new(0.0, 0.25, 0.0))];
    assert!(matches!(chain.set_targets(&apart), Err(StaticError::OutOfReach { .. })));
    let slack = Target::pulled(5, Point3::origin(), -1.0);
    assert!(matches!(chain.set_targets(&[slack]), Err(StaticError::NotPositive { .. })));
    let nowhere = Target::held(11, Point3::origin());
    assert!(matches!(
        chain.set_targets(&[nowhere]),
        Err(StaticError::NoNode { node: 11, last: 10 })
    ));
    let other = new(11).expect("a chain").natural_shape();
    assert!(matches!(chain.relax(&other), Err(StaticError::WrongCount { .. })));
    assert!(Chain::relax_all(&[chain], &[]).is_err());
}
