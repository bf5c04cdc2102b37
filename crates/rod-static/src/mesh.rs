use crate::StaticError;
use crate::rod::{Piece, Properties};
use crate::state::State;
use crate::step::ShootingNode;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;

/// Longest element of a continuation, in units of the length in which the rod bends or turns by one
/// radian.
const COARSE: f64 = 0.6;
/// Longest element of the solution where its variations oscillate, so that stability can be
/// determined.
const RESOLVED: f64 = 1.0;
/// Estimated error of a step that is allowed, in lengths and radians: near a saddle, errors of a
/// path grow.
const FINE: f64 = 1e-14;
/// Largest number of elements.
const MOST_ELEMENTS: f64 = 5e4;
/// Length of the rod over the radius of the sharpest bend that arc lengths can resolve.
const SHARPEST: f64 = 1e8;
/// Growth of the elements with the distance from what holds or loads the rod.
const GROWTH: f64 = 8.0;

/// The pieces of a rod, and the units in which its length and a stiffness are one.
#[derive(Debug, Clone)]
pub(crate) struct Scaled {
    pieces: Vec<Piece>,
    /// Unit of length, m: the rod's length.
    pub(crate) length: f64,
    /// Unit of stiffness, N m^2.
    stiffness: f64,
}

/// An element of the mesh: the arc lengths of one step of the integration, scaled.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeshElement {
    pub(crate) piece: usize,
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// Dead force on the far end of the element, scaled.
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
    pub(crate) fn properties(
        &self,
        element: &MeshElement,
        factor: f64,
    ) -> impl Fn(f64) -> Properties {
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

    /// Elements short enough for the natural shape, and for what the loads and `end`, the sizes of
    /// force and moment on the end, bend it by. A force bends a rod within `sqrt(EI / force)` of
    /// what holds or loads it: there the elements are short, and from there they grow.
    ///
    /// # Errors
    /// [`StaticError::TooFine`].
    pub(crate) fn elements(&self, end: [f64; 2]) -> Result<Vec<MeshElement>, StaticError> {
        let [mut carried, moment] = end;
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
            rates.push((curvature + moment / soft + 5.0, soft));
        }
        let mut from = 0.0;
        let mut elements = Vec::new();
        for (index, (piece, (slow, soft))) in self.pieces.iter().zip(rates).enumerate() {
            let (length, fast) = (piece.length() / self.length, (carried / soft).sqrt());
            // In this form what is no number is refused too.
            let resolved = slow * length < COARSE * MOST_ELEMENTS && fast < SHARPEST;
            if !resolved {
                let radius = self.length / slow.max(fast);
                return Err(StaticError::TooFine { radius, length: self.length });
            }
            let parts = graded(length, slow, fast);
            for ends in parts.windows(2) {
                elements.push(MeshElement {
                    piece: index,
                    from: from + ends[0],
                    to: from + ends[1],
                    end_load: Vector3::zeros(),
                });
            }
            from += length;
            if let Some(last) = elements.last_mut() {
                last.end_load = piece.end_load() / self.force();
            }
        }
        Ok(elements)
    }

    /// Splits the elements on which a step of the integration is too inaccurate; `None` if there
    /// are none, or so many that they are not resolved.
    pub(crate) fn refined(
        &self,
        elements: &[MeshElement],
        nodes: &[ShootingNode],
        factor: f64,
    ) -> Option<(Vec<MeshElement>, Vec<ShootingNode>)> {
        let (mut finer, mut more) = (Vec::new(), Vec::new());
        for (element, node) in elements.iter().zip(nodes) {
            let properties = self.properties(element, factor);
            let h = element.to - element.from;
            let end = node.step(element.from, element.to, &properties);
            let (mut turn, mut push, mut pull) = (0.0_f64, 0.0_f64, 0.0_f64);
            for (s, node) in [(element.from, node), (element.to, &end.node)] {
                let p = properties(s);
                let body = node.q.inverse_transform_vector(&node.m);
                turn = turn.max((p.natural_curvature + body.component_div(&p.stiffness)).norm());
                let soft = p.stiffness.min();
                pull = pull.max((node.n.norm() / soft).sqrt());
                push = push.max((-node.n.dot(&(node.q * Vector3::z())) / soft).max(0.0).sqrt());
            }
            // What the highest polynomial of a solution that varies as exp(z) is to its error.
            let error = end.rough * ((turn + pull) * h / 16.0).min(1.0).powi(6);
            let parts = (error / FINE).powf(1.0 / 9.0).max((turn + push) * h / RESOLVED);
            let parts = parts.ceil().clamp(1.0, 64.0);
            let mut part = 0.0;
            while part < parts {
                let from = element.from + h * part / parts;
                let last = part + 1.0 >= parts;
                more.push(node.step(element.from, from, &properties).node);
                finer.push(MeshElement {
                    from,
                    to: if last { element.to } else { element.from + h * ((part + 1.0) / parts) },
                    end_load: if last { element.end_load } else { Vector3::zeros() },
                    ..*element
                });
                part += 1.0;
            }
        }
        more.extend(nodes.last());
        let split = finer.len() > elements.len() && (finer.len() as f64) < MOST_ELEMENTS;
        split.then_some((finer, more))
    }

    /// Each of the elements in two, with a step of the integration between.
    pub(crate) fn halved(
        &self,
        elements: &[MeshElement],
        nodes: &[ShootingNode],
        factor: f64,
    ) -> (Vec<MeshElement>, Vec<ShootingNode>) {
        let (mut halves, mut more) = (Vec::new(), Vec::new());
        for (element, node) in elements.iter().zip(nodes) {
            let middle = 0.5 * (element.from + element.to);
            let first = MeshElement { to: middle, end_load: Vector3::zeros(), ..*element };
            let properties = self.properties(element, factor);
            more.extend([*node, node.step(element.from, middle, properties).node]);
            halves.extend([first, MeshElement { from: middle, ..*element }]);
        }
        more.extend(nodes.last());
        (halves, more)
    }

    /// The elements of a rod `other` in this one, in the same parts of their pieces; `None` if the
    /// rods are not of the same number of pieces.
    pub(crate) fn elements_like(
        &self,
        elements: &[MeshElement],
        other: &Self,
    ) -> Option<Vec<MeshElement>> {
        if self.pieces.len() != other.pieces.len() {
            return None;
        }
        let [ends, before] = [self, other].map(Self::ends);
        let like = elements.iter().map(|element| {
            let i = element.piece;
            let scale = (ends[i + 1] - ends[i]) / (before[i + 1] - before[i]);
            let at = |s: f64| {
                // The ends of pieces stay what they are, to the last bit.
                if s == before[i + 1] { ends[i + 1] } else { ends[i] + (s - before[i]) * scale }
            };
            let loaded = element.to == before[i + 1];
            let load = self.pieces[i].end_load() / self.force();
            MeshElement {
                piece: i,
                from: at(element.from),
                to: at(element.to),
                end_load: if loaded { load } else { Vector3::zeros() },
            }
        });
        Some(like.collect())
    }

    /// Scaled arc lengths of the ends of the pieces, from zero.
    fn ends(&self) -> Vec<f64> {
        let mut ends = vec![0.0];
        ends.extend(self.pieces.iter().scan(0.0, |s, piece| {
            *s += piece.length() / self.length;
            Some(*s)
        }));
        ends
    }

    /// The node at the scaled arc length `s`, by a step from the node before.
    pub(crate) fn node_at(
        &self,
        elements: &[MeshElement],
        nodes: &[ShootingNode],
        factor: f64,
        s: f64,
    ) -> ShootingNode {
        let index = elements.partition_point(|e| e.to <= s);
        let Some(element) = elements.get(index) else { return nodes[nodes.len() - 1] };
        let properties = self.properties(element, factor);
        nodes[index].step(element.from, s.max(element.from), properties).node
    }

    /// Converts a state from SI units to the units of the rod.
    pub(crate) fn scale(&self, state: &State) -> ShootingNode {
        ShootingNode {
            r: state.position.coords / self.length,
            q: so3::quaternion(&state.frame),
            m: state.moment / self.energy(),
            n: state.force / self.force(),
        }
    }

    /// Converts a node from the units of the rod to SI units.
    pub(crate) fn unscale(&self, node: &ShootingNode) -> State {
        State {
            position: Point3::from(node.r * self.length),
            frame: node.q.to_rotation_matrix(),
            force: node.n * self.force(),
            moment: node.m * self.energy(),
        }
    }

    /// Nodes of the rod without loads, clamped at `clamp` and bent by the dead `moment` (scaled).
    pub(crate) fn natural(
        &self,
        elements: &[MeshElement],
        clamp: (Vector3<f64>, UnitQuaternion<f64>),
        moment: Vector3<f64>,
    ) -> Vec<ShootingNode> {
        let (r, q) = clamp;
        let mut nodes = vec![ShootingNode { r, q, m: moment, n: Vector3::zeros() }];
        for (i, element) in elements.iter().enumerate() {
            let properties = self.properties(element, 0.0);
            nodes.push(nodes[i].step(element.from, element.to, properties).node);
        }
        nodes
    }
}

/// Ends of the elements of a piece, from zero: `fast` are bends near its ends, `slow` anywhere.
fn graded(length: f64, slow: f64, fast: f64) -> Vec<f64> {
    let mut half = vec![0.0];
    let mut at = 0.0;
    while at < 0.5 * length {
        at += COARSE / (slow + fast / (1.0 + fast * at / GROWTH));
        half.push(at);
    }
    let scale = 0.5 * length / at;
    half.iter_mut().for_each(|s| *s *= scale);
    let mirrored: Vec<f64> = half.iter().rev().skip(1).map(|s| length - s).collect();
    half.extend(mirrored);
    half
}
