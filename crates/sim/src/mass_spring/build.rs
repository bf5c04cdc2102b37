use super::motion::{ErasedSystem, MovingSystem};
use super::space::flat;
use crate::scene::{MassSpring, Model, NodeContacts, NodePlaces, Wind};
use nalgebra::{Point, Point3, Vector3};
use rapunzel_mass_spring::{
    self as spring, Cells, Contacts, Enclosure, Lattice, PlaceMatrix, Rope, RoundBody, SpringError,
    Surface, System,
};

/// The system of a scene at its start.
pub(crate) fn build(scene: &MassSpring) -> Result<Box<dyn ErasedSystem>, SpringError> {
    let element = scene.element();
    match &scene.model {
        Model::Rope { nodes, spacing, direction, bending_stiffness, inextensible } => {
            let rope = Rope {
                nodes: *nodes,
                spacing: *spacing,
                element,
                bending_stiffness: *bending_stiffness,
                rigid: *inextensible,
            };
            let system = rope.build(Point3::from(scene.position), Vector3::from(*direction))?;
            moving(scene, system, Vec::new(), None)
        }
        Model::Net { place, spacing, triangular } => {
            let place = match place {
                NodePlaces::Line { rows, columns } => PlaceMatrix::line(*rows, *columns),
                NodePlaces::Flag { rows, columns } => PlaceMatrix::flag(*rows, *columns),
                NodePlaces::Flying { rows, columns } => PlaceMatrix::free(*rows, *columns),
                NodePlaces::Matrix { rows } => {
                    PlaceMatrix::new(&rows.iter().map(String::as_str).collect::<Vec<_>>())
                }
            }?;
            let cells = if *triangular { Cells::Triangular } else { Cells::Rectangular };
            let net = Lattice { place, spacing: *spacing, element, cells };
            moving::<3>(scene, net.build(Point3::from(scene.position))?, net.faces(), None)
        }
        Model::Body { shape, spacing } => {
            let corner = Point::from(flat::<2>(&scene.position));
            let body = shape.body().lattice(*spacing, element)?;
            moving(scene, body.build(corner)?, body.faces(), None)
        }
        Model::Ring { count, radius, tau } => {
            let ball = RoundBody { radius: *radius, element, radial: 1.0, tau: *tau };
            let (system, area) = ball.ring(flat::<2>(&scene.position).into(), *count)?;
            // With the mass in the middle, where its springs lead.
            let faces = area.facets().iter().map(|&[a, b]| vec![0, a, b]).collect();
            moving(scene, system, faces, Some(area))
        }
        Model::Ball { radius, fineness, tau } => {
            let ball = RoundBody { radius: *radius, element, radial: 1.0, tau: *tau };
            let (system, volume) = ball.sphere(scene.position.into(), *fineness)?;
            let faces = volume.facets().iter().map(|facet| facet.to_vec()).collect();
            moving(scene, system, faces, Some(volume))
        }
    }
}

fn moving<const D: usize>(
    scene: &MassSpring,
    mut system: System<D>,
    faces: Vec<Vec<usize>>,
    enclosure: Option<Enclosure<D>>,
) -> Result<Box<dyn ErasedSystem>, SpringError>
where
    MovingSystem<D>: ErasedSystem,
{
    if let Some(strain) = scene.yield_strain {
        system.set_yield_strain(strain)?;
    }
    system.set_wind(wind(&scene.wind))?;
    for load in &scene.loads {
        system.set_load(load.node, flat(&load.force))?;
    }
    for tie in &scene.ties {
        system.pin_to(tie.node, tie.to)?;
    }
    for hold in &scene.holds {
        // Only to find out whether there is such a node.
        system.clone().pin(hold.node)?;
    }
    let touching = |&NodeContacts { radius, restitution, friction, mutual, .. }: &NodeContacts| {
        Contacts::new(&system, Surface { radius, restitution, friction }, mutual)
    };
    let contacts = scene.contacts.as_ref().map(touching).transpose()?;
    let chain = matches!(scene.model, Model::Rope { inextensible: true, .. });
    Ok(Box::new(MovingSystem::new(scene, system, faces, enclosure, contacts, chain)))
}

fn wind<const D: usize>(wind: &Wind) -> spring::WindField<D> {
    match wind {
        Wind::Steady { velocity } => spring::WindField::steady(flat(velocity)),
        Wind::Gusts { velocity, gust, period } => {
            spring::WindField { steady: flat(velocity), pulse: flat(gust), period: *period }
        }
    }
}

/// Names and units of the [readings](Springs::readings) of a scene.
pub(crate) fn readings(scene: &MassSpring) -> Vec<String> {
    let ledger = ["load (J)", "dissipation (W)", "supports (W)"];
    let wind = ["wind x (m/s)", "wind y (m/s)", "wind z (m/s)"];
    let mut names: Vec<_> = ledger.into_iter().chain(wind).map(str::to_owned).collect();
    let enclosed = match scene.model {
        Model::Ring { .. } => Some(("area", "m^2")),
        Model::Ball { .. } => Some(("volume", "m^3")),
        _ => None,
    };
    if let Some((what, unit)) = enclosed {
        names.extend([format!("{what} ({unit})"), format!("{what} at rest ({unit})")]);
    }
    names
}
