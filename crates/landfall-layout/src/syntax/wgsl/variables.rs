//! Parsing of module-scope variables (§7.3) to [`Block`].

use std::sync::Arc;

use super::attributes::{self, Attributes, number};
use super::lexer::WgslLexer;
use super::outline::OutlineItem;
use super::reader::ModuleReader;
use super::report::{self, Refused};
use super::types::{self, Meaning, TypeFacts};
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{AddressSpace, ArrayLen, Block, Member, Rules, Type};
use crate::source::Span;

/// Address spaces whose variables are not buffers.
const NO_BUFFER: [&str; 8] = [
    "private",
    "workgroup",
    "function",
    "handle",
    "task_payload",
    "ray_payload",
    "incoming_ray_payload",
    "pixel_local",
];

/// Returns the block of a variable, if it is a buffer.
// global_variable_decl: attribute* variable_decl ( `=` expression )?
// Buffers take no initialiser, so `;` follows the type.
pub(super) fn block<'a>(
    reader: &mut ModuleReader<'a>,
    item: &OutlineItem<'a>,
) -> Result<Option<Block>, Refused> {
    let Some(space) = address_space(reader, item)? else { return Ok(None) };
    let mut lexer = WgslLexer::new(reader.text, item.rest);
    reader.expect(&mut lexer, b':')?;
    let type_at = report::span(lexer.peek());
    let typed = types::read(reader, &mut lexer)?;
    reader.expect(&mut lexer, b';')?;
    // An invalid number is reported; the layout does not depend on it.
    let attributes = attributes::of_item(reader, item).unwrap_or_default();
    check(reader, item, space, typed.facts, type_at)?;
    let (meaning, count) = match typed.meaning {
        Meaning::Bindings(element, len) => (*element, vec![len]),
        meaning @ (Meaning::Data(_) | Meaning::Opaque) => (meaning, Vec::new()),
    };
    let Meaning::Data(ty) = meaning else {
        return Err(reader.reports.refuse(opaque(item, type_at, type_at)));
    };
    Ok(Some(made(item, space, attributes, ty, count)))
}

fn made(
    item: &OutlineItem<'_>,
    space: AddressSpace,
    attributes: Attributes,
    ty: Type,
    count: Vec<ArrayLen>,
) -> Block {
    let variable: Arc<str> = Arc::from(item.name);
    // A variable whose type is no structure is a block of one member with its own name, at offset
    // 0.
    let (name, instance, members) = match ty {
        Type::Struct(s) => (s.name.clone(), Some(variable), s.members.clone()),
        ty => {
            let member = Member::unqualified(variable.clone(), ty, item.name_span);
            (variable, None, vec![member])
        }
    };
    Block {
        instance,
        group: number(attributes.group),
        binding: number(attributes.binding),
        count,
        comment: item.comment.clone(),
        ..Block::unqualified(name, space, Rules::Wgsl, members, item.name_span)
    }
}

/// Returns the address space of a variable, if it is that of a buffer.
fn address_space(
    reader: &mut ModuleReader<'_>,
    item: &OutlineItem<'_>,
) -> Result<Option<AddressSpace>, Refused> {
    let Some((name, at)) = item.space else { return Ok(None) };
    match name {
        "uniform" => Ok(Some(AddressSpace::Uniform)),
        "storage" => Ok(Some(AddressSpace::Storage)),
        "immediate" => Ok(Some(AddressSpace::PushConstant)),
        "push_constant" => {
            let message = "WGSL has no address space `push_constant`";
            let note = "only naga before version 28 accepts it: it is now `immediate`";
            let warning = Diagnostic::warning(Code::UnknownAddressSpace, at, message);
            reader.reports.push(warning.with_note(note).with_help("write `var<immediate>`"));
            Ok(Some(AddressSpace::PushConstant))
        }
        _ if NO_BUFFER.contains(&name) => Ok(None),
        _ => {
            let message = format!("unknown address space `{name}`");
            let known = ["uniform", "storage", "immediate"].into_iter().chain(NO_BUFFER);
            let diagnostic = Diagnostic::error(Code::UnknownAddressSpace, at, message);
            Err(reader.reports.refuse(report::misspelt(diagnostic, name, known)))
        }
    }
}

/// Checks that a type is allowed in an address space.
// Buffers hold host-shareable types; atomics and runtime sizes are only in `storage`. All that is
// wrong is reported, not the first alone.
fn check(
    reader: &mut ModuleReader<'_>,
    item: &OutlineItem<'_>,
    space: AddressSpace,
    facts: TypeFacts,
    type_at: Span,
) -> Result<(), Refused> {
    let (name, is_storage) = (item.name, space == AddressSpace::Storage);
    let mut errors = Vec::new();
    let error = |code, at, message: String, help: &str| {
        let error = Diagnostic::error(code, at, message);
        error.with_label(item.name_span, "in this buffer").with_help(help)
    };
    if let Some(at) = facts.boolean {
        let message = format!("`{name}` holds a bool, which is not host-shareable");
        let help = "write `u32`, and compare with `!= 0u`";
        errors.push(error(Code::NotHostShareable, at, message, help));
    }
    errors.extend(facts.opaque.map(|at| opaque(item, at, type_at)));
    if let Some(at) = facts.atomic.filter(|_| !is_storage) {
        let message =
            format!("`{name}` holds an atomic, which cannot be in {} memory", space.name());
        let help = "write `var<storage, read_write>`, or the plain type without `atomic`";
        errors.push(error(Code::NotHostShareable, at, message, help));
    }
    if let Some(runtime) = facts.runtime.filter(|_| !is_storage) {
        let message =
            format!("`{name}` is runtime-sized, which is not allowed in {} memory", space.name());
        let otherwise = "write `var<storage>`, or specify the array's number of elements";
        let help = runtime.help(reader, otherwise);
        errors.push(error(Code::RuntimeSizedArray, runtime.at, message, &help));
    }
    let is_refused = !errors.is_empty();
    errors.into_iter().for_each(|error| reader.reports.push(error));
    if let (Some(at), false, false) = (facts.half, reader.outline.f16, reader.warned_f16) {
        reader.warned_f16 = true;
        reader.reports.push(
            Diagnostic::warning(Code::F16NotEnabled, at, "`f16` is used but not enabled")
                .with_help("write `enable f16;` as the first line"),
        );
    }
    if is_refused {
        return Err(Refused);
    }
    if let Some(at) = facts.overridden {
        reader.reports.push(override_sized(item, at));
    }
    Ok(())
}

/// WGSL §6.2.9: only workgroup variables may have such a size; naga 30 and Tint reject buffers.
fn override_sized(item: &OutlineItem<'_>, at: Span) -> Diagnostic {
    let message = format!(
        "`{}` is sized by an override, which WGSL only allows in workgroup memory",
        item.name
    );
    Diagnostic::warning(Code::OverrideSizedArray, at, message)
        .with_label(item.name_span, "in this buffer")
        .with_note("laid out by the override's default, or by `-O` where it has none")
        .with_help("use a `const` for its length, or omit the length")
}

fn opaque(item: &OutlineItem<'_>, at: Span, type_at: Span) -> Diagnostic {
    let message =
        format!("`{}` holds a texture, sampler or pointer, which is not host-shareable", item.name);
    let diagnostic = Diagnostic::error(Code::NotHostShareable, at, message);
    if at == type_at {
        diagnostic.with_help("declare it as a variable without an address space")
    } else {
        diagnostic
            .with_label(item.name_span, "in this buffer")
            .with_help("declare it as a variable of its own, outside the struct")
    }
}
