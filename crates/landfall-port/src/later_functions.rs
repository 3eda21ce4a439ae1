//! Built-in functions that a version before GLSL 4.50 lacks: a shader's own function of the same
//! name clashes with them in the ported text.

use landfall_layout::text::word_list::WordList;

/// The version of functions that an extension alone has.
const NEVER: u32 = u32::MAX;

/// Functions by the desktop version and the ES version of GLSL that added them (the lists of
/// changes in the specifications of GLSL 1.20 to 4.50 and of GLSL ES 3.00 to 3.20).
const VERSIONS: &[(u32, u32, &str)] = &[
    (110, 300, "dFdx dFdy fwidth"),
    (120, 300, "outerProduct transpose"),
    (
        130,
        300,
        "sinh cosh tanh asinh acosh atanh trunc round roundEven isnan isinf modf texture \
         textureProj textureLod textureGrad textureOffset textureProjLod textureProjGrad \
         textureProjOffset textureLodOffset textureGradOffset textureProjLodOffset \
         textureProjGradOffset textureSize texelFetch texelFetchOffset",
    ),
    (140, 300, "inverse"),
    (150, 300, "determinant"),
    (150, 320, "EmitVertex EndPrimitive"),
    (330, 300, "floatBitsToInt floatBitsToUint intBitsToFloat uintBitsToFloat"),
    (400, 300, "packUnorm2x16 unpackUnorm2x16"),
    (
        400,
        310,
        "frexp ldexp bitfieldExtract bitfieldInsert bitfieldReverse bitCount findLSB findMSB \
         uaddCarry usubBorrow umulExtended imulExtended packUnorm4x8 packSnorm4x8 \
         unpackUnorm4x8 unpackSnorm4x8 textureGather textureGatherOffset barrier",
    ),
    (
        400,
        320,
        "fma textureGatherOffsets interpolateAtCentroid interpolateAtSample \
         interpolateAtOffset",
    ),
    (
        400,
        NEVER,
        "packDouble2x32 unpackDouble2x32 textureQueryLod EmitStreamVertex EndStreamPrimitive",
    ),
    (420, 300, "packSnorm2x16 unpackSnorm2x16 packHalf2x16 unpackHalf2x16"),
    (420, 310, "imageLoad imageStore memoryBarrier"),
    (
        420,
        320,
        "imageAtomicAdd imageAtomicMin imageAtomicMax imageAtomicAnd imageAtomicOr \
         imageAtomicXor imageAtomicExchange imageAtomicCompSwap",
    ),
    (
        430,
        310,
        "atomicAdd atomicMin atomicMax atomicAnd atomicOr atomicXor atomicExchange \
         atomicCompSwap imageSize memoryBarrierBuffer memoryBarrierImage memoryBarrierShared \
         groupMemoryBarrier",
    ),
    (430, NEVER, "textureQueryLevels"),
    (
        450,
        NEVER,
        "dFdxFine dFdyFine fwidthFine dFdxCoarse dFdyCoarse fwidthCoarse textureSamples \
         imageSamples",
    ),
    // Of extensions; glslang lets no function have the name and parameters of one, enabled or not.
    (
        NEVER,
        NEVER,
        "absoluteDifference addSaturate subtractSaturate average averageRounded \
         countLeadingZeros countTrailingZeros multiply32x16 min3 mid3 max3 atomicLoad \
         atomicStore imageAtomicLoad imageAtomicStore controlBarrier subpassLoad \
         doubleBitsToInt64 doubleBitsToUint64 int64BitsToDouble uint64BitsToDouble \
         float16BitsToInt16 float16BitsToUint16 int16BitsToFloat16 uint16BitsToFloat16 \
         halfBitsToInt16 halfBitsToUint16 int16BitsToHalf uint16BitsToHalf",
    ),
];

/// Beginnings of the names of functions of extensions: of subgroups, and of conversions between
/// several small numbers and one.
const PREFIXES: &[&str] =
    &["subgroup", "pack16", "pack32", "pack64", "unpack8", "unpack16", "unpack32"];

/// Conversions between two or four numbers and one.
const PACKED: &[&str] =
    &["Float2x16", "Int2x16", "Int2x32", "Int4x16", "Uint2x16", "Uint2x32", "Uint4x16"];

/// Whether a function of that name is built into GLSL 4.50 or an extension, but not into the
/// version of a shader. Names that end in that of a vendor are left out.
pub(super) fn is_later(name: &str, version: u32, es: bool) -> bool {
    // Functions of a table first, then those that extensions have under many names.
    let row = VERSIONS.iter().find(|(_, _, names)| WordList(names).contains(name));
    if let Some((desktop, mobile, _)) = row {
        return version < if es { *mobile } else { *desktop };
    }
    let packed = name.strip_prefix("un").unwrap_or(name).strip_prefix("pack");
    PREFIXES.iter().any(|prefix| name.starts_with(prefix))
        || packed.is_some_and(|rest| PACKED.contains(&rest))
}
