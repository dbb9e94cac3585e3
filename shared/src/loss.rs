//! What a resistance and a voltage drop take from the current of a step.
//!
//! Both depend on the current, which in a step of z electrical time constants goes from u to u2 as an exponential. A loss
//! counts in two ways. For the last current it counts by what the winding still keeps of it at the end; for the speed it
//! counts by its mean, wherever in the step it was, for the winding passes on every volt-second in the end.
//!
//! Below its knee a brush is a resistance of drop / knee times the winding's, which lets a current fade so much faster. The
//! exponential here is the winding's alone: up to a step of its electrical time constant over (1 + drop / knee) the losses
//! never take more than there is; in longer ones a current that begins a step far from where it ends is not followed.

use crate::base::Coefficients;
use crate::scalar::Scalar;
use crate::step::{Drive, Laws};

/// How the currents of a step share in a loss; the last current has what is left of 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares<S> {
    /// The first current, in what a resistance takes from the last one: one half in short steps, none in long ones.
    pub early: S,
    /// The same, in the mean over the step.
    pub early_in_mean: S,
    /// The first current, in the one at half the step's time.
    pub half_way: S,
    /// The first half of the step, in what a drop takes from the last current, with its second half at one half.
    pub half: S,
    /// The same, in the mean over the step.
    pub half_in_mean: S,
}

impl<S: Scalar> Shares<S> {
    /// In a step of `z` electrical time constants, after which the winding keeps `kept` of a current and after half of which
    /// it keeps `half_kept`; `uv` is the current that one volt makes in it.
    #[inline(always)]
    pub fn new(z: S, [kept, half_kept]: [S; 2], uv: S) -> Self {
        let (one, zero, half) = (S::one(), S::zero(), S::lit(0.5));
        let (kept, half_kept) = (kept.max(zero), half_kept.max(zero));
        let early = kept * (z - uv).max(zero) / (uv * uv);
        let early_in_mean = (one / z - kept / uv).clamp(zero, half);
        let half_way = half_kept / (one + half_kept);
        // Right where the drop is in proportion to the current.
        let of_half = |early: S| (early + early - half * half_way) / (one + half_way);
        Self { early, early_in_mean, half_way, half: of_half(early), half_in_mean: of_half(early_in_mean) }
    }
}

impl Shares<f64> {
    /// In the numbers of `S`; shares have no unit.
    pub(crate) fn per_unit<S: Scalar>(&self) -> Shares<S> {
        Shares {
            early: S::lit(self.early),
            early_in_mean: S::lit(self.early_in_mean),
            half_way: S::lit(self.half_way),
            half: S::lit(self.half),
            half_in_mean: S::lit(self.half_in_mean),
        }
    }
}

/// What is left of the current `u2` behind drops and a resistance in a step that began with `u`, and the torque (V) by which
/// the speed is better off than that current says.
///
/// A brush loses at current `u` the share u / sqrt(u^2 + knee^2) of its full drop. While a current goes evenly from a to b,
/// that is in the mean (a + b) / (sqrt(a^2 + knee^2) + sqrt(b^2 + knee^2)), even where it passes zero.
#[inline(always)]
pub fn left<S: Scalar>(c: &Coefficients<S>, laws: Laws, [u, u2]: [S; 2], drive: &Drive<S>) -> (S, S) {
    let s = &c.shares;
    let mut after = if laws.drop { u2.shrink(c.uv * drive.drop) } else { u2 };
    let mut open = S::one();
    let mut late = S::zero();
    if laws.series {
        let (taken, early) = (drive.series * c.uv, drive.series * c.uv * s.early);
        after += -(early * u);
        open += taken - early;
    }
    if laws.brush {
        let end;
        let first;
        (after, [first, end]) = behind_brush(c, u, after, open, drive);
        late += drive.brush * (s.half - s.half_in_mean) * (first - end);
    } else if laws.series {
        after = after / open;
    }
    if laws.series {
        late += drive.series * (s.early - s.early_in_mean) * (u - after);
    }
    (after, late)
}

/// What a brush leaves of the current `free`, of which a resistance leaves 1 / `open`; and the shares of its full drop that
/// it takes in the first half of the step and at its end.
#[inline(always)]
fn behind_brush<S: Scalar>(c: &Coefficients<S>, u: S, free: S, open: S, drive: &Drive<S>) -> (S, [S; 2]) {
    let (one, half, s) = (S::one(), S::lit(0.5), &c.shares);
    let (full, knee) = (c.uv * drive.brush, drive.brush_knee);
    let size = u.hypot(knee);
    // First guess: the first and the last current share in the drop. Newton's rounds from the sharp knee's current, which is
    // the smaller, never pass it: the share bends down.
    let (rest, late) = (without(free, full * s.early * u / size), full - full * s.early);
    let mut after = rest.shrink(late) / open;
    for _ in 0..3 {
        let per_size = one / after.hypot(knee);
        let share = after * per_size;
        let lack = rest - open.mul_add(after, late * share);
        after += lack / (late * per_size).mul_add(one - share * share, open);
    }
    let middle = s.half_way.mul_add(u - after, after);
    let middle_size = middle.hypot(knee);
    let first = (u + middle) / (size + middle_size);
    let rest = without(free, full * s.half * first);
    let last = half - s.half;
    let mut end = S::zero();
    for _ in 0..2 {
        let (end_size, old) = (after.hypot(knee), after);
        let (per_sum, per_end) = (one / (middle_size + end_size), one / end_size);
        end = old * per_end;
        let second = (middle + old) * per_sum;
        let lack = rest - open.mul_add(old, full * half.mul_add(second, last * end));
        let slope = (half * per_sum).mul_add(one - second * end, last * per_end * (one - end * end));
        after += lack / full.mul_add(slope, open);
    }
    (after, [first, end])
}

/// The current `free` after a loss before the step's end, which stops it and never turns it round.
#[inline(always)]
fn without<S: Scalar>(free: S, lost: S) -> S {
    free - lost.clamp(-free.abs(), free.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Base;

    const BASE: Base<f64> = Base { gain: 0.9, tau_m: 1e6, tau_e: 8e-4, viscous_share: 0.1 };

    /// A resistance that is a share q of the winding's shortens the electrical time constant by 1 + q: to first order of q
    /// the first current keeps e^-z (1 - q z) of itself in z time constants.
    #[test]
    fn a_series_resistance_takes_its_exact_share_to_first_order() {
        for (step, q) in [(1e-4, 1e-4), (1e-3, 1e-4), (4e-3, 1e-4)] {
            let c = Coefficients::new(&BASE, step);
            let left = (c.uu - q * c.uv * c.shares.early) / (1.0 + q * c.uv * (1.0 - c.shares.early));
            let truth = libm::exp(-(1.0 + q) * step / BASE.tau_e);
            assert!((left - truth).abs() < 1e-3 * (c.uu - truth).abs() + 1e-9, "{left} {truth} in {step} s");
        }
    }

    /// With a share q more of resistance a current that is left alone gives 1 / (1 + q) of its volt-seconds.
    #[test]
    fn a_series_resistance_takes_its_exact_share_of_the_volt_seconds() {
        for (step, q) in [(2e-4, 1e-4), (1e-3, 1e-4), (4e-3, 1e-4)] {
            let c = Coefficients::new(&BASE, step);
            let drive = Drive { series: q, ..Drive::plain(0.0) };
            let laws = Laws { series: true, ..Laws::default() };
            let (mut u, mut sum) = (1.0, 0.0);
            for _ in 0..(40.0 * BASE.tau_e / step) as usize + 40 {
                let free = c.uu * u;
                let (after, late) = left(&c, laws, [u, free], &drive);
                // Volt-seconds are what the coil gave up, less what the resistance took.
                sum += (after - free) * c.inverse_uv + late;
                u = after;
            }
            let lost = -sum * step / BASE.tau_e;
            let truth = q / (1.0 + q);
            assert!((lost / truth - 1.0).abs() < 2e-3, "{lost} {truth} in {step} s");
        }
    }
}
