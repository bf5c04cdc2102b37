use crate::ChargingError;
use crate::rods::RestingRod;
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Assembly;
use rapunzel_rod_static::Shape;
use rapunzel_scene::Scene;
use rayon::prelude::*;

/// All fibres of a scene with charge, each at rest.
#[derive(Debug, Clone)]
pub(crate) struct RestingFibers {
    pub(crate) assembly: Assembly,
    /// In the order of the assembly.
    pub(crate) rods: Vec<RestingRod>,
    /// Time, s.
    pub(crate) time: f64,
    /// Gravity at that time, m/s^2.
    pub(crate) gravity: Vector3<f64>,
}

impl RestingFibers {
    /// Fibres in their natural shapes, without charge and loads.
    pub(crate) fn new(assembly: Assembly) -> Result<Self, ChargingError> {
        let rods = assembly.fibers().iter().enumerate().map(|(fiber, own)| {
            RestingRod::new(own).map_err(|source| ChargingError::Rest { fiber, source })
        });
        let rods = rods.collect::<Result<_, _>>()?;
        Ok(Self { assembly, rods, time: 0.0, gravity: Vector3::zeros() })
    }

    /// Puts the loads and the gravity of a scene at time `t` (s) on the fibres, and makes them of
    /// their matter in the climate then, if that changes. They keep their shapes until they settle.
    pub(crate) fn load_at(&mut self, scene: &Scene, t: f64) -> Result<(), ChargingError> {
        (self.time, self.gravity) = (t, scene.environment.gravity_at(t));
        let mut rods = self.rods.iter_mut().zip(self.assembly.fibers()).enumerate();
        for (i, bundle) in scene.fibers.iter().enumerate() {
            let forces = bundle.node_forces(bundle.segments, t);
            let matter = scene.environment.climate.changes().then(|| scene.matter(bundle, t));
            let matter = matter.transpose();
            let matter = matter.map_err(|source| ChargingError::Keratin { bundle: i, source })?;
            for (fiber, (rod, natural)) in rods.by_ref().take(bundle.arrangement.fibers()) {
                if let Some(forces) = &forces {
                    rod.loads.clone_from(forces);
                }
                if let Some((matter, _)) = &matter {
                    let nodes = matter.along(natural.segment_lengths());
                    let set = rod.set_matter(natural, nodes);
                    set.map_err(|source| ChargingError::Rest { fiber, source })?;
                }
            }
        }
        Ok(())
    }

    /// Brings each fibre to rest by itself, in parallel.
    ///
    /// # Errors
    /// [`ChargingError::Rest`] with the first fibre that has no equilibrium.
    pub(crate) fn relax(&mut self) -> Result<(), ChargingError> {
        let gravity = &self.gravity;
        let results: Vec<_> = self.rods.par_iter_mut().map(|rod| rod.settle(gravity)).collect();
        for (fiber, result) in results.into_iter().enumerate() {
            result.map_err(|source| ChargingError::Rest { fiber, source })?;
        }
        Ok(())
    }

    /// Gives all fibres electric forces, N, world, coordinate by coordinate.
    pub(crate) fn hold(&mut self, held: &[f64]) {
        let layout = self.assembly.layout();
        for (fiber, rod) in self.rods.iter_mut().enumerate() {
            let nodes = layout.node_range(fiber);
            let forces = held[3 * nodes.start..3 * nodes.end].chunks(3);
            rod.electric = forces.map(|f| Vector3::new(f[0], f[1], f[2])).collect();
        }
    }

    /// How all fibres lie.
    pub(crate) fn shapes(&self) -> Vec<Shape> {
        self.rods.iter().map(|rod| rod.shape().clone()).collect()
    }

    /// Lays all fibres back.
    pub(crate) fn lie(&mut self, shapes: &[Shape]) {
        for (rod, shape) in self.rods.iter_mut().zip(shapes) {
            rod.lie(shape.clone());
        }
    }

    /// Nodes of all fibres, m, world.
    pub(crate) fn positions(&self) -> Vec<Point3<f64>> {
        self.rods.iter().flat_map(|rod| rod.positions().iter().copied()).collect()
    }

    /// Charges of all segments, C.
    pub(crate) fn charges(&self) -> Vec<f64> {
        self.rods.iter().flat_map(|rod| rod.charges.iter().copied()).collect()
    }
}
