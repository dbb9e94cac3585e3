//! What programs and boards say one value or a few a line, behind a stamp: values of different names in different lines are one table.

use motorlens::log::ReadOptions;

use super::{assert_same, clock, lines, mapped, read_bytes, read_same, refusal};

/// A stamp of row `k`.
fn at(k: u32) -> String {
    clock(43_200, 10 * k)
}

#[test]
fn values_behind_stamps_in_lines_of_their_own_are_rows_at_the_times_of_those() {
    let python = |k: u32| format!("2024-05-01 {}", at(k).replace('.', ","));
    let esp = |k: u32, said: String| format!("I ({}) motor: {said}", 1000 + 10 * k);
    for (what, text) in [
        ("a dash", lines("", |k, _, u, x| format!("{0} - u: {u}\n{0} - theta: {x}", at(k)))),
        ("a level", lines("", |k, _, u, x| format!("{0} [INFO] u: {u}\n{0} [INFO] theta: {x}", at(k)))),
        ("logging", lines("", |k, _, u, x| format!("{0} - u={u}\n{0} - theta={x}", python(k)))),
        (
            "logging of a name",
            lines("", |k, _, u, x| {
                format!("{0} - motor - INFO - u={u}\n{0} - motor - INFO - theta={x}", python(k))
            }),
        ),
        (
            "logging between colons",
            lines("", |k, _, u, x| format!("{0}:INFO:motor:u={u}\n{0}:INFO:motor:theta={x}", python(k))),
        ),
        ("a monitor", lines("boot\n", |k, _, u, x| format!("{0} -> u: {u}\n{0} -> theta: {x}", at(k)))),
        (
            "ESP-IDF",
            lines("", |k, _, u, x| {
                format!("{}\n{}", esp(k, format!("u: {u}")), esp(k, format!("theta: {x}")))
            }),
        ),
        ("units", lines("", |k, _, u, x| format!("{0} - u: {u} V\n{0} - theta: {x} rad", at(k)))),
    ] {
        let proposal = refusal(&text).proposal.unwrap_or_else(|| panic!("{what}: nothing is proposed"));
        let units = if what == "units" { ["u [V]", "theta [rad]"] } else { ["u", "theta"] };
        let map = format!("time=time_s:s,voltage={}:V,angle={}:rad", units[0], units[1]);
        assert_eq!(proposal.map, map, "{what}");
        read_same(text.as_bytes(), &mapped(&map), what);
    }
}

#[test]
fn lines_of_some_values_and_lines_of_others_are_joined() {
    let map = mapped("time=time_s,voltage=u,angle=theta");
    let text = lines("", |k, _, u, x| format!("{0} - u: {u}, vbat: 12.1\n{0} - theta: {x}, temp: 30", at(k)));
    read_same(text.as_bytes(), &map, "of some values");
    // A drive that is told only now and then holds.
    let text = lines("", |k, _, _, x| {
        let set = if k % 20 == 0 { format!("{} - u={}, mode=1\n", at(k), k / 20) } else { String::new() };
        format!("{set}{} - theta={x}, temp=30", at(k))
    });
    let record = read_bytes(text.as_bytes(), &map).unwrap();
    let held = |k: usize| (record.voltage_v[k] - (k / 20) as f64).abs() < 1e-9;
    assert!(record.len() == 200 && (0..200).all(held), "{:?}", record.voltage_v);
}

#[test]
fn stamps_of_whole_seconds_do_not_part_the_rows_and_a_rate_does() {
    let text = lines("", |k, _, u, x| format!("{0} - u: {u}\n{0} - theta: {x}", &at(k)[..8]));
    let options = mapped("time=time_s:s,voltage=u:V,angle=theta:rad");
    let refused = read_bytes(text.as_bytes(), &options).unwrap_err().to_string();
    assert!(refused.contains("repeat the time") && refused.contains("--rate"), "{refused}");
    let options = ReadOptions { rate_hz: Some(100.0), ..options };
    assert_same(&read_bytes(text.as_bytes(), &options).unwrap(), "whole seconds", 0);
}

#[test]
fn lines_that_all_hold_the_same_names_are_rows_as_before() {
    for (what, line) in [
        ("Loguru", " | INFO     | __main__:run:42 - "),
        ("a name before the level", " motor INFO "),
        ("a file", " INFO drive.py:42 - "),
        ("a bar", " | "),
    ] {
        let text = lines("", |k, _, u, x| format!("2024-05-01 {}{line}u={u} theta={x}", at(k)));
        assert_eq!(refusal(&text).proposal.unwrap().map, "voltage=u:V,angle=theta:rad", "{what}");
        read_same(text.as_bytes(), &mapped("voltage=u,angle=theta"), what);
    }
    let text = lines("", |_, t, u, x| format!("[{:12.6}] u={u} theta={x}", 5.0 + t));
    read_same(text.as_bytes(), &mapped("voltage=u,angle=theta"), "a kernel's log");
}

#[test]
fn what_stands_before_the_values_of_a_line_is_left_out_or_tells_their_time() {
    let by_number = "time=0:ms,voltage=1:V,angle=2:rad";
    let by_name = "voltage=u,angle=theta";
    for (what, text, map) in [
        ("J-Link", lines("00> \n", |k, _, u, x| format!("00> {},{u},{x}", 10 * k)), by_number),
        ("a level and a name", lines("", |k, _, u, x| format!("<info> app: {},{u},{x}", 10 * k)), by_number),
        ("Zephyr", lines("", |k, _, u, x| format!("[{}] <inf> motor: u {u} theta {x}", at(k))), by_name),
        ("milliseconds", lines("", |k, _, u, x| format!("{} ms\tu:{u}\ttheta:{x}", 10 * k)), by_name),
        (
            "MicroPython",
            lines(">>> import main\n", |k, _, u, x| format!("({}, {u}, {x})", 10 * k)),
            by_number,
        ),
    ] {
        read_same(text.as_bytes(), &mapped(map), what);
    }
}

#[test]
fn a_remark_tells_the_rate_that_is_proposed() {
    for remark in ["# sampling rate: 250 Hz", "Sampling time: 4 ms", "% fs = 250"] {
        let text = lines(&format!("{remark}\nu,theta\n"), |_, _, u, x| format!("{u},{x}"));
        let proposal = refusal(&text).proposal.unwrap();
        assert_eq!(proposal.rate.as_deref(), Some("250"), "{remark}");
    }
}

#[test]
fn rows_between_marks_are_rows() {
    let map = mapped("time=0:ms,voltage=1:V,angle=2:rad");
    for (what, text) in [
        ("marks", lines("", |k, _, u, x| format!("<{},{u},{x}>", 10 * k))),
        ("a list", lines("data = [\n", |k, _, u, x| format!("  [{}, {u}, {x}],", 10 * k)) + "]\n"),
        ("a matrix", lines("data = [\n", |k, _, u, x| format!("{} {u} {x};", 10 * k)) + "];\n"),
    ] {
        read_same(text.as_bytes(), &map, what);
    }
    let text = lines("", |k, _, u, x| format!("$MOT,{},{u},{x}*5A", 10 * k));
    read_same(text.as_bytes(), &mapped("time=1:ms,voltage=2:V,angle=3:rad"), "sentences");
}
