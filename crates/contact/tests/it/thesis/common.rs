//! What the tests share.
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_contact::RigidBody;
use rapunzel_contact::thesis::projection::{Partner, PolygonalCone, Touch};
use serde_json::Value;

pub(crate) fn number(case: &Value, key: &str) -> f64 {
    case[key].as_f64().unwrap_or_else(|| panic!("{key} of {case}"))
}

pub(crate) fn vector(case: &Value, key: &str) -> Vector3<f64> {
    let numbers = numbers(case, key);
    Vector3::new(numbers[0], numbers[1], numbers[2])
}

pub(crate) fn numbers(case: &Value, key: &str) -> Vec<f64> {
    let list = case[key].as_array().unwrap_or_else(|| panic!("{key} of {case}"));
    list.iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// A ball at the origin: with a contact at its center it is a particle.
pub(crate) fn particle(mass: f64, velocity: Vector3<f64>) -> RigidBody {
    let mut body = RigidBody::ball(mass, 1.0, Isometry3::identity()).expect("valid");
    body.velocity = velocity;
    body
}

/// A contact of body 0 at its center with a fixed plane.
pub(crate) fn floor(normal: Vector3<f64>, tangent: Vector3<f64>, friction: PolygonalCone) -> Touch {
    Touch {
        body: 0,
        partner: Partner::Given(Vector3::zeros()),
        point: Point3::origin(),
        normal,
        tangent,
        closing: 0.0,
        friction,
    }
}

pub(crate) fn frictionless() -> PolygonalCone {
    PolygonalCone::regular(0.0, 4).expect("valid")
}

/// Numbers between -1 and 1 that are the same in every run (Marsaglia's xorshift64).
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub(crate) fn positive(&mut self) -> f64 {
        0.5 * (1.0 + self.next())
    }

    pub(crate) fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next())
    }
}
