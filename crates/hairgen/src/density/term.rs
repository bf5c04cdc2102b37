use super::VoxelFrame;
use crate::quadrature::trapezoid;
use nalgebra::{Matrix3, Point3, Vector3};
use rapunzel_rod_static::{Shape, ShapeDerivatives};
use serde::{Deserialize, Serialize};

/// How hair that is there counts for guides that are laid after it (thesis 5.3.4).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum DensityModel {
    /// The voxels that a wisp of this radius around a guide meets are occupied (5.11).
    Binary {
        /// Radius of a wisp, m.
        radius: f64,
    },
    /// Each voxel sums up the lengths of the guides in it, over its diagonal (5.12).
    Continuous {
        /// Density that is not to be exceeded.
        most: f64,
    },
}

/// The density of hair in voxels, that grows with each hair laid.
///
/// The count of (5.11) has no derivative; the term that a search takes instead is the occupied part
/// of the 5³ voxels around each, interpolated between their centers and integrated along the hair.
/// The term (5.12)
/// turns hair into surfaces of the same density but does not keep it from dense places, which the
/// text before it wants: a penalty is added for a density above the largest.
#[derive(Debug, Clone, PartialEq)]
pub struct HairDensity {
    frame: VoxelFrame,
    model: DensityModel,
    /// Whether hair is in each voxel.
    occupied: Vec<bool>,
    /// The densities of the voxels.
    cells: Vec<f64>,
}

/// Voxels to each side over which the binary occupancy is averaged.
const REACH: i64 = 2;

impl HairDensity {
    /// No hair yet.
    #[must_use]
    pub fn new(frame: VoxelFrame, model: DensityModel) -> Self {
        let count = frame.voxel_count();
        Self { frame, model, occupied: vec![false; count], cells: vec![0.0; count] }
    }

    /// The densities of the voxels by their numbers: the occupied part of those around in the
    /// binary model, length over diagonal in the continuous one.
    #[must_use]
    pub fn cells(&self) -> &[f64] {
        &self.cells
    }

    /// The voxels.
    #[must_use]
    pub fn frame(&self) -> VoxelFrame {
        self.frame
    }

    /// Adds a hair along `points` (world), m.
    pub fn add(&mut self, points: &[Point3<f64>]) {
        let diagonal = self.frame.spacing() * 3.0_f64.sqrt();
        let (frame, model) = (self.frame, self.model);
        for ends in points.windows(2) {
            let [start, end] = [&ends[0], &ends[1]];
            match model {
                DensityModel::Binary { radius } => {
                    frame.cover([start, end], radius, |voxel| self.occupy(voxel));
                }
                DensityModel::Continuous { .. } => frame.walk(start, end, |voxel, part| {
                    self.occupied[voxel] = true;
                    self.cells[voxel] += part / diagonal;
                }),
            }
        }
    }

    /// Takes a voxel into the means of those around it, once.
    fn occupy(&mut self, voxel: usize) {
        if std::mem::replace(&mut self.occupied[voxel], true) {
            return;
        }
        let side = 2 * REACH + 1;
        let share = ((side * side * side) as f64).recip();
        let [i, j, k] = self.frame.index(&self.frame.scaled(&self.frame.center(voxel)));
        for n in 0..side * side * side {
            let off = [n % side, n / side % side, n / (side * side)].map(|x| x - REACH);
            if let Some(around) = self.frame.voxel([i + off[0], j + off[1], k + off[2]]) {
                self.cells[around] += share;
            }
        }
    }

    /// How many of the segments between the `points` (world) cross a voxel with hair: the sum of
    /// (5.11).
    #[must_use]
    pub fn crossings(&self, points: &[Point3<f64>]) -> usize {
        let crosses = |ends: &&[Point3<f64>]| {
            let mut crosses = false;
            self.frame.walk(&ends[0], &ends[1], |voxel, _| crosses |= self.occupied[voxel]);
            crosses
        };
        points.windows(2).filter(crosses).count()
    }

    fn cell(&self, index: [i64; 3]) -> f64 {
        self.frame.voxel(index).map_or(0.0, |voxel| self.cells[voxel])
    }

    /// Gradient at the center of a voxel by central differences, per voxel.
    fn slope(&self, index: [i64; 3]) -> Vector3<f64> {
        let difference = |k: usize| {
            let [mut low, mut high] = [index; 2];
            low[k] -= 1;
            high[k] += 1;
            0.5 * (self.cell(high) - self.cell(low))
        };
        Vector3::new(difference(0), difference(1), difference(2))
    }

    /// The term of a guide's objective, integrated over its scaled length. Adds `weight` times its
    /// derivatives.
    pub(crate) fn term(&self, shape: &Shape, weight: f64, by: &mut ShapeDerivatives) -> f64 {
        let segments = shape.positions().len() - 1;
        let mut sum = 0.0;
        for (node, position) in shape.positions().iter().enumerate() {
            let part = trapezoid(node, segments);
            let (value, by_place) = self.frame.interpolate(position, |index| self.cell(index));
            match self.model {
                DensityModel::Binary { .. } => {
                    sum += part * value;
                    by.positions[node] += Vector3::from(by_place) * (weight * part);
                }
                DensityModel::Continuous { most } => {
                    // The square of the gradient along the tangent (5.12), in voxels and in units
                    // of the largest density.
                    let tangent = shape.frames()[node] * Vector3::z();
                    let (slope, by_axes) =
                        self.frame.interpolate(position, |index| self.slope(index) / most);
                    let along = slope.dot(&tangent);
                    sum += part * along * along;
                    let by_slope = Matrix3::from_columns(&by_axes).tr_mul(&tangent);
                    by.positions[node] += by_slope * (2.0 * weight * part * along);
                    by.tangents[node] += slope * (2.0 * weight * part * along);
                    // Above the largest density.
                    let above = (value / most - 1.0).max(0.0);
                    sum += part * above * above;
                    let push = 2.0 * weight * part * above / most;
                    by.positions[node] += Vector3::from(by_place) * push;
                }
            }
        }
        sum
    }
}
