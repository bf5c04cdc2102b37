//! A rope without weight and bending stiffness, inextensible, on corners that lie on a circle.
use crate::common::{Dense, circle, contact, exact, resolve, to};
use nalgebra::{DMatrix, Vector3};
use rapunzel_contact::Contact;

const RADIUS: f64 = 0.01;

/// The rope as particles at `n` corners of one turn by `angle`, with one more at each end where
/// tangents go off to the loads; the first end bears the low load.
struct Rope {
    body: Dense,
    contacts: Vec<Contact>,
    /// From the low end to the high one.
    tangents: Vec<Vector3<f64>>,
    /// Turn at a corner.
    turn: f64,
}

impl Rope {
    fn new(mu: f64, angle: f64, n: usize, end_masses: [f64; 2]) -> Self {
        let turn = angle / n as f64;
        let at = |k: f64| {
            let (sine, cosine) = (turn * k).sin_cos();
            (Vector3::new(cosine, sine, 0.0), Vector3::new(-sine, cosine, 0.0))
        };
        let mut points: Vec<_> = (0..n).map(|k| at(k as f64).0 * RADIUS).collect();
        let step = 2.0 * RADIUS * (0.5 * turn).sin();
        points.insert(0, points[0] - at(-0.5).1 * step);
        points.push(points[n] + at(n as f64 - 0.5).1 * step);
        let count = n + 2;
        let mut mobility = DMatrix::identity(3 * count, 3 * count) / 1e-6;
        for (end, mass) in [(0, end_masses[0]), (count - 1, end_masses[1])] {
            mobility.fixed_view_mut::<3, 3>(3 * end, 3 * end).fill_with_identity();
            let mut block = mobility.fixed_view_mut::<3, 3>(3 * end, 3 * end);
            block /= mass;
        }
        let mut taut = DMatrix::zeros(count - 1, 3 * count);
        for i in 0..count - 1 {
            let direction = (points[i + 1] - points[i]).normalize();
            taut.fixed_view_mut::<1, 3>(i, 3 * i).copy_from(&-direction.transpose());
            taut.fixed_view_mut::<1, 3>(i, 3 * i + 3).copy_from(&direction.transpose());
        }
        let body = Dense::new(mobility, DMatrix::identity(3 * count, 3 * count)).constrained(&taut);
        let contacts = (0..n).map(|k| contact(k + 1, None, &at(k as f64).0, circle(mu))).collect();
        let mut tangents: Vec<_> = (0..n).map(|k| at(k as f64).1).collect();
        tangents.insert(0, at(-0.5).1);
        tangents.push(at(n as f64 - 0.5).1);
        Self { body, contacts, tangents, turn }
    }

    fn pull(&mut self, low: f64, high: f64, dt: f64) {
        let mut impulse = vec![0.0; 3 * self.tangents.len()];
        let last = self.tangents.len() - 1;
        for (point, force) in [(0, -low), (last, high)] {
            for axis in 0..3 {
                impulse[3 * point + axis] = force * dt * self.tangents[point][axis];
            }
        }
        self.body.push(&impulse);
    }

    /// Moment of all friction about the middle, divided by the lever of the loads.
    fn held(&self, impulses: &[Vector3<f64>]) -> f64 {
        let moment: f64 = self
            .contacts
            .iter()
            .zip(impulses)
            .map(|(c, r)| (c.frame * r).dot(&self.tangents[c.first]))
            .sum();
        moment / (0.5 * self.turn).cos()
    }
}

/// Ratio of the loads of a rope that slips over `n` corners at constant speed: one end is drawn by
/// something so heavy that its speed does not change.
pub(crate) fn slipping_ratio(mu: f64, angle: f64, n: usize, low: f64) -> f64 {
    let dt = 1e-3;
    let mut rope = Rope::new(mu, angle, n, [1e-6, 1e9]);
    for (i, tangent) in rope.tangents.clone().iter().enumerate() {
        let speed = if i == 0 || i == n + 1 { (0.5 * rope.turn).cos() } else { 1.0 };
        rope.body.velocity.fixed_rows_mut::<3>(3 * i).copy_from(&(tangent * speed));
    }
    rope.pull(low, 0.0, dt);
    let mut impulses = vec![Vector3::zeros(); n];
    let mut solver = to(1e-9, 1e-6, 100_000);
    let mut bodies = [rope.body.clone()];
    let report = resolve(&mut bodies, &rope.contacts, &mut impulses, &mut solver);
    println!("{n} corners: {report:?}");
    assert!(report.converged, "{report:?}");
    1.0 - rope.held(&impulses) / (low * dt)
}

/// Ratio of the tensions beside a corner that slips.
pub(crate) fn corner(mu: f64, turn: f64) -> f64 {
    (1.0 + mu * (0.5 * turn).tan()) / (1.0 - mu * (0.5 * turn).tan())
}

#[test]
fn a_polygonal_capstan_slips_at_its_ratio() {
    let turn = std::f64::consts::TAU;
    let ratio = slipping_ratio(0.3, turn, 100, 1.0);
    let expected = corner(0.3, turn / 100.0).powi(100);
    assert!((expected - 6.59052).abs() < 5e-6);
    assert!((ratio / expected - 1.0).abs() < 1e-6, "{ratio}");
}

/// So many corners are a smooth capstan: what is left of them is `mu phi^3 (1 + mu^2) / (12 n^2)`,
/// 4e-5.
#[test]
fn a_smooth_capstan_slips_at_the_exponential() {
    let (mu, turn, n) = (0.3_f64, std::f64::consts::TAU, 400);
    let smooth = (mu * turn).exp();
    assert!((smooth - 6.5861).abs() < 5e-5);
    let relative = slipping_ratio(mu, turn, n, 1.0) / smooth - 1.0;
    let polygonal = mu * turn.powi(3) * (1.0 + mu * mu) / (12.0 * (n * n) as f64);
    assert!(relative.abs() < 1e-3, "{relative}");
    assert!((relative / polygonal - 1.0).abs() < 0.1, "{relative} {polygonal}");
}

/// Ten corners of 0.3 rad each hold up to 2.477 times the load and not more; both ends move freely.
#[test]
fn a_capstan_holds_what_it_can() {
    let limit = corner(0.3, 0.3).powi(10);
    assert!((limit - 2.477).abs() < 1e-3);
    for (ratio, holds) in [(1.0, true), (2.0, true), (0.999 * limit, true), (1.001 * limit, false)]
    {
        let dt = 1e-3;
        let mut rope = Rope::new(0.3, 3.0, 10, [1e-3; 2]);
        let mut impulses = vec![Vector3::zeros(); 10];
        let mut way: f64 = 0.0;
        let mut solver = exact();
        for _ in 0..100 {
            rope.pull(0.02, 0.02 * ratio, dt);
            let mut bodies = [rope.body.clone()];
            let report = resolve(&mut bodies, &rope.contacts, &mut impulses, &mut solver);
            assert!(report.converged, "{ratio}: {report:?}");
            [rope.body] = bodies;
            way += rope.body.velocity.amax() * dt;
        }
        println!("capstan at {ratio:.4}: {way:.1e} m in 0.1 s");
        assert_eq!(way < 1e-12, holds, "{ratio}: {way}");
    }
}
