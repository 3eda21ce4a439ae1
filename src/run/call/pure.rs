//! A function of a shader with everything it reads as a parameter: arguments, inputs of the
//! stage, members of blocks. What it writes besides its result comes back too.
//!
//! Made of a shader's text; [`accuracy::stress`](crate::accuracy::stress) calls it over many
//! samples at a time.

use naga::{
    AddressSpace, Block, Expression, Function, FunctionArgument, GlobalVariable, Handle, Span,
    Statement, Type, TypeInner,
};
use rustc_hash::FxHashSet;
use serde_json::{Map, Value};

use super::caller::{self, Caller};
use super::effects::{look, through_initialisers};
use super::find::{shown, unknown};
use super::reads;
use super::report::Given;
use super::{Refusal, arguments, finding};
use crate::run::bound::{self, Data};
use crate::run::eval::{
    Call, Called, Floats, Numbers, Place, Program, Settings, Step, Trace, ValueType, Words,
};
use crate::run::glsl::reach;
use crate::run::module::{Direction, FunctionInfo};
use crate::run::reader::{Failure, Resource};
use crate::run::{Module, verify};
use crate::source::{Files, Language, Source, Span as TextSpan};
use crate::{Diagnostic, Options};

/// Scalars a block may have to become parameters; larger ones stay buffers.
const SCALARS: usize = 4096;

/// What is to be called, and what of it stays fixed.
#[derive(Clone, Debug, Default)]
pub struct PureRequest {
    /// The function: `phong`, or `phong(vec3, Light)` where several have the name.
    pub function: String,
    /// What blocks hold; the others are parameters.
    pub data: Data,
    /// Colours of textures by name; the others are white.
    pub textures: Vec<(String, [f32; 4])>,
    /// What its floats are rounded to.
    pub floats: Floats,
}

/// A function that depends on its parameters alone.
#[derive(Debug)]
pub struct Pure {
    /// Its name with the types of its parameters.
    pub shown: String,
    /// Its name in the text.
    pub name_span: Option<TextSpan>,
    /// What it reads.
    pub parameters: Vec<PureParameter>,
    /// What it gives.
    pub results: Vec<PureResult>,
    /// What was taken for what was not given.
    pub notes: Vec<String>,
    /// The files the shader is made of.
    pub files: Files,
    /// The language the shader is written in.
    pub language: Language,
    program: Program,
    pub(super) resources: Vec<Resource>,
    /// By parameter of the caller: which of ours, or what stands there.
    pub(super) slots: Vec<Slot>,
    /// Data that was given, for repeating a call.
    pub(super) data: Data,
    /// Colours of textures that were given.
    pub(super) textures: Vec<(String, [f32; 4])>,
    /// The module; its last function is the caller.
    pub(super) module: Module,
    /// The function as its text declares it.
    pub(super) info: FunctionInfo,
    /// The inputs of the stage, which the caller takes first, whether they are read or not.
    pub(super) inputs: Vec<(String, ValueType)>,
    /// The text, and how it is read: a driver may have a compiler of its own.
    pub(super) source: Source,
    pub(super) options: Options,
    pub(super) asks: Asks,
}

/// What is to be done with the function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asks {
    /// It is called over many lanes, and so may do nothing that is not of its own lane.
    Pure,
    /// It is called once, by one invocation.
    Call,
}

/// Something the function reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PureParameter {
    /// The way to it as people write it: `light`, `material` of a block.
    pub path: String,
    /// Where it comes from.
    pub origin: Origin,
    /// What it is.
    pub ty: ValueType,
    /// The way to each of its scalars, and what the scalar is in the text.
    pub scalars: Vec<String>,
    /// Whether it is read: of a block, only some members may be. The others may be anything.
    pub read: bool,
    /// Of a member of a block: which of the module's.
    pub(super) block: Option<usize>,
}

/// Where a parameter comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// An argument of the function, by position.
    Argument(usize),
    /// An input of the stage.
    Input,
    /// A member of a block: the block's name, and the member's.
    Block(String, String),
}

/// Something the function gives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PureResult {
    /// `result`, or the name of the parameter or variable.
    pub name: String,
    /// What it is.
    pub ty: ValueType,
    /// The parameter of the caller it is left in; none for what is returned.
    pub(super) at: Option<usize>,
}

#[derive(Clone, Debug)]
pub(super) enum Slot {
    /// Parameters of ours, one after the other.
    Given(Vec<usize>),
    /// Zeros, as many.
    Zero(usize),
    /// Only written.
    Out,
}

/// What a call of many lanes gave.
#[derive(Clone, Debug)]
pub struct PureCalled {
    /// By result: its numbers.
    pub results: Vec<Numbers>,
    /// All else.
    pub called: Called,
}

impl Pure {
    /// Makes a function of a shader pure.
    ///
    /// # Errors
    /// A shader that does not run; a function it does not have; one that cannot be called by
    /// itself, by what it does.
    pub fn new(
        source: &Source,
        options: &Options,
        request: &PureRequest,
    ) -> Result<Pure, Box<Refusal>> {
        Pure::asked(source, options, request, Asks::Pure)
    }

    /// The same of a function that need not be pure, if it is only called.
    pub(super) fn asked(
        source: &Source,
        options: &Options,
        request: &PureRequest,
        asks: Asks,
    ) -> Result<Pure, Box<Refusal>> {
        let options = &Options { gather: true, naga: false, ..options.clone() };
        let module = Module::new(source, options).map_err(|found| {
            Box::new(Refusal { found, files: crate::layout(source, options).files })
        })?;
        let files = module.files().clone();
        let refused =
            |found: Diagnostic| Box::new(Refusal { found: vec![found], files: files.clone() });
        make(source, options, module, request, asks).map_err(|found| refused(*found))
    }

    /// Calls it over lanes: the words of each scalar of all parameters, in order.
    ///
    /// # Errors
    /// As [`Program::call`].
    pub fn call(
        &self,
        columns: &[Vec<u64>],
        lanes: usize,
        settings: &Settings,
    ) -> Result<PureCalled, Failure> {
        let mut firsts = Vec::with_capacity(self.parameters.len());
        let mut next = 0;
        for parameter in &self.parameters {
            firsts.push(next);
            next += parameter.scalars.len();
        }
        let words = |slot: &Slot| -> Words {
            match slot {
                Slot::Given(parameters) => parameters
                    .iter()
                    .flat_map(|&p| firsts[p]..firsts[p] + self.parameters[p].scalars.len())
                    .map(|column| columns[column].clone())
                    .collect(),
                Slot::Zero(scalars) => vec![vec![0; lanes]; *scalars],
                Slot::Out => Words::new(),
            }
        };
        let arguments = self.slots.iter().map(words).collect();
        let call = Call { function: caller::NAME, lanes, arguments, resources: &self.resources };
        let mut called = self.program.call(&call, settings)?;
        let results = self.results.iter().map(|result| match result.at {
            None => std::mem::take(&mut called.result),
            Some(at) => called.returned[at].clone().unwrap_or_default(),
        });
        let results = results.collect();
        Ok(PureCalled { results, called })
    }

    /// The place of an operation of a trace.
    pub fn place_of(&self, step: &Step) -> Place {
        self.program.place_of(step)
    }

    /// Where each scalar of each result came from, in the order of the results.
    pub fn sources(&self, trace: &Trace) -> Vec<crate::run::eval::Source> {
        let of = |result: &PureResult| match result.at {
            None => trace.results.clone(),
            Some(at) => trace.returned.get(at).cloned().unwrap_or_default(),
        };
        self.results.iter().flat_map(of).collect()
    }

    /// The scalar of our parameters that a scalar of the caller's is: its number in the columns.
    pub fn scalar_of(&self, parameter: u32, scalar: u32) -> Option<usize> {
        let Slot::Given(parameters) = self.slots.get(parameter as usize)? else { return None };
        let mut rest = scalar as usize;
        for &p in parameters {
            let len = self.parameters[p].scalars.len();
            if rest < len {
                let before: usize = self.parameters[..p].iter().map(|p| p.scalars.len()).sum();
                return Some(before + rest);
            }
            rest -= len;
        }
        None
    }

    /// The way from a result to one of its scalars: `.x`.
    pub fn result_path(&self, result: usize, scalar: usize) -> String {
        arguments::paths(&self.results[result].ty).get(scalar).cloned().unwrap_or_default()
    }

    /// The arguments, block contents and inputs of one sample as `landfall run` takes them.
    pub fn json(&self, words: &[u64]) -> (Vec<Value>, Data, Vec<(String, Value)>) {
        let mut arguments: Vec<(usize, Value)> = Vec::new();
        let mut data = self.data.clone();
        let mut inputs = Vec::new();
        let mut next = 0;
        for parameter in &self.parameters {
            let words = &words[next..next + parameter.scalars.len()];
            next += parameter.scalars.len();
            let value = shortest(Given::new(&parameter.ty, self.language, words, None).json());
            match &parameter.origin {
                Origin::Argument(at) => arguments.push((*at, value)),
                Origin::Input => inputs.push((parameter.path.clone(), value)),
                Origin::Block(block, member) => {
                    let members = data
                        .entry(block.clone())
                        .or_insert_with(|| Value::Object(Map::new()))
                        .as_object_mut()
                        .expect("a block that is sampled has no other data");
                    members.insert(member.clone(), value);
                }
            }
        }
        arguments.sort_by_key(|(at, _)| *at);
        (arguments.into_iter().map(|(_, value)| value).collect(), data, inputs)
    }
}

fn make(
    source: &Source,
    options: &Options,
    mut module: Module,
    request: &PureRequest,
    asks: Asks,
) -> Result<Pure, Box<Diagnostic>> {
    let language = source.language;
    let path = source.path.as_str();
    let refuse = |code: &'static str, message: String, help: Option<String>| {
        Box::new(finding(code, message, help, path))
    };
    let info =
        meant(&mut module, &request.function).map_err(|m| refuse(m.code, m.message, m.help))?;
    let shown = shown(&info);
    let cannot = |what: &str, help: &str| {
        let help = (!help.is_empty()).then(|| help.to_string());
        refuse("cannot-call", format!("`{shown}` cannot be sampled: {what}"), help)
    };
    let ir = &module.ir;
    let mut reached = reach::variables(ir, info.handle);
    let seen = look(ir, info.handle);
    let strict = asks == Asks::Pure;
    if strict && seen.derivatives {
        return Err(cannot(
            "it takes derivatives, which samples do not have",
            "name the function that is given what they depend on",
        ));
    }
    if let Some(name) = seen.stored.iter().filter(|_| strict).find_map(|handle| {
        let variable = &ir.global_variables[*handle];
        let buffer =
            matches!(variable.space, AddressSpace::Storage { .. } | AddressSpace::WorkGroup);
        buffer.then(|| variable.name.clone().unwrap_or_default())
    }) {
        let help = "name a function that returns what is to be written";
        return Err(cannot(&format!("it writes the buffer `{name}`"), help));
    }
    if strict && seen.barriers {
        return Err(cannot("it waits for other invocations", ""));
    }
    let written: Vec<Handle<GlobalVariable>> = ir
        .global_variables
        .iter()
        .filter(|(handle, v)| v.space == AddressSpace::Private && seen.stored.contains(handle))
        .map(|(handle, _)| handle)
        .collect();
    let Caller { mut module, inputs } =
        caller::caller(&module, info.handle).map_err(|mut all| Box::new(all.swap_remove(0)))?;
    let number = module.ir.functions.len() - 1;
    through_initialisers(&module.ir, &mut reached);
    let handle = module.ir.functions.iter().last().expect("the caller was appended").0;
    let members_read = reads::members(&module.ir, handle);
    let reads = |variable: Handle<GlobalVariable>, member: u32| {
        let members = members_read.get(&variable);
        members.is_some_and(|members| members.as_ref().is_none_or(|all| all.contains(&member)))
    };
    let base = inputs.len();
    let mut notes = Vec::new();
    // Which blocks become parameters.
    let mut blocks = Vec::new();
    let mut shared = FxHashSet::default();
    for (nth, block) in module.blocks.iter().enumerate() {
        if !reached.contains(&block.variable) || !shared.insert(block.variable) {
            continue;
        }
        if bound::given(&request.data, block).is_some() {
            continue;
        }
        let name = block.layout.name.to_string();
        let ty = ValueType::of(&module, module.ir.global_variables[block.variable].ty);
        match ty {
            Some(ValueType::Struct { members, .. }) => {
                let scalars: usize = members.iter().map(|(_, ty)| ty.scalars().len()).sum();
                if scalars <= SCALARS {
                    blocks.push((nth, block.variable, members));
                } else {
                    notes.push(format!(
                        "`{name}` has {scalars} scalars: it is zero, --data gives values"
                    ));
                }
            }
            _ => notes.push(format!(
                "`{name}` is no structure of a known size: it is zero, --data gives values"
            )),
        }
    }
    let returned_globals = if info.returns.is_none() { &written[..] } else { &[] };
    let mut function = std::mem::take(&mut module.ir.functions[handle]);
    let mut front = Block::new();
    for (nth, variable, _) in &blocks {
        let name = module.blocks[*nth].layout.name.to_string();
        let global = &mut module.ir.global_variables[*variable];
        global.space = AddressSpace::Private;
        global.binding = None;
        let (argument, pointer) = {
            let at = function.arguments.len() as u32;
            let (name, ty, binding) = (Some(name), global.ty, None);
            function.arguments.push(FunctionArgument { name, ty, binding });
            let mut push = |e| function.expressions.append(e, Span::UNDEFINED);
            (push(Expression::FunctionArgument(at)), push(Expression::GlobalVariable(*variable)))
        };
        front.push(Statement::Store { pointer, value: argument }, Span::UNDEFINED);
    }
    let globals_from = function.arguments.len();
    let mut tail = Vec::new();
    for variable in returned_globals {
        let global = &module.ir.global_variables[*variable];
        let inner = TypeInner::Pointer { base: global.ty, space: AddressSpace::Function };
        let (name, ty) = (
            global.name.clone(),
            module.ir.types.insert(Type { name: None, inner }, Span::UNDEFINED),
        );
        tail.push((function.arguments.len() as u32, *variable));
        function.arguments.push(FunctionArgument { name, ty, binding: None });
    }
    rewrite(&mut function, front, &tail);
    module.ir.functions[handle] = function;
    let blank = |block: &crate::BlockLayout| bound::zeros(block);
    let bytes = bound::blocks(&module, &request.data, blank)?;
    let files = module.files().clone();
    let writable = |block: &_| verify::access::writable(block, &files, language);
    let resources = bound::resources(&module, bytes, writable, &request.textures);
    let module = module.validated().map_err(|mut all| Box::new(all.swap_remove(0)))?;
    let program = Program::rounded(&module, &[], request.floats);
    let signature = match program.signature(number) {
        Ok(Some(signature)) => signature,
        Ok(None) => {
            let words = ["sampler", "texture", "image"];
            let opaque = info.parameters.iter().find(|p| words.iter().any(|w| p.ty.contains(w)));
            let what = opaque.map_or("a parameter is no plain value".to_string(), |p| {
                format!("`{}` is a `{}`, which is no plain value", p.name, p.ty)
            });
            return Err(cannot(&what, "name the function that calls it"));
        }
        Err(what) => return Err(cannot(&format!("the evaluator does not know {what}"), "")),
    };
    // The parameters people know.
    let mut parameters: Vec<PureParameter> = Vec::new();
    let mut slots = Vec::new();
    let mut results = Vec::new();
    let reads_input = |name: &str| {
        let root = name.split(['.', '[']).next().unwrap_or(name);
        reached.iter().any(|v| module.ir.global_variables[*v].name.as_deref() == Some(root))
    };
    for (at, parameter) in signature.parameters.iter().enumerate() {
        let ty = parameter.ty.clone();
        if at < base {
            let path = inputs[at].clone();
            slots.push(if reads_input(&path) {
                parameters.push(plain(path, Origin::Input, ty));
                Slot::Given(vec![parameters.len() - 1])
            } else {
                Slot::Zero(ty.scalars().len())
            });
        } else if at < base + info.parameters.len() {
            let nth = at - base;
            let known = &info.parameters[nth];
            let name = match known.name.as_str() {
                "" => format!("args[{nth}]"),
                name => name.to_string(),
            };
            if parameter.returned {
                results.push(PureResult { name: name.clone(), ty: ty.clone(), at: Some(at) });
            }
            slots.push(if known.direction == Direction::Out {
                Slot::Out
            } else {
                parameters.push(plain(name, Origin::Argument(nth), ty));
                Slot::Given(vec![parameters.len() - 1])
            });
        } else if at < globals_from {
            let (nth, variable, members) = &blocks[at - base - info.parameters.len()];
            let block = &module.blocks[*nth].layout;
            let mut all = Vec::new();
            for (member_number, (member, ty)) in members.iter().enumerate() {
                let named = block.instance.as_deref().or(match &*block.name {
                    "DefaultBlock" | "" => None,
                    _ if language == Language::Glsl => None,
                    name => Some(name),
                });
                let path = named.map_or(member.clone(), |name| format!("{name}.{member}"));
                let origin = Origin::Block(block.name.to_string(), member.clone());
                all.push(parameters.len());
                let block = Some(*nth);
                let read = reads(*variable, member_number as u32);
                parameters.push(PureParameter { read, block, ..plain(path, origin, ty.clone()) });
            }
            slots.push(Slot::Given(all));
        } else {
            let name = parameter.name.clone();
            results.push(PureResult { name, ty, at: Some(at) });
            slots.push(Slot::Out);
        }
    }
    let given = inputs.into_iter().zip(&signature.parameters);
    let given = given.map(|(name, parameter)| (name, parameter.ty.clone())).collect();
    if let Some(ty) = signature.result {
        results.insert(0, PureResult { name: "result".to_string(), ty, at: None });
    }
    if strict && results.is_empty() {
        let help =
            "name a function that returns something, has an `out` parameter or writes a global";
        return Err(cannot("it gives nothing back", help));
    }
    // A uniform may have the name of a parameter.
    for at in 0..parameters.len() {
        let twice = parameters.iter().filter(|p| p.path == parameters[at].path).count() > 1;
        if let (true, Origin::Block(block, member)) = (twice, parameters[at].origin.clone()) {
            let PureParameter { ty, read, block: number, .. } = parameters[at].clone();
            let made = plain(format!("{block}.{member}"), Origin::Block(block, member), ty);
            parameters[at] = PureParameter { read, block: number, ..made };
        }
    }
    let white: Vec<&str> = module
        .handles()
        .iter()
        .filter(|handle| reached.contains(&handle.variable))
        .map(|handle| handle.path.as_str())
        .filter(|path| !request.textures.iter().any(|(name, _)| path.starts_with(name.as_str())))
        .collect();
    if !white.is_empty() {
        let mut white = white;
        white.dedup();
        notes.push(format!("`{}` is white: --texture gives a colour", white.join("`, `")));
    }
    Ok(Pure {
        shown,
        name_span: Some(info.span),
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

fn plain(path: String, origin: Origin, ty: ValueType) -> PureParameter {
    let scalars = arguments::paths(&ty).into_iter().map(|rest| format!("{path}{rest}")).collect();
    PureParameter { path, origin, ty, scalars, read: true, block: None }
}

/// The function of that name; an entry point of WGSL as a function.
fn meant(module: &mut Module, meant: &str) -> Result<FunctionInfo, arguments::Misfit> {
    let bare = |text: &str| text.chars().filter(|c| !c.is_whitespace()).collect::<String>();
    let name = meant.split('(').next().unwrap_or_default().trim();
    let named: Vec<&FunctionInfo> = module.functions().iter().filter(|f| f.name == name).collect();
    let fits: Vec<&FunctionInfo> = named
        .iter()
        .copied()
        .filter(|info| !meant.contains('(') || bare(&shown(info)) == bare(meant))
        .collect();
    let all =
        || named.iter().map(|info| format!("`{}`", shown(info))).collect::<Vec<_>>().join(", ");
    match (&fits[..], named.len()) {
        ([one], _) => return Ok((*one).clone()),
        ([], 0) => {}
        ([], _) => {
            return Err(arguments::Misfit {
                code: "unknown-function",
                message: format!("no function `{name}` has these parameters"),
                help: Some(format!("there is {}", all())),
            });
        }
        (_, several) => {
            return Err(arguments::Misfit {
                code: "ambiguous-function",
                message: format!("{several} functions are named `{name}`"),
                help: Some(format!("say which with its types: {}", all())),
            });
        }
    }
    let entry = module.ir.entry_points.iter().find(|entry| entry.name == name);
    let Some(entry) = entry else { return Err(unknown(module, name)) };
    let mut function = entry.function.clone();
    function.name = Some(format!("{name}_called"));
    function.arguments.iter_mut().for_each(|argument| argument.binding = None);
    if let Some(result) = &mut function.result {
        result.binding = None;
    }
    let parameters = function.arguments.iter().map(|argument| crate::run::module::Parameter {
        name: argument.name.clone().unwrap_or_default(),
        ty: module.ir.types[argument.ty].name.clone().unwrap_or_default(),
        direction: Direction::In,
    });
    let parameters = parameters.collect();
    let returns = function.result.as_ref().map(|_| String::new());
    let handle = module.ir.functions.append(function, Span::UNDEFINED);
    Ok(FunctionInfo {
        name: name.to_string(),
        parameters,
        returns,
        span: TextSpan::default(),
        handle,
    })
}

/// Puts statements before the body, and copies of variables into pointers before it returns.
fn rewrite(function: &mut Function, front: Block, tail: &[(u32, Handle<GlobalVariable>)]) {
    let mut body = front;
    let old = std::mem::take(&mut function.body);
    for (statement, span) in old.span_iter() {
        if matches!(statement, Statement::Return { .. }) {
            for (argument, variable) in tail {
                let mut push = |e| function.expressions.append(e, Span::UNDEFINED);
                let pointer = push(Expression::FunctionArgument(*argument));
                let from = push(Expression::GlobalVariable(*variable));
                let before = function.expressions.len();
                let value = function
                    .expressions
                    .append(Expression::Load { pointer: from }, Span::UNDEFINED);
                let emitted = function.expressions.range_from(before);
                body.push(Statement::Emit(emitted), Span::UNDEFINED);
                body.push(Statement::Store { pointer, value }, Span::UNDEFINED);
            }
        }
        body.push(statement.clone(), *span);
    }
    function.body = body;
}

/// Floats by the fewest digits that are the same `f32`.
fn shortest(value: Value) -> Value {
    match value {
        Value::Array(items) => Value::Array(items.into_iter().map(shortest).collect()),
        Value::Object(map) => {
            Value::Object(map.into_iter().map(|(key, value)| (key, shortest(value))).collect())
        }
        Value::Number(number) if number.is_f64() => {
            let wide = number.as_f64().unwrap_or_default();
            let single = wide as f32;
            let short = format!("{single:?}").parse::<f64>();
            match short {
                Ok(short) if f64::from(single) == wide => Value::from(short),
                Ok(_) | Err(_) => Value::Number(number),
            }
        }
        Value::Number(_) | Value::String(_) | Value::Bool(_) | Value::Null => value,
    }
}
