//! Project tasks: `cargo xtask test` is the whole test run, the other subcommands are its parts and the tools around it.

mod added_effect;
mod apt;
mod arm;
mod avr;
mod bench;
mod book;
mod browser;
mod cores;
#[path = "../../tests/documented.rs"]
mod documented;
mod emulated;
mod examples;
mod exports;
mod features;
mod fuzz;
mod image;
mod instructions;
mod licences;
mod links;
mod npm;
mod peers;
mod pico;
mod pico2;
mod picos;
mod process;
mod python;
mod real_logs;
mod report;
mod shells;
mod sizes;
mod test;
mod uf2;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// The project's tasks.
#[derive(Parser)]
#[command(bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Run everything: format, lints, documents, licences, tests, the ARM image, the virtual bench.
    Test(test::Options),
    /// Build the image for every board, print its use of flash and RAM against the limits, and prove on the linked image that no
    /// interrupt's handler can panic and that the stack is large enough.
    Sizes {
        /// Images that are built already, instead of every board's
        images: Vec<std::path::PathBuf>,
    },
    /// Build the images for Raspberry Pi Pico and Pico 2 as UF2 files, which their boot loader takes by drag and drop.
    Uf2,
    /// Run the firmware image on the virtual bench and offer its UART on a TCP port.
    Bench(bench::Options),
    /// Write the effects' pages and plots of the book (docs/book) again, from the registry.
    Book,
    /// Run `motorlens discover` on published logs of real motors and print a table.
    RealLogs(real_logs::Options),
    /// Check that every dependency of every workspace has a permissive licence.
    Licences,
    /// Run the paper's search beside that of others (scipy, pygad, pymoo, DEAP, genevo, Octave) and print the ratios.
    Peers,
    /// Fuzz the readers of logs, guided by coverage (needs `cargo install cargo-fuzz`).
    Fuzz(fuzz::Options),
    /// Count the instructions of the host's kernels, or of the firmware, and hold them against the recorded ones.
    Instructions(instructions::Options),
}

fn main() -> anyhow::Result<ExitCode> {
    match Cli::parse().task {
        Task::Test(options) => return Ok(test::run(&options)),
        Task::Sizes { images } if images.is_empty() => sizes::print()?,
        Task::Sizes { images } => sizes::print_of(&images)?,
        Task::Uf2 => drop(uf2::write_all()?),
        Task::Bench(options) => bench::serve(&options)?,
        Task::Book => book::write()?,
        Task::RealLogs(options) => real_logs::print(&options)?,
        Task::Licences => licences::check_all()?,
        Task::Peers => peers::run()?,
        Task::Fuzz(options) => fuzz::run(&options)?,
        Task::Instructions(options) => instructions::check(&options)?,
    }
    Ok(ExitCode::SUCCESS)
}
