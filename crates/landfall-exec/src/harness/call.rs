//! Calls one function of a shader with arguments and block contents from JSON.
//!
//! The interpreter runs the function in `f32` and `f64` side by side, and a driver runs it too if
//! one is given. The result is a [`CallReport`].

mod arguments;
mod caller;
mod causes;
mod driver;
mod effects;
mod find;
mod globals;
pub mod kernel;
mod make;
mod parameters;
pub mod pure;
mod reads;
pub mod report;

use crate::backend::BackendKind;
use landfall_layout::diagnostic::Code;
use std::time::Duration;

use serde_json::Value;

use self::caller::{Caller, CallerInput};
use self::causes::Causes;
use self::find::Target;
pub use self::report::{
    CallReport, ResultCause, ReturnedScalar, ReturnedValue, UndefinedOperation,
};
use super::access;
use crate::backend::{Backend, Failure};
use crate::harness::bindings as bound;
use crate::harness::bindings::Data;
use crate::harness::origins::Names;
use landfall_interp::backend::deadline;
use landfall_interp::{
    Call, Called, Cpu, Floats, FunctionSignature, Numbers, Precision, Program, Settings, ValueType,
    Words,
};
use landfall_ir::module::{Direction, FunctionInfo, HandleKind, ModuleHandle};
use landfall_ir::{Module, call_graph};
use landfall_layout::source::{Files, Language, Source};
use landfall_layout::{Diagnostic, Options};

/// A function to call, with its arguments and resources.
#[derive(Clone, Debug)]
pub struct Request {
    /// The function: `phong`, or `phong(vec3, Light)` where several have the name.
    pub function: String,
    /// The arguments by position.
    pub arguments: Vec<Value>,
    /// Contents of blocks; the others are zero.
    pub data: Data,
    /// Colours of textures by name; the others are white.
    pub textures: Vec<(String, [f32; 4])>,
    /// Values of the shader's inputs by name; the others are zero.
    pub inputs: Vec<(String, Value)>,
    /// The precision to which the interpreter rounds floats.
    pub floats: Floats,
    /// The time limit; a backend that exceeds it has failed.
    pub limit: Duration,
}

impl Default for Request {
    fn default() -> Request {
        Request {
            function: String::new(),
            arguments: Vec::new(),
            data: Data::new(),
            textures: Vec::new(),
            inputs: Vec::new(),
            floats: Floats::AsWritten,
            limit: Duration::from_secs(20),
        }
    }
}

impl Request {
    /// Returns the words of an input, if given.
    fn input(
        &self,
        name: &str,
        ty: &ValueType,
        language: Language,
    ) -> Result<Option<Words>, Box<Diagnostic>> {
        let Some((_, value)) = self.inputs.iter().find(|(given, _)| given == name) else {
            return Ok(None);
        };
        let mut words = Vec::new();
        arguments::append_words(ty, value, name, language, &mut words)
            .map_err(|m| Box::new(Diagnostic::about(m.code, m.message, m.help, "--input")))?;
        Ok(Some(words.into_iter().map(|word| vec![word]).collect()))
    }
}

/// The errors of a request that was not run, with the files they refer to.
#[derive(Clone, Debug)]
pub struct Refusal {
    /// The errors in the shader, the request or the run.
    pub found: Vec<Diagnostic>,
    /// The shader's files.
    pub files: Files,
}

/// Calls a function on the interpreter, and on `backend` if it is a driver.
///
/// # Errors
/// Fails if the shader does not run, the function or a block does not exist, the arguments do not
/// fit, or the run does not end.
pub fn call(
    source: &Source,
    options: &Options,
    request: &Request,
    backend: Option<&mut dyn Backend>,
) -> Result<CallReport, Refusal> {
    let options = &options.clone().with_naga(false);
    let assumed_target = landfall_layout::layout(source, options).assumed_target;
    // Loose uniforms become a block, for which values can be given.
    let options = &options.clone().with_gather(true);
    let unread = |found| Refusal { found, files: landfall_layout::layout(source, options).files };
    let mut module = Module::for_calls(source, options).map_err(unread)?;
    // An entry point of WGSL cannot be called; a copy of it without its bindings can.
    let entry_point = match source.language {
        Language::Wgsl => find::entry_as_function(&mut module, request.function.trim()),
        Language::Glsl | Language::SpirV => None,
    };
    if entry_point.is_some() {
        module = module.validated().map_err(unread)?;
    }
    let refused =
        |found: Box<Diagnostic>| Refusal { found: vec![*found], files: module.files().clone() };
    let entry_point = entry_point.as_ref();
    let job = CallJob { source, options, request, module: &module, entry_point };
    let report = job.run(backend).map_err(refused)?;
    Ok(CallReport { assumed_target, ..report })
}

/// Returns the functions of a shader that [`call`] takes, as `NAME(TYPE, …)` with arguments that fit;
/// none of a shader that does not run.
pub fn signatures(source: &Source, options: &Options) -> Vec<(String, Vec<Value>)> {
    let options = &options.clone().with_naga(false).with_gather(true);
    let Ok(module) = Module::for_calls(source, options) else { return Vec::new() };
    let program = Program::new(&module, &[]);
    let described = |info: &FunctionInfo| {
        let signature = program.signature(info.handle.index()).ok()??;
        let arguments = signature.parameters.iter().map(|p| arguments::ones(&p.ty)).collect();
        Some((find::spelled_signature(info), arguments))
    };
    module.functions().iter().filter_map(described).collect()
}

/// Returns the inputs of a stage of GLSL that [`Request::inputs`] may name, each with a value that fits; none
/// of a shader that does not run.
pub fn stage_inputs(source: &Source, options: &Options) -> Vec<(String, Value)> {
    let options = &options.clone().with_naga(false).with_gather(true);
    let Ok(module) = Module::for_calls(source, options) else { return Vec::new() };
    let main = module.functions().iter().find(|function| function.name == "main");
    let caller = main.and_then(|main| caller::caller(&module, main.handle).ok());
    let Some(caller) = caller else { return Vec::new() };
    let program = Program::new(&caller.module, &[]);
    let Ok(Some(signature)) = program.signature(caller.handle.index()) else { return Vec::new() };
    let named = caller.inputs.iter().zip(&signature.parameters);
    named.map(|(input, parameter)| (input.name.clone(), arguments::ones(&parameter.ty))).collect()
}

/// A call in progress.
struct CallJob<'a> {
    source: &'a Source,
    options: &'a Options,
    request: &'a Request,
    module: &'a Module,
    /// The entry point of WGSL that has the function's name.
    entry_point: Option<&'a FunctionInfo>,
}

/// The interpreter's results.
struct InterpreterResults {
    called: Called,
    causes: Causes,
    /// Names of blocks that the call read and that have no values.
    blank: Vec<String>,
    textured: bool,
}

impl CallJob<'_> {
    fn run(&self, backend: Option<&mut dyn Backend>) -> Result<CallReport, Box<Diagnostic>> {
        let CallJob { source, request, module, .. } = self;
        let language = source.language;
        let program = Program::new(module, &[]);
        let given = &request.arguments;
        let found =
            find::find(module, self.entry_point, &program, &request.function, given, language)
                .map_err(|misfit| self.misfit(misfit))?;
        let first_of = |mut all: Vec<Diagnostic>| Box::new(all.swap_remove(0));
        let mut caller = caller::caller(module, found.info.handle).map_err(first_of)?;
        let ir = &module.ir;
        let effects = effects::effects_of(ir, &ir.functions[found.info.handle]);
        let written = effects::written(ir, found.info, &effects);
        globals::through_arguments(&mut caller.module, caller.handle, &[], &written);
        caller.module = caller.module.validated().map_err(first_of)?;
        let evaluated = self.evaluate(&caller, &found)?;
        let mut notes: Vec<String> =
            request.floats.note().map(str::to_string).into_iter().collect();
        let driver = backend.filter(|backend| backend.device().backend.is_driver());
        let (device, answered) = match driver {
            Some(backend) => {
                let device = backend.device().clone();
                let answered = driver::run(self.source, self.options, request, &found, backend)
                    .map_err(|failure| failed(device.backend, &failure))?;
                (device, Some(answered))
            }
            None => (Cpu::default().device().clone(), None),
        };
        let evaluated = match (evaluated, &answered) {
            (Ok(evaluated), _) => Some(evaluated),
            (Err(failure), None) => return Err(failed(BackendKind::Cpu, &failure)),
            (Err(failure), Some(_)) => {
                notes.push(format!("no f64 value to compare with: {}", failure.message));
                None
            }
        };
        if let Some(evaluated) = &evaluated {
            notes.extend(evaluated.causes.rounded.iter().cloned());
            self.assumed(evaluated, &mut notes);
        }
        self.assumed_inputs(&caller, &found, &mut notes);
        let (called, known) = match evaluated {
            Some(evaluated) => (Some(evaluated.called), evaluated.causes),
            None => (None, Causes::default()),
        };
        let called = called.as_ref();
        let mut causes = Vec::new();
        let base = caller.inputs.len();
        // The driver's words, else the interpreter's.
        let mut returned =
            |name: &str, at: Option<usize>, ty: &ValueType, driven: Option<Vec<u64>>| {
                let numbers = called.and_then(|called| match at {
                    None => Some(&called.result),
                    Some(at) => called.returned.get(at)?.as_ref(),
                });
                let own = |numbers: &Numbers| numbers.words.iter().map(|lanes| lanes[0]).collect();
                let words = driven.or_else(|| numbers.map(own))?;
                let value = ReturnedValue::new(ty, language, &words, numbers);
                known.push(name, at, &value, &mut causes);
                Some(value)
            };
        let answered = answered.as_ref();
        let result = found.signature.result.as_ref().and_then(|ty| {
            returned("result", None, ty, answered.map(|answered| answered.result.clone()))
        });
        let mut parameters = Vec::new();
        for (nth, parameter) in found.signature.parameters.iter().enumerate() {
            if !parameter.returned {
                continue;
            }
            let driven = answered.map(|answered| answered.parameters[nth].clone());
            let way = found.info.parameters.get(nth).map_or(Direction::InOut, |p| p.direction);
            let value = returned(&parameter.name, Some(base + nth), &parameter.ty, driven);
            parameters.extend(value.map(|value| (parameter.name.clone(), way, value)));
        }
        let after = base + found.signature.parameters.len();
        for (nth, variable) in written.iter().map(|at| &ir.global_variables[*at]).enumerate() {
            let Some(ty) = ValueType::new(module, variable.ty) else { continue };
            let Some(name) = variable.name.clone() else { continue };
            let driven = answered.and_then(|answered| answered.written.get(nth).cloned());
            let value = returned(&name, Some(after + nth), &ty, driven);
            parameters.extend(value.map(|value| (name, Direction::Out, value)));
        }
        let counts = called.map(|called| called.notes.counts.operations());
        Ok(CallReport {
            path: source.path.clone(),
            assumed_target: None,
            function: find::spelled_signature(found.info),
            backend: device,
            result,
            parameters,
            discarded: called.is_some_and(|called| called.discarded.contains(&true)),
            operations: counts,
            undefined: known.undefined,
            causes,
            notes,
            files: module.files().clone(),
        })
    }

    /// Runs the call on the interpreter. The outer error is a fault of the request; the inner one,
    /// a fault of the run, may be left to a driver.
    fn evaluate(
        &self,
        caller: &Caller,
        found: &Target<'_>,
    ) -> Result<Result<InterpreterResults, Failure>, Box<Diagnostic>> {
        let CallJob { source, request, .. } = self;
        let module = &caller.module;
        let bytes = bound::blocks(module, &request.data, bound::zeros)?;
        bound::textures_are_there(module, &request.textures)?;
        let files = module.files();
        let writable = |block: &_| access::writable(block, files, source.language);
        let resources = bound::resources(module, bytes, writable, &request.textures);
        let program = Program::rounded(module, &[], request.floats);
        // The caller is the last function.
        let number = module.ir.functions.len() - 1;
        let signature = match program.signature(number) {
            Ok(Some(signature)) => signature,
            Ok(None) => {
                return Ok(Err(Failure::refused(
                    "a parameter is not made of numbers: it is a sampler, image or pointer",
                    "",
                )));
            }
            Err(what) => {
                let message = format!("the interpreter does not support {what}");
                return Ok(Err(Failure::refused(message, "")));
            }
        };
        let mut arguments = self.inputs(caller, &signature)?;
        arguments.extend(found.arguments.iter().cloned());
        // The written variables come after the arguments, by pointers; what these point to is
        // overwritten.
        let written = &signature.parameters[arguments.len().min(signature.parameters.len())..];
        arguments.extend(written.iter().map(|p| vec![vec![0]; p.ty.scalars().len()]));
        let call = Call { function: caller::NAME, lanes: 1, arguments, resources: &resources };
        let settings = Settings {
            precision: Precision::Both,
            watch: true,
            deadline: deadline(request.limit),
            threads: 1,
            ..Settings::default()
        };
        let called = match program.call(&call, &settings) {
            Ok(called) => called,
            Err(failure) => return Ok(Err(failure)),
        };
        // Blocks that were read without values are worth a note.
        let blocks = module.blocks().iter().zip(&called.notes.read);
        let mut blank: Vec<String> = blocks
            .filter(|(block, read)| {
                read.contains(&true) && bound::values_for_block(&request.data, block).is_none()
            })
            .map(|(block, _)| block.layout.name.to_string())
            .collect();
        // The buffers of an array of blocks have one name.
        blank.dedup();
        let textured = called.notes.counts.textures > 0;
        // In the order of the caller's parameters.
        let inputs = caller.inputs.iter().map(|input| &input.name);
        let own = found.signature.parameters.iter().map(|parameter| &parameter.name);
        let listed = signature.parameters.iter().map(|parameter| &parameter.name);
        let listed = listed.skip(inputs.len() + own.len());
        let types = signature.parameters.iter().map(|parameter| parameter.ty.clone());
        let parameters = inputs.chain(own).chain(listed).cloned().zip(types).collect();
        let names = Names { program: &program, module, language: source.language, parameters };
        let (ran, result) = ((&call, &settings), signature.result.as_ref());
        let rounds = self.request.floats != Floats::AsWritten;
        let causes = causes::causes(&names, result, &called, rounds, ran);
        Ok(Ok(InterpreterResults { called, causes, blank, textured }))
    }

    /// Returns the values of the shader's inputs.
    fn inputs(
        &self,
        caller: &Caller,
        signature: &FunctionSignature,
    ) -> Result<Vec<Words>, Box<Diagnostic>> {
        let known: Vec<&String> = caller.inputs.iter().map(|input| &input.name).collect();
        if let Some((name, _)) = self.request.inputs.iter().find(|(name, _)| !known.contains(&name))
        {
            let all: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
            return Err(Box::new(Diagnostic::about(
                Code::UnknownInput,
                format!("the shader has no input `{name}`"),
                (!all.is_empty()).then(|| format!("it reads {}", all.join(", "))),
                "--input",
            )));
        }
        let language = self.source.language;
        let each = known.iter().zip(&signature.parameters).map(|(name, parameter)| {
            let zeros = || vec![vec![0]; parameter.ty.scalars().len()];
            Ok(self.request.input(name, &parameter.ty, language)?.unwrap_or_else(zeros))
        });
        each.collect()
    }

    /// Adds a note for each value that defaulted.
    fn assumed(&self, evaluated: &InterpreterResults, notes: &mut Vec<String>) {
        for name in &evaluated.blank {
            notes.push(format!("`{name}` defaults to zero: set it with --data"));
        }
        if evaluated.textured {
            notes.extend(white(self.module.handles(), &self.request.textures));
        }
    }

    fn assumed_inputs(&self, caller: &Caller, found: &Target<'_>, notes: &mut Vec<String>) {
        let ir = &caller.module.ir;
        let mut reached = call_graph::variables(ir, &ir.functions[found.info.handle]);
        effects::through_initialisers(ir, &ir.functions[caller.handle], &mut reached);
        let is_read = |input: &&CallerInput| input.variable.is_some_and(|v| reached.contains(&v));
        let mut names: Vec<&str> =
            caller.inputs.iter().filter(is_read).map(|input| input.name.as_str()).collect();
        names.retain(|name| !self.request.inputs.iter().any(|(given, _)| given == name));
        if names.is_empty() {
            return;
        }
        let list = names.join("`, `");
        let (defaults, it) = if names.len() > 1 { ("default", "them") } else { ("defaults", "it") };
        notes.push(format!("`{list}` {defaults} to zero: set {it} with --input"));
    }

    fn misfit(&self, misfit: arguments::ArgumentError) -> Box<Diagnostic> {
        let about = match misfit.code {
            Code::UnknownFunction | Code::AmbiguousFunction | Code::CannotCall => {
                self.source.path.as_str()
            }
            _ => "--args",
        };
        Box::new(Diagnostic::about(misfit.code, misfit.message, misfit.help, about))
    }
}

/// Returns a note on textures without a colour.
fn white<'h>(
    handles: impl IntoIterator<Item = &'h ModuleHandle>,
    textures: &[(String, [f32; 4])],
) -> Option<String> {
    let handles = handles.into_iter().filter(|handle| match handle.kind {
        HandleKind::Texture => true,
        HandleKind::Sampler | HandleKind::Image => false,
    });
    let paths = handles.map(|handle| handle.path.as_str());
    let mut white: Vec<&str> =
        paths.filter(|path| bound::colour(textures, path).is_none()).collect();
    white.dedup();
    let (names, are) = (white.join("`, `"), if white.len() > 1 { "are" } else { "is" });
    (!white.is_empty())
        .then(|| format!("`{names}` {are} white by default: set a colour with --texture"))
}

fn failed(backend: BackendKind, failure: &Failure) -> Box<Diagnostic> {
    let message = format!("{backend}: {}", failure.message);
    let mut found = Diagnostic::about(Code::CannotRun, message, None, "");
    found.path = None;
    found.notes = failure.log.lines().take(6).map(str::to_string).collect();
    Box::new(found)
}
