//! Makes a function of a shader pure: rejects side effects, turns blocks into parameters, and binds
//! fixed resources.
//!
//! Built from a [`Module`]; [`pure`](super::pure) holds the result.

use landfall_layout::diagnostic::Code;
use naga::{AddressSpace, Function, GlobalVariable, Handle};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeSet;

use super::arguments::ArgumentError;
use super::caller;
use super::caller::{Caller, CallerInput};
use super::effects::{Effects, effects_of, through_initialisers, written};
use super::find::{find_by_name, opaque, spelled_signature};
use super::globals::{SampledBlock, SampledMember, through_arguments};
use super::parameters::{CallerParameters, PublicParameters, list};
use super::pure::{CallPurpose, PureFunction, PureRequest};
use super::reads;
use super::reads::Members;
use super::{Refusal, white};
use crate::harness::access;
use crate::harness::bindings as bound;
use crate::harness::bindings::Data;
use landfall_interp::{FunctionSignature, Program, ValueType};
use landfall_ir::module::{FunctionInfo, ModuleHandle};
use landfall_ir::{Module, call_graph};
use landfall_layout::source::Source;
use landfall_layout::{Diagnostic, Options};

/// The maximum number of scalars of a block that becomes parameters; larger blocks stay buffers.
const SCALARS: usize = 4096;

impl PureFunction {
    /// Makes a function of a shader pure.
    ///
    /// # Errors
    /// Fails if the shader does not run, the function does not exist, or its side effects rule out
    /// sampling.
    pub fn new(
        source: &Source,
        options: &Options,
        request: &PureRequest,
    ) -> Result<PureFunction, Box<Refusal>> {
        PureFunction::prepare(source, options, request, CallPurpose::Pure)
    }

    /// Prepares a function for a purpose; a single call need not be pure.
    pub(super) fn prepare(
        source: &Source,
        options: &Options,
        request: &PureRequest,
        purpose: CallPurpose,
    ) -> Result<PureFunction, Box<Refusal>> {
        let options = &options.clone().with_gather(true).with_naga(false);
        let module = Module::for_calls(source, options).map_err(|found| {
            Box::new(Refusal { found, files: landfall_layout::layout(source, options).files })
        })?;
        let files = module.files().clone();
        let refused =
            |found: Diagnostic| Box::new(Refusal { found: vec![found], files: files.clone() });
        make(source, options, module, request, purpose).map_err(|found| refused(*found))
    }
}

/// Makes a function that depends on its parameters alone.
fn make(
    source: &Source,
    options: &Options,
    mut module: Module,
    request: &PureRequest,
    purpose: CallPurpose,
) -> Result<PureFunction, Box<Diagnostic>> {
    let (language, path) = (source.language, source.path.as_str());
    let refuse = |m: ArgumentError| Box::new(Diagnostic::about(m.code, m.message, m.help, path));
    let info = find_by_name(&mut module, &request.function).map_err(refuse)?;
    let shown = spelled_signature(&info);
    let cannot = |Obstacle { what, help }: Obstacle| {
        let done = match purpose {
            CallPurpose::Pure => "sampled",
            CallPurpose::Call => "called",
        };
        let message = format!("`{shown}` cannot be {done}: {what}");
        let help = (!help.is_empty()).then(|| help.to_string());
        refuse(ArgumentError { code: Code::CannotCall, message, help })
    };
    let target = &module.ir.functions[info.handle];
    let mut reached = call_graph::variables(&module.ir, target);
    let effects = effects_of(&module.ir, target);
    if purpose == CallPurpose::Pure {
        is_confined_to_lane(&module, &effects).map_err(cannot)?;
    }
    let written = written(&module.ir, &info, &effects);
    let Caller { mut module, handle, inputs } =
        caller::caller(&module, info.handle).map_err(|mut all| Box::new(all.swap_remove(0)))?;
    let caller = &module.ir.functions[handle];
    through_initialisers(&module.ir, caller, &mut reached);
    // Read from the code as long as the blocks are variables.
    let read = reads::members(&module.ir, caller);
    let mut notes = Vec::new();
    let blocks = sampled(&module, &reached, &read, &request.data, &mut notes);
    let is_read = |input: &CallerInput| input.variable.is_some_and(|v| reached.contains(&v));
    let (read_inputs, inputs): (Vec<bool>, Vec<String>) =
        inputs.into_iter().map(|input| (is_read(&input), input.name)).unzip();
    // From here on, blocks are parameters of the caller.
    through_arguments(&mut module, handle, &blocks, &written);
    let bytes = bound::blocks(&module, &request.data, bound::zeros)?;
    bound::textures_are_there(&module, &request.textures)?;
    let files = module.files().clone();
    let writable = |block: &_| access::writable(block, &files, language);
    let resources = bound::resources(&module, bytes, writable, &request.textures);
    let module = module.validated().map_err(|mut all| Box::new(all.swap_remove(0)))?;
    let program = Program::rounded(&module, &[], request.floats);
    let signature = signature(&program, handle, &info).map_err(cannot)?;
    // The inputs are the caller's first parameters.
    let given = inputs.iter().cloned().zip(signature.parameters.iter().map(|p| p.ty.clone()));
    let given = given.collect();
    let known = CallerParameters {
        module: &module,
        language,
        inputs: &inputs,
        read_inputs,
        info: &info,
        blocks: &blocks,
    };
    let PublicParameters { parameters, slots, results } = list(&known, &signature);
    // A function may be called for its effects alone, but not sampled.
    if purpose == CallPurpose::Pure && results.is_empty() {
        let what = "it returns nothing".to_string();
        let help =
            "name a function that returns something, has an `out` parameter or writes a global";
        return Err(cannot(Obstacle { what, help }));
    }
    let reached = |handle: &&ModuleHandle| reached.contains(&handle.variable);
    notes.extend(white(module.handles().iter().filter(reached), &request.textures));
    Ok(PureFunction {
        shown,
        name_span: info.span,
        parameters,
        results,
        notes,
        files,
        language,
        program,
        resources,
        slots,
        data: request.data.clone(),
        textures: request.textures.clone(),
        module,
        info,
        inputs: given,
        source: source.clone(),
        options: options.clone(),
        purpose,
    })
}

/// The reason why a function cannot be sampled, and a remedy.
struct Obstacle {
    what: String,
    help: &'static str,
}

/// Returns the signature of the caller.
fn signature(
    program: &Program,
    caller: Handle<Function>,
    info: &FunctionInfo,
) -> Result<FunctionSignature, Obstacle> {
    match program.signature(caller.index()) {
        Ok(Some(signature)) => Ok(signature),
        Ok(None) => Err(Obstacle { what: opaque(info), help: "name the function that calls it" }),
        Err(what) => {
            Err(Obstacle { what: format!("the interpreter does not support {what}"), help: "" })
        }
    }
}

/// Fails if a function's effects go beyond its own lane.
fn is_confined_to_lane(module: &Module, effects: &Effects) -> Result<(), Obstacle> {
    if effects.derivatives {
        return Err(Obstacle {
            what: "it takes derivatives, but each sample is a single call without neighbours"
                .to_string(),
            help: "name the function whose arguments they depend on",
        });
    }
    let variables = module.ir.global_variables.iter();
    for (_, variable) in variables.filter(|(handle, _)| effects.stored.contains(handle)) {
        let what = match variable.space {
            AddressSpace::Storage { .. } | AddressSpace::WorkGroup => "buffer",
            AddressSpace::Handle => "image",
            // Private variables are the lane's own.
            _ => continue,
        };
        let name = variable.name.as_deref().unwrap_or_default();
        return Err(Obstacle {
            what: format!("it writes the {what} `{name}`"),
            help: "name a function that returns the value instead",
        });
    }
    if effects.together {
        let what = "it synchronises with other invocations or uses their values".to_string();
        return Err(Obstacle { what, help: "" });
    }
    Ok(())
}

/// Returns the blocks whose members become parameters: those in use without given values.
fn sampled(
    module: &Module,
    reached: &BTreeSet<Handle<GlobalVariable>>,
    read: &FxHashMap<Handle<GlobalVariable>, Members>,
    data: &Data,
    notes: &mut Vec<String>,
) -> Vec<SampledBlock> {
    let mut blocks = Vec::new();
    let mut shared = FxHashSet::default();
    for (number, block) in module.blocks.iter().enumerate() {
        let variable = block.variable;
        // The buffers of an array of blocks have one variable.
        if !reached.contains(&variable) || !shared.insert(variable) {
            continue;
        }
        if bound::values_for_block(data, block).is_some() {
            continue;
        }
        let name = &block.layout.name;
        let ty = ValueType::new(module, module.ir.global_variables[variable].ty);
        let Some(ValueType::Struct { members, .. }) = ty else {
            notes.push(format!(
                "`{name}` holds an array of unknown length, so it is read as zeros: set it with --data"
            ));
            continue;
        };
        let scalars: usize = members.iter().map(|(_, ty)| ty.scalars().len()).sum();
        if scalars > SCALARS {
            notes.push(format!(
                "`{name}` has {scalars} scalars, more than the {SCALARS} that are sampled, so it is \
                 read as zeros: set it with --data"
            ));
            continue;
        }
        let reads = |member: u32| {
            let members = read.get(&variable);
            members.is_some_and(|members| members.as_ref().is_none_or(|all| all.contains(&member)))
        };
        let members = (0..).zip(members);
        let members = members.map(|(nth, (name, ty))| SampledMember { name, ty, read: reads(nth) });
        blocks.push(SampledBlock { number, variable, members: members.collect() });
    }
    blocks
}
