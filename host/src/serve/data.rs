//! The records of a page as its user edits them: which are fitted, which only judge, which are out, and what is cut out.
//!
//! What was read stays as it was read; roles and cuts are laid over it, so that everything can be undone.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::App;
use super::fits::kept;
use super::jobs::{self, Answer, End, Job, refused};
use super::origin::Origin;
use super::session::Session;
use crate::log::{FEWEST_SAMPLES, Record, Warning, breakaway, part, servo, still_beside};
use crate::motor_file::MotorFile;

/// What a record is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Parameters and effects are fitted to it.
    Fit,
    /// It touches no fit and no choice; errors are told on it.
    Validation,
    /// It is not used.
    Out,
}

/// A record as it was read, and what its user made of it.
#[derive(Debug, Clone)]
pub struct Entry {
    /// As read.
    pub record: Arc<Record>,
    /// What it is used for.
    pub role: Role,
    /// Ranges that are left out, s, in order and apart.
    pub cuts: Vec<[f64; 2]>,
    /// The file that it was read from, where its columns can be mapped anew.
    pub origin: Option<Arc<Origin>>,
}

/// Shorter ends between two cuts are left out with them, s.
const SHORTEST_S: f64 = 0.2;

impl Entry {
    /// `record` whole.
    pub fn new(record: Record, role: Role) -> Self {
        Self { record: Arc::new(record), role, cuts: Vec::new(), origin: None }
    }

    /// What is left of the record: a piece between two cuts is a record of its own, for the shaft moved on meanwhile.
    pub fn pieces(&self) -> Vec<Record> {
        if self.cuts.is_empty() {
            return vec![self.record.as_ref().clone()];
        }
        let time = &self.record.time_s;
        let mut ranges = Vec::new();
        let mut from = 0;
        for [low, high] in &self.cuts {
            ranges.push((from, time.partition_point(|t| t < low)));
            from = time.partition_point(|t| t <= high);
        }
        ranges.push((from, time.len()));
        let long = |(a, b): &(usize, usize)| *b >= a + FEWEST_SAMPLES && time[b - 1] - time[*a] >= SHORTEST_S;
        let pieces: Vec<(usize, usize)> = ranges.into_iter().filter(long).collect();
        let several = pieces.len() > 1;
        let named = |k: usize| {
            let name = &self.record.name;
            if several { format!("{name} (part {})", k + 1) } else { name.clone() }
        };
        let piece = |(k, (a, b)): (usize, &(usize, usize))| Record {
            name: named(k),
            ..part(&self.record, *a..*b, k + 1)
        };
        pieces.iter().enumerate().map(piece).collect()
    }

    /// Leaves out `[from, to]`, s; cuts that touch become one.
    fn cut(&mut self, from: f64, to: f64) {
        let mut joined = [from, to];
        self.cuts.retain(|[low, high]| {
            let apart = *high < joined[0] || *low > joined[1];
            if !apart {
                joined = [joined[0].min(*low), joined[1].max(*high)];
            }
            apart
        });
        self.cuts.push(joined);
        self.cuts.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }
}

/// The entries now, and as they were before each change.
#[derive(Debug, Clone, Default)]
pub struct Data {
    /// In the order in which they came.
    pub entries: Vec<Entry>,
    /// What is known of their motor.
    pub motor: MotorFile,
    past: Vec<(Vec<Entry>, MotorFile)>,
}

/// Changes that can be undone.
const REMEMBERED: usize = 100;

impl Data {
    /// `records` to fit and `validation` records of `motor`, whole.
    pub fn new(records: Vec<Record>, validation: Vec<Record>, motor: MotorFile) -> Self {
        let of = |role| move |record| Entry::new(record, role);
        let fit = records.into_iter().map(of(Role::Fit));
        let entries = fit.chain(validation.into_iter().map(of(Role::Validation))).collect();
        Self { entries, motor, past: Vec::new() }
    }

    /// The records with this role, cut. What a cut leaves of a record may stand still, and then says nothing of the motor.
    pub fn with(&self, role: Role) -> Vec<Record> {
        let of = |role: Role| self.entries.iter().filter(move |e| e.role == role);
        let fitted: Vec<Record> = of(Role::Fit).flat_map(Entry::pieces).collect();
        let stands = still_beside(&fitted.iter().collect::<Vec<_>>());
        let says = |entry: &Entry, piece: &Record| entry.cuts.is_empty() || !stands(piece);
        of(role).flat_map(|e| e.pieces().into_iter().filter(move |piece| says(e, piece))).collect()
    }

    /// What the verbs do with the records of a motor before they judge them: all servos of which nobody knows the controller get one,
    /// and a record in which the motor stands still is out. Says what such records tell.
    pub fn settle(&mut self) -> Vec<Warning> {
        let used: Vec<usize> =
            (0..self.entries.len()).filter(|k| self.entries[*k].role != Role::Out).collect();
        let mut records: Vec<Record> = used.iter().map(|k| (*self.entries[*k].record).clone()).collect();
        if records.iter().any(|record| record.servo.is_some()) {
            servo::close_loops(&mut records);
            for (k, record) in used.iter().zip(records) {
                self.entries[*k].record = Arc::new(record);
            }
        }
        let fitted = self.entries.iter().filter(|e| e.role == Role::Fit).map(|e| e.record.as_ref());
        let stands = still_beside(&fitted.collect::<Vec<_>>());
        let mut said = Vec::new();
        for k in used {
            if stands(&self.entries[k].record) {
                said.push(breakaway(&self.entries[k].record));
                self.entries[k].role = Role::Out;
            }
        }
        said
    }

    /// Whether a change can be undone.
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// The same with `change` made, which can be undone.
    pub fn changed(&self, change: impl FnOnce(&mut Vec<Entry>)) -> Self {
        let mut new = self.clone();
        new.past.push((self.entries.clone(), self.motor.clone()));
        if new.past.len() > REMEMBERED {
            new.past.remove(0);
        }
        change(&mut new.entries);
        new
    }

    fn undone(&self) -> Option<Self> {
        let mut old = self.clone();
        (old.entries, old.motor) = old.past.pop()?;
        Some(old)
    }
}

/// A change of the data.
#[derive(Debug, Deserialize)]
#[serde(tag = "change", rename_all = "snake_case")]
pub enum Change {
    /// Another role for an entry.
    Role {
        /// Which entry.
        entry: usize,
        /// Its role from now on.
        role: Role,
    },
    /// A range that is left out, s.
    Cut {
        /// Which entry.
        entry: usize,
        /// Where it begins.
        from: f64,
        /// Where it ends.
        to: f64,
    },
    /// All of an entry is used again.
    Whole {
        /// Which entry.
        entry: usize,
    },
    /// As it was before the last change.
    Undo,
}

/// Makes a change, fits the base model anew, and with it the effects that were in the model.
pub async fn change(State(app): State<Arc<App>>, Json(change): Json<Change>) -> Answer {
    let data = app.session().data.clone();
    let no_such = || refused(StatusCode::NOT_FOUND, "there is no such record");
    let entry = match change {
        Change::Role { entry, .. } | Change::Cut { entry, .. } | Change::Whole { entry } => entry,
        Change::Undo => 0,
    };
    let name = data.entries.get(entry).ok_or_else(no_such)?.record.name.clone();
    let (new, what) = match change {
        Change::Role { role, .. } => {
            let word = match role {
                Role::Fit => "is fitted now",
                Role::Validation => "is a validation record now: no fit sees it",
                Role::Out => "is out",
            };
            (data.changed(|all| all[entry].role = role), format!("{name} {word}."))
        }
        Change::Cut { from, to, .. } => {
            if !(from.is_finite() && to.is_finite() && from < to) {
                return Err(refused(StatusCode::UNPROCESSABLE_ENTITY, "the range ends before it begins"));
            }
            let told = format!("{from:.3} to {to:.3} s of {name} are left out.");
            (data.changed(|all| all[entry].cut(from, to)), told)
        }
        Change::Whole { .. } => {
            (data.changed(|all| all[entry].cuts.clear()), format!("All of {name} is used again."))
        }
        Change::Undo => {
            let nothing = || refused(StatusCode::CONFLICT, "there is nothing to undo");
            (data.undone().ok_or_else(nothing)?, "The last change of the data is undone.".to_owned())
        }
    };
    if new.with(Role::Fit).is_empty() {
        let why = "no record would be left to fit; give another one the role fit first";
        return Err(refused(StatusCode::UNPROCESSABLE_ENTITY, why));
    }
    jobs::start(&app, "Fitting the changed data", move |job| renewed(job, new, what))
}

/// A session of `data` with the effects of the one before, told as `what`.
pub fn renewed(job: &Job, data: Data, what: String) -> End {
    let had = job.app.session().current.values();
    match Session::of(data).map(|session| kept(job, session, &had)) {
        Ok(Some(mut session)) => End::Done(
            what,
            Box::new(move |old| {
                session.puzzle = old.puzzle.take();
                *old = session;
            }),
        ),
        Ok(None) => End::Stopped("Stopped. Data and model are as they were.".into()),
        Err(error) => End::Failed(error.to_json()),
    }
}

impl Data {
    /// As the page lists them.
    pub fn to_json(&self) -> serde_json::Value {
        let entry = |e: &Entry| {
            let r = &e.record;
            json!({ "name": r.name, "role": e.role, "cuts": e.cuts, "samples": r.len(), "seconds": r.duration_s(),
                    "file": e.origin.as_ref().map(|origin| origin.file()),
                    "parts": if e.role == Role::Out { 0 } else { e.pieces().len() } })
        };
        json!({ "entries": self.entries.iter().map(entry).collect::<Vec<_>>(), "can_undo": self.can_undo() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::servo::Servo;

    fn entry() -> Entry {
        let time_s: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
        let column = vec![1.0; 1000];
        let record = Record {
            name: "stairs".into(),
            voltage_v: column.clone(),
            speed_rad_s: Some(column),
            time_s,
            ..Record::default()
        };
        Entry::new(record, Role::Fit)
    }

    #[test]
    fn a_cut_leaves_two_records_that_keep_their_times() {
        let mut entry = entry();
        entry.cut(3.2, 4.0);
        let pieces = entry.pieces();
        let names: Vec<&str> = pieces.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["stairs (part 1)", "stairs (part 2)"]);
        assert!(pieces[0].time_s.iter().all(|t| *t < 3.2) && pieces[1].time_s.iter().all(|t| *t > 4.0));
        assert_eq!(pieces[1].speed_rad_s.as_ref().map(Vec::len), Some(pieces[1].len()));
    }

    #[test]
    fn a_cut_leaves_the_targets_of_a_servo_as_long_as_its_record() {
        let mut entry = entry();
        let servo = Servo { target_rad: vec![0.5; 1000], gain: None, damping: None };
        entry.record = Arc::new(Record { servo: Some(servo), ..entry.record.as_ref().clone() });
        entry.cut(3.2, 4.0);
        for piece in entry.pieces() {
            assert_eq!(piece.servo.as_ref().map(|servo| servo.target_rad.len()), Some(piece.len()));
        }
    }

    #[test]
    fn a_record_at_rest_is_out_beside_one_that_moves_and_a_servo_gets_its_voltage() {
        let mut moving = entry().record.as_ref().clone();
        moving.speed_rad_s = Some(moving.time_s.iter().map(|t| 5.0 * (2.0 * t).sin()).collect());
        moving.voltage_v = moving.time_s.iter().map(|t| 2.0 * (2.0 * t + 0.1).sin()).collect();
        let still = Record { name: "still".into(), speed_rad_s: Some(vec![0.0; 1000]), ..moving.clone() };
        let angle: Vec<f64> = moving.time_s.iter().map(|t| 1.0 - (-2.0 * t).exp()).collect();
        let servo = Servo { target_rad: vec![1.0; 1000], gain: Some(2.0), damping: None };
        let servo = Record {
            name: "servo".into(),
            voltage_v: vec![0.0; 1000],
            angle_rad: Some(angle),
            speed_rad_s: None,
            servo: Some(servo),
            ..moving.clone()
        };
        let mut data = Data::new(vec![moving, still, servo], Vec::new(), MotorFile::default());
        let said = data.settle();
        assert!(said.len() == 1 && said[0].what.contains("still_record"), "{said:?}");
        assert_eq!(
            data.entries.iter().map(|e| e.role).collect::<Vec<_>>(),
            [Role::Fit, Role::Out, Role::Fit]
        );
        assert!(data.entries[2].record.voltage_v[0] > 1.0);
    }

    #[test]
    fn cuts_that_touch_become_one_and_short_ends_go_with_them() {
        let mut entry = entry();
        for (from, to) in [(2.0, 3.0), (5.0, 6.0), (2.5, 5.5), (0.0, 0.1), (6.1, 10.0)] {
            entry.cut(from, to);
        }
        assert_eq!(entry.cuts, [[0.0, 0.1], [2.0, 6.0], [6.1, 10.0]]);
        let pieces = entry.pieces();
        assert_eq!(pieces.len(), 1);
        assert_eq!(pieces[0].name, "stairs");
    }

    #[test]
    fn every_change_can_be_undone() {
        let one = entry();
        let data = Data::new(vec![one.record.as_ref().clone()], Vec::new(), MotorFile::default());
        let changed = data.changed(|all| all[0].cut(1.0, 2.0)).changed(|all| all[0].role = Role::Out);
        assert!(changed.with(Role::Fit).is_empty());
        let before = changed.undone().unwrap();
        assert_eq!(before.with(Role::Fit).len(), 2);
        let first = before.undone().unwrap();
        assert_eq!(first.with(Role::Fit)[0].len(), 1000);
        assert!(first.undone().is_none());
    }
}
