//! Several equilibria of one problem.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapunzel_rod_static::{EndCondition, Equilibrium, Piece, Problem, Properties};

fn held(g: f64, end: Isometry3<f64>) -> Problem {
    let properties = Properties {
        stiffness: Vector3::new(1.0, 1.0, 0.75),
        natural_curvature: Vector3::zeros(),
        load: Vector3::new(0.0, 0.0, -g),
    };
    let piece = Piece::uniform(1.0, properties);
    Problem::new(&Isometry3::identity(), vec![piece], EndCondition::Held(end)).expect("a problem")
}

/// Whole turns of the end give other equilibria of the same ends.
#[test]
fn turns_of_the_end_give_other_equilibria() {
    let end = Isometry3::from_parts(
        Translation3::new(0.3, 0.1, 0.7),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 0.9, 0.3)),
    );
    let found: Vec<Equilibrium> = held(3.0, end).solutions(1);
    for one in &found {
        let tip = one.tip();
        assert!((tip.position.coords - end.translation.vector).norm() < 1e-9);
        let turn = UnitQuaternion::from_rotation_matrix(&tip.frame).angle_to(&end.rotation);
        assert!(turn < 1e-8, "{turn}");
    }
    let energies: Vec<f64> = found.iter().map(Equilibrium::energy).collect();
    assert!(energies.is_sorted() && energies.len() > 3, "{energies:?}");
    assert!(found[0].is_stable());
    let lowest = held(3.0, end).solve().expect("an equilibrium");
    assert!((lowest.energy() - energies[0]).abs() < 1e-9);
    // Minima by their winding, and saddles between them.
    let stable = found.iter().filter(|one| one.is_stable()).count();
    assert!(stable > 1 && stable < found.len(), "{stable} of {} stable", found.len());
}
