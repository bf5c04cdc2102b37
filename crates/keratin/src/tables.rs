//! The tables and facts of the thesis's chapter 2 as printed, in their printed units.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Source of a number in the thesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source {
    /// Number of the table, as "2.9", or key of the fact.
    pub place: &'static str,
    /// Line of the thesis's plain text.
    pub line: u32,
    /// Study that the thesis cites, empty where it cites none.
    pub study: &'static str,
}

/// A table of the thesis.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table<R: 'static> {
    /// Number of the table, as "2.9".
    pub id: &'static str,
    /// Contents of the table.
    pub title: &'static str,
    /// Studies that the table is from.
    pub source: &'static str,
    /// Conditions of the measurement, as far as they are given.
    #[serde(default)]
    pub conditions: &'static str,
    /// Caveats for the use of the table.
    #[serde(default)]
    pub note: &'static str,
    /// Line of the caption in the thesis's plain text.
    pub caption_line: u32,
    /// Line of the first row in the thesis's plain text.
    pub first_row_line: u32,
    /// Unit of each column that has one.
    pub units: BTreeMap<&'static str, &'static str>,
    /// Rows of the table, in the printed order.
    pub rows: Vec<R>,
}

impl<R> Table<R> {
    /// Source of the row with this index.
    #[must_use]
    pub fn row_source(&self, index: usize) -> Source {
        let line = self.first_row_line + u32::try_from(index).unwrap_or(u32::MAX);
        Source { place: self.id, line, study: self.source }
    }
}

/// Declares the rows of a table: all fields public, read strictly.
macro_rules! rows {
    ($($(#[$of_row:meta])* $name:ident { $($(#[$of_field:meta])* $field:ident: $kind:ty,)* })*) => {$(
        $(#[$of_row])*
        #[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
        #[serde(deny_unknown_fields)]
        #[expect(missing_docs, reason = "fields are the columns as printed; units: in the table")]
        pub struct $name { $($(#[$of_field])* pub $field: $kind,)* }
    )*};
}

rows! {
    /// Table 2.1: hair by age. `r_max` holds diameters.
    Growth { kind: &'static str, age_a: &'static str, l_max: f64, r_max: f64, }
    /// Table 2.2: diameters by type.
    Diameters { group: &'static str, d_max: f64, d_min: f64, ratio: f64, area: f64, }
    /// Table 2.3: waviness by type and treatment.
    Waviness {
        hair: &'static str, treatment: &'static str, dry: f64,
        #[serde(default)] wet: Option<f64>,
    }
    /// Table 2.4: hairs per area of scalp, by age and sex.
    Follicles { age_a: &'static str, female: f64, male: f64, }
    /// Table 2.5: speed of sound and modulus by humidity.
    Sound { rh: f64, v_s: f64, e: f64, }
    /// Table 2.6: moduli of thin and thick hairs of one person.
    Nikiforidis { sample: u32, e_thin: f64, e_thick: f64, }
    /// Table 2.7: ratios of second moments of area by type.
    SecondMoments { group: &'static str, i2_i1: f64, i1_i1w: f64, }
    /// Table 2.8: moduli in bending and in tension.
    ScottRobbins {
        sample: &'static str, linear_density: f64, e_b: f64, e_s: f64, ratio: f64,
    }
    /// Table 2.9: moduli at 60 to 65 % humidity, and by how much they fall toward 100 %.
    Modulus { symbol: &'static str, modulus: f64, ratio_65_100: f64, }
    /// Table 2.10: torsion after treatments.
    Torsion { treatment: &'static str, g: f64, rigidity_ratio: f64, log_decrement: f64, }
    /// Table 2.11: coefficients of friction.
    FrictionRow {
        pair: &'static str,
        #[serde(default)] treatment: &'static str,
        direction: u8,
        #[serde(default)] mu_s_dry: Option<f64>,
        #[serde(default)] mu_s_wet: Option<f64>,
        #[serde(default)] mu_k_dry: Option<f64>,
        #[serde(default)] mu_k_wet: Option<f64>,
        line: u32,
    }
    /// Table 2.12: strength of bonds of hair spray, least and most.
    SprayRow { class: &'static str, force: (f64, f64), }
}

/// Value of a fact.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub enum Value {
    /// A number.
    Number(f64),
    /// Least and largest value.
    Range(f64, f64),
    /// Several numbers.
    List(Vec<f64>),
    /// A formula or a statement.
    Text(&'static str),
    /// A yes-or-no statement.
    Flag(bool),
}

/// A number from the prose of the thesis.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fact {
    /// Name of the fact.
    pub key: &'static str,
    /// Value of the fact in `unit`.
    pub value: Value,
    /// Unit of the value.
    pub unit: &'static str,
    /// Material of the fact, where it is not hair.
    #[serde(default)]
    pub material: &'static str,
    /// The conditions of the measurement.
    #[serde(default)]
    pub conditions: &'static str,
    /// Study that the fact is from.
    #[serde(default)]
    pub source: &'static str,
    /// Caveats for the use of the fact.
    #[serde(default)]
    pub note: &'static str,
    /// Line of the fact in the thesis's plain text.
    pub line: u32,
}

impl Fact {
    /// Source of the fact.
    #[must_use]
    pub fn origin(&self) -> Source {
        Source { place: self.key, line: self.line, study: self.source }
    }
}

/// All tables and facts of chapter 2.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tables {
    /// Reference of the thesis.
    pub thesis: &'static str,
    /// Table 2.1: hair by age.
    pub growth: Table<Growth>,
    /// Table 2.2: diameters by type.
    pub diameters: Table<Diameters>,
    /// Table 2.3: waviness by type and treatment.
    pub waviness: Table<Waviness>,
    /// Table 2.4: hairs per area of scalp, by age and sex.
    pub follicles: Table<Follicles>,
    /// Table 2.5: speed of sound and modulus by humidity.
    pub sound: Table<Sound>,
    /// Table 2.6: moduli of thin and thick hairs of one person.
    pub nikiforidis: Table<Nikiforidis>,
    /// Table 2.7: ratios of second moments of area by type.
    pub second_moments: Table<SecondMoments>,
    /// Table 2.8: moduli in bending and in tension.
    pub scott_robbins: Table<ScottRobbins>,
    /// Table 2.9: moduli at 60 to 65 % humidity, and their ratios to those at 100 %.
    pub moduli: Table<Modulus>,
    /// Table 2.10: torsion after treatments.
    pub torsion: Table<Torsion>,
    /// Table 2.11: coefficients of friction.
    pub friction: Table<FrictionRow>,
    /// Table 2.12: strength of bonds of hair spray.
    pub sprays: Table<SprayRow>,
    /// Numbers in the prose, in the order of the text.
    pub facts: Vec<Fact>,
}

/// The tables, parsed on first use.
///
/// # Panics
/// Never: the file is part of the crate and its tests read all of it.
#[must_use]
pub fn tables() -> &'static Tables {
    static TABLES: LazyLock<Tables> = LazyLock::new(|| {
        ron::from_str(include_str!("../data/tables.ron")).expect("the tables parse: tested")
    });
    &TABLES
}

/// The fact with this name, if there is one. Cost: a search among 85 names.
#[must_use]
pub fn fact(key: &str) -> Option<&'static Fact> {
    static BY_KEY: LazyLock<BTreeMap<&str, &Fact>> =
        LazyLock::new(|| tables().facts.iter().map(|f| (f.key, f)).collect());
    BY_KEY.get(key).copied()
}

/// Value of a fact that is a number, and its source.
///
/// # Panics
/// If there is no fact with this name, which the tests of its callers exclude.
pub(crate) fn number(key: &'static str) -> (f64, Source) {
    match fact(key) {
        Some(Fact { value: Value::Number(value), line, source, .. }) => {
            (*value, Source { place: key, line: *line, study: source })
        }
        _ => unreachable!("{key} is a number of the tables"),
    }
}

/// Least and largest value of a fact that is a range, and their source.
///
/// # Panics
/// If there is no such fact, as for [`number`].
pub(crate) fn range(key: &'static str) -> ([f64; 2], Source) {
    match fact(key) {
        Some(Fact { value: Value::Range(low, high), line, source, .. }) => {
            ([*low, *high], Source { place: key, line: *line, study: source })
        }
        _ => unreachable!("{key} is a range of the tables"),
    }
}
