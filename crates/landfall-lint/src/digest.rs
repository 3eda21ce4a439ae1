//! Summaries of blocks, by which lints over all shaders find the shaders that they have to compare.
//!
//! Computed from [`ShaderLayout`]s and stored in caches, so that only shaders
//! with blocks that differ, or that the settings name, are laid out again.

use std::fmt::{self, Write as _};

use rustc_hash::{FxHashMap, FxHashSet};
use serde::{Deserialize, Serialize};

use super::block_mismatch;
use super::settings::Settings;
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::Type;
use landfall_layout::text::glob;
use landfall_layout::{Language, ShaderLayout};

/// The hashes of one block.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BlockDigest {
    /// The hashes of the keys it shares with every block that it is compared with.
    pub keys: Vec<u32>,
    /// The hashes of the names that the settings may use for it: its own, its instance's, its
    /// structures' and its members'.
    pub names: Vec<u32>,
    /// The hash of its layout, names and types included.
    pub layout: u64,
}

/// Returns the digests of a shader's blocks.
pub fn digest(shader: &ShaderLayout) -> Vec<BlockDigest> {
    shader.blocks.iter().map(|block| of_block(shader, block)).collect()
}

/// Returns the indices of the shaders about which lints over all shaders may report something.
pub fn shaders_to_compare(shaders: &[(&str, &[BlockDigest])], settings: &Settings) -> Vec<usize> {
    // A key under which blocks differ is one that a lint may report.
    let mut layouts: FxHashMap<u32, u64> = FxHashMap::default();
    let mut differing: FxHashSet<u32> = FxHashSet::default();
    for block in shaders.iter().flat_map(|(_, blocks)| *blocks) {
        for &key in &block.keys {
            if *layouts.entry(key).or_insert(block.layout) != block.layout {
                differing.insert(key);
            }
        }
    }
    let differs = |block: &BlockDigest| block.keys.iter().any(|key| differing.contains(key));
    let mut is_concerned: Vec<bool> =
        shaders.iter().map(|(_, blocks)| blocks.iter().any(differs)).collect();
    // What the settings name is always compared.
    for (file, name) in names_in_settings(settings) {
        let meant = |path: &str| file.is_empty() || glob::matches(&file, path);
        let meant: Vec<usize> = (0..shaders.len()).filter(|&i| meant(shaders[i].0)).collect();
        let has = |&i: &usize| shaders[i].1.iter().any(|block| block.names.contains(&name));
        let having: Vec<usize> = meant.iter().copied().filter(has).collect();
        // A name that is nowhere may be misspelt: then every block is a candidate.
        let all = if having.is_empty() { meant } else { having };
        all.into_iter().for_each(|i| is_concerned[i] = true);
    }
    (0..shaders.len()).filter(|&i| is_concerned[i]).collect()
}

/// Returns the names in the settings, the first of each path, each with the glob of its shaders.
fn names_in_settings(settings: &Settings) -> FxHashSet<(String, u32)> {
    let groups = settings.mirror_groups.iter().flat_map(|group| &group.copies);
    let copies = groups.map(|copy| (copy.file.clone(), copy.block.clone()));
    let tables = settings.tables.iter().map(|table| (table.file.clone(), table.block.clone()));
    let first = |name: &str| short(name.trim().split(['.', '[']).next().unwrap_or(name));
    let mirrors = settings.rust_mirrors.iter().map(|m| (m.shader.clone(), m.block.clone()));
    #[cfg(feature = "rust-mirrors")]
    let mirrors = mirrors.chain(super::rust_mirror::named(settings));
    copies.chain(tables).chain(mirrors).map(|(file, name)| (file, first(&name))).collect()
}

fn of_block(shader: &ShaderLayout, block: &BlockLayout) -> BlockDigest {
    let mut names = vec![short(&block.name)];
    names.extend(block.instance.as_deref().map(short));
    names.extend(block.members.iter().map(|member| short(&member.name)));
    structures(&block.members, &mut names);
    names.sort_unstable();
    names.dedup();
    BlockDigest {
        keys: block_mismatch::keys(shader, block).map(|key| short(&key)).collect(),
        names,
        layout: layout(block),
    }
}

fn structures(members: &[MemberLayout], names: &mut Vec<u32>) {
    for member in members {
        let mut ty = &member.ty;
        while let Type::Array { element, .. } = ty {
            ty = element;
        }
        if let Type::Struct(structure) = ty {
            names.push(short(&structure.name));
        }
        structures(&member.members, names);
    }
}

fn layout(block: &BlockLayout) -> u64 {
    // All that lints compare goes in: a difference that is not hashed is not found.
    let mut hash = Fnv::new();
    let written = write!(
        hash,
        "{} {:?} {:?} {:?} {} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
        block.name,
        block.instance,
        block.space,
        block.rules,
        block.rules_declared,
        block.group,
        block.binding,
        block.count,
        block.size,
        block.data_size,
        block.align,
        block.opaque,
    )
    .and_then(|()| members(&block.members, &mut hash));
    written.expect("hashing does not fail");
    for leaf in &block.leaves {
        let ty = leaf.ty.spelled(Language::Glsl);
        write!(hash, "\n{} {ty} {:?} {:?}", leaf.path, leaf.offset, leaf.dims)
            .and_then(|()| write!(hash, " {:?} {:?}", leaf.strides, leaf.size))
            .and_then(|()| write!(hash, " {:?} {}", leaf.matrix_stride, leaf.row_major))
            .expect("hashing does not fail");
    }
    hash.0
}

/// The names of structures are not in the leaves.
fn members(members_of: &[MemberLayout], hash: &mut Fnv) -> fmt::Result {
    for member in members_of {
        write!(hash, "({} {}", member.name, member.ty.spelled(Language::Glsl))?;
        members(&member.members, hash)?;
        hash.write_char(')')?;
    }
    Ok(())
}

fn short(name: &str) -> u32 {
    // A collision makes lints look at blocks that agree, and hides nothing.
    let long = fnv(name.as_bytes());
    (long ^ (long >> 32)) as u32
}

/// FNV-1a with 64 bits, implemented here because caches depend on its values.
pub fn fnv(bytes: &[u8]) -> u64 {
    let mut hash = Fnv::new();
    hash.bytes(bytes);
    hash.0
}

struct Fnv(u64);

impl Fnv {
    fn new() -> Fnv {
        Fnv(0xcbf2_9ce4_8422_2325)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

impl fmt::Write for Fnv {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.bytes(text.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Table;
    use landfall_layout::{Options, Source, layout};

    fn digests(text: &str) -> Vec<BlockDigest> {
        digest(&layout(&Source::new("a.frag", text), &Options::default()))
    }

    fn block(name: &str, binding: u32, members: &str) -> Vec<BlockDigest> {
        digests(&format!(
            "#version 450\nlayout(std140, binding = {binding}) uniform {name} {{ {members} }} u{name};\n"
        ))
    }

    fn concerned_of(shaders: &[Vec<BlockDigest>], settings: &Settings) -> Vec<usize> {
        let shaders: Vec<(&str, &[BlockDigest])> =
            shaders.iter().map(|blocks| ("a.frag", blocks.as_slice())).collect();
        shaders_to_compare(&shaders, settings)
    }

    // The values its authors publish for these texts.
    #[test]
    fn the_hash_is_fnv_1a() {
        assert_eq!(fnv(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv(b"foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn blocks_of_one_name_in_two_directories_are_not_compared() {
        let at = |path: &str, body: &str| {
            let text = format!("#version 450\nlayout(std140) uniform A {{ {body} }} a;\n");
            digest(&layout(&Source::new(path, text), &Options::default()))
        };
        let shaders =
            [at("x/a.frag", "vec3 a;"), at("y/a.frag", "vec4 a;"), at("y/a.vert", "mat4 a;")];
        assert_eq!(concerned_of(&shaders, &Settings::default()), [1, 2]);
    }

    #[test]
    fn only_blocks_that_differ_under_one_name_or_binding_are_of_concern() {
        let shaders = [
            block("A", 0, "vec3 a; float b;"),
            block("A", 0, "vec3 a; /* same */ float b;"),
            block("B", 1, "vec4 a;"),
            block("B", 2, "vec3 a;"),
            block("C", 3, "float a;"),
            block("D", 3, "float a; float b;"),
        ];
        assert_eq!(concerned_of(&shaders, &Settings::default()), [2, 3, 4, 5]);
    }

    #[test]
    fn blocks_the_settings_name_are_of_concern_and_all_when_one_is_nowhere() {
        let shaders = [block("A", 0, "float a;"), block("B", 1, "float lights[3];")];
        let table = |name: &str| Table { block: name.to_string(), ..Table::default() };
        let settings = |names: &[&str]| Settings {
            tables: names.iter().map(|name| table(name)).collect(),
            ..Settings::default()
        };
        assert_eq!(concerned_of(&shaders, &settings(&["A"])), [0]);
        assert_eq!(concerned_of(&shaders, &settings(&["uB"])), [1]);
        assert_eq!(concerned_of(&shaders, &settings(&["lights[].x"])), [1]);
        assert_eq!(concerned_of(&shaders, &settings(&["Gone"])), [0, 1]);
    }
}
