//! What of a scene can be changed by sliders.

use rapunzel_scene::{Amount, Bundle, FrictionLaw, Model, Scene, Wind};

/// A number of a scene that can be changed while it runs.
pub(crate) struct Knob {
    /// Its name, by which pages know it.
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Whether a slider goes by factors rather than by differences.
    pub(crate) by_factors: bool,
    /// The number; none where the scene has no such thing.
    pub(crate) read: fn(&Scene) -> Option<f64>,
    write: fn(&mut Scene, f64),
}

impl Knob {
    /// The knob of a name that a scene has.
    pub(crate) fn of(scene: &Scene, name: &str) -> Option<&'static Self> {
        KNOBS.iter().find(|knob| knob.name == name && (knob.read)(scene).is_some())
    }

    /// Sets the number, within its range.
    pub(crate) fn set(&self, scene: &mut Scene, value: f64) {
        (self.write)(scene, value.clamp(self.low, self.high));
    }
}

/// All knobs, in the order in which they are shown.
pub(crate) const KNOBS: &[Knob] = &[
    Knob {
        name: "frequency",
        unit: "Hz",
        low: 1.0,
        high: 400.0,
        by_factors: true,
        read: |scene| scene.mass_spring.as_ref().map(|springs| springs.frequency),
        write: |scene, x| scene.mass_spring.iter_mut().for_each(|springs| springs.frequency = x),
    },
    Knob {
        name: "damping",
        unit: "",
        low: 0.0,
        high: 1.0,
        by_factors: false,
        read: |scene| scene.mass_spring.as_ref().map(|springs| springs.damping_ratio),
        write: |scene, x| {
            scene.mass_spring.iter_mut().for_each(|springs| springs.damping_ratio = x);
        },
    },
    Knob {
        name: "drag",
        unit: "1/s",
        low: 0.0,
        high: 10.0,
        by_factors: false,
        read: |scene| scene.mass_spring.as_ref().map(|springs| springs.drag),
        write: |scene, x| {
            if let Some(springs) = &mut scene.mass_spring {
                springs.drag = x;
                // Wind acts through the drag, and without it there is none.
                if x == 0.0 {
                    springs.wind = Wind::default();
                }
            }
        },
    },
    Knob {
        name: "substeps",
        unit: "",
        low: 1.0,
        high: 64.0,
        by_factors: true,
        read: |scene| scene.mass_spring.as_ref().map(|springs| springs.substeps as f64),
        write: |scene, x| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
            let substeps = x.round() as usize;
            scene.mass_spring.iter_mut().for_each(|springs| springs.substeps = substeps);
        },
    },
    Knob {
        name: "area_control",
        unit: "",
        low: 0.0,
        high: 1.0,
        by_factors: false,
        read: |scene| match scene.mass_spring.as_ref()?.model {
            Model::Ring { tau, .. } | Model::Ball { tau, .. } => Some(tau),
            _ => None,
        },
        write: |scene, x| {
            if let Some(springs) = &mut scene.mass_spring
                && let Model::Ring { tau, .. } | Model::Ball { tau, .. } = &mut springs.model
            {
                *tau = x;
            }
        },
    },
    Knob {
        name: "gravity",
        unit: "m/s²",
        low: -20.0,
        high: 20.0,
        by_factors: false,
        read: |scene| Some(-scene.environment.gravity[2]),
        write: |scene, x| scene.environment.gravity[2] = -x,
    },
    wind_knob("wind_x", |scene| wind(scene, 0), |scene, x| set_wind(scene, 0, x)),
    wind_knob("wind_y", |scene| wind(scene, 1), |scene, x| set_wind(scene, 1, x)),
    wind_knob("wind_z", |scene| wind(scene, 2), |scene, x| set_wind(scene, 2, x)),
    Knob {
        name: "gust_period",
        unit: "s",
        low: 0.1,
        high: 20.0,
        by_factors: true,
        read: |scene| match air(scene)? {
            Wind::Gusts { period, .. } => Some(*period),
            Wind::Steady { .. } => None,
        },
        write: |scene, x| {
            if let Some(Wind::Gusts { period, .. }) = air_mut(scene) {
                *period = x;
            }
        },
    },
    Knob {
        name: "friction",
        unit: "",
        low: 0.0,
        high: 2.0,
        by_factors: false,
        read: |scene| match (&scene.mass_spring, &scene.contact) {
            (Some(springs), _) => Some(springs.contacts.as_ref()?.friction),
            (None, Some(contact)) => match contact.friction {
                FrictionLaw::Isotropic(friction) => Some(friction),
                _ => None,
            },
            (None, None) => None,
        },
        write: |scene, x| {
            let springs = scene.mass_spring.as_mut();
            if let Some(contacts) = springs.and_then(|springs| springs.contacts.as_mut()) {
                contacts.friction = x;
            } else if let Some(contact) = &mut scene.contact {
                contact.friction = FrictionLaw::Isotropic(x);
            }
        },
    },
    Knob {
        name: "restitution",
        unit: "",
        low: 0.0,
        high: 1.0,
        by_factors: false,
        read: |scene| match (&scene.mass_spring, &scene.contact) {
            (Some(springs), _) => Some(springs.contacts.as_ref()?.restitution),
            (None, Some(contact)) => Some(contact.restitution),
            (None, None) => None,
        },
        write: |scene, x| {
            let springs = scene.mass_spring.as_mut();
            if let Some(contacts) = springs.and_then(|springs| springs.contacts.as_mut()) {
                contacts.restitution = x;
            } else if let Some(contact) = &mut scene.contact {
                contact.restitution = x;
            }
        },
    },
    Knob {
        name: "damping_time",
        unit: "s",
        low: 1e-5,
        high: 0.1,
        by_factors: true,
        read: |scene| {
            let time = scene.fibers.first()?.damping_time;
            (time > 0.0).then_some(time)
        },
        write: |scene, x| {
            let damped = scene.fibers.iter_mut().filter(|bundle| bundle.damping_time > 0.0);
            damped.for_each(|bundle| bundle.damping_time = x);
        },
    },
    Knob {
        name: "fiber_charge",
        unit: "C",
        low: 1e-14,
        high: 1e-8,
        by_factors: true,
        read: |scene| {
            scene.charging.as_ref()?;
            let charge = charge_of_a_fiber(scene.fibers.first()?).abs();
            (charge > 0.0).then_some(charge)
        },
        write: |scene, x| {
            let Some(before) = scene.fibers.first().map(charge_of_a_fiber) else { return };
            let factor = x / before.abs();
            scene.fibers.iter_mut().for_each(|bundle| scale(&mut bundle.charge.amount, factor));
            if let Some(Amount::Fiber(charge)) =
                scene.fibers.first_mut().map(|b| &mut b.charge.amount)
            {
                // Without the rounding of the factor.
                *charge = x.copysign(before);
            }
        },
    },
    Knob {
        name: "humidity",
        unit: "",
        low: 0.0,
        high: 1.0,
        by_factors: false,
        read: |scene| {
            let keratin = scene.fibers.iter().any(|bundle| bundle.material.keratin().is_some());
            let climate = &scene.environment.climate;
            let steady = keratin && !climate.changes();
            climate.humidity.first().filter(|_| steady).map(|(_, humidity)| *humidity)
        },
        write: |scene, x| scene.environment.climate.humidity = vec![(0.0, x)],
    },
    Knob {
        name: "temperature",
        unit: "°C",
        low: 0.0,
        high: 60.0,
        by_factors: false,
        read: |scene| {
            let keratin = scene.fibers.iter().any(|bundle| bundle.material.keratin().is_some());
            keratin.then_some(scene.environment.climate.temperature)
        },
        write: |scene, x| scene.environment.climate.temperature = x,
    },
];

/// Charge of the first fibre of a bundle, C.
fn charge_of_a_fiber(bundle: &Bundle) -> f64 {
    match bundle.charge.amount {
        Amount::Fiber(charge) => charge,
        _ => {
            let fibers = bundle.arrangement.fibers();
            bundle.charge.of_segments(0, fibers, bundle.length, bundle.segments).iter().sum()
        }
    }
}

fn scale(amount: &mut Amount, factor: f64) {
    match amount {
        Amount::Fibers(charges) => charges.iter_mut().for_each(|charge| *charge *= factor),
        Amount::Fiber(x)
        | Amount::Bundle(x)
        | Amount::CoulombPerMeter(x)
        | Amount::StatcoulombPerCentimeter(x) => *x *= factor,
    }
}

/// A slider of a component of the wind.
const fn wind_knob(
    name: &'static str,
    read: fn(&Scene) -> Option<f64>,
    write: fn(&mut Scene, f64),
) -> Knob {
    Knob { name, unit: "m/s", low: -20.0, high: 20.0, by_factors: false, read, write }
}

/// The wind of a scene, if it acts on something.
fn air(scene: &Scene) -> Option<&Wind> {
    match &scene.mass_spring {
        Some(springs) => (springs.drag > 0.0).then_some(&springs.wind),
        None => (scene.environment.viscosity > 0.0).then_some(&scene.environment.wind),
    }
}

fn air_mut(scene: &mut Scene) -> Option<&mut Wind> {
    match &mut scene.mass_spring {
        Some(springs) => (springs.drag > 0.0).then_some(&mut springs.wind),
        None => (scene.environment.viscosity > 0.0).then_some(&mut scene.environment.wind),
    }
}

/// A component of the wind: of gusts, where it blows in gusts.
fn wind(scene: &Scene, axis: usize) -> Option<f64> {
    Some(match air(scene)? {
        Wind::Steady { velocity } => velocity[axis],
        Wind::Gusts { gust, .. } => gust[axis],
    })
}

fn set_wind(scene: &mut Scene, axis: usize, x: f64) {
    match air_mut(scene) {
        Some(Wind::Steady { velocity }) => velocity[axis] = x,
        Some(Wind::Gusts { gust, .. }) => gust[axis] = x,
        None => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(body: &str) -> Scene {
        let text = format!("(format: 1, duration: 1.0, stepper: (dt: 1e-3), {body})");
        Scene::from_ron(&text).expect("a scene")
    }

    fn rope() -> Scene {
        scene(
            "mass_spring: (
                model: Rope(nodes: 4, spacing: 0.1, direction: (0.0, 0.0, -1.0)),
                mass: 0.01, frequency: 40.0, drag: 0.2,
            )",
        )
    }

    #[test]
    fn every_slider_of_a_scene_reads_what_it_wrote() {
        let hair = scene(
            "fibers: [(
                length: 0.1, segments: 10, damping_time: 1e-3,
                material: Keratin(type: \"West European\"),
            )],
            contact: (friction: Isotropic(0.3)), environment: (viscosity: 1.8e-5)",
        );
        let charged = scene(
            "fibers: [(
                length: 0.1, segments: 10, material: Keratin(type: \"West European\"),
                charge: (amount: Fiber(-1e-11)),
            )],
            charging: (dealing: Falling(3))",
        );
        let mut seen = 0;
        for mut scene in [rope(), hair, charged] {
            for knob in KNOBS {
                if (knob.read)(&scene).is_none() {
                    continue;
                }
                let middle = 0.5 * (knob.low + knob.high);
                let middle = if middle > 1.0 { middle.round() } else { middle };
                knob.set(&mut scene, middle);
                assert_eq!((knob.read)(&scene), Some(middle), "{}", knob.name);
                knob.set(&mut scene, 1e6);
                assert_eq!((knob.read)(&scene), Some(knob.high), "{}", knob.name);
                seen += 1;
            }
        }
        assert!(seen >= 18, "{seen}");
    }

    #[test]
    fn the_charge_of_all_bundles_goes_by_one_slider_and_keeps_its_sign() {
        let bundle = |amount: &str| {
            format!(
                "(length: 0.1, segments: 10, charge: (amount: {amount}), section: Circle(radius: 3e-5))"
            )
        };
        let bundles = ["CoulombPerMeter(-1e-10)", "Bundle(4e-11)"].map(bundle).join(",");
        let mut scene = scene(&format!("fibers: [{bundles}], charging: (dealing: Falling(3))"));
        let knob = Knob::of(&scene, "fiber_charge").expect("a slider");
        let before = (knob.read)(&scene).expect("a charge");
        assert!((before - 1e-11).abs() < 1e-24, "{before}");
        knob.set(&mut scene, 3e-11);
        let after: Vec<_> = scene.fibers.iter().map(charge_of_a_fiber).collect();
        assert!((after[0] + 3e-11).abs() < 1e-24 && (after[1] - 12e-11).abs() < 1e-23, "{after:?}");
    }

    #[test]
    fn a_scene_has_the_sliders_of_what_is_in_it() {
        let of = |scene: &Scene| {
            let own = KNOBS.iter().filter(|knob| (knob.read)(scene).is_some());
            own.map(|knob| knob.name).collect::<Vec<_>>()
        };
        let springs = ["frequency", "damping", "drag", "substeps", "gravity"];
        let wind = ["wind_x", "wind_y", "wind_z"];
        assert_eq!(of(&rope()), [&springs[..], &wind[..]].concat());
        assert!(Knob::of(&rope(), "friction").is_none() && Knob::of(&rope(), "drag").is_some());
    }
}
