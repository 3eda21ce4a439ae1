//! Inputs and outputs of stages: `attribute`, `varying`, `in` and `out` with locations that both
//! stages share, and `gl_FragColor` as an output.

use std::collections::BTreeMap;
use std::ops::Range;

use rustc_hash::FxHashMap;

use super::edits::Edits;
use super::ported::{Direction, Location};
use super::shader::{Shader, refusal};
use super::uniforms::{number, qualifiers, qualify, set_apart};
use landfall_layout::Diagnostic;
use landfall_layout::shape::{ArrayLen, Type};
use landfall_layout::source::{ReadOptions, Source, Span, Stage};
use landfall_layout::syntax::glsl::ast::{Declaration, Dim, Item, Name, Qualifiers};
use landfall_layout::syntax::parse;

/// An input or output as declared.
#[derive(Clone, Debug)]
pub(super) struct InterfaceDeclaration {
    pub name: String,
    pub direction: Direction,
    pub span: Span,
    /// The number of locations it takes; `None` if unknown.
    slots: Option<u32>,
    explicit: Option<u32>,
    /// Whether it states which part of its location it takes: others may have the rest.
    is_part: bool,
    /// The index of its item, and of its declarator in that.
    item: usize,
    declarator: usize,
}

/// The inputs and outputs of a shader, in source order.
pub(super) fn inputs_and_outputs(
    shader: &Shader<'_>,
    source: &Source,
    stage: Stage,
    read: &ReadOptions,
) -> Vec<InterfaceDeclaration> {
    let mut all = Vec::new();
    let mut types = Vec::new();
    for (item, declared) in shader.items.iter().enumerate() {
        let Some(qualifiers) = qualifiers(declared) else { continue };
        let Some(direction) = direction(shader, qualifiers, stage) else { continue };
        let mut add = |name: &Name<'_>, declarator, ty: String| {
            if !name.text.starts_with("gl_") {
                types.push(ty);
                all.push(InterfaceDeclaration {
                    name: name.text.to_string(),
                    direction,
                    span: name.span,
                    slots: None,
                    explicit: number(shader, qualifiers, "location"),
                    is_part: ["component", "index"]
                        .iter()
                        .any(|key| number(shader, qualifiers, key).is_some()),
                    item,
                    declarator,
                });
            }
        };
        match declared {
            Item::Variables(variables) => {
                for (index, declarator) in variables.names.iter().enumerate() {
                    let dims = declarator.dims.iter().chain(&variables.ty.dims);
                    let ty = variable_type(shader, variables, dims, direction, stage);
                    add(&declarator.name, index, ty);
                }
            }
            Item::Block(block) | Item::Interface(block) => {
                let members = block.members.iter();
                let members = members.map(|m| shader.text_of(&(m.ty.at..m.tokens.end)));
                let ty = format!("struct {{ {} }} X;", members.collect::<String>());
                add(&block.name, 0, ty);
            }
            _ => {}
        }
    }
    for (passed, slots) in all.iter_mut().zip(slots(source, read, &types)) {
        passed.slots = slots;
    }
    all
}

/// The declaration of a uniform `X` of a variable's type, to be measured by the front end.
fn variable_type<'a: 'd, 'd>(
    shader: &Shader<'a>,
    variables: &Declaration<'_>,
    dims: impl Iterator<Item = &'d Dim<'a>>,
    direction: Direction,
    stage: Stage,
) -> String {
    // Each vertex of a patch or primitive has its own value: the outermost dimension is vertices.
    let per_vertex = match (stage, direction) {
        (
            Stage::Geometry | Stage::TessellationControl | Stage::TessellationEvaluation,
            Direction::In,
        )
        | (Stage::TessellationControl, Direction::Out) => {
            !shader.has_word(&variables.qualifiers, "patch")
        }
        _ => false,
    };
    let dims = shader.dims(dims.skip(usize::from(per_vertex)));
    format!("{} X{dims};", shader.type_word(&variables.ty))
}

fn direction(shader: &Shader<'_>, qualifiers: &Qualifiers<'_>, stage: Stage) -> Option<Direction> {
    shader.words_of(qualifiers).into_iter().find_map(|word| match word {
        "attribute" | "in" => Some(Direction::In),
        "out" => Some(Direction::Out),
        "varying" if stage == Stage::Vertex => Some(Direction::Out),
        "varying" => Some(Direction::In),
        _ => None,
    })
}

/// The number of locations of each type, from parsing the shader with a uniform of each appended.
// A type may depend on macros and constants of the text. The front end measures it, as that of a
// uniform which nothing in the text can be called like.
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

/// The locations of a type (GLSL 4.60 §4.4.1): a location holds a vec4; a dvec3 or dvec4 takes
/// two, a matrix as many as its columns.
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

/// Assigns a location to every input and output.
///
/// Variables shared with another stage are ordered by name, together with those of `partner`, so
/// that both stages get the same numbers; vertex attributes and fragment outputs keep source order.
pub(super) fn locate(
    stage: Stage,
    passed: &[InterfaceDeclaration],
    partner: &[InterfaceDeclaration],
    given: &[(String, u32)],
    problems: &mut Vec<Diagnostic>,
) -> Vec<Location> {
    let mut locations = Vec::new();
    for direction in [Direction::In, Direction::Out] {
        let own: Vec<&InterfaceDeclaration> =
            passed.iter().filter(|p| p.direction == direction).collect();
        // The host matches these by number or name; between stages the numbers have to agree.
        let outside = (stage == Stage::Vertex && direction == Direction::In)
            || (stage == Stage::Fragment && direction == Direction::Out);
        let mut all = own.clone();
        if !outside {
            // What one stage writes, the other reads. A name that both have counts as this stage's.
            let theirs = partner.iter().filter(|p| p.direction != direction);
            all.extend(theirs.filter(|p| own.iter().all(|own| own.name != p.name)));
            all.sort_by(|a, b| a.name.cmp(&b.name));
        }
        let numbers = place(&all, given, problems);
        let placed = own.iter().filter_map(|p| Some((numbers.get(p.name.as_str())?, *p)));
        let mut whole: Vec<_> = placed.filter(|(_, passed)| !passed.is_part).collect();
        whole.sort_by_key(|(range, _)| range.start);
        for two in whole.windows(2) {
            let ((first, other), (second, passed)) = (two[0], two[1]);
            if second.start < first.end && passed.name != other.name {
                problems.push(shared(passed, other));
            }
        }
        for passed in own {
            if let Some(range) = numbers.get(passed.name.as_str()) {
                let (name, location) = (passed.name.clone(), range.start);
                locations.push(Location { name, direction, location });
            }
        }
    }
    locations
}

fn place<'p>(
    all: &[&'p InterfaceDeclaration],
    given: &[(String, u32)],
    problems: &mut Vec<Diagnostic>,
) -> BTreeMap<&'p str, Range<u32>> {
    let mut numbers = BTreeMap::new();
    let mut taken = TakenLocations::default();
    let wanted = |passed: &InterfaceDeclaration| {
        let given = given.iter().find(|(name, _)| *name == passed.name).map(|(_, n)| *n);
        given.or(passed.explicit)
    };
    // Locations that are written or asked for are taken first; the others fill what is left.
    for passed in all {
        if let (Some(at), Some(slots)) = (wanted(passed), passed.slots) {
            let range = at..at.saturating_add(slots);
            taken.take(range.clone());
            numbers.insert(passed.name.as_str(), range);
        }
    }
    for passed in all.iter().filter(|passed| wanted(passed).is_none()) {
        let Some(slots) = passed.slots else {
            problems.push(unknown_size(passed));
            continue;
        };
        let at = taken.first_gap(slots);
        let range = at..at.saturating_add(slots);
        taken.take(range.clone());
        numbers.insert(passed.name.as_str(), range);
    }
    numbers
}

/// The locations that are taken, as ranges that neither overlap nor touch: the end of each by its start.
#[derive(Default)]
struct TakenLocations(BTreeMap<u32, u32>);

impl TakenLocations {
    fn take(&mut self, mut range: Range<u32>) {
        let last = range.end;
        while let Some((start, end)) = self.last_from(last).filter(|(_, end)| *end >= range.start) {
            self.0.remove(&start);
            range = range.start.min(start)..range.end.max(end);
        }
        self.0.insert(range.start, range.end);
    }

    fn first_gap(&self, slots: u32) -> u32 {
        let mut at = 0;
        let last = |at: u32| at.saturating_add(slots).saturating_sub(1);
        while let Some((_, end)) = self.last_from(last(at)).filter(|(_, end)| *end > at) {
            at = end;
        }
        at
    }

    /// The last range that starts at a location or before.
    fn last_from(&self, location: u32) -> Option<(u32, u32)> {
        self.0.range(..=location).next_back().map(|(start, end)| (*start, *end))
    }
}

fn unknown_size(passed: &InterfaceDeclaration) -> Diagnostic {
    let message = format!("the number of locations that `{}` takes is unknown", passed.name);
    refusal(passed.span, message).with_help("write its type and size without macros")
}

// GLSL 4.60 §4.4.1: two inputs or outputs may have a location only by components or indices that differ.
// What OpenGL lets attributes of vertices share beyond that, Vulkan does not.
fn shared(passed: &InterfaceDeclaration, other: &InterfaceDeclaration) -> Diagnostic {
    let message = format!("`{}` has a location of `{}`", passed.name, other.name);
    refusal(passed.span, message).with_help("declare it apart, with a location of its own")
}

/// Writes the locations into the text, and replaces `attribute` and `varying`.
pub(super) fn write(
    shader: &Shader<'_>,
    stage: Stage,
    passed: &[InterfaceDeclaration],
    locations: &[Location],
    edits: &mut Edits,
) {
    let locations: FxHashMap<_, _> =
        locations.iter().map(|l| ((l.name.as_str(), l.direction), l.location)).collect();
    let number = |passed: &InterfaceDeclaration| {
        let at = *locations.get(&(passed.name.as_str(), passed.direction))?;
        // Only the first declarator has the location that the declaration states.
        let is_written = passed.declarator == 0 && passed.explicit == Some(at);
        (!is_written).then(|| format!("location = {at}"))
    };
    for passed in passed {
        let Some(location) = number(passed) else { continue };
        let (location, drop) = ([location], ["location"]);
        match &shader.items[passed.item] {
            Item::Block(block) | Item::Interface(block) => {
                let start = block.tokens.start;
                qualify(shader, &block.qualifiers, start, &location, &drop, edits);
            }
            Item::Variables(variables) if passed.declarator == 0 => {
                let start = variables.tokens.start;
                qualify(shader, &variables.qualifiers, start, &location, &drop, edits);
            }
            Item::Variables(variables) => {
                // `in vec3 a, b;`: each needs a declaration for its own location.
                let declarator = &variables.names[passed.declarator];
                let words = shader.words_of(&variables.qualifiers).into_iter();
                let words: Vec<&str> = words.map(|word| modern(word, stage)).collect();
                set_apart(shader, variables, declarator, &words, &location, &drop, edits);
            }
            _ => {}
        }
    }
    for at in shader.words() {
        let word = shader.word(at);
        if modern(word, stage) != word {
            edits.replace(shader.raw_bytes(at), modern(word, stage));
        }
    }
}

fn modern(word: &str, stage: Stage) -> &str {
    // GLSL 1.20 §4.3: storage qualifiers that GLSL 1.30 replaced.
    match word {
        "attribute" => "in",
        "varying" if stage == Stage::Vertex => "out",
        "varying" => "in",
        word => word,
    }
}

/// Replaces `gl_FragColor` and `gl_FragData`; returns the declaration of the output that replaces
/// them, and its location.
pub(super) fn fragment_output(
    shader: &Shader<'_>,
    edits: &mut Edits,
    problems: &mut Vec<Diagnostic>,
) -> Option<(String, Location)> {
    let mut name = None;
    let mut most = 0;
    for at in shader.words() {
        let many = match shader.word(at) {
            "gl_FragColor" => false,
            "gl_FragData" => true,
            _ => continue,
        };
        let new =
            name.get_or_insert_with(|| shader.unused(if many { "FragData" } else { "FragColor" }));
        edits.replace(shader.raw_bytes(at), new.clone());
        if many {
            // The word behind the bracket.
            let index = shader.word(at + 2).parse::<u32>().ok();
            match index.and_then(|index| index.checked_add(1)) {
                Some(count) => most = most.max(count),
                None => {
                    let message = "`gl_FragData` is not indexed by a literal";
                    let problem = refusal(shader.raw_span(at), message);
                    problems.push(problem.with_help("use literal indices, or declare the outputs"));
                }
            }
        }
    }
    let name = name?;
    // Without an index only `gl_FragColor` was used, which is no array.
    let dims = if most > 0 { format!("[{most}]") } else { String::new() };
    let text = format!("layout(location = 0) out vec4 {name}{dims};\n");
    Some((text, Location { name, direction: Direction::Out, location: 0 }))
}
