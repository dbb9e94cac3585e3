//! Puts the memory map, which stands beside this file, where the linker finds it, and lays the program out by it.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    let here = env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    fs::copy(Path::new(&here).join("memory.x"), out.join("memory.x"))
        .expect("memory.x stands beside build.rs");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rerun-if-changed=memory.x");
}
