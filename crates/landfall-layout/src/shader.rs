//! The layouts of one shader: its text read, its blocks laid out, findings collected.

use crate::diagnostic::{Diagnostic, Severity};
use crate::layout::{BlockLayout, targets};
use crate::shape::{Override, Rules};
use crate::source::{Files, Language, ReadOptions, Source, Stage, Target};
use crate::syntax::Parsed;

/// How a shader is laid out.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// How its text is read.
    pub read: ReadOptions,
    /// Lay every block out by these rules instead of its own.
    pub rules: Option<Rules>,
    /// Gather loose uniforms into one std140 block named `DefaultBlock`.
    pub gather: bool,
    /// Ask naga too, and note on each leaf where its answer differs.
    pub naga: bool,
}

/// The layouts of one shader, and all there is to say about it.
#[derive(Clone, Debug)]
pub struct ShaderLayout {
    /// The path as messages print it.
    pub path: String,
    /// The language it is written in.
    pub language: Language,
    /// The stage it is written for, where known.
    pub stage: Option<Stage>,
    /// Its blocks in the order of the text; loose uniforms come last.
    pub blocks: Vec<BlockLayout>,
    /// Specialisation constants and overrides that sizes depend on.
    pub overrides: Vec<Override>,
    /// The files it is made of: itself, then its includes.
    pub files: Files,
    /// Errors and warnings in the order they were found.
    pub diagnostics: Vec<Diagnostic>,
    /// The API a GLSL text was read for, where nothing says which and it has other blocks for
    /// the other one.
    pub assumed_target: Option<Target>,
}

impl ShaderLayout {
    /// Whether any finding is an error: then some block may be missing.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|d| d.severity == Severity::Error)
    }
}

/// Lays out every block of a shader.
pub fn layout(source: &Source, options: &Options) -> ShaderLayout {
    layout_parsed(crate::syntax::parse(source, &options.read, options.gather), source, options)
}

/// Lays out every block of a shader that is parsed already, its loose uniforms gathered or not.
pub fn layout_parsed(parsed: Parsed, source: &Source, options: &Options) -> ShaderLayout {
    let (assumed, bodies) = (parsed.assumed, parsed.bodies.clone());
    let mut shader = placed(source, options, parsed);
    if let Some(target) = assumed.filter(|_| !shader.has_errors()) {
        compare_targets(source, options, &mut shader, target);
    }
    #[cfg(feature = "naga")]
    // naga is not asked about a text that is refused here: it panics on some of those.
    if options.naga && !shader.has_errors() {
        crate::naga_compare::ask(source, &bodies, &mut shader.blocks);
    }
    #[cfg(not(feature = "naga"))]
    let _ = bodies;
    shader
}

/// Lays a text out for the other API as well, and notes what differs in `shader`.
fn compare_targets(source: &Source, options: &Options, shader: &mut ShaderLayout, target: Target) {
    let read = ReadOptions { target: Some(targets::other(target)), ..options.read.clone() };
    let options = Options { read, naga: false, ..options.clone() };
    let parsed = crate::syntax::parse(source, &options.read, options.gather);
    let there = placed(source, &options, parsed);
    if there.has_errors() {
        return; // what cannot be read for the other API is not written for it
    }
    if let Some(mut found) = targets::compare(&shader.blocks, &there.blocks, target) {
        shader.assumed_target = Some(target);
        shader.diagnostics.append(&mut found);
    }
}

/// Lays out what was read of a shader.
pub(crate) fn placed(source: &Source, options: &Options, parsed: Parsed) -> ShaderLayout {
    let mut diagnostics = parsed.diagnostics;
    let mut blocks = Vec::with_capacity(parsed.shape.blocks.len());
    for mut block in parsed.shape.blocks {
        if source.language == Language::Wgsl {
            let found = crate::layout::attributes::check(&block);
            if !found.is_empty() {
                extend_once(&mut diagnostics, found);
                continue;
            }
        }
        if let Some(rules) = options.rules {
            block.rules = rules;
            block.rules_declared = true;
        }
        match crate::layout::lay_out(&block) {
            Ok(layout) => {
                if !parsed.standard_uniforms {
                    let found = crate::layout::uniform_constraints::check(&block);
                    extend_once(&mut diagnostics, found);
                }
                diagnostics.extend(crate::layout::untold_order(&block, &layout));
                blocks.push(layout);
            }
            Err(mut found) => diagnostics.append(&mut found),
        }
    }
    ShaderLayout {
        path: source.path.clone(),
        language: source.language,
        stage: source.stage,
        blocks,
        overrides: parsed.shape.overrides,
        files: parsed.files,
        diagnostics,
        assumed_target: None,
    }
}

/// Two blocks of one structure have the same things said about it.
fn extend_once(diagnostics: &mut Vec<Diagnostic>, found: Vec<Diagnostic>) {
    for diagnostic in found {
        if !diagnostics.contains(&diagnostic) {
            diagnostics.push(diagnostic);
        }
    }
}
