//! Declarations that no compiler takes although their bytes are known: qualifiers that blocks and
//! their members may not have, and blocks before the version that has them.

use super::ast::{BlockDecl, Declaration, Qualifiers, Storage, TypeBase};
use super::declarations::DeclarationReader;
use super::layout_ids;
use super::lexer::Token;
use super::qualifiers::{INTERPOLATION, OTHER_STORAGE};
use super::report::diagnostic_at;
use super::target::TargetDecision;
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

/// Entries of `layout(…)` that no `in` or `out` block takes.
const NOT_ON_INTERFACES: &[&str] =
    &["std140", "std430", "shared", "packed", "row_major", "column_major", "binding"];

impl<'a> DeclarationReader<'a> {
    /// Returns what makes a block illegal in every version; `written` are the rules in effect.
    // `written` is `None` where neither the block nor a default names rules, `Some(None)` for
    // `shared` and `packed`, whose offsets the driver chooses.
    pub(super) fn illegal(
        &mut self,
        block: &BlockDecl<'a>,
        space: AddressSpace,
        written: Option<Option<Rules>>,
    ) -> Vec<Diagnostic> {
        let mut found = Vec::new();
        for id in &block.qualifiers.layout {
            if id.is_among(NOT_ON_BLOCKS) || layout_ids::is_image_format(id.name.text) {
                found.push(self.not_allowed(&self.parser.token_of(&id.name), "a block"));
            }
        }
        found.extend(self.other_qualifiers(&block.qualifiers, "a block"));
        found.extend(self.two_storages(block));
        found.extend(self.repeated(&block.qualifiers));
        found.extend(self.reserved_names(block));
        if space == AddressSpace::PushConstant {
            self.illegal_push_constants(block, &mut found);
        }
        for member in &block.members {
            self.illegal_member(member, block.qualifiers.storage, &mut found);
        }
        found.extend(self.offset_without_rules(block, space, written));
        found.extend(self.drivers_layout(block, written));
        found.extend(self.second_of_a_stage(block, space));
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
            let format = data && layout_ids::is_image_format(id.name.text);
            if format || id.is_among(NOT_ON_MEMBERS) {
                found
                    .push(self.not_allowed(&self.parser.token_of(&id.name), "a member of a block"));
            }
        }
        found.extend(self.other_qualifiers(&member.qualifiers, "a member of a block"));
        // A member may repeat the storage of its block (§4.3.9), no other.
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
    // The tokens of `layout` lie inside its parentheses, where `shared` is an identifier and no
    // storage.
    pub(super) fn words(&self, qualifiers: &Qualifiers<'a>) -> impl Iterator<Item = Token<'a>> {
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

    /// `uniform buffer U { … }`
    fn two_storages(&self, block: &BlockDecl<'a>) -> Option<Diagnostic> {
        let storage = |token: &Token<'a>| token.is("uniform") || token.is("buffer");
        let mut all = self.words(&block.qualifiers).filter(storage);
        let first = all.next()?;
        let second = all.find(|token| token.text != first.text)?;
        let message = format!("`{}` and `{}` exclude each other", first.text, second.text);
        let note = "GLSL 4.60 §4.3: a declaration has one storage qualifier";
        Some(diagnostic_at(&second, Code::LayoutQualifier, message).with_note(note))
    }

    /// GL_KHR_vulkan_glsl: push constants are one `uniform` block without a descriptor.
    fn illegal_push_constants(&self, block: &BlockDecl<'a>, found: &mut Vec<Diagnostic>) {
        for id in block.qualifiers.layout.iter().filter(|id| id.is("binding") || id.is("set")) {
            found.push(self.not_allowed(&self.parser.token_of(&id.name), "push constants"));
        }
        if block.qualifiers.storage == Storage::Buffer {
            let at = self.words(&block.qualifiers).find(|token| token.is("buffer"));
            found.extend(at.map(|token| {
                let message = "push constants are a `uniform` block, not `buffer`";
                diagnostic_at(&token, Code::LayoutQualifier, message).with_help("write `uniform`")
            }));
        }
        if let Some(dim) = block.dims.first() {
            let message = format!("push constants `{}` cannot be an array", block.name.text);
            found.push(Diagnostic::error(Code::LayoutQualifier, dim.span, message));
        }
    }

    /// Reports what an `in` or `out` block may not have (GLSL 4.60 §4.4.5).
    pub(super) fn interface(&mut self, block: &BlockDecl<'a>) {
        if !matches!(block.qualifiers.storage, Storage::In | Storage::Out) {
            return;
        }
        let ids = block.qualifiers.layout.iter().filter(|id| id.is_among(NOT_ON_INTERFACES));
        let mut found = self.repeated(&block.qualifiers);
        found.extend(ids.map(|id| {
            self.not_allowed(&self.parser.token_of(&id.name), "a block of inputs or outputs")
        }));
        self.report_all(found);
    }

    /// GLSL 4.60 §4.1.8; GLSL 1.10 had structures inside others.
    pub(super) fn structure_inside(&self, member: &Declaration<'a>) -> Option<Diagnostic> {
        let TypeBase::Struct(structure) = &member.ty.base else { return None };
        let version = self.parser.version()?;
        if version.number == 110 {
            return None;
        }
        let token = self.parser.token_of(&structure.name);
        let message = "a structure is declared inside a structure or block";
        let error = diagnostic_at(&token, Code::Syntax, message);
        let note = "GLSL 4.60 §4.1.8: structures are not declared inside others";
        Some(error.with_note(note).with_help("declare it before, and use its name here"))
    }

    pub(super) fn not_allowed(&self, token: &Token<'a>, on: &str) -> Diagnostic {
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
                "`{}` needs a block declared std140 or std430, but the driver chooses the layout of `{}`",
                id.name.text, block.name.text
            );
            let rules = if space == AddressSpace::Uniform { "std140" } else { "std430" };
            diagnostic_at(&self.parser.token_of(&id.name), Code::LayoutQualifier, message)
                .with_help(format!("declare the block with `layout({rules})`"))
        })
    }

    /// `shared` and `packed` in a text for Vulkan, whose compilers write the offsets into SPIR-V
    /// (GL_KHR_vulkan_glsl).
    fn drivers_layout(
        &mut self,
        block: &BlockDecl<'a>,
        written: Option<Option<Rules>>,
    ) -> Option<Diagnostic> {
        let vulkan = TargetDecision::Known(Target::Vulkan);
        if written != Some(None) || self.parser.preprocessor().decision() != vulkan {
            return None;
        }
        let own =
            block.qualifiers.layout.iter().rev().find(|id| id.is("shared") || id.is("packed"));
        // The qualifier may come from `layout(shared) uniform;` far above; the block is then named.
        let token = self.parser.token_of(own.map_or(&block.name, |id| &id.name));
        let message = match own {
            Some(id) => format!("`{}` is not allowed in GLSL for Vulkan", id.name.text),
            None => format!(
                "block `{}` is `shared` or `packed` by default, which is not allowed in GLSL for \
                 Vulkan",
                block.name.text
            ),
        };
        Some(
            diagnostic_at(&token, Code::LayoutQualifier, message)
                .with_note("GL_KHR_vulkan_glsl: no driver chooses the layout of a block")
                .with_help("write `std140` or `std430`"),
        )
    }

    /// A second block of push constants or second shader record: a stage has one
    /// (GL_KHR_vulkan_glsl, GL_EXT_ray_tracing).
    fn second_of_a_stage(&self, block: &BlockDecl<'a>, space: AddressSpace) -> Option<Diagnostic> {
        let what = match space {
            AddressSpace::PushConstant => "block of push constants",
            AddressSpace::ShaderRecord => "shader record",
            AddressSpace::Uniform
            | AddressSpace::Storage
            | AddressSpace::BufferReference
            | AddressSpace::TaskPayload
            | AddressSpace::Default
            | AddressSpace::Structure => return None,
        };
        let first = self.blocks.iter().find(|other| other.space == space)?;
        let message = format!(
            "`{}` is a second {what} beside `{}`: a stage has one",
            block.name.text, first.name
        );
        Some(
            diagnostic_at(&self.parser.token_of(&block.name), Code::LayoutQualifier, message)
                .with_label(first.span, "the first one")
                .with_help(format!("move its members into `{}`", first.name)),
        )
    }

    /// Reports a block or rules that the declared version does not have without an extension.
    /// Drivers may take them, so it is a warning.
    // At most one warning: of the block itself, of its rules or address space, of `offset` and
    // `align`, of `binding`, in this order. Versions are compared only if the text states one: a
    // part of a text leaves that to the others.
    pub(super) fn check_version(
        &mut self,
        block: &BlockDecl<'a>,
        space: AddressSpace,
        rules: Rules,
    ) {
        let name = self.parser.token_of(&block.name);
        let early_offset = self.early_offset(block);
        let preprocessor = self.parser.preprocessor();
        let (version, declared) = (preprocessor.version, preprocessor.version_declared);
        let has = |extensions: &[&str]| {
            preprocessor.extensions.iter().any(|own| *own == "all" || extensions.contains(own))
        };
        // The version that introduced the blocks, and the extension that adds them to earlier ones.
        let (kind, needed, extensions): (_, _, &[&str]) =
            match (block.qualifiers.storage, version.es) {
                (Storage::Uniform, true) => ("uniform", 300, &[]),
                (Storage::Uniform, false) => ("uniform", 140, &["GL_ARB_uniform_buffer_object"]),
                (_, true) => ("buffer", 310, &[]),
                (_, false) => ("buffer", 430, &["GL_ARB_shader_storage_buffer_object"]),
            };
        let lacks_version = |what: String, needed: u32, extension: Option<&&str>| {
            let es = if version.es { " es" } else { "" };
            let or = extension.map(|name| format!(" or `#extension {name} : enable`"));
            let help = format!("write `#version {needed}{es}`{}", or.unwrap_or_default());
            Some((format!("{what} `#version {needed}{es}`"), help))
        };
        let mut missing = None;
        if declared && version.number < needed && !has(extensions) {
            missing = lacks_version(format!("`{kind}` blocks need"), needed, extensions.first());
        } else if let Some((what, extensions, or)) = extensions_of(space, rules) {
            missing = (!has(extensions)).then(|| {
                let extension = extensions[0];
                let help = format!("write `#extension {extension} : require`{or}");
                (format!("{what} needs {extension}"), help)
            });
        }
        // One warning a block: a text whose version is too old for the block would get all three.
        if let (None, Some(id)) = (&missing, early_offset) {
            let what = format!("`{id}` on a member needs");
            missing = lacks_version(what, 440, Some(&"GL_ARB_enhanced_layouts"));
        }
        let binding = block.qualifiers.find("binding").is_some();
        let needed = if version.es { 310 } else { 420 };
        let packs = ["GL_ARB_shading_language_420pack", "GL_ARB_shader_storage_buffer_object"];
        if missing.is_none() && binding && declared && version.number < needed && !has(&packs) {
            let extension = packs.first().filter(|_| !version.es);
            missing = lacks_version("`binding` needs".to_string(), needed, extension);
        }
        if let Some((message, help)) = missing {
            let mut warning = diagnostic_at(&name, Code::Version, message).with_help(help);
            warning.severity = crate::Severity::Warning;
            self.report(warning);
        }
    }

    /// Returns `offset` or `align` of a block or its members in a version of OpenGL before 4.40
    /// (GLSL 4.60 §4.4.5). Vulkan's compilers take them in every version.
    fn early_offset(&mut self, block: &BlockDecl<'a>) -> Option<&'static str> {
        let preprocessor = self.parser.preprocessor();
        let version = preprocessor.version;
        let early = preprocessor.version_declared && !version.es && version.number < 440;
        let extended = |name: &&str| matches!(*name, "all" | "GL_ARB_enhanced_layouts");
        if !early
            || preprocessor.extensions.iter().any(extended)
            || preprocessor.target() == Some(Target::Vulkan)
        {
            return None;
        }
        let members = block.members.iter().map(|member| &member.qualifiers);
        let mut all = std::iter::once(&block.qualifiers).chain(members);
        all.find_map(|q| ["offset", "align"].into_iter().find(|name| q.find(name).is_some()))
    }
}

/// What a block needs an extension for, the extensions that have it, and what does without.
fn extensions_of(
    space: AddressSpace,
    rules: Rules,
) -> Option<(&'static str, &'static [&'static str], &'static str)> {
    const SCALAR: &[&str] = &["GL_EXT_scalar_block_layout"];
    match (space, rules) {
        (_, Rules::Scalar) => Some(("`scalar`", SCALAR, ", or use std430")),
        (AddressSpace::Uniform, Rules::Std430) => {
            Some(("a `uniform` block in std430", SCALAR, ", or use std140"))
        }
        (AddressSpace::BufferReference, Rules::Std140 | Rules::Std430 | Rules::Wgsl) => Some((
            "`buffer_reference`",
            &[
                "GL_EXT_buffer_reference",
                "GL_EXT_buffer_reference2",
                "GL_EXT_buffer_reference_uvec2",
            ],
            "",
        )),
        (AddressSpace::ShaderRecord, Rules::Std140 | Rules::Std430 | Rules::Wgsl) => {
            Some(("a shader record", &["GL_EXT_ray_tracing", "GL_NV_ray_tracing"], ""))
        }
        (
            AddressSpace::Uniform
            | AddressSpace::Storage
            | AddressSpace::PushConstant
            | AddressSpace::TaskPayload
            | AddressSpace::Default
            | AddressSpace::Structure,
            Rules::Std140 | Rules::Std430 | Rules::Wgsl,
        )
        // No text declares it.
        | (_, Rules::Explicit(_)) => None,
    }
}
