//! Whether stdout was open when the process began.
//!
//! Before `main`, the standard library replaces a closed standard stream by `/dev/null`, which
//! hides that output is lost; so the check runs before that.

#![cfg_attr(
    any(target_os = "linux", target_os = "macos"),
    allow(unsafe_code, reason = "a function that runs before `main` is named in a section")
)]

use std::sync::atomic::{AtomicBool, Ordering};

static CLOSED: AtomicBool = AtomicBool::new(false);

pub fn was_closed() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

/// Opens no file: it would get the number of the closed stream.
#[cfg(any(target_os = "linux", target_os = "macos"))]
extern "C" fn check_stdout() {
    let is_there = |path| std::fs::symlink_metadata(path).is_ok();
    // Without `/dev/fd`, the state of streams is unknown.
    let is_known = std::fs::metadata("/dev/fd").is_ok();
    CLOSED.store(is_known && !is_there("/dev/fd/1"), Ordering::Relaxed);
}

#[cfg(target_os = "linux")]
#[used]
#[unsafe(link_section = ".init_array")]
static CHECK: extern "C" fn() = check_stdout;

#[cfg(target_os = "macos")]
#[used]
#[unsafe(link_section = "__DATA,__mod_init_func")]
static CHECK: extern "C" fn() = check_stdout;
