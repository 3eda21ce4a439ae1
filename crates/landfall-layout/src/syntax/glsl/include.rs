//! `#include`: quoted and angled, as `GL_GOOGLE_include_directive` and
//! `GL_ARB_shading_language_include` spell it.

use std::path::{Path, PathBuf};

use rustc_hash::FxHashMap;

use super::dialect;
use super::lexer::{Kind, Lexer, Token};
use super::preprocess::{Preprocessor, TokenSource};
use crate::diagnostic::{Code, Diagnostic};
use crate::file::nearest_path;
use crate::interface::Include;
use crate::source::file_cache::FoundFile;
use crate::source::{Language, Span, has_language};
use crate::syntax::{above, listed};

/// The folders of three.js's chunks, below one above a file.
const CHUNKS: [&str; 2] = ["ShaderChunk", "node_modules/three/src/renderers/shaders/ShaderChunk"];

/// The number of nested includes from which one that includes itself is refused.
// A file may include itself a few times on purpose, with other macros each time.
const DEEPEST_CYCLE: usize = 64;

const DEEPEST_INCLUDE: usize = 512;

const MAX_INCLUDES: usize = 1 << 14;

/// The limit on bytes that includes may add to one shader.
const MAX_INCLUDED: usize = 64 << 20;

impl<'a> Preprocessor<'a> {
    /// Executes `#include`; the line has been read to its end.
    pub(super) fn include(&mut self, directive: Token<'a>) {
        let rest = self.rest_of_line();
        let Some((name, angled)) = self.header_name(rest) else {
            let message = "`#include` expects `\"FILE\"` or `<FILE>`";
            return self.report(Diagnostic::error(Code::Include, directive.span, message));
        };
        let span =
            Span { end: directive.span.end + rest.trim_end().len() as u32, ..directive.span };
        if let Some(cycle) = self.cycle_past_bound() {
            let message = format!("`{name}` includes itself");
            let found = Diagnostic::error(Code::CyclicInclude, span, message).with_note(cycle);
            let help = "guard the file with `#ifndef NAME`, `#define NAME`, `#endif`";
            return self.stop(found.with_help(help));
        }
        self.includes += 1;
        let bomb = match self.frames.len() {
            deep if deep > DEEPEST_INCLUDE => {
                Some(format!("includes are nested more than {DEEPEST_INCLUDE} deep"))
            }
            _ if self.includes > MAX_INCLUDES => {
                Some(format!("the shader has more than {MAX_INCLUDES} includes"))
            }
            _ => None,
        };
        if let Some(message) = bomb {
            return self.stop(Diagnostic::error(Code::IncludeBomb, span, message));
        }
        let is_once = directive.text == "moj_import";
        let (places, found) = self.find(name, angled, span.file);
        let outer = if angled { None } else { self.find_as_glslang(name, span.file) };
        if let (Some(path), Some(outer)) = (&found, &outer) {
            let real = |path: &Path| path.canonicalize().ok();
            // Two paths of one file, by a link or by `..`, are no conflict.
            if path != outer && real(path) != real(outer) {
                let message = format!("`{name}` is read from `{}`", path.display());
                let found = Diagnostic::warning(Code::Include, span, message);
                let note = format!("glslangValidator reads `{}`", outer.display());
                self.diagnostics
                    .push(found.with_note(note).with_help("give one of them another name"));
            }
        }
        let Some(path) = found.or(outer) else {
            if name == "metal_stdlib" {
                let message = "`<metal_stdlib>` is a header of Metal, not GLSL";
                let found = Diagnostic::error(Code::OtherLanguage, span, message);
                return self.stop(found.with_help("landfall reads GLSL and WGSL"));
            }
            let mut diagnostic =
                Diagnostic::error(Code::MissingInclude, span, format!("`{name}` not found"));
            for place in &places {
                diagnostic = diagnostic.with_note(format!("looked for `{}`", place.display()));
            }
            let help = match self.folder_of(name, span.file) {
                Some(folder) => format!("pass `-I {}`", folder.display()),
                None => self
                    .misspelt(name, &places)
                    .unwrap_or_else(|| "pass its directory with `-I DIR`".to_string()),
            };
            return self.report(diagnostic.with_help(help));
        };
        // Minecraft imports a file once.
        if is_once && self.included.contains_key(&path.display().to_string()) {
            return;
        }
        match self.open_include(&path) {
            Ok((file, text)) => {
                self.included_bytes += text.len();
                if self.included_bytes > MAX_INCLUDED {
                    let message = format!("includes add more than {MAX_INCLUDED} bytes");
                    return self.stop(Diagnostic::error(Code::IncludeBomb, span, message));
                }
                let conditions = self.conditions.len();
                self.opened.push(Include { span, file, depth: self.open_files().count() });
                self.frames.push(TokenSource::File {
                    lexer: Lexer::of_file(text, file, self.texts),
                    conditions,
                });
            }
            Err(error) => {
                let message = format!("`{name}` {}", error.message);
                self.report(Diagnostic::error(Code::Include, span, message));
            }
        }
    }

    /// Returns the name between quotes or angle brackets, which may come from a macro.
    fn header_name(&mut self, rest: &'a str) -> Option<(&'a str, bool)> {
        let rest = rest.trim();
        if let Some(name) = rest.strip_prefix('"') {
            return Some((name.split('"').next()?, false));
        }
        if let Some(name) = rest.strip_prefix('<') {
            return Some((name.split('>').next()?, true));
        }
        let token = Lexer::new(rest, 0).next(&mut Vec::new());
        let body = &self.macros.get(token.text)?.body;
        let name = body.first().filter(|t| t.kind == Kind::Text)?.text;
        Some((name.trim_matches('"'), false))
    }

    /// Opens the preludes of GLSL, the first of which is read first.
    pub(super) fn open_preludes(&mut self) {
        let of_glsl = |path: &&PathBuf| has_language(path, Language::Glsl);
        for path in self.options.preludes.iter().rev().filter(of_glsl) {
            match self.open_include(path) {
                Ok((file, text)) => {
                    self.preludes.push(file);
                    let lexer = Lexer::of_file(text, file, self.texts);
                    self.frames.push(TokenSource::File { lexer, conditions: 0 });
                }
                Err(error) => {
                    let message = format!("`{}` {}", path.display(), error.message);
                    self.report(Diagnostic::error(Code::Include, Span::default(), message));
                }
            }
        }
    }

    /// Returns the candidate paths of a file and the one that exists. Quoted names are first
    /// searched beside the including file, angled ones in the `-I` directories; then all in the
    /// folders above the file.
    fn find(&self, name: &str, angled: bool, from: u32) -> FoundFile {
        let way = if angled { "include of GLSL in <>" } else { "include of GLSL" };
        let file = self.files.get(from).map_or("", |file| &file.path);
        self.options.found(way, Path::new(file), name, || self.sought(name, angled, from))
    }

    // The order: for quotes the folder of the including file, then `-I`; for angle brackets `-I`
    // first; at last each folder above the file and its `include`, where engines keep what they
    // pass with `-I`.
    fn sought(&self, name: &str, angled: bool, from: u32) -> FoundFile {
        // GL_ARB_shading_language_include names begin with a slash: the root of the `-I` tree.
        let relative = name.trim_start_matches('/');
        let beside = self.files.get(from).and_then(|file| Path::new(&file.path).parent());
        let beside = beside.map(|dir| dir.join(relative));
        let given = self.options.include_dirs.iter().map(|dir| dir.join(relative));
        let places: Vec<PathBuf> = if angled {
            given.chain(beside).collect()
        } else {
            beside.into_iter().chain(given).collect()
        };
        let is_chunk = angled && Path::new(relative).extension().is_none();
        let spellings = |place: &PathBuf| {
            let ends: &[&str] = if is_chunk { &["", ".glsl", ".glsl.js"] } else { &[""] };
            let place = place.display().to_string();
            ends.iter().map(|end| PathBuf::from(format!("{place}{end}"))).collect::<Vec<_>>()
        };
        let above = self.files.get(from).map(|file| above(Path::new(&file.path)).skip(1));
        let above = above.into_iter().flatten().flat_map(|folder| {
            let mut places = vec![folder.join(relative)];
            match relative.split_once(':') {
                // Minecraft: `namespace:file` in a folder of assets.
                Some((space, name)) => {
                    places.push(folder.join(space).join("shaders/include").join(name));
                }
                None => places.push(folder.join("include").join(relative)),
            }
            if is_chunk {
                places.extend(CHUNKS.map(|chunks| folder.join(chunks).join(relative)));
            }
            places
        });
        let all = places.iter().cloned().chain(above);
        let found =
            all.flat_map(|place| spellings(&place)).find(|place| self.options.is_file(place));
        (places, found)
    }

    /// Returns the folder that a file which was not found is in: one beside a folder above.
    fn folder_of(&self, name: &str, from: u32) -> Option<PathBuf> {
        let relative = name.trim_start_matches('/');
        let file = self.files.get(from).filter(|_| self.options.files.is_none())?;
        above(Path::new(&file.path)).skip(1).find_map(|folder| {
            listed(&folder).into_iter().find(|folder| folder.join(relative).is_file())
        })
    }

    /// Returns the help for an include beside whose places is a file of a similar name.
    fn misspelt(&self, name: &str, places: &[PathBuf]) -> Option<String> {
        // Editors and build scripts may give the files themselves.
        let places = places.iter().filter(|_| self.options.files.is_none());
        let near = places.filter_map(|place| nearest_path(place)).find(|near| near.is_file())?;
        let meant = Path::new(name).with_file_name(near.file_name()?);
        Some(format!("did you mean `{}`?", meant.display()))
    }

    /// Returns the file of a quoted name beside one of the open files, the innermost first.
    // glslang looks beside every file that is open, from the innermost outwards, before `-I`: the
    // two searches may find two files, of which the caller warns.
    fn find_as_glslang(&self, name: &str, from: u32) -> Option<PathBuf> {
        let relative = name.trim_start_matches('/');
        let files = std::iter::once(from).chain(self.open_files().rev());
        let folders = files.filter_map(|file| Path::new(&self.files.get(file)?.path).parent());
        let mut seen: Vec<&Path> = Vec::new();
        for folder in folders {
            if seen.contains(&folder) {
                continue;
            }
            seen.push(folder);
            let place = folder.join(relative);
            if self.options.is_file(&place) {
                return Some(place);
            }
        }
        None
    }

    // Messages show the file as it is; the lexer reads it with what another tool replaces blanked
    // out.
    fn open_include(&mut self, path: &Path) -> Result<(u32, &'a str), crate::Error> {
        let shown = path.display().to_string();
        if let Some(&known) = self.included.get(&shown) {
            return Ok(known);
        }
        let (text, foreign) = match self.options.known_text(path) {
            Some(text) => (text, None),
            None => {
                let (text, foreign) = self.options.read_file(path)?;
                // Other readings have to note bytes that are not UTF-8 as well.
                if foreign.is_none() {
                    self.options.keep_text(path, &text);
                }
                (text, foreign)
            }
        };
        let known = self.files.iter().take(self.known_files).position(|file| file.path == shown);
        let file = match known {
            Some(known) => known as u32,
            None => self.files.add(shown.clone(), text.clone()),
        };
        self.note_foreign(file, foreign);
        let text = match dialect::without_tags(&text) {
            _ if shown.ends_with(".js") => dialect::literal(&text).into(),
            Some(text) => text.into(),
            None => text,
        };
        let opened: (u32, &'a str) = (file, self.texts.alloc(text));
        self.included.insert(shown, opened);
        Ok(opened)
    }

    /// Returns the chain of includes from a file back to itself, beyond [`DEEPEST_CYCLE`].
    // The stack of open files holds the first file twice if it includes itself; the part between
    // the two is the cycle.
    fn cycle_past_bound(&self) -> Option<String> {
        if self.frames.len() <= DEEPEST_CYCLE {
            return None;
        }
        let open: Vec<u32> = self.open_files().collect();
        let mut seen: FxHashMap<u32, usize> = FxHashMap::default();
        let (first, last) = open
            .iter()
            .enumerate()
            .find_map(|(last, &file)| seen.insert(file, last).map(|first| (first, last)))?;
        let names = open[first..=last].iter().filter_map(|&f| self.files.get(f));
        let names: Vec<String> = names.map(|file| format!("`{}`", file.path)).collect();
        Some(names.join(" includes "))
    }
}
