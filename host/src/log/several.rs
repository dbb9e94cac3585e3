//! Rows of several motors in one table, told apart by a column such as `id`: read as one they are no motor's.
//!
//! In turn, or under names, they are of several motors, of which one has to be chosen. Long blocks of numbers, one after another, may be
//! several tests of one motor as well: each is a record, and nothing is held from one to the next.

use std::collections::BTreeSet;
use std::path::Path;

use super::guess::{quoted, words};
use super::mapping::Mapping;
use super::only::Only;
use super::samples::FEWEST_SAMPLES;
use crate::error::BadInput;

/// What the column is called that tells the elements of a list in one file apart, each a test with arrays of its own.
pub(super) const ELEMENT: &str = "list_element";
/// Words that make the name of a column which tells the motors apart.
const WHOSE: [&str; 14] = [
    "id", "motor", "motors", "joint", "servo", "node", "can", "axis", "device", "wheel", "name", "index",
    "no", "number",
];
/// Of these, those that name nothing but what is driven: where such a column holds names, each is another motor's, in whatever order.
const DRIVEN: [&str; 6] = ["motor", "motors", "joint", "servo", "axis", "wheel"];
/// Of these, those that may number anything, the levels of a drive as well: alone they part no records.
const OF_ANYTHING: [&str; 3] = ["index", "no", "number"];
/// Of these, those that are called so where they are switched on and off too: 0 and 1 in such a column are no numbers of motors.
const SWITCHED: [&str; 4] = ["motor", "motors", "servo", "device"];
/// More values than this are no motors ...
const MOST: usize = 32;
/// ... and they take turns: in at least this share of the rows it is another one's.
const TURNS: f64 = 0.3;
/// ... or they come back so often, in blocks that are too short for records.
const OFTEN: usize = 2;

/// What a column that may tell motors apart says, row by row.
#[derive(Debug, Default)]
pub(super) struct Several {
    column: Option<(usize, String)>,
    values: BTreeSet<String>,
    last: String,
    changes: usize,
    rows: usize,
    /// Rows of the block so far.
    block: usize,
    /// The time goes back where another one's rows begin.
    goes_back: bool,
}

impl Several {
    /// Of a table whose columns have these `names`, of which those that are `read` tell something else.
    pub fn new(names: &[String], read: impl Fn(usize) -> bool) -> Self {
        let is_whose = |name: &String| {
            let words = words::of(name);
            !words.is_empty() && words.iter().all(|word| WHOSE.contains(&word.as_str()))
        };
        let mut columns = names.iter().enumerate().filter(|(k, _)| !read(*k));
        let column = columns.clone().find(|(_, name)| *name == ELEMENT);
        let column = column.or_else(|| columns.find(|(_, name)| is_whose(name)));
        Self { column: column.map(|(k, name)| (k, name.clone())), ..Self::default() }
    }

    /// Where that column stands.
    pub fn column(&self) -> Option<usize> {
        self.column.as_ref().map(|(k, _)| *k)
    }

    /// Where that column stands, if its blocks are records of their own.
    pub fn parting(&self) -> Option<usize> {
        let (k, header) = self.column.as_ref()?;
        words::of(header).iter().any(|word| !OF_ANYTHING.contains(&word.as_str())).then_some(*k)
    }

    /// Its name, where its blocks are records of their own and there are several values.
    pub fn parted_by(&self) -> Option<&str> {
        let (_, header) = self.column.as_ref().filter(|_| self.parting().is_some() && !self.is_switch())?;
        (self.values.len() > 1).then_some(header.as_str())
    }

    /// Takes what a row says there, and tells whether it ends a block that is long enough for a record. Where it says nothing the last
    /// value holds.
    pub fn saw(&mut self, text: &str) -> bool {
        self.rows += 1;
        self.block += 1;
        if text.is_empty() || self.last == text {
            return false;
        }
        let is_long = self.block > FEWEST_SAMPLES;
        let most = if self.is_of_list() { usize::MAX } else { MOST };
        self.changes += 1;
        self.block = 1;
        text.clone_into(&mut self.last);
        if self.values.len() <= most {
            self.values.insert(text.to_owned());
        }
        is_long && self.values.len() <= most && self.parting().is_some() && !self.is_switch()
    }

    /// Whether the column tells the elements of a list apart, which are no motors.
    fn is_of_list(&self) -> bool {
        self.column.as_ref().is_some_and(|(_, header)| header == ELEMENT)
    }

    /// Whether the column may say when the one motor is switched on.
    fn is_switch(&self) -> bool {
        let mut words = self.column.iter().flat_map(|(_, header)| words::of(header));
        words.all(|word| SWITCHED.contains(&word.as_str()))
            && self
                .values
                .iter()
                .all(|value| value.parse::<f64>().is_ok_and(|value| value == 0.0 || value == 1.0))
    }

    /// Says that the time of the last row goes back.
    pub fn goes_back(&mut self) {
        self.goes_back |= self.block == 1;
    }

    /// The fault of rows that are those of several motors in turn, of a table that is read by `map`.
    pub fn fault(&self, path: &Path, map: Option<&Mapping>) -> Option<BadInput> {
        let (_, header) = self.column.as_ref().filter(|_| !self.is_of_list())?;
        let several = (2..=MOST).contains(&self.values.len());
        let in_short_blocks = self.parting().is_some()
            && !self.is_switch()
            && self.changes >= OFTEN * self.values.len()
            && self.rows < FEWEST_SAMPLES * self.changes;
        let in_turn = self.changes as f64 > TURNS * self.rows as f64 || in_short_blocks || self.goes_back;
        let of_driven = words::of(header).iter().any(|word| DRIVEN.contains(&word.as_str()));
        let named = of_driven && self.values.iter().all(|value| value.parse::<f64>().is_err());
        let mut values = self.values.iter();
        let first = values.next().filter(|_| several && (in_turn || named))?;
        let how = if in_turn { "in turn" } else { "one after another" };
        let others: Vec<&str> = values.take(3).map(String::as_str).collect();
        let only = Only { column: header.clone(), value: first.clone() };
        let map = map.cloned().unwrap_or_default().with_only(only).written();
        Some(
            BadInput::new(
                path,
                format!(
                    "the rows are of several motors {how}: \"{header}\" is {first}, {}",
                    others.join(", ")
                ),
                format!(
                    "read those of one, with --map {} where {header} is {first}, and so each motor by itself",
                    quoted(&map)
                ),
            )
            .in_column(header),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::file;
    use super::super::{ReadOptions, Record, read};

    fn rows(id: impl Fn(u32) -> String) -> String {
        let row =
            |k: u32| format!("{},{},{},{}\n", 0.01 * f64::from(k), id(k), k % 7, 0.1 * f64::from(k % 9));
        format!("time_s,motor_id,voltage_v,speed_rad_s\n{}", (0..200).map(row).collect::<String>())
    }

    #[test]
    fn rows_of_two_motors_in_turn_are_refused_and_one_motor_with_its_number_is_read() {
        let (_directory, path) = file(rows(|k| ["left", "right"][k as usize % 2].into()).as_bytes());
        let refused = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("several motors") && refused.contains("only=motor_id:left"), "{refused}");
        let (_directory, path) = file(rows(|k| format!("M{}", k / 100)).as_bytes());
        let refused = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(
            refused.contains("motors one after another") && refused.contains("only=motor_id:M0"),
            "{refused}"
        );
        for one in [rows(|_| "7".into()), rows(|k| k.to_string())] {
            let (_directory, path) = file(one.as_bytes());
            assert_eq!(read(&path, &ReadOptions::default()).unwrap()[0].len(), 200);
        }
    }

    #[test]
    fn blocks_of_numbers_are_records_whatever_their_clock_does() {
        let blocks = |header: &str, time: fn(u32) -> u32| {
            let row = |k: u32| format!("{},{},{},{}\n", 10 * time(k), k / 100 + 1, k % 7, k % 9);
            let text = format!("{header},u,w\n{}", (0..300).map(row).collect::<String>());
            let (_directory, path) = file(text.as_bytes());
            let map = Some("time=0:ms,voltage=u:V,speed=w:rad/s".parse().unwrap());
            read(&path, &ReadOptions { map, ..ReadOptions::default() }).unwrap()
        };
        // It goes on, starts anew, and goes back by a half.
        let times: [fn(u32) -> u32; 3] = [|k| k, |k| k % 100, |k| k - k / 100 * 50];
        for time in times {
            let records = blocks("t,servo", time);
            let names: Vec<&str> = records.iter().map(|r| r.name.as_str()).collect();
            assert_eq!(names, ["run servo 1 1", "run servo 2 2", "run servo 3 3"]);
            assert_eq!(records.iter().map(Record::len).collect::<Vec<_>>(), [100; 3]);
            let said = records[0].warnings.iter().find(|w| w.what.contains("by \"servo\"")).unwrap();
            assert!(said.fix.contains("only=servo:1"), "{said:?}");
        }
        // What may number the levels of a staircase parts nothing.
        assert_eq!(blocks("t,no", |k| k).len(), 1);
    }

    #[test]
    fn a_motor_that_is_switched_on_and_off_is_one() {
        let row = |k: u32| format!("{:.2},{},{},{}\n", 0.01 * f64::from(k), k / 50 % 2, k % 7, k % 9);
        let text = format!("time_s,motor,voltage_v,speed_rad_s\n{}", (0..300).map(row).collect::<String>());
        let (_directory, path) = file(text.as_bytes());
        assert_eq!(read(&path, &ReadOptions::default()).unwrap().len(), 1);
    }

    #[test]
    fn nothing_is_held_from_one_motor_to_the_next() {
        let row = |k: u32| {
            let volts = if k == 0 || k == 140 { "6" } else { "" };
            format!("{:.2},{},{volts},{}\n", 0.01 * f64::from(k), k / 100, k % 9)
        };
        let text = format!("time_s,id,voltage_v,speed_rad_s\n{}", (0..200).map(row).collect::<String>());
        let (_directory, path) = file(text.as_bytes());
        let lengths: Vec<usize> =
            read(&path, &ReadOptions::default()).unwrap().iter().map(Record::len).collect();
        assert_eq!(lengths, [100, 60]);
    }

    #[test]
    fn short_blocks_that_come_back_are_in_turn() {
        let times: [fn(u32) -> u32; 2] = [|k| k, |k| k / 20 * 10 + k % 10];
        for time in times {
            let row = |k: u32| format!("{},{},{},{}\n", time(k), k / 10 % 2, k % 7, k % 9);
            let text =
                format!("time_s,node,voltage_v,speed_rad_s\n{}", (0..400).map(row).collect::<String>());
            let (_directory, path) = file(text.as_bytes());
            let refused = read(&path, &ReadOptions::default()).unwrap_err().to_string();
            assert!(refused.contains("in turn") && refused.contains("--map only=node:0"), "{refused}");
        }
    }
}
