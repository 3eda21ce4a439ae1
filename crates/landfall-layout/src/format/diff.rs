//! Output of [`diff`](crate::diff::diff): as text, as JSON, and as Markdown for a comment on a
//! pull request.
//!
//! `beside` prints the old and the new block side by side.

mod beside;

use std::fmt::Write as _;

use serde::Serialize;
use unicode_width::UnicodeWidthStr;

use super::columns::{GAP, WIDTH, wrapped};
use super::json::{Tool, to_lines};
use super::paint::{CAUTION, FAINT, STRONG};
use super::{Paint, SCHEMA_VERSION, phrases};
use crate::ShaderLayout;
use crate::diff::{BlockDiff, Change, Class, Kind, Policy};
use crate::layout::{BlockLayout, targets};
use crate::source::Target;
use crate::text::escape::{markdown_code, markdown_name, name};

pub use beside::{Width, side_by_side};

/// The JSON Schema (draft 2020-12) of the JSON output of `diff`.
pub const DIFF_SCHEMA: &str = include_str!("../../schema/diff.json");

/// The most leaves times changes of a block for which Rust names are written: each name depends
/// on those of all members before it, and is computed for each change.
const MAX_NAMED: usize = 1 << 17;

/// Two layouts of one shader, and their differences.
#[derive(Clone, Copy, Debug)]
pub struct Compared<'a> {
    /// The shader's name in the report.
    pub name: &'a str,
    /// The macros of the variant that is compared; `None` for the shader without them.
    pub variant: Option<&'a str>,
    /// The old layout.
    pub old: &'a ShaderLayout,
    /// The new layout.
    pub new: &'a ShaderLayout,
    /// The changed blocks; may be empty.
    pub blocks: &'a [BlockDiff],
    /// The policy that applies to the shader, if any.
    pub policy: Option<Policy>,
    /// The field of a block's Rust mirror at a path, if it has one.
    pub rust_field: fn(&BlockLayout, &str) -> Option<String>,
}

impl<'a> Compared<'a> {
    /// Whether the policy allows a change: `allowed` or `forbidden`; `None` without a policy.
    pub fn verdict(&self, change: &Change) -> Option<&'static str> {
        Some(if self.policy?.forbids(change) { "forbidden" } else { "allowed" })
    }

    fn was(&self, diff: &BlockDiff) -> Option<&'a BlockLayout> {
        diff.old.map(|at| &self.old.blocks[at])
    }

    fn is(&self, diff: &BlockDiff) -> Option<&'a BlockLayout> {
        diff.new.map(|at| &self.new.blocks[at])
    }

    /// The Rust field of a change: the old mirror's if it has one, else the new mirror's.
    fn field(&self, diff: &BlockDiff, change: &Change) -> Option<String> {
        let named = |block: Option<&BlockLayout>| {
            let block =
                // A name needs those of all members before it: quadratic in blocks that are made
                // for it.
                block.filter(|block| block.leaves.len() * diff.changes.len() <= MAX_NAMED)?;
            (self.rust_field)(block, &change.path)
        };
        named(self.was(diff)).or_else(|| named(self.is(diff)))
    }

    /// The note on an API assumed for either side.
    fn assumed(&self) -> Option<String> {
        targets::note(self.new.assumed_target.or(self.old.assumed_target))
    }

    /// Both listings of a block, side by side.
    pub fn side_by_side(&self, diff: &BlockDiff, width: Width, paint: Paint) -> String {
        let old = self.was(diff).map(|block| (block, self.old.language));
        let new = self.is(diff).map(|block| (block, self.new.language));
        side_by_side(old, new, width, paint)
    }
}

/// The changes of one shader as text; empty when there are none.
pub fn human(compared: &Compared<'_>, width: Width, paint: Paint) -> String {
    let mut text = String::new();
    for diff in compared.blocks {
        if !text.is_empty() {
            text.push('\n');
        }
        let mut head = format!("{}: {}", name(compared.name), diff.name);
        if let Some(variant) = compared.variant {
            let _ = write!(head, " under `{}`", name(variant));
        }
        let head = paint.text(STRONG, &head);
        let _ = writeln!(text, "{head}: {}", class(diff.class(), paint).trim_end());
        if let Some(note) = compared.assumed() {
            let _ = writeln!(text, "  {}", paint.text(CAUTION, &note));
        }
        for change in &diff.changes {
            let room = WIDTH - CHANGES;
            let lines = wrapped(&change.message, room);
            let indent = " ".repeat(CHANGES);
            let message = lines.join(&format!("\n{indent}"));
            let _ = write!(text, "  {} {message}", class(change.class, paint));
            match compared.field(diff, change) {
                Some(field) if !change.path.is_empty() => {
                    let field = format!("[{field}]");
                    let last = lines.last().map_or(0, |line| line.width());
                    // The field stands behind the last line of the message, or in a line of its own
                    // if it does not fit there.
                    let gap = match last + GAP.len() + field.width() > room {
                        true => format!("\n{indent}"),
                        false => GAP.to_string(),
                    };
                    let _ = writeln!(text, "{gap}{}", paint.text(FAINT, &field));
                }
                Some(_) | None => text.push('\n'),
            }
        }
        text.push('\n');
        // Two columns are taken by the indentation.
        for line in compared.side_by_side(diff, width.less(2), paint).lines() {
            let line = format!("  {line}");
            text.push_str(line.trim_end());
            text.push('\n');
        }
    }
    text
}

/// The column at which the message of a change begins.
const CHANGES: usize = 2 + "compatible".len() + 1;

/// The name of a class, padded to one width.
fn class(class: Class, paint: Paint) -> String {
    let style = match class {
        Class::Breaking => super::paint::REMOVED,
        Class::Compatible => CAUTION,
        Class::Cosmetic => FAINT,
    };
    let room = " ".repeat("compatible".len() - class.name().len());
    paint.text(style, class.name()) + &room
}

/// The last line: the number of changed blocks, by class.
pub fn summary(all: &[Compared<'_>]) -> String {
    let of = |class: Class| {
        all.iter().flat_map(|one| one.blocks).filter(|diff| diff.class() == class).count()
    };
    let parts: Vec<String> = [Class::Breaking, Class::Compatible, Class::Cosmetic]
        .into_iter()
        .filter(|class| of(*class) > 0)
        .map(|class| format!("{} {}", of(class), class.name()))
        .collect();
    let changed = match all.iter().map(|one| one.blocks.len()).sum::<usize>() {
        0 => "no layout changed\n".to_string(),
        1 => format!("1 block changed: {}\n", parts.join(", ")),
        n => format!("{} blocks changed: {}\n", phrases::number(n as u64), parts.join(", ")),
    };
    changed + &judgements(all)
}

/// The number of changes that policies forbid, a line for each policy.
fn judgements(all: &[Compared<'_>]) -> String {
    let mut text = String::new();
    for policy in Policy::ALL {
        let under = all.iter().filter(|one| one.policy == Some(policy));
        let forbidden = under.map(|one| policy.forbidden(one.blocks).count()).sum::<usize>();
        if forbidden > 0 {
            let changes = phrases::counted(forbidden, "change");
            let _ = writeln!(text, "policy `{}` forbids {changes}", policy.name());
        }
    }
    text
}

/// All changes as Markdown.
pub fn markdown(all: &[Compared<'_>]) -> String {
    let mut text = format!("### Layouts: {}", summary(all));
    for compared in all {
        for diff in compared.blocks {
            let _ = writeln!(
                text,
                "\n#### {} {}{}: {}\n",
                markdown_name(compared.name),
                markdown_code(&diff.name),
                compared.variant.map_or(String::new(), |v| format!(" under {}", markdown_code(v))),
                diff.class().name(),
            );
            if let Some(note) = compared.assumed() {
                let _ = writeln!(text, "Note: {note}.\n");
            }
            text.push_str("| class | change | Rust |\n|---|---|---|\n");
            for change in &diff.changes {
                let field = compared.field(diff, change);
                let field = field.map(|field| format!("`{field}`")).unwrap_or_default();
                let message = cell(&change.message);
                let _ = writeln!(text, "| {} | {message} | {field} |", change.class.name());
            }
            let beside = compared.side_by_side(diff, Width::Unified, Paint::Plain);
            // A fence longer than any run of backticks in the listing.
            let _ = writeln!(
                text,
                "\n<details><summary>old and new listing</summary>\n\n````diff\n{beside}````\n\n</details>"
            );
        }
    }
    text
}

fn cell(text: &str) -> String {
    // In Markdown a bar ends the cell, and a line end the row.
    text.replace('|', "\\|").replace('\n', " ")
}

/// The changes between two layouts.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct DiffDocument<'a> {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA_VERSION)))]
    schema_version: u32,
    tool: Tool,
    /// The most serious class; null without changes.
    class: Option<Class>,
    /// The changed blocks.
    shaders: Vec<DiffedShader<'a>>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct DiffedShader<'a> {
    /// The shader's name in the report.
    name: &'a str,
    /// The macros of `permutations` under which the blocks changed, such as `SHADOWS LIGHTS=8`;
    /// absent for changes that the shader shows without them.
    #[serde(skip_serializing_if = "Option::is_none")]
    variant: Option<&'a str>,
    /// The path of the old side.
    old: &'a str,
    /// The path of the new side.
    new: &'a str,
    /// The policy that holds for the shader; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    policy: Option<Policy>,
    blocks: Vec<BlockObject<'a>>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct BlockObject<'a> {
    /// The block's name, or `(loose uniforms)`.
    name: &'a str,
    class: Class,
    /// The old block; null if it is new.
    old: Option<DiffedBlock>,
    /// The new block; null if it was removed.
    new: Option<DiffedBlock>,
    /// The changes, the most serious first.
    #[cfg_attr(feature = "schema", schemars(length(min = 1)))]
    changes: Vec<ChangeObject<'a>>,
}

/// The old or new block in JSON.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct DiffedBlock {
    /// Address space, name and instance.
    name: String,
    /// Bytes; null for loose uniforms.
    size: Option<u64>,
    /// The line of its name in that side's file.
    line: u32,
    /// The API assumed for a shader that tests `VULKAN` without declaring its API, if its blocks
    /// depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ChangeObject<'a> {
    kind: Kind,
    /// breaking: bytes uploaded for the old layout are misread; compatible: they are read
    /// correctly, but a buffer may be too small; cosmetic: no byte changes.
    class: Class,
    /// The path of the member, as in data[].color; empty for the block.
    path: &'a str,
    /// The old value: a number, a type, a name.
    old: Option<&'a str>,
    /// The new value.
    new: Option<&'a str>,
    message: &'a str,
    /// The field of the mirror that `landfall emit --lang rust` writes.
    rust: Option<String>,
    /// `allowed` or `forbidden`, where a policy holds.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["allowed", "forbidden"])))]
    verdict: Option<&'static str>,
}

/// The schema of [`DIFF_SCHEMA`].
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    crate::schema::text::<DiffDocument<'_>>("landfall diff --format json")
}

/// All changes as JSON that follows [`DIFF_SCHEMA`].
pub fn json(all: &[Compared<'_>]) -> String {
    let worst = all.iter().flat_map(|one| one.blocks).map(BlockDiff::class).max();
    let changed = all.iter().filter(|one| !one.blocks.is_empty());
    let document = DiffDocument {
        schema_version: SCHEMA_VERSION,
        tool: Tool::LANDFALL,
        class: worst,
        shaders: changed.map(shader_object).collect(),
    };
    to_lines(&document) + "\n"
}

fn shader_object<'a>(compared: &Compared<'a>) -> DiffedShader<'a> {
    let side = |block: &BlockLayout, shader: &ShaderLayout| DiffedBlock {
        name: phrases::block_name(block),
        size: block.size,
        line: shader.files.locate(block.span).line,
        assumed_target: shader.assumed_target,
    };
    let block = |diff: &'a BlockDiff| BlockObject {
        name: &diff.name,
        class: diff.class(),
        old: compared.was(diff).map(|block| side(block, compared.old)),
        new: compared.is(diff).map(|block| side(block, compared.new)),
        changes: diff
            .changes
            .iter()
            .map(|change| ChangeObject {
                kind: change.kind,
                class: change.class,
                path: &change.path,
                old: change.old.as_deref(),
                new: change.new.as_deref(),
                message: &change.message,
                rust: compared.field(diff, change),
                verdict: compared.verdict(change),
            })
            .collect(),
    };
    DiffedShader {
        name: compared.name,
        variant: compared.variant,
        old: &compared.old.path,
        new: &compared.new.path,
        policy: compared.policy,
        blocks: compared.blocks.iter().map(block).collect(),
    }
}
