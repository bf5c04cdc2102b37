use nalgebra::Vector3;
use rapunzel_fiber::Fiber;

/// Units in which the equations of a step are solved, so that hair in SI units (stiffness
/// 4e-9 N m^2) and a mast look alike: the length L, the mean mass per length, and
/// `T = (g/L + B/(rho L^4))^(-1/2)`, the faster of the pendulum's and of the bending time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Units {
    pub(super) length: f64,
    pub(super) line_density: f64,
    pub(super) time: f64,
}

impl Units {
    /// Units for a fibre under loads that accelerate its mass by `acceleration` (m/s^2).
    pub(super) fn of(fiber: &Fiber, acceleration: f64) -> Self {
        let length = fiber.length();
        let line_density = fiber.mass() / length;
        let count = fiber.nodes().len() as f64;
        let stiffness: f64 =
            fiber.nodes().iter().map(|p| p.stiffness.xy().max()).sum::<f64>() / count;
        let rate = acceleration / length + stiffness / (line_density * length.powi(4));
        Self { length, line_density, time: rate.sqrt().recip() }
    }

    pub(super) fn speed(&self) -> f64 {
        self.length / self.time
    }

    pub(super) fn acceleration(&self) -> f64 {
        self.speed() / self.time
    }

    pub(super) fn force_per_length(&self) -> f64 {
        self.line_density * self.acceleration()
    }

    pub(super) fn force(&self) -> f64 {
        self.force_per_length() * self.length
    }

    pub(super) fn moment(&self) -> f64 {
        self.force() * self.length
    }

    pub(super) fn stiffness(&self) -> f64 {
        self.moment() * self.length
    }

    pub(super) fn drag(&self) -> f64 {
        self.line_density / self.time
    }

    pub(super) fn inertia(&self) -> f64 {
        self.line_density * self.length * self.length
    }
}

/// Largest Euclidean norm of the vectors, 0 if there are none.
pub(super) fn largest(vectors: impl Iterator<Item = Vector3<f64>>) -> f64 {
    vectors.map(|v| v.norm()).fold(0.0, f64::max)
}
