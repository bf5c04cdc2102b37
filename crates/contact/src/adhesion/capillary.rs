use super::positive;
use crate::ContactError;
use std::f64::consts::PI;

/// Two equal cylinders that a liquid, which wets them completely, pulls together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinders {
    radius: f64,
    surface_tension: f64,
}

impl Cylinders {
    /// `radius` in m, `surface_tension` in N/m (water at 20 degrees Celsius: 0.0728).
    ///
    /// # Errors
    /// [`ContactError::Invalid`] for numbers that are not finite and positive.
    pub fn new(radius: f64, surface_tension: f64) -> Result<Self, ContactError> {
        Ok(Self {
            radius: positive("radius of a cylinder", radius)?,
            surface_tension: positive("surface tension", surface_tension)?,
        })
    }

    /// Attraction per length of parallel cylinders at a distance `gap` between their surfaces, N/m,
    /// with the volume of liquid `area` (m^2) per length between them.
    ///
    /// The two menisci are circular arcs tangent to both cylinders; the force is that of the
    /// pressure in the neck and of the tension of both menisci (Princen 1970, without gravity), and
    /// the derivative of [`Self::parallel_energy`]. It is zero where the liquid does not reach
    /// across: where the menisci would meet. More liquid than fits between flat menisci counts as
    /// just that much. A gap below zero counts as zero.
    #[must_use]
    pub fn parallel_force(&self, gap: f64, area: f64) -> f64 {
        let half = self.half_distance(gap);
        self.meniscus(half, area).map_or(0.0, |delta| {
            2.0 * self.surface_tension * half * delta.cos() / (half - self.radius * delta.sin())
        })
    }

    /// Surface energy per length of parallel cylinders, J/m, both covered by a film outside of the
    /// neck; `None` where the liquid does not reach across.
    #[must_use]
    pub fn parallel_energy(&self, gap: f64, area: f64) -> Option<f64> {
        let half = self.half_distance(gap);
        self.meniscus(half, area).map(|delta| {
            // The menisci's radius times delta, which stays finite as they become flat.
            let ratio = if delta > 0.0 { delta / delta.sin() } else { 1.0 };
            let arcs = half * ratio - self.radius * delta;
            self.surface_tension * (2.0 * self.radius * (PI + 2.0 * delta) + 4.0 * arcs)
        })
    }

    /// Attraction of cylinders that cross at `angle` (radians), N, at a distance `gap` between
    /// their surfaces, with the liquid `volume` (m^3) between them.
    ///
    /// The neck is thin against the radius and its menisci are half circles (Derjaguin): at contact
    /// the force is `4 pi gamma r / sin(angle)` whatever the volume, as of a sphere of the same
    /// radius on a plane for a right angle. It is zero beyond the gap at which the bridge breaks,
    /// the cube root of the volume (Lian, Thornton and Adams 1993 for complete wetting). A gap
    /// below zero counts as zero. Not for fibers nearly parallel, where it grows without bound:
    /// take [`Self::parallel_force`] times the length along which they are wet if that is less.
    #[must_use]
    pub fn crossed_force(&self, gap: f64, volume: f64, angle: f64) -> f64 {
        let gap = gap.max(0.0);
        let sine = angle.sin().abs();
        if volume <= 0.0 || gap > volume.cbrt() || sine <= 0.0 {
            return 0.0;
        }
        let height = gap.hypot((volume * sine / (PI * self.radius)).sqrt());
        4.0 * PI * self.surface_tension * self.radius / sine * (1.0 - gap / height)
    }

    /// Largest gap across which the volume of liquid `area` (m^2) per length reaches between
    /// parallel cylinders, m: there [`Self::parallel_force`] still pulls. None for no liquid.
    #[must_use]
    pub fn reach(&self, area: f64) -> f64 {
        let reaches = |gap: f64| self.meniscus(self.half_distance(gap), area).is_some();
        let (mut low, mut high) = (0.0, self.radius);
        while high.is_finite() && reaches(high) {
            (low, high) = (high, 2.0 * high);
        }
        while high - low > 4.0 * f64::EPSILON * high {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            (low, high) = if reaches(middle) { (middle, high) } else { (low, middle) };
        }
        low
    }

    fn half_distance(&self, gap: f64) -> f64 {
        self.radius + 0.5 * gap.max(0.0)
    }

    /// The angle by which the menisci end short of the cylinders' sides: zero for flat ones. The
    /// liquid between falls as it grows.
    fn meniscus(&self, half: f64, area: f64) -> Option<f64> {
        let widest = 2.0 * (self.radius / half).atan();
        if area <= 0.0 || area < self.area(half, widest) {
            return None;
        }
        let (mut low, mut high) = (0.0, widest);
        if area >= self.area(half, low) {
            return Some(low);
        }
        while high - low > 4.0 * f64::EPSILON * high {
            let middle = 0.5 * (low + high);
            if self.area(half, middle) > area {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(low)
    }

    /// Cross-section of the liquid between menisci: the quadrangle of the centers of cylinders and
    /// menisci, less their sectors.
    fn area(&self, half: f64, delta: f64) -> f64 {
        let radius = self.radius;
        if delta < 1e-4 {
            let curved = -2.0 / 3.0 * delta * (1.0 + delta * delta * 2.0 / 15.0);
            return 2.0 * half * half * curved + 4.0 * half * radius * (1.0 + delta * delta / 6.0)
                - PI * radius * radius;
        }
        let sine = delta.sin();
        2.0 * half * half * (0.5 * (2.0 * delta).sin() - delta) / (sine * sine)
            + 4.0 * half * radius * delta / sine
            - PI * radius * radius
    }
}

/// Energy per length that two parallel cylinders of `radius` (m) gain by joining with the liquid
/// between them filled to flat menisci, J/m: `(2 pi - 4) gamma r`.
///
/// That is the difference of the perimeters, twice `2 pi r` alone and `2 pi r + 4 r` together
/// (Bico et al. 2004).
#[must_use]
pub fn wet_pair_energy(radius: f64, surface_tension: f64) -> f64 {
    (2.0 * PI - 4.0) * surface_tension * radius
}
