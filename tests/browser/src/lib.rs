//! What the browser tests stand on: a headless browser and the program that serves the page.

pub mod board;
mod browser;
mod server;

pub use board::Board;
pub use browser::Browser;
pub use server::{Server, run};

use std::path::PathBuf;

/// The directory where screenshots are kept.
pub fn screenshots() -> PathBuf {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../target/screenshots");
    std::fs::create_dir_all(&root).expect("a directory for screenshots");
    root
}
