//! The state of parsing the declarations that blocks depend on.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::constants::Outcome;
use super::lexer::{WgslLexer, WgslToken};
use super::outline::Outline;
use super::report::{self, Refused, Reports};
use super::types::Typed;
use crate::shape::{LengthConstant, Override};
use crate::source::{ReadOptions, Span};

/// The limit on the cost of nesting, so as to fit the stack of a thread: 100 nested arrays.
const DEEPEST_GRAMMAR: u32 = 200;

/// The cost of the declaration of a name.
// The costs stand for frames of the stack: an expression in brackets passes more functions that
// call each other than a type.
pub(super) const NAME_LEVEL: u32 = 1;

/// The cost of a type expression; the name it resolves costs another level.
pub(super) const TYPE_LEVEL: u32 = 2;

/// The cost of an expression in brackets, or after an operator.
pub(super) const EXPRESSION_LEVEL: u32 = 4;

/// A declaration that is parsed on first use.
// A name is read once, whatever the number of its uses, and in any order of the text: WGSL has no
// declaration before use at module scope (§5).
#[derive(Clone, Debug)]
pub(super) enum Known<T> {
    /// Being parsed: another use means that it depends on itself.
    Open,
    Done(T),
    /// Failed to parse; the error is reported.
    Broken,
}

/// The text, its outline, and the declarations parsed so far.
pub(super) struct ModuleReader<'a> {
    pub(super) text: &'a str,
    pub(super) outline: &'a Outline<'a>,
    pub(super) options: &'a ReadOptions,
    pub(super) reports: Reports,
    /// Structures and aliases by index in the outline.
    pub(super) types: FxHashMap<usize, Known<Typed>>,
    /// Constants and overrides by index in the outline.
    pub(super) constants: FxHashMap<usize, Known<Outcome>>,
    /// The overrides that sizes depend on.
    pub(super) overrides: Vec<Override>,
    /// The constants that lengths are written with.
    pub(super) length_constants: Vec<LengthConstant>,
    /// Whether an override was used since this was last cleared.
    pub(super) used_override: bool,
    /// The current nesting of the grammar and of names that stand for other text.
    pub(super) depth: u32,
    /// Whether all constants up to some deep one were evaluated in order.
    pub(super) swept: bool,
    /// Whether the missing `enable f16;` was reported.
    pub(super) warned_f16: bool,
}

impl<'a> ModuleReader<'a> {
    pub(super) fn new(
        text: &'a str,
        outline: &'a Outline<'a>,
        options: &'a ReadOptions,
        reports: Reports,
    ) -> ModuleReader<'a> {
        ModuleReader {
            text,
            outline,
            options,
            reports,
            types: FxHashMap::default(),
            constants: FxHashMap::default(),
            overrides: Vec::new(),
            length_constants: Vec::new(),
            used_override: false,
            depth: 0,
            swept: false,
            warned_f16: false,
        }
    }

    /// Consumes that sign, or reports that it is missing.
    pub(super) fn expect(
        &mut self,
        lexer: &mut WgslLexer<'_>,
        sign: u8,
    ) -> Result<WgslToken, Refused> {
        self.reports.checked(report::expect(lexer, sign))
    }

    /// Parses a part of a type or expression, unless nested too deep.
    pub(super) fn deeper<T>(
        &mut self,
        at: Span,
        levels: u32,
        read: impl FnOnce(&mut Self) -> Result<T, Refused>,
    ) -> Result<T, Refused> {
        if self.depth > DEEPEST_GRAMMAR {
            return Err(self.reports.refuse(report::too_deep(at)));
        }
        self.depth += levels;
        let result = read(self);
        self.depth -= levels;
        result
    }

    pub(super) fn slice(&self, span: Span) -> &'a str {
        &self.text[span.start as usize..span.end as usize]
    }

    /// Records that a size depends on an override.
    pub(super) fn note_override(&mut self, name: &str, id: Option<u32>, value: Option<i64>) {
        if !self.overrides.iter().any(|known| &*known.name == name) {
            self.overrides.push(Override { name: Arc::from(name), id, value });
        }
    }
}
