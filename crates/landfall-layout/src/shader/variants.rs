//! The variants of a shader: its layouts under the sets of macros that a project compiles it with.
//!
//! `permutations` of a configuration are such sets. A lock records the blocks of each variant, and
//! `define-changes-layout` compares them.

use rustc_hash::FxHashSet;

use crate::shader::{Options, ShaderLayout, layout};
use crate::source::{File, Files, Language, Source, Span};
use crate::syntax::glsl::conditional_blocks;

/// Macros with their texts, as `-D` gives them.
pub type Macros = [(String, String)];

/// A shader under one set of macros.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Variant {
    /// The macros.
    pub macros: Vec<(String, String)>,
    /// The layout; `None` if it is that without these macros, since no file of the shader has one
    /// of them.
    pub layout: Option<ShaderLayout>,
}

impl Variant {
    /// Returns a variant with a layout of its own.
    pub fn new(macros: Vec<(String, String)>, layout: ShaderLayout) -> Variant {
        Variant { macros, layout: Some(layout) }
    }

    /// Returns a variant that is as the shader without its macros.
    pub fn unchanged(macros: Vec<(String, String)>) -> Variant {
        Variant { macros, layout: None }
    }

    /// The macros as messages name them: `SHADOWS`, `LIGHTS=8 SHADOWS`.
    pub fn name(&self) -> String {
        name(&self.macros)
    }
}

/// Returns macros as messages name them: `SHADOWS`, `LIGHTS=8 SHADOWS`.
pub fn name(macros: &Macros) -> String {
    let one = |(name, text): &(String, String)| match text.as_str() {
        "" | "1" => name.clone(),
        text => format!("{name}={text}"),
    };
    macros.iter().map(one).collect::<Vec<_>>().join(" ")
}

/// Lays a shader out under each of several sets of macros; of sets that are equal, under the first.
///
/// `shader` is its layout without them, whose files tell which sets may change anything.
pub fn variants(
    source: &Source,
    options: &Options,
    shader: &ShaderLayout,
    sets: &[Vec<(String, String)>],
) -> Vec<Variant> {
    let mut variants: Vec<Variant> = Vec::with_capacity(sets.len());
    for macros in sets {
        if variants.iter().all(|known| known.macros != *macros) {
            let layout = mentions(shader, macros).then(|| under(source, options, macros));
            variants.push(Variant { macros: macros.clone(), layout });
        }
    }
    variants
}

/// Lays a shader out with macros beside those of the options, without naga's answer.
fn under(source: &Source, options: &Options, macros: &Macros) -> ShaderLayout {
    layout(source, &options.clone().with_naga(false).with_macros(macros))
}

/// Whether any file of the shader contains one of the macros as a word.
fn mentions(shader: &ShaderLayout, macros: &Macros) -> bool {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let in_text = |text: &str, name: &str| {
        text.match_indices(name).any(|(at, _)| {
            !text[..at].ends_with(word) && !text[at + name.len()..].starts_with(word)
        })
    };
    macros.iter().any(|(name, _)| {
        !name.is_empty() && shader.files.iter().any(|file| in_text(&file.text, name))
    })
}

impl ShaderLayout {
    /// Returns the layout with its variants under these sets of macros, unless it has errors.
    #[must_use]
    pub fn with_variants(
        mut self,
        source: &Source,
        options: &Options,
        sets: &[Vec<(String, String)>],
    ) -> ShaderLayout {
        if !sets.is_empty() && !self.has_errors() {
            self.variants = variants(source, options, &self, sets);
        }
        self
    }

    /// The files of the shader, then those that only its variants include.
    pub fn all_files(&self) -> impl Iterator<Item = &File> {
        let own = self.variants.iter().filter_map(|variant| variant.layout.as_ref());
        let more = own.flat_map(|layout| layout.files.iter());
        let is_new = |file: &&File| self.files.iter().all(|known| known.path != file.path);
        self.files.iter().chain(more.filter(is_new))
    }

    /// Returns the layout under a set of macros: that of its variant, or this one.
    pub fn under(&self, macros: &Macros) -> &ShaderLayout {
        let variant = self.variants.iter().find(|variant| variant.macros == macros);
        variant.and_then(|variant| variant.layout.as_ref()).unwrap_or(self)
    }

    /// Returns the variants that have a layout of their own with errors.
    pub fn failed_variants(&self) -> impl Iterator<Item = (&Variant, &ShaderLayout)> {
        let own = self.variants.iter().filter_map(|one| Some((one, one.layout.as_ref()?)));
        own.filter(|(_, layout)| layout.has_errors())
    }

    /// Returns the variants that have a layout of their own without errors.
    pub fn laid_out_variants(&self) -> impl Iterator<Item = (&Variant, &ShaderLayout)> {
        let own = self.variants.iter().filter_map(|one| Some((one, one.layout.as_ref()?)));
        own.filter(|(_, layout)| !layout.has_errors())
    }
}

/// A block that neither a shader nor any of its variants has.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct UnreachedBlock<'a> {
    /// The name.
    pub name: &'a str,
    /// The files of its span.
    pub files: &'a Files,
    /// The name in its declaration.
    pub span: Span,
    /// The macros that the conditions around it test.
    pub macros: Vec<String>,
}

/// Returns the blocks in the files of a shader that neither it nor any of its variants has, though
/// other macros would give them.
///
/// Blocks that depend only on what the language or the text defines are left out: those under
/// `#if 0`, `GL_ES` or `VULKAN`.
pub fn unreached_blocks(shader: &ShaderLayout) -> Vec<UnreachedBlock<'_>> {
    if shader.language == Language::Wgsl {
        return Vec::new();
    }
    let own = shader.variants.iter().filter_map(|variant| variant.layout.as_ref());
    let all: Vec<&ShaderLayout> = std::iter::once(shader).chain(own).collect();
    let path = |files: &Files, span: Span| files.get(span.file).map(|file| file.path.clone());
    let mut reached: FxHashSet<(Option<String>, u32)> = FxHashSet::default();
    for layout in &all {
        let blocks = layout.blocks.iter().map(|block| block.span);
        reached.extend(blocks.map(|span| (path(&layout.files, span), span.start)));
    }
    // A variant with errors may lack a block for that reason.
    let failed = shader.variants.iter();
    let failed = failed.filter(|one| one.layout.as_ref().is_some_and(ShaderLayout::has_errors));
    let failed: Vec<&str> =
        failed.flat_map(|one| &one.macros).map(|(name, _)| name.as_str()).collect();
    let mut seen: FxHashSet<&str> = FxHashSet::default();
    let mut found = Vec::new();
    for layout in all {
        for (number, file) in layout.files.iter().enumerate() {
            if !seen.insert(&file.path) {
                continue;
            }
            for block in conditional_blocks(&file.text, number as u32) {
                let is_reached = reached.contains(&(Some(file.path.clone()), block.name.start));
                let may_fail = block.macros.iter().any(|name| failed.contains(&name.as_str()));
                if !is_reached && !may_fail {
                    let (files, span) = (&layout.files, block.name);
                    let name = files.text(span);
                    found.push(UnreachedBlock { name, files, span, macros: block.macros });
                }
            }
        }
    }
    found
}
