//! Panics while a shader is read: errors of that shader where a panic can be caught, else the end of
//! the command.

use std::cell::RefCell;
use std::panic::{self, AssertUnwindSafe, catch_unwind};

use landfall_layout::diagnostic::Code;
use landfall_layout::{Diagnostic, Error};

use crate::watch;

thread_local! {
    /// The shader that this thread works on.
    static SHADER: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs the work on a shader; a panic is an error of the shader.
pub fn caught<T>(shown: &str, work: impl FnOnce() -> T) -> Result<T, Diagnostic> {
    SHADER.set(shown.to_string());
    let done = catch_unwind(AssertUnwindSafe(work));
    SHADER.set(String::new());
    done.map_err(|_| {
        let error = Error::new(shown, "made landfall panic, which is a bug in landfall");
        found(error.with_help("please report it with the file; the other files are not affected"))
    })
}

/// Lets the first panic end the command with an error: for builds with `panic = "abort"`, in which
/// panics of naga cannot be caught either.
pub fn end_command() {
    let print = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        print(info);
        let shown = SHADER.try_with(|shader| shader.take()).unwrap_or_default();
        let (error, with) = match shown.as_str() {
            "" => {
                (Error::new("landfall", "panicked, or naga in it, which is a bug"), "the command")
            }
            _ => (Error::new(shown, "made landfall or naga panic, which is a bug"), "the file"),
        };
        let help = format!(
            "please report it with {with}; this binary was built to end at a panic (profile \
             `small`), those of other profiles go on with the other files"
        );
        watch::end_by(found(error.with_help(help)));
    }));
}

fn found(error: Error) -> Diagnostic {
    Diagnostic { code: Code::InternalError, ..error.into() }
}

#[cfg(test)]
mod tests {
    use std::process::Command;
    use std::{env, thread};

    use super::*;
    use crate::args::Args;
    use crate::output::Streams;
    use clap::Parser;

    /// Set in the process that panics.
    const IN_CHILD: &str = "LANDFALL_TEST_PANICS";

    #[test]
    fn a_panic_that_is_not_caught_ends_the_command_with_an_error() {
        let name = "panics::tests::a_panic_that_is_not_caught_ends_the_command_with_an_error";
        if env::var_os(IN_CHILD).is_none() {
            let test = env::current_exe().unwrap();
            let child = Command::new(test)
                .args(["--exact", name, "--nocapture"])
                .env(IN_CHILD, "1")
                .output();
            let child = child.unwrap();
            let printed = String::from_utf8_lossy(&child.stderr);
            assert_eq!(child.status.code(), Some(2), "{printed}");
            assert_eq!(
                printed.matches("`b.frag` made landfall or naga panic").count(),
                1,
                "{printed}"
            );
            assert!(printed.contains("as planned"), "{printed}");
            return;
        }
        let args = Args::parse_from(["landfall", "layout", "b.frag"]);
        let streams = Streams::new(args.global.color, args.global.quiet);
        watch::begin(&args.command, &args.global.budget, &streams);
        end_command();
        // Of two threads that panic, one error is printed.
        thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(|| caught("b.frag", || panic!("as planned")));
            }
        });
        unreachable!("the process ends at the panic");
    }

    #[test]
    fn a_panic_that_is_caught_is_an_error_of_the_shader() {
        let found = caught("a.frag", || -> u32 { panic!("as planned") }).unwrap_err();
        assert_eq!(found.code, Code::InternalError);
        assert!(found.message.contains("made landfall panic"), "{}", found.message);
        assert_eq!(caught("a.frag", || 3).unwrap(), 3);
    }
}
