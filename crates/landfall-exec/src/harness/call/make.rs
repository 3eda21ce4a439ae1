//! Makes a function of a shader pure: refuses what cannot be sampled, turns blocks into
//! parameters, and binds what stays fixed.
//!
//! Made of a [`Module`]; gives [`pure`](super::pure) all it holds.

use landfall_layout::diagnostic::Code;
use naga::{AddressSpace, Function, GlobalVariable, Handle};
use rustc_hash::{FxHashMap, FxHashSet};

use super::arguments::Misfit;
use super::caller;
use super::caller::{Caller, CallerInput};
use super::effects::{Seen, look, through_initialisers};
use super::find::{alone, opaque, shown};
use super::globals::through_arguments;
use super::parameters::{Known, Listed, list};
use super::pure::{Asks, Pure, PureRequest};
use super::reads;
use super::reads::Members;
use super::white;
use crate::harness::access;
use crate::harness::bindings as bound;
use crate::harness::bindings::Data;
use crate::interp::{FunctionSignature, Program, ValueType};
use landfall_ir::module::{FunctionInfo, ModuleHandle};
use landfall_ir::{Module, reach};
use landfall_layout::source::Source;
use landfall_layout::{Diagnostic, Options};

/// Scalars a block may have to become parameters; larger ones stay buffers.
const SCALARS: usize = 4096;

/// A block whose members become parameters.
pub(super) struct Sampled {
    /// Which of the module's.
    pub number: usize,
    pub variable: Handle<GlobalVariable>,
    pub members: Vec<SampledMember>,
}

pub(super) struct SampledMember {
    pub name: String,
    pub ty: ValueType,
    pub read: bool,
}

/// The function as one that depends on its parameters alone.
pub(super) fn make(
    source: &Source,
    options: &Options,
    mut module: Module,
    request: &PureRequest,
    asks: Asks,
) -> Result<Pure, Box<Diagnostic>> {
    let (language, path) = (source.language, source.path.as_str());
    let refuse = |m: Misfit| Box::new(Diagnostic::about(m.code, m.message, m.help, path));
    let info = alone(&mut module, &request.function).map_err(refuse)?;
    let shown = shown(&info);
    let cannot = |Why { what, help }: Why| {
        let done = match asks {
            Asks::Pure => "sampled",
            Asks::Call => "called",
        };
        let message = format!("`{shown}` cannot be {done}: {what}");
        let help = (!help.is_empty()).then(|| help.to_string());
        refuse(Misfit { code: Code::CannotCall, message, help })
    };
    let target = &module.ir.functions[info.handle];
    let mut reached = reach::variables(&module.ir, target);
    let seen = look(&module.ir, target);
    if asks == Asks::Pure {
        of_its_own_lane(&module, &seen).map_err(cannot)?;
    }
    let private = |(handle, variable): (Handle<GlobalVariable>, &GlobalVariable)| {
        let written = variable.space == AddressSpace::Private && seen.stored.contains(&handle);
        written.then_some(handle)
    };
    // What a function returns is its result; one that returns nothing gives what it writes.
    let written: Vec<Handle<GlobalVariable>> = match info.returns {
        Some(_) => Vec::new(),
        None => module.ir.global_variables.iter().filter_map(private).collect(),
    };
    let Caller { mut module, handle, inputs } =
        caller::caller(&module, info.handle).map_err(|mut all| Box::new(all.swap_remove(0)))?;
    let caller = &module.ir.functions[handle];
    through_initialisers(&module.ir, caller, &mut reached);
    let read = reads::members(&module.ir, caller);
    let mut notes = Vec::new();
    let blocks = sampled(&module, &reached, &read, &request.data, &mut notes);
    let is_read = |input: &CallerInput| input.variable.is_some_and(|v| reached.contains(&v));
    let (read_inputs, inputs): (Vec<bool>, Vec<String>) =
        inputs.into_iter().map(|input| (is_read(&input), input.name)).unzip();
    through_arguments(&mut module, handle, &blocks, &written);
    let bytes = bound::blocks(&module, &request.data, bound::zeros)?;
    bound::textures_are_there(&module, &request.textures)?;
    let files = module.files().clone();
    let writable = |block: &_| access::writable(block, &files, language);
    let resources = bound::resources(&module, bytes, writable, &request.textures);
    let module = module.validated().map_err(|mut all| Box::new(all.swap_remove(0)))?;
    let program = Program::rounded(&module, &[], request.floats);
    let signature = signature(&program, handle, &info).map_err(cannot)?;
    let given = inputs.iter().cloned().zip(signature.parameters.iter().map(|p| p.ty.clone()));
    let given = given.collect();
    let known = Known {
        module: &module,
        language,
        inputs: &inputs,
        read_inputs,
        info: &info,
        blocks: &blocks,
    };
    let Listed { parameters, slots, results } = list(&known, &signature);
    if asks == Asks::Pure && results.is_empty() {
        let what = "it gives nothing back".to_string();
        let help =
            "name a function that returns something, has an `out` parameter or writes a global";
        return Err(cannot(Why { what, help }));
    }
    let reached = |handle: &&ModuleHandle| reached.contains(&handle.variable);
    notes.extend(white(module.handles().iter().filter(reached), &request.textures));
    Ok(Pure {
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
        asks,
    })
}

/// Why a function cannot be sampled, and what to do.
struct Why {
    what: String,
    help: &'static str,
}

/// What the caller takes and gives.
fn signature(
    program: &Program,
    caller: Handle<Function>,
    info: &FunctionInfo,
) -> Result<FunctionSignature, Why> {
    match program.signature(caller.index()) {
        Ok(Some(signature)) => Ok(signature),
        Ok(None) => Err(Why { what: opaque(info), help: "name the function that calls it" }),
        Err(what) => Err(Why { what: format!("the evaluator does not know {what}"), help: "" }),
    }
}

/// That what a function does is of its own lane.
fn of_its_own_lane(module: &Module, seen: &Seen) -> Result<(), Why> {
    if seen.derivatives {
        return Err(Why {
            what: "it takes derivatives, which samples do not have".to_string(),
            help: "name the function that is given what they depend on",
        });
    }
    let variables = module.ir.global_variables.iter();
    for (_, variable) in variables.filter(|(handle, _)| seen.stored.contains(handle)) {
        let what = match variable.space {
            AddressSpace::Storage { .. } | AddressSpace::WorkGroup => "buffer",
            AddressSpace::Handle => "image",
            _ => continue,
        };
        let name = variable.name.as_deref().unwrap_or_default();
        return Err(Why {
            what: format!("it writes the {what} `{name}`"),
            help: "name a function that returns what is to be written",
        });
    }
    if seen.together {
        let what = "it waits for other invocations, or computes with them".to_string();
        return Err(Why { what, help: "" });
    }
    Ok(())
}

/// The blocks whose members become parameters: those that are reached and not given.
fn sampled(
    module: &Module,
    reached: &FxHashSet<Handle<GlobalVariable>>,
    read: &FxHashMap<Handle<GlobalVariable>, Members>,
    data: &Data,
    notes: &mut Vec<String>,
) -> Vec<Sampled> {
    let mut blocks = Vec::new();
    let mut shared = FxHashSet::default();
    for (number, block) in module.blocks.iter().enumerate() {
        let variable = block.variable;
        if !reached.contains(&variable) || !shared.insert(variable) {
            continue;
        }
        if bound::given(data, block).is_some() {
            continue;
        }
        let name = &block.layout.name;
        let ty = ValueType::of(module, module.ir.global_variables[variable].ty);
        let Some(ValueType::Struct { members, .. }) = ty else {
            notes.push(format!(
                "`{name}` is no structure of a known size: it is zero, --data gives values"
            ));
            continue;
        };
        let scalars: usize = members.iter().map(|(_, ty)| ty.scalars().len()).sum();
        if scalars > SCALARS {
            notes.push(format!("`{name}` has {scalars} scalars: it is zero, --data gives values"));
            continue;
        }
        let reads = |member: u32| {
            let members = read.get(&variable);
            members.is_some_and(|members| members.as_ref().is_none_or(|all| all.contains(&member)))
        };
        let members = (0..).zip(members);
        let members = members.map(|(nth, (name, ty))| SampledMember { name, ty, read: reads(nth) });
        blocks.push(Sampled { number, variable, members: members.collect() });
    }
    blocks
}
