//! What a brush leaves of the current of a step.
//!
//! A brush loses at current `u` the share u / sqrt(u^2 + knee^2) of its full drop. While a current goes evenly from a to b,
//! that is in the mean (a + b) / (sqrt(a^2 + knee^2) + sqrt(b^2 + knee^2)), even where it passes zero. The first half of a step
//! and its second count by the winding's memory ([`Behind`]); the last current is Newton's.

use crate::base::Coefficients;
use crate::loss::Behind;
use crate::scalar::Scalar;
use crate::step::Drive;

/// What a brush leaves of a current if all of it is lost at the end.
pub(crate) struct About<S> {
    /// The last current.
    pub current: S,
    /// What the drop rises by a volt of current from the step's first one to about that.
    pub rise: S,
    /// sqrt(u^2 + knee^2) of the first current.
    pub size: S,
}

impl<S: Scalar> About<S> {
    /// Without a brush.
    #[inline(always)]
    pub fn none(current: S) -> Self {
        Self { current, rise: S::zero(), size: S::zero() }
    }
}

/// About what a brush leaves of the current `free`.
#[inline(always)]
pub(crate) fn guess<S: Scalar>(c: &Coefficients<S>, u: S, free: S, open: S, drive: &Drive<S>) -> About<S> {
    const SAME: f64 = 1e-3;
    let (one, full, knee) = (S::one(), c.uv * drive.brush, drive.brush_knee);
    // Newton's rounds from the sharp knee's current, which is the smaller, never pass the right one: the share bends down.
    let mut current = free.shrink(full) / open;
    let (mut last, mut share) = (current, S::zero());
    for _ in 0..3 {
        let per_size = one / current.hypot(knee);
        (last, share) = (current, current * per_size);
        let lack = free - open.mul_add(current, full * share);
        current += lack / (full * per_size).mul_add(one - share * share, open);
    }
    let size = u.hypot(knee);
    let per_size = one / size;
    let first = u * per_size;
    let (apart, near) = (last - u, S::lit(SAME) * knee);
    let rise = S::pick_gt(apart.abs(), near, share - first, knee * per_size * (one - first * first));
    About { current, rise: drive.brush * rise / S::pick_gt(apart.abs(), near, apart, knee), size }
}

/// What a brush leaves in a step.
pub(crate) struct End<S> {
    /// The last current.
    pub current: S,
    /// Share of its full drop in the first half of the step.
    pub first: S,
    /// The same at the end ...
    pub share: S,
    /// ... where it rises by so much a volt of current.
    pub slope: S,
    /// By how much a volt before the last current must rise for a volt of it.
    pub open: S,
}

/// What a brush leaves of the current `free`, of which a resistance leaves 1 / `open`.
#[inline(always)]
pub(crate) fn behind<S: Scalar>(
    c: &Coefficients<S>,
    s: &Behind<S>,
    [u, free]: [S; 2],
    about: &About<S>,
    open: S,
    drive: &Drive<S>,
) -> End<S> {
    let (one, half) = (S::one(), S::lit(0.5));
    let (full, knee) = (c.uv * drive.brush, drive.brush_knee);
    let middle = s.half_way.mul_add(u - about.current, about.current);
    let middle_size = middle.hypot(knee);
    let first = (u + middle) / (about.size + middle_size);
    let rest = without(free, full * s.half * first);
    let last = half - s.half;
    let mut end = End { current: about.current, first, share: S::zero(), slope: S::zero(), open };
    for _ in 0..2 {
        let (size, old) = (end.current.hypot(knee), end.current);
        let (per_sum, per_size) = (one / (middle_size + size), one / size);
        end.share = old * per_size;
        end.slope = per_size * (one - end.share * end.share);
        let second = (middle + old) * per_sum;
        let lack = rest - open.mul_add(old, full * half.mul_add(second, last * end.share));
        let slope = (half * per_sum).mul_add(one - second * end.share, last * end.slope);
        end.open = full.mul_add(slope, open);
        end.current += lack / end.open;
    }
    end
}

/// The current `free` after a loss before the step's end, which stops it and never turns it round.
#[inline(always)]
fn without<S: Scalar>(free: S, lost: S) -> S {
    free - lost.clamp(-free.abs(), free.abs())
}
