//! A thread with a stack for what recurses over a shader.

use landfall_layout::Diagnostic;
use landfall_layout::diagnostic::Code;
use landfall_layout::source::Span;

/// Bytes of stack for what recurses over a shader's text; it is touched only as far as it nests.
const STACK: usize = 256 << 20;

/// Runs what recurses over a shader; a text that nests deeply does not end the program.
pub(super) fn on_a_large_stack<T: Send>(
    run: impl FnOnce() -> Result<T, Vec<Diagnostic>> + Send,
) -> Result<T, Vec<Diagnostic>> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, run);
        let message = match thread.map(|thread| thread.join()) {
            Ok(Ok(result)) => return result,
            Ok(Err(_)) => "landfall failed on this shader; please report it",
            Err(_) => "there is no memory for a thread",
        };
        Err(vec![Diagnostic::error(Code::CannotRun, Span::default(), message)])
    })
}
