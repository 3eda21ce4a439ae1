//! The report of `landfall lights`: what lights cost, as text and as JSON of [`LIGHTS_SCHEMA`].
//!
//! Formats the data of [`cost`](crate::report::lights::cost).

mod json;

pub mod cost;

use std::ops::Range;

use anstyle::Style;
use unicode_width::UnicodeWidthStr as _;

use crate::report::lights::cost::{Light, LightHazard, Report};
use landfall_ir::analysis::occurrence::IndexBound;
use landfall_ir::analysis::roles::Form;
use landfall_layout::ShaderLayout;
use landfall_layout::diagnostic::{Diagnostic, Severity};
pub use landfall_layout::format::columns;
use landfall_layout::format::columns::GAP;
use landfall_layout::format::diagnostics::human as diagnostics;
use landfall_layout::format::diagnostics::render::DiagnosticRenderer;
pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, PLAIN, STRONG, TYPE};
pub use landfall_layout::format::phrases::{bytes, number};
use landfall_layout::format::{Paint, SCHEMA_VERSION};
use landfall_layout::layout::targets;
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::Files;
use landfall_layout::text::escape;

#[cfg(feature = "schema")]
pub use json::schema;
pub use json::{closing, opening, shader as json};

pub use crate::report::schema::LIGHTS_SCHEMA;

/// Returns the text for one shader: a table of lights, the members of each, then the hazards with
/// excerpts.
pub fn human(shader: &ShaderLayout, report: &Report, paint: Paint) -> String {
    let mut text = paint.text(HEADING, &escape::name(&shader.path));
    text.push('\n');
    // Sizes and offsets depend on the API that was assumed.
    if let Some(note) = targets::note(shader.assumed_target) {
        text.push_str(&paint.text(CAUTION, &format!("{note}\n")));
    }
    if report.lights.is_empty() {
        text.push_str("no lights found in structures, blocks or members\n");
    } else {
        text.push_str(&lights(&report.lights, paint));
    }
    if !report.unfollowed.is_empty() {
        text.push_str(
            "\nits functions could not be analysed, so loop bounds and hazards are unknown:\n",
        );
        text.push_str(&diagnostics(&report.unfollowed, &shader.files, paint));
    } else if report.cut_short {
        text.push_str("\nits functions are too long to be analysed to the end\n");
    }
    if !report.hazards.is_empty() {
        text.push('\n');
        text.push_str(&hazards(&report.hazards, &shader.files, paint));
    }
    text
}

/// Returns the table of some lights, and the members of each.
pub fn lights(lights: &[Light], paint: Paint) -> String {
    let mut text = table(lights, paint);
    for light in lights {
        text.push('\n');
        text.push_str(&light_text(light, paint));
    }
    text
}

const TITLES: [&str; 7] = ["kind", "bytes", "padding", "slots", "array", "block", "light"];
/// The columns of numbers, which are aligned to the right.
const NUMBERS: Range<usize> = 1..6;

/// A row for each light, its name last; a name too long for the line continues on the next.
fn table(lights: &[Light], paint: Paint) -> String {
    let rows: Vec<[String; 7]> = lights.iter().map(row).collect();
    let mut widths = TITLES.map(str::width);
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.width());
        }
    }
    let indent: usize = widths[..NUMBERS.end].iter().map(|width| width + GAP.len()).sum();
    let line = |cells: &[String; 7], style: [Style; 2]| {
        let mut text = String::new();
        let (name, others) = cells.split_last().expect("a row has cells");
        for (at, (cell, width)) in others.iter().zip(widths).enumerate() {
            let space = " ".repeat(width - cell.width());
            let cell = paint.text(style[0], cell);
            let cells = if NUMBERS.contains(&at) { [space, cell] } else { [cell, space] };
            text.push_str(&cells.concat());
            text.push_str(GAP);
        }
        let names = columns::wrapped(name, columns::WIDTH.saturating_sub(indent));
        let names: Vec<String> = names.iter().map(|part| paint.text(style[1], part)).collect();
        text + &names.join(&format!("\n{}", " ".repeat(indent))) + "\n"
    };
    let mut text = line(&TITLES.map(String::from), [FAINT, FAINT]);
    for row in &rows {
        text.push_str(&line(row, [PLAIN, STRONG]));
    }
    text
}

fn row(light: &Light) -> [String; 7] {
    let known = |n: Option<u64>| n.map_or("-".to_string(), number);
    let slots = match (light.array, light.slots) {
        (true, Some(slots)) => number(slots),
        (true, None) => "any".to_string(),
        (false, _) => "1".to_string(),
    };
    // The bytes of all slots, used or not: all of them are uploaded.
    let array = match (light.array, light.slots, light.bytes) {
        (true, Some(slots), Some(bytes)) => slots.checked_mul(bytes),
        _ => None,
    };
    [
        light.kind.to_string(),
        known(light.bytes),
        known(light.padding),
        slots,
        known(array),
        known(light.block_size),
        name(light),
    ]
}

/// Returns the name of a light: `PointLight data[]`, `LightBlock`, `lightPos, lightColor`.
fn name(light: &Light) -> String {
    match light.form {
        Form::Structure if light.structure.is_empty() => light.path.clone(),
        Form::Structure => format!("{} {}", light.structure, light.path),
        Form::Block => light.structure.clone(),
        Form::Members => {
            let names: Vec<&str> = light.members.iter().map(|part| part.path.as_str()).collect();
            match names.len() {
                0..=3 => names.join(", "),
                _ => format!("{}, …", names[..3].join(", ")),
            }
        }
    }
}

fn block(light: &Light) -> String {
    match light.address_space {
        AddressSpace::Default => "loose uniforms".to_string(),
        space => format!("{} {} ({})", space.name(), light.block, light.rules),
    }
}

fn light_text(light: &Light, paint: Paint) -> String {
    let mut text = match light.form {
        Form::Block => format!("{}\n", paint.text(STRONG, &block(light))),
        Form::Structure | Form::Members => {
            format!("{} in {}\n", paint.text(STRONG, &name(light)), block(light))
        }
    };
    let rows: Vec<[String; 4]> = light
        .members
        .iter()
        .map(|part| {
            let offset = part.offset.map_or("-".to_string(), |offset| offset.to_string());
            [part.role.replace('_', " "), part.path.clone(), part.ty.clone(), offset]
        })
        .collect();
    let mut widths = [0; 4];
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.width());
        }
    }
    let pad = |cell: &str, width: usize| " ".repeat(width.saturating_sub(cell.width()));
    for [role, path, ty, offset] in &rows {
        text.push_str(&format!(
            "  {}{}  {path}{}  {}{}  {}{offset}\n",
            paint.text(FAINT, role),
            pad(role, widths[0]),
            pad(path, widths[1]),
            paint.text(TYPE, ty),
            pad(ty, widths[2]),
            pad(offset, widths[3]),
        ));
    }
    if !light.others.is_empty() {
        text.push_str(&format!("  other members: {}\n", light.others.join(", ")));
    }
    if let Some(count) = &light.count {
        let at = count.offset.map_or(String::new(), |offset| format!(" at byte {offset}"));
        text.push_str(&format!("  count: {} of {}{at}\n", count.name, count.block));
    } else if light.array {
        text.push_str("  count: no member holds the number of slots in use\n");
    }
    if !light.bounds.is_empty() {
        let all: Vec<String> = light.bounds.iter().map(|bound| bound_text(*bound)).collect();
        // An index that is only bounded by the count can leave the array.
        let style = match light.bounds.contains(&IndexBound::Count) {
            true => CAUTION,
            false => PLAIN,
        };
        text.push_str(&format!("  index: {}\n", paint.text(style, &all.join("; "))));
    }
    if let (Some(better), Some(now)) = (&light.reorder, light.bytes) {
        let saved = now.saturating_sub(better.bytes);
        // The saving counts for each slot of the array.
        let all = light.slots.unwrap_or(1).saturating_mul(saved);
        let line = format!(
            "reordered as {}: {} instead of {now}, {} saved in total",
            better.order.join(", "),
            bytes(better.bytes),
            bytes(all),
        );
        let lines = columns::wrapped(&line, columns::WIDTH - 4);
        text.push_str(&format!("  {}\n", lines.join("\n    ")));
    }
    text
}

fn bound_text(bound: IndexBound) -> String {
    match bound {
        IndexBound::Fixed(index) => format!("constant {index}"),
        IndexBound::Constant(n) => format!("loop to {n}"),
        IndexBound::ClampedCount => "loop to the count, clamped to the array".to_string(),
        IndexBound::Count => "loop to the count, not clamped to the array".to_string(),
        IndexBound::Length => "loop to the array's length".to_string(),
        IndexBound::Unknown => "not bounded by a loop".to_string(),
    }
}

fn hazards(found: &[LightHazard], files: &Files, paint: Paint) -> String {
    let mut pen = DiagnosticRenderer::new(files, paint);
    let mut text = String::new();
    for hazard in found {
        let finding = &hazard.finding;
        let note = format!("hazard `{}`, {}", hazard.hazard.code(), hazard.certainty.name());
        let mut shown = Diagnostic::new(
            finding.code.as_str(),
            Severity::Warning,
            hazard.span,
            finding.message.clone(),
        )
        .with_text(finding.text());
        shown.notes = finding.notes.clone();
        shown.help = finding.help.clone();
        text.push_str(&pen.draw(&shown.with_note(note), None));
    }
    text
}
