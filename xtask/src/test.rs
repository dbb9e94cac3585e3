//! The whole test run.

use std::process::ExitCode;

use anyhow::Result;
use clap::Args;

use crate::report::{Count, Report};
use crate::{
    added_effect, avr, bench, book, browser, cores, examples, exports, features, instructions, licences,
    pico, pico2, process, python, shells, sizes,
};

/// What to run.
#[derive(Args)]
pub struct Options {
    /// Run only the parts whose name contains this.
    #[arg(long)]
    only: Option<String>,
}

/// A part of the run: its name and what it does.
type Part = (&'static str, fn() -> Result<Count>);

/// Every part, cheap ones first so that a slip shows early.
const PARTS: [Part; 23] = [
    ("format", || one(format())),
    ("licences", || one(licences::check_all())),
    ("lints", || {
        let lint = ["clippy", "--workspace", "--all-targets", "--locked", "--", "-D", "warnings"];
        one(process::run(process::cargo().args(lint)))
    }),
    ("documents", || {
        let mut doc = process::cargo();
        doc.args(["doc", "--workspace", "--no-deps", "--locked"]).env("RUSTDOCFLAGS", "-D warnings");
        one(process::run(&mut doc))
    }),
    ("book rendered by mdBook", book::tests),
    ("host tests", || {
        let mut tests = process::cargo();
        tests.args(["test", "--workspace", "--locked", "--no-fail-fast"]).env("MOTORLENS_LONG_TESTS", "1");
        process::run_tests(&mut tests)
    }),
    ("examples of the library", examples::tests),
    ("library with each feature alone, and with none", features::tests),
    ("an effect is added by its file and its row", || one(added_effect::check())),
    ("exports in their tools", exports::tests),
    ("completions in their shells, manual pages in man", shells::tests),
    ("Python package", python::tests),
    ("instructions of the kernels", || one(instructions::check(&instructions::Options::default()))),
    ("decoders of host and board on ten million inputs each", || {
        let test = ["test", "--release", "-p", "motorlens-shared", "--test", "link_any_bytes"];
        process::run_tests(process::cargo().args(test))
    }),
    // These also show that what runs on boards needs neither std nor, here, an FPU.
    ("quick fit on an emulated Cortex-M0", || one(cores::cortex_m0())),
    ("a run and its fit on an emulated Cortex-M33, the Pico 2's core", || one(cores::cortex_m33())),
    ("images of all boards: sizes, stack, no panic in interrupts", || one(sizes::print())),
    ("instructions on the board", || {
        one(instructions::check(&instructions::Options { board: true, ..Default::default() }))
    }),
    ("virtual bench", bench::tests),
    ("Arduino sketch on an emulated Uno", avr::tests),
    ("Pico images and an emulated Pico", pico::tests),
    ("Pico 2's image on an emulated RP2350", pico2::tests),
    ("browser", browser::tests),
];

/// Runs the parts, prints a summary, fails when anything failed.
pub fn run(options: &Options) -> ExitCode {
    let mut report = Report::default();
    for (name, part) in PARTS {
        if options.only.as_deref().is_none_or(|wanted| name.contains(wanted)) {
            report.part(name, part);
        }
    }
    if report.finish() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The workspaces beside the host's are formatted like it.
fn format() -> Result<()> {
    for manifest in licences::workspaces() {
        process::run(process::cargo().args(["fmt", "--all", "--check", "--manifest-path"]).arg(manifest))?;
    }
    Ok(())
}

/// A part that is one check.
fn one(result: Result<()>) -> Result<Count> {
    result.map(|()| Count::ONE)
}
