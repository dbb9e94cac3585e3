//! YAML as programs print it: `ros2 topic echo` with `---` between its messages, a list of samples, an object of columns.
//!
//! Read is what such programs write: keys above indented blocks, lists of either kind, numbers, words and texts in quotes. It becomes JSON, whose
//! reader makes the table; anchors, tags and texts over several lines are none of a log.

use serde_json::{Map, Value};

use super::objects;
use super::{Content, Fault};
use crate::log::text;

/// Deeper blocks are none of a log.
const DEEPEST: usize = 16;

const REMEDY: &str = "write it as JSON, which is read (python -m pip install pyyaml): python -c \"import json, yaml; \
                      docs = [one for one in yaml.safe_load_all(open('OLD')) if one]; \
                      json.dump(docs if len(docs) > 1 else docs[0], open('NEW.json', 'w'))\"; of a ROS topic: ros2 topic echo --csv TOPIC > NEW.csv";

/// Whether a text begins with a key that has nothing behind it but indented lines or a list below it, or with a list of keys.
pub fn is(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let mut lines =
        text.lines().map(str::trim_end).filter(|line| !matches!(*line, "" | "---") && !line.starts_with('#'));
    let (Some(first), Some(second)) = (lines.next(), lines.next()) else { return false };
    let is_key = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || c == '_');
    let is_bare = first.strip_suffix(':').is_some_and(is_key);
    let item = |line: &str| {
        let item = line.strip_prefix("- ")?.trim_start_matches('{');
        item.split_once(':')
            .filter(|(key, rest)| is_key(key) && (rest.is_empty() || rest.starts_with(' ')))
            .map(|_| ())
    };
    let goes_on = second.starts_with("  ") || item(second).is_some();
    is_bare && (goes_on || second.starts_with("- ")) || item(first).is_some() && goes_on
}

/// Reads such a file.
///
/// # Errors
/// A fault where it is no text, or holds no table.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let text = text::whole(all);
    let text = text.map_err(|why| Fault::new(why.to_string(), REMEDY))?;
    let mut json = String::new();
    for document in text.split("\n---").map(document).filter(|value| !value.is_null()) {
        json.push_str(&document.to_string());
        json.push('\n');
    }
    let table = objects::read(json.as_bytes());
    let table =
        table.map_err(|fault| Fault::new(format!("no table is found in it ({})", fault.why), REMEDY))?;
    Ok(Content::Table(table))
}

/// A document between two lines of dashes.
fn document(text: &str) -> Value {
    let is_told = |line: &&str| !matches!(line.trim(), "" | "---" | "...") && !line.trim().starts_with('#');
    let lines = text.lines().filter(is_told).map(|line| {
        let text = line.trim_start();
        Line { indent: line.len() - text.len(), text: text.trim_end() }
    });
    Lines { lines: lines.collect(), at: 0 }.block(0, 0)
}

/// A line without the blanks around it.
#[derive(Debug, Clone, Copy)]
struct Line<'a> {
    indent: usize,
    text: &'a str,
}

/// The lines of a document.
struct Lines<'a> {
    lines: Vec<Line<'a>>,
    at: usize,
}

impl<'a> Lines<'a> {
    /// The next line, where it is indented so far at least.
    fn next_within(&self, indent: usize) -> Option<Line<'a>> {
        self.lines.get(self.at).copied().filter(|line| line.indent >= indent)
    }

    /// The next line, where it is indented so far; what is indented further is no part of what came before it, and is left out.
    fn next_at(&mut self, indent: usize) -> Option<Line<'a>> {
        while let Some(line) = self.next_within(indent) {
            if line.indent == indent {
                return Some(line);
            }
            self.at += 1;
        }
        None
    }

    /// The block that begins at the next line and is indented so far at least.
    fn block(&mut self, indent: usize, depth: usize) -> Value {
        match self.next_within(indent) {
            Some(_) if depth > DEEPEST => {
                self.at += 1;
                Value::Null
            }
            Some(line) if item(line.text).is_some() => self.list(line.indent, depth),
            Some(line) => self.map(line.indent, depth),
            None => Value::Null,
        }
    }

    /// A list whose dashes are indented so far.
    fn list(&mut self, indent: usize, depth: usize) -> Value {
        let mut all = Vec::new();
        while let Some(line) = self.next_at(indent) {
            let Some(rest) = item(line.text) else { break };
            if rest.is_empty() {
                self.at += 1;
                all.push(self.block(indent + 1, depth + 1));
            } else if !rest.starts_with(['{', '[']) && key(rest).is_some() {
                // A key behind the dash begins a block that is indented as far as it stands.
                let begin = line.indent + line.text.len() - rest.len();
                self.lines[self.at] = Line { indent: begin, text: rest };
                all.push(self.block(begin, depth + 1));
            } else {
                self.at += 1;
                all.push(flow(rest, 0));
            }
        }
        Value::Array(all)
    }

    /// Keys that are indented so far.
    fn map(&mut self, indent: usize, depth: usize) -> Value {
        let mut all = Map::new();
        while let Some(line) = self.next_at(indent) {
            self.at += 1;
            let Some((name, rest)) = key(line.text) else { continue };
            let is_list = |next: &Line<'_>| next.indent == indent && item(next.text).is_some();
            let value = match self.next_within(indent) {
                _ if !rest.is_empty() => flow(rest, 0),
                // A list may stand as far left as its key.
                Some(next) if next.indent > indent || is_list(&next) => self.block(next.indent, depth + 1),
                _ => Value::Null,
            };
            all.insert(name.to_owned(), value);
        }
        if all.is_empty() { Value::Null } else { Value::Object(all) }
    }
}

/// What stands behind the dash of an item.
fn item(text: &str) -> Option<&str> {
    if text == "-" { Some("") } else { text.strip_prefix("- ").map(str::trim_start) }
}

/// A key, and what stands behind its colon.
fn key(text: &str) -> Option<(&str, &str)> {
    let (name, rest) = text.split_once(':')?;
    let name = name.trim_matches(['"', '\'', ' ']);
    (!name.is_empty() && (rest.is_empty() || rest.starts_with(' '))).then_some((name, rest.trim()))
}

/// A value on one line: a number, a word, `[1, 2]`, `{a: 1, b: 2}`.
fn flow(text: &str, depth: usize) -> Value {
    let text = text.trim();
    let inside = |open: char, close: char| text.strip_prefix(open)?.strip_suffix(close);
    if depth > DEEPEST {
        return Value::Null;
    }
    if let Some(all) = inside('[', ']') {
        return Value::Array(parts(all).into_iter().map(|part| flow(part, depth + 1)).collect());
    }
    if let Some(all) = inside('{', '}') {
        let pair = |part| key(part).map(|(name, rest)| (name.to_owned(), flow(rest, depth + 1)));
        return Value::Object(parts(all).into_iter().filter_map(pair).collect());
    }
    if let Some(quoted) = inside('"', '"').or_else(|| inside('\'', '\'')) {
        return Value::String(quoted.to_owned());
    }
    // A remark behind a value.
    let text = text.split(" #").next().unwrap_or_default().trim_end();
    match text {
        "true" | "True" => Value::Bool(true),
        "false" | "False" => Value::Bool(false),
        "" | "~" | "null" => Value::Null,
        _ => match text.parse::<f64>() {
            Ok(number) => text.parse::<i64>().map(Value::from).unwrap_or_else(|_| Value::from(number)),
            Err(_) if text.starts_with(['.', '-']) && text.ends_with(['n', 'N', 'f', 'F']) => Value::Null,
            Err(_) => Value::String(text.to_owned()),
        },
    }
}

/// The parts between the commas that stand in no brackets of their own.
fn parts(text: &str) -> Vec<&str> {
    let (mut all, mut begin, mut open) = (Vec::new(), 0, 0_i32);
    for (at, c) in text.char_indices() {
        match c {
            '[' | '{' => open += 1,
            ']' | '}' => open -= 1,
            ',' if open == 0 => {
                all.push(&text[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
    }
    all.push(&text[begin..]);
    all.retain(|part| !part.trim().is_empty());
    all
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use serde_json::json;

    use super::super::super::read_tests::file;
    use super::super::super::{ReadOptions, read};
    use super::*;

    #[test]
    fn keys_lists_and_values_are_those_of_yaml() {
        let echo = "header:\n  stamp:\n    sec: 17\n    nanosec: 250\n  frame_id: ''\nname:\n- wheel\nposition:\n- 0.5\n- -1.0e-05\n\
                    velocity: []\n";
        assert_eq!(
            document(echo),
            json!({
                "header": {"stamp": {"sec": 17, "nanosec": 250}, "frame_id": ""},
                "name": ["wheel"], "position": [0.5, -1e-5], "velocity": []
            })
        );
        let samples = "# by hand\nmotor:\n  name: \"x: y\"\nsamples:\n  - time: 0.0  # s\n    pwm: 1\n  - {time: 0.1, pwm: 2, q: [1, 2]}\n\
                       \x20 -\n    time: 0.2\n";
        assert_eq!(
            document(samples),
            json!({
                "motor": {"name": "x: y"},
                "samples": [{"time": 0.0, "pwm": 1}, {"time": 0.1, "pwm": 2, "q": [1, 2]}, {"time": 0.2}]
            })
        );
        assert_eq!(
            document("a: .nan\nb: true\nc: ~\nd: on"),
            json!({"a": null, "b": true, "c": null, "d": "on"})
        );
        let deep: String = (0..200).map(|k| format!("{}a:\n", " ".repeat(k))).collect();
        for text in [deep.as_str(), "- - - 1", "a\n b\nc", "[[[[", "{a: {b: [", ": 1", "- a: 1\n b: 2\n"] {
            document(text);
        }
    }

    #[test]
    fn messages_of_a_topic_and_lists_of_samples_are_tables() {
        let (mut echo, mut list) = (String::new(), String::from("---\n"));
        for k in 0..100 {
            let t = 0.02 * f64::from(k);
            let (u, x) = ((3.0 * t).sin(), t * t);
            let _ = write!(
                echo,
                "header:\n  stamp:\n    sec: {}\n    nanosec: {}\n  frame_id: ''\nposition:\n- {x}\neffort:\n- {u}\n---\n",
                1_700_000_000 + k / 50,
                k % 50 * 20_000_000
            );
            let _ = writeln!(list, "- {{time: {t}, u: {u}, theta: {x}}}");
        }
        for (text, map) in [
            (echo, "time=header.stamp.sec+header.stamp.nanosec:ns,voltage=effort[0]:V,angle=position[0]:rad"),
            (list, "time=time,voltage=u,angle=theta"),
        ] {
            assert!(is(text.as_bytes()));
            let (_directory, path) = file(text.as_bytes());
            let options = ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() };
            let record = read(&path, &options).unwrap().remove(0);
            assert_eq!(record.len(), 100, "{map}");
            assert!((record.time_s[99] - record.time_s[0] - 1.98).abs() < 1e-6, "{map}");
            assert!((record.angle_rad.as_ref().unwrap()[50] - 1.0).abs() < 1e-9, "{map}");
        }
        let (_directory, path) = file(b"motor:\n  name: x\n  kind: y\n");
        let refused = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("no table") && refused.contains("safe_load_all"), "{refused}");
    }

    #[test]
    fn what_is_no_yaml_is_left_to_the_reader_of_texts() {
        for start in ["Results:\n12,13\n", "pwm: 80\nenc: 7\n", "time,voltage\n"] {
            assert!(!is(start.as_bytes()), "{start}");
        }
    }
}
