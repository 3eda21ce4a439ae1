//! Reads the variants of a lock: the sets of macros, and which blocks each of them has.

use super::blocks::{BlockReader, MacroSet, Sets};
use crate::error::Error;
use crate::layout::BlockLayout;
use crate::lock::place::{Object, WRITE_AGAIN};
use crate::lock::{RecordedVariant, check};
use crate::shader::variant_name;
use crate::text::json::Node;

impl BlockReader<'_> {
    /// The path of a shader in the output of `layout`, with the variants that have its blocks.
    pub(super) fn title(
        &self,
        object: Object<'_>,
        path: Option<String>,
    ) -> Result<Option<String>, Error> {
        let Some(node) = object.get("variants") else { return Ok(path) };
        let sets = self.place.list(node, "variants")?.iter();
        let names: Vec<String> =
            sets.map(|set| Ok(variant_name(&self.set(set)?))).collect::<Result<_, Error>>()?;
        Ok(path.map(|path| format!("{path} with {}", names.join(" or "))))
    }

    /// The sets of macros of a lock.
    pub(super) fn sets(&self, object: Object<'_>) -> Result<Sets, Error> {
        let Sets(mut sets) = Sets::none();
        let Some(node) = object.get("variants") else { return Ok(Sets(sets)) };
        for item in self.place.list(node, "variants")? {
            let set = self.set(item)?;
            if sets.contains(&set) {
                let message = "has the same macros twice in `variants`";
                return Err(self.place.error(item.start, message).with_help(WRITE_AGAIN));
            }
            sets.push(set);
        }
        Ok(Sets(sets))
    }

    fn set(&self, node: &Node) -> Result<MacroSet, Error> {
        let macros = self.place.list(node, "variants")?.iter();
        macros
            .map(|one| {
                let spelled = self.place.text(one, "variants")?;
                // `NAME` is `NAME=1`, as with `-D` of a compiler.
                let (name, text) = spelled.split_once('=').unwrap_or((spelled, "1"));
                Ok((name.to_string(), text.to_string()))
            })
            .collect()
    }

    /// The variants that have a block, by their indices.
    pub(super) fn having(&self, block: &Node, sets: &Sets) -> Result<Vec<usize>, Error> {
        let object = self.place.object(block, "a block")?;
        // Without the key every variant has the block.
        let Some(node) = object.get("variants") else { return Ok((0..sets.0.len()).collect()) };
        let mut having = Vec::new();
        for item in self.place.list(node, "variants")? {
            let set = self.set(item)?;
            let known = sets.0.iter().position(|other| *other == set);
            having.push(known.ok_or_else(|| {
                let message = "has a block of a variant that `variants` of the lock does not list";
                self.place.error(item.start, message).with_help(WRITE_AGAIN)
            })?);
        }
        Ok(having)
    }

    /// Sorts the blocks of a lock by the variants that have them: those without macros, and those of
    /// each set.
    pub(super) fn divided(
        &self,
        sets: Sets,
        blocks: Vec<(BlockLayout, Vec<usize>)>,
    ) -> Result<(Vec<BlockLayout>, Vec<RecordedVariant>), Error> {
        // A block that several variants have is in each of them.
        let of = |set: usize| -> Result<Vec<BlockLayout>, Error> {
            let all = blocks.iter().filter(|(_, having)| having.contains(&set));
            let all: Vec<BlockLayout> = all.map(|(block, _)| block.clone()).collect();
            check::blocks(&self.place, &all)?;
            Ok(all)
        };
        let mut variants = Vec::new();
        // Set 0 is the shader without macros.
        for (at, macros) in sets.0.iter().enumerate().skip(1) {
            variants.push(RecordedVariant { macros: macros.clone(), blocks: of(at)? });
        }
        Ok((of(0)?, variants))
    }
}
