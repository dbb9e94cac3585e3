//! `simulate` and `reveal`.

use super::next::{shell, then};
use super::{Console, wrap};
use crate::error::Result;
use crate::formula::Library;
use crate::simulate::{self, RevealArgs, SimulateArgs};

/// Makes logs.
pub fn run(args: &SimulateArgs, library: &Library, console: &Console) -> Result<()> {
    let simulated = simulate::run(&SimulateArgs { library: library.clone(), ..args.clone() })?;
    console.answer(&simulated, || {
        let validate: Vec<String> =
            simulated.held_out.iter().map(|p| format!("--validate {}", shell(p))).collect();
        let logs: Vec<String> =
            simulated.training.iter().chain(&simulated.repeats).map(|p| shell(p)).collect();
        let command = format!(
            "motorlens discover {} {} --motor {}",
            logs.join(" "),
            validate.join(" "),
            shell(&simulated.motor)
        );
        format!("{simulated}\n{}", then("find what it hides", &command))
    });
    Ok(())
}

/// Tells what was hidden.
pub fn reveal(args: &RevealArgs, console: &Console) -> Result<()> {
    let answer = simulate::reveal(args)?;
    console.list(&answer, || wrap::listed(&answer.to_string()));
    let directory = shell(&args.directory);
    console.next(
        "see how well its logs show that",
        &format!("motorlens report {directory}/*.csv --motor {directory}/motor.toml --out report.html"),
    );
    Ok(())
}
