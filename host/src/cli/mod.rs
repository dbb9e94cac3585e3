//! The command line: one file a verb, each thin. A verb reads its options, calls the library and hands the
//! answer to the [`Console`], which knows whether a person or a program listens.
//!
//! To add a verb: a file with `Args` and `run`, its `mod` line, and its rows in `Verb`.

mod add;
#[cfg(feature = "device")]
mod capture;
mod compare;
mod console;
mod demo;
#[cfg(feature = "device")]
mod device;
#[cfg(feature = "device")]
mod device_check;
mod diagnose;
mod discover;
mod effects;
mod exam;
mod export;
mod fit;
mod help;
mod input;
#[cfg(feature = "device")]
mod interrupt;
#[cfg(feature = "device")]
mod listen;
mod next;
mod paper;
mod plan;
mod prose;
mod report;
mod same;
#[cfg(feature = "serve")]
mod serve;
mod shell;
mod simulate;
#[cfg(feature = "device")]
mod strip;
mod table;
mod tune;
mod watch;
mod wrap;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

pub use console::Console;

use crate::error::{Error, Result};
use crate::formula::Library;
use crate::log::guess::{self, Proposal};
use crate::log::halves;

/// Finds out what a motor model is missing: fit, compare, diagnose, add, and watch the error fall.
#[derive(Debug, Parser)]
#[command(name = "motorlens", version, arg_required_else_help = false)]
struct Cli {
    /// Print one JSON document on standard output and nothing else there
    #[arg(short, long, global = true)]
    json: bool,
    /// Print no progress and no prose, only errors
    #[arg(short, long, global = true)]
    quiet: bool,
    /// An effect of your own: a text file with name, port, formula and parameters; repeatable
    #[arg(long, global = true, value_name = "FILE.toml")]
    effect_file: Vec<PathBuf>,
    #[command(subcommand)]
    verb: Option<Verb>,
}

/// What can be done.
#[derive(Debug, Subcommand)]
enum Verb {
    /// The whole loop in seconds, on a simulated motor with a hidden effect (what runs without a verb)
    Demo(demo::Args),
    /// Make logs from the virtual motor, with effects that are named or hidden
    Simulate(crate::simulate::SimulateArgs),
    /// Tell which effects a simulation has
    Reveal(crate::simulate::RevealArgs),
    /// Find the parameters of a model with given effects
    Fit(fit::Args),
    /// Hold a model against measurements and show where it fails
    Compare(compare::Args),
    /// Rank the effects that a model is missing
    Diagnose(diagnose::Args),
    /// Add one effect to a model, refit, and show whether it is worth it
    Add(add::Args),
    /// The loop by itself: fit, diagnose, add, until nothing is worth adding
    Discover(discover::Args),
    /// Choose the excitation that would tell apart what these logs cannot
    Plan(plan::Args),
    /// List the effects: equations, parameters, units, signatures
    Effects(effects::Args),
    /// The loop by itself, told in one HTML file that opens without a network
    Report(report::Args),
    /// Run programmes on the board and save the logs
    #[cfg(feature = "device")]
    Capture(capture::Args),
    /// Ask the board, fit on it, stop it, flash it
    #[cfg(feature = "device")]
    Device(device::Args),
    /// The five steps of the work, live in a browser on this machine
    #[cfg(feature = "serve")]
    Serve(serve::Args),
    /// Write a model for MuJoCo, Modelica, Python, C, FMI, WPILib, BAM, Isaac Lab or URDF
    Export(export::Args),
    /// Gains for velocity and position from a model, and what its effects cost in tracking
    Tune(tune::Args),
    /// Tell whether two sets of records come from one motor, and which parameters differ
    Same(same::Args),
    /// Print the completion script for a shell
    Completions(shell::Completions),
    /// Write the manual pages
    Man(shell::Man),
    /// Hide effects in virtual motors and count how often the loop finds them
    Exam(exam::Args),
    /// The paper's run with one command, and what the paper does not say
    Paper(crate::paper::PaperArgs),
}

impl Verb {
    fn run(&self, library: &Library, console: &Console) -> Result<()> {
        match self {
            Self::Demo(args) => demo::run(args, library, console),
            Self::Simulate(args) => simulate::run(args, library, console),
            Self::Reveal(args) => simulate::reveal(args, console),
            Self::Fit(args) => fit::run(args, library, console),
            Self::Compare(args) => compare::run(args, library, console),
            Self::Diagnose(args) => diagnose::run(args, library, console),
            Self::Add(args) => add::run(args, library, console),
            Self::Discover(args) => discover::run(args, library, console),
            Self::Plan(args) => plan::run(args, library, console),
            Self::Effects(args) => effects::run(args, library, console),
            Self::Report(args) => report::run(args, library, console),
            #[cfg(feature = "device")]
            Self::Capture(args) => capture::run(args, console),
            #[cfg(feature = "device")]
            Self::Device(args) => device::run(args, console),
            #[cfg(feature = "serve")]
            Self::Serve(args) => serve::run(args, library, console),
            Self::Export(args) => export::run(args, console),
            Self::Tune(args) => tune::run(args, console),
            Self::Same(args) => same::run(args, library, console),
            Self::Completions(args) => shell::completions(args, console),
            Self::Man(args) => shell::man(args, console),
            Self::Exam(args) => exam::run(args, console),
            Self::Paper(args) => paper::run(args, library, console),
        }
    }
}

/// The whole command line, as documents and tests look at it.
pub fn command() -> clap::Command {
    Cli::command()
}

/// Runs the program on the arguments of the process.
///
/// Exit status: 0 done, 2 wrong usage, 3 bad input, 4 the device, 1 the machine itself.
pub fn main() -> ExitCode {
    let parsed = help::with_whole_examples(command()).try_get_matches();
    let read = |given| Cli::from_arg_matches(&given).map_err(|error| error.format(&mut command()));
    let cli = match parsed.and_then(read) {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    let console = Console::new(cli.json, cli.quiet);
    let verb = cli.verb.unwrap_or_else(|| Verb::Demo(demo::Args::default()));
    match library(&cli.effect_file).and_then(|library| verb.run(&library, &console)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            console.fail(&error);
            if let Error::BadInput(fault) = &error
                && let Some(proposal) = &fault.proposal
            {
                let given = std::env::args().skip(1);
                console.say(format!(
                    "  so the whole command is\n    {}",
                    with_proposal(given, &fault.file, proposal)
                ));
            }
            ExitCode::from(error.exit_code())
        }
    }
}

/// The command that was `given`, with the mapping of `proposal` in the place of its own and what that assumes beside it; where `file` is two
/// files that were given as two, they are given as one.
fn with_proposal(given: impl Iterator<Item = String>, file: &Path, proposal: &Proposal) -> String {
    let mut words = vec!["motorlens".to_owned()];
    let mut given: Vec<String> = given.collect();
    let pair = file.display().to_string();
    let place = |half: &str| given.iter().position(|word| word == half);
    if let Some((one, other)) = halves(&pair).find_map(|(one, other)| place(one).zip(place(other))) {
        given[one.min(other)].clone_from(&pair);
        given.remove(one.max(other));
    }
    let mut given = given.into_iter();
    while let Some(word) = given.next() {
        if word == "--map" {
            let _value = given.next();
        } else if !word.starts_with("--map=") {
            words.push(guess::quoted(&word));
        }
    }
    words.push(proposal.options());
    words.join(" ")
}

/// What every verb may use: the library's effects, and those in these files.
fn library(files: &[PathBuf]) -> Result<Library> {
    files.iter().try_fold(Library::default(), |library, path| library.with_file(path))
}

/// What clap could not parse; help and version arrive here too.
fn refuse(error: &clap::Error) -> ExitCode {
    help::print(error);
    if error.use_stderr() && std::env::args_os().any(|a| a == "--json") {
        let text = error.render().to_string();
        let why = text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        Console::new(true, true).fail(&Error::usage(why, "see motorlens --help"));
    }
    ExitCode::from(error.exit_code() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_files_that_are_one_log_are_given_as_one_in_the_proposed_command() {
        let proposal = Proposal { map: "time=t:s".into(), ..Proposal::default() };
        let command = |given: &str, file: &str| {
            with_proposal(given.split(' ').map(str::to_owned), Path::new(file), &proposal)
        };
        for (given, file, expected) in [
            (
                "fit in.csv out.csv --out m",
                "in.csv+out.csv",
                "motorlens fit in.csv+out.csv --out m --map time=t:s",
            ),
            ("fit out.csv in.csv", "in.csv+out.csv", "motorlens fit in.csv+out.csv --map time=t:s"),
            ("fit in.csv+out.csv", "in.csv+out.csv", "motorlens fit in.csv+out.csv --map time=t:s"),
            ("fit log.csv --map x", "log.csv", "motorlens fit log.csv --map time=t:s"),
        ] {
            assert_eq!(command(given, file), expected);
        }
    }

    #[test]
    fn every_verb_and_everything_that_a_verb_can_do_has_an_example_in_its_help() {
        fn without(command: &clap::Command, path: &str) -> Vec<String> {
            let of = |below: &clap::Command| {
                let path = format!("{path} {}", below.get_name());
                let help = below.get_after_help().map(ToString::to_string).unwrap_or_default();
                let own = (!help.contains(&format!("\n  {path} "))).then(|| path.clone());
                own.into_iter().chain(without(below, &path)).collect::<Vec<_>>()
            };
            command.get_subcommands().flat_map(of).collect()
        }
        assert_eq!(without(&super::command(), "motorlens"), Vec::<String>::new());
    }

    #[test]
    fn the_options_of_all_verbs_are_consistent() {
        super::command().debug_assert();
    }
}
