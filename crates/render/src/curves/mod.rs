//! Fibres as swept curves: tubes around cubics or straight pieces, round or elliptical.

mod capsules;
mod fiber;
mod piece;
mod search;
mod store;
mod tube;

use crate::check::check;
use crate::tree::{LeafThings, NONE, RayQuery, RayTree, TreeRay, WIDTH, rounding, single, walk};
use crate::{Ray, RenderError};
use capsules::{CapsuleBlock, CurveCapsule, CurvePart, MovingEnds};
pub use fiber::FiberCurve;
use nalgebra::{Point3, Vector3};
pub use piece::CurveForm;
use rayon::prelude::*;
use search::CurveSearch;
use store::CurveStore;
use tube::Tube;
pub(crate) use tube::across;
pub use tube::{CurveHit, TubePoint};

/// Leaves that are filled together.
const LEAVES_PER_TASK: usize = 4096;

/// Fibres as tubes, in a tree that finds where rays meet them.
///
/// A point of a tube lies in the normal plane of a point of its curve, on the section around it. A
/// tube is open at its ends, and only where a ray comes in from outside it is met: light that a
/// fibre scatters goes on from where it came in.
#[derive(Debug, Clone)]
pub struct Curves {
    store: CurveStore,
    tree: RayTree,
    blocks: Vec<CapsuleBlock>,
    /// Ways of both ends of the capsules, where something moves.
    moving: Vec<MovingEnds>,
    middle: Point3<f64>,
    extent: f64,
}

impl Curves {
    /// Tubes around fibres; `ratio` is that of the second semi-axis of their elliptical sections to
    /// the first, none for round ones. Cost: see the bench `rays`.
    ///
    /// # Errors
    /// [`RenderError::Curve`] names the fibre that has too few nodes, lists of other lengths, or
    /// what is not finite or not positive; [`RenderError::Parameter`] refuses a ratio, and more
    /// nodes than 2^27.
    pub fn new(
        form: CurveForm,
        ratio: Option<f64>,
        fibers: &[FiberCurve],
    ) -> Result<Self, RenderError> {
        if let Some(ratio) = ratio {
            let allowed = ratio > 0.0 && ratio.is_finite();
            check("the ratio of semi-axes", ratio, "positive and finite", allowed)?;
        }
        let aspect = ratio.map(|ratio| [ratio.sqrt().recip(), ratio.sqrt()]);
        let moves = fibers.iter().any(|fiber| !fiber.ways.is_empty());
        let nodes = fibers.iter().map(|fiber| fiber.nodes.len()).sum();
        let mut store = CurveStore::new(form, aspect, [fibers.len(), nodes]);
        for (index, fiber) in fibers.iter().enumerate() {
            fiber.check(index, aspect.is_some())?;
            store.add(fiber, moves);
        }
        let count = store.points();
        check("the number of all nodes", count as f64, "at most 2^27", count <= CurvePart::PIECES)?;
        Ok(Self::planted(store))
    }

    /// Makes the tree.
    fn planted(store: CurveStore) -> Self {
        let [low, high] = store.bounds().unwrap_or([Point3::origin(); 2]);
        let middle = nalgebra::center(&low, &high);
        // What is flat still has an inside.
        let extent = (0.5 * (high - low).amax()).max(f64::MIN_POSITIVE) * (1.0 + 1e-6);
        let (spare, moves) = (rounding(extent), store.moves());
        // A piece when the exposure begins, 0, or ends, 1, and what holds a part of it.
        let tube = |piece: u32, time| store.tube(piece as usize, time, &middle);
        let capsule = |part: CurvePart, now: &Tube| {
            let still = CurveCapsule::new(part, now, spare);
            if moves { still.to(&tube(part.piece(), 1.0), spare) } else { still }
        };
        let of_fiber = |[first, end]: [u32; 2]| {
            let mut boxes = Vec::with_capacity((end - first) as usize);
            for piece in first..end {
                let now = tube(piece, 0.0);
                let bounds = |part| capsule(part, &now).bounds();
                boxes.extend(CurvePart::all(piece, &now).map(bounds));
            }
            boxes
        };
        let pieces: Vec<_> = store.pieces().collect();
        let boxes = pieces.into_par_iter().flat_map_iter(of_fiber).collect();
        let (tree, leaves) = RayTree::new(boxes);
        let of = |part: CurvePart| capsule(part, &tube(part.piece(), 0.0));
        let set = |block: &mut CapsuleBlock, lane, part| block.set(lane, &of(part));
        let blocks = filled(&leaves, CapsuleBlock::EMPTY, set);
        let moving = if moves {
            filled(&leaves, MovingEnds::REST, |ways, lane, part| ways.set(lane, &of(part)))
        } else {
            Vec::new()
        };
        Self { store, tree, blocks, moving, middle, extent }
    }

    /// Number of fibres.
    #[must_use]
    pub fn len(&self) -> usize {
        self.store.len()
    }

    /// Whether there is no fibre.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of nodes of all fibres.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.store.nodes()
    }

    /// Two corners of a box that holds all tubes at all times (world), m; none if there is no
    /// fibre.
    #[must_use]
    pub fn bounds(&self) -> Option<[Point3<f64>; 2]> {
        self.store.bounds()
    }

    /// Memory of all, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.store.bytes()
            + size_of_val(self.blocks.as_slice())
            + size_of_val(self.moving.as_slice())
            + self.tree.bytes()
    }

    /// The first place where a ray comes into a tube, farther than `range[0]` and nearer than
    /// `range[1]`, m. Cost: see the bench `rays`.
    #[must_use]
    pub fn hit(&self, ray: &Ray, range: [f64; 2]) -> Option<CurveHit> {
        self.search(ray, range, RayQuery::Nearest)
    }

    /// Whether a ray comes into any tube between two distances, m.
    #[must_use]
    pub fn hides(&self, ray: &Ray, range: [f64; 2]) -> bool {
        self.search(ray, range, RayQuery::Any).is_some()
    }

    fn search(&self, ray: &Ray, range: [f64; 2], query: RayQuery) -> Option<CurveHit> {
        let mut in_tree = TreeRay::new(ray, range, &self.middle, self.extent)?;
        let across = across(&ray.direction).map(|axis| single(&axis.into()));
        let Self { store, blocks, moving, .. } = self;
        let mut leaves = CurveSearch { store, blocks, moving, ray, range, across };
        walk(&self.tree, &mut leaves, &mut in_tree, query)
    }

    /// What is at a hit of a ray.
    #[must_use]
    pub fn at(&self, ray: &Ray, hit: &CurveHit) -> TubePoint {
        self.store.at(ray, hit)
    }

    /// What is given at the nodes of all fibres, one after another, at a point of a tube.
    pub(crate) fn between(&self, point: &TubePoint, at_nodes: &[Vector3<f32>]) -> Vector3<f32> {
        self.store.between(point, at_nodes)
    }
}

/// What is made of leaves, filled lane by lane with what is made of parts. The parts of a batch
/// come in the order of the fibres: what they are made of lies side by side in memory, and far from
/// that of the neighbours in a leaf.
fn filled<T: Copy + Send + Sync>(
    leaves: &[LeafThings],
    empty: T,
    set: impl Fn(&mut T, usize, CurvePart) + Sync,
) -> Vec<T> {
    let mut all: Vec<T> = leaves.par_iter().map(|_| empty).collect();
    all.par_chunks_mut(LEAVES_PER_TASK).zip(leaves.par_chunks(LEAVES_PER_TASK)).for_each(
        |(batch, leaves)| {
            let things = leaves.as_flattened().iter().copied().zip(0_u32..);
            let mut order: Vec<_> = things.filter(|(thing, _)| *thing != NONE).collect();
            order.sort_unstable_by_key(|(thing, at)| u64::from(*thing) << 32 | u64::from(*at));
            for (thing, at) in order {
                let at = at as usize;
                set(&mut batch[at / WIDTH], at % WIDTH, CurvePart::from_thing(thing));
            }
        },
    );
    all
}
