//! The plot that shows an effect: its own equation over what the records ask for beyond the model without it.

use motorlens_shared::effects::{Kind, Port, Rig};

use super::figure::{Axis, Curve, Draw, Figure, Numbers, Panel, in_words};
use crate::compare::effect_trace::{EffectTrace, harmonics};
use crate::compare::effect_views::{Shafts, Sorted, View};
use crate::compare::free_run::{FreeRun, free_runs};
use crate::diagnose::evidence::Evidence;
use crate::fit::layout::Values;

/// Height of the plot, CSS pixels.
const HEIGHT: u32 = 240;
/// Fewer places than this show nothing.
const FEWEST_PLACES: usize = 4;

/// From where an effect is seen, best first, and what its equation looks like from the first of them.
struct Row(&'static [View], &'static str);

/// The row of `kind`.
fn row(kind: Kind) -> Row {
    use View::{
        Acceleration, CountedSpeed, Current, CurrentAlong, EncoderAngle, Jump, OutputAngle, Reversal, Ripple,
        SlowSpeed, Speed, Time, Travel, Voltage, VoltageAlong,
    };
    match kind {
        Kind::Coulomb => {
            Row(&[Speed], "a step at zero speed and one height on either side, always against the motion")
        }
        Kind::CoulombAsymmetric => {
            Row(&[Speed], "a step at zero speed, of another height forwards than backwards")
        }
        Kind::Stribeck => Row(
            &[SlowSpeed, Speed],
            "a step at zero speed that is highest beside rest and falls off within slow motion",
        ),
        Kind::QuadraticDrag => {
            Row(&[Speed], "a curve that bends ever more against the motion as the speed grows")
        }
        Kind::ConstantLoad => Row(&[Speed], "one height at every speed, forwards and backwards"),
        Kind::LoadFriction => Row(
            &[CurrentAlong],
            "a loss that grows to both sides: with the motor's torque, driving or braking",
        ),
        Kind::Gravity => Row(&[OutputAngle], "one wave per turn of the output shaft"),
        Kind::Spring => Row(&[Travel], "a straight line that falls with the way from the start"),
        Kind::Cogging => Row(&[Ripple], "a wave that repeats along the motor's turn"),
        Kind::Backlash => {
            Row(&[Reversal], "a swing close to the reversal, while the gap is crossed, and nothing later")
        }
        Kind::Compliance => {
            Row(&[Jump, Reversal, Acceleration], "a swing to and fro after the jump that dies away")
        }
        Kind::DeadZone => {
            Row(&[Voltage], "a slope through zero up to the width of the zone, and one height beyond it")
        }
        Kind::Coast => {
            Row(&[VoltageAlong], "a push along the motion that is largest at zero voltage: no braking there")
        }
        Kind::Freewheel => Row(
            &[CurrentAlong],
            "a push along the motion where the current would brake, and nothing where it drives",
        ),
        Kind::SupplySag => Row(&[Current], "a loss that grows with the current, most of all at full voltage"),
        Kind::Saturation => Row(&[Current], "a loss that bends in only at high current"),
        Kind::VoltageDrop => Row(&[Current], "a step where the current changes its sign"),
        Kind::WindingHeating => Row(&[Time], "a share that grows from nothing while the motor works"),
        Kind::Delay => Row(
            &[Jump, Acceleration],
            "the motor behind right after the jump, and level with the model soon after",
        ),
        Kind::SensorLag => Row(
            &[Jump, Acceleration],
            "the reading behind after the jump, and level with the model soon after",
        ),
        Kind::Eccentricity => Row(&[EncoderAngle], "a wave once per turn of the encoder's shaft"),
        Kind::LostCounts => Row(
            &[CountedSpeed],
            "nothing at low speed, and counted speed that is missing above the threshold",
        ),
        // A user's formula, or an effect that has no row yet.
        _ if kind.spec().port == Port::Sensor => {
            Row(&[EncoderAngle, CountedSpeed], "the shape of its equation")
        }
        _ => Row(&[Speed, OutputAngle, Voltage, Current, Reversal], "the shape of its equation"),
    }
}

/// Heading, horizontal and vertical axis of a view.
fn titles(view: View) -> (&'static str, &'static str, &'static str) {
    const TORQUE: &str = "Residual torque (V)";
    const ALONG: &str = "Residual torque along the motion (V)";
    const SPEED: &str = "Speed error (rad/s)";
    match view {
        View::Speed => ("by speed and direction", "Speed (rad/s)", TORQUE),
        View::SlowSpeed => ("by speed, slow motion", "Speed (rad/s)", TORQUE),
        View::OutputAngle => {
            ("by angle of the output shaft", "Angle within a turn of the output shaft (deg)", TORQUE)
        }
        View::Travel => ("by way from the start", "Way of the output shaft from the start (turns)", TORQUE),
        View::Ripple => (
            "by angle of the motor, slow motion",
            "Angle of the motor, turns laid over each other (deg)",
            TORQUE,
        ),
        View::Reversal => {
            ("around reversals", "Time since the reversal (s)", "Residual torque, new direction (V)")
        }
        View::Voltage => ("by voltage", "Voltage applied (V)", TORQUE),
        View::VoltageAlong => ("by voltage along the motion", "Voltage, positive where it drives (V)", ALONG),
        View::Current => ("by current", "Current times resistance: voltage less back-EMF (V)", TORQUE),
        View::CurrentAlong => {
            ("by current along the motion", "Current times resistance, positive where it drives (V)", ALONG)
        }
        View::Time => ("by time", "Time from the record's start (s)", "Loss, of the winding's voltage (%)"),
        View::Jump => {
            ("after jumps of the voltage", "Time since the jump (s)", "Speed error along the jump (rad/s)")
        }
        View::Acceleration => ("by acceleration", "Acceleration (rad/s^2)", SPEED),
        View::CountedSpeed => ("by speed", "Speed (rad/s)", SPEED),
        View::EncoderAngle => (
            "by angle of the encoder",
            "Angle within a turn of the encoder's shaft (deg)",
            "Quick error of the angle (rad)",
        ),
    }
}

/// The heading of the plot that shows `kind` best, and what its equation looks like there.
pub fn look(kind: Kind) -> (&'static str, &'static str) {
    let Row(views, look) = row(kind);
    (titles(views[0]).0, look)
}

/// The figures that show `kind` of the model `values`, whose runs and those without it are given.
pub fn figures(kind: Kind, values: &Values, rig: &Rig, runs: [&[FreeRun]; 2]) -> Vec<Figure> {
    let [with, without] = runs;
    let traces =
        with.iter().zip(without).map(|(with, without)| EffectTrace::new(with, without, &values.base));
    let traces: Vec<EffectTrace> = traces.filter(|t| !t.motion.time_s.is_empty()).collect();
    let order = kind.spec().parameters.iter().position(|p| p.name == "order");
    let order = order.zip(values.parameters(kind)).and_then(|(k, parameters)| parameters.get(k).copied());
    let shafts = Shafts {
        gear_ratio: rig.gear_ratio,
        encoder_on_motor: rig.encoder_on_motor,
        order: order.unwrap_or(1.0),
    };
    let Row(views, look) = row(kind);
    let seen = views.iter().map(|view| (*view, view.sorted(&traces, &shafts)));
    let mut seen = seen.filter(|(_, sorted)| sorted.at.len() >= FEWEST_PLACES);
    let chosen = match kind {
        // Nobody knows a user's equation: it is seen from where it accounts for most.
        Kind::Formula(_) => seen.max_by(|a, b| a.1.agreement.total_cmp(&b.1.agreement)),
        _ => seen.next(),
    };
    let Some((view, sorted)) = chosen else { return Vec::new() };
    let first = views.first() == Some(&view) || matches!(kind, Kind::Formula(_));
    let mut all = vec![figure(kind, view, first.then_some(look), &sorted)];
    let torque = kind.spec().port == Port::Torque;
    all.extend(torque.then(|| sines(kind, &traces)).flatten());
    all
}

/// The same on the records of `evidence`.
pub fn of(evidence: &Evidence, kind: Kind, values: &Values) -> Vec<Figure> {
    let runs = |values: &Values| {
        let mut runs = free_runs(&evidence.whole, values);
        runs.extend(evidence.kept_out.iter().flat_map(|kept_out| free_runs(kept_out, values)));
        runs
    };
    figures(kind, values, &evidence.whole.rig, [&runs(values), &runs(&values.without(kind))])
}

/// Measured and said over one axis.
fn pair(figure: Figure, name: &str, at: &[f64], seen: &[f64], said: &[f64], y: &str) -> Figure {
    let numbers = |values: &[f64]| Numbers::new(values.iter().copied(), 4);
    let measured = Curve { draw: Draw::Dots, ..Curve::line("measured", "records", 0, numbers(seen)) };
    let law = Curve::line("model", format!("equation of {name}"), 0, numbers(said));
    let panel = Panel { y: Axis::titled(y), height: HEIGHT, curves: vec![measured, law], floor: None };
    Figure { columns: vec![numbers(at)], panels: vec![panel], ..figure }
}

fn figure(kind: Kind, view: View, look: Option<&str>, sorted: &Sorted) -> Figure {
    let (title, x, y) = titles(view);
    let name = kind.name();
    let x = match view {
        View::OutputAngle | View::EncoderAngle => Axis::of_angles(x, &sorted.at),
        _ => Axis::titled(x),
    };
    let unit = y.rsplit(['(', ')']).nth(1).unwrap_or_default();
    let look = look.map_or(String::new(), |look| {
        if one_sided(view, &sorted.at) {
            format!("{name} would be {look}; these records show one side of zero only. ")
        } else {
            format!("Here {name} is {look}. ")
        }
    });
    let empty = Figure {
        share_percent: None,
        first: None,
        id: format!("evidence-{name}"),
        title: format!("Equation of {name} {title}"),
        reading: format!(
            "{look}Dots are what the records ask for beyond the model with {name} taken out; {}.",
            law_in_words(sorted, unit)
        ),
        x,
        columns: Vec::new(),
        panels: Vec::new(),
    };
    pair(empty, name, &sorted.at, &sorted.pair.seen, &sorted.pair.said, y)
}

/// Harmonics, where the records are sines.
fn sines(kind: Kind, traces: &[EffectTrace]) -> Option<Figure> {
    let (orders, seen) = harmonics(traces)?;
    let name = kind.name();
    // The first harmonic is the sine itself, which gain and time constants share.
    let strongest = (1..orders.len()).max_by(|a, b| seen.said[*a].total_cmp(&seen.said[*b]))?;
    let empty = Figure {
        share_percent: None,
        first: None,
        id: format!("harmonics-{name}"),
        title: format!("Equation of {name}, harmonics under the sine"),
        reading: format!(
            "A linear motor answers a sine with a sine, so all beyond the first harmonic is something else. By its equation \
             {name} shows most at {} times the sine's frequency, with {}; the records have {} there.",
            orders[strongest],
            in_words(seen.said[strongest], "V"),
            in_words(seen.seen[strongest], "V"),
        ),
        x: Axis { step: Some(1.0), ..Axis::titled("Harmonic of the sine's frequency (1)") },
        columns: Vec::new(),
        panels: Vec::new(),
    };
    Some(pair(empty, name, &orders, &seen.seen, &seen.said, "Amplitude of the residual torque (V)"))
}

/// Whether an axis that has two sides of zero shows moments on one of them alone.
fn one_sided(view: View, at: &[f64]) -> bool {
    let even =
        matches!(view, View::Speed | View::SlowSpeed | View::Voltage | View::Current | View::CountedSpeed);
    even && (at.iter().all(|x| *x > 0.0) || at.iter().all(|x| *x < 0.0))
}

/// An equation that nowhere reaches this share of what is seen has no size.
const NOTHING: f64 = 1e-3;
/// An equation whose values differ by less than this share of their size is level.
const LEVEL: f64 = 0.05;

/// Where the line lies, and how well the dots lie on it.
fn law_in_words(sorted: &Sorted, unit: &str) -> String {
    let said = &sorted.pair.said;
    let size = |values: &[f64]| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    if size(said) < NOTHING * size(&sorted.pair.seen) {
        return "the fit gives it no size worth seeing".into();
    }
    let high = said.iter().copied().fold(f64::MIN, f64::max);
    let low = said.iter().copied().fold(f64::MAX, f64::min);
    let place = if high - low < LEVEL * size(said) {
        format!("stays at {}", in_words(0.5 * (low + high), unit))
    } else {
        format!("runs from {} to {}", in_words(low, unit), in_words(high, unit))
    };
    format!("the line, its equation as fitted, {place}: {}", agreement(sorted.agreement))
}

/// How well the dots lie on the line, in words.
fn agreement(share: f64) -> String {
    let percent = (100.0 * share).floor();
    match share {
        s if s >= 0.9 => format!("the dots follow it, it accounts for {percent} % of them"),
        s if s >= 0.5 => format!("the dots follow it in part, it accounts for {percent} % of them"),
        s if s > 0.05 => format!("the dots hardly follow it, it accounts for {percent} % of them"),
        _ => "the dots do not follow it".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_a_side_with_units_on_its_axes_and_a_sentence() {
        for kind in Kind::ALL {
            let Row(views, look) = row(*kind);
            assert!(!views.is_empty() && look.len() > 20, "{kind}");
            for view in views {
                let (_, x, y) = titles(*view);
                assert!(x.ends_with(')') && y.ends_with(')'), "{kind}: {x} / {y}");
            }
        }
    }

    #[test]
    fn words_of_agreement_come_from_the_dots() {
        let sorted = |agreement| {
            let pair = crate::compare::effect_trace::Pair { seen: vec![0.4, -0.4], said: vec![0.4, -0.4] };
            Sorted { at: vec![-1.0, 1.0], pair, agreement }
        };
        let told = |sorted: &Sorted| figure(Kind::Coulomb, View::Speed, Some("a step"), sorted).reading;
        let with = |agreement| told(&sorted(agreement));
        assert!(
            with(0.979).contains("runs from -0.4 V to 0.4 V: the dots follow it, it accounts for 97 %"),
            "{}",
            with(0.979)
        );
        assert!(
            with(0.6).contains("in part")
                && with(0.2).contains("hardly")
                && with(-3.0).contains("do not follow")
        );
        let mut one_way = sorted(0.99);
        (one_way.at, one_way.pair.said) = (vec![1.0, 2.0], vec![-0.2, -0.2]);
        let told_one_way = told(&one_way);
        assert!(
            told_one_way.contains("one side of zero only") && told_one_way.contains("stays at -0.2 V"),
            "{told_one_way}"
        );
        one_way.pair.said = vec![0.0, 0.0];
        assert!(told(&one_way).contains("no size"));
    }
}
