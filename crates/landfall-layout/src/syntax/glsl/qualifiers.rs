//! The qualifiers in front of a declaration (GLSL 4.60 §4.3 to §4.10).

use crate::text::word_filter::WordFilter;

/// Interpolation, auxiliary and invariance qualifiers.
pub(crate) const INTERPOLATION: &[&str] =
    &["flat", "smooth", "noperspective", "centroid", "sample", "patch", "invariant"];

/// Other qualifiers without an effect on the layout.
pub(crate) const SILENT: &[&str] = &[
    "precise",
    "lowp",
    "mediump",
    "highp",
    "superp",
    "coherent",
    "volatile",
    "restrict",
    "readonly",
    "writeonly",
    "devicecoherent",
    "queuefamilycoherent",
    "workgroupcoherent",
    "subgroupcoherent",
    "shadercallcoherent",
    "nonprivate",
    "nontemporal",
    "nonuniformEXT",
    "perprimitiveNV",
    "perprimitiveEXT",
    "perviewNV",
    "pervertexNV",
    "pervertexEXT",
    "__explicitInterpAMD",
];

/// Storage qualifiers of variables without a byte layout.
pub(crate) const OTHER_STORAGE: &[&str] = &[
    "in",
    "out",
    "inout",
    "attribute",
    "varying",
    "shared",
    "rayPayloadEXT",
    "rayPayloadInEXT",
    "rayPayloadNV",
    "rayPayloadInNV",
    "hitAttributeEXT",
    "hitAttributeNV",
    "callableDataEXT",
    "callableDataInEXT",
    "callableDataNV",
    "callableDataInNV",
    "hitObjectAttributeEXT",
    "hitObjectAttributeNV",
    "taskNV",
    "taskPayloadSharedEXT",
    "tileImageEXT",
];

const BLOCK_STORAGE: &[&str] = &["const", "uniform", "buffer"];

/// Whether a word may be among the qualifiers before a type.
// Asked of every word of every declaration: the filter answers for most of those that are types or
// names, without a search of the lists.
pub fn is_qualifier(word: &str) -> bool {
    const FILTER: WordFilter =
        WordFilter::NONE.with(BLOCK_STORAGE).with(OTHER_STORAGE).with(INTERPOLATION).with(SILENT);
    let mut lists = [BLOCK_STORAGE, OTHER_STORAGE, INTERPOLATION, SILENT].into_iter();
    FILTER.may_contain(word) && lists.any(|list| list.contains(&word))
}
