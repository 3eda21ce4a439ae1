//! The interface of a WGSL module: its variables with bindings, entry points and overrides, and
//! which variables each entry point uses.

use std::sync::Arc;

use super::attributes::{self, WantedAttributes, number};
use super::constants;
use super::expressions::{self, ExpressionContext};
use super::handles;
use super::lexer::{Kind, WgslLexer};
use super::outline::{self, Class, OutlineItem};
use super::reader::ModuleReader;
use super::report::{self, Refused, Reports};
use super::types::{self, Meaning};
use super::uses;
use crate::interface::{
    Access, EntryPoint, Input, Interface, Resource, ResourceKind, SpecConstant,
};
use crate::shape::{AddressSpace, Scalar, Type};
use crate::source::{ReadOptions, Source, Stage};
use crate::syntax::constant::Value;

/// Returns the interface of a module; what has errors, which [`super::read`] reports, is missing.
// Errors are dropped with `reports`: the reader of layouts has reported them.
pub(in crate::syntax) fn read(source: &Source, options: &ReadOptions) -> Interface {
    let text: &str = &source.text;
    let mut reports = Reports::default();
    let outline = outline::read(text, &mut reports);
    let mut interface = Interface::default();
    if outline.incomplete {
        return interface;
    }
    let mut reader = ModuleReader::new(text, &outline, options, reports);
    // The resource of each variable, by its index in the outline.
    let mut variables = Vec::new();
    for (index, item) in outline.items.iter().enumerate() {
        match item.class {
            Class::Var => {
                if let Ok(Some(resource)) = resource(&mut reader, item) {
                    variables.push(index);
                    interface.resources.push(resource);
                }
            }
            Class::Override => interface.constants.extend(constant(&mut reader, item)),
            Class::Struct | Class::Alias | Class::Const | Class::Fn => {}
        }
    }
    let found = uses::read(text, &outline);
    let resource_of = |index: usize| variables.iter().position(|&variable| variable == index);
    for (texture, sampler) in &found.pairs {
        if let Some((texture, sampler)) = resource_of(*texture).zip(resource_of(*sampler)) {
            interface.pair(texture, sampler);
        }
    }
    for (index, item) in outline.items.iter().enumerate() {
        if let Some(mut entry) = entry_point(&mut reader, item) {
            let reached = found.reached(index);
            entry.uses = reached.into_iter().filter_map(resource_of).collect();
            entry.uses.sort_unstable();
            interface.entry_points.push(entry);
        }
    }
    interface
}

fn resource<'a>(
    reader: &mut ModuleReader<'a>,
    item: &OutlineItem<'a>,
) -> Result<Option<Resource>, Refused> {
    // `handle` is the address space of textures and samplers, and is never written in WGSL.
    let space = match item.space.map(|(space, _)| space) {
        None | Some("handle") => None,
        Some("uniform") => Some(AddressSpace::Uniform),
        Some("storage") => Some(AddressSpace::Storage),
        Some("immediate" | "push_constant") => Some(AddressSpace::PushConstant),
        Some(_) => return Ok(None),
    };
    let attributes = attributes::of_item(reader, item)?;
    let mut lexer = WgslLexer::new(reader.text, item.rest);
    reader.expect(&mut lexer, b':')?;
    let (kind, count) = match space {
        Some(space) => {
            let typed = types::read(reader, &mut lexer)?;
            let count = match typed.meaning {
                Meaning::Bindings(_, len) => vec![len],
                Meaning::Data(_) | Meaning::Opaque => Vec::new(),
            };
            (ResourceKind::Buffer(space, access(reader, item)), count)
        }
        None => handles::read(reader, &mut lexer)?,
    };
    Ok(Some(Resource {
        name: Arc::from(item.name),
        group: number(attributes.group),
        binding: number(attributes.binding),
        location: None,
        kind,
        count,
        span: item.name_span,
    }))
}

/// The access mode of `var<storage, MODE>`.
// `var` `<` `storage` ( `,` access_mode )? `>`, `read` without one
fn access(reader: &ModuleReader<'_>, item: &OutlineItem<'_>) -> Access {
    let mut lexer = WgslLexer::new(reader.text, item.name_span.start);
    if let Some((_, at)) = item.space {
        lexer.jump(at.end);
    }
    let mode = if lexer.take(b',') { lexer.next() } else { return Access::Read };
    match lexer.text_of(mode) {
        "read_write" => Access::ReadWrite,
        "write" => Access::Write,
        _ => Access::Read,
    }
}

fn constant<'a>(reader: &mut ModuleReader<'a>, item: &OutlineItem<'a>) -> Option<SpecConstant> {
    let id = number(attributes::of_item(reader, item).ok()?.id);
    let mut lexer = WgslLexer::new(reader.text, item.rest);
    let declared = constants::declared_kind(reader, &mut lexer).ok()?;
    let has_default = lexer.take(b'=');
    let scalar = match declared {
        None if has_default => {
            let value = expressions::read(reader, &mut lexer, ExpressionContext::Statement).ok()?;
            value.0.ok().and_then(|value| scalar_of(&value))
        }
        declared => declared,
    };
    Some(SpecConstant { name: Arc::from(item.name), id, scalar, has_default, span: item.name_span })
}

/// The type of an override without one: that of its default, made concrete.
// AbstractInt becomes i32, AbstractFloat f32.
fn scalar_of(value: &Value) -> Option<Scalar> {
    match value {
        Value::Bool(_) => Some(Scalar::BOOL),
        Value::Abstract(_) | Value::Int(_) => Some(Scalar::I32),
        Value::Uint(_) => Some(Scalar::U32),
        Value::Float(_) => Some(Scalar::F32),
        Value::Long(_) | Value::Ulong(_) | Value::List(_) => None,
    }
}

// A function with one of the attributes `@vertex`, `@fragment`, `@compute` is an entry point; those
// of task and mesh are naga's.
fn entry_point<'a>(reader: &mut ModuleReader<'a>, item: &OutlineItem<'a>) -> Option<EntryPoint> {
    if item.class != Class::Fn {
        return None;
    }
    let mut stage = None;
    let mut workgroup_size = None;
    let mut lexer = WgslLexer::new(reader.text, item.start);
    while lexer.take(b'@') {
        let name = lexer.next();
        match lexer.text_of(name) {
            "vertex" => stage = Some(Stage::Vertex),
            "fragment" => stage = Some(Stage::Fragment),
            "compute" => stage = Some(Stage::Compute),
            "task" => stage = Some(Stage::Task),
            "mesh" => stage = Some(Stage::Mesh),
            "workgroup_size" => workgroup_size = Some(size(reader, &mut lexer).ok()?),
            _ => {}
        }
        if lexer.take(b'(') {
            report::skip_past(&mut lexer, b'(', b')').ok()?;
        }
    }
    let stage = stage?;
    let inputs = match stage {
        Stage::Vertex => inputs(reader, item).unwrap_or_default(),
        _ => Vec::new(),
    };
    Some(EntryPoint {
        name: Arc::from(item.name),
        stage: Some(stage),
        workgroup_size,
        inputs,
        uses: Vec::new(),
        span: item.name_span,
    })
}

/// Parses `(X, Y, Z)`; a number that depends on an override without a value is not known.
fn size<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
) -> Result<[Option<u32>; 3], Refused> {
    let mut size = [Some(1); 3];
    reader.expect(lexer, b'(')?;
    for axis in &mut size {
        // A size that an override sets is not the module's.
        reader.used_override = false;
        let (outcome, _) = expressions::read(reader, lexer, ExpressionContext::Statement)?;
        let value = outcome.ok().and_then(|value| u32::try_from(value.integer()?).ok());
        *axis = value.filter(|_| !reader.used_override);
        if !lexer.take(b',') || lexer.peek().is(b')') {
            break;
        }
    }
    reader.expect(lexer, b')')?;
    Ok(size)
}

/// The inputs of a vertex shader, from its parameters and the structures among them.
fn inputs(reader: &mut ModuleReader<'_>, item: &OutlineItem<'_>) -> Result<Vec<Input>, Refused> {
    let mut lexer = WgslLexer::new(reader.text, item.rest);
    let mut inputs = Vec::new();
    reader.expect(&mut lexer, b'(')?;
    members(reader, &mut lexer, b')', &mut inputs)?;
    Ok(inputs)
}

/// Parses `@location(N) NAME: TYPE, …` up to a sign, structures included.
// param: attribute* ident `:` type_specifier      struct_member: the same
// A structure among the parameters contributes its members, each with its own `@location`.
fn members<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    end: u8,
    inputs: &mut Vec<Input>,
) -> Result<(), Refused> {
    while !lexer.take(end) {
        let attributes = attributes::read_those(reader, lexer, WantedAttributes::OfInputs)?;
        let name = lexer.next();
        reader.expect(lexer, b':')?;
        let typed = types::read(reader, lexer)?;
        lexer.take(b',');
        if name.kind != Kind::Word {
            return Err(Refused);
        }
        let location = number(attributes.location);
        match typed.meaning {
            Meaning::Data(Type::Struct(structure)) => {
                let index = reader.outline.names.get(&*structure.name).copied();
                let Some(index) = index else { continue };
                let mut inside = WgslLexer::new(reader.text, reader.outline.items[index].rest);
                reader.expect(&mut inside, b'{')?;
                members(reader, &mut inside, b'}', inputs)?;
            }
            // Without a location it is a builtin.
            Meaning::Data(ty) if location.is_some() => inputs.push(Input {
                name: Arc::from(lexer.text_of(name)),
                location,
                ty,
                span: report::span(name),
            }),
            Meaning::Data(_) | Meaning::Opaque | Meaning::Bindings(..) => {}
        }
    }
    Ok(())
}
