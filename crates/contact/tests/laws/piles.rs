//! Piles of discs at rest: contact.md's tests 9 and 10.
use crate::common::{Dense, G, circle, contact, exact, resolve};
use nalgebra::{Matrix3, Vector3};
use rapunzel_contact::Contact;

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
}

#[test]
fn a_pile_at_rest_stays_for_ten_thousand_steps() {
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
    let mut pile = Pile::new(&centers, &touching, [1.0, 1.0]);
    let mut impulses = vec![Vector3::zeros(); pile.contacts.len()];
    let mut way = 0.0;
    for step in 0..10_000 {
        let speed = pile.step(&mut impulses);
        way += speed * DT;
        let ground: f64 = impulses.iter().zip(&pile.grounded).filter(|x| *x.1).map(|x| x.0.x).sum();
        let weight = 10.0 * MASS * G * DT;
        assert!(
            (ground / weight - 1.0).abs() < 1e-8,
            "{step}: {ground} {speed} {:?}",
            pile.discs.iter().map(|d| d.velocity.as_slice().to_vec()).collect::<Vec<_>>()
        );
    }
    println!("pile of ten: {way:.1e} m in 10^4 steps");
    assert!(way < 1e-11, "{way}");
}
