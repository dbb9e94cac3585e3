//! The user's effects beside the library's.
//!
//! A description is kept once in a process and lives as long as it: fits hold many copies of its name. Callers do not see each
//! other's: two of them may describe different effects by one name. Only what a program offers by its options is there by name.

use std::sync::Mutex;

use motorlens_shared::effects::{Kind, UserDefined};

use super::Written;
use super::definition::Wrong;

struct Entry {
    written: Written,
    kind: Kind,
    /// Named by the user for this run, so that searches try it.
    offered: bool,
}

static DEFINED: Mutex<Vec<Entry>> = Mutex::new(Vec::new());

fn defined<T>(look: impl FnOnce(&mut Vec<Entry>) -> T) -> T {
    // A panic elsewhere leaves the list whole: entries are pushed, and offered, in one step.
    look(&mut DEFINED.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
}

/// The effect that `written` describes; the same description gives the same effect.
///
/// # Errors
/// A description that is wrong.
pub fn define(written: &Written) -> Result<Kind, Wrong> {
    defined(|list| {
        if let Some(entry) = list.iter().find(|e| e.written == *written) {
            return Ok(entry.kind);
        }
        let kind = Kind::Formula(UserDefined(written.define()?));
        list.push(Entry { written: written.clone(), kind, offered: false });
        Ok(kind)
    })
}

/// Whether another effect than `kind` is offered by its name.
pub(super) fn is_taken(kind: Kind) -> bool {
    defined(|list| list.iter().any(|e| e.offered && e.kind != kind && e.written.name == kind.name()))
}

/// Lets the program's searches try `kind`, and find it by its name.
pub fn offer(kind: Kind) {
    defined(|list| list.iter_mut().filter(|e| e.kind == kind).for_each(|e| e.offered = true));
}

/// The library's effects, and the user's that were offered.
pub fn all() -> Vec<Kind> {
    let own = defined(|list| list.iter().filter(|e| e.offered).map(|e| e.kind).collect::<Vec<_>>());
    Kind::ALL.iter().copied().chain(own).collect()
}

/// The effect called `name`: the library's, one that was offered, or the one last read from a model.
pub fn by_name(name: &str) -> Option<Kind> {
    let own = |offered: bool| {
        defined(|list| {
            list.iter().rfind(|e| e.written.name == name && (e.offered || !offered)).map(|e| e.kind)
        })
    };
    Kind::by_name(name).or_else(|| own(true)).or_else(|| own(false))
}

/// What was written of a user's effect.
pub fn written(kind: Kind) -> Option<Written> {
    defined(|list| list.iter().find(|e| e.kind == kind).map(|e| e.written.clone()))
}
