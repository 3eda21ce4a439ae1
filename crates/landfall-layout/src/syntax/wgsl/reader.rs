//! What is known while the declarations that blocks depend on are read.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::constants::Outcome;
use super::outline::Outline;
use super::report;
use super::report::{Refused, Reports};
use super::types::Typed;
use crate::shape::Override;
use crate::source::{ReadOptions, Span};

/// What nesting may cost, so as to fit the stack of a thread: 100 arrays in one another.
const DEEPEST_GRAMMAR: u32 = 200;

/// A type expression; the name it resolves costs another level.
const TYPE_LEVEL: u32 = 2;

/// An expression in brackets, or behind an operator.
const EXPRESSION_LEVEL: u32 = 4;

/// A declaration that is read when first asked for.
#[derive(Clone, Debug)]
pub(super) enum Known<T> {
    /// It is being read: asking again means that it depends on itself.
    Open,
    /// What it says.
    Done(T),
    /// It cannot be read, and a finding says why.
    Broken,
}

/// The text, its outline, and what was read of it so far.
pub(super) struct Reader<'a> {
    pub(super) text: &'a str,
    pub(super) outline: &'a Outline<'a>,
    pub(super) options: &'a ReadOptions,
    pub(super) reports: Reports,
    /// Structures and aliases by their index in the outline.
    pub(super) types: FxHashMap<usize, Known<Typed>>,
    /// Constants and overrides by their index in the outline.
    pub(super) constants: FxHashMap<usize, Known<Outcome>>,
    /// Overrides that a size was computed from.
    pub(super) overrides: Vec<Override>,
    /// Whether an override was asked for since this was last cleared.
    pub(super) asked_override: bool,
    /// How deep the grammar, and names that stand for other text, are nested right now.
    depth: u32,
    /// Whether all constants up to some deep one were already read in order.
    pub(super) swept: bool,
    /// Whether the missing `enable f16;` was spoken of.
    pub(super) warned_f16: bool,
}

impl<'a> Reader<'a> {
    pub(super) fn new(
        text: &'a str,
        outline: &'a Outline<'a>,
        options: &'a ReadOptions,
        reports: Reports,
    ) -> Reader<'a> {
        Reader {
            text,
            outline,
            options,
            reports,
            types: FxHashMap::default(),
            constants: FxHashMap::default(),
            overrides: Vec::new(),
            asked_override: false,
            depth: 0,
            swept: false,
            warned_f16: false,
        }
    }

    /// Reads what a name stands for, if that is not too deep.
    pub(super) fn deeper_name<T>(
        &mut self,
        at: Span,
        read: impl FnOnce(&mut Self) -> Result<T, Refused>,
    ) -> Result<T, Refused> {
        self.descend(at, 1, read)
    }

    /// The same for part of a type.
    pub(super) fn deeper_type<T>(
        &mut self,
        at: Span,
        read: impl FnOnce(&mut Self) -> Result<T, Refused>,
    ) -> Result<T, Refused> {
        self.descend(at, TYPE_LEVEL, read)
    }

    /// The same for part of an expression.
    pub(super) fn deeper_expression<T>(
        &mut self,
        at: Span,
        read: impl FnOnce(&mut Self) -> Result<T, Refused>,
    ) -> Result<T, Refused> {
        self.descend(at, EXPRESSION_LEVEL, read)
    }

    fn descend<T>(
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

    pub(super) fn depth(&self) -> u32 {
        self.depth
    }

    /// The text of a span.
    pub(super) fn slice(&self, span: Span) -> &'a str {
        &self.text[span.start as usize..span.end as usize]
    }

    /// Notes that a size depends on an override.
    pub(super) fn note_override(&mut self, name: &str, id: Option<u32>, value: Option<i64>) {
        if !self.overrides.iter().any(|known| &*known.name == name) {
            self.overrides.push(Override { name: Arc::from(name), id, value });
        }
    }
}
