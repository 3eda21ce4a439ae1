//! `buffer-too-small`: hand-written sizes and offsets that do not fit the layout.

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::settings::{Figure, Row, Table};
use super::show::{bytes, is_called, listing, number, place};
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::layout::BlockLayout;
use landfall_layout::layout::explain::explain;
use landfall_layout::text::edit_distance::suggestion;
use landfall_layout::text::glob;

pub(super) const LINT: Lint = Lint {
    code: "buffer-too-small",
    level: Level::Deny,
    what: "a buffer size or offset in the configuration that does not fit the layout",
    why: "Host code that computes a buffer's size by hand (`48 * 128 + 4`) leaves out the padding \
          after the last member, and the driver refuses the buffer or reads past its end. A table \
          of names and offsets goes stale when a member moves, and later uploads overwrite other \
          members. A buffer larger than needed is accepted. A table that names a block or member \
          that does not exist is reported too, because it no longer checks anything.",
    example: "#version 330 core\n\
              // Checked with the table `PointLightBlock`, size 48 * 128 + 4.\n\
              struct PointLight { vec3 pos; vec3 color; float intensity; vec3 fade; };\n\
              layout(std140) uniform PointLightBlock {\n    \
              PointLight data[128];\n    \
              int count;\n\
              } u_lights;\n\
              out vec4 shade;\n\
              void main() { shade = vec4(u_lights.data[0].color, 1.0); }\n",
    fix: "Write the number from the layout, both in the host code and in the table.",
    check: Check::Tree(check),
};

fn check(subjects: &[Subject<'_>], settings: &Settings) -> Vec<Finding> {
    settings.tables.iter().flat_map(|table| held_against(table, subjects)).collect()
}

fn held_against(table: &Table, subjects: &[Subject<'_>]) -> Vec<Finding> {
    let files = || subjects.iter().filter(|s| glob::matches(&table.file, &s.source.path));
    let blocks = || {
        files().flat_map(|subject| {
            let declared = subject.shader.blocks.iter();
            // Loose uniforms have no buffer.
            declared.filter(|b| !b.gathered).map(move |block| (subject, block))
        })
    };
    let meant: Vec<_> = blocks().filter(|(_, block)| is_called(block, &table.block)).collect();
    if meant.is_empty() {
        let names = blocks()
            .flat_map(|(_, block)| std::iter::once(&*block.name).chain(block.instance.as_deref()));
        return vec![unknown_block(table, files().count(), names)];
    }
    let mut found: Vec<Finding> = Vec::new();
    for (subject, block) in meant {
        let wrong_rows = table.offsets.iter().filter_map(|row| wrong(subject, block, table, row));
        for mut finding in too_small(subject, block, table).into_iter().chain(wrong_rows) {
            // Each stage declares the block again; the table is wrong once.
            let told =
                found.iter_mut().find(|f| f.place() == finding.place() && f.about == finding.about);
            match told {
                Some(told) if told.message == finding.message => {
                    // The first label is the place, which both have.
                    told.labels.extend(finding.labels.drain(1..));
                }
                Some(_) | None => found.push(finding),
            }
        }
    }
    found
}

fn unknown_block<'a>(table: &Table, files: usize, names: impl Iterator<Item = &'a str>) -> Finding {
    let message = match (files, table.file.is_empty()) {
        (0, false) => format!("no shader matches `{}`", table.file),
        (_, true) => format!("no shader has a block `{}`", table.block),
        (_, false) => {
            format!("no shader that matches `{}` has a block `{}`", table.file, table.block)
        }
    };
    let code = super::layout_warnings::UNKNOWN_BLOCK.code;
    let finding = Finding::at(code, table.block.as_str(), table.place.clone(), message);
    Finding { help: suggestion(&table.block, names), ..finding }
}

fn too_small(subject: &Subject<'_>, block: &BlockLayout, table: &Table) -> Option<Finding> {
    let figure = table.size.as_ref()?;
    let size = block.size.filter(|&size| size > figure.bytes)?;
    let message = format!(
        "{} for block `{}`, but it needs {}",
        spelled(figure, "bytes"),
        block.name,
        bytes(size)
    );
    let mut finding = Finding::at(
        LINT.code,
        format!("{} size", block.name),
        or(&figure.place, &table.place),
        message,
    )
    .with_text(format!("{} too few", bytes(size - figure.bytes)))
    .with_label(place(subject, block.span), format!("{} by {}", bytes(size), block.rules.name()));
    // If no more is missing than the padding at the end, that was left out.
    if let Some(tail) = tail(block).filter(|tail| size - figure.bytes <= tail.size) {
        finding = finding.with_note(format!(
            "the last member ends at byte {}; {} of tail padding belong to the block",
            tail.offset,
            bytes(tail.size)
        ));
    }
    finding.listing = listing(subject.shader, block);
    Some(finding.with_help(format!("write {size}")))
}

/// Returns the padding after the last member.
fn tail(block: &BlockLayout) -> Option<Tail> {
    let (size, end) = (block.size?, block.data_size?);
    (size > end).then_some(Tail { offset: end, size: size - end })
}

struct Tail {
    offset: u64,
    size: u64,
}

fn wrong(subject: &Subject<'_>, block: &BlockLayout, table: &Table, row: &Row) -> Option<Finding> {
    let at = or(&row.offset.place, &table.place);
    let about = format!("{}.{}", block.name, row.path);
    let found = match explain(block, &row.path, subject.shader.language) {
        Ok(found) => found,
        Err(fault) => {
            let message = format!("{}: {}", table.block, fault.kind);
            let finding = Finding::at(LINT.code, about, at, message)
                .with_label(place(subject, block.span), "the block");
            return Some(match fault.kind.help() {
                Some(help) => finding.with_help(help),
                None => finding,
            });
        }
    };
    if found.offset == row.offset.bytes {
        return None;
    }
    let message = format!(
        "`{}` of block `{}` is listed at offset {}, but it is at {}",
        row.path,
        block.name,
        figure_text(&row.offset, |place| place.to_string()),
        found.offset
    );
    let mut finding = Finding::at(LINT.code, about, at, message)
        .with_text(format!("the shader reads it from byte {}", found.offset))
        .with_label(place(subject, block.span), format!("laid out by {}", block.rules.name()))
        .with_help(format!("write {}", found.offset));
    finding.listing = listing(subject.shader, block);
    Some(finding)
}

/// Returns a figure for a message: `48 * 128 + 4 = 6148 bytes are allocated`.
fn spelled(figure: &Figure, unit: &str) -> String {
    format!("{} {unit} are allocated", figure_text(figure, number))
}

/// The text of a figure and its value, a count or a place.
fn figure_text(figure: &Figure, shown: fn(u64) -> String) -> String {
    let number = shown(figure.bytes);
    match figure.written.trim() {
        text if text.is_empty() || text == figure.bytes.to_string() => number,
        text => format!("{text} = {number}"),
    }
}

/// Returns a figure's own place, or the table's if it has none.
fn or(own: &Place, table: &Place) -> Place {
    if own.path.is_empty() { table.clone() } else { own.clone() }
}
