//! Layout of one shader: parses its text, lays out its blocks, collects diagnostics.

mod divided;
mod variants;

use std::sync::Arc;

use crate::diagnostic::{Diagnostic, Severity};
use crate::interface::Interface;
use crate::layout::{BlockLayout, targets};
use crate::shape::{AddressSpace, LengthConstant, Override, Rules, SpecialisedLength};
use crate::source::{Files, Language, ReadOptions, Source, Span, Stage, Target};
use crate::syntax::Parsed;

pub use divided::VariantCondition;
pub use variants::{
    Macros, UnreachedBlock, Variant, name as variant_name, unreached_blocks, variants,
};

/// The options of laying out a shader.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Options {
    /// The options of reading the text.
    pub read: ReadOptions,
    /// Rules that replace those of every block.
    pub rules: Option<Rules>,
    /// Whether to gather loose uniforms into one std140 block named `DefaultBlock`.
    pub gather: bool,
    /// Whether to compare with naga and record on each leaf where naga's placement differs.
    pub naga: bool,
    /// Whether to read what a program binds: entry points, resources, vertex inputs, constants.
    pub interface: bool,
}

impl Options {
    /// Returns the options with other read options.
    #[must_use]
    pub fn with_read(self, read: ReadOptions) -> Options {
        Options { read, ..self }
    }

    /// Returns the options with rules that replace those of every block, or with none.
    #[must_use]
    pub fn with_rules(self, rules: Option<Rules>) -> Options {
        Options { rules, ..self }
    }

    /// Returns the options with macros beside those they have; of two definitions of one name the
    /// later holds, as with `-D`.
    #[must_use]
    pub fn with_macros(mut self, macros: &Macros) -> Options {
        let defines = &mut self.read.defines;
        defines.retain(|(name, _)| macros.iter().all(|(other, _)| other != name));
        defines.extend(macros.iter().cloned());
        self
    }

    /// Returns the options with a structure that is laid out instead of the blocks, or with none.
    #[must_use]
    pub fn with_structure(self, structure: Option<String>) -> Options {
        Options { read: ReadOptions { structure, ..self.read }, ..self }
    }

    /// Returns the options with gathering of loose uniforms on or off.
    #[must_use]
    pub fn with_gather(self, gather: bool) -> Options {
        Options { gather, ..self }
    }

    /// Returns the options with the comparison with naga on or off.
    #[must_use]
    pub fn with_naga(self, naga: bool) -> Options {
        Options { naga, ..self }
    }

    /// Returns the options with the reading of the interface on or off.
    #[must_use]
    pub fn with_interface(self, interface: bool) -> Options {
        Options { interface, ..self }
    }
}

/// The block layouts and diagnostics of one shader.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ShaderLayout {
    /// The path as messages print it.
    pub path: String,
    /// The language.
    pub language: Language,
    /// The stage, if known.
    pub stage: Option<Stage>,
    /// The blocks in declaration order; loose uniforms come last.
    pub blocks: Vec<BlockLayout>,
    /// Which variants have these blocks; [`ShaderLayout::divided`] says so.
    pub condition: Option<VariantCondition>,
    /// The specialisation constants and overrides that sizes depend on.
    pub overrides: Vec<Override>,
    /// The arrays of GLSL whose lengths depend on specialisation constants.
    pub specialised: Vec<SpecialisedLength>,
    /// The constants that the lengths of blocks' arrays are written with, each once.
    pub constants: Vec<LengthConstant>,
    /// The names of GLSL's members whose lengths are taken from their uses.
    pub sized_by_use: Vec<Span>,
    /// The shader's file, then its includes.
    pub files: Files,
    /// Errors and warnings in the order they were found.
    pub diagnostics: Vec<Diagnostic>,
    /// The API assumed for a GLSL shader that tests for `VULKAN`, where neither options nor text
    /// name one and the blocks differ between the two.
    pub assumed_target: Option<Target>,
    /// Whether it is GLSL ES that is read for OpenGL: the size that a driver reports of a block is
    /// up to the implementation (OpenGL ES 3.2 §7.6).
    pub opengl_es: bool,
    /// What a program binds, if [`Options::interface`] asks for it.
    pub interface: Option<Arc<Interface>>,
    /// The layouts under other macros; [`variants`] makes them.
    pub variants: Vec<Variant>,
}

impl ShaderLayout {
    /// Returns the layout of one block on its own, without path, files and diagnostics.
    pub fn of_block(&self, block: &BlockLayout) -> ShaderLayout {
        let empty = ShaderLayout::empty(String::new(), self.language, self.stage);
        ShaderLayout { blocks: vec![block.clone()], ..empty }
    }

    /// Returns a layout without blocks.
    pub fn empty(path: String, language: Language, stage: Option<Stage>) -> ShaderLayout {
        ShaderLayout {
            path,
            language,
            stage,
            blocks: Vec::new(),
            condition: None,
            overrides: Vec::new(),
            specialised: Vec::new(),
            constants: Vec::new(),
            sized_by_use: Vec::new(),
            files: Files::default(),
            diagnostics: Vec::new(),
            assumed_target: None,
            opengl_es: false,
            interface: None,
            variants: Vec::new(),
        }
    }

    /// The block of this name or instance name, the first if there are several.
    ///
    /// ```
    /// # extern crate landfall_layout as landfall;
    /// use landfall::{Options, Source, layout};
    ///
    /// let text = "#version 450\nlayout(std140) uniform Camera { mat4 view; } camera;\n";
    /// let shader = layout(&Source::new("a.vert", text), &Options::default());
    /// assert_eq!(shader.block("Camera").and_then(|block| block.size), Some(64));
    /// assert!(shader.block("camera").is_some() && shader.block("Light").is_none());
    /// ```
    pub fn block(&self, name: &str) -> Option<&BlockLayout> {
        let named = self.blocks.iter().find(|block| &*block.name == name);
        named.or_else(|| self.blocks.iter().find(|block| block.instance.as_deref() == Some(name)))
    }

    /// Whether any diagnostic is an error; blocks may then be missing.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|d| d.severity == Severity::Error)
    }
}

/// Lays out every block of a shader.
pub fn layout(source: &Source, options: &Options) -> ShaderLayout {
    let (source, warnings) = crate::syntax::link(source, &options.read);
    let mut parsed = crate::syntax::parse(&source, &options.read, options.gather);
    // What linking finds stands before what the parser finds.
    parsed.diagnostics.splice(0..0, warnings);
    layout_parsed(parsed, &source, options)
}

/// Lays out every block of a shader parsed before; whether loose uniforms were gathered is up to
/// the parse.
pub fn layout_parsed(parsed: Parsed, source: &Source, options: &Options) -> ShaderLayout {
    let (assumed, bodies) = (parsed.assumed, parsed.bodies.clone());
    let of_loose = parsed.assumed_of_loose;
    let mut shader = placed(source, options, parsed);
    // Blocks that differ under the other API are a warning; with errors there is nothing to
    // compare.
    if let Some(target) = assumed.filter(|_| !shader.has_errors()) {
        compare_targets(source, options, &mut shader, target, of_loose);
    }
    #[cfg(feature = "naga")]
    // naga panics on some texts that are rejected here, so it only gets texts without errors.
    if options.naga && !shader.has_errors() {
        crate::naga_compare::compare(source, &bodies, &mut shader.blocks);
    }
    #[cfg(not(feature = "naga"))]
    let _ = bodies;
    if source.language == Language::SpirV {
        // Messages name the block and the member.
        let found = std::mem::take(&mut shader.diagnostics).into_iter();
        shader.diagnostics = found.map(|found| found.of_binary(&source.path)).collect();
    }
    if options.interface && !shader.has_errors() {
        match source.without_text() {
            Some(error) => shader.diagnostics.push(error.into()),
            None => {
                let read = crate::syntax::interface(source, &options.read);
                shader.interface = Some(Arc::new(read));
            }
        }
    }
    shader
}

/// Lays out the shader for the other API as well, and records the differences in `shader`.
fn compare_targets(
    source: &Source,
    options: &Options,
    shader: &mut ShaderLayout,
    target: Target,
    of_loose: bool,
) {
    let read = ReadOptions { target: Some(targets::other(target)), ..options.read.clone() };
    let options = Options { read, naga: false, ..options.clone() };
    let parsed = crate::syntax::parse(source, &options.read, options.gather);
    let there = placed(source, &options, parsed);
    if there.has_errors() {
        return; // a text invalid for the other API is not written for it
    }
    if let Some(mut found) = targets::compare(&shader.blocks, &there.blocks, target, of_loose) {
        shader.assumed_target = Some(target);
        shader.diagnostics.append(&mut found);
    }
}

/// Lays out the blocks of a parsed shader.
pub(crate) fn placed(source: &Source, options: &Options, parsed: Parsed) -> ShaderLayout {
    let mut diagnostics = parsed.diagnostics;
    let mut blocks = Vec::with_capacity(parsed.shape.blocks.len());
    for mut block in parsed.shape.blocks {
        // `@align` and `@size` that are wrong have no layout.
        if source.language == Language::Wgsl {
            let found = crate::layout::attributes::check(&block);
            if !found.is_empty() {
                extend_once(&mut diagnostics, found);
                continue;
            }
        }
        let all_rules = match options.rules {
            Some(rules) => {
                // Rules that the user asks for are as good as declared.
                block.rules_declared = true;
                vec![rules]
            }
            // A structure of GLSL has no rules of its own: it is laid out by those of each kind of
            // block.
            None if block.space == AddressSpace::Structure && block.rules != Rules::Wgsl => {
                vec![Rules::Std140, Rules::Std430, Rules::Scalar]
            }
            None => vec![block.rules],
        };
        for rules in all_rules {
            block.rules = rules;
            match crate::layout::lay_out(&block) {
                Ok(layout) => {
                    if !parsed.standard_uniforms {
                        let found = crate::layout::uniform_constraints::check(&block);
                        extend_once(&mut diagnostics, found);
                    }
                    diagnostics.extend(crate::layout::order_of_unknown_target(&block, &layout));
                    blocks.push(layout);
                }
                Err(found) => extend_once(&mut diagnostics, found),
            }
        }
    }
    let stage = source.stage.or(parsed.stage);
    ShaderLayout {
        blocks,
        overrides: parsed.shape.overrides,
        specialised: parsed.shape.specialised,
        constants: parsed.shape.constants,
        sized_by_use: parsed.shape.sized_by_use,
        files: parsed.files,
        diagnostics,
        opengl_es: parsed.opengl_es,
        ..ShaderLayout::empty(source.path.clone(), source.language, stage)
    }
}

/// Adds diagnostics that are not present yet: two blocks of one structure have the same ones.
fn extend_once(diagnostics: &mut Vec<Diagnostic>, found: Vec<Diagnostic>) {
    for diagnostic in found {
        if !diagnostics.contains(&diagnostic) {
            diagnostics.push(diagnostic);
        }
    }
}
