//! The variants of a shader: its layouts under the sets of macros that a project compiles it with.
//!
//! `permutations` of a configuration are such sets. A lock records the blocks of each variant, and
//! `define-changes-layout` compares them.

use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

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
    pub layout: Option<Arc<ShaderLayout>>,
}

impl Variant {
    /// Returns a variant with a layout of its own.
    pub fn new(macros: Vec<(String, String)>, layout: ShaderLayout) -> Variant {
        Variant { macros, layout: Some(Arc::new(layout)) }
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
/// `shader` is its layout without them, whose files tell which sets may change anything. Sets that
/// agree on all macros that the files name have one layout.
pub fn variants(
    source: &Source,
    options: &Options,
    shader: &ShaderLayout,
    sets: &[Vec<(String, String)>],
) -> Vec<Variant> {
    let mut seen: FxHashSet<&Macros> = FxHashSet::default();
    let mut named = NamedMacros::new(sets, shader);
    let mut laid_out: FxHashMap<Vec<&(String, String)>, Arc<ShaderLayout>> = FxHashMap::default();
    let mut variants: Vec<Variant> = Vec::with_capacity(sets.len());
    // naga's answer is compared once, for the shader itself.
    let mut options = options.clone().with_naga(false);
    // Sets share what is read of included files.
    options.read.cache = Some(Arc::default());
    for macros in sets.iter().filter(|set| seen.insert(set.as_slice())) {
        // Two sets that agree on all macros in the files read the same text.
        let part = named.part(macros);
        let layout = (!part.is_empty()).then(|| match laid_out.get(&part) {
            Some(known) => Arc::clone(known),
            None => {
                let options = options.clone().with_macros(macros);
                let new = Arc::new(layout(source, &options));
                // An include under a condition may bring files that name more macros.
                if named.add(&new) {
                    // Sets that agreed on the names so far may differ in these.
                    laid_out.clear();
                }
                laid_out.insert(named.part(macros), Arc::clone(&new));
                new
            }
        });
        variants.push(Variant { macros: macros.clone(), layout });
    }
    variants
}

/// The macros of some sets that the files of a shader contain as words.
struct NamedMacros<'a> {
    /// Those that no file contains so far.
    others: FxHashSet<&'a str>,
    named: FxHashSet<&'a str>,
    /// The files that were searched.
    files: FxHashSet<String>,
}

impl<'a> NamedMacros<'a> {
    fn new(sets: &'a [Vec<(String, String)>], shader: &ShaderLayout) -> NamedMacros<'a> {
        let names = sets.iter().flatten().map(|(name, _)| name.as_str());
        let others = names.filter(|name| !name.is_empty()).collect();
        let mut all =
            NamedMacros { others, named: FxHashSet::default(), files: FxHashSet::default() };
        all.add(shader);
        all
    }

    /// Adds the macros that the files of a layout contain; returns whether there are more now.
    fn add(&mut self, layout: &ShaderLayout) -> bool {
        let before = self.named.len();
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        // Macros that are given are files of this name.
        for file in layout.files.written().filter(|file| !file.path.starts_with("-D ")) {
            if self.files.insert(file.path.clone()) {
                for word in file.text.split(|c| !is_word(c)) {
                    if let Some(name) = self.others.take(word) {
                        self.named.insert(name);
                    }
                }
            }
        }
        self.named.len() > before
    }

    /// The macros of a set that the files contain.
    fn part<'s>(&self, macros: &'s Macros) -> Vec<&'s (String, String)> {
        let mut part: Vec<_> =
            macros.iter().filter(|(name, _)| self.named.contains(name.as_str())).collect();
        part.sort_by(|a, b| a.0.cmp(&b.0));
        part
    }
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
        let more = self.own_variants().flat_map(|(_, layout)| layout.files.iter());
        let is_new = |file: &&File| self.files.iter().all(|known| known.path != file.path);
        self.files.iter().chain(more.filter(is_new))
    }

    /// Returns the layout under a set of macros: that of its variant, or this one.
    pub fn under(&self, macros: &Macros) -> &ShaderLayout {
        let variant = self.variants.iter().find(|variant| variant.macros == macros);
        variant.and_then(|variant| variant.layout.as_deref()).unwrap_or(self)
    }

    fn own_variants(&self) -> impl Iterator<Item = (&Variant, &ShaderLayout)> {
        self.variants.iter().filter_map(|one| Some((one, one.layout.as_deref()?)))
    }

    /// Returns the variants that have a layout of their own with errors.
    pub fn failed_variants(&self) -> impl Iterator<Item = (&Variant, &ShaderLayout)> {
        self.own_variants().filter(|(_, layout)| layout.has_errors())
    }

    /// Returns the variants that have a layout of their own without errors.
    pub fn laid_out_variants(&self) -> impl Iterator<Item = (&Variant, &ShaderLayout)> {
        self.own_variants().filter(|(_, layout)| !layout.has_errors())
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
    if shader.language != Language::Glsl {
        return Vec::new();
    }
    let own = shader.own_variants().map(|(_, layout)| layout);
    let all: Vec<&ShaderLayout> = std::iter::once(shader).chain(own).collect();
    // A block is known by its file and the offset of its name, the same under all macros.
    let path = |files: &Files, span: Span| files.get(span.file).map(|file| file.path.clone());
    let mut reached: FxHashSet<(Option<String>, u32)> = FxHashSet::default();
    for layout in &all {
        let blocks = layout.blocks.iter().map(|block| block.span);
        reached.extend(blocks.map(|span| (path(&layout.files, span), span.start)));
    }
    // A variant with errors may lack a block for that reason.
    let macros = shader.failed_variants().flat_map(|(one, _)| &one.macros);
    let failed: Vec<&str> = macros.map(|(name, _)| name.as_str()).collect();
    let mut seen: FxHashSet<&str> = FxHashSet::default();
    let mut found = Vec::new();
    // Each file once, whichever variant includes it.
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
