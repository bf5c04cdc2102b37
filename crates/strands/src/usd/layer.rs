//! What a layer of USD holds of curves and of what moves them.

use crate::UpAxis;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A layer, whether it was text or binary.
#[derive(Debug, Default)]
pub(super) struct UsdLayer {
    /// Length of a unit, m, if it is stated.
    pub(super) meters_per_unit: Option<f64>,
    pub(super) up: Option<UpAxis>,
    /// The prims, each after its parent, in the order of the layer.
    pub(super) prims: Vec<UsdPrim>,
    /// What other layers or parts of this one may hold strands.
    pub(super) unread: Vec<String>,
}

/// A prim with those of its attributes that [`is_kept`].
#[derive(Debug)]
pub(super) struct UsdPrim {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    /// Name of its schema, such as `BasisCurves`.
    pub(super) kind: String,
    /// Whether it is defined and active, as all its ancestors are.
    pub(super) is_shown: bool,
    pub(super) attributes: BTreeMap<String, UsdAttribute>,
}

/// The value of an attribute, with what is known of its samples.
#[derive(Debug)]
pub(super) struct UsdAttribute {
    pub(super) default: Option<UsdValue>,
    pub(super) samples: UsdSamples,
    pub(super) interpolation: Option<String>,
}

/// A value without the structure of vectors and matrices.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum UsdValue {
    /// Numbers one after the other; the real part of quaternions comes first.
    Numbers(Vec<f64>),
    /// Tokens, strings or assets.
    Words(Vec<String>),
    /// None, or a value of another type.
    Other,
}

/// The samples on both sides of a time, of all that were seen; without a time the first.
#[derive(Debug)]
pub(super) struct UsdSamples {
    time: Option<f64>,
    before: Option<(f64, UsdValue)>,
    after: Option<(f64, UsdValue)>,
}

impl UsdLayer {
    /// Adds a prim and returns its index.
    pub(super) fn add(
        &mut self,
        parent: Option<usize>,
        name: String,
        kind: String,
        is_shown: bool,
    ) -> usize {
        let is_shown = is_shown && parent.is_none_or(|parent| self.prims[parent].is_shown);
        self.prims.push(UsdPrim { name, parent, kind, is_shown, attributes: BTreeMap::new() });
        self.prims.len() - 1
    }

    /// Path of a prim, for messages; of those far down the last part alone.
    pub(super) fn path(&self, prim: usize) -> String {
        let parents = std::iter::successors(Some(prim), |&prim| self.prims[prim].parent);
        let mut names: Vec<_> = parents.take(20).map(|prim| &*self.prims[prim].name).collect();
        names.reverse();
        format!("prim /{}", names.join("/"))
    }

    /// Takes the metadata of the layer that say how large a unit is and which way is up.
    pub(super) fn take_metadata(&mut self, key: &str, value: &UsdValue) {
        match (key, value) {
            ("metersPerUnit", UsdValue::Numbers(numbers)) => {
                let unit = numbers.first().copied();
                self.meters_per_unit = unit.filter(|&unit| unit > 0.0 && unit.is_finite());
            }
            ("upAxis", UsdValue::Words(words)) => {
                self.up = match words.first().map(String::as_str) {
                    Some("Y") => Some(UpAxis::Y),
                    Some("Z") => Some(UpAxis::Z),
                    _ => None,
                };
            }
            ("subLayers", UsdValue::Words(words)) => {
                // Besides their names there may be changes of their times.
                let names = words.iter().filter(|word| word.contains('.'));
                self.unread.extend(names.map(|name| format!("the sublayer {name}")));
            }
            _ => {}
        }
    }

    /// Notes what a prim has from elsewhere.
    pub(super) fn note_arc(&mut self, key: &str, prim: usize) {
        const ARCS: [&str; 8] = [
            "references",
            "payload",
            "inherits",
            "inheritPaths",
            "specializes",
            "clips",
            "variantSet",
            "variantSetNames",
        ];
        if ARCS.contains(&key) {
            let note = format!("{key} of {}", self.path(prim));
            self.unread.push(note);
        }
    }
}

/// Whether an attribute says where curves are.
pub(super) fn is_kept(kind: &str, name: &str) -> bool {
    let of_curves = ["points", "curveVertexCounts", "widths", "primvars:widths"];
    let words = ["type", "basis", "wrap"];
    name.starts_with("xformOp")
        || kind == "BasisCurves" && (of_curves.contains(&name) || words.contains(&name))
}

impl UsdAttribute {
    /// An attribute without a value, of which the samples around `time` will be kept.
    pub(super) fn new(time: Option<f64>) -> Self {
        let samples = UsdSamples { time, before: None, after: None };
        Self { default: None, samples, interpolation: None }
    }

    /// Its value at the time; samples go before what does not change.
    pub(super) fn value(&self) -> Option<Cow<'_, UsdValue>> {
        self.samples.value().or(self.default.as_ref().map(Cow::Borrowed))
    }
}

impl UsdSamples {
    /// Whether a sample at this time is nearer than those that were seen.
    pub(super) fn wants(&self, at: f64) -> bool {
        let before = self.before.as_ref().map(|(at, _)| *at);
        let after = self.after.as_ref().map(|(at, _)| *at);
        match self.time {
            None => before.is_none_or(|before| at < before),
            Some(time) if at <= time => before.is_none_or(|before| at > before),
            Some(_) => after.is_none_or(|after| at < after),
        }
    }

    /// Keeps a sample that is wanted.
    pub(super) fn put(&mut self, at: f64, value: UsdValue) {
        let is_before = self.time.is_none_or(|time| at <= time);
        *(if is_before { &mut self.before } else { &mut self.after }) = Some((at, value));
    }

    fn value(&self) -> Option<Cow<'_, UsdValue>> {
        use UsdValue::Numbers;
        if let (Some(time), Some((start, Numbers(a))), Some((end, Numbers(b)))) =
            (self.time, &self.before, &self.after)
            && a.len() == b.len()
        {
            let t = (time - start) / (end - start);
            let numbers = a.iter().zip(b).map(|(a, b)| a + t * (b - a)).collect();
            return Some(Cow::Owned(Numbers(numbers)));
        }
        let nearest = self.before.as_ref().or(self.after.as_ref());
        nearest.map(|(_, value)| Cow::Borrowed(value))
    }
}
