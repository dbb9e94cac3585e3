//! The fast method: each effect from its probes in turn, then all parameters together.

use motorlens_shared::effects::Kind;

use super::Searched;
use crate::diagnose::contained::extended;
use crate::diagnose::evidence::Evidence;
use crate::fit::cost::Objective;
use crate::fit::layout::{BaseValues, Values};
use crate::fit::search::Problem;
use crate::select;
use crate::select::fitted::Fitted;
use crate::stop;

/// Steps of the textbook's search.
const TEXTBOOK: usize = 60;

/// Adds `effects` to `base` one after the other on all records, as the diagnosis does, in their order and in the opposite one: what comes first
/// takes up some of what the others would, and not every search leads out of that again.
pub(crate) fn search(problem: &Problem, base: &Values, effects: &[Kind]) -> Searched {
    let evidence = Evidence::of(problem.clone(), Vec::new());
    let plain = select::fitted_from(&evidence, base);
    let kept = plain.simulating(&evidence);
    let found = in_order(&evidence, [&plain, &kept], effects.iter());
    let found = if effects.len() > 1 && !stop::asked() {
        let reversed = in_order(&evidence, [&plain, &kept], effects.iter().rev()).values();
        let own = |kind: &Kind| Some((*kind, reversed.parameters(*kind)?.to_vec()));
        let effects = found.kinds().iter().filter_map(own).collect();
        let start = Values { base: reversed.base, effects };
        found.or_better(Some(Fitted::of(&evidence, &start, 1, 0).simulating(&evidence)))
    } else {
        found
    };
    Searched { values: found.values(), history: Vec::new(), evaluations: evidence.simulations() }
}

/// A model, as effects are `chosen` by and as it is `kept` for use, with the effects of `order`, fitted for use. With each it begins once more
/// where it ended without it and the effect is nothing: of two models the one that contains the other is never the worse.
fn in_order<'a>(
    evidence: &Evidence,
    [chosen, kept]: [&Fitted; 2],
    order: impl Iterator<Item = &'a Kind>,
) -> Fitted {
    let (mut chosen, mut kept) = (chosen.clone(), kept.clone());
    for kind in order {
        let Some(richer) = select::with(evidence, &chosen, *kind) else { continue };
        let nothing = nothing(&richer.values(), *kind);
        let poorer = extended(&kept.values(), *kind, nothing);
        let again = Fitted::of(evidence, &poorer, 1, 0).simulating(evidence);
        kept = richer.simulating(evidence).or_better(Some(again));
        chosen = richer;
        if stop::asked() {
            break;
        }
    }
    kept
}

/// The parameters of `kind` in `values`, but that it is nothing.
fn nothing(values: &Values, kind: Kind) -> Vec<f64> {
    let own = values.parameters(kind).unwrap_or_default();
    kind.spec().parameters.iter().zip(own).map(|(p, own)| if p.strength { 0.0 } else { *own }).collect()
}

/// Least squares on the error itself, once, from the ordinary size of everything: what a textbook would do.
pub(crate) fn textbook(problem: &Problem, effects: &[Kind]) -> Searched {
    let layout = problem.layout(effects);
    let rig = &problem.rig;
    let base = BaseValues {
        gain: rig.reference_speed / rig.nominal_v,
        tau_m: 0.05,
        tau_e: problem.prior.tau_e.0,
        viscous_share: problem.prior.viscous_share.0,
    };
    let ordinary = |k: &Kind| (*k, k.spec().typical(rig).collect());
    let start = Values { base, effects: effects.iter().map(ordinary).collect() };
    let found = problem.search(&layout, Objective::Position, &layout.pack(&start), TEXTBOOK, 1e-6);
    Searched { values: layout.unpack(&found.x), history: Vec::new(), evaluations: problem.simulations.get() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::free_run::simulated;
    use crate::estimate::start::prepare;
    use crate::log::Record;
    use crate::motor_file::MotorFile;

    /// Steps down and up of a motor whose bridge lets it float, cut out of a longer log: with a dead zone looked for first twice as much was left
    /// as without.
    #[test]
    fn an_effect_more_leaves_no_more_whatever_the_order() {
        let of = |from: f64, to: f64| {
            let (mut speed, mut angle, mut record) = (25.0, 0.0, Record::default());
            let mut measured = Vec::new();
            for k in 0..1400_u32 {
                let t = f64::from(k) * 1e-3;
                let volts = if t < 0.4 { from } else { to };
                if k.is_multiple_of(5) {
                    record.time_s.push(t);
                    record.voltage_v.push(volts);
                    measured.push((angle / 2.6e-3_f64).round() * 2.6e-3);
                }
                // Below the speed that a voltage holds the motor is driven, above it it runs out.
                let towards = 3.4 * (volts - 3.0);
                let rate =
                    if speed < towards { (towards - speed) / 0.15 } else { (towards - speed) / 0.5 - 4.0 };
                speed = (speed + 1e-3 * rate).max(0.0);
                angle += 1e-3 * speed;
            }
            record.angle_rad = Some(measured);
            record
        };
        let (problem, base) = prepare(&[of(11.0, 7.5), of(8.0, 11.5)], &MotorFile::default()).unwrap();
        let left = |effects: &[Kind]| {
            let values = search(&problem, &base, effects).values;
            simulated(&problem, &values).unwrap().rmse
        };
        use Kind::{Coast, Coulomb, DeadZone, Delay};
        for more in [Delay, Coulomb, DeadZone] {
            let (one, [first, second]) =
                (left(&[Coast]), [[Coast, more], [more, Coast]].map(|both| left(&both)));
            assert!(first.max(second) < 1.02 * one, "{more}: {first} {second} rad, and {one} without it");
        }
    }
}
