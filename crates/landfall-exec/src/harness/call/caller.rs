//! A module with an added function that calls another as its entry point would: it sets inputs,
//! initialises global variables, and calls.
//!
//! The interpreter runs it for [`call`](super::call()), and drivers run the form that
//! [`kernel`](super::kernel) gives it.

use naga::{
    Block, Expression, Function, FunctionArgument, GlobalVariable, Handle, Span, Statement,
};

use landfall_ir::Module;
use landfall_layout::Diagnostic;

/// The name of the added function.
pub(super) const NAME: &str = "landfall_call";

/// A module with a calling function; its [`NAME`] takes the inputs before the called function's
/// arguments.
pub(super) struct Caller {
    pub module: Module,
    pub handle: Handle<Function>,
    /// The shader's inputs, one parameter each.
    pub inputs: Vec<CallerInput>,
}

/// An input of the shader.
pub(super) struct CallerInput {
    pub name: String,
    /// The variable that holds it in the shader.
    pub variable: Option<Handle<GlobalVariable>>,
}

/// Returns the module with a function that calls `target`.
pub(super) fn caller(module: &Module, target: Handle<Function>) -> Result<Caller, Vec<Diagnostic>> {
    let mut module = module.clone();
    let (mut function, inputs) = prologue(&module);
    let callee = &module.ir.functions[target];
    let base = function.arguments.len() as u32;
    let mut arguments = Vec::new();
    for (index, argument) in callee.arguments.iter().enumerate() {
        // The target's arguments come after the inputs.
        let (name, ty) = (argument.name.clone(), argument.ty);
        function.arguments.push(FunctionArgument { name, ty, binding: None });
        let given = Expression::FunctionArgument(base + index as u32);
        arguments.push(function.expressions.append(given, Span::UNDEFINED));
    }
    let result = callee
        .result
        .is_some()
        .then(|| function.expressions.append(Expression::CallResult(target), Span::UNDEFINED));
    function.result = callee.result.clone();
    let call = Statement::Call { function: target, arguments, result };
    function.body.push(call, Span::UNDEFINED);
    function.body.push(Statement::Return { value: result }, Span::UNDEFINED);
    let handle = module.ir.functions.append(function, Span::UNDEFINED);
    Ok(Caller { module: module.validated()?, handle, inputs })
}

/// Returns the part of GLSL's entry point before the call of `main`; empty if there is no `main`.
fn prologue(module: &Module) -> (Function, Vec<CallerInput>) {
    let empty = || (Function { name: Some(NAME.to_string()), ..Function::default() }, Vec::new());
    let Some(main) = module.functions().iter().find(|f| f.name == "main").map(|f| f.handle) else {
        return empty();
    };
    let Some(entry) = module.ir.entry_points.iter().find(|entry| entry.name == "main") else {
        return empty();
    };
    let is_call =
        |s: &Statement| matches!(s, Statement::Call { function, .. } if *function == main);
    // WGSL's entry points are ordinary functions.
    if !entry.function.body.iter().any(is_call) {
        return empty();
    }
    let mut function = entry.function.clone();
    function.name = Some(NAME.to_string());
    function.named_expressions.clear();
    let mut body = Block::new();
    // naga's entry point of GLSL stores the inputs in variables, runs the initialisers, calls
    // `main` and loads the outputs.
    for (statement, span) in entry.function.body.span_iter() {
        if is_call(statement) {
            break;
        }
        body.push(statement.clone(), *span);
    }
    // What the other statements computed stays among the expressions, unused.
    function.body = body;
    let inputs = function.arguments.iter_mut().map(|argument| {
        // Only an entry point has bindings: its inputs become parameters.
        let location = match argument.binding.take() {
            Some(naga::Binding::Location { location, .. }) => Some(location),
            Some(naga::Binding::BuiltIn(_)) | None => None,
        };
        let known = module.inputs().iter().find(|input| Some(input.location) == location);
        let own = argument.name.clone().unwrap_or_default();
        let named = || {
            let mut all = module.ir.global_variables.iter();
            all.find(|(_, variable)| variable.name.as_ref() == Some(&own)).map(|(handle, _)| handle)
        };
        match known {
            Some(known) => CallerInput { name: known.name.clone(), variable: Some(known.variable) },
            // A built-in input.
            None => CallerInput { variable: named(), name: own },
        }
    });
    let inputs = inputs.collect();
    (function, inputs)
}
