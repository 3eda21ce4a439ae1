//! Declarations that no compiler takes although their bytes are known: qualifiers that blocks and
//! their members may not have, and blocks before the version that has them.

use super::ast::{BlockDecl, Declaration, LayoutId, Qualifiers, Storage};
use super::declarations::DeclarationReader;
use super::lexer::Token;
use super::parser::diagnostic_at;
use super::qualifiers::{INTERPOLATION, OTHER_STORAGE};
use super::types::{Builtin, builtin};
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{AddressSpace, Rules};
use crate::source::Target;

/// Entries of `layout(…)` that no member of a block takes (GLSL 4.60 §4.4).
const NOT_ON_MEMBERS: &[&str] = &[
    "std140",
    "std430",
    "scalar",
    "shared",
    "packed",
    "binding",
    "push_constant",
    "location",
    "component",
    "index",
    "constant_id",
];

/// Entries of `layout(…)` that no `uniform` or `buffer` block takes.
const NOT_ON_BLOCKS: &[&str] = &["location", "component", "index", "offset", "constant_id"];

impl<'a> DeclarationReader<'a> {
    /// Returns what makes a block illegal in every version; `written` are the rules in effect.
    pub(super) fn illegal(
        &mut self,
        block: &BlockDecl<'a>,
        space: AddressSpace,
        written: Option<Option<Rules>>,
    ) -> Vec<Diagnostic> {
        let mut found = Vec::new();
        let on_block = |id: &&LayoutId<'a>| NOT_ON_BLOCKS.iter().any(|name| id.is(name));
        let format = |id: &&LayoutId<'a>| super::layout_ids::is_image_format(id.name.text);
        for id in block.qualifiers.layout.iter().filter(|id| on_block(id) || format(id)) {
            found.push(self.not_allowed(&self.parser.token_of(&id.name), "a block"));
        }
        found.extend(self.other_qualifiers(&block.qualifiers, "a block"));
        for member in &block.members {
            self.illegal_member(member, block.qualifiers.storage, &mut found);
        }
        found.extend(self.offset_without_rules(block, space, written));
        if let (true, Some(dim)) =
            (self.parser.is_es(), block.dims.iter().find(|dim| dim.tokens.is_empty()))
        {
            let message = format!("array of blocks `{}` has no size", block.name.text);
            found.push(
                Diagnostic::error(Code::ArraySize, dim.span, message)
                    .with_help("write the number of blocks between the brackets"),
            );
        }
        found
    }

    fn illegal_member(
        &self,
        member: &Declaration<'a>,
        storage: Storage,
        found: &mut Vec<Diagnostic>,
    ) {
        let data =
            matches!(builtin(self.parser.tokens()[member.ty.at].text), Some(Builtin::Data(_)));
        for id in &member.qualifiers.layout {
            let format = data && super::layout_ids::is_image_format(id.name.text);
            if format || NOT_ON_MEMBERS.iter().any(|name| id.is(name)) {
                found
                    .push(self.not_allowed(&self.parser.token_of(&id.name), "a member of a block"));
            }
        }
        found.extend(self.other_qualifiers(&member.qualifiers, "a member of a block"));
        let own = member.qualifiers.storage;
        if matches!(own, Storage::Uniform | Storage::Buffer) && own != storage {
            let word = if own == Storage::Uniform { "uniform" } else { "buffer" };
            let at = self.words(&member.qualifiers).find(|token| token.is(word));
            let error = at.map(|token| self.not_allowed(&token, "a member of this block"));
            found.extend(error);
        }
        for name in member.names.iter().filter(|name| !name.tokens.is_empty()) {
            let message = format!("member `{}` of a block has an initialiser", name.name.text);
            let token = self.parser.token_of(&name.name);
            let note = "GLSL 4.60 §4.3.9: members of blocks take no initialisers";
            found.push(diagnostic_at(&token, Code::Syntax, message).with_note(note));
        }
    }

    /// Returns the tokens of qualifiers that stand outside `layout(…)`.
    fn words(&self, qualifiers: &Qualifiers<'a>) -> impl Iterator<Item = Token<'a>> {
        let mut depth = 0u32;
        self.parser.tokens()[qualifiers.tokens.clone()].iter().copied().filter(move |token| {
            match token.text {
                "(" => depth += 1,
                ")" => depth = depth.saturating_sub(1),
                _ => return depth == 0,
            }
            false
        })
    }

    fn other_qualifiers(&self, qualifiers: &Qualifiers<'a>, on: &str) -> Vec<Diagnostic> {
        // GLSL 4.60 §4.3.9.
        let other = |token: &Token<'a>| {
            let word = &token.text;
            *word == "const" || INTERPOLATION.contains(word) || OTHER_STORAGE.contains(word)
        };
        self.words(qualifiers).filter(other).map(|token| self.not_allowed(&token, on)).collect()
    }

    fn not_allowed(&self, token: &Token<'a>, on: &str) -> Diagnostic {
        let message = format!("`{}` is not allowed on {on}", token.text);
        let help = format!("remove `{}`", token.text);
        diagnostic_at(token, Code::LayoutQualifier, message).with_help(help)
    }

    /// `offset` and `align` need std140, std430 or scalar (GLSL 4.60 §4.4.5).
    fn offset_without_rules(
        &mut self,
        block: &BlockDecl<'a>,
        space: AddressSpace,
        written: Option<Option<Rules>>,
    ) -> Option<Diagnostic> {
        let members = block.members.iter().map(|member| &member.qualifiers);
        let mut all = std::iter::once(&block.qualifiers).chain(members);
        let id = all.find_map(|q| q.find("align").or_else(|| q.find("offset")))?;
        let own = matches!(space, AddressSpace::Uniform | AddressSpace::Storage);
        let drivers = match written {
            Some(rules) => rules.is_none(),
            // Vulkan has std140 and std430 by default.
            None => own && self.parser.preprocessor().target() == Some(Target::OpenGl),
        };
        drivers.then(|| {
            let message = format!(
                "`{}` needs a block declared with std140 or std430, and the driver lays out `{}`",
                id.name.text, block.name.text
            );
            let rules = if space == AddressSpace::Uniform { "std140" } else { "std430" };
            diagnostic_at(&self.parser.token_of(&id.name), Code::LayoutQualifier, message)
                .with_help(format!("declare the block with `layout({rules})`"))
        })
    }

    /// Reports a block or rules that the declared version does not have without an extension.
    /// Drivers may take them, so it is a warning.
    pub(super) fn check_version(
        &mut self,
        block: &BlockDecl<'a>,
        space: AddressSpace,
        rules: Rules,
    ) {
        let name = self.parser.token_of(&block.name);
        let preprocessor = self.parser.preprocessor();
        let (version, declared) = (preprocessor.version, preprocessor.version_declared);
        let has = |extensions: &[&str]| {
            preprocessor.extensions.iter().any(|own| *own == "all" || extensions.contains(own))
        };
        let (kind, needed, extensions): (_, _, &[&str]) =
            match (block.qualifiers.storage, version.es) {
                (Storage::Uniform, true) => ("uniform", 300, &[]),
                (Storage::Uniform, false) => ("uniform", 140, &["GL_ARB_uniform_buffer_object"]),
                (_, true) => ("buffer", 310, &[]),
                (_, false) => ("buffer", 430, &["GL_ARB_shader_storage_buffer_object"]),
            };
        let mut missing = None;
        if declared && version.number < needed && !has(extensions) {
            let es = if version.es { " es" } else { "" };
            let or = extensions.first().map(|name| format!(" or `#extension {name} : enable`"));
            missing = Some((
                format!("`{kind}` blocks need `#version {needed}{es}`"),
                format!("write `#version {needed}{es}`{}", or.unwrap_or_default()),
            ));
        } else if space == AddressSpace::Uniform
            && matches!(rules, Rules::Std430)
            && !has(&["GL_EXT_scalar_block_layout"])
        {
            missing = Some((
                "a `uniform` block in std430 needs GL_EXT_scalar_block_layout".to_string(),
                "write `#extension GL_EXT_scalar_block_layout : require`, or use std140"
                    .to_string(),
            ));
        }
        if let Some((message, help)) = missing {
            let mut warning = diagnostic_at(&name, Code::Version, message).with_help(help);
            warning.severity = crate::Severity::Warning;
            self.report(warning);
        }
    }
}
