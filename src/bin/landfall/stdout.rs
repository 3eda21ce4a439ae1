//! Whether stdout was open when the process began.
//!
//! Before `main` the standard library opens `/dev/null` in the place of a standard stream that is
//! closed, and nobody can tell then that a product goes nowhere; so this looks before that.

#![cfg_attr(
    any(target_os = "linux", target_os = "macos"),
    allow(unsafe_code, reason = "a function that runs before `main` is named in a section")
)]

use std::sync::atomic::{AtomicBool, Ordering};

static CLOSED: AtomicBool = AtomicBool::new(false);

/// Whether stdout was closed.
pub fn was_closed() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

/// Opens no file: that would get the number of the stream that is closed.
#[cfg(any(target_os = "linux", target_os = "macos"))]
extern "C" fn look() {
    let is_there = |path| std::fs::symlink_metadata(path).is_ok();
    // Without `/proc` there is nothing to be seen of any stream.
    let seen = std::fs::metadata("/dev/fd").is_ok();
    CLOSED.store(seen && !is_there("/dev/fd/1"), Ordering::Relaxed);
}

#[cfg(target_os = "linux")]
#[used]
#[unsafe(link_section = ".init_array")]
static LOOK: extern "C" fn() = look;

#[cfg(target_os = "macos")]
#[used]
#[unsafe(link_section = "__DATA,__mod_init_func")]
static LOOK: extern "C" fn() = look;
