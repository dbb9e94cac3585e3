//! Arrays by name or by number: NumPy, MATLAB, HDF5.

use motorlens::log::Record;

use super::formats_support::{canonical_columns, fixture, npy, zip_of};
use super::{as_csv, fixed, records, refusal, same};

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
