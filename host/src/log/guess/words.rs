//! What the names of columns say: a quantity, a unit, or that the column is a command and no measurement.

use super::super::units::Quantity;
pub(super) use super::spelling::bracketed;
pub(in crate::log) use super::spelling::of;
use super::unit_names::{PER, UNITS, rate_in, unit_named};
use super::vocabulary::{
    ACTION, CLOCKS, COMMANDED, EFFORT, ERROR_ENDS, GYROSCOPE, LINEAR, OF_A_VELOCITY, RATES, READINGS,
    REGISTERS, ROWS, SCALES, SENSED, TARGETS, TELL_TURNS, TERMS, TIME_STEPS, TORQUES, TURNING, TURNS, WANTED,
    WORDS,
};

use Quantity::{Angle, Current, Duty, Interval, Speed, Supply, Time, Voltage};

/// What the name of one column says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Said {
    /// The quantity it names, and how plainly (higher is plainer).
    pub quantity: Option<(Quantity, u8)>,
    /// Its unit as `--map` writes it.
    pub unit: Option<&'static str>,
    /// The unit stands there in so many words: `t_ms`, `rpm`, `Angle [deg]`; `enc` only suggests one.
    pub told: bool,
    /// It is what somebody wanted, a setpoint or an error: never a measurement.
    pub wanted: bool,
    /// What the unit in the name measures, whether it fits what else the name says or not: `encoder_V`; or a word that is one: `RPM_left`.
    pub unit_of: Option<Quantity>,
    /// It is where a servo was told to go.
    pub target: bool,
    /// It is a register of a servo.
    pub register: bool,
    /// It is what was counted since the row before.
    pub since_before: bool,
    /// What a number is divided by to be of that unit, as `--map` writes it: `rpm_x10`.
    pub scale: Option<&'static str>,
    /// It is an effort, which robots' messages have as a torque and drives as whatever they are commanded.
    pub effort: bool,
}

/// Whether a name is that of a gyroscope's axis.
pub fn is_gyroscope(name: &str) -> bool {
    of(name).iter().any(|word| GYROSCOPE.contains(&word.as_str()))
}

/// Whether a name is that of a time.
pub fn is_time(name: &str) -> bool {
    said(name).quantity.is_some_and(|(of, _)| of == Time)
}

/// Whether a name is that of a count of steps, which tells the time in a unit of its own.
pub(super) fn is_time_step(name: &str) -> bool {
    of(name).iter().any(|word| TIME_STEPS.contains(&word.as_str()))
}

/// Whether a name is that of the time since the row before.
pub fn is_interval(name: &str) -> bool {
    said(name).quantity.is_some_and(|(of, _)| of == Interval)
}

/// Whether the words of a name say that it is an error.
fn is_error(words: &[String]) -> bool {
    words.iter().any(|word| ERROR_ENDS.iter().any(|end| word.ends_with(end)))
}

/// Whether a name is that of a torque, which follows from a motor's current, whoever commanded it.
pub(super) fn is_torque(name: &str) -> bool {
    of(name).iter().any(|word| TORQUES.contains(&word.as_str()))
}

/// Whether the words of a name are of how many readings there were (`sample_count`, `samples_consumed`): no motion, and nothing that drives one.
pub(super) fn counts_readings(words: &[String]) -> bool {
    let ends = ["count", "consumed", "read", "received", "sent"];
    words.windows(2).any(|pair| READINGS.contains(&pair[0].as_str()) && ends.contains(&pair[1].as_str()))
}

/// Whether a name says that its column drives nothing, whatever its numbers are: a clock, an error, a controller's term, what a sensor tells.
pub(super) fn drives_nothing(name: &str) -> bool {
    let is_time = said(name).quantity.is_some_and(|(of, _)| matches!(of, Time | Interval));
    let words = of(name);
    let any_of = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    is_time || is_error(&words) || any_of(&TERMS) || any_of(&SENSED)
}

/// Reads a name: `Time (s)`, `t_ms`, `leftSpeed`, `motor.position [deg]`, `goal_position`, `speed_rpm_x10`.
pub fn said(name: &str) -> Said {
    let lower = name.to_lowercase();
    let scaled = |(end, scale)| Some((lower.strip_suffix(end)?.strip_suffix(['_', ' '])?.len(), scale));
    if let Some((bare, scale)) = SCALES.into_iter().find_map(scaled) {
        let plain = said(&name[..bare]);
        return Said { scale: plain.quantity.map(|_| scale), ..plain };
    }
    let (mut bare, bracket) = bracketed(name);
    if bracket.as_deref().is_some_and(|inside| unit_named(inside).is_none()) {
        // No unit: `ex_signal(u)`.
        name.trim().clone_into(&mut bare);
    }
    let lower = bare.to_lowercase();
    let words = of(&bare);
    // `PositionRotations`, `velocityRadPerSec`.
    let snake = words.join("_");
    let unit = bracket.as_deref().and_then(unit_named).or_else(|| rate_in(&lower)).or_else(|| rate_in(&snake)).or_else(|| {
        // The longest unit that ends the name behind an underscore or a blank.
        let ends = UNITS.iter().filter(|(text, ..)| {
            // `theta_m` is a motor's angle, `position_m` a way.
            (*text != "m" || words.iter().any(|word| LINEAR.contains(&word.as_str())))
                // `pwm_min` is the least of all, `carriage_h` a height.
                && (!["min", "h", "d", "day", "days", "cs"].contains(text) || words.iter().any(|word| CLOCKS.contains(&word.as_str())))
                && [&lower, &snake].iter().any(|name| {
                    // `ms` is the name of a time, `v` perhaps that of a speed.
                    let ends = |before: &str| {
                        before.is_empty() && text.chars().count() > 1 || before.ends_with(['_', ' ', '-', '.'])
                    };
                    name.strip_suffix(text).is_some_and(|before| ends(before) && !before.ends_with(PER))
                })
        });
        ends.max_by_key(|(text, ..)| text.len()).map(|(_, quantity, unit)| (*quantity, *unit))
    });
    let unit_of = unit.map(|(of, _)| of);
    let any_of = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let effort = any_of(&[EFFORT]) || any_of(&TORQUES);
    let is_made = any_of(&WANTED) || is_error(&words);
    let wanted = any_of(&TARGETS) || is_made;
    // A torque that was wanted is no place to go to.
    let target = !effort && (any_of(&TARGETS) || any_of(&[ACTION]));
    let mut best: Option<(Quantity, u8, Option<&'static str>)> = None;
    for (quantity, plain, implied, list) in WORDS {
        let here = words.iter().any(|word| list.contains(&word.as_str())) || list.contains(&lower.as_str());
        // A word that tells the unit too is plainer than another of the same quantity.
        let plainer = |(of, before, told): (Quantity, u8, Option<&str>)| {
            plain > before || plain == before && of == quantity && told.is_none() && implied.is_some()
        };
        if here && best.is_none_or(plainer) {
            best = Some((quantity, plain, implied));
        }
    }
    // The clock of one signal among several: `speed.Time`.
    if lower.rsplit_once('.').is_some_and(|(_, field)| ["time", "timestamp"].contains(&field)) {
        best = Some((Time, 3, None));
    }
    // Neither the voltage nor the current along the q axis is a joint's position q.
    if let Some((Angle, ..)) = best
        && any_of(&["q"])
    {
        if any_of(&["v", "u", "voltage", "volts"]) {
            best = Some((Voltage, 5, None));
        } else if any_of(&["i", "current", "curr"]) {
            best = Some((Current, 3, None));
        }
    }
    // A torque that was commanded is no duty: `tau_cmd`.
    if any_of(&TORQUES) && best.is_some_and(|(of, ..)| matches!(of, Duty | Voltage)) {
        best = None;
    }
    // What changes an angle is a speed: `theta_dot`, `angle_rate`.
    if let Some((Angle, plain, implied)) = best
        && any_of(&RATES)
    {
        best = Some((Speed, plain, implied.filter(|unit| *unit == "counts")));
    }
    // A velocity of rotation is neither a voltage nor turns: `v_rot`, `v [m/s]`.
    let is_velocity = any_of(&["v"])
        && best.is_some_and(|(of, plain, _)| of == Voltage && plain == 2)
        && match unit {
            None | Some((Angle, _)) => any_of(&OF_A_VELOCITY),
            Some((of, _)) => of == Speed,
        };
    if is_velocity {
        best = Some((Speed, 4, None));
    }
    let unit = unit.filter(|(of, _)| !is_velocity || *of == Speed);
    // What an encoder counted since the row before is no angle.
    let per_row = words.windows(2).any(|pair| pair[0] == "per" && ROWS.contains(&pair[1].as_str()));
    let since_before = (per_row || any_of(&["delta", "diff", "increment", "increments"]))
        && unit.is_none_or(|(_, unit)| unit == "counts")
        && best.is_none_or(|(of, ..)| of == Angle);
    let unit = unit.filter(|_| !since_before);
    if since_before || best.is_some_and(|(of, ..)| of == Angle) && counts_readings(&words) {
        best = None;
    }
    // The motion of what is driven, as the sensor saw it.
    if let Some((Angle | Speed, plain, _)) = &mut best {
        *plain += u8::from(any_of(&["wheel", "joint", "gearbox", "load", "output", "raw"]));
        *plain = plain
            .saturating_sub(u8::from(any_of(&["filtered", "filt", "smooth", "smoothed", "avg", "mean"])));
        // Of several readings the mean is the motion, rather than one at their ends.
        let is_end = words.first().is_some_and(|word| ["max", "min"].contains(&word.as_str()));
        *plain = plain.saturating_sub(2 * u8::from(is_end));
    }
    // The voltage and the current along the d axis of a field-oriented drive turn nothing.
    if best.is_some_and(|(of, ..)| matches!(of, Voltage | Current)) && any_of(&["d", "vd", "ud", "id"]) {
        best = None;
    }
    // What a converter counts is no volt.
    if best.is_some_and(|(of, ..)| matches!(of, Voltage | Supply | Current))
        && any_of(&["adc"])
        && unit.is_none()
    {
        best = None;
    }
    // A unit in so many words decides between quantities: `motor (rpm)`, `t_ms`, `velocity [V]` is none.
    let quantity = match (best, unit) {
        (Some((Supply, plain, _)), Some((Voltage, _))) => Some((Supply, plain)),
        (Some((Interval, plain, _)), Some((Time, _))) => Some((Interval, plain)),
        (Some((Duty, _, _)), Some((Voltage, _))) => Some((Voltage, 4)),
        // The shaft behind the gear: `out_deg`.
        (Some((Duty, ..)), Some((of @ (Angle | Speed), _))) if any_of(&["out", "output"]) => Some((of, 4)),
        (Some((named, plain, _)), Some((of, _))) if named == of => Some((named, plain + 2)),
        // A potentiometer's or a tachometer's volts.
        (Some((Angle | Speed, ..)), Some((Voltage, _))) => None,
        // A current one, in degrees.
        (Some((Current, ..)), Some((Angle | Speed, _))) => None,
        // The time of a rate names none: `deg_per_sec`.
        (Some((Angle | Time, ..)), Some((Speed, _))) => Some((Speed, 5)),
        // The number of a row that is one of milliseconds: `i_ms`; an `i_s` is a source's current.
        (Some((Current, ..)), Some((Time, short))) if ["ms", "us", "ns"].contains(&short) => Some((Time, 2)),
        // The ticks of a clock: `ticks_ms`.
        (Some((Angle, ..)), Some((Time, _))) => Some((Time, 4)),
        (Some((named, plain, _)), Some(_)) => Some((named, plain)),
        (Some((named, plain, _)), None) => Some((named, plain)),
        (None, Some((of, _))) => Some((of, 2)),
        (None, None) => None,
    };
    let unit = unit.filter(|(of, _)| {
        quantity.is_some_and(|(q, _)| {
            q == *of || (q == Supply && *of == Voltage) || (q == Interval && *of == Time)
        })
    });
    let implied =
        best.and_then(|(of, _, implied)| implied.filter(|_| quantity.is_some_and(|(q, _)| q == of)));
    // "speed" of "encoder counts" counts per second.
    let implied = match (quantity, implied) {
        (Some((Speed, _)), Some("counts")) => Some("counts/s"),
        (_, implied) => implied,
    };
    // What is counted may be anything, and any way may be metres.
    let unit_of =
        unit_of.or(implied.filter(|unit| !["counts", "m"].contains(unit)).and(quantity).map(|(of, _)| of));
    // Names of the unit itself, and not of what is usually measured in it.
    const SUGGESTED: [&str; 3] = ["counts", "counts/s", "m"];
    let by_itself = implied.is_some_and(|unit| !SUGGESTED.contains(&unit)) && !any_of(&TURNING);
    let told = unit.is_some() || by_itself;
    let in_turns = any_of(&TELL_TURNS) || TURNS.iter().any(|end| snake.ends_with(end));
    let implied = implied.or(match quantity {
        Some((Angle, _)) if in_turns => Some("rev"),
        Some((Speed, _)) if in_turns => Some("rev/s"),
        _ => None,
    });
    // The shaft at the input of a gear moves, and is not told to.
    let commanded = matches!(quantity, Some((Angle | Speed, _)))
        && any_of(&COMMANDED)
        && !any_of(&["shaft", "encoder", "enc", "counts", "ticks"]);
    let (wanted, target) = (wanted || commanded, target || commanded);
    // A voltage or a duty that was commanded drives the motor, where none was measured.
    let drives =
        matches!(quantity, Some((Voltage | Duty, plain)) if plain >= 3) && !is_made && !any_of(&REGISTERS);
    let asked = drives && wanted || matches!(quantity, Some((Voltage, _))) && any_of(&COMMANDED[..3]);
    let quantity = quantity.map(|(of, plain)| if asked { (of, 1) } else { (of, plain) });
    let (wanted, target) = (wanted && !drives, target && !drives);
    let register = any_of(&REGISTERS);
    Said {
        quantity,
        unit: unit.map(|(_, unit)| unit).or(implied),
        told,
        unit_of,
        wanted,
        target,
        register,
        since_before,
        scale: None,
        effort,
    }
}

/// The unit that a name says in so many words, and of what it is one.
pub fn told(name: &str) -> Option<(Quantity, &'static str)> {
    let said = said(name);
    let of = match said.quantity?.0 {
        Supply => Voltage,
        Interval => Time,
        of => of,
    };
    said.unit.filter(|_| said.told && said.scale.is_none()).map(|unit| (of, unit))
}
