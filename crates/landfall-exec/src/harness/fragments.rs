//! Any fragment shader run over a list of fragments whose inputs are given, on any reader, each
//! fragment with the same bits whoever runs it.
//!
//! There are no vertices: the fragments are packed into an image in the order of the caller, and
//! the inputs come from a texture of floats, read by the pixel. `module` puts that into a
//! module for the evaluator and wgpu, `text` into the user's GLSL for OpenGL, and `batch`
//! makes and runs the jobs. Feeds `landfall_light`.

mod batch;
mod module;
mod permitted;
mod text;

use landfall_layout::diagnostic::Code;
use std::sync::Arc;

use landfall_ir::Module;
use landfall_ir::module::{HandleKind, ModuleBlock, ModuleHandle};
use landfall_layout::source::{Language, Source};
use landfall_layout::{BlockLayout, Diagnostic, Options};

pub use batch::{Batch, Image, Shaded};
pub use permitted::Permitted;

/// The texture that inputs are read from.
const ATLAS: &str = "landfall_inputs";
/// The pixel as an input, by GLSL's name of it.
pub const PIXEL: &str = "gl_FragCoord";
/// Its width and the rows of one input, where GLSL cannot ask a texture.
const SIZE: &str = "landfall_size";

/// A fragment shader whose inputs are given.
///
/// Making one compiles; running it again with other buffers does not, as readers keep what they
/// compiled.
#[derive(Clone, Debug)]
pub struct FragmentShader {
    module: Arc<Module>,
    /// White wherever nothing is discarded; of shaders that may.
    covered: Option<Arc<Module>>,
    entry: String,
    /// For OpenGL: the shader's text, and that of `covered`.
    texts: Option<(String, Option<String>)>,
    /// Whether the text takes [`SIZE`].
    wants_size: bool,
    inputs: Vec<Input>,
    atlas: (u32, u32),
    language: Language,
    rows_from_bottom: bool,
    /// Numbers of the blocks the entry point reads.
    read: Vec<bool>,
}

/// An input of a fragment shader: a scalar or vector, or a part of a larger one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// Its name in the text: `FragPos`, `Surface.uv` of a block, `basis[1]` of a matrix.
    pub name: String,
    /// Its location in the module; none of `gl_FragCoord`, which is given like any other
    /// because the pixel of a list is not the one that is seen.
    pub location: Option<u32>,
    /// 1 to 4.
    pub components: u8,
    /// What the components are.
    pub kind: InputKind,
}

/// What the components of an input are; whole numbers are given as floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum InputKind {
    Float,
    Sint,
    Uint,
}

impl FragmentShader {
    /// Makes a fragment shader runnable; `entry` says which one where WGSL has several.
    ///
    /// # Errors
    /// What is wrong with the shader or cannot run; a shader that takes differences between
    /// neighbouring pixels, which packed fragments do not have.
    pub fn new(
        source: &Source,
        options: &Options,
        entry: Option<&str>,
    ) -> Result<FragmentShader, Vec<Diagnostic>> {
        let source = &Source {
            stage: match source.language {
                Language::Glsl => source.stage.or(Some(landfall_layout::Stage::Fragment)),
                Language::Wgsl => source.stage,
            },
            ..source.clone()
        };
        let whole = Module::new(source, options)?;
        if let Some(image) = whole.handles().iter().find(|h| h.kind == HandleKind::Image) {
            let message = format!("`{}` is a storage image, and no scene has one", image.path);
            return Err(vec![Diagnostic::error(
                Code::CannotRun,
                landfall_layout::Span::default(),
                message,
            )]);
        }
        let fetching = module::fetching(&whole, entry)?;
        if fetching.differences {
            let message = "the shader takes differences between neighbouring pixels (`dFdx`, \
                           `fwidth`), and fragments of a list have no neighbours";
            return Err(vec![Diagnostic::error(
                Code::CannotRun,
                landfall_layout::Span::default(),
                message,
            )]);
        }
        let original = text::versioned(source, &options.read);
        let texts = match source.language {
            Language::Wgsl => None,
            Language::Glsl => {
                let made = |writes| text::text(&original, &options.read, &fetching.inputs, writes);
                let covered = fetching.covered.as_ref().map(|_| made(text::Writes::White));
                Some((made(text::Writes::Result), covered))
            }
        };
        Ok(FragmentShader {
            module: Arc::new(fetching.module),
            covered: fetching.covered.map(Arc::new),
            entry: fetching.entry,
            texts,
            wants_size: text::wants_size(&original, &options.read),
            inputs: fetching.inputs,
            atlas: fetching.atlas,
            language: source.language,
            rows_from_bottom: text::is_opengl(source, &options.read),
            read: fetching.read,
        })
    }

    /// Its inputs, in the order their values are given in.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// Its blocks, in the order their bytes are given in; loose uniforms are `DefaultBlock`.
    pub fn blocks(&self) -> &[ModuleBlock] {
        self.module.blocks()
    }

    /// Whether the entry point reads a block, by its number: others may hold anything.
    pub fn reads(&self, block: usize) -> bool {
        self.read.get(block).copied().unwrap_or(false)
    }

    /// Its textures, in the order they are given in.
    pub fn textures(&self) -> impl Iterator<Item = &ModuleHandle> {
        self.module.handles().iter().filter(|handle| handle.kind == HandleKind::Texture)
    }

    /// Whether it may discard a fragment.
    pub fn discards(&self) -> bool {
        self.covered.is_some()
    }

    /// Whether it counts rows of pixels from the bottom, as OpenGL does.
    pub fn rows_from_bottom(&self) -> bool {
        self.rows_from_bottom
    }

    /// The language it is written in.
    pub fn language(&self) -> Language {
        self.language
    }

    /// The text OpenGL is given; none of WGSL.
    pub fn glsl(&self) -> Option<&str> {
        self.texts.as_ref().map(|(text, _)| text.as_str())
    }

    /// Whether a block is the loose uniforms of GLSL.
    pub fn is_loose(&self, block: &BlockLayout) -> bool {
        self.language == Language::Glsl && block.gathered
    }
}
