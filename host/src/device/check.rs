//! The self-test of a board's wiring: a slow triangle of voltage, and what the encoder and the supply make of it.
//!
//! Read off one short run: whether anything moves, whether both of the encoder's lines do, which way it counts, whether the
//! driver has both directions, at which voltage the motor breaks away, and what the supply does under load.

use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, Sample, Setup};
use serde::Serialize;

use super::{Captured, remedy};

/// One rise, fall and rise back, s.
const SECONDS: f32 = 8.0;
/// Counts that an encoder at rest may flicker by.
const FLICKER: i64 = 2;
/// Counts of steady motion that are no flicker.
const MOTION: i64 = 4;
/// Changes of a count that stays where it is, by which one line of two gives itself away.
const TOGGLES: u64 = 20;
/// The supply may sag by so much of itself under load.
const SAG: f64 = 0.1;
/// A motor that has broken away does not stand again below this multiple of that voltage.
const STALL_ABOVE: f64 = 1.5;
/// A current that is no offset of its amplifier, mA.
const SOME_CURRENT: i16 = 100;

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Its name: `motion`, `encoder_lines`, `direction`, `encoder_sign`, `supply`, `run`.
    pub check: &'static str,
    /// Whether it is as it should be.
    pub ok: bool,
    /// What was seen.
    pub what: String,
    /// What to do about it; empty where it is right.
    pub fix: &'static str,
}

/// What the run showed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Checked {
    /// Whether every check is right.
    pub ok: bool,
    /// The checks.
    pub findings: Vec<Finding>,
    /// Voltage at which the motor began to turn forward and backward, V; none where it did not.
    pub breakaway_v: [Option<f64>; 2],
    /// What `--stall-voltage` may be: clear of both, V.
    pub stall_voltage_v: Option<f64>,
}

/// The run: a triangle of this amplitude.
pub fn programme(amplitude_v: f32) -> Programme {
    Programme::single("check", Shape::Triangle { amplitude_v, period_s: SECONDS }, SECONDS)
}

/// The setup of the run: a motor that does not turn is part of the question, so the short run is not ended by a stall.
pub fn setup(setup: Setup) -> Setup {
    Setup { stall_ms: 0, ..setup }
}

/// Reads the run.
pub fn check(captured: &Captured) -> Checked {
    let samples: Vec<(f64, i64)> = captured
        .samples
        .iter()
        .map(|(_, sample)| (f64::from(captured.scaling.volts(sample)), i64::from(sample.count)))
        .collect();
    let mut findings = Vec::new();
    if captured.cause != Cause::Finished {
        let what = format!("the run ended early: {}", captured.cause);
        findings.push(Finding { check: "run", ok: false, what, fix: remedy(captured.cause) });
    }
    let (forward, backward) = (ramp(&samples, 1.0), ramp(&samples, -1.0));
    // A run that did not begin says nothing of the wires.
    let motion = (!samples.is_empty()).then(|| motion(captured, &samples));
    let moves = motion.as_ref().is_some_and(|finding| finding.ok);
    findings.extend(motion);
    if moves {
        findings.push(direction(&forward, &backward));
        if forward.travel * backward.travel < 0 {
            findings.push(sign(&forward));
        }
    }
    findings.extend(supply(captured));
    let breakaway_v = if moves { [forward.breakaway_v, backward.breakaway_v] } else { [None, None] };
    let highest = breakaway_v.iter().flatten().copied().reduce(f64::max);
    Checked {
        ok: findings.iter().all(|finding| finding.ok),
        findings,
        breakaway_v,
        stall_voltage_v: highest.map(|volts| STALL_ABOVE * volts),
    }
}

/// What the counter does while the voltage has one sign.
#[derive(Debug, Default)]
struct Ramp {
    /// Counts from the first sign of the motion that this voltage causes to its end.
    travel: i64,
    /// Voltage at its beginning, without sign, V.
    breakaway_v: Option<f64>,
}

fn ramp(samples: &[(f64, i64)], sign: f64) -> Ramp {
    // The motor may still turn the other way when the sign changes: count from where it turns round, if it does.
    let driven: Vec<(f64, i64)> = samples.iter().filter(|(volts, _)| sign * volts > 0.0).copied().collect();
    let (Some(first), Some(last)) = (driven.first(), driven.last()) else { return Ramp::default() };
    let travel_way = if last.1 >= middle(&driven) { 1 } else { -1 };
    let rest = driven.iter().map(|(_, count)| travel_way * count).min().unwrap_or(travel_way * first.1);
    let turn = driven.iter().position(|(_, count)| travel_way * count == rest).unwrap_or(0);
    let moved = driven[turn..].iter().find(|(_, count)| travel_way * count - rest >= MOTION);
    Ramp { travel: last.1 - travel_way * rest, breakaway_v: moved.map(|(volts, _)| volts.abs()) }
}

/// The count at the middle of the time, where the voltage is largest.
fn middle(samples: &[(f64, i64)]) -> i64 {
    samples[samples.len() / 2].1
}

fn motion(captured: &Captured, samples: &[(f64, i64)]) -> Finding {
    let counts = || samples.iter().map(|(_, count)| *count);
    let span = counts().max().unwrap_or(0) - counts().min().unwrap_or(0);
    let changes: u64 = samples.windows(2).map(|pair| pair[1].1.abs_diff(pair[0].1)).sum();
    if span > FLICKER {
        let what = format!("the encoder counts: {span} counts over the run");
        return Finding { check: "motion", ok: true, what, fix: "" };
    }
    if changes >= TOGGLES {
        let what =
            format!("the count changes {changes} times and stays where it is: one line of two arrives");
        return Finding {
            check: "encoder_lines",
            ok: false,
            what,
            fix: "check the wires of the encoder's A and B",
        };
    }
    let current =
        |sample: &Sample| captured.capabilities.measures_current && sample.current_ma.abs() > SOME_CURRENT;
    let flows = captured.samples.iter().any(|(_, sample)| current(sample));
    let highest = samples.iter().map(|(volts, _)| volts.abs()).fold(0.0, f64::max);
    let (what, fix) = if flows {
        (
            format!(
                "no count up to {highest:.1} V, though current flows: the shaft is held or the encoder is dead"
            ),
            "free the shaft; check the encoder's supply and both its lines",
        )
    } else {
        (
            format!("no count up to {highest:.1} V"),
            "check the driver's supply, its enable, the motor's leads, and the encoder's supply and lines; or raise --amplitude",
        )
    };
    Finding { check: "motion", ok: false, what, fix }
}

fn direction(forward: &Ramp, backward: &Ramp) -> Finding {
    let (there, back) = (forward.travel, backward.travel);
    let dead = |travel: i64| travel.abs() <= FLICKER;
    let wrong = |what: String, fix| Finding { check: "direction", ok: false, what, fix };
    match (dead(there), dead(back)) {
        (false, true) => wrong(
            format!("{there} counts forward, none backward: half of the bridge is dead"),
            "check the wire of the direction backward (with in-in drivers of the second PWM), and the driver",
        ),
        (true, false) => wrong(
            format!("none forward, {back} counts backward: half of the bridge is dead"),
            "check the wire of the direction forward (with in-in drivers of the PWM), and the driver",
        ),
        _ if (there > 0) == (back > 0) => wrong(
            format!("the motor turns the same way forward and backward ({there} and {back} counts)"),
            "check the direction wires, and that --drive is the kind of driver that is wired",
        ),
        _ => {
            let what = format!("both directions turn the motor: {there} and {back} counts");
            Finding { check: "direction", ok: true, what, fix: "" }
        }
    }
}

fn sign(forward: &Ramp) -> Finding {
    let ok = forward.travel > 0;
    let what = if ok { "positive voltage counts up" } else { "positive voltage counts down" };
    let fix = if ok { "" } else { "swap the encoder's A and B, or the motor's two leads" };
    Finding { check: "encoder_sign", ok, what: what.to_owned(), fix }
}

/// The supply under load, where it is measured.
fn supply(captured: &Captured) -> Option<Finding> {
    if !captured.capabilities.measures_supply {
        return None;
    }
    let stated = f64::from(captured.setup.supply_mv) * 1e-3;
    let measured = || captured.samples.iter().map(|(_, sample)| f64::from(sample.supply_mv) * 1e-3);
    let wrong = |what: String, fix| Some(Finding { check: "supply", ok: false, what, fix });
    if captured.cause == Cause::Supply {
        return wrong(
            format!("the measured supply is not within half and one and a half of the stated {stated:.1} V"),
            "check --supply and --divider, and that the divider is wired to the supply's input",
        );
    }
    let (lowest, highest) = (measured().fold(f64::MAX, f64::min), measured().fold(0.0, f64::max));
    if highest > 0.0 && lowest < (1.0 - SAG) * highest {
        return wrong(
            format!("the supply sags from {highest:.2} to {lowest:.2} V under load"),
            "use a stronger supply, thicker leads, or a capacitor at the driver",
        );
    }
    let what = format!("the supply is {lowest:.2} to {highest:.2} V");
    (highest > 0.0).then_some(Finding { check: "supply", ok: true, what, fix: "" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use motorlens_shared::link::{Capabilities, Reset, RunState, Scaling, Status};

    const SCALING: Scaling = Scaling { pwm_top: 1000, rate_hz: 500 };

    /// The run as a motor makes it that turns with `counts_per_v_s` above 1 V, its counts and supply changed by `wiring`.
    fn run(counts_per_v_s: f64, wiring: impl Fn(f64, f64) -> (f64, u16)) -> Captured {
        let mut position = 0.0;
        let sample = |index: u32| {
            let time = f64::from(index) / 500.0;
            let volts = match time {
                t if t < 2.0 => 3.0 * t,
                t if t < 6.0 => 12.0 - 3.0 * t,
                t => 3.0 * t - 24.0,
            };
            let drive = if volts.abs() > 1.0 { volts - volts.signum() } else { 0.0 };
            let (count, supply_mv) = wiring(position, volts);
            position += counts_per_v_s * drive / 500.0;
            let duty = (volts / 12.0 * 1000.0) as i16;
            (index, Sample { duty, count: count.floor() as i32, supply_mv, current_ma: 0, late_us: 0 })
        };
        let samples: Vec<_> = (0..4000).map(sample).collect();
        let capabilities = Capabilities {
            effects: 0,
            segments: 16,
            log_samples: 1024,
            fit_samples: 2000,
            core_hz: 84_000_000,
            pwm_hz: 20_000,
            measures_supply: true,
            measures_current: false,
            scaling: SCALING,
            converter: true,
        };
        let status = Status {
            state: RunState::Stopped(Cause::Finished),
            run: 1,
            oldest: 0,
            next: 4000,
            missed: 0,
            kept: 0,
            damaged: 0,
            reset: Reset::PowerOn,
            worst_cycles: 0,
        };
        let setup = Setup::default();
        Captured {
            cause: Cause::Finished,
            samples,
            holes: vec![],
            scaling: SCALING,
            capabilities,
            setup,
            status,
        }
    }

    fn wrong(captured: &Captured) -> Vec<&'static str> {
        check(captured)
            .findings
            .into_iter()
            .filter(|finding| !finding.ok)
            .map(|finding| finding.check)
            .collect()
    }

    #[test]
    fn a_sound_bench_passes_and_tells_where_the_motor_breaks_away() {
        let checked = check(&run(500.0, |position, _| (position, 12_000)));
        assert!(checked.ok, "{checked:?}");
        for volts in checked.breakaway_v {
            let volts = volts.expect("it turns");
            assert!((1.0..1.6).contains(&volts), "{volts} V");
        }
        assert!(checked.stall_voltage_v.is_some_and(|volts| (1.5..2.4).contains(&volts)));
    }

    #[test]
    fn every_fault_of_the_wiring_is_named() {
        assert_eq!(wrong(&run(500.0, |position, _| (-position, 12_000))), ["encoder_sign"]);
        assert_eq!(wrong(&run(500.0, |_, _| (7.0, 12_000))), ["motion"]);
        assert_eq!(wrong(&run(500.0, |position, _| (position.rem_euclid(2.0), 12_000))), ["encoder_lines"]);
        // A direction wire that does not arrive: the other way is another way of going forward, or none at all.
        assert_eq!(wrong(&run(500.0, |_, _| (0.0, 12_000))), ["motion"]);
        let sag = |volts: f64| (12_000.0 - 400.0 * volts.abs()) as u16;
        assert_eq!(wrong(&run(500.0, |position, volts| (position, sag(volts)))), ["supply"]);
    }

    #[test]
    fn a_bridge_with_one_direction_is_named() {
        let mut only_forward = run(500.0, |position, _| (position, 12_000));
        let most = only_forward.samples.iter().map(|(_, sample)| sample.count).max().unwrap();
        let top = only_forward.samples.iter().position(|(_, sample)| sample.count == most).unwrap();
        only_forward.samples[top..].iter_mut().for_each(|(_, sample)| sample.count = most);
        assert_eq!(wrong(&only_forward), ["direction"]);
        // It goes on forward in the backward half.
        let mut same_way = run(500.0, |position, _| (position, 12_000));
        for (_, sample) in &mut same_way.samples[top..] {
            sample.count = 2 * most - sample.count;
        }
        assert_eq!(wrong(&same_way), ["direction"]);
    }

    #[test]
    fn a_shaft_that_never_stands_is_named_with_what_to_do_and_nothing_else_is() {
        let mut captured = run(500.0, |position, _| (position, 12_000));
        captured.cause = Cause::Turning;
        captured.samples.clear();
        let checked = check(&captured);
        let [finding] = checked.findings.as_slice() else { panic!("{checked:?}") };
        assert!(
            !checked.ok && finding.check == "run" && finding.what.contains("went on turning"),
            "{finding:?}"
        );
        assert!(finding.fix.contains("hold the shaft") && finding.fix.contains("enable"), "{finding:?}");
    }

    #[test]
    fn a_supply_without_its_divider_is_named() {
        let mut captured = run(500.0, |position, _| (position, 300));
        captured.cause = Cause::Supply;
        captured.samples.truncate(3);
        assert_eq!(wrong(&captured), ["run", "motion", "supply"]);
    }
}
