//! `simulate` and `reveal`.

use super::Console;
use crate::error::Result;
use crate::simulate::{self, RevealArgs, SimulateArgs};

/// Makes logs.
pub fn run(args: &SimulateArgs, console: &Console) -> Result<()> {
    let simulated = simulate::run(args)?;
    console.answer(&simulated, || {
        let validate: Vec<String> =
            simulated.held_out.iter().map(|p| format!("--validate {}", p.display())).collect();
        let logs: Vec<String> =
            simulated.training.iter().chain(&simulated.repeats).map(|p| p.display().to_string()).collect();
        format!(
            "{simulated}\nnext: motorlens discover {} {} --motor {}",
            logs.join(" "),
            validate.join(" "),
            simulated.motor.display()
        )
    });
    Ok(())
}

/// Tells what was hidden.
pub fn reveal(args: &RevealArgs, console: &Console) -> Result<()> {
    let answer = simulate::reveal(args)?;
    console.list(&answer, || answer.to_string());
    Ok(())
}
