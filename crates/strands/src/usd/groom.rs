//! The curves of a prim as strands in its world.

use super::curves::{ControlPoint, CurveBasis, CurveKind, CurveWrap};
use super::layer::{UsdPrim, UsdValue};
use crate::raw::RawStrands;
use nalgebra::{Matrix4, Point3};

/// What values of width belong to.
#[derive(Clone, Copy, PartialEq)]
enum WidthPlace {
    All,
    Curve,
    /// A control point.
    ControlPoint,
    /// The end of a span.
    SpanEnd,
}

/// Adds all curves of a prim that `place` takes to its world, cubic ones with `fine` points for
/// each span.
///
/// # Errors
/// What is wrong with the prim.
pub(super) fn add(
    prim: &UsdPrim,
    place: &Matrix4<f64>,
    fine: usize,
    raw: &mut RawStrands,
) -> Result<(), String> {
    let kind = kind(prim)?;
    let points = numbers(prim, "points")?;
    let (points, rest) = points.as_chunks::<3>();
    let counts = numbers(prim, "curveVertexCounts")?;
    let sum = counts.iter().fold(0.0, |sum, count| sum + count);
    let is_count = |n: &f64| *n >= 0.0 && n.fract() == 0.0;
    if !rest.is_empty() || !counts.iter().all(is_count) || sum != points.len() as f64 {
        let count = points.len();
        return Err(format!("curveVertexCounts add up to {sum}, but there are {count} points"));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small counts")]
    let counts: Vec<_> = counts.iter().map(|&n| n as usize).collect();
    let ends = |&n: &usize| {
        let is_closed = kind.wrap == CurveWrap::Periodic;
        kind.spans(n).map_or(0, |spans| spans + usize::from(!is_closed))
    };
    let widths = widths(prim, &counts, points.len(), counts.iter().map(ends).sum())?;

    // A width grows as the volume of what the matrix does.
    let growth = place.fixed_view::<3, 3>(0, 0).determinant().abs().cbrt();
    let (mut start, mut end) = (0, 0);
    let (mut controls, mut curve): (Vec<ControlPoint>, Vec<ControlPoint>) =
        (Vec::new(), Vec::new());
    for (index, count) in counts.iter().enumerate() {
        let own = |at: usize| match &widths {
            None => 0.0,
            Some((WidthPlace::All, all)) => all[0],
            Some((WidthPlace::Curve, all)) => all[index],
            Some((WidthPlace::ControlPoint, all)) => all[at],
            Some((WidthPlace::SpanEnd, _)) => 0.0,
        };
        controls.clear();
        controls.extend((start..start + count).map(|at| {
            let [x, y, z] = points[at];
            [x, y, z, own(at)]
        }));
        start += count;
        curve.clear();
        match kind.evaluate(&controls, fine, &mut curve) {
            Ok(()) => raw.counts.push(curve.len()),
            Err(fault) => {
                raw.faults.push((raw.counts.len(), fault));
                raw.counts.push(0);
            }
        }
        if let Some((WidthPlace::SpanEnd, all)) = &widths {
            let own = &all[end..end + ends(count)];
            let each = if kind.basis == CurveBasis::Linear { 1 } else { fine };
            for (k, point) in curve.iter_mut().enumerate() {
                let [a, b] = [k / each, k / each + 1].map(|at| own[at % own.len()]);
                point[3] = a + (k % each) as f64 / each as f64 * (b - a);
            }
        }
        end += ends(count);
        raw.points.extend(curve.iter().map(|&[x, y, z, _]| {
            let point = place * Point3::new(x, y, z).to_homogeneous();
            Point3::from(point.xyz())
        }));
        if widths.is_some() {
            raw.widths.extend(curve.iter().map(|point| growth * point[3]));
        }
    }
    Ok(())
}

/// The basis and the ends; where nothing is said, as the schema has it.
fn kind(prim: &UsdPrim) -> Result<CurveKind, String> {
    let word = |name: &str, usual: &str| {
        let value = prim.attributes.get(name).and_then(|attribute| attribute.value());
        match value.as_deref() {
            Some(UsdValue::Words(words)) => words.concat(),
            _ => usual.to_owned(),
        }
    };
    let (form, basis, wrap) =
        (word("type", "cubic"), word("basis", "bezier"), word("wrap", "nonperiodic"));
    let basis = match (&*form, &*basis) {
        ("linear", _) => CurveBasis::Linear,
        ("cubic", "bezier") => CurveBasis::Bezier,
        ("cubic", "bspline") => CurveBasis::Bspline,
        ("cubic", "catmullRom") => CurveBasis::CatmullRom,
        _ => return Err(format!("curves of type {form} and basis {basis} are not known")),
    };
    let wrap = match &*wrap {
        "nonperiodic" => CurveWrap::Nonperiodic,
        "pinned" => CurveWrap::Pinned,
        "periodic" => CurveWrap::Periodic,
        _ => return Err(format!("the wrap {wrap} of curves is not known")),
    };
    Ok(CurveKind { basis, wrap })
}

/// An attribute of numbers; without a value there are none.
fn numbers(prim: &UsdPrim, name: &str) -> Result<Vec<f64>, String> {
    let Some(value) = prim.attributes.get(name).and_then(|attribute| attribute.value()) else {
        return Ok(Vec::new());
    };
    match value.into_owned() {
        UsdValue::Numbers(numbers) => Ok(numbers),
        UsdValue::Other => Ok(Vec::new()),
        UsdValue::Words(_) => Err(format!("{name} should be numbers")),
    }
}

/// The widths, if there are any, and what they belong to: as it is said, or as their number tells.
fn widths(
    prim: &UsdPrim,
    counts: &[usize],
    points: usize,
    ends: usize,
) -> Result<Option<(WidthPlace, Vec<f64>)>, String> {
    // A primvar goes before the attribute of the schema.
    let has_primvar = prim.attributes.contains_key("primvars:widths");
    let name = if has_primvar { "primvars:widths" } else { "widths" };
    let values = numbers(prim, name)?;
    if values.is_empty() {
        return Ok(None);
    }
    let said = prim.attributes.get(name).and_then(|own| own.interpolation.as_deref());
    let places = [
        ("vertex", WidthPlace::ControlPoint, points),
        ("constant", WidthPlace::All, 1),
        ("uniform", WidthPlace::Curve, counts.len()),
        ("varying", WidthPlace::SpanEnd, ends),
    ];
    let fits = |(_, _, count): &&(&str, WidthPlace, usize)| *count == values.len();
    let as_said = places.iter().filter(|place| said == Some(place.0)).find(fits);
    let Some((_, place, _)) = as_said.or_else(|| places.iter().find(fits)) else {
        let curves = counts.len();
        return Err(format!(
            "{} widths suit neither {points} points nor {curves} curves",
            values.len()
        ));
    };
    Ok(Some((*place, values)))
}
