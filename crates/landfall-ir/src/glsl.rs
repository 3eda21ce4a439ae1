//! Lowers GLSL of any version, function bodies included, to naga IR with Landfall's offsets.
//!
//! naga's own front end accepts neither old versions nor loose uniforms, and lays some blocks out
//! wrongly. This one takes the syntax tree and the layout of a shader; [`globals`] and [`blocks`]
//! lower declarations outside functions, [`function`] and the modules it calls lower bodies,
//! [`block_types`], [`lvalue`] and [`memory`] access blocks at Landfall's offsets, [`opaque`] binds
//! textures, [`io`] makes the entry point.

mod block_types;
mod blocks;
mod body;
mod call;
mod constant;
mod construct;
mod evaluate;
mod expression;
mod function;
mod globals;
mod image;
mod io;
mod lvalue;
mod math;
mod math_expanded;
mod memory;
mod name_usage;
mod opaque;
mod operators;
mod precision;
mod predeclared;
mod statement;
mod texture;
mod types;
mod value_types;

use landfall_layout::diagnostic::Code;
use std::rc::Rc;

use naga::Handle;
use naga::valid::ModuleInfo;
use rustc_hash::{FxHashMap, FxHashSet};

use super::module::{
    Bases, Binder, Inputs, Locals, Module, ModuleBlock, ModuleHandle, SkippedFunction,
};
use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::source::{Source, Span, Stage};
pub use landfall_layout::syntax::glsl::ast;
use landfall_layout::syntax::glsl::{Texts, parse};
use landfall_layout::{BlockLayout, Options, Severity, layout_parsed};
use types::{Structure, Ty};
use value_types::{ValueTypes, value_type};

/// The result of lowering; the error is a diagnostic with its span.
pub(super) type Lowering<T> = Result<T, Box<Diagnostic>>;

/// Returns the error for an unsupported construct.
pub(super) fn refuse(span: Span, message: impl Into<String>) -> Box<Diagnostic> {
    Box::new(Diagnostic::error(Code::CannotRun, span, message))
}

pub(super) trait Help {
    fn help(self, text: impl Into<String>) -> Self;
}

impl Help for Box<Diagnostic> {
    fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

#[derive(Default)]
pub struct Lowerer<'a> {
    pub ir: naga::Module,
    pub stage: Option<Stage>,
    wanted_inputs: Inputs,
    pub bases: Bases,
    /// Values of specialisation constants, by name or number.
    overrides: &'a [(String, String)],
    layouts: Vec<BlockLayout>,
    /// Their indices by the spans of their names.
    layout_at: FxHashMap<Span, usize>,
    pub blocks: Vec<ModuleBlock>,
    pub memories: Vec<globals::Memory>,
    /// The memory of each of `blocks`.
    pub block_memory: Vec<usize>,
    pub module_handles: Vec<ModuleHandle>,
    pub bindings: Binder,
    pub handles: FxHashMap<String, opaque::HandlePair>,
    pub globals: Vec<globals::Global<'a>>,
    pub global_names: FxHashMap<&'a str, usize>,
    /// The built-in variables in use, by name.
    pub predeclared: FxHashMap<String, usize>,
    pub io: Vec<io::StageVariable>,
    structures: FxHashMap<&'a str, Ty>,
    /// Unsupported structures, each with the error.
    broken: FxHashMap<&'a str, Box<Diagnostic>>,
    /// Structures by the spans of their names, by which the layout refers to them.
    structures_at: FxHashMap<(u32, u32), Rc<Structure>>,
    next_structure: u32,
    value_types: ValueTypes,
    pub functions: Vec<function::Entry<'a>>,
    pub function_names: FxHashMap<&'a str, Vec<usize>>,
    /// Names of members and variables that atomic functions change.
    pub atomics: FxHashSet<&'a str>,
    /// The sizes with which built-in arrays are redeclared.
    pub sizes: FxHashMap<&'a str, u32>,
    pub workgroup_size: [u32; 3],
    pub early_fragment_tests: bool,
    /// Initialisers of global variables, which the entry point runs first.
    initialisers: Vec<(usize, Rc<ast::Declaration<'a>>, usize)>,
    pub left_out: Vec<SkippedFunction>,
    /// The current nesting of functions, statements and expressions.
    pub nesting: u32,
    /// The number of expressions in the finished functions.
    pub expressions: usize,
}

pub(super) fn lower(
    source: &Source,
    options: &Options,
    inputs: Inputs,
) -> Result<Module, Vec<Diagnostic>> {
    let texts = Texts::new();
    let mut shader = parse(source, &options.read, &texts, true);
    // The stages: parse, lay out, declare types and globals, lower bodies on demand, make the
    // entry point. The layout comes first, since blocks are built from it; its errors end the
    // work. Loose uniforms are gathered in one block, and naga's own layout is not compared: it is
    // this module that checks it.
    let layout_options = options.clone().with_gather(true).with_naga(false);
    let laid_out = layout_parsed(shader.parsed, source, &layout_options);
    let errors = laid_out.diagnostics.into_iter().filter(|d| d.severity == Severity::Error);
    let errors: Vec<Diagnostic> = errors.collect();
    if !errors.is_empty() {
        return Err(errors);
    }
    let stage = source.stage.or_else(|| io::stage_of(shader.parser.tokens()));
    io::check_stage(stage).map_err(|d| vec![*d])?;
    let es = shader.parser.is_es();
    // Functions whose bodies the parser has skipped are parsed here.
    let mut items = shader.items;
    shader.parser.complete(&mut items, stage).map_err(|error| vec![*error.diagnostic()])?;
    // Only ES gives precisions a meaning (GLSL ES 3.00 §4.5).
    let reduced = if es { precision::reduced(&items) } else { FxHashSet::default() };
    let mut lowerer = Lowerer {
        stage,
        wanted_inputs: inputs,
        bases: Bases::new(&laid_out.files),
        overrides: &options.read.overrides,
        layout_at: laid_out.blocks.iter().enumerate().map(|(n, block)| (block.span, n)).collect(),
        layouts: laid_out.blocks,
        atomics: name_usage::atomics(&items),
        workgroup_size: [1; 3],
        ..Lowerer::default()
    };
    lowerer.items(&items)?;
    let functions = lowerer.lower_functions()?;
    let (inputs, outputs) = lowerer.entry_point().map_err(|d| vec![*d])?;
    Ok(Module {
        ir: lowerer.ir,
        info: ModuleInfo::default(),
        blocks: lowerer.blocks,
        handles: lowerer.module_handles,
        functions,
        inputs,
        outputs,
        left_out: lowerer.left_out,
        files: laid_out.files,
        reduced: reduced.iter().filter_map(|span| range(lowerer.bases.to_naga(*span))).collect(),
        bases: lowerer.bases.starts,
        locals: Locals::Anything,
    })
}

/// Returns the first byte of a naga span and the byte after its last.
fn range(span: naga::Span) -> Option<(u32, u32)> {
    span.to_range().map(|range| (range.start as u32, range.end as u32))
}

impl Lowerer<'_> {
    pub fn naga_span(&self, span: Span) -> naga::Span {
        self.bases.to_naga(span)
    }

    pub fn nameless(&mut self, inner: naga::TypeInner) -> Handle<naga::Type> {
        self.ir.types.insert(naga::Type { name: None, inner }, naga::Span::UNDEFINED)
    }

    /// Returns the naga type for values of a type.
    pub fn value_type(&mut self, ty: &Ty, span: Span) -> Lowering<Handle<naga::Type>> {
        let Some(found) = value_type(&mut self.ir.types, &mut self.value_types, ty) else {
            let message = match ty {
                Ty::Array(_, None) => format!("`{ty}` has no size and cannot be used as a value"),
                Ty::Array(..) | Ty::Struct(_) => {
                    format!(
                        "`{ty}` cannot be used as a value: it is too large, or holds a sampler, image or runtime-sized array"
                    )
                }
                _ => format!("a `{ty}` cannot be used as a value"),
            };
            return Err(refuse(span, message));
        };
        Ok(found.handle)
    }
}
