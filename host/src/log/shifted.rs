//! Motion that comes before its voltage or long after it: the columns of a row do not belong to one instant.
//!
//! Each record's own shift is the one at which the motor's equation leaves least ([`super::weak`]); it is told where most records agree.
//! [`super::early`] tells parts of a row.

use super::early::led_by;
use super::motion::mean;
use super::suspicion::{BEFORE_ITS_VOLTAGE, Seen, place_of};
use super::timing::median;
use super::voltages::is_level;
use super::weak::Weak;
use super::{Record, Warning};

/// Shifts tried, s.
const FURTHEST_S: f64 = 0.12;
/// A record of which more than this is left at its best shift shows none.
const SHIFT_UNCLEAR: f64 = 0.5;
/// Share of the records that must agree on the shift, within so many steps.
const AGREEING: f64 = 0.6;
const TOGETHER_STEPS: f64 = 1.6;
/// In a gap of the gears the motor leads by some milliseconds, s; a log that is slower than that is shifted by whole rows.
const LEADS_S: f64 = 0.006;
/// Fewer records than this must also be much better for it.
const FEW: usize = 3;
const SHIFT_BETTER: f64 = 0.6;

/// A voltage that changes by less than this share of itself in so many seconds shows no shift: friction looks alike.
const LIVELY: f64 = 0.1;
const LIVELY_S: f64 = 0.02;

/// Whether the voltage of `record` changes fast enough to tell a shift from friction.
fn lively(record: &Record) -> bool {
    let (t, v) = (&record.time_s, &record.voltage_v);
    let mean = mean(v);
    let (mut change, mut all, mut later) = (0.0, 0.0, 0);
    for k in 0..v.len() {
        while later + 1 < v.len() && t[later] < t[k] + LIVELY_S {
            later += 1;
        }
        change += (v[later] - v[k]).powi(2);
        all += (v[k] - mean).powi(2);
    }
    // The scatter of a meter about one level is none of its changes.
    !is_level(record) && change > LIVELY * LIVELY * all
}

/// Motion that comes before its voltage, or long after it: one shift for all records that were logged alike.
pub(super) fn shifted(seen: &[Seen]) -> Option<Warning> {
    let weak: Vec<(&Record, &Weak)> =
        seen.iter().filter(|s| lively(s.record)).filter_map(|s| Some((s.record, s.weak.as_ref()?))).collect();
    let interval = weak.iter().map(|w| w.1.interval_s()).fold(0.0, f64::max);
    let step = interval.max(0.002);
    let most = (FURTHEST_S / step).floor().min(24.0) as i32;
    // Each record's own best shift, and what it leaves of what is left without.
    let own = |weak: &Weak| {
        let left = |k: i32| Some((f64::from(k) * step, weak.regress(f64::from(k) * step, |v| v)?.left));
        let best = (-most..=most).filter_map(left).min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((best.0, best.1 / left(0)?.1)).filter(|_| best.1 < SHIFT_UNCLEAR)
    };
    let own: Vec<(&Record, (f64, f64))> =
        weak.iter().filter_map(|(record, weak)| Some((*record, own(weak)?))).collect();
    let (first, _) = own.first()?;
    let shift = median(&mut own.iter().map(|(_, (shift, _))| *shift).collect::<Vec<f64>>());
    let agree = own.iter().filter(|(_, o)| (o.0 - shift).abs() < TOGETHER_STEPS * step);
    let agree: Vec<f64> = agree.map(|(_, (_, ratio))| *ratio).collect();
    // What a loop makes of a target and the motion itself has no row of its own.
    let is_logged = first.servo.is_none();
    let leads = is_logged && shift < if interval < 0.5 * LEADS_S { -LEADS_S } else { -0.9 * interval };
    let late = shift > (2.0 * interval).max(0.012);
    let clear = agree.len() >= FEW || agree.iter().all(|ratio| *ratio < SHIFT_BETTER);
    if (agree.len() as f64) < AGREEING * own.len() as f64 || !clear || !(leads || late) {
        return None;
    }
    let (ms, samples) = (1e3 * shift.abs(), shift.abs() / interval);
    let (what, fix) = if leads {
        (
            format!(
                "the motor moves {ms:.0} ms ({samples:.1} samples) {BEFORE_ITS_VOLTAGE}: the voltage is logged late"
            ),
            format!("log voltage and motion of one instant in one row; {}", led_by(shift.abs())),
        )
    } else {
        (
            format!("the motion comes {ms:.0} ms ({samples:.1} samples) after its voltage"),
            "check that the columns of a row belong to one instant; if the drive is that slow, add the effect delay (or \
             sensor_lag)"
                .into(),
        )
    };
    let place = place_of(first, "voltage_v");
    Some(Warning { place, what: format!("shifted_samples: {what}"), fix })
}
