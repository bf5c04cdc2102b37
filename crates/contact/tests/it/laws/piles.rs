//! Piles of discs: contact.md's tests 9, 10 and 23.
use crate::common::{Dense, G, Random, circle, contact, exact, resolve, to};
use nalgebra::{Matrix3, Vector3};
use rapunzel_contact::Contact;
use std::f64::consts::PI;

const DT: f64 = 1e-3;
const RADIUS: f64 = 1.0;
const MASS: f64 = 2.0;

/// Discs (cylinders along y) that touch each other and the ground at z = 0.
struct Pile {
    discs: Vec<Dense>,
    contacts: Vec<Contact>,
    /// Which contacts are with the ground.
    grounded: Vec<bool>,
}

impl Pile {
    /// `touching` are pairs of centers that touch.
    fn new(centers: &[(f64, f64)], touching: &[(usize, usize)], mu: [f64; 2]) -> Self {
        let at = |i: usize| Vector3::new(centers[i].0, 0.0, centers[i].1);
        // Every touch is a point of its disc: (disc, offset), then its contact.
        let mut points: Vec<Vec<Vector3<f64>>> = vec![Vec::new(); centers.len()];
        let mut touches = Vec::new();
        for (i, center) in centers.iter().enumerate() {
            if center.1 < 1.5 * RADIUS {
                touches.push((i, points[i].len(), None, Vector3::z()));
                points[i].push(-Vector3::z() * RADIUS);
            }
        }
        for &(i, j) in touching {
            let normal = (at(i) - at(j)).normalize();
            touches.push((i, points[i].len(), Some((j, points[j].len())), normal));
            points[i].push(-normal * RADIUS);
            points[j].push(normal * RADIUS);
        }
        let starts: Vec<usize> = points
            .iter()
            .scan(0, |sum, p| {
                *sum += p.len();
                Some(*sum - p.len())
            })
            .collect();
        let contacts = touches
            .iter()
            .map(|(i, k, other, normal)| {
                let second = other.map(|(j, l)| starts[j] + l);
                let mu = mu[usize::from(other.is_none())];
                contact(starts[*i] + k, second, normal, circle(mu))
            })
            .collect();
        let inertia = Matrix3::from_diagonal_element(0.5 * MASS * RADIUS * RADIUS);
        Self {
            discs: points.iter().map(|p| Dense::rigid(MASS, &inertia, p)).collect(),
            contacts,
            grounded: touches.iter().map(|t| t.2.is_none()).collect(),
        }
    }

    /// One step; the largest velocity afterwards.
    fn step(&mut self, impulses: &mut [Vector3<f64>]) -> f64 {
        for disc in &mut self.discs {
            disc.push(&[0.0, 0.0, -MASS * G * DT, 0.0, 0.0, 0.0]);
        }
        let report = resolve(&mut self.discs, &self.contacts, impulses, &mut exact());
        assert!(report.converged, "{report:?}");
        self.discs.iter().map(|d| d.velocity.amax()).fold(0.0, f64::max)
    }
}

/// Two below that just do not press each other, one on them.
fn stands(mu: [f64; 2]) -> bool {
    let height = 3.0_f64.sqrt();
    let centers = [(-1.0, 1.0), (1.0, 1.0), (0.0, 1.0 + height)];
    let mut pile = Pile::new(&centers, &[(2, 0), (2, 1)], mu);
    pile.step(&mut [Vector3::zeros(); 4]) < 1e-8 * G * DT
}

fn threshold(stands: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        if stands(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

#[test]
fn a_pyramid_of_three_needs_its_friction() {
    let between = threshold(|mu| stands([mu, 1.0]));
    let ground = threshold(|mu| stands([1.0, mu]));
    println!("pyramid of three: {between:.5} between fibers, {ground:.5} on the ground");
    assert!((between - (2.0 - 3.0_f64.sqrt())).abs() < 1e-5, "{between}");
    assert!((ground - (2.0 - 3.0_f64.sqrt()) / 3.0).abs() < 1e-5, "{ground}");
    assert!(stands([5.0, 5.0]) && !stands([0.0, 5.0]) && !stands([5.0, 0.0]));
}

/// Ten discs, four rows.
fn ten(mu: f64) -> Pile {
    let mut centers = Vec::new();
    for row in 0..4 {
        for k in 0..4 - row {
            let x = 2.0 * f64::from(k) + f64::from(row);
            centers.push((x, 1.0 + 3.0_f64.sqrt() * f64::from(row)));
        }
    }
    let mut touching = Vec::new();
    for j in 0..centers.len() {
        for i in j + 1..centers.len() {
            let (a, b) = (centers[i], centers[j]);
            if (a.0 - b.0).hypot(a.1 - b.1) < 2.001 {
                touching.push((i, j));
            }
        }
    }
    Pile::new(&centers, &touching, [mu, mu])
}

/// With a coefficient of one half statics has an equilibrium also (from 0.473, by linear
/// programming), but it is not the only solution: the discs may roll on each other as gears do.
#[test]
fn a_pile_at_rest_stays_for_ten_thousand_steps() {
    let mut pile = ten(1.0);
    let mut impulses = vec![Vector3::zeros(); pile.contacts.len()];
    let mut way = 0.0;
    for step in 0..10_000 {
        let speed = pile.step(&mut impulses);
        way += speed * DT;
        let ground: f64 = impulses.iter().zip(&pile.grounded).filter(|x| *x.1).map(|x| x.0.x).sum();
        let weight = 10.0 * MASS * G * DT;
        assert!((ground / weight - 1.0).abs() < 1e-8, "{step}: {ground}");
    }
    println!("pile of ten: {way:.1e} m in 10^4 steps");
    assert!(way < 1e-11, "{way}");
}

/// Seven fibers pressed together sideways get as dense as can be, and never denser. Gaps close by
/// no more than they are, and distances are at least what their linearization says.
#[test]
fn a_bundle_is_not_denser_than_discs_can_be() {
    let bound = PI / (2.0 * 3.0_f64.sqrt());
    let mut random = Random(23);
    let mut centers = vec![Vector3::zeros()];
    for k in 0..6 {
        let (sine, cosine) = (PI / 3.0 * f64::from(k)).sin_cos();
        centers.push(Vector3::new(cosine, sine, 0.0) * 2.5 + random.vector() * 0.2);
    }
    centers.iter_mut().for_each(|c| c.z = 0.0);
    let mut impulses = vec![Vector3::zeros(); 21];
    let mut density = 0.0;
    for _ in 0..3000 {
        let mut fibers: Vec<_> = centers.iter().map(|_| Dense::particle(1.0)).collect();
        for (fiber, center) in fibers.iter_mut().zip(&centers) {
            // Drawn to the middle; without inertia from step to step.
            fiber.push((-center * 0.02).as_slice());
        }
        let mut contacts = Vec::new();
        for i in 0..7 {
            for j in i + 1..7 {
                let between = centers[i] - centers[j];
                let mut touch = contact(i, Some(j), &between, circle(0.0));
                touch.bias.x = between.norm() - 2.0 * RADIUS;
                contacts.push(touch);
            }
        }
        let mut solver = to(1e-5, 1e-7, 20_000);
        let report = resolve(&mut fibers, &contacts, &mut impulses, &mut solver);
        assert!(report.converged, "{report:?}");
        for (center, fiber) in centers.iter_mut().zip(&fibers) {
            *center += fiber.velocities()[0];
        }
        // Of the hexagon of the outer centers, which contains three discs' worth.
        let area: f64 = (1..7).map(|i| 0.5 * centers[i].xy().perp(&centers[i % 6 + 1].xy())).sum();
        density = 3.0 * PI * RADIUS * RADIUS / area;
        assert!(density <= bound * (1.0 + 1e-6), "{density}");
    }
    println!("seven fibers: density {density:.7}, bound {bound:.7}");
    assert!((density / bound - 1.0).abs() < 1e-6, "{density}");
}
