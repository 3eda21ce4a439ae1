//! Names that the configuration gives to structures, blocks and shaders' modules.

use std::cell::RefCell;

use rustc_hash::FxHashSet;

use landfall_layout::ShaderLayout;
use landfall_layout::diagnostic::{Code, Diagnostic, Severity};
use landfall_layout::text::edit_distance::suggestion;

use super::{RustOptions, names};
use crate::refusal::declared_names;

/// The renames, and which of them were used.
#[derive(Default)]
pub(super) struct Renames {
    /// The items to rename, each with its new name.
    all: Vec<(String, String)>,
    /// How many of them, from the first, name something of these shaders.
    needed: usize,
    used: RefCell<FxHashSet<usize>>,
}

impl Renames {
    /// Reads the renames; one whose new name Rust does not take is reported and left out.
    pub(super) fn new(options: &RustOptions) -> (Renames, Vec<Diagnostic>) {
        let all = options.rename.iter().chain(&options.project_renames).cloned();
        let (good, bad): (Vec<_>, Vec<_>) = all.partition(|(_, new)| names::is_identifier(new));
        let bad = bad.into_iter().map(|(old, new)| {
            let message = format!("`{old}` cannot be renamed `{new}`: it is no name in Rust");
            Diagnostic::without_place(Code::BadName, Severity::Error, message)
                .with_help("a name has ASCII letters, digits and underscores, and is no keyword")
        });
        // Renames of the project may be for other shaders; those before them were given for these.
        let needed = good.len().min(options.rename.len());
        (Renames { all: good, needed, used: RefCell::default() }, bad.collect())
    }

    /// The new name of a structure or block of a shader: of `lights.frag:Light`, or of `Light`.
    pub(super) fn new_name(&self, input: &str, name: &str) -> Option<&str> {
        let qualified = |old: &str| {
            // A path may contain colons, a name does not.
            let (file, of) = old.rsplit_once(':')?;
            Some(of == name && is_file(file, input))
        };
        // A name with a file is more specific than one for all files.
        self.find(|old| qualified(old) == Some(true)).or_else(|| self.find(|old| old == name))
    }

    /// The new name of a shader's module.
    pub(super) fn of_shader(&self, input: &str) -> Option<&str> {
        self.find(|old| is_file(old, input))
    }

    fn find(&self, is: impl Fn(&str) -> bool) -> Option<&str> {
        let at = self.all.iter().position(|(old, _)| is(old))?;
        self.used.borrow_mut().insert(at);
        Some(&self.all[at].1)
    }

    /// A warning for each rename that nothing was found for.
    pub(super) fn unused(&self, shaders: &[&ShaderLayout], inputs: &[String]) -> Vec<Diagnostic> {
        let used = self.used.borrow();
        let unused =
            self.all[..self.needed].iter().enumerate().filter(|(at, _)| !used.contains(at));
        let mut known: Vec<&str> = inputs.iter().map(String::as_str).collect();
        known.extend(declared_names(shaders));
        unused
            .map(|(_, (old, _))| {
                let message = format!("the rename of `{old}` has no effect: nothing has that name");
                let otherwise =
                    "write the name of a structure or block, `FILE:NAME`, or a shader's file";
                let help = suggestion(old, known.iter().copied());
                Diagnostic::without_place(Code::UnusedOption, Severity::Warning, message)
                    .with_help(help.unwrap_or_else(|| otherwise.to_string()))
            })
            .collect()
    }
}

/// Whether `file` names a shader: its path, or the end of it.
pub(super) fn is_file(file: &str, input: &str) -> bool {
    let rest = input.strip_suffix(file);
    // `b.frag` does not name `ab.frag`: what is before it ends a directory.
    rest.is_some_and(|rest| !file.is_empty() && (rest.is_empty() || rest.ends_with('/')))
}
