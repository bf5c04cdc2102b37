use super::group::{ProjectionGroup, TwistForm};
use super::{Differences, Form, active_set, program};
use crate::ContactError;
use nalgebra::{DMatrix, DVector, Vector6};

/// Result of the first projection.
pub(super) struct NormalProjection {
    /// Twists after a plastic impact, `u+`.
    pub(super) twists: Vec<Vector6<f64>>,
    /// Normal impulses on which friction's bounds rest, N s.
    pub(super) impulses: Vec<f64>,
}

/// Lines 5 to 7 of Alg. 6: the twists nearest to `before` that no contact forbids, by the
/// program's dual, `min 1/2 l^T G l + l^T (J u- - v_N)` over `l >= 0` with `G = J M^-1 J^T`.
pub(super) fn project(
    group: &ProjectionGroup<'_>,
    before: &[Vector6<f64>],
    restitution: f64,
    form: &Differences,
) -> Result<NormalProjection, ContactError> {
    let rows: Vec<&TwistForm> = group.links.iter().map(|link| &link.normal).collect();
    let gram = group.gram(form.metric, &rows, &rows);
    let slack = DVector::from_iterator(
        rows.len(),
        group.links.iter().map(|link| link.normal.velocity(before) + link.closing),
    );
    let multipliers = multipliers(&gram, &slack)?;
    let change = group.answer(form.metric, rows.iter().copied().zip(multipliers.iter().copied()));
    let impulses = match form.impulse {
        Form::AsPrinted => {
            let momentum = group.mass(&change);
            rows.iter().map(|row| row.apply(&momentum).abs() * row.norm()).collect()
        }
        Form::Corrected => {
            // In the Euclidean metric a multiplier is a velocity; the impulse that changes the
            // normal velocity as much stands in for it.
            let masses = group.gram(Form::Corrected, &rows, &rows);
            group
                .links
                .iter()
                .enumerate()
                .map(|(i, link)| {
                    let multiplier = multipliers[i] * gram[(i, i)] / masses[(i, i)];
                    (1.0 + restitution) * multiplier * link.normal_scale
                })
                .collect()
        }
    };
    let twists = before.iter().zip(&change).map(|(u, du)| u + du).collect();
    Ok(NormalProjection { twists, impulses })
}

/// `argmin 1/2 l^T G l + l^T c` over `l >= 0`.
pub(super) fn multipliers(
    gram: &DMatrix<f64>,
    slack: &DVector<f64>,
) -> Result<DVector<f64>, ContactError> {
    if let Some(multipliers) = active_set::minimize(gram, slack) {
        return Ok(multipliers);
    }
    let positive = -DMatrix::identity(slack.len(), slack.len());
    program::solve(gram, slack, &positive, &DVector::zeros(slack.len()))
}
