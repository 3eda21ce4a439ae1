//! Finds the function of a request: by its name, its name and types, or its arguments.

use landfall_layout::diagnostic::Code;
use serde_json::Value;

use super::arguments::{ArgumentError, append_words};
use landfall_interp::{FunctionSignature, Program, Words};
use landfall_ir::Module;
use landfall_ir::module::{Direction, FunctionInfo, Parameter, SkippedFunction};
use landfall_layout::source::{Language, Span};
use landfall_layout::text::edit_distance::suggestion;

/// The function to call and its arguments as words.
#[derive(Debug)]
pub struct Target<'m> {
    pub info: &'m FunctionInfo,
    pub signature: FunctionSignature,
    /// By parameter; empty for an `out` parameter.
    pub arguments: Vec<Words>,
}

/// Finds the function among those of a module, or the entry point that was made one.
pub(super) fn find<'m>(
    module: &'m Module,
    entry_point: Option<&'m FunctionInfo>,
    program: &Program,
    meant: &str,
    arguments: &[Value],
    language: Language,
) -> Result<Target<'m>, ArgumentError> {
    let Candidates { name, mut named, mut fitting } = Candidates::new(module, meant);
    if named.is_empty() {
        let Some(entry_point) = entry_point else { return Err(unknown(module, name)) };
        named.push(entry_point);
        fitting.push(entry_point);
    }
    let mut wrong = None;
    let mut found = Vec::new();
    for info in &fitting {
        // Each overload takes the arguments or gives the reason why not.
        match converted_arguments(program, info, arguments, language) {
            Ok(taken) => found.push(taken),
            // Of several overloads, the error of one with the right number of parameters explains
            // most.
            Err(misfit) if wrong.is_none() || misfit.code != "wrong-count" => wrong = Some(misfit),
            Err(_) => {}
        }
    }
    match (found.len(), wrong) {
        (1, _) => Ok(found.swap_remove(0)),
        (0, Some(misfit)) if fitting.len() == 1 => Err(misfit),
        (0, Some(misfit)) => Err(ArgumentError {
            code: Code::NoOverload,
            message: format!("no `{name}` takes these arguments: {}", misfit.message),
            help: Some(format!("there is {}", all_of(&named))),
        }),
        (0, None) => Err(no_such_parameters(name, &named)),
        (_, _) => Err(ArgumentError {
            code: Code::AmbiguousFunction,
            message: format!("{} overloads of `{name}` accept these arguments", found.len()),
            help: Some(format!("select one by its parameter types: {}", all_of(&named))),
        }),
    }
}

/// Returns the arguments converted to the function's parameters.
fn converted_arguments<'m>(
    program: &Program,
    info: &'m FunctionInfo,
    given: &[Value],
    language: Language,
) -> Result<Target<'m>, ArgumentError> {
    let cannot = |message: String| ArgumentError { code: Code::CannotCall, message, help: None };
    let signature = program.signature(info.handle.index()).map_err(|what| {
        let shown = spelled_signature(info);
        cannot(format!("`{shown}` cannot be called: the interpreter does not support {what}"))
    })?;
    let Some(signature) = signature else {
        let (shown, which) = (spelled_signature(info), opaque(info));
        return Err(cannot(format!("`{shown}` cannot be called: {which}"))
            .with_help("call the function that calls it"));
    };
    let is_out =
        |at: &usize| info.parameters.get(*at).is_some_and(|p| p.direction == Direction::Out);
    let all = signature.parameters.len();
    let outs = (0..all).filter(is_out).count();
    let mut given: Vec<Option<&Value>> = given.iter().map(Some).collect();
    if given.len() == all - outs && outs > 0 {
        // `out` parameters were left out.
        (0..all).filter(is_out).for_each(|at| given.insert(at, None));
    }
    if given.len() != all {
        return Err(ArgumentError {
            code: Code::WrongCount,
            message: format!(
                "`{}` takes {}, but {} given",
                spelled_signature(info),
                match all {
                    1 => "1 argument".to_string(),
                    _ => format!("{all} arguments"),
                },
                match given.len() {
                    0 => "none was".to_string(),
                    1 => "1 was".to_string(),
                    given => format!("{given} were"),
                }
            ),
            help: Some(format!("it is declared as `{}`", declared(info))),
        });
    }
    let mut arguments = Vec::with_capacity(all);
    for (at, (parameter, value)) in signature.parameters.iter().zip(given).enumerate() {
        // `null` may stand for an `out` parameter.
        let value = value.filter(|value| !(is_out(&at) && value.is_null()));
        let mut flat = Vec::new();
        if let Some(value) = value {
            append_words(&parameter.ty, value, &format!("args[{at}]"), language, &mut flat)?;
        } else {
            flat.resize(parameter.ty.scalars().len(), 0);
        }
        arguments.push(flat.into_iter().map(|word| vec![word]).collect());
    }
    Ok(Target { info, signature, arguments })
}

/// Returns a message that names the parameter without a plain value.
pub(super) fn opaque(info: &FunctionInfo) -> String {
    let words = ["sampler", "texture", "image"];
    let opaque = info.parameters.iter().find(|p| words.iter().any(|w| p.ty.contains(w)));
    opaque.map_or("a parameter is not made of numbers: it is a sampler, image or pointer".to_string(), |p| {
        format!("`{}` is a `{}`, but arguments can only be numbers, vectors, matrices, and arrays or structures of them", p.name, p.ty)
    })
}

/// Finds a function by name, whatever its arguments; an entry point of WGSL as a function.
pub(super) fn find_by_name(
    module: &mut Module,
    meant: &str,
) -> Result<FunctionInfo, ArgumentError> {
    let Candidates { name, named, fitting } = Candidates::new(module, meant);
    match (&fitting[..], named.len()) {
        ([one], _) => Ok((*one).clone()),
        ([], 0) => {
            let called = entry_as_function(module, name);
            called.ok_or_else(|| unknown(module, name))
        }
        ([], _) => Err(no_such_parameters(name, &named)),
        (_, several) => Err(ArgumentError {
            code: Code::AmbiguousFunction,
            message: format!("{several} functions are named `{name}`"),
            help: Some(format!("select one by its parameter types: {}", all_of(&named))),
        }),
    }
}

/// The functions of a name, and those with the types of the request.
struct Candidates<'m, 'a> {
    name: &'a str,
    named: Vec<&'m FunctionInfo>,
    fitting: Vec<&'m FunctionInfo>,
}

impl<'m, 'a> Candidates<'m, 'a> {
    fn new(module: &'m Module, meant: &'a str) -> Candidates<'m, 'a> {
        let (name, types) = match meant.split_once('(') {
            Some((name, types)) => {
                (name.trim(), Some(without_spaces(types.trim().trim_end_matches(')'))))
            }
            None => (meant.trim(), None),
        };
        let named: Vec<&FunctionInfo> =
            module.functions().iter().filter(|f| f.name == name).collect();
        let fits = |info: &&FunctionInfo| {
            types.as_ref().is_none_or(|types| without_spaces(&parameter_types(info)) == *types)
        };
        let fitting = named.iter().copied().filter(fits).collect();
        Candidates { name, named, fitting }
    }
}

fn no_such_parameters(name: &str, named: &[&FunctionInfo]) -> ArgumentError {
    ArgumentError {
        code: Code::UnknownFunction,
        message: format!("no function `{name}` has these parameters"),
        help: Some(format!("there is {}", all_of(named))),
    }
}

fn all_of(named: &[&FunctionInfo]) -> String {
    named.iter().map(|info| format!("`{}`", spelled_signature(info))).collect::<Vec<_>>().join(", ")
}

/// Returns an entry point of WGSL as a function of its stage's inputs, added to the module.
pub(super) fn entry_as_function(module: &mut Module, name: &str) -> Option<FunctionInfo> {
    let entry = module.ir.entry_points.iter().find(|entry| entry.name == name)?;
    let mut function = entry.function.clone();
    // Another name than that of the entry point, which stays.
    function.name = Some(format!("{name}_called"));
    // Only entry points may have bindings.
    function.arguments.iter_mut().for_each(|argument| argument.binding = None);
    if let Some(result) = &mut function.result {
        result.binding = None;
    }
    let parameters = function.arguments.iter().map(|argument| Parameter {
        name: argument.name.clone().unwrap_or_default(),
        ty: module.ir.types[argument.ty].name.clone().unwrap_or_default(),
        direction: Direction::In,
    });
    let parameters = parameters.collect();
    let returns = function.result.as_ref().map(|_| String::new());
    let handle = module.ir.functions.append(function, naga::Span::UNDEFINED);
    let (name, span) = (name.to_string(), Span::default());
    Some(FunctionInfo { name, parameters, returns, span, handle })
}

/// Returns the error of a function that cannot be called: it does not exist or does not run.
pub(super) fn unknown(module: &Module, name: &str) -> ArgumentError {
    if let Some(SkippedFunction { why, .. }) =
        module.left_out().iter().find(|left| left.function == name)
    {
        let place = why.labels.first().map(|label| module.files().locate(label.at));
        let place = place.map_or(String::new(), |at| format!(", at {}:{}", at.path, at.line));
        let message = format!("`{name}` cannot run: {}{place}", why.message);
        return ArgumentError { code: Code::CannotCall, message, help: why.help.clone() };
    }
    let entries = || module.ir.entry_points.iter().map(|entry| entry.name.as_str());
    let names =
        || module.functions().iter().map(|function| function.name.as_str()).chain(entries());
    let list = || {
        let functions = module.functions().iter().filter(|f| f.name != "main");
        let entries = entries().filter(|entry| *entry != "main").map(str::to_string);
        let all: Vec<String> = functions.map(spelled_signature).chain(entries).collect();
        match all.is_empty() {
            true => "it has no functions but `main`".to_string(),
            false => format!("its functions are `{}`", all.join("`, `")),
        }
    };
    ArgumentError {
        code: Code::UnknownFunction,
        message: format!("the shader has no function `{name}`"),
        help: Some(suggestion(name, names()).unwrap_or_else(list)),
    }
}

/// Returns `phong(vec3, Light)`.
pub(super) fn spelled_signature(info: &FunctionInfo) -> String {
    format!("{}({})", info.name, parameter_types(info))
}

fn parameter_types(info: &FunctionInfo) -> String {
    info.parameters.iter().map(|p| p.ty.as_str()).collect::<Vec<_>>().join(", ")
}

/// Returns `phong(vec3 normal, Light light)`.
fn declared(info: &FunctionInfo) -> String {
    let parameters = info.parameters.iter().map(|p| {
        let way = match p.direction {
            Direction::In => "",
            Direction::Out => "out ",
            Direction::InOut => "inout ",
        };
        format!("{way}{} {}", p.ty, p.name).trim_end().to_string()
    });
    format!("{}({})", info.name, parameters.collect::<Vec<_>>().join(", "))
}

/// Returns types without spaces, for comparison.
fn without_spaces(types: &str) -> String {
    types.chars().filter(|c| !c.is_whitespace()).collect()
}
