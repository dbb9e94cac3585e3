//! Formats that are not read: what they are, and which program makes something of them that is.

use std::path::Path;

use super::Fault;

/// A format that another program converts.
struct Foreign {
    name: &'static str,
    /// How a file of it begins; empty where only the name tells.
    magic: &'static [u8],
    /// Where the magic stands.
    at: usize,
    /// What files of it are called; for those with a magic, for nothing.
    extension: &'static str,
    remedy: &'static str,
}

/// A row whose content tells.
const fn content(name: &'static str, magic: &'static [u8], remedy: &'static str) -> Foreign {
    Foreign { name, magic, at: 0, extension: "", remedy }
}

/// A row that only its name tells, where the content is no text.
const fn named_by(name: &'static str, extension: &'static str, remedy: &'static str) -> Foreign {
    Foreign { name, magic: b"", at: 0, extension, remedy }
}

const UNPACK: &str = "unpack it and give the log that is in it";
const WEB: &str = "export the table as CSV, or save the page's data and not the page";
const IMAGE: &str = "give the log itself, not a picture of it";
const MCAP: &str = "convert it with the MCAP command line tool: mcap convert OLD NEW.mcap";
const PANDAS: &str =
    "write it as Parquet: python -c \"import pandas; pandas.read_feather('OLD').to_parquet('NEW.parquet')\"";
const ASAMMDF: &str = "write it as CSV: python -m pip install asammdf, then \
                       python -c \"from asammdf import MDF; MDF('OLD').export('csv', 'NEW.csv', single_time_base=True)\"";

const FRAMES: &str = "decode the frames with the DBC of the drive (python -m pip install cantools; of candump: python -m cantools decode \
                      --single-line DBC < OLD) and write the signals as CSV";

const FOREIGN: [Foreign; 36] = [
    content("XML", b"<?xml", "export the table as CSV from the program that made it"),
    content("a page of the web", b"<!DOCTYPE", WEB),
    content("a page of the web", b"<html", WEB),
    content(
        "a document with its formatting (.rtf)",
        b"{\\rtf",
        "save it as plain text from the program that wrote it",
    ),
    content(
        "a pointer of Git LFS to the log",
        b"version https://git-lfs.github.com/spec/",
        "fetch the log itself in its repository: git lfs pull",
    ),
    content("a ROS 1 bag", b"#ROSBAG V", MCAP),
    content("a database, perhaps a ROS 2 bag (.db3)", b"SQLite format 3\0", MCAP),
    content("a PX4 log (.ulg)", b"ULog\x01\x12\x35", "convert it with pyulog: ulog2csv OLD"),
    content(
        "an ArduPilot log (.bin)",
        b"\xA3\x95\x80\x80",
        "convert it with pymavlink, one message at a time: mavlogdump.py --format csv --types RCOU OLD > NEW.csv",
    ),
    content("a measurement file (.mf4, .dat)", b"MDF     ", ASAMMDF),
    content("a measurement file that was not closed (.mf4)", b"UnFinMF ", ASAMMDF),
    content(
        "a LabVIEW measurement (.tdms)",
        b"TDSm",
        "write it as CSV with npTDMS: python -c \"from nptdms import TdmsFile; \
         TdmsFile('OLD').as_dataframe().to_csv('NEW.csv')\"",
    ),
    content("a log of CAN frames (.blf)", b"LOGG\x90\0\0\0", FRAMES),
    content("a log of CAN frames (.trc)", b";$FILEVERSION", FRAMES),
    content("a Feather file", b"ARROW1\0\0", PANDAS),
    content("a Feather file", b"FEA1", PANDAS),
    content(
        "a Python pickle",
        b"\x80\x04\x95",
        "write it as CSV: python -c \"import pandas; pandas.read_pickle('OLD').to_csv('NEW.csv', index=False)\"",
    ),
    content("compressed with gzip", b"\x1F\x8B", "unpack it with gunzip"),
    content("compressed with bzip2", b"BZh91AY&SY", "unpack it with bunzip2"),
    content("compressed with xz", b"\xFD7zXZ\0", "unpack it with unxz"),
    content("compressed with zstd", b"\x28\xB5\x2F\xFD", "unpack it with unzstd"),
    content("compressed with lz4", b"\x04\x22\x4D\x18", "unpack it with unlz4"),
    content("a 7-Zip archive", b"7z\xBC\xAF\x27\x1C", UNPACK),
    content("a RAR archive", b"Rar!\x1A\x07", UNPACK),
    Foreign { name: "a tar archive", magic: b"ustar", at: 257, extension: "", remedy: UNPACK },
    content("a zip archive", b"PK\x03\x04", UNPACK),
    content("a PDF", b"%PDF-", "give the log itself, not a print of it"),
    content("a picture", b"\x89PNG\r\n", IMAGE),
    content("a picture", b"\xFF\xD8\xFF", IMAGE),
    content("a picture", b"GIF8", IMAGE),
    content("a program", b"\x7FELF", "give the log that it wrote"),
    named_by(
        "a CTRE hoot log",
        "hoot",
        "convert it with Phoenix Tuner X (Tools, Extract Signal Logs) or with owlet: owlet -f wpilog OLD NEW.wpilog",
    ),
    named_by("a REV log", "revlog", "open it in AdvantageScope and export it as WPILOG or CSV"),
    named_by(
        "a MAVLink telemetry log",
        "tlog",
        "convert it with pymavlink, one message at a time: mavlogdump.py --format csv --types SERVO_OUTPUT_RAW OLD > NEW.csv",
    ),
    named_by(
        "a MATLAB file of version 4 or damaged",
        "mat",
        "save it anew in MATLAB: save('NEW.mat', '-v7')",
    ),
    named_by("a damaged spreadsheet", "xlsx", "save it anew as .xlsx or as CSV (UTF-8)"),
];

/// What the file at `path` is, where it begins with `start`, and what to do; `None` where it is nothing known or a text.
pub fn named(start: &[u8], path: &Path) -> Option<Fault> {
    let extension = path.extension().map(|text| text.to_string_lossy().to_lowercase()).unwrap_or_default();
    let is_text = !start.contains(&0) || start.starts_with(b"\xFF\xFE") || start.starts_with(b"\xFE\xFF");
    let row = FOREIGN.iter().find(|row| match row.magic {
        b"" => !is_text && row.extension == extension,
        // Four letters alone may begin a header.
        b"TDSm" | b"FEA1" | b"GIF8" => !is_text && start.starts_with(row.magic),
        magic => start.get(row.at..).is_some_and(|rest| rest.starts_with(magic)),
    });
    let known = row.map(|row| (row.name, row.remedy));
    let known = known.or_else(|| are_frames(start).then_some(("a log of CAN frames", FRAMES)));
    known.map(|(name, remedy)| Fault::new(format!("this is {name}, not a log that is read"), remedy))
}

/// Whether a text begins with CAN frames as candump prints them, `(1714557600.25) can0 123#00FF` or `can0  123  [2]  00 FF`, or as Vector's
/// tools do.
fn are_frames(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let (Some(first), Some(second)) = (lines.next(), lines.next()) else { return false };
    let is_hex = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_hexdigit());
    let is_frame = |line: &str| {
        let line =
            if line.starts_with('(') { line.split_once(')').map_or("", |(_, rest)| rest) } else { line };
        let words: Vec<&str> = line.split_whitespace().collect();
        let [bus, id, ..] = words[..] else { return false };
        let length = words.get(2).and_then(|word| word.strip_prefix('[')?.strip_suffix(']'));
        let is_short = id.split_once('#').is_some_and(|(id, _)| is_hex(id));
        bus.starts_with(|c: char| c.is_ascii_alphabetic())
            && (is_short || is_hex(id) && length.is_some_and(is_hex))
    };
    is_frame(first) && is_frame(second) || first.starts_with("date ") && second.starts_with("base ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_another_program_has_to_convert_is_named_with_the_program() {
        for (start, name, is, remedy) in [
            (&b"#ROSBAG V2.0\n"[..], "x.bag", "ROS 1 bag", "mcap convert"),
            (b"\0\x01\x02hoot", "x.HOOT", "hoot", "owlet"),
            (b"MDF     4.10", "x.dat", "measurement", "asammdf"),
            (b"ULog\x01\x12\x35\x01", "x.ulg", "PX4", "ulog2csv"),
            (b"\xA3\x95\x80\x80\x59", "x.bin", "ArduPilot", "mavlogdump"),
            (b"\x1F\x8B\x08", "x.csv", "gzip", "gunzip"),
            (b"PK\x03\x04", "x", "zip", "unpack"),
            (b"%PDF-1.7", "x.pdf", "PDF", "the log itself"),
            (b"{\\rtf1\\ansi time_s,voltage_v\\par\n", "x.csv", ".rtf", "plain text"),
            (
                b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\n",
                "x.csv",
                "Git LFS",
                "git lfs pull",
            ),
            (b"<?xml version='1.0'?>", "x.xml", "XML", "CSV"),
            (
                b"(1714557600.250000) can0 123#00FF\n(1714557600.260000) can0 123#01FF\n",
                "x.log",
                "CAN frames",
                "DBC",
            ),
            (b"  can0  123   [2]  00 FF\n  can0  124   [2]  01 FF\n", "x.txt", "CAN frames", "cantools"),
            (b"date Wed May 1 12:00:00 2024\nbase hex  timestamps absolute\n", "x.asc", "CAN frames", "DBC"),
        ] {
            let fault = named(start, Path::new(name)).unwrap();
            assert!(fault.why.contains(is) && fault.remedy.contains(remedy), "{name}: {fault:?}");
        }
    }

    #[test]
    fn texts_are_left_to_the_reader_of_texts_whatever_they_are_called() {
        for (start, name) in [
            (&b"time,voltage\n"[..], "x.hoot"),
            (b"TDSm,y\n", "x.csv"),
            (b"GIF8 is no header", "x.csv"),
            (b"\xFF\xFEt\0,\0", "x.mat"),
            (b"0,1\0\0", "x.csv"),
            (b"Results:\n12,13\n", "x.yaml"),
            (b"pwm: 80\nenc: 7\n", "x.txt"),
            (b"u 12 [V]\nw 13 [rad/s]\n", "x.txt"),
            (b"(1, 2)\n(3, 4)\n", "x.txt"),
        ] {
            assert_eq!(named(start, Path::new(name)), None, "{name}");
        }
    }
}
