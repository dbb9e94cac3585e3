//! One record among several that is in other volts, or of another motor: it turns further per volt than the others, or less far.

use super::Warning;
use super::motion::peak;
use super::suspicion::{Seen, place_of};
use super::timing::median;

/// Gains of most records lie this close together; one that is this far off is in other units.
const TOGETHER: f64 = 1.2;
const APART: f64 = 1.5;
/// A record whose regression leaves more than this says nothing about the gain.
const UNCLEAR: f64 = 0.3;

/// Whether `voltages` tell dry friction from a gain: of one level friction alone may be all that the motor does.
fn tells_friction(voltages: &[f64]) -> bool {
    let highest = peak(voltages);
    voltages.iter().any(|v| (0.05..0.8).contains(&(v.abs() / highest)))
}

/// One record in other volts, or of another motor.
pub(super) fn disagreeing(seen: &[Seen]) -> Vec<Warning> {
    let regressed =
        |s: &Seen| s.weak.as_ref().filter(|_| tells_friction(&s.record.voltage_v))?.regress(0.0, |v| v);
    let gain = |s: &Seen| regressed(s).filter(|x| x.left < UNCLEAR && x.gain > 0.0);
    let gains: Vec<(&Seen, f64)> = seen.iter().filter_map(|s| Some((s, gain(s)?.gain))).collect();
    if gains.len() < 3 {
        return Vec::new();
    }
    let median = median(&mut gains.iter().map(|g| g.1).collect::<Vec<f64>>());
    let off = |g: f64| (g / median).max(median / g);
    let odd: Vec<&(&Seen, f64)> = gains.iter().filter(|g| off(g.1) > APART).collect();
    let agree = gains.iter().filter(|g| off(g.1) < TOGETHER).count();
    if agree + odd.len() < gains.len() || odd.len() * 2 >= agree {
        return Vec::new();
    }
    // A pendulum or a latency changes what fast reversals say of the gain, which show little but acceleration.
    let surely = |s: &Seen| s.weak.as_ref().is_some_and(|weak| weak.gains().iter().all(|g| off(*g) > APART));
    odd.into_iter()
        .filter(|(one, _)| surely(one))
        .map(|(Seen { record, .. }, g)| Warning {
            place: place_of(record, "voltage_v"),
            what: format!(
                "records_disagree: {} turns {:.3} rad/s per volt, the other records {median:.3}",
                record.name, g
            ),
            fix: "check that all records have one motor, one supply and one unit of voltage; leave this one out or correct it".into(),
        })
        .collect()
}
