//! Ctrl-C, for commands that end with what they have.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::SIGINT;
use signal_hook::flag;

/// Set by the first Ctrl-C; the second ends the program at once.
pub fn watched() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    // In this order: what is set by the first is what the second looks at. Where signals cannot
    // be had, Ctrl-C ends the program as it does every other.
    let second = flag::register_conditional_default(SIGINT, Arc::clone(&stop));
    if second.is_ok() {
        let _ = flag::register(SIGINT, Arc::clone(&stop));
    }
    stop
}
