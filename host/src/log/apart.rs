//! Input and output logged apart: two tables, each with times of its own, as one record.
//!
//! `input.csv+output.csv` names both. Samples are those of the output, where the input has begun and has not ended; what drives the
//! motor holds from its last row at or before, as the driver held it. No value is taken from the future.

use std::path::{Path, PathBuf};

use super::clock::Clock;
use super::samples::FEWEST_SAMPLES;
use super::table::{self, Part, Read};
use super::units::Quantity;
use super::{Metadata, ReadOptions, Record, Warning, guess, preamble, sample, text};
use crate::error::{BadInput, Error, Result};

/// What belongs to the input of a motor.
const INPUTS: [Quantity; 5] =
    [Quantity::Voltage, Quantity::Duty, Quantity::Direction, Quantity::Target, Quantity::Supply];
/// Fewer samples than this in common are no overlap.
const FEWEST: usize = 2;

/// The two files that `path` names, where it is no file itself.
pub(super) fn both(path: &Path) -> Option<(PathBuf, PathBuf)> {
    let name = path.to_str().filter(|_| !path.exists())?;
    let mut cuts = halves(name).map(|(input, output)| (PathBuf::from(input), PathBuf::from(output)));
    cuts.find(|(input, output)| input.is_file() && output.is_file())
}

/// The two names that `name` may consist of.
pub(crate) fn halves(name: &str) -> impl Iterator<Item = (&str, &str)> {
    name.match_indices('+').map(|(at, _)| (&name[..at], &name[at + 1..]))
}

/// Reads the record of the two files.
///
/// # Errors
/// Those of a table, of either file; bad input where their clocks have no time in common.
pub(super) fn read(path: &Path, input: &Path, output: &Path, options: &ReadOptions) -> Result<Vec<Record>> {
    let mut clock = Clock::default();
    let driven = table::columns(input, text::open(input)?, options, &mut clock, Part::Half);
    let mut clock = clock.rewound();
    let moved = table::columns(output, text::open(output)?, options, &mut clock, Part::Half);
    let read = match (driven, moved) {
        (Ok(driven), Ok(moved)) => joined(input, output, driven, moved),
        (Err(error), _) | (_, Err(error)) => Err(error),
    };
    let read = read.map_err(|error| proposing(error, input, output, options))?;
    let structure = read.structure.clone();
    let name = format!("{}+{}", super::stem(input), super::stem(output));
    Ok(structure.tests(table::record(path, name, read, options)?))
}

/// The beginning of one of the files.
fn beginning(path: &Path) -> Option<sample::Sample> {
    let mut lines = text::open(path).ok()?;
    let head = preamble::read(path, &mut lines, true).ok()?;
    sample::read(path, lines, &head, 0).ok()
}

/// The mapping that both files look like.
fn proposal(input: &Path, output: &Path, options: &ReadOptions) -> Option<guess::Proposal> {
    let proposal = guess::propose_apart(&beginning(input)?, &beginning(output)?)?;
    let mut meta = Metadata::default();
    let _ = options.complete(input, &mut meta);
    Some(proposal.with_known(options.known(&meta)))
}

/// The fault of two files given as two logs of which one has only what drives the motor and the other only its motion: how they are
/// given as one. Any other fault stays what it is.
pub(super) fn as_one(error: Error, paths: &[PathBuf], options: &ReadOptions) -> Error {
    let ([one, other], Error::BadInput(_), None) = (paths, &error, &options.map) else { return error };
    let is_apart = |input: &Path, output: &Path| {
        beginning(input)
            .zip(beginning(output))
            .is_some_and(|(input, output)| guess::are_apart(&input, &output))
    };
    for (input, output) in [(one, other), (other, one)] {
        if is_apart(input, output)
            && let Some(proposal) = proposal(input, output, options)
        {
            let pair = PathBuf::from(format!("{}+{}", input.display(), output.display()));
            let why = format!(
                "{} has only what drives the motor, and {} only its motion",
                input.display(),
                output.display()
            );
            let remedy = format!(
                "give both as one log, {}; they look like {}",
                guess::quoted(&pair.display().to_string()),
                proposal.told()
            );
            return BadInput::new(&pair, why, remedy).proposing(Some(proposal)).into();
        }
    }
    error
}

/// The fault with the mapping that both files look like, where none was given.
fn proposing(error: Error, input: &Path, output: &Path, options: &ReadOptions) -> Error {
    match error {
        Error::BadInput(mut fault) if options.map.is_none() => {
            if let Some(proposal) = proposal(input, output, options) {
                fault.remedy = format!(
                    "say which column is what and in which unit; the files look like {}",
                    proposal.told()
                );
                fault.proposal = Some(Box::new(proposal));
            }
            Error::BadInput(fault)
        }
        other => other,
    }
}

fn joined(input: &Path, output: &Path, mut driven: Read, moved: Read) -> Result<Read> {
    let is_input = |quantity: Quantity| INPUTS.contains(&quantity);
    // Both may have a column of the same name: each gives its own part.
    let (drives, others): (Vec<_>, Vec<_>) = driven.values.into_iter().partition(|(q, _)| is_input(*q));
    if !drives.iter().any(|(q, _)| ![Quantity::Supply, Quantity::Direction].contains(q))
        || moved.values.iter().all(|(q, _)| is_input(*q))
    {
        let swapped = others.iter().any(|(q, _)| matches!(q, Quantity::Angle | Quantity::Speed));
        let why = format!(
            "{} has nothing that drives the motor, or {} no angle or speed",
            input.display(),
            output.display()
        );
        let remedy = if swapped {
            format!("give them in this order: {}+{}", output.display(), input.display())
        } else {
            "say which columns they are: --map time=t,voltage=COLUMN OF THE FIRST:V,angle=COLUMN OF THE SECOND:rad".into()
        };
        return Err(BadInput::new(input, why, remedy).into());
    }
    let (first, last) = (ends(&driven.time_s), ends(&moved.time_s));
    let common: Vec<usize> = (0..moved.time_s.len())
        .filter(|&k| moved.time_s[k] >= first.0 && moved.time_s[k] <= first.1)
        .collect();
    if common.len() < FEWEST {
        let why = format!(
            "the files have no time in common: {:.3}..{:.3} s in {} and {:.3}..{:.3} s in {}",
            first.0,
            first.1,
            input.display(),
            last.0,
            last.1,
            output.display()
        );
        return Err(BadInput::new(
            output,
            why,
            "log both by one clock, check the units of both times, or shift the times of one file",
        )
        .into());
    }
    if moved.time_s.len() < FEWEST_SAMPLES {
        let why = format!("{} samples of the motion are too few to fit a motor", moved.time_s.len());
        let remedy =
            format!("record at least {FEWEST_SAMPLES} samples, better some seconds with changing voltage");
        return Err(BadInput::new(output, why, remedy).into());
    }
    let place = format!("{}+{}", input.display(), output.display());
    let held: Vec<usize> =
        common.iter().map(|&k| driven.time_s.partition_point(|t| *t <= moved.time_s[k]) - 1).collect();
    let pick = |values: &[f64], rows: &[usize]| rows.iter().map(|&k| values[k]).collect::<Vec<f64>>();
    let time_s = pick(&moved.time_s, &common);
    let what = format!(
        "two files as one record: {} of {} samples of {}, from {:.3} to {:.3} s, where {} drives the motor; its {} rows hold until the next",
        common.len(),
        moved.time_s.len(),
        output.display(),
        time_s[0],
        time_s[time_s.len() - 1],
        input.display(),
        driven.time_s.len(),
    );
    let mut warnings = std::mem::take(&mut driven.warnings);
    warnings.extend(moved.warnings);
    warnings.push(Warning { place, what, fix: "nothing, if both were logged by one clock".into() });
    let mut values: Vec<(Quantity, Vec<f64>)> =
        drives.into_iter().map(|(quantity, column)| (quantity, pick(&column, &held))).collect();
    values.extend(
        moved
            .values
            .iter()
            .filter(|(q, _)| !is_input(*q))
            .map(|(quantity, column)| (*quantity, pick(column, &common))),
    );
    let mut meta = driven.meta;
    for (key, value) in moved.meta.iter() {
        // What was checked once fits again.
        let _ = meta.insert(key, value);
    }
    let structure = super::structure::Structure::default();
    // Units that either header says.
    let other = |quantity| moved.map.as_ref().and_then(|map| map.source(quantity));
    let map = driven.map.as_ref().map(|map| {
        map.with_units(|source| {
            other(source.quantity).map(|other| other.written.clone()).filter(|unit| !unit.is_empty())
        })
    });
    let labels = driven.labels.or(moved.labels);
    Ok(Read { time_s, values, meta, map, structure, labels, warnings })
}

fn ends(time_s: &[f64]) -> (f64, f64) {
    (time_s.first().copied().unwrap_or(f64::NAN), time_s.last().copied().unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::super::read;
    use super::*;

    fn files(input: &str, output: &str) -> (tempfile::TempDir, PathBuf) {
        let directory = tempfile::tempdir().unwrap();
        let (a, b) = (directory.path().join("in.csv"), directory.path().join("out.csv"));
        std::fs::write(&a, input).unwrap();
        std::fs::write(&b, output).unwrap();
        let path = PathBuf::from(format!("{}+{}", a.display(), b.display()));
        (directory, path)
    }

    fn output(begin: f64) -> String {
        let mut text = "t,value\n".to_owned();
        for k in 0..100 {
            let _ = writeln!(text, "{:.3},{:.4}", begin + 0.01 * f64::from(k), 0.01 * f64::from(k * k));
        }
        text
    }

    fn input() -> String {
        let mut text = "t,value\n".to_owned();
        (0..40).for_each(|k| writeln!(text, "{:.3},{}", 0.205 + 0.02 * f64::from(k), k % 5).unwrap());
        text
    }

    #[test]
    fn an_input_that_is_logged_where_it_changes_is_none_too_short_and_an_output_is() {
        let map = Some("time=t,voltage=value,angle=value".parse().unwrap());
        let options = ReadOptions { map, ..ReadOptions::default() };
        let (_directory, path) = files("t,value\n0.00,0\n0.20,6\n0.99,-4\n", &output(0.0));
        let record = read(&path, &options).unwrap().remove(0);
        assert_eq!((record.len(), record.voltage_v[19], record.voltage_v[20]), (100, 0.0, 6.0));
        let (_directory, path) = files(&input(), "t,value\n0.3,0\n0.4,1\n0.5,2\n");
        let refused = read(&path, &options).unwrap_err().to_string();
        assert!(refused.contains("3 samples of the motion are too few"), "{refused}");
    }

    #[test]
    fn times_of_other_names_in_the_same_place_are_proposed_by_their_number() {
        let (_directory, path) =
            files(&input().replace("t,value", "t,volts"), &output(0.2).replace("t,value", "timestamp,theta"));
        let Err(Error::BadInput(fault)) = read(&path, &ReadOptions::default()) else { panic!("it was read") };
        let map = fault.proposal.unwrap().map;
        assert_eq!(map, "time=0:s,voltage=volts:V,angle=theta:rad");
        let options = ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() };
        assert_eq!(read(&path, &options).unwrap().len(), 1);
    }

    #[test]
    fn the_input_holds_from_its_last_row_and_never_comes_from_the_future() {
        let (_directory, path) = files(&input(), &output(0.0));
        let map = Some("time=t,voltage=value,angle=value".parse().unwrap());
        let options = ReadOptions { map, ..ReadOptions::default() };
        let record = read(&path, &options).unwrap().remove(0);
        // The rows of the output between the first and the last of the input.
        assert_eq!((record.len(), record.time_s[0]), (78, 0.21));
        for (t, volts) in record.time_s.iter().zip(&record.voltage_v) {
            let row = ((t - 0.205) / 0.02 + 1e-9).floor();
            assert_eq!(*volts, row % 5.0, "{t}");
        }
        assert!(
            record.warnings.iter().any(|w| w.what.contains("78 of 100 samples")),
            "{:?}",
            record.warnings
        );
    }

    #[test]
    fn a_mapping_that_fits_both_files_is_proposed_and_reads_them() {
        let input: String = (0..60).map(|k| format!("{},{}\n", 20 * k, k % 7 * 30)).collect();
        let output: String = (0..120).map(|k| format!("{},{}\n", 10 * k, 7 * k)).collect();
        let (_directory, path) = files(&format!("millis,pwm\n{input}"), &format!("millis,enc\n{output}"));
        let Err(Error::BadInput(fault)) = read(&path, &ReadOptions::default()) else { panic!("it is read") };
        let proposal = fault.proposal.unwrap();
        assert_eq!(
            proposal.options(),
            "--map time=millis:ms,duty=pwm:255,angle=enc:counts --supply-volts 12 --counts-per-rev 1320"
        );
        let mut options = ReadOptions { map: Some(proposal.map.parse().unwrap()), ..ReadOptions::default() };
        options.supply_volts = Some(12.0);
        options.motor.counts_per_rev = Some(1320.0);
        assert_eq!(read(&path, &options).unwrap()[0].len(), 119);
    }

    #[test]
    fn what_stands_alone_beside_the_time_of_the_first_file_is_taken_for_the_voltage_and_asked_about() {
        let stamp = |ms: u64| 1_714_557_600_000_000_000 + ms * 1_000_000;
        let input: String = (0..60).map(|k| format!("{},{}\n", stamp(20 * k), k % 7)).collect();
        let output: String =
            (0..120).map(|k| format!("{},{},{}\n", stamp(10 * k), 0.07 * k as f64, 7.0)).collect();
        let (_directory, path) = files(
            &format!("%time,field.data\n{input}"),
            &format!("%time,field.position0,field.velocity0\n{output}"),
        );
        let Err(Error::BadInput(fault)) = read(&path, &ReadOptions::default()) else { panic!("it is read") };
        let proposal = fault.proposal.unwrap();
        assert_eq!(proposal.options(), "--map time=time:ns,voltage=field.data:V,angle=field.position0:rad");
        assert!(proposal.assumptions().contains("duty=field.data:255"), "{}", proposal.assumptions());
        let options = ReadOptions { map: Some(proposal.map.parse().unwrap()), ..ReadOptions::default() };
        assert_eq!(read(&path, &options).unwrap()[0].len(), 119);
    }

    #[test]
    fn files_in_the_wrong_order_or_on_other_clocks_are_refused_with_the_fix() {
        let map = |text: &str| ReadOptions { map: Some(text.parse().unwrap()), ..ReadOptions::default() };
        let (_directory, path) =
            files(&output(0.0).replace("value", "angle"), &input().replace("value", "u"));
        let refused = read(&path, &map("time=t,voltage=u,angle=angle")).unwrap_err().to_string();
        assert!(refused.contains("in this order") && refused.contains("out.csv+"), "{refused}");
        let (_directory, path) = files(&input(), &output(1000.0));
        let refused = read(&path, &map("time=t,voltage=value,angle=value")).unwrap_err().to_string();
        assert!(refused.contains("no time in common") && refused.contains("one clock"), "{refused}");
    }
}
