//! Small writers of the formats that have no crate with one, and the numbers that all of them write.

#![allow(dead_code)] // each test file is a crate of its own and uses what it needs

/// Names and columns of a canonical log: 2 s of a motion at 100 Hz.
pub fn canonical_columns() -> (Vec<&'static str>, Vec<Vec<f64>>) {
    let time: Vec<f64> = (0..200).map(|k| f64::from(k) / 100.0).collect();
    let voltage = time.iter().map(|t| if (2.0 * t).fract() < 0.5 { 4.5 } else { -3.25 }).collect();
    let angle = time.iter().map(|t| 3.0 - 3.0 * (2.0 * t).cos()).collect();
    let speed = time.iter().map(|t| 6.0 * (2.0 * t).sin()).collect();
    (vec!["time_s", "voltage_v", "angle_rad", "speed_rad_s"], vec![time, voltage, angle, speed])
}

/// A WPILib data log.
pub struct Wpilog {
    pub bytes: Vec<u8>,
    entries: u32,
}

impl Wpilog {
    pub fn new() -> Self {
        Wpilog { bytes: b"WPILOG\x00\x01\x00\x00\x00\x00".to_vec(), entries: 0 }
    }

    fn record(&mut self, entry: u32, time_s: f64, payload: &[u8]) {
        let time = ((time_s * 1e6).round() as u64).to_le_bytes();
        // Numbers as short as they go: entry of 1 byte, size of 2, time of 5.
        self.bytes.push(0b0100_0100);
        self.bytes.push(u8::try_from(entry).unwrap());
        self.bytes.extend(u16::try_from(payload.len()).unwrap().to_le_bytes());
        self.bytes.extend(&time[..5]);
        self.bytes.extend(payload);
    }

    /// Starts an entry and gives its number.
    pub fn start(&mut self, name: &str, kind: &str, metadata: &str) -> u32 {
        self.entries += 1;
        let mut payload = vec![0];
        payload.extend(self.entries.to_le_bytes());
        for text in [name, kind, metadata] {
            payload.extend((text.len() as u32).to_le_bytes());
            payload.extend(text.as_bytes());
        }
        self.record(0, 0.0, &payload);
        self.entries
    }

    pub fn number(&mut self, entry: u32, time_s: f64, value: f64) {
        self.record(entry, time_s, &value.to_le_bytes());
    }

    pub fn text(&mut self, entry: u32, time_s: f64, text: &str) {
        self.record(entry, time_s, text.as_bytes());
    }
}

/// A NumPy array of format 1.0, its header padded so that the data begin at a multiple of 64 bytes.
pub fn npy(description: &str, fortran: &str, shape: &str, data: &[f64]) -> Vec<u8> {
    let mut header = format!("{{'descr': {description}, 'fortran_order': {fortran}, 'shape': {shape}, }}");
    while !(10 + header.len() + 1).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// A zip archive of files, packed or not.
pub fn zip_of(files: &[(String, Vec<u8>)], packed: bool) -> Vec<u8> {
    use zip::write::SimpleFileOptions;
    let method = if packed { zip::CompressionMethod::Deflated } else { zip::CompressionMethod::Stored };
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, content) in files {
        archive.start_file(name, SimpleFileOptions::default().compression_method(method)).unwrap();
        std::io::Write::write_all(&mut archive, content).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A spreadsheet with a title, a header, a row of units perhaps, and these rows; the first column dates where `dated`.
pub fn sheet(rows: &[Vec<f64>], names: &[&str], dated: bool) -> Vec<u8> {
    let place = |row: usize, column: usize| format!("{}{}", char::from(b'A' + column as u8), row + 1);
    let text = |row, column, text: &str| {
        format!("<c r=\"{}\" t=\"inlineStr\"><is><t>{text}</t></is></c>", place(row, column))
    };
    let mut body = format!("<row r=\"1\">{}</row>", text(0, 0, "Run 7"));
    let header: String = names.iter().enumerate().map(|(k, name)| text(2, k, name)).collect();
    body += &format!("<row r=\"3\">{header}</row>");
    for (k, row) in rows.iter().enumerate() {
        let cells: String = row
            .iter()
            .enumerate()
            .map(|(c, value)| {
                let style = if dated && c == 0 { " s=\"1\"" } else { "" };
                format!("<c r=\"{}\"{style}><v>{value:?}</v></c>", place(3 + k, c))
            })
            .collect();
        body += &format!("<row r=\"{}\">{cells}</row>", 4 + k);
    }
    let main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    let relations = "http://schemas.openxmlformats.org/package/2006/relationships";
    let office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    let empty = format!("<worksheet xmlns=\"{main}\"><sheetData/></worksheet>");
    let file = |name: &str, content: String| (name.to_owned(), content.into_bytes());
    zip_of(
        &[
            file(
                "[Content_Types].xml",
                "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"/>".into(),
            ),
            file(
                "_rels/.rels",
                format!(
                    "<Relationships xmlns=\"{relations}\"><Relationship Id=\"rId1\" Type=\"{office}/officeDocument\" Target=\"xl/workbook.xml\"/></Relationships>"
                ),
            ),
            file(
                "xl/workbook.xml",
                format!(
                    "<workbook xmlns=\"{main}\" xmlns:r=\"{office}\"><sheets><sheet name=\"Notes\" sheetId=\"1\" r:id=\"rId1\"/><sheet name=\"Log\" sheetId=\"2\" r:id=\"rId2\"/></sheets></workbook>"
                ),
            ),
            file(
                "xl/_rels/workbook.xml.rels",
                format!(
                    "<Relationships xmlns=\"{relations}\"><Relationship Id=\"rId1\" Type=\"{office}/worksheet\" Target=\"worksheets/sheet1.xml\"/><Relationship Id=\"rId2\" Type=\"{office}/worksheet\" Target=\"worksheets/sheet2.xml\"/><Relationship Id=\"rId3\" Type=\"{office}/styles\" Target=\"styles.xml\"/></Relationships>"
                ),
            ),
            file(
                "xl/styles.xml",
                format!(
                    "<styleSheet xmlns=\"{main}\"><cellXfs count=\"2\"><xf numFmtId=\"0\"/><xf numFmtId=\"22\"/></cellXfs></styleSheet>"
                ),
            ),
            file("xl/worksheets/sheet1.xml", empty),
            file(
                "xl/worksheets/sheet2.xml",
                format!("<worksheet xmlns=\"{main}\"><sheetData>{body}</sheetData></worksheet>"),
            ),
        ],
        true,
    )
}

/// The columns as a Parquet file; every seventh speed is blank.
pub fn parquet_of(names: &[&str], columns: &[Vec<f64>], packing: parquet::basic::Compression) -> Vec<u8> {
    use parquet::data_type::{DoubleType, Int64Type};
    use parquet::file::{properties::WriterProperties, writer::SerializedFileWriter};
    let fields: String = names[1..].iter().map(|name| format!("optional double {name};")).collect();
    let schema = format!("message log {{ required int64 {} (TIMESTAMP(MICROS,true)); {fields} }}", names[0]);
    let schema = parquet::schema::parser::parse_message_type(&schema).unwrap();
    let properties = WriterProperties::builder().set_compression(packing).build();
    let mut file = SerializedFileWriter::new(Vec::new(), schema.into(), properties.into()).unwrap();
    // Two groups of rows.
    let half = columns[0].len() / 2;
    for range in [0..half, half..columns[0].len()] {
        let mut group = file.next_row_group().unwrap();
        for (number, column) in columns.iter().enumerate() {
            let values = &column[range.clone()];
            let mut writer = group.next_column().unwrap().unwrap();
            if number == 0 {
                let micros: Vec<i64> = values.iter().map(|t| (t * 1e6).round() as i64).collect();
                writer.typed::<Int64Type>().write_batch(&micros, None, None).unwrap();
            } else {
                let there: Vec<i16> = values.iter().map(|v| i16::from(!v.is_nan())).collect();
                let values: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
                writer.typed::<DoubleType>().write_batch(&values, Some(&there), None).unwrap();
            }
            writer.close().unwrap();
        }
        group.close().unwrap();
    }
    file.into_inner().unwrap()
}

/// Messages of the columns on one topic, in JSON or as ROS 2's joint states, packed in chunks.
pub fn mcap_of(columns: &[Vec<f64>], ros: bool, packing: &str) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let record = |kind: u8, data: &[u8]| [&[kind][..], &(data.len() as u64).to_le_bytes(), data].concat();
    let layout = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n\
                  ===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id";
    let mut inside = Vec::new();
    if ros {
        let data =
            [&1_u16.to_le_bytes()[..], &text("sensor_msgs/msg/JointState"), &text("ros2msg"), &text(layout)];
        inside.extend(record(3, &data.concat()));
    }
    let (schema, encoding) = if ros { (1_u16, "cdr") } else { (0, "json") };
    let channel =
        [&7_u16.to_le_bytes()[..], &schema.to_le_bytes(), &text("/joint_states"), &text(encoding), &[0; 4]];
    inside.extend(record(4, &channel.concat()));
    let begin = 1_700_000_000_u64;
    for row in 0..columns[0].len() {
        let micros = (columns[0][row] * 1e6).round() as u64;
        let nanos = begin * 1_000_000_000 + micros * 1000;
        let value = |column: usize| columns[column][row];
        let message = if ros {
            let mut cdr = vec![0, 1, 0, 0];
            let align = |cdr: &mut Vec<u8>, to: usize| {
                while !(cdr.len() - 4).is_multiple_of(to) {
                    cdr.push(0)
                }
            };
            cdr.extend((nanos / 1_000_000_000).to_le_bytes()[..4].iter());
            cdr.extend((nanos % 1_000_000_000).to_le_bytes()[..4].iter());
            cdr.extend(text("\0"));
            align(&mut cdr, 4);
            cdr.extend(1_u32.to_le_bytes());
            cdr.extend(text("wheel\0"));
            for column in [2, 3, 1] {
                align(&mut cdr, 4);
                cdr.extend(1_u32.to_le_bytes());
                align(&mut cdr, 8);
                cdr.extend(value(column).to_le_bytes());
            }
            cdr
        } else {
            serde_json::json!({"motor": {"volts": value(1), "angle": value(2)}, "speed": value(3), "note": "x"})
                .to_string()
                .into_bytes()
        };
        // Of JSON the time of logging counts; a stamp in the message is nearer to the sensor.
        let logged = nanos + if ros { 3_000_000 * (row as u64 % 2) } else { 0 };
        let head = [&7_u16.to_le_bytes()[..], &[0; 4], &logged.to_le_bytes(), &logged.to_le_bytes()].concat();
        inside.extend(record(5, &[head, message].concat()));
    }
    let packed = match packing {
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            std::io::Write::write_all(&mut encoder, &inside).unwrap();
            encoder.finish().unwrap()
        }
        "zstd" => zstd::stream::encode_all(&inside[..], 3).unwrap(),
        _ => inside.clone(),
    };
    let chunk = [
        &[0; 16][..],
        &(inside.len() as u64).to_le_bytes(),
        &[0; 4],
        &text(packing),
        &(packed.len() as u64).to_le_bytes(),
        &packed,
    ];
    let head = record(1, &[text(""), text("test")].concat());
    [b"\x89MCAP0\r\n".to_vec(), head, record(6, &chunk.concat()), record(15, &[0; 4])].concat()
}

/// A file of `tests/formats`.
pub fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats").join(name)).unwrap()
}
