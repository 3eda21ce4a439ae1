//! From the command line's words to a shader's source and the options it is laid out with.

use std::io::Read;
use std::path::{Path, PathBuf};

use landfall::{Error, Language, Options, ReadOptions, Rules, Source, source};

use crate::args::ReadArgs;

/// The options all shaders of a run are laid out with.
pub fn options(args: &ReadArgs) -> Options {
    Options {
        read: ReadOptions {
            defines: args.defines.clone(),
            include_dirs: args.include_dirs.clone(),
            overrides: args.overrides.clone(),
            target: args.target.map(|api| api.target()),
        },
        rules: args.rules.as_deref().and_then(Rules::from_name),
        gather: args.gather,
        naga: false,
    }
}

/// Whether a path on the command line means stdin.
pub fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The path stdin goes by.
pub fn stdin_path(args: &ReadArgs) -> PathBuf {
    args.stdin_filename.clone().unwrap_or_else(|| PathBuf::from("<stdin>"))
}

/// Reads one shader.
pub fn source(path: &Path, args: &ReadArgs) -> Result<Source, Error> {
    let mut source = if is_stdin(path) {
        let name = stdin_path(args).display().to_string();
        let mut bytes = Vec::new();
        let failed = |cause| Error::new("<stdin>", format!("cannot be read: {cause}"));
        std::io::stdin().lock().read_to_end(&mut bytes).map_err(failed)?;
        let text = source::decode(&name, bytes)?;
        Source::new(name, text)
    } else {
        Source::read(path)?
    };
    if let Some(language) = args.language {
        source.language = language.language();
    }
    source.stage = match source.language {
        Language::Glsl => args.stage.or(source.stage),
        Language::Wgsl => None,
    };
    Ok(source)
}
