//! The beginning of a table, from which its columns are guessed.

use std::io::BufRead;
use std::path::Path;

use super::clock::Clock;
use super::direction;
use super::fields::trimmed;
use super::formats::interval;
use super::guess::{self, by_numbers};
use super::line_ends::read_row;
use super::newest;
use super::numbers::OfFile;
use super::own_rate;
use super::preamble::{NAMELESS, Preamble, remark_in};
use super::samples::FEWEST_SAMPLES;
use super::stamped::moment_of;
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
    /// When each row was received or said, s, where the lines carry times of their own.
    pub stamps: Vec<f64>,
    /// Columns whose numbers got the signs that their type took away, and its width.
    pub signed: Vec<(usize, f64)>,
    /// Rows per second, as the lines before the header tell.
    pub rate: Option<f64>,
    /// The clock of rows that have none, as the only number of a column tells it; that column is blank in `rows`.
    pub clock: Option<interval::Clock>,
}

impl Sample {
    /// Rows per second, as the file tells them.
    pub fn rate_hz(&self) -> Option<f64> {
        self.rate.or_else(|| self.clock.as_ref().map(interval::Clock::rate_hz))
    }

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

    /// A table of which nothing is known but its names, parted by semicolons, and its rows.
    #[cfg(test)]
    pub fn of(header: &str, rows: Vec<Vec<f64>>) -> Sample {
        let names: Vec<String> = header.split(';').map(str::to_owned).collect();
        Sample {
            with_units: names.clone(),
            names,
            rows,
            texts: Vec::new(),
            stamped: false,
            stamps: Vec::new(),
            signed: Vec::new(),
            rate: None,
            clock: None,
        }
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
        stamps: Vec::new(),
        signed: Vec::new(),
        rate: head.rate,
        clock: None,
    };
    let mut clocks: Vec<Clock> = Vec::new();
    let mut stamps = Clock::default();
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
        if head.stamped {
            let stamp = splitter.stamp().and_then(|stamp| moment_of(stamp, &mut stamps));
            sample.stamps.push(stamp.unwrap_or(f64::NAN));
        }
        if sample.texts.len() < shown {
            sample.texts.push(splitter.iter().map(str::to_owned).collect());
        }
    };
    for (_, line) in &head.rows {
        take(line, &mut sample);
    }
    let (mut line, mut beyond, mut stride) = (String::new(), 0, 1);
    while read_row(&mut input, &mut line).map_err(|error| cannot_read(path, &error))? > 0 {
        if sample.rows.len() < GUESSED_FROM {
            take(&line, &mut sample);
        } else {
            if beyond % stride == 0 {
                take(&line, &mut sample);
            }
            beyond += 1;
            if sample.rows.len() > GUESSED_FROM + LATER {
                keep_every_second(&mut sample.rows);
                keep_every_second(&mut sample.stamps);
                stride *= 2;
            }
        }
        line.clear();
    }
    // A counter may be as large as a stamp: only the name tells a time from it.
    let is_called_time = |k: usize| sample.names.get(k).is_some_and(|name| guess::words::is_time(name));
    let is_dated =
        |k: usize| clocked[k] || is_called_time(k) && numbers(&sample.rows, k).all(newest::is_stamp);
    let falls = |k: usize| newest::falls(&numbers(&sample.rows, k).collect::<Vec<_>>());
    if (0..clocked.len()).any(|k| is_dated(k) && falls(k)) {
        sample.rows.reverse();
        sample.stamps.reverse();
    }
    if leave_out_stale_first(&mut sample.rows) && !sample.stamps.is_empty() {
        sample.stamps.remove(0);
    }
    sample.clock = own_rate::take(&mut sample);
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

/// Behind the rows in succession every second one stays.
fn keep_every_second<T>(all: &mut Vec<T>) {
    let mut place = 0;
    all.retain(|_| {
        place += 1;
        place <= GUESSED_FROM || place % 2 == 0
    });
}

/// Leaves out a first row from before a column began that only rises behind it, as the reader of the rows does, and tells whether there was one: what
/// a serial port still held when the board was reset tells nothing of this run.
fn leave_out_stale_first(rows: &mut Vec<Vec<f64>>) -> bool {
    let Some(([first, second], rest)) =
        rows.split_first_chunk::<2>().filter(|_| rows.len() >= FEWEST_SAMPLES)
    else {
        return false;
    };
    let rises = |k: usize| {
        let later = std::iter::once(second).chain(rest).map(|row| row.get(k));
        later.clone().zip(later.skip(1)).all(|(before, after)| after > before)
    };
    let is_stale = |k: usize| first[k] > second.get(k).copied().unwrap_or(f64::NAN) && rises(k);
    let is_there = (0..first.len()).any(is_stale);
    if is_there {
        rows.remove(0);
    }
    is_there
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
    let open =
        || question(&sample).or_else(|| no_table(&sample, head)).unwrap_or_else(|| any_mapping(&sample));
    Ok(match guess::propose_for(&sample) {
        Some(proposal) => {
            guess::steady_question(&sample, &proposal).map_or(Guess::Proposed(proposal), Guess::Open)
        }
        None => Guess::Open(open()),
    })
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
    // Where the header is wrong its names are those of no column.
    let sample = Sample { names: Vec::new(), with_units: Vec::new(), ..read(path, input, head, 0)? };
    let described = || by_numbers::described(&sample.rows);
    if let Some(why) = wrong {
        let remedy = format!(
            "give every column its name there, and no other, or say by its number, from 0, which column is what (--map time=0:s,...); {}",
            described()
        );
        return Ok(BadInput::new(path, why, remedy).at_line(head.line));
    }
    let proposal = guess::propose_for(&sample);
    let remedy = match &proposal {
        Some(proposal) => format!(
            "say by its number which column is what, or add a header line; it looks like {} ({})",
            proposal.options(),
            proposal.assumptions()
        ),
        None => guess::garbled_question(&sample).unwrap_or_else(|| {
            format!(
                "add a header line such as time_s,voltage_v,angle_rad, or say by its number, from 0, which column is what (--map time=0:s,...); {}",
                described()
            )
        }),
    };
    Ok(BadInput::new(path, NAMELESS, remedy).at_line(head.line).proposing(proposal))
}

/// What a table leaves open in which too little is recognised.
pub(super) fn question(sample: &Sample) -> Option<String> {
    let questions = [
        guess::garbled_question,
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

/// As much of a line as a message holds, in characters.
const SHOWN: usize = 60;

/// What is said of lines with fewer than two columns of numbers, of which no mapping makes a log.
fn no_table(sample: &Sample, head: &Preamble) -> Option<String> {
    let width = sample.rows.iter().map(Vec::len).max()?;
    let mut columns = (0..width).filter(|k| numbers(&sample.rows, *k).next().is_some());
    match (columns.next(), columns.next()) {
        (Some(only), None) => {
            let name = sample.names.get(only).cloned().unwrap_or_else(|| only.to_string());
            Some(format!(
                "only \"{name}\" holds numbers, and a fit needs the time, what drove the motor (a duty or voltage) and how it moved (an angle, \
                 counts or a speed): log them in every row"
            ))
        }
        (None, _) => {
            // A number at its beginning rather shows what the lines are than a sentence does.
            let has_number = |line: &str| line.trim_start().starts_with(|c: char| c.is_ascii_digit());
            let first = head.rows.iter().find(|(_, line)| has_number(line)).or(head.rows.first());
            let (line, text) = first?;
            let text: String = text.trim().chars().take(SHOWN).collect();
            Some(format!(
                "this is no table of numbers: line {line} reads \"{text}\"; write a row for each instant, with the time, what drives the motor and \
                 its motion as numbers in columns of their own"
            ))
        }
        _ => None,
    }
}

/// What is said where nothing is known of the columns, or nothing but what was commanded and counted.
fn any_mapping(sample: &Sample) -> String {
    if let Some(said) = guess::unmeasured(sample) {
        return said;
    }
    format!(
        "say which column is what and in which unit; if they are time, voltage and speed: --map {}, and of a duty and encoder counts: --map \
         time=t:ms,duty=pwm:255,angle=enc:counts --supply-volts 12 --counts-per-rev {}",
        guess::example(&sample.names, &sample.rows),
        guess::ASSUMED_COUNTS
    )
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
    Open(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_row_from_before_the_clock_began_tells_nothing_of_the_columns() {
        let run = |first: [f64; 2]| -> Vec<Vec<f64>> {
            let rows = (0..30).map(|k| vec![f64::from(k), 64.0]);
            std::iter::once(first.to_vec()).chain(rows).collect()
        };
        let mut rows = run([249.0, 65_472.0]);
        leave_out_stale_first(&mut rows);
        assert_eq!((rows.len(), rows[0][1]), (30, 64.0));
        // In its place, and before a clock that begins anew later too.
        let mut begins = run([-1.0, 65_472.0]);
        let mut twice = [run([249.0, 64.0]), run([0.0, 64.0])].concat();
        for rows in [&mut begins, &mut twice] {
            let before = rows.len();
            leave_out_stale_first(rows);
            assert_eq!(rows.len(), before);
        }
    }
}
