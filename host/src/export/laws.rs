//! Effects as statements that C and Python both read.
//!
//! Names: `volts` the command; `past` the commands up to now, the latest first; `time`; `v` the voltage so far;
//! `asked` what the bridge is told of it;
//! `torque` and `load_torque`, and the `weakening` of the former by saturation; `up` and `down` the friction against forward and
//! backward motion; `meshing` and `brush` with their knees; `drop`; `series`.
//! The state: `current`, `speed`, `angle` of the rotor, `load_speed`, `load_angle`, each with a 2 at the
//! end of the step; `shown` the encoder's shaft as a disc off centre shows it; `start` the first angle; `m[k]` what effect k remembers. `reading` is what the sensor shows.

use motorlens_shared::base::Base;
use motorlens_shared::effects::{Kind, Rig, UserDefined};

use super::formula;

/// The statements of an effect, by the moment at which they run.
#[derive(Debug, Default, Clone)]
pub(super) struct Statements {
    /// What is remembered at the start, where the shaft has long been turning at `speed`, and what the sensor makes of that.
    pub begin: Vec<String>,
    /// Voltage and torque of the coming step.
    pub drive: Vec<String>,
    /// Between rotor and load.
    pub couple: Vec<String>,
    /// What is remembered after the step.
    pub settle: Vec<String>,
    /// What the sensor makes of the angle.
    pub read: Vec<String>,
}

/// What the statements of an effect depend on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// The motor.
    pub base: &'a Base<f64>,
    /// Length of one step of the program, s.
    pub part_s: f64,
    /// The effect's own number in `m`.
    pub memory: usize,
}

/// A disc that sits off centre: how far, where that shows at angle zero, what it shows there, and its turns per output turn.
pub(super) struct Disc {
    pub off: f64,
    pub phase: f64,
    pub at_zero: f64,
    pub turns: f64,
}

impl Disc {
    pub(super) fn new(p: &[f64], turns: f64) -> Self {
        let (off, phase) = ((turns * p[0].hypot(p[1])).min(0.9), p[1].atan2(p[0]));
        Self { off, phase, at_zero: (off * phase.sin()).atan2(1.0 - off * phase.cos()), turns }
    }
}

/// A number that may follow any operator.
pub(super) fn number(x: f64) -> String {
    if x.is_sign_negative() { format!("({x:e})") } else { format!("{x:e}") }
}

/// The statements of `kind` with parameters `p`.
pub(super) fn statements(kind: Kind, p: &[f64], place: &Place) -> Statements {
    let rig = place.rig;
    let n: Vec<String> = p.iter().map(|x| number(*x)).collect();
    let n = |k: usize| n[k].as_str();
    let m = place.memory;
    let motor = rig.encoder_on_motor;
    let drive = |line: String| Statements { drive: vec![line], ..Statements::default() };
    let asks = |line: String| Statements { drive: vec![line, "asked = v".into()], ..Statements::default() };
    let friction = |up: &str, down: &str| Statements {
        drive: vec![format!("up += {up}"), format!("down += {down}")],
        ..Statements::default()
    };
    // The speed in the middle of the step, where it goes on as in the last.
    let middle = format!("(speed + 0.5 * m[{m}])");
    let change = format!("m[{m}] = speed2 - speed");
    match kind {
        Kind::Delay => asks(format!("v += look_back(past, {}) - volts", number(p[0] / rig.step_s))),
        Kind::DeadZone => {
            asks(format!("v -= clamp(v, -{:e}, {:e})", (p[0] - p[1]).max(0.0), (p[0] + p[1]).max(0.0)))
        }
        Kind::Coast => Statements {
            drive: vec![format!(
                "v = coasting(v, {:e} * {middle}, {}, {:e}, {:e})",
                place.base.back_emf(),
                n(0),
                rig.supply_v,
                p[1] * place.base.tau_e
            )],
            settle: vec![change],
            ..Statements::default()
        },
        Kind::SupplySag => {
            let duty = format!("(asked / {:e})", rig.supply_v);
            let steps = place.part_s / p[1].max(1e-3 * place.part_s);
            let kept = (-steps).exp();
            let first = (1.0 - kept) / steps;
            let drawn = format!("({:e} * current + {:e} * current2)", first - kept, 1.0 - first);
            Statements {
                drive: vec![
                    format!("series += {:e} * {duty} * {duty}", (1.0 - first) * p[0]),
                    format!("v -= {duty} * {first:e} * m[{m}]"),
                ],
                settle: vec![format!("m[{m}] = {kept:e} * m[{m}] + {} * {duty} * {drawn}", n(0))],
                ..Statements::default()
            }
        }
        Kind::WindingHeating => {
            let gain = p[0] * place.part_s / (rig.nominal_v * rig.nominal_v);
            let (z, emf) = (place.part_s / place.base.tau_e, place.base.back_emf());
            let square = format!("mean_square(current, current2, {emf:e} * (speed2 - speed), {z:e})");
            Statements {
                drive: vec![format!("series += m[{m}] + {:e} * current * current", 0.5 * gain)],
                settle: vec![format!(
                    "m[{m}] += {gain:e} * {square} * (1.0 + m[{m}]) - {:e} * m[{m}]",
                    place.part_s / p[1]
                )],
                ..Statements::default()
            }
        }
        Kind::Saturation => {
            let strength = number(p[0] / (rig.nominal_v * rig.nominal_v));
            let (emf, z) = (place.base.back_emf(), place.part_s / place.base.tau_e);
            let gain = place.part_s * place.base.acceleration() * emf;
            let through = "1.0 / (1.0 + series)";
            let braked = place.part_s * place.base.damping() * emf;
            let lacks = |of_torque| {
                format!(
                    "saturated({strength}, current, v, {emf:e} * speed, {through}, {z:e}, {gain:e}, {gain:e} * others - \
                     {braked:e} * speed, meshing * sign(speed), meshing_knee, {of_torque})"
                )
            };
            let dry = "up * fmax(sign(speed), 0.0) - down * fmax(-sign(speed), 0.0)";
            let mut lines = drive(format!("others = torque + load_torque - ({dry})"));
            lines.drive.push(format!("weakening = {}", lacks(1)));
            lines.drive.push("torque -= weakening".to_owned());
            lines.drive.push(format!("v += {}", lacks(0)));
            lines
        }
        Kind::VoltageDrop => {
            let mut lines = drive(format!("brush = {}", n(0)));
            lines.drive.push(format!("brush_knee = {}", n(1)));
            lines
        }
        Kind::Coulomb => friction(n(0), n(0)),
        Kind::CoulombAsymmetric => friction(&number((p[0] + p[1]).max(0.0)), &number((p[0] - p[1]).max(0.0))),
        Kind::Stribeck => {
            let x = format!("fmax(fabs(speed) + 0.5 * m[{m}] * sign(speed), 0.0) / {}", n(2));
            let s = format!("({x} * ({} + {} * {x}))", n(3), number(1.0 - p[3]));
            let f = format!("{} + {} / (1.0 + {s} * (1.0 + {s} * (0.5 + {s} / 6.0)))", n(0), n(1));
            Statements { settle: vec![change], ..friction(&f, &f) }
        }
        Kind::LoadFriction => {
            let mut lines = drive(format!("meshing = {}", n(0)));
            lines.drive.push(format!("meshing_knee = {}", n(1)));
            lines
        }
        Kind::QuadraticDrag => Statements {
            settle: vec![change],
            ..drive(format!("torque -= {} * {middle} * fabs{middle}", n(0)))
        },
        Kind::Gravity => {
            // At the middle of the step, like every torque that depends on an angle.
            let middle = format!("(load_angle + {:e} * load_speed)", 0.5 * place.part_s);
            drive(format!("load_torque -= {} * sin{middle} + {} * cos{middle}", n(0), n(1)))
        }
        Kind::ConstantLoad => drive(format!("load_torque -= {}", n(0))),
        Kind::Cogging => {
            // The mean over the step in angles of the motor shaft; `order` periods a turn. Where `passed`, in halves
            // of a period, comes to 1, a whole one goes by.
            let mean = format!("(speed + m[{m}] / 3.0)");
            let wave = |times: f64, sine: &str, cosine: &str| {
                let per_angle = times * p[4] * rig.gear_ratio;
                let turn = format!("({per_angle:e} * (angle + {:e} * {mean}))", 0.5 * place.part_s);
                let passed =
                    format!("{:e} * fabs({mean})", 0.5 * place.part_s * per_angle / std::f64::consts::PI);
                let q = format!("clamp({passed}, 0.0, 1.0)");
                let q = format!("({q} * {q})");
                let flat = format!("(1.0 + {q} * (-1.644934 + {q} * (0.811742 - 0.166808 * {q})))");
                format!("{flat} * ({sine} * sin{turn} + {cosine} * cos{turn})")
            };
            let torque = format!("torque -= {} + {}", wave(1.0, n(0), n(1)), wave(2.0, n(2), n(3)));
            Statements { settle: vec![change], ..drive(torque) }
        }
        Kind::Spring => {
            let middle = format!("(load_angle + {:e} * load_speed)", 0.5 * place.part_s);
            drive(format!("load_torque -= {} * ({middle} - start) + {}", n(0), n(1)))
        }
        Kind::Backlash => Statements { couple: backlash(p, place), ..Statements::default() },
        Kind::Compliance => Statements { couple: compliance(p, place), ..Statements::default() },
        Kind::Eccentricity => {
            let disc = Disc::new(p, if motor { rig.gear_ratio } else { 1.0 });
            let (off, turns, phase) = (disc.off, disc.turns, number(disc.phase));
            let shows = |shaft: &str| {
                let at = format!("({turns:e} * {shaft} + {phase})");
                format!("atan2({off:e} * sin{at}, 1.0 - {off:e} * cos{at})")
            };
            let shaft = if motor { "angle2" } else { "load_angle2" };
            let error = format!("({} - {}) / {turns:e}", shows(shaft), number(disc.at_zero));
            let seen = |shaft: &str| format!("{shaft} += {} / {turns:e}", shows(shaft));
            Statements {
                settle: vec![seen("shown"), seen("shown2")],
                read: vec![format!("reading += {error}")],
                ..Statements::default()
            }
        }
        Kind::LostCounts => Statements {
            settle: vec![format!(
                "m[{m}] += {} * clamp((fabs(load_speed2) - {}) / {:e} + 0.5, 0.0, 1.0) * (load_angle2 - load_angle)",
                n(0),
                n(1),
                0.02 * rig.reference_speed
            )],
            read: vec![format!("reading -= m[{m}]")],
            ..Statements::default()
        },
        Kind::SensorLag if p[1] > 0.0 => {
            let (moved, hold, part) = ("(shown2 - shown)", n(1), place.part_s);
            Statements {
                settle: vec![
                    format!("over = elapsed - {hold} * floor(elapsed / {hold})"),
                    format!("m[{m}] = pick({part:e} - over, {moved} * over / {part:e}, m[{m}] + {moved})"),
                ],
                read: vec![format!("reading -= m[{m}]")],
                ..Statements::default()
            }
        }
        Kind::SensorLag => {
            let (keep, ramp) = filter(p[0], place.part_s);
            Statements {
                begin: vec![format!("m[{m}] = {} * speed", n(0)), format!("reading -= m[{m}]")],
                settle: vec![format!("m[{m}] = {keep:e} * m[{m}] + {ramp:e} * (shown2 - shown)")],
                read: vec![format!("reading -= m[{m}]")],
                ..Statements::default()
            }
        }
        Kind::Formula(UserDefined(definition)) => formula::statements(definition, p, rig),
    }
}

/// Rotor and load overlap by what exceeds the gap: there the teeth push, and are braked for as long as they touched.
fn backlash(p: &[f64], place: &Place) -> Vec<String> {
    let (half, share, part_s) = (0.5 * p[0], p[1], place.part_s);
    let keep = 1.0 - part_s * place.base.damping() * p[2] / share;
    let rate = p[3] * std::f64::consts::TAU;
    let loss = 2.0 * p[4] * rate;
    let held = 1.0 / (1.0 + loss * part_s);
    vec![
        format!("common = {keep:e} * load_speed2"),
        format!("load_angle2 += {:e} * (load_speed2 + common)", 0.5 * part_s),
        "load_speed2 = common".into(),
        "overlap = angle2 - load_angle2".into(),
        format!("overlap -= clamp(overlap, -{half:e}, {half:e})"),
        format!("closing = clamp({part_s:e} * (speed2 - load_speed2), -fabs(overlap), fabs(overlap))"),
        format!("closing = {:e} * overlap + {:e} * closing", rate * rate * part_s * held, loss * held),
        "closing = pick(overlap * closing, closing, 0.0)".into(),
        format!("speed2 -= {share:e} * closing"),
        format!("load_speed2 += {:e} * closing", 1.0 - share),
    ]
}

fn compliance(p: &[f64], place: &Place) -> Vec<String> {
    let (rate, share, part_s) = (p[0] * std::f64::consts::TAU, p[1], place.part_s);
    let keep = 1.0 - part_s * place.base.damping() * p[3] / share;
    vec![
        format!("load_angle2 += {part_s:e} * load_speed2"),
        format!(
            "closing = {part_s:e} * ({:e} * (speed2 - load_speed2) + {:e} * (angle2 - load_angle2))",
            2.0 * p[2] * rate,
            rate * rate
        ),
        format!("load_speed2 = {keep:e} * load_speed2 + closing"),
        format!("speed2 -= {:e} * closing", share / (1.0 - share)),
    ]
}

/// A first-order filter over a step: how much of the trail is kept, and what motion adds to it.
///
/// The same quotient for e^(-h/T) as in the effect itself.
fn filter(time: f64, h: f64) -> (f64, f64) {
    let (square, product) = (12.0 * time * time, 6.0 * time * h);
    let keep = if h > 4.0 * time { 0.0 } else { (square - product + h * h) / (square + product + h * h) };
    (keep, time * (1.0 - keep) / h)
}
