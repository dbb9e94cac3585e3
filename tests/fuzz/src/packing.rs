//! Archives around an input: chance would never come upon the sums of a zip, and the readers behind it would see nothing.

use std::io::Read;
use std::sync::LazyLock;

use crate::formats_support::{canonical_columns, sheet, zip_of};

/// Names and contents of an archive's files.
type Files = Vec<(String, Vec<u8>)>;

/// A spreadsheet of Excel's and one of LibreOffice's, unpacked.
static SHEETS: LazyLock<[Files; 2]> = LazyLock::new(|| {
    let (names, columns) = canonical_columns();
    let rows: Vec<Vec<f64>> = (0..30).map(|row| columns.iter().map(|column| column[row]).collect()).collect();
    let ods = include_bytes!("../../../host/tests/formats/sheet.ods");
    [unpacked(&sheet(&rows, &names, true)), unpacked(ods)]
});

/// The files of an archive.
fn unpacked(archive: &[u8]) -> Files {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(archive)).expect("a valid archive");
    let mut files = Files::new();
    for number in 0..archive.len() {
        let mut file = archive.by_index(number).expect("a file of a valid archive");
        let mut content = Vec::new();
        let name = file.name().expect("a name of a valid archive").into_owned();
        file.read_to_end(&mut content).expect("a file of a valid archive");
        files.push((name, content));
    }
    files
}

/// Which file of which archive an input stands for: one input for each, with its content.
pub fn parts() -> Vec<Vec<u8>> {
    let files = SHEETS.iter().flatten().enumerate();
    let mut parts: Vec<Vec<u8>> = files
        .filter(|(_, (_, content))| content.len() < 20_000)
        .map(|(number, (_, content))| [&[number as u8], content.as_slice()].concat())
        .collect();
    let array = crate::formats_support::npy("'<f8'", "False", "(40,)", &[0.5; 40]);
    parts.push([&[u8::MAX], array.as_slice()].concat());
    parts
}

/// The archive that an input stands for: a spreadsheet of which one file is this input, or one of arrays.
pub fn packed(input: &[u8]) -> Vec<u8> {
    let Some((which, content)) = input.split_first() else { return Vec::new() };
    let mut number = usize::from(*which);
    for files in SHEETS.iter() {
        if number < files.len() {
            let mut files = files.clone();
            files[number].1 = content.to_vec();
            return zip_of(&files, false);
        }
        number -= files.len();
    }
    let both = ["time_s.npy", "voltage_v.npy"].map(|name| (name.to_owned(), content.to_vec()));
    zip_of(&both, false)
}
