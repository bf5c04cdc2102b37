use crate::folder::{SPRINGS_USD, USD};
use crate::scene::{MassSpring, Scene, Tip};
use crate::stepper::{FiberStates, Scenery};
use nalgebra::{Point3, Vector3};
use rapunzel_export::Strand;
use rapunzel_export::usd::{Prim, PrimShape};
use rapunzel_rod_dynamic::NodeQuantity;
use rapunzel_studio::Coloring;
use rapunzel_studio::sheet::Support;
use std::ops::Range;

/// Colours of hair, bundle by bundle: red, green and blue, linear.
const HAIR: [[f64; 3]; 6] = [
    [0.09, 0.045, 0.02],
    [0.35, 0.2, 0.08],
    [0.25, 0.06, 0.02],
    [0.03, 0.02, 0.015],
    [0.55, 0.4, 0.2],
    [0.35, 0.33, 0.3],
];
/// From the start on.
const ALWAYS: Range<f64> = 0.0..f64::INFINITY;

/// Number of nodes of each fibre.
pub(super) fn fiber_nodes(fibers: &dyn FiberStates) -> Vec<usize> {
    let layout = fibers.assembly().layout();
    (0..layout.fibers()).map(|fiber| layout.node_range(fiber).len()).collect()
}

/// What acts on the nodes of all fibres; a list is empty where nothing does.
#[derive(Default)]
pub(super) struct NodeLoads {
    /// Forces of contacts (world), N.
    pub(super) contact_forces: Vec<Vector3<f64>>,
    /// Charges, C.
    pub(super) charges: Vec<f64>,
}

/// All fibres as they are now, one after another: all strands together are half as much as the
/// state.
pub(super) fn fiber_strands(
    fibers: &dyn FiberStates,
    loads: NodeLoads,
) -> impl Iterator<Item = Strand> {
    let assembly = fibers.assembly();
    (0..assembly.fibers().len()).map(move |fiber| {
        let state = fibers.state(fiber);
        let nodes = assembly.layout().node_range(fiber);
        let none = || vec![Vector3::zeros(); nodes.len()];
        Strand {
            contact_forces: loads.contact_forces.get(nodes.clone()).map_or_else(none, Into::into),
            charges: loads.charges.get(nodes.clone()).map_or(vec![0.0; nodes.len()], Into::into),
            points: state.positions,
            radii: assembly.radii()[nodes].to_vec(),
            velocities: state.velocities,
            frames: state.frames,
            curvatures: state.curvatures,
            forces: state.forces,
        }
    })
}

/// Appends the points of [`fiber_strands`].
pub(super) fn fiber_points(fibers: &dyn FiberStates, into: &mut Vec<Point3<f64>>) {
    let layout = fibers.assembly().layout();
    into.reserve(layout.nodes());
    (0..layout.fibers()).for_each(|fiber| fibers.node_positions(fiber, into));
}

/// Appends what colors show at these points; loads are asked for where they are shown.
pub(super) fn fiber_values(
    fibers: &dyn FiberStates,
    of: Coloring,
    loads: impl FnOnce() -> NodeLoads,
    into: &mut Vec<f64>,
) {
    let assembly = fibers.assembly();
    let layout = assembly.layout();
    into.reserve(layout.nodes());
    let begin = into.len();
    let mut read = |of| (0..layout.fibers()).for_each(|fiber| fibers.node_values(fiber, of, into));
    match of {
        Coloring::Speed => read(NodeQuantity::Speed),
        Coloring::Curvature => read(NodeQuantity::Curvature),
        Coloring::Tension => read(NodeQuantity::Tension),
        Coloring::Strain => {
            read(NodeQuantity::Curvature);
            let values = into[begin..].iter_mut().zip(assembly.radii());
            values.for_each(|(value, radius)| *value *= radius);
        }
        Coloring::Contact => into.extend(loads().contact_forces.iter().map(|force| force.norm())),
        Coloring::Charge => into.extend(loads().charges),
        Coloring::Fiber => {
            let of = |fiber| layout.node_range(fiber).map(move |_| fiber as f64);
            into.extend((0..layout.fibers()).flat_map(of));
        }
    }
    // No loads are told where there are none.
    into.resize(begin + layout.nodes(), 0.0);
}

impl Scenery {
    /// The USD layer of fibres, and the prim that holds them.
    pub(crate) const FIBERS: (&'static str, &'static str) = (USD, "Fibers");
    /// The USD layer of springs, and the prim that holds them.
    pub(crate) const SPRINGS: (&'static str, &'static str) = (SPRINGS_USD, "Springs");
    /// Colour of springs and other lines: red, green and blue, linear.
    pub(crate) const ROPE: [f64; 3] = [0.5, 0.4, 0.25];

    /// The scenery of the fibres of a scene, whose bundles have fibres of these numbers of
    /// `segments`: a prim for each bundle.
    pub(crate) fn of_fibers(scene: &Scene, segments: &[Vec<usize>]) -> Self {
        let bundles = segments.iter().scan(0, |end, fibers| {
            let first = *end;
            *end += fibers.len();
            Some(first..*end)
        });
        let prim = |(i, strands): (usize, Range<usize>)| Prim {
            name: format!("Bundle_{i}"),
            shape: PrimShape::Curves { strands, guide: false },
            color: HAIR[i % HAIR.len()],
        };
        let prims = bundles.enumerate().map(prim).collect();
        Self { layer: Self::FIBERS, prims, supports: fiber_supports(scene, segments) }
    }

    /// The scenery of a mass-spring system at its start: lines, which are a guide to its surface if
    /// it has one. `places` are strand and point of nodes, `is_held` tells whether something holds
    /// a node.
    pub(crate) fn of_springs(
        scene: &MassSpring,
        lines: usize,
        surface: Option<PrimShape>,
        places: impl IntoIterator<Item = (usize, [usize; 2])>,
        is_held: impl Fn(usize) -> bool,
    ) -> Self {
        let shape = PrimShape::Curves { strands: 0..lines, guide: surface.is_some() };
        let prim =
            |(name, shape): (&str, _)| Prim { name: name.to_owned(), shape, color: Self::ROPE };
        let surface = surface.map(|shape| ("Surface", shape));
        let prims = surface.into_iter().chain([("Lines", shape)]).map(prim).collect();
        let mut supports = Vec::new();
        for (node, [strand, point]) in places {
            let support = Support { strand, point, clamped: false };
            let taken = scene.holds.iter().filter(|hold| hold.node == node);
            let end = |release, until| if release { until } else { f64::INFINITY };
            if is_held(node) {
                let ends = taken.clone().map(|hold| end(hold.release, hold.until));
                supports.push((support, 0.0..ends.fold(f64::INFINITY, f64::min)));
            }
            supports.extend(taken.map(|hold| (support, hold.from..end(hold.release, hold.until))));
        }
        Self { layer: Self::SPRINGS, prims, supports }
    }
}

/// What holds the ends of fibres, and when, s.
fn fiber_supports(scene: &Scene, segments: &[Vec<usize>]) -> Vec<(Support, Range<f64>)> {
    let bundles = scene.fibers.iter().zip(segments);
    let fibers =
        bundles.flat_map(|(bundle, all)| all.iter().map(move |segments| (bundle, segments)));
    let supports = fibers.enumerate().flat_map(|(strand, (bundle, segments))| {
        let tip = match &bundle.tip {
            Tip::Free | Tip::Loaded { .. } => None,
            Tip::Pulled { until, .. } => Some((true, 0.0..*until)),
            Tip::Held => Some((true, ALWAYS)),
            Tip::Driven { joint, .. } | Tip::Led { joint, .. } => {
                joint.clamps().map(|clamped| (clamped, ALWAYS))
            }
        };
        // Roots of hair are many, and seen to be in the skin.
        let root = bundle.root_joint.clamps().filter(|_| bundle.groom.is_none());
        let root = root.map(|clamped| (clamped, ALWAYS));
        let ends = [(0, root), (*segments, tip)];
        ends.into_iter().filter_map(move |(point, hold)| {
            let (clamped, times) = hold?;
            Some((Support { strand, point, clamped }, times))
        })
    });
    supports.collect()
}
