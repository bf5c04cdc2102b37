//! What the printed chains of thesis 8.5 do, by numbers, and that their corrections do not.

use super::chains::{momenta, run, settings, shake, step, straight};
use nalgebra::{Point3, Vector3};
use rapunzel_contact::thesis::chain::{
    ChainForm, Coupling, JointSprings, Root, Settings, collision_matrix,
};
use rapunzel_contact::thesis::projection::Form;

#[test]
fn collision_matrix_is_positive_corrected_and_singular_printed() {
    let chain = straight(2, 0.2, Vector3::new(0.6, 0.0, 0.8), Root::Free);
    let joint = chain.ends(0)[1];
    let [k, l] = [&chain.segments()[0], &chain.segments()[1]];
    let matrix = collision_matrix(k, l, &joint, Form::Corrected);
    assert!((matrix - matrix.transpose()).amax() < 1e-12 * matrix.amax());
    assert!(matrix.symmetric_eigenvalues().min() > 0.0);
    let printed = collision_matrix(k, l, &joint, Form::AsPrinted);
    let values = printed.fixed_view::<3, 3>(3, 3).into_owned().singular_values();
    assert!(values[1] < 1e-12 * values[0], "rank one: {values}");
}

#[test]
fn printed_signs_do_not_close_the_joints() {
    let form = ChainForm { signs: Form::AsPrinted, ..Form::Corrected.into() };
    let mut chain = straight(6, 0.2, Vector3::x(), Root::Hinged(Point3::origin()));
    let mut widest = 0.0_f64;
    let mut failed = None;
    for i in 0..100 {
        match step(std::slice::from_mut(&mut chain), &Settings { form, ..settings(1e-3) }) {
            Ok(report) => widest = widest.max(report.widest_gap),
            Err(error) => {
                failed = Some((i, error));
                break;
            }
        }
    }
    println!("printed signs: gap {widest} m, then {failed:?}");
    assert!(widest > 1e-3 || failed.is_some());
}

#[test]
fn printed_rotation_loses_angular_momentum() {
    let change = |gyroscopic: Form| {
        let mut chain = straight(4, 0.2, Vector3::x(), Root::Free);
        shake(&mut chain, 1.0, 5);
        let form = ChainForm { gyroscopic, ..Form::Corrected.into() };
        let free = Settings { gravity: Vector3::zeros(), form, ..settings(1e-3) };
        run(&mut chain, 1, &free);
        let before = momenta(&chain).1;
        run(&mut chain, 300, &free);
        (momenta(&chain).1 - before).norm() / before.norm()
    };
    assert!(change(Form::Corrected) < 1e-12);
    let printed = change(Form::AsPrinted);
    println!("printed rotation: angular momentum changes by {printed} in 0.3 s");
    assert!(printed > 1e-3, "{printed}");
}

/// As printed the curvature is the angle between the segments, so the stiffness depends on how many
/// there are, and the natural curvature is taken off again and again.
#[test]
fn printed_curvature_is_an_angle_and_runs_away() {
    let bent = |n: usize, curvature: Form| {
        let mut chain = straight(n, 0.2, Vector3::x(), Root::Free);
        let natural = vec![Vector3::new(0.0, 1.0, 0.0); n - 1];
        let springs = JointSprings {
            stiffness: Vector3::repeat(1e-9),
            natural,
            coupling: Coupling::Explicit,
        };
        chain = chain.with_springs(springs).expect("valid");
        let form = ChainForm { curvature, ..Form::Corrected.into() };
        let free = Settings { gravity: Vector3::zeros(), form, ..settings(1e-3) };
        [10, 10].map(|steps| {
            run(&mut chain, steps, &free);
            chain.curvatures()[n / 2 - 1].norm()
        })
    };
    // Under a constant moment the curvature grows with the square of time.
    let [corrected, printed] = [Form::Corrected, Form::AsPrinted].map(|form| bent(10, form));
    println!("curvature after 10 and 20 steps: {corrected:?}, printed {printed:?}");
    assert!((corrected[1] / corrected[0] - 4.0).abs() < 0.5, "{corrected:?}");
    assert!(printed[1] / printed[0] > 6.0, "the moment grows in every step: {printed:?}");
}
