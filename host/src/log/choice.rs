//! Which columns of a table are wanted, by the mapping or by their canonical names, and what is said where one is absent.

use std::path::Path;

use super::guess::{unit_names, words};
use super::mapping::{Mapping, Source};
use super::only::Only;
use super::sample::Guess;
use super::units::{PerTurn, Quantity, Unit};
use super::{Metadata, ReadOptions};
use crate::error::{BadInput, Result};

/// A column of the file that is wanted.
#[derive(Debug, Clone)]
pub(super) struct Wanted {
    pub quantity: Quantity,
    pub index: usize,
    pub header: String,
    /// The column that is taken off, of a difference of two.
    pub less: Option<usize>,
    /// Its factor is that to SI: what it has to be divided by is in it.
    pub unit: Unit,
}

/// What tells the time of a row.
#[derive(Debug, Clone)]
pub(super) enum TimeSource {
    /// A column.
    Column(Wanted),
    /// A column of seconds and one of what comes on top.
    Columns(Wanted, Wanted),
    /// A column of the time since the row before.
    Intervals(Wanted),
    /// When a serial monitor received the line.
    Stamps,
    /// Nothing: rows of this rate, Hz.
    Rate(f64),
    /// The number of the row in a column, which rises by so much a row, at this rate, Hz.
    Numbered(Wanted, f64, f64),
}

impl TimeSource {
    /// What a message calls it.
    pub fn header(&self) -> &str {
        match self {
            TimeSource::Column(column)
            | TimeSource::Columns(column, _)
            | TimeSource::Intervals(column)
            | TimeSource::Numbered(column, ..) => &column.header,
            TimeSource::Stamps => "stamp before ->",
            TimeSource::Rate(_) => "row (--rate)",
        }
    }
}

/// What a table is read from.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    pub time: TimeSource,
    pub values: Vec<Wanted>,
    /// The rows that are read, where not all are, by what stands in the column at this place.
    pub only: Option<(usize, Only)>,
    /// `--rate` was given, and the log tells its times itself.
    pub rate_unused: bool,
}

impl Columns {
    /// The same with rows of this rate, Hz, whatever tells their time.
    pub fn by_rate(&self, rate: f64) -> Columns {
        Columns { time: TimeSource::Rate(rate), rate_unused: false, ..self.clone() }
    }

    /// Whether column `k` of the table is one of them.
    pub fn reads(&self, k: usize) -> bool {
        let of_time = match &self.time {
            TimeSource::Column(one) | TimeSource::Intervals(one) | TimeSource::Numbered(one, ..) => {
                one.index == k
            }
            TimeSource::Columns(one, other) => one.index == k || other.index == k,
            TimeSource::Stamps | TimeSource::Rate(_) => false,
        };
        let chooses = self.only.as_ref().is_some_and(|(place, _)| *place == k);
        of_time || chooses || self.values.iter().any(|column| column.index == k || column.less == Some(k))
    }
}

/// A canonical column that neither the header nor the mapping has.
#[derive(Debug)]
pub(super) struct Missing {
    pub header: &'static str,
    pub why: &'static str,
}

/// The header of a file, out of which columns are chosen.
pub(super) struct Choice<'a> {
    pub path: &'a Path,
    pub line: u64,
    pub names: &'a [String],
    /// The row of units below the header; may be empty.
    pub units: &'a [String],
    pub stamped: bool,
    pub meta: &'a Metadata,
    /// Another file has what this one has not.
    pub partial: bool,
}

impl Choice<'_> {
    /// The columns that are wanted, or which one is absent.
    ///
    /// # Errors
    /// Bad input where the mapping names a column that there is not, or a name is there twice.
    pub fn columns(&self, options: &ReadOptions) -> Result<Result<Columns, Missing>> {
        let map = options.map.as_ref();
        let mut values = Vec::new();
        for quantity in
            Quantity::ALL.into_iter().filter(|q| ![Quantity::Time, Quantity::Interval].contains(q))
        {
            if let Some(source) = self.source(map, quantity) {
                values.push(self.mapped(source)?);
            } else if !displaced(quantity, map) {
                values.extend(self.canonical(quantity)?);
            }
        }
        let Some(time) = self.time(options)? else {
            return Ok(Err(Missing {
                header: "time_s",
                why: "no column is called time_s or mapped as the time",
            }));
        };
        let rate_unused = options.rate_hz.is_some() && !matches!(time, TimeSource::Rate(_));
        let columns = Columns { time, values, only: self.only(map)?, rate_unused };
        Ok(match missing(&columns) {
            Some(_) if self.partial && !columns.values.is_empty() => Ok(columns),
            Some(missing) => Err(missing),
            None => Ok(columns),
        })
    }

    /// Which rows the mapping wants, and where the column stands that tells; nothing where another file has it.
    fn only(&self, map: Option<&Mapping>) -> Result<Option<(usize, Only)>> {
        let Some(only) = map.and_then(Mapping::only) else { return Ok(None) };
        match self.index_of(&only.column) {
            Some(place) => Ok(Some((place, only.clone()))),
            None if self.partial => Ok(None),
            None => Err(self.absent(&only.column, "to choose rows by").into()),
        }
    }

    /// The fault of a column that there is not.
    fn absent(&self, column: &str, wanted: impl std::fmt::Display) -> BadInput {
        let why = format!("there is no column \"{column}\" {wanted}");
        BadInput::new(self.path, why, format!("take one of: {}", self.listed()))
            .at_line(self.line)
            .in_column(column)
    }

    fn time(&self, options: &ReadOptions) -> Result<Option<TimeSource>> {
        let map = options.map.as_ref();
        if let Some(source) = self.source(map, Quantity::Time) {
            return self.time_column(source).map(Some);
        }
        if let Some(source) = self.source(map, Quantity::Interval) {
            return Ok(Some(TimeSource::Intervals(self.mapped(source)?)));
        }
        if let Some(column) = self.canonical(Quantity::Time)? {
            return Ok(Some(TimeSource::Column(column)));
        }
        let stamps = self.stamped.then_some(TimeSource::Stamps);
        Ok(stamps.or(options.rate_hz.map(TimeSource::Rate)))
    }

    /// `time=sec+nanosec:ns` names two columns, where there is none of that whole name.
    fn time_column(&self, source: &Source) -> Result<TimeSource> {
        if let Some((seconds, rest)) = source.column.split_once('+')
            && !self.names.contains(&source.column)
        {
            let seconds = self.named(Quantity::Time, seconds.trim(), Unit::SI)?;
            let rest = self.named(Quantity::Time, rest.trim(), source.unit)?;
            return Ok(TimeSource::Columns(seconds, rest));
        }
        self.mapped(source).map(TimeSource::Column)
    }

    /// Where the mapping says that a quantity is; nothing where another file has that column.
    fn source<'m>(&self, map: Option<&'m Mapping>, quantity: Quantity) -> Option<&'m Source> {
        let source = map.and_then(|map| map.source(quantity))?;
        let first = source.column.split('+').next().unwrap_or_default().trim();
        let here = self.index_of(&source.column).or_else(|| self.index_of(first)).is_some()
            || self.difference(source).is_some();
        (here || !self.partial).then_some(source)
    }

    /// The mapping with the units that the header, or the row below it, says of columns whose unit the mapping leaves open.
    pub fn with_units(&self, map: &Mapping) -> Mapping {
        map.with_units(|source| {
            let first = || self.difference(source).and_then(|(one, _)| self.index_of(one));
            let index = self.index_of(&source.column).or_else(first)?;
            let below = self.units.get(index).and_then(|unit| unit_names::unit_named(unit));
            let name = || words::told(self.names.get(index)?);
            let (of, unit) = below.or_else(name)?;
            let like = match source.quantity {
                Quantity::Supply => Quantity::Voltage,
                Quantity::Interval => Quantity::Time,
                Quantity::Target => Quantity::Angle,
                own => own,
            };
            (of == like).then(|| unit.to_owned())
        })
    }

    /// `duty=in1-in2` names two columns, where there is none of that whole name.
    fn difference<'s>(&self, source: &'s Source) -> Option<(&'s str, &'s str)> {
        if ![Quantity::Duty, Quantity::Voltage].contains(&source.quantity)
            || self.index_of(&source.column).is_some()
        {
            return None;
        }
        let splits = source.column.match_indices('-').map(|(at, _)| source.column.split_at(at));
        let mut pairs = splits.map(|(one, other)| (one.trim(), other[1..].trim()));
        pairs.find(|(one, other)| self.index_of(one).is_some() && self.index_of(other).is_some())
    }

    fn mapped(&self, source: &Source) -> Result<Wanted> {
        if let Some((one, other)) = self.difference(source) {
            let less = self.named(source.quantity, other, source.unit)?.index;
            let one = self.named(source.quantity, one, source.unit)?;
            return Ok(Wanted { less: Some(less), header: source.column.clone(), ..one });
        }
        self.named(source.quantity, &source.column, source.unit)
    }

    fn index_of(&self, column: &str) -> Option<usize> {
        let by_name = self.names.iter().position(|name| name == column);
        by_name.or_else(|| {
            column.parse().ok().filter(|&index| self.names.is_empty() || index < self.names.len())
        })
    }

    /// The column with the canonical name of a quantity; a row of units below it must not contradict.
    fn canonical(&self, quantity: Quantity) -> Result<Option<Wanted>> {
        let Some(header) = quantity.canonical() else { return Ok(None) };
        let Some(index) = self.names.iter().position(|name| name == header) else { return Ok(None) };
        self.only_one(header)?;
        let said = self.units.get(index).and_then(|unit| unit_names::unit_named(unit));
        if let Some((_, unit)) = said
            && Unit::parse(quantity, unit).map_or(true, |unit| unit.factor != 1.0)
        {
            let why = format!(
                "the unit below the header, or beside the numbers, is \"{unit}\", and the header says {}",
                quantity.si()
            );
            let remedy = format!(
                "say which is right: --map {quantity}={header}:{unit} or --map {quantity}={header}:{}",
                quantity.si()
            );
            return Err(BadInput::new(self.path, why, remedy).at_line(self.line).in_column(header).into());
        }
        Ok(Some(Wanted { quantity, index, less: None, header: header.to_owned(), unit: Unit::SI }))
    }

    fn only_one(&self, name: &str) -> Result<()> {
        if self.names.iter().filter(|other| *other == name).count() < 2 {
            return Ok(());
        }
        Err(BadInput::new(
            self.path,
            format!("two columns are called \"{name}\""),
            "rename one of them, or pick by number: --map time=0:s,...",
        )
        .at_line(self.line)
        .in_column(name)
        .into())
    }

    fn named(&self, quantity: Quantity, column: &str, mut unit: Unit) -> Result<Wanted> {
        let index =
            self.index_of(column).ok_or_else(|| self.absent(column, format_args!("for {quantity}")))?;
        if self.names.get(index).is_some_and(|name| name == column) {
            self.only_one(column)?;
        }
        let header = self.names.get(index).cloned().unwrap_or_else(|| index.to_string());
        if let Some(per_turn) = unit.per_turn {
            unit.factor /=
                self.one_turn(per_turn, quantity, column).map_err(|fault| fault.in_column(&header))?;
        }
        Ok(Wanted { quantity, index, less: None, header, unit })
    }

    /// What one turn of the output shaft is of a number that is none of turns.
    fn one_turn(&self, per_turn: PerTurn, quantity: Quantity, column: &str) -> Result<f64, BadInput> {
        self.meta.one_turn(per_turn).ok_or_else(|| {
            let (why, remedy) = per_turn.unknown(quantity, column);
            BadInput::new(self.path, why, remedy)
        })
    }

    /// The refusal where a column is absent, with what the table looks like.
    pub fn refusal(&self, missing: &Missing, guess: Guess) -> crate::error::Error {
        let remedy = match &guess {
            Guess::Proposed(proposal) => {
                format!("say which column is what and in which unit; it looks like {}", proposal.told())
            }
            Guess::Open(question) => question.clone(),
        };
        let proposal = if let Guess::Proposed(proposal) = guess { Some(proposal) } else { None };
        BadInput::new(self.path, format!("{}; the columns are {}", missing.why, self.listed()), remedy)
            .at_line(self.line)
            .in_column(missing.header)
            .proposing(proposal)
            .into()
    }

    fn listed(&self) -> String {
        const SHOWN: usize = 20;
        let mut text = self.names.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
        if self.names.len() > SHOWN {
            text += &format!(" and {} more", self.names.len() - SHOWN);
        }
        text
    }
}

/// What is absent of time, drive and motion.
fn missing(columns: &Columns) -> Option<Missing> {
    let has = |quantity| columns.values.iter().any(|column| column.quantity == quantity);
    // The target of a servo drives it only where nothing nearer to the motor was logged.
    if !has(Quantity::Voltage) && !has(Quantity::Duty) && has(Quantity::Target) {
        let why = "a target moves the motor by its angle, and no column gives the angle";
        return (!has(Quantity::Angle)).then_some(Missing { header: "angle_rad", why });
    }
    if !has(Quantity::Voltage) && !has(Quantity::Duty) {
        return Some(Missing {
            header: "voltage_v",
            why: "no column is called voltage_v or mapped as voltage or duty",
        });
    }
    if !has(Quantity::Angle) && !has(Quantity::Speed) {
        let why = "no column is called angle_rad or speed_rad_s or mapped as angle or speed";
        return Some(Missing { header: "angle_rad", why });
    }
    None
}

/// Whether the mapping makes a canonical column of this kind unwanted.
fn displaced(quantity: Quantity, map: Option<&Mapping>) -> bool {
    map.is_some_and(|map| match quantity {
        Quantity::Angle | Quantity::Speed => map.names_motion(),
        Quantity::Voltage => [Quantity::Duty, Quantity::Target].iter().any(|q| map.source(*q).is_some()),
        _ => false,
    })
}
