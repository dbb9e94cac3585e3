//! The beginning of a table, from which its columns are guessed.

use std::io::BufRead;
use std::path::Path;

use super::clock::Clock;
use super::direction;
use super::fields::trimmed;
use super::guess::{self, by_numbers};
use super::newest;
use super::numbers::OfFile;
use super::preamble::{NAMELESS, Preamble, remark_in};
use super::text::cannot_read;
use super::unsigned;
use crate::error::{BadInput, Result};

/// Rows in succession from which a mapping is guessed.
const GUESSED_FROM: usize = 2000;
/// Rows from all over the rest of the table, at most: few enough that most steps are still those of the clock.
const LATER: usize = 500;

/// The first rows of a table and some of the later ones, for a guess at its columns: a duty that has only begun to rise looks like
/// another.
#[derive(Debug, Clone)]
pub(super) struct Sample {
    pub names: Vec<String>,
    /// The names with the units of the row below them.
    pub with_units: Vec<String>,
    /// The numbers, times in seconds; NaN where a field is none.
    pub rows: Vec<Vec<f64>>,
    /// The fields as they stand there.
    pub texts: Vec<Vec<String>>,
    pub stamped: bool,
    /// Columns whose numbers got the signs that their type took away, and its width.
    pub signed: Vec<(usize, f64)>,
    /// Rows per second, as the lines before the header tell.
    pub rate: Option<f64>,
}

impl Sample {
    /// The same, whose columns are called by their places where they have no names.
    pub fn with_places(&self) -> Sample {
        let mut sample = self.clone();
        if sample.names.is_empty() {
            let width = sample.rows.first().map_or(0, Vec::len);
            sample.names = (0..width).map(|place| place.to_string()).collect();
            sample.with_units = sample.names.clone();
        }
        sample
    }
}

/// Reads on behind the head of a table; of the texts only the first `shown` rows are kept.
///
/// # Errors
/// What reading says.
pub(super) fn read(path: &Path, mut input: impl BufRead, head: &Preamble, shown: usize) -> Result<Sample> {
    let mut splitter = head.splitter();
    let names = head.headers.clone().unwrap_or_default();
    let mut sample = Sample {
        with_units: names.clone(),
        names,
        rows: Vec::new(),
        texts: Vec::new(),
        stamped: head.stamped,
        signed: Vec::new(),
        rate: head.rate,
    };
    let mut clocks: Vec<Clock> = Vec::new();
    let mut clocked: Vec<bool> = Vec::new();
    let mut written = OfFile::with_thousands(head.thousands);
    let mut take = |line: &str, sample: &mut Sample| {
        let text = trimmed(line);
        if text.is_empty() || remark_in(text.trim_start()).is_some() || !splitter.split(text) {
            return;
        }
        clocks.resize(clocks.len().max(splitter.len()), Clock::default());
        clocked.resize(clocked.len().max(splitter.len()), false);
        let value = |(k, text): (usize, &str)| {
            written
                .read(k, text)
                .or_else(|| clocks[k].read(text, 1.0, None).inspect(|_| clocked[k] = true))
                .or_else(|| direction::named(text))
                .unwrap_or(f64::NAN)
        };
        sample.rows.push(splitter.iter().enumerate().map(value).collect());
        if sample.texts.len() < shown {
            sample.texts.push(splitter.iter().map(str::to_owned).collect());
        }
    };
    for (_, line) in &head.rows {
        take(line, &mut sample);
    }
    let (mut line, mut beyond, mut stride) = (String::new(), 0, 1);
    while input.read_line(&mut line).map_err(|error| cannot_read(path, &error))? > 0 {
        if sample.rows.len() < GUESSED_FROM {
            take(&line, &mut sample);
        } else {
            if beyond % stride == 0 {
                take(&line, &mut sample);
            }
            beyond += 1;
            if sample.rows.len() > GUESSED_FROM + LATER {
                // Every second one goes.
                let mut place = 0;
                sample.rows.retain(|_| {
                    place += 1;
                    place <= GUESSED_FROM || place % 2 == 0
                });
                stride *= 2;
            }
        }
        line.clear();
    }
    let is_dated = |k: usize| clocked.get(k) == Some(&true);
    let falls = |k: usize| newest::falls(&numbers(&sample.rows, k).collect::<Vec<_>>());
    if (0..clocked.len()).any(|k| is_dated(k) && falls(k)) {
        sample.rows.reverse();
    }
    sample.signed = give_signs(&mut sample.rows);
    for (k, name) in sample.with_units.iter_mut().enumerate() {
        let unit = head.units.get(k).map(String::as_str).filter(|unit| !unit.is_empty());
        // A clock time tells its unit itself.
        let unit = if clocked.get(k) == Some(&true) { Some("s") } else { unit };
        if let Some(unit) = unit {
            *name = format!("{name} [{unit}]");
        }
    }
    Ok(sample)
}

/// The numbers of a column, as far as its rows have them.
pub(super) fn numbers(rows: &[Vec<f64>], column: usize) -> impl Iterator<Item = f64> + Clone {
    rows.iter().filter_map(move |row| row.get(column)).copied().filter(|value| value.is_finite())
}

/// Gives columns of whole numbers the signs that their type took away, and tells which, and the width of the type.
fn give_signs(rows: &mut [Vec<f64>]) -> Vec<(usize, f64)> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let mut signed = Vec::new();
    for column in 0..columns {
        let values = numbers(rows, column);
        let Some(width) = unsigned::width_of(values) else { continue };
        for value in rows.iter_mut().filter_map(|row| row.get_mut(column)) {
            *value = unsigned::signed(*value, width);
        }
        signed.push((column, width));
    }
    signed
}

/// What the beginning of a table proposes, or the question that it leaves open.
///
/// # Errors
/// What reading says.
pub(super) fn proposal(path: &Path, input: impl BufRead, head: &Preamble) -> Result<Guess> {
    let sample = read(path, input, head, 0)?;
    Ok(guess::propose_for(&sample).map_or_else(|| Guess::Open(question(&sample)), Guess::Proposed))
}

/// The fault of a table whose columns have no names, or whose header is `wrong`, with what their numbers say of them.
///
/// # Errors
/// What reading says.
pub(super) fn nameless(
    path: &Path,
    input: &mut impl BufRead,
    head: &Preamble,
    wrong: Option<String>,
) -> Result<BadInput> {
    let rows = read(path, input, head, 0)?.rows;
    if let Some(why) = wrong {
        let remedy = format!(
            "give every column its name there, and no other, or say by its number, from 0, which column is what (--map time=0:s,...); {}",
            by_numbers::described(&rows)
        );
        return Ok(BadInput::new(path, why, remedy).at_line(head.line));
    }
    let proposal = by_numbers::propose(&rows);
    let remedy = match &proposal {
        Some(proposal) => format!(
            "say by its number which column is what, or add a header line; it looks like {} ({})",
            proposal.options(),
            proposal.assumptions()
        ),
        None => format!(
            "add a header line such as time_s,voltage_v,angle_rad, or say by its number, from 0, which column is what (--map time=0:s,...); {}",
            by_numbers::described(&rows)
        ),
    };
    Ok(BadInput::new(path, NAMELESS, remedy).at_line(head.line).proposing(proposal))
}

/// What a table leaves open in which too little is recognised.
fn question(sample: &Sample) -> Option<String> {
    let questions = [
        guess::effort_question,
        guess::levels_question,
        guess::loop_question,
        guess::sampled_question,
        guess::channels_question,
        guess::error_question,
        guess::half_question,
        guess::numbers_question,
    ];
    questions.into_iter().find_map(|question| question(sample))
}

impl Guess {
    /// The same without assumptions about what is known.
    pub fn with_known(self, known: guess::Known) -> Self {
        match self {
            Guess::Proposed(proposal) => Guess::Proposed(proposal.with_known(known)),
            Guess::Open(_) => self,
        }
    }
}

/// What a guess came to.
#[derive(Debug)]
pub(super) enum Guess {
    /// Options that read the table.
    Proposed(guess::Proposal),
    /// No options; what else is known of the columns.
    Open(Option<String>),
}
