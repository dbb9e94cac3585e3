//! Times as most loggers write them: clock times, dates, epochs, intervals, or a rate beside the rows.

use motorlens::log::ReadOptions;

use super::{HEADER, ROWS, clock, lines, mapped, plain, read_bytes, read_same, row};

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
        read_same(text.as_bytes(), &mapped(map), what);
    }
    let untimed = lines("voltage_v,angle_rad\n", |_, _, u, x| format!("{u},{x}"));
    let with_rate = ReadOptions { rate_hz: Some(100.0), ..ReadOptions::default() };
    read_same(untimed.as_bytes(), &with_rate, "rate");
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
    let slower = ReadOptions { rate_hz: Some(7.0), ..ReadOptions::default() };
    let record = read_same(plain().as_bytes(), &slower, "rate beside times");
    assert!(record.warnings.iter().any(|w| w.what.contains("--rate is not used")), "{:?}", record.warnings);
}
