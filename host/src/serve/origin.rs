//! The file that a record was read from, and how: its columns can be mapped anew, and another file be read the same way.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use axum::body::Bytes;
use serde_json::{Value, json};

use super::data::{Data, Entry, Role};
use super::rig::Rig;
use crate::error::{Error, Result};
use crate::log::guess::{Look, look};
use crate::log::roles::Division;
use crate::log::{ReadOptions, Record, read};
use crate::motor_file::MotorFile;

/// A file, and how it was read.
#[derive(Debug)]
pub struct Origin {
    /// As the user named it; where nothing is kept of it, its place on this machine.
    pub name: PathBuf,
    /// What was dropped on the page; none of a file that was named on the command line.
    content: Option<Bytes>,
    /// How it was read.
    pub options: ReadOptions,
    /// What was left out of its records, and what of them judges, when it was given.
    division: Division,
    /// Whether its columns were looked at once more and said to be so.
    confirmed: bool,
    look: OnceLock<Look>,
}

impl Origin {
    /// A file that was dropped on the page.
    pub fn dropped(name: &str, content: Bytes, options: ReadOptions) -> Self {
        // Only the last part of the name, so that it stays within the directory where it is kept.
        let name = Path::new(name).file_name().map_or_else(|| PathBuf::from("log.csv"), PathBuf::from);
        let (content, division) = (Some(content), Division::default());
        Self { name, content, options, division, confirmed: false, look: OnceLock::new() }
    }

    /// A file on this machine, whose records were divided by `division`.
    fn on_disk(name: PathBuf, options: ReadOptions, division: Division) -> Self {
        Self { name, content: None, options, division, confirmed: false, look: OnceLock::new() }
    }

    /// The same file, read once more.
    fn read_again(&self, options: ReadOptions) -> Self {
        let (name, content, division) = (self.name.clone(), self.content.clone(), self.division.clone());
        Self { name, content, options, division, confirmed: true, look: OnceLock::new() }
    }

    /// The name of the file without its place.
    pub fn file(&self) -> String {
        self.name.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }

    /// What `work` makes of the file; messages call it as the user does.
    fn with_file<T>(&self, work: impl FnOnce(&Path) -> Result<T>) -> Result<T> {
        let Some(content) = &self.content else { return work(&self.name) };
        let io = |source| Error::Io { doing: "cannot keep the log for reading".into(), source };
        let directory = tempfile::tempdir().map_err(io)?;
        let path = directory.path().join(&self.name);
        std::fs::write(&path, content).map_err(io)?;
        work(&path).map_err(|error| match error {
            Error::BadInput(mut fault) => {
                fault.file.clone_from(&self.name);
                Error::BadInput(fault)
            }
            other => other,
        })
    }

    /// Its records. They are judged when all are taken in, as a set, as the verbs judge theirs.
    pub fn records(&self) -> Result<Vec<Record>> {
        let mut records = self.with_file(|path| read(path, &self.options))?;
        for record in &mut records {
            record.path.clone_from(&self.name);
        }
        // What judges keeps its role by its name.
        let parts = records.into_iter().flat_map(|record| self.division.parts(record, false));
        Ok(parts.map(|(part, _)| part).collect())
    }

    /// What its columns are, looked at once.
    pub fn look(&self) -> Result<&Look> {
        if self.look.get().is_none() {
            // Another request may have been faster; it saw the same.
            let _ = self.look.set(self.with_file(look)?);
        }
        self.look.get().ok_or_else(|| Error::usage("the file cannot be looked at", "open it again"))
    }

    /// Whether `other` has the same columns and is read the same way.
    fn is_read_like(&self, other: &Self) -> bool {
        // What is known of the motor is known of all its files.
        let own = |origin: &Self| ReadOptions { motor: MotorFile::default(), ..origin.options.clone() };
        own(self) == own(other)
            && self.look().is_ok_and(|own| other.look().is_ok_and(|look| own.names == look.names))
    }

    /// The way in which it is read, as the dialogue shows it; `motor` is what is known of its motor.
    fn in_use(&self, motor: &MotorFile) -> Result<Value> {
        let look = self.look()?;
        let map = self.options.map.as_ref();
        let mut kinds = map.map_or_else(|| look.kinds.clone(), |map| look.kinds_by(map));
        let of_motion = |kind: &str| kind.starts_with("angle:") || kind.starts_with("speed:");
        let mut motion = kinds.iter().filter(|kind| of_motion(kind)).peekable();
        let turned = motion.peek().is_some() && motion.all(|kind| kind.ends_with(TURNED));
        for kind in kinds.iter_mut().filter(|kind| turned && of_motion(kind)) {
            kind.truncate(kind.len() - TURNED.len());
        }
        let chosen = |motor: &&String| {
            map.is_some_and(|map| map.written().starts_with(&format!("voltage=voltage-{motor}:")))
        };
        Ok(json!({
            "file": self.file(),
            "kinds": kinds,
            "turned": turned,
            "motor": look.motors.iter().find(chosen),
            "rig": Rig::of(&self.options, motor),
        }))
    }
}

/// The scale of a column whose sign is turned round.
const TURNED: &str = "*-1";

impl Data {
    /// The files that the records come from, each once.
    fn origins(&self) -> Vec<Arc<Origin>> {
        let mut all: Vec<Arc<Origin>> = Vec::new();
        for origin in self.entries.iter().filter_map(|entry| entry.origin.as_ref()) {
            if !all.iter().any(|known| Arc::ptr_eq(known, origin)) {
                all.push(Arc::clone(origin));
            }
        }
        all
    }

    /// Gives every record the file that it came from: all were read with `options` and divided by `division`; of those that were `kept_out` as a
    /// whole no range was to judge apart from the rest. A pipe, or two files that were read as one record, cannot be read once more as one file.
    pub fn came_from(&mut self, options: &ReadOptions, division: &Division, kept_out: &[PathBuf]) {
        let mut all: Vec<Arc<Origin>> = Vec::new();
        for entry in self.entries.iter_mut().filter(|entry| entry.record.path.is_file()) {
            let path = &entry.record.path;
            let known = all.iter().find(|origin| origin.name == *path).cloned();
            let origin = known.unwrap_or_else(|| {
                let mut division = division.clone();
                if kept_out.contains(path) {
                    division.judge_by.clear();
                }
                all.push(Arc::new(Origin::on_disk(path.clone(), options.clone(), division)));
                Arc::clone(&all[all.len() - 1])
            });
            entry.origin = Some(origin);
        }
    }

    /// Whether a person looked once more at the columns of all files that are fitted: what only perhaps is wrong with them is right then.
    pub fn is_confirmed(&self) -> bool {
        let mut fitted = self.entries.iter().filter(|entry| entry.role == Role::Fit);
        fitted.all(|entry| entry.origin.as_ref().is_some_and(|origin| origin.confirmed))
    }

    /// What the dialogue shows of the file of record `entry`, and how many other files are read the same way.
    pub fn mapping_of(&self, entry: usize) -> Result<Value> {
        let origin = self.origin_of(entry)?;
        let others = self.origins().iter().filter(|other| other.is_read_like(&origin)).count();
        Ok(
            json!({ "table": origin.look()?, "in_use": origin.in_use(&self.motor)?, "others": others.saturating_sub(1) }),
        )
    }

    fn origin_of(&self, entry: usize) -> Result<Arc<Origin>> {
        let origin = self.entries.get(entry).and_then(|entry| entry.origin.clone());
        origin.ok_or_else(|| {
            Error::usage(
                "this record was not read from a file of which the page knows how",
                "open its log again",
            )
        })
    }

    /// How a file called `name` that looks like `new` is read without asking again: as one that is there and has the same columns. The same
    /// file once more is asked about, and so are columns without names.
    pub fn read_like(&self, new: &Look, name: &str) -> Option<Value> {
        let origins = self.origins();
        if !new.is_named() || origins.iter().any(|origin| origin.file() == name) {
            return None;
        }
        let same = |origin: &&Arc<Origin>| origin.look().is_ok_and(|look| look.names == new.names);
        origins.iter().rfind(same).and_then(|origin| origin.in_use(&self.motor).ok())
    }

    /// The same with the file of record `entry` read by `map` and `rig`, and with `alike` all files that were read as it was.
    pub fn mapped(&self, entry: usize, alike: bool, map: &str, rig: &Rig) -> Result<Self> {
        let origin = self.origin_of(entry)?;
        let too = |other: &Arc<Origin>| Arc::ptr_eq(other, &origin) || alike && other.is_read_like(&origin);
        let mut anew = Vec::new();
        for old in self.origins().into_iter().filter(too) {
            let new = old.read_again(rig.options(map, old.options.clone())?);
            let records = new.records()?;
            anew.push((old, Arc::new(new), records));
        }
        let motor = rig.motor(self.motor.clone())?;
        let mut data = self.changed(|all| {
            for (old, new, records) in anew {
                replace(all, &old, &new, records);
            }
        });
        data.motor = motor;
        Ok(data)
    }
}

/// Puts the `records` of `new` in the place of those of `old`; each keeps the role of the record of its name, and its cuts where its times
/// are the same.
fn replace(all: &mut Vec<Entry>, old: &Arc<Origin>, new: &Arc<Origin>, records: Vec<Record>) {
    let came = |entry: &Entry| entry.origin.as_ref().is_some_and(|origin| Arc::ptr_eq(origin, old));
    let Some(at) = all.iter().position(came) else { return };
    let (before, mut kept): (Vec<Entry>, Vec<Entry>) = std::mem::take(all).into_iter().partition(came);
    let ends = |record: &Record| (record.time_s.first().copied(), record.time_s.last().copied());
    let entries: Vec<Entry> = records
        .into_iter()
        .map(|record| {
            let own = before.iter().find(|entry| entry.record.name == record.name);
            let role = own.unwrap_or(&before[0]).role;
            let same = own.filter(|entry| ends(&entry.record) == ends(&record));
            let cuts = same.map_or_else(Vec::new, |entry| entry.cuts.clone());
            Entry { cuts, origin: Some(Arc::clone(new)), ..Entry::new(record, role) }
        })
        .collect();
    let behind = kept.split_off(at);
    *all = kept.into_iter().chain(entries).chain(behind).collect();
}

#[cfg(test)]
mod tests {
    use super::super::session::Session;
    use super::*;
    use crate::log::Hold;

    /// A log in milliseconds whose second column may be volts or a duty.
    fn log() -> Bytes {
        let row = |k: u32| {
            let t = 0.01 * f64::from(k);
            format!("{},{:.3},{:.4}\n", 10 * k, 100.0 * (2.0 * t).sin(), 30.0 * (2.0 * t - 0.1).sin())
        };
        Bytes::from("ms,u,w\n".to_owned() + &(0..600).map(row).collect::<String>())
    }

    /// The same as a file on this machine, the directory that it is in, and how it is read.
    fn on_disk(name: &str) -> (tempfile::TempDir, PathBuf, ReadOptions) {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join(name);
        std::fs::write(&path, log()).unwrap();
        let options = Rig::default().options("time=0:ms,voltage=1:mV,speed=2", ReadOptions::default());
        (directory, path, options.unwrap())
    }

    fn loaded(names: &[&str], map: &str, rig: &Rig) -> Data {
        let mut data = Data::default();
        for name in names {
            let options = rig.options(map, ReadOptions::default()).unwrap();
            let origin = Arc::new(Origin::dropped(name, log(), options));
            let entry = |record| Entry { origin: Some(Arc::clone(&origin)), ..Entry::new(record, Role::Fit) };
            data.entries.extend(origin.records().unwrap().into_iter().map(entry));
        }
        data
    }

    #[test]
    fn a_mapping_is_shown_as_it_is_in_use_and_a_new_one_can_be_undone() {
        let map = "time=0:ms,voltage=1:mV,speed=2:rad/s*-1";
        let mut data = loaded(&["a.csv"], map, &Rig::default());
        data.entries[0].role = Role::Validation;
        data.entries[0].cuts = vec![[1.0, 2.0]];
        let shown = data.mapping_of(0).unwrap();
        assert_eq!(shown["in_use"]["kinds"], json!(["time:ms", "voltage:mV", "speed:rad/s"]));
        assert_eq!((&shown["in_use"]["turned"], &shown["others"]), (&json!(true), &json!(0)));
        let rig = Rig::with(&[("supply_volts", "8"), ("gear_ratio", "50")]);
        let new = data.mapped(0, false, "time=0:ms,duty=1:255,speed=2", &rig).unwrap();
        let [old, own] = [&data, &new].map(|data| &data.entries[0]);
        assert!((own.record.voltage_v[50] / old.record.voltage_v[50] - 8.0 / 255.0 * 1e3).abs() < 1e-6);
        assert_eq!((own.role, &own.cuts), (Role::Validation, &vec![[1.0, 2.0]]));
        assert_eq!(new.motor.gear_ratio, Some(50.0));
        assert_eq!(new.mapping_of(0).unwrap()["in_use"]["rig"]["supply_volts"], "8");
        assert!(new.can_undo());
        // In other seconds a cut would be another one.
        let slow = data.mapped(0, false, "time=0:s,voltage=1:V,speed=2", &rig).unwrap();
        assert!(slow.entries[0].cuts.is_empty());
    }

    #[test]
    fn how_the_voltage_acts_between_the_rows_is_kept_shown_again_and_makes_the_same_model_again() {
        let map = "time=0:ms,voltage=1:mV,speed=2";
        let data = loaded(&["a.csv", "b.csv"], map, &Rig::default());
        let rig = Rig::with(&[("voltage_lead", "0.004"), ("hold", "first"), ("inductance_h", "0.02")]);
        let new = data.mapped(0, false, map, &rig).unwrap();
        let record = &new.entries[0].record;
        assert_eq!((record.hold, record.meta.voltage_lead_s()), (Hold::First, Some(0.004)));
        assert_eq!(new.motor.nameplate.inductance_h, Some(0.02));
        // The other file is read otherwise from now on.
        assert_eq!([&data, &new].map(|data| data.mapping_of(1).unwrap()["others"].clone()), [1, 0]);
        // What the dialogue shows is what it sends.
        let shown = new.mapping_of(0).unwrap()["in_use"]["rig"].clone();
        assert_eq!(shown["voltage_lead"], "0.004");
        let again = new.mapped(0, false, map, &serde_json::from_value(shown).unwrap()).unwrap();
        assert_eq!(again.entries[0].record, new.entries[0].record);
        let gain = |data: &Data| Session::of(data.clone()).unwrap().model().base.gain;
        assert_eq!(gain(&again).to_bits(), gain(&new).to_bits());
        assert_ne!(gain(&new).to_bits(), gain(&data).to_bits());
        // Another log of the same columns is read so too; a field that is emptied says nothing any more.
        let other = Origin::dropped("c.csv", log(), ReadOptions::default());
        let like = |data: &Data| data.read_like(other.look().unwrap(), "c.csv").unwrap()["file"].clone();
        assert_eq!(like(&new), "b.csv");
        let emptied = again.mapped(0, false, map, &Rig::default()).unwrap();
        assert_eq!((&emptied.entries[0].record, emptied.motor), (&data.entries[0].record, data.motor));
    }

    #[test]
    fn files_that_were_read_the_same_way_may_be_read_anew_together() {
        let data = loaded(&["a.csv", "b.csv"], "time=0:ms,voltage=1,speed=2", &Rig::default());
        assert_eq!(data.mapping_of(1).unwrap()["others"], 1);
        let speed = |data: &Data, k: usize| data.entries[k].record.speed_rad_s.as_ref().unwrap()[100];
        let map = "time=0:ms,voltage=1,speed=2:deg/s";
        let [one, both] = [false, true].map(|alike| data.mapped(1, alike, map, &Rig::default()).unwrap());
        assert_eq!(speed(&one, 0), speed(&data, 0));
        assert!(speed(&one, 1).abs() < 0.1 * speed(&data, 1).abs());
        assert_eq!(speed(&both, 0), speed(&both, 1));
        assert_eq!(both.entries.len(), 2);
        assert_eq!([&data, &one, &both].map(Data::is_confirmed), [false, false, true]);
    }

    #[test]
    fn a_second_file_of_the_same_columns_is_read_as_the_first_and_the_same_file_is_asked_about() {
        let data = loaded(&["a.csv"], "time=0:ms,voltage=1:mV,speed=2", &Rig::default());
        let new = Origin::dropped("b.csv", log(), ReadOptions::default());
        let like = data.read_like(new.look().unwrap(), "b.csv").unwrap();
        assert_eq!((&like["file"], &like["kinds"][1]), (&json!("a.csv"), &json!("voltage:mV")));
        assert!(data.read_like(new.look().unwrap(), "a.csv").is_none());
        let other =
            Origin::dropped("c.csv", Bytes::from("s,u,w\n0,1,2\n1,2,3\n2,3,4\n"), ReadOptions::default());
        assert!(data.read_like(other.look().unwrap(), "c.csv").is_none());
    }

    #[test]
    fn records_that_the_command_line_divided_are_divided_alike_when_their_file_is_read_anew() {
        let (_directory, path, options) = on_disk("run.csv");
        let ranges = |text: &str| vec![text.parse().unwrap()];
        let division = Division { skip: ranges("2..3"), judge_by: ranges("run:4..") };
        let parts = read(&path, &options).unwrap().into_iter().flat_map(|r| division.parts(r, false));
        let (judged, fitted): (Vec<_>, Vec<_>) = parts.partition(|(_, judges)| *judges);
        let records = |of: Vec<(Record, bool)>| of.into_iter().map(|(record, _)| record).collect();
        let mut data = Data::new(records(fitted), records(judged), MotorFile::default());
        data.came_from(&options, &division, &[]);
        let new = data.mapped(2, false, "time=0:ms,voltage=1,speed=2", &Rig::default()).unwrap();
        let of = |data: &Data| -> Vec<(String, Role, usize)> {
            data.entries.iter().map(|e| (e.record.name.clone(), e.role, e.record.len())).collect()
        };
        assert_eq!(of(&new), of(&data));
        assert_eq!((of(&new).len(), new.entries[2].role), (3, Role::Validation));
        let [old, own] = [&data, &new].map(|data| data.entries[1].record.voltage_v[50]);
        assert!((own / old - 1e3).abs() < 1e-6, "{old} {own}");
        data.entries[0].origin = None;
        assert!(data.mapping_of(0).unwrap_err().to_string().contains("open its log again"));
    }

    #[test]
    fn a_file_that_was_kept_out_as_a_whole_is_whole_again_when_it_is_read_anew() {
        let (_directory, path, options) = on_disk("unseen.csv");
        let division = Division { judge_by: vec!["2..4".parse().unwrap()], ..Division::default() };
        let mut data = Data::new(Vec::new(), read(&path, &options).unwrap(), MotorFile::default());
        data.came_from(&options, &division, &[path]);
        let new = data.mapped(0, false, "time=0:ms,voltage=1,speed=2", &Rig::default()).unwrap();
        let [old, own] = [&data, &new].map(|data| &data.entries[0]);
        assert_eq!((new.entries.len(), own.role), (1, Role::Validation));
        assert_eq!((&own.record.name, own.record.len()), (&old.record.name, old.record.len()));
    }

    #[test]
    fn a_bad_log_gets_a_message_without_the_place_where_it_was_kept() {
        let text = "time_s,voltage_v,angle_rad\n0,1,2\n1,x,3\n";
        let origin = Origin::dropped("../../etc/log.csv", Bytes::from(text), ReadOptions::default());
        let error = origin.records().unwrap_err().to_string();
        assert!(error.starts_with("log.csv") && error.contains("line 3"), "{error}");
    }
}
