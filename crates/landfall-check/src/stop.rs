//! The flag by which a caller ends a run: on Ctrl-C, or when an editor has a newer text.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that threads share; once set, it stays.
#[derive(Clone, Debug, Default)]
pub struct StopFlag(pub Arc<AtomicBool>);

impl StopFlag {
    /// Sets it.
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it is set: no further input is read, and the results are those so far.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
