//! `#include`: quoted and angled, as `GL_GOOGLE_include_directive` and
//! `GL_ARB_shading_language_include` spell it.

use crate::diagnostic::Code;
use std::path::{Path, PathBuf};

use rustc_hash::FxHashMap;

use super::lexer::{Kind, Lexer, Token};
use super::preprocess::{Frame, Preprocessor};
use crate::diagnostic::Diagnostic;
use crate::interface::Include;
use crate::source::{Span, decode_shader, normalized, read_bytes};

/// The number of nested includes from which one that includes itself is refused.
const DEEPEST_CYCLE: usize = 64;

/// The limit on nested includes.
const DEEPEST_INCLUDE: usize = 512;

/// The limit on includes in one shader.
const MOST_INCLUDES: usize = 1 << 14;

/// The limit on bytes that includes may add to one shader.
const MOST_INCLUDED: usize = 64 << 20;

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
            self.report(
                Diagnostic::error(Code::CyclicInclude, span, format!("`{name}` includes itself"))
                    .with_note(cycle)
                    .with_help("guard the file with `#ifndef NAME`, `#define NAME`, `#endif`"),
            );
            self.stopped = true;
            return;
        }
        self.includes += 1;
        let bomb = match self.frames.len() {
            deep if deep > DEEPEST_INCLUDE => {
                Some(format!("includes are nested more than {DEEPEST_INCLUDE} deep"))
            }
            _ if self.includes > MOST_INCLUDES => {
                Some(format!("the shader has more than {MOST_INCLUDES} includes"))
            }
            _ => None,
        };
        if let Some(message) = bomb {
            self.report(Diagnostic::error(Code::IncludeBomb, span, message));
            self.stopped = true;
            return;
        }
        let (places, found) = self.find(name, angled, span.file);
        let outer = if angled { None } else { self.find_as_glslang(name, span.file) };
        if let (Some(path), Some(outer)) = (&found, &outer) {
            let real = |path: &Path| path.canonicalize().ok();
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
                self.report(found.with_help("landfall reads GLSL and WGSL"));
                self.stopped = true;
                return;
            }
            let mut diagnostic =
                Diagnostic::error(Code::MissingInclude, span, format!("`{name}` not found"));
            for place in places {
                diagnostic = diagnostic.with_note(format!("looked for `{}`", place.display()));
            }
            return self.report(diagnostic.with_help("pass its directory with `-I DIR`"));
        };
        match self.open_include(&path) {
            Ok((file, text)) => {
                self.included_bytes += text.len();
                if self.included_bytes > MOST_INCLUDED {
                    let message = format!("includes add more than {MOST_INCLUDED} bytes");
                    self.report(Diagnostic::error(Code::IncludeBomb, span, message));
                    self.stopped = true;
                    return;
                }
                let conditions = self.conditions.len();
                let depth = self.frames.iter().filter(|f| matches!(f, Frame::File { .. })).count();
                self.opened.push(Include { span, file, depth });
                self.frames.push(Frame::File {
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

    /// Returns the candidate paths of a file and the one that exists. Quoted names are first
    /// searched beside the including file, angled ones in the `-I` directories.
    fn find(&self, name: &str, angled: bool, from: u32) -> (Vec<PathBuf>, Option<PathBuf>) {
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
        let found = places.iter().find(|place| self.is_file(place)).cloned();
        (places, found)
    }

    /// Returns the file of a quoted name beside one of the open files, the innermost first.
    fn find_as_glslang(&self, name: &str, from: u32) -> Option<PathBuf> {
        let relative = name.trim_start_matches('/');
        let outer = self.frames.iter().rev().filter_map(|frame| match frame {
            Frame::File { lexer, .. } => Some(lexer.file()),
            Frame::Macro { .. } | Frame::Tokens { .. } => None,
        });
        let files = std::iter::once(from).chain(outer);
        let folders = files.filter_map(|file| Path::new(&self.files.get(file)?.path).parent());
        let mut seen: Vec<&Path> = Vec::new();
        for folder in folders {
            if seen.contains(&folder) {
                continue;
            }
            seen.push(folder);
            let place = folder.join(relative);
            if self.is_file(&place) {
                return Some(place);
            }
        }
        None
    }

    /// Whether a path is that of a file that may be included.
    fn is_file(&self, path: &Path) -> bool {
        match &self.options.files {
            Some(files) => files.iter().any(|(given, _)| Path::new(given) == path),
            None => path.is_file(),
        }
    }

    fn open_include(&mut self, path: &Path) -> Result<(u32, &'a str), crate::Error> {
        let shown = path.display().to_string();
        if let Some(&file) = self.included.get(&shown) {
            let text = self.files.get(file).map(|f| f.text.clone()).unwrap_or_default();
            return Ok((file, self.texts.alloc(text)));
        }
        let bytes = match &self.options.files {
            Some(files) => {
                let given = files.iter().find(|(given, _)| Path::new(given) == path);
                given.map(|(_, text)| text.clone().into_bytes()).unwrap_or_default()
            }
            None => read_bytes(path, self.options.max_bytes)?,
        };
        let (text, foreign) = decode_shader(&shown, bytes)?;
        let text = normalized(text.into());
        let file = self.files.add(shown.clone(), text.clone());
        self.note_foreign(file, foreign);
        self.included.insert(shown, file);
        Ok((file, self.texts.alloc(text)))
    }

    /// Returns the chain of includes from a file back to itself, beyond [`DEEPEST_CYCLE`].
    fn cycle_past_bound(&self) -> Option<String> {
        if self.frames.len() <= DEEPEST_CYCLE {
            return None;
        }
        let open: Vec<u32> = self
            .frames
            .iter()
            .filter_map(|frame| match frame {
                Frame::File { lexer, .. } => Some(lexer.file()),
                Frame::Macro { .. } | Frame::Tokens { .. } => None,
            })
            .collect();
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
