//! What is asked of a gain before a further effect is accepted ([`super::fitted::Fitted::beats`]).

use std::f64::consts::LN_2;

use motorlens_shared::effects::Kind;

use super::gain::Gain;
use crate::fit::instants::usual;

/// A gain that is worth more parameters: natural logarithms (a factor of 20,000 in likelihood) ...
pub(crate) const WORTH: f64 = 10.0;
/// ... and standard errors: beyond chance for the twenty effects that are tried at once (2.6 are 0.5 % of a normal distribution).
pub(crate) const SURE: f64 = 2.6;

/// Standard errors that `blocks` blocks have to show: those of a normal distribution as a Student t distribution has them, since so few
/// blocks know their own scatter only roughly (first term of the Cornish-Fisher expansion).
pub(super) fn sure_enough(blocks: usize) -> f64 {
    SURE + (SURE.powi(3) + SURE) / (4.0 * blocks.saturating_sub(1).max(1) as f64)
}

/// A gain of so many natural logarithms, and of this share of all that is explained so far, has to be only [`LIKELY`]. Of 120 plain motors,
/// half of them disturbed by torques that last 50 ms, an effect gained 40 in one and less in all others (docs/DIAGNOSIS.md). Half of it will do
/// where the simulation error falls as well.
const LARGE: (f64, f64) = (50.0, 0.1);
/// Standard errors: 5 % of a normal distribution.
pub(crate) const LIKELY: f64 = 1.64;

/// Whether `gain`, the best of those at so many `places`, is so many natural logarithms, and this share of `all` that are explained with it.
fn is_beyond(gain: Gain, (nats, share): (f64, f64), all: f64, places: usize) -> bool {
    gain.total > (nats + (places as f64).ln()).max(share * all)
}

/// Whether it is worth a further equation: what is missing of [`SHARE`] must be made up for by the simulation error, which surely `falls` by so
/// many factors of e; where that halves, any share will do. It is asked only where it decides: it takes a fit to each part of the records.
pub(super) fn is_worth(gain: Gain, all: f64, places: usize, falls: impl FnOnce() -> f64) -> bool {
    let explains = |share: f64| is_beyond(gain, (WORTH, share), all, places);
    explains(SHARE) || explains(0.0) && explains(SHARE * (1.0 - falls() / LN_2).clamp(0.0, 1.0))
}

/// The same by the gain alone.
pub(super) fn is_worth_alone(gain: Gain, all: f64, places: usize) -> bool {
    is_worth(gain, all, places, || 0.0)
}

/// Whether it is so much that it has to be only likely; where the simulation error surely `falls` too (factors of e), half as much will do.
pub(super) fn is_large(gain: Gain, all: f64, places: usize, falls: impl FnOnce() -> f64) -> bool {
    let (nats, share) = LARGE;
    is_beyond(gain, LARGE, all, places) || is_beyond(gain, (0.5 * nats, share), all, places) && falls() > 0.0
}

/// What the likelihood has to gain by dry friction, a delay or a filter where it is not sure in many blocks, natural logarithms. Nearly every motor has
/// the one and nearly every log the others, and a test may have one block that tells: lateness shows only where the voltage jumps, friction where
/// the shaft is slow. Of 120 plain motors, half of them disturbed, lateness gained more in one (docs/DIAGNOSIS.md).
const EXPECTED: f64 = 2.0 * WORTH;

/// Whether nearly every motor or log has it: dry friction, on which most equations of the library build, and what is only late.
pub(super) fn is_expected(kind: Kind) -> bool {
    kind.spec().is_late() || usual(Kind::ALL.iter().copied()) == Some(kind)
}

/// Whether it is enough for what is expected.
pub(super) fn is_enough_for_expected(gain: Gain, all: f64) -> bool {
    is_beyond(gain, (EXPECTED, SHARE), all, 1)
}

/// Standard errors that the best of so many `places` has to show where one alone has to show `sure`: each of them may pass by chance so many
/// times less often (C. Bonferroni, 1936; the tail of a normal distribution falls like exp(-z^2 / 2)).
pub(super) fn best_of(places: usize, sure: f64) -> f64 {
    (sure * sure + 2.0 * (places as f64).ln()).sqrt()
}

/// Standard errors that a rise of the cross-validated simulation error beyond its own standard error costs, for each factor of e: two for a
/// tenth.
pub(super) const RISE: f64 = 20.0;

/// A torque or a voltage below this share of the highest voltage is a trifle, whatever it depends on: a converter of ten bits knows no voltage
/// better, and no equation of a motor is as exact.
pub(crate) const KNOWN_VOLTAGE: f64 = 1e-3;

/// Whether all that `kind` adds with `parameters` are voltages that are a trifle beside the `highest`, V. A reading rounded to a hundredth of a
/// degree gave plain motors dead zones of 40 microvolts, beyond doubt.
pub(super) fn is_trifle(kind: Kind, parameters: &[f64], highest: f64) -> bool {
    let mut sizes = kind.spec().parameters.iter().zip(parameters).filter(|(of, _)| of.strength).peekable();
    // What has no size is something.
    sizes.peek().is_some() && sizes.all(|(of, size)| of.unit == "V" && size.abs() < KNOWN_VOLTAGE * highest)
}

/// A model does not do as well as another where its cross-validated simulation error is higher by this factor of e, a tenth, and does better
/// where it is surely lower by it.
pub(super) const AS_GOOD: f64 = 0.1;

/// A further equation must explain this share of all that is explained so far: the equations are idealised, and what the form of one misses,
/// another must not be called in for (proportion of deviance explained: A. Cameron and F. Windmeijer, *Journal of Econometrics* 77, 1997).
pub(super) const SHARE: f64 = 0.05;

#[cfg(test)]
mod tests {
    use super::*;

    /// 500 of 20,000 natural logarithms, a fortieth: beside a pendulum's gravity friction comes to no more, and leaves half of the error.
    #[test]
    fn what_a_further_effect_lacks_of_its_share_a_sure_fall_of_the_simulation_error_makes_up_for() {
        let gain = Gain { total: 500.0, sure: 9.0 };
        assert!(!is_worth_alone(gain, 20e3, 1), "what the form of the first may miss");
        assert!(!is_worth(gain, 20e3, 1, || -0.5), "a rise takes nothing off");
        assert!(is_worth(gain, 20e3, 1, || 0.53));
        assert!(is_worth(gain, 1e6, 1, || LN_2), "half of the error is no form");
        assert!(is_worth_alone(gain, 9e3, 1), "a twentieth");
    }

    #[test]
    fn a_few_nats_are_worth_nothing_and_the_best_of_many_places_has_to_gain_more() {
        let gain = Gain { total: WORTH + 1.0, sure: 9.0 };
        assert!(is_worth(gain, 11.0, 1, || 1.0) && !is_worth(gain, 11.0, 24, || 1.0));
        assert!(!is_worth(Gain { total: WORTH - 1.0, ..gain }, 9.0, 1, || 1.0));
    }

    #[test]
    fn half_of_a_large_gain_is_large_where_the_simulation_error_falls_with_it() {
        let gain = Gain { total: 0.7 * LARGE.0, sure: 2.0 };
        assert!(is_large(gain, gain.total, 1, || 0.05));
        assert!(!is_large(gain, gain.total, 1, || -0.05), "the simulation does not agree");
        assert!(is_large(Gain { total: 2.0 * gain.total, ..gain }, 2.0 * gain.total, 1, || -0.05));
        assert!(
            !is_large(gain, 20.0 * gain.total, 1, || 0.05),
            "less than the form of what is there may miss"
        );
    }

    #[test]
    fn voltages_below_a_thousandth_of_the_highest_are_a_trifle_and_sizes_in_other_units_are_none() {
        assert!(is_trifle(Kind::DeadZone, &[5e-5, 1e-4], 8.0));
        assert!(!is_trifle(Kind::DeadZone, &[0.05, 1e-4], 8.0));
        assert!(
            !is_trifle(Kind::Delay, &[1e-5], 8.0)
                && !is_trifle(Kind::Compliance, &[20.0, 0.1, 0.05, 0.0], 8.0)
        );
    }

    #[test]
    fn friction_and_lateness_are_expected_and_have_to_gain_much_rather_than_surely() {
        assert!([Kind::Coulomb, Kind::Delay, Kind::SensorLag].map(is_expected).iter().all(|is| *is));
        let others = [Kind::Stribeck, Kind::DeadZone, Kind::Gravity, Kind::Cogging, Kind::LoadFriction];
        assert!(!others.map(is_expected).contains(&true));
        // A servo's friction beside its pendulum.
        let gain = Gain { total: 47.0, sure: 1.3 };
        assert!(is_enough_for_expected(gain, 155.0));
        assert!(!is_enough_for_expected(Gain { total: 19.0, ..gain }, 155.0));
        assert!(!is_enough_for_expected(gain, 1e3), "less than the form of what is there may miss");
    }

    #[test]
    fn few_blocks_and_many_places_ask_for_more_standard_errors() {
        assert!(sure_enough(5) > sure_enough(50) && sure_enough(1000) < SURE + 0.01);
        assert!((best_of(24, SURE) - 3.6).abs() < 0.05);
    }
}
