//! What Octave saves as text (`save -text`, its default): variables one after the other, each below its name, its type and its size.
//!
//! A file whose first variable is a matrix of several columns is a table below remarks, and is left to the reader of those.

use super::table::{Column, Table, Values, matrix};
use super::{Content, Fault};
use crate::log::text;

/// How such a file begins.
const CREATED: &str = "# Created by Octave";

/// A variable as it is read.
#[derive(Debug, Default)]
struct Variable {
    name: String,
    kind: String,
    /// Rows and columns; zeros where the file tells none.
    size: [usize; 2],
    /// Its size stands in the next line, and its numbers column after column.
    of_dimensions: bool,
    numbers: Vec<f64>,
}

/// Whether a file that begins so is one of variables.
pub fn is(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let is_name = |line: &&str| told(line, "name").is_some();
    let mut first = text.lines().skip_while(|line| !is_name(line)).skip(1).take_while(|line| !is_name(line));
    let columns = first.find_map(|line| told(line, "columns")).unwrap_or("1");
    text.starts_with(CREATED) && text.lines().any(|line| is_name(&line)) && columns == "1"
}

/// What a line tells by this key.
fn told<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    line.strip_prefix("# ")?.strip_prefix(key)?.strip_prefix(':').map(str::trim)
}

/// Reads such a file.
///
/// # Errors
/// A fault where it is no text, or holds no numbers.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let text = text::whole(all);
    let text = text.map_err(|why| Fault::new(why.to_string(), "save the variables again"))?;
    let mut variables: Vec<Variable> = Vec::new();
    for line in text.lines() {
        if let Some(name) = told(line, "name") {
            variables.push(Variable { name: name.to_owned(), ..Variable::default() });
            continue;
        }
        if let Some(variable) = variables.last_mut() {
            variable.take(line);
        }
    }
    let longest = variables.iter().map(|variable| variable.numbers.len()).max().unwrap_or(0);
    let (mut columns, mut left_out) = (Vec::new(), Vec::new());
    for variable in variables {
        let name = variable.name.clone();
        let own = variable.columns(longest);
        if own.is_empty() {
            left_out.push(name);
        }
        columns.extend(own);
    }
    Table::of(columns, left_out).map(Content::Table)
}

impl Variable {
    fn take(&mut self, line: &str) {
        let count = |text: &str| text.parse().unwrap_or(0);
        if let Some(kind) = told(line, "type") {
            kind.clone_into(&mut self.kind);
        } else if let Some(rows) = told(line, "rows") {
            self.size[0] = count(rows);
        } else if let Some(columns) = told(line, "columns") {
            self.size[1] = count(columns);
        } else if told(line, "ndims").is_some() {
            self.of_dimensions = true;
        } else if !line.starts_with('#') {
            let words = line.split_whitespace();
            if self.of_dimensions && self.size == [0, 0] {
                let mut sizes = words.map(count);
                self.size = [sizes.next().unwrap_or(0), sizes.next().unwrap_or(0)];
                return;
            }
            // What was not available is NA.
            self.numbers.extend(words.map(|word| word.parse().unwrap_or(f64::NAN)));
        }
    }

    /// Its columns; none where it is no matrix of numbers, or a range of more than `most`: a line of it stands for any number of rows.
    fn columns(self, most: usize) -> Vec<Column> {
        let is_of_numbers = ["matrix", "scalar", "range"].iter().any(|kind| self.kind.ends_with(kind));
        if !is_of_numbers || self.kind.contains("complex") || self.numbers.is_empty() {
            return Vec::new();
        }
        let one =
            |numbers: Vec<f64>| vec![Column { name: self.name.clone(), values: Values::Numbers(numbers) }];
        if self.kind.ends_with("range") {
            let [base, limit, step] = self.numbers[..] else { return Vec::new() };
            let count = ((limit - base) / step + 1e-9).floor();
            if !(0.0..most as f64).contains(&count) {
                return Vec::new();
            }
            return one((0..=count as usize).map(|k| base + step * k as f64).collect());
        }
        let width = self.size[1].max(1);
        let rows = self.numbers.len() / width;
        if rows == 0 || self.kind.ends_with("scalar") || width == 1 {
            return one(self.numbers);
        }
        if self.of_dimensions {
            return matrix(&self.name, rows, width, &self.numbers[..rows * width]);
        }
        let turned = (0..width).flat_map(|column| (0..rows).map(move |row| row * width + column));
        let by_column: Vec<f64> = turned.map(|place| self.numbers[place]).collect();
        matrix(&self.name, rows, width, &by_column)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::read_tests::file;
    use super::super::super::{ReadOptions, read};
    use super::*;

    fn saved(variables: &[(&str, &str, &str)]) -> String {
        let mut text = format!("{CREATED} 8.4.0, Wed May 01 12:00:00 2024 CEST <user@host>\n");
        for (name, head, numbers) in variables {
            text += &format!("# name: {name}\n{head}{numbers}\n\n\n");
        }
        text
    }

    fn column(value: impl Fn(f64) -> f64) -> String {
        (0..100).map(|k| format!(" {}\n", value(0.01 * f64::from(k)))).collect()
    }

    #[test]
    fn the_variables_of_a_file_are_its_columns() {
        let head = "# type: matrix\n# rows: 100\n# columns: 1\n";
        let (volts, theta) = (column(|t| (3.0 * t).sin()), column(|t| t * t));
        let both: String = volts.lines().zip(theta.lines()).map(|(u, x)| format!("{u}{x}\n")).collect();
        let range = ("t", "# type: range\n# base, limit, increment\n", "0 0.99 0.01\n");
        for (text, map) in [
            (
                saved(&[
                    ("t", head, column(|t| t).as_str()),
                    ("u", head, volts.as_str()),
                    ("theta", head, theta.as_str()),
                ]),
                "time=t,voltage=u,angle=theta",
            ),
            (
                saved(&[range, ("data", "# type: matrix\n# rows: 100\n# columns: 2\n", both.as_str())]),
                "time=t,voltage=data(1),angle=data(2)",
            ),
            (
                saved(&[
                    ("run", "# type: scalar struct\n# ndims: 2\n 1 1\n# length: 3\n", ""),
                    ("dt", "# type: scalar\n", "0.01\n"),
                    ("u", "# type: single matrix\n# ndims: 2\n 100 1\n", volts.as_str()),
                    ("theta", head, theta.as_str()),
                ]),
                "voltage=u,angle=theta",
            ),
        ] {
            assert!(is(text.as_bytes()));
            let (_directory, path) = file(text.as_bytes());
            let options = ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() };
            let record = read(&path, &options).unwrap_or_else(|error| panic!("{map}: {error}")).remove(0);
            assert_eq!(record.len(), 100, "{map}");
            assert!((record.time_s[99] - record.time_s[0] - 0.99).abs() < 1e-9, "{map}");
            assert!((record.angle_rad.as_ref().unwrap()[50] - 0.25).abs() < 1e-9, "{map}");
        }
        // A table below remarks is one.
        let table = saved(&[("data", "# type: matrix\n# rows: 100\n# columns: 2\n", both.as_str())]);
        assert!(!is(table.as_bytes()));
    }

    #[test]
    fn a_range_that_is_longer_than_all_that_was_saved_is_none() {
        let columns = |most: usize| {
            let numbers = vec![0.0, 0.99, 0.01];
            let range = Variable { kind: "range".into(), numbers, ..Variable::default() };
            range.columns(most).len()
        };
        assert_eq!([100, 99, 0].map(columns), [1, 0, 0]);
    }
}
