//! What passes between stages: `attribute`, `varying`, `in` and `out` with
//! locations both stages agree on, and `gl_FragColor` as an output.

use crate::diagnostic::Code;
use std::collections::BTreeMap;

use super::Location;
use super::edits::Edits;
use super::outline::{Declaration, Qualifiers, Tokens, Variables};
use super::shader::Shader;
use super::uniforms::{number, qualify};
use crate::shape::{ArrayLen, Type};
use crate::source::{ReadOptions, Source, Stage};
use crate::syntax::parse;
use crate::{Diagnostic, Severity};

/// Which way something passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Direction {
    /// Into the stage.
    In,
    /// Out of the stage.
    Out,
}

impl Direction {
    /// `in` or `out`.
    pub fn name(self) -> &'static str {
        match self {
            Direction::In => "in",
            Direction::Out => "out",
        }
    }
}

/// One input or output as declared.
#[derive(Clone, Debug)]
pub(super) struct Passed {
    pub name: String,
    pub direction: Direction,
    /// Locations it takes; `None` when its size could not be told.
    slots: Option<u32>,
    explicit: Option<u32>,
    /// Index into the declarations, and of the declarator.
    declaration: usize,
    declarator: usize,
}

/// The inputs and outputs of a shader, in the order of the text.
pub(super) fn passed(
    shader: &Shader<'_>,
    source: &Source,
    stage: Stage,
    read: &ReadOptions,
) -> Vec<Passed> {
    let mut all = Vec::new();
    let mut types = Vec::new();
    for (index, declaration) in shader.declarations.iter().enumerate() {
        match declaration {
            Declaration::Variables(variables) => {
                let Some(direction) = direction(shader, &variables.qualifiers, stage) else {
                    continue;
                };
                for (declarator, declared) in variables.declarators.iter().enumerate() {
                    let name = shader.code[declared.name].text;
                    if name.starts_with("gl_") {
                        continue;
                    }
                    let dims = declared.dims.iter().chain(&variables.type_dims);
                    types.push(variable_type(shader, variables, dims, direction, stage));
                    all.push(Passed {
                        name: name.to_string(),
                        direction,
                        slots: None,
                        explicit: number(shader, &variables.qualifiers, "location"),
                        declaration: index,
                        declarator,
                    });
                }
            }
            Declaration::Block(block) => {
                let Some(direction) = direction(shader, &block.qualifiers, stage) else { continue };
                let name = shader.code[block.name].text;
                if name.starts_with("gl_") {
                    continue;
                }
                let members = block.members.iter().map(|member| {
                    let start = member.ty;
                    shader.text_of(&(start..member.tokens.end)).to_string()
                });
                let members: String = members.collect();
                types.push(format!("struct {{ {members} }} X;"));
                all.push(Passed {
                    name: name.to_string(),
                    direction,
                    slots: None,
                    explicit: number(shader, &block.qualifiers, "location"),
                    declaration: index,
                    declarator: 0,
                });
            }
            _ => {}
        }
    }
    for (passed, slots) in all.iter_mut().zip(slots(source, read, &types)) {
        passed.slots = slots;
    }
    all
}

/// The declaration of a uniform of that type, named `X`: what the front end is asked about.
fn variable_type<'t>(
    shader: &Shader<'_>,
    variables: &Variables,
    dims: impl Iterator<Item = &'t Tokens>,
    direction: Direction,
    stage: Stage,
) -> String {
    // Each vertex of a patch or primitive has its own: the outermost dimension counts vertices.
    let per_vertex = match (stage, direction) {
        (
            Stage::Geometry | Stage::TessellationControl | Stage::TessellationEvaluation,
            Direction::In,
        )
        | (Stage::TessellationControl, Direction::Out) => !shader.has_word(variables, "patch"),
        _ => false,
    };
    let dims = dims.skip(usize::from(per_vertex));
    let dims: String = dims.map(|dim| format!("[{}]", shader.text_of(dim))).collect();
    format!("{} X{dims};", shader.code[variables.ty].text)
}

fn direction(shader: &Shader<'_>, qualifiers: &Qualifiers, stage: Stage) -> Option<Direction> {
    qualifiers.words.iter().find_map(|&at| match shader.code[at].text {
        "attribute" | "in" => Some(Direction::In),
        "out" => Some(Direction::Out),
        "varying" if stage == Stage::Vertex => Some(Direction::Out),
        "varying" => Some(Direction::In),
        _ => None,
    })
}

/// Locations each type takes: the front end reads the shader with a uniform of each behind it.
fn slots(source: &Source, read: &ReadOptions, types: &[String]) -> Vec<Option<u32>> {
    let mut text = source.text.to_string();
    for (index, ty) in types.iter().enumerate() {
        text.push_str(&format!(
            "\nuniform {}",
            ty.replace(" X", &format!(" landfall_slots_{index}"))
        ));
    }
    text.push('\n');
    let parsed = parse(&Source { text: text.into(), ..source.clone() }, read, false);
    let members = parsed.shape.blocks.last().map_or(&[][..], |block| &block.members);
    let find = |index: usize| {
        let name = format!("landfall_slots_{index}");
        members.iter().find(|member| *member.name == *name).and_then(|member| slots_of(&member.ty))
    };
    (0..types.len()).map(find).collect()
}

/// GLSL 4.60 §4.4.1: a location holds a vec4; a dvec3 or dvec4 takes two, a matrix one a column.
fn slots_of(ty: &Type) -> Option<u32> {
    match ty {
        Type::Scalar(_) | Type::Atomic(_) => Some(1),
        Type::Vector { scalar, rows } => Some(if scalar.width == 8 && *rows > 2 { 2 } else { 1 }),
        Type::Matrix { scalar, columns, rows } => {
            let column = if scalar.width == 8 && *rows > 2 { 2 } else { 1 };
            Some(u32::from(*columns) * column)
        }
        Type::Array { element, len: ArrayLen::Fixed(n) } => slots_of(element)?.checked_mul(*n),
        Type::Array { .. } | Type::Address(_) => None,
        Type::Struct(s) => {
            s.members.iter().try_fold(0u32, |sum, m| sum.checked_add(slots_of(&m.ty)?))
        }
    }
}

/// Gives every input and output a location.
///
/// What another stage sees goes in the order of names, `partner`'s own among them, so that both
/// stages come to the same numbers; vertex attributes and fragment outputs keep the text's order.
pub(super) fn locate(
    shader: &Shader<'_>,
    stage: Stage,
    passed: &[Passed],
    partner: &[Passed],
    given: &[(String, u32)],
    problems: &mut Vec<Diagnostic>,
) -> Vec<Location> {
    let mut locations = Vec::new();
    for direction in [Direction::In, Direction::Out] {
        let own: Vec<&Passed> = passed.iter().filter(|p| p.direction == direction).collect();
        let outside = (stage == Stage::Vertex && direction == Direction::In)
            || (stage == Stage::Fragment && direction == Direction::Out);
        let mut all = own.clone();
        if !outside {
            let theirs = partner.iter().filter(|p| p.direction != direction);
            all.extend(theirs.filter(|p| own.iter().all(|own| own.name != p.name)));
            all.sort_by(|a, b| a.name.cmp(&b.name));
        }
        let numbers = place(shader, &all, given, problems);
        for passed in own {
            if let Some(&location) = numbers.get(passed.name.as_str()) {
                locations.push(Location { name: passed.name.clone(), direction, location });
            }
        }
    }
    locations
}

fn place<'p>(
    shader: &Shader<'_>,
    all: &[&'p Passed],
    given: &[(String, u32)],
    problems: &mut Vec<Diagnostic>,
) -> BTreeMap<&'p str, u32> {
    let mut numbers = BTreeMap::new();
    let mut taken: Vec<(u32, u32)> = Vec::new();
    let wanted = |passed: &Passed| {
        let given = given.iter().find(|(name, _)| *name == passed.name).map(|(_, n)| *n);
        given.or(passed.explicit)
    };
    for passed in all {
        if let (Some(at), Some(slots)) = (wanted(passed), passed.slots) {
            taken.push((at, at.saturating_add(slots)));
            numbers.insert(passed.name.as_str(), at);
        }
    }
    for passed in all.iter().filter(|passed| wanted(passed).is_none()) {
        let Some(slots) = passed.slots else {
            problems.push(unknown_size(shader, passed));
            continue;
        };
        let mut at = 0;
        while let Some((_, end)) = taken.iter().find(|(s, e)| at < *e && *s < at + slots) {
            at = *end;
        }
        taken.push((at, at + slots));
        numbers.insert(passed.name.as_str(), at);
    }
    numbers
}

fn unknown_size(shader: &Shader<'_>, passed: &Passed) -> Diagnostic {
    let span = match shader.declarations.get(passed.declaration) {
        Some(Declaration::Variables(v)) => shader.span(v.declarators[passed.declarator].name),
        Some(Declaration::Block(block)) => shader.span(block.name),
        _ => crate::Span::default(),
    };
    let message = format!("how many locations `{}` takes is not known", passed.name);
    Diagnostic { severity: Severity::Error, ..Diagnostic::error(Code::NotPortable, span, message) }
        .with_help("write its type and size without macros")
}

/// Writes the locations into the text, and today's words for `attribute` and `varying`.
pub(super) fn write(
    shader: &Shader<'_>,
    stage: Stage,
    passed: &[Passed],
    locations: &[Location],
    edits: &mut Edits,
) {
    let number = |passed: &Passed| {
        if passed.explicit.is_some()
            && passed.declarator == 0
            && locations.iter().any(|l| {
                l.name == passed.name
                    && l.direction == passed.direction
                    && Some(l.location) == passed.explicit
            })
        {
            return None; // it stands there already
        }
        let found =
            locations.iter().find(|l| l.name == passed.name && l.direction == passed.direction);
        found.map(|location| format!("location = {}", location.location))
    };
    for passed in passed {
        let Some(location) = number(passed) else { continue };
        match &shader.declarations[passed.declaration] {
            Declaration::Block(block) => {
                qualify(
                    shader,
                    &block.qualifiers,
                    block.tokens.start,
                    &[location],
                    &["location"],
                    edits,
                );
            }
            Declaration::Variables(variables) if passed.declarator == 0 => {
                let start = variables.tokens.start;
                qualify(shader, &variables.qualifiers, start, &[location], &["location"], edits);
            }
            Declaration::Variables(variables) => {
                // `in vec3 a, b;`: each has a location, so each has a declaration.
                let declarator = &variables.declarators[passed.declarator];
                let comma = shader.code[declarator.name - 1];
                let words = variables.qualifiers.words.iter();
                let words: Vec<&str> =
                    words.map(|&at| modern(shader.code[at].text, stage)).collect();
                let dims = variables.type_dims.iter().map(|d| format!("[{}]", shader.text_of(d)));
                let ty = shader.code[variables.ty].text;
                let dims: String = dims.collect();
                let text = format!("; layout({location}) {} {ty}{dims}", words.join(" "));
                edits.replace(comma.start..comma.end, text);
            }
            _ => {}
        }
    }
    for at in shader.words() {
        let word = shader.word(at);
        let token = &shader.raw.tokens[at];
        if modern(word, stage) != word {
            edits.replace(token.start..token.end, modern(word, stage));
        }
    }
}

fn modern(word: &str, stage: Stage) -> &str {
    match word {
        "attribute" => "in",
        "varying" if stage == Stage::Vertex => "out",
        "varying" => "in",
        word => word,
    }
}

/// Replaces `gl_FragColor` and `gl_FragData`; returns the declaration of what stands for them,
/// and the names that need it.
pub(super) fn fragment_output(
    shader: &Shader<'_>,
    edits: &mut Edits,
    problems: &mut Vec<Diagnostic>,
) -> Option<(String, Location)> {
    let mut name = None;
    let mut most = 0;
    for at in shader.words() {
        let word = shader.word(at);
        let token = &shader.raw.tokens[at];
        let many = match word {
            "gl_FragColor" => false,
            "gl_FragData" => true,
            _ => continue,
        };
        let new =
            name.get_or_insert_with(|| shader.unused(if many { "FragData" } else { "FragColor" }));
        edits.replace(token.start..token.end, new.clone());
        if many {
            let index =
                (at + 2 < shader.raw.tokens.len()).then(|| shader.word(at + 2).parse::<u32>());
            match index {
                Some(Ok(index)) => most = most.max(index + 1),
                _ => {
                    let span =
                        crate::Span { file: 0, start: token.start as u32, end: token.end as u32 };
                    let message = "`gl_FragData` is indexed by what is no number";
                    problems.push(
                        Diagnostic::error(Code::NotPortable, span, message)
                            .with_help("write the indices as numbers, or declare the outputs"),
                    );
                }
            }
        }
    }
    let name = name?;
    let dims = if most > 0 { format!("[{most}]") } else { String::new() };
    let text = format!("layout(location = 0) out vec4 {name}{dims};\n");
    Some((text, Location { name, direction: Direction::Out, location: 0 }))
}
