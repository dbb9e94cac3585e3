//! Puts the memory map, which stands at the top of the repository, where the linker finds it, and lays the image out by it.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let source =
        PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("../../memory.x");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    fs::copy(&source, out.join("memory.x")).expect("memory.x stands at the top of the repository");
    println!("cargo:rustc-link-search={}", out.display());
    for argument in ["-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    println!("cargo:rerun-if-changed={}", source.display());
}
