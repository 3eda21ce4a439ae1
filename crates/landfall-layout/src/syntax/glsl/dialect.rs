//! Files of GLSL with lines of an engine or tool, which splits them into stages: Godot's `#[vertex]`,
//! RetroArch's `#pragma stage vertex`, sokol-shdc's `@vs name`.
//!
//! Each stage is read on its own from the same text, in which what it does not hold is blank, so that
//! offsets in it are those of the file. The text of `@block` stays where it stands, in the stages that
//! include it.

use std::ops::Range;
use std::rc::Rc;

use rustc_hash::FxHashMap;

use crate::source::Stage;
use crate::syntax::{blanked, reached};

/// The lines that Godot replaces by text of its own when it compiles a shader.
pub(super) const GODOT_LINES: [&str; 4] =
    ["CODE", "GLOBALS", "MATERIAL_UNIFORMS", "VERSION_DEFINES"];

/// The limit on the stages of one file.
pub(super) const MAX_STAGES: usize = 256;

#[derive(Clone, Debug)]
pub(super) struct StageText<'a> {
    pub(super) stage: Stage,
    /// What the file has of the stage alone.
    parts: Vec<Range<usize>>,
    /// The blocks of sokol-shdc's file that the stage includes itself.
    blocks: Vec<&'a str>,
    /// What all stages of that file share.
    sokol: Rc<SokolFile<'a>>,
    /// The version that the tool compiles it as, where it states none.
    pub(super) version: u32,
    /// Whether the tool compiles it for Vulkan.
    pub(super) is_vulkan: bool,
}

impl StageText<'_> {
    /// Returns the file's text with blanks for what is not of the stage.
    // The blocks are searched here and not by `stages`, of whose result one stage is read.
    pub(super) fn text(&self, file: &str) -> String {
        let SokolFile { blocks, includes, tags } = &*self.sokol;
        let block = |name| blocks.get(name).into_iter();
        let included = reached(self.blocks.iter().copied(), |name| {
            block(name).flat_map(|(_, blocks)| blocks.iter().copied())
        });
        let included = included.into_iter().flat_map(block).map(|(range, _)| range);
        let mut parts: Vec<Range<usize>> =
            self.parts.iter().chain(included).chain(includes).cloned().collect();
        parts.sort_by_key(|range| range.start);
        let is_include = |line: &&Range<usize>| {
            tag(&file[(*line).clone()]).is_some_and(|(word, _)| word == "include")
        };
        let (directives, others): (Vec<&Range<usize>>, Vec<_>) = tags.iter().partition(is_include);
        let mut text = blanked(&kept(file, &parts), others.into_iter().cloned());
        directives.into_iter().for_each(|line| include(&mut text, line));
        text
    }
}

/// Returns the stages of a file that a tool splits, at most one more than may be; none of a plain GLSL
/// text.
// Marks are searched as bytes first: nearly all texts have none, and each parser costs a pass.
pub(super) fn stages(text: &str) -> Vec<StageText<'_>> {
    let has = |mark: &str| memchr::memmem::find(text.as_bytes(), mark.as_bytes()).is_some();
    let mut found = Vec::new();
    if has("#[") {
        found = godot(text);
    }
    if found.is_empty() && has("#pragma") && has("stage") {
        found = retroarch(text);
    }
    if found.is_empty() && !has("#version") && (has("@vs") || has("@fs") || has("@cs")) {
        found = sokol(text);
    }
    found
}

/// Returns a text without the lines that begin with `@`, which tell sokol-shdc what an included file
/// is for.
pub(super) fn without_tags(text: &str) -> Option<String> {
    let mut tags = lines(text).filter(|line| tag(&text[line.clone()]).is_some()).peekable();
    tags.peek()?;
    Some(blanked(text, tags))
}

/// Returns the text of a template literal, where JavaScript holds a shader, with blanks around it.
pub(super) fn literal(text: &str) -> String {
    let start = text.find('`').map_or(text.len(), |at| at + 1);
    let end = text.rfind('`').unwrap_or(text.len()).max(start);
    blanked(text, [0..start, end..text.len()])
}

/// Godot: `#[vertex]` begins a stage. What comes before, above all `#[modes]`, is no GLSL.
fn godot(text: &str) -> Vec<StageText<'_>> {
    let mut is_compatibility = false;
    let parts = divided(text, |line| {
        let name = line.trim().strip_prefix("#[")?.strip_suffix(']')?;
        // `#[modes]` and `#[specializations]` are of Godot's Compatibility renderer, which compiles
        // for OpenGL; files without them, above all with `#[versions]`, are compiled for Vulkan.
        is_compatibility |= matches!(name, "modes" | "specializations");
        Some(match name {
            "vertex" => Some(Stage::Vertex),
            "fragment" => Some(Stage::Fragment),
            "compute" => Some(Stage::Compute),
            // As Godot spells it.
            "tesselation_control" => Some(Stage::TessellationControl),
            "tesselation_evaluation" => Some(Stage::TessellationEvaluation),
            "raygen" => Some(Stage::RayGeneration),
            "intersection" => Some(Stage::Intersection),
            "any_hit" => Some(Stage::AnyHit),
            "closest_hit" => Some(Stage::ClosestHit),
            "miss" => Some(Stage::Miss),
            "modes" | "specializations" | "versions" => None,
            _ => return None,
        })
    });
    let of_stage = |(stage, line, end): (Option<Stage>, Range<usize>, usize)| {
        let part = line.end..end;
        Some(StageText {
            stage: stage?,
            parts: vec![part],
            blocks: Vec::new(),
            sokol: Rc::default(),
            version: if is_compatibility { 330 } else { 450 },
            is_vulkan: !is_compatibility,
        })
    };
    parts.into_iter().filter_map(of_stage).take(MAX_STAGES + 1).collect()
}

/// RetroArch: `#pragma stage vertex` begins a stage; what comes before belongs to each.
fn retroarch(text: &str) -> Vec<StageText<'_>> {
    let parts = divided(text, |line| {
        let mut words = line.split_whitespace();
        match [words.next()?, words.next()?, words.next()?] {
            ["#pragma", "stage", "vertex"] => Some(Stage::Vertex),
            ["#pragma", "stage", "fragment"] => Some(Stage::Fragment),
            _ => None,
        }
    });
    let common = 0..parts.first().map_or(0, |(_, line, _)| line.start);
    let of_stage = |(stage, line, end): (Stage, Range<usize>, usize)| {
        let parts = vec![common.clone(), line.start..end];
        let (blocks, sokol) = (Vec::new(), Rc::default());
        StageText { stage, parts, blocks, sokol, version: 450, is_vulkan: true }
    };
    parts.into_iter().map(of_stage).take(MAX_STAGES + 1).collect()
}

/// The parts of a text that begin at some lines: what such a line says, its range, and where the next
/// one begins.
fn divided<T>(
    text: &str,
    mut begins: impl FnMut(&str) -> Option<T>,
) -> Vec<(T, Range<usize>, usize)> {
    let mut parts: Vec<(T, Range<usize>, usize)> = Vec::new();
    for line in lines(text) {
        if let Some(what) = begins(&text[line.clone()]) {
            parts.last_mut().into_iter().for_each(|(_, _, end)| *end = line.start);
            parts.push((what, line, text.len()));
        }
    }
    parts
}

/// What a file for sokol-shdc has besides its stages.
#[derive(Debug, Default)]
struct SokolFile<'a> {
    /// By the name of each `@block`, its range and the blocks that it includes.
    blocks: FxHashMap<&'a str, (Range<usize>, Vec<&'a str>)>,
    /// The lines `@include` outside of all parts.
    includes: Vec<Range<usize>>,
    /// The lines for the tool.
    tags: Vec<Range<usize>>,
}

/// A part of such a file: `@vs name` to `@end`.
struct SokolPart<'a> {
    /// The stage; `None` of `@block`.
    stage: Option<Stage>,
    name: &'a str,
    range: Range<usize>,
    /// The blocks that `@include_block` names.
    blocks: Vec<&'a str>,
}

/// sokol-shdc: `@vs`, `@fs`, `@cs` and `@block` begin a part that ends with `@end`; what stands
/// outside is for the tool alone, `@include` apart.
fn sokol<'a>(text: &'a str) -> Vec<StageText<'a>> {
    let mut parts: Vec<SokolPart<'a>> = Vec::new();
    let mut file = SokolFile::default();
    let mut is_open = false;
    for line in lines(text) {
        let Some((word, rest)) = tag(&text[line.clone()]) else { continue };
        let stage = match word {
            "vs" => Some(Stage::Vertex),
            "fs" => Some(Stage::Fragment),
            "cs" => Some(Stage::Compute),
            _ => None,
        };
        match word {
            "vs" | "fs" | "cs" | "block" => {
                let range = line.end..text.len();
                parts.push(SokolPart { stage, name: rest, range, blocks: Vec::new() });
                is_open = true;
            }
            "end" if is_open => {
                parts.last_mut().into_iter().for_each(|part| part.range.end = line.start);
                is_open = false;
            }
            "include_block" if is_open => {
                parts.last_mut().into_iter().for_each(|part| part.blocks.push(rest));
            }
            "include" if !is_open => file.includes.push(line.clone()),
            _ => {}
        }
        file.tags.push(line);
    }
    let (stages, blocks): (Vec<_>, Vec<_>) =
        parts.into_iter().partition(|part| part.stage.is_some());
    for SokolPart { name, range, blocks, .. } in blocks {
        file.blocks.entry(name).or_insert((range, blocks));
    }
    let sokol = Rc::new(file);
    let of_stage = |SokolPart { stage, range, blocks, .. }: SokolPart<'a>| {
        let (parts, sokol) = (vec![range], Rc::clone(&sokol));
        Some(StageText { stage: stage?, parts, blocks, sokol, version: 450, is_vulkan: true })
    };
    stages.into_iter().filter_map(of_stage).take(MAX_STAGES + 1).collect()
}

/// The word and the rest of a line `@word rest` of sokol-shdc, which may follow `#pragma sokol`.
fn tag(line: &str) -> Option<(&str, &str)> {
    let line = line.trim();
    let line = line
        .strip_prefix("#pragma")
        .map_or(line, |rest| rest.trim_start().strip_prefix("sokol").map_or(line, str::trim_start));
    let (word, rest) =
        line.strip_prefix('@')?.split_once(char::is_whitespace).unwrap_or((line.get(1..)?, ""));
    word.starts_with(|c: char| c.is_ascii_lowercase()).then(|| (word, rest.trim()))
}

/// The ranges of a text's lines, with what ends them.
fn lines(text: &str) -> impl Iterator<Item = Range<usize>> {
    text.split_inclusive('\n').scan(0, |start, line| {
        *start += line.len();
        Some(*start - line.len()..*start)
    })
}

/// Returns a text with blanks outside some ranges, which are in order.
fn kept(text: &str, ranges: &[Range<usize>]) -> String {
    // A part that is not closed reaches over those after it.
    let ends = ranges.iter().scan(0, |end, range| {
        *end = range.end.max(*end);
        Some(*end)
    });
    let ends = std::iter::once(0).chain(ends);
    let starts = ranges.iter().map(|range| range.start).chain([text.len()]);
    blanked(text, ends.zip(starts).map(|(end, start)| end..start.max(end)))
}

/// Turns `@include NAME` in a line into a directive, if the line is not blank.
// `#include"NAME` is as long.
fn include(text: &mut String, line: &Range<usize>) {
    let Some(sign) = text[line.clone()].find("@include").map(|at| line.start + at) else { return };
    let name = sign + "@include".len();
    if matches!(text.as_bytes().get(name), Some(b' ' | b'\t')) {
        text.replace_range(name..=name, "\"");
        text.replace_range(line.start..=sign, &format!("{}#", " ".repeat(sign - line.start)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lines of each stage that are not blank.
    fn read(text: &str) -> Vec<(Stage, Vec<String>)> {
        let stages = stages(text).into_iter();
        let lines = |text: &str| {
            let lines = text.lines().filter(|line| !line.trim().is_empty());
            lines.map(|line| line.trim().to_string()).collect()
        };
        stages
            .map(|stage| {
                let of_stage = stage.text(text);
                assert_eq!(of_stage.len(), text.len(), "offsets stay");
                assert_eq!(of_stage.lines().count(), text.lines().count());
                (stage.stage, lines(&of_stage))
            })
            .collect()
    }

    fn strings(lines: &[&str]) -> Vec<String> {
        lines.iter().map(|line| (*line).to_string()).collect()
    }

    #[test]
    fn each_stage_has_its_own_lines_and_those_of_all() {
        assert_eq!(
            read("#[modes]\nmode =\n#[vertex]\na;\n#[fragment]\r\nb;\r\n"),
            [(Stage::Vertex, strings(&["a;"])), (Stage::Fragment, strings(&["b;"]))]
        );
        let pragma = "#pragma stage vertex";
        assert_eq!(
            read("#version 450\nü;\n#pragma stage vertex\na;\n#pragma stage fragment\nb;"),
            [
                (Stage::Vertex, strings(&["#version 450", "ü;", pragma, "a;"])),
                (Stage::Fragment, strings(&["#version 450", "ü;", "#pragma stage fragment", "b;"])),
            ]
        );
        assert_eq!(
            read(
                "@ctype mat4 m\n@include x.glsl\n@block inner\ni;\n@end\n@block b\n\
                 @include_block inner\nc;\n@end\n@block no\nn;\n@end\n@vs v\n@include_block b\n  \
                 @include y\na;\n@end\n#pragma sokol @fs f\nd;\n#pragma sokol @end\n@program p v f\n"
            ),
            [
                (Stage::Vertex, strings(&["#include\"x.glsl", "i;", "c;", "#include\"y", "a;"])),
                (Stage::Fragment, strings(&["#include\"x.glsl", "d;"])),
            ]
        );
        assert!(read("// @fs of me@vs.org\n#pragma optimize(stage)\nvoid main() {}").is_empty());
    }
}
