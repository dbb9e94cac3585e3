//! The paper's whole run with one command: conventional fit, genetic algorithm, Figure 5, Table 1, Figure 7, Table 2,
//! and then what the paper leaves out.

mod choices;
pub(crate) mod data;
mod figures;
mod missing;
pub mod sines;
mod tables;
mod text;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use motorlens_shared::motor::{Combinations, PARAMETERS, PaperMotor, SYMBOLS};
use serde::Serialize;

pub use choices::Choice;
pub use missing::Missing;
pub use tables::{Errors, Growth, Row};

use crate::error::{BadInput, Error, Result};
use crate::formula::Library;
use crate::log::ReadArgs;
use crate::search::dispatch::Level;
use crate::search::{ConventionalResult, FastResult, STARTS};
use crate::search::{GaOptions, GaResult, RecordError, Records, Start, conventional_on, fast_on, genetic_on};

/// Which records the two fits see.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FitOn {
    /// The one of the smallest voltage, as the paper's own Table 2 suggests
    Smallest,
    /// All of them
    All,
}

/// The paper's run, and what it does not say.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  motorlens paper
  motorlens paper --population 40 --generations 200")]
pub struct PaperArgs {
    /// Logs of your own, instead of the virtual motor's three sines
    #[arg(long, value_name = "LOG", num_args = 1..)]
    pub on: Vec<PathBuf>,
    /// Directory for figures, tables and the model with the missing effect
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Picks the genetic algorithm's and the virtual motor's random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Which records are fitted
    #[arg(long = "fit", value_enum, default_value = "smallest")]
    pub fit_on: FitOn,
    /// Chromosomes
    #[arg(long, default_value_t = 80, value_parser = clap::value_parser!(u32).range(4..=1024))]
    pub population: u32,
    /// Generations
    #[arg(long, default_value_t = 800, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub generations: u32,
    /// Threads; they change the time and nothing else
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub threads: u32,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub reading: ReadArgs,
    /// The effects among which the missing one is sought.
    #[arg(skip)]
    pub library: Library,
}

/// One line of Table 1.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Parameter {
    /// As in the paper.
    pub symbol: &'static str,
    /// SI.
    pub unit: &'static str,
    /// Where the conventional fit began.
    pub nameplate: f64,
    /// The conventional fit's, x_sm.
    pub conventional: f64,
    /// The genetic algorithm's.
    pub ga: f64,
    /// As the paper prints it.
    pub printed: f64,
}

/// All that the run found: text by `Display`, a JSON document by `Serialize`.
#[derive(Debug, Clone, Serialize)]
pub struct PaperRun {
    schema: u32,
    /// What the virtual motor hides; none on the user's own logs.
    pub hidden: Option<&'static str>,
    /// Which records were fitted.
    pub fit_on: FitOn,
    /// Seed of everything random.
    pub seed: u64,
    /// Chromosomes.
    pub population: u32,
    /// The conventional fit.
    pub conventional: ConventionalResult,
    /// The genetic algorithm, with Figure 5 as its history.
    pub ga: GaResult,
    /// The fast search on the same objective, for comparison.
    pub fast: FastResult,
    /// Table 1.
    pub table_1: Vec<Parameter>,
    /// Table 2.
    pub table_2: Vec<Row>,
    /// Growth of the genetic model's average error with the voltage.
    pub growth: Option<Growth>,
    /// What the printed Table 1 implies.
    pub printed_combinations: Combinations,
    /// The missing effect, and Table 2 with it.
    pub missing: Missing,
    /// What the paper leaves open.
    pub choices: Vec<Choice>,
    /// Files written.
    pub files: Vec<PathBuf>,
}

/// The verb `paper`.
///
/// `progress` gets a line now and then.
///
/// # Errors
/// Bad input in the user's logs, or the machine's refusal to write.
pub fn run(args: &PaperArgs, progress: &mut dyn FnMut(&str)) -> Result<PaperRun> {
    let data = data::data(args)?;
    let even = data::even(&data.records);
    let prepare = |records| Records::new(records, Level::best()).map_err(|error| refused(&data, &error));
    let all = prepare(&even)?;
    let fitted = match args.fit_on {
        FitOn::Smallest => prepare(&even[..1])?,
        FitOn::All => all.clone(),
    };
    let nameplate = data::nameplate_start(&data);
    let conventional = conventional_on(&fitted, &nameplate);
    progress(&format!("conventional fit: IAE {:.5}", conventional.iae));
    let options = GaOptions {
        population: args.population as usize,
        generations: args.generations,
        seed: args.seed,
        threads: args.threads as usize,
        ..GaOptions::default()
    };
    let start = Start::Literal { centre: conventional.motor };
    let ga = genetic_on(&fitted, &start, &options, &mut |generation, best| {
        if generation % 200 == 0 {
            progress(&format!("generation {generation}: IAE {best:.5}"));
        }
    });
    let near = Start::Logarithmic { centre: conventional.motor, factor: 4.0 };
    let fast = fast_on(&fitted, &near, STARTS, args.seed);
    let printed = PaperMotor::printed_table_1();
    let printed_combinations = printed.combinations();
    let table_2 = tables::table_2(
        &data.records,
        &all,
        &ga.combinations,
        &conventional.combinations,
        &printed_combinations,
    );
    let missing = missing::missing_effect(&data, args.library.kinds(), progress)?;
    let mut run = PaperRun {
        schema: 1,
        hidden: data.hidden,
        fit_on: args.fit_on,
        seed: args.seed,
        population: args.population,
        table_1: table_1(&nameplate, &conventional.motor, &ga.motor, &printed),
        growth: tables::growth(&table_2, |row| row.ga.ae),
        table_2,
        printed_combinations,
        missing,
        choices: choices::choices(),
        files: Vec::new(),
        conventional,
        ga,
        fast,
    };
    if let Some(out) = &args.out {
        run.files = figures::write(&run, &data, &even, &all, out)?;
    }
    Ok(run)
}

fn table_1(
    nameplate: &PaperMotor,
    conventional: &PaperMotor,
    ga: &PaperMotor,
    printed: &PaperMotor,
) -> Vec<Parameter> {
    let of: [[f64; PARAMETERS]; 4] = [nameplate, conventional, ga, printed].map(PaperMotor::genes);
    SYMBOLS
        .iter()
        .enumerate()
        .map(|(k, &(symbol, unit))| Parameter {
            symbol,
            unit,
            nameplate: of[0][k],
            conventional: of[1][k],
            ga: of[2][k],
            printed: of[3][k],
        })
        .collect()
}

/// A record that the search refuses although the reader let it pass: named by its file.
fn refused(data: &data::Data, error: &RecordError) -> Error {
    let number = match error {
        RecordError::Empty => 1,
        RecordError::Lengths { record, .. }
        | RecordError::NotFinite { record, .. }
        | RecordError::Step { record, .. } => *record,
    };
    let file = data.records.get(number - 1).map(|r| r.path.clone()).unwrap_or_default();
    let remedy = "give a log of angle or speed with two samples or more".to_owned();
    BadInput { file, line: None, column: None, why: error.to_string(), remedy, proposal: None }.into()
}

#[cfg(test)]
mod tests {
    use super::{PaperArgs, run};
    use crate::log::write_canonical;
    use clap::Parser;

    #[derive(Parser)]
    struct Verb {
        #[command(flatten)]
        paper: PaperArgs,
    }

    fn args(words: &[&str]) -> PaperArgs {
        let words = std::iter::once("paper").chain(words.iter().copied());
        Verb::try_parse_from(words).expect("good options").paper
    }

    #[test]
    fn the_whole_run_shows_the_growth_names_the_hidden_effect_and_removes_it() {
        let out = tempfile::tempdir().expect("a directory");
        let path = out.path().to_str().expect("a plain path");
        let run = run(&args(&["--out", path]), &mut |_| ()).expect("a run");
        assert_eq!(run.ga.history.len(), 800);
        assert_eq!(run.ga.evaluations, 80 + 799 * 76);
        assert!(run.ga.clamped > 0);
        let growth = run.growth.expect("three voltages");
        assert!(growth.error > 3.0 * growth.voltage, "{growth:?}");
        let names: Vec<String> = run.missing.effects.iter().map(ToString::to_string).collect();
        assert_eq!(names, ["quadratic_drag"]);
        for (row, new) in run.table_2.iter().zip(&run.missing.table_2).skip(1) {
            assert!(new.ae < 0.1 * row.ga.ae, "{}: {} {}", row.record, new.ae, row.ga.ae);
        }
        let text = run.to_string();
        for part in ["Figure 5", "Table 1", "Table 2", "does not say", "quadratic_drag", "leaves open"] {
            assert!(text.contains(part), "no {part} in\n{text}");
        }
        for file in ["figure-5.svg", "figure-5.csv", "figure-7-1.svg", "figure-7-3.csv", "paper.json"] {
            assert!(out.path().join(file).is_file(), "no {file}");
        }
        let model = crate::model_file::Model::read(&out.path().join("model.json"));
        assert_eq!(model.expect("a model").effects.len(), 1);
    }

    #[test]
    fn the_same_run_goes_over_logs_of_ones_own() {
        let directory = tempfile::tempdir().expect("a directory");
        let data = super::data::data(&args(&["--rate", "50"])).expect("records");
        let mut words = vec!["--generations".to_owned(), "60".to_owned(), "--on".to_owned()];
        for record in &data.records {
            let path = directory.path().join(&record.name).with_extension("csv");
            write_canonical(record, &path).expect("written");
            words.push(path.to_str().expect("a plain path").to_owned());
        }
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let run = run(&args(&words), &mut |_| ()).expect("a run");
        assert_eq!(run.hidden, None);
        assert_eq!(run.table_2.len(), 3);
        assert!(run.growth.expect("three voltages").error > 5.0);
    }
}
