//! The declarations of lists in WGSL.

use std::fmt::Write as _;

use super::tokens::{ListedToken, closing};
use super::{BufferBindings, RangeEdit};
use crate::bind::Kind;
use landfall_layout::source::Source;

/// Adds the variables and the functions that read them, and gives them the fragment's position.
///
/// # Errors
/// The reason why the position is not found.
pub(super) fn declare(
    source: &Source,
    tokens: &[ListedToken<'_>],
    kinds: &[Kind],
    bindings: &BufferBindings,
    edits: &mut Vec<RangeEdit>,
) -> Result<(), String> {
    // The functions are called from anywhere, so each fragment entry point stores its position in
    // a private variable first.
    let mut entries = 0;
    for at in 0..tokens.len() {
        if words(tokens, at, &["@", "fragment"]) {
            edits.extend(entry(tokens, at).ok_or("the fragment entry point is not understood")?);
            entries += 1;
        }
    }
    if entries == 0 {
        return Err("the text has no fragment entry point".to_string());
    }
    let end = source.text.len();
    edits.push(RangeEdit::insert(end, declarations(kinds, bindings)));
    Ok(())
}

fn words(tokens: &[ListedToken<'_>], at: usize, words: &[&str]) -> bool {
    let mut next = tokens.iter().skip(at);
    words.iter().all(|word| next.next().is_some_and(|token| token.text == *word))
}

/// Returns the edits that keep the position at the start of an entry point.
fn entry(tokens: &[ListedToken<'_>], at: usize) -> Option<Vec<RangeEdit>> {
    let function = (at..tokens.len()).find(|at| tokens[*at].text == "fn")?;
    let open = function + 2;
    let close = closing(tokens, open)?;
    let body = (close..tokens.len()).find(|at| tokens[*at].text == "{")?;
    let mut edits = Vec::new();
    // A position that is a parameter already, or a member of one, is used; a second one is an
    // error of WGSL.
    let position = match own(tokens, open + 1..close) {
        Some(position) => position,
        None => {
            // A trailing comma is allowed in WGSL.
            let more = if open + 1 < close && tokens[close - 1].text != "," { ", " } else { "" };
            let declared = format!("{more}@builtin(position) landfall_pixel: vec4f");
            edits.push(RangeEdit::insert(tokens[close].start, declared));
            "landfall_pixel".to_string()
        }
    };
    let kept = format!(" landfall_position = {position};");
    edits.push(RangeEdit::insert(tokens[body].end, kept));
    Some(edits)
}

/// Returns the expression of the position that parameters give already.
fn own(tokens: &[ListedToken<'_>], parameters: std::ops::Range<usize>) -> Option<String> {
    const POSITION: [&str; 5] = ["@", "builtin", "(", "position", ")"];
    let name_at = |from: usize, end: usize| {
        // Other attributes may follow.
        (from..end).find(|at| tokens[*at + 1].text == ":").map(|at| tokens[at].text)
    };
    for at in parameters.clone() {
        if words(tokens, at, &POSITION) {
            return name_at(at + POSITION.len(), parameters.end).map(str::to_string);
        }
        if tokens[at].text != ":" {
            continue;
        }
        let (name, ty) = (tokens[at - 1].text, tokens[at + 1].text);
        let structure = (0..tokens.len()).find(|at| words(tokens, *at, &["struct", ty, "{"]));
        let Some(open) = structure.map(|at| at + 2) else { continue };
        let end = closing(tokens, open)?;
        if let Some(at) = (open..end).find(|at| words(tokens, *at, &POSITION)) {
            return Some(format!("{name}.{}", name_at(at + POSITION.len(), end)?));
        }
    }
    None
}

fn declarations(kinds: &[Kind], bindings: &BufferBindings) -> String {
    let group = bindings.group.unwrap_or_default();
    let (first, second) = (bindings.first, bindings.first + 1);
    let mut text = format!(
        "
struct LandfallTile {{
    pointFirst: u32,      // offset 0, in `indices`
    pointCount: u32,      // offset 4
    spotFirst: u32,       // offset 8, in `indices`
    spotCount: u32,       // offset 12
    directionalMask: u32, // offset 16: bit n for light n; those from 32 on are always lit
}}

struct LandfallTileBlock {{
    tileSize: u32,       // offset 0
    tilesAcross: u32,    // offset 4
    pictureHeight: u32,  // offset 8
    tiles: array<LandfallTile>, // offset 12, stride 20
}}

struct LandfallIndexBlock {{
    indices: array<u32>, // offset 0
}}

@group({group}) @binding({first}) var<storage, read> landfall_tiles: LandfallTileBlock;
@group({group}) @binding({second}) var<storage, read> landfall_lists: LandfallIndexBlock;

var<private> landfall_position: vec4f;

fn landfall_tile() -> u32 {{
    let at = vec2u(landfall_position.xy) / max(landfall_tiles.tileSize, 1u);
    return min(at.y * landfall_tiles.tilesAcross + at.x, arrayLength(&landfall_tiles.tiles) - 1u);
}}
"
    );
    for kind in kinds {
        let (name, word) = match kind {
            Kind::Directional => {
                text.push_str(
                    "
fn landfall_directional() -> u32 {
    return landfall_tiles.tiles[landfall_tile()].directionalMask;
}
",
                );
                continue;
            }
            Kind::Point => ("points", "point"),
            Kind::Spot => ("spots", "spot"),
        };
        let _ = write!(
            text,
            "
fn landfall_{name}() -> vec2u {{
    let tile = landfall_tile();
    let first = landfall_tiles.tiles[tile].{word}First;
    let end = first + landfall_tiles.tiles[tile].{word}Count;
    return vec2u(first, min(end, arrayLength(&landfall_lists.indices)));
}}
"
        );
    }
    text
}
