//! Progress on standard error, where a person watches.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::{Console, prose};
use crate::diagnose::discover::Progress;
use crate::diagnose::ladder::Rung;

/// A bar, or nothing where nobody watches.
pub fn bar(console: &Console, length: u64, unit: &str) -> ProgressBar {
    if !console.shows_progress() {
        return ProgressBar::hidden();
    }
    let template = format!("{{bar:30}} {{pos}}/{{len}} {unit}  {{msg}}  {{elapsed}}");
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(length).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Watches a climb: the bar counts effects tried, every rung is a line that stays.
pub fn climb<'a>(
    console: &'a Console,
    bar: &'a ProgressBar,
    unit: &'static str,
) -> impl FnMut(Progress) + 'a {
    move |progress| match progress {
        Progress::Trying { depth, effect } => {
            bar.set_message(format!("trying {effect} on {depth} effects"));
            bar.inc(1);
        }
        Progress::Rung(rung) => {
            bar.set_position(0);
            bar.suspend(|| console.say(rung_line(&rung, unit)));
        }
    }
}

/// A rung of the ladder.
pub fn rung_line(rung: &Rung, unit: &str) -> String {
    let validation = rung
        .validation
        .map_or(String::new(), |v| format!("   unseen rmse {:>10} {unit}", prose::figure(v.rmse)));
    format!(
        "{:<44} rmse {:>10} {unit}{validation}",
        prose::effects(&rung.effects),
        prose::figure(rung.train.rmse)
    )
}
