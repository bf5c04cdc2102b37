//! Chains that the tests share.
use super::common::Numbers;
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_contact::ContactError;
use rapunzel_contact::thesis::chain::{
    self, Coupling, CylinderChain, HarmonizationReport, JointMethod, JointSprings, LastWord, Root,
    Settings,
};
use rapunzel_contact::thesis::projection::{Differences, Form};

pub(crate) const G: f64 = 9.81;

pub(crate) fn settings(dt: f64) -> Settings {
    Settings {
        dt,
        gravity: Vector3::new(0.0, 0.0, -G),
        method: JointMethod::ImpulseCorrection,
        order: LastWord::JointsFirst,
        harmonizations: 1,
        restitution: 0.0,
        form: Form::Corrected.into(),
    }
}

/// A step without contacts.
pub(crate) fn step(
    chains: &mut [CylinderChain],
    settings: &Settings,
) -> Result<HarmonizationReport, ContactError> {
    chain::step(chains, &[], settings, &mut Differences::from(Form::Corrected))
}

/// A chain of total `length` along `direction` from the origin.
pub(crate) fn straight(
    segments: usize,
    length: f64,
    direction: Vector3<f64>,
    root: Root,
) -> CylinderChain {
    let node = |i: usize| Point3::from(direction * (length * i as f64 / segments as f64));
    let nodes: Vec<_> = (0..=segments).map(node).collect();
    CylinderChain::new(&nodes, 0.1, 1e-3, &Vector3::new(0.3, 1.0, 0.2), root).expect("valid")
}

/// A chain along x whose root is clamped at the origin.
pub(crate) fn cantilever(segments: usize, length: f64) -> CylinderChain {
    let mut chain = straight(segments, length, Vector3::x(), Root::Hinged(Point3::origin()));
    let rotation = chain.segments()[0].pose.rotation;
    let pose = Isometry3::from_parts(Vector3::zeros().into(), rotation);
    chain.set_root(Root::Clamped(pose)).expect("no springs");
    chain
}

pub(crate) fn springs(stiffness: f64, joints: usize, coupling: Coupling) -> JointSprings {
    let natural = vec![Vector3::zeros(); joints];
    JointSprings { stiffness: Vector3::repeat(stiffness), natural, coupling }
}

pub(crate) fn run(chain: &mut CylinderChain, steps: usize, settings: &Settings) -> f64 {
    let mut widest = 0.0_f64;
    for _ in 0..steps {
        let report = step(std::slice::from_mut(chain), settings).expect("closed");
        widest = widest.max(report.widest_gap);
    }
    widest
}

pub(crate) fn shake(chain: &mut CylinderChain, size: f64, seed: u64) {
    let mut numbers = Numbers(seed);
    for segment in chain.segments_mut() {
        segment.velocity = size * numbers.vector();
        segment.set_angular_velocity(&(10.0 * size * numbers.vector()));
    }
}

/// Momentum, and angular momentum about the origin.
pub(crate) fn momenta(chain: &CylinderChain) -> (Vector3<f64>, Vector3<f64>) {
    chain.segments().iter().fold((Vector3::zeros(), Vector3::zeros()), |sum, s| {
        (sum.0 + s.mass() * s.velocity, sum.1 + s.angular_momentum_about(&Point3::origin()))
    })
}
