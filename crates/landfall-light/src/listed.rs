//! Rewrites a fragment shader so that its loops over lights read lists of lights.
//!
//! A loop over point lights or spotlights visits the indices in the list of the fragment's tile, a
//! loop over directional lights those whose bit is set in the tile's mask; everything else of the
//! text stays as it is. The lists are in two storage buffers, which
//! [`TileLists::bytes`](crate::plan::TileLists::bytes) fills, or by names any
//! [`Renderer`](crate::render::Renderer) of the text. `tokens` reads both languages, `loops` finds
//! the loops, `glsl` and `wgsl` write the declarations.

mod glsl;
mod loops;
mod tokens;
mod wgsl;

use std::fmt::Write as _;
use std::sync::Arc;

use crate::bind::{BindingMap, Kind, Quantity, Slot};
use landfall_exec::harness::fragments::FragmentShader;
use landfall_layout::interface::Resource;
use landfall_layout::source::{Language, Source};
use landfall_layout::syntax::glsl::raw;
use landfall_layout::text::escape;
use landfall_layout::{Options, ReadOptions, layout};
use loops::{Array, Loop};
use tokens::{ListedToken, joined};

#[derive(Clone, Debug)]
pub struct ListedShader {
    /// The text, with the name of the original.
    pub source: Source,
    /// The kinds of lights that have lists or, if directional, a mask.
    pub kinds: Vec<Kind>,
    /// For each other kind of light that the shader has, why it is read as before.
    pub unlisted: Vec<String>,
}

/// A replacement of a range of the text.
struct RangeEdit {
    start: usize,
    end: usize,
    text: String,
}

impl RangeEdit {
    fn insert(at: usize, text: impl Into<String>) -> RangeEdit {
        RangeEdit { start: at, end: at, text: text.into() }
    }
}

/// The place of the two buffers: `set` only where the language has them.
struct BufferBindings {
    group: Option<u32>,
    first: u32,
}

/// Rewrites a shader; `shader` and `map` are those of a renderer of it. Text of includes is
/// inlined.
///
/// # Errors
/// The reasons why no loop over lights can read lists.
pub fn listed(
    source: &Source,
    options: &ReadOptions,
    shader: &FragmentShader,
    map: &BindingMap,
) -> Result<ListedShader, String> {
    // The bindings of the original, before includes are inlined.
    let resources = resources(source, options);
    let source = &inlined(source, options);
    let tokens = tokens::read(source, options);
    let is_own = |name: &str| name.starts_with("landfall_") || name.starts_with("LandfallTile");
    // A text that was rewritten already.
    if tokens.iter().any(|token| is_own(token.text)) {
        return Err("the shader has names of Landfall's lists already".to_string());
    }
    let arrays = arrays(shader, map);
    let found = loops::loops(&tokens, source.language);
    let mut edits = Vec::new();
    let mut kinds = Vec::new();
    let mut unlisted = Vec::new();
    // A kind whose loops cannot be read keeps its loop; one kind with lists is enough.
    for kind in Kind::ALL.into_iter().filter(|kind| map.has(*kind)) {
        match loops::over(kind, &arrays, &tokens, &found) {
            Ok(over) => {
                kinds.push(kind);
                for one in over {
                    edits.extend(rewritten(kind, one, &tokens, source));
                }
            }
            Err(why) => unlisted.push(format!("{} lights: {why}", kind.name())),
        }
    }
    if kinds.is_empty() {
        return Err(match unlisted.is_empty() {
            true => "the shader has no directional, point or spot lights".to_string(),
            false => unlisted.join("; "),
        });
    }
    let bindings = bindings(source.language, &resources, shader);
    // `#version` of GLSL ES comes before any comment.
    let top = match source.language {
        Language::Glsl | Language::SpirV => glsl::place(&source.text),
        Language::Wgsl => 0,
    };
    edits.push(RangeEdit::insert(top, header(source, &kinds, &unlisted, &bindings)));
    match source.language {
        Language::Glsl | Language::SpirV => {
            glsl::declare(source, &kinds, &bindings, shader, &mut edits)?
        }
        Language::Wgsl => wgsl::declare(source, &tokens, &kinds, &bindings, &mut edits)?,
    }
    // Edits do not overlap; inserted from the front in order.
    edits.sort_by_key(|edit| edit.start);
    let mut text = String::with_capacity(source.text.len() + 4096);
    let mut at = 0;
    for edit in &edits {
        text.push_str(&source.text[at..edit.start]);
        text.push_str(&edit.text);
        at = edit.end;
    }
    text.push_str(&source.text[at..]);
    let source = Source { text: Arc::from(text), foreign: None, ..source.clone() };
    Ok(ListedShader { source, kinds, unlisted })
}

/// Returns the shader in one text.
fn inlined(source: &Source, options: &ReadOptions) -> Source {
    let includes = || raw::read(source, options).files.iter().count() > 1;
    match source.language == Language::Glsl && includes() {
        true => Source { text: Arc::from(raw::flattened(source, options)), ..source.clone() },
        false => source.clone(),
    }
}

fn resources(source: &Source, options: &ReadOptions) -> Vec<Resource> {
    let options = Options::default().with_read(options.clone()).with_interface(true);
    let interface = layout(source, &options).interface;
    interface.map_or(Vec::new(), |interface| interface.resources.clone())
}

/// Returns the first of two bindings that the shader does not use, in the group of its lights.
fn bindings(language: Language, resources: &[Resource], shader: &FragmentShader) -> BufferBindings {
    // OpenGL has no sets: all bindings are of one group there.
    let vulkan = language == Language::Glsl && !shader.rows_from_bottom();
    let grouped = vulkan || language == Language::Wgsl;
    let group = grouped.then(|| resources.iter().filter_map(|r| r.group).min().unwrap_or(0));
    let same = resources.iter().filter(|r| !grouped || r.group.or(Some(0)) == group);
    let used = same.filter_map(|resource| resource.binding);
    BufferBindings { group, first: used.max().map_or(0, |last| last + 1) }
}

/// Returns the arrays of lights, as the text writes them before an index.
fn arrays(shader: &FragmentShader, map: &BindingMap) -> Vec<Array> {
    let mut arrays: Vec<Array> = Vec::new();
    for member in &map.members {
        let Some(Quantity::Light { kind, slot: Slot::Each, .. }) = member.source.quantity() else {
            continue;
        };
        // The array's name in the text is the path before its index, behind the instance name.
        let Some((path, _)) = member.path.split_once("[]") else { continue };
        let block = &shader.blocks()[member.block].layout;
        let instance = block.instance.iter().map(|name| name.to_string());
        let names = path.split('.').filter(|name| !name.is_empty()).map(str::to_string);
        let array = Array { kind, names: instance.chain(names).collect() };
        if !arrays.contains(&array) {
            arrays.push(array);
        }
    }
    arrays
}

/// Returns the edits that make a loop read a list or a mask.
fn rewritten(
    kind: Kind,
    over: &Loop<'_>,
    tokens: &[ListedToken<'_>],
    source: &Source,
) -> Vec<RangeEdit> {
    let wgsl = source.language == Language::Wgsl;
    let Loop { variable, ty, .. } = *over;
    let unsigned = if wgsl { "u32" } else { "uint" };
    let (declare, pair) = if wgsl { ("let ", "let") } else { ("", "uvec2") };
    let wrap = |condition: &str| match wgsl {
        true => format!("if {condition} {{ continue; }}"),
        false => format!("if ({condition}) {{ continue; }}"),
    };
    let body = tokens[over.body.start].start;
    let last = tokens[over.body.end - 1].end;
    let start = tokens[over.at].start;
    let line = source.text[..start].rfind('\n').map_or(0, |end| end + 1);
    let indent: String =
        source.text[line..start].chars().take_while(|c| c.is_whitespace()).collect();
    let mut edits = Vec::new();
    // Directional lights keep their loop and skip those whose bit is not set; the other kinds walk
    // their list.
    let own = match kind {
        Kind::Directional => {
            let mask = if wgsl { "let" } else { "uint" };
            let before = format!("{{ {mask} landfall_mask = landfall_directional();\n{indent}");
            edits.push(RangeEdit::insert(start, before));
            let at = format!("{unsigned}({variable})");
            wrap(&format!("{at} < 32u && ((landfall_mask >> {at}) & 1u) == 0u"))
        }
        Kind::Point | Kind::Spot => {
            let lists = if kind == Kind::Point { "landfall_points" } else { "landfall_spots" };
            let before = format!("{{ {pair} landfall_list = {lists}();\n{indent}");
            edits.push(RangeEdit::insert(start, before));
            let counter = if wgsl { "var" } else { "uint" };
            edits.push(RangeEdit {
                start: tokens[over.at + 1].end,
                end: tokens[over.close].start,
                text: format!(
                    // The loop's own condition is kept as a guard: a list may hold an index past
                    // the count.
                    "{counter} landfall_at = landfall_list.x; landfall_at < landfall_list.y; \
                     landfall_at++"
                ),
            });
            let spelled = if wgsl { String::new() } else { format!("{ty} ") };
            let index = format!(
                "{declare}{spelled}{variable} = {ty}(landfall_lists.indices[landfall_at]);"
            );
            let condition = joined(&tokens[over.condition.clone()]);
            format!("{index}\n{indent}    {}", wrap(&format!("!({condition})")))
        }
    };
    // Braces are added where the body has none.
    match over.braced {
        true => {
            edits.push(RangeEdit::insert(
                tokens[over.body.start].end,
                format!("\n{indent}    {own}"),
            ));
            edits.push(RangeEdit::insert(last, " }"));
        }
        false => {
            edits.push(RangeEdit::insert(body, format!("{{ {own} ")));
            edits.push(RangeEdit::insert(last, " } }"));
        }
    }
    edits
}

fn header(
    source: &Source,
    kinds: &[Kind],
    unlisted: &[String],
    bindings: &BufferBindings,
) -> String {
    let mut text = String::new();
    let name = source.path.rsplit(['/', '\\']).next().unwrap_or_default();
    let read = |kind: &Kind| match kind {
        Kind::Directional => "directional lights by a mask",
        Kind::Point => "point lights by lists",
        Kind::Spot => "spotlights by lists",
    };
    let read: Vec<&str> = kinds.iter().map(read).collect();
    let set = bindings.group.map_or(String::new(), |group| match source.language {
        Language::Glsl | Language::SpirV => format!("set {group}, "),
        Language::Wgsl => format!("group {group}, "),
    });
    let BufferBindings { first, .. } = *bindings;
    let _ = writeln!(
        text,
        "// {} with lists of lights for tiles of the picture, by `landfall render --emit-shader`:",
        escape::comment(name)
    );
    let _ = writeln!(text, "// it reads {}.", read.join(", "));
    for why in unlisted {
        let _ = writeln!(text, "// Read as before: {}.", escape::comment(why));
    }
    let _ = writeln!(
        text,
        "//
// Two storage buffers must hold the lists of a picture; `landfall layout` on this file prints the
// offsets of their members:
//   LandfallTileBlock   {set}binding {first}: the side of a tile and the height of the picture in
//                       pixels, the tiles in a row, and for each tile, row by row from the top left,
//                       where its lists begin in `indices` and how long they are
//   LandfallIndexBlock  {set}binding {}: indices of point lights and of spotlights in the arrays of
//                       this shader, which hold all lights; ascending in each list, so that sums are
//                       added up in the order of the original loop
// `landfall_light::culling::plan_only` plans a picture, `Plan::tile_lists` gives its lists and
// `TileLists::bytes` the bytes of both buffers. A picture of one tile of 4294967295 pixels needs no
// plan: its lists hold all lights.
",
        first + 1
    );
    text
}
