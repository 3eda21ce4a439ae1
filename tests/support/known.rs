//! Where the oracles are known to disagree, which one departs from the
//! specification's text, and why. Seen in glslang 12.0.0 and Mesa 22.3.6.
//!
//! Every entry has a small text that shows it, and `tests/layout/oracles.rs` asserts
//! that it still does: an entry that an upgrade makes stale fails there.

use super::blocks::{Basic, Block, Major, Member, Rules, Scalar, Standing, Type};
use super::generate::alignment_bound;
use super::leaf::{Difference, What};

/// A kind of block that an API of a browser does not take, and is not asked to read.
pub struct Unread {
    /// `webgl` or `webgpu`.
    pub api: &'static str,
    /// How the reason begins that `verify` gives.
    pub reason: &'static str,
    /// The rule, or what this browser lacks.
    pub because: &'static str,
    /// A shader that shows it: its extension, and declarations of which the block is `B`.
    pub example: (&'static str, &'static str),
}

const fn unread(
    api: &'static str,
    reason: &'static str,
    because: &'static str,
    example: (&'static str, &'static str),
) -> Unread {
    Unread { api, reason, because, example }
}

/// What Chromium 156 does not read, with ANGLE on SwiftShader and Mesa, and Tint on SwiftShader. Where
/// it reads, it keeps to the rules: there is no difference in offsets to list.
pub const UNREAD: &[Unread] = &[
    unread(
        "webgl",
        "WebGL does not accept WGSL",
        "WebGL 2.0: shaders are GLSL ES 3.00",
        ("wgsl", "@group(0) @binding(0) var<uniform> B: vec4f;"),
    ),
    unread(
        "webgl",
        "WebGL 2 has no storage buffers",
        "GLSL ES 3.00 §4.3: buffer is no storage qualifier",
        ("frag", "layout(std430) buffer B { vec4 a; };"),
    ),
    unread(
        "webgl",
        "WebGL 2 has no push constants",
        "GLSL ES 3.00 §4.3: they are those of GL_KHR_vulkan_glsl",
        ("frag", "layout(push_constant) uniform B { vec4 a; };"),
    ),
    unread(
        "webgl",
        "WebGL 2 has no std430 blocks, only std140",
        "WebGL 2.0, \"Only std140 layout supported in uniform blocks\"",
        (
            "frag",
            "#extension GL_EXT_scalar_block_layout : require\n\
             layout(std430) uniform B { vec4 a; };",
        ),
    ),
    unread(
        "webgl",
        "WebGL 2 has no scalar blocks, only std140",
        "WebGL 2.0, as above",
        (
            "frag",
            "#extension GL_EXT_scalar_block_layout : require\n\
             layout(scalar) uniform B { vec4 a; };",
        ),
    ),
    unread(
        "webgl",
        "its compiler rejects the shader: ERROR: 0:4: 'shared'",
        "WebGL 2.0, as above",
        ("frag", "layout(shared) uniform B { vec4 a; };"),
    ),
    unread(
        "webgl",
        "its compiler rejects the shader: ERROR: 0:4: 'packed'",
        "WebGL 2.0, as above",
        ("frag", "layout(packed) uniform B { vec4 a; };"),
    ),
    unread(
        "webgl",
        "WebGL 2 has no arrays of arrays",
        "GLSL ES 3.00 §4.1.9: arrays have one dimension",
        ("frag", "layout(std140) uniform B { vec4 a[2][3]; };"),
    ),
    unread(
        "webgl",
        "WebGL 2 has no type `",
        "GLSL ES 3.00 §4.1: scalars have 32 bits",
        ("frag", "layout(std140) uniform B { dvec3 a; };"),
    ),
    unread(
        "webgl",
        "GLSL ES 3.00 has no `align`",
        "GLSL ES 3.00 §4.3.8.3: the qualifiers of a block's layout",
        ("frag", "layout(std140) uniform B { layout(align = 32) vec4 a; };"),
    ),
    unread(
        "webgl",
        "GLSL ES 3.00 has no `offset`",
        "GLSL ES 3.00 §4.3.8.3, as above",
        ("frag", "layout(std140) uniform B { layout(offset = 32) vec4 a; };"),
    ),
    unread(
        "webgl",
        "its compiler rejects the shader: ERROR: 0:8: 'a' : Reference of struct type W exceeds",
        "WebGL 1.0, \"Maximum Nesting Level of Structures in GLSL Shaders\": four",
        (
            "frag",
            "struct Z { vec4 a; }; struct Y { Z a; }; struct X { Y a; }; struct W { X a; };\n\
             struct V { W a; };\nlayout(std140) uniform B { V a; };",
        ),
    ),
    unread(
        "webgpu",
        "it cannot be ported to WGSL: ",
        "WGSL §14.4: the layout of WGSL, here the stride of an array of floats; or a limit of naga, \
         which `landfall port` says",
        ("frag", "layout(std140) uniform B { float a[4]; };"),
    ),
    unread(
        "webgpu",
        "`landfall port --to wgsl` gives its members other types",
        "WGSL §6.4: bool is not host-shareable; ports have u32",
        ("frag", "layout(std140) uniform B { bool a; };"),
    ),
    unread(
        "webgpu",
        "the browser's WebGPU has no push constants",
        "WebGPU has no immediate data yet",
        ("frag", "layout(push_constant) uniform B { vec4 a; };"),
    ),
    unread(
        "webgpu",
        "its compiler rejects the shader: 1:8 error: extension 'f16' is not allowed",
        "WGSL §4.1.1: f16 needs the feature shader-f16, which SwiftShader lacks",
        (
            "wgsl",
            "enable f16;\n@group(0) @binding(0) var<storage> B: vec4<f16>;\n\
             @compute @workgroup_size(1) fn main() { _ = B.x; }",
        ),
    ),
];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Oracle {
    Glslang,
    Driver,
}

/// One known disagreement.
pub struct Known {
    pub name: &'static str,
    /// The oracle that departs from the specification.
    pub wrong: Oracle,
    /// What the specification says instead.
    pub because: &'static str,
    /// Declarations that show it; the block spoken of is `B`.
    pub example: &'static str,
    pub shown: Shown,
    pub reach: Reach,
}

/// What the two oracles say of an entry's example.
#[derive(Clone, Copy, Debug)]
pub enum Shown {
    Offset {
        path: &'static str,
        glslang: u64,
        driver: u64,
    },
    Type {
        path: &'static str,
        glslang: &'static str,
        driver: &'static str,
    },
    /// glslang's end of the last member against the driver's buffer size.
    Size {
        glslang: u64,
        driver: u64,
    },
    /// glslang's end of the last member of a block no driver takes, against the specification's.
    DataSize {
        glslang: u64,
        right: u64,
    },
    /// The driver refuses the text, and its log has this in it.
    Refused {
        log: &'static str,
    },
    /// The driver leaves this member out.
    Unlisted {
        path: &'static str,
    },
}

/// What a test may put down to an entry.
#[derive(Clone, Copy)]
pub enum Reach {
    /// A difference in a block.
    Excuses(fn(Subject<'_>, &Difference) -> bool),
    /// Nothing the driver says of such a block is worth asking for.
    Unasked(fn(Subject<'_>) -> bool),
    /// The harness asks in a way that does not meet it.
    Avoided,
}

/// A block with the default-layout statements it stands under.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    pub block: &'a Block,
    pub standing: &'a [Standing],
}

/// The entry that explains a difference, if there is one; only among faults
/// of one oracle where `wrong` names it.
pub fn explains(
    subject: Subject<'_>,
    difference: &Difference,
    wrong: Option<Oracle>,
) -> Option<&'static Known> {
    KNOWN
        .iter()
        .filter(|known| wrong.is_none_or(|oracle| oracle == known.wrong))
        .find(|known| matches!(known.reach, Reach::Excuses(is) if is(subject, difference)))
}

/// Whether the driver is worth asking about a block.
pub fn within_the_driver(subject: Subject<'_>) -> bool {
    !KNOWN.iter().any(|known| matches!(known.reach, Reach::Unasked(is) if is(subject)))
}

pub const KNOWN: &[Known] = &[
    Known {
        name: "glslang ignores align under a default-layout statement",
        wrong: Oracle::Glslang,
        because: "GLSL 4.60 §4.4.5: align is for members of any block laid out by std140 or \
                  std430, and a block without a layout of its own takes the default's",
        example: "layout(std140) uniform;
                  uniform B { float a; layout(align = 32) float b; } b;",
        shown: Shown::Offset { path: "b", glslang: 4, driver: 32 },
        reach: Reach::Excuses(|s, d| {
            matches!(d.what, What::Offset | What::Size | What::DataSize)
                && !s.block.rules_written
                && has_align(s.block)
        }),
    },
    Known {
        name: "glslang's reflection ignores offset under a default-layout statement",
        wrong: Oracle::Glslang,
        because: "GLSL 4.60 §4.4.5, as above; its SPIR-V has the offset right, only the size in \
                  its listing is short",
        example: "layout(std430) buffer;
                  buffer B { layout(offset = 12) uint a; uint b; } b;",
        shown: Shown::Size { glslang: 8, driver: 32 },
        reach: Reach::Excuses(|s, d| {
            matches!(d.what, What::Size | What::DataSize)
                && !s.block.rules_written
                && s.block.members.iter().any(|m| m.offset.is_some())
        }),
    },
    Known {
        name: "glslang's reflection sizes a last matrix by the block's order, not its own",
        wrong: Oracle::Glslang,
        because: "OpenGL 4.6 §7.6.2.2 rule 7: dmat2x3 by rows is three dvec2, 48 bytes; by \
                  columns two dvec3 of stride 32",
        example: "layout(std140) uniform B { layout(row_major) dmat2x3 a; } b;",
        shown: Shown::Size { glslang: 64, driver: 48 },
        reach: Reach::Excuses(|s, d| {
            let last = s.block.members.last().expect("no empty blocks");
            matches!(d.what, What::Size | What::DataSize)
                && last.major.is_some()
                && matches!(last.ty, Type::Basic(basic) if basic.is_matrix())
        }),
    },
    Known {
        name: "glslang's reflection counts no element of a runtime-sized tail in scalar",
        wrong: Oracle::Glslang,
        because: "OpenGL 4.6 §7.3.1.1: the size is as if the array had one element; in std140 \
                  and std430 glslang counts it",
        example: "#extension GL_EXT_scalar_block_layout : require
                  layout(scalar) buffer B { vec2 a; vec3 b[]; } b;",
        shown: Shown::DataSize { glslang: 8, right: 20 },
        reach: Reach::Excuses(|s, d| {
            let last = s.block.members.last().expect("no empty blocks");
            d.what == What::DataSize
                && s.block.rules == Rules::Scalar
                && last.dims().any(|d| d.length.is_none())
        }),
    },
    Known {
        name: "SPIR-V has no bool in memory",
        wrong: Oracle::Glslang,
        because: "OpenGL 4.6 §7.6.2.1: the member is a bool, held as a uint",
        example: "layout(std140) uniform B { float f; bvec3 a; } b;",
        shown: Shown::Type { path: "a", glslang: "uvec3", driver: "bvec3" },
        reach: Reach::Excuses(|_, d| {
            let as_uint = |ty: &str| ty.replace("bool", "uint").replace("bvec", "uvec");
            d.what == What::Type && as_uint(&d.left) == as_uint(&d.right)
        }),
    },
    Known {
        name: "Mesa leaves out the tail padding of a structure aligned to 32",
        wrong: Oracle::Driver,
        because: "OpenGL 4.6 §7.6.2.2 rule 9: a structure is padded to a multiple of its \
                  alignment, which a dvec3 makes 32; Mesa puts a member after it at 64 too",
        example: "struct T { dvec3 t; dvec2 u; };
                  layout(std140) uniform B { T a; } b;",
        shown: Shown::Size { glslang: 64, driver: 48 },
        reach: Reach::Excuses(|s, d| {
            let last = s.block.members.last().expect("no empty blocks");
            d.what == What::Size
                && matches!(last.ty, Type::Struct(_))
                && alignment_bound(last, s.block.rules) == 32
        }),
    },
    Known {
        name: "Mesa overlaps what follows a member whose align is below its own alignment",
        wrong: Oracle::Driver,
        because: "GLSL 4.60 §4.4.5: the actual alignment is the greater of align and the base \
                  alignment, and the next member follows the end; Mesa has b at 16 and c at 20",
        example: "layout(std140) uniform B {
                      float a; layout(align = 4) vec4 b; layout(align = 4) float c; } b;",
        shown: Shown::Offset { path: "c", glslang: 32, driver: 20 },
        reach: Reach::Unasked(|s| low_align(s.block)),
    },
    Known {
        name: "Mesa refuses an align below 8 before a double",
        wrong: Oracle::Driver,
        because: "GLSL 4.60 §4.4.5, as above; its log speaks of an xfb_offset that is not there",
        example: "layout(std430) buffer B { float a; layout(align = 4) double b; } b;",
        shown: Shown::Refused { log: "xfb_offset=4" },
        reach: Reach::Unasked(|s| {
            low_align(s.block) && s.block.members.iter().any(|m| any_basic(&m.ty, is_double))
        }),
    },
    Known {
        name: "Mesa takes a column_major matrix in a row_major block for row-major before align",
        wrong: Oracle::Driver,
        because: "GLSL 4.60 §4.4.5: the member's own qualifier overrides the block's; mat4x2 by \
                  columns is 64 bytes in std140, which Mesa's matrix stride of 16 agrees with",
        example: "layout(std140, row_major) uniform B {
                      layout(column_major) mat4x2 a; layout(align = 16) vec2 b; } b;",
        shown: Shown::Offset { path: "b", glslang: 64, driver: 32 },
        reach: Reach::Unasked(|s| {
            has_align(s.block)
                && row_major_block(s)
                && s.block
                    .members
                    .iter()
                    .any(|m| m.major == Some(Major::Column) && any_basic(&m.ty, Basic::is_matrix))
        }),
    },
    Known {
        name: "Mesa refuses offset and align on a runtime-sized array",
        wrong: Oracle::Driver,
        because: "GLSL 4.60 §4.4.5: offset and align are for block members, the last member of a \
                  buffer block not excepted",
        example: "layout(std430) buffer B { float a; layout(align = 32) vec4 b[]; } b;",
        shown: Shown::Refused { log: "align can only be used with std430 and std140 layouts" },
        reach: Reach::Unasked(|s| {
            s.block.members.iter().any(|m| {
                m.dims().any(|d| d.length.is_none())
                    && (m.offset.is_some() || effective_align(s.block, m).is_some())
            })
        }),
    },
    Known {
        name: "Mesa mislists a storage block beside another one",
        wrong: Oracle::Driver,
        because: "OpenGL 4.6 §7.3.1.1: every active member of a storage block is enumerated",
        example: "struct T { float a; };
                  layout(std140) buffer B { vec3 a; float b[2][2]; float c; } b;
                  layout(std140) buffer D { float e; T f[2]; } d;",
        shown: Shown::Unlisted { path: "c" },
        reach: Reach::Avoided,
    },
];

fn has_align(block: &Block) -> bool {
    block.align.is_some() || block.members.iter().any(|m| m.align.is_some())
}

fn effective_align(block: &Block, member: &Member) -> Option<u64> {
    member.align.or(block.align)
}

/// Some member's align is below what its own alignment may be.
fn low_align(block: &Block) -> bool {
    block.members.iter().any(|m| {
        effective_align(block, m).is_some_and(|align| align < alignment_bound(m, block.rules))
    })
}

fn row_major_block(subject: Subject<'_>) -> bool {
    let standing = subject.standing.iter().find(|s| s.space == subject.block.space);
    subject.block.major.or(standing.and_then(|s| s.major)) == Some(Major::Row)
}

fn is_double(basic: Basic) -> bool {
    basic.scalar == Scalar::Double
}

fn any_basic(ty: &Type, is: fn(Basic) -> bool) -> bool {
    match ty {
        Type::Basic(basic) => is(*basic),
        Type::Struct(structure) => structure.members.iter().any(|m| any_basic(&m.ty, is)),
    }
}
