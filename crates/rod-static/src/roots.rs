use crate::carlson::rf;
use crate::elliptic::Modulus;

/// Distance from a singular limit at which the limit is evaluated: its effect is below rounding.
///
/// The planar, the polar and the separatrix limits are singular in the formulas only; at this
/// distance (and its square, `1e-200`) all of them are ordinary numbers.
const NEARBY: f64 = 1e-100;

/// First integrals of the axisymmetric rod divided by its bending stiffness: what the roots follow
/// from. `z` is the cosine of the angle between the tangent and the force.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Integrals {
    /// Magnitude of the force over the bending stiffness, 1/m^2.
    pub(crate) n: f64,
    /// `1 - z` at the start.
    pub(crate) below: f64,
    /// `1 + z` at the start.
    pub(crate) above: f64,
    /// `z'` at the start, 1/m.
    pub(crate) slope: f64,
    /// Square of the bending curvature at the start, 1/m^2.
    pub(crate) bending: f64,
    /// Moment along the tangent over the bending stiffness, 1/m.
    pub(crate) m3: f64,
    /// Moment along the force over the bending stiffness, 1/m.
    pub(crate) mz: f64,
    /// `mz - m3 z` at the start, 1/m.
    pub(crate) crossing: f64,
    /// `mz - m3`, 1/m.
    pub(crate) difference: f64,
    /// `mz + m3`, 1/m.
    pub(crate) sum: f64,
}

/// The roots `z1 <= z2 <= 1 <= z3` of the cubic (thesis (3.89), (3.91)) as distances from the poles
/// and from each other, each to its own last digit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CubicRoots {
    /// `1 - z1`.
    pub(crate) below1: f64,
    /// `1 + z1`.
    pub(crate) above1: f64,
    /// `1 - z2`.
    pub(crate) below2: f64,
    /// `1 + z2`.
    pub(crate) above2: f64,
    /// `2 n (z3 - 1)`, 1/m^2: finite also without a force.
    pub(crate) beyond3: f64,
    /// `z2 - z1`.
    pub(crate) span: f64,
    /// Half the frequency of z: `lambda = sqrt(n (z3 - z1) / 2)`, 1/m.
    pub(crate) lambda: f64,
    /// `k^2 = (z2 - z1) / (z3 - z1)`.
    pub(crate) modulus: Modulus,
    /// `lambda s0`, where sn vanishes at `s = -s0` (thesis (3.99); its sign corrected).
    pub(crate) start: f64,
    /// `mz - m3`, 1/m, kept away from zero.
    pub(crate) difference: f64,
    /// `mz + m3`, 1/m, kept away from zero.
    pub(crate) sum: f64,
}

impl CubicRoots {
    /// The lowest cosine `z1` of the angle between tangent and force.
    pub(crate) fn z1(&self) -> f64 {
        if self.below1 < 1.0 { 1.0 - self.below1 } else { self.above1 - 1.0 }
    }

    /// The roots, for a rod that is not straight along its force.
    pub(crate) fn of(i: &Integrals) -> Option<Self> {
        let scale = i.bending.sqrt() + i.m3.abs() + i.n.sqrt();
        let nearby = |x: f64| if x.abs() < NEARBY * scale { NEARBY * scale } else { x };
        let (difference, sum) = (nearby(i.difference), nearby(i.sum));
        let cubic = Cubic::of(i);
        let y3 = cubic.largest().max(2.0 * i.n * i.below);
        let (mut up, mut down) = cubic.others(y3);
        let separatrix = y3 - 2.0 * i.n * up < 0.25 * (y3 + 2.0 * i.n * down);
        if separatrix {
            // There z2 and z3 nearly meet, and z1 is the root that is known to its last digit.
            down = cubic.polished(down);
        }
        let below1 = i.below + down;
        // The other two roots in w = 1 - z from their product -d2 / 2n and their sum s / 2n.
        let d2 = difference * difference / below1;
        let w1 = 2.0 * i.bending - 4.0 * i.n * i.below - 2.0 * i.difference * i.m3;
        let s = (d2 - w1) / below1;
        let root = (s * s + 8.0 * i.n * d2).sqrt();
        let (below2, beyond3) = if s < 0.0 {
            let beyond3 = 0.5 * (root - s);
            (d2 / beyond3, beyond3)
        } else {
            ((s + root) / (4.0 * i.n), 4.0 * i.n * d2 / (s + root))
        };
        if separatrix {
            let product = cubic.c0 / (down * (beyond3 + 2.0 * i.n * i.below));
            let near1 = 2.0 * down < below1 - below2;
            up = if near1 { i.below - below2 } else { product }.max(0.0);
        }
        let above2 = i.above + up;
        let above1 = sum * sum / (above2 * (beyond3 + 4.0 * i.n));
        let span = up + down;
        let fourfold = beyond3 + 2.0 * i.n * below1;
        let complement = (beyond3 + 2.0 * i.n * below2) / fourfold;
        let modulus = Modulus::from_complement(complement.clamp(NEARBY * NEARBY, 1.0))?;
        let start = if span > 0.0 {
            let (c2, s2) = (up / span, down / span);
            s2.sqrt().copysign(i.slope) * rf(c2, c2 + modulus.complement() * s2, 1.0)
        } else {
            0.0
        };
        let lambda = 0.5 * fourfold.sqrt();
        let roots = Self {
            below1,
            above1,
            below2,
            above2,
            beyond3,
            span,
            lambda,
            modulus,
            start,
            difference,
            sum,
        };
        let known = [below1, above1, below2, above2, lambda, start].iter().all(|x| x.is_finite());
        (known && lambda > 0.0 && above2 > 0.0).then_some(roots)
    }
}

/// `(z')^2` as a cubic in `x = z - z(0)`: `2 n x^3 + c2 x^2 + c1 x + c0`.
struct Cubic {
    n: f64,
    c0: f64,
    c1: f64,
    c2: f64,
}

impl Cubic {
    fn of(i: &Integrals) -> Self {
        let z = if i.below < 1.0 { 1.0 - i.below } else { i.above - 1.0 };
        Self {
            n: i.n,
            c0: i.slope * i.slope,
            c1: 2.0 * (i.m3 * i.crossing - z * i.bending - i.n * i.below * i.above),
            c2: 4.0 * i.n * z - i.bending - i.m3 * i.m3,
        }
    }

    /// `2 n (z3 - z(0))` by Newton's method from above, which falls to the largest root.
    fn largest(&self) -> f64 {
        let (b, c) = (2.0 * self.n * self.c1, 4.0 * self.n * self.n * self.c0);
        let mut y = 2.0 * self.c2.abs().max(b.abs().sqrt()).max(c.cbrt());
        for _ in 0..200 {
            let slope = (3.0 * y + 2.0 * self.c2) * y + b;
            let next = y - (((y + self.c2) * y + b) * y + c) / slope;
            if !(next < y && next >= 0.0) {
                break;
            }
            y = next;
        }
        y
    }

    /// `(z2 - z(0), z(0) - z1)` when the third root is known, without cancellation.
    fn others(&self, y3: f64) -> (f64, f64) {
        let product = self.c0 / y3;
        let difference = (self.c1 + 2.0 * self.n * product) / y3;
        let span = (difference * difference + 4.0 * product).sqrt();
        let larger = 0.5 * (span + difference.abs());
        let smaller = if larger > 0.0 { product / larger } else { 0.0 };
        if difference > 0.0 { (larger, smaller) } else { (smaller, larger) }
    }

    /// `z(0) - z1`, polished where it is a simple root.
    fn polished(&self, mut down: f64) -> f64 {
        for _ in 0..4 {
            let value = ((self.c2 - 2.0 * self.n * down) * down - self.c1) * down + self.c0;
            let slope = (2.0 * self.c2 - 6.0 * self.n * down) * down - self.c1;
            let step = value / slope;
            if step.is_finite() {
                down = (down - step).max(0.0);
            }
        }
        down
    }
}
