//! What a proposal leaves open and says: units that nothing tells, clocks of which there are two, signs that were given.

use super::clocks::{self, DAYS};
use super::columns::{self, Part};
use super::preview::short;
use super::ranges::Range;
use super::{
    ASSUMED_COUNTS, Proposal, by_numbers, column, duty_range, options_as_if, propose_for, quoted, time_steps,
    unit_names, words, written,
};
use crate::log::motion;
use crate::log::sample::{Sample, numbers};
use crate::log::samples::FEWEST_SAMPLES;
use crate::log::steady_states::{FAR_APART_S, are_steady_states};
use crate::log::timing;
use crate::log::units::Quantity;

/// What is said of a duty, a voltage or a motion whose numbers got the signs that their type took away.
pub(super) fn given_sign(sample: &Sample, part: &Part) -> Option<String> {
    let (_, width) = sample.signed.iter().find(|(column, _)| *column == part.index)?;
    if part.quantity == Quantity::Time {
        return None;
    }
    let name = &sample.names.get(part.index)?;
    let (minus_one, column) = (width - 1.0, column(&sample.names, part.index));
    let otherwise = match part.quantity {
        Quantity::Duty => format!("; where it is full duty, write duty={column}:{minus_one}"),
        _ => String::new(),
    };
    Some(format!("{minus_one} in \"{name}\" is read as -1{otherwise}"))
}

/// What is said of a table in which the drive is another in each row and the speed goes with it, and which has no clock, or one whose rows are
/// far apart or in a unit that nothing tells.
pub(super) fn steady_states(sample: &Sample, parts: &[Part]) -> Option<String> {
    let of = |wanted: &[Quantity]| parts.iter().find(|part| wanted.contains(&part.quantity));
    let drive = of(&[Quantity::Voltage, Quantity::Duty]).filter(|part| part.rest.is_none())?;
    let speed = of(&[Quantity::Speed])?;
    let both = |row: &Vec<f64>| Some((*row.get(drive.index)?, *row.get(speed.index)?));
    let (volts, speeds): (Vec<f64>, Vec<f64>) = sample.rows.iter().filter_map(both).unzip();
    let clock = of(&[Quantity::Time, Quantity::Interval]);
    let is_fast = |clock: &Part| {
        let values: Vec<f64> = numbers(&sample.rows, clock.index).collect();
        let interval = clocks::interval(clock.quantity, &clock.unit, &values);
        clock.rest.is_some() || !clock.guessed && interval.is_none_or(|(_, in_s)| in_s < FAR_APART_S)
    };
    let is_timed = clock.map_or(sample.stamped, is_fast);
    (!is_timed && are_steady_states(&volts, &speeds)).then(|| {
        let by = if clock.is_some() { "clock" } else { "--rate" };
        let name = |part: &Part| sample.names.get(part.index).cloned().unwrap_or(part.index.to_string());
        format!(
            "\"{}\" is another in every row and \"{}\" goes with it: where each row is the speed that a level settled at, these are steady states, \
             which tell gain and friction and no time constant, and no {by} makes a log of them; log time, drive and motion while it moves",
            name(drive),
            name(speed)
        )
    })
}

/// The same in the place of a proposal, which would make a log of them when pasted: the rate is left to whoever knows one.
pub(in crate::log) fn steady_question(sample: &Sample, proposal: &Proposal) -> Option<String> {
    let parts = columns::parts(&sample.with_units, &sample.rows);
    let said = steady_states(sample, &parts).filter(|_| sample.rate_hz().is_none())?;
    let rows = sample.rows.len();
    if rows < FEWEST_SAMPLES {
        return Some(format!("{said} ({rows} rows are too few for a fit besides)"));
    }
    // Without a clock.
    let rate = proposal.rate.as_ref().map(|_| "N".to_owned());
    let mut all_the_same = Proposal { rate, ..proposal.clone() };
    all_the_same.unknown_units.retain(|text| *text != said);
    Some(format!(
        "{said}; where the rows are instants of one motion all the same, say {}",
        all_the_same.told()
    ))
}

/// More columns than this are not looked at each as if it were a speed.
const MOST_SPEEDS: usize = 8;

/// The same where no column is called a speed, and one of `others` would make such a table as one.
pub(super) fn steady_beside(sample: &Sample, others: &[usize]) -> Option<String> {
    others.iter().take(MOST_SPEEDS).find_map(|&other| {
        let mut called = sample.clone();
        "speed [rad/s]".clone_into(&mut called.with_units[other]);
        steady_question(&called, &propose_for(&called)?)
    })
}

/// What is asked of a duty or voltage that is never negative though it goes with the size of an error that changes its sign: what a
/// controller commanded, without its sign.
pub(super) fn size_of_an_error(sample: &Sample, part: &Part) -> Option<String> {
    let rows = |k: usize| sample.rows.iter().map(move |row| row.get(k).copied().unwrap_or(f64::NAN));
    let size: Vec<f64> = rows(part.index).collect();
    let limit = motion::peak(&size);
    let drives = [Quantity::Duty, Quantity::Voltage].contains(&part.quantity) && part.rest.is_none();
    if !drives || size.iter().any(|value| value.is_nan() || *value < 0.0) {
        return None;
    }
    let said: Vec<words::Said> = sample.names.iter().map(|name| words::said(name)).collect();
    let wanted = (0..said.len()).find(|k| said[*k].target || said[*k].wanted && *k != part.index)?;
    let is_motion = |k: &usize| *k != part.index && *k != wanted && !said[*k].wanted;
    (0..said.len()).filter(is_motion).find_map(|k| {
        // At its limit a command goes with nothing.
        let all = rows(wanted).zip(rows(k)).map(|(wanted, is)| wanted - is).zip(&size);
        let (error, size): (Vec<f64>, Vec<f64>) = all.filter(|(_, size)| **size < limit).unzip();
        let (low, high) = motion::ends(&error);
        let of_error: Vec<f64> = error.iter().map(|e| e.abs()).collect();
        let goes_with = error.len() >= FEWEST_ERRORS && motion::correlation(&of_error, &size) > GOES_WITH;
        (low < -BOTH_SIGNS * high && high > -BOTH_SIGNS * low && goes_with).then(|| {
            let [size, wanted, is] = [part.index, wanted, k].map(|k| &sample.names[k]);
            format!(
                "\"{size}\" is never negative and goes with the size of \"{wanted}\" less \"{is}\", which changes its sign: log it with its sign, \
                 or put a column of directions beside it (direction=COLUMN)"
            )
        })
    })
}

/// The same where the motion is recognised by nothing but that.
pub(in crate::log) fn error_question(sample: &Sample) -> Option<String> {
    let parts = columns::parts(&sample.with_units, &sample.rows);
    let said = parts.iter().find_map(|part| size_of_an_error(sample, part))?;
    Some(format!(
        "{said}; what is taken off there is the motion: --map ...,angle=COLUMN:deg (or rad, counts)"
    ))
}

/// What the size of an error and what a controller commands have in common, and how far the error goes the other way.
const GOES_WITH: f64 = 0.98;
const BOTH_SIGNS: f64 = 0.05;
const FEWEST_ERRORS: usize = 20;

/// What is asked where another column has the clock's name and other times: each signal has its own.
pub(super) fn other_clock(sample: &Sample, parts: &[Part]) -> Option<String> {
    let clock = parts.iter().find(|part| part.quantity == Quantity::Time)?.index;
    let name = sample.names.get(clock)?;
    let times = |k: usize| sample.rows.iter().map(move |row| row.get(k).copied().unwrap_or(f64::NAN));
    let interval = timing::median_interval(&times(clock).collect::<Vec<_>>());
    let furthest = |k: &usize| times(clock).zip(times(*k)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // `speed.Time` is the clock of one signal, and `volts.Time` that of another.
    let field = |name: &str| name.rsplit('.').next().unwrap_or_default().to_lowercase();
    let is_clock = |k: &usize| {
        let of_another = field(&sample.names[*k]) == field(name) && words::is_time(&sample.names[*k]);
        *k != clock && (sample.names[*k] == *name || of_another)
    };
    let other = (0..sample.names.len()).find(|k| is_clock(k) && furthest(k) > SAME_TIME * interval)?;
    let called = &sample.names[other];
    let is = if called == name {
        format!("is called \"{name}\" too")
    } else {
        format!("is the clock \"{called}\" beside \"{name}\"")
    };
    Some(format!(
        "column {other} {is} and tells other times, up to {:.0} % of an interval apart: where each signal has its own, \
         export them with one column of times",
        100.0 * furthest(&other) / interval
    ))
}

/// Times of one row that are further apart than this share of an interval are two.
const SAME_TIME: f64 = 0.01;

/// What is asked where a name tells a unit, as in `speed (furlongs)` or `speed [%]`, that is none of those known of such a quantity, so
/// that the one of `part` stands in its place.
pub(super) fn unknown_unit(name: &str, part: &Part) -> Option<String> {
    let taken = &part.unit;
    let of_another = |unit: &str| {
        [Quantity::Angle, Quantity::Speed].contains(&part.quantity)
            && unit_names::unit_named(unit).is_some_and(|(of, _)| of != part.quantity)
    };
    // `PWM (0-255)` tells its full duty.
    let is_full = part.quantity == Quantity::Duty && duty_range::told(name).is_some();
    // How often a clock steps is no unit, and was understood.
    if part.quantity == Quantity::Time && time_steps::said_of_ticks(name, part).is_some() {
        return None;
    }
    // MATLAB's `ans(2)` and NumPy's `data[1]` are places.
    let is_place = |unit: &str| part.quantity != Quantity::Duty && unit.bytes().all(|b| b.is_ascii_digit());
    // `pwm []` tells none.
    let is_told = |unit: &str| !unit.is_empty() && !is_full && !is_place(unit);
    let unknown = |unit: &String| is_told(unit) && (!unit_names::is_unit(unit) || of_another(unit));
    let unit = words::bracketed(name).1.filter(unknown)?;
    Some(format!(
        "\"{unit}\" of the column \"{name}\" is no unit that is known here: {taken} stands in its place; put the right one, or its scale ({taken}*1000)"
    ))
}

/// What is said of a time that is taken for days, of a motion that is a gyroscope's, and of a speed without a sign beside a direction.
pub(super) fn taken_for(names: &[String], part: &Part, parts: &[Part], rows: &[Vec<f64>]) -> Option<String> {
    let name = names.get(part.index)?;
    let range = |part: &Part| Range::of(rows.iter().filter_map(|row| row.get(part.index)).copied());
    let unsigned = |part: &Part| part.rest.is_none() && range(part).high > 0.0 && range(part).low >= 0.0;
    let direction = || parts.iter().find(|part| part.quantity == Quantity::Direction);
    let drive = || parts.iter().find(|part| [Quantity::Voltage, Quantity::Duty].contains(&part.quantity));
    match part.quantity {
        Quantity::Time if part.unit == DAYS && words::told(name).is_none() => Some(format!(
            "\"{name}\" is taken for days, as Excel and MATLAB number dates ({DAYS}); if it is none, put s, ms, us or ns in its place"
        )),
        Quantity::Time => time_steps::said_of_ticks(name, part),
        Quantity::Speed if words::is_gyroscope(name) => Some(format!(
            "\"{name}\" is taken for the axis of a gyroscope that turns with the output shaft, because it moves most; take another where it does not"
        )),
        Quantity::Speed if unsigned(part) && direction().is_some() => {
            let direction = names.get(direction()?.index)?;
            Some(if drive().is_some_and(unsigned) {
                format!(
                    "\"{name}\" is never negative, and \"{direction}\" is taken for that of the drive, which a turning motor does not follow at \
                     once: log the speed with its sign, or an angle, if the motor runs both ways"
                )
            } else {
                format!(
                    "\"{name}\" is never negative and gets its sign from \"{direction}\", because what drives the motor has its own"
                )
            })
        }
        _ => None,
    }
}

/// What is asked of a table whose only motion is the levels of an encoder's channels: none where another column counts.
pub(in crate::log) fn levels_question(sample: &Sample) -> Option<String> {
    let values = |k: usize| numbers(&sample.rows, k);
    let range = |k: usize| Range::of(values(k));
    let is_counted = |k: &usize| words::said(&sample.with_units[*k]).unit == Some("counts");
    // One that never moves is neither.
    let moves = |k: &usize| range(*k).high > range(*k).low;
    let (levels, counts): (Vec<usize>, Vec<usize>) = (0..sample.names.len())
        .filter(|k| is_counted(k) && moves(k))
        .partition(|k| columns::is_level(sample.rows.len(), &range(*k)));
    let levels: Vec<String> = levels.into_iter().map(|k| format!("\"{}\"", sample.names[k])).collect();
    (!levels.is_empty() && counts.is_empty()).then(|| {
        format!(
            "{} hold 0 and 1 only, the level of an encoder's channel and no count: count the edges on the board (interrupts, a timer in encoder \
             mode) and log the count, as --map ...,angle=count:counts --counts-per-rev {ASSUMED_COUNTS}",
            levels.join(" and ")
        )
    })
}

/// What is asked of a controller's own log, `setpoint,input,output`: its input is what it measures and its output what it commands, as
/// Arduino's PID library has them, the other way round than those of a motor.
pub(in crate::log) fn loop_question(sample: &Sample) -> Option<String> {
    let called = |word: &str| sample.names.iter().position(|name| words::of(name) == [word]);
    let (input, output) = (called("input")?, called("output")?);
    if !sample.names.iter().any(|name| words::said(name).target) {
        return None;
    }
    let meaning = |motion: &str| options_as_if(sample, &[(input, motion), (output, "duty")]);
    Some(format!(
        "beside a setpoint the input of a controller is what it measures, and its output what it commands: if they are a speed and a duty, say \
         {}, and with the other units where it is none of turns a minute; if they are a position in counts and a duty, {}",
        meaning("speed [rpm]")?,
        meaning("encoder count")?
    ))
}

/// What is asked of a table that an oscilloscope sampled, whose rate is known and whose channels are not.
pub(in crate::log) fn sampled_question(sample: &Sample) -> Option<String> {
    let rate = sample.rate?;
    // The first may number the samples.
    let rises = |k: usize| {
        let at = |row: &Vec<f64>| row.get(k).copied().unwrap_or(f64::NAN);
        sample.rows.windows(2).all(|pair| at(&pair[1]) - at(&pair[0]) == 1.0)
    };
    let mut channels = (0..sample.names.len()).filter(|k| !sample.names[*k].is_empty() && !rises(*k));
    let (volts, speed) = (channels.next()?, channels.next()?);
    let map =
        format!("voltage={}:V,speed={}:rad/s", column(&sample.names, volts), column(&sample.names, speed));
    Some(format!(
        "the file tells its {rate} samples a second; say which channel is what: if \"{}\" is the motor's voltage and \"{}\" its speed, \
         --map {} --rate {rate}, with the speed's own scale (rad/s*104.7 for 1 V at 1000 rpm)",
        sample.names[volts],
        sample.names[speed],
        quoted(&map)
    ))
}

/// What is proposed where no name tells what drives the motor or how it moves, `value` twice over, and the numbers do.
pub(in crate::log) fn numbers_question(sample: &Sample) -> Option<String> {
    let tells = |name: &String| {
        let said = words::said(name);
        said.wanted || said.effort || said.quantity.is_some_and(|(of, _)| of != Quantity::Time)
    };
    let parts = by_numbers::parts(&sample.with_units, &sample.rows);
    let is_named = parts.iter().all(|part| part.index < sample.names.len());
    if parts.is_empty() || !is_named || sample.with_units.iter().any(tells) {
        return None;
    }
    let proposal =
        written(&sample.names, &parts, &sample.rows, sample.stamped).at_the_rate_of(sample, &parts);
    Some(format!(
        "no name tells which column drives the motor and which is its motion; by the course of their numbers alone it looks like {}: compare it \
         with what you know of them",
        proposal.told()
    ))
}

/// What is said of a time whose name tells a unit in which no motor is logged, so that another one was taken.
pub(super) fn other_rate(sample: &Sample, part: &Part) -> Option<String> {
    let said = words::said(sample.with_units.get(part.index)?);
    let told = format!("{}{}", said.unit?, said.scale.unwrap_or_default());
    let values = numbers(&sample.rows, part.index);
    let values: Vec<f64> = values.collect();
    let taken = clocks::plausible(part.quantity, &told, &values).filter(|unit| *unit == part.unit)?;
    let (_, interval_s) = clocks::interval(part.quantity, &told, &values)?;
    Some(format!(
        "\"{}\" tells {told}, in which these would be {:.1e} samples a second: {taken} is proposed, in which they are {}; put the right unit in its \
         place if it is another",
        sample.names[part.index],
        1.0 / interval_s,
        short(1.0 / clocks::interval(part.quantity, taken, &values)?.1)
    ))
}

/// What is said of a unit that nothing tells.
pub(super) fn guessed_unit(name: &str, part: &Part) -> Option<String> {
    let taken = &part.unit;
    let others = match (part.quantity, taken.as_str()) {
        (Quantity::Angle, "rad") => "deg, rev or counts",
        (Quantity::Angle, "deg") => "rad, rev or counts",
        (Quantity::Angle, _) => "rad, deg or rev",
        (Quantity::Time, "s") => "ms, us or ns (or --rate for it, where it numbers the rows)",
        (Quantity::Time, "ms") => "s, us or ns (or --rate for it, where it numbers the rows)",
        (Quantity::Time, _) => "s or ms (or --rate for it, where it numbers the rows)",
        _ => "rpm, deg/s, rev/s, counts/s or (of a linear axis) m/s",
    };
    let of_motion = matches!(part.quantity, Quantity::Angle | Quantity::Speed | Quantity::Time);
    let asked = part.guessed && of_motion && unknown_unit(name, part).is_none();
    let why = match words::said(name).unit {
        Some("counts") => format!("\"{name}\" has fractions, as no count has"),
        _ => format!("nothing tells the unit of \"{name}\""),
    };
    asked.then(|| format!("{why}: {taken} is a guess; put {others} in its place where it is that"))
}
