//! Names in function bodies that no declaration of the module has: variables, and members that no
//! structure has. Functions and types are not looked at.

use rustc_hash::FxHashSet;

use super::lexer::{Kind, WgslLexer};
use super::outline::{Class, Outline};
use super::uses::{self, Word};
use super::{predeclared, report};
use crate::diagnostic::{Code, Diagnostic};
use crate::syntax::{MAX_NAME_ERRORS, first_name_errors};

/// Returns an error for each such name.
// A member is looked for in all structures: types of expressions are not known. So some errors are
// missed, none is false.
pub(super) fn undeclared<'a>(text: &'a str, outline: &Outline<'a>) -> Vec<Diagnostic> {
    let members = members(text, outline);
    let mut errors = Vec::new();
    for item in outline.items.iter().filter(|item| item.class == Class::Fn) {
        uses::walk(text, outline, item, &mut |names, word, token, lexer| {
            if errors.len() > MAX_NAME_ERRORS {
                return;
            }
            let name = lexer.text_of(token);
            let at = report::span(token);
            match word {
                Word::Member if !members.contains(name) && !is_predeclared_member(name) => {
                    let message = format!("no structure has a member `{name}`");
                    let error = Diagnostic::error(Code::UnknownMember, at, message);
                    errors.push(report::misspelt(error, name, members.iter().copied()));
                }
                // What is called or has a template may be a function or a type.
                Word::Other if !follows(lexer) && !is_predeclared(name) => {
                    let message = format!("`{name}` is not declared");
                    let error = Diagnostic::error(Code::UnknownName, at, message);
                    let known = outline.items.iter().map(|item| item.name);
                    errors.push(report::misspelt(error, name, known.chain(names.locals())));
                }
                Word::Member | Word::Module(_) | Word::Local | Word::Other => {}
            }
        });
    }
    first_name_errors(errors.into_iter())
}

/// Whether a call or a template list follows.
fn follows(lexer: &WgslLexer<'_>) -> bool {
    let next = lexer.clone().next();
    next.is(b'(') || next.is(b'<')
}

/// The members of all structures.
fn members<'a>(text: &'a str, outline: &Outline<'a>) -> FxHashSet<&'a str> {
    let mut members = FxHashSet::default();
    for item in outline.items.iter().filter(|item| item.class == Class::Struct) {
        let mut lexer = WgslLexer::new(text, item.rest);
        while let Some(token) = lexer.next_before(item.end) {
            if token.kind == Kind::Word && lexer.peek().is(b':') {
                members.insert(lexer.text_of(token));
            }
        }
    }
    members
}

/// Whether a member may be components of a vector, or one of a structure of the language or of naga.
fn is_predeclared_member(name: &str) -> bool {
    let is_swizzle = ["xyzw", "rgba"].iter().any(|set| name.chars().all(|c| set.contains(c)));
    (is_swizzle && name.len() <= 4) || MEMBERS.contains(&name)
}

/// Members of the results of `frexp`, `modf`, `atomicCompareExchangeWeak`, and of naga's structures
/// for rays.
const MEMBERS: &[&str] = &[
    "fract",
    "whole",
    "exp",
    "old_value",
    "exchanged",
    "flags",
    "cull_mask",
    "tmin",
    "tmax",
    "origin",
    "dir",
    "kind",
    "t",
    "instance_custom_data",
    "instance_index",
    "sbt_record_offset",
    "geometry_index",
    "primitive_index",
    "barycentrics",
    "front_face",
    "object_to_world",
    "world_to_object",
    "hit_triangle_vertex_positions",
];

/// Whether a name is a keyword, a type, or an enumerant of the language or of naga.
fn is_predeclared(name: &str) -> bool {
    name.starts_with("RAY_")
        || name == "_"
        || WORDS.contains(&name)
        || predeclared::lookup(name).is_some()
}

/// Keywords (§15.1), and the enumerants that template lists and constants may hold (§6.4, §14).
const WORDS: &[&str] = &[
    "break",
    "case",
    "const_assert",
    "continue",
    "continuing",
    "default",
    "discard",
    "else",
    "fn",
    "if",
    "loop",
    "return",
    "switch",
    "true",
    "false",
    "while",
    "function",
    "private",
    "workgroup",
    "uniform",
    "storage",
    "handle",
    "immediate",
    "push_constant",
    "read",
    "write",
    "read_write",
    "atomic",
    "task_payload",
    "ray_payload",
    "incoming_ray_payload",
];
