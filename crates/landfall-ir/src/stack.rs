//! Threads with a large stack, for functions that recurse over a shader.
//!
//! Starting one takes longer than lowering a small shader, so that a program that reads many does
//! all its work on such threads.

use std::any::Any;
use std::cell::Cell;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread::{self, Builder, Scope, ScopedJoinHandle};

#[cfg(feature = "lowering")]
use landfall_layout::diagnostic::{Code, Diagnostic};
#[cfg(feature = "lowering")]
use landfall_layout::source::Span;

/// The size of the stack in bytes; only the part that the nesting needs is touched.
const STACK: usize = 256 << 20;

/// The usual size of the stack of a process, in bytes.
const PROCESS_STACK: usize = 8 << 20;

thread_local! {
    static IS_LARGE: Cell<bool> = const { Cell::new(false) };
}

#[derive(Debug)]
pub enum StackError {
    /// There is not enough memory for another thread; the function was not called.
    Memory,
    Panic(Box<dyn Any + Send>),
}

/// Runs a function on this thread if its stack is large, else on another one.
///
/// # Errors
/// A panic of the function, or not enough memory for another thread.
pub fn on_a_large_stack<T: Send>(run: impl FnOnce() -> T + Send) -> Result<T, StackError> {
    // WebAssembly has the one stack that its linker was told of, and no threads.
    if cfg!(target_family = "wasm") {
        return Ok(run());
    }
    // A thread that has a large stack does not start another for each nested call.
    if IS_LARGE.get() {
        return catch_unwind(AssertUnwindSafe(run)).map_err(StackError::Panic);
    }
    thread::scope(|scope| match spawn_large(scope, run) {
        Ok(thread) => thread.join().map_err(StackError::Panic),
        Err(_) => Err(StackError::Memory),
    })
}

/// Starts a thread with a large stack if that of this one is large, else with that of a process.
///
/// # Errors
/// There is not enough memory for it, or there are too many threads.
pub fn spawn_alike<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    run: impl FnOnce() -> T + Send + 'scope,
) -> io::Result<ScopedJoinHandle<'scope, T>> {
    match IS_LARGE.get() {
        true => spawn_large(scope, run),
        false => Builder::new().stack_size(PROCESS_STACK).spawn_scoped(scope, run),
    }
}

fn spawn_large<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    run: impl FnOnce() -> T + Send + 'scope,
) -> io::Result<ScopedJoinHandle<'scope, T>> {
    let marked = || {
        IS_LARGE.set(true);
        run()
    };
    Builder::new().stack_size(STACK).spawn_scoped(scope, marked)
}

/// Runs a function over a shader on a large stack; what keeps it from returning is an error of the
/// shader.
#[cfg(feature = "lowering")]
pub(super) fn over_shader<T: Send>(
    run: impl FnOnce() -> Result<T, Vec<Diagnostic>> + Send,
) -> Result<T, Vec<Diagnostic>> {
    on_a_large_stack(run).unwrap_or_else(|error| {
        let message = match error {
            StackError::Panic(_) => "landfall failed on this shader; please report it",
            StackError::Memory => "not enough memory for another thread",
        };
        Err(vec![Diagnostic::error(Code::CannotRun, Span::default(), message)])
    })
}
