//! A rod between clamps that is twisted under tension leaves its axis.

use crate::greenhill::clamps;
use rapunzel_sim::statics::{Case, CaseAnswer, solve};

/// A rod of length 1 with both bending stiffnesses 1 along z, whose far clamp slides along z under
/// a tension.
fn answer(tension: f64, more: &str) -> CaseAnswer {
    let text = format!(
        "(format: 1, length: 1.0, gravity: (0, 0, 0), parts: 200,
          rod: Measured(bending: (1, 1), torsion: 0.75, linear_density: 0, radius: 0.001),
          clamp: (orientation: Euler(degrees: (0, 0, 0))),
          end: Sliding(position: (0, 0, 1), direction: (0, 0, 1), force: {tension:?},
              hold: Clamped(orientation: Euler(degrees: (0, 0, 0)))),
          {more})"
    );
    let case = Case::from_ron(&text).unwrap_or_else(|error| panic!("{error}"));
    solve(&case).unwrap_or_else(|error| panic!("{tension}: {error}"))
}

/// Torsion stiffness.
const TORSION: f64 = 0.75;

/// It is twisted until it is not stable: at the moment of theory for rods of ten and of twenty
/// times `sqrt(B / T)`, which nears the `M = 2 sqrt(B T)` of long ones: the longer one turns by
/// more than eight whole turns before. It may bend to all sides.
#[test]
fn a_twisted_rod_under_tension_leaves_its_axis() {
    for (tension, above) in [(100.0_f64, 1.06), (400.0, 1.02)] {
        let up_to = 2.0 * (tension.sqrt() + 4.0) / TORSION;
        let asked = format!("critical: (of: EndTwist, up_to: {:?})", up_to.to_degrees());
        let branch = answer(tension, &asked).branch.expect("a branch");
        let limit = &branch.limits[0];
        assert_eq!(limit.ways_down, [0, 2]);
        let moment = TORSION * limit.parameter.to_radians();
        let missing = [1.0 - 1e-8, 1.0 + 1e-8].map(|part| {
            let half = 0.5 * part * moment;
            clamps(half, (half * half - tension).sqrt())
        });
        assert!(missing[0] * missing[1] < 0.0, "{moment}: {missing:?}");
        let long = 2.0 * tension.sqrt();
        assert!(moment > long && moment < above * long, "{moment}");
    }
}
