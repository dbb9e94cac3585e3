//! The usual model of robotics: v = kS sign(w) + kV w + kA w', by ordinary least squares on the logged motion.
//!
//! It is what WPILib's SysId and its relatives fit, and the one to beat on unseen records. The motion's derivatives are
//! averaged over a tenth of a second, or four intervals where these are slow, which is kinder to it than differences. As
//! there, only what moves counts: where the shaft stands or turns round, friction may hold anything.

use std::f64::consts::PI;

use motorlens_shared::effects::Kind;
use nalgebra::{DMatrix, DVector};

use super::Searched;
use crate::compare::free_run::simulated;
use crate::compare::measures::Measures;
use crate::error::{BadInput, Error, Result};
use crate::fit::layout::{BaseValues, REACH, Values};
use crate::fit::search::Problem;
use crate::log::{Record, motion, timing::median_interval};

/// Width of a window, s, and in intervals where these are slow.
const WIDTH_S: f64 = 0.1;
const FEWEST_INTERVALS: usize = 4;
/// Below this share of the highest speed the shaft counts as still.
const STILL: f64 = 0.03;

/// kS, kV and kA in V, V s/rad and V s^2/rad.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gains {
    friction: f64,
    speed: f64,
    acceleration: f64,
}

/// Fits the three numbers to all records.
///
/// # Errors
/// A record that tells nothing, named, so that none is dropped in silence; records that no such motor explains.
pub(crate) fn search(problem: &Problem, records: &[Record]) -> Result<Searched> {
    let mut rows = Vec::new();
    for record in records {
        let own = rows_of(record);
        if own.is_empty() {
            let why = "kS, kV and kA learn nothing from this record: at no time does it turn one way for a tenth of a \
                       second and four samples";
            return Err(BadInput::new(&record.path, why, "leave it out, or use --method fast").into());
        }
        rows.extend(own);
    }
    if !rows.is_empty() && is_one_level(&rows) {
        let path = records.first().map(|r| r.path.clone()).unwrap_or_default();
        let fix = "add records at other voltages, or one in which the motor runs out; or use --method fast";
        // At other voltages it may turn too, and not evenly enough.
        let why = if is_one_voltage(records.iter().flat_map(driven)) { ONE_LEVEL } else { ONE_EVEN_LEVEL };
        return Err(BadInput::new(&path, why, fix).into());
    }
    let Some(k) = gains(&rows) else {
        let path = records.first().map(|r| r.path.clone()).unwrap_or_default();
        let why = "kS, kV and kA cannot be fitted: the voltage does not rise with the speed";
        let fix =
            "change the sign of the voltage if the motor is wired the other way round, or use --method fast";
        return Err(BadInput::new(&path, why, fix).into());
    };
    let base = BaseValues {
        gain: 1.0 / k.speed,
        // A late sensor or a slow log can leave no inertia at all; the model wants some.
        tau_m: (k.acceleration / k.speed).max(1e-3),
        // It knows no winding: the shortest time constant that the model takes.
        tau_e: problem.prior.tau_e.0 * (-REACH * problem.prior.tau_e.1).exp(),
        viscous_share: problem.prior.viscous_share.0,
    };
    let effects = vec![(Kind::Coulomb, vec![k.friction])];
    Ok(Searched { values: Values { base, effects }, history: Vec::new(), evaluations: 0 })
}

/// Why `records` give no kS, kV and kA; none where they do.
pub(crate) fn why_not(problem: &Problem, records: &[Record]) -> Option<String> {
    match search(problem, records) {
        Err(Error::BadInput(fault)) => Some(fault.why),
        _ => None,
    }
}

/// kS-kV-kA fitted to records, once for all who compare with it.
#[derive(Debug, Clone)]
pub struct Usual {
    /// The model.
    pub values: Values,
    /// What it leaves on the records, rms in the measured unit; infinite where it cannot run on them.
    pub rmse: f64,
}

impl Usual {
    /// Of `records` as `problem` lays them out; none where they do not give it.
    pub fn of(problem: &Problem, records: &[Record]) -> Option<Self> {
        let values = search(problem, records).ok()?.values;
        let rmse = simulated(problem, &values).map_or(f64::INFINITY, |left| left.rmse);
        Some(Self { values, rmse })
    }
}

/// What kS-kV-kA fitted to `records` leaves on them, and on those of `unseen`; none where a record does not give it.
pub(crate) fn errors(
    problem: &Problem,
    records: &[Record],
    unseen: Option<&Problem>,
) -> Option<(Measures, Option<Measures>)> {
    let values = search(problem, records).ok()?.values;
    Some((simulated(problem, &values)?, unseen.and_then(|unseen| simulated(unseen, &values))))
}

/// Sign, speed and acceleration, and the voltage, averaged over every window in which `record` turns one way.
///
/// The held voltage, the change of speed and (of an angle) the speed itself are exact on each interval, so that a slow log
/// does no harm; a weight of sin^2 over the window keeps the noise of single differences out.
fn rows_of(record: &Record) -> Vec<([f64; 3], f64)> {
    let t = &record.time_s;
    let way = motion::speed(record);
    let still = STILL * motion::peak(&way);
    let speed = match (&record.angle_rad, &record.speed_rad_s) {
        (None, Some(speed)) => speed.clone(),
        (Some(x), _) => (0..t.len())
            .map(|k| (k.saturating_sub(1), (k + 1).min(t.len() - 1)))
            .map(|(a, b)| (x[b] - x[a]) / (t[b] - t[a]))
            .collect(),
        (None, None) => return Vec::new(),
    };
    let width = ((WIDTH_S / median_interval(t)).round() as usize).max(FEWEST_INTERVALS);
    // The ends of an angle have a difference on one side only.
    let edge = usize::from(record.angle_rad.is_some());
    let starts = (edge..(t.len()).saturating_sub(width + edge)).step_by((width / 4).max(1));
    let row = |from: usize| {
        let one_way = (from..=from + width).all(|k| way[k] * way[from] > 0.0 && way[k].abs() > still);
        let (mut row, mut volts, mut area) = ([0.0; 3], 0.0, 0.0);
        for k in from..from + width {
            let weight = (PI * ((k - from) as f64 + 0.5) / width as f64).sin().powi(2);
            let dt = t[k + 1] - t[k];
            let turned = match &record.angle_rad {
                Some(x) => x[k + 1] - x[k],
                None => 0.5 * dt * (speed[k] + speed[k + 1]),
            };
            row[0] += weight * dt * way[from].signum();
            row[1] += weight * turned;
            row[2] += weight * (speed[k + 1] - speed[k]);
            volts += weight * dt * record.voltage_v[k];
            area += weight * dt;
        }
        one_way.then(|| (row.map(|x| x / area), volts / area))
    };
    starts.filter_map(row).collect()
}

const ONE_LEVEL: &str = "kS, kV and kA are not determined: all that turns the motor is one voltage, of which friction alone can be any share";
const ONE_EVEN_LEVEL: &str = "kS, kV and kA are not determined: at one voltage alone does the motor turn one way for a tenth of a second and four \
                              samples without a reading near zero, and there friction alone can be any share";
/// Voltages in the direction of the motion that lie this close together, in shares of the highest, are one.
const SAME_LEVEL: f64 = 0.05;

/// Whether one voltage drives all that turns: along a step up speed and acceleration make up for each other, so that friction, speed
/// and acceleration are one equation for three numbers.
fn is_one_level(rows: &[([f64; 3], f64)]) -> bool {
    is_one_voltage(rows.iter().map(|(row, volts)| volts * row[0].signum()))
}

fn is_one_voltage(along: impl Iterator<Item = f64>) -> bool {
    let (low, high) = along.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    high - low <= SAME_LEVEL * high.abs().max(low.abs())
}

/// The share of the readings of a motion at either end of their voltages that may be a moment's: an edge, the end of the log.
const MOMENTS: f64 = 0.05;

/// The voltages in the direction of the motion that turn `record` for more than a moment.
fn driven(record: &Record) -> Vec<f64> {
    let way = motion::speed(record);
    let still = STILL * motion::peak(&way);
    let turning = way.iter().zip(&record.voltage_v).filter(|(w, _)| w.abs() > still);
    let mut along: Vec<f64> = turning.map(|(w, v)| v * w.signum()).collect();
    along.sort_by(f64::total_cmp);
    let moments = (MOMENTS * along.len() as f64) as usize;
    along[moments..along.len() - moments].to_vec()
}

/// Least squares, in which neither friction nor inertia is negative: one that would be is left out and the rest fitted again.
fn gains(rows: &[([f64; 3], f64)]) -> Option<Gains> {
    let solve = |use_of: [bool; 3]| {
        let used: Vec<usize> = (0..3).filter(|k| use_of[*k]).collect();
        let a = DMatrix::from_fn(rows.len(), used.len(), |i, j| rows[i].0[used[j]]);
        let v = DVector::from_fn(rows.len(), |i, _| rows[i].1);
        let x = (a.transpose() * &a).cholesky()?.solve(&(a.transpose() * &v));
        let left = (a * &x - v).norm_squared();
        let mut k = [0.0; 3];
        used.iter().zip(x.iter()).for_each(|(place, value)| k[*place] = *value);
        (k[0] >= 0.0 && k[1] > 0.0 && k[2] >= 0.0).then_some((left, k))
    };
    let sets = [[true; 3], [true, true, false], [false, true, true], [false, true, false]];
    let best = sets.into_iter().filter_map(solve).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let [friction, speed, acceleration] = best.1;
    Some(Gains { friction, speed, acceleration })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot's drive, kS 0.3, kV 0.9, kA 0.12, whose held voltage is played exactly from sample to sample at 20 ms.
    fn test(seconds: f64, volts: impl Fn(f64) -> f64) -> Record {
        let (ks, kv, ka, dt) = (0.3, 0.9, 0.12, 0.02);
        let time_s: Vec<f64> = (0..(seconds / dt) as usize).map(|k| k as f64 * dt).collect();
        let voltage_v: Vec<f64> = time_s.iter().map(|t| volts(*t)).collect();
        let keep = (-dt * kv / ka).exp();
        let mut w = 0.0_f64;
        let speed = voltage_v.iter().map(|v| {
            let now = w;
            let way = if w == 0.0 { v.signum() } else { w.signum() };
            w = if w == 0.0 && v.abs() <= ks { 0.0 } else { keep * w + (1.0 - keep) * (v - ks * way) / kv };
            now
        });
        Record { speed_rad_s: Some(speed.collect()), time_s, voltage_v, ..Record::default() }
    }

    fn found(records: &[Record]) -> Gains {
        gains(&records.iter().flat_map(rows_of).collect::<Vec<_>>()).unwrap()
    }

    fn close(k: Gains) {
        assert!((k.friction - 0.3).abs() < 0.01, "{k:?}");
        assert!((k.speed - 0.9).abs() < 0.01, "{k:?}");
        assert!((k.acceleration - 0.12).abs() < 0.006, "{k:?}");
    }

    #[test]
    fn ramps_and_short_steps_at_20_ms_give_all_three() {
        let ramps = [1.0, -1.0].map(|s| test(8.0, move |t| s * t));
        let steps = [1.0, -1.0].map(|s| test(2.0, move |_| s * 7.0));
        close(found(&[&ramps[..], &steps[..]].concat()));
    }

    #[test]
    fn a_step_of_two_seconds_teaches_and_one_that_hardly_moves_tells_nothing() {
        assert!(rows_of(&test(2.0, |_| 7.0)).len() > 20);
        assert!(rows_of(&test(0.09, |_| 7.0)).is_empty());
    }

    #[test]
    fn steps_of_one_level_determine_nothing_and_running_out_adds_a_level() {
        let rows =
            |volts: fn(f64) -> f64| [1.0, -1.0].map(|s| rows_of(&test(2.0, move |t| s * volts(t)))).concat();
        assert!(is_one_level(&rows(|_| 7.0)));
        assert!(!is_one_level(&rows(|t| if t < 1.0 { 7.0 } else { 0.0 })));
    }

    #[test]
    fn one_level_is_said_of_the_motor_only_where_no_other_turns_it() {
        let steps = |t: f64| if t < 2.0 { 7.0 } else { 5.0 };
        let mut record = test(4.0, steps);
        assert!(driven(&record).contains(&5.0) && !is_one_voltage(driven(&record).into_iter()));
        // Below the second level readings of none stand in every window.
        let speed = record.speed_rad_s.as_mut().unwrap();
        (100..200).step_by(3).for_each(|k| speed[k] = 0.0);
        assert!(is_one_level(&rows_of(&record)) && !is_one_voltage(driven(&record).into_iter()));
        // The log ends as the drive does.
        let one = test(2.0, |t| if t < 1.96 { 7.0 } else { 0.0 });
        assert!(is_one_voltage(driven(&one).into_iter()));
    }

    #[test]
    fn where_friction_holds_the_shaft_no_row_is_taken() {
        let still = test(3.0, |t| if t < 2.0 { 0.25 } else { 5.0 });
        let all = rows_of(&still);
        assert!(!all.is_empty() && all.iter().all(|(row, _)| row[1] > 0.0), "{all:?}");
    }
}
