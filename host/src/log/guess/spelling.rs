//! How a name is spelt: what stands in its brackets, and the words that it is made of.

use super::unit_names::unit_named;
use super::vocabulary::CLOCKS;

/// The name without what stands in its brackets, and that.
pub(super) fn bracketed(name: &str) -> (String, Option<String>) {
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
        if let Some((before, rest)) = name.split_once(open)
            && let Some((inside, after)) = rest.split_once(close)
        {
            return (format!("{before}{after}").trim().to_owned(), Some(inside.trim().to_owned()));
        }
    }
    // "Position / rad", "Zeit in s", "tension en V".
    for between in [" / ", " in ", " en ", ", "] {
        if let Some((before, unit)) = name.rsplit_once(between)
            && unit_named(unit.trim()).is_some()
        {
            return (before.trim().to_owned(), Some(unit.trim().to_owned()));
        }
    }
    // As laboratories write it: `U/V`, `n/min^-1`; `rad/s` is a unit itself, and `velocity rad/s` ends with one.
    if let Some((before, unit)) = name.trim().split_once('/')
        && unit_named(name.trim()).is_none()
        && !before.is_empty()
        && before.chars().all(char::is_alphabetic)
        && unit_named(before).is_none_or(|_| before.chars().count() == 1)
        // `n/min` are turns.
        && unit_named(unit).is_some_and(|(_, unit)| !unit.starts_with("s*") || CLOCKS.contains(&before.to_lowercase().as_str()))
    {
        return (before.to_owned(), Some(unit.to_owned()));
    }
    (name.trim().to_owned(), None)
}

/// The words of a name in small letters: split at everything that is no letter, and where small letters turn large.
pub(in crate::log) fn of(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in name.chars() {
        let turn = before.is_lowercase() && c.is_uppercase();
        if !c.is_alphabetic() || turn {
            words.push(String::new());
        }
        if c.is_alphabetic()
            && let Some(word) = words.last_mut()
        {
            word.extend(c.to_lowercase());
        }
        before = c;
    }
    words.retain(|word| !word.is_empty());
    words
}
