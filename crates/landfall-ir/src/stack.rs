//! A thread with a large stack, for functions that recurse over a shader.

use landfall_layout::Diagnostic;
use landfall_layout::diagnostic::Code;
use landfall_layout::source::Span;

/// The size of the stack in bytes; only the part that the nesting needs is touched.
const STACK: usize = 256 << 20;

/// Runs a function that recurses over a shader, so that a deeply nested text does not overflow the
/// stack.
pub(super) fn on_a_large_stack<T: Send>(
    run: impl FnOnce() -> Result<T, Vec<Diagnostic>> + Send,
) -> Result<T, Vec<Diagnostic>> {
    // WebAssembly has the one stack that its linker was told of, and no threads.
    if cfg!(target_family = "wasm") {
        return run();
    }
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, run);
        let message = match thread.map(|thread| thread.join()) {
            Ok(Ok(result)) => return result,
            Ok(Err(_)) => "landfall failed on this shader; please report it",
            Err(_) => "not enough memory for another thread",
        };
        Err(vec![Diagnostic::error(Code::CannotRun, Span::default(), message)])
    })
}
