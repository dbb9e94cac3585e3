//! Rows per second, as what stands before the rows tells them: LabVIEW's `Delta_X`, an oscilloscope's interval, Rigol's increment.

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
