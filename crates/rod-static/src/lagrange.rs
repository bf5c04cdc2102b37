use crate::StaticError;
use crate::carlson::{rd, rj};
use crate::error::{finite, positive};
use crate::quadrature::gauss;
use crate::roots::{CubicRoots, Integrals};
use crate::state::State;
use nalgebra::{Complex, Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use rapunzel_fiber::euler::EulerAngles;
use rapunzel_fiber::so3;

/// A rod of circular section with a force and a moment at its ends only: the closed form
/// (Lagrange's case, thesis section 3.3.1.1 with its errata).
///
/// The bending stiffness is the same in all directions; the natural shape may be twisted, not
/// bent. The state at any arc length follows from that at zero at constant cost, about a
/// microsecond, through elliptic functions.
///
/// The thesis's Euler angles are singular where the tangent is along the force. Here they enter as
/// the two complex numbers `cos(theta/2) exp(i (phi + psi)/2)` and `sin(theta/2) exp(i (phi -
/// psi)/2)` of Cayley and Klein, which are smooth everywhere; each of the two phases is one
/// integral of the third kind. So the helix, planar rods, the poles and the separatrix are no
/// exceptions. Positions are closed too, and where the force is too weak to divide by they come
/// from quadrature of the closed tangent.
#[derive(Debug, Clone)]
pub struct Lagrange {
    bending: f64,
    start: State,
    /// Rotation from the axes of the force, whose z axis is the force, to the world.
    to_world: Rotation3<f64>,
    /// Moment along the tangent, 1/m, and half the excess of twist over that of the precession.
    spin: f64,
    motion: Option<AngleMotion>,
}

/// Force times arc length, in units of the rates, below which positions come from quadrature: the
/// closed form is a difference divided by the force.
const WEAK: f64 = 1e-2;
/// Largest rotation, rad, for which quadrature is used; longer rods use the closed form again.
const PANELS: f64 = 1e5;

/// Motion of the angle to the force and of the phases that follow from it, in units of the bending
/// stiffness.
#[derive(Debug, Clone)]
struct AngleMotion {
    roots: CubicRoots,
    n: f64,
    mz: f64,
    /// Bound of the rates of all angles, 1/m.
    rate: f64,
    /// Phases of the two complex numbers at the start, less their integrals.
    phases: [f64; 2],
    /// Transverse moment at the start, 1/m.
    transverse: Complex<f64>,
}

/// The elliptic functions at one arc length: argument, number of half waves, and sn, cn, dn.
struct EllipticPlace {
    u: f64,
    rest: f64,
    half_waves: f64,
    sn: f64,
    cn: f64,
    dn: f64,
}

impl Lagrange {
    /// The rod of bending stiffness `bending` and torsion stiffness `torsion` (N m^2), naturally
    /// straight with the twist `natural_twist` (rad/m), that is in the state `start` at arc length
    /// zero.
    ///
    /// # Errors
    /// A stiffness that is not positive, and numbers that are not finite.
    pub fn new(
        bending: f64,
        torsion: f64,
        natural_twist: f64,
        start: &State,
    ) -> Result<Self, StaticError> {
        positive("the bending stiffness (N m^2)", bending)?;
        positive("the torsion stiffness (N m^2)", torsion)?;
        finite("the natural twist (rad/m)", &[natural_twist])?;
        start.validate()?;
        let (force, moment) = (start.force / bending, start.moment / bending);
        // Without a force the moment is constant and the rod winds about it.
        let axis = if force == Vector3::zeros() { moment } else { force };
        let to_world = so3::between(&Vector3::z(), &axis).unwrap_or_else(|| {
            let sign = if axis.z < 0.0 { -1.0 } else { 1.0 };
            let half_turn = Matrix3::from_diagonal(&Vector3::new(1.0, sign, sign));
            Rotation3::from_matrix_unchecked(half_turn)
        });
        let (frame, moment) = (to_world.inverse() * start.frame, to_world.inverse() * moment);
        let tangent = frame.matrix().column(2).into_owned();
        let m3 = moment.dot(&tangent);
        // 1 - z and 1 + z; the smaller of them from the sine, which keeps its digits.
        let squared = tangent.x * tangent.x + tangent.y * tangent.y;
        let (below, above) = if tangent.z > 0.0 {
            (squared / (1.0 + tangent.z), 1.0 + tangent.z)
        } else {
            (1.0 - tangent.z, squared / (1.0 - tangent.z))
        };
        let level = moment.x * tangent.x + moment.y * tangent.y;
        let integrals = Integrals {
            n: force.norm(),
            below,
            above,
            slope: moment.cross(&tangent).z,
            bending: moment.cross(&tangent).norm_squared(),
            m3,
            mz: moment.z,
            crossing: moment.z * squared - tangent.z * level,
            difference: moment.z * below - level,
            sum: moment.z * above + level,
        };
        let spin = 0.5 * ((bending / torsion - 1.0) * m3 + natural_twist);
        let straight = squared == 0.0 && integrals.bending == 0.0;
        let across = Complex::new(moment.x, moment.y);
        let motion = CubicRoots::of(&integrals)
            .filter(|_| !straight)
            .map(|roots| AngleMotion::of(roots, &integrals, &frame, across));
        Ok(Self { bending, start: *start, to_world, spin, motion })
    }

    /// The roots `z1 <= z2 <= 1 <= z3` of `(dz/ds)^2` (thesis (3.91)), `z` the cosine of the angle
    /// between the tangent and the force; `z3` is infinite without a force. `None` for a rod that
    /// is straight along its force.
    #[must_use]
    pub fn roots(&self) -> Option<[f64; 3]> {
        self.motion.as_ref().map(|m| {
            let r = &m.roots;
            [r.z1(), 1.0 - r.below2, 1.0 + r.beyond3 / (2.0 * m.n)]
        })
    }

    /// The modulus `k` of the elliptic functions (thesis (3.97)), and half their frequency
    /// `lambda`, 1/m. `None` as for [`Lagrange::roots`].
    #[must_use]
    pub fn modulus(&self) -> Option<(f64, f64)> {
        let of = |m: &AngleMotion| ((1.0 - m.roots.modulus.complement()).sqrt(), m.roots.lambda);
        self.motion.as_ref().map(of)
    }

    /// The arc length after which the angle to the force repeats, m (thesis (3.101), corrected).
    /// `None` as for [`Lagrange::roots`].
    #[must_use]
    pub fn period(&self) -> Option<f64> {
        self.motion.as_ref().map(|m| 2.0 * m.roots.modulus.quarter_period() / m.roots.lambda)
    }

    /// The Euler angles of the frame at arc length `s` (m) in axes whose z is the force, continuous
    /// in `s`; at the poles `phi` and `psi` jump by pi. `None` as for [`Lagrange::roots`].
    #[must_use]
    pub fn euler_angles(&self, s: f64) -> Option<EulerAngles> {
        let motion = self.motion.as_ref()?;
        let place = motion.place(s);
        let ([above, below], [plus, minus]) = (motion.distances(&place), motion.phases(&place));
        let turned = self.spin * s;
        Some(EulerAngles {
            phi: plus + minus,
            theta: 2.0 * below.sqrt().atan2(above.sqrt()),
            psi: plus - minus + 2.0 * turned,
        })
    }

    /// The state at arc length `s`, m, of either sign. Not a number only if `s` is not finite.
    #[must_use]
    pub fn at(&self, s: f64) -> State {
        let free = self.start.force == Vector3::zeros();
        let Some(motion) = self.motion.as_ref().filter(|_| !free) else { return self.helix(s) };
        let place = motion.place(s);
        let [alpha, beta] = motion.numbers(&place, self.spin * s);
        let quaternion = Quaternion::new(alpha.re, -beta.im, beta.re, alpha.im);
        let frame = UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix();
        let transverse = motion.transverse(&place, alpha, beta);
        let weak = motion.n * s.abs() <= WEAK * motion.rate && s.abs() * motion.rate <= PANELS;
        let local = if weak {
            motion.by_quadrature(s)
        } else {
            let way = Complex::new(0.0, -1.0) * (transverse - motion.transverse) / motion.n;
            Vector3::new(way.re, way.im, motion.along(&place, s))
        };
        let moment = Vector3::new(transverse.re, transverse.im, motion.mz) * self.bending;
        State {
            position: self.start.position + self.to_world * local,
            frame: self.to_world * frame,
            force: self.start.force,
            moment: self.to_world * moment,
        }
    }

    /// A rod along its force, or without one: the world sees it turn about its constant moment, and
    /// it turns about itself.
    fn helix(&self, s: f64) -> State {
        let turn = self.start.moment * (s / self.bending);
        let tangent = self.start.frame * Vector3::z();
        let own = so3::exp(&(Vector3::z() * (2.0 * self.spin * s)));
        State {
            position: self.start.position + so3::right_jacobian(&-turn) * tangent * s,
            frame: so3::exp(&turn) * self.start.frame * own,
            ..self.start
        }
    }
}

impl AngleMotion {
    fn of(
        roots: CubicRoots,
        i: &Integrals,
        frame: &Rotation3<f64>,
        transverse: Complex<f64>,
    ) -> Self {
        let rate = roots.lambda + i.bending.sqrt() + i.m3.abs();
        let mut motion = Self { roots, n: i.n, mz: i.mz, rate, phases: [0.0; 2], transverse };
        let q = so3::quaternion(frame);
        let (alpha, beta) = (Complex::new(q.w, q.k), Complex::new(q.j, -q.i));
        let mut args = [alpha.arg(), beta.arg()];
        let place = motion.place(0.0);
        let slope = motion.slope(&place);
        // Close to a pole the azimuth of the tangent says little, that of the moment all.
        if beta.norm() < alpha.norm() {
            let bent = beta / alpha.conj() * i.mz - transverse;
            if bent.norm() > rate * beta.norm() {
                args[1] = bent.arg() - args[0] - Complex::new(roots.difference, slope).arg();
            }
        } else {
            let bent = transverse + alpha / beta.conj() * i.mz;
            if bent.norm() > rate * alpha.norm() {
                args[0] = bent.arg() - args[1] - Complex::new(roots.sum, -slope).arg();
            }
        }
        let integrals = motion.phases(&place);
        motion.phases = [args[0] - integrals[0], args[1] - integrals[1]];
        motion
    }

    fn place(&self, s: f64) -> EllipticPlace {
        let u = self.roots.lambda * s + self.roots.start;
        let (half_waves, rest) = self.roots.modulus.reduce(u);
        let at = self.roots.modulus.jacobi_reduced(rest);
        EllipticPlace { u, rest, half_waves, sn: at.sn, cn: at.cn, dn: at.dn }
    }

    /// `(1 + z) / 2` and `(1 - z) / 2` (thesis (3.96)).
    fn distances(&self, p: &EllipticPlace) -> [f64; 2] {
        let r = &self.roots;
        [0.5 * (r.above1 + r.span * p.sn * p.sn), 0.5 * (r.below2 + r.span * p.cn * p.cn)]
    }

    /// `z'`, 1/m.
    fn slope(&self, p: &EllipticPlace) -> f64 {
        2.0 * self.roots.lambda * self.roots.span * p.sn * p.cn * p.dn
    }

    /// The phases `(phi + psi)/2` and `(phi - psi)/2` without the part that grows with the spin
    /// (thesis (3.108), (3.109), corrected).
    ///
    /// The second varies fast where the tangent passes the force (z2), and its integral starts at
    /// z1; the first varies fast at z1, and its integral starts at z2. So both are sums of
    /// positive terms and keep their digits however close the pole is passed.
    fn phases(&self, p: &EllipticPlace) -> [f64; 2] {
        let r = &self.roots;
        let k1 = r.modulus.complement();
        let quarter = r.modulus.quarter_period();
        let third = |sn: f64, cn2: f64, dn2: f64, gap: f64| {
            sn.powi(3) / 3.0 * rj(cn2, dn2, 1.0, cn2 + gap * sn * sn)
        };
        let gap = r.below2 / r.below1;
        let complete = third(1.0, 0.0, k1, gap);
        let part = third(p.sn, p.cn * p.cn, p.dn * p.dn, gap);
        let minus = p.u + r.span / r.below1 * (2.0 * p.half_waves * complete + part);

        let gap = k1 * r.above1 / r.above2;
        let factor = k1 * r.span / r.above2;
        let complete = quarter + factor * third(1.0, 0.0, k1, gap);
        // sn, cn, dn at the distance K - |u| from z2.
        let (sn, cn, dn) = (p.cn / p.dn, k1.sqrt() * p.sn / p.dn, k1.sqrt() / p.dn);
        let part = quarter - p.rest.abs() + factor * third(sn, cn * cn, dn * dn, gap);
        let side = 1.0_f64.copysign(p.rest);
        let plus = 2.0 * p.half_waves * complete + side * (complete - part);
        [
            self.phases[0] + r.sum / (2.0 * r.lambda * r.above2) * plus,
            self.phases[1] + r.difference / (2.0 * r.lambda * r.below1) * minus,
        ]
    }

    /// The two complex numbers whose real and imaginary parts are the frame's quaternion.
    fn numbers(&self, p: &EllipticPlace, spin: f64) -> [Complex<f64>; 2] {
        let ([above, below], [plus, minus]) = (self.distances(p), self.phases(p));
        [
            Complex::from_polar(above.sqrt(), plus + spin),
            Complex::from_polar(below.sqrt(), minus - spin),
        ]
    }

    /// The moment across the force, 1/m.
    fn transverse(
        &self,
        p: &EllipticPlace,
        alpha: Complex<f64>,
        beta: Complex<f64>,
    ) -> Complex<f64> {
        let (slope, both) = (self.slope(p), 2.0 * (alpha * beta).conj());
        if beta.norm_sqr() < alpha.norm_sqr() {
            beta / alpha.conj() * self.mz - Complex::new(self.roots.difference, slope) / both
        } else {
            Complex::new(self.roots.sum, -slope) / both - alpha / beta.conj() * self.mz
        }
    }

    /// Displacement along the force, m (thesis (3.118), corrected).
    fn along(&self, p: &EllipticPlace, s: f64) -> f64 {
        let r = &self.roots;
        let squares = |p: &EllipticPlace| {
            let part = |sn: f64, cn2: f64, dn2: f64| sn.powi(3) / 3.0 * rd(cn2, dn2, 1.0);
            2.0 * p.half_waves * part(1.0, 0.0, r.modulus.complement())
                + part(p.sn, p.cn * p.cn, p.dn * p.dn)
        };
        r.z1() * s + r.span / r.lambda * (squares(p) - squares(&self.place(0.0)))
    }

    /// Displacement from the start to arc length `s`, m, by quadrature of the tangent.
    fn by_quadrature(&self, s: f64) -> Vector3<f64> {
        let panels = (s.abs() * self.rate).ceil().max(1.0);
        let mut way = Vector3::zeros();
        let mut panel = 0.0;
        while panel < panels {
            let (from, to) = (s * panel / panels, s * ((panel + 1.0) / panels));
            way += gauss(from, to, |t| {
                let [alpha, beta] = self.numbers(&self.place(t), 0.0);
                let across = alpha * beta * 2.0;
                Vector3::new(across.re, across.im, alpha.norm_sqr() - beta.norm_sqr())
            });
            panel += 1.0;
        }
        way
    }
}
