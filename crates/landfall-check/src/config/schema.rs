//! A configuration as it is written: the types of its JSON Schema.
//!
//! The parent module reads the same keys, each with its place; `tests/command/cli_init.rs` holds the
//! two together.

#![expect(dead_code, reason = "only their schema is used")]

use std::collections::BTreeMap;

use landfall_codegen::rust::Api;
use landfall_layout::diff::Policy;
use landfall_layout::finding::Level;
use landfall_layout::{Rules, Target};
use landfall_lint::settings::Target as Limits;
use schemars::JsonSchema;
use serde_json::{Map, Value};

type Texts = BTreeMap<String, String>;

/// The schema of `landfall.toml`.
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text_of_input::<WrittenConfig>("Configuration of landfall")
}

/// landfall.toml or .landfall.toml. Paths are relative to its directory.
#[derive(JsonSchema)]
#[schemars(rename_all = "kebab-case")]
struct WrittenConfig {
    /// The paths that `landfall check` and `landfall lock` read if none is named.
    paths: Option<Vec<String>>,
    /// Globs of paths, or of file or directory names at any depth, that are not read.
    exclude: Option<Vec<String>>,
    /// The directory of the lock files.
    #[schemars(extend("default" = super::LOCKS))]
    locks: Option<String>,
    /// A directory of findings, so that only changed shaders are checked again.
    cache_dir: Option<String>,
    /// A file of findings that `landfall check` permits.
    baseline: Option<String>,
    /// Directories in which `#include` is searched.
    include: Option<Vec<String>>,
    /// Macros, as `NAME` or `NAME=TEXT`.
    define: Option<WrittenMacros>,
    /// Flags of WESL's conditions, as `NAME` or `NAME=false`.
    #[schemars(inner(regex(pattern = "^[^=]+(=(true|false))?$")))]
    features: Option<Vec<String>>,
    /// Files whose text comes before that of each WGSL shader, in order.
    prelude: Option<Vec<String>>,
    /// Values of specialisation and override constants, as `NAME=VALUE`.
    #[schemars(inner(regex(pattern = "=")))]
    r#override: Option<Vec<String>>,
    /// The layout rules of every block.
    #[schemars(extend("enum" = Rules::OF_TEXT.map(Rules::name)))]
    rules: Option<String>,
    /// Whether loose uniforms are laid out as one block.
    #[schemars(extend("default" = false))]
    gather: Option<bool>,
    /// The dialect of GLSL in shaders that state neither.
    api: Option<Target>,
    /// The APIs whose limits hold.
    targets: Option<Vec<WrittenTarget>>,
    /// Sets of macros under which each shader is laid out, too.
    permutations: Option<Vec<WrittenMacros>>,
    /// Sets of macros, features and definitions of which one holds for some files.
    variants: Option<Vec<WrittenVariants>>,
    levels: Option<WrittenLevels>,
    /// New names of mirrors: of a structure or block, `FILE:NAME`, or a shader's file.
    rename: Option<Texts>,
    /// Types of the program in Rust mirrors: of a type, a structure, or `STRUCTURE.MEMBER`.
    types: Option<Texts>,
    /// Types of the program in C headers: of a type, or `STRUCTURE.MEMBER`.
    c_types: Option<Texts>,
    /// Traits that all types of Rust mirrors derive.
    derive: Option<Vec<String>>,
    bindings: Option<WrittenBindings>,
    policy: Option<WrittenPolicy>,
    /// Policies for some files; a later table takes precedence.
    path_policy: Option<Vec<WrittenPathPolicy>>,
    /// Levels in some files; a later table takes precedence.
    path_levels: Option<Vec<WrittenPathLevels>>,
    /// Copies of one block or structure under other names.
    mirror_group: Option<Vec<WrittenMirrorGroup>>,
    /// Sizes and offsets of a block that are written by hand elsewhere.
    table: Option<Vec<WrittenTable>>,
    /// A structure written by hand in Rust.
    rust_mirror: Option<Vec<WrittenRustMirror>>,
    /// Files of assertions about structures of the program, which `landfall emit` writes.
    assert: Option<Vec<WrittenAssert>>,
    /// A SPIR-V module and the text that it is compiled from, which `landfall check` compares.
    compiled: Option<Vec<WrittenCompiled>>,
    /// Demands on a function, as of `landfall prove`.
    prove: Option<Vec<WrittenProof>>,
}

#[derive(JsonSchema)]
struct WrittenMacros(
    #[schemars(inner(regex(pattern = "^[A-Za-z_][A-Za-z0-9_]*(=|$)")))] Vec<String>,
);

#[derive(JsonSchema)]
#[schemars(extend("enum" = Limits::ALL.map(Limits::name)))]
struct WrittenTarget(String);

#[derive(JsonSchema)]
struct WrittenVariants {
    /// A glob of the files.
    file: String,
    sets: Vec<WrittenMacros>,
    /// Whether they are laid out without any, too.
    base: Option<bool>,
}

/// Levels by lint; `all` and `warnings` are groups.
#[derive(JsonSchema)]
struct WrittenLevels(BTreeMap<String, WrittenLevel>);

#[derive(JsonSchema)]
#[schemars(extend("enum" = Level::ALL.map(Level::name)))]
struct WrittenLevel(String);

/// What `landfall emit` adds to Rust mirrors for an API.
#[derive(JsonSchema)]
#[schemars(rename_all = "kebab-case")]
struct WrittenBindings {
    /// The APIs, as `--bindings` names them.
    api: Option<Vec<WrittenApi>>,
    /// Programs of several shaders: the files of each, or `FILE:ENTRY`.
    programs: Option<BTreeMap<String, Vec<String>>>,
    /// Numbers of elements of arrays of resources that are declared without.
    counts: Option<BTreeMap<String, WrittenElements>>,
    /// Buffers that are bound with a dynamic offset.
    dynamic_offsets: Option<Vec<String>>,
    /// Textures of floats that are not filtered, samplers that do not filter.
    unfilterable: Option<Vec<String>>,
    /// Whether the shaders' text is part of the bindings.
    #[schemars(extend("default" = false))]
    embed_sources: Option<bool>,
}

#[derive(JsonSchema)]
#[schemars(extend("enum" = Api::NAMES.iter().map(|(name, _)| *name).collect::<Vec<_>>()))]
struct WrittenApi(String);

#[derive(JsonSchema)]
struct WrittenElements(#[schemars(range(min = 1, max = u32::MAX))] u32);

/// The changes of layouts that `landfall diff` and `landfall lock` refuse.
#[derive(JsonSchema)]
#[schemars(extend("enum" = Policy::ALL.map(Policy::name)))]
struct WrittenPolicy(String);

/// A glob of files; `*` stays in a directory, `**` does not.
#[derive(JsonSchema)]
struct WrittenGlob(String);

/// Members that have other names here.
#[derive(JsonSchema)]
struct WrittenAliases(Texts);

#[derive(JsonSchema)]
struct WrittenPathPolicy {
    file: WrittenGlob,
    policy: WrittenPolicy,
}

#[derive(JsonSchema)]
struct WrittenPathLevels {
    file: WrittenGlob,
    levels: WrittenLevels,
}

#[derive(JsonSchema)]
struct WrittenMirrorGroup {
    /// Its name in messages.
    name: String,
    #[schemars(length(min = 2))]
    copies: Vec<WrittenCopy>,
}

#[derive(JsonSchema)]
struct WrittenCopy {
    file: Option<WrittenGlob>,
    /// The block, its instance, or a path such as `lights[]`.
    block: String,
    /// What the names of all its members begin with.
    prefix: Option<String>,
    aliases: Option<WrittenAliases>,
}

#[derive(JsonSchema)]
#[schemars(extend("allOf" = [{"anyOf": [{"required": ["size"]}, {"required": ["offsets"]}]}]))]
struct WrittenTable {
    /// The block, or its instance.
    block: String,
    file: Option<WrittenGlob>,
    size: Option<WrittenBytes>,
    /// Offsets by path, such as `data[0].pos`.
    offsets: Option<BTreeMap<String, WrittenBytes>>,
}

/// A number of bytes, or arithmetic such as `48 * 128 + 16`.
#[derive(JsonSchema)]
#[schemars(untagged)]
enum WrittenBytes {
    Number(u64),
    Arithmetic(String),
}

#[derive(JsonSchema)]
struct WrittenRustMirror {
    /// The Rust file.
    file: String,
    /// The structure in it.
    structure: String,
    /// The block, its instance, or a structure in it.
    block: String,
    shader: Option<WrittenGlob>,
    aliases: Option<WrittenAliases>,
}

#[derive(JsonSchema)]
#[schemars(rename_all = "kebab-case")]
struct WrittenAssert {
    /// The file, relative to the configuration.
    out: String,
    /// Its language.
    #[schemars(extend("enum" = ["c", "rust", "zig", "csharp"]))]
    lang: String,
    /// Files, directories and globs.
    shaders: Vec<String>,
    /// Structures of the program, with what they are in the shaders.
    structures: Texts,
    /// The program's names of members; an empty one where it has none.
    fields: Option<Texts>,
    /// What the program's names begin with.
    field_prefix: Option<String>,
    /// Headers to include (C), or the file to import (Zig).
    include_header: Option<Vec<String>>,
}

#[derive(JsonSchema)]
struct WrittenCompiled {
    /// The text.
    source: String,
    /// The module.
    spirv: String,
}

#[derive(JsonSchema)]
#[schemars(rename_all = "kebab-case")]
struct WrittenProof {
    file: WrittenGlob,
    /// Its name, or an overload such as `f(vec3)`.
    function: String,
    /// Whether to demand that no result is NaN.
    no_nan: Option<bool>,
    /// Whether to demand that no result is infinite.
    no_inf: Option<bool>,
    /// The largest error in units in the last place.
    #[schemars(range(min = 0))]
    max_ulp: Option<f64>,
    /// The largest error in steps of 1/255.
    #[schemars(range(min = 0))]
    max_step: Option<f64>,
    /// Ranges of inputs, as of the option --domain.
    domain: Option<Map<String, Value>>,
    /// Limit of processor time in seconds.
    #[schemars(range(min = 0))]
    time: Option<f64>,
}
