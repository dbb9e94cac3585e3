//! `device check`: the self-test of the wiring.

use clap::ValueEnum;
use motorlens_shared::link::Setup;
use serde_json::json;

use super::Console;
use super::capture::{Drive, Wired, converse, run_number};
use super::device::At;
use super::interrupt::interrupted;
use crate::device::check::{Checked, check, programme, setup};
use crate::device::{Capture, Port, wiring};
use crate::error::{Error, Result};

/// The supply where none is stated, V: what `capture` takes too.
const SUPPLY_V: f32 = 12.0;

/// Options of `device check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens device check --port /dev/ttyACM0
  motorlens device check --port /dev/ttyACM0 --supply 12 --amplitude 4")]
pub struct Args {
    #[command(flatten)]
    pub at: At,
    /// How the driver is driven
    #[arg(long, value_enum, default_value = "brake")]
    pub drive: Drive,
    /// Supply of the driver in volts
    #[arg(long, value_name = "VOLTS", default_value_t = SUPPLY_V)]
    pub supply: f32,
    #[command(flatten)]
    pub wired: Wired,
    /// Frequency of the PWM, 5000 to 50000 [default: 20000]
    #[arg(long, value_name = "HZ")]
    pub pwm_frequency: Option<u32>,
    /// Largest voltage that is applied [default: half the supply]
    #[arg(long, value_name = "VOLTS")]
    pub amplitude: Option<f32>,
}

/// Plays the slow triangle and says what it shows.
pub fn run(args: &Args, console: &Console) -> Result<()> {
    let amplitude = args.amplitude.unwrap_or(0.5 * args.supply);
    let programme = programme(amplitude);
    programme.validate(args.supply).map_err(|error| {
        Error::usage(error.to_string(), "lower --amplitude, or state the --supply there is")
    })?;
    let Wired { divider, amplifier } = args.wired;
    let setup = setup(Setup {
        drive: args.drive.mode(),
        pwm_hz: args.pwm_frequency.unwrap_or(0),
        ..wiring::setup(args.supply, divider, amplifier, 0.0)?
    });
    setup
        .check(1024, true)
        .map_err(|fault| Error::usage(fault.to_string(), "see motorlens device check --help"))?;
    let mut port = Port::open(&args.at.port)?;
    let mut capture = Capture::new(setup, &programme, run_number());
    let captured =
        converse(&mut port, &mut capture, "check", programme.seconds(), None, &interrupted(), console)?;
    let checked = check(&captured);
    let mut document = json!({ "schema": 1 });
    if let (Some(all), Ok(serde_json::Value::Object(found))) =
        (document.as_object_mut(), serde_json::to_value(&checked))
    {
        all.extend(found);
    }
    console.answer(&document, || {
        let mut lines: Vec<String> = Vec::new();
        for finding in &checked.findings {
            lines.push(format!("{} {}", if finding.ok { "right" } else { "WRONG" }, finding.what));
            if !finding.ok {
                lines.push(format!("      do: {}", finding.fix));
            }
        }
        let [forward, backward] =
            checked.breakaway_v.map(|volts| volts.map_or("-".into(), |v| format!("{v:.2} V")));
        lines.push(format!("the motor breaks away at {forward} forward, {backward} backward"));
        if let Some(volts) = checked.stall_voltage_v {
            lines.push(format!("--stall-voltage {volts:.1} is clear of both"));
        }
        lines.join("\n")
    });
    let (what, command) = next(args, &checked);
    console.next(what, &command);
    Ok(())
}

/// What to do next, and the command that does it, with what this one was told of driver and wires: without it another kind of driver
/// would be driven, or another supply.
fn next(args: &Args, checked: &Checked) -> (&'static str, String) {
    let drive = args.drive.to_possible_value().filter(|_| args.drive != Drive::Brake);
    let told = [
        drive.map(|value| format!(" --drive {}", value.get_name())),
        (args.supply != SUPPLY_V).then(|| format!(" --supply {}", args.supply)),
        args.wired.divider.map(|ratio| format!(" --divider {ratio}")),
        args.wired.amplifier.map(|slope| format!(" --amplifier {slope}")),
        args.pwm_frequency.map(|frequency| format!(" --pwm-frequency {frequency}")),
    ];
    let told: String = told.into_iter().flatten().collect();
    let port = &args.at.port;
    if checked.ok {
        let stall =
            checked.stall_voltage_v.map_or(String::new(), |volts| format!(" --stall-voltage {volts:.1}"));
        let command = format!(
            "motorlens capture --port {port} --programme default --counts-per-rev COUNTS{told}{stall} --out logs"
        );
        ("record the default protocol", command)
    } else {
        let amplitude = args.amplitude.map_or(String::new(), |volts| format!(" --amplitude {volts}"));
        let command = format!("motorlens device check --port {port}{told}{amplitude}");
        ("mend what is wrong, and look again", command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_command_is_told_of_driver_and_wires_what_this_one_was() {
        let mut args = Args {
            at: At { port: "P".into() },
            drive: Drive::AntiPhase,
            supply: 24.0,
            wired: Wired { divider: Some(11.0), amplifier: Some(62.5) },
            pwm_frequency: Some(5_000),
            amplitude: Some(3.0),
        };
        let right =
            Checked { ok: true, findings: vec![], breakaway_v: [None, None], stall_voltage_v: Some(1.26) };
        let wrong = Checked { ok: false, stall_voltage_v: None, ..right.clone() };
        let told = "--drive anti-phase --supply 24 --divider 11 --amplifier 62.5 --pwm-frequency 5000";
        assert_eq!(
            next(&args, &right).1,
            format!(
                "motorlens capture --port P --programme default --counts-per-rev COUNTS {told} --stall-voltage 1.3 --out logs"
            )
        );
        assert_eq!(next(&args, &wrong).1, format!("motorlens device check --port P {told} --amplitude 3"));
        (args.drive, args.supply) = (Drive::Brake, SUPPLY_V);
        (args.wired, args.pwm_frequency, args.amplitude) = (Wired::default(), None, None);
        assert_eq!(next(&args, &wrong).1, "motorlens device check --port P");
    }
}
