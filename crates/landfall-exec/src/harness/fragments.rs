//! Runs any fragment shader over a list of fragments with given inputs on any backend; each
//! fragment gets bit-identical inputs everywhere.
//!
//! There are no vertices: the fragments are packed into an image in list order, and each pixel
//! fetches its inputs from a texture of floats. `module` builds that into a module for the
//! interpreter and wgpu, `text` into the user's GLSL for OpenGL, and `batch` makes and runs the
//! jobs. Browsers draw points with inputs instead: `wgsl`. Used by `landfall_light`.

mod batch;
mod causes;
mod module;
mod permitted;
mod text;
mod wgsl;

use landfall_layout::diagnostic::Code;
use std::sync::Arc;

use crate::harness::access;
use landfall_ir::Module;
use landfall_ir::module::{HandleKind, ModuleBlock, ModuleHandle};
use landfall_layout::source::{Language, Source};
use landfall_layout::{BlockLayout, Diagnostic, Options};

pub use batch::{Batch, Image, Inputs, Shaded};
pub use causes::{FragmentCause, UndefinedInFragment};
pub use permitted::Permitted;
pub use wgsl::{BufferKind, WgslTexts};

/// The name of the texture that holds the inputs.
pub const ATLAS: &str = "landfall_inputs";
/// GLSL's name of the pixel coordinate, which is an input too.
pub const PIXEL: &str = "gl_FragCoord";
/// The name of the uniform with the texture's width and rows per input, for GLSL without
/// `textureSize`.
const SIZE: &str = "landfall_size";

/// A fragment shader with given inputs.
///
/// Making one compiles; running it again with other buffers does not, since backends cache compiled
/// code.
#[derive(Clone, Debug)]
pub struct FragmentShader {
    module: Arc<Module>,
    /// The same shader writing white unless it discards; `None` if it never discards.
    covered: Option<Arc<Module>>,
    entry: String,
    /// For OpenGL: the shader's text, and that of `covered`.
    texts: Option<(String, Option<String>)>,
    /// For WebGPU in a browser: the text and the name of its entry point; `None` for GLSL.
    wgsl: Option<(String, String)>,
    /// Whether the text declares [`SIZE`].
    wants_size: bool,
    inputs: Vec<Input>,
    atlas: (u32, u32),
    language: Language,
    rows_from_bottom: bool,
    /// By block: whether the entry point reads it.
    read: Vec<bool>,
    /// By block: whether some stage may write it, which the text says.
    writable: Vec<bool>,
}

/// An input of a fragment shader: a scalar or vector, or a part of a larger one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// The name in the text: `FragPos`, `Surface.uv` of a block, `basis[1]` of a matrix.
    pub name: String,
    /// The location in the module; `None` for `gl_FragCoord`, which is given like any other input
    /// because the packed pixel is not the visible one.
    pub location: Option<u32>,
    /// 1 to 4.
    pub components: u8,
    pub kind: InputKind,
    /// How it is interpolated, as WGSL's attribute; empty for `gl_FragCoord`.
    interpolation: String,
}

/// The component type of an input; integers are given as floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputKind {
    Float,
    Sint,
    Uint,
}

/// A fragment shader in GLSL ES 3.00.
#[derive(Clone, Debug)]
pub struct EsText {
    /// The text.
    pub text: String,
    /// The names of the blocks in it, in the order of [`Batch::blocks`]; `None` for one that it does
    /// not read.
    pub blocks: Vec<Option<String>>,
    /// Its samplers, each with its index in [`Batch::textures`]; `None` for that of the inputs.
    pub samplers: Vec<(String, Option<usize>)>,
}

impl FragmentShader {
    /// Prepares a fragment shader; `entry` selects the entry point if WGSL has several.
    ///
    /// # Errors
    /// Fails if the shader has errors or cannot run, or uses derivatives, which packed fragments do
    /// not have.
    pub fn new(
        source: &Source,
        options: &Options,
        entry: Option<&str>,
    ) -> Result<FragmentShader, Vec<Diagnostic>> {
        // A GLSL text that names no stage is taken for a fragment shader.
        let source = &Source {
            stage: match source.language {
                Language::Glsl => source.stage.or(Some(landfall_layout::Stage::Fragment)),
                Language::Wgsl | Language::SpirV => source.stage,
            },
            ..source.clone()
        };
        let whole = Module::new(source, options)?;
        if let Some(image) = whole.handles().iter().find(|h| h.kind == HandleKind::Image) {
            let message =
                format!("`{}` is a storage image, which a scene does not provide", image.path);
            return Err(vec![Diagnostic::error(
                Code::CannotRun,
                landfall_layout::Span::default(),
                message,
            )]);
        }
        let fetching = module::fetching(&whole, entry)?;
        if fetching.differences {
            let message = "the shader uses derivatives (`dFdx`, `fwidth`), but fragments \
                           are shaded one by one, without neighbours";
            return Err(vec![Diagnostic::error(
                Code::CannotRun,
                landfall_layout::Span::default(),
                message,
            )]);
        }
        let original = text::versioned(source, &options.read);
        let texts = match source.language {
            Language::Wgsl | Language::SpirV => None,
            Language::Glsl => {
                let made = |writes| text::text(&original, &options.read, &fetching.inputs, writes);
                let covered = fetching.covered.as_ref().map(|_| made(text::Writes::White));
                Some((made(text::Writes::Result), covered))
            }
        };
        let wgsl = (source.language == Language::Wgsl)
            .then(|| (source.text.to_string(), fetching.original));
        let module = &fetching.module;
        let writable = module
            .blocks()
            .iter()
            .map(|block| access::writable(&block.layout, module.files(), source.language));
        Ok(FragmentShader {
            writable: writable.collect(),
            module: Arc::new(fetching.module),
            covered: fetching.covered.map(Arc::new),
            entry: fetching.entry,
            texts,
            wgsl,
            wants_size: text::wants_size(&original, &options.read),
            inputs: fetching.inputs,
            atlas: fetching.atlas,
            language: source.language,
            rows_from_bottom: text::is_opengl(source, &options.read),
            read: fetching.read,
        })
    }

    /// Returns the inputs, in the order of [`Batch::inputs`].
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// Returns the blocks, in the order of [`Batch::blocks`]; loose uniforms are `DefaultBlock`.
    pub fn blocks(&self) -> &[ModuleBlock] {
        self.module.blocks()
    }

    /// Returns whether the entry point reads the block of that index; others may hold anything.
    pub fn reads(&self, block: usize) -> bool {
        self.read.get(block).copied().unwrap_or(false)
    }

    /// Returns the textures, in the order of [`Batch::textures`].
    pub fn textures(&self) -> impl Iterator<Item = &ModuleHandle> {
        self.module.handles().iter().filter(|handle| handle.kind == HandleKind::Texture)
    }

    /// Returns whether the shader may discard a fragment.
    pub fn discards(&self) -> bool {
        self.covered.is_some()
    }

    /// Returns whether some of it asks for no more than `mediump`, which drivers may compute in 16
    /// bits (GLSL ES 3.20 §4.7).
    pub fn is_mediump(&self) -> bool {
        !self.module.reduced.is_empty()
    }

    /// Returns whether row 0 of the pixels is the bottom one, as in OpenGL.
    pub fn rows_from_bottom(&self) -> bool {
        self.rows_from_bottom
    }

    /// Returns the shader's language.
    pub fn language(&self) -> Language {
        self.language
    }

    /// Returns the GLSL text for OpenGL; `None` for WGSL.
    pub fn glsl(&self) -> Option<&str> {
        self.texts.as_ref().map(|(text, _)| text.as_str())
    }

    /// Returns the shader in GLSL ES 3.00: it reads its inputs from the sampler [`ATLAS`], one below
    /// the other.
    ///
    /// # Errors
    /// What WebGL 2 does not have.
    #[cfg(feature = "es")]
    pub fn es(&self) -> Result<EsText, String> {
        let shader = self.module.es(&self.entry)?;
        let handles = self.module.handles();
        let is_texture = |handle: &&ModuleHandle| handle.kind == HandleKind::Texture;
        // Textures alone are numbered, without samplers.
        let number = |handle: usize| handles[..handle].iter().filter(is_texture).count();
        let samplers = shader.textures.into_iter();
        Ok(EsText {
            text: shader.text,
            blocks: shader.blocks,
            samplers: samplers.map(|(name, handle)| (name, handle.map(number))).collect(),
        })
    }

    /// Returns whether a block holds the loose uniforms of GLSL.
    pub fn is_loose(&self, block: &BlockLayout) -> bool {
        self.language == Language::Glsl && block.gathered
    }
}
