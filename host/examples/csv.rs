//! The same from log files, with records to judge by and a motor file.
//!
//! `cargo run --release --example csv -- LOG... [--validate LOG] [--motor motor.toml]`

use std::ops::ControlFlow;
use std::path::Path;

use motorlens::log::{ReadOptions, read};
use motorlens::{Options, Result, discover_records, motor_file};

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let (mut logs, mut options) = (Vec::new(), Options::default());
    let mut validate = Vec::new();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--validate" => validate.extend(arguments.next()),
            "--motor" => options.motor = motor_file::read(Path::new(&arguments.next().unwrap_or_default()))?,
            _ => logs.push(argument),
        }
    }
    let reading = ReadOptions { motor: options.motor.clone(), ..ReadOptions::default() };
    let records = |paths: &[String]| -> Result<Vec<_>> {
        let each = paths.iter().map(|path| read(Path::new(path), &reading)).collect::<Result<Vec<_>>>()?;
        Ok(each.into_iter().flatten().collect())
    };
    options.validation = records(&validate)?;
    let found = discover_records(&records(&logs)?, &options, &mut |_| ControlFlow::Continue(()))?;
    println!("{}", found.findings.headline);
    found.model.write(Path::new("model.json"))
}
