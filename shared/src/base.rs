//! The base model: a geared DC motor in volt-equivalents, discretised exactly.
//!
//! ```text
//! tau_e du/dt = v - k_e w - u          u = R i, the current as a voltage              [V]
//!       dw/dt = c (u + f) - b w        f = T R / (n K_t), a torque as a voltage       [V]
//!       dx/dt = w                      w, x: speed and angle of the output shaft      [rad/s, rad]
//! with  c = gain / tau_m,  k_e = (1 - viscous_share) / gain,  b = viscous_share / tau_m
//! ```
//! `gain` is the no-load speed per volt and `tau_m` the mechanical time constant whatever the share of the
//! damping that is viscous. Source: the usual DC-motor equations (paper, eqs 1-12), divided by K_t / R.

use crate::loss::Shares;
use crate::scalar::Scalar;

/// What voltage and motion determine about a motor without further effects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Base<S> {
    /// No-load speed of the output shaft per volt, rad/s per V.
    pub gain: S,
    /// Mechanical time constant, s.
    pub tau_m: S,
    /// Electrical time constant L/R, s.
    pub tau_e: S,
    /// Share of the mechanical damping that is viscous friction (the rest is back-EMF), 0 ..= 1.
    pub viscous_share: S,
}

impl<S: Scalar> Base<S> {
    /// Acceleration per volt-equivalent of torque, rad/s^2 per V.
    #[inline(always)]
    pub fn acceleration(&self) -> S {
        self.gain / self.tau_m
    }
    /// Back-EMF constant seen at the output shaft, V per rad/s.
    #[inline(always)]
    pub fn back_emf(&self) -> S {
        (S::one() - self.viscous_share) / self.gain
    }
    /// Viscous damping rate, 1/s.
    #[inline(always)]
    pub fn damping(&self) -> S {
        self.viscous_share / self.tau_m
    }
    /// The rotor alone, when `load_share` of the inertia and `load_damping` of the viscous friction sit behind a gap or
    /// a spring: c / (1 - load_share), b (1 - load_damping) / (1 - load_share) and k_e.
    #[inline(always)]
    #[must_use]
    pub fn without_load(self, load_share: S, load_damping: S) -> Self {
        let moved = self.viscous_share * load_damping;
        let rest = S::one() / (S::one() - moved);
        Self {
            gain: self.gain * rest,
            tau_m: self.tau_m * (S::one() - load_share) * rest,
            viscous_share: (self.viscous_share - moved) * rest,
            ..self
        }
    }
}

/// Exact one-step map of the base model for inputs held over the step.
///
/// ```text
/// u' = uu u + uw w + uv v + uf f
/// w' = wu u + ww w + wv v + wf f
/// x' = x + half_step (w + w') + xu u + xw w + xv v + xf f      the x-row corrects the trapezium
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // the equations above name every coefficient
pub struct Coefficients<S> {
    pub uu: S,
    pub uw: S,
    pub uv: S,
    pub uf: S,
    pub wu: S,
    pub ww: S,
    pub wv: S,
    pub wf: S,
    pub xu: S,
    pub xw: S,
    pub xv: S,
    pub xf: S,
    /// Half the step, s.
    pub half_step: S,
    /// 1 / uv and 1 / wf, for the implicit equations of current and friction.
    pub inverse_uv: S,
    pub inverse_wf: S,
    /// Torque that changes the speed by one unit in one step, V per rad/s, and half the viscous torque.
    pub per_impulse: S,
    /// Speed that one volt of torque gives in an electrical time constant, rad/s.
    pub electric_impulse: S,
    /// Half the viscous friction, V per rad/s.
    pub viscous: S,
    /// Back-EMF constant, V per rad/s.
    pub back_emf: S,
    /// How a step's currents share in what is lost against them.
    pub shares: Shares<S>,
}

type M2<S> = [[S; 2]; 2];

#[inline(always)]
fn product<S: Scalar>(a: &M2<S>, b: &M2<S>) -> M2<S> {
    core::array::from_fn(|r| core::array::from_fn(|c| a[r][0].mul_add(b[0][c], a[r][1] * b[1][c])))
}
#[inline(always)]
fn combine<S: Scalar>(a: &M2<S>, scale: S, b: &M2<S>) -> M2<S> {
    core::array::from_fn(|r| core::array::from_fn(|c| b[r][c].mul_add(scale, a[r][c])))
}

impl<S: Scalar> Coefficients<S> {
    /// Discretises `base` for steps of `step` seconds.
    ///
    /// Taylor series on a 512th of the step, then nine doublings of D = e^{At} - 1, P = integral of e^{As} and
    /// Q = integral of P. Keeping D instead of e^{At} and doubling the integrals keeps full relative precision
    /// in `f32` and needs no inverse; it holds for steps up to about 50 electrical time constants.
    #[must_use]
    pub fn new(base: &Base<S>, step: S) -> Self {
        Self::discretised(base, step)
    }

    /// [`Self::new`], compiled for the vector unit of its caller.
    #[inline(always)]
    #[must_use]
    pub fn discretised(base: &Base<S>, step: S) -> Self {
        const DOUBLINGS: usize = 9;
        const TERMS: usize = 7;
        let (one, zero) = (S::one(), S::zero());
        let (c, k, b) = (base.acceleration(), base.back_emf(), base.damping());
        let inverse_tau = one / base.tau_e;
        let a = [[-inverse_tau, -(k * inverse_tau)], [c, -b]];
        let mut t = step * S::lit(1.0 / (1 << DOUBLINGS) as f64);

        // P = sum A^(n-1) t^n / n!,  Q = sum A^(n-2) t^n / n!  (term holds A^(n-1) t^n / n!)
        let identity = [[one, zero], [zero, one]];
        let mut term = [[t, zero], [zero, t]];
        let mut p = term;
        let mut half = S::lit(0.5) * t * t;
        let mut q = [[half, zero], [zero, half]];
        for n in 2..=TERMS {
            let scale = t * S::lit(1.0 / n as f64);
            term = product(&term, &a);
            term = core::array::from_fn(|r| core::array::from_fn(|s| term[r][s] * scale));
            p = combine(&p, one, &term);
            // term * t / (n + 1) is the next term of Q
            q = combine(&q, t * S::lit(1.0 / (n as f64 + 1.0)), &term);
        }
        let mut d = product(&a, &p);
        let mut half_kept = one;
        for _ in 0..DOUBLINGS {
            half_kept = one + d[0][0];
            let e = combine(&d, one, &identity);
            let q2 = combine(&combine(&q, t, &p), one, &product(&e, &q));
            let p2 = combine(&p, one, &product(&e, &p));
            d = combine(&combine(&d, one, &d), one, &product(&d, &d));
            (p, q) = (p2, q2);
            t += t;
        }
        half = S::lit(0.5) * step;
        let (uv, uf) = (p[0][0] * inverse_tau, p[0][1] * c);
        let (wv, wf) = (p[1][0] * inverse_tau, p[1][1] * c);
        let (wu, ww) = (d[1][0], one + d[1][1]);
        Self {
            uu: one + d[0][0],
            uw: d[0][1],
            uv,
            uf,
            wu,
            ww,
            wv,
            wf,
            xu: p[1][0] - half * wu,
            xw: p[1][1] - half * (one + ww),
            xv: q[1][0] * inverse_tau - half * wv,
            xf: q[1][1] * c - half * wf,
            half_step: half,
            inverse_uv: one / uv,
            inverse_wf: one / wf,
            per_impulse: one / (c * step),
            electric_impulse: c * base.tau_e,
            viscous: S::lit(0.5) * b / c,
            back_emf: k,
            shares: Shares::new(step * inverse_tau, [one + d[0][0], half_kept], uv),
        }
    }
}

/// The units in which a per-unit model counts: one unit of each quantity, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// V.
    pub volt: f64,
    /// rad/s.
    pub speed: f64,
    /// rad.
    pub angle: f64,
}

impl Coefficients<f64> {
    /// The same map with voltages, speeds and angles counted in `units`, rounded to the numbers of `S`.
    ///
    /// With volt = highest voltage, speed = gain * volt and angle = speed * step * 2^k every coefficient and
    /// state of a motor lies within a few units, and `half_step` is a power of two: no drift in fixed point.
    #[must_use]
    pub fn per_unit<S: Scalar>(&self, units: &Units) -> Coefficients<S> {
        let Units { volt, speed, angle } = *units;
        Coefficients {
            uu: S::lit(self.uu),
            uw: S::lit(self.uw * speed / volt),
            uv: S::lit(self.uv),
            uf: S::lit(self.uf),
            wu: S::lit(self.wu * volt / speed),
            ww: S::lit(self.ww),
            wv: S::lit(self.wv * volt / speed),
            wf: S::lit(self.wf * volt / speed),
            xu: S::lit(self.xu * volt / angle),
            xw: S::lit(self.xw * speed / angle),
            xv: S::lit(self.xv * volt / angle),
            xf: S::lit(self.xf * volt / angle),
            half_step: S::lit(self.half_step * speed / angle),
            inverse_uv: S::lit(self.inverse_uv),
            inverse_wf: S::lit(self.inverse_wf * speed / volt),
            per_impulse: S::lit(self.per_impulse * speed / volt),
            electric_impulse: S::lit(self.electric_impulse * volt / speed),
            viscous: S::lit(self.viscous * speed / volt),
            back_emf: S::lit(self.back_emf * speed / volt),
            shares: self.shares.per_unit(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn base() -> Base<f64> {
        Base { gain: 0.9, tau_m: 0.06, tau_e: 8e-4, viscous_share: 0.1 }
    }

    #[test]
    fn two_half_steps_equal_one_step() {
        let (one, half) = (Coefficients::new(&base(), 2e-3), Coefficients::new(&base(), 1e-3));
        let go = |c: &Coefficients<f64>, s: [f64; 3]| {
            let [u, w, x] = s;
            let (v, f) = (3.0, -0.4);
            let u2 = c.uu * u + c.uw * w + c.uv * v + c.uf * f;
            let w2 = c.wu * u + c.ww * w + c.wv * v + c.wf * f;
            [u2, w2, x + c.half_step * (w + w2) + c.xu * u + c.xw * w + c.xv * v + c.xf * f]
        };
        let a = go(&one, [0.7, 5.0, 1.0]);
        let b = go(&half, go(&half, [0.7, 5.0, 1.0]));
        for k in 0..3 {
            assert!((a[k] - b[k]).abs() < 1e-13, "{a:?} {b:?}");
        }
    }

    proptest! {
        /// Without electrical lag the model is first order: w = gain v (1 - e^{-t/tau_m}).
        #[test]
        fn a_fast_winding_gives_the_first_order_step_response(
            gain in 0.1_f64..100.0, tau_m in 0.01_f64..1.0, share in 0.0_f64..0.9, step in 1e-4_f64..2e-3,
        ) {
            let base = Base { gain, tau_m, tau_e: 2e-5, viscous_share: share };
            let c = Coefficients::new(&base, step);
            let truth = gain * (1.0 - libm::exp(-step / tau_m));
            prop_assert!((c.wv - truth).abs() < 1.5 * gain * 2e-5 / tau_m);
        }

        /// Held voltage: gain v is a fixed point of the map, and its angle grows by gain v step.
        #[test]
        fn no_load_speed_is_a_fixed_point(
            gain in 0.1_f64..100.0, tau_m in 5e-3_f64..1.0, tau_e in 5e-5_f64..5e-3, share in 0.0_f64..0.9,
        ) {
            let base = Base { gain, tau_m, tau_e, viscous_share: share };
            let c = Coefficients::new(&base, 1e-3);
            let (v, w) = (6.0, 6.0 * gain);
            let u = share * v;
            prop_assert!((c.uu * u + c.uw * w + c.uv * v - u).abs() < 1e-9 * v);
            prop_assert!((c.wu * u + c.ww * w + c.wv * v - w).abs() < 1e-9 * w);
            prop_assert!((c.xu * u + c.xw * w + c.xv * v).abs() < 1e-12 * w);
        }

        /// The board's single precision follows the reference.
        #[test]
        fn single_precision_keeps_six_digits(tau_m in 0.01_f64..1.0, tau_e in 1e-4_f64..5e-3) {
            let f = Base { gain: 1.0_f64, tau_m, tau_e, viscous_share: 0.1 };
            let g = Base { gain: 1.0_f32, tau_m: tau_m as f32, tau_e: tau_e as f32, viscous_share: 0.1 };
            let (a, b) = (Coefficients::new(&f, 1e-3), Coefficients::new(&g, 1e-3));
            for (x, y) in [(a.uv, f64::from(b.uv)), (a.wv, f64::from(b.wv)), (a.wf, f64::from(b.wf)), (1.0 - a.ww, 1.0 - f64::from(b.ww))] {
                prop_assert!((x - y).abs() < 1e-5 * x.abs() + 1.2e-7, "{x} {y}");
            }
        }
    }
}
