//! One motion, written as people's programs, boards and spreadsheets write it: each is read as the same record, or its proposal reads it.

use std::fmt::Write as _;
use std::path::PathBuf;

use motorlens::error::{BadInput, Error};
use motorlens::log::{ReadOptions, Record, read};

#[path = "text_logs/clocks.rs"]
mod clocks;
#[path = "text_logs/drives.rs"]
mod drives;
#[path = "text_logs/heads.rs"]
mod heads;
#[path = "text_logs/names.rs"]
mod names;
#[path = "text_logs/numbers.rs"]
mod numbers;
#[path = "text_logs/signs.rs"]
mod signs;
#[path = "text_logs/tools.rs"]
mod tools;

const ROWS: u32 = 200;

/// Time, s, voltage, V, and angle, rad, of row `k`, with four decimals.
fn row(k: u32) -> (f64, f64, f64) {
    let t = f64::from(k) * 0.01;
    let round = |x: f64| (1e4 * x).round() / 1e4;
    (t, round(4.0 * (3.0 * t).sin()), round(2.0 - 2.0 * (3.0 * t).cos()))
}

/// A file of `head` and one line per row.
fn lines(head: &str, line: impl Fn(u32, f64, f64, f64) -> String) -> String {
    let mut text = head.to_owned();
    for k in 0..ROWS {
        let (t, u, x) = row(k);
        text += &line(k, t, u, x);
        text.push('\n');
    }
    text
}

/// A clock time of `ms` milliseconds after `from` seconds since midnight.
fn clock(from: u32, ms: u32) -> String {
    let all = (u64::from(from) * 1000 + u64::from(ms)) % 86_400_000;
    format!("{:02}:{:02}:{:02}.{:03}", all / 3_600_000, all / 60_000 % 60, all / 1000 % 60, all % 1000)
}

fn kept(content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("log.csv");
    std::fs::write(&path, content).unwrap();
    (directory, path)
}

fn read_bytes(content: &[u8], options: &ReadOptions) -> Result<Record, Error> {
    let (_directory, path) = kept(content);
    read(&path, options).map(|mut records| {
        assert_eq!(records.len(), 1);
        records.remove(0)
    })
}

fn mapped(map: &str) -> ReadOptions {
    ReadOptions { map: (!map.is_empty()).then(|| map.parse().unwrap()), ..ReadOptions::default() }
}

/// The record is that of all rows but the first `missing`, whatever the origin of its clock.
fn assert_same(record: &Record, what: &str, missing: usize) {
    assert_eq!(record.len(), ROWS as usize - missing, "{what}: {:?}", record.warnings);
    let angle = record.angle_rad.as_ref().unwrap();
    for k in 0..record.len() {
        let (t, u, x) = row((k + missing) as u32);
        let since = record.time_s[k] - record.time_s[0] + 0.01 * missing as f64;
        let off = [since - t, record.voltage_v[k] - u, angle[k] - x];
        assert!(off.iter().all(|off| off.abs() < 2e-6), "{what}: {off:?} in row {k}");
    }
}

const HEADER: &str = "time_s,voltage_v,angle_rad\n";

fn plain() -> String {
    lines(HEADER, |_, t, u, x| format!("{t:.4},{u:.4},{x:.4}"))
}

/// The same rows in every encoding, with the mapping that names their columns.
fn encoded() -> (Vec<(&'static str, Vec<u8>)>, &'static str) {
    let header = "Zeit [s],Spannung µ [V],Winkel für ° [rad]\n";
    let text = plain().replace(HEADER, header);
    let wide = |order: fn(u16) -> [u8; 2]| -> Vec<u8> { text.encode_utf16().flat_map(order).collect() };
    let (little, big) = (wide(u16::to_le_bytes), wide(u16::to_be_bytes));
    let map = "time=Zeit [s],voltage=Spannung µ [V],angle=Winkel für ° [rad]";
    let rows = vec![
        ("UTF-8", text.clone().into_bytes()),
        ("UTF-8 with its mark", [b"\xEF\xBB\xBF", text.as_bytes()].concat()),
        ("UTF-16 LE with its mark", [b"\xFF\xFE", little.as_slice()].concat()),
        ("UTF-16 BE with its mark", [b"\xFE\xFF", big.as_slice()].concat()),
        ("UTF-16 LE", little.clone()),
        ("UTF-16 BE", big.clone()),
        ("Windows-1252", text.chars().map(|c| c as u8).collect()),
        ("CR LF", text.replace('\n', "\r\n").into_bytes()),
        ("CR", text.replace('\n', "\r").into_bytes()),
        ("a block of zeros behind", [text.as_bytes(), &[0; 900]].concat()),
    ];
    (rows, map)
}

/// The same rows however their fields are separated and their numbers written, under canonical names.
fn separated() -> Vec<(&'static str, String)> {
    let comma = |x: f64| format!("{x:.4}").replace('.', ",");
    let semicolons = |k: u32, t: f64, u: f64, x: f64| {
        let _ = k;
        format!("{};{};{}", comma(t), comma(u), comma(x))
    };
    let names = HEADER.replace(',', ";");
    vec![
        (
            "decimal commas between commas",
            lines(HEADER, |_, t, u, x| format!("{},{},{}", comma(t), comma(u), comma(x))),
        ),
        (
            "decimal commas in quotes",
            lines(HEADER, |_, t, u, x| format!("\"{}\",\"{}\",\"{}\"", comma(t), comma(u), comma(x))),
        ),
        ("semicolons and decimal commas", lines(&names, semicolons)),
        ("a spreadsheet's remark", lines(&format!("sep=;\r\n{names}"), semicolons)),
        ("blanks", lines("time_s voltage_v angle_rad\n", |_, t, u, x| format!("{t:.4} {u:.4} {x:.4}"))),
        (
            "columns aligned",
            lines("  time_s   voltage_v   angle_rad\n", |_, t, u, x| format!("{t:10.4} {u:10.4} {x:10.4}")),
        ),
        ("tabs", lines("time_s\tvoltage_v\tangle_rad\n", |_, t, u, x| format!("{t}\t{u}\t{x}"))),
        (
            "NumPy's header",
            lines("# time_s voltage_v angle_rad\n", |_, t, u, x| format!("{t:.18e} {u:.18e} {x:.18e}")),
        ),
        ("a row of units", lines(&format!("{HEADER}(s),(V),(rad)\n\n"), |_, t, u, x| format!("{t},{u},{x}"))),
        ("units beside the numbers", lines(HEADER, |_, t, u, x| format!("{t:.4}s,{u:.4}V,{x:.4} rad"))),
        ("half a row first", format!("4,1.25\n{}", plain())),
        (
            "boot text first",
            format!("rst:0x1 (POWERON_RESET),boot:0x13\r\nentry 0x400805e4\r\nREADY\r\n{}", plain()),
        ),
        ("noise before the header", plain().replace(HEADER, &format!("\u{0}\u{0}{HEADER}"))),
    ]
}

#[test]
fn texts_of_any_encoding_line_end_separator_and_decimal_are_read_alike() {
    let (encoded, map) = encoded();
    let encoded = encoded.into_iter().map(|(what, bytes)| (what, bytes, map));
    let separated = separated().into_iter().map(|(what, text)| (what, text.into_bytes(), ""));
    for (what, bytes, map) in encoded.chain(separated) {
        let record = read_bytes(&bytes, &mapped(map)).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_same(&record, what, 0);
    }
}

#[test]
fn times_are_understood_however_they_are_written() {
    const NOON: u32 = 12 * 3600;
    const LATE: u32 = 24 * 3600 - 1;
    let epoch = 1_732_340_000_u64;
    let table = |time: &dyn Fn(u32) -> String| lines(HEADER, |k, _, u, x| format!("{},{u},{x}", time(k)));
    let renamed = |name: &str, text: String| text.replacen("time_s", name, 1);
    for (what, text, map) in [
        ("clock times", table(&|k| clock(NOON, 10 * k)), ""),
        (
            "clock times with a comma",
            table(&|k| format!("\"{}\"", clock(NOON, 10 * k).replace('.', ","))),
            "",
        ),
        ("midnight", table(&|k| clock(LATE, 10 * k)), ""),
        (
            "dates",
            table(&|k| format!("2024-02-2{} {}", if k < 100 { 8 } else { 9 }, clock(LATE, 10 * k))),
            "",
        ),
        ("dates with T and Z", table(&|k| format!("2024-05-01T{}Z", clock(NOON, 10 * k))), ""),
        ("dates with a zone", table(&|k| format!("2024-05-01T{}+02:00", clock(NOON, 10 * k))), ""),
        ("German dates", table(&|k| format!("01.05.2024 {}", clock(NOON, 10 * k))), ""),
        ("afternoon", table(&|k| format!("5/1/2024 {} PM", clock(3600, 10 * k))), ""),
        ("epoch, s", table(&|k| format!("{}.{:02}", epoch + u64::from(k / 100), k % 100)), ""),
        ("epoch, ms", renamed("t", table(&|k| (epoch * 1000 + 10 * u64::from(k)).to_string())), "time=t:ms"),
        (
            "epoch, us",
            renamed("t", table(&|k| (epoch * 1_000_000 + 10_000 * u64::from(k)).to_string())),
            "time=t:us",
        ),
        (
            "epoch, ns",
            renamed("t", table(&|k| (epoch * 1_000_000_000 + 10_000_000 * u64::from(k)).to_string())),
            "time=t:ns",
        ),
        (
            "seconds and nanoseconds",
            renamed(
                "sec,nanosec",
                table(&|k| format!("{},{}", epoch + u64::from(k / 100), 10_000_000 * (k % 100))),
            ),
            "time=sec+nanosec:ns",
        ),
        ("intervals", renamed("dt", table(&|_| "10".into())), "interval=dt:ms"),
    ] {
        let record = read_bytes(text.as_bytes(), &mapped(map)).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_same(&record, what, 0);
    }
    let untimed = lines("voltage_v,angle_rad\n", |_, _, u, x| format!("{u},{x}"));
    let with_rate = ReadOptions { rate_hz: Some(100.0), ..ReadOptions::default() };
    assert_same(&read_bytes(untimed.as_bytes(), &with_rate).unwrap(), "rate", 0);
    // A row that cannot be read leaves a hole; the time goes on.
    let holed = untimed.replacen(&format!("\n{},", row(40).1), "\n?,", 1);
    let record = read_bytes(holed.as_bytes(), &with_rate).unwrap();
    assert_eq!(record.len(), ROWS as usize - 1);
    assert!(
        (record.time_s[40] - 0.41).abs() < 1e-9 && record.warnings[0].what.contains("\"?\""),
        "{:?}",
        record.warnings
    );
    // A log that tells its times keeps them, and that is said.
    let record =
        read_bytes(plain().as_bytes(), &ReadOptions { rate_hz: Some(7.0), ..ReadOptions::default() })
            .unwrap();
    assert_same(&record, "rate beside times", 0);
    assert!(record.warnings.iter().any(|w| w.what.contains("--rate is not used")), "{:?}", record.warnings);
}

#[test]
fn what_a_board_prints_is_read_with_names_stamps_and_noise() {
    let noisy = |text: String| {
        let at = text.match_indices('\n').nth(77).unwrap().0 + 1;
        let (before, after) = text.split_at(at);
        format!("{before}*** watchdog ***\n{after}")
    };
    let arrow = |line: &str, k: u32| format!("{} -> {line}", clock(45_296, 10 * k));
    for (what, text, map) in [
        (
            "names, blanks",
            lines("", |_, t, u, x| format!("t:{t} u:{u} pos:{x}")),
            "time=t,voltage=u,angle=pos",
        ),
        (
            "names, commas",
            lines("boot\n", |_, t, u, x| format!("t: {t}, u: {u}, pos: {x}")),
            "time=t,voltage=u,angle=pos",
        ),
        (
            "names, tabs",
            lines("", |_, t, u, x| format!("t={t}\tu={u}\tpos={x}")),
            "time=t,voltage=u,angle=pos",
        ),
        (
            "half of the first names",
            format!("u:1 pos:0\n{}", lines("", |_, t, u, x| format!("t:{t} u:{u} pos:{x}"))),
            "time=t,voltage=u,angle=pos",
        ),
        (
            "stamps beside a time",
            lines(&arrow(HEADER, 0), |k, t, u, x| arrow(&format!("{t},{u},{x}"), k + k % 3)),
            "",
        ),
        (
            "stamps alone",
            lines(&arrow("voltage_v,angle_rad\n", 0), |k, _, u, x| arrow(&format!("{u},{x}"), k)),
            "",
        ),
        (
            "stamps and names",
            lines("", |k, _, u, x| arrow(&format!("u:{u} pos:{x}"), k)),
            "voltage=u,angle=pos",
        ),
    ] {
        for text in [text.clone(), noisy(text)] {
            let record = read_bytes(text.as_bytes(), &mapped(map)).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_same(&record, what, 0);
            let noise =
                record.warnings.iter().any(|w| w.place.contains("line ") && w.what.contains("left out"));
            assert!(noise || !text.contains("watchdog"), "{what}: {:?}", record.warnings);
            let stamps = record.warnings.iter().any(|w| w.what.contains("serial monitor"));
            assert_eq!(stamps, what.starts_with("stamps a") || what.ends_with("and names"), "{what}");
        }
    }
}

#[test]
fn what_drives_the_motor_holds_through_blanks_and_motion_is_never_filled() {
    let text =
        lines(HEADER, |k, t, u, x| if k % 10 == 0 { format!("{t},{u},{x}") } else { format!("{t},,{x}") });
    let record = read_bytes(text.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(record.len(), ROWS as usize);
    assert!((0..record.len()).all(|k| record.voltage_v[k] == row(k as u32 / 10 * 10).1));
    assert!(record.warnings.iter().any(|w| w.what.contains("180 blank fields")), "{:?}", record.warnings);
    // What says that there is no value is a blank.
    for nothing in ["NaN", "nan", "null", "None", "NA", "-"] {
        let text =
            lines(
                HEADER,
                |k, t, u, x| {
                    if k % 10 == 0 { format!("{t},{u},{x}") } else { format!("{t},{nothing},{x}") }
                },
            );
        let record = read_bytes(text.as_bytes(), &ReadOptions::default()).unwrap();
        assert!((0..record.len()).all(|k| record.voltage_v[k] == row(k as u32 / 10 * 10).1), "{nothing}");
        assert!(record.warnings.iter().any(|w| w.what.contains("first in line 3")), "{:?}", record.warnings);
    }
    let empty = refusal(&lines(HEADER, |_, t, u, _| format!("{t},{u},nan"))).to_string();
    assert!(empty.contains("angle_rad") && empty.contains("no row has a value here"), "{empty}");
    // Voltages and angles in rows of their own.
    let text = lines(HEADER, |_, t, u, x| format!("{t},{u},\n{:.4},,{x}", t + 0.001));
    let record = read_bytes(text.as_bytes(), &ReadOptions::default()).unwrap();
    assert_same(&record, "apart", 0);
}

fn refusal(text: &str) -> Box<BadInput> {
    match read_bytes(text.as_bytes(), &ReadOptions::default()) {
        Err(Error::BadInput(fault)) => fault,
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_cannot_be_told_is_refused_with_what_to_do() {
    for (text, words) in [
        (
            lines(HEADER, |k, _, u, x| {
                format!("{k},{},{}", format!("{u:.2}").replace('.', ","), format!("{x:.2}").replace('.', ","))
            }),
            ["line 1", "decimal commas", "semicolons"],
        ),
        (
            lines(&format!("{HEADER}ms,V,rad\n"), |_, t, u, x| format!("{t},{u},{x}")),
            ["time_s", "\"ms\"", "--map time=time_s:ms"],
        ),
        (
            lines("t,u,pos,pos\n", |_, t, u, x| format!("{t},{u},{x},{x}")),
            ["the columns are t, u, pos, pos", "angle=2:rad", "voltage=u:V"],
        ),
        (
            lines("t,ch1,ch2\n", |_, t, u, x| format!("{t},{u},{x}")),
            [
                "the columns are t, ch1, ch2",
                "time=t:s,voltage=ch1:V,speed=ch2:rad/s",
                "channels of an oscilloscope",
            ],
        ),
        (
            lines("t,effort,position\n", |_, t, u, x| format!("{t},{u},{x}")),
            ["torque in ROS", "--map time=t:s,voltage=effort:V,angle=position:rad", "duty=effort:100"],
        ),
        (
            lines("MOT: Monitor enabled!\nMOT: Align sensor.\nMOT: Ready.\n", |_, _, u, x| {
                format!("{u:.4}\t{u:.4}\t{:.4}\t{x:.4}", 1.5 * u)
            }),
            ["SimpleFOC", "--map voltage=1:V,speed=2:rad/s,angle=3:rad --rate 100", "micros()"],
        ),
        (
            lines(HEADER, |_, _, u, x| format!("0.01,{u},{x}")),
            ["repeat the time", "--map interval=time_s:s", "time since the row before"],
        ),
        (
            lines(HEADER, |k, _, u, x| format!("{:.4},{u},{x}", 0.01 + 1e-4 * f64::from(k % 3))),
            ["backwards", "--map interval=time_s:s", "time since the row before"],
        ),
    ] {
        let said = refusal(&text).to_string();
        assert!(words.iter().all(|word| said.contains(word)), "{words:?} in {said}");
    }
}

/// A unit in the header, or in the row below it, holds where the mapping names none.
#[test]
fn the_unit_of_a_header_holds_where_the_mapping_leaves_it_open() {
    let rows = |k: u32, u: f64, x: f64| format!("{},{},{}", 10 * k, 1e3 * u, x.to_degrees());
    for (head, map) in [
        ("t_ms,u_mV,pos_deg\n", "time=t_ms,voltage=u_mV,angle=pos_deg"),
        ("Time [ms],U [mV],Angle (deg)\n", "time=Time [ms],voltage=U [mV],angle=Angle (deg)"),
        ("Time,U,Angle\n(ms),(mV),(deg)\n", "time=0,voltage=1,angle=2"),
        ("millis,mv,shaftAngleDegrees\n", "time=millis,voltage=mv,angle=shaftAngleDegrees"),
        ("t_us,u,angle\n", "time=t_us:ms,voltage=u:mV,angle=angle:deg"),
    ] {
        let record = read_bytes(lines(head, |k, _, u, x| rows(k, u, x)).as_bytes(), &mapped(map)).unwrap();
        assert_same(&record, head, 0);
    }
}

/// The proposal reads the file as it stands, in the right units.
#[test]
fn every_proposal_reads_its_log() {
    let mut wrong = String::new();
    for (what, text, options) in [
        (
            "unit row",
            lines("Time,Voltage,Angle\n(ms),(V),(deg)\n", |k, _, u, x| {
                format!("{},{u},{}", 10 * k, x.to_degrees())
            }),
            "--map time=Time:ms,voltage=Voltage:V,angle=Angle:deg",
        ),
        (
            "in",
            lines("Zeit in s;Spannung in V;Winkel in rad\n", |_, t, u, x| format!("{t};{u};{x}")),
            "--map \"time=Zeit in s:s,voltage=Spannung in V:V,angle=Winkel in rad:rad\"",
        ),
        (
            "suffixes",
            lines("t_ms,u_mV,pos_deg\n", |k, _, u, x| format!("{},{},{}", 10 * k, 1e3 * u, x.to_degrees())),
            "--map time=t_ms:ms,voltage=u_mV:mV,angle=pos_deg:deg",
        ),
        (
            "ROS",
            lines("sec,nanosec,u,position\n", |k, _, u, x| {
                format!("{},{},{u},{x}", 1_732_340_000 + k / 100, 10_000_000 * (k % 100))
            }),
            "--map time=sec+nanosec:ns,voltage=u:V,angle=position:rad",
        ),
        (
            "intervals",
            lines("dt_ms,u,theta\n", |_, _, u, x| format!("10,{u},{x}")),
            "--map interval=dt_ms:ms,voltage=u:V,angle=theta:rad",
        ),
        (
            "no time",
            lines("voltage,angle\n", |_, _, u, x| format!("{u},{x}")),
            "--map voltage=voltage:V,angle=angle:rad --rate 100",
        ),
        (
            "clock times",
            lines("Timestamp,u,theta\n", |k, _, u, x| format!("{},{u},{x}", clock(40_000, 10 * k))),
            "--map time=Timestamp:s,voltage=u:V,angle=theta:rad",
        ),
        (
            "names",
            lines("", |k, _, u, x| format!("millis:{} u:{u} theta:{x}", 10 * k)),
            "--map time=millis:ms,voltage=u:V,angle=theta:rad",
        ),
        (
            "a clock of no known name",
            lines("frame;logged;u;theta\n", |k, t, u, x| format!("{k};{t};{u};{x}")),
            "--map time=logged:s,voltage=u:V,angle=theta:rad",
        ),
        (
            "names that are units",
            lines("ms,V,deg\n", |k, _, u, x| format!("{},{u},{}", 10 * k, x.to_degrees())),
            "--map time=ms:ms,voltage=V:V,angle=deg:deg",
        ),
        (
            "names of AdvantageKit",
            lines("time;LeftAppliedVolts;LeftPositionRotations\n", |_, t, u, x| {
                format!("{t};{u};{}", x / std::f64::consts::TAU)
            }),
            "--map time=time:s,voltage=LeftAppliedVolts:V,angle=LeftPositionRotations:rev",
        ),
        (
            "a column that never changes is no motion",
            lines("time,x,y,voltage,angle\n", |_, t, u, x| format!("{t},1,2,{u},{x}")),
            "--map time=time:s,voltage=voltage:V,angle=angle:rad",
        ),
        (
            "stamps",
            lines("", |k, _, u, x| format!("{} -> u:{u} theta:{x}", clock(50_000, 10 * k))),
            "--map voltage=u:V,angle=theta:rad",
        ),
    ] {
        let proposal = refusal(&text).proposal.unwrap_or_else(|| panic!("{what}: no proposal"));
        if proposal.options() != options {
            let _ = writeln!(wrong, "{what}: {}", proposal.options());
            continue;
        }
        let rate_hz = proposal.rate.as_ref().map(|rate| rate.parse().unwrap());
        let record = read_bytes(text.as_bytes(), &ReadOptions { rate_hz, ..mapped(&proposal.map) }).unwrap();
        assert_same(&record, what, 0);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn units_beside_the_numbers_hold_and_a_number_in_another_unit_is_no_row() {
    let text = lines("t,u,pos\n", |k, t, u, x| {
        let volts = if k == 50 { format!("{:.1}mV", 1e3 * u) } else { format!("{u:.4}V") };
        format!("{:.0} ms,{volts},{x:.4}", 1e3 * t)
    });
    let record = read_bytes(text.as_bytes(), &mapped("time=t,voltage=u,angle=pos")).unwrap();
    assert_eq!(record.len(), ROWS as usize - 1);
    assert!((record.time_s[199 - 1] - record.time_s[0] - 1.99).abs() < 1e-9);
    assert!(record.warnings.iter().any(|w| w.place.contains("line 52")), "{:?}", record.warnings);
    let proposal = refusal(&text).proposal.unwrap();
    assert_eq!(proposal.map, "time=t:ms,voltage=u:V,angle=pos:rad");
    // Names beside the numbers too.
    let text = lines("", |_, t, u, x| format!("t:{:.0}ms u:{u:.4}V pos:{x:.4}rad", 1e3 * t));
    assert_same(&read_bytes(text.as_bytes(), &mapped("time=t,voltage=u,angle=pos")).unwrap(), "names", 0);
}

#[test]
fn thousands_may_stand_apart() {
    let apart = |x: f64| {
        let text = format!("{:.1}", x.abs());
        let (whole, part) = text.split_once('.').unwrap();
        let sign = if x < 0.0 { "-" } else { "" };
        let at = whole.len().saturating_sub(3);
        if at == 0 {
            format!("{sign}{text}")
        } else {
            format!("{sign}{}'{}.{part}", &whole[..at], &whole[at..])
        }
    };
    let text = lines("t,u,pos\n", |_, t, u, x| format!("{t:.2},{},{}", apart(1e3 * u), apart(1e4 * x)));
    assert!(text.contains("'"));
    let record = read_bytes(text.as_bytes(), &mapped("time=t:s,voltage=u:mV,angle=pos:rad*1e-4")).unwrap();
    assert_same(&record, "thousands", 0);
}

#[test]
fn a_direction_in_a_column_of_its_own_gives_the_duty_its_sign() {
    for (forth, back) in [("1", "-1"), ("1", "0"), ("1", "2"), ("FWD", "REV"), ("cw", "ccw"), ("HIGH", "LOW")]
    {
        let text = lines("t_ms,dir,pwm,theta\n", |_, t, u, x| {
            format!("{:.0},{},{:.4},{x}", 1e3 * t, if u < 0.0 { back } else { forth }, 20.0 * u.abs())
        });
        let proposal = refusal(&text).proposal.unwrap();
        assert_eq!(proposal.map, "time=t_ms:ms,duty=pwm:100,direction=dir:sign,angle=theta:rad", "{forth}");
        let options = ReadOptions { supply_volts: Some(5.0), ..mapped(&proposal.map) };
        assert_same(&read_bytes(text.as_bytes(), &options).unwrap(), forth, 0);
        let turned = mapped("time=t_ms:ms,duty=pwm:100,direction=dir:*-1,angle=theta:rad");
        let turned = read_bytes(text.as_bytes(), &ReadOptions { supply_volts: Some(5.0), ..turned }).unwrap();
        assert!((turned.voltage_v[50] + row(50).1).abs() < 1e-9, "{forth}");
    }
    // A duty with a sign of its own needs none.
    let text =
        lines("t,dir,pwm,theta\n", |_, t, u, x| format!("{t},{},{},{x}", i32::from(u > 0.0), 20.0 * u));
    assert!(!refusal(&text).proposal.unwrap().map.contains("direction"));
    let text = lines("t,dir,u,theta\n", |k, t, u, x| format!("{t},{k},{},{x}", u.abs()));
    let options = mapped("time=t,voltage=u,direction=dir,angle=theta");
    let error = read_bytes(text.as_bytes(), &options).unwrap_err().to_string();
    assert!(error.contains("is no direction") && error.contains("FWD and REV"), "{error}");
}
