//! Output of `explain`: an [`Explanation`], or the owner of a byte, as text and as JSON.

use super::SCHEMA_VERSION;
use super::json::{Tool, to_lines};
use super::paint::{FAINT, HEADING, PLAIN, Paint, STRONG, TYPE};
use super::{columns, phrases};
use crate::layout::BlockLayout;
use crate::layout::byte::ByteOwner;
use crate::layout::explain::{Explanation, Step, StepKind};
use crate::layout::padding::{PaddingKind, PaddingOwner};
use crate::shader::ShaderLayout;
use crate::shape::Rules;
use crate::source::{Language, Target};

/// The answer of one block to a query.
///
/// Exhaustive: a query is about a member or a byte.
#[derive(Clone, Debug)]
pub enum Answer {
    /// The steps to a path.
    Path(Explanation),
    /// The owner of the byte at an offset.
    Byte(u64, ByteOwner),
}

/// Renders an answer as text.
pub fn text(block: &BlockLayout, language: Language, answer: &Answer, paint: Paint) -> String {
    let declared = match block.rules_declared {
        true => "",
        false => " (not declared: the driver's offsets may differ)",
    };
    let rules = format!("{}{declared}", block.rules.name());
    let mut text =
        columns::heading(&[(HEADING, phrases::block_name(block)), (PLAIN, rules)], paint);
    match answer {
        Answer::Path(explanation) => path_text(explanation, block.rules, paint, &mut text),
        Answer::Byte(byte, owner) => {
            let lines =
                columns::wrapped(&byte_text(*byte, owner, language, paint), columns::WIDTH - 4);
            text.push_str(&format!("\n  {}\n", lines.join("\n    ")));
        }
    }
    text
}

fn path_text(explanation: &Explanation, rules: Rules, paint: Paint, text: &mut String) {
    for step in &explanation.steps {
        let (why, cited) = reason(&step.kind, step.adds, rules);
        text.push_str(&format!(
            "\n  {}  {}\n",
            paint.text(STRONG, &step.path),
            paint.text(TYPE, &step.ty)
        ));
        for line in cited {
            text.push_str(&format!("      {}\n", paint.text(FAINT, &line)));
        }
        for line in why {
            text.push_str(&format!("      {line}\n"));
        }
        text.push_str(&format!("      {}\n", sum(step)));
    }
    text.push_str(&format!(
        "\n  {}: {}\n",
        paint.text(STRONG, &explanation.path),
        range(explanation)
    ));
}

/// The sum of a step: `144 + 16 = 160`.
fn sum(step: &Step) -> String {
    format!("{} + {} = {}", step.base, step.adds, step.base + step.adds)
}

fn range(explanation: &Explanation) -> String {
    let start = explanation.offset;
    let mut text = match explanation.size {
        Some(0) => format!("no bytes at {start}"),
        Some(1) => format!("byte {start}, 1 byte"),
        Some(size) => format!("bytes {start} to {}, {}", start + size - 1, phrases::bytes(size)),
        None => format!("from byte {start} to the end of the buffer"),
    };
    let strided: Vec<String> = explanation.steps.iter().filter_map(every_element).collect();
    // `[]` in the path is every element: the offset is that of the first, and each such step says
    // how far the next ones lie.
    if !strided.is_empty() {
        text.push_str(&format!(", then every {} bytes", strided.join(" and every ")));
    }
    text
}

fn every_element(step: &Step) -> Option<String> {
    match &step.kind {
        StepKind::Element { index: None, stride, .. } => Some(stride.to_string()),
        StepKind::Element { .. }
        | StepKind::Member { .. }
        | StepKind::Column { .. }
        | StepKind::ColumnAcrossRows { .. }
        | StepKind::Component { .. } => None,
    }
}

/// The explanation of a step that adds that many bytes, and the rules it cites.
#[doc(hidden)]
pub fn reason(kind: &StepKind, adds: u64, rules: Rules) -> (Vec<String>, Vec<String>) {
    match kind {
        StepKind::Member {
            rule,
            own_align,
            align,
            after,
            previous_end,
            written,
            size,
            own_size,
        } => {
            let cited = vec![format!("{}: {}", rule.cite(rules), rule.text(rules))];
            // The steps of a SPIR-V module are its numbers: no rule has led to them.
            if let Rules::Explicit(_) = rules {
                return (vec![format!("the module gives it Offset {adds}")], cited);
            }
            // The three numbers a member's offset follows from: its alignment, the end of what lies
            // before it, and what the shader writes. Of a written offset the others explain
            // nothing.
            let mut why = vec![match align == own_align {
                true => format!("alignment {align}"),
                false => format!("alignment {own_align}, raised to {align} in the shader"),
            }];
            why.push(match (after, written) {
                (_, true) => format!("the shader puts it at offset {}", adds),
                (None, false) => "the first member: starts at 0".to_string(),
                (Some(after), false) if *previous_end == adds => {
                    format!("`{after}` ends at {previous_end}, a multiple of {align}")
                }
                (Some(after), false) => {
                    format!("`{after}` ends at {previous_end}, rounded up to {align}: {}", adds)
                }
            });
            // Set only where `@size` makes the member longer than its type.
            if let (Some(own), Some(size)) = (own_size, size) {
                why.push(format!("size {own}, raised to {size} in the shader"));
            }
            (why, cited)
        }
        StepKind::Element { index, len, stride, element_size, align, rule } => {
            let cited = vec![format!("{}: {}", rule.cite(rules), rule.text(rules))];
            let mut why = vec![match element_size == stride {
                // A module's stride need not be a multiple of any alignment, so that nothing is
                // said of rounding.
                _ if matches!(rules, Rules::Explicit(_)) => {
                    format!(
                        "the module gives it ArrayStride {stride}: an element takes {}",
                        phrases::bytes(*element_size)
                    )
                }
                true => format!("stride {stride}: an element's size, a multiple of {align}"),
                false => format!(
                    "stride {stride}: an element's {}, rounded up to {align}",
                    phrases::bytes(*element_size)
                ),
            }];
            let elements = len.map_or_else(|| "any number of".to_string(), phrases::number);
            why.push(match index {
                Some(index) => format!("{index} × {stride} = {}", adds),
                None => format!("every one of {elements} elements, the first shown"),
            });
            (why, cited)
        }
        StepKind::Column { index, stride, column_size } => {
            // No rule is cited: the stride is that of an array of columns, which the member's own
            // step has placed.
            let why = vec![
                format!("matrix stride {stride}: columns of {column_size} bytes"),
                format!("{index} × {stride} = {}", adds),
            ];
            (why, vec![])
        }
        StepKind::ColumnAcrossRows { index, width, stride } => {
            let why = vec![
                format!("stored by rows: a column's components lie {stride} bytes apart"),
                format!("{index} × {width} = {}", adds),
            ];
            (why, vec![])
        }
        StepKind::Component { index, stride } => {
            (vec![format!("component {index}: {index} × {stride} = {}", adds)], vec![])
        }
    }
}

fn byte_text(byte: u64, owner: &ByteOwner, language: Language, paint: Paint) -> String {
    match owner {
        ByteOwner::Component {
            leaf, ty, leaf_offset, leaf_size, path, size, byte: nth, ..
        } => {
            format!(
                "byte {byte} is byte {nth} of {size} of {} ({} `{leaf}`, bytes {leaf_offset} to {})",
                paint.text(STRONG, path),
                paint.text(TYPE, &ty.spelled(language).to_string()),
                leaf_offset + leaf_size - 1
            )
        }
        ByteOwner::Padding { kind, owner, path, offset, size, after, before } => {
            let of = match path.is_empty() {
                true => format!("the {}", owner.noun()),
                false => format!("{} {}", owner.noun(), paint.text(STRONG, path)),
            };
            let place = match kind {
                PaddingKind::Hole => "a hole in",
                PaddingKind::Tail => "tail padding of",
            };
            let mut text = format!("byte {byte} is padding: {place} {of}");
            if let Some(after) = after {
                text.push_str(&format!(", after `{after}`"));
            }
            if let Some(before) = before {
                text.push_str(&format!(", before `{before}`"));
            }
            // `size` is not zero: the byte asked for lies in it.
            let end = offset + size - 1;
            text.push_str(&format!(" (bytes {offset} to {end})"));
            text
        }
        ByteOwner::Beyond { size } => {
            format!("byte {byte} lies past the end: the block has {}", phrases::bytes(*size))
        }
        ByteOwner::Loose => {
            "loose uniforms have no bytes: --gather lays them out as a block".to_string()
        }
    }
}

/// The schema of [`EXPLAIN_SCHEMA`](super::EXPLAIN_SCHEMA).
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    crate::schema::text::<ExplainDocument<'_>>("landfall explain --format json")
}

/// Renders all answers of one shader as a JSON document.
pub fn json(shader: &ShaderLayout, answers: &[(&BlockLayout, Answer)]) -> String {
    let document = ExplainDocument {
        schema_version: SCHEMA_VERSION,
        tool: Tool::LANDFALL,
        path: &shader.path,
        assumed_target: shader.assumed_target,
        answers: answers
            .iter()
            .map(|(block, answer)| answer_object(block, answer, shader.language))
            .collect(),
    };
    to_lines(&document) + "\n"
}

/// The steps that place a path, or the owner of a byte, in every block that has it. Offsets are
/// from the start of the block.
#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ExplainDocument<'a> {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA_VERSION)))]
    schema_version: u32,
    tool: Tool,
    /// The shader's path.
    path: &'a str,
    /// The API assumed for a shader that tests `VULKAN` without declaring its API, if its blocks
    /// depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    answers: Vec<AnswerObject<'a>>,
}

/// The steps to a path.
#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct AnswerObject<'a> {
    block: &'a str,
    instance: Option<&'a str>,
    #[cfg_attr(feature = "schema", schemars(extend("enum" = Rules::ALL.map(Rules::name))))]
    rules: &'static str,
    rules_declared: bool,
    #[serde(flatten)]
    what: AnswerKind<'a>,
}

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case")]
enum AnswerKind<'a> {
    /// The steps to a path.
    Path {
        path: &'a str,
        #[serde(rename = "type")]
        ty: &'a str,
        offset: u64,
        /// The size in bytes; null if runtime-sized.
        size: Option<u64>,
        steps: Vec<ExplainStepObject<'a>>,
    },
    /// The answer for a byte of a component.
    Component {
        byte: u64,
        /// The path of the component.
        path: &'a str,
        /// The path of the scalar, vector or matrix that contains it.
        leaf: &'a str,
        /// The leaf's type.
        #[serde(rename = "type")]
        ty: String,
        /// The first byte of the component.
        offset: u64,
        /// The size of the component in bytes.
        size: u64,
        /// The index of the byte in the component, from 0.
        nth_byte: u64,
    },
    /// The answer for a byte of padding.
    Padding {
        byte: u64,
        padding: PaddingKind,
        owner: PaddingOwner,
        /// The path of the owner; empty for the block.
        path: &'a str,
        /// The first byte of the padding.
        offset: u64,
        size: u64,
        after: Option<&'a str>,
        before: Option<&'a str>,
    },
    /// The answer for a byte past the end.
    Beyond { byte: u64, block_size: u64 },
    /// The answer for loose uniforms, which have no bytes.
    Loose { byte: u64 },
}

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ExplainStepObject<'a> {
    path: &'a str,
    #[serde(rename = "type")]
    ty: &'a str,
    /// The rule cited; null where arithmetic alone decides.
    rule: Option<String>,
    /// The offset from the start of the block before this step.
    base: u64,
    adds: u64,
    /// base + adds.
    offset: u64,
    reason: Vec<String>,
}

fn answer_object<'a>(
    block: &'a BlockLayout,
    answer: &'a Answer,
    language: Language,
) -> AnswerObject<'a> {
    let what = match answer {
        Answer::Path(found) => AnswerKind::Path {
            path: &found.path,
            ty: &found.ty,
            offset: found.offset,
            size: found.size,
            steps: found.steps.iter().map(|step| step_object(step, block.rules)).collect(),
        },
        Answer::Byte(byte, owner) => match owner {
            ByteOwner::Component { leaf, ty, path, offset, size, byte: nth, .. } => {
                AnswerKind::Component {
                    byte: *byte,
                    path,
                    leaf,
                    ty: ty.spelled(language).to_string(),
                    offset: *offset,
                    size: *size,
                    nth_byte: *nth,
                }
            }
            ByteOwner::Padding { kind, owner, path, offset, size, after, before } => {
                AnswerKind::Padding {
                    byte: *byte,
                    padding: *kind,
                    owner: *owner,
                    path,
                    offset: *offset,
                    size: *size,
                    after: after.as_deref(),
                    before: before.as_deref(),
                }
            }
            ByteOwner::Beyond { size } => AnswerKind::Beyond { byte: *byte, block_size: *size },
            ByteOwner::Loose => AnswerKind::Loose { byte: *byte },
        },
    };
    AnswerObject {
        block: &block.name,
        instance: block.instance.as_deref(),
        rules: block.rules.name(),
        rules_declared: block.rules_declared,
        what,
    }
}

fn step_object(step: &Step, rules: Rules) -> ExplainStepObject<'_> {
    let rule = match &step.kind {
        StepKind::Member { rule, .. } | StepKind::Element { rule, .. } => Some(rule.cite(rules)),
        StepKind::Column { .. }
        | StepKind::ColumnAcrossRows { .. }
        | StepKind::Component { .. } => None,
    };
    ExplainStepObject {
        path: &step.path,
        ty: &step.ty,
        rule,
        base: step.base,
        adds: step.adds,
        offset: step.base + step.adds,
        reason: reason(&step.kind, step.adds, rules).0,
    }
}
