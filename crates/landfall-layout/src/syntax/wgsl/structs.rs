//! Parsing of structure declarations (§6.2.10) to [`Struct`].

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::lexer::{Kind, WgslLexer, WgslToken};
use super::reader::ModuleReader;
use super::report::{self, Refused};
use super::types::{self, Meaning, TypeFacts, Typed};
use super::{attributes, comments};
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{DEEPEST_NESTING, Member, Scalar, Struct, Type};
use crate::source::Span;

// struct_body_decl: `{` struct_member ( `,` struct_member )* `,`? `}`
// An error in a member makes the structure broken, but all members are read, so that each error is
// reported once.
pub(super) fn read(reader: &mut ModuleReader<'_>, index: usize) -> Result<Typed, Refused> {
    let outline = reader.outline;
    let item = &outline.items[index];
    let mut lexer = WgslLexer::new(reader.text, item.rest);
    let open = lexer.next();
    let mut body = StructBody { end: open.end, ..StructBody::default() };
    loop {
        let next = lexer.peek();
        let (trailing, before) =
            comments::split(reader.text, &lexer.comments[body.seen..], body.end, next);
        if let Some(last) = body.members.last_mut() {
            last.comment.extend(comments::spans(trailing));
        }
        let before = comments::spans(before).collect();
        body.seen = lexer.comments.len();
        if lexer.take(b'}') {
            break;
        }
        match member(reader, &mut lexer, &mut body, before) {
            Ok(end) => body.end = end,
            Err(Refused) => {
                body.broken = true;
                // From the start of the member, since the error may stand past its end.
                lexer.jump(next.start);
                if recover(&mut lexer) {
                    break;
                }
                body.end = lexer.peek().start;
                body.seen = lexer.comments.len();
            }
        }
    }
    if body.broken {
        return Err(Refused);
    }
    if body.members.is_empty() && body.opaque.is_empty() {
        let message = format!("`{}` has no members, but WGSL requires at least one", item.name);
        let diagnostic = Diagnostic::error(Code::EmptyStruct, item.name_span, message);
        return Err(reader.reports.refuse(diagnostic.with_help("add a member")));
    }
    let made = Struct::new(Arc::from(item.name), body.members, body.opaque, item.name_span);
    let ty = Type::Struct(Arc::new(made));
    if ty.depth() > DEEPEST_NESTING {
        return Err(reader.reports.refuse(report::too_deep(item.name_span)));
    }
    Ok(Typed { meaning: Meaning::Data(ty), facts: body.facts })
}

#[derive(Default)]
struct StructBody {
    members: Vec<Member>,
    names: FxHashMap<Arc<str>, Span>,
    opaque: Vec<Arc<str>>,
    facts: TypeFacts,
    end: u32,
    /// The number of comments assigned to members.
    seen: usize,
    broken: bool,
}

/// Parses `@align(16) name: type,`; returns its end.
// struct_member: attribute* member_ident `:` type_specifier
fn member<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    body: &mut StructBody,
    comment: Vec<Span>,
) -> Result<u32, Refused> {
    let attributes = attributes::read(reader, lexer)?;
    let name = reader.reports.checked(report::word(lexer, "a member"))?;
    reader.expect(lexer, b':')?;
    let type_at = report::span(lexer.peek());
    // The text may continue after an invalid type; the structure is then invalid.
    let typed = types::read(reader, lexer)?;
    let (span, text) = (report::span(name), lexer.text_of(name));
    if let Some(&first) = body.names.get(text) {
        reader.reports.push(report::duplicate(text, span, first));
        body.broken = true;
    } else {
        body.names.insert(Arc::from(text), span);
    }
    // Of a member before this one: only the last may be runtime-sized (§6.2.9).
    if let Some(runtime) = body.facts.runtime {
        let help = "make it the last member, or specify its number of elements";
        let help = runtime.help(reader, help);
        reader.reports.push(not_last(&body.members, runtime.at).with_help(help));
        body.facts.runtime = None;
        body.broken = true;
    }
    let end = member_end(reader, lexer)?;
    body.facts = body.facts.and(typed.facts);
    match typed.meaning {
        Meaning::Data(ty) => {
            if let (Type::Struct(inner), Some(runtime)) = (&ty, typed.facts.runtime) {
                let help = "specify the array's number of elements, or move it to the outer struct";
                let help = runtime.help(reader, help);
                let diagnostic = nested_runtime(&inner.name, type_at, runtime.at);
                reader.reports.push(diagnostic.with_help(help));
                body.broken = true;
            }
            body.members.push(Member {
                align: attributes.align,
                size: attributes.size,
                comment,
                ..Member::unqualified(Arc::from(text), ty, span)
            });
        }
        Meaning::Opaque | Meaning::Bindings(..) => {
            body.facts.opaque = body.facts.opaque.or(Some(type_at));
            body.opaque.push(Arc::from(text));
        }
    }
    Ok(end)
}

/// Parses the `,` after a member, or the end of the structure, which is not consumed.
fn member_end(reader: &mut ModuleReader<'_>, lexer: &mut WgslLexer<'_>) -> Result<u32, Refused> {
    let next = lexer.peek();
    match next.kind {
        Kind::Sign(b',') => {
            lexer.next();
            Ok(next.end)
        }
        Kind::Sign(b'}') => Ok(next.start),
        Kind::Sign(b';') => {
            lexer.next();
            reader.reports.push(
                Diagnostic::error(
                    Code::Syntax,
                    report::span(next),
                    "expected `,` after a member, found `;`",
                )
                .with_help("write `,`"),
            );
            Ok(next.end)
        }
        // A missing comma: continue with the next member.
        Kind::Word | Kind::Sign(b'@') => {
            reader.reports.push(report::unexpected(lexer, next, "`,` or `}`"));
            Ok(next.start)
        }
        Kind::Number | Kind::Sign(_) | Kind::End => {
            Err(reader.reports.refuse(report::unexpected(lexer, next, "`,` or `}`")))
        }
    }
}

/// Recovers from an error in a member: skips past the next `,` that ends a member; returns `true`
/// at the structure's end.
// `<` may be an operator, which is not closed; hence signed depths, and line breaks as a second
// sign.
fn recover(lexer: &mut WgslLexer<'_>) -> bool {
    let mut depth = 0i32;
    loop {
        let token: WgslToken = lexer.next();
        match token.kind {
            Kind::Sign(b'(' | b'[' | b'<') => depth += 1,
            Kind::Sign(b')' | b']' | b'>') => depth -= 1,
            Kind::Sign(b',') if depth <= 0 => return false,
            // A line break after the comma ends the member even inside open brackets.
            Kind::Sign(b',') if breaks_after(lexer, token) => return false,
            Kind::Sign(b'}') | Kind::End => return true,
            Kind::Word | Kind::Number | Kind::Sign(_) => {}
        }
    }
}

fn breaks_after(lexer: &WgslLexer<'_>, token: WgslToken) -> bool {
    let rest = &lexer.text()[token.end as usize..];
    rest.trim_start_matches([' ', '\t', '\r']).starts_with('\n')
}

fn not_last(members: &[Member], runtime: Span) -> Diagnostic {
    let name = members.last().map_or("", |member| &member.name);
    let message = format!("`{name}` is runtime-sized, but it is not the last member");
    Diagnostic::error(Code::RuntimeSizedArray, runtime, message)
}

fn nested_runtime(inner: &str, at: Span, runtime: Span) -> Diagnostic {
    let message = format!("`{inner}` ends in a runtime-sized array, so it cannot be a member");
    Diagnostic::error(Code::RuntimeSizedArray, at, message).with_label(runtime, "runtime-sized")
}

/// Returns naga's predeclared `RayDesc`.
pub(super) fn ray_desc() -> Type {
    let member = |name: &str, ty: Type| Member::unqualified(Arc::from(name), ty, Span::default());
    let vector = Type::Vector { scalar: Scalar::F32, rows: 3 };
    let members = vec![
        member("flags", Type::Scalar(Scalar::U32)),
        member("cull_mask", Type::Scalar(Scalar::U32)),
        member("tmin", Type::Scalar(Scalar::F32)),
        member("tmax", Type::Scalar(Scalar::F32)),
        member("origin", vector.clone()),
        member("dir", vector),
    ];
    let name = Arc::from("RayDesc");
    Type::Struct(Arc::new(Struct::new(name, members, Vec::new(), Span::default())))
}
