//! Ctrl-C while a motor runs: it stops the motor, and not this program.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Becomes true with Ctrl-C, from now on.
pub(super) fn interrupted() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    std::thread::spawn(move || {
        let Ok(runtime) = tokio::runtime::Builder::new_current_thread().enable_all().build() else { return };
        runtime.block_on(async {
            while tokio::signal::ctrl_c().await.is_ok() {
                // Asked twice is asked once: the run ends in either way, at the latest when the board falls silent.
                raised.store(true, Ordering::Relaxed);
            }
        });
    });
    flag
}
