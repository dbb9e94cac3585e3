//! What stands before a line: when a serial monitor received it, or a board or a program said it, and with which level.

use super::clock::{self, Clock};
use super::pairs::{is_name_first, is_word};

/// Levels of loggers, in small letters.
const LEVELS: [&str; 14] = [
    "trace", "debug", "info", "notice", "warn", "warning", "error", "critical", "fatal", "inf", "dbg", "wrn",
    "err", "log",
];
/// Decimals of the seconds that a kernel writes, or more.
const KERNEL_DIGITS: usize = 3;

/// The stamp before a line, and the line: that of a serial monitor, `12:34:56.789 -> 1,2,3`, with a single `>`, or `[12:34:56.789] 1,2`;
/// that of a board's own log, `I (1234) motor: 1,2`, in ms since it started; that of ROS, `[INFO] [1700000000.25] [motor]: 1,2`, in s;
/// that of a program's logger, `2024-05-01 12:34:56,789 - motor - INFO - u=1 w=2`; that of a terminal, `2024-05-01 12:34:56.789 1,2`; that of
/// a kernel's log, `[   12.345678] u=1 w=2`, in s; a number in ms or s before values with names, `10 ms u=1 w=2`.
pub fn stamped(line: &str) -> Option<(&str, &str)> {
    if let Some(found) = logged(line).or_else(|| logged_by_ros(line)) {
        return Some(found);
    }
    if let Some((stamp, rest)) = line.strip_prefix('[').and_then(|inside| inside.split_once(']')) {
        let rest = rest.trim();
        let seconds = || seconds_in(stamp).filter(|_| !rest.is_empty());
        return Some((moment_in(stamp.trim()).or_else(seconds)?, behind_level(rest).unwrap_or(rest)));
    }
    let by_monitor = line.split_once("->").or_else(|| line.split_once(" > "));
    let by_monitor = by_monitor.map(|(stamp, rest)| (stamp.trim(), rest.trim()));
    let by_monitor = by_monitor.filter(|(stamp, _)| clock::moment(stamp).is_some());
    let by_program = || logged_between_colons(line).or_else(|| logged_by_program(line));
    by_monitor.or_else(by_program).or_else(|| counted(line))
}

/// The time of a stamp, s: a board counts milliseconds, ROS seconds with their fraction, a serial monitor reads a clock.
pub fn moment_of(stamp: &str, clock: &mut Clock) -> Option<f64> {
    let unit_s = if stamp.contains('.') { 1.0 } else { 1e-3 };
    clock.read(stamp, unit_s, stamp.parse().ok())
}

/// A line of ESP-IDF's log, perhaps in colour: its level, the stamp in brackets, its tag, and what was said.
fn logged(line: &str) -> Option<(&str, &str)> {
    let mut line = line;
    if let Some(coloured) = line.strip_prefix('\u{1b}') {
        line = coloured.split_once('m')?.1;
    }
    let line = line.split('\u{1b}').next()?;
    let (stamp, rest) = line.strip_prefix(['I', 'W', 'E', 'D', 'V'])?.strip_prefix(" (")?.split_once(')')?;
    let (_, said) = rest.split_once(": ")?;
    let is_stamp =
        !stamp.is_empty() && stamp.bytes().all(|b| b.is_ascii_digit()) || clock::moment(stamp).is_some();
    is_stamp.then_some((stamp, said.trim()))
}

/// A line of ROS's console: level, stamp and perhaps the node, each in brackets, and what was said.
fn logged_by_ros(line: &str) -> Option<(&str, &str)> {
    let (level, rest) = line.strip_prefix('[')?.split_once(']')?;
    let (stamp, rest) = rest.trim_start().strip_prefix('[')?.split_once(']')?;
    let is_level = !level.is_empty() && level.bytes().all(|b| b.is_ascii_alphabetic() || b == b' ');
    let is_stamp = stamp.contains('.') && stamp.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let rest = rest.trim_start();
    let said = rest.strip_prefix('[').and_then(|node| node.split_once(']')).map_or(rest, |(_, said)| said);
    (is_level && is_stamp).then(|| (stamp, said.trim_start_matches(':').trim()))
}

/// The clock time in what brackets hold: `12:34:56.789`, Zephyr's `00:00:01.234,567`, Tera Term's `Wed May 01 12:34:56.789 2024`.
fn moment_in(text: &str) -> Option<&str> {
    let is_moment = |text: &&str| clock::moment(text).is_some();
    let plain = Some(text).filter(is_moment);
    plain.or_else(|| {
        text.split_whitespace().find_map(|word| {
            let shorter = || word.rsplit_once(',').map(|(before, _)| before).filter(is_moment);
            Some(word).filter(is_moment).or_else(shorter)
        })
    })
}

/// The seconds in what brackets hold, as a kernel writes them, with the time since the line before behind them perhaps: a counter of lines has
/// no fraction.
fn seconds_in(text: &str) -> Option<&str> {
    let word = text.split_whitespace().next()?;
    (is_count(word) && word.rsplit('.').next().is_some_and(|part| part.len() >= KERNEL_DIGITS))
        .then_some(word)
}

/// Whether a text is a number with a fraction.
fn is_count(text: &str) -> bool {
    text.contains('.') && text.bytes().all(|b| b.is_ascii_digit() || b == b'.')
}

/// A line of Python's logging whose fields stand between colons: `2024-05-01 12:34:56,789:INFO:motor:u=1 w=2`.
fn logged_between_colons(line: &str) -> Option<(&str, &str)> {
    line.match_indices(':').find_map(|(at, _)| {
        let (word, said) = line[at + 1..].split_once(':')?;
        let stamp = line[..at].trim_end();
        (is_level(word.trim()) && clock::moment(stamp).is_some()).then(|| (stamp, said.trim()))
    })
}

/// A line whose time stands bare before it, or before a dash or a colon: behind that there is a level, or values with names, or a row that
/// something other than blanks separates. Seconds without a clock's colons are a time only before a level.
fn logged_by_program(line: &str) -> Option<(&str, &str)> {
    let blanks = line.match_indices(' ').map(|(at, _)| at);
    let ends: Vec<usize> = blanks.take(2).collect();
    let before = |end: &usize| line[..*end].trim_end_matches(':');
    let stamp = ends.iter().rev().map(before).find(|stamp| clock::moment(stamp).is_some());
    let stamp = stamp.or_else(|| ends.first().map(before).filter(|stamp| is_count(stamp)))?;
    let rest = line[stamp.len()..].trim_start_matches(':').trim_start();
    if let Some(said) = behind_level(rest) {
        return Some((stamp, said));
    }
    let rest = behind_bar(rest).unwrap_or(rest).trim_start();
    let separated = rest.contains([',', ';', '\t']) && !rest.replace(", ", ",").contains(' ');
    let first = line.split([',', ';', '\t']).next().unwrap_or_default();
    let is_row = separated && clock::moment(first).is_none();
    (!is_count(stamp) && (is_name_first(rest) || is_row)).then_some((stamp, rest))
}

/// A line before which a number with its unit stands, whole in ms or with a fraction in s: behind it there are values with names, or a colon parts
/// them.
fn counted(line: &str) -> Option<(&str, &str)> {
    let (count, rest) = line.split_at(line.find(|c: char| !c.is_ascii_digit() && c != '.')?);
    let rest = rest.trim_start();
    let (rest, is_whole) = match rest.strip_prefix("ms") {
        Some(rest) => (rest, true),
        None => (rest.strip_prefix('s')?, false),
    };
    let said = rest.trim_start_matches([' ', '\t', ':', ';', ',', '|']);
    let is_apart = rest.len() > said.len() && (rest.starts_with(':') || is_name_first(said));
    let is_time = count.parse::<f64>().is_ok() && count.contains('.') != is_whole;
    (is_apart && is_time).then_some((count, said))
}

/// What follows the dash or bar that parts the fields of a logger's line.
fn behind_bar(text: &str) -> Option<&str> {
    text.strip_prefix("- ").or_else(|| text.strip_prefix("| "))
}

/// What was said behind the level of a logger's line: `- motor - INFO - u=1`, `[INFO ] u=1`, `<inf> motor: u=1`.
fn behind_level(line: &str) -> Option<&str> {
    let mut rest = line;
    loop {
        rest = rest.trim_start();
        rest = behind_bar(rest).unwrap_or(rest).trim_start();
        let close = match rest.chars().next()? {
            '[' => rest.find(']').map(|at| at + 1),
            '<' => rest.find('>').map(|at| at + 1),
            _ => rest.find([' ', '\t']),
        };
        let (word, behind) = rest.split_at(close?);
        let word = word.trim_matches(['[', ']', '<', '>', ':', ' ']);
        let behind = behind.trim_start();
        if is_level(word) {
            let said = behind.trim_start_matches(':').trim_start();
            return Some(behind_place(behind_bar(said).unwrap_or(said).trim()));
        }
        // The name of who said it.
        let next =
            behind.split([' ', '\t']).next().unwrap_or_default().trim_matches(['[', ']', '<', '>', ':']);
        if !is_word(word) || behind_bar(behind).is_none() && !is_level(next) {
            return None;
        }
        rest = behind;
    }
}

fn is_level(word: &str) -> bool {
    LEVELS.iter().any(|level| word.eq_ignore_ascii_case(level))
}

/// What was said behind the place in a program, as Loguru names it: `__main__:run:42 - u=1`, `drive.py:42 - u=1`.
fn behind_place(text: &str) -> &str {
    let Some((place, said)) = text.split_once(" - ") else { return text };
    let line = place.rsplit(':').next().unwrap_or_default();
    let is_line = !line.is_empty() && line.bytes().all(|b| b.is_ascii_digit());
    let is_place = place.matches(':').count() == 2 || place.contains(".py:");
    if is_line && is_place && !place.contains(' ') { said.trim_start() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_of_monitors_boards_terminals_and_loggers_are_told_from_what_was_said() {
        for (line, stamp, said) in [
            ("12:34:56.789 -> 1,2", "12:34:56.789", "1,2"),
            ("[12:34:56.789] 1,2", "12:34:56.789", "1,2"),
            ("I (1234) motor: 1,2", "1234", "1,2"),
            ("[INFO] [1700000000.25] [motor]: 1,2", "1700000000.25", "1,2"),
            ("[Wed May 01 12:34:56.789 2024] u:1 w:2", "12:34:56.789", "u:1 w:2"),
            ("[00:00:01.234,567] <inf> motor: u: 1, w: 2", "00:00:01.234", "motor: u: 1, w: 2"),
            ("2024-05-01 12:34:56,789 - motor - INFO - u=1 w=2", "2024-05-01 12:34:56,789", "u=1 w=2"),
            ("2024-05-01 12:34:56,789 INFO u: 1, w: 2", "2024-05-01 12:34:56,789", "u: 1, w: 2"),
            ("2024-05-01 12:34:56.789 | INFO | 1,2", "2024-05-01 12:34:56.789", "1,2"),
            ("2024-05-01 12:34:56.789 1,2", "2024-05-01 12:34:56.789", "1,2"),
            ("12:34:56.789 u:1,w:2", "12:34:56.789", "u:1,w:2"),
            ("0.010000 [INFO ] u=1 w=2", "0.010000", "u=1 w=2"),
            ("12:34:56 - u: 1", "12:34:56", "u: 1"),
            ("12:34:56.789 | u: 1, w: 2", "12:34:56.789", "u: 1, w: 2"),
            ("12:34:56.789: u=1 w=2", "12:34:56.789", "u=1 w=2"),
            ("12:34:56.789 - 1,2", "12:34:56.789", "1,2"),
            ("2024-05-01 12:34:56,789 - u=1", "2024-05-01 12:34:56,789", "u=1"),
            ("12:34:56.789 [INFO] u: 1", "12:34:56.789", "u: 1"),
            ("2024-05-01 12:34:56,789:INFO:motor:u=1 w=2", "2024-05-01 12:34:56,789", "motor:u=1 w=2"),
            ("2024-05-01 12:34:56,789 motor INFO u=1 w=2", "2024-05-01 12:34:56,789", "u=1 w=2"),
            (
                "2024-05-01 12:34:56.789 | INFO     | __main__:run:42 - u=1 w=2",
                "2024-05-01 12:34:56.789",
                "u=1 w=2",
            ),
            ("2024-05-01 12:34:56,789 INFO drive.py:42 - u=1 w=2", "2024-05-01 12:34:56,789", "u=1 w=2"),
            ("[   12.345678] u=1 w=2", "12.345678", "u=1 w=2"),
            ("10 ms\tu:1\tw:2", "10", "u:1\tw:2"),
            ("10ms: 0.00V 0.5rad", "10", "0.00V 0.5rad"),
            ("0.01 s | u = 1 | w = 2", "0.01", "u = 1 | w = 2"),
            ("[12.345678 0.010002] u=1 w=2", "12.345678", "u=1 w=2"),
        ] {
            assert_eq!(stamped(line), Some((stamp, said)), "{line}");
        }
        for line in [
            "[1, 2]",
            "[0.010 120 345]",
            "[0.010, 120, 345]",
            "[7] u:1 w:2",
            "[a] 1,2",
            "I (x) motor: 1,2",
            "In (12) of: 3",
            "12:34:56.789 1 2",
            "12:34:56.789 1,5 2,5",
            "2024-05-01 12:34:56,1,2",
            "2024-05-01 12:34:56 +0200,1,2",
            "1:02:03 PM,1,2",
            "0.01 1,2",
            "0.01 u=1 w=2",
            "10 ms, 5 V, 3 rad/s",
            "0.01 ms u=1",
            "10 m u=1",
        ] {
            assert_eq!(stamped(line), None, "{line}");
        }
    }
}
