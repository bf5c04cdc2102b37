use super::check::{Allowed, Check};
use super::load::{LoadFrame, TimedLoad};
use nalgebra::{Isometry3, UnitQuaternion};
use rapunzel_rod_dynamic as rod;
use serde::{Deserialize, Serialize};

/// What holds one freedom of a supported end.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Freedom {
    /// Nothing: only loads act.
    #[default]
    Free,
    /// It is held at its value at the start, and moved by the motion of the end.
    Held,
    /// A spring pulls it to where it would be if it were held.
    Sprung {
        /// Stiffness, N/m of a translation and N m/rad of a rotation.
        stiffness: f64,
    },
}

/// The axes along and about which the freedoms of an end are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum SupportAxes {
    /// The world's axes x, y, z.
    #[default]
    World,
    /// The material frame of the end at the start (d1, d2, tangent), turned by the motion of the
    /// end.
    End,
}

/// What holds each of the six freedoms of an end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Freedoms {
    pub(crate) axes: SupportAxes,
    pub(crate) translations: [Freedom; 3],
    pub(crate) rotations: [Freedom; 3],
}

impl Freedom {
    fn of_rod(self) -> rod::Restraint {
        match self {
            Self::Free => rod::Restraint::Free,
            Self::Held => rod::Restraint::Held,
            Self::Sprung { stiffness } => rod::Restraint::Sprung(stiffness),
        }
    }
}

impl Freedoms {
    /// The end at time `t`, s, with the pose that it would have if it were held.
    pub(crate) fn end(
        &self,
        t: f64,
        pose: Isometry3<f64>,
        [force, moment]: [&TimedLoad; 2],
    ) -> rod::End {
        rod::End::Supported(rod::EndSupport {
            pose,
            axes: match self.axes {
                SupportAxes::World => UnitQuaternion::identity(),
                SupportAxes::End => pose.rotation,
            },
            translations: self.translations.map(Freedom::of_rod),
            rotations: self.rotations.map(Freedom::of_rod),
            force: force.at(t),
            moment: moment.at(t),
        })
    }

    /// Reports problems of the freedoms, and those that are loaded although they are held.
    pub(crate) fn check(&self, check: &mut Check, [force, moment]: [&TimedLoad; 2]) {
        let axes = match self.axes {
            SupportAxes::World => LoadFrame::World,
            SupportAxes::End => LoadFrame::Follower,
        };
        for (field, three, unit, load, loads) in [
            ("translations", &self.translations, "N/m", force, "force"),
            ("rotations", &self.rotations, "N m/rad", moment, "moment"),
        ] {
            for (i, one) in three.iter().enumerate() {
                if let Freedom::Sprung { stiffness } = one {
                    let field = format!("{field}[{i}].stiffness");
                    check.number(&field, *stiffness, Allowed::Positive, unit);
                }
                let loaded = load.frame == axes && load.value[i] != 0.0;
                if *one == Freedom::Held && loaded {
                    let message = format!(
                        "is {:?}, but {field}[{i}] is Held, so that the load does nothing; leave \
                         one out",
                        load.value[i]
                    );
                    check.refuse(&format!("{loads}.value[{i}]"), message);
                }
            }
            let all = three.iter().all(|one| *one == Freedom::Held);
            if all && load.frame != axes && load.value != [0.0; 3] {
                let message = format!("is given, but all {field} are Held; leave one out");
                check.refuse(loads, message);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_freedom_that_is_held_and_loaded_is_named() {
        let (free, held) = (Freedom::Free, Freedom::Held);
        let mut freedoms = Freedoms {
            translations: [held, free, free],
            rotations: [free, free, Freedom::Sprung { stiffness: -1.0 }],
            ..Freedoms::default()
        };
        let (mut force, moment) = (TimedLoad::default(), TimedLoad::default());
        force.value = [1.0, 2.0, 0.0];
        let problems = |freedoms: &Freedoms, force: &TimedLoad| {
            let mut check = Check::default();
            freedoms.check(&mut check, [force, &moment]);
            check.finish(None).into_iter().map(|problem| problem.path).collect::<Vec<_>>()
        };
        assert_eq!(problems(&freedoms, &force), ["force.value[0]", "rotations[2].stiffness"]);
        force.frame = LoadFrame::Follower;
        freedoms.rotations = [free; 3];
        assert!(problems(&freedoms, &force).is_empty());
        freedoms.axes = SupportAxes::End;
        assert_eq!(problems(&freedoms, &force), ["force.value[0]"]);
        freedoms.translations = [held; 3];
        force.frame = LoadFrame::World;
        assert_eq!(problems(&freedoms, &force), ["force"]);
    }
}
