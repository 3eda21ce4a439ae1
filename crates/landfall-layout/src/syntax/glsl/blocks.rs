//! Blocks (`uniform NAME { … } instance[N];`, `buffer`, push constants and buffer references), with
//! the rules and matrix storage in effect.

use super::ast::{BlockDecl, Qualifiers, Storage};
use super::declarations::{DeclarationReader, Defaults, Named};
use super::members::{MemberOwner, matrix_layout};
use super::report::diagnostic_at;
use crate::diagnostic::Code;
use crate::shape::{AddressSpace, ArrayLen, Block, MatrixLayout, OffsetOrder, Rules};
use crate::source::Target;

impl<'a> DeclarationReader<'a> {
    // GLSL 4.60 §4.3.9. A block with an error is reported and left out.
    pub(super) fn block(&mut self, block: &BlockDecl<'a>) {
        let qualifiers = &block.qualifiers;
        let name = self.parser.token_of(&block.name);
        let space = address_space(qualifiers);
        // Before its members are read, which may refer to it, as the links of a list do.
        if space == AddressSpace::BufferReference {
            self.types.insert(name.text, Named::Reference);
        }
        let comment = self.comments_before(block.tokens.start);
        let errors = block.diagnostics;
        let bindless = self.is_bindless();
        let runtime_tail = qualifiers.storage == Storage::Buffer;
        self.instance = block.instance.map(|instance| instance.text);
        let mut read =
            self.members(MemberOwner::Block { bindless, runtime_tail }, &name, &block.members);
        if !block.closed {
            return;
        }
        // `U u[2][3]`: the outermost dimension first.
        let mut count = Vec::new();
        if let Some(instance) = &block.instance {
            let token = self.parser.token_of(instance);
            for dim in &block.dims {
                if dim.tokens.is_empty() {
                    count.push(ArrayLen::Runtime);
                    continue;
                }
                self.note_length_constants(name.span, dim);
                match self.array_size(&token, dim) {
                    Ok(size) => count.push(ArrayLen::Fixed(size)),
                    Err(diagnostic) => read.problems.push(diagnostic),
                }
            }
        }
        let instance = block.instance.map(|instance| instance.text.into());
        let unread = self.parser.diagnostics().len() > errors;
        if read.members.is_empty() && read.problems.is_empty() && !unread {
            let message = format!("block `{}` has no members", name.text);
            read.problems.push(diagnostic_at(&name, Code::EmptyStruct, message));
        }
        if let Some(id) = qualifiers.find("align") {
            // GLSL 4.60 §4.4.5: `align` on a block is as if on each member without its own.
            match self.alignment(id) {
                Ok(align) => {
                    for member in &mut read.members {
                        member.align = member.align.or(Some(align));
                    }
                }
                Err(diagnostic) => read.problems.push(diagnostic),
            }
        }
        let mut number = |reader: &mut Self, key: &str| {
            let id = qualifiers.find(key)?;
            match reader.layout_number(id) {
                Ok(value) => u32::try_from(value).ok(),
                Err(diagnostic) => {
                    read.problems.push(diagnostic);
                    None
                }
            }
        };
        let group = number(self, "set");
        let binding = number(self, "binding");
        let defaults = if qualifiers.storage == Storage::Uniform {
            self.uniform_defaults
        } else {
            self.buffer_defaults
        };
        let own = own_defaults(qualifiers);
        let written = match space {
            AddressSpace::Uniform
            | AddressSpace::Storage
            | AddressSpace::BufferReference
            | AddressSpace::Default
            | AddressSpace::Structure => own.rules.or(defaults.rules),
            // GL_KHR_vulkan_glsl, GL_EXT_ray_tracing: std430 unless the block itself has another
            // qualifier; the defaults set for `uniform` or `buffer` do not apply.
            AddressSpace::PushConstant | AddressSpace::ShaderRecord | AddressSpace::TaskPayload => {
                own.rules
            }
        };
        read.problems.extend(self.illegal(block, space, written));
        let broken = !read.problems.is_empty() || self.parser.diagnostics().len() > errors;
        self.report_all(std::mem::take(&mut read.problems));
        if broken && self.has_error_since(errors) {
            return;
        }
        let (rules, rules_declared) = self.rules(written, space);
        self.check_version(block, space, rules);
        // Offset order only matters with explicit offsets; without them the text need not be
        // searched.
        let explicit = read.members.iter().any(|member| member.offset.is_some());
        self.blocks.push(Block {
            name: name.text.into(),
            instance,
            space,
            rules,
            rules_declared,
            gathered: false,
            group,
            binding,
            count,
            matrix_layout: own
                .matrix_layout
                .or(defaults.matrix_layout)
                .unwrap_or(MatrixLayout::Column),
            members: read.members,
            opaque: read.opaque,
            offset_order: match explicit.then(|| self.parser.preprocessor().target()).flatten() {
                Some(Target::Vulkan) => OffsetOrder::Any,
                Some(Target::OpenGl) => OffsetOrder::Ascending,
                None => OffsetOrder::Unknown,
            },
            span: name.span,
            comment,
        });
    }

    fn has_error_since(&self, count: usize) -> bool {
        let new = &self.parser.diagnostics()[count..];
        new.iter().any(|d| d.severity == crate::Severity::Error)
    }

    /// Returns the comments on the lines before a declaration.
    fn comments_before(&mut self, start: usize) -> Vec<crate::Span> {
        let first = self.parser.tokens()[start];
        let mut all = self.comments_of(&(start..start + 1));
        all.retain(|comment| comment.file == first.span.file && comment.end <= first.span.start);
        all
    }

    /// Returns the rules in effect, and whether the text or the language determines them.
    fn rules(&mut self, written: Option<Option<Rules>>, space: AddressSpace) -> (Rules, bool) {
        let fallback = match space {
            AddressSpace::Uniform | AddressSpace::Default | AddressSpace::Structure => {
                Rules::Std140
            }
            AddressSpace::Storage
            | AddressSpace::PushConstant
            | AddressSpace::BufferReference
            | AddressSpace::ShaderRecord
            | AddressSpace::TaskPayload => Rules::Std430,
        };
        match written {
            Some(Some(rules)) => (rules, true),
            // `shared` and `packed`: the driver chooses the offsets.
            Some(None) => (fallback, false),
            None => {
                // GL_KHR_vulkan_glsl: std140 for uniform blocks, std430 for the others, by default;
                // OpenGL's default is `shared` (GLSL 4.60 §4.4.5).
                let vulkan_only = match space {
                    AddressSpace::PushConstant
                    | AddressSpace::BufferReference
                    | AddressSpace::ShaderRecord
                    | AddressSpace::TaskPayload => true,
                    AddressSpace::Uniform
                    | AddressSpace::Storage
                    | AddressSpace::Default
                    | AddressSpace::Structure => false,
                };
                (
                    fallback,
                    vulkan_only || self.parser.preprocessor().target() == Some(Target::Vulkan),
                )
            }
        }
    }
}

pub(super) fn address_space(qualifiers: &Qualifiers<'_>) -> AddressSpace {
    if qualifiers.find("push_constant").is_some() {
        AddressSpace::PushConstant
    } else if qualifiers.find("buffer_reference").is_some() {
        AddressSpace::BufferReference
    } else if qualifiers.find("shaderRecordEXT").is_some()
        || qualifiers.find("shaderRecordNV").is_some()
    {
        AddressSpace::ShaderRecord
    } else if qualifiers.storage == Storage::Uniform {
        AddressSpace::Uniform
    } else {
        AddressSpace::Storage
    }
}

/// Returns the rules and matrix storage set in `layout(…)` itself.
// Of several rules in one `layout(…)` the last counts (§4.4).
pub(super) fn own_defaults(qualifiers: &Qualifiers<'_>) -> Defaults {
    let rules = qualifiers.layout.iter().rev().find_map(|id| {
        if id.is("shared") || id.is("packed") {
            return Some(None);
        }
        [Rules::Std140, Rules::Std430, Rules::Scalar]
            .into_iter()
            .find(|rules| id.is(rules.name()))
            .map(Some)
    });
    Defaults { rules, matrix_layout: matrix_layout(qualifiers) }
}
