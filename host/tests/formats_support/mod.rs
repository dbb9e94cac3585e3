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
    while (10 + header.len() + 1) % 64 != 0 {
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
