//! The verdict, from plain numbers: one word, one sentence, and what to do next.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::standing::Doubted;
use super::yardstick::is_known;
use crate::compare::measures::Measures;
use crate::compare::rise::Rise;
use crate::report::figure::in_words;
use crate::select::adequacy::{Adequacy, LITTLE};
use crate::sentence::{capital, listed};

/// Multiples of the noise level above which nothing is called explained that is not a disturbance by all that these records show.
pub const MANY: f64 = 10.0;
/// ... and above which a fit that nobody has diagnosed is doubted.
const CLOSE: f64 = 1.5;
/// What a disturbance may leave of the motion within a second: a model that misses more of it than this explains part of it at most.
const STRAYED: f64 = 0.25;
/// What equations that are idealised may leave of it beside any noise: readings of a fine encoder show what nobody needs to know.
const IDEALISED: f64 = 0.005;

/// Said of more than the noise in which nothing was found: neither is sure, the noise of readings that were not taken twice least of all.
const EITHER: &str = ", either more noise than estimated or something that the library lacks";

/// How a diagnosis ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing is left that these data can show.
    Explained,
    /// The accepted effects lower the error, and more than noise is left.
    PartlyExplained,
    /// Much is left, and no effect of the library helps.
    Unexplained,
    /// The data must be mended first.
    BadData,
}

impl Verdict {
    /// In two words, for a badge.
    pub fn badge(self) -> &'static str {
        match self {
            Self::Explained => "Explained",
            Self::PartlyExplained => "Partly explained",
            Self::Unexplained => "Unexplained",
            Self::BadData => "Data problem",
        }
    }
}

/// The errors that a verdict rests on, rms of the simulation in the measured unit, all of the same records.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    /// Of the base model.
    pub base: f64,
    /// Of the accepted model.
    pub model: f64,
    /// Noise level.
    pub noise: f64,
    /// Share of the motion that the accepted model misses: its error over the rms of what was measured about its mean.
    pub missed: f64,
    /// Share of what the motor does in a second that it misses.
    pub strayed: f64,
    /// How many times nearer a simpler model comes to them, where one does by much; 1 where none does.
    pub beaten: f64,
}

impl Errors {
    /// Of models with the errors `base` and `model` on the same records, which have `noise`.
    pub fn of(base: &Measures, model: &Measures, noise: f64) -> Self {
        Self {
            base: base.rmse,
            model: model.rmse,
            noise,
            missed: model.missed(),
            strayed: model.strayed,
            beaten: 1.0,
        }
    }

    /// Error of the accepted model in multiples of the noise level; none where the readings are too smooth to have one.
    pub fn left_over(&self) -> Option<f64> {
        is_known(self.noise, self.model, self.missed).then(|| self.model / self.noise)
    }

    /// Fraction of the error above the noise level that the effects explain: negative where the error rose, none where
    /// the base model left no more than noise.
    pub fn explained_share(&self) -> Option<f64> {
        let excess = self.base - self.noise;
        (excess > 0.0).then(|| ((self.base - self.model) / excess).min(1.0))
    }

    /// The verdict on `effects` accepted effects, which leave what `left` says.
    pub fn verdict(&self, effects: usize, left: Adequacy) -> Verdict {
        let beside = match left {
            Adequacy::Something => false,
            // What meets the records that judge worse than something simpler does is no explanation of them, whatever is left.
            _ if self.beaten > 1.0 => false,
            Adequacy::Noise | Adequacy::Trifle(_) => self.is_close(),
            Adequacy::Disturbance(_) => self.is_few() || self.strayed <= STRAYED,
        };
        if beside {
            Verdict::Explained
        } else if effects > 0 && self.model < self.base {
            Verdict::PartlyExplained
        } else {
            Verdict::Unexplained
        }
    }

    /// `verdict` in a few words, for a badge: what drives a model far from the measurement is no small print.
    pub fn badge(&self, verdict: Verdict, left: Adequacy) -> &'static str {
        match (verdict, left) {
            (Verdict::Explained, Adequacy::Disturbance(_)) if !self.is_few() => {
                "Explained but for a disturbance"
            }
            _ => verdict.badge(),
        }
    }

    /// Whether the model misses no more of what the motor does than idealised equations must.
    fn is_idealised(&self) -> bool {
        self.strayed <= IDEALISED
    }

    /// Whether the model leaves few times the noise.
    fn is_few(&self) -> bool {
        self.left_over().is_some_and(|n| n <= MANY)
    }

    /// Whether the model leaves so little that it can be used.
    pub(super) fn is_close(&self) -> bool {
        self.is_few() || self.is_idealised()
    }

    /// Said of data that must be mended first.
    pub const BAD_DATA: &str = "The data must be mended before a model can be judged";

    /// What is left, in the one unit of all sentences.
    fn left(&self) -> String {
        self.left_over().map_or_else(
            || format!("{:.1} % of the motion (the noise is too small to be known)", 100.0 * self.missed),
            multiple,
        )
    }

    /// The verdict on `effects`, as a sentence names them, in one sentence without its full stop; `left` is what they leave.
    pub fn headline<S: AsRef<str>>(&self, effects: &[S], verdict: Verdict, left: Adequacy) -> String {
        match verdict {
            Verdict::BadData => Self::BAD_DATA.into(),
            Verdict::Explained => self.explained(effects, left),
            _ if effects.is_empty() => {
                format!("No effect of the library helps; what is left is {}{}", self.left(), self.and_yet())
            }
            _ => self.share_of(effects) + &self.and_yet(),
        }
    }

    /// Why so little is not called explained, said where the numbers alone would contradict the verdict.
    fn and_yet(&self) -> String {
        if self.beaten > 1.0 {
            return format!(", and a simpler model comes {:.1} times nearer", self.beaten);
        }
        let little = self.left_over().is_some_and(|n| n <= CLOSE);
        if little { ", and still shows a pattern".to_owned() } else { String::new() }
    }

    /// What `effects` explain beside what they leave.
    fn explained<S: AsRef<str>>(&self, effects: &[S], left: Adequacy) -> String {
        let beside = match left {
            Adequacy::Something | Adequacy::Noise => None,
            Adequacy::Disturbance(volts) => Some(format!(
                "depends on nothing that was measured: a disturbance of {}",
                in_words(volts, "V")
            )),
            Adequacy::Trifle(volts) => Some(format!(
                "comes to a torque of {}, less than a thousandth of the highest voltage",
                in_words(volts, "V")
            )),
        };
        // The shares are those of whole simulations, which a disturbance makes drift.
        let rises = self.explained_share().is_some_and(|share| share < 0.0);
        let left = self.left();
        let either = if self.left_over().is_some_and(|n| n > LITTLE) { EITHER } else { "" };
        let (names, verb) = subject(effects);
        match beside {
            None if effects.is_empty() => {
                let of_library = ", for these records show none of its effects";
                let none =
                    if either.is_empty() { ", and these records show no missing effect" } else { of_library };
                format!("The base model leaves {left}{either}{none}")
            }
            Some(is) if effects.is_empty() => format!("The base model leaves {left}, which {is}"),
            None if rises => capital(&format!(
                "{names} {verb} all that repeats itself at any time scale; a disturbance drives whole records to {left}"
            )),
            Some(is) if rises => {
                capital(&format!("{names} {verb} all but what {is}, which drives whole records to {left}"))
            }
            None => self.share_of(effects) + either,
            Some(is) => format!("{}, and {is}", self.share_of(effects)),
        }
    }

    /// How far a model with `effects` has come while nobody has looked for what it is missing, or with a `candidate` to add.
    pub fn so_far<S: AsRef<str>>(&self, effects: &[S], candidate: Option<Kind>) -> String {
        let said = if effects.is_empty() {
            format!("The base model leaves {}", self.left())
        } else if self.base == self.model {
            format!("The model with {} leaves {}", subject(effects).0, self.left())
        } else {
            self.share_of(effects)
        };
        said + match self.left_over() {
            Some(n) if n > MANY && self.is_idealised() => ": as close as the equations of a motor come",
            Some(n) if n > MANY => ": not enough",
            Some(n) if n > CLOSE => ": something may be missing",
            // Who proposes an effect does not say in one breath that there is none to find.
            Some(_) if candidate.is_none() => ": about as little as the noise allows",
            Some(_) | None => "",
        } + &candidate.map_or(String::new(), |best| format!("; the best candidate is {}", spoken(best)))
    }

    /// Said where held-out data do not confirm the effect added last.
    pub fn doubt(&self, doubted: &Doubted) -> String {
        let (effect, left) = (spoken(doubted.effect), self.left());
        if !doubted.rises {
            return format!("Held-out data do not confirm {effect}; what is left is {left}");
        }
        let most = doubted.most.map_or_else(String::new, Rise::place);
        format!("With {effect} the error rises{most}; what is left is {left}")
    }

    fn share_of<S: AsRef<str>>(&self, effects: &[S]) -> String {
        let (names, verb) = subject(effects);
        let left = self.left();
        match self.explained_share() {
            Some(share) if share < 0.0 => format!("With {names} the error rises; what is left is {left}"),
            Some(share) => {
                let above = if self.left_over().is_some() { " above the noise" } else { "" };
                // All of it is not explained where several times the noise is left.
                let is_rounded = share >= 0.995 && self.left_over().is_some_and(|n| n > CLOSE);
                let share =
                    if is_rounded { "more than 99".to_owned() } else { format!("{:.0}", 100.0 * share) };
                capital(&format!("{names} {verb} {share} % of the error{above}; what is left is {left}"))
            }
            None => format!("With {names} what is left is {left}"),
        }
    }
}

/// The effect's name as a sentence has it.
pub fn spoken(effect: Kind) -> String {
    effect.name().replace('_', " ")
}

/// The names of `effects` as the subject of a sentence, and what it says of them.
fn subject<S: AsRef<str>>(effects: &[S]) -> (String, &'static str) {
    (listed(effects), if effects.len() == 1 { "explains" } else { "explain" })
}

/// So many times the noise, in words: two digits below ten.
pub fn multiple(n: f64) -> String {
    times(n) + " the noise"
}

/// The same on a plot whose axis says what is multiplied.
pub fn times(n: f64) -> String {
    if n < 9.95 { format!("{n:.1} x") } else { format!("{n:.0} x") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Adequacy = Adequacy::Noise;
    const SOME: Adequacy = Adequacy::Something;
    /// A model that follows the motion down to the noise.
    const PLAIN: Errors =
        Errors { base: 1.0, model: 1.0, noise: 1.0, missed: 0.01, strayed: 0.01, beaten: 1.0 };

    #[test]
    fn a_hundred_times_the_noise_is_never_called_explained() {
        let errors = Errors { base: 151.0, model: 151.0, ..PLAIN };
        assert_eq!(errors.verdict(0, ALL), Verdict::Unexplained);
        assert!(errors.headline::<&str>(&[], Verdict::Unexplained, SOME).ends_with("151 x the noise"));
    }

    #[test]
    fn the_share_and_what_is_left_are_in_one_sentence() {
        let errors = Errors { base: 101.0, model: 4.0, ..PLAIN };
        assert_eq!(errors.verdict(1, SOME), Verdict::PartlyExplained);
        let said = errors.headline(&["coulomb"], Verdict::PartlyExplained, SOME);
        assert_eq!(
            said,
            "Coulomb explains 97 % of the error above the noise; what is left is 4.0 x the noise"
        );
    }

    #[test]
    fn all_of_the_error_is_not_explained_where_five_times_the_noise_is_left() {
        let errors = Errors { base: 1001.0, model: 5.5, ..PLAIN };
        let said = errors.headline(&["delay"], Verdict::PartlyExplained, SOME);
        assert_eq!(
            said,
            "Delay explains more than 99 % of the error above the noise; what is left is 5.5 x the noise"
        );
        let said = Errors { model: 1.1, ..errors }.headline(&["delay"], Verdict::Explained, ALL);
        assert!(said.starts_with("Delay explains 100 %"), "{said}");
    }

    #[test]
    fn a_disturbance_that_hides_nothing_is_named_with_its_size() {
        let errors = Errors { base: 1001.0, model: 41.0, ..PLAIN };
        let left = Adequacy::Disturbance(0.05);
        assert_eq!(errors.verdict(1, left), Verdict::Explained);
        assert_eq!(errors.verdict(0, left), Verdict::Explained);
        let told = errors.headline(&["gravity (0.9 V)"], Verdict::Explained, left);
        let end = "what is left is 41 x the noise, and depends on nothing that was measured: a disturbance of 50 mV";
        assert_eq!(told, format!("Gravity (0.9 V) explains 96 % of the error above the noise; {end}"));
        let plain = errors.headline::<&str>(&[], Verdict::Explained, left);
        assert!(
            plain.starts_with("The base model leaves 41 x the noise, which depends on nothing"),
            "{plain}"
        );
    }

    #[test]
    fn a_disturbance_that_is_half_of_the_motion_is_not_called_explained() {
        let left = Adequacy::Disturbance(0.07);
        let errors = Errors { base: 6000.0, model: 1791.0, missed: 0.6, strayed: 0.3, ..PLAIN };
        assert_eq!(errors.verdict(1, left), Verdict::PartlyExplained);
        assert_eq!(Errors { strayed: 0.05, ..errors }.verdict(1, left), Verdict::Explained);
    }

    /// A fine encoder on a smooth motor: 99.8 % of the motion was called "not enough" at 146 times the noise.
    #[test]
    fn a_torque_smaller_than_the_voltage_is_known_is_told_and_not_held_against_the_model() {
        let left = Adequacy::Trifle(0.007);
        let errors =
            Errors { base: 0.49, model: 0.021, noise: 1.45e-4, missed: 3e-4, strayed: 2e-3, ..PLAIN };
        assert_eq!(errors.verdict(1, left), Verdict::Explained);
        let told = errors.headline(&["coulomb (74.9 mV)"], Verdict::Explained, left);
        let end = "what is left is 145 x the noise, and comes to a torque of 7 mV, less than a thousandth of the highest voltage";
        assert!(told.ends_with(end), "{told}");
        let elsewhere = Errors { strayed: 0.02, ..errors };
        assert_eq!(elsewhere.verdict(1, left), Verdict::PartlyExplained, "records kept out show more");
    }

    #[test]
    fn a_comparison_does_not_call_too_little_what_a_diagnosis_calls_explained() {
        let errors =
            Errors { base: 0.021, model: 0.021, noise: 1.45e-4, missed: 3e-4, strayed: 2e-3, ..PLAIN };
        let told = errors.so_far(&["coulomb"], None);
        assert!(told.ends_with("145 x the noise: as close as the equations of a motor come"), "{told}");
        assert!(errors.is_close() && !Errors { strayed: 0.02, ..errors }.is_close());
    }

    #[test]
    fn readings_too_smooth_to_have_a_noise_are_told_by_what_is_missed_of_the_motion() {
        let errors = Errors { base: 0.1, model: 0.006, noise: 1.7e-8, missed: 0.04, ..PLAIN };
        assert_eq!(errors.left_over(), None);
        let told = errors.headline(&["coulomb (0.4 V)"], Verdict::PartlyExplained, SOME);
        let said = "explains 94 % of the error; what is left is 4.0 % of the motion (the noise is too small to be known)";
        assert!(told.ends_with(said), "{told}");
    }

    /// A page said "explain 100 % ...; what is left is 0.8 x the noise" under "Partly explained", and nothing of why.
    #[test]
    fn where_little_is_left_a_verdict_that_doubts_it_says_why() {
        let errors = Errors { base: 3.0, model: 0.8, ..PLAIN };
        let told = errors.headline(&["delay", "coulomb"], errors.verdict(2, SOME), SOME);
        assert!(told.ends_with("what is left is 0.8 x the noise, and still shows a pattern"), "{told}");
        let told = errors.headline(&["delay", "coulomb"], errors.verdict(2, ALL), ALL);
        assert!(told.ends_with("0.8 x the noise"), "{told}");
    }

    /// A dead zone met the records kept out at 6 times the noise, with two more effects 9 times were "explained".
    #[test]
    fn a_model_that_a_simpler_one_beats_on_the_records_that_judge_explains_them_in_part() {
        let errors = Errors { base: 32.0, model: 8.7, beaten: 1.4, ..PLAIN };
        assert_eq!(errors.verdict(3, ALL), Verdict::PartlyExplained);
        let told = errors.headline(&["dead zone", "delay"], Verdict::PartlyExplained, ALL);
        assert!(told.ends_with("8.7 x the noise, and a simpler model comes 1.4 times nearer"), "{told}");
        assert_eq!(errors.verdict(3, Adequacy::Disturbance(0.05)), Verdict::PartlyExplained);
        assert_eq!(Errors { beaten: 1.0, ..errors }.verdict(3, ALL), Verdict::Explained);
    }

    /// A step that a duty of 8 bits drove was "explained" at 8.7 times the noise, with a hitch in it.
    #[test]
    fn more_than_the_noise_in_which_nothing_was_found_is_not_told_as_if_it_were_noise() {
        let errors = |model| Errors { base: 9.0, model, ..PLAIN };
        let told = errors(8.7).headline::<&str>(&[], Verdict::Explained, ALL);
        let open = "8.7 x the noise, either more noise than estimated or something that the library lacks";
        assert_eq!(told, format!("The base model leaves {open}, for these records show none of its effects"));
        assert!(errors(8.7).headline(&["delay"], Verdict::Explained, ALL).ends_with(open));
        let told = errors(1.2).headline::<&str>(&[], Verdict::Explained, ALL);
        assert_eq!(told, "The base model leaves 1.2 x the noise, and these records show no missing effect");
        assert!(!errors(1.2).headline(&["delay"], Verdict::Explained, ALL).contains("either"));
        assert!(!errors(8.7).headline(&["delay"], Verdict::PartlyExplained, SOME).contains("either"));
    }

    #[test]
    fn a_rise_is_called_a_rise() {
        let errors = Errors { base: 2.0, model: 3.0, ..PLAIN };
        assert_eq!(errors.verdict(1, SOME), Verdict::Unexplained);
        assert!(errors.headline(&["delay"], Verdict::Unexplained, SOME).contains("the error rises"));
    }
}
