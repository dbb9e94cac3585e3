//! What the browser tests stand on: a headless browser and the program that serves the page.

mod browser;
mod server;

pub use browser::Browser;
pub use server::{Server, run};

use std::path::PathBuf;

/// The directory where screenshots are kept.
pub fn screenshots() -> PathBuf {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../target/screenshots");
    std::fs::create_dir_all(&root).expect("a directory for screenshots");
    root
}
