//! What no compiler accepts in a block, although its layout could be computed: qualifiers that
//! members do not take, and initial values.

use super::ast::{BlockDecl, LayoutId, Qualifiers};
use super::declarations::Reader;
use super::parser::diagnostic_at;
use crate::diagnostic::{Code, Diagnostic};

/// The layout qualifiers that choose the rules of a block.
const PACKINGS: [&str; 5] = ["std140", "std430", "scalar", "shared", "packed"];

/// Layout qualifiers of blocks that their members do not take.
const OF_BLOCKS: [&str; 4] = ["binding", "set", "push_constant", "buffer_reference"];

impl<'a> Reader<'a> {
    /// Returns an error for each rejected part of a block.
    pub(super) fn rejected(&self, block: &BlockDecl<'a>) -> Vec<Diagnostic> {
        let mut found = Vec::new();
        self.unplaced(&block.qualifiers, &block.qualifiers, &mut found);
        for declaration in &block.members {
            let qualifiers = &declaration.qualifiers;
            self.unplaced(&block.qualifiers, qualifiers, &mut found);
            for id in &qualifiers.layout {
                let rule = match () {
                    () if is_one_of(id, &PACKINGS) => {
                        "GLSL 4.60 §4.4.5: the rules are chosen for a whole block"
                    }
                    () if is_one_of(id, &OF_BLOCKS) => {
                        "GLSL 4.60 §4.4.5: members take `offset`, `align` and the order of matrices"
                    }
                    () => continue,
                };
                let message = format!("`{}` is not allowed on a member of a block", id.name.text);
                found.push(self.at_id(id, message).with_note(rule));
            }
            found.extend(self.interpolated(qualifiers));
            for declarator in declaration.names.iter().filter(|name| !name.tokens.is_empty()) {
                let name = self.parser.token_of(&declarator.name);
                let message = format!("`{}` has an initial value", name.text);
                let rule = "GLSL 4.60 §4.3.9: members of blocks cannot have an initial value";
                found.push(diagnostic_at(&name, Code::Syntax, message).with_note(rule));
            }
        }
        found
    }

    /// Reports `offset` and `align` of a block or its member if the block's rules are the driver's.
    fn unplaced(
        &self,
        block: &Qualifiers<'a>,
        qualifiers: &Qualifiers<'a>,
        found: &mut Vec<Diagnostic>,
    ) {
        let packing = block.layout.iter().rev().find(|id| is_one_of(id, &PACKINGS));
        let Some(packing) = packing.filter(|id| is_one_of(id, &["shared", "packed"])) else {
            return;
        };
        for id in qualifiers.layout.iter().filter(|id| is_one_of(id, &["offset", "align"])) {
            let (name, rules) = (id.name.text, packing.name.text);
            let message = format!("`{name}` is not allowed in a block that is `{rules}`");
            let rule = "GLSL 4.60 §4.4.5: only std140 and std430 blocks take `offset` and `align`";
            found.push(self.at_id(id, message).with_note(rule));
        }
    }

    /// Returns an error for a qualifier of inputs and outputs.
    fn interpolated(&self, qualifiers: &Qualifiers<'a>) -> Option<Diagnostic> {
        let Qualifiers { flat, noperspective, centroid, sample, patch, .. } = qualifiers;
        if ![*flat, *noperspective, *centroid, *sample, *patch].contains(&true) {
            return None;
        }
        let words = ["flat", "noperspective", "centroid", "sample", "patch"];
        let tokens = &self.parser.tokens()[qualifiers.tokens.clone()];
        let token = tokens.iter().find(|token| words.contains(&token.text))?;
        let message =
            format!("`{}` is not allowed on a member of a uniform or buffer block", token.text);
        let rule = "GLSL 4.60 §4.3.9: only inputs and outputs are interpolated";
        Some(diagnostic_at(token, Code::Syntax, message).with_note(rule))
    }

    fn at_id(&self, id: &LayoutId<'a>, message: String) -> Diagnostic {
        diagnostic_at(&self.parser.token_of(&id.name), Code::LayoutQualifier, message)
    }
}

fn is_one_of(id: &LayoutId<'_>, names: &[&str]) -> bool {
    names.iter().any(|name| id.is(name))
}
