//! The parts of the text that is put together, and the names in it.

use std::ops::RangeFrom;
use std::rc::Rc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::super::outline::{Class, OutlineItem};
use super::references::{Reference, References, references};
use super::{LinkedModule, Linker, ROOT, Referent, Target};
use crate::source::Span;
use crate::source::joined::Joined;

/// A part of the text: the root module, or a declaration of another.
pub(super) struct Part {
    module: usize,
    start: u32,
    end: u32,
    /// What stands for ranges of it.
    edits: Vec<(u32, u32, Referent)>,
}

impl<'a> Linker<'a> {
    /// Returns a module, or one of its declarations, and notes what it uses.
    // Edits are noted with what they refer to, not with a text: names are not known before all
    // parts are.
    pub(super) fn part(&mut self, module: usize, index: Option<usize>) -> Part {
        let LinkedModule { joined, text, outline, .. } = &self.modules[module];
        let (joined, text, outline) = (Rc::clone(joined), *text, Rc::clone(outline));
        let numbers = index.map_or(0..outline.items.len(), |index| index..index + 1);
        let (start, end) = match index {
            Some(index) => (outline.items[index].start, outline.items[index].end),
            None => (0, text.len() as u32),
        };
        let mut edits: Vec<(u32, u32, Referent)> = Vec::new();
        for number in numbers {
            let item = &outline.items[number];
            let (from, to) = (item.name_span.start, item.name_span.end);
            edits.push((from, to, Referent::Declaration((module, number))));
            let References { all, locals } = references(text, &outline, item);
            for Reference { from, to, path } in all {
                let at = joined.place(Span { file: 0, start: from, end: to });
                match self.referent(module, &path, at, &text[..from as usize]) {
                    Ok(None) => drop(self.free.insert(path[0].clone())),
                    Ok(Some(referent)) => {
                        if let Referent::Declaration(target) = referent {
                            let name = self.used_name(target);
                            // In a function with a local of that name, the declaration needs
                            // another name.
                            if locals.contains(name) && name != &text[from as usize..to as usize] {
                                self.hidden.insert(target);
                            }
                        }
                        edits.push((from, to, referent));
                    }
                    // Blocks do not depend on what functions need.
                    Err(error) if item.class == Class::Fn => {
                        self.warn(error);
                        let last = path.last().cloned().unwrap_or_default();
                        edits.push((from, to, Referent::Value(last)));
                    }
                    Err(error) => self.fail(error),
                }
            }
            self.locals.extend(locals.into_iter().map(str::to_string));
        }
        edits.sort_by_key(|(from, ..)| *from);
        Part { module, start, end, edits }
    }

    /// Notes that a declaration is used; returns its name in its module.
    pub(super) fn used_name(&mut self, target: Target) -> &'a str {
        if target.0 != ROOT && self.known.insert(target) {
            self.used.push(target);
        }
        self.modules[target.0].outline.items[target.1].name
    }

    /// Returns the names in the text of all: their own, but for those of other modules that mean
    /// something else there. A function of the shader itself gives way to a predeclared one that
    /// another module uses.
    // A name is taken if the shader itself has it, or if it is used but declared nowhere (`max`,
    // `vec3f`): giving it to a declaration would change what those uses mean. Numbers from 2 on
    // make others.
    pub(super) fn names(&self) -> FxHashMap<Target, String> {
        let items = &self.modules[ROOT].outline.items;
        let mut taken: FxHashSet<String> = items
            .iter()
            .map(|item| item.name.to_string())
            .chain(self.free.iter().cloned())
            .collect();
        let mut names = FxHashMap::default();
        // Numbers that were tried stay taken.
        let mut numbers: FxHashMap<&str, RangeFrom<u64>> = FxHashMap::default();
        let is_mixed = |(number, item): &(usize, &OutlineItem<'_>)| {
            let is_hidden = self.hidden.contains(&(ROOT, *number));
            item.class == Class::Fn && (is_hidden || self.free.contains(item.name))
        };
        let mixed = items.iter().enumerate().filter(is_mixed).map(|(number, _)| (ROOT, number));
        for target in mixed.chain(self.used.iter().copied()) {
            let own = self.modules[target.0].outline.items[target.1].name;
            let own = self.exported.get(&target).map_or(own, String::as_str);
            let keeps = target.0 != ROOT && !self.hidden.contains(&target);
            let numbers = numbers.entry(own).or_insert(2..);
            let others = numbers.map(|number| format!("{own}_{number}"));
            let name = std::iter::once(own.to_string())
                .filter(|_| keeps)
                .chain(others.filter(|name| !self.locals.contains(name)))
                .find(|name| taken.insert(name.clone()))
                .expect("there are more numbers than names");
            names.insert(target, name);
        }
        names
    }

    /// Returns the name of a declaration in the text of all.
    pub(super) fn name_of<'n>(
        &'n self,
        target: Target,
        names: &'n FxHashMap<Target, String>,
    ) -> &'n str {
        let own = self.modules[target.0].outline.items[target.1].name;
        names.get(&target).map_or(own, String::as_str)
    }

    // Text between edits is copied with its places; an edit that changes nothing is skipped, which
    // keeps longer runs in one piece.
    pub(super) fn write(
        &self,
        part: &Part,
        names: &FxHashMap<Target, String>,
        joined: &mut Joined,
    ) {
        let module = &self.modules[part.module];
        let mut last = part.start;
        for (from, to, referent) in &part.edits {
            let name = match referent {
                Referent::Value(value) => value,
                Referent::Declaration(target) => self.name_of(*target, names),
            };
            if name != &module.text[*from as usize..*to as usize] {
                joined.push_part(&module.joined, last, *from);
                let place = module.joined.place(Span { file: 0, start: *from, end: *to });
                joined.push(name, place);
                last = *to;
            }
        }
        joined.push_part(&module.joined, last, part.end);
    }
}
