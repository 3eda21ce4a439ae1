//! Panics while a shader is read, as errors of that shader.

use std::panic::{AssertUnwindSafe, catch_unwind};

use landfall_layout::diagnostic::Code;
use landfall_layout::{Diagnostic, Error};

/// Runs the work on a shader; a panic is an error of the shader.
///
/// # Errors
///
/// The work panicked, which a build with `panic = "unwind"` alone survives.
pub fn caught<T>(shown: &str, work: impl FnOnce() -> T) -> Result<T, Diagnostic> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        let error = Error::new(shown, "made landfall panic, which is a bug in landfall")
            .with_help("please report it with the file; the other files are not affected");
        Diagnostic { code: Code::InternalError, ..error.into() }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_of_the_shader() {
        let found = caught("a.frag", || -> u32 { panic!("as planned") }).unwrap_err();
        assert_eq!(found.code, Code::InternalError);
        assert!(found.message.contains("made landfall panic"), "{}", found.message);
        assert_eq!(caught("a.frag", || 3).unwrap(), 3);
    }
}
