//! Which column is what, and in which unit: by its name, and by its values where the name leaves it open.

use super::clocks::{self, FEWEST_TICKS, is_below_a_second, is_clock, stands_beside_a_clock};
use super::column_units::{unit_of, unit_of_wrap};
use super::one_motion::{pairs_of, ratio};
use super::ranges::Range;
use super::settle::settle;
use super::turns::Turn;
use super::{companions, drive, duty_range, leads, registers, since_before, words};
use crate::log::numbered::{counts_rows, numbers_rows};
use crate::log::sample::numbers;
use crate::log::units::Quantity;

/// What most gyroscopes read at most, 2000 deg/s, in rad/s: larger numbers are degrees.
const FASTEST_GYROSCOPE: f64 = 35.0;

/// One column of the proposal.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// What it measures.
    pub quantity: Quantity,
    /// Its place, from 0.
    pub index: usize,
    /// Of a time in two columns, the place of the one that adds the fraction of a second, whose unit `unit` is; of the two sides of a
    /// bridge, that of the one to be taken off.
    pub rest: Option<usize>,
    /// Its unit as `--map` writes it.
    pub unit: String,
    /// Neither a name nor the values tell the unit.
    pub guessed: bool,
    /// Of an angle in counts, those of a turn by the speed beside it.
    pub turn: Option<Turn>,
}

impl Part {
    /// What stands between its two columns: a fraction is added, a bridge's other side is taken off.
    pub fn sign(&self) -> char {
        if self.quantity == Quantity::Time { '+' } else { '-' }
    }
}

/// The column for each quantity, in the order of [`Quantity::ALL`].
pub fn parts(names: &[String], rows: &[Vec<f64>]) -> Vec<Part> {
    let mut said: Vec<words::Said> = names.iter().map(|name| words::said(name)).collect();
    companions::tell(&mut said, names);
    tell_turns(&mut said, names);
    since_before::tell(&mut said, rows);
    // What has fractions counts nothing.
    for (index, said) in said.iter_mut().enumerate().filter(|(_, said)| said.unit == Some("counts")) {
        if numbers(rows, index).any(|value| value.fract() != 0.0) {
            (said.unit, said.told) = (None, false);
        }
    }
    let quantities = quantities(names, &said, rows);
    let mut parts = plainest(names, &said, rows, &quantities);
    settle(&mut parts, names, &said, rows, &quantities);
    parts
}

/// What each column may measure, and how plainly its name says so.
fn quantities(names: &[String], said: &[words::Said], rows: &[Vec<f64>]) -> Vec<Option<(Quantity, u8)>> {
    let values = |index: usize| numbers(rows, index);
    let useful = |index: usize| rows.is_empty() || values(index).next().is_some();
    let mut quantities: Vec<Option<(Quantity, u8)>> = said
        .iter()
        .enumerate()
        .map(|(index, said)| said.quantity.filter(|_| !said.wanted && useful(index)))
        .collect();
    let clocks = quantities.iter().filter(|q| q.is_some_and(|(q, _)| q == Quantity::Time)).count();
    // A voltage that hardly changes beside a duty or a target is the supply's; whole numbers far beyond any supply are a duty.
    // Beside a torque one that changes even less is too: a drive that is told a torque logs what it is fed with.
    let driven = quantities.iter().any(|q| q.is_some_and(|(q, _)| q == Quantity::Duty))
        || said.iter().any(|said| said.target);
    let steady = match driven {
        true => 0.4,
        false if said.iter().any(|said| said.effort) => 0.1,
        false => 0.0,
    };
    for (index, guess) in quantities.iter_mut().enumerate() {
        let Some((quantity, plain)) = *guess else { continue };
        // `i` may be the number of a row.
        if quantity == Quantity::Current && numbers_rows(&names[index], &values(index).collect::<Vec<_>>()) {
            *guess = None;
            continue;
        }
        let counts = || counts_rows(&values(index).collect::<Vec<_>>()) && rows.len() >= FEWEST_TICKS;
        if quantity == Quantity::Time && words::is_time_step(&names[index]) && counts() {
            *guess = None;
            continue;
        }
        let range = Range::of(values(index));
        // Times that stay within those of a servo's pulses are its pulses, and no clock, where they fall or, in us, stand beside one.
        let is_no_clock = || falls(values(index)) || said[index].unit == Some("us") && clocks > 1;
        if quantity == Quantity::Time && range.pulse_of_no_duty().is_some() && is_no_clock() {
            *guess = Some((Quantity::Duty, plain));
            continue;
        }
        // `v` beside `v_ref` is what was reached of it.
        let is_of = |target: &str| {
            let (own, target) = (names[index].to_lowercase(), target.to_lowercase());
            own.chars().count() == 1
                && [format!("{own}_"), format!("{own}ref")].iter().any(|of| target.starts_with(of))
        };
        if quantity == Quantity::Voltage
            && names.iter().zip(said).any(|(name, said)| said.target && is_of(name))
        {
            *guess = None;
            continue;
        }
        if said[index].unit == Some("counts") && is_level(rows.len(), &range) {
            *guess = None;
            continue;
        }
        // The pins of a bridge: one that is high drives the motor one way.
        let is_pin = range.whole && range.low == 0.0 && range.high == 1.0 && said[index].unit.is_none();
        // One that is on or off lets another one drive the motor.
        if quantity == Quantity::Duty && is_pin && words::of(&names[index]) == ["en"] {
            *guess = None;
        } else if quantity == Quantity::Voltage && plain == 2 && is_pin {
            *guess = Some((Quantity::Direction, 1));
        } else if quantity == Quantity::Voltage {
            if range.low > 0.0 && range.high - range.low < steady * range.high {
                *guess = Some((Quantity::Supply, plain));
            } else if range.whole
                && range.peak() > 60.0
                && said[index].unit.is_none()
                && said[index].scale.is_none()
                && !drive::are_millivolts(&range)
            {
                *guess = Some((Quantity::Duty, plain));
            }
        } else if quantity == Quantity::Duty
            && plain == 2
            && !range.whole
            && range.peak() > 1.0
            && range.peak() <= 60.0
        {
            // "command", "output": in volts by its size, and less plainly than what was measured.
            *guess = Some((Quantity::Voltage, 1));
        }
    }
    // What always rises is a clock, whatever it is called: `elapsed`.
    for (index, guess) in quantities.iter_mut().enumerate() {
        let rises = || rows.len() > 3 && rows.windows(2).all(|w| w[1].get(index) > w[0].get(index));
        if let Some((Quantity::Interval, plain)) = *guess
            && rises()
        {
            *guess = Some((Quantity::Time, plain));
        }
    }
    tell_speed_from_voltage(&mut quantities, names, said, rows);
    keep_one_axis(&mut quantities, names, &values);
    let is_timed = |q: &Option<(Quantity, u8)>| {
        q.is_some_and(|(q, _)| [Quantity::Time, Quantity::Interval].contains(&q))
    };
    if !quantities.iter().any(is_timed) {
        let unnamed =
            |k: &usize| said[*k].quantity.is_none() && !said[*k].wanted && is_clock(&names[*k], rows, *k);
        if let Some(clock) = (0..names.len()).find(unnamed) {
            quantities[clock] = Some((Quantity::Time, 1));
        }
    }
    let drives =
        |q: &Option<(Quantity, u8)>| q.is_some_and(|(q, _)| [Quantity::Voltage, Quantity::Duty].contains(&q));
    if !quantities.iter().any(drives) {
        // What a servo was told is what drives it, where nothing nearer to the motor was logged.
        for (guess, said) in quantities.iter_mut().zip(said) {
            if said.target && said.quantity.is_none_or(|(q, _)| q == Quantity::Angle) {
                *guess = Some((Quantity::Target, 1));
            }
        }
        leave_out_unreached_targets(&mut quantities, said, &values);
    }
    quantities
}

/// For each quantity the column that says it most plainly, in its unit.
fn plainest(
    names: &[String],
    said: &[words::Said],
    rows: &[Vec<f64>],
    quantities: &[Option<(Quantity, u8)>],
) -> Vec<Part> {
    let values = |index: usize| numbers(rows, index);
    let clocks_beside = |own: usize| {
        let is_one = |k: usize| {
            quantities[k].is_some_and(|(q, _)| q == Quantity::Time)
                && !is_below_a_second(said[k].unit, values(k))
        };
        (0..names.len()).filter(|k| *k != own && is_one(*k)).map(values).collect::<Vec<_>>()
    };
    let words_of_all = names.join(" ").to_lowercase();
    let mut parts: Vec<Part> = Vec::new();
    for quantity in Quantity::ALL {
        // The plainest name; of equals the first, which moves.
        let candidates = quantities.iter().enumerate().filter_map(|(index, guess)| {
            let (_, plain) = guess.filter(|(q, _)| *q == quantity)?;
            let range = Range::of(values(index));
            let moves = rows.is_empty() || range.high > range.low;
            let is_clock = quantity == Quantity::Time
                && !is_below_a_second(said[index].unit, values(index))
                && !stands_beside_a_clock(values(index), clocks_beside(index));
            // Whole turns are the coarse part of the angle that stands beside them.
            let is_coarse = quantity == Quantity::Angle && said[index].unit == Some("rev") && range.whole;
            Some((index, (moves || quantity == Quantity::Supply, is_clock, !is_coarse, plain)))
        });
        let best = candidates.max_by_key(|&(index, rank)| (rank, std::cmp::Reverse(index)));
        let Some((index, _)) = best else { continue };
        let all: Vec<f64> = values(index).collect();
        let register = said[index].register.then(|| registers::unit(quantity, &all, &words_of_all)).flatten();
        let in_degrees = quantity == Quantity::Speed
            && said[index].unit.is_none()
            && words::is_gyroscope(&names[index])
            && Range::of(all.iter().copied()).peak() > FASTEST_GYROSCOPE;
        let register = register.or(in_degrees.then_some("deg/s"));
        let unit = register.map_or_else(|| unit_of(quantity, said[index].unit, &all), str::to_owned);
        let by_bracket = (quantity == Quantity::Duty).then(|| duty_range::told(&names[index])).flatten();
        let by_bracket = by_bracket.filter(|full| f64::from(*full) >= Range::of(all.iter().copied()).peak());
        let unit = by_bracket.map_or(unit, |full| full.to_string());
        let unit = unit + said[index].scale.unwrap_or_default();
        let unit = clocks::plausible(quantity, &unit, &all).map_or(unit, str::to_owned);
        let told = said[index].unit.is_some()
            || said[index].register
            || by_bracket.is_some()
            || unit_of_wrap(&all).is_some();
        let of_time = || quantity == Quantity::Time && clocks::is_open_time(&unit, &all);
        let is_open = [Quantity::Duty, Quantity::Angle, Quantity::Speed].contains(&quantity)
            || quantity == Quantity::Current && unit == "mA";
        let guessed = !told && (is_open || of_time());
        parts.push(Part { quantity, index, rest: None, unit, guessed, turn: None });
    }
    parts
}

/// Whether values go down on their way.
fn falls(values: impl Iterator<Item = f64> + Clone) -> bool {
    values.clone().zip(values.skip(1)).any(|(before, after)| after < before)
}

/// Whether a column that is called one of counts holds an encoder's levels, which are high or low and count nothing. One that is 0 in every
/// row is a count that never moved.
pub(super) fn is_level(rows: usize, range: &Range) -> bool {
    rows >= FEWEST_TICKS && range.whole && range.low == 0.0 && range.high == 1.0
}

/// Of a gyroscope's axes the one that moves most may be the motor's, where no other motion was logged.
fn keep_one_axis<V: Iterator<Item = f64>>(
    quantities: &mut [Option<(Quantity, u8)>],
    names: &[String],
    values: &impl Fn(usize) -> V,
) {
    let is_motion =
        |k: &usize| quantities[*k].is_some_and(|(q, _)| [Quantity::Angle, Quantity::Speed].contains(&q));
    let (axes, others): (Vec<usize>, Vec<usize>) =
        (0..names.len()).filter(is_motion).partition(|k| words::is_gyroscope(&names[*k]));
    let span = |k: usize| {
        let range = Range::of(values(k));
        range.high - range.low
    };
    let most =
        axes.iter().copied().filter(|_| others.is_empty()).max_by(|a, b| span(*a).total_cmp(&span(*b)));
    axes.into_iter().filter(|k| Some(*k) != most).for_each(|k| quantities[k] = None);
}

/// A target is where the angle goes: of one that most angles lie far beyond it is none, but what drives the motor, or of another axis.
const MOST_BEYOND: f64 = 0.5;

/// Takes targets back that the first angle does not keep to, where no name says that they are in different units.
fn leave_out_unreached_targets<V: Iterator<Item = f64>>(
    quantities: &mut [Option<(Quantity, u8)>],
    said: &[words::Said],
    values: &impl Fn(usize) -> V,
) {
    let is = |k: usize, wanted: Quantity| quantities[k].is_some_and(|(q, _)| q == wanted);
    let Some(angle) = (0..quantities.len()).find(|k| is(*k, Quantity::Angle)) else { return };
    let angles: Vec<f64> = values(angle).collect();
    let is_unreached = |k: &usize| {
        let range = Range::of(values(*k));
        let reach = range.high - range.low;
        let beyond = |x: &&f64| **x > range.high + reach || **x < range.low - reach;
        let beyond = angles.iter().filter(beyond).count() as f64;
        let in_units = said[*k].told || said[angle].told;
        is(*k, Quantity::Target) && !in_units && reach > 0.0 && beyond > MOST_BEYOND * angles.len() as f64
    };
    let unreached: Vec<usize> = (0..quantities.len()).filter(is_unreached).collect();
    unreached.into_iter().for_each(|k| quantities[k] = None);
}

/// A bare `v` is a voltage, or the speed of the angle beside it: then it is its change, in some unit of both.
fn tell_speed_from_voltage(
    quantities: &mut [Option<(Quantity, u8)>],
    names: &[String],
    said: &[words::Said],
    rows: &[Vec<f64>],
) {
    let place = |wanted: Quantity| quantities.iter().position(|q| q.is_some_and(|(q, _)| q == wanted));
    let v = (0..names.len()).find(|k| {
        words::of(&names[*k]) == ["v"]
            && said[*k].unit.is_none()
            && quantities[*k].is_some_and(|(q, _)| q == Quantity::Voltage)
    });
    let (Some(v), Some(angle), Some(clock)) = (v, place(Quantity::Angle), place(Quantity::Time)) else {
        return;
    };
    let is_whole = |row: &&Vec<f64>| {
        [v, angle, clock].iter().all(|k| row.get(*k).is_some_and(|value| value.is_finite()))
    };
    let whole: Vec<&Vec<f64>> = rows.iter().filter(is_whole).collect();
    let of = |k: usize| whole.iter().map(|row| row[k]).collect::<Vec<f64>>();
    let part = |(quantity, index): (Quantity, usize)| {
        let unit = unit_of(quantity, said[index].unit, &of(index));
        Part { quantity, index, rest: None, unit, guessed: true, turn: None }
    };
    let parts = [(Quantity::Time, clock), (Quantity::Angle, angle), (Quantity::Speed, v)].map(part);
    let in_units = || ratio(&parts, rows).is_some_and(|(ratio, _)| pairs_of(ratio).next().is_some());
    if whole.len() >= FEWEST_TICKS && leads::is_speed_of(&of(v), &of(angle), Some(&of(clock))) && in_units() {
        quantities[v] = Some((Quantity::Speed, 2));
    }
}

/// moteus logs turns and turns a second, which nothing but the company of its own names says (github.com/mjbots/moteus, reference).
fn tell_turns(said: &mut [words::Said], names: &[String]) {
    let has = |own: &str| names.iter().any(|name| words::of(name).join("_").ends_with(own));
    if !["q_current", "d_current", "position", "velocity", "torque"].into_iter().all(has) {
        return;
    }
    for said in said.iter_mut().filter(|said| said.unit.is_none()) {
        said.unit = match said.quantity {
            Some((Quantity::Angle, _)) => Some("rev"),
            Some((Quantity::Speed, _)) => Some("rev/s"),
            _ => None,
        };
    }
}
