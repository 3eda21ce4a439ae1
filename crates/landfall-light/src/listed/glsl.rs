//! The declarations of lists in GLSL.

use std::fmt::Write as _;

use super::{BufferBindings, RangeEdit};
use crate::bind::Kind;
use landfall_exec::harness::fragments::FragmentShader;
use landfall_layout::ReadOptions;
use landfall_layout::source::Source;
use landfall_layout::syntax::glsl::raw;

/// Adds the blocks and the functions that read them, and raises `#version` to one with storage
/// buffers.
///
/// # Errors
/// The reason why the text cannot have storage buffers.
pub(super) fn declare(
    source: &Source,
    kinds: &[Kind],
    bindings: &BufferBindings,
    shader: &FragmentShader,
    edits: &mut Vec<RangeEdit>,
) -> Result<(), String> {
    let text = &*source.text;
    let raw = raw::read(source, &ReadOptions::default());
    let word = |at: usize| raw.tokens.get(at).map_or("", |token| &text[token.start..token.end]);
    let version = (0..raw.tokens.len())
        .find(|at| raw.tokens[*at].directive.is_some() && word(*at) == "version");
    let number = version.map(|at| &raw.tokens[at + 1]);
    let Some(number) = number else {
        return Err(
            "the text has no `#version`, and lists need storage buffers, of GLSL 430".into()
        );
    };
    // Storage buffers need GLSL 4.30 or ES 3.10. From 1.40 and ES 3.00 on the number alone is
    // raised; older texts have `varying` and `texture2D`, which these versions have not.
    match (raw.es, raw.version) {
        (true, 310..) | (false, 430..) => {}
        (true, 300) | (false, 140..) => {
            let raised = if raw.es { "310" } else { "430" };
            edits.push(RangeEdit {
                start: number.start,
                end: number.end,
                text: raised.to_string(),
            });
        }
        (true, version) => {
            return Err(format!(
                "lists need storage buffers, of GLSL ES 310, and `#version {version}` cannot be raised \
                 to it without other changes"
            ));
        }
        (false, version) => {
            return Err(format!(
                "lists need storage buffers, of GLSL 430, and `#version {version}` cannot be raised \
                 to it without other changes"
            ));
        }
    }
    let again = |at: usize| word(at) == "gl_FragCoord" && at > 0 && word(at - 1) == "vec4";
    if (0..raw.tokens.len()).any(again) {
        return Err("the text declares `gl_FragCoord` again, which must come before its use".into());
    }
    edits.push(RangeEdit::insert(place(text), declarations(kinds, bindings, shader, raw.es)));
    Ok(())
}

/// Returns the start of the line behind the last `#version` and `#extension`, outside of
/// conditions.
pub(super) fn place(text: &str) -> usize {
    let (mut at, mut depth, mut place) = (0, 0u32, 0);
    // Declarations must follow `#extension`, and must not be within `#if`.
    let mut behind = false;
    for line in text.split_inclusive('\n') {
        at += line.len();
        let directive = line.trim_start().strip_prefix('#').map_or("", str::trim_start);
        depth += u32::from(directive.starts_with("if"));
        depth = depth.saturating_sub(u32::from(directive.starts_with("endif")));
        behind |= directive.starts_with("version") || directive.starts_with("extension");
        if behind && depth == 0 {
            (place, behind) = (at, false);
        }
    }
    place
}

fn declarations(
    kinds: &[Kind],
    bindings: &BufferBindings,
    shader: &FragmentShader,
    es: bool,
) -> String {
    let precision = if es { "highp " } else { "" };
    let set = bindings.group.map_or(String::new(), |group| format!("set = {group}, "));
    let (first, second) = (bindings.first, bindings.first + 1);
    let rows = match shader.rows_from_bottom() {
        // Row 0 of `gl_FragCoord` is the bottom one.
        true => {
            "    at.y = landfall_tiles.pictureHeight - min(at.y + 1u, landfall_tiles.pictureHeight);\n"
        }
        false => "",
    };
    let mut text = format!(
        "
struct LandfallTile {{
    {precision}uint pointFirst;      // offset 0, in `indices`
    {precision}uint pointCount;      // offset 4
    {precision}uint spotFirst;       // offset 8, in `indices`
    {precision}uint spotCount;       // offset 12
    {precision}uint directionalMask; // offset 16: bit n for light n; those from 32 on are always lit
}};

layout({set}binding = {first}, std430) readonly buffer LandfallTileBlock {{
    {precision}uint tileSize;       // offset 0
    {precision}uint tilesAcross;    // offset 4
    {precision}uint pictureHeight;  // offset 8
    LandfallTile tiles[]; // offset 12, stride 20
}} landfall_tiles;

layout({set}binding = {second}, std430) readonly buffer LandfallIndexBlock {{
    {precision}uint indices[]; // offset 0
}} landfall_lists;

{precision}uint landfall_tile() {{
    {precision}uvec2 at = uvec2(gl_FragCoord.xy);
{rows}    at /= max(landfall_tiles.tileSize, 1u);
    return min(at.y * landfall_tiles.tilesAcross + at.x, uint(landfall_tiles.tiles.length()) - 1u);
}}
"
    );
    for kind in kinds {
        let (name, word) = match kind {
            Kind::Directional => {
                let _ = write!(
                    text,
                    "
{precision}uint landfall_directional() {{
    return landfall_tiles.tiles[landfall_tile()].directionalMask;
}}
"
                );
                continue;
            }
            Kind::Point => ("points", "point"),
            Kind::Spot => ("spots", "spot"),
        };
        let _ = write!(
            text,
            "
{precision}uvec2 landfall_{name}() {{
    {precision}uint tile = landfall_tile();
    {precision}uint first = landfall_tiles.tiles[tile].{word}First;
    {precision}uint end = first + landfall_tiles.tiles[tile].{word}Count;
    return uvec2(first, min(end, uint(landfall_lists.indices.length())));
}}
"
        );
    }
    text.push('\n');
    text
}
