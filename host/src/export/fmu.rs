//! A unit for co-simulation (FMI 3.0): the exported C program, its description, its source, and a binary for this machine.
//!
//! The binary is compiled by the C compiler that is found as `$CC`, else `cc`. Without one the unit holds its source and a build
//! description alone, which importers that compile can use. Layout and functions: FMI 3.0 specification, 2.5 and 4.

use std::io::{Cursor, Write};
use std::process::Command;

use zip::write::{SimpleFileOptions, ZipWriter};

use super::program::{C, export as program};
use super::{Exported, Options};
use crate::error::{Error, Result};
use crate::model_file::Model;

const BUILD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="motor">
    <SourceFileSet language="C99">
      <SourceFile name="motor.c"/>
    </SourceFileSet>
    <Library name="m"/>
  </BuildConfiguration>
</fmiBuildDescription>
"#;

/// The archive.
pub(super) fn export(model: &Model, options: &Options) -> Result<Exported> {
    let mut exported = program(model, options, &C);
    let source = exported.text();
    let token = format!("motorlens-{:016x}", fingerprint(source.as_bytes()));
    let source = format!(
        "#include <stdbool.h>\n#define INSTANTIATION_TOKEN \"{token}\"\n{source}{}",
        include_str!("fmu.c.in")
    );
    let description = include_str!("modelDescription.xml.in")
        .replace("@TOKEN@", &token)
        .replace("@VERSION@", env!("CARGO_PKG_VERSION"))
        .replace("@STEP@", &format!("{:?}", options.step_s()));

    let mut files: Vec<(String, Vec<u8>)> = vec![
        ("modelDescription.xml".into(), description.into_bytes()),
        ("sources/motor.c".into(), source.clone().into_bytes()),
        ("sources/buildDescription.xml".into(), BUILD.into()),
    ];
    match compiled(&source) {
        Ok(binary) => files.push((format!("binaries/{}/motor{}", platform(), std::env::consts::DLL_SUFFIX), binary)),
        Err(why) => exported.notes.push(format!(
            "The unit holds its source only, for importers that compile it, because {why}; set CC to a C compiler for a binary."
        )),
    }
    exported.content = archive(&files).map_err(|source| Error::Io {
        doing: "cannot write the archive of the FMU".into(),
        source: std::io::Error::other(source),
    })?;
    Ok(exported)
}

/// FNV-1a, so that a unit of another model is another unit.
fn fingerprint(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The name of a platform in FMI 3.0.
fn platform() -> String {
    let system = match std::env::consts::OS {
        "macos" => "darwin",
        other => other,
    };
    format!("{}-{system}", std::env::consts::ARCH)
}

/// The shared library of `source`, or why there is none.
fn compiled(source: &str) -> std::result::Result<Vec<u8>, String> {
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let directory = tempfile::tempdir().map_err(|e| e.to_string())?;
    let (file, library) = (directory.path().join("motor.c"), directory.path().join("motor.so"));
    std::fs::write(&file, source).map_err(|e| e.to_string())?;
    let built = Command::new(&compiler)
        .args(["-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-o"])
        .args([&library, &file])
        .arg("-lm")
        .output()
        .map_err(|_| format!("there is no C compiler \"{compiler}\" here"))?;
    if !built.status.success() {
        let said = String::from_utf8_lossy(&built.stderr);
        return Err(format!("\"{compiler}\" refused it ({})", said.lines().next().unwrap_or_default()));
    }
    std::fs::read(&library).map_err(|e| e.to_string())
}

fn archive(files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, content) in files {
        writer.start_file(name.as_str(), options)?;
        writer.write_all(content)?;
    }
    Ok(writer.finish()?.into_inner())
}
