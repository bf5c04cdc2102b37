use crate::StaticError;
use crate::rod::{Piece, Properties};
use crate::state::State;
use crate::step::Node;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;

/// Longest element of the solution, in units of what bends or turns the rod by one radian.
const RESOLVED: f64 = 0.2;
/// The same for the way there.
const COARSE: f64 = 0.6;

/// The pieces of a rod, and the units in which its length and a stiffness are one.
#[derive(Debug, Clone)]
pub(crate) struct Scaled {
    pieces: Vec<Piece>,
    /// Unit of length, m: the rod's length.
    pub(crate) length: f64,
    /// Unit of stiffness, N m^2.
    stiffness: f64,
}

/// A stretch of one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Element {
    piece: usize,
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// Force on its far end.
    pub(crate) end_load: Vector3<f64>,
}

impl Scaled {
    pub(crate) fn new(pieces: Vec<Piece>) -> Result<Self, StaticError> {
        let mut length = 0.0;
        for piece in &pieces {
            piece.validate(length)?;
            length += piece.length();
        }
        let Some(first) = pieces.first() else { return Err(StaticError::NoPieces) };
        let k = first.at(0.0).stiffness;
        Ok(Self { stiffness: (k.x * k.y).sqrt(), pieces, length })
    }

    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Unit of force, N.
    pub(crate) fn force(&self) -> f64 {
        self.stiffness / (self.length * self.length)
    }

    /// Unit of moments and of energy, N m.
    pub(crate) fn energy(&self) -> f64 {
        self.stiffness / self.length
    }

    /// The properties of an element at scaled arc lengths, its load times `factor`.
    pub(crate) fn properties(&self, element: &Element, factor: f64) -> impl Fn(f64) -> Properties {
        let (piece, length, stiffness) = (&self.pieces[element.piece], self.length, self.stiffness);
        let load = factor * length / self.force();
        move |s| {
            let p = piece.at(s * length);
            Properties {
                stiffness: p.stiffness / stiffness,
                natural_curvature: p.natural_curvature * length,
                load: p.load * load,
            }
        }
    }

    /// Elements short enough for the natural shape and the loads.
    pub(crate) fn elements(&self) -> Vec<Element> {
        let mut elements = Vec::new();
        let mut carried = 0.0;
        let mut at = 0.0;
        let mut rates = Vec::new();
        for piece in &self.pieces {
            let samples = (0..=8).map(|i| piece.at(at + piece.length() * f64::from(i) / 8.0));
            let (mut curvature, mut load, mut soft) = (0.0_f64, 0.0_f64, f64::INFINITY);
            for p in samples {
                curvature = curvature.max(p.natural_curvature.norm() * self.length);
                load = load.max(p.load.norm() * self.length / self.force());
                soft = soft.min(p.stiffness.min() / self.stiffness);
            }
            at += piece.length();
            carried += load * piece.length() / self.length + piece.end_load().norm() / self.force();
            rates.push((curvature, soft));
        }
        let mut from = 0.0;
        for (index, (piece, (curvature, soft))) in self.pieces.iter().zip(rates).enumerate() {
            let length = piece.length() / self.length;
            let rate = curvature + (carried / soft).sqrt() + 5.0;
            let count = (rate * length / COARSE).ceil().max(2.0);
            let mut i = 0.0;
            while i < count {
                let last = i + 1.0 >= count;
                elements.push(Element {
                    piece: index,
                    from: from + length * i / count,
                    to: from + length * ((i + 1.0) / count),
                    end_load: if last { piece.end_load() / self.force() } else { Vector3::zeros() },
                });
                i += 1.0;
            }
            from += length;
        }
        elements
    }

    /// Splits the elements in which `nodes` vary too fast; `None` if there are none.
    pub(crate) fn refined(
        &self,
        elements: &[Element],
        nodes: &[Node],
        factor: f64,
    ) -> Option<(Vec<Element>, Vec<Node>)> {
        let (mut finer, mut more) = (Vec::new(), Vec::new());
        for (element, node) in elements.iter().zip(nodes) {
            let properties = self.properties(element, factor);
            let h = element.to - element.from;
            let rate = |s: f64, node: &Node| {
                let p = properties(s);
                let strain = node.q.inverse_transform_vector(&node.m).component_div(&p.stiffness);
                p.natural_curvature.norm()
                    + strain.norm()
                    + (node.n.norm() / p.stiffness.min()).sqrt()
            };
            let end = node.step(element.from, element.to, &properties).node;
            let fastest = rate(element.from, node).max(rate(element.to, &end));
            let parts = (fastest * h / RESOLVED).ceil().clamp(1.0, 64.0);
            let mut part = 0.0;
            while part < parts {
                let from = element.from + h * part / parts;
                let last = part + 1.0 >= parts;
                more.push(node.step(element.from, from, &properties).node);
                finer.push(Element {
                    from,
                    to: if last { element.to } else { element.from + h * ((part + 1.0) / parts) },
                    end_load: if last { element.end_load } else { Vector3::zeros() },
                    ..*element
                });
                part += 1.0;
            }
        }
        more.extend(nodes.last());
        (finer.len() > elements.len()).then_some((finer, more))
    }

    /// In these units.
    pub(crate) fn scale(&self, state: &State) -> Node {
        Node {
            r: state.position.coords / self.length,
            q: so3::quaternion(&state.frame),
            m: state.moment / self.energy(),
            n: state.force / self.force(),
        }
    }

    /// In SI units.
    pub(crate) fn unscale(&self, node: &Node) -> State {
        State {
            position: Point3::from(node.r * self.length),
            frame: node.q.to_rotation_matrix(),
            force: node.n * self.force(),
            moment: node.m * self.energy(),
        }
    }

    /// The natural shape from a clamp.
    pub(crate) fn natural(
        &self,
        elements: &[Element],
        clamp: (Vector3<f64>, UnitQuaternion<f64>),
        moment: Vector3<f64>,
    ) -> Vec<Node> {
        let (r, q) = clamp;
        let mut nodes = vec![Node { r, q, m: moment, n: Vector3::zeros() }];
        for (i, element) in elements.iter().enumerate() {
            let properties = self.properties(element, 0.0);
            nodes.push(nodes[i].step(element.from, element.to, properties).node);
        }
        nodes
    }
}
