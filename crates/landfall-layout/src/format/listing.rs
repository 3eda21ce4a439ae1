//! Structures and blocks in the shader's language, each member after a comment with its offset,
//! alignment, size and strides, and with padding shown.

use unicode_width::UnicodeWidthStr;

use super::paint::{FAINT, PLAIN, Paint, STRONG};
use super::{EmitOptions, phrases};
use crate::ShaderLayout;
use crate::layout::measure::{element_size, own_size, reach, structure};
use crate::layout::padding::{MemberOrGap, PaddingKind, PaddingOwner, UnusedBytes, in_text_order};
use crate::layout::{BlockLayout, MemberLayout, targets};
use crate::shape::{AddressSpace, Packing, Rules, Struct, Type};
use crate::source::Language;
use crate::text::escape::name;

pub(super) fn shader(shader: &ShaderLayout, options: &EmitOptions) -> String {
    let paint = options.paint;
    let mut text = paint.text(STRONG, &format!("// {}\n", name(&shader.title())));
    if let Some(note) = targets::note(shader.assumed_target) {
        text.push_str(&paint.text(FAINT, &format!("// {note}\n")));
    }
    for block in &shader.blocks {
        let mut listing = ListingText { block, language: shader.language, lines: vec![] };
        for (s, member) in structures(block) {
            text.push('\n');
            listing.structure(s, member);
            write(&std::mem::take(&mut listing.lines), paint, &mut text);
        }
        text.push('\n');
        listing.block();
        write(&listing.lines, paint, &mut text);
        let summary = phrases::summary(block);
        if !summary.is_empty() {
            text.push_str(&paint.text(FAINT, &format!("// {summary}\n")));
        }
        if let Some(note) = phrases::reported_size(shader, block) {
            text.push_str(&paint.text(FAINT, &format!("// {note}\n")));
        }
    }
    text
}

/// One line: a comment with numbers, then code.
#[derive(Default)]
struct ListingLine {
    offset: Option<u64>,
    align: Option<u64>,
    size: Option<u64>,
    strides: String,
    code: String,
    faint: bool,
}

/// The named structures of a block, each after those it contains. A structure with two layouts
/// (matrices by columns and by rows) is listed twice.
fn structures(block: &BlockLayout) -> Vec<(&Struct, &MemberLayout)> {
    let mut found = Vec::new();
    collect(&block.members, &mut found);
    found
}

fn collect<'a>(members: &'a [MemberLayout], found: &mut Vec<(&'a Struct, &'a MemberLayout)>) {
    for member in members {
        collect(&member.members, found);
        if let Type::Struct(s) = member.ty.innermost() {
            // One name may have two layouts in one block: the matrices of a member with `row_major`
            // (GLSL 4.60, §4.4.5) lie otherwise than those of another. Both are listed, hence the
            // comparison.
            let known = found.iter().any(|(other, layout)| {
                other.name == s.name && same_layout(&layout.members, &member.members)
            });
            if !s.name.is_empty() && !known {
                found.push((s, member));
            }
        }
    }
}

fn same_layout(a: &[MemberLayout], b: &[MemberLayout]) -> bool {
    a.len() == b.len()
        && a.iter().zip(b).all(|(a, b)| {
            a.name == b.name
                && a.offset == b.offset
                && a.matrix_stride == b.matrix_stride
                && a.row_major == b.row_major
                && same_layout(&a.members, &b.members)
        })
}

struct ListingText<'a> {
    block: &'a BlockLayout,
    language: Language,
    lines: Vec<ListingLine>,
}

impl ListingText<'_> {
    fn code(&mut self, depth: usize, code: String) {
        let code = format!("{}{code}", "    ".repeat(depth));
        self.lines.push(ListingLine { code, ..ListingLine::default() });
    }

    fn structure(&mut self, s: &Struct, member: &MemberLayout) {
        // Loose uniforms have no offsets, and thus their structures no size and alignment.
        let loose = self.block.space == AddressSpace::Default;
        let rules = self.block.rules;
        self.lines.push(ListingLine {
            align: (!loose).then(|| structure(&member.members, rules).align),
            size: (!loose).then(|| element_size(member, rules)),
            code: format!("struct {} {{", s.name),
            ..ListingLine::default()
        });
        let whole = (!loose).then(|| element_size(member, rules));
        let owner = (PaddingOwner::Structure, phrases::structure_name(&member.ty));
        self.members(&member.members, whole, owner, 1);
        for name in &s.opaque {
            self.code(1, format!("// {name}: opaque, no bytes"));
        }
        self.code(0, self.closing_brace());
    }

    fn closing_brace(&self) -> String {
        match self.language {
            Language::Glsl | Language::SpirV => "};".to_string(),
            Language::Wgsl => "}".to_string(),
        }
    }

    fn block(&mut self) {
        if self.block.space == AddressSpace::Default {
            for member in &self.block.members {
                let declared = self.declaration(member);
                self.code(0, format!("uniform {declared}"));
            }
        } else {
            match self.language {
                Language::Glsl | Language::SpirV => self.glsl_block(),
                Language::Wgsl => self.wgsl_block(),
            }
        }
        for name in &self.block.opaque {
            self.code(0, format!("// {name}: opaque, no bytes"));
        }
    }

    fn glsl_block(&mut self) {
        let block = self.block;
        let mut qualifiers = Vec::new();
        let keyword = match block.space {
            AddressSpace::Structure => "struct",
            AddressSpace::Uniform | AddressSpace::Default => "uniform",
            AddressSpace::Storage => "buffer",
            AddressSpace::PushConstant => {
                qualifiers.push("push_constant".to_string());
                "uniform"
            }
            AddressSpace::BufferReference => {
                qualifiers.push("buffer_reference".to_string());
                "buffer"
            }
            AddressSpace::TaskPayload => "taskPayloadSharedEXT",
            AddressSpace::ShaderRecord => {
                qualifiers.push("shaderRecordEXT".to_string());
                "buffer"
            }
        };
        // GLSL has no qualifier for these rules, or none at a structure, so that a comment names
        // them.
        let mut remark = "";
        match (block.rules, block.rules_declared) {
            (Rules::Wgsl, _) => remark = " // WGSL's rules",
            (Rules::Std140, _) if block.space == AddressSpace::Structure => remark = " // std140",
            (Rules::Std430, _) if block.space == AddressSpace::Structure => remark = " // std430",
            (Rules::Scalar, _) if block.space == AddressSpace::Structure => remark = " // scalar",
            (Rules::Explicit(packing), _) => remark = remark_of(packing),
            (rules, true) => qualifiers.push(rules.name().to_string()),
            (_, false) => remark = " // rules not declared: the driver's offsets may differ",
        }
        qualifiers.extend(block.group.map(|n| format!("set = {n}")));
        qualifiers.extend(block.binding.map(|n| format!("binding = {n}")));
        let layout = match qualifiers.is_empty() {
            true => String::new(),
            false => format!("layout({}) ", qualifiers.join(", ")),
        };
        self.lines.push(ListingLine {
            align: block.align,
            size: block.size,
            code: format!("{layout}{keyword} {} {{{remark}", block.name),
            ..ListingLine::default()
        });
        self.members(&block.members, block.size, (PaddingOwner::Block, None), 1);
        let instance = block.instance.as_deref().map(|i| format!(" {i}")).unwrap_or_default();
        self.code(0, format!("}}{instance}{};", phrases::dims(&block.count)));
    }

    fn wgsl_block(&mut self) {
        let block = self.block;
        let space = match block.space {
            AddressSpace::Uniform | AddressSpace::Default => "uniform",
            AddressSpace::Storage => "storage",
            AddressSpace::PushConstant
            | AddressSpace::BufferReference
            | AddressSpace::ShaderRecord
            | AddressSpace::TaskPayload
            | AddressSpace::Structure => "immediate",
        };
        let slot = phrases::slot(block, Language::Wgsl);
        let slot = if slot.is_empty() { slot } else { format!("{slot} ") };
        let name = block.instance.as_ref().unwrap_or(&block.name);
        // `var<storage> data: array<f32>` is a block of one member that is the variable itself.
        if let ([member], true) = (block.members.as_slice(), *name == block.name) {
            let mut line = self.member_line(member);
            let ty = member.ty.spelled(Language::Wgsl);
            line.code = format!("{slot}var<{space}> {name} : {ty};");
            self.lines.push(line);
            return;
        }
        self.lines.push(ListingLine {
            align: block.align,
            size: block.size,
            code: format!("struct {} {{", block.name),
            ..ListingLine::default()
        });
        self.members(&block.members, block.size, (PaddingOwner::Block, None), 1);
        self.code(0, "}".to_string());
        if block.space != AddressSpace::Structure {
            self.code(0, format!("{slot}var<{space}> {name} : {};", block.name));
        }
    }

    fn members(
        &mut self,
        members: &[MemberLayout],
        whole: Option<u64>,
        owner: (PaddingOwner, Option<&str>),
        depth: usize,
    ) {
        for one in in_text_order(members, whole) {
            match one {
                MemberOrGap::Member(member) => self.member(member, depth),
                MemberOrGap::Gap(gap) => {
                    self.gap(&gap, &phrases::padding(gap.kind, owner.0, owner.1), depth);
                }
            }
        }
    }

    fn gap(&mut self, gap: &UnusedBytes, words: &str, depth: usize) {
        self.lines.push(ListingLine {
            offset: Some(gap.offset),
            size: Some(gap.size),
            code: format!("{}// -- {words}", "    ".repeat(depth)),
            faint: true,
            ..ListingLine::default()
        });
    }

    fn member(&mut self, member: &MemberLayout, depth: usize) {
        let indent = "    ".repeat(depth);
        let mut line = self.member_line(member);
        // A nameless structure is written in place.
        let nameless = matches!(member.ty.innermost(), Type::Struct(s) if s.name.is_empty());
        let declared = self.declaration(member);
        line.code = if nameless { format!("{indent}struct {{") } else { indent + &declared };
        self.lines.push(line);
        if nameless {
            let whole = member.offset.map(|_| element_size(member, self.block.rules));
            self.members(&member.members, whole, (PaddingOwner::Structure, None), depth + 1);
            self.code(depth, format!("}} {}{};", member.name, phrases::dims(&member.dims)));
        }
        // `@size` may give a member more bytes than its type takes. They are a line of their own.
        if let Some(offset) = member.offset {
            let own = own_size(member, self.block.rules);
            if reach(member) > own {
                let (kind, size) = (PaddingKind::Tail, reach(member) - own);
                let gap =
                    UnusedBytes { kind, offset: offset + own, size, after: None, before: None };
                self.gap(&gap, &format!("tail padding of {}", member.name), depth);
            }
        }
    }

    fn member_line(&self, member: &MemberLayout) -> ListingLine {
        let mut strides = Vec::new();
        if !member.strides.is_empty() {
            let all: Vec<String> = member.strides.iter().map(u64::to_string).collect();
            strides.push(format!("stride({})", all.join(", ")));
        }
        if let Some(stride) = member.matrix_stride {
            let vectors = if member.row_major { "rows" } else { "columns" };
            strides.push(format!("{vectors}({stride})"));
        }
        ListingLine {
            offset: member.offset,
            align: member.align,
            size: member.size,
            strides: strides.join(" "),
            ..ListingLine::default()
        }
    }

    /// The declaration of a member: `layout(row_major) mat4 m[2];`, `m : array<mat4x4<f32>, 2>,`.
    fn declaration(&self, member: &MemberLayout) -> String {
        match self.language {
            Language::Glsl | Language::SpirV => {
                let row_major = if member.row_major { "layout(row_major) " } else { "" };
                let ty = phrases::type_name(&member.ty, self.language);
                format!("{row_major}{ty} {}{};", member.name, phrases::dims(&member.dims))
            }
            Language::Wgsl => format!("{} : {},", member.name, member.ty.spelled(self.language)),
        }
    }
}

fn write(lines: &[ListingLine], paint: Paint, text: &mut String) {
    let digits = |n: Option<u64>| n.map_or(0, |n| n.to_string().len());
    let widest = |of: fn(&ListingLine) -> Option<u64>| {
        lines.iter().map(|l| digits(of(l))).max().unwrap_or(0)
    };
    // The widths are those over all lines, so that the code after the comments starts in one
    // column.
    let widths = [widest(|l| l.offset), widest(|l| l.align), widest(|l| l.size)];
    let strides = lines.iter().map(|l| l.strides.width()).max().unwrap_or(0);
    let has_numbers = widths.iter().any(|&width| width > 0);
    for line in lines {
        if has_numbers {
            let mut comment = String::from("/*");
            let cells = [("offset", line.offset), ("align", line.align), ("size", line.size)];
            for ((name, number), width) in cells.into_iter().zip(widths) {
                match number {
                    Some(number) => comment.push_str(&format!(" {name}({number:>width$})")),
                    None if width == 0 => {}
                    None => comment.push_str(&" ".repeat(name.len() + width + 3)),
                }
            }
            if strides > 0 {
                comment.push_str(&format!(" {:<strides$}", line.strides));
            }
            comment.push_str(" */ ");
            text.push_str(&paint.text(FAINT, &comment));
        }
        text.push_str(&paint.text(if line.faint { FAINT } else { PLAIN }, &line.code));
        text.push('\n');
    }
}

/// What a listing says of a block that follows no rules of a text.
fn remark_of(packing: Packing) -> &'static str {
    match packing {
        Packing::Relaxed => " // offsets as written: relaxed block layout",
        Packing::D3d => " // offsets as written: Direct3D's packing",
        Packing::Free => " // offsets as written: they follow no rules",
    }
}

#[cfg(test)]
mod tests {
    use crate::examples::*;
    use crate::format::{EmitOptions, Format, document};
    use crate::shape::Rules;
    use crate::source::Language;

    #[test]
    fn point_lights_are_listed_with_their_holes() {
        let shader = shader("a.frag", Language::Glsl, vec![point_lights()]);
        let text = document(&shader, &EmitOptions::new(Format::Listing));
        assert_eq!(
            text,
            "\
// a.frag

/*            align(16) size(48) */ struct PointLight {
/* offset( 0) align(16) size(12) */     vec3 pos;
/* offset(12)           size( 4) */     // -- hole
/* offset(16) align(16) size(12) */     vec3 color;
/* offset(28) align( 4) size( 4) */     float intensity;
/* offset(32) align( 4) size( 4) */     float constant;
/* offset(36) align( 4) size( 4) */     float linear;
/* offset(40) align( 4) size( 4) */     float quadratic;
/* offset(44)           size( 4) */     // -- tail padding of PointLight
/*                               */ };

/*              align(16) size(6160)            */ layout(std140) uniform PointLightBlock {
/* offset(   0) align(16) size(6144) stride(48) */     PointLight data[128];
/* offset(6144) align( 4) size(   4)            */     int actually_used_count;
/* offset(6148)           size(  12)            */     // -- tail padding
/*                                              */ } u_point_light_array;
// 6,160 bytes: 5,124 used, 1,036 padding (16.8 %)
"
        );
    }

    #[test]
    fn wgsl_is_listed_as_wgsl() {
        let block = crate::BlockLayout { rules: Rules::Wgsl, ..particles() };
        let shader = shader("a.wgsl", Language::Wgsl, vec![block]);
        let text = document(&shader, &EmitOptions::new(Format::Listing));
        assert!(
            text.contains(
                "struct Particle {\n/* offset( 0) align(16) size(12) */     pos : vec3<f32>,"
            ),
            "{text}"
        );
        assert!(text.contains("particles : array<Particle>,"), "{text}");
        assert!(
            text.contains("@group(0) @binding(3) var<storage> Particles : Particles;"),
            "{text}"
        );
    }

    #[test]
    fn loose_uniforms_are_listed_without_numbers() {
        let shader = shader("a.frag", Language::Glsl, vec![loose()]);
        let text = document(&shader, &EmitOptions::new(Format::Listing));
        assert!(text.contains("struct Light {\n    vec3 position;\n    float linear;\n};\n\nuniform vec3 view_pos;\nuniform Light lights[6];\n"), "{text}");
    }
}
