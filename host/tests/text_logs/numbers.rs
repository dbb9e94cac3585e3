//! What loggers and spreadsheets do to rows and numbers: each is undone and said, or refused with what to do.

use motorlens::log::{ReadOptions, Record};

use super::{HEADER, ROWS, assert_same, lines, mapped, read_bytes, refusal, row};

/// The record in `text`, of which something was said with these words.
fn read_with(text: &str, map: &str, words: &str) -> Record {
    let record = read_bytes(text.as_bytes(), &mapped(map)).unwrap_or_else(|error| panic!("{words}: {error}"));
    assert!(record.warnings.iter().any(|w| w.what.contains(words)), "{words}: {:?}", record.warnings);
    record
}

#[test]
fn values_that_were_not_read_are_blanks_in_any_share_of_the_rows() {
    for nothing in ["NA", "N/A", "null", "NULL", "nan", "#N/A", "-", "None"] {
        let text = lines(HEADER, |k, t, u, x| match k % 10 {
            3 => format!("{t},{u},{nothing}"),
            _ => format!("{t},{u},{x}"),
        });
        let record = read_with(&text, "", "20 rows with a blank here were left out, first in line 5");
        assert_eq!(record.len(), ROWS as usize - 20, "{nothing}");
        let text = text.replace(HEADER, "time_s,angle_rad,voltage_v\n");
        let held = read_with(&text, "", "20 blank fields hold the value before them");
        assert_eq!(held.voltage_v[3], row(2).2, "{nothing}");
    }
    // A time that is not there is made up by nobody, and what is no number is a fault.
    for (text, words) in [
        (
            lines(HEADER, |k, t, u, x| {
                format!("{},{u},{x}", if k % 10 == 3 { "NA".into() } else { t.to_string() })
            }),
            "\"NA\"",
        ),
        (
            lines(HEADER, |k, t, u, x| {
                format!("{t},{u},{}", if k % 10 == 3 { "ERR".into() } else { x.to_string() })
            }),
            "\"ERR\"",
        ),
    ] {
        let said = refusal(&text).to_string();
        assert!(said.contains(words) && said.contains("20 of 200 rows are unreadable"), "{said}");
    }
}

/// A speed is divided by no time in its first row.
#[test]
fn one_row_without_a_number_is_left_out_of_a_log_however_short_it_is() {
    let one = |bad: u32| {
        let text = lines(HEADER, |k, t, u, x| {
            format!("{t},{u},{}", if k < bad { "inf".into() } else { x.to_string() })
        });
        text.lines().take(25).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(read_with(&one(1), "", "\"inf\"").len(), 23);
    assert!(refusal(&one(2)).to_string().contains("2 of 24 rows are unreadable"));
}

/// All rows, those at `places` behind their neighbours.
fn late(places: &[usize]) -> String {
    let text = lines(HEADER, |_, t, u, x| format!("{t:.4},{u:.4},{x:.4}"));
    let mut all: Vec<&str> = text.lines().collect();
    places.iter().for_each(|&k| all.swap(1 + k, 2 + k));
    all.join("\n")
}

#[test]
fn a_row_that_came_late_is_put_in_order_and_many_are_refused() {
    for places in [&[100][..], &[40, 120], &[198]] {
        let last = format!("line {}", places[places.len() - 1] + 3);
        let record = read_with(&late(places), "", "put in order by their time");
        assert!(record.warnings[0].what.contains(&last), "{:?}", record.warnings);
        assert_same(&record, "late rows", 0);
    }
    let said = refusal(&late(&[40, 80, 120])).to_string();
    assert!(said.contains("line 43") && said.contains("goes backwards, from 0.41 s to 0.4 s"), "{said}");
    // A time from the future is no row that others are late behind.
    let odd = lines(HEADER, |k, t, u, x| format!("{},{u},{x}", if k == 197 { 3.0 } else { t }));
    assert!(refusal(&odd).to_string().contains("goes backwards, from 3 s"));
}

/// A serial port still holds a line of before the board was reset.
#[test]
fn a_first_row_of_before_the_clock_began_is_left_out_and_named() {
    let text = lines(HEADER, |k, t, u, x| format!("{},{u},{x}", if k == 0 { 1.074 } else { t }));
    let record = read_with(&text, "", "its time, 1.074 s, is later than that of the next row");
    assert!(record.warnings[0].place.contains("line 2"), "{:?}", record.warnings);
    assert_eq!(record.len(), ROWS as usize - 1);
}

#[test]
fn a_clock_of_few_bits_goes_on_where_it_begins_anew() {
    for (unit, from, step, width) in [
        ("ms", 65_000_u64, 10, 1_u64 << 16),
        ("us", 1_234, 10_000, 1 << 16),
        ("us", (1 << 32) - 99_000, 10_000, 1 << 32),
    ] {
        let text =
            lines("t,u,pos\n", |k, _, u, x| format!("{},{u},{x}", (from + step * u64::from(k)) % width));
        let map = format!("time=t:{unit},voltage=u,angle=pos");
        let record = read_with(&text, &map, &format!("the clock begins anew at {width}"));
        assert_same(&record, unit, 0);
    }
}

#[test]
fn signs_that_a_type_took_away_come_back() {
    for width in [1_i64 << 16, 1 << 32] {
        let taken = |x: f64| ((1e3 * x).round() as i64).rem_euclid(width);
        let text = lines("t,u_mV,pos\n", |_, t, u, x| format!("{t},{},{x}", taken(u)));
        let proposal = refusal(&text).proposal.unwrap();
        assert!(proposal.preview[1].contains("-4000 .. 4000 mV"), "{:?}", proposal.preview);
        let record = read_with(&text, &proposal.map, &format!("{} was read as -1", width - 1));
        assert!((0..ROWS).all(|k| (record.voltage_v[k as usize] - row(k).1).abs() < 6e-4));
    }
    // Of 8 bits nothing is sure but where the motor turns back, and it is asked.
    let text = lines("t,pwm,pos\n", |_, t, u, x| format!("{t},{},{x}", ((10.0 * u) as i64).rem_euclid(256)));
    let proposal = refusal(&text).proposal.unwrap();
    assert!(proposal.map.contains("duty=pwm:int8/255"), "{}", proposal.map);
    assert!(proposal.assumptions().contains("255 is read as -1"));
    // A duty of 16 bits that is said to be one, though it stays near both ends.
    let level = |k: u32| [0, 2000, 4000, 9000, 60_000, 62_000, 64_000, 65_535][k as usize / 10 % 8];
    let text = lines("t,pwm,pos\n", |k, t, _, x| format!("{t},{},{x}", level(k)));
    let asked = refusal(&text).proposal.unwrap().assumptions();
    assert!(
        asked.contains("65535 in \"pwm\" is read as -1; where it is full duty, write duty=pwm:65535"),
        "{asked}"
    );
    let options = ReadOptions { supply_volts: Some(65.535), ..mapped("time=t,duty=pwm:65535,angle=pos") };
    let record = read_bytes(text.as_bytes(), &options).unwrap();
    assert!((0..ROWS).all(|k| (record.voltage_v[k as usize] - 1e-3 * f64::from(level(k))).abs() < 1e-9));
    // A duty of 16 bits that is off or full is one.
    let text = lines("t,pwm,pos\n", |_, t, u, x| format!("{t},{},{x}", if u > 0.0 { 65_535 } else { 0 }));
    let options = ReadOptions { supply_volts: Some(4.0), ..mapped("time=t,duty=pwm:65535,angle=pos") };
    let record = read_bytes(text.as_bytes(), &options).unwrap();
    assert!(record.voltage_v.contains(&4.0) && record.voltage_v.iter().all(|volts| *volts >= 0.0));
}

#[test]
fn brackets_are_a_minus_and_quoted_thousands_are_one_number() {
    let bracketed = |x: f64| if x < 0.0 { format!("({:.4})", -x) } else { format!("{x:.4}") };
    let text = lines(HEADER, |_, t, u, x| format!("{t},{},{x}", bracketed(u)));
    assert_same(&read_with(&text, "", "in brackets were read as negative ones"), "brackets", 0);
    let grouped = |x: f64| {
        let (sign, text) = (if x < 0.0 { "-" } else { "" }, format!("{:.1}", x.abs()));
        match text.len().checked_sub(5) {
            Some(at) if at > 0 => format!("\"{sign}{},{}\"", &text[..at], &text[at..]),
            _ => format!("\"{sign}{text}\""),
        }
    };
    let text = lines("t_ms,u_mV,pos\n", |k, _, u, x| {
        let ms = 10 * k;
        let ms = if ms < 1000 { ms.to_string() } else { format!("\"{},{:03}\"", ms / 1000, ms % 1000) };
        format!("{ms},{},{x}", grouped(1e3 * u))
    });
    let proposal = refusal(&text).proposal.unwrap();
    assert!(proposal.preview[0].contains("0 .. 1990 ms"), "{:?}", proposal.preview);
    assert_same(&read_bytes(text.as_bytes(), &mapped(&proposal.map)).unwrap(), "thousands", 0);
}

#[test]
fn a_counter_goes_on_over_the_end_of_its_bits_however_seldom_it_gets_there() {
    let count = |x: f64| (x * 500.0).round() as i64;
    let map = "time=t,voltage=u,angle=count:counts";
    let mut options = mapped(map);
    options.motor.counts_per_rev = Some(500.0 * std::f64::consts::TAU);
    for (width, signed) in [(1_i64 << 16, false), (1 << 16, true), (1 << 32, false), (1 << 32, true)] {
        let (begin, shift) = if signed { (width / 2 - 300, width / 2) } else { (width - 300, 0) };
        let text = lines("t,u,count\n", |_, t, u, x| {
            format!("{t},{u},{}", (count(x) + begin + shift).rem_euclid(width) - shift)
        });
        let record = read_bytes(text.as_bytes(), &options).unwrap_or_else(|e| panic!("{width}: {e}"));
        assert_eq!(record.len(), ROWS as usize, "{width} {signed}: {:?}", record.warnings);
        let angle = record.angle_rad.as_ref().unwrap();
        let off = |k: usize| angle[k] - angle[0] - row(k as u32).2;
        assert!((0..record.len()).all(|k| off(k).abs() < 2e-3), "{width} {signed}");
        assert!(record.warnings.iter().any(|w| w.what.starts_with("wrapped_angle")), "{:?}", record.warnings);
    }
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
