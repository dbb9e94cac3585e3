//! The user's effects beside the library's, by name.
//!
//! An effect is defined once in a process and lives as long as it: fits hold many copies of its name.

use std::sync::Mutex;

use motorlens_shared::effects::{Kind, UserDefined};

use super::Written;
use super::definition::{Field, Wrong};

struct Entry {
    written: Written,
    kind: Kind,
    /// Named by the user for this run, so that searches try it.
    offered: bool,
}

static DEFINED: Mutex<Vec<Entry>> = Mutex::new(Vec::new());

fn defined<T>(look: impl FnOnce(&mut Vec<Entry>) -> T) -> T {
    // A panic elsewhere leaves the list whole: entries are only ever pushed.
    look(&mut DEFINED.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
}

/// The effect that `written` describes; the same description gives the same effect.
///
/// # Errors
/// A description that is wrong, or another one under the same name.
pub fn define(written: &Written) -> Result<Kind, Wrong> {
    defined(|list| {
        if let Some(entry) = list.iter().find(|e| e.written.name == written.name) {
            return if entry.written == *written {
                Ok(entry.kind)
            } else {
                Err(Wrong {
                    field: Field::Name,
                    why: format!("two different effects are called {}", written.name),
                    remedy: "give one of them another name".into(),
                })
            };
        }
        let kind = Kind::Formula(UserDefined(written.define()?));
        list.push(Entry { written: written.clone(), kind, offered: false });
        Ok(kind)
    })
}

/// Lets searches try `kind`.
pub fn offer(kind: Kind) {
    defined(|list| list.iter_mut().filter(|e| e.kind == kind).for_each(|e| e.offered = true));
}

/// The library's effects, and the user's that were offered.
pub fn all() -> Vec<Kind> {
    let own = defined(|list| list.iter().filter(|e| e.offered).map(|e| e.kind).collect::<Vec<_>>());
    Kind::ALL.iter().copied().chain(own).collect()
}

/// The effect called `name`, the user's included.
pub fn by_name(name: &str) -> Option<Kind> {
    Kind::by_name(name)
        .or_else(|| defined(|list| list.iter().find(|e| e.written.name == name).map(|e| e.kind)))
}

/// What was written of a user's effect.
pub fn written(kind: Kind) -> Option<Written> {
    defined(|list| list.iter().find(|e| e.kind == kind).map(|e| e.written.clone()))
}
