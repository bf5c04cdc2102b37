//! Kinds of scenes: by a button one goes through those of a kind.

use crate::GalleryScene;
use rapunzel_scene::{Model, Scene};

/// What kind of scene it is; scenes of one kind are variants of each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Rope,
    Net,
    Body,
    Round,
    Fibers,
    Contact,
    Charge,
}

impl Kind {
    pub(crate) fn of(scene: &Scene) -> Self {
        match scene.mass_spring.as_ref().map(|springs| &springs.model) {
            Some(Model::Rope { .. }) => Self::Rope,
            Some(Model::Net { .. }) => Self::Net,
            Some(Model::Body { .. }) => Self::Body,
            Some(Model::Ring { .. } | Model::Ball { .. }) => Self::Round,
            None if scene.charging.is_some() => Self::Charge,
            None if scene.contact.is_some() => Self::Contact,
            None => Self::Fibers,
        }
    }

    /// Its name, by which pages know it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Rope => "rope",
            Self::Net => "net",
            Self::Body => "body",
            Self::Round => "round",
            Self::Fibers => "fibers",
            Self::Contact => "contact",
            Self::Charge => "charge",
        }
    }
}

/// The scene of the gallery after the one named `now` that is of the same kind as it.
pub(crate) fn next<'a>(gallery: &'a [GalleryScene], now: &str) -> Option<&'a GalleryScene> {
    let place = gallery.iter().position(|scene| scene.name == now)?;
    let kind = Kind::of(&gallery[place].scene()?);
    let (before, after) = gallery.split_at(place);
    let others = after[1..].iter().chain(before);
    others.into_iter().find(|other| other.scene().is_some_and(|scene| Kind::of(&scene) == kind))
}
