//! Dry friction within a step: the instants at which it turns, holds and lets go.
//!
//! A friction that is held over a step leaves an error of first order at every reversal, and one as large at every
//! start, where the current still rises. Both instants follow from the motion of the step in closed form, so that no
//! finer steps are needed.

use crate::base::Coefficients;
use crate::scalar::Scalar;

/// New speed (rad/s) of a rotor that without friction would come from `w` to `free`, and twice the step's mean speed.
///
/// `u` and `w` are current (V) and speed at the beginning, `v` and `f` voltage and torque (V) of the step, `forward`
/// and `backward` the largest friction against either motion (V).
#[inline(always)]
pub fn turn<S: Scalar>(
    c: &Coefficients<S>,
    [u, w]: [S; 2],
    [v, f]: [S; 2],
    free: S,
    [forward, backward]: [S; 2],
) -> (S, S) {
    let zero = S::zero();
    let (less, more) = (c.wf * forward, c.wf * backward);
    // Where the speed passes through zero friction turns, and holds the rotor or opposes its new direction.
    let kept = S::pick_gt(w, zero, free - less, free + more);
    let passes = -(w * kept);
    let change = free - w;
    // Without a change of direction.
    let mut new = free - free.clamp(-more, less);
    let mut ends = w + new;
    if S::any_gt(passes, zero) {
        let after = kept / (kept - w);
        let turned = after * (change - change.clamp(-more, less));
        new = S::pick_gt(passes, zero, turned, new);
        ends = S::pick_gt(passes, zero, after.mul_add(turned - w, w), ends);
    }
    let rests = S::pick_gt(w.abs(), zero, zero, S::one());
    if S::any_gt(rests, zero) {
        let gone = let_go(c, u, [v, f], free, [forward, backward]);
        new = S::pick_gt(rests, zero, gone, new);
        ends = S::pick_gt(rests, zero, gone, ends);
    }
    (new, ends)
}

/// Speed at the end of a step from rest.
///
/// The current of a held rotor rises from u to v with the electrical time constant. Once it exceeds the friction F by
/// what other torques f leave of it, the rotor goes. With a = v + f - F, what is left over in the end, and
/// b = F - f - u, what lacks in the beginning, friction takes c tau_e (b - a ln(1 + b / a)) less of the speed than it
/// would over the whole step (c: acceleration per torque); the logarithm is taken as its Pade approximant of order 3.
#[inline(always)]
fn let_go<S: Scalar>(c: &Coefficients<S>, u: S, [v, f]: [S; 2], free: S, [forward, backward]: [S; 2]) -> S {
    let zero = S::zero();
    // The direction in which it would go: mirrored, so that there is one case.
    let push = v + f;
    let side = S::pick_gt(push, zero, S::one(), -S::one());
    let most = S::pick_gt(push, zero, forward, backward);
    let a = (side * push - most).max(zero);
    let b = (most - side * (f + u)).max(zero);
    let above = a - (a + b) * c.uu;
    let (aa, bb) = (a * a, b * b);
    let over = bb * (S::lit(30.0) * aa + b * (S::lit(25.0) * a + S::lit(3.0) * b));
    let under = aa * (S::lit(60.0) * a + S::lit(90.0) * b) + bb * (S::lit(36.0) * a + S::lit(3.0) * b);
    let spared = c.electric_impulse * over / S::pick_gt(under, zero, under, S::one());
    let new = side * (side * free - c.wf * most + spared).max(zero);
    S::pick_gt(above, zero, new, zero)
}

#[cfg(test)]
mod tests {
    use crate::effects::{Kind, Rig, testing::*};
    use crate::simulator::Simulator;
    use crate::step::State;

    /// Root mean square, over drives that reverse with and without a rest, of the angle's distance from fine steps.
    fn error(step_s: f64) -> f64 {
        let angles = |step_s: f64, level: f64| {
            let parts = (0.1 / step_s).round() as usize;
            let simulator = Simulator::new(&BASE, [(Kind::Coulomb, &[level][..])], &Rig { step_s, ..RIG });
            let mut motion = simulator.start(State::rest());
            [6.0, -5.3, 0.7, 4.1, 0.0, -6.2, 5.1].map(|v| {
                for _ in 0..parts {
                    simulator.advance(&mut motion, &[0.0, v], 1);
                }
                simulator.read(&motion)
            })
        };
        let square = |level: f64| {
            let (coarse, fine) = (angles(step_s, level), angles(2e-5, level));
            coarse.iter().zip(fine).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
        };
        ((1..30).map(|k| square(0.1 * f64::from(k))).sum::<f64>() / 203.0).sqrt()
    }

    /// Friction held to the end of every step would leave sixty times as much.
    #[test]
    fn reversals_and_starts_are_of_second_order_in_the_step() {
        let (coarse, fine) = (error(1e-3), error(2.5e-4));
        assert!(coarse < 1e-5 && fine < 0.1 * coarse, "{coarse:e} rad, {fine:e} rad");
    }
}
