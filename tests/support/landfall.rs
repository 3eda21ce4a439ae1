//! What landfall itself says, in the table the oracles answer with.

use ::landfall::{
    ArrayLen, BlockLayout, Language, Leaf, Options, Rules, Severity, ShaderLayout, Source, Target,
    layout,
};

use super::leaf::{OracleBlock, OracleLeaf};

/// The blocks of a GLSL text, read as OpenGL's or Vulkan's.
///
/// # Panics
/// Landfall refuses the text: what is asked about is legal.
pub fn glsl_blocks(text: &str, target: Target) -> Vec<OracleBlock> {
    let mut options = Options::default();
    options.read.target = Some(target);
    blocks(&Source::new("blocks.comp", text), &options)
}

/// The blocks of a WGSL text.
///
/// # Panics
/// Landfall refuses the text.
pub fn wgsl_blocks(text: &str) -> Vec<OracleBlock> {
    blocks(&Source::new("blocks.wgsl", text), &Options::default())
}

fn blocks(source: &Source, options: &Options) -> Vec<OracleBlock> {
    table(&without_errors(source, options))
}

/// The layout of a text.
///
/// # Panics
/// Landfall refuses it.
pub fn laid_out(path: &str, text: &str) -> ShaderLayout {
    without_errors(&Source::new(path, text), &Options::default())
}

/// The same of a text that is read as Vulkan's.
pub fn laid_out_for_vulkan(path: &str, text: &str) -> ShaderLayout {
    let mut options = Options::default();
    options.read.target = Some(Target::Vulkan);
    without_errors(&Source::new(path, text), &options)
}

fn without_errors(source: &Source, options: &Options) -> ShaderLayout {
    let shader = layout(source, options);
    assert!(!shader.has_errors(), "{}: {:#?}\n{}", source.path, shader.diagnostics, source.text);
    shader
}

/// Lays out the first of some files in memory.
pub fn in_memory(files: &[(&str, &str)], change: impl FnOnce(&mut Options)) -> ShaderLayout {
    let mut options = Options::default();
    options.read.files =
        Some(files.iter().map(|(path, text)| (path.to_string(), text.to_string())).collect());
    change(&mut options);
    layout(&Source::new(files[0].0, files[0].1), &options)
}

/// The first error: its message, its file and line, and its help.
pub fn first_error(shader: &ShaderLayout) -> (String, String, String) {
    let mut errors = shader.diagnostics.iter();
    let found = errors.find(|found| found.severity == Severity::Error).expect("an error");
    let place = found.labels.first().map(|label| shader.files.locate(label.at));
    let place = place.map_or_else(String::new, |at| format!("{}:{}", at.path, at.line));
    (found.message.clone(), place, found.help.clone().unwrap_or_default())
}

/// A layout as a table, loose uniforms left out: they have no offsets.
pub fn table(shader: &ShaderLayout) -> Vec<OracleBlock> {
    let placed = shader.blocks.iter().filter(|block| block.size.is_some());
    placed.map(|block| of_block(block, shader.language)).collect()
}

fn of_block(block: &BlockLayout, language: Language) -> OracleBlock {
    let leaf = |leaf: &Leaf| OracleLeaf {
        path: leaf.path.clone(),
        ty: leaf.ty.spelled(language).to_string(),
        offset: leaf.offset.expect("a block that is no set of loose uniforms has offsets"),
        dims: leaf.dims.iter().map(len).collect(),
        strides: leaf.strides.iter().copied().map(Some).collect(),
        matrix_stride: leaf.matrix_stride,
        row_major: leaf.row_major,
    };
    OracleBlock {
        name: block.name.to_string(),
        count: block.count.iter().map(len).collect(),
        // Mesa rounds std430 blocks up to 16 as well, which no rule asks for; landfall rounds
        // them up to their own alignment. The end of the last member is compared all the same.
        size: block.size.filter(|_| matches!(block.rules, Rules::Std140 | Rules::Wgsl)),
        data_size: block.data_size,
        leaves: block.leaves.iter().map(leaf).collect(),
    }
}

fn len(len: &ArrayLen) -> Option<u64> {
    match len {
        ArrayLen::Fixed(n) => Some((*n).into()),
        ArrayLen::Runtime | ArrayLen::Override(_) => None,
    }
}
