//! Lengths of block members declared without one, `float a[];`: the largest constant index that
//! the shader uses, plus one (GLSL 4.60 §4.1.9).
//!
//! Function bodies have to be read for that, so it is done only for texts with such a member.

use super::ast::Item;
use super::declarations::{DeclarationReader, Lengths, Unsized};
use super::member_uses::MemberUses;
use super::parser::{Bodies, Parser};
use super::texts::Texts;
use crate::source::{ReadOptions, Source};

/// Returns a shader with the lengths of such members written into their declarations, which then
/// also take indices known only at run time; `None` if its own text has no such member.
pub fn sized(source: &Source, options: &ReadOptions) -> Option<Source> {
    let texts = Texts::new();
    let mut reader = super::reader(source, options, &texts, Bodies::Keep);
    let items = reader.read_items();
    let members = std::mem::take(&mut reader.unsized_members);
    let found = lengths(&mut reader, items, &members);
    let mut text = source.text.to_string();
    let mut written = false;
    // From the end, so that earlier places stay valid.
    for member in members.iter().rev().filter(|member| member.brackets.file == 0) {
        let place = member.brackets.start as usize..member.brackets.end as usize;
        let Some(Ok(length)) = found.get(&(member.instance, member.name)) else { continue };
        // The brackets may be those of a macro.
        if source.text.get(place.clone()).is_some_and(|text| text.starts_with('[')) {
            text.replace_range(place, &format!("[{length}]"));
            written = true;
        }
    }
    written.then(|| Source { text: text.into(), ..source.clone() })
}

/// Returns the lengths of members, from a reader that has kept the function bodies.
// No stage is passed: it decides `varying` and precisions only, and neither changes an index.
pub(super) fn lengths<'a>(
    reader: &mut DeclarationReader<'a>,
    items: Vec<Item<'a>>,
    members: &[Unsized<'a>],
) -> Lengths<'a> {
    let mut uses = MemberUses::new(members, &reader.constants);
    for mut item in items {
        match reader.parser.complete(std::slice::from_mut(&mut item), None) {
            Ok(()) => uses.item(&item),
            Err(_) if !may_use(&reader.parser, &item, members) => {}
            Err(error) => uses.unread(error.place()),
        }
    }
    let keys = members.iter().map(|member| (member.instance, member.name));
    keys.zip(uses.lengths()).collect()
}

/// Whether a declaration that cannot be parsed mentions one of the members.
fn may_use<'a>(parser: &Parser<'a>, item: &Item<'a>, members: &[Unsized<'a>]) -> bool {
    let tokens = match item {
        Item::Function(function) => &function.tokens,
        Item::Variables(declaration) => &declaration.tokens,
        Item::Block(_)
        | Item::Interface(_)
        | Item::Defaults(_)
        | Item::Requalified(..)
        | Item::Precision(_)
        | Item::Other(_) => return false,
    };
    let tokens = &parser.tokens()[tokens.clone()];
    tokens.iter().any(|token| members.iter().any(|member| member.name == token.text))
}
