//! `serve`: the live page.

use std::path::PathBuf;

use super::Console;
use crate::error::Result;
use crate::formula::Library;
use crate::log::{self, ReadArgs};
use crate::serve::{self, Session};

/// Options of `serve`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  motorlens serve run1.csv run2.csv -m motor.toml")]
pub struct Args {
    /// Log files; without any, the demo's
    #[arg(value_name = "LOG")]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    reading: ReadArgs,
    /// Port on this machine; 0 takes any free one
    #[arg(long, value_name = "PORT", default_value_t = 7878)]
    port: u16,
    /// Do not open the page in a browser (only a person at a terminal gets one opened)
    #[arg(long)]
    no_open: bool,
}

/// Serves until interrupted.
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    let session = if args.logs.is_empty() {
        serve::demo()?
    } else {
        let loaded = log::load(&args.logs, &args.reading)?;
        for warning in &loaded.warnings {
            console.say(super::prose::fault(warning));
        }
        Session::of_files(loaded, &args.reading)?
    };
    serve::serve(session, library.clone(), args.port, |address| {
        let url = format!("http://{address}");
        let document = serde_json::json!({ "schema": 1, "url": url });
        console.list(&document, || url.clone());
        console.say("The page is open to this machine only. Ctrl-C ends it.");
        if !args.no_open && console.shows_progress() && !console.json() && open::that_detached(&url).is_err()
        {
            console.say("No browser could be opened; open the address yourself.");
        }
    })
}
