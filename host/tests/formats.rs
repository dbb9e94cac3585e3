//! Binary logs: every format gives the records that a CSV of the same numbers gives, and is refused in words where it is damaged.

mod formats_support;
mod program;

use std::f64::consts::TAU;
use std::io::Write;
use std::path::{Path, PathBuf};

use formats_support::{Wpilog, canonical_columns, fixture, mcap_of, npy, parquet_of, sheet, zip_of};
use motorlens::log::{Format, ReadOptions, Record, read};

fn written(name: &str, content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    std::fs::write(&path, content).unwrap();
    (directory, path)
}

/// The records of a file with this content.
fn records(name: &str, content: &[u8], map: &str) -> motorlens::error::Result<Vec<Record>> {
    let (_directory, path) = written(name, content);
    let map = (!map.is_empty()).then(|| map.parse().unwrap());
    read(&path, &ReadOptions { map, ..ReadOptions::default() })
}

fn refusal(name: &str, content: &[u8], map: &str) -> String {
    records(name, content, map).unwrap_err().to_string()
}

/// What the CSV of the same numbers gives.
fn as_csv(map: &str) -> Record {
    let (names, columns) = canonical_columns();
    let mut text = names.join(",") + "\n";
    for row in 0..columns[0].len() {
        let fields: Vec<String> = columns.iter().map(|column| format!("{:?}", column[row])).collect();
        text += &(fields.join(",") + "\n");
    }
    records("log.csv", text.as_bytes(), map).unwrap().remove(0)
}

#[track_caller]
fn same(found: &Record, expected: &Record, within: f64) {
    let close =
        |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within);
    assert!(close(&found.time_s, &expected.time_s), "times differ: {:?} {:?}", found.time_s, expected.time_s);
    assert!(close(&found.voltage_v, &expected.voltage_v), "voltages differ");
    for (a, b) in [(&found.angle_rad, &expected.angle_rad), (&found.speed_rad_s, &expected.speed_rad_s)] {
        assert_eq!(a.is_some(), b.is_some());
        assert!(a.iter().zip(b).all(|(a, b)| close(a, b)), "motions differ");
    }
}

/// The four tests of a real robot, in the layout of SysId's JSON; `None` where its logs are not beside the workspace.
fn robot() -> Option<serde_json::Value> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/frc-romi-left");
    if !data.is_dir() {
        // Written past the test harness, which would swallow it.
        let _ = std::io::stderr().write_all(b"SKIPPED: no logs at ../shared/data\n");
        return None;
    }
    let mut tests = serde_json::Map::new();
    for (number, (name, part)) in [
        ("slow-forward", "train"),
        ("slow-backward", "train"),
        ("fast-forward", "validation"),
        ("fast-backward", "train"),
    ]
    .into_iter()
    .enumerate()
    {
        let run =
            read(&data.join(part).join(format!("{name}.csv")), &ReadOptions::default()).unwrap().remove(0);
        let mut turns = 0.0;
        let rows: Vec<[f64; 4]> = (0..run.len())
            .map(|k| {
                let speed = run.speed_rad_s.as_ref().unwrap()[k] / TAU;
                turns += speed * (run.time_s[k] - run.time_s[k.saturating_sub(1)]);
                // Whole microseconds, as a data log has them.
                let time = ((100.0 * number as f64 + run.time_s[k]) * 1e6).round() * 1e-6;
                [time, run.voltage_v[k], turns, speed]
            })
            .collect();
        tests.insert(name.into(), serde_json::json!(rows));
    }
    Some(tests.into())
}

/// The tests as a robot's routine logs them: a value only when it changes, but for the velocity.
fn routine(tests: &serde_json::Value, state: &str, names: [&str; 3]) -> Vec<u8> {
    let mut file = Wpilog::new();
    let state = file.start(state, "string", "");
    let entries = names.map(|name| file.start(name, "double", "Rotation"));
    let mut before = [f64::NAN; 3];
    for (test, named) in [
        ("slow-forward", "Quasistatic-Forward"),
        ("slow-backward", "quasistatic-reverse"),
        ("fast-forward", "dynamic-forward"),
        ("fast-backward", "dynamic-reverse"),
    ] {
        let mut last = 0.0;
        for row in tests[test].as_array().unwrap() {
            let number = |k: usize| row[k].as_f64().unwrap();
            last = number(0);
            file.text(state, last, named);
            for k in 0..3 {
                if k == 2 || number(k + 1) != before[k] {
                    file.number(entries[k], last, number(k + 1));
                    before[k] = number(k + 1);
                }
            }
        }
        file.text(state, last + 1e-3, "none");
    }
    file.bytes
}

#[test]
fn a_wpilog_of_sysid_gives_the_records_of_its_json() {
    let Some(tests) = robot() else { return };
    let (_directory, path) = written("log.json", tests.to_string().as_bytes());
    let options = ReadOptions { format: Format::WpilibSysid, ..ReadOptions::default() };
    let expected = read(&path, &options).unwrap();
    assert_eq!(expected.len(), 4);
    for (state, names) in [
        ("sysid-test-state-drive", ["voltage-left-drive", "position-left-drive", "velocity-left-drive"]),
        (
            "/RealOutputs/Drive/SysIdState",
            [
                "/AdvantageKit/Drive/LeftAppliedVolts",
                "/AdvantageKit/Drive/LeftPositionRotations",
                "/AdvantageKit/Drive/LeftVelocityRotationsPerSec",
            ],
        ),
    ] {
        // No --format is needed: the content tells.
        let found = records("log.wpilog", &routine(&tests, state, names), "").unwrap();
        assert_eq!(found.len(), 4);
        for (found, expected) in found.iter().zip(&expected) {
            same(found, expected, 1e-9);
        }
    }
}

#[test]
fn several_mechanisms_in_one_wpilog_are_a_named_choice() {
    let mut file = Wpilog::new();
    for (mechanism, motor, begin) in [("arm", "joint-arm", 0.0), ("drive", "left-drive", 10.0)] {
        let state = file.start(&format!("sysid-test-state-{mechanism}"), "string", "");
        let entries =
            ["voltage", "position", "velocity"].map(|k| file.start(&format!("{k}-{motor}"), "double", ""));
        for k in 0..60 {
            let t = begin + 0.02 * f64::from(k);
            file.text(state, t, "dynamic-forward");
            for (entry, value) in entries.iter().zip([6.0, 0.1 * t, 0.1]) {
                file.number(*entry, t, value);
            }
        }
        file.text(state, begin + 2.0, "none");
    }
    let refused = refusal("log.wpilog", &file.bytes, "");
    assert!(refused.contains("arm (joint-arm), drive (left-drive)"), "{refused}");
    assert!(refused.contains("--map voltage=voltage-joint-arm:V"), "{refused}");
    let chosen = records("log.wpilog", &file.bytes, "voltage=voltage-left-drive:V").unwrap();
    assert_eq!(chosen.len(), 1);
    assert!(chosen[0].name.contains("left-drive") && chosen[0].time_s[0] >= 10.0, "{}", chosen[0].name);
}

/// Signals of two motors, logged when they change, beside one of no number.
fn free_log() -> Vec<u8> {
    let (_, columns) = canonical_columns();
    let mut file = Wpilog::new();
    file.start("/Pose", "struct:Pose2d", "");
    let other = file.start("NT:/Arm/encoderPosition", "double", "");
    let entries =
        ["NT:/Roller/appliedVoltage", "NT:/Roller/shaftAngle"].map(|name| file.start(name, "double", ""));
    let mut before = f64::NAN;
    for row in 0..columns[0].len() {
        let t = columns[0][row];
        file.number(other, t, 3.0);
        if columns[1][row] != before {
            file.number(entries[0], t, columns[1][row]);
            before = columns[1][row];
        }
        file.number(entries[1], t, columns[2][row]);
    }
    file.bytes
}

#[test]
fn a_wpilog_of_any_other_program_is_proposed_by_its_motors_and_read_by_its_entries() {
    let content = free_log();
    let refused = refusal("log.wpilog", &content, "");
    assert!(refused.contains("--map time=time_s"), "{refused}");
    assert!(
        refused.contains("voltage=NT:/Roller/appliedVoltage:V,angle=NT:/Roller/shaftAngle:rad"),
        "{refused}"
    );
    let found =
        records("log.wpilog", &content, "voltage=NT:/Roller/appliedVoltage,angle=NT:/Roller/shaftAngle")
            .unwrap();
    let expected = as_csv("");
    same(&found[0], &Record { speed_rad_s: None, ..expected }, 1e-6);
    let wrong = refusal("log.wpilog", &content, "voltage=NT:/Roller/volts:V,angle=NT:/Roller/shaftAngle");
    assert!(wrong.contains("there is no column \"NT:/Roller/volts\""), "{wrong}");
    assert!(wrong.contains("NT:/Roller/appliedVoltage"), "{wrong}");
}

#[test]
fn a_wpilog_that_was_cut_off_is_read_up_to_there_and_a_damaged_one_names_the_byte() {
    let content = free_log();
    let map = "voltage=NT:/Roller/appliedVoltage,angle=NT:/Roller/shaftAngle";
    let whole = records("log.wpilog", &content, map).unwrap().remove(0);
    let cut = records("log.wpilog", &content[..content.len() - 3], map).unwrap().remove(0);
    assert_eq!(cut.len(), whole.len() - 1);
    let damaged = refusal("log.wpilog", &content[..14], map);
    assert!(damaged.contains("damaged at byte 12"), "{damaged}");
    let mut version = content;
    version[7] = 9;
    assert!(refusal("log.wpilog", &version, map).contains("version is 9.0"));
}

#[test]
fn numpy_arrays_are_columns_by_number_or_by_field() {
    let (names, columns) = canonical_columns();
    let expected = as_csv("");
    let rows = columns[0].len();
    // Row after row, then column after column.
    let by_row: Vec<f64> = (0..rows).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
    let by_column = columns.concat();
    let shape = format!("({rows}, {})", columns.len());
    let map = "time=column0,voltage=column1,angle=column2,speed=column3";
    for (data, fortran) in [(&by_row, "False"), (&by_column, "True")] {
        let content = npy("'<f8'", fortran, &shape, data);
        same(&records("log.npy", &content, map).unwrap()[0], &expected, 0.0);
        same(&records("log.npy", &content, "time=0,voltage=1,angle=2,speed=3").unwrap()[0], &expected, 0.0);
    }
    let fields: Vec<String> = names.iter().map(|name| format!("('{name}', '<f8')")).collect();
    let content = npy(&format!("[{}]", fields.join(", ")), "False", &format!("({rows},)"), &by_row);
    same(&records("log.npy", &content, "").unwrap()[0], &expected, 0.0);
    let cut = refusal("log.npy", &content[..content.len() / 2], "");
    let data = content.len() - 8 * by_row.len();
    assert!(cut.contains(&format!("cut off or damaged at byte {data}")), "{cut}");
    let vast = npy("'<f8'", "False", "(99999999999, 99999999999)", &by_row);
    assert!(refusal("log.npy", &vast, "").contains("cut off or damaged"));
}

#[test]
fn arrays_of_an_npz_are_columns_by_their_names_packed_or_not() {
    let (names, columns) = canonical_columns();
    let expected = as_csv("");
    let vector = |column: &[f64]| npy("'<f8'", "False", &format!("({},)", column.len()), column);
    let mut parts: Vec<(String, Vec<u8>)> =
        names.iter().zip(&columns).map(|(name, column)| (format!("{name}.npy"), vector(column))).collect();
    // Parameters and objects beside them do not matter.
    parts.push(("gains.npy".into(), vector(&[1.0, 2.0, 3.0])));
    parts.push(("notes.npy".into(), npy("'|O'", "False", "(1,)", &[0.0])));
    for packed in [false, true] {
        let content = zip_of(&parts, packed);
        same(&records("log.npz", &content, "").unwrap()[0], &expected, 0.0);
        let refused = refusal("log.npz", &content, "voltage=gains,angle=angle_rad");
        assert!(refused.contains("gains (3 values)") && refused.contains("notes"), "{refused}");
        let cut = refusal("log.npz", &content[..content.len() - 200], "");
        assert!(cut.contains("archive is damaged"), "{cut}");
    }
}

#[test]
fn what_only_another_program_reads_is_answered_with_that_program() {
    let directory = tempfile::tempdir().unwrap();
    for (name, content, is, program) in [
        ("match.hoot", &b"\0\x01\x02\x03"[..], "hoot", "owlet"),
        ("run.bag", b"#ROSBAG V2.0\n", "ROS 1 bag", "mcap convert"),
        ("run.mf4", b"MDF     4.10    ", "measurement", "asammdf"),
        ("log.csv.gz", b"\x1F\x8B\x08\0", "gzip", "gunzip"),
    ] {
        std::fs::write(directory.path().join(name), content).unwrap();
        let refused = program::run(directory.path(), &format!("fit {name}")).ends(3);
        assert!(refused.err.contains(is) && refused.err.contains(program), "{}", refused.err);
    }
}

/// The motion that `fixtures.py` writes.
fn fixed() -> Record {
    let time_s: Vec<f64> = (0..60).map(|k| f64::from(k) / 100.0).collect();
    let round = |x: f64, scale: f64| (x * scale).round() / scale;
    Record {
        voltage_v: (0..60).map(|k| if k / 15 % 2 == 0 { 4.5 } else { -3.25 }).collect(),
        angle_rad: Some(time_s.iter().map(|t| round(1.5 - 1.5 * (4.0 * t).cos(), 1e4)).collect()),
        speed_rad_s: Some(time_s.iter().map(|t| round(6.0 * (4.0 * t).sin(), 1e3)).collect()),
        time_s,
        ..Record::default()
    }
}

#[test]
fn matlab_files_of_every_version_give_the_same_record() {
    for name in ["v6.mat", "v7.mat", "v73.mat"] {
        let found = records(name, &fixture(name), "").unwrap();
        same(&found[0], &fixed(), 1e-12);
        // The content tells, whatever a file is called.
        same(&records("log.dat", &fixture(name), "").unwrap()[0], &fixed(), 1e-12);
        let refused = refusal(name, &fixture(name), "voltage=gains,angle=angle_rad");
        assert!(refused.contains("gains (2 values)"), "{refused}");
    }
    let angle_only = Record { speed_rad_s: None, ..fixed() };
    let map = "time=run.t,voltage=run.motor.u,angle=run.motor.pos";
    same(&records("struct.mat", &fixture("struct.mat"), map).unwrap()[0], &angle_only, 1e-12);
    let proposed = refusal("struct.mat", &fixture("struct.mat"), "");
    assert!(proposed.contains("time=run.t:s,voltage=run.motor.u:V,angle=run.motor.pos:rad"), "{proposed}");
    let map = "time=run.t,voltage=run.u,angle=table.q";
    same(&records("groups.h5", &fixture("groups.h5"), map).unwrap()[0], &angle_only, 1e-12);
}

#[test]
fn matlab_files_that_are_cut_off_say_where() {
    for name in ["v6.mat", "v7.mat", "v73.mat"] {
        let content = fixture(name);
        let refused = refusal(name, &content[..content.len() * 2 / 3], "");
        assert!(refused.contains("damaged") && refused.contains("\n  do: "), "{refused}");
    }
}

#[test]
fn objects_of_matlab_are_refused_with_the_line_that_exports_them() {
    // A variable of an opaque class, as a timetable is: flags, then its name.
    let mut content = b"MATLAB 5.0 MAT-file".to_vec();
    content.resize(124, b' ');
    content.extend(b"\x00\x01IM");
    let mut inner = Vec::new();
    for (kind, data) in [(6_u32, &[17, 0, 0, 0, 0, 0, 0, 0][..]), (1, b"run\0\0\0\0\0")] {
        inner.extend(kind.to_le_bytes());
        inner.extend((data.len() as u32).to_le_bytes());
        inner.extend(data);
    }
    content.extend(14_u32.to_le_bytes());
    content.extend((inner.len() as u32).to_le_bytes());
    content.extend(inner);
    let refused = refusal("log.mat", &content, "");
    assert!(refused.contains("writetimetable(run, 'log.csv')"), "{refused}");
}

#[test]
fn the_sheet_of_a_workbook_that_is_a_table_is_read_below_its_title() {
    let (names, columns) = canonical_columns();
    let mut rows: Vec<Vec<f64>> =
        (0..columns[0].len()).map(|row| columns.iter().map(|column| column[row]).collect()).collect();
    same(&records("log.xlsx", &sheet(&rows, &names, false), "").unwrap()[0], &as_csv(""), 0.0);
    // Dates are days; they become seconds since the first.
    for row in &mut rows {
        row[0] = 45_000.0 + row[0] / 86_400.0;
    }
    let content = sheet(&rows, &["Zeit", "U (V)", "Winkel (rad)", "other"], true);
    let map = "time=Zeit [s]:s,voltage=U (V):V,angle=Winkel (rad):rad";
    let expected = Record { speed_rad_s: None, ..as_csv("") };
    same(&records("log.xlsx", &content, map).unwrap()[0], &expected, 1e-6);
    let refused = refusal("log.xlsx", &content, "");
    assert!(refused.contains("time=Zeit [s]:s,voltage=U (V):V,angle=Winkel (rad):rad"), "{refused}");
    let cut = refusal("log.xlsx", &content[..content.len() / 2], "");
    assert!(cut.contains("spreadsheet is damaged"), "{cut}");
}

#[test]
fn parquet_gives_the_record_of_the_csv_however_it_is_packed() {
    use parquet::basic::{Compression, ZstdLevel};
    let (names, columns) = canonical_columns();
    let packings = [
        Compression::UNCOMPRESSED,
        Compression::SNAPPY,
        Compression::LZ4_RAW,
        Compression::ZSTD(ZstdLevel::default()),
        Compression::GZIP(Default::default()),
    ];
    for packing in packings {
        let content = parquet_of(&names, &columns, packing);
        same(&records("log.parquet", &content, "").unwrap()[0], &as_csv(""), 1e-9);
        let cut = refusal("log.parquet", &content[..content.len() / 2], "");
        assert!(cut.contains("damaged, cut off"), "{cut}");
    }
    // A blank is a blank of a CSV: a row that is left out.
    let mut gaps = columns.clone();
    gaps[3][100] = f64::NAN;
    let found = records("log.parquet", &parquet_of(&names, &gaps, packings[1]), "").unwrap();
    assert_eq!(found.iter().map(Record::len).sum::<usize>(), columns[0].len() - 1);
}

#[test]
fn mcap_gives_the_record_of_the_csv_from_json_and_from_ros_messages() {
    let (_, columns) = canonical_columns();
    let expected = as_csv("");
    for packing in ["", "lz4", "zstd"] {
        for (ros, map) in [
            (
                false,
                "voltage=/joint_states/motor.volts,angle=/joint_states/motor.angle,speed=/joint_states/speed",
            ),
            (
                true,
                "voltage=/joint_states/effort[wheel]:V,angle=/joint_states/position[wheel],speed=/joint_states/velocity[wheel]",
            ),
        ] {
            let content = mcap_of(&columns, ros, packing);
            let found = records("run.mcap", &content, map).unwrap();
            assert_eq!(found.len(), 1, "{packing} {ros}");
            same(&found[0], &expected, 1e-6);
            let refused = refusal("run.mcap", &content, "");
            assert!(refused.contains("time=time_s:s,voltage="), "{refused}");
            let cut = refusal("run.mcap", &content[..content.len() / 3], "");
            assert!(cut.contains("damaged") && cut.contains("byte"), "{cut}");
        }
    }
}
