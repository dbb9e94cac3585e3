//! The compiler for Cortex-M: rustup's where the target is installed, else Debian's.
//!
//! Debian's `rustc-web` and `rust-web-src` carry a compiler and the library source that matches it, from which cargo
//! builds `core` for the target. What that takes is set for the one child process and goes to a target directory of
//! its own, so the host's build never sees it.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::{apt, process};

/// Cortex-M4F and M7F, the boards' core.
pub const CORTEX_M4F: &str = "thumbv7em-none-eabihf";
/// Cortex-M0 and M0+: no FPU, no divide.
pub const CORTEX_M0: &str = "thumbv6m-none-eabi";

/// Cortex-M33 with a floating-point unit.
pub const CORTEX_M33: &str = "thumbv8m.main-none-eabihf";

const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

/// A way to build for one target.
pub struct Compiler {
    target: &'static str,
    debian_linker: Option<PathBuf>,
}

impl Compiler {
    /// Finds what builds for `target`, installing Debian's packages when rustup has not the target.
    pub fn find_or_install(target: &'static str) -> Result<Self> {
        let sysroot = process::output(Command::new("rustc").args(["--print", "sysroot"]))?;
        let libraries = Path::new(sysroot.trim()).join("lib/rustlib");
        if libraries.join(target).join("lib").is_dir() {
            return Ok(Compiler { target, debian_linker: None });
        }
        apt::ensure_apt(&["rustc-web", "rust-web-src"]).with_context(|| {
            format!("no compiler for {target}: neither `rustup target add {target}` nor Debian's rustc-web is here")
        })?;
        Ok(Compiler { target, debian_linker: Some(linker(&libraries)?) })
    }

    /// A cargo command (`build`, `clippy`, ...) in `directory` for the target.
    pub fn cargo(&self, subcommand: &str, directory: &Path) -> Command {
        let mut command = process::cargo();
        command.current_dir(directory).arg(subcommand).args(["--target", self.target]);
        command.env("CARGO_TARGET_DIR", target_directory()).env_remove("RUSTFLAGS");
        if let Some(linker) = &self.debian_linker {
            let variable =
                format!("CARGO_TARGET_{}_LINKER", self.target.to_uppercase().replace(['-', '.'], "_"));
            command
                .arg("-Zbuild-std=core,alloc")
                .env("RUSTC", DEBIAN_RUSTC)
                .env("RUSTC_BOOTSTRAP", "1")
                .env(variable, linker);
        }
        command
    }

    /// Where a release build puts the program `name`.
    pub fn artifact(&self, name: &str) -> PathBuf {
        target_directory().join(self.target).join("release").join(name)
    }
}

/// Everything built for Cortex-M goes here, apart from the host's build.
fn target_directory() -> PathBuf {
    process::root().join("target").join("arm")
}

/// `rust-lld`, which rustup's own tool chain carries; else Debian's `ld.lld`.
fn linker(libraries: &Path) -> Result<PathBuf> {
    let hosts =
        std::fs::read_dir(libraries).with_context(|| format!("cannot list {}", libraries.display()))?;
    for host in hosts {
        let candidate = host?.path().join("bin/rust-lld");
        if candidate.is_file() {
            return Ok(candidate);
        }
    }
    apt::ensure_apt(&["lld"])?;
    let debian = PathBuf::from("/usr/bin/ld.lld");
    if !debian.is_file() {
        bail!("no linker for Cortex-M: neither rust-lld in the tool chain nor {}", debian.display());
    }
    Ok(debian)
}

/// The directory of the board image's own workspace.
fn image_directory() -> PathBuf {
    process::root().join("firmware/stm32f4")
}

/// A board that the image can be built for.
pub struct Board {
    /// The feature that stands for it.
    pub feature: &'static str,
}

/// Every board; the first is the one that the virtual bench emulates.
pub const BOARDS: [Board; 3] =
    [Board { feature: "stm32f407" }, Board { feature: "nucleo-f446re" }, Board { feature: "blackpill-f411" }];

/// Builds the emulated board's image and returns its ELF.
pub fn build_image() -> Result<PathBuf> {
    build_image_for(&BOARDS[0])
}

/// Builds a board's image as the README has it and returns its ELF.
pub fn build_image_for(board: &Board) -> Result<PathBuf> {
    let compiler = Compiler::find_or_install(CORTEX_M4F)?;
    let mut build = compiler.cargo("build", &image_directory());
    process::run(build.args(["--release", "--no-default-features", "--features", board.feature]))?;
    // A name of its own: the next board's image takes the place of this one.
    let image = compiler.artifact("motorlens-stm32f4");
    let kept = image.with_file_name(format!("motorlens-{}", board.feature));
    std::fs::copy(&image, &kept).with_context(|| format!("cannot copy {}", image.display()))?;
    Ok(kept)
}

/// A Pico that the image in `firmware/rp` can be built for.
pub struct Pico {
    /// The feature that stands for it.
    pub feature: &'static str,
    /// The core's target.
    target: &'static str,
    /// The chip's family in UF2 files.
    pub family: u32,
}

/// The Picos, of which the tests emulate each: in [`crate::pico`] and in [`crate::pico2`].
pub const PICOS: [Pico; 2] = [
    Pico { feature: "pico", target: CORTEX_M0, family: 0xe48b_ff56 },
    Pico { feature: "pico2", target: CORTEX_M33, family: 0xe48b_ff59 },
];

/// The directory of the Picos' own workspace.
fn pico_directory() -> PathBuf {
    process::root().join("firmware/rp")
}

/// Builds a Pico's image and returns its ELF.
pub fn build_pico(pico: &Pico) -> Result<PathBuf> {
    let compiler = Compiler::find_or_install(pico.target)?;
    let mut build = compiler.cargo("build", &pico_directory());
    process::run(build.args(["--release", "--no-default-features", "--features", pico.feature]))?;
    Ok(compiler.artifact("motorlens-rp"))
}

/// Builds the release program `name` of the workspace in `directory` and returns its ELF.
pub fn build_program(target: &'static str, directory: &Path, name: &str) -> Result<PathBuf> {
    let compiler = Compiler::find_or_install(target)?;
    process::run(compiler.cargo("build", directory).arg("--release"))?;
    Ok(compiler.artifact(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the README's first command for a board builds, which names none.
    #[test]
    fn the_nucleo_is_the_board_that_is_built_where_none_is_named() {
        let manifest = std::fs::read_to_string(image_directory().join("Cargo.toml")).expect("the manifest");
        let default = format!("default = [\"{}\"]", BOARDS[1].feature);
        assert!(manifest.lines().any(|line| line == default), "no {default} in {manifest}");
        assert_eq!(BOARDS[1].feature, "nucleo-f446re");
    }
}
