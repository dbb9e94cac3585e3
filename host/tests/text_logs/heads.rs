//! What boards, oscilloscopes and laboratories write before rows and tables: none of it is a column or a value.

use motorlens::log::ReadOptions;

use super::{HEADER, ROWS, assert_same, lines, mapped, plain, read_bytes, read_same, refusal};

/// A way of writing, the options that are proposed for it (empty: none are needed), and the rate that reads it.
type Case = (&'static str, String, &'static str, Option<f64>);

fn before_each_line() -> Vec<Case> {
    let pairs = |k: u32, u: f64, x: f64| format!("ms:{} V:{u} rad:{x}", 10 * k);
    let by_ms = "--map time=ms:ms,voltage=V:V,angle=rad:rad";
    let untimed = "--map voltage=V:V,angle=rad:rad --rate 100";
    vec![
        ("an echo", lines("", |k, _, u, x| format!("echo: {}", pairs(k, u, x))), by_ms, None),
        ("a level", lines("", |k, _, u, x| format!("[INFO] motor: {}", pairs(k, u, x))), by_ms, None),
        ("a number", lines("", |k, _, u, x| format!("[{k}] V: {u} rad: {x}")), untimed, Some(100.0)),
        (
            "ROS",
            lines("", |_, t, u, x| format!("[INFO] [{:.9}] [motor]: V: {u}, rad: {x}", 1.7e9 + t)),
            "--map voltage=V:V,angle=rad:rad",
            None,
        ),
        (
            "a word before every row",
            lines(&format!("DATA: {HEADER}"), |_, t, u, x| format!("DATA: {t},{u},{x}")),
            "",
            None,
        ),
    ]
}

fn before_the_table() -> Vec<Case> {
    let remarks = "\u{feff}# by hand\n// motor: M1, 20:1\n; of May\n%\n";
    let comma = |x: f64| format!("{x:.4}").replace('.', ",");
    let labview = "LabVIEW Measurement\t\nDecimal_Separator\t,\n***End_of_Header***\t\n\nChannels\t2\t\t\nDelta_X\t0,010000\t0,010000\t\n\
                   ***End_of_Header***\t\t\t\nX_Value\tVoltage\tAngle\tComment\n";
    let scope = "Model,MSO54\nFirmware Version,1.20\n\nHorizontal Units,s\nHorizontal Scale,0.4\nSample Interval,0.01\n\
                 Probe Attenuation,1,1\nVertical Units,V,V\nVertical Offset,0,0\nLabel,,\n\nTIME,u,theta\n";
    let twincat = "Name\tScope\nFile\tC:\\scope.svdx\n\nName\tVoltage\tName\tAngle\nData-Type\tREAL64\tData-Type\tREAL64\n\
                   SampleTime[ms]\t10\tSampleTime[ms]\t10\nUnit\tV\tUnit\trad\n\n";
    vec![
        ("remarks", lines(&format!("{remarks}{HEADER}"), |_, t, u, x| format!("{t},{u},{x}")), "", None),
        (
            "a header that is one",
            lines(&format!("{remarks}% {HEADER}"), |_, t, u, x| format!("{t},{u},{x}")),
            "",
            None,
        ),
        (
            "LabVIEW without times",
            lines(labview, |_, _, u, x| format!("\t{}\t{}\t", comma(u), comma(x))),
            "--map voltage=Voltage:V,angle=Angle:rad --rate 100",
            Some(100.0),
        ),
        (
            "an oscilloscope",
            lines(scope, |_, t, u, x| format!("{:.4e},{u},{x}", t - 1.0)),
            "--map time=TIME:s,voltage=u:V,angle=theta:rad",
            None,
        ),
        (
            "TwinCAT",
            lines(twincat, |k, _, u, x| format!("{}\t{u}\t{}\t{x}", 10 * k, 10 * k)),
            "--map time=0:ms,voltage=Voltage:V,angle=Angle:rad",
            None,
        ),
    ]
}

#[test]
fn what_stands_before_rows_and_tables_is_no_part_of_them() {
    for (what, text, options, rate_hz) in before_each_line().into_iter().chain(before_the_table()) {
        let mut map = String::new();
        if !options.is_empty() {
            let proposal = refusal(&text).proposal.unwrap_or_else(|| panic!("{what}: no proposal"));
            assert_eq!(proposal.options(), options, "{what}");
            map = proposal.map;
        }
        read_same(text.as_bytes(), &ReadOptions { rate_hz, ..mapped(&map) }, what);
    }
}

#[test]
fn a_blank_before_or_behind_a_tab_is_a_value_that_is_not_there() {
    let head = HEADER.replace(',', "\t");
    let text = lines(&head, |k, t, u, x| match k % 10 {
        3 => format!("{t}\t{u}\t"),
        _ => format!("{t}\t{u}\t{x}"),
    });
    assert_eq!(read_bytes(text.as_bytes(), &mapped("")).unwrap().len(), ROWS as usize - 20);
    let text = lines("voltage_v\ttime_s\tangle_rad\n", |k, t, u, x| match k % 2 {
        0 => format!("{u}\t{t}\t{x}"),
        _ => format!("\t{t}\t{x}"),
    });
    let record = read_bytes(text.as_bytes(), &mapped("")).unwrap();
    assert_eq!((record.len(), record.voltage_v[7]), (ROWS as usize, super::row(6).1));
}

#[test]
fn signals_with_times_of_their_own_are_told() {
    let text = lines("Time\tVoltage\tTime\tAngle\n", |_, t, u, x| format!("{t}\t{u}\t{}\t{x}", t + 0.002));
    let said = refusal(&text).to_string();
    assert!(said.contains("column 2 is called \"Time\" too and tells other times, up to 20 %"), "{said}");
}

const BANNER: &str = "=~=~=~=~=~=~= PuTTY log 2024.05.01 12:00:00 =~=~=~=~=~=~=\n";

#[test]
fn banners_of_putty_are_no_rows_and_labels_between_separators_are_names() {
    let ms = |t: f64| (1e3 * t).round();
    for (what, text, map) in [
        ("a banner", format!("{BANNER}{}", plain()), ""),
        (
            "a banner for each session",
            lines(&format!("{BANNER}{HEADER}"), |k, t, u, x| {
                format!("{}{t},{u},{x}", if k == 100 { BANNER } else { "" })
            }),
            "",
        ),
        (
            "labels",
            lines(BANNER, |_, t, u, x| format!("t,{},u,{u},pos,{x}", ms(t))),
            "time=t:ms,voltage=u,angle=pos",
        ),
        (
            "labels with colons",
            lines("", |_, t, u, x| format!("T:,{},U:,{u},Pos:,{x}", ms(t))),
            "time=T:ms,voltage=U,angle=Pos",
        ),
        (
            "labels, semicolons",
            lines("", |_, t, u, x| format!("t;{t};u;{u};pos;{x}")),
            "time=t,voltage=u,angle=pos",
        ),
        (
            "words that are values",
            lines("dir,time_s,state,angle_rad,voltage_v\n", |_, t, u, x| format!("FWD,{t},ON,{x},{u}")),
            "",
        ),
        (
            "a separator in brackets",
            lines("t (s, from 0),u,pos\n", |_, t, u, x| format!("{t},{u},{x}")),
            "time=0:s,voltage=u,angle=pos",
        ),
    ] {
        let record = read_same(text.as_bytes(), &mapped(map), what);
        assert!(record.warnings.is_empty(), "{what}: {:?}", record.warnings);
    }
}

#[test]
fn a_header_of_more_names_than_fields_shifts_nothing() {
    let rows = |header: &str| lines(header, |_, t, u, x| format!("{t},{u},{x}"));
    for header in ["time_s,voltage_v,current_a,angle_rad\n", "t,u,i,pos,x\n"] {
        let said = refusal(&rows(header)).to_string();
        for words in ["line 1", "names, the rows have 3 fields", "its name there, and no other", "time=0:s"] {
            assert!(said.contains(words), "{words}: {said}");
        }
        let by_number = mapped("time=0:s,voltage=1:V,angle=2:rad");
        assert_same(&read_bytes(rows(header).as_bytes(), &by_number).unwrap(), header, 0);
    }
    // Remarks that nobody wrote.
    let noted = rows("time_s,voltage_v,angle_rad,note\n");
    assert_same(&read_bytes(noted.as_bytes(), &ReadOptions::default()).unwrap(), "note", 0);
}

#[test]
fn blank_cells_in_a_first_row_of_numbers_make_it_no_header() {
    let blank = |k: u32| if k == 0 { ",,7.5" } else { ",3," };
    let text = lines("", |k, t, u, x| format!("{t:.4},{u:.3e},{x:.4}{}", blank(k)));
    let said = refusal(&text).to_string();
    assert!(said.contains("the first row holds numbers") && said.contains("--map time=0:s,"), "{said}");
    let record = read_bytes(text.as_bytes(), &mapped("time=0:s,voltage=1:V,angle=2:rad")).unwrap();
    assert_eq!(record.len(), ROWS as usize);
}
