//! Assertions at compile time that structures of a program lie in memory as a shader reads them.
//!
//! Resolves which structure or block of the shaders each of the program's structures is compared
//! with, and what its offsets and sizes have to be; the languages write that down.

mod c;
mod csharp;
mod rust;
mod zig;

use landfall_layout::diagnostic::{Code, Severity};
use landfall_layout::layout::{BlockLayout, MemberLayout, measure};
use landfall_layout::shape::{ArrayLen, Rules, ScalarKind, Type};
use landfall_layout::source::Span;
use landfall_layout::text::edit_distance::suggestion;
use landfall_layout::{Diagnostic, ShaderLayout};

use crate::c::comments::safe;
use crate::language::{AssertOptions, CodeOptions, CodeOutput};
use crate::model::header;
use crate::refusal::{blocks, declared_names};

/// A structure of the program and what the shader expects of it.
struct HostStructure {
    /// Its name in the program, as given.
    pub host: String,
    /// What it is in the shader: "`PointLight` (lights.frag:3, std140)".
    pub what: String,
    pub fields: Vec<HostField>,
    /// The sizes that it may have; none where a runtime-sized array follows.
    pub sizes: Vec<u64>,
    /// What a failed assertion of its size says.
    pub size_message: String,
}

/// A member that the program's structure has.
struct HostField {
    /// Its name in the program.
    pub name: String,
    pub offset: u64,
    /// What a failed assertion of its offset says.
    pub offset_message: String,
    /// The sizes that it may have.
    pub sizes: Vec<u64>,
    /// What a failed assertion of its size says.
    pub size_message: String,
}

/// How assertions are written in a language.
struct AssertionWriter {
    /// The name of a member where none is given.
    pub field: fn(&str) -> String,
    /// Whether a text can stand for a structure.
    pub is_structure: fn(&str) -> bool,
    /// An example of one.
    pub example: &'static str,
    pub write: fn(&[HostStructure], &CodeOptions) -> String,
}

/// Writes assertions in C and C++.
pub(crate) fn c(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    output(&c::C, shaders, options)
}

pub(crate) fn rust(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    output(&rust::RUST, shaders, options)
}

pub(crate) fn zig(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    output(&zig::ZIG, shaders, options)
}

pub(crate) fn csharp(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    output(&csharp::CSHARP, shaders, options)
}

/// Refuses a language that has no structures whose layout is fixed.
pub(crate) fn none(_: &[&ShaderLayout], _: &CodeOptions) -> CodeOutput {
    let message = "structures of this language have no layout that is fixed".to_string();
    let error = error(Code::CannotRun, message)
        .with_help("assertions are written in `rust`, `c`, `csharp` and `zig`");
    CodeOutput { text: String::new(), diagnostics: vec![error] }
}

/// Writes the assertions of the options; structures with errors are left out.
fn output(
    writer: &AssertionWriter,
    shaders: &[&ShaderLayout],
    options: &CodeOptions,
) -> CodeOutput {
    let (structures, diagnostics) = resolve(shaders, &options.assertions, writer);
    let text = header(shaders, "//", &[]) + &(writer.write)(&structures, options);
    CodeOutput { text, diagnostics }
}

fn resolve(
    shaders: &[&ShaderLayout],
    options: &AssertOptions,
    writer: &AssertionWriter,
) -> (Vec<HostStructure>, Vec<Diagnostic>) {
    let mut resolved = Vec::new();
    let mut errors = Vec::new();
    let mut used = vec![false; options.fields.len()];
    for (at, (host, shader)) in options.structures.iter().enumerate() {
        if !(writer.is_structure)(host) {
            let message = format!("`{host}` cannot be the name of a structure");
            errors.push(
                error(Code::BadName, message)
                    .with_help(format!("write it as the program does: `{}`", writer.example)),
            );
            continue;
        }
        if options.structures[..at].iter().any(|(other, _)| other == host) {
            let message = format!("`{host}` has two assertions");
            errors.push(
                error(Code::DuplicateName, message).with_help("one structure is read in one way"),
            );
            continue;
        }
        match find(shaders, shader) {
            Ok(expected) => {
                let structure = structure(host, shader, &expected, options, writer, &mut used);
                errors.extend(structure.fields.iter().filter_map(|field| bad_field(&field.name)));
                resolved.push(structure);
            }
            Err(found) => errors.push(found),
        }
    }
    // A name that was never looked up is a mistake: the member would go unchecked.
    for ((member, _), used) in options.fields.iter().zip(used) {
        if !used {
            errors.push(unknown_field(member, shaders, options));
        }
    }
    (resolved, errors)
}

fn error(code: Code, message: String) -> Diagnostic {
    Diagnostic::without_place(code, Severity::Error, message)
}

/// An error for a name that cannot be that of a member, with or without Rust's mark of a raw one.
fn bad_field(name: &str) -> Option<Diagnostic> {
    let is_name = is_path(name.strip_prefix("r#").unwrap_or(name), "::") && !name.contains(':');
    let message = format!("`{name}` cannot be the name of a member");
    (!is_name).then(|| error(Code::BadName, message))
}

/// What a structure of the program has to look like.
struct Expected<'s> {
    shader: &'s ShaderLayout,
    name: &'s str,
    span: Span,
    rules: Rules,
    members: &'s [MemberLayout],
    /// The end of the last member, and the whole.
    sizes: Vec<u64>,
}

impl Expected<'_> {
    /// Whether both have the same members at the same places.
    fn is_same(&self, other: &Expected<'_>) -> bool {
        let same = |(a, b): (&MemberLayout, &MemberLayout)| {
            a.name == b.name && a.offset == b.offset && a.size == b.size && a.strides == b.strides
        };
        self.members.len() == other.members.len()
            && self.members.iter().zip(other.members).all(same)
    }
}

/// Finds a block, a member of one, or a structure of one.
fn find<'s>(shaders: &[&'s ShaderLayout], name: &str) -> Result<Expected<'s>, Diagnostic> {
    // `Lights.data[]` and `Lights.data` are the same member here.
    let path = name.replace("[]", "");
    let (first, rest) = path.split_once('.').map_or((&*path, None), |(a, b)| (a, Some(b)));
    let named =
        |block: &BlockLayout| *block.name == *first || block.instance.as_deref() == Some(first);
    let mut found: Vec<Expected<'s>> = Vec::new();
    for (shader, block) in blocks(shaders).filter(|(_, block)| named(block)) {
        match rest {
            None => found.extend(whole(shader, block)),
            Some(rest) => match member(&block.members, rest) {
                Some(member) => found.extend(of_member(shader, block, member)),
                None => {
                    let message = format!("`{name}`: no member of `{first}` has the path `{rest}`");
                    return Err(error(Code::UnknownMember, message));
                }
            },
        }
    }
    // Only a name that no block has is that of a structure, wherever it is used.
    if found.is_empty() && rest.is_none() {
        for (shader, block) in blocks(shaders) {
            of_structures(shader, block, &block.members, first, &mut found);
        }
    }
    // What is an element of an array somewhere has the size of one everywhere.
    let least = found.iter().map(|expected| expected.sizes.len()).min().unwrap_or(0);
    let mut found = found.into_iter();
    let Some(mut expected) = found.next() else { return Err(unknown(shaders, name)) };
    for other in found {
        if !expected.is_same(&other) {
            let at = |e: &Expected<'_>| format!("{} ({})", place(e.shader, e.span), e.rules.name());
            let message =
                format!("`{name}` is laid out in two ways: {} and {}", at(&expected), at(&other));
            let help = "name the block that the structure is uploaded to: `Block.member`";
            return Err(error(Code::AmbiguousBlock, message).with_help(help));
        }
        if other.sizes.len() == least {
            expected = other;
        }
    }
    Ok(expected)
}

fn whole<'s>(shader: &'s ShaderLayout, block: &'s BlockLayout) -> Option<Expected<'s>> {
    let (size, data_size) = (block.size?, block.data_size?);
    let is_open = |member: &MemberLayout| member.dims.first() == Some(&ArrayLen::Runtime);
    // With or without the padding at the end: both hold all that the shader reads. In front of a
    // runtime-sized array neither is asserted.
    let mut sizes = vec![data_size, size];
    sizes.dedup();
    if block.members.last().is_some_and(is_open) {
        sizes.clear();
    }
    let (name, members) = (&*block.name, &*block.members);
    Some(Expected { shader, name, span: block.span, rules: block.rules, members, sizes })
}

fn member<'s>(members: &'s [MemberLayout], path: &str) -> Option<&'s MemberLayout> {
    let (first, rest) = path.split_once('.').map_or((path, None), |(a, b)| (a, Some(b)));
    let found = members.iter().find(|member| *member.name == *first)?;
    rest.map_or(Some(found), |rest| member(&found.members, rest))
}

fn of_member<'s>(
    shader: &'s ShaderLayout,
    block: &'s BlockLayout,
    member: &'s MemberLayout,
) -> Option<Expected<'s>> {
    let Type::Struct(structure) = member.ty.innermost() else { return None };
    let data_size = measure::structure(&member.members, block.rules).data_size;
    let size = measure::element_size(member, block.rules);
    // An element of an array has to be as long as the stride; alone it may end with its last
    // member.
    let sizes = match member.strides.last() {
        Some(&stride) => vec![stride],
        None if size == data_size => vec![size],
        None => vec![data_size, size],
    };
    let (name, members) = (&*structure.name, &*member.members);
    Some(Expected { shader, name, span: structure.span, rules: block.rules, members, sizes })
}

fn of_structures<'s>(
    shader: &'s ShaderLayout,
    block: &'s BlockLayout,
    members: &'s [MemberLayout],
    name: &str,
    found: &mut Vec<Expected<'s>>,
) {
    for member in members {
        if let Type::Struct(structure) = member.ty.innermost() {
            if *structure.name == *name {
                found.extend(of_member(shader, block, member));
            }
            of_structures(shader, block, &member.members, name, found);
        }
    }
}

fn unknown(shaders: &[&ShaderLayout], name: &str) -> Diagnostic {
    let message = format!("no block has or is a structure `{name}`");
    let help = suggestion(name, declared_names(shaders).into_iter());
    error(Code::UnknownName, message).with_help(
        help.unwrap_or_else(|| "`landfall layout` lists the blocks with their structures".into()),
    )
}

fn unknown_field(member: &str, shaders: &[&ShaderLayout], options: &AssertOptions) -> Diagnostic {
    let message = format!("`{member}` is no member of a structure with an assertion");
    let members = options.structures.iter().filter_map(|(_, shader)| find(shaders, shader).ok());
    let members = members.flat_map(|expected| {
        expected.members.iter().map(move |member| format!("{}.{}", expected.name, member.name))
    });
    let members: Vec<String> = members.collect();
    let help = suggestion(member, members.iter().map(String::as_str));
    error(Code::UnknownMember, message).with_help(
        help.unwrap_or_else(|| {
            "name the shader's structure and member: `PointLight.position`".into()
        }),
    )
}

fn structure(
    host: &str,
    asked: &str,
    expected: &Expected<'_>,
    options: &AssertOptions,
    writer: &AssertionWriter,
    used: &mut [bool],
) -> HostStructure {
    let Expected { shader, name, rules, .. } = *expected;
    let mut members: Vec<&MemberLayout> = expected.members.iter().collect();
    members.sort_by_key(|member| member.offset);
    let mut fields = Vec::new();
    let mut before: Option<(&MemberLayout, u64)> = None;
    for (at, member) in members.iter().enumerate() {
        let (Some(offset), Some(size)) = (member.offset, member.size) else { continue };
        // By the structure's name, or by what the assertion was asked for.
        let is_named = |path: &str| {
            path.rsplit_once('.')
                .is_some_and(|(of, field)| *field == *member.name && (of == name || of == asked))
        };
        let given = options.fields.iter().position(|(path, _)| is_named(path));
        let host_name = match given {
            Some(at) => {
                used[at] = true;
                options.fields[at].1.clone()
            }
            None => format!("{}{}", options.field_prefix, (writer.field)(&member.name)),
        };
        // An empty name: the program has no such member, and what it has there does not matter.
        if !host_name.is_empty() {
            // The bytes up to the next member, more than which a member of the program cannot take.
            let next = members.get(at + 1).and_then(|next| next.offset);
            let end = next.or(expected.sizes.last().copied()).unwrap_or(offset + size);
            let sizes = field_sizes(member, rules, size, end.saturating_sub(offset));
            fields.push(HostField {
                name: host_name,
                offset,
                offset_message: offset_message(shader, member, offset, before),
                size_message: size_message(shader, member, &sizes),
                sizes,
            });
        }
        // Also of a member that the program does not have: the next one follows it in the shader.
        before = Some((member, offset + size));
    }
    let what = format!("`{name}` ({}, {})", place(shader, expected.span), rules.name());
    let size_message = match expected.sizes.as_slice() {
        [stride] => {
            format!("`{name}` takes {stride} bytes in the shader, padding at its end included")
        }
        [data, whole] => format!(
            "`{name}` takes {data} bytes in the shader, or {whole} with the padding at its end"
        ),
        _ => String::new(),
    };
    HostStructure {
        host: host.to_string(),
        what,
        fields,
        sizes: expected.sizes.clone(),
        size_message,
    }
}

/// The sizes a member may have in the program: that in the shader, and of vectors and matrices also
/// with the padding behind the last column, as `vec4` stands for `vec3`.
fn field_sizes(member: &MemberLayout, rules: Rules, size: u64, most: u64) -> Vec<u64> {
    let mut sizes = vec![size];
    match member.ty.innermost() {
        Type::Struct(_) if member.strides.is_empty() => {
            sizes.insert(0, measure::structure(&member.members, rules).data_size);
        }
        // A `vec3` may be a vector of four in the program, if nothing lies in its fourth component.
        Type::Vector { scalar, rows: 3 } if member.strides.is_empty() => {
            sizes.push(size + u64::from(scalar.width));
        }
        _ => {}
    }
    sizes.dedup();
    // Without room behind it, only the first.
    sizes.retain(|&one| one <= size.max(most));
    sizes
}

fn offset_message(
    shader: &ShaderLayout,
    member: &MemberLayout,
    offset: u64,
    before: Option<(&MemberLayout, u64)>,
) -> String {
    let reads = format!(
        "the shader reads `{}` at byte {offset} ({})",
        member.name,
        place(shader, member.span)
    );
    match before {
        None => format!("{reads}: put it first"),
        Some((before, end)) if end < offset => format!(
            "{reads}: `{}` ends at {end}, so put {} bytes of padding before it",
            before.name,
            offset - end
        ),
        Some((before, _)) => format!("{reads}: right behind `{}`", before.name),
    }
}

fn size_message(shader: &ShaderLayout, member: &MemberLayout, sizes: &[u64]) -> String {
    let size = sizes[0];
    let ty = member.ty.spelled(shader.language);
    let takes = format!("`{}` ({ty}) takes {size} bytes in the shader", member.name);
    let element = member.ty.innermost();
    let takes = match sizes {
        [_, padded] => format!("{takes}, or {padded} with its padding"),
        _ => takes,
    };
    let columns = match (element, member.matrix_stride) {
        (Type::Matrix { .. }, Some(stride)) => Some(stride),
        _ => None,
    };
    match (element, columns, member.strides.last()) {
        (_, Some(stride), None) => {
            let vector = if member.row_major { "row" } else { "column" };
            format!("{takes}: {stride} for each {vector}")
        }
        (_, _, Some(stride)) => format!("{takes}: {stride} for each element"),
        // A `bool` is 4 bytes in a shader, and mostly 1 in these languages.
        (Type::Scalar(scalar), ..) if scalar.kind == ScalarKind::Bool => {
            format!("{takes}: use an integer of 32 bits")
        }
        _ => takes,
    }
}

/// `lights.frag:12`.
fn place(shader: &ShaderLayout, span: Span) -> String {
    let at = shader.files.locate(span);
    format!("{}:{}", safe(&at.path), at.line)
}

/// A text as a literal between double quotes in C, C++, C#, Rust and Zig.
fn quoted(text: &str) -> String {
    // Backslashes first, so that those of escaped quotes stay.
    format!("\"{}\"", safe(text).replace('\\', "\\\\").replace('"', "\\\""))
}

/// Whether a text is identifiers with one of these separators between them.
fn is_path(text: &str, separator: &str) -> bool {
    text.split(separator).all(|part| {
        part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && part.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_')
    })
}
