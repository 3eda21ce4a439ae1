//! The names at global scope, of which those of blocks are declared once (GLSL 4.60 §4.3.9).

use rustc_hash::FxHashMap;
use std::collections::hash_map::Entry;

use super::ast::{Item, Storage, TypeBase};
use super::lexer::Token;
use super::parser::Parser;
use super::report::diagnostic_at;
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// The kind of declaration of a name at global scope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Declared {
    /// The name of a block with that storage.
    Block(Storage),
    /// The instance of a block, or a member of a block without one.
    OfBlock,
    Function,
    Other,
}

#[derive(Default)]
pub(super) struct Globals<'a>(FxHashMap<&'a str, (Declared, Span)>);

impl<'a> Globals<'a> {
    /// Records the names of a declaration and returns the errors about those that a block has.
    pub fn declare(&mut self, parser: &Parser<'a>, item: &Item<'a>) -> Vec<Diagnostic> {
        let mut errors = Vec::new();
        let mut add = |token: Token<'a>, as_: Declared| errors.extend(self.add(&token, as_));
        match item {
            Item::Block(block) => {
                add(parser.token_of(&block.name), Declared::Block(block.qualifiers.storage));
                let reference = block.qualifiers.find("buffer_reference").is_some();
                match &block.instance {
                    // It is a type, whose members are reached through its values.
                    _ if reference => {}
                    Some(instance) => add(parser.token_of(instance), Declared::OfBlock),
                    None => {
                        for name in block.members.iter().flat_map(|member| &member.names) {
                            add(parser.token_of(&name.name), Declared::OfBlock);
                        }
                    }
                }
            }
            Item::Variables(declaration) => {
                if let TypeBase::Struct(structure) = &declaration.ty.base {
                    add(parser.token_of(&structure.name), Declared::Other);
                }
                for name in &declaration.names {
                    add(parser.token_of(&name.name), Declared::Other);
                }
            }
            Item::Function(function) => add(parser.token_of(&function.name), Declared::Function),
            Item::Interface(_)
            | Item::Defaults(_)
            | Item::Requalified(..)
            | Item::Precision(_)
            | Item::Other(_) => {}
        }
        errors
    }

    pub fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    // GLSL 4.60 §4.2.2 has one name space for variables, types and functions. Clashes among those
    // are left to the reader of each; here only those that involve a block are found.
    fn add(&mut self, token: &Token<'a>, as_: Declared) -> Option<Diagnostic> {
        if token.text.is_empty() || token.text == "struct" {
            return None;
        }
        let (before, span) = match self.0.entry(token.text) {
            Entry::Vacant(entry) => {
                entry.insert((as_, token.span));
                return None;
            }
            Entry::Occupied(entry) => *entry.get(),
        };
        let clash = match (before, as_) {
            // Blocks of other storage are of other interfaces.
            (Declared::Block(before), Declared::Block(now)) => before == now,
            // A member of a block hides a function declared before it.
            (Declared::Function, Declared::OfBlock) => false,
            (Declared::Function | Declared::Other, Declared::Function | Declared::Other) => false,
            _ => true,
        };
        clash.then(|| {
            let message = format!("`{}` is declared twice at global scope", token.text);
            let note = "names of blocks, of their instances, and of members of blocks without an \
                        instance are global (GLSL 4.60 §4.3.9)";
            diagnostic_at(token, Code::DuplicateName, message)
                .with_label(span, "previously declared here")
                .with_note(note)
        })
    }
}
