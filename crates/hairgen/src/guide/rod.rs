use crate::{HairgenError, Pore};
use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3, Vector6};
use rapunzel_rod_static::{
    Chain, Piece, Properties, Rest, Shape, ShapeDerivatives, ShapeResponse, StaticError,
};

/// Smallest sine of an angle between two directions that span a plane.
const LEAST_SINE: f64 = 1e-3;

/// The load on the end of a guide that gives it its shape (thesis 5.3.3): the shape depends on the
/// load in units of the bending stiffness `EI` and the length `L` only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndLoad {
    /// Force in units of `EI / L^2`, dead: in the world frame.
    pub force: Vector3<f64>,
    /// Couple in units of `EI / L`, following: in the end's own axes.
    pub couple: Vector3<f64>,
}

impl EndLoad {
    pub(crate) fn of(unknowns: &Vector6<f64>) -> Self {
        let [force, couple] = [0, 3].map(|row| unknowns.fixed_rows::<3>(row).into_owned());
        Self { force, couple }
    }

    pub(super) fn unknowns(&self) -> Vector6<f64> {
        let (f, c) = (self.force, self.couple);
        Vector6::new(f.x, f.y, f.z, c.x, c.y, c.z)
    }
}

/// A guide as a naturally straight round rod, clamped in its pore.
#[derive(Debug, Clone)]
pub(crate) struct GuideRod {
    chain: Chain,
    forces: Vec<Vector3<f64>>,
    /// Length, m.
    pub(crate) length: f64,
}

impl GuideRod {
    /// The rod of pore number `number`, in `segments` segments, with the given ratio of torsion to
    /// bending stiffness. Its d1 is the direction in which it bends toward the head.
    pub(crate) fn new(
        pore: &Pore,
        number: usize,
        options: &super::GuideOptions,
    ) -> Result<Self, HairgenError> {
        check(pore, number)?;
        let (d3, d1) = (pore.direction.into_inner(), bend(pore, &options.down));
        let frame =
            Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[d1, d3.cross(&d1), d3]));
        let clamp = Isometry3::from_parts(
            pore.position.into(),
            UnitQuaternion::from_rotation_matrix(&frame),
        );
        // With `EI = L^2` the unit of force is 1 N, and that of couples is the length.
        let bending = pore.length * pore.length;
        let properties = Properties {
            stiffness: Vector3::new(1.0, 1.0, options.torsion) * bending,
            natural_curvature: Vector3::zeros(),
            load: Vector3::zeros(),
        };
        let piece = Piece::uniform(pore.length, properties);
        let chain = Chain::new(&clamp, &[piece], options.segments)
            .map_err(|source| HairgenError::Rod { pore: number, source })?;
        let forces = vec![Vector3::zeros(); options.segments + 1];
        Ok(Self { chain, forces, length: pore.length })
    }

    /// The direction across the root in which the rod bends toward the head (world).
    pub(crate) fn bend(&self) -> Vector3<f64> {
        self.chain.clamp() * Vector3::x()
    }

    /// The frame of the root.
    pub(crate) fn root(&self) -> UnitQuaternion<f64> {
        self.chain.clamp().rotation
    }

    pub(crate) fn straight(&self) -> Shape {
        self.chain.natural_shape()
    }

    /// The shape with the given frames of the nodes.
    pub(super) fn shape_of(&self, frames: Vec<UnitQuaternion<f64>>) -> Result<Shape, StaticError> {
        self.chain.shape_of(frames)
    }

    /// The equilibrium under a load on the end that is reached from `start`.
    pub(crate) fn relax(&mut self, load: &EndLoad, start: &Shape) -> Result<Rest, StaticError> {
        self.load(load)?;
        self.chain.relax(start)
    }

    /// The equilibrium under a load on the end next to `start`, on the same branch.
    pub(super) fn relax_nearby(
        &mut self,
        load: &EndLoad,
        start: &Shape,
    ) -> Result<Rest, StaticError> {
        self.load(load)?;
        self.chain.relax_nearby(start)
    }

    fn load(&mut self, load: &EndLoad) -> Result<(), StaticError> {
        if let Some(end) = self.forces.last_mut() {
            *end = load.force;
        }
        self.chain.set_forces(&self.forces)?;
        self.chain.set_tip_couple(&(load.couple * self.length))
    }

    /// Derivatives of a functional of the last equilibrium by the load on the end, in its units.
    pub(crate) fn by_load(
        &self,
        rest: &Rest,
        by: &ShapeDerivatives,
    ) -> Result<Vector6<f64>, StaticError> {
        let by = self.chain.by_rotations(&rest.shape, by)?;
        let by = self.chain.end_load_derivatives(rest, &by)?;
        let couple = by.couple * self.length;
        Ok(Vector6::new(by.force.x, by.force.y, by.force.z, couple.x, couple.y, couple.z))
    }

    /// Changes of an equilibrium by the components of the load on the end, in its units.
    pub(super) fn responses(&self, rest: &Rest) -> Result<[ShapeResponse; 6], StaticError> {
        let mut responses = self.chain.end_load_responses(rest)?;
        for response in &mut responses[3..] {
            let parts = [&mut response.positions, &mut response.tangents, &mut response.curvatures];
            parts.into_iter().flatten().for_each(|change| *change *= self.length);
        }
        Ok(responses)
    }

    /// Curvatures of the segments times the length, in their own axes: those of the curve scaled to
    /// unit length.
    pub(crate) fn bends(&self, shape: &Shape) -> Vec<Vector3<f64>> {
        self.chain.curvatures(shape).iter().map(|curvature| curvature * self.length).collect()
    }
}

/// Checks that a hair can grow out of a pore.
fn check(pore: &Pore, number: usize) -> Result<(), HairgenError> {
    let refuse = |problem| Err(HairgenError::Pore { pore: number, problem });
    let unit = |v: &Vector3<f64>| (v.norm() - 1.0).abs() < 1e-6;
    if !(pore.length > 0.0 && pore.length.is_finite()) {
        return refuse("its length must be positive and finite; leave out pores without hair");
    }
    if !pore.position.iter().all(|x| x.is_finite()) {
        return refuse("its position must be finite");
    }
    if !unit(&pore.normal) || !unit(&pore.direction) {
        return refuse("its normal and its direction must be unit vectors");
    }
    Ok(())
}

/// The direction across the hair in which it bends toward the head: in the plane of normal and
/// direction; downward where they are one, and any where that is none either.
fn bend(pore: &Pore, down: &Vector3<f64>) -> Vector3<f64> {
    let along = pore.direction.into_inner();
    let ways = [-pore.normal.into_inner(), *down, Vector3::x(), Vector3::z()];
    let across = ways.into_iter().map(|way| way - along * way.dot(&along));
    // One of two axes is always across: they are not both along.
    let across = across.into_iter().find_map(|way| way.try_normalize(LEAST_SINE));
    across.unwrap_or_else(Vector3::x)
}
