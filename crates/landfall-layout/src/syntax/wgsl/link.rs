//! Puts a shader together from the modules and files it imports: WESL, naga_oil, and files that are
//! included as text.
//!
//! The shader's own text comes first and keeps its names; what it uses of other modules follows, each
//! declaration once. Where two have one name, the later one gets another. Imports that nothing uses
//! need not resolve.

mod conditions;
mod imports;
mod lines;
mod packages;
mod parts;
mod references;
mod resolve;
mod visibility;

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::lexer::WgslLexer;
use super::outline::{self, Class, Outline};
use super::report::Reports;
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::other_language::refuse_text;
use crate::source::joined::{Joined, Linked};
use crate::source::{Files, Language, ReadOptions, Source, Span, has_language};
use crate::syntax::glsl::Texts;
use imports::Import;
use packages::Packages;
use visibility::is_wesl;

/// The limit on modules and included files of one shader.
const MAX_FILES: usize = 1 << 14;

const DEEPEST_INCLUSION: u32 = 200;

const MAX_BYTES: usize = 64 << 20;

const OWN_FILE: u32 = 1;

const ROOT: usize = 0;

/// A shader whose imports cannot be resolved.
pub(crate) struct Unlinked {
    pub(crate) files: Files,
    pub(crate) diagnostics: Vec<Diagnostic>,
}

/// Returns the shader with all that it imports, its conditions applied, and the warnings about that;
/// `None` where it imports nothing and has no conditions.
///
/// # Errors
/// What is wrong with an import, a condition, or a file that is included.
pub(crate) fn linked(
    source: &Source,
    options: &ReadOptions,
) -> Result<Option<(Source, Vec<Diagnostic>)>, Box<Unlinked>> {
    let is_path = options.structure.as_ref().is_some_and(|name| name.contains("::"));
    let may_link = may_import(&source.text) || is_wesl(Path::new(&source.path));
    let may_link = may_link || !preludes(options).is_empty() || is_path;
    if source.linked.is_some() || !may_link {
        return Ok(None);
    }
    let texts = Texts::new();
    let mut linker = Linker::new(source, options, &texts);
    let linked = linker.link();
    let mut files = linker.files;
    let mut diagnostics = linker.warnings.all;
    match linked {
        _ if !linker.errors.all.is_empty() => {
            diagnostics.extend(linker.errors.all);
            Err(Box::new(Unlinked { files, diagnostics }))
        }
        Ok(joined) if joined.text == *source.text => Ok(None),
        Ok(joined) => {
            let text: Arc<str> = joined.text.as_str().into();
            files.join(joined);
            let is_complete = diagnostics.is_empty();
            let linked = Arc::new(Linked { files, structure: linker.structure, is_complete });
            Ok(Some((Source { text, linked: Some(linked), ..source.clone() }, diagnostics)))
        }
        Err(found) => {
            diagnostics.push(found);
            Err(Box::new(Unlinked { files, diagnostics }))
        }
    }
}

/// The preludes that are not GLSL.
fn preludes(options: &ReadOptions) -> Vec<PathBuf> {
    let preludes = options.preludes.iter();
    preludes.filter(|path| !has_language(path, Language::Glsl)).cloned().collect()
}

/// Whether a text may have imports or conditions; comments and strings may look so too.
fn may_import(text: &str) -> bool {
    let has = |what: &str| memchr::memmem::find(text.as_bytes(), what.as_bytes()).is_some();
    has("#") || has("import") || has("::") || has("@if") || has("@el")
}

fn take_path_separator(lexer: &mut WgslLexer<'_>) -> bool {
    let mut ahead = lexer.clone();
    let is_there = ahead.take(b':') && ahead.take(b':');
    if is_there {
        *lexer = ahead;
    }
    is_there
}

/// A module: a file with what it includes as text.
struct LinkedModule<'a> {
    /// The path as it was found, for `super` and `package`.
    file: PathBuf,
    joined: Rc<Joined>,
    /// The text of `joined`, which the outline borrows.
    text: &'a str,
    outline: Rc<Outline<'a>>,
    /// What its imports stand for.
    aliases: FxHashMap<String, Import>,
    directives: Vec<(u32, u32)>,
}

/// A declaration by its module and its index there.
type Target = (usize, usize);

enum Referent {
    Declaration(Target),
    /// A number that the program gives: `constants::NAME`.
    Value(String),
}

struct Linker<'a> {
    options: &'a ReadOptions,
    texts: &'a Texts,
    files: Files,
    loaded: FxHashMap<PathBuf, u32>,
    bytes: usize,
    depth: u32,
    packages: Packages<'a>,
    /// The definitions of naga_oil and flags of WESL.
    defines: FxHashMap<String, String>,
    /// Whether a file has lines of naga_oil, whose modules are found by the path they state.
    is_naga_oil: bool,
    /// The files that are included as text already.
    included: FxHashSet<u32>,
    modules: Vec<LinkedModule<'a>>,
    by_file: FxHashMap<u32, usize>,
    /// The modules at paths in modules.
    by_path: FxHashMap<(usize, Vec<String>), Sought>,
    /// The declarations of other modules that are used, in the order of the text.
    used: Vec<Target>,
    known: FxHashSet<Target>,
    /// Those that a local name would hide where they are used under another name.
    hidden: FxHashSet<Target>,
    /// The local names of all functions.
    locals: FxHashSet<String>,
    /// The names that no module declares, predeclared ones above all.
    free: FxHashSet<String>,
    /// The names of declarations that the shader imports publicly.
    exported: FxHashMap<Target, String>,
    /// The name in the text of all of the structure that is to be laid out.
    structure: Option<String>,
    warnings: LinkFindings,
    errors: LinkFindings,
}

/// Findings, of those with one message the first.
#[derive(Default)]
struct LinkFindings {
    all: Vec<Diagnostic>,
    messages: FxHashSet<String>,
}

impl LinkFindings {
    fn add(&mut self, finding: Diagnostic) {
        if self.messages.insert(finding.message.clone()) {
            self.all.push(finding);
        }
    }
}

/// Where a module was looked for, and its index.
type Sought = (Rc<[PathBuf]>, Option<usize>);

impl<'a> Linker<'a> {
    fn new(source: &Source, options: &'a ReadOptions, texts: &'a Texts) -> Linker<'a> {
        let mut linker = Linker {
            options,
            texts,
            files: Files::default(),
            loaded: FxHashMap::default(),
            bytes: 0,
            depth: 0,
            packages: Packages::new(options),
            defines: options.defines.iter().cloned().collect(),
            is_naga_oil: false,
            included: FxHashSet::default(),
            modules: Vec::new(),
            by_file: FxHashMap::default(),
            by_path: FxHashMap::default(),
            used: Vec::new(),
            known: FxHashSet::default(),
            hidden: FxHashSet::default(),
            locals: FxHashSet::default(),
            free: FxHashSet::default(),
            exported: FxHashMap::default(),
            structure: None,
            warnings: LinkFindings::default(),
            errors: LinkFindings::default(),
        };
        // The first is the text of all, once it is known; the second the shader's own.
        linker.files.add(source.path.clone(), source.text.clone());
        let own = linker.files.add(source.path.clone(), source.text.clone());
        debug_assert_eq!(own, OWN_FILE, "places in the shader's own text have this number");
        linker.loaded.insert(PathBuf::from(&source.path), own);
        linker
    }

    /// Returns the text of the shader and of what it uses.
    // 1. The shader's own module is read whole; each path in it that leads to another module adds
    // the declaration there to `used`. 2. Each of these is read in turn, and may add more: a walk
    // over the graph of declarations, each entered once. 3. Names are given when all are known,
    // since any two may clash. 4. The texts are written one after the other, with the names
    // changed.
    fn link(&mut self) -> Result<Joined, Diagnostic> {
        self.add_module(OWN_FILE)?;
        let mut parts = vec![self.part(ROOT, None)];
        self.export();
        let structure = self.named_structure();
        let mut next = 0;
        while let Some(&(module, index)) = self.used.get(next) {
            parts.push(self.part(module, Some(index)));
            next += 1;
        }
        let names = self.names();
        self.structure = structure.map(|target| self.name_of(target, &names).to_string());
        let mut joined = Joined::default();
        // Directives come before all declarations.
        for module in self.modules.iter().skip(1) {
            for &(start, end) in &module.directives {
                joined.push_part(&module.joined, start, end);
                joined.push("\n", Span::default());
            }
        }
        for (number, part) in parts.iter().enumerate() {
            if number > 0 {
                joined.push("\n", Span::default());
            }
            self.write(part, &names, &mut joined);
        }
        Ok(joined)
    }

    // --- Files ---

    fn text(&self, file: u32) -> Arc<str> {
        self.files.get(file).map_or_else(|| "".into(), |file| file.text.clone())
    }

    fn path(&self, file: u32) -> PathBuf {
        self.files.get(file).map_or_else(PathBuf::new, |file| PathBuf::from(&file.path))
    }

    fn load(&mut self, path: &Path, at: Span) -> Result<u32, Diagnostic> {
        if let Some(&file) = self.loaded.get(path) {
            return Ok(file);
        }
        let shown = path.display().to_string();
        if let Some(text) = self.options.known_text(path) {
            return self.add_file(path, shown, text, at);
        }
        let failed = |error: crate::Error| {
            Diagnostic::error(Code::Include, at, format!("`{shown}` {}", error.message))
        };
        let (text, _) = self.options.read_file(path).map_err(failed)?;
        refuse_text(path, &text).map_err(failed)?;
        self.options.keep_text(path, &text);
        self.add_file(path, shown, text, at)
    }

    fn add_file(
        &mut self,
        path: &Path,
        shown: String,
        text: Arc<str>,
        at: Span,
    ) -> Result<u32, Diagnostic> {
        self.bytes += text.len();
        if self.loaded.len() >= MAX_FILES || self.bytes > MAX_BYTES {
            let message = format!("imports read more than {MAX_FILES} files or {MAX_BYTES} bytes");
            return Err(Diagnostic::error(Code::IncludeBomb, at, message));
        }
        let file = self.files.add(shown, text);
        self.loaded.insert(path.to_path_buf(), file);
        Ok(file)
    }

    /// Reads something nested, unless it is too deep.
    fn enter<T>(
        &mut self,
        at: Span,
        read: impl FnOnce(&mut Self) -> Result<T, Diagnostic>,
    ) -> Result<T, Diagnostic> {
        if self.depth >= DEEPEST_INCLUSION {
            let message = format!("files are included more than {DEEPEST_INCLUSION} deep");
            return Err(Diagnostic::error(Code::IncludeBomb, at, message));
        }
        self.depth += 1;
        let result = read(self);
        self.depth -= 1;
        result
    }

    /// Returns the file that is included as text by a name.
    fn find_text(&self, from: u32, name: &str) -> Option<PathBuf> {
        self.packages.text(&self.path(from), name.trim_matches(['"', '<', '>'])).1
    }

    /// Whether a module of naga_oil has a path.
    fn is_module(&mut self, from: u32, path: &str) -> bool {
        let from = self.path(from);
        !self.packages.named(&from, path).is_empty()
    }

    fn no_text(&self, from: u32, name: &str, at: Span) -> Diagnostic {
        let (places, _) = self.packages.text(&self.path(from), name);
        not_found(format!("`{name}` not found"), &places, at)
            .with_help("pass its directory with `-I DIR`")
    }

    /// Returns the value of a definition; 0 where the number of a binding needs one that is missing.
    fn value(&mut self, name: &str, at: Span, before: &str) -> Result<Option<String>, Diagnostic> {
        if let Some(value) = self.defines.get(name) {
            return Ok(Some(value.clone()));
        }
        let text = self.text(at.file);
        let written = &text[at.start as usize..at.end as usize];
        if !written.contains(['{', ':']) {
            return Ok(None);
        }
        let message = format!("`{name}` has no value");
        let help = format!("pass `-D {name}=VALUE`");
        let before = before.trim_end();
        if before.ends_with("@group(") || before.ends_with("@binding(") {
            let warning = Diagnostic::warning(Code::UndefinedMacro, at, message);
            let warning = warning.with_note("0 stands for it; offsets do not depend on it");
            self.warnings.add(warning.with_help(help));
            return Ok(Some("0".to_string()));
        }
        Err(Diagnostic::error(Code::UndefinedMacro, at, message).with_help(help))
    }

    // --- Modules ---

    /// Reads a file as a module; returns its index.
    // Stages, each on the result of the one before: lines with `#`, `public` and `private`, `@if`,
    // imports, outline. All but the first put blanks for what they take out, so places stay.
    fn add_module(&mut self, file: u32) -> Result<usize, Diagnostic> {
        if let Some(&known) = self.by_file.get(&file) {
            return Ok(known);
        }
        let is_root = file == OWN_FILE;
        let mut lines = lines::Lines::default();
        if is_root {
            for prelude in preludes(self.options) {
                let prelude = self.load(&prelude, Span::default())?;
                lines::read(self, prelude, &mut lines)?;
                lines.text.push("\n", Span::default());
            }
        }
        lines::read(self, file, &mut lines)?;
        let joined = lines.text;
        let placed = |mut error: Diagnostic, joined: &Joined| {
            error.labels.iter_mut().for_each(|label| label.at = joined.place(label.at));
            error
        };
        let defines = &self.defines;
        let is_set = |flag: &str| defines.get(flag).is_some_and(|value| value != "false");
        let (joined, public) = match is_wesl(&self.path(file)) {
            true => {
                let (text, public) = visibility::removed(&joined.text);
                (joined.with_text(text), public)
            }
            false => (joined, Vec::new()),
        };
        let text = conditions::applied(&joined.text, &is_set).map_err(|e| placed(e, &joined))?;
        let joined = joined.with_text(text);
        let head = imports::head(&joined.text, &public).map_err(|e| placed(e, &joined))?;
        let mut all = head.imports;
        for import in &mut all {
            import.at = joined.place(import.at);
        }
        all.extend(lines.imports);
        let joined = joined.with_text(head.text);
        let text: &'a str = self.texts.alloc(joined.text.as_str().into());
        let mut reports = Reports::default();
        let outline = outline::read(text, &mut reports);
        // Those of the shader itself are found again when its text is read.
        if !is_root {
            let found = reports.finish().into_iter();
            for found in found.filter(|found| found.severity == Severity::Error) {
                self.fail(placed(found, &joined));
            }
        }
        let mut aliases: FxHashMap<String, Import> = FxHashMap::default();
        for import in all {
            let declared = outline.names.get(import.alias.as_str());
            // naga_oil takes a function for one that its module imports but no other declares.
            if self.is_naga_oil && declared.is_some_and(|&at| outline.items[at].class == Class::Fn)
            {
                continue;
            }
            let declared = declared.map(|&index| joined.place(outline.items[index].name_span));
            let before = aliases.get(&import.alias).filter(|known| known.path != import.path);
            if let Some(first) = declared.or(before.map(|known| known.at)) {
                self.fail(super::report::duplicate(&import.alias, import.at, first));
            }
            aliases.insert(import.alias.clone(), import);
        }
        self.by_file.insert(file, self.modules.len());
        self.modules.push(LinkedModule {
            file: self.path(file),
            joined: Rc::new(joined),
            text,
            outline: Rc::new(outline),
            aliases,
            directives: head.directives,
        });
        Ok(self.modules.len() - 1)
    }

    /// Returns the structure that is to be laid out, by its name in the shader or its path.
    fn named_structure(&mut self) -> Option<Target> {
        let path = self.options.structure.as_ref()?;
        let path: Vec<String> = path.split("::").map(|name| name.trim().to_string()).collect();
        match self.referent(ROOT, &path, Span { file: OWN_FILE, ..Span::default() }, "") {
            Ok(Some(Referent::Declaration(target))) => {
                self.used_name(target);
                Some(target)
            }
            // The reader of the text reports a name that is none.
            Ok(Some(Referent::Value(_)) | None) => None,
            Err(error) => {
                self.fail(error);
                None
            }
        }
    }

    // --- Findings ---

    /// Reports that the name of a comparison has no definition.
    fn undefined_condition(&mut self, name: &str, at: Span) {
        let message = format!("`{name}` is not defined, so this condition does not hold");
        let found = Diagnostic::warning(Code::UndefinedMacro, at, message);
        self.warnings.add(found.with_help(format!("pass `-D {name}=VALUE`")));
    }

    /// Reports an error, and goes on: there may be more of its kind.
    fn fail(&mut self, error: Diagnostic) {
        self.errors.add(error);
    }

    /// Reports an error in a function as a warning.
    fn warn(&mut self, error: Diagnostic) {
        let warning = Diagnostic { severity: Severity::Warning, ..error };
        let note = "a function needs it; offsets do not depend on it";
        self.warnings.add(warning.with_note(note));
    }
}

fn not_found(message: String, places: &[PathBuf], at: Span) -> Diagnostic {
    let mut error = Diagnostic::error(Code::MissingInclude, at, message);
    let mut seen = FxHashSet::default();
    for place in places.iter().filter(|place| seen.insert(*place)).take(8) {
        error = error.with_note(format!("looked for `{}`", place.display()));
    }
    error
}

/// Returns a text of the same length with blanks in some ranges.
fn blanked(text: &str, ranges: &[(u32, u32)]) -> String {
    let ranges = ranges.iter().map(|&(start, end)| start as usize..end as usize);
    crate::syntax::blanked(text, ranges)
}
