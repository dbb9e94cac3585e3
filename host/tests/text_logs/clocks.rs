//! Times that are written as few expect them: in two columns, with colons only, in days, with too few digits, or not at all; lines that were
//! printed twice.

use motorlens::log::ReadOptions;

use super::{HEADER, ROWS, assert_same, clock, lines, mapped, plain, read_bytes, refusal};

#[test]
fn milliseconds_apart_and_behind_a_colon_are_read() {
    let apart = |name: &str| {
        lines(&format!("Time,{name},u,theta\n"), |k, _, u, x| {
            format!("{},{},{u},{x}", 1_700_000_000 + k / 100, k % 100 * 10)
        })
    };
    for (text, time) in [
        (apart("Millitm"), "Time+Millitm:ms"),
        (apart("Milliseconds"), "Time+Milliseconds:ms"),
        (
            lines("Time,u,theta\n", |k, _, u, x| {
                let clock = clock(86_399, 10 * k);
                format!("{}:{},{u},{x}", &clock[..8], &clock[9..])
            }),
            "Time:s",
        ),
    ] {
        let proposal = refusal(&text).proposal.unwrap();
        assert_eq!(proposal.map, format!("time={time},voltage=u:V,angle=theta:rad"));
        assert!(!proposal.assumptions().contains("Time"), "{}", proposal.assumptions());
        assert_same(&read_bytes(text.as_bytes(), &mapped(&proposal.map)).unwrap(), time, 0);
    }
    // A count of milliseconds that goes on beyond a second is none of them.
    let text = lines("sec,millis,u,theta\n", |k, _, u, x| format!("{},{},{u},{x}", k / 100, 10 * k));
    assert!(refusal(&text).proposal.unwrap().map.starts_with("time=millis:ms,"));
}

#[test]
fn a_semicolon_that_ends_each_line_separates_nothing() {
    let ended = plain().lines().map(|line| format!("{line};\n")).collect::<String>();
    assert_same(&read_bytes(ended.as_bytes(), &ReadOptions::default()).unwrap(), "ended", 0);
}

#[test]
fn fractions_that_are_no_seconds_are_milliseconds_by_their_interval_and_asked_for() {
    let text = lines("TIMESTAMP,u,theta\n", |k, _, u, x| format!("{},{u},{x}", 0.076 + 2.16 * f64::from(k)));
    let proposal = refusal(&text).proposal.unwrap();
    assert_eq!(proposal.map, "time=TIMESTAMP:ms,voltage=u:V,angle=theta:rad");
    assert!(proposal.assumptions().contains("ms is a guess"), "{}", proposal.assumptions());
}

#[test]
fn a_unit_that_no_motor_is_logged_in_gives_way_to_one_it_may_be_and_is_said() {
    for (name, per_s, unit, rate) in [
        ("time_us", 1.0, "s", "1.0e8 samples a second"),
        ("time_us", 0.1, "s", "1.0e9 samples a second"),
        ("time [us]", 1.0, "s", "1.0e8 samples a second"),
        ("t_ns", 1000.0, "ms", "1.0e8 samples a second"),
        ("time_s", 1e6, "us", "1.0e-4 samples a second"),
    ] {
        let text = lines(&format!("{name},u,theta\n"), |_, t, u, x| format!("{:.3},{u},{x}", per_s * t));
        let proposal = refusal(&text).proposal.unwrap();
        assert_eq!(proposal.map, format!("time={name}:{unit},voltage=u:V,angle=theta:rad"));
        let said = proposal.assumptions();
        assert!(said.contains(rate) && said.contains(&format!("{unit} is proposed")), "{said}");
        read_bytes(text.as_bytes(), &mapped(&proposal.map)).unwrap();
    }
    // A unit that may be is left alone, be it unusual.
    for (name, per_s, unit) in [("time_us", 1e6, "us"), ("t_ms", 1000.0, "ms"), ("t_s", 100.0, "s")] {
        let text = lines(&format!("{name},u,theta\n"), |_, t, u, x| format!("{:.3},{u},{x}", per_s * t));
        let proposal = refusal(&text).proposal.unwrap();
        assert_eq!(proposal.map, format!("time={name}:{unit},voltage=u:V,angle=theta:rad"));
        assert!(!proposal.assumptions().contains("samples a second"), "{}", proposal.assumptions());
    }
}

#[test]
fn days_of_excel_and_matlab_are_proposed_as_days_and_said() {
    for first in [45_987.123_456, 739_900.5] {
        let text = lines("time,u,theta\n", |_, t, u, x| format!("{:.11},{u},{x}", first + t / 86_400.0));
        let proposal = refusal(&text).proposal.unwrap();
        assert_eq!(proposal.map, "time=time:s*86400,voltage=u:V,angle=theta:rad");
        assert!(proposal.assumptions().contains("days"), "{}", proposal.assumptions());
        let record = read_bytes(text.as_bytes(), &mapped(&proposal.map)).unwrap();
        let late = |k: usize| record.time_s[k] - record.time_s[0] - 0.01 * k as f64;
        assert!((0..ROWS as usize).all(|k| late(k).abs() < 2e-5));
    }
    // A board that has been on for half a day counts seconds.
    let text = lines("time,u,theta\n", |_, t, u, x| format!("{:.3},{u},{x}", 45_987.123 + t));
    assert!(refusal(&text).proposal.unwrap().map.starts_with("time=time:s,"));
}

#[test]
fn a_rate_tells_the_time_where_its_column_cannot_and_the_refusal_proposes_it() {
    for (head, unit) in [(HEADER, ""), ("t,u,theta\n", "time=t:s,voltage=u:V,angle=theta:rad")] {
        let text = lines(head, |_, t, u, x| format!("{:.1},{u},{x}", (10.0 * t + 1e-9).floor() / 10.0));
        let options = mapped(unit);
        if head != HEADER {
            let proposal = refusal(&text).proposal.unwrap();
            assert_eq!((proposal.map.as_str(), proposal.rate.as_deref()), (unit, Some("100")));
        }
        let refused = read_bytes(text.as_bytes(), &options).unwrap_err();
        let motorlens::error::Error::BadInput(fault) = refused else { panic!("{refused}") };
        assert!(fault.why.contains("repeat the time"), "{fault}");
        let proposal = fault.proposal.unwrap();
        assert_eq!((proposal.map.as_str(), proposal.rate.as_deref()), (unit, Some("105")));
        let options = ReadOptions { rate_hz: Some(100.0), ..options };
        let record = read_bytes(text.as_bytes(), &options).unwrap();
        assert_same(&record, head, 0);
        assert!(record.warnings[0].what.contains("--rate does"), "{:?}", record.warnings);
        assert!(!record.warnings[0].what.contains("a second"), "{:?}", record.warnings);
        let options = ReadOptions { rate_hz: Some(50.0), ..options };
        let said = read_bytes(text.as_bytes(), &options).unwrap().warnings;
        assert!(said[0].what.contains("they are 105 a second, not 50"), "{said:?}");
    }
    // A clock that can tell the time does.
    let options = ReadOptions { rate_hz: Some(50.0), ..ReadOptions::default() };
    let record = read_bytes(plain().as_bytes(), &options).unwrap();
    assert_same(&record, "plain", 0);
    assert!(record.warnings[0].what.contains("--rate is not used"), "{:?}", record.warnings);
}

#[test]
fn lines_that_were_printed_twice_are_left_out_once_and_counted() {
    for every in [1, 7] {
        let text = lines(HEADER, |k, t, u, x| {
            let line = format!("{t:.4},{u:.4},{x:.4}");
            if k % every == 0 { format!("{line}\n{line}") } else { line }
        });
        let record = read_bytes(text.as_bytes(), &ReadOptions::default()).unwrap();
        assert_same(&record, "twice", 0);
        let said: Vec<&str> = record.warnings.iter().map(|w| w.what.as_str()).collect();
        let count = ROWS.div_ceil(every);
        assert!(said.len() == 1 && said[0].starts_with(&format!("{count} lines say again")), "{said:?}");
    }
    // Without a time equal lines are those of a motor that stands still.
    let text = lines("u,theta\n", |k, _, _, _| if k < 50 { "0,0".into() } else { format!("1,{}", k - 49) });
    let options = ReadOptions { rate_hz: Some(100.0), ..mapped("voltage=u,angle=theta") };
    assert_eq!(read_bytes(text.as_bytes(), &options).unwrap().len(), ROWS as usize);
}

/// Rigol's files tell their rate in the header, behind the names of the channels or in a row below them.
#[test]
fn a_header_of_rigol_tells_the_rate() {
    let old =
        lines("X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.000000e+01,1.000000e-02\n", |k, _, u, x| {
            format!("{k},{u:.6e},{x:.6e},")
        });
    let new =
        lines("CH1,CH2,t0 =-1.000000e+01, tInc = 1.000000e-02,\n", |_, _, u, x| format!("{u:.6e},{x:.6e},,"));
    for text in [old, new] {
        let asked = refusal(&text).to_string();
        assert!(asked.contains("--map voltage=CH1:V,speed=CH2:rad/s --rate 100"), "{asked}");
        let options = ReadOptions { rate_hz: Some(100.0), ..mapped("voltage=CH1:V,angle=CH2:rad") };
        assert_same(&read_bytes(text.as_bytes(), &options).unwrap(), "rigol", 0);
    }
}
