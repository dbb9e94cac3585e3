//! What a resistance and a voltage drop take from the current of a step.
//!
//! Both depend on the current, which in a step of z electrical time constants goes from u to u2 as an exponential. A loss
//! counts in two ways. For the last current it counts by what the winding still keeps of it at the end; for the speed it
//! counts by its mean, wherever in the step it was, for the winding passes on every volt-second in the end.
//!
//! A loss that grows with the current takes the place of a resistance: behind a share q of the winding's a current fades 1 + q
//! times as fast. Of a brush that share is the slope of its drop from the step's first current to its last. And while the shaft
//! gains speed its back-EMF takes from the current evenly over the step, not as an exponential: what a loss follows of that
//! counts by the step's own times ([`Shares::ramp`] for the last current, one half in the mean).

use crate::base::Coefficients;
use crate::brush::{self, About};
use crate::scalar::Scalar;
use crate::step::{Drive, Laws};

/// How the winding forgets what happens in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares<S> {
    /// Electrical time constants in a step.
    pub constants: S,
    /// Steps in one of them.
    pub per_constant: S,
    /// Share of a current that is left after a step.
    pub kept: S,
    /// The same after half of it.
    pub half_kept: S,
    /// The start of a step, in what a loss that goes evenly to zero takes from the last current: one half in short steps.
    pub ramp: S,
}

/// How the currents of a step share in a loss that grows with them; the last current has what is left of 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Behind<S> {
    /// The first current, in what the loss takes from the last one: one half in short steps, none in long ones.
    pub early: S,
    /// The same, in the mean over the step.
    pub early_in_mean: S,
    /// The first current, in the one at half the step's time.
    pub half_way: S,
    /// The first half of the step, in what a drop takes from the last current, with its second half at one half.
    pub half: S,
    /// The same, in the mean over the step.
    pub half_in_mean: S,
    /// What a current is to the one without the loss: 1 / (1 + slope).
    pub left: S,
}

impl<S: Scalar> Shares<S> {
    /// In a step of `constants` electrical time constants, after which the winding keeps `kept` of a current and after half
    /// of which it keeps `half_kept`; `uv` is the current that one volt makes in it.
    #[inline(always)]
    pub fn new(constants: S, [kept, half_kept]: [S; 2], uv: S) -> Self {
        let (one, zero, half) = (S::one(), S::zero(), S::lit(0.5));
        let (kept, half_kept) = (kept.max(zero), half_kept.max(zero));
        let per_constant = one / constants;
        let ramp = (per_constant - kept / uv).clamp(zero, half);
        Self { constants, per_constant, kept, half_kept, ramp }
    }

    /// Behind a loss of `slope` times the winding's resistance; `inverse_uv` is 1 / `uv`.
    #[inline(always)]
    fn behind(&self, slope: S, [uv, inverse_uv]: [S; 2]) -> Behind<S> {
        let (one, zero, half) = (S::one(), S::zero(), S::lit(0.5));
        // e^-x of what the loss adds: the eighth power of its Pade approximant, 1 - e^-x by its factors.
        let z = S::lit(0.125) * self.constants;
        let x = z * slope;
        let (even, odd) = ((x * x).mul_add(S::lit(1.0 / 12.0), one), half * x);
        let per_sum = one / (even + odd);
        let root = (even - odd) * per_sum;
        let square = root * root;
        let fourth = square * square;
        let fades = fourth * fourth;
        let gone_per_slope = z * per_sum * (one + root) * (one + square) * (one + fourth);
        let kept = self.kept * fades;
        let per_gone = one / (one - kept);
        let early = (self.kept * (gone_per_slope - fades * uv) * (per_gone * inverse_uv)).max(zero);
        let left = one / (one + slope);
        let early_in_mean = (self.per_constant * left - kept * per_gone).clamp(zero, half);
        let half_kept = self.half_kept * fourth;
        let per_way = one / (one + half_kept);
        let half_way = half_kept * per_way;
        // Right where the drop is in proportion to the current: over 1 + half_way.
        let per_both = (one + half_kept) / (one + half_kept + half_kept);
        let of_half = |early: S| (early + early - half * half_way) * per_both;
        let (in_last, in_mean) = (of_half(early), of_half(early_in_mean));
        Behind { early, early_in_mean, half_way, half: in_last, half_in_mean: in_mean, left }
    }
}

impl Shares<f64> {
    /// In the numbers of `S`; shares have no unit.
    pub(crate) fn per_unit<S: Scalar>(&self) -> Shares<S> {
        Shares {
            constants: S::lit(self.constants),
            per_constant: S::lit(self.per_constant),
            kept: S::lit(self.kept),
            half_kept: S::lit(self.half_kept),
            ramp: S::lit(self.ramp),
        }
    }
}

/// What is left of the current `u2` behind drops and a resistance in a step that began with `u` and in which the speed goes
/// from `w` to `w2`, were it not for them; and the torque (V) by which the speed is better off than that current says.
#[inline(always)]
pub fn left<S: Scalar>(
    c: &Coefficients<S>,
    laws: Laws,
    [u, u2]: [S; 2],
    [w, w2]: [S; 2],
    drive: &Drive<S>,
) -> (S, S) {
    let (one, zero) = (S::one(), S::zero());
    let mut after = if laws.drop { u2.shrink(c.uv * drive.drop) } else { u2 };
    if !(laws.series || laws.brush) {
        return (after, zero);
    }
    let series = if laws.series { drive.series } else { zero };
    let mut open = c.uv.mul_add(series, one);
    let about = if laws.brush { brush::guess(c, u, after, open, drive) } else { About::none(after) };
    let s = c.shares.behind(series + about.rise, [c.uv, c.inverse_uv]);
    let early = series * c.uv * s.early;
    after += -(early * u);
    open += -early;
    let mut late = zero;
    // Of a resistance, what a volt of the current after is to one before, and its share in what the current loses.
    let mut closed = one / open;
    let mut taken = series * s.left;
    if laws.brush {
        let end = brush::behind(c, &s, [u, after], &about, open, drive);
        after = end.current;
        late = drive.brush * (s.half - s.half_in_mean) * (end.first - end.share);
        let slope = drive.brush.mul_add(end.slope, series);
        taken = slope / (one + slope);
        closed = one / end.open;
    } else {
        after = after * closed;
    }
    late += series * (s.early - s.early_in_mean) * (u - after);
    // What the back-EMF takes from the current in the step, and the loss follows.
    let mut ends = (after - u2).mul_add(c.inverse_uv * c.wv, w2);
    if laws.dry {
        ends += -ends.clamp(-(c.wf * drive.friction_backward), c.wf * drive.friction_forward);
    }
    let ramp = taken * c.back_emf * (ends - w);
    let sooner = (c.shares.ramp - s.early) * ramp;
    after += -(c.uv * sooner * closed);
    late += sooner - (S::lit(0.5) - s.early_in_mean) * ramp;
    (after, late)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Base;

    const BASE: Base<f64> = Base { gain: 0.9, tau_m: 1e6, tau_e: 8e-4, viscous_share: 0.1 };

    /// A resistance that is a share q of the winding's shortens the electrical time constant by 1 + q: the first current keeps
    /// e^(-(1 + q) z) of itself in z time constants.
    #[test]
    fn a_series_resistance_leaves_what_an_exponential_of_its_own_leaves() {
        for step in [1e-4, 1e-3, 4e-3] {
            let c = Coefficients::new(&BASE, step);
            for q in [1e-4, 0.1, 0.5, 3.0] {
                let early = c.shares.behind(q, [c.uv, c.inverse_uv]).early;
                let left = (c.uu - q * c.uv * early) / (1.0 + q * c.uv * (1.0 - early));
                let truth = libm::exp(-(1.0 + q) * step / BASE.tau_e);
                assert!(
                    (left - truth).abs() < 1e-3 * (c.uu - truth).abs() + 1e-9,
                    "{left} {truth} in {step} s, {q}"
                );
            }
        }
    }

    /// With a share q more of resistance a current that is left alone gives 1 / (1 + q) of its volt-seconds.
    #[test]
    fn a_series_resistance_takes_its_exact_share_of_the_volt_seconds() {
        for (step, q) in
            [(2e-4, 1e-4), (1e-3, 1e-4), (4e-3, 1e-4), (2e-4, 0.3), (1e-3, 0.3), (1e-3, 2.0), (4e-3, 0.3)]
        {
            let c = Coefficients::new(&BASE, step);
            let drive = Drive { series: q, ..Drive::plain(0.0) };
            let laws = Laws { series: true, ..Laws::default() };
            let (mut u, mut sum) = (1.0, 0.0);
            for _ in 0..(40.0 * BASE.tau_e / step) as usize + 40 {
                let free = c.uu * u;
                let (after, late) = left(&c, laws, [u, free], [0.0, 0.0], &drive);
                // Volt-seconds are what the coil gave up, less what the resistance took.
                sum += (after - free) * c.inverse_uv + late;
                u = after;
            }
            let lost = -sum * step / BASE.tau_e;
            let truth = q / (1.0 + q);
            assert!((lost / truth - 1.0).abs() < 2e-3, "{lost} {truth} in {step} s");
        }
    }

    /// A shaft that speeds up takes from the current evenly: behind a resistance the speed after steps of 3 time constants
    /// is that of short steps.
    #[test]
    fn a_resistance_follows_what_the_back_emf_takes_in_a_step() {
        let base = Base { gain: 4.0, tau_m: 0.014, tau_e: 3.4e-4, viscous_share: 0.1 };
        let reached = |parts: usize, series: f64| {
            let c = Coefficients::new(&base, 1e-3 / parts as f64);
            let laws = Laws { series: true, ..Laws::default() };
            let drive = Drive { series, ..Drive::plain(6.0) };
            let mut s = crate::step::State::rest();
            (0..20 * parts).for_each(|_| crate::step::step(&c, laws, &mut s, &drive));
            s.angle
        };
        let truth = reached(64, 0.5);
        let done = (truth - reached(64, 0.0)).abs();
        let off = (reached(1, 0.5) - truth).abs();
        assert!(off < done / 300.0, "off by 1/{:.0}", done / off);
    }
}
