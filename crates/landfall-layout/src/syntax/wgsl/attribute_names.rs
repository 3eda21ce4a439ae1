//! Which attributes (§12) a text may have at which place: those of the specification, of naga 30 and
//! of Tint. Compilers refuse every other, so none is passed over.

use super::lexer::{Kind, WgslLexer, WgslToken};
use super::outline::{Class, Outline, OutlineItem};
use super::report::{self, Refused, Reports};
use crate::diagnostic::{Code, Diagnostic};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AttributeTarget {
    Member,
    Variable,
    Override,
    Function,
    Parameter,
    ReturnType,
    Statement,
    /// A declaration or directive that no attribute may stand before.
    Other(&'static str),
}

impl AttributeTarget {
    fn described(self) -> &'static str {
        match self {
            AttributeTarget::Member => "a member of a structure",
            AttributeTarget::Variable => "a variable",
            AttributeTarget::Override => "an override",
            AttributeTarget::Function => "a function",
            AttributeTarget::Parameter => "a parameter",
            AttributeTarget::ReturnType => "a return type",
            AttributeTarget::Statement => "a statement",
            AttributeTarget::Other(what) => what,
        }
    }

    fn from_class(class: Class) -> AttributeTarget {
        match class {
            Class::Var => AttributeTarget::Variable,
            Class::Override => AttributeTarget::Override,
            Class::Fn => AttributeTarget::Function,
            Class::Struct | Class::Alias | Class::Const => AttributeTarget::Other(class.name()),
        }
    }
}

/// An attribute: its name, where it may stand, and how many arguments it has.
struct KnownAttribute {
    name: &'static str,
    places: &'static [AttributeTarget],
    arguments: (u32, u32),
}

const MEMBERS: &[AttributeTarget] = &[AttributeTarget::Member];
const VARIABLES: &[AttributeTarget] = &[AttributeTarget::Variable];
const OVERRIDES: &[AttributeTarget] = &[AttributeTarget::Override];
const FUNCTIONS: &[AttributeTarget] = &[AttributeTarget::Function];
/// Where the inputs and outputs of entry points are declared.
const STAGE_VALUES: &[AttributeTarget] =
    &[AttributeTarget::Member, AttributeTarget::Parameter, AttributeTarget::ReturnType];
const DIAGNOSED: &[AttributeTarget] = &[AttributeTarget::Function, AttributeTarget::Statement];

const fn known(
    name: &'static str,
    places: &'static [AttributeTarget],
    arguments: (u32, u32),
) -> KnownAttribute {
    KnownAttribute { name, places, arguments }
}

const ATTRIBUTES: &[KnownAttribute] = &[
    // §12.
    known("align", MEMBERS, (1, 1)),
    known("size", MEMBERS, (1, 1)),
    known("binding", VARIABLES, (1, 1)),
    known("group", VARIABLES, (1, 1)),
    known("id", OVERRIDES, (1, 1)),
    known("builtin", STAGE_VALUES, (1, 1)),
    known("location", STAGE_VALUES, (1, 1)),
    known("interpolate", STAGE_VALUES, (1, 2)),
    known("invariant", STAGE_VALUES, (0, 0)),
    known("blend_src", STAGE_VALUES, (1, 1)),
    known("diagnostic", DIAGNOSED, (2, 2)),
    known("must_use", FUNCTIONS, (0, 0)),
    known("vertex", FUNCTIONS, (0, 0)),
    known("fragment", FUNCTIONS, (0, 0)),
    known("compute", FUNCTIONS, (0, 0)),
    known("workgroup_size", FUNCTIONS, (1, 3)),
    // Of Tint.
    known("color", STAGE_VALUES, (1, 1)),
    known("input_attachment_index", VARIABLES, (1, 1)),
    known("subgroup_size", FUNCTIONS, (1, 1)),
    // Of naga.
    known("per_primitive", STAGE_VALUES, (0, 0)),
    known("coherent", VARIABLES, (0, 0)),
    known("volatile", VARIABLES, (0, 0)),
    known("early_depth_test", FUNCTIONS, (1, 1)),
    known("task", FUNCTIONS, (0, 0)),
    known("mesh", FUNCTIONS, (1, 1)),
    known("payload", FUNCTIONS, (1, 1)),
    known("ray_generation", FUNCTIONS, (0, 0)),
    known("any_hit", FUNCTIONS, (0, 0)),
    known("closest_hit", FUNCTIONS, (0, 0)),
    known("miss", FUNCTIONS, (0, 0)),
    known("incoming_payload", FUNCTIONS, (1, 1)),
];

/// The attributes whose arguments are evaluated, which reports errors in them.
const EVALUATED: [&str; 5] = ["align", "size", "group", "binding", "id"];

/// The attributes that naga takes more than once, and the rules of diagnostics, each a filter.
const REPEATABLE: [&str; 3] = ["diagnostic", "coherent", "volatile"];

/// The stages, of which a function has one.
const STAGES: [&str; 9] = [
    "vertex",
    "fragment",
    "compute",
    "task",
    "mesh",
    "ray_generation",
    "any_hit",
    "closest_hit",
    "miss",
];

/// Whether a function of the module has the attribute of a stage.
pub(super) fn has_entry_point(text: &str, outline: &Outline<'_>) -> bool {
    let has_stage = |item: &OutlineItem<'_>| {
        let mut lexer = WgslLexer::new(text, item.start);
        while let Some(token) = lexer.next_before(item.rest) {
            let attribute = lexer.peek();
            if token.is(b'@') && STAGES.contains(&lexer.text_of(attribute)) {
                return true;
            }
        }
        false
    };
    outline.items.iter().filter(|item| item.class == Class::Fn).any(has_stage)
}

/// Reports the attributes of a text's declarations that do not belong there.
pub(super) fn check(text: &str, outline: &Outline<'_>, reports: &mut Reports) {
    for &(start, end, what) in &outline.without_attributes {
        let mut lexer = WgslLexer::new(text, start);
        let _ = before(&mut lexer, AttributeTarget::Other(what), end, reports);
    }
    for item in &outline.items {
        let declared = &text.as_bytes()[item.start as usize..item.end as usize];
        if memchr::memchr(b'@', declared).is_some() {
            // A text of another tool is refused as a whole.
            let _ = of_item(text, item, reports);
        }
        if reports.saw_preprocessor {
            return;
        }
    }
}

// A scan by brackets: in a struct all attributes are of members. In a function those before the `)`
// that closes the parameters are of parameters, up to the `{` of the result, then of statements.
fn of_item(text: &str, item: &OutlineItem<'_>, reports: &mut Reports) -> Result<(), Refused> {
    let mut lexer = WgslLexer::new(text, item.start);
    before(&mut lexer, AttributeTarget::from_class(item.class), item.end, reports)?;
    lexer.jump(item.rest);
    // The place of an attribute that comes next, and the nesting of `(` in a function's head.
    let (mut place, mut depth) = match item.class {
        Class::Struct => (AttributeTarget::Member, 0u32),
        Class::Fn => (AttributeTarget::Parameter, 0),
        Class::Alias | Class::Const | Class::Override | Class::Var => return Ok(()),
    };
    loop {
        let token = lexer.peek();
        match token.kind {
            Kind::End => return Ok(()),
            _ if token.start >= item.end => return Ok(()),
            Kind::Sign(b'@') => {
                before(&mut lexer, place, item.end, reports)?;
                continue;
            }
            Kind::Sign(b'(') => depth += 1,
            Kind::Sign(b')') => {
                depth = depth.saturating_sub(1);
                if depth == 0 && place == AttributeTarget::Parameter {
                    place = AttributeTarget::ReturnType;
                }
            }
            Kind::Sign(b'{') if place == AttributeTarget::ReturnType => {
                place = AttributeTarget::Statement
            }
            Kind::Sign(_) | Kind::Word | Kind::Number => {}
        }
        lexer.next();
    }
}

/// Reads the attributes before what is declared.
fn before(
    lexer: &mut WgslLexer<'_>,
    place: AttributeTarget,
    end: u32,
    reports: &mut Reports,
) -> Result<(), Refused> {
    let mut seen: Vec<WgslToken> = Vec::new();
    while lexer.peek().start < end && lexer.take(b'@') {
        let name = lexer.next();
        let word = lexer.text_of(name);
        // What is no name is reported where the declaration is parsed.
        if name.kind != Kind::Word {
            return Ok(());
        }
        let arguments = arguments(lexer);
        // All stages count as one attribute here, so that `@vertex @fragment` is a repetition.
        let kind = |word| if STAGES.contains(&word) { "vertex" } else { word };
        let first = seen.iter().find(|first| kind(lexer.text_of(**first)) == kind(word));
        let found = match ATTRIBUTES.iter().find(|known| known.name == word) {
            None => Some(unknown(word, name, place)),
            Some(known) if !known.places.contains(&place) => Some(misplaced(known, name, place)),
            Some(known) => wrong_count(known, name, arguments).or_else(|| {
                let first = first.filter(|_| !REPEATABLE.contains(&word))?;
                Some(repeated(lexer, name, *first))
            }),
        };
        if let Some(found) = found {
            reports.push(found);
        }
        seen.push(name);
    }
    Ok(())
}

/// Reads `(…)` after a name; returns the number of arguments, if it can be told.
fn arguments(lexer: &mut WgslLexer<'_>) -> AttributeArguments {
    if !lexer.peek().is(b'(') {
        return AttributeArguments::None;
    }
    let (mut depth, mut count, mut is_begun) = (0u32, 0, false);
    let mut has_template = false;
    loop {
        let token = lexer.next();
        match token.kind {
            Kind::Sign(b'(' | b'[') => depth += 1,
            Kind::Sign(b')' | b']') if depth <= 1 => break,
            Kind::Sign(b')' | b']') => depth -= 1,
            // The commas of a template list are not told from those between arguments.
            Kind::Sign(b'<') => has_template = true,
            Kind::Sign(b',') if depth == 1 => {
                count += u32::from(is_begun);
                is_begun = false;
                continue;
            }
            Kind::Sign(b';' | b'{' | b'}') | Kind::End => return AttributeArguments::Unclear,
            Kind::Word | Kind::Number | Kind::Sign(_) => {}
        }
        is_begun |= depth > 1 || !token.is(b'(');
    }
    match has_template {
        true => AttributeArguments::Unclear,
        false => AttributeArguments::Given(count + u32::from(is_begun)),
    }
}

#[derive(Clone, Copy)]
enum AttributeArguments {
    None,
    Given(u32),
    Unclear,
}

fn unknown(word: &str, name: WgslToken, place: AttributeTarget) -> Diagnostic {
    let message = format!("unknown attribute `{word}`");
    let error = Diagnostic::error(Code::UnknownAttribute, report::span(name), message);
    // Attributes of WGSL before 2022.
    match word {
        "stage" => return error.with_help("write `@vertex`, `@fragment` or `@compute`"),
        "block" => return error.with_help("remove it: `var<uniform>` says it"),
        "stride" => return error.with_help("remove it: the element's type sets the stride"),
        _ => {}
    }
    let here = ATTRIBUTES.iter().filter(|known| known.places.contains(&place));
    report::misspelt(error, word, here.map(|known| known.name))
}

fn misplaced(known: &KnownAttribute, name: WgslToken, place: AttributeTarget) -> Diagnostic {
    let belongs: Vec<&str> = known.places.iter().map(|place| place.described()).collect();
    let (what, here) = (belongs.join(" or "), place.described());
    let message = format!("`@{}` is not for {here}", known.name);
    Diagnostic::error(Code::InvalidAttribute, report::span(name), message)
        .with_note(format!("it is an attribute of {what}"))
        .with_help("remove it, or move it to where it belongs")
}

fn wrong_count(
    known: &KnownAttribute,
    name: WgslToken,
    arguments: AttributeArguments,
) -> Option<Diagnostic> {
    let (least, most) = known.arguments;
    let count = match arguments {
        AttributeArguments::None => 0,
        // No `()` either.
        AttributeArguments::Given(count) if most > 0 && EVALUATED.contains(&known.name) => {
            count.clamp(least, most)
        }
        AttributeArguments::Given(count) if most == 0 => count.max(1),
        AttributeArguments::Given(count) => count,
        AttributeArguments::Unclear => return None,
    };
    if (least..=most).contains(&count) {
        return None;
    }
    let name_text = known.name;
    let message = match (least, most) {
        (_, 0) => format!("`@{name_text}` takes no arguments"),
        (1, 1) => format!("`@{name_text}` takes one argument, found {count}"),
        (least, most) if least == most => {
            format!("`@{name_text}` takes {least} arguments, found {count}")
        }
        (least, most) => format!("`@{name_text}` takes {least} to {most} arguments, found {count}"),
    };
    Some(Diagnostic::error(Code::InvalidAttribute, report::span(name), message))
}

fn repeated(lexer: &WgslLexer<'_>, name: WgslToken, first: WgslToken) -> Diagnostic {
    let (again, earlier) = (lexer.text_of(name), lexer.text_of(first));
    let message = match again == earlier {
        true => format!("`@{again}` is given twice"),
        false => format!("a function is of one stage: `@{earlier}` and `@{again}` are two"),
    };
    Diagnostic::error(Code::InvalidAttribute, report::span(name), message)
        .with_label(report::span(first), "first given here")
        .with_help("remove one of them")
}
