//! Puts the chip's memory map where the linker finds it, and lays the image out by it.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let source = if env::var_os("CARGO_FEATURE_PICO2").is_some() { "rp2350.x" } else { "rp2040.x" };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    fs::copy(source, out.join("memory.x")).expect("the memory map stands beside this file");
    println!("cargo:rustc-link-search={}", out.display());
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    println!("cargo:rerun-if-changed={source}");
}
