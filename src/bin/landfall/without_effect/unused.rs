//! Options of a command that its other options leave without effect.

use std::ffi::OsStr;

use landfall_layout::Error;
use landfall_layout::diagnostic::Code;

use super::{text_of, warn};
#[cfg(feature = "exec")]
use crate::args::{BackendName, VerifierName};
use crate::args::{Command, EmitArgs};
use crate::output::Streams;

pub fn warn_of_options(command: &Command, streams: &Streams) {
    let mut unused: Vec<(String, String)> = Vec::new();
    let mut add = |option: &str, why: &str| unused.push((option.to_string(), why.to_string()));
    if let Command::Emit(args) = command {
        let on =
            args.lang.map_or("without a language".to_string(), |lang| format!("on {}", lang.title));
        unused_of_emit(args).into_iter().for_each(|option| add(option, &on));
    }
    let named = text_of(command).is_some_and(|(text, ..)| text.stdin_filename.is_some());
    // The name is used for standard input only.
    if named && !std::env::args_os().any(|argument| argument == OsStr::new("-")) {
        add("--stdin-filename", "without the input `-`");
    }
    #[cfg(feature = "exec")]
    of_execution(command, &mut add);
    for (option, why) in unused {
        let error = Error::new(option, format!("has no effect {why}"));
        warn(Code::UnusedOption, error, streams);
    }
}

/// The options of `emit` that are for other languages.
fn unused_of_emit(args: &EmitArgs) -> Vec<&'static str> {
    let given = [
        (!args.prefix.is_empty(), "--prefix"),
        (args.vectors.is_some(), "--vectors"),
        (args.crate_visible, "--crate-visible"),
        (args.no_tables, "--no-tables"),
        (args.modules.is_some(), "--modules"),
        (!args.rename.is_empty(), "--rename"),
        (!args.bindings.is_empty(), "--bindings"),
        (!args.types.is_empty(), "--type"),
        (!args.derives.is_empty(), "--derive"),
        (!args.namespace.is_empty(), "--namespace"),
        (!args.include_header.is_empty(), "--include-header"),
    ];
    let options = args.lang.map_or(&[][..], |lang| lang.options);
    // Each language lists the options that it uses.
    let unused = given.iter().filter(|(is, name)| *is && !options.contains(name));
    unused.map(|(_, option)| *option).collect()
}

/// Finds options of the commands that execute shaders.
#[cfg(feature = "exec")]
fn of_execution(command: &Command, add: &mut dyn FnMut(&str, &str)) {
    if let Some(name) = unused_adapter(command) {
        add(&format!("--adapter {name}"), "without `--backend gpu`");
    }
    match command {
        Command::Verify(args) if args.locks.is_some() && !args.record => {
            add("--locks", "without `--record`");
        }
        Command::Render(args) => {
            // `--reference` alone runs no shader; with `--compare`, one may.
            let alone = args.reference && args.compare.is_empty();
            let of_shader = [
                (args.entry.is_some(), "--entry"),
                (!args.bind.is_empty(), "--bind"),
                (args.leave_out, "--leave-out"),
                (args.watch, "--watch"),
            ];
            for (_, option) in of_shader.iter().filter(|(is, _)| *is && alone) {
                add(option, "on the reference, which runs no shader");
            }
            // `--compare cpu` also runs the shader on the interpreter.
            let compares = args.compare.iter().any(|what| what.eq_ignore_ascii_case("cpu"));
            if args.watch && !alone && args.backend != BackendName::Cpu && !compares {
                add("--watch", "without `--backend cpu`");
            }
            let of_picture =
                [(args.out.is_some(), "--out"), (!args.compare.is_empty(), "--compare")];
            for (_, option) in of_picture.iter().filter(|(is, _)| *is && args.print_bind) {
                add(option, "with `--print-bind`, which draws nothing");
            }
        }
        _ => {}
    }
}

/// The adapter named for a command that does not use the GPU.
#[cfg(feature = "exec")]
fn unused_adapter(command: &Command) -> Option<&str> {
    let gpu = BackendName::Gpu;
    let (adapter, is_used) = match command {
        Command::Verify(args) => {
            let used = args.backends.is_empty() || args.backends.contains(&VerifierName::Gpu);
            (&args.adapter, used)
        }
        Command::Bench(args) => {
            (&args.adapter, args.backend.is_empty() || args.backend.contains(&gpu))
        }
        Command::Run(args) => (&args.adapter, args.backend == gpu),
        Command::Stress(args) => (&args.adapter, args.backends.contains(&gpu)),
        Command::Render(args) => {
            let compares = args.compare.iter().any(|what| what.eq_ignore_ascii_case("gpu"));
            (&args.adapter, args.backend == gpu || compares)
        }
        _ => return None,
    };
    adapter.as_deref().filter(|_| !is_used)
}

/// The option by which a command rounds what OpenGL ES declares `mediump` or `lowp`.
pub fn mediump(command: &Command) -> Option<String> {
    #[cfg(feature = "exec")]
    return match command {
        Command::Run(args) => args.floats.mediump.then(|| "--mediump".to_string()),
        Command::Stress(args) => args.floats.mediump.then(|| "--mediump".to_string()),
        Command::Bench(args) => {
            let rounded = args.variants.iter().find(|(_, what)| what.ends_with(":mediump"));
            rounded.map(|(name, what)| format!("--variant {name}={what}"))
        }
        _ => None,
    };
    #[cfg(not(feature = "exec"))]
    {
        let _ = command;
        None
    }
}
