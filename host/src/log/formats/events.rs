//! Values that are logged each at its own time, many of them only when they change: the last one holds, never a future one; a motion is that
//! of its own stamps.

use std::collections::{BTreeMap, BTreeSet};

use super::Fault;
use super::stamps::{self, Readings};
use super::table::{Column, Table, Values};
use crate::log::guess::{self, words};
use crate::log::mapping::{Mapping, Source};
use crate::log::robot_loop::{clock, held_at, turn_s};
use crate::log::samples::Place;
use crate::log::structure;
use crate::log::sysid_entries::{Entries, Value};
use crate::log::sysid_names::group_of;
use crate::log::units::Quantity;

/// Columns that a mapping is guessed from where no group of them makes sense.
const GUESSED_FROM: usize = 60;
/// Parts of a stamp that are told.
const STAMP_PARTS: f64 = 1e6;

/// What was logged under one name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// Times, s, with numbers or texts as many.
    pub times: Vec<f64>,
    /// The numbers; none where they are texts.
    pub numbers: Vec<f64>,
    /// The texts; none where they are numbers.
    pub texts: Vec<String>,
    /// What the file says of it: a unit, perhaps.
    pub about: String,
}

impl Series {
    fn is_text(&self) -> bool {
        !self.texts.is_empty()
    }

    /// In the order of their times; a file need not keep it.
    fn sort(&mut self) {
        if self.times.is_sorted() {
            return;
        }
        let mut order: Vec<usize> = (0..self.times.len()).collect();
        order.sort_by(|a, b| self.times[*a].total_cmp(&self.times[*b]));
        self.times = order.iter().map(|k| self.times[*k]).collect();
        self.numbers = order.iter().filter_map(|k| self.numbers.get(*k).copied()).collect();
        self.texts = order.iter().filter_map(|k| self.texts.get(*k).cloned()).collect();
    }
}

/// All that a file logged.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Events {
    series: BTreeMap<String, Series>,
    /// Entries of other types, for messages.
    left_out: Vec<String>,
    /// Of stamps whose unit nothing tells, so many were taken for a second.
    stamps_per_s: Option<f64>,
}

impl Events {
    /// All series by name, and what else the file holds.
    pub fn new(series: BTreeMap<String, Series>, left_out: BTreeSet<String>) -> Events {
        let mut events = Events::default();
        for (name, mut series) in series {
            series.sort();
            // A mapping cannot name these characters.
            let name = name.replace([',', '"', '=', '$', '`', '\\'], "_");
            events.series.insert(name, series);
        }
        events.left_out = left_out.into_iter().collect();
        events
    }

    /// The same with stamps of which `per_s` were taken for a second, though nothing tells their unit: they are shown as they stand in the file, for
    /// a mapping to say it.
    #[must_use]
    pub fn with_stamps(mut self, per_s: f64) -> Events {
        self.stamps_per_s = Some(per_s);
        self
    }

    /// The column of the clock.
    fn clock(&self, times: &[f64]) -> Column {
        let Some(per_s) = self.stamps_per_s else {
            return Column { name: "time_s".into(), values: Values::Numbers(times.to_vec()) };
        };
        // Whole stamps are whole again.
        let written = |time_s: &f64| (time_s * per_s * STAMP_PARTS).round() / STAMP_PARTS;
        Column { name: "stamp".into(), values: Values::Numbers(times.iter().map(written).collect()) }
    }

    /// Whether `map` names entries of this file, or numbers of its columns: the way round SysId's own names.
    pub fn are_mapped(&self, map: Option<&Mapping>) -> bool {
        let motion = [Quantity::Angle, Quantity::Speed];
        let mut sources = motion.iter().filter_map(|quantity| map?.source(*quantity));
        sources.any(|source| self.series.contains_key(&source.column) || self.is_number(&source.column))
    }

    /// Whether a mapping means a column by its number.
    fn is_number(&self, column: &str) -> bool {
        !self.series.contains_key(column) && column.parse::<usize>().is_ok()
    }

    /// The entries as SysId's routines log them.
    pub fn sysid(&self) -> Entries {
        let mut entries = Entries::default();
        for (name, series) in &self.series {
            for (time_s, text) in series.times.iter().zip(&series.texts) {
                entries.saw_text(*time_s, name, text);
            }
            let values = series.times.iter().zip(&series.numbers).enumerate();
            for (k, (&time_s, &value)) in values {
                entries.saw_number(name, Value { time_s, value, place: Place::Entry(k) });
            }
            if !series.about.is_empty() {
                entries.saw_unit(name, &series.about);
            }
        }
        entries
    }

    /// The columns that `map` names, or those of the first group that has all that a fit needs: the motion at its own stamps and what
    /// drives the motor from its own on, or all on the clock of the one that was logged most often where no motion is named. Numbers of
    /// columns count in the table without a mapping, which is the one that a guess is made from.
    ///
    /// # Errors
    /// A fault where no value was logged.
    pub fn table(&self, map: Option<&Mapping>) -> Result<Table, Fault> {
        let mut hint = String::new();
        let sources = || Quantity::ALL.iter().filter_map(|quantity| map?.source(*quantity));
        let by_number = sources()
            .any(|source| source.column.split(['+', '-']).all(|column| self.is_number(column.trim())));
        let chosen: Vec<&str> = if map.is_some() && !by_number {
            let named: BTreeSet<&str> = sources().flat_map(Source::columns).collect();
            self.series.keys().map(String::as_str).filter(|name| named.contains(name)).collect()
        } else {
            let mut groups = self.groups();
            let first = if groups.is_empty() { self.telling() } else { groups.remove(0).1 };
            if !groups.is_empty() {
                let others: Vec<&str> = groups.iter().take(12).map(|(name, _)| name.as_str()).collect();
                hint = format!("other motors of this file: {}", others.join(", "));
            }
            first
        };
        let chosen = if chosen.is_empty() { self.telling() } else { chosen };
        let left_out = self.left_out.iter().cloned();
        let others = self.series.keys().filter(|name| !chosen.contains(&name.as_str())).cloned();
        Ok(self.tabulated(&chosen, map, others.chain(left_out).collect())?.hinting(hint))
    }

    /// Groups of numbers that belong to one motor and have all that a fit needs.
    fn groups(&self) -> Vec<(String, Vec<&str>)> {
        let mut groups: BTreeMap<String, Vec<&str>> = BTreeMap::new();
        for (name, series) in &self.series {
            if !series.is_text() && !series.times.is_empty() {
                groups.entry(group_of(name)).or_default().push(name);
            }
        }
        groups.retain(|_, names| {
            let plain: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
            guess::may_suffice(&plain)
        });
        groups.into_iter().collect()
    }

    /// The names that say a quantity, or the first few.
    fn telling(&self) -> Vec<&str> {
        let all = || self.series.iter().filter(|(_, s)| !s.times.is_empty()).map(|(name, _)| name.as_str());
        let say = |name: &&str| words::said(name).quantity.is_some();
        let telling: Vec<&str> = all().filter(say).take(GUESSED_FROM).collect();
        if telling.is_empty() { all().take(GUESSED_FROM).collect() } else { telling }
    }

    /// What each of the `chosen` measures: as `map` says, by name or by the number of its column, or as a canonical log has it.
    fn quantity(&self, name: &str, place: usize, map: Option<&Mapping>) -> Option<Quantity> {
        let number = place.to_string();
        Quantity::ALL.into_iter().find(|quantity| match map {
            Some(map) => map.source(*quantity).is_some_and(|source| {
                source.columns().any(|column| column == name || self.is_number(column) && column == number)
            }),
            None => quantity.canonical() == Some(name),
        })
    }

    fn tabulated(
        &self,
        chosen: &[&str],
        map: Option<&Mapping>,
        left_out: Vec<String>,
    ) -> Result<Table, Fault> {
        let numbers = || chosen.iter().filter_map(|name| self.series.get_key_value(*name));
        // The clock is the first column.
        let kind = |place: usize, name: &str| self.quantity(name, place + 1, map);
        let is_one = |place: usize, name: &str, kinds: [Quantity; 2]| {
            kind(place, name).is_some_and(|kind| kinds.contains(&kind))
        };
        let motions: BTreeMap<&str, Readings> = numbers()
            .enumerate()
            .filter(|(k, (name, series))| {
                !series.is_text() && is_one(*k, name, [Quantity::Angle, Quantity::Speed])
            })
            .map(|(_, (name, series))| (name.as_str(), Readings::of_motion(series)))
            .filter(|(_, readings)| readings.times.len() > 1)
            .collect();
        let states = self.series.iter().filter(|(name, s)| s.is_text() && structure::is_state(name));
        let moved = clock(motions.values().map(|readings| readings.times.as_slice()));
        let beat: &[f64] =
            moved.or_else(|| clock(numbers().map(|(_, s)| s.times.as_slice()))).unwrap_or_default();
        if beat.len() < 2 {
            let why = "no number was logged more than once";
            return Err(Fault::new(why, "check that the motor's entries were logged, and export them"));
        }
        let turn_s = turn_s(beat);
        // Before the last of them began, something is not known yet.
        let begin = numbers().filter_map(|(_, series)| series.times.first()).fold(f64::MIN, |a, b| a.max(*b));
        let drives = numbers().enumerate().filter(|(k, (name, _))| {
            moved.is_some() && is_one(*k, name, [Quantity::Voltage, Quantity::Duty])
        });
        let mut rows = stamps::joined(beat, drives.map(|(_, (_, series))| series.times.as_slice()));
        rows.retain(|(time, _)| time + turn_s >= begin);
        let times: Vec<f64> = rows.iter().map(|(time, _)| *time).collect();
        let mut columns = vec![self.clock(&times)];
        for (name, series) in numbers().chain(states) {
            // Of the turn that a reading is of, what was logged behind it too; between them, what was logged so far.
            let last = |(time, is_read): &(f64, bool)| {
                held_at(&series.times, time + if *is_read { turn_s } else { 0.0 })
            };
            let values = if series.is_text() {
                let text = |row| last(row).and_then(|k| series.texts.get(k)).cloned().unwrap_or_default();
                Values::Texts(rows.iter().map(text).collect())
            } else if let Some(readings) = motions.get(name.as_str()) {
                let read = readings.at(&times, turn_s).into_iter().zip(&rows);
                Values::Numbers(read.map(|(value, row)| if row.1 { value } else { f64::NAN }).collect())
            } else {
                let number = |row| last(row).and_then(|k| series.numbers.get(k)).copied().unwrap_or(f64::NAN);
                Values::Numbers(rows.iter().map(number).collect())
            };
            columns.push(Column { name: name.clone(), values });
        }
        Ok(Table::of(columns, left_out)?.with_own_stamps(rows.iter().any(|row| !row.1)))
    }
}

#[cfg(test)]
mod tests {
    use std::io::BufRead;

    use super::*;

    fn series(times: &[f64], numbers: &[f64]) -> Series {
        Series { times: times.to_vec(), numbers: numbers.to_vec(), ..Series::default() }
    }

    #[test]
    fn a_value_holds_until_the_next_and_never_before_it_was_logged() {
        let all = [
            ("/arm/Voltage".to_owned(), series(&[0.1, 0.5], &[1.0, 2.0])),
            ("/arm/Velocity".to_owned(), series(&[0.0, 0.1, 0.2, 0.4, 0.6], &[9.0, 1.0, 2.0, 4.0, 6.0])),
        ];
        let events = Events::new(all.into_iter().collect(), BTreeSet::new());
        let map: Mapping = "voltage=/arm/Voltage:V,speed=/arm/Velocity:rad/s".parse().unwrap();
        let table = events.table(Some(&map)).unwrap();
        let column = |time_s: &[f64], voltage: &[f64], velocity: &[f64]| {
            let column = |name: &str, values: &[f64]| Column {
                name: name.into(),
                values: Values::Numbers(values.to_vec()),
            };
            let columns = vec![
                column("time_s", time_s),
                column("/arm/Velocity", velocity),
                column("/arm/Voltage", voltage),
            ];
            Table::of(columns, vec![]).unwrap()
        };
        let read = |table: Table| table.text().lines().map(Result::unwrap).collect::<Vec<_>>();
        assert_eq!(
            read(table)[1..],
            ["0.1,1.0,1.0", "0.2,2.0,1.0", "0.4,4.0,1.0", "0.5,,2.0", "0.6,6.0,2.0"],
            "the voltage has a row of its own, in which no motion was read"
        );
        // Where nobody says yet which is the motion, all are shown on one clock.
        let table = events.table(None).unwrap();
        assert_eq!(table, column(&[0.1, 0.2, 0.4, 0.6], &[1.0, 1.0, 1.0, 2.0], &[1.0, 2.0, 4.0, 6.0]));
    }

    #[test]
    fn numbers_of_columns_count_in_the_table_that_the_guess_is_made_from() {
        let times = [0.0, 0.1, 0.2];
        let names = ["/a/Temperature", "/arm/Velocity", "/arm/Voltage", "/wrist/Velocity", "/wrist/Voltage"];
        let all = names.map(|name| (name.to_owned(), series(&times, &[1.0, 2.0, 3.0])));
        let events = Events::new(all.into_iter().collect(), BTreeSet::new());
        let guessed = events.table(None).unwrap();
        let by_number: Mapping = "time=0:s,speed=1:rad/s,voltage=2:V".parse().unwrap();
        assert_eq!(events.table(Some(&by_number)).unwrap(), guessed);
        let mixed: Mapping = "time=time_s:s,speed=1:rad/s,voltage=/arm/Voltage:V".parse().unwrap();
        assert_eq!(events.table(Some(&mixed)).unwrap(), guessed);
        assert!(events.are_mapped(Some(&by_number)));
        let named: Mapping = "speed=/wrist/Velocity,voltage=/wrist/Voltage".parse().unwrap();
        assert_ne!(events.table(Some(&named)).unwrap(), guessed);
    }

    #[test]
    fn times_out_of_order_are_put_in_order() {
        let mut mixed = series(&[0.2, 0.0, 0.1], &[2.0, 0.0, 1.0]);
        mixed.sort();
        assert_eq!(mixed, series(&[0.0, 0.1, 0.2], &[0.0, 1.0, 2.0]));
    }
}
