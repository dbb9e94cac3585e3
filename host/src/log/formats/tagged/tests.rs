//! Lines of several kinds, told and read.

use super::super::super::read_tests::file;
use super::super::super::{ReadOptions, Record, read};
use super::*;

fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).map(line).collect()
}

/// The records of lines that are told to be of several kinds.
fn records(text: &str, map: &str, supply_volts: f64, rate_hz: Option<f64>) -> Vec<Record> {
    assert!(is(text.as_bytes()));
    let (_directory, path) = file(text.as_bytes());
    let map = Some(map.parse().unwrap());
    let options = ReadOptions { map, supply_volts: Some(supply_volts), rate_hz, ..ReadOptions::default() };
    read(&path, &options).unwrap()
}

#[test]
fn lines_of_several_kinds_are_told_from_rows_that_begin_with_a_word() {
    let is = |text: String| is(text.as_bytes());
    assert!(is(lines(40, |k| format!("PWM,{},{}\nENC,{},{k}\n", 10 * k, k % 7, 10 * k + 3))));
    assert!(is(lines(40, |k| format!("P:{},{}\r\nE:{},{k}\r\n", 10 * k, k % 7, 10 * k + 3))));
    // A header may stand above, and one kind come more often.
    let rare = lines(40, |k| {
        let pwm = if k % 4 == 0 { format!("PWM,{k},1\n") } else { String::new() };
        format!("{pwm}ENC,{k},{k},2\n")
    });
    assert!(is(format!("kind,ms,value\n{rare}")));
    // A state, a direction, one kind, words that are names of values.
    assert!(!is(lines(80, |k| format!("{},{k},1,2\n", if k < 40 { "ramp" } else { "step" }))));
    assert!(!is(lines(80, |k| format!("{},{k},120\n", if k % 2 == 0 { "FWD" } else { "REV" }))));
    assert!(!is(lines(80, |k| format!("DATA,{k},120\n"))));
    let seldom = lines(300, |k| format!("{},{k},120,55\n", if k % 16 == 0 { "SAT" } else { "OK" }));
    assert!(!is(format!("status,ms,duty,rpm\n{seldom}")));
    assert!(!is(lines(80, |k| format!("u:{k},w:{k}\n"))));
    assert!(!is(lines(80, |k| format!("{k},{k}\n"))));
}

#[test]
fn a_duty_and_counts_with_stamps_of_their_own_are_one_record() {
    let text = lines(400, |k| {
        let duty = (200.0 * (0.03 * k as f64).sin()) as i64;
        format!("P:{},{duty}\nE:{},{}\n", 1000 + 10 * k, 1003 + 10 * k, 7 * k)
    });
    let (_directory, path) = file(text.as_bytes());
    let options = ReadOptions {
        map: Some("time=stamp:ms,duty=pwm:255,angle=enc:rev/1000".parse().unwrap()),
        supply_volts: Some(12.0),
        ..ReadOptions::default()
    };
    let records = read(&path, &options).unwrap();
    let all: usize = records.iter().map(|record| record.len()).sum();
    assert!(all > 390, "{all}");
    let asked = read(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(asked.contains("time=stamp:ms,duty=pwm:255,angle=enc:counts"), "{asked}");
    assert!(asked.contains("nothing tells the unit of \"stamp\": ms is a guess"), "{asked}");
    // The same stamps in another unit.
    let options = ReadOptions {
        map: Some("time=stamp:us,duty=pwm:255,angle=enc:rev/1000".parse().unwrap()),
        ..options
    };
    let faster = read(&path, &options).unwrap();
    let length = |records: &[Record]| {
        let times = |record: &Record| record.time_s[record.len() - 1] - record.time_s[0];
        records.iter().map(times).sum::<f64>()
    };
    assert!((length(&records) / length(&faster) / 1e3 - 1.0).abs() < 0.02);
}

#[test]
fn lines_without_stamps_that_take_turns_are_rows_at_a_rate() {
    let text = lines(400, |k| {
        let duty = (200.0 * (0.03 * k as f64).sin()) as i64;
        format!("PWM,{duty}\nENC,{},{}\n", 7 * k, -7 * (k as i64))
    });
    let records = records(&text, "duty=PWM:255,angle=ENC_0:rev/1000", 12.0, Some(200.0));
    assert_eq!((records.len(), records[0].len()), (1, 400));
    assert!((records[0].time_s[399] - 399.0 / 200.0).abs() < 1e-9);
}

#[test]
fn a_lost_line_leaves_the_rows_after_it_as_they_are() {
    let duty = |k: usize| (200.0 * (0.03 * k as f64).sin()) as i64;
    let text = lines(400, |k| match k {
        100 => format!("ENC,{}\n", 7 * k),
        200 => format!("PWM,{}\nNC,{}\n", duty(k), 7 * k),
        _ => format!("PWM,{}\nENC,{}\n", duty(k), 7 * k),
    });
    let text = format!("WM,3\n{text}");
    let records = records(&text, "duty=PWM:255,angle=ENC:rev/1000", 255.0, Some(200.0));
    let all: usize = records.iter().map(Record::len).sum();
    assert!(all > 390, "{all}");
    let volts = records.iter().flat_map(|record| record.voltage_v.iter());
    let angles = records.iter().flat_map(|record| record.angle_rad.as_ref().unwrap().iter());
    let row = |angle_rad: f64| (angle_rad / std::f64::consts::TAU * 1000.0 / 7.0).round() as usize;
    let is_apart = |(v, x): &(&f64, &f64)| (**v - duty(row(**x)) as f64).abs() > 0.5;
    // The line that is lost, and the reading that is.
    let apart = volts.zip(angles).filter(is_apart).count();
    assert!(apart <= 2, "{apart}");
}

#[test]
fn a_line_that_was_cut_off_and_a_garbled_word_take_no_stamps_from_the_others() {
    let text = lines(400, |k| {
        let duty = (200.0 * (0.03 * k as f64).sin()) as i64;
        let counts = match k {
            100 => "E:10".to_owned(),
            200 => format!("EE:{},{}", 1003 + 10 * k, 7 * k),
            _ => format!("E:{},{}", 1003 + 10 * k, 7 * k),
        };
        format!("P:{},{duty}\n{counts}\n", 1000 + 10 * k)
    });
    let text = format!("0,55\nE:10\n{text}");
    let records = records(&text, "time=stamp:ms,duty=pwm:255,angle=enc:rev/1000", 12.0, None);
    let all: usize = records.iter().map(|record| record.len()).sum();
    assert!(all > 390, "{all}");
}

#[test]
fn stamps_of_a_monitor_before_the_lines_are_their_times() {
    let stamp = |k: usize, ms: usize| format!("12:00:{:02}.{:03}", k / 100, 10 * (k % 100) + ms);
    let duty = |k: usize| (200.0 * (0.03 * k as f64).sin()) as i64;
    let text = lines(400, |k| {
        let pwm = if k % 4 == 0 { format!("{} -> PWM,{}\n", stamp(k, 0), duty(k)) } else { String::new() };
        format!("{pwm}{} -> ENC,{},2\n", stamp(k, 3), 7 * k)
    });
    let read = records(&text, "time=time_s,duty=PWM:255,angle=ENC_0:rev/1000", 12.0, None);
    let all: usize = read.iter().map(Record::len).sum();
    assert!(all > 390, "{all}");
    // The board's own stamps go before those of the monitor.
    let own = lines(400, |k| {
        format!("{0} -> PWM,{1},{2}\n{0} -> ENC,{1},{3}\n", stamp(k, 0), 10 * k, duty(k), 7 * k)
    });
    records(&own, "time=stamp:ms,duty=PWM:255,angle=ENC:rev/1000", 12.0, None);
    let single = lines(400, |k| format!("{0} -> PWM,{1}\n{0} -> ENC,{2}\n", stamp(k, 0), duty(k), 7 * k));
    records(&single, "time=time_s,duty=PWM:255,angle=ENC:rev/1000", 12.0, None);
    let states =
        lines(400, |k| format!("{} -> {},120,{k}\n", stamp(k, 0), if k % 5 == 0 { "SAT" } else { "OK" }));
    assert!(!is(states.as_bytes()));
}

#[test]
fn words_that_are_values_of_a_row_come_in_no_order() {
    let states = ["idle", "ramp", "hold", "ramp", "idle", "hold", "idle"];
    assert!(!is(lines(200, |k| format!("{},{k}\n", states[k * k % 7])).as_bytes()));
    assert!(!is(lines(200, |k| format!("{},{k}\n", states[k / 40])).as_bytes()));
}

#[test]
fn stamps_are_milliseconds_microseconds_or_seconds() {
    let of = |step: f64| second(&(0..50).map(|k| step * f64::from(k)).collect::<Vec<_>>());
    assert_eq!([10.0, 10_000.0, 0.01, 10.5].map(of), [1e3, 1e6, 1.0, 1e3]);
}
