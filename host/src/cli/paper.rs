//! `paper`.

use super::Console;
use crate::error::Result;
use crate::formula::Library;
use crate::paper::{self, PaperArgs};

/// The paper's run, and what it does not say.
pub fn run(args: &PaperArgs, library: &Library, console: &Console) -> Result<()> {
    let args = PaperArgs { library: library.clone(), ..args.clone() };
    let run = paper::run(&args, &mut |line| console.say(line))?;
    console.list(&run, || run.to_string());
    console.next(
        "try the whole loop on such records",
        "motorlens simulate --excitation paper --hidden 1 --out paper-logs",
    );
    Ok(())
}
