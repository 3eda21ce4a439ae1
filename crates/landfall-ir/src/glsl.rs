//! GLSL of any version, bodies included, as naga IR with our offsets.
//!
//! A front end of our own: naga's takes neither old versions nor loose uniforms, and lays blocks
//! out wrongly. Takes the syntax tree and the layout of a shader; [`globals`] and [`blocks`] lower what stands outside functions, [`function`] and what
//! it calls lower bodies, [`host`], [`place`] and [`memory`] put blocks where our layout says,
//! [`opaque`] binds textures, [`io`] makes the entry point.

mod blocks;
mod body;
mod call;
mod carrier;
mod constant;
mod construct;
mod evaluate;
mod expression;
mod function;
mod globals;
mod host;
mod image;
mod io;
mod math;
mod math_expanded;
mod memory;
mod opaque;
mod operators;
mod place;
mod precision;
mod predeclared;
mod statement;
mod texture;
mod types;
mod uses;

use landfall_layout::diagnostic::Code;
use std::rc::Rc;

use naga::Handle;
use rustc_hash::{FxHashMap, FxHashSet};

use super::module::{
    Bases, Binder, EntryInterface, FunctionInfo, Inputs, LeftOut, ModuleBlock, ModuleHandle,
};
use carrier::{Carriers, carrier};
use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::source::{Files, Source, Span, Stage};
pub use landfall_layout::syntax::glsl::ast;
use landfall_layout::syntax::glsl::{Texts, parse};
use landfall_layout::{BlockLayout, Options, Severity, layout_parsed};
use types::{Structure, Ty};

/// A result of lowering: what cannot be lowered is said with its place.
pub(super) type R<T> = Result<T, Box<Diagnostic>>;

/// What lowering a shader gives: naga's module and how its parts are called.
pub struct Lowered {
    pub ir: naga::Module,
    pub blocks: Vec<ModuleBlock>,
    pub handles: Vec<ModuleHandle>,
    pub functions: Vec<FunctionInfo>,
    pub inputs: Vec<EntryInterface>,
    pub outputs: Vec<EntryInterface>,
    pub left_out: Vec<LeftOut>,
    pub files: Files,
    pub bases: Bases,
    /// What needs no more than `mediump`, in naga's numbering.
    pub reduced: FxHashSet<(u32, u32)>,
}

/// What cannot run, and where.
pub(super) fn refuse(span: Span, message: impl Into<String>) -> Box<Diagnostic> {
    Box::new(Diagnostic::error(Code::CannotRun, span, message))
}

/// Advice for a refusal.
pub(super) trait Help {
    fn help(self, text: impl Into<String>) -> Self;
}

impl Help for Box<Diagnostic> {
    fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

/// The shader as a whole, while it is lowered.
pub struct Lowerer<'a> {
    pub ir: naga::Module,
    pub stage: Option<Stage>,
    wanted_inputs: Inputs,
    pub bases: Bases,
    /// Values of specialisation constants, by name or number.
    overrides: &'a [(String, String)],
    /// The layouts of the shader's blocks.
    layouts: Vec<BlockLayout>,
    pub blocks: Vec<ModuleBlock>,
    pub memories: Vec<globals::Memory>,
    /// For each of `blocks`, its memory.
    pub block_memory: Vec<usize>,
    pub module_handles: Vec<ModuleHandle>,
    pub bindings: Binder,
    pub handles: FxHashMap<String, opaque::HandlePair>,
    pub globals: Vec<globals::Global<'a>>,
    pub global_names: FxHashMap<&'a str, usize>,
    /// The language's own variables that are used, by name.
    pub predeclared: FxHashMap<String, usize>,
    pub io: Vec<io::Io>,
    structures: FxHashMap<&'a str, Ty>,
    /// Structures that cannot run, and why.
    broken: FxHashMap<&'a str, Box<Diagnostic>>,
    /// Structures by where their names stand: so the layout tells which it means.
    structures_at: FxHashMap<(u32, u32), Rc<Structure>>,
    next_structure: u32,
    carriers: Carriers,
    pub functions: Vec<function::Entry<'a>>,
    pub function_names: FxHashMap<&'a str, Vec<usize>>,
    /// Names of members and variables that atomic functions change.
    pub atomics: FxHashSet<&'a str>,
    /// Sizes that arrays of the language's own are declared again with.
    pub sizes: FxHashMap<&'a str, u32>,
    pub workgroup_size: [u32; 3],
    pub early_fragment_tests: bool,
    /// Initialisers of global variables, which the entry point runs first.
    initialisers: Vec<(usize, Rc<ast::Declaration<'a>>, usize)>,
    pub left_out: Vec<LeftOut>,
    /// Levels of functions, statements and expressions that lowering is in.
    pub nesting: u32,
    /// Expressions of the functions that are done.
    pub expressions: usize,
}

/// Lowers a GLSL shader.
pub(super) fn lower(
    source: &Source,
    options: &Options,
    inputs: Inputs,
) -> Result<Lowered, Vec<Diagnostic>> {
    let texts = Texts::new();
    let mut shader = parse(source, &options.read, &texts, true);
    let layout_options = Options { gather: true, naga: false, ..options.clone() };
    let laid_out = layout_parsed(shader.parsed, source, &layout_options);
    let errors = laid_out.diagnostics.into_iter().filter(|d| d.severity == Severity::Error);
    let errors: Vec<Diagnostic> = errors.collect();
    if !errors.is_empty() {
        return Err(errors);
    }
    let stage = source.stage.or_else(|| io::stage_of(shader.parser.tokens()));
    io::check_stage(stage).map_err(|d| vec![*d])?;
    let es = shader.parser.is_es();
    let mut items = shader.items;
    shader.parser.complete(&mut items, stage).map_err(|error| vec![*error.diagnostic()])?;
    let reduced = if es { precision::reduced(&items) } else { FxHashSet::default() };
    let mut lowerer = Lowerer {
        ir: naga::Module::default(),
        stage,
        wanted_inputs: inputs,
        bases: Bases::new(&laid_out.files),
        overrides: &options.read.overrides,
        layouts: laid_out.blocks,
        blocks: Vec::new(),
        memories: Vec::new(),
        block_memory: Vec::new(),
        module_handles: Vec::new(),
        bindings: Binder::default(),
        handles: FxHashMap::default(),
        globals: Vec::new(),
        global_names: FxHashMap::default(),
        predeclared: FxHashMap::default(),
        io: Vec::new(),
        structures: FxHashMap::default(),
        broken: FxHashMap::default(),
        structures_at: FxHashMap::default(),
        next_structure: 0,
        carriers: FxHashMap::default(),
        functions: Vec::new(),
        function_names: FxHashMap::default(),
        atomics: uses::atomics(&items),
        sizes: FxHashMap::default(),
        workgroup_size: [1; 3],
        early_fragment_tests: false,
        initialisers: Vec::new(),
        left_out: Vec::new(),
        nesting: 0,
        expressions: 0,
    };
    lowerer.items(&items)?;
    let functions = lowerer.lower_functions()?;
    let (inputs, outputs) = lowerer.entry_point().map_err(|d| vec![*d])?;
    Ok(Lowered {
        ir: lowerer.ir,
        blocks: lowerer.blocks,
        handles: lowerer.module_handles,
        functions,
        inputs,
        outputs,
        left_out: lowerer.left_out,
        files: laid_out.files,
        reduced: reduced.iter().filter_map(|span| range(lowerer.bases.to_naga(*span))).collect(),
        bases: lowerer.bases,
    })
}

/// A span of naga's as first byte and one past the last.
fn range(span: naga::Span) -> Option<(u32, u32)> {
    span.to_range().map(|range| (range.start as u32, range.end as u32))
}

impl Lowerer<'_> {
    pub fn naga_span(&self, span: Span) -> naga::Span {
        self.bases.to_naga(span)
    }

    /// The naga type that carries values of a type.
    pub fn carrier(&mut self, ty: &Ty, span: Span) -> R<Handle<naga::Type>> {
        let Some(found) = carrier(&mut self.ir.types, &mut self.carriers, ty) else {
            let message = match ty {
                Ty::Array(_, None) => format!("`{ty}` has no size, and no value"),
                Ty::Array(..) | Ty::Struct(_) => format!("values of `{ty}` are too large, or none"),
                _ => format!("a `{ty}` is no value"),
            };
            return Err(refuse(span, message));
        };
        Ok(found.handle)
    }
}
