use nalgebra::Vector3;

/// A force or a moment at an end of a rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// Components in the world frame; the direction stays.
    World(Vector3<f64>),
    /// Components in the material frame of the end; the direction follows the rod.
    Follower(Vector3<f64>),
}

impl Load {
    /// No load.
    pub const ZERO: Self = Self::World(Vector3::new(0.0, 0.0, 0.0));

    /// Components as given, whatever the frame.
    #[must_use]
    pub fn components(&self) -> &Vector3<f64> {
        match self {
            Self::World(v) | Self::Follower(v) => v,
        }
    }
}
