//! Adds an entry point to a module that calls the function once per lane, for wgpu and the
//! interpreter.
//!
//! Compute, or a fragment stage if the function needs one (discards, implicit derivatives) or reads
//! many words.

use naga::{
    AddressSpace, ArraySize, BinaryOperator, Binding, BuiltIn, EntryPoint, Expression, Function,
    FunctionArgument, GlobalVariable, Handle, ResourceBinding, Scalar, ScalarKind, ShaderStage,
    Span, Statement, StorageAccess, Type, TypeInner, VectorSize,
};

use super::builder::{At, KernelBuilder};
use super::packing::LaneWords;
use super::{KernelCode, LaneMap, ROW, buffer, refused};
use crate::backend::{Failure, Resource, ResourceKind, StageCode};
use crate::harness::call::pure::{CallPurpose, ParameterSlot, PureFunction};
use landfall_ir::Module;
use landfall_layout::Diagnostic;
use landfall_layout::source::Stage;

/// The name of the new entry point.
const ENTRY: &str = "landfall_main";
/// The names of the buffers.
const INPUTS: &str = "landfall_in";
const OUTPUTS: &str = "landfall_out";

/// Words per lane from which a fragment stage is preferred: llvmpipe (Mesa 22.3.6) compiles compute
/// shaders as coroutines, whose compile time grows with the words per lane.
const LARGE: u32 = 128;

/// Invocations of a workgroup.
const GROUP: u32 = 64;

/// Returns the workgroup size: 1 for a function that is called once and may have side effects.
fn invocations(pure: &PureFunction) -> u32 {
    match pure.purpose {
        CallPurpose::Pure => GROUP,
        CallPurpose::Call => 1,
    }
}

/// Returns the code that runs a function.
pub(super) fn code(pure: &PureFunction, places: &LaneWords) -> Result<KernelCode, Failure> {
    let bindings = pure.module.free_places();
    let compute = (Stage::Compute, ShaderStage::Compute);
    let fragment = (Stage::Fragment, ShaderStage::Fragment);
    let [first, second] = match places.words_in > LARGE {
        false => [compute, fragment],
        true => [fragment, compute],
    };
    let at =
        |(stage, entry)| build_module(pure, places, bindings, entry).map(|module| (stage, module));
    // The other stage where the first fails, such as the fragment stage for a function that
    // discards.
    let made = at(first).or_else(|found| at(second).map_err(|_| found));
    let (stage, module) = made.map_err(|found| refused(found.first()))?;
    // Blocks that became variables of a lane are not bound, and their bindings may be reused.
    let has = |module: &Module, resource: &Resource| {
        let place = Some(ResourceBinding { group: resource.group, binding: resource.binding });
        let pushed = matches!(resource.kind, ResourceKind::PushConstant(_));
        module.ir.global_variables.iter().any(|(_, global)| {
            if pushed { global.space == AddressSpace::Immediate } else { global.binding == place }
        })
    };
    let bound = |resource: &&Resource| has(&pure.module, resource) && has(&module, resource);
    Ok(KernelCode {
        resources: pure.resources.iter().filter(bound).cloned().collect(),
        stages: vec![StageCode::of_module(stage, ENTRY, module)],
        buffers: [buffer(INPUTS, bindings[0]), buffer(OUTPUTS, bindings[1])],
        lanes: match stage {
            Stage::Fragment => LaneMap::pixels(pure)?,
            _ => LaneMap::Groups(invocations(pure)),
        },
    })
}

/// Returns the module, reduced to what a lane runs.
fn build_module(
    pure: &PureFunction,
    places: &LaneWords,
    bindings: [(u32, u32); 2],
    stage: ShaderStage,
) -> Result<Module, Vec<Diagnostic>> {
    let mut ir = pure.module.ir.clone();
    let uint = Type { name: None, inner: TypeInner::Scalar(Scalar::U32) };
    let uint = ir.types.insert(uint, Span::UNDEFINED);
    let words = TypeInner::Array { base: uint, size: ArraySize::Dynamic, stride: 4 };
    let words = ir.types.insert(Type { name: None, inner: words }, Span::UNDEFINED);
    let mut variable = |name: &str, (group, binding): (u32, u32), access| {
        let global = GlobalVariable {
            name: Some(name.to_string()),
            space: AddressSpace::Storage { access },
            binding: Some(ResourceBinding { group, binding }),
            ty: words,
            init: None,
            memory_decorations: naga::MemoryDecorations::empty(),
        };
        ir.global_variables.append(global, Span::UNDEFINED)
    };
    let inputs = variable(INPUTS, bindings[0], StorageAccess::LOAD);
    let outputs = variable(OUTPUTS, bindings[1], StorageAccess::LOAD | StorageAccess::STORE);
    let function = entry(pure, places, &mut ir, [inputs, outputs], stage);
    let function = function.ok_or_else(|| {
        let message = "a parameter or result is not made of numbers";
        vec![Diagnostic::error(
            landfall_layout::diagnostic::Code::CannotRun,
            landfall_layout::Span::default(),
            message,
        )]
    })?;
    let compute = stage == ShaderStage::Compute;
    ir.entry_points = vec![EntryPoint {
        name: ENTRY.to_string(),
        stage,
        early_depth_test: None,
        workgroup_size: if compute { [invocations(pure), 1, 1] } else { [0; 3] },
        workgroup_size_overrides: None,
        function,
        mesh_info: None,
        task_payload: None,
        incoming_ray_payload: None,
    }];
    // Compaction needs a valid module.
    let whole = Module::unvalidated(ir, pure.files.clone(), Vec::new()).validated()?;
    // What no lane calls may use features that the device lacks.
    let mut ir = whole.ir;
    naga::compact::compact(&mut ir, naga::compact::KeepUnused::No);
    Module::unvalidated(ir, pure.files.clone(), Vec::new()).validated()
}

/// Builds the entry point: reads the words of a lane, calls the function, writes the results.
fn entry(
    pure: &PureFunction,
    places: &LaneWords,
    ir: &mut naga::Module,
    [inputs, outputs]: [Handle<GlobalVariable>; 2],
    stage: ShaderStage,
) -> Option<Function> {
    let (caller, parameters, result) = {
        // The caller is the last function.
        let (handle, caller) = ir.functions.iter().last()?;
        let types: Vec<Handle<Type>> = caller.arguments.iter().map(|a| a.ty).collect();
        (handle, types, caller.result.as_ref().map(|result| result.ty))
    };
    let blocks = blocks_apart(pure, &mut ir.functions[caller]);
    let mut new = KernelBuilder::new(&mut ir.types);
    let lane = match pure.purpose {
        CallPurpose::Pure => lane(&mut new, stage),
        // Other pixels run for the derivatives only.
        CallPurpose::Call => new.number(0),
    };
    let from = new.number(places.words_in);
    let to = new.number(places.words_out);
    let [inputs, outputs] =
        [inputs, outputs].map(|v| new.add_before_body(Expression::GlobalVariable(v)));
    new.count_by_length(outputs);
    let base = new.binary(BinaryOperator::Multiply, lane, from);
    let from = At { buffer: inputs, base, offset: 0 };
    let base = new.binary(BinaryOperator::Multiply, lane, to);
    let to = At { buffer: outputs, base, offset: 0 };
    let mut arguments = Vec::with_capacity(parameters.len());
    for (nth, (ty, slot)) in parameters.iter().zip(&pure.slots).enumerate() {
        if let Some((_, block)) = blocks.iter().find(|(at, _)| *at == nth) {
            let pointer = new.add_before_body(Expression::GlobalVariable(*block));
            new.load_into(pointer, *ty, At { offset: places.slot(slot)?, ..from })?;
            arguments.push(None);
            continue;
        }
        let pointed = match new.types[*ty].inner {
            TypeInner::Pointer { base, .. } => Some(base),
            _ => None,
        };
        let first = match (places.slot(slot), slot) {
            (Some(first), _) => Some(At { offset: first, ..from }),
            (None, ParameterSlot::Given(_) | ParameterSlot::Zero(_) | ParameterSlot::Out) => None,
        };
        arguments.push(Some(match (pointed, first) {
            (None, Some(at)) => new.load(*ty, at)?,
            (None, None) => new.add_before_body(Expression::ZeroValue(*ty)),
            (Some(ty), Some(at)) => {
                let pointer = new.local(ty);
                new.load_into(pointer, ty, at)?;
                pointer
            }
            // Local variables start as zeros.
            (Some(ty), None) => new.local(ty),
        }));
    }
    let returned = result.map(|ty| (new.call_result(caller), ty));
    let call = Statement::Call {
        function: caller,
        // Blocks are variables now.
        arguments: arguments.iter().copied().flatten().collect(),
        result: returned.map(|(value, _)| value),
    };
    new.statement(call);
    for (result, first) in pure.results.iter().zip(&places.results) {
        let to = At { offset: *first, ..to };
        match result.at {
            None => {
                let (value, ty) = returned?;
                new.store(ty, value, to)?;
            }
            Some(at) => {
                let TypeInner::Pointer { base, .. } = new.types[parameters[at]].inner else {
                    return None;
                };
                new.store_from(arguments[at]?, base, to)?;
            }
        }
    }
    // A lane that discards does not get here.
    let one = new.number(1);
    new.store_word(one, At { offset: places.done, ..to });
    new.statement(Statement::Return { value: None });
    let mut function = new.finish();
    function.name = Some(ENTRY.to_string());
    Some(function)
}

/// Takes the blocks out of the caller's parameters: returns their numbers and the variables to fill
/// before the call.
fn blocks_apart(
    pure: &PureFunction,
    caller: &mut Function,
) -> Vec<(usize, Handle<GlobalVariable>)> {
    let first = pure.inputs.len() + pure.info.parameters.len();
    let given =
        pure.slots.iter().skip(first).take_while(|slot| matches!(slot, ParameterSlot::Given(_)));
    let range = first..first + given.count();
    let mut blocks = Vec::new();
    let mut body = naga::Block::new();
    for (statement, span) in std::mem::take(&mut caller.body).span_iter() {
        if let Statement::Store { pointer, value } = statement {
            let expressions = (&caller.expressions[*pointer], &caller.expressions[*value]);
            if let (Expression::GlobalVariable(block), Expression::FunctionArgument(at)) =
                expressions
            {
                if range.contains(&(*at as usize)) {
                    blocks.push((*at as usize, *block));
                    continue;
                }
            }
        }
        body.push(statement.clone(), *span);
    }
    caller.body = body;
    caller.arguments.drain(range.clone());
    for (_, expression) in caller.expressions.iter_mut() {
        let Expression::FunctionArgument(at) = expression else { continue };
        if range.contains(&(*at as usize)) {
            // No longer read by anything.
            *expression = Expression::Literal(naga::Literal::U32(0));
        } else if *at as usize >= range.end {
            *at -= range.len() as u32;
        }
    }
    blocks
}

/// Computes the number of the running lane.
fn lane(new: &mut KernelBuilder<'_>, stage: ShaderStage) -> Handle<Expression> {
    let compute = stage == ShaderStage::Compute;
    let (inner, builtin) = match compute {
        true => (
            TypeInner::Vector { size: VectorSize::Tri, scalar: Scalar::U32 },
            BuiltIn::GlobalInvocationId,
        ),
        false => (
            TypeInner::Vector { size: VectorSize::Quad, scalar: Scalar::F32 },
            BuiltIn::Position { invariant: false },
        ),
    };
    let ty = new.ty(inner);
    let binding = Some(Binding::BuiltIn(builtin));
    new.function.arguments.push(FunctionArgument { name: None, ty, binding });
    let place = new.add_before_body(Expression::FunctionArgument(0));
    let x = new.index(place, 0);
    if compute {
        return x;
    }
    // The coordinate is that of the pixel's centre; the conversion drops the half.
    let whole = |expr| Expression::As { expr, kind: ScalarKind::Uint, convert: Some(4) };
    let x = new.computed(whole(x));
    let y = new.index(place, 1);
    let y = new.computed(whole(y));
    let row = new.number(ROW);
    let before = new.binary(BinaryOperator::Multiply, y, row);
    new.binary(BinaryOperator::Add, before, x)
}
