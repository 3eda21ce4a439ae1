//! Parsing of WGSL type expressions (§6) to [`Type`].

use std::sync::Arc;

use super::lengths::{self, Length};
use super::lexer::{WgslLexer, WgslToken};
use super::outline::Class;
use super::predeclared::{self, Predeclared};
use super::reader::{Known, ModuleReader, NAME_LEVEL, TYPE_LEVEL};
use super::report::{self, Refused};
use super::structs;
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{ArrayLen, Scalar, ScalarKind, Type};
use crate::source::Span;

/// Properties of a type that may make it invalid in a block, each with its span.
// Whether they are errors depends on the variable: a bool in a `private` structure is fine. So they
// are collected on the way up, each with the first place that has it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TypeFacts {
    /// A `bool`, which is not host-shareable.
    pub(super) boolean: Option<Span>,
    /// An atomic, which is only allowed in storage.
    pub(super) atomic: Option<Span>,
    /// A texture, sampler or pointer inside a structure or array.
    pub(super) opaque: Option<Span>,
    pub(super) half: Option<Span>,
    /// A runtime-sized array at its end, or one whose override has no value.
    pub(super) runtime: Option<UnsizedArray>,
    /// An array length that depends on an override.
    pub(super) overridden: Option<Span>,
}

/// An array whose length the text alone does not determine.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnsizedArray {
    pub(super) at: Span,
    /// The override its length depends on, by its index in the outline.
    pub(super) waits_for: Option<usize>,
}

impl UnsizedArray {
    /// Returns the help for a place where the type must have a size.
    pub(super) fn help(self, reader: &ModuleReader<'_>, otherwise: &str) -> String {
        match self.waits_for {
            Some(index) => {
                let name = reader.outline.items[index].name;
                format!("`{name}` has no default: pass `-O {name}=VALUE`")
            }
            None => otherwise.to_string(),
        }
    }
}

impl TypeFacts {
    pub(super) fn and(self, other: TypeFacts) -> TypeFacts {
        TypeFacts {
            boolean: self.boolean.or(other.boolean),
            atomic: self.atomic.or(other.atomic),
            opaque: self.opaque.or(other.opaque),
            half: self.half.or(other.half),
            runtime: self.runtime.or(other.runtime),
            overridden: self.overridden.or(other.overridden),
        }
    }
}

#[derive(Clone, Debug)]
pub(super) enum Meaning {
    Data(Type),
    /// A texture, sampler, pointer or other opaque type.
    Opaque,
    /// `binding_array<T, N>`: N separate buffers.
    Bindings(Box<Meaning>, ArrayLen),
}

#[derive(Clone, Debug)]
pub(super) struct Typed {
    pub(super) meaning: Meaning,
    pub(super) facts: TypeFacts,
}

impl Typed {
    fn data(ty: Type) -> Typed {
        Typed { meaning: Meaning::Data(ty), facts: TypeFacts::default() }
    }

    fn scalars(ty: Type, scalar: Scalar, at: Span) -> Typed {
        let facts = TypeFacts {
            boolean: (scalar.kind == ScalarKind::Bool).then_some(at),
            half: (scalar == Scalar::F16).then_some(at),
            ..TypeFacts::default()
        };
        Typed { meaning: Meaning::Data(ty), facts }
    }
}

// type_specifier: template_elaborated_ident
// template_elaborated_ident: ident template_list?
pub(super) fn read<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
) -> Result<Typed, Refused> {
    let word = reader.reports.checked(report::word(lexer, "a type"))?;
    reader.deeper(report::span(word), TYPE_LEVEL, |reader| named(reader, lexer, word))
}

/// Parses the type that a word begins, with its template list.
// A name of the module hides a predeclared one (§5), so it is looked up first.
pub(super) fn named<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    word: WgslToken,
) -> Result<Typed, Refused> {
    let name = lexer.text_of(word);
    let at = report::span(word);
    if let Some(&index) = reader.outline.names.get(name) {
        return declared(reader, index, at);
    }
    let Some(predeclared) = predeclared::lookup(name) else {
        return Err(unknown(reader, name, at));
    };
    match predeclared {
        Predeclared::Scalar(scalar) => Ok(Typed::scalars(Type::Scalar(scalar), scalar, at)),
        Predeclared::Vector { rows, scalar } => {
            let scalar = component(reader, lexer, word, scalar)?;
            Ok(Typed::scalars(Type::Vector { scalar, rows }, scalar, at))
        }
        Predeclared::Matrix { columns, rows, scalar } => {
            let scalar = component(reader, lexer, word, scalar)?;
            if scalar.kind != ScalarKind::Float {
                let message = format!("`{name}` only has floating-point components");
                let diagnostic = Diagnostic::error(Code::UnknownType, at, message);
                return Err(reader.reports.refuse(diagnostic.with_help("write `f32`")));
            }
            Ok(Typed::scalars(Type::Matrix { scalar, columns, rows }, scalar, at))
        }
        Predeclared::Atomic => {
            let scalar = component(reader, lexer, word, None)?;
            let mut typed = Typed::data(Type::Atomic(scalar));
            typed.facts.atomic = Some(at);
            Ok(typed)
        }
        Predeclared::Array => array(reader, lexer, word),
        Predeclared::BindingArray => {
            let (element, length, _) = element_and_length(reader, lexer, word)?;
            let meaning = Meaning::Bindings(Box::new(element.meaning), length.len);
            Ok(Typed { meaning, facts: element.facts })
        }
        Predeclared::RayDesc => Ok(Typed::data(structs::ray_desc())),
        // The parameters of textures and pointers are skipped: `handles` reads them, for
        // interfaces.
        Predeclared::Opaque => {
            if lexer.take(b'<') {
                reader.reports.checked(report::skip_past(lexer, b'<', b'>'))?;
            }
            Ok(Typed { meaning: Meaning::Opaque, facts: TypeFacts::default() })
        }
    }
}

/// Parses a structure for its errors.
pub(super) fn check(reader: &mut ModuleReader<'_>, index: usize) -> Option<Typed> {
    declared(reader, index, reader.outline.items[index].name_span).ok()
}

/// Resolves a type declared in the text.
// Read at the first use, and kept: a type that is met while it is read contains itself, which only
// pointers could break, and WGSL has none in structures.
fn declared(reader: &mut ModuleReader<'_>, index: usize, at: Span) -> Result<Typed, Refused> {
    match reader.types.get(&index) {
        Some(Known::Done(typed)) => return Ok(typed.clone()),
        Some(Known::Broken) => return Err(Refused),
        Some(Known::Open) => return Err(recursive(reader, index, at)),
        None => {}
    }
    let item = &reader.outline.items[index];
    let read = match item.class {
        Class::Struct => structs::read,
        Class::Alias => alias,
        Class::Const | Class::Override | Class::Var | Class::Fn => {
            let message = format!("`{}` is {}, not a type", item.name, item.class.name());
            let diagnostic = Diagnostic::error(Code::UnknownType, at, message)
                .with_label(item.name_span, "defined here");
            return Err(reader.reports.refuse(diagnostic));
        }
    };
    reader.types.insert(index, Known::Open);
    let result = reader.deeper(at, NAME_LEVEL, |reader| read(reader, index));
    let known = match &result {
        Ok(typed) => Known::Done(typed.clone()),
        Err(Refused) => Known::Broken,
    };
    reader.types.insert(index, known);
    result
}

// type_alias_decl: `alias` ident `=` type_specifier
fn alias(reader: &mut ModuleReader<'_>, index: usize) -> Result<Typed, Refused> {
    let mut lexer = WgslLexer::new(reader.text, reader.outline.items[index].rest);
    reader.expect(&mut lexer, b'=')?;
    let typed = read(reader, &mut lexer)?;
    reader.expect(&mut lexer, b';')?;
    Ok(typed)
}

/// Returns the component of a vector, matrix or atomic, from its name or template list.
// `vec3f` has it in its name, `vec3` `<` type_specifier `,`? `>` in its list
fn component<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    word: WgslToken,
    named: Option<Scalar>,
) -> Result<Scalar, Refused> {
    if let Some(scalar) = named {
        return Ok(scalar);
    }
    let name = lexer.text_of(word);
    if !lexer.take(b'<') {
        let message = format!("`{name}` lacks its component type");
        let diagnostic = Diagnostic::error(Code::UnknownType, report::span(word), message)
            .with_help(format!("write `{name}<f32>`"));
        return Err(reader.reports.refuse(diagnostic));
    }
    let at = report::span(lexer.peek());
    let typed = read(reader, lexer)?;
    close_template(reader, lexer)?;
    match typed.meaning {
        Meaning::Data(Type::Scalar(scalar)) => Ok(scalar),
        Meaning::Data(_) | Meaning::Opaque | Meaning::Bindings(..) => {
            let message = format!("the component of a `{name}` must be a scalar");
            Err(reader.reports.refuse(Diagnostic::error(Code::UnknownType, at, message)))
        }
    }
}

// `array` `<` type_specifier ( `,` expression )? `,`? `>`     (§6.2.9)
fn array<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    word: WgslToken,
) -> Result<Typed, Refused> {
    let at = report::span(word);
    let (element, length, element_at) = element_and_length(reader, lexer, word)?;
    let mut facts = element.facts;
    if let Some(runtime) = facts.runtime {
        let message = "the elements of an array must have a size, and this type has none";
        let help = runtime.help(reader, "specify the inner array's number of elements");
        let diagnostic = Diagnostic::error(Code::RuntimeSizedArray, element_at, message)
            .with_label(runtime.at, "runtime-sized")
            .with_help(help);
        return Err(reader.reports.refuse(diagnostic));
    }
    let ty = match element.meaning {
        Meaning::Data(ty) => ty,
        // Kept so that parsing can continue; a block with such a type is rejected.
        Meaning::Opaque | Meaning::Bindings(..) => {
            facts.opaque = facts.opaque.or(Some(element_at));
            return Ok(Typed { meaning: Meaning::Opaque, facts });
        }
    };
    facts.overridden = facts.overridden.or(length.overridden);
    facts.runtime = match length.len {
        ArrayLen::Fixed(_) => None,
        ArrayLen::Runtime | ArrayLen::Override(_) => {
            Some(UnsizedArray { at, waits_for: length.waits_for })
        }
    };
    let ty = Type::Array { element: Arc::new(ty), len: length.len };
    if ty.depth() > crate::shape::DEEPEST_NESTING {
        return Err(reader.reports.refuse(report::too_deep(at)));
    }
    Ok(Typed { meaning: Meaning::Data(ty), facts })
}

fn element_and_length<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    word: WgslToken,
) -> Result<(Typed, Length, Span), Refused> {
    if !lexer.take(b'<') {
        let name = lexer.text_of(word);
        let message = format!("`{name}` lacks its element type");
        let diagnostic = Diagnostic::error(Code::UnknownType, report::span(word), message)
            .with_help(format!("write `{name}<f32, 4>`"));
        return Err(reader.reports.refuse(diagnostic));
    }
    let at = report::span(lexer.peek());
    let element = read(reader, lexer)?;
    let length = if lexer.take(b',') && !lexer.peek().is(b'>') {
        lengths::read(reader, lexer)?
    } else {
        Length { len: ArrayLen::Runtime, waits_for: None, overridden: None }
    };
    close_template(reader, lexer)?;
    Ok((element, length, at))
}

// WGSL allows a `,` before the `>`.
fn close_template(reader: &mut ModuleReader<'_>, lexer: &mut WgslLexer<'_>) -> Result<(), Refused> {
    lexer.take(b',');
    reader.expect(lexer, b'>').map(|_| ())
}

fn unknown(reader: &mut ModuleReader<'_>, name: &str, at: Span) -> Refused {
    let diagnostic = Diagnostic::error(Code::UnknownType, at, format!("unknown type `{name}`"));
    let declared = reader.outline.items.iter().filter(|item| match item.class {
        Class::Struct | Class::Alias => true,
        Class::Const | Class::Override | Class::Var | Class::Fn => false,
    });
    let known = declared.map(|item| item.name).chain(predeclared::NAMES);
    let diagnostic = match glsl_habit(name) {
        Some(ours) => diagnostic.with_help(format!("write `{ours}`")),
        None => report::misspelt(diagnostic, name, known),
    };
    reader.reports.refuse(diagnostic)
}

/// Returns WGSL's spelling of a type name from GLSL or HLSL.
fn glsl_habit(name: &str) -> Option<&'static str> {
    Some(match name {
        "float" | "double" => "f32",
        "int" => "i32",
        "uint" => "u32",
        "half" => "f16",
        "float2" => "vec2f",
        "float3" => "vec3f",
        "float4" => "vec4f",
        "mat2" | "float2x2" => "mat2x2f",
        "mat3" | "float3x3" => "mat3x3f",
        "mat4" | "float4x4" => "mat4x4f",
        _ => return None,
    })
}

fn recursive(reader: &mut ModuleReader<'_>, index: usize, at: Span) -> Refused {
    let item = &reader.outline.items[index];
    let message = format!("`{}` contains itself", item.name);
    reader.reports.refuse(
        Diagnostic::error(Code::RecursiveStruct, at, message)
            .with_label(item.name_span, "defined here")
            .with_help("store an index into an array of them instead"),
    )
}

/// Returns the type a constructor names; `None` if its constructor is not evaluated here.
// `mat2x2(…)` infers its component from its arguments, which is not evaluated here.
pub(super) fn constructed<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    word: WgslToken,
) -> Result<Option<Type>, Refused> {
    let matrix = matches!(
        predeclared::lookup(lexer.text_of(word)),
        Some(Predeclared::Matrix { scalar: None, .. })
    );
    if matrix && !lexer.peek().is(b'<') {
        return Ok(None);
    }
    let typed =
        reader.deeper(report::span(word), TYPE_LEVEL, |reader| named(reader, lexer, word))?;
    Ok(match typed.meaning {
        Meaning::Data(ty) => Some(ty),
        Meaning::Opaque | Meaning::Bindings(..) => None,
    })
}
