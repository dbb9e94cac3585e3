//! Rows per second, as what stands before the rows tells them: LabVIEW's `Delta_X`, an oscilloscope's interval, Rigol's increment, a remark.

use super::formats::interval;
use super::numbers::number;

/// Rows per second, where a line before the header tells the time between them.
pub(super) fn before(text: &str) -> Option<f64> {
    const INTERVALS: [(&str, f64); 4] =
        [("delta_x", 1.0), ("sample interval", 1.0), ("sampling interval", 1.0), ("sampletime[ms]", 1e-3)];
    let between = ['\t', ',', ';'].into_iter().find(|between| text.contains(*between))?;
    let (key, rest) = text.split_once(between)?;
    let key = key.trim().to_lowercase();
    let (_, unit_s) = INTERVALS.into_iter().find(|(known, _)| *known == key)?;
    of(unit_s * number(rest.split(between).next()?.trim())?)
}

/// The same of a line in words: `sampling rate: 100 Hz`, `fs = 100`, `Sample time: 10 ms`.
pub(super) fn told(text: &str) -> Option<f64> {
    let (key, value) = text.split_once([':', '='])?;
    let (key, value) = (key.trim(), value.trim());
    let end = value.find(|c: char| !c.is_ascii_digit() && !".,eE+-".contains(c)).unwrap_or(value.len());
    let size = number(value[..end].trim())?;
    let unit = value[end..].split_whitespace().next().unwrap_or_default().to_lowercase();
    let rate = if interval::is_rate(key) {
        match unit.as_str() {
            "" | "hz" | "sps" | "s/s" | "sa/s" | "1/s" => size,
            "khz" | "ksps" | "ks/s" => 1e3 * size,
            _ => return None,
        }
    } else if interval::is_interval(key) {
        match unit.as_str() {
            "s" | "sec" => 1.0 / size,
            "ms" => 1e3 / size,
            "us" | "\u{b5}s" | "\u{3bc}s" => 1e6 / size,
            // Seconds have a fraction, or are too long for a motor.
            "" if size < 1.0 => 1.0 / size,
            _ => return None,
        }
    } else {
        return None;
    };
    of(1.0 / rate)
}

/// The same of Rigol's header, whose last columns are none: `X,CH1,CH2,Start,Increment` above a row of what they are, or
/// `CH1V,CH2V,t0 = -1e-3, tInc = 1e-6`. Tells how many of the `names` are columns too, and whether the next line is no row.
pub(super) fn rigol(names: &[String], next: &str) -> Option<(f64, usize, bool)> {
    let lower: Vec<String> = names.iter().map(|name| name.trim().to_lowercase()).collect();
    if let Some(place) = lower.iter().position(|name| name == "increment")
        && lower.get(place.checked_sub(1)?).is_some_and(|name| name == "start")
    {
        let interval = number(next.split(',').nth(place)?.trim())?;
        return Some((of(interval)?, place - 1, true));
    }
    let place = lower.iter().position(|name| name.starts_with("tinc"))?;
    let interval = number(lower[place].split_once('=')?.1.trim().trim_end_matches('s').trim())?;
    let first = lower.iter().position(|name| name.starts_with("t0")).unwrap_or(place);
    Some((of(interval)?, first.min(place), false))
}

fn of(interval_s: f64) -> Option<f64> {
    (interval_s > 0.0 && interval_s.is_finite()).then(|| (1e6 / interval_s).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_remark_tells_the_rate_in_words_and_the_speed_of_a_line_is_none() {
        for (text, rate) in [
            ("sampling rate: 100 Hz", Some(100.0)),
            (" Sample rate: 2.5kHz", Some(2500.0)),
            ("fs = 250", Some(250.0)),
            ("Sampling time: 10 ms", Some(100.0)),
            ("dt=0.005", Some(200.0)),
            ("sample_rate = 100", Some(100.0)),
            ("Sampling_period: 0.02 s", Some(50.0)),
            ("dt: 5", None),
            ("baud rate: 115200", None),
            ("sampling rate: high", None),
            ("fs = 0", None),
            ("gear_ratio: 100", None),
        ] {
            assert_eq!(told(text), rate, "{text}");
        }
    }

    #[test]
    fn a_header_of_rigol_tells_the_rate_and_what_is_no_column() {
        let names = |text: &str| text.split(',').map(str::to_owned).collect::<Vec<_>>();
        let (old, next) = ("X,CH1,CH2,Start,Increment,", "Sequence,Volt,Volt,-1.0e+01,1.0e-02");
        assert_eq!(rigol(&names(old), next), Some((100.0, 3, true)));
        assert_eq!(
            rigol(&names("CH1V,CH2V,t0 =-1e-3, tInc = 2.0e-06"), "1,2,,"),
            Some((500_000.0, 2, false))
        );
        for (other, next) in
            [("t,u,increment", "1,2,3"), (old, "0,1,2,x,y"), ("tinc,u", "1,2"), ("t0,tInc = 0", "")]
        {
            assert_eq!(rigol(&names(other), next), None, "{other}");
        }
    }
}
