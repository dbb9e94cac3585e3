//! The effects that a call may use: the library's own, and those of the user's that it is given.

use std::path::Path;
use std::sync::Mutex;

use motorlens_shared::effects::{Kind, UserDefined};

use super::definition::Wrong;
use super::{Written, file};
use crate::error::{Error, Result};

/// Effects by name: the library's own, and those that a caller offers beside them. A value: what one call is offered no other call finds.
///
/// ```
/// use motorlens::formula::{Library, Written, WrittenParameter, define};
/// let drag = WrittenParameter {
///     name: "drag".into(),
///     unit: "V s^2/rad^2".into(),
///     meaning: String::new(),
///     low: 0.0,
///     typical: 0.02,
///     high: 1.0,
/// };
/// let fan = define(&Written {
///     name: "fan".into(),
///     port: "torque".into(),
///     formula: "-drag * speed * abs(speed)".into(),
///     title: String::new(),
///     signature: String::new(),
///     source: String::new(),
///     parameters: vec![drag],
/// })
/// .map_err(|wrong| motorlens::Error::usage(wrong.why, wrong.remedy))?;
/// let library = Library::default().with(fan)?;
/// assert_eq!(library.by_name("fan"), Some(fan));
/// assert_eq!(Library::default().by_name("fan"), None);
/// # Ok::<(), motorlens::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Library(Vec<Kind>);

/// The library's own effects only.
impl Default for Library {
    fn default() -> Self {
        Self(Kind::ALL.to_vec())
    }
}

impl Library {
    /// Offers `kind` too.
    ///
    /// # Errors
    /// Wrong usage: another effect is called so.
    pub fn with(mut self, kind: Kind) -> Result<Self> {
        if self.has_another(kind) {
            return Err(Error::usage(two_called(kind.name()), RENAME));
        }
        if !self.0.contains(&kind) {
            self.0.push(kind);
        }
        Ok(self)
    }

    /// Offers the effect in a file too.
    ///
    /// # Errors
    /// As [`Library::read`].
    ///
    /// ```
    /// use motorlens::formula::Library;
    /// # let directory = tempfile::tempdir().expect("a directory");
    /// # let path = directory.path().join("fan.toml");
    /// let fan = r#"
    /// name = "fan"
    /// port = "torque"
    /// formula = "-drag * speed * abs(speed)"
    ///
    /// [[parameter]]
    /// name = "drag"
    /// unit = "V s^2/rad^2"
    /// low = 0.0
    /// typical = 0.02
    /// high = 1.0
    /// "#;
    /// # std::fs::write(&path, fan).expect("a file");
    /// let library = Library::default().with_file(&path)?;
    /// assert!(library.by_name("fan").is_some());
    /// # Ok::<(), motorlens::Error>(())
    /// ```
    pub fn with_file(self, path: &Path) -> Result<Self> {
        let kind = self.read(path)?;
        self.with(kind)
    }

    /// Reads the effect in a file, to be offered beside these.
    ///
    /// # Errors
    /// A file that cannot be read; what is wrong in it, with line and column; a name that another effect has.
    pub fn read(&self, path: &Path) -> Result<Kind> {
        file::read_beside(path, self)
    }

    /// The same with what a model has, whose file describes it; a name stays with the effect that had it.
    #[must_use]
    pub fn and_those_of(&self, model: &[Kind]) -> Self {
        let more = model.iter().copied().filter(|kind| self.by_name(kind.name()).is_none());
        Self(self.0.iter().copied().chain(more).collect())
    }

    /// All of them, the library's own first.
    pub fn kinds(&self) -> &[Kind] {
        &self.0
    }

    /// The effect called `name`.
    pub fn by_name(&self, name: &str) -> Option<Kind> {
        self.0.iter().copied().find(|kind| kind.name() == name)
    }

    /// Whether another effect than `kind` has its name here.
    pub(super) fn has_another(&self, kind: Kind) -> bool {
        self.by_name(kind.name()).is_some_and(|own| own != kind)
    }
}

pub(super) fn two_called(name: &str) -> String {
    format!("two different effects are called {name}")
}

pub(super) const RENAME: &str = "give one of them another name";

/// Descriptions and what was made of them. This is a cache and no register: it is looked up by a whole description or by the effect that
/// was made of it, never by a name, so that no call finds what another call described. It lives as long as the process, as fits hold
/// many copies of an effect; each description is kept once.
static DEFINED: Mutex<Vec<(Written, Kind)>> = Mutex::new(Vec::new());

fn defined<T>(look: impl FnOnce(&mut Vec<(Written, Kind)>) -> T) -> T {
    // A panic elsewhere leaves the list whole: a pair is pushed in one step.
    look(&mut DEFINED.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
}

/// The effect that `written` describes; the same description gives the same effect. It is offered to nobody: see [`Library`].
///
/// # Errors
/// A description that is wrong.
pub fn define(written: &Written) -> std::result::Result<Kind, Wrong> {
    defined(|list| {
        if let Some((_, kind)) = list.iter().find(|(known, _)| known == written) {
            return Ok(*kind);
        }
        let kind = Kind::Formula(UserDefined(written.define()?));
        list.push((written.clone(), kind));
        Ok(kind)
    })
}

/// What was written of a user's effect.
pub fn written(kind: Kind) -> Option<Written> {
    defined(|list| list.iter().find(|(_, known)| *known == kind).map(|(written, _)| written.clone()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula;
    use crate::simulate::Custom;

    fn lobe(typical: f64) -> Kind {
        define(&formula::lobe::lobe("library_test_lobe", typical)).unwrap()
    }

    #[test]
    fn an_effect_is_found_where_it_was_offered_and_nowhere_else() {
        let (ours, theirs) = (lobe(0.3), lobe(0.4));
        let [first, second] = [ours, theirs].map(|kind| Library::default().with(kind).unwrap());
        assert_eq!(first.by_name(ours.name()), Some(ours));
        assert_eq!(second.by_name(ours.name()), Some(theirs));
        assert_eq!(Library::default().by_name(ours.name()), None);
        assert_eq!(Library::default().kinds(), Kind::ALL);
        let simulated = |library| Custom::parse("library_test_lobe=0.5", library).unwrap();
        assert!(simulated(&first).is_some() && simulated(&Library::default()).is_none());
    }

    #[test]
    fn one_library_has_one_effect_of_a_name() {
        let (ours, theirs) = (lobe(0.3), lobe(0.4));
        let first = Library::default().with(ours).unwrap();
        assert_eq!(first.clone().with(ours).unwrap(), first);
        let refused = first.clone().with(theirs).unwrap_err().to_string();
        assert!(refused.contains("two different effects are called library_test_lobe"), "{refused}");
        assert_eq!(first.and_those_of(&[theirs, Kind::Coulomb]), first);
        assert_eq!(Library::default().and_those_of(&[theirs]).by_name(ours.name()), Some(theirs));
    }
}
