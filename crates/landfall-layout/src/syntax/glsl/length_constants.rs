//! The constants and macros that the lengths of arrays are written with, for generated code.

use rustc_hash::FxHashSet;

use super::ast::Dim;
use super::declarations::DeclarationReader;
use super::lexer::{Kind, Token};
use crate::shape::{AddressSpace, Block, LengthConstant, Member, Type};
use crate::source::Span;

impl<'a> DeclarationReader<'a> {
    /// Records the names of a length; `owner` is the name of its member, or of its block.
    pub(super) fn note_length_constants(&mut self, owner: Span, dim: &Dim<'a>) {
        let tokens = &self.parser.tokens()[dim.tokens.clone()];
        let is_named = |token: &Token<'_>| token.kind == Kind::Name || token.definition.is_some();
        if !tokens.iter().any(is_named) {
            return;
        }
        // The tokens of a macro have the place where its name stands.
        let parts: Vec<Vec<Token<'a>>> =
            tokens.chunk_by(|a, b| a.span == b.span).map(<[_]>::to_vec).collect();
        for part in parts.iter().filter(|part| part.iter().any(is_named)) {
            let name = match part[0].definition {
                Some(_) => self.macro_name(part[0].span),
                None => Some(part[0].text.to_string()),
            };
            let value = self.constants.unspecialised(part, part[0].span);
            if let Some((name, value)) = name.zip(value) {
                let constant = LengthConstant { name: name.into(), value };
                self.length_constants.push((owner, constant));
            }
        }
    }

    /// The name of the macro without parameters that is used at a place, unless it is the language's.
    fn macro_name(&mut self, at: Span) -> Option<String> {
        let preprocessor = self.parser.preprocessor();
        let name = preprocessor.files.text(at);
        let definition = preprocessor.macros.get(name)?;
        let is_own = definition.parameters.is_none() && !name.to_lowercase().starts_with("gl_");
        is_own.then(|| name.to_string())
    }
}

/// Returns the constants of members that blocks hold, each once, without names of two values.
pub(super) fn of_blocks(
    noted: Vec<(Span, LengthConstant)>,
    blocks: &[Block],
) -> Vec<LengthConstant> {
    let mut owners = FxHashSet::default();
    let mut structures = FxHashSet::default();
    if !noted.is_empty() {
        for block in blocks.iter().filter(|block| block.space != AddressSpace::Default) {
            owners.insert(block.span);
            add_members(&block.members, &mut owners, &mut structures);
        }
    }
    let used = noted.into_iter().filter(|(owner, _)| owners.contains(owner));
    LengthConstant::distinct(used.map(|(_, constant)| constant))
}

fn add_members(members: &[Member], owners: &mut FxHashSet<Span>, structures: &mut FxHashSet<Span>) {
    for member in members {
        owners.insert(member.span);
        if let Type::Struct(structure) = member.ty.innermost() {
            // Once a structure, however many members have it.
            if structures.insert(structure.span) {
                add_members(&structure.members, owners, structures);
            }
        }
    }
}
