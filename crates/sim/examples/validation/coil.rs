//! A rod that coils steadily on a floor, as a boundary value problem.
//!
//! In the frame that turns with the coiling the shape stands still and the rod flows along it.
//! Lengths are in `(B / rho A g)^(1/3)`, forces in the weight of such a length. From the mouth on,
//! at the height `H`, `r' = t`, `t' = M x t`, `n' = z + F (t' + 2 W z x t - W^2 r_h)`,
//! `M' = n x t`, with `W = -1 / R`, since what is laid down stays where it is while the place where
//! the rod touches down runs back along it, and `F = U^2 / g` in these lengths. Where the rod
//! touches down it goes along the circle of the radius `R` with its curvature. Material that leaves
//! a mouth that does not turn and lies down without rolling is twisted by one turn in each coil,
//! `M t = (C / B) / R` (see Mahadevan and Keller 1996, and Habibi, Ribe and Bonn 2007).

use nalgebra::{DMatrix, DVector, Vector3};
use rapunzel_repro::Fallible;

/// Pieces of the rod that are shot over, and steps in each.
const PIECES: usize = 32;
const STEPS: usize = 24;
/// Most iterations of Newton's method.
const MOST: usize = 60;

type State = [Vector3<f64>; 4];

/// A steady coil.
#[derive(Clone)]
pub(crate) struct Coil {
    /// Height of the mouth.
    pub(crate) height: f64,
    /// Length of the rod from the mouth to where it touches down.
    pub(crate) length: f64,
    pub(crate) radius: f64,
    /// Place, tangent, force and moment at the start of each piece.
    pieces: Vec<State>,
}

/// What a coil is of.
#[derive(Clone, Copy)]
pub(crate) struct Rod {
    /// Stiffness of torsion over that of bending.
    pub(crate) torsion: f64,
    /// `U^2 / g`.
    pub(crate) inertia: f64,
}

fn slope([r, t, n, m]: &State, radius: f64, rod: Rod) -> State {
    let turned = m.cross(t);
    let rate = -1.0 / radius;
    let coriolis = Vector3::new(-t.y, t.x, 0.0) * (2.0 * rate);
    let inertia = turned + coriolis - Vector3::new(r.x, r.y, 0.0) * rate.powi(2);
    [*t, turned, Vector3::z() + rod.inertia * inertia, n.cross(t)]
}

fn ahead(state: &State, slope: &State, way: f64) -> State {
    std::array::from_fn(|i| state[i] + slope[i] * way)
}

/// The end of a piece of some length, by the classical method of Runge and Kutta.
fn shot(start: &State, length: f64, radius: f64, rod: Rod) -> State {
    let h = length / STEPS as f64;
    let mut state = *start;
    for _ in 0..STEPS {
        let a = slope(&state, radius, rod);
        let b = slope(&ahead(&state, &a, 0.5 * h), radius, rod);
        let c = slope(&ahead(&state, &b, 0.5 * h), radius, rod);
        let d = slope(&ahead(&state, &c, h), radius, rod);
        let sum = std::array::from_fn(|i| a[i] + 2.0 * (b[i] + c[i]) + d[i]);
        state = ahead(&state, &sum, h / 6.0);
    }
    state
}

fn numbers(state: &State) -> impl Iterator<Item = f64> {
    state.iter().flatten().copied()
}

impl Coil {
    fn unknowns(&self) -> DVector<f64> {
        let pieces = self.pieces.iter().flat_map(numbers);
        DVector::from_iterator(12 * PIECES + 2, pieces.chain([self.length, self.radius]))
    }

    fn with(&self, x: &DVector<f64>) -> Self {
        let piece = |k: usize| -> State {
            std::array::from_fn(|i| Vector3::from_fn(|j, _| x[12 * k + 3 * i + j]))
        };
        let pieces = (0..PIECES).map(piece).collect();
        Self { height: self.height, length: x[12 * PIECES], radius: x[12 * PIECES + 1], pieces }
    }

    /// What is wrong at the mouth, between the pieces from `ends` on, and on the floor.
    fn residual(&self, ends: &[State], rod: Rod) -> DVector<f64> {
        let [r, t, _, m] = self.pieces[0];
        let mouth = [
            r - Vector3::new(0.0, 0.0, self.height),
            t + Vector3::z(),
            Vector3::new(m.z + rod.torsion / self.radius, 0.0, 0.0),
        ];
        let mut all: Vec<f64> = mouth.iter().flatten().copied().take(7).collect();
        for (end, next) in ends.iter().zip(&self.pieces[1..]) {
            all.extend(numbers(end).zip(numbers(next)).map(|(a, b)| a - b));
        }
        let [r, t, _, m] = ends[PIECES - 1];
        let bend = m - t * m.dot(&t);
        let radius = self.radius;
        all.extend([r.x - radius, r.y, r.z, t.x, t.z, bend.x, bend.z - 1.0 / radius]);
        DVector::from_vec(all)
    }

    fn ends(&self, rod: Rod) -> Vec<State> {
        let length = self.length / PIECES as f64;
        self.pieces.iter().map(|piece| shot(piece, length, self.radius, rod)).collect()
    }

    /// The coil near this one, by Newton's method over all pieces at once.
    fn solved(mut self, rod: Rod) -> Fallible<Self> {
        for _ in 0..MOST {
            let ends = self.ends(rod);
            let wrong = self.residual(&ends, rod);
            if wrong.amax() < 1e-9 {
                return Ok(self);
            }
            let x = self.unknowns();
            let mut slopes = DMatrix::zeros(x.len(), x.len());
            for i in 0..x.len() {
                let step = 1e-6 * (1.0 + x[i].abs());
                let mut moved = x.clone();
                moved[i] += step;
                let moved = self.with(&moved);
                let ends = if i < 12 * PIECES {
                    // Only one piece has changed.
                    let (k, length) = (i / 12, moved.length / PIECES as f64);
                    let mut ends = ends.clone();
                    ends[k] = shot(&moved.pieces[k], length, moved.radius, rod);
                    ends
                } else {
                    moved.ends(rod)
                };
                slopes.set_column(i, &((moved.residual(&ends, rod) - &wrong) / step));
            }
            let step = slopes.lu().solve(&wrong).ok_or("the coil has no slope")?;
            // Not farther than the equations are nearly linear.
            let scale = (0.5 / step.amax()).min(1.0);
            self = self.with(&(x - step * scale));
        }
        Err("a coil was not found".into())
    }

    /// A coil at the height 2, from which those at others are found.
    fn first(rod: Rod) -> Fallible<Self> {
        // Of a rod that resists no torsion and has no inertia.
        let (height, length, radius) = (2.0, 3.046_811_7, 0.935_157_5);
        let own = Rod { torsion: 0.0, inertia: 0.0 };
        let mut state = [
            Vector3::new(0.0, 0.0, height),
            -Vector3::z(),
            Vector3::new(-0.722_810, -1.143_485, -0.802_040),
            Vector3::new(-1.089_225, 0.256_954, 0.0),
        ];
        let mut pieces = Vec::new();
        for _ in 0..PIECES {
            pieces.push(state);
            state = shot(&state, length / PIECES as f64, radius, own);
        }
        let mut coil = Self { height, length, radius, pieces };
        for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let some = Rod { torsion: part * rod.torsion, inertia: part * rod.inertia };
            coil = coil.solved(some)?;
        }
        Ok(coil)
    }

    /// The same rod higher by some way: what is more of it hangs from the mouth.
    fn raised(&self, way: f64, rod: Rod) -> Fallible<Self> {
        let length = self.length + way;
        let piece = |k: usize| -> State {
            let s = length * k as f64 / PIECES as f64 - way;
            if s <= 0.0 {
                let [r, t, n, m] = self.pieces[0];
                return [r - Vector3::z() * s, t, n + Vector3::z() * s, m * (2.0 * s).exp()];
            }
            let own = self.length / PIECES as f64;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a piece")]
            let from = ((s / own) as usize).min(PIECES - 1);
            shot(&self.pieces[from], s - own * from as f64, self.radius, rod)
        };
        let mut pieces: Vec<State> = (0..PIECES).map(piece).collect();
        pieces[0][3].z = -rod.torsion / self.radius;
        let height = self.height + way;
        Self { height, length, radius: self.radius, pieces }.solved(rod)
    }
}

/// Coils of a rod at heights, which ascend from 2.
pub(crate) fn coils(rod: Rod, heights: &[f64]) -> Fallible<Vec<Coil>> {
    let mut coil = Coil::first(rod)?;
    let mut all = Vec::new();
    for height in heights {
        while coil.height < height - 1e-9 {
            let way = (height - coil.height).min(0.15 * coil.height);
            coil = coil.raised(way, rod)?;
        }
        all.push(coil.clone());
    }
    Ok(all)
}
