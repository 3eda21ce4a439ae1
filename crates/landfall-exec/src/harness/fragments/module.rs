//! Makes the fragment entry point of a module read its inputs from a texture, by its pixel.
//!
//! The old entry point becomes a function; the new one loads a texel for each of its inputs and
//! calls it. Used by [`fragments`](super).

use landfall_layout::diagnostic::Code;
use naga::{
    AddressSpace, BinaryOperator, Binding, Block, BuiltIn, EntryPoint, Expression, Function,
    FunctionArgument, FunctionResult, GlobalVariable, Handle, ImageClass, ImageDimension,
    ImageQuery, Literal, ResourceBinding, Scalar, ScalarKind, ShaderStage, Span, Statement,
    StructMember, SwizzleComponent, Type, TypeInner, VectorSize,
};

use super::wgsl::attribute;
use super::{ATLAS, Input, InputKind};
use landfall_ir::{Module, call_graph};
use landfall_layout::Diagnostic;

/// A module with a fragment entry point that reads its inputs from a texture.
pub(super) struct Fetching {
    /// The module to run.
    pub module: Module,
    /// The same, writing white unless the shader discards; `None` if it never discards.
    pub covered: Option<Module>,
    /// The name of the entry point.
    pub entry: String,
    /// Its name in the text.
    pub original: String,
    /// The inputs in the order of their rows of texels.
    pub inputs: Vec<Input>,
    /// Group and binding of the texture.
    pub atlas: (u32, u32),
    /// Whether the entry point uses derivatives.
    pub differences: bool,
    /// By block of the module: whether it is read.
    pub read: Vec<bool>,
}

/// The new entry point's name; names like it are reserved.
const ENTRY: &str = "landfall_main";

/// The output of the new entry point.
#[derive(Clone, Copy)]
enum EntryOutput {
    Result,
    White,
}

/// Makes the fragment entry point of that name, or the only one, read a texture.
pub(super) fn fetching(module: &Module, name: Option<&str>) -> Result<Fetching, Vec<Diagnostic>> {
    let entries = &module.ir.entry_points;
    let fragments: Vec<&EntryPoint> =
        entries.iter().filter(|entry| entry.stage == ShaderStage::Fragment).collect();
    let names = || fragments.iter().map(|e| format!("`{}`", e.name)).collect::<Vec<_>>().join(", ");
    let entry = match (name, &fragments[..]) {
        (_, []) => return Err(refused("the shader has no fragment stage".into())),
        (Some(name), all) => all.iter().find(|entry| entry.name == name).ok_or_else(|| {
            refused(format!("there is no fragment entry point `{name}`; there is {}", names()))
        })?,
        (None, [one]) => one,
        (None, _) => {
            return Err(refused(format!("the shader has several fragment stages: {}", names())));
        }
    };
    let inputs = inputs(module, entry)?;
    let (kills, differences) = reaches(module, entry);
    let [atlas] = module.free_places();
    let made = |gives| rebuilt(module, entry, &inputs, atlas, gives);
    let number = entries.iter().position(|other| std::ptr::eq(other, *entry)).unwrap_or(0);
    // naga has found which variables each entry point uses.
    let uses = module.info.get_entry_point(number);
    let read = module.blocks().iter().map(|block| !uses[block.variable].is_empty()).collect();
    Ok(Fetching {
        module: made(EntryOutput::Result)?,
        read,
        covered: if kills { Some(made(EntryOutput::White)?) } else { None },
        entry: ENTRY.to_string(),
        original: entry.name.clone(),
        inputs,
        atlas,
        differences,
    })
}

fn refused(message: String) -> Vec<Diagnostic> {
    vec![Diagnostic::error(Code::CannotRun, landfall_layout::Span::default(), message)]
}

/// Returns every input with a location, in the order of the arguments, and the pixel coordinate.
fn inputs(module: &Module, entry: &EntryPoint) -> Result<Vec<Input>, Vec<Diagnostic>> {
    let ir = &module.ir;
    let mut inputs = Vec::new();
    let mut has_pixel = false;
    let mut add = |name: &Option<String>, binding: &Option<Binding>, ty: Handle<Type>| {
        // The pixel is given as an input, though it has no location.
        has_pixel |= matches!(binding, Some(Binding::BuiltIn(BuiltIn::Position { .. })));
        let Some(Binding::Location { location, interpolation, sampling, .. }) = binding else {
            return Ok(());
        };
        let known = module.inputs().iter().find(|input| input.location == *location);
        let name = known.map_or_else(|| name.clone().unwrap_or_default(), |k| k.name.clone());
        let (components, scalar) = match ir.types[ty].inner {
            TypeInner::Scalar(scalar) => (1, scalar),
            TypeInner::Vector { size, scalar } => (size as u8, scalar),
            _ => return Err(refused(format!("the input `{name}` is not a scalar or vector"))),
        };
        let kind = match (scalar.kind, scalar.width) {
            (ScalarKind::Float, 4) => InputKind::Float,
            (ScalarKind::Sint, 4) => InputKind::Sint,
            (ScalarKind::Uint, 4) => InputKind::Uint,
            _ => return Err(refused(format!("the input `{name}` does not have a 32-bit type"))),
        };
        let (location, interpolation) = (Some(*location), attribute(*interpolation, *sampling));
        inputs.push(Input { name, location, components, kind, interpolation });
        Ok(())
    };
    for argument in &entry.function.arguments {
        match &ir.types[argument.ty].inner {
            TypeInner::Struct { members, .. } => {
                members.iter().try_for_each(|m| add(&m.name, &m.binding, m.ty))?;
            }
            _ => add(&argument.name, &argument.binding, argument.ty)?,
        }
    }
    // The last of them, as those with a location are in the order of the text.
    if has_pixel {
        let (name, kind) = (super::PIXEL.to_string(), InputKind::Float);
        let interpolation = String::new();
        inputs.push(Input { name, location: None, components: 4, kind, interpolation });
    }
    Ok(inputs)
}

/// Returns whether the entry point may discard, and whether it uses derivatives.
fn reaches(module: &Module, entry: &EntryPoint) -> (bool, bool) {
    let functions = call_graph::functions(&module.ir, &entry.function);
    let kills = |function: &&Function| {
        call_graph::statements(&function.body).any(|statement| matches!(statement, Statement::Kill))
    };
    let differs = |function: &&Function| {
        function.expressions.iter().any(|(_, e)| matches!(e, Expression::Derivative { .. }))
    };
    (functions.iter().any(kills), functions.iter().any(differs))
}

fn rebuilt(
    module: &Module,
    entry: &EntryPoint,
    inputs: &[Input],
    (group, binding): (u32, u32),
    gives: EntryOutput,
) -> Result<Module, Vec<Diagnostic>> {
    let mut module = module.clone();
    let ir = &mut module.ir;
    let mut old = entry.function.clone();
    // GLSL's entry point is a wrapper that calls `main`.
    if ir.functions.iter().any(|(_, function)| function.name == old.name) {
        old.name = Some("landfall_entry".to_string());
    }
    old.arguments.iter_mut().for_each(|argument| argument.binding = None);
    let result = old.result.as_mut().map(|result| result.binding.take());
    let result = result.zip(old.result.clone());
    let old_arguments = entry.function.arguments.clone();
    // The old entry point becomes a function.
    let callee = ir.functions.append(old, Span::UNDEFINED);
    let mut ty = |inner| ir.types.insert(Type { name: None, inner }, Span::UNDEFINED);
    let class = ImageClass::Sampled { kind: ScalarKind::Float, multi: false };
    let image = ty(TypeInner::Image { dim: ImageDimension::D2, arrayed: false, class });
    let vector = |size, scalar| TypeInner::Vector { size, scalar };
    let types = Types {
        position: ty(vector(VectorSize::Quad, Scalar::F32)),
        place: ty(vector(VectorSize::Bi, Scalar::I32)),
    };
    let atlas = ir.global_variables.append(atlas(image, group, binding), Span::UNDEFINED);
    let mut new = Fetcher { function: Function::default(), builtins: Vec::new() };
    new.function.name = Some(ENTRY.to_string());
    let structs: Vec<Option<Vec<StructMember>>> = old_arguments
        .iter()
        .map(|argument| match &ir.types[argument.ty].inner {
            TypeInner::Struct { members, .. } => Some(members.clone()),
            _ => None,
        })
        .collect();
    // Built-in values first: arguments and literals are not emitted.
    let position = new.builtin(&BuiltIn::Position { invariant: false }, types.position);
    for (argument, members) in old_arguments.iter().zip(&structs) {
        let mut note = |binding: &Option<Binding>, ty| {
            // The pixel coordinate was added above.
            if let Some(Binding::BuiltIn(builtin)) = binding {
                new.builtin(builtin, ty);
            }
        };
        match members {
            Some(members) => members.iter().for_each(|m| note(&m.binding, m.ty)),
            None => note(&argument.binding, argument.ty),
        }
    }
    let texels = new.fetches(inputs, atlas, position, types.place);
    // If the pixel is an input, it is the last.
    let pixel = texels.last().copied().unwrap_or(position);
    let mut texels = texels.into_iter();
    let mut arguments = Vec::new();
    for (argument, members) in old_arguments.iter().zip(&structs) {
        let value = match members {
            Some(members) => {
                let components = members
                    .iter()
                    .map(|m| new.value(&m.binding, m.ty, pixel, &mut texels))
                    .collect();
                new.add(Expression::Compose { ty: argument.ty, components })
            }
            None => new.value(&argument.binding, argument.ty, pixel, &mut texels),
        };
        arguments.push(value);
    }
    let mut function = new.emitted();
    let returned = result
        .is_some()
        .then(|| function.expressions.append(Expression::CallResult(callee), Span::UNDEFINED));
    let call = Statement::Call { function: callee, arguments, result: returned };
    function.body.push(call, Span::UNDEFINED);
    let value = match gives {
        EntryOutput::Result => {
            function.result =
                result.map(|(binding, result)| FunctionResult { ty: result.ty, binding });
            returned
        }
        EntryOutput::White => Some(white(&mut function, types.position)),
    };
    function.body.push(Statement::Return { value }, Span::UNDEFINED);
    // Other entry points are left out.
    let name = ENTRY.to_string();
    ir.entry_points = vec![EntryPoint { name, function, ..entry.clone() }];
    module.validated()
}

/// Returns the texture that holds the inputs.
fn atlas(ty: Handle<Type>, group: u32, binding: u32) -> GlobalVariable {
    GlobalVariable {
        name: Some(ATLAS.to_string()),
        space: AddressSpace::Handle,
        binding: Some(ResourceBinding { group, binding }),
        ty,
        init: None,
        memory_decorations: naga::MemoryDecorations::empty(),
    }
}

/// Makes a function return white at location 0, and returns its result.
fn white(function: &mut Function, ty: Handle<Type>) -> Handle<Expression> {
    let binding = Binding::Location {
        location: 0,
        interpolation: None,
        sampling: None,
        blend_src: None,
        per_primitive: false,
    };
    function.result = Some(FunctionResult { ty, binding: Some(binding) });
    let one = Expression::Literal(Literal::F32(1.0));
    let one = function.expressions.append(one, Span::UNDEFINED);
    let white = Expression::Splat { size: VectorSize::Quad, value: one };
    let white = function.expressions.append(white, Span::UNDEFINED);
    let emitted = naga::Range::new_from_bounds(white, white);
    function.body.push(Statement::Emit(emitted), Span::UNDEFINED);
    white
}

struct Types {
    position: Handle<Type>,
    place: Handle<Type>,
}

/// The new entry point under construction.
struct Fetcher {
    function: Function,
    /// The built-in arguments and their expressions.
    builtins: Vec<(BuiltIn, Handle<Expression>)>,
}

impl Fetcher {
    fn add(&mut self, expression: Expression) -> Handle<Expression> {
        self.function.expressions.append(expression, Span::UNDEFINED)
    }

    /// Returns the argument of a built-in value, which an entry point may have only once.
    fn builtin(&mut self, builtin: &BuiltIn, ty: Handle<Type>) -> Handle<Expression> {
        let same = |other: &BuiltIn| match (other, builtin) {
            (BuiltIn::Position { .. }, BuiltIn::Position { .. }) => true,
            (other, builtin) => other == builtin,
        };
        if let Some((_, known)) = self.builtins.iter().find(|(other, _)| same(other)) {
            return *known;
        }
        let index = self.function.arguments.len() as u32;
        let binding = Some(Binding::BuiltIn(*builtin));
        self.function.arguments.push(FunctionArgument { name: None, ty, binding });
        let value = self.add(Expression::FunctionArgument(index));
        self.builtins.push((*builtin, value));
        value
    }

    /// Appends loads of all inputs; emission starts with them.
    fn fetches(
        &mut self,
        inputs: &[Input],
        atlas: Handle<GlobalVariable>,
        position: Handle<Expression>,
        place: Handle<Type>,
    ) -> Vec<Handle<Expression>> {
        let image = self.add(Expression::GlobalVariable(atlas));
        let literal = |value| Expression::Literal(value);
        let count = self.add(literal(Literal::U32(inputs.len().max(1) as u32)));
        let level = self.add(literal(Literal::I32(0)));
        let numbers: Vec<_> =
            (0..inputs.len()).map(|k| self.add(literal(Literal::I32(k as i32)))).collect();
        // Everything from here on is emitted.
        let whole = |expr, kind| Expression::As { expr, kind, convert: Some(4) };
        let axis = |base, index| Expression::AccessIndex { base, index };
        let binary = |op, left, right| Expression::Binary { op, left, right };
        // The texel of input `k` is `k` times the rows below the pixel.
        let across = self.add(axis(position, 0));
        let across = self.add(whole(across, ScalarKind::Sint));
        let down = self.add(axis(position, 1));
        let down = self.add(whole(down, ScalarKind::Sint));
        let size =
            self.add(Expression::ImageQuery { image, query: ImageQuery::Size { level: None } });
        let height = self.add(axis(size, 1));
        let rows = self.add(binary(BinaryOperator::Divide, height, count));
        let rows = self.add(whole(rows, ScalarKind::Sint));
        let each = inputs.iter().zip(numbers).map(|(input, number)| {
            let skipped = self.add(binary(BinaryOperator::Multiply, rows, number));
            let row = self.add(binary(BinaryOperator::Add, down, skipped));
            let coordinate =
                self.add(Expression::Compose { ty: place, components: vec![across, row] });
            let texel = self.add(Expression::ImageLoad {
                image,
                coordinate,
                array_index: None,
                sample: None,
                level: Some(level),
            });
            let pattern = SwizzleComponent::XYZW;
            let part = |size| Expression::Swizzle { size, vector: texel, pattern };
            let value = match input.components {
                1 => self.add(axis(texel, 0)),
                2 => self.add(part(VectorSize::Bi)),
                3 => self.add(part(VectorSize::Tri)),
                _ => texel,
            };
            match input.kind {
                InputKind::Float => value,
                InputKind::Sint => self.add(whole(value, ScalarKind::Sint)),
                InputKind::Uint => self.add(whole(value, ScalarKind::Uint)),
            }
        });
        each.collect()
    }

    /// Returns the value of an argument or of one of its members.
    fn value(
        &mut self,
        binding: &Option<Binding>,
        ty: Handle<Type>,
        pixel: Handle<Expression>,
        texels: &mut impl Iterator<Item = Handle<Expression>>,
    ) -> Handle<Expression> {
        match binding {
            Some(Binding::BuiltIn(BuiltIn::Position { .. })) => pixel,
            Some(Binding::BuiltIn(builtin)) => self.builtin(builtin, ty),
            Some(Binding::Location { .. }) => texels.next().expect("each location is an input"),
            None => unreachable!("naga's validator wants a binding of each"),
        }
    }

    /// Returns the function with all expressions emitted.
    fn emitted(mut self) -> Function {
        let first = self.function.expressions.iter().find(|(_, expression)| {
            !matches!(
                expression,
                Expression::FunctionArgument(_)
                    | Expression::GlobalVariable(_)
                    | Expression::Literal(_)
            )
        });
        if let Some((first, _)) = first {
            let range = self.function.expressions.range_from(first.index());
            self.function.body = Block::new();
            self.function.body.push(Statement::Emit(range), Span::UNDEFINED);
        }
        self.function
    }
}
