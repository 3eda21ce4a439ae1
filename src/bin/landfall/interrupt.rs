//! Ctrl-C handling for commands that print partial results.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::SIGINT;
use signal_hook::flag;

/// Set by the first Ctrl-C; the second ends the program at once.
pub fn watched() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    // In this order: the second handler checks the flag that the first sets. Without signals,
    // Ctrl-C ends the program.
    let second = flag::register_conditional_default(SIGINT, Arc::clone(&stop));
    if second.is_ok() {
        let _ = flag::register(SIGINT, Arc::clone(&stop));
    }
    stop
}
