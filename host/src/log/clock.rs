//! Times as loggers write them: numbers in a unit, clock times, dates with times, counts of nanoseconds.
//!
//! A clock time counts from midnight of the first day; midnight is crossed where it falls by more than half a day. A count with more
//! digits than a number holds (nanoseconds of the epoch) counts from its first row.

const DAY_S: f64 = 86_400.0;
/// Whole numbers beyond this do not fit a floating-point number.
const EXACT: i64 = 1 << 53;

/// A time of day, and the day where it is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moment {
    /// Days since 1970-01-01.
    pub day: Option<i64>,
    /// Seconds since midnight, of the zone if one is told.
    pub seconds: f64,
}

/// The clock of one or several files that belong together.
#[derive(Debug, Clone, Default)]
pub(super) struct Clock {
    day: Option<i64>,
    origin: Option<i64>,
    midnights: f64,
    last: Option<f64>,
}

impl Clock {
    /// The same clock at the beginning of another file.
    pub fn rewound(&self) -> Clock {
        Clock { midnights: 0.0, last: None, ..self.clone() }
    }

    /// The time in a field, s; numbers are in units of `unit_s` seconds.
    pub fn read(&mut self, text: &str, unit_s: f64, number: Option<f64>) -> Option<f64> {
        if let Some(value) = number {
            if value.abs() >= EXACT as f64
                && let Ok(count) = text.parse::<i64>()
            {
                let origin = *self.origin.get_or_insert(count);
                return Some(count.checked_sub(origin)? as f64 * unit_s);
            }
            return Some(value * unit_s);
        }
        if let Some(seconds) = time_delta(text) {
            return Some(seconds);
        }
        let moment = moment(text)?;
        if let Some(day) = moment.day {
            let first = *self.day.get_or_insert(day);
            return Some((day - first) as f64 * DAY_S + moment.seconds);
        }
        if self.last.is_some_and(|last| last - moment.seconds > 0.5 * DAY_S) {
            self.midnights += DAY_S;
        }
        self.last = Some(moment.seconds);
        Some(self.midnights + moment.seconds)
    }
}

/// Understands `12:34:56.789`, `34:56.789`, `1:02:03,5 PM`, `2024-05-01T12:34:56.789+02:00`, `01.05.2024 12:34:56`. Of a date
/// with strokes and the year last, which may be of either order, the day is left open.
pub(super) fn moment(text: &str) -> Option<Moment> {
    if let Some(seconds) = time_delta(text) {
        return Some(Moment { day: None, seconds });
    }
    if !text.contains(':') || text.len() > 48 {
        return None;
    }
    let text = text.trim();
    let text = ["UTC", "GMT"].iter().find_map(|zone| text.strip_suffix(*zone)).map_or(text, str::trim_end);
    let (date, time) = match text.find(['T', 't', ' ', '_']) {
        Some(at) if is_date(text[..at].trim_end_matches(',')) => {
            (Some(text[..at].trim_end_matches(',')), &text[at + 1..])
        }
        _ => (None, text),
    };
    let (seconds, zone_s) = time_of_day(time.trim())?;
    let day = match date {
        Some(date) => day_of(date)?,
        None => None,
    };
    let seconds = seconds - zone_s;
    let days = (seconds / DAY_S).floor();
    if day.is_some() {
        return Some(Moment { day: day.map(|day| day + days as i64), seconds: seconds - days * DAY_S });
    }
    Some(Moment { day, seconds: seconds.rem_euclid(DAY_S) })
}

/// Seconds of a time literal of PLCs (IEC 61131-3): `T#1s20ms`, `TIME#2m3.5s`, `LTIME#1us500ns`.
fn literal(text: &str) -> Option<f64> {
    const UNITS: [(&str, f64); 7] =
        [("d", DAY_S), ("h", 3600.0), ("m", 60.0), ("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
    let (kind, rest) = text.trim().split_once('#')?;
    let lower = rest.to_ascii_lowercase().replace('_', "");
    let (sign, mut rest) = lower.strip_prefix('-').map_or((1.0, lower.as_str()), |size| (-1.0, size));
    if !["t", "time", "lt", "ltime"].contains(&kind.to_ascii_lowercase().as_str()) || rest.is_empty() {
        return None;
    }
    let mut seconds = 0.0;
    while !rest.is_empty() {
        let (count, behind) = rest.split_at(rest.find(|c: char| c.is_ascii_alphabetic())?);
        let end = behind.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(behind.len());
        let name = &behind[..end];
        let (_, unit_s) = UNITS.iter().find(|(unit, _)| *unit == name)?;
        seconds += count.parse::<f64>().ok().filter(|count| *count >= 0.0)? * unit_s;
        rest = &behind[end..];
    }
    Some(sign * seconds)
}

/// Seconds of a difference of times as pandas writes it: `0 days 00:00:01.25`, `-1 days +23:59:59`; or of a time literal.
fn time_delta(text: &str) -> Option<f64> {
    if text.contains('#') {
        return literal(text);
    }
    let (days, time) = text.trim().split_once(" day")?;
    let days: f64 = days.trim().parse().ok()?;
    let (seconds, _) = time_of_day(time.trim_start_matches('s').trim().trim_start_matches('+'))?;
    Some(days * DAY_S + seconds)
}

/// Whether `text` has the shape of a date, or of a difference of times.
pub(super) fn is_date(text: &str) -> bool {
    day_of(text).is_some()
}

/// The day of a date, `Some(None)` where it is one whose order is not told.
fn day_of(text: &str) -> Option<Option<i64>> {
    let between = text.chars().find(|c| ['-', '/', '.'].contains(c))?;
    let mut parts = text.split(between);
    let mut part = || {
        let digits = parts.next()?;
        (digits.len() <= 4 && !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()))
            .then(|| Some((digits.parse::<i64>().ok()?, digits.len())))?
    };
    let (a, b, c) = (part()?, part()?, part()?);
    if parts.next().is_some() {
        return None;
    }
    let of = |year: i64, month: i64, day: i64| {
        ((1..=12).contains(&month) && (1..=31).contains(&day)).then(|| days_since_1970(year, month, day))
    };
    match (a.1, c.1, between) {
        (4, ..) => Some(Some(of(a.0, b.0, c.0)?)),
        (_, 4, '.' | '-') => Some(Some(of(c.0, b.0, a.0)?)),
        (_, 2 | 4, '/') => Some(None),
        _ => None,
    }
}

/// Seconds since midnight, and the zone's seconds east of Greenwich.
fn time_of_day(text: &str) -> Option<(f64, f64)> {
    let lower = text.to_ascii_lowercase();
    let (clock, afternoon) = match (lower.strip_suffix("pm"), lower.strip_suffix("am")) {
        (Some(clock), _) => (clock.trim(), Some(true)),
        (_, Some(clock)) => (clock.trim(), Some(false)),
        _ => (lower.trim_end_matches('z'), None),
    };
    let (clock, zone_s) = match clock.rfind(['+', '-']) {
        Some(at) => {
            let digits: String = clock[at + 1..].chars().filter(|c| *c != ':').collect();
            let zone: f64 = digits.parse::<u32>().ok().filter(|_| [2, 4].contains(&digits.len()))?.into();
            let (hours, minutes) =
                if digits.len() == 2 { (zone, 0.0) } else { ((zone / 100.0).floor(), zone % 100.0) };
            let sign = if clock[at..].starts_with('-') { -1.0 } else { 1.0 };
            (clock[..at].trim_end(), sign * (3600.0 * hours + 60.0 * minutes))
        }
        None => (clock, 0.0),
    };
    let mut parts: Vec<&str> = clock.split(':').collect();
    let mut last = parts.pop()?.replacen(',', ".", 1);
    // `12:00:00:005`: three digits behind the seconds are milliseconds.
    if parts.len() == 3 && last.len() == 3 && last.bytes().all(|b| b.is_ascii_digit()) {
        last = format!("{}.{last}", parts.pop()?);
    }
    let plain = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    if parts.iter().any(|part| !plain(part) || part.len() > 2 || part.contains('.')) || !plain(&last) {
        return None;
    }
    let seconds: f64 = last.parse().ok().filter(|s| *s < 61.0)?;
    let number = |text: &str| text.parse::<f64>().ok();
    let (mut hours, minutes) = match parts.as_slice() {
        [hours, minutes] => (number(hours)?, number(minutes)?),
        // With hours and minutes alone the seconds would be missing: a fraction tells them apart.
        [minutes] if last.contains('.') => (0.0, number(minutes)?),
        _ => return None,
    };
    match afternoon {
        Some(true) if hours < 12.0 => hours += 12.0,
        Some(false) if hours == 12.0 => hours = 0.0,
        _ => {}
    }
    (hours <= 24.0 && minutes < 60.0).then_some((3600.0 * hours + 60.0 * minutes + seconds, zone_s))
}

/// Days of the Gregorian calendar: years of 365 days, the leap days, and the days before the month in a year that begins in March.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let leap_days = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    365 * year + leap_days + of_year - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(day: Option<i64>, seconds: f64) -> Option<Moment> {
        Some(Moment { day, seconds })
    }

    #[test]
    fn a_difference_of_times_as_pandas_writes_it_is_seconds() {
        let mut clock = Clock::default();
        assert_eq!(clock.read("0 days 00:00:00.004", 1.0, None), Some(0.004));
        assert_eq!(clock.read("1 days 00:01:00", 1.0, None), Some(86_460.0));
        assert_eq!(clock.read("-1 days +23:59:59.5", 1.0, None), Some(-0.5));
        assert_eq!(clock.read("one day", 1.0, None), None);
    }

    #[test]
    fn a_time_literal_of_a_plc_is_seconds() {
        for (text, seconds) in [
            ("T#20ms", Some(0.02)),
            ("t#1s20ms", Some(1.02)),
            ("TIME#2m3.5s", Some(123.5)),
            ("LTIME#1d_2h", Some(93_600.0)),
            ("T#-5ms", Some(-0.005)),
            ("T#", None),
            ("T#5", None),
            ("T#5x", None),
            ("N#5ms", None),
            ("#5ms", None),
        ] {
            let read = Clock::default().read(text, 1.0, None);
            assert_eq!(read.is_some(), seconds.is_some(), "{text}");
            assert!(read.is_none_or(|read| (read - seconds.unwrap()).abs() < 1e-12), "{text} {read:?}");
        }
    }

    #[test]
    fn times_and_dates_of_loggers_are_understood() {
        let noon = 12.0 * 3600.0;
        for (text, expected) in [
            ("12:00:00.250", at(None, noon + 0.25)),
            ("12:00:00,250", at(None, noon + 0.25)),
            ("1:00:00 PM", at(None, noon + 3600.0)),
            ("12:00:01 am", at(None, 1.0)),
            ("02:03.5", at(None, 123.5)),
            ("1970-01-02T12:00:00Z", at(Some(1), noon)),
            ("1970-01-02 12:00:00+02:00", at(Some(1), noon - 7200.0)),
            ("1970-01-02 12:00:00.5 UTC", at(Some(1), noon + 0.5)),
            ("1970-01-02 12:00:00.5 +0200 GMT", at(Some(1), noon - 7199.5)),
            ("1970-01-02T01:00:00+0200", at(Some(0), 23.0 * 3600.0)),
            ("2024/03/01 12:00:00", at(Some(19_783), noon)),
            ("01.03.2024 12:00:00", at(Some(19_783), noon)),
            ("3/1/2024 12:00:00", at(None, noon)),
            ("12:00", None),
            ("a:1", None),
            ("1.5", None),
            ("25:00:00", None),
            ("2024-13-01 12:00:00", None),
        ] {
            assert_eq!(moment(text), expected, "{text}");
        }
        assert_eq!(days_since_1970(2000, 2, 29), 11_016);
    }

    #[test]
    fn midnight_is_crossed_and_days_are_counted_from_the_first() {
        let mut clock = Clock::default();
        assert_eq!(clock.read("23:59:59.5", 1.0, None), Some(86_399.5));
        assert_eq!(clock.read("00:00:00.5", 1.0, None), Some(86_400.5));
        let mut clock = Clock::default();
        assert_eq!(clock.read("2024-02-29 23:59:59", 1.0, None), Some(86_399.0));
        assert_eq!(clock.read("2024-03-01 00:00:01", 1.0, None), Some(86_401.0));
        // Another file on the same clock.
        assert_eq!(clock.rewound().read("2024-02-29 00:00:01", 1.0, None), Some(1.0));
    }

    #[test]
    fn nanoseconds_of_the_epoch_lose_nothing() {
        let mut clock = Clock::default();
        let mut read = |text: &str| clock.read(text, 1e-9, text.parse().ok()).unwrap();
        assert_eq!(read("1732340000000000001"), 0.0);
        assert_eq!(read("1732340000000000003"), 2e-9);
        assert!((read("12") - 12e-9).abs() < 1e-20);
    }
}
