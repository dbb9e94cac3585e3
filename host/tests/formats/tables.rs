//! Tables and messages: spreadsheets, Parquet, MCAP.

use motorlens::log::Record;

use super::formats_support::{canonical_columns, fixture, mcap_of, parquet_of, sheet};
use super::{as_csv, fixed, records, refusal, same};

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
fn spreadsheets_of_other_programs_are_read_as_they_are() {
    for name in ["sheet.xls", "sheet.ods"] {
        same(&records(name, &fixture(name), "").unwrap()[0], &fixed(), 1e-9);
        let cut = refusal(name, &fixture(name)[..2000], "");
        assert!(cut.contains("damaged") && cut.contains("save it anew"), "{cut}");
    }
}

#[test]
fn lists_of_one_length_are_a_column_for_each_place() {
    let content = fixture("lists.parquet");
    let map = "time=timestamp,voltage=action[0],angle=observation.state[0],speed=observation.state[1]";
    same(&records("episode.parquet", &content, map).unwrap()[0], &fixed(), 1e-9);
    let proposed = refusal("episode.parquet", &content, "");
    assert!(proposed.contains("action[0]") && proposed.contains("observation.state[1]"), "{proposed}");
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
