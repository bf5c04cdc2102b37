//! What pages ask for.

use crate::extras::Shows;
use crate::wish::PictureWish;
use serde::Deserialize;

/// Farthest place of a hand from the origin, m.
const FARTHEST_HAND: f64 = 1e6;

/// What a page asks for, as JSON.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Order {
    /// Of so many frames that came it has drawn the last.
    Drawn { frames: u32 },
    /// It takes the controls.
    Control,
    /// Everything moves.
    Run,
    /// Everything stands still.
    Pause,
    /// One step, or one frame of a run.
    Step,
    /// Back to the start.
    Restart,
    /// Simulated seconds for each second.
    Speed { value: f64 },
    /// Colors by a quantity; those of the materials without one.
    Color { by: Option<String> },
    /// Colors spread between the values of now.
    FitColors,
    /// What is shown besides.
    Show(Shows),
    /// A picture by paths of light.
    Picture(PictureWish),
    /// No more of the picture.
    EndPicture,
    /// The second of two runs lies over the first, or beside it.
    Over { over: bool },
    /// A scene of the gallery.
    Open { name: String },
    /// Back to the gallery.
    Gallery,
    /// The next scene of the gallery of the same kind.
    Mode,
    /// A frame of a run.
    Seek { frame: usize },
    /// Another value of a slider.
    Set { knob: String, value: f64 },
    /// A hand takes hold of a point of a strand.
    Take { strand: usize, point: usize, to: [f64; 3] },
    /// A hand takes hold of an object at a place.
    TakeObject { object: usize, at: [f64; 3] },
    /// The hand moves.
    Move { to: [f64; 3] },
    /// The hand lets go.
    Drop,
    /// A point of a strand is fixed where it is, or released.
    Fix { strand: usize, point: usize, fixed: bool },
    /// What was changed is saved as a scene.
    Save,
}

impl Order {
    /// The order that a text says; none if it says none.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let order = serde_json::from_str(text).ok()?;
        let places = match &order {
            Self::Take { to, .. } | Self::Move { to } => &to[..],
            Self::TakeObject { at, .. } => &at[..],
            Self::Picture(PictureWish { eye, target, .. }) => {
                return eye.iter().chain(target).all(|x| x.abs() <= FARTHEST_HAND).then_some(order);
            }
            Self::Speed { value } | Self::Set { value, .. } => std::slice::from_ref(value),
            _ => &[],
        };
        places.iter().all(|x| x.abs() <= FARTHEST_HAND).then_some(order)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_read() {
        let read = |text| Order::read(text).expect("an order");
        assert_eq!(read(r#"{"do":"run"}"#), Order::Run);
        assert_eq!(read(r#"{"do":"color","by":null}"#), Order::Color { by: None });
        let show = read(r#"{"do":"show","contacts":true,"volumes":1,"field":false}"#);
        let shows = Shows { contacts: true, volumes: Some(1), field: false };
        assert_eq!(show, Order::Show(shows));
        let take = read(r#"{"do":"take","strand":1,"point":2,"to":[0,0.5,-1]}"#);
        assert_eq!(take, Order::Take { strand: 1, point: 2, to: [0.0, 0.5, -1.0] });
    }

    #[test]
    fn what_is_no_order_is_not_read() {
        for text in [
            "",
            "run",
            "{}",
            r#"{"do":"fly"}"#,
            r#"{"do":"seek","frame":-1}"#,
            r#"{"do":"speed","value":1e300}"#,
            r#"{"do":"move","to":[0,0]}"#,
            r#"{"do":"move","to":[0,0,1e9]}"#,
            r#"{"do":"show","contacts":true,"volumes":-1,"field":false}"#,
            r#"{"do":"picture","number":1,"eye":[0,0,1e9],"target":[0,0,0],"field":1,"thickness":1,"plain":false,"size":[9,9],"samples":1}"#,
            r#"{"do":"set","knob":"frequency","value":3,"more":1}"#,
        ] {
            assert_eq!(Order::read(text), None, "{text}");
        }
        let deep = format!("{}{}", "[".repeat(10_000), "]".repeat(10_000));
        assert_eq!(Order::read(&deep), None);
    }
}
