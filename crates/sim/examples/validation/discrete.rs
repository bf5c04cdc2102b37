//! Rods in segments at rest, and how their errors fall with the number of segments.

use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, NodeProperties, Section};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{ClaimCheck, Criterion, Fallible, check};
use rapunzel_rod_dynamic::{Instant, Rod, RodIntegrator, RodState, Staggered, equilibrium};

/// What theory leaves of the order two of the staggered rod on meshes that are not infinitely fine.
const ORDER: Criterion = Criterion::Within(1.9, 2.1);

/// A frame with these axes.
pub(crate) fn frame(d1: Vector3<f64>, d3: Vector3<f64>) -> UnitQuaternion<f64> {
    let axes = Rotation3::from_basis_unchecked(&[d1, d3.cross(&d1), d3]);
    UnitQuaternion::from_rotation_matrix(&axes)
}

/// A rod of equal segments from the origin, whose stiffness (N m^2) depends on the part of its
/// length; the natural curvature (1/m) and the mass per length (kg/m) are the same all along.
pub(crate) fn rod(
    root: UnitQuaternion<f64>,
    (length, segments): (f64, usize),
    stiffness: impl Fn(f64) -> Vector3<f64>,
    natural_curvature: Vector3<f64>,
    linear_density: f64,
) -> Fallible<Rod> {
    let node = |i: usize| NodeProperties {
        // For nothing but pictures.
        section: Section::Circle { radius: 1e-4 * length },
        linear_density,
        rotary_inertia: Vector3::repeat(1e-8 * linear_density * length * length),
        stiffness: stiffness(i as f64 / segments as f64),
        natural_curvature,
    };
    let lengths = vec![length / segments as f64; segments];
    let root = Isometry3::from_parts(Vector3::zeros().into(), root);
    Ok(Rod::new(Fiber::new(root, lengths, (0..=segments).map(node).collect())?))
}

/// Where it rests, from its natural shape or from another start.
pub(crate) fn rests(
    rod: &Rod,
    conditions: &Instant,
    start: Option<RodState>,
) -> Fallible<RodState> {
    let start = start.map_or_else(|| Ok(Staggered::new(rod.clone())?.state()), Fallible::Ok)?;
    Ok(equilibrium(rod, conditions, &start)?.0)
}

/// Errors of a number on meshes, each twice as fine as the one before it.
pub(crate) struct Convergence {
    pub(crate) name: String,
    /// Numbers of segments.
    pub(crate) segments: Vec<usize>,
    /// What was found, and what theory says, in its unit.
    pub(crate) found: Vec<f64>,
    pub(crate) right: f64,
}

impl Convergence {
    /// A number on meshes of so many segments.
    pub(crate) fn of(
        name: impl Into<String>,
        segments: &[usize],
        right: f64,
        mut found: impl FnMut(usize) -> Fallible<f64>,
    ) -> Fallible<Self> {
        let values = segments.iter().map(|n| found(*n)).collect::<Fallible<_>>()?;
        Ok(Self { name: name.into(), segments: segments.to_vec(), found: values, right })
    }

    fn errors(&self) -> Vec<f64> {
        self.found.iter().map(|found| (found - self.right).abs()).collect()
    }

    /// The order between the two finest meshes; and, that being two, the number at no length of
    /// segments, which is off by a power of them that is two higher: by no more than a tenth of the
    /// error on the finest mesh.
    pub(crate) fn checks(&self, unit: &'static str, theory: &'static str) -> [ClaimCheck; 2] {
        let (errors, last) = (self.errors(), self.segments.len() - 1);
        let order = (errors[last - 1] / errors[last]).log2();
        let limit = (4.0 * self.found[last] - self.found[last - 1]) / 3.0;
        let room = 0.1 * errors[last];
        let criterion = Criterion::Within(self.right - room, self.right + room);
        [
            check(format!("{}, order", self.name), order, "", ORDER, "two"),
            check(format!("{}, extrapolated", self.name), limit, unit, criterion, theory),
        ]
    }

    /// Its curve: errors by segments, both as powers.
    fn curve(&self) -> Curve {
        let points = self.segments.iter().zip(self.errors());
        let points = points.map(|(n, error)| [(*n as f64).log2(), error]).collect();
        Curve { name: self.name.clone(), points }
    }
}

/// The errors of several numbers.
pub(crate) fn errors(all: &[Convergence]) -> Drawing {
    Drawing::Chart(Chart {
        title: "Errors fall with the square of the segments' length".into(),
        x: "binary logarithm of the number of segments",
        y: "error, in the unit of the number",
        log_from: Some(1e-12),
        curves: all.iter().map(Convergence::curve).collect(),
    })
}
