//! The commands that can be run next, so that they can be pasted.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::findings::{NextStep, Standing};
use crate::log::{ReadArgs, guess};

/// What can be done next, in words and as a command.
pub fn then(what: &str, command: &str) -> String {
    format!("next: {what} with\n  {command}\n")
}

/// `path` as a shell takes it.
pub fn shell(path: &Path) -> String {
    guess::quoted(&path.display().to_string())
}

/// What to do next, with the commands that do it.
pub fn told(step: &NextStep, model: Option<&Path>, logs: &[PathBuf]) -> String {
    let label = step.label.to_lowercase();
    // What is to be mended by an option or in the log was told before; the command only shows it.
    let what = match &step.place {
        Some(place) => format!("{label}, as told above of {place}; see it on the page"),
        None => label,
    };
    then(&what, &commands(step, model, logs).join("\n  "))
}

/// The commands of the next step, to be pasted where the files are few. A model that was not written is written first.
pub fn commands(step: &NextStep, model: Option<&Path>, logs: &[PathBuf]) -> Vec<String> {
    let all: Vec<String> = logs.iter().map(|log| shell(log)).collect();
    let all = all.join(" ");
    let logs = if all.is_empty() || all.len() > LONGEST { "LOG...".to_owned() } else { all };
    let given = || std::env::args().skip(1);
    let keep = (model.is_none() && step.command.contains("MODEL")).then(|| keeping(given()));
    let model = model.map_or_else(|| MODEL.to_owned(), shell);
    let command = step.command.replace("LOG...", &(logs + &reading_again(given()))).replace("MODEL", &model);
    keep.into_iter().flatten().chain([command]).collect()
}

/// The name of a model that has none.
const MODEL: &str = "model.json";

/// The command of these `words`, but that it writes its model; none for one that is too long to repeat.
fn keeping(words: impl Iterator<Item = String>) -> Option<String> {
    let mut all = vec!["motorlens".to_owned()];
    let mut words = words.peekable();
    // Where a report or a programme goes is no place for a model, and what a programme may ask of the motor is not asked again.
    let others: &[&str] = match words.peek().map(String::as_str) {
        Some("report") => &["-o", "--out"],
        Some("plan") => &["-o", "--out", "--volts", "--seconds"],
        _ => &[],
    };
    let other = |word: &str| others.contains(&word);
    while let Some(word) = words.next() {
        match word.as_str() {
            "report" | "plan" if all.len() == 1 => all.push("discover".into()),
            option if other(option) => drop(words.next()),
            option if option.split_once('=').is_some_and(|(option, _)| other(option)) => {}
            _ => all.push(guess::quoted(&word)),
        }
    }
    let text = format!("{} --out {MODEL}", all.join(" "));
    (text.len() <= 2 * LONGEST).then_some(text)
}

/// The options of this command that say how its logs are read, each with a blank before it.
pub fn as_read() -> String {
    reading_again(std::env::args().skip(1))
}

/// Those of the words of a command that say how logs are read and judged, as a shell takes them, each with a blank before it: the next verb
/// needs them again.
fn reading_again(mut words: impl Iterator<Item = String>) -> String {
    let reading = ReadArgs::augment_args(clap::Command::new("motorlens"));
    let reads = |option: &str| {
        let long =
            |arg: &clap::Arg| arg.get_long().is_some_and(|long| option.strip_prefix("--") == Some(long));
        let short = |arg: &clap::Arg| arg.get_short().is_some_and(|short| option == format!("-{short}"));
        option == "--effect-file" || reading.get_arguments().any(|arg| long(arg) || short(arg))
    };
    let mut again = String::new();
    while let Some(word) = words.next() {
        let option = word.split('=').next().unwrap_or_default();
        if !reads(option) {
            continue;
        }
        again += &format!(" {}", guess::quoted(&word));
        if option == word {
            again += &words.next().map_or_else(String::new, |value| format!(" {}", guess::quoted(&value)));
        }
    }
    again
}

/// More characters of file names than these are not repeated.
const LONGEST: usize = 400;

/// What to do next, and what to go on with once a data problem that comes first is mended.
pub fn steps(standing: &Standing, model: Option<&Path>, logs: &[PathBuf]) -> String {
    let later = standing.also.as_ref().map(|also| told(also, model, logs));
    let later = later.map_or_else(String::new, |text| text.replacen("next:", "after that:", 1));
    told(&standing.next, model, logs) + &later
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings::Action;

    #[test]
    fn the_next_command_can_be_pasted() {
        let step = NextStep::new(Action::Diagnose, None);
        let told = told(&step, Some(Path::new("base.json")), &["a.csv".into(), "b.csv".into()]);
        assert_eq!(told, "next: find what is missing with\n  motorlens diagnose base.json a.csv b.csv\n");
    }

    #[test]
    fn a_data_problem_is_mended_as_its_text_says_and_the_page_shows_it() {
        let place = Some("run.csv, column voltage_v".to_owned());
        let label = "Give the voltage that drove the motor".to_owned();
        let step = NextStep { place, label, ..NextStep::new(Action::Data, None) };
        assert_eq!(
            told(&step, None, &["run.csv".into()]),
            "next: give the voltage that drove the motor, as told above of run.csv, column voltage_v; see it on the page with\n  \
             motorlens serve run.csv\n"
        );
    }

    #[test]
    fn the_next_command_reads_the_logs_as_this_one_did() {
        let given =
            "discover a.csv --map time=t:ms,duty=pwm:255 -v b.csv --supply-volts=11.1 --out m.json --quiet";
        let again = reading_again(given.split(' ').map(str::to_owned));
        assert_eq!(again, " --map time=t:ms,duty=pwm:255 -v b.csv --supply-volts=11.1");
        let spaced = ["--motor", "my motor.toml", "a.csv", "--skip", "1..2"].map(str::to_owned);
        assert_eq!(reading_again(spaced.into_iter()), " --motor \"my motor.toml\" --skip 1..2");
    }

    #[test]
    fn a_model_that_was_not_written_is_written_before_it_is_used() {
        let keep = |words: &str| keeping(words.split(' ').map(str::to_owned)).unwrap();
        let fitted = keep("fit a.csv -e coulomb --motor motor.toml");
        assert_eq!(fitted, "motorlens fit a.csv -e coulomb --motor motor.toml --out model.json");
        for report in ["report a.csv -o r.html -v b.csv", "report a.csv --out=r.html -v b.csv"] {
            assert_eq!(keep(report), "motorlens discover a.csv -v b.csv --out model.json");
        }
        let planned = keep("plan a.csv --volts=6 --seconds 4 -o programme.json -v b.csv");
        assert_eq!(planned, "motorlens discover a.csv -v b.csv --out model.json");
    }
}
