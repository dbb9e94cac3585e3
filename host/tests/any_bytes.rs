//! Properties of the reader over files that nobody would write by hand.

mod formats_support;
#[path = "formats_support/readers.rs"]
mod readers;

use motorlens::log::guess::look;
use motorlens::log::{Format, Hold, ReadOptions, Record, content_faults, read, suspicions, write_canonical};
use proptest::prelude::*;
use readers::{WAYS, told, wrong};

fn outcome(
    content: &[u8],
    format: Format,
    map: Option<&str>,
) -> Result<Vec<Record>, motorlens::error::Error> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("any.csv");
    std::fs::write(&path, content).unwrap();
    let options = ReadOptions { format, map: map.map(|map| map.parse().unwrap()), ..ReadOptions::default() };
    read(&path, &options)
}

/// What logs are made of, so that chance comes upon every way of writing one.
const PIECES: [&str; 52] = [
    "time_s",
    "voltage_v",
    "angle_rad",
    "speed_rad_s",
    "t_ms",
    "pwm",
    "enc",
    "sec",
    "nanosec",
    "dt",
    "[s]",
    "(ms)",
    "V",
    "rad/s",
    ",",
    ",",
    ";",
    "\t",
    " ",
    "  ",
    "\n",
    "\n",
    "\r\n",
    "\r",
    "0",
    "1",
    "-2.5",
    "1,5",
    "1e300",
    "1732340000000000000",
    "nan",
    "\"",
    ":",
    "=",
    "t:12",
    " pwm:80",
    "12:34:56.789",
    "23:59:59",
    " -> ",
    "2024-05-01T",
    "01.05.2024 ",
    "Z",
    "+02:00",
    "PM",
    "#",
    "sep=;",
    ">u:",
    "§V",
    "|g",
    "0x1A",
    "FF",
    "I (12) a: ",
];

/// Panics of what looks through the records are faults too.
fn holds(answer: Result<Vec<Record>, motorlens::error::Error>) -> Result<(), TestCaseError> {
    let wrong = wrong(&answer);
    prop_assert!(wrong.is_none(), "{:?}", wrong);
    for record in answer.into_iter().flatten() {
        content_faults(&record);
        suspicions(&[record]);
    }
    Ok(())
}

static VALID: std::sync::LazyLock<Vec<Vec<u8>>> = std::sync::LazyLock::new(valid);

/// A valid file of every binary format.
fn valid() -> Vec<Vec<u8>> {
    use formats_support::{Wpilog, canonical_columns, fixture, mcap_of, npy, parquet_of, sheet, zip_of};
    let (names, columns) = canonical_columns();
    let mut wpilog = Wpilog::new();
    let state = wpilog.start("sysid-test-state-arm", "string", "");
    let entries = ["voltage-m-arm", "position-m-arm"].map(|name| wpilog.start(name, "double", "Rotation"));
    for k in 0..40 {
        wpilog.text(state, f64::from(k) * 0.02, "dynamic-forward");
        entries.iter().for_each(|entry| wpilog.number(*entry, f64::from(k) * 0.02, f64::from(k)));
    }
    let array = npy("'<f8'", "True", "(200, 4)", &columns.concat());
    let vector = npy("'<f8'", "False", "(200,)", &columns[0]);
    let rows: Vec<Vec<f64>> = (0..40).map(|row| columns.iter().map(|column| column[row]).collect()).collect();
    let mut all = vec![
        wpilog.bytes,
        array,
        zip_of(&[("time_s.npy".into(), vector.clone()), ("voltage_v.npy".into(), vector)], true),
        sheet(&rows, &names, true),
        parquet_of(&names, &columns, parquet::basic::Compression::SNAPPY),
        mcap_of(&columns, true, "lz4"),
        mcap_of(&columns, false, ""),
    ];
    all.extend(["v6.mat", "v7.mat", "v73.mat", "struct.mat", "groups.h5"].map(fixture));
    all.extend(["sheet.xls", "sheet.ods", "lists.parquet"].map(fixture));
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_make_the_reader_panic(content in prop::collection::vec(any::<u8>(), 0..400)) {
        for format in [Format::Csv, Format::WpilibSysid, Format::BamJson] {
            holds(outcome(&content, format, None))?;
        }
    }

    #[test]
    fn no_pieces_of_logs_make_the_reader_or_the_guess_panic(
        pieces in prop::collection::vec(0..PIECES.len(), 0..200),
        rows in 0..60_usize,
        way in 0..WAYS.len(),
        wide in any::<bool>(),
    ) {
        let text: String = pieces.iter().map(|k| PIECES[*k]).collect();
        // The last line of it many times over makes a table of many.
        let row = text.lines().last().unwrap_or_default().to_owned();
        let text = text + "\n" + &format!("{row}\n").repeat(rows);
        let bytes: Vec<u8> =
            if wide { text.encode_utf16().flat_map(u16::to_le_bytes).collect() } else { text.into_bytes() };
        let directory = tempfile::tempdir().unwrap();
        let (path, other) = (directory.path().join("any.csv"), directory.path().join("other.csv"));
        std::fs::write(&path, &bytes).unwrap();
        std::fs::write(&other, "time_s,angle_rad\n0,0\n1,1\n2,2\n").unwrap();
        holds(read(&path, &told(Format::Csv, WAYS[way])))?;
        let both = format!("{}+{}", path.display(), other.display());
        holds(read(std::path::Path::new(&both), &told(Format::Csv, WAYS[way])))?;
        if let Ok(look) = look(&path) {
            prop_assert!(look.names.len() <= look.kinds.len().max(1));
        }
    }

    #[test]
    fn no_damage_of_a_binary_file_makes_its_reader_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        end in any::<prop::sample::Index>(),
        cut in any::<bool>(),
    ) {
        for mut content in VALID.iter().cloned() {
            for (place, byte) in &changes {
                let place = place.index(content.len());
                content[place] = *byte;
            }
            if cut {
                content.truncate(end.index(content.len()));
            }
            holds(outcome(&content, Format::Csv, None))?;
        }
    }

    #[test]
    fn no_fields_under_a_good_header_make_the_reader_panic(
        rows in prop::collection::vec("[-0-9.eE,;#\"x\u{B5} ]{0,24}", 0..60),
        mapped in any::<bool>(),
    ) {
        let content = format!("time_s,voltage_v,speed_rad_s\n{}", rows.join("\n"));
        holds(outcome(content.as_bytes(), Format::Csv, mapped.then_some("time=0:us,voltage=1:mV*3,angle=2:rev")))?;
    }

    #[test]
    fn the_numbers_of_any_motion_survive_writing_and_reading(
        // A step that stands apart from all others would be no motion, and be left out.
        steps in prop::collection::vec((1e-6..10.0f64, -1e3..1e3f64, 0.5..1.0f64), 20..80),
        exponent in -290..290i32,
        hold in prop::bool::ANY,
    ) {
        let (mut time, mut turned) = (0.0, 0.0);
        let record = Record {
            name: "any".into(),
            time_s: steps.iter().map(|(step, ..)| { time += step; time }).collect(),
            voltage_v: steps.iter().map(|(_, voltage, _)| *voltage).collect(),
            angle_rad: Some(steps.iter().map(|(.., step)| { turned += step * 10f64.powi(exponent); turned }).collect()),
            hold: if hold { Hold::First } else { Hold::Zero },
            ..Record::default()
        };
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("any.csv");
        write_canonical(&record, &path).unwrap();
        let back = read(&path, &ReadOptions::default()).unwrap().remove(0);
        prop_assert_eq!(back.time_s, record.time_s);
        prop_assert_eq!(back.voltage_v, record.voltage_v);
        prop_assert_eq!(back.angle_rad, record.angle_rad);
        prop_assert_eq!(back.hold, record.hold);
    }
}
