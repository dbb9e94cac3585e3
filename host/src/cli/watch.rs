//! Progress on standard error, where a person watches.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use motorlens_shared::effects::Kind;

use super::{Console, prose, wrap};
use crate::diagnose::discover::Progress;
use crate::diagnose::ladder::Rung;

/// A bar, or nothing where nobody watches.
pub fn bar(console: &Console, length: u64, unit: &str) -> ProgressBar {
    if !console.shows_progress() {
        return ProgressBar::hidden();
    }
    let template = template(wrap::width(), unit);
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(length).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Narrower terminals have no room for a bar beside a message.
const NARROW: usize = 60;

/// What stands on the line of progress on a terminal of `width`.
fn template(width: usize, unit: &str) -> String {
    let told = format!("{{pos}}/{{len}} {unit} {{elapsed}} {{wide_msg}}");
    if width < NARROW { told } else { format!("{{bar:{}}} {told}", bar_within(width)) }
}

/// Columns of the bar on a terminal of `width`, which is not narrow: what the longest message leaves.
fn bar_within(width: usize) -> usize {
    let longest = "step 1: trying coulomb_asymmetric".len();
    width.saturating_sub(longest + " 21/21 effects 10s ".len()).min(30)
}

/// What is done in a step of a forward selection: `effect` is tried, or the best one fitted; in as many words as `width` has room for.
fn doing(width: usize, step: usize, effect: Option<Kind>) -> String {
    match (width < NARROW, effect) {
        (true, Some(effect)) => effect.to_string(),
        (true, None) => "fitting the best".into(),
        (false, Some(effect)) => format!("step {step}: trying {effect}"),
        (false, None) => format!("step {step}: fitting the best"),
    }
}

/// Watches a forward selection: the bar counts effects tried, every model of its sequence is a line that stays.
pub fn climb<'a>(
    console: &'a Console,
    bar: &'a ProgressBar,
    unit: &'static str,
) -> impl FnMut(Progress) + 'a {
    move |progress| match progress {
        Progress::Trying { depth, effect } => {
            // Effects are tried more than once; a bar that is full would say that all is done.
            bar.inc(1);
            if bar.length().is_some_and(|all| bar.position() > all) {
                bar.set_position(1);
            }
            let step = depth + 1;
            // The last one is tried in a moment; what takes long is what follows.
            let all_tried = bar.length() == Some(bar.position());
            bar.set_message(doing(wrap::width(), step, (!all_tried).then_some(effect)));
        }
        Progress::Anew(reading) => {
            if let Some(reading) = reading.speed_in_words() {
                bar.suspend(|| {
                    console.say(format!("Each speed turns out to be {reading}. With that, anew:"))
                });
            }
        }
        Progress::Rung(rung) => {
            // The step that ended is not said beside the bar of the next one.
            bar.set_position(0);
            bar.set_message("");
            bar.suspend(|| console.say(rung_line(&rung, unit)));
        }
    }
}

/// A line for a model of the sequence.
pub fn rung_line(rung: &Rung, unit: &str) -> String {
    errors(&prose::effects(&rung.effects), rung, unit)
}

/// The errors of a model that is called `name`.
pub fn errors(name: &str, rung: &Rung, unit: &str) -> String {
    let validation = rung
        .validation
        .map_or(String::new(), |v| format!("   validation {:>9} {unit}", prose::figure(v.rmse)));
    // The numbers stay on one line; many effects get one of their own before it.
    let wide = wrap::width().saturating_sub(47);
    let name = if name.len() > wide { format!("{name}\n{:wide$}", "") } else { format!("{name:<wide$}") };
    format!("{name} rmse {:>9} {unit}{validation}", prose::figure(rung.train.rmse))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_tried_is_read_to_its_end_on_a_narrow_terminal() {
        let longest = Kind::ALL.iter().map(|kind| format!("step 1: trying {kind}").len()).max().unwrap_or(0);
        for width in [60, 80] {
            let line = bar_within(width) + format!(" 21/21 effects 10s {}", " ".repeat(longest)).len();
            assert!(line <= width, "{line} columns of {width}");
        }
        assert_eq!(bar_within(200), 30);
    }

    #[test]
    fn a_phone_wide_terminal_shows_the_numbers_and_the_whole_name_and_no_bar() {
        let counted = template(40, "effects");
        assert!(counted.starts_with("{pos}/{len} effects"), "{counted}");
        assert!(template(60, "effects").starts_with("{bar:"));
        for kind in Kind::ALL {
            assert_eq!(doing(40, 1, Some(*kind)), kind.to_string());
            assert!("21/21 effects 10s ".len() + kind.to_string().len() <= 40, "{kind}");
        }
        assert_eq!(doing(80, 2, Some(Kind::Delay)), "step 2: trying delay");
        assert_eq!(
            [40, 80].map(|width| doing(width, 2, None)),
            ["fitting the best", "step 2: fitting the best"]
        );
    }
}
