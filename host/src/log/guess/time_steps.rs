//! A clock that counts the steps of a loop or a timer: how many of them come a second.

use super::clocks::LONG_FOR_SECONDS;
use super::columns::Part;
use super::one_motion::{NEAR, ratio};
use super::words;
use crate::log::timing;
use crate::log::units::{Quantity, Unit};

/// The unit of a count of time steps, before how many of them come a second.
const A_SECOND: &str = "s/";
/// How many timers count a second, in each decade.
const USUAL: [f64; 8] = [1.0, 1.25, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0];

/// How many steps a second the name of a count of them tells: 8000 of `timestep (8kHz)`.
fn ticks_told(name: &str) -> Option<f64> {
    let lower = name.to_lowercase();
    let (before, _) = lower.split_once("hz").filter(|_| words::is_time_step(name))?;
    let (before, factor) = match (before.strip_suffix('k'), before.strip_suffix('m')) {
        (Some(before), _) => (before, 1e3),
        (_, Some(before)) => (before, 1e6),
        _ => (before, 1.0),
    };
    let before = before.trim_end();
    let rest = before.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
    let number: f64 = before[rest.len()..].parse().ok()?;
    Some(factor * number).filter(|rate| *rate > 0.0)
}

/// How many steps a second make the speed the change of the angle beside it, where a timer counts so many.
fn ticks_by_motion(parts: &[Part], rows: &[Vec<f64>]) -> Option<f64> {
    let unit = |wanted: Quantity| {
        let part = parts.iter().find(|part| part.quantity == wanted)?;
        Unit::parse(wanted, &part.unit).ok()
    };
    let (time, angle, speed) = (unit(Quantity::Time)?, unit(Quantity::Angle)?, unit(Quantity::Speed)?);
    let (times, _) = ratio(parts, rows).filter(|_| angle.per_turn == speed.per_turn)?;
    let rate = times * speed.factor / angle.factor / time.factor;
    let decade = 10_f64.powi(rate.log10().floor() as i32);
    USUAL.into_iter().map(|usual| usual * decade).find(|usual| (rate / usual - 1.0).abs() < NEAR)
}

/// Reads a count of time steps, whose unit nothing tells, as so many a second as the motion beside it tells, or else its name.
pub(super) fn tell_ticks(parts: &mut [Part], names: &[String], rows: &[Vec<f64>]) {
    let is_open = |part: &Part| {
        part.quantity == Quantity::Time
            && part.guessed
            && part.rest.is_none()
            && words::is_time_step(&names[part.index])
    };
    let Some(clock) = parts.iter().position(is_open) else { return };
    let index = parts[clock].index;
    let by_name = || {
        let values: Vec<f64> = rows.iter().filter_map(|row| row.get(index)).copied().collect();
        let rate = ticks_told(&names[index])?;
        let interval_s = timing::median_interval(&values) / rate;
        (timing::is_plausible(interval_s) && interval_s < LONG_FOR_SECONDS).then_some(rate)
    };
    if let Some(rate) = ticks_by_motion(parts, rows).or_else(by_name) {
        parts[clock].unit = format!("{A_SECOND}{rate}");
        parts[clock].guessed = false;
    }
}

/// What is said of a count of time steps that is read as so many a second.
pub(super) fn said_of_ticks(name: &str, part: &Part) -> Option<String> {
    let rate = part.unit.strip_prefix(A_SECOND).filter(|_| words::is_time_step(name))?;
    let told = ticks_told(name);
    let why = match told {
        Some(told) if told.to_string() == rate => "as it says itself".to_owned(),
        Some(told) => {
            format!("by which the speed is the change of the angle, and not {told}, as it says")
        }
        None => "by which the speed is the change of the angle".to_owned(),
    };
    Some(format!(
        "\"{name}\" is taken for a count of {rate} steps a second, {why}; put another unit in its place if it is one"
    ))
}

#[cfg(test)]
mod tests {
    use super::super::propose;

    /// A motor's log whose clock counts the steps of a loop, 40 and 41 of them a row.
    fn steps(name: &str, motion: &[&str], factor: f64) -> super::super::Proposal {
        let row = |k: u32| {
            let ticks = 15_000.0 + (40.5 * f64::from(k)).floor();
            let angle = 4.0 * (5.0 * ticks / 8000.0).sin();
            let speed = factor * 20.0 * (5.0 * ticks / 8000.0).cos();
            let drive = 3.0 * (5.0 * ticks / 8000.0 + 0.4).cos();
            if motion.len() == 2 { vec![ticks, drive, angle, speed] } else { vec![ticks, drive, angle] }
        };
        let names: Vec<String> = [name, "voltage"].iter().chain(motion).map(|name| (*name).into()).collect();
        propose(&names, &(0..200).map(row).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_count_of_time_steps_is_read_as_so_many_a_second_as_the_motion_or_its_name_tells() {
        let both = ["position [rad]", "velocity [rad/s]"];
        for (name, motion, unit, said) in [
            ("timestep (8Hz)", &both[..], "s/8000", "the change of the angle, and not 8, as it says"),
            ("timestep", &both[..], "s/8000", "by which the speed is the change of the angle; put"),
            (
                "timestep",
                &["position", "velocity"][..],
                "s/8000",
                "is taken for a count of 8000 steps a second",
            ),
            ("timestep (8 kHz)", &both[..1], "s/8000", "as it says itself"),
            ("timestep", &both[..1], "ms", "nothing tells the unit of \"timestep\""),
            ("timestep (8Hz)", &both[..1], "ms", "\"8Hz\" of the column"),
        ] {
            let proposal = steps(name, motion, 1.0);
            assert!(proposal.map.starts_with(&format!("time={name}:{unit},")), "{}", proposal.map);
            assert!(proposal.assumptions().contains(said), "{}", proposal.assumptions());
        }
        // No timer counts so many.
        assert!(steps("timestep", &both, 0.73).map.starts_with("time=timestep:ms,"));
    }

    #[test]
    fn a_time_step_of_one_a_row_is_the_number_of_the_row() {
        let row = |k: u32| vec![f64::from(k), (0.1 * f64::from(k)).sin(), (0.1 * f64::from(k)).cos()];
        let names = ["timestep", "voltage", "position"].map(str::to_owned);
        let proposal = propose(&names, &(0..100).map(row).collect::<Vec<_>>()).unwrap();
        assert!(proposal.map.starts_with("voltage=") && proposal.rate.is_some(), "{}", proposal.map);
    }
}
