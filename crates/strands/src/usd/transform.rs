//! Where a prim is: the transform ops of its own, within its parent.

use super::layer::{UsdPrim, UsdValue};
use nalgebra::{Matrix4, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Placement of a prim within its parent.
pub(super) struct Placement {
    /// Matrix that takes columns (own frame) to columns (parent's frame).
    pub(super) matrix: Matrix4<f64>,
    /// Whether it is within the world instead.
    pub(super) is_reset: bool,
}

/// Multiplies the ops of a prim in their order, the first one outermost.
///
/// # Errors
/// What is wrong with an op.
pub(super) fn placement(prim: &UsdPrim) -> Result<Placement, String> {
    let mut placement = Placement { matrix: Matrix4::identity(), is_reset: false };
    let value = |name: &str| prim.attributes.get(name)?.value();
    let order = value("xformOpOrder");
    let Some(UsdValue::Words(order)) = order.as_deref() else { return Ok(placement) };
    for op in order {
        if op == "!resetXformStack!" {
            placement = Placement { matrix: Matrix4::identity(), is_reset: true };
            continue;
        }
        let (is_inverse, name) = op.strip_prefix("!invert!").map_or((false, &**op), |n| (true, n));
        let kind = name.strip_prefix("xformOp:").and_then(|rest| rest.split(':').next());
        let value = value(name);
        let Some(UsdValue::Numbers(numbers)) = value.as_deref() else {
            return Err(format!("the value of {name} is missing"));
        };
        let matrix = kind.and_then(|kind| matrix(kind, numbers));
        let mut matrix = matrix.ok_or_else(|| format!("{name} with {numbers:?} is not known"))?;
        if is_inverse {
            matrix = matrix.try_inverse().ok_or_else(|| format!("{name} cannot be inverted"))?;
        }
        placement.matrix *= matrix;
    }
    Ok(placement)
}

/// The matrix of one op; angles are in degrees.
fn matrix(kind: &str, numbers: &[f64]) -> Option<Matrix4<f64>> {
    let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
    let turn = |axis: usize, degrees: f64| {
        Rotation3::from_axis_angle(&axes[axis], degrees.to_radians()).to_homogeneous()
    };
    let along = |letter: &str| ["X", "Y", "Z"].iter().position(|axis| *axis == letter);
    let vector = || <[f64; 3]>::try_from(numbers).ok().map(Vector3::from);
    match (kind, numbers) {
        ("translate", _) => vector().map(|v| Matrix4::new_translation(&v)),
        ("scale", _) => vector().map(|v| Matrix4::new_nonuniform_scaling(&v)),
        ("orient", &[w, i, j, k]) => {
            let rotation = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), f64::MIN_POSITIVE)?;
            Some(rotation.to_homogeneous())
        }
        // The file has rows (own frame) times matrix.
        ("transform", numbers) if numbers.len() == 16 => Some(Matrix4::from_column_slice(numbers)),
        (kind, _) => {
            let (name, letters) = kind.split_at_checked(kind.find(['X', 'Y', 'Z'])?)?;
            match (name, letters.len(), numbers) {
                ("rotate", 1, &[degrees]) => Some(turn(along(letters)?, degrees)),
                ("translate", 1, &[way]) => {
                    Some(Matrix4::new_translation(&(way * axes[along(letters)?].into_inner())))
                }
                ("scale", 1, &[factor]) => {
                    let mut factors = Vector3::repeat(1.0);
                    factors[along(letters)?] = factor;
                    Some(Matrix4::new_nonuniform_scaling(&factors))
                }
                // About the axes in the order of the letters, the first one first.
                ("rotate", 3, _) => {
                    let angles = vector()?;
                    let mut product = Matrix4::identity();
                    for letter in letters.split("").filter(|letter| !letter.is_empty()) {
                        let axis = along(letter)?;
                        product = turn(axis, angles[axis]) * product;
                    }
                    Some(product)
                }
                _ => None,
            }
        }
    }
}
