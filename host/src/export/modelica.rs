//! A Modelica model: the equations of the base model with the effects as terms of theirs.
//!
//! Where the model's own step solves for dry friction, the equations have a steep slope at zero speed: a solver of
//! variable step needs no events then.

use motorlens_shared::effects::{DIODES_V, Definition, Entry, Kind, Quantity, UserDefined};

use super::laws::{Disc, number};
use super::{Exported, effects, formula};
use crate::model_file::Model;

/// Below this share of the top speed friction fades out.
const SMOOTH: f64 = 1e-3;
/// Below this share of the nominal voltage a drop fades out with the current.
const SMALL_CURRENT: f64 = 1e-3;

/// The model while it is put together.
#[derive(Default)]
struct Parts {
    /// Declarations, a line each.
    declared: Vec<String>,
    equations: Vec<String>,
    torque: String,
    load_torque: String,
    friction: String,
    drop: String,
    /// A drop that grows with the current.
    brush: String,
    resistance: String,
    field: String,
    /// What the sensor adds to the angle.
    error: String,
    /// What a disc off centre adds of that, and how it grows with the angle.
    disc: [String; 2],
    /// The variable that holds the voltage so far.
    voltage: String,
    /// The one that holds what the bridge is told of it.
    asked: String,
    /// Torque from rotor to load per inertia of the load, and the load's shares of inertia and viscous friction.
    pull: Option<(String, [f64; 2])>,
    left_out: Vec<String>,
}

impl Parts {
    /// A further stage of the voltage.
    fn voltage(&mut self, what: &str, law: impl FnOnce(&str) -> String) {
        let name = format!("v_{what}");
        self.declared.push(format!("Real {name}(unit=\"V\") \"voltage after {what}\""));
        self.equations.push(format!("{name} = {}", law(&self.voltage)));
        self.voltage = name;
    }
    fn state(&mut self, name: &str, unit: &str, meaning: &str, slope: String) {
        self.declared.push(format!("Real {name}(unit=\"{unit}\", start=0, fixed=true) \"{meaning}\""));
        self.equations.push(format!("der({name}) = {slope}"));
    }
}

/// One model, no libraries.
pub(super) fn export(model: &Model) -> Exported {
    let mut parts = Parts { voltage: "v".into(), asked: "v".into(), ..Parts::default() };
    for (kind, p) in effects(model) {
        add(&mut parts, model, kind, &p);
    }
    if !parts.friction.is_empty() {
        let width = SMOOTH * model.rig.reference_speed_rad_s;
        parts
            .left_out
            .push(format!("Friction is smoothed below {width:.2e} rad/s, so a motor held by it creeps."));
    }
    let text = file(model, &parts);
    Exported { text, left_out: parts.left_out }
}

fn add(parts: &mut Parts, model: &Model, kind: Kind, p: &[f64]) {
    let rig = &model.rig;
    let n: Vec<String> = p.iter().map(|x| number(*x)).collect();
    let n = |k: usize| n[k].as_str();
    match kind {
        Kind::Delay => {
            parts.voltage("delay", |v| format!("delay({v}, {})", n(0)));
            parts.asked.clone_from(&parts.voltage);
        }
        Kind::DeadZone => {
            let (up, down) = ((p[0] + p[1]).max(0.0), (p[0] - p[1]).max(0.0));
            parts.voltage("dead_zone", |v| format!("{v} - max(-{down:e}, min({up:e}, {v}))"));
            parts.asked.clone_from(&parts.voltage);
        }
        Kind::Coast => coast(parts, rig.supply_v, n(0), p[1]),
        Kind::SupplySag if p[1] > 0.0 => {
            let supply = rig.supply_v;
            let duty = format!("{}/{supply:e}", parts.asked);
            let slope = format!("({}*{duty}*u - sag)/{}", n(0), n(1));
            parts.state("sag", "V", "what the supply lacks", slope);
            parts.voltage("supply_sag", |name| format!("{name} - {duty}*sag"));
        }
        Kind::SupplySag => parts.resistance += &format!(" + {}*({}/{:e})^2", n(0), parts.asked, rig.supply_v),
        Kind::WindingHeating => {
            let slope = format!("{}*(u/{:e})^2*(1 + heat) - heat/{}", n(0), rig.nominal_v, n(1));
            parts.state("heat", "1", "rise of the winding's resistance", slope);
            parts.resistance += " + heat";
        }
        Kind::Saturation => {
            let q = format!("{}*(u/{:e})^2", n(0), rig.nominal_v);
            parts.field += &format!("*(35 + 10*{q})/(35 + 45*{q} + 3*({q})^2)");
        }
        Kind::VoltageDrop => {
            parts.brush += &format!(" - {}*u/sqrt(u^2 + {}^2)", n(0), n(1));
        }
        Kind::Coulomb => parts.friction += &format!(" + {}", n(0)),
        Kind::CoulombAsymmetric => parts.friction += &format!(" + {} + {}*tanh(w/w0)", n(0), n(1)),
        Kind::Stribeck => {
            let x = format!("abs(w/{})", n(2));
            let s = format!("({x}*({} + {}*{x}))", n(3), number(1.0 - p[3]));
            parts.friction += &format!(" + {} + {}/(1 + {s}*(1 + {s}*(0.5 + {s}/6)))", n(0), n(1));
        }
        Kind::LoadFriction => {
            parts.friction += &format!(" + {}*(sqrt((field*u)^2 + {}^2) - {})", n(0), n(1), n(1));
        }
        Kind::QuadraticDrag => parts.torque += &format!(" - {}*w*abs(w)", n(0)),
        Kind::Gravity => {
            parts.load_torque += &format!(" - ({}*sin(load_angle) + {}*cos(load_angle))", n(0), n(1));
        }
        Kind::ConstantLoad => parts.load_torque += &format!(" - {}", n(0)),
        Kind::Cogging => {
            for (harmonic, sine, cosine) in [(1.0, n(0), n(1)), (2.0, n(2), n(3))] {
                let k = harmonic * p[4] * rig.gear_ratio;
                parts.torque += &format!(" - ({sine}*sin({k:e}*angle) + {cosine}*cos({k:e}*angle))");
            }
        }
        Kind::Spring => parts.load_torque += &format!(" - ({}*load_angle + {})", n(0), n(1)),
        Kind::Backlash => {
            let (rate, half) = (p[3] * std::f64::consts::TAU, 0.5 * p[0]);
            parts.declared.push("Real overlap(unit=\"rad\") \"of rotor and load, beyond the gap\"".into());
            parts.equations.push(format!(
                "overlap = angle - load_angle - max(-{half:e}, min({half:e}, angle - load_angle))"
            ));
            // On either side the teeth push and never pull, and are braked where they touch.
            let side = |push: &str| {
                let into = format!("{push}(0, overlap)");
                let touching = format!("abs({into})/(abs({into}) + {:e})", 1e-3 * half);
                let (stiffness, damping) = (rate * rate, 2.0 * p[4] * rate);
                format!("{push}(0, {stiffness:e}*{into} + {damping:e}*(w - load_w)*{touching})")
            };
            let pull = format!("{:e}*({} + {})", 1.0 - p[1], side("max"), side("min"));
            parts.pull = Some((pull, [p[1], p[2]]));
        }
        Kind::Compliance => {
            let rate = p[0] * std::f64::consts::TAU;
            let pull =
                format!("{:e}*(angle - load_angle) + {:e}*(w - load_w)", rate * rate, 2.0 * p[2] * rate);
            parts.pull = Some((pull, [p[1], p[3]]));
        }
        Kind::Eccentricity => {
            let turn = if rig.encoder_on_motor {
                format!("{:e}*angle", rig.gear_ratio)
            } else {
                "load_angle".into()
            };
            let disc = Disc::new(p, if rig.encoder_on_motor { rig.gear_ratio } else { 1.0 });
            let (off, at) = (disc.off, format!("{turn} + {}", number(disc.phase)));
            let shown = format!("atan2({off:e}*sin({at}), 1 - {off:e}*cos({at}))");
            let more = format!(" + ({shown} - {})/{:e}", number(disc.at_zero), disc.turns);
            parts.error += &more;
            let way = format!("{off:e}*cos({at})");
            parts.disc = [more, format!(" + ({way} - {0:e})/(1 - 2*{way} + {0:e})", off * off)];
        }
        Kind::LostCounts => {
            let width = 0.02 * rig.reference_speed_rad_s;
            let slope = format!("{}*max(0, min(1, (abs(load_w) - {})/{width:e} + 0.5))*load_w", n(0), n(1));
            parts.state("lost", "rad", "angle that the counter lost", slope);
            parts.error += " - lost";
        }
        Kind::SensorLag if p[1] > 0.0 => {
            let shaft = if rig.encoder_on_motor { "angle" } else { "load_angle" };
            let held =
                "discrete Real held(unit=\"rad\", start=0, fixed=true) \"the shaft's angle when last read\"";
            parts.declared.push(held.into());
            let shown = format!("{shaft}{}", parts.disc[0]);
            parts.equations.push(format!("when sample({0}, {0}) then held = {shown}; end when", n(1)));
            parts.error += &format!(" - ({shown} - held)");
        }
        Kind::SensorLag => {
            let w = if rig.encoder_on_motor { "w" } else { "load_w" };
            let slope = format!("{w}*(1{}) - trail/{}", parts.disc[1], n(0));
            parts.state("trail", "rad", "by how much the reading trails", slope);
            parts.error += " - trail";
        }
        Kind::Formula(UserDefined(own)) => add_formula(parts, model, own, p),
    }
}

/// The mean of a bridge over a PWM period; for one command, mirrored where that is negative.
fn coast(parts: &mut Parts, supply: f64, share: &str, frequency: f64) {
    let v = parts.voltage.clone();
    let mut declare = |name: &str, unit: &str, meaning: &str, is: String| {
        parts.declared.push(format!("Real {name}(unit=\"{unit}\") \"{meaning}\""));
        parts.equations.push(format!("{name} = {is}"));
    };
    declare("command_side", "1", "of the command", format!("if {v} < 0 then -1 else 1"));
    let emf = "command_side*(1 - viscous_share)/gain*w".to_owned();
    declare("emf_against", "V", "back-EMF against the command", emf);
    declare("duty", "1", "driven share of the PWM period", format!("min(abs({v})/{supply:e}, 1)"));
    declare("floating", "1", "share in which the driver floats", format!("{share}*(1 - duty)"));
    let driven = format!("({supply:e} - emf_against)*(1 - exp(-duty/({frequency:e}*tau_e))) + emf_against");
    let left = format!("({driven})*exp(-(1 - duty - floating)/({frequency:e}*tau_e)) - emf_against");
    declare("left_over", "V", "current as the driver switches off", left);
    let side = "if left_over < 0 then -1 else 1".to_owned();
    declare("current_side", "1", "of that current", side);
    let against = format!("{:e} + current_side*emf_against", supply + DIODES_V);
    declare("returning", "V", "what the diodes return the current against", against);
    let conducting = format!("min({frequency:e}*tau_e*log(1 + abs(left_over)/returning), floating)");
    declare("conducting", "1", "share in which they do", conducting);
    parts.voltage("coast", |v| {
        format!("{v} + command_side*(floating*emf_against - current_side*returning*conducting)")
    });
}

fn add_formula(parts: &mut Parts, model: &Model, own: &Definition, p: &[f64]) {
    let gear = number(model.rig.gear_ratio);
    let voltage = parts.voltage.clone();
    let names = |quantity: Quantity| match quantity {
        Quantity::Voltage => voltage.clone(),
        Quantity::Command => "v".to_owned(),
        Quantity::Time => "time".to_owned(),
        Quantity::Current => "u".to_owned(),
        Quantity::Speed => "load_w".to_owned(),
        Quantity::Angle => "load_angle".to_owned(),
        Quantity::MotorSpeed => format!("({gear}*w)"),
        Quantity::MotorAngle => format!("({gear}*angle)"),
    };
    let call = |name: &str, a: &[String]| match name {
        "fmin" => format!("min({}, {})", a[0], a[1]),
        "fmax" => format!("max({}, {})", a[0], a[1]),
        "fabs" => format!("abs({})", a[0]),
        "pow" => format!("({}^{})", a[0], a[1]),
        other => format!("{other}({})", a.join(", ")),
    };
    let value = formula::expression(own, p, &names, &call);
    match own.entry() {
        Entry::Torque => parts.load_torque += &format!(" + {value}"),
        Entry::Friction => parts.friction += &format!(" + max({value}, 0)"),
        Entry::Voltage => parts.voltage(own.spec().name, |v| format!("{v} + {value}")),
        Entry::Drop => parts.drop += &format!(" + max({value}, 0)"),
        Entry::Resistance => parts.resistance += &format!(" + max({value}, 0)"),
        Entry::Sensor => parts.error += &format!(" + {value}"),
    }
}

fn file(model: &Model, parts: &Parts) -> String {
    let (b, r) = (&model.base, &model.rig);
    let comment: String = parts.left_out.iter().map(|s| format!("\n// {s}")).collect();
    let (coupling, load, rotor_share, rotor_damping) = match &parts.pull {
        Some((pull, [share, damping])) => (
            format!(" - {:e}*pull", share / (1.0 - share)),
            vec![
                format!("pull = {pull}"),
                format!(
                    "der(load_w) = pull + (gain*load_torque - {damping:e}*viscous_share*load_w)/(tau_m*{share:e})"
                ),
                "der(load_angle) = load_w".into(),
            ],
            1.0 - share,
            1.0 - damping,
        ),
        None => (String::new(), vec!["load_w = w".into(), "load_angle = angle".into()], 1.0, 1.0),
    };
    let on_rotor = if parts.pull.is_some() { "" } else { " + load_torque" };
    let load_start = if parts.pull.is_some() { ", start=0, fixed=true" } else { "" };
    let mut declared: String = parts.declared.iter().map(|d| format!("  {d};\n")).collect();
    if parts.pull.is_some() {
        declared += "  Real pull(unit=\"rad/s2\") \"acceleration that the rotor gives the load\";\n";
    }
    let equations: String = parts.equations.iter().chain(&load).map(|e| format!("  {e};\n")).collect();
    let drop = if parts.drop.is_empty() {
        String::new()
    } else {
        format!(" - (0{})*tanh(u/{:e})", parts.drop, SMALL_CURRENT * r.nominal_v)
    };
    let shaft = if r.encoder_on_motor { "angle" } else { "load_angle" };
    format!(
        r#"// Written by motorlens.{comment}
model Motor "geared DC motor; current and torques as voltages"
  input Real v(unit="V") "voltage at the driver's output";
  output Real reading(unit="rad") "what the sensor shows of the output shaft, without its counting";
  Real angle(unit="rad", start=0, fixed=true) "of the rotor, seen through the gear";
  Real w(unit="rad/s", start=0, fixed=true) "speed of the rotor, seen through the gear";
  Real u(unit="V", start=0, fixed=true) "current times winding resistance";
  Real load_angle(unit="rad"{load_start}) "of the output shaft";
  Real load_w(unit="rad/s"{load_start}) "speed of the output shaft";
  Real torque(unit="V") "on the rotor, without friction";
  Real load_torque(unit="V") "on the output shaft";
  Real friction(unit="V") "largest that there can be";
  Real field(unit="1") "as a share of the rated one";
  parameter Real gain(unit="rad/(s.V)") = {gain:e} "no-load speed per volt";
  parameter Real tau_m(unit="s") = {tau_m:e} "mechanical time constant";
  parameter Real tau_e(unit="s") = {tau_e:e} "electrical time constant";
  parameter Real viscous_share(unit="1") = {share:e} "of the mechanical damping";
  parameter Real w0(unit="rad/s") = {w0:e} "friction is smooth below";
{declared}equation
  field = 1{field};
  tau_e*der(u) = {voltage} - field*(1 - viscous_share)/gain*w - (1{resistance})*u{drop}{brush};
  torque = 0{torque};
  load_torque = 0{load_torque};
  friction = 0{friction};
  der(w) = (gain*(field*u + torque{on_rotor} - friction*tanh(w/w0)) - {rotor_damping:e}*viscous_share*w)/(tau_m*{rotor_share:e}){coupling};
  der(angle) = w;
{equations}  reading = {shaft}{error};
end Motor;
"#,
        gain = b.gain,
        tau_m = b.tau_m,
        tau_e = b.tau_e,
        share = b.viscous_share,
        w0 = SMOOTH * r.reference_speed_rad_s,
        field = parts.field,
        voltage = parts.voltage,
        resistance = parts.resistance,
        brush = parts.brush,
        torque = parts.torque,
        load_torque = parts.load_torque,
        friction = parts.friction,
        error = parts.error,
    )
}
