use crate::density::HairDensity;
use crate::guide::{EndLoad, GuideFlow, GuideOptions, GuideRod, Objective, PreGuide};
use crate::{HairgenError, Pore, Region};
use nalgebra::Vector6;
use rayon::prelude::*;

/// Side of the first simplex, in units of the end load.
const SIDE: f64 = 2.0;
/// Spread of the values over their size at which the search ends.
const SPREAD: f64 = 1e-9;
/// Decrease, relative to the value, for which the search is started again.
const GAIN: f64 = 1e-6;
/// Size of a simplex at which the search ends: it is stuck where equilibria end.
const SMALLEST: f64 = 1e-6;

/// A guide's end load as found without derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimplexGuide {
    /// The load on its end.
    pub load: EndLoad,
    /// The objective (5.7) there.
    pub value: f64,
    /// Number of equilibria that the search took.
    pub equilibria: usize,
}

/// Searches the end loads of guides as the thesis does (5.3.3), without derivatives and from the
/// straight hair: by the simplex method of Nelder and Mead (1965), in at most `most` equilibria
/// each. The objective is that of [`place_guides`](crate::place_guides) at the given density.
/// `None` for a guide without equilibria.
///
/// # Errors
/// As [`place_guides`](crate::place_guides).
pub fn simplex_guides(
    pores: &[Pore],
    pre: &[PreGuide],
    region: Region<'_>,
    density: Option<&HairDensity>,
    options: &GuideOptions,
    most: usize,
) -> Result<Vec<Option<SimplexGuide>>, HairgenError> {
    options.validate()?;
    let search = |(number, pore): (usize, &Pore)| {
        let flow = GuideFlow::at(&pore.position, pre)?;
        let objective = Objective::new(flow, region, density, options)?;
        let mut rod = GuideRod::new(&objective.flow.fitted(pore), number, options)?;
        let mut shape = rod.straight();
        let mut lowest = f64::INFINITY;
        let found = descend(most, |load| {
            let Some((value, next)) = objective.at(&mut rod, load, &shape) else {
                return f64::INFINITY;
            };
            // The next equilibria are searched from that of the lowest value.
            if value < lowest {
                (lowest, shape) = (value, next);
            }
            value
        });
        let (point, value, equilibria) = found;
        let guide = SimplexGuide { load: EndLoad::of(&point), value, equilibria };
        Ok(value.is_finite().then_some(guide))
    };
    pores.par_iter().enumerate().map(search).collect()
}

/// The lowest point, its value, and the number of values, from the origin. A simplex may collapse
/// where there is no minimum, so the search is started again from what it finds until that gains
/// nothing (Press et al. 2007, section 10.5).
fn descend(
    most: usize,
    mut function: impl FnMut(&Vector6<f64>) -> f64,
) -> (Vector6<f64>, f64, usize) {
    let (mut lowest, mut count) = ((f64::INFINITY, Vector6::zeros()), 0);
    while count < most {
        let before = lowest.0;
        let (found, taken) = collapse(&lowest.1, most - count, &mut function);
        count += taken;
        if found.0 < lowest.0 {
            lowest = found;
        }
        if found.0 >= before - GAIN * before.abs() || !found.0.is_finite() {
            break;
        }
    }
    (lowest.1, lowest.0, count)
}

/// The lowest corner, with its value, of a simplex that begins at `start`, and the number of
/// values.
fn collapse(
    start: &Vector6<f64>,
    most: usize,
    mut function: impl FnMut(&Vector6<f64>) -> f64,
) -> ((f64, Vector6<f64>), usize) {
    let mut corners = vec![*start];
    for axis in 0..6 {
        let mut corner = *start;
        corner[axis] += SIDE;
        corners.push(corner);
    }
    let mut simplex: Vec<(f64, Vector6<f64>)> =
        corners.into_iter().map(|corner| (function(&corner), corner)).collect();
    let mut count = simplex.len();
    while count < most {
        simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (lowest, (second, highest)) = (simplex[0], (simplex[5].0, simplex[6]));
        let size = simplex.iter().map(|(_, corner)| (corner - lowest.1).amax()).fold(0.0, f64::max);
        if highest.0 - lowest.0 <= SPREAD * lowest.0.abs() || size < SMALLEST {
            break;
        }
        let center = simplex[..6].iter().map(|(_, corner)| corner).sum::<Vector6<f64>>() / 6.0;
        let mut at = |part: f64| {
            let corner = center + (highest.1 - center) * part;
            count += 1;
            (function(&corner), corner)
        };
        let reflected = at(-1.0);
        simplex[6] = if reflected.0 < lowest.0 {
            let expanded = at(-2.0);
            if expanded.0 < reflected.0 { expanded } else { reflected }
        } else if reflected.0 < second {
            reflected
        } else {
            let contracted = at(if reflected.0 < highest.0 { -0.5 } else { 0.5 });
            if contracted.0 < reflected.0.min(highest.0) {
                contracted
            } else {
                // Shrink toward the lowest corner; the highest is the last of them.
                for corner in &mut simplex[1..] {
                    corner.1 = lowest.1 + (corner.1 - lowest.1) * 0.5;
                    corner.0 = function(&corner.1);
                }
                count += 6;
                continue;
            }
        };
    }
    simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
    (simplex[0], count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bowl_is_found() {
        let to = Vector6::new(1.0, -2.0, 3.0, 0.5, -0.5, 4.0);
        let bowl = |x: &Vector6<f64>| 1.0 + (x - to).norm_squared();
        let (point, value, count) = descend(5000, bowl);
        assert!(value < 1.0 + 1e-6 && (point - to).norm() < 1e-3, "{point} {count}");
        assert!(descend(30, bowl).2 < 40);
    }
}
