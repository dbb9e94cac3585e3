//! Rows of several motors in one table, told apart by a column such as `id`: read as one they are no motor's.

use std::collections::BTreeSet;
use std::path::Path;

use super::guess::words;
use crate::error::BadInput;

/// Words that make the name of a column which tells the motors apart.
const WHOSE: [&str; 14] = [
    "id", "motor", "motors", "joint", "servo", "node", "can", "axis", "device", "wheel", "name", "index",
    "no", "number",
];
/// Of these, those that name nothing but what is driven: where such a column holds names, each is another motor's, in whatever order.
const DRIVEN: [&str; 6] = ["motor", "motors", "joint", "servo", "axis", "wheel"];
/// More values than this are no motors ...
const MOST: usize = 32;
/// ... and they take turns: in at least this share of the rows it is another one's.
const TURNS: f64 = 0.3;

/// What a column that may tell motors apart says, row by row.
#[derive(Debug, Default)]
pub(super) struct Several {
    column: Option<(usize, String)>,
    values: BTreeSet<String>,
    last: String,
    changes: usize,
    rows: usize,
}

impl Several {
    /// Of a table whose columns have these `names`, of which those that are `read` tell something else.
    pub fn new(names: &[String], read: impl Fn(usize) -> bool) -> Self {
        let is_whose = |name: &String| {
            let words = words::of(name);
            !words.is_empty() && words.iter().all(|word| WHOSE.contains(&word.as_str()))
        };
        let column = names.iter().enumerate().find(|(k, name)| is_whose(name) && !read(*k));
        Self { column: column.map(|(k, name)| (k, name.clone())), ..Self::default() }
    }

    /// Where that column stands.
    pub fn column(&self) -> Option<usize> {
        self.column.as_ref().map(|(k, _)| *k)
    }

    /// Takes what a row says there.
    pub fn saw(&mut self, text: &str) {
        self.rows += 1;
        if self.last != text {
            self.changes += 1;
            text.clone_into(&mut self.last);
            if self.values.len() <= MOST {
                self.values.insert(text.to_owned());
            }
        }
    }

    /// The fault of rows that are those of several motors in turn.
    pub fn fault(&self, path: &Path) -> Option<BadInput> {
        let (_, header) = self.column.as_ref()?;
        let several = (2..=MOST).contains(&self.values.len());
        let in_turn = self.changes as f64 > TURNS * self.rows as f64;
        let of_driven = words::of(header).iter().any(|word| DRIVEN.contains(&word.as_str()));
        let named =
            of_driven && self.values.iter().all(|value| !value.is_empty() && value.parse::<f64>().is_err());
        let mut values = self.values.iter();
        let first = values.next().filter(|_| several && (in_turn || named))?;
        let how = if in_turn { "in turn" } else { "one after another" };
        let others: Vec<&str> = values.take(3).map(String::as_str).collect();
        Some(
            BadInput::new(
                path,
                format!(
                    "the rows are of several motors {how}: \"{header}\" is {first}, {}",
                    others.join(", ")
                ),
                format!("keep the rows of one, such as those where {header} is {first} (a spreadsheet's filter does)"),
            )
            .in_column(header),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::file;
    use super::super::{ReadOptions, read};

    fn rows(id: impl Fn(u32) -> String) -> String {
        let row =
            |k: u32| format!("{},{},{},{}\n", 0.01 * f64::from(k), id(k), k % 7, 0.1 * f64::from(k % 9));
        format!("time_s,motor_id,voltage_v,speed_rad_s\n{}", (0..200).map(row).collect::<String>())
    }

    #[test]
    fn rows_of_two_motors_in_turn_are_refused_and_one_motor_with_its_number_is_read() {
        let (_directory, path) = file(rows(|k| ["left", "right"][k as usize % 2].into()).as_bytes());
        let refused = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("several motors") && refused.contains("motor_id is left"), "{refused}");
        let (_directory, path) = file(rows(|k| format!("M{}", k / 100)).as_bytes());
        let refused = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(
            refused.contains("motors one after another") && refused.contains("motor_id is M0"),
            "{refused}"
        );
        for one in [rows(|_| "7".into()), rows(|k| k.to_string()), rows(|k| (k / 100).to_string())] {
            let (_directory, path) = file(one.as_bytes());
            assert_eq!(read(&path, &ReadOptions::default()).unwrap()[0].len(), 200);
        }
    }
}
