//! `device check`: the self-test of the wiring.

use motorlens_shared::link::Setup;
use serde_json::json;

use super::Console;
use super::capture::{Drive, Wired, converse, run_number};
use super::device::At;
use super::interrupt::interrupted;
use crate::device::check::{check, programme, setup};
use crate::device::{Capture, Port, wiring};
use crate::error::{Error, Result};

/// Options of `device check`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub at: At,
    /// How the driver is driven
    #[arg(long, value_enum, default_value = "brake")]
    pub drive: Drive,
    /// Supply of the driver in volts
    #[arg(long, value_name = "VOLTS", default_value_t = 12.0)]
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
    let divider = wiring::divider(args.wired.divider)?;
    let setup = setup(Setup {
        drive: args.drive.mode(),
        supply_mv: wiring::supply(args.supply, divider)?,
        pwm_hz: args.pwm_frequency.unwrap_or(0),
        divider,
        amplifier: wiring::amplifier(args.wired.amplifier)?,
        ..Setup::default()
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
        lines.join("\n")
    });
    let stall = checked.stall_voltage_v.map_or(String::new(), |volts| format!(" --stall-voltage {volts:.1}"));
    let port = &args.at.port;
    if checked.findings.iter().all(|finding| finding.ok) {
        let command = format!(
            "motorlens capture --port {port} --programme default --counts-per-rev COUNTS{stall} --out logs"
        );
        console.next("record the default protocol", &command);
    } else {
        let command = format!("motorlens device check --port {port}");
        console.next("mend what is wrong, and look again", &command);
    }
    Ok(())
}
