//! Inlay hints: the bytes of members, blocks and structures, where these are declared.

use std::ops::Range;

use gen_lsp_types::{InlayHint, Position};
use landfall_layout::Rules;
use landfall_layout::format::phrases::{counted, number};

use crate::declarations::{BlockPlacement, DeclarationKind, PlacedBytes, PlacedDeclaration};
use crate::positions::LineText;
use crate::settings::HintSettings;

/// Returns the hints of the declarations of a file in a range of it.
pub fn hints(
    declarations: &[&PlacedDeclaration],
    text: &LineText,
    range: Range<u32>,
    settings: HintSettings,
) -> Vec<InlayHint> {
    let plain = text.plain();
    let inside = declarations.iter().filter(|one| range.contains(&one.span.start));
    let hints = inside.filter_map(|declaration| {
        let label = label(declaration, settings)?;
        let at = match declaration.kind {
            DeclarationKind::Member => end_of_declarator(plain, declaration.span.end),
            _ => declaration.span.end,
        };
        Some(hint(text.position(at), label))
    });
    hints.collect()
}

fn hint(position: Position, label: String) -> InlayHint {
    InlayHint {
        position,
        label: label.into(),
        kind: None,
        text_edits: None,
        tooltip: None,
        padding_left: Some(true),
        padding_right: None,
        data: None,
    }
}

/// The label of a declaration; under several rules, or in several places, each that differs.
fn label(declaration: &PlacedDeclaration, settings: HintSettings) -> Option<String> {
    let mut labels: Vec<(String, &BlockPlacement)> = Vec::new();
    for placement in declaration.distinct() {
        let label = match declaration.kind {
            DeclarationKind::Member => member(&placement.bytes, settings),
            kind if kind.has_members() && settings.blocks => whole(&placement.bytes),
            _ => String::new(),
        };
        if !label.is_empty() && labels.iter().all(|(known, _)| *known != label) {
            labels.push((label, placement));
        }
    }
    match labels.as_slice() {
        [] => None,
        // In WGSL there is no choice.
        [(label, placement)]
            if declaration.kind == DeclarationKind::Block && placement.rules != Rules::Wgsl =>
        {
            Some(format!("{label}, {}", placement.rules.name()))
        }
        [(label, _)] => Some(label.clone()),
        several => {
            let each = several.iter().map(|(label, at)| format!("{}: {label}", at.rules.name()));
            Some(each.collect::<Vec<_>>().join(" · "))
        }
    }
}

fn member(bytes: &PlacedBytes, settings: HintSettings) -> String {
    let mut parts = Vec::new();
    if settings.padding && bytes.before > 0 {
        parts.push(format!("{} padding before", number(bytes.before)));
    }
    if settings.offsets {
        parts.push(format!("@{}", bytes.offset));
    }
    if settings.sizes {
        parts.push(match bytes.size {
            Some(size) => counted(size as usize, "byte"),
            None => "runtime-sized".to_string(),
        });
    }
    if settings.strides && !bytes.strides.is_empty() {
        let strides: Vec<String> = bytes.strides.iter().map(u64::to_string).collect();
        parts.push(format!("stride {}", strides.join(" × ")));
    }
    if settings.padding && bytes.after > 0 {
        parts.push(format!("+{} padding", number(bytes.after)));
    }
    parts.join(", ")
}

fn whole(bytes: &PlacedBytes) -> String {
    let size = counted(bytes.size.unwrap_or_default() as usize, "byte");
    match bytes.after {
        0 => size,
        padding => format!("{size}, {} of them padding", number(padding)),
    }
}

/// The end of a member's declarator: before the `,` or `;` that ends it, its array lengths and type
/// included.
pub fn end_of_declarator(text: &str, name_end: u32) -> u32 {
    let rest = text.get(name_end as usize..).unwrap_or_default();
    let mut depth = 0_usize;
    let mut end = 0;
    for (at, c) in rest.char_indices() {
        match c {
            '[' | '(' | '<' => depth += 1,
            ']' | ')' | '>' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => break,
            ';' | '}' | '{' | '\n' | '\r' => break,
            '/' if rest[at + 1..].starts_with(['/', '*']) => break,
            _ => {}
        }
        if !c.is_whitespace() {
            end = at + c.len_utf8();
        }
    }
    name_end + end as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_declarator_ends_before_its_comma() {
        for (text, end) in [
            ("a[4], b;", 4),
            ("a ;", 1),
            ("a: array<vec4<f32>, 4>,", 22),
            ("a: f32 // why", 6),
            ("a: f32\n}", 6),
            ("a", 1),
        ] {
            assert_eq!(end_of_declarator(text, 1), end, "{text}");
        }
    }
}
