//! Random trees of conditions around blocks, members and lengths: the layouts of all variants against
//! glslang's of the text with those macros.

use landfall_layout::{Options, ShaderLayout, Source, layout, variants};

use crate::support::{glslang, sample};

const FLAGS: [&str; 5] = ["SHADOWS", "FOG", "SKIN", "HIGH", "CLUSTERED"];

/// A linear congruential generator.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % bound
    }

    fn flag(&mut self) -> &'static str {
        FLAGS[self.below(FLAGS.len() as u64) as usize]
    }

    /// A condition of `#if`.
    fn condition(&mut self, depth: u64) -> String {
        let (a, b) = (self.flag(), self.flag());
        let number = self.below(3);
        match self.below(if depth > 1 { 5 } else { 8 }) {
            0 => format!("defined({a})"),
            1 => format!("!defined {a}"),
            2 => format!("defined({a}) && defined({b})"),
            3 => format!("defined({a}) || !defined({b})"),
            4 => format!("defined({a}) && {a} > {number}"),
            5 => format!("({}) && !({})", self.condition(depth + 1), self.condition(depth + 1)),
            6 => format!("({}) || ({})", self.condition(depth + 1), self.condition(depth + 1)),
            _ => format!("LEVEL * 2 >= {number} + 1"),
        }
    }

    /// Conditions around some of what `line` gives, in `budget` steps.
    fn tree(&mut self, depth: u64, line: &mut dyn FnMut(&mut Random) -> String) -> String {
        let mut text = String::new();
        for _ in 0..=self.below(3) {
            if depth > 3 || self.below(3) == 0 {
                text.push_str(&line(self));
                continue;
            }
            let flag = self.flag();
            text.push_str(&match self.below(3) {
                0 => format!("#ifdef {flag}\n"),
                1 => format!("#ifndef {flag}\n"),
                _ => format!("#if {}\n", self.condition(0)),
            });
            text.push_str(&self.tree(depth + 1, line));
            for _ in 0..self.below(3) {
                text.push_str(&format!("#elif {}\n", self.condition(0)));
                text.push_str(&self.tree(depth + 1, line));
            }
            if self.below(2) == 0 {
                text.push_str("#else\n");
                text.push_str(&self.tree(depth + 1, line));
            }
            text.push_str("#endif\n");
        }
        text
    }

    fn shader(&mut self) -> String {
        let mut number = 0;
        let mut lengths = self.tree(1, &mut |random| {
            let value = random.below(7) + 1;
            format!("#undef N\n#define N {value}\n")
        });
        lengths.insert_str(0, "#define N 2\n");
        let mut member = |random: &mut Random| {
            number += 1;
            let ty = ["float", "vec2", "vec3", "vec4", "mat3", "int"][random.below(6) as usize];
            let length = ["", "[N]", "[N + 1]"][random.below(3) as usize];
            format!("    {ty} m{number}{length};\n")
        };
        let mut binding = 0;
        let blocks = self.tree(0, &mut |random| {
            binding += 1;
            let rules = ["std140", "std430"][random.below(2) as usize];
            let members = random.tree(1, &mut member);
            format!(
                "layout({rules}, binding = {binding}) buffer B{binding} {{\n    float first;\n{members}}} \
                 b{binding};\n"
            )
        });
        format!(
            "#version 450\n#ifndef LEVEL\n#define LEVEL 0\n#endif\n{lengths}{blocks}void main() {{}}\n"
        )
    }

    fn set(&mut self) -> Vec<(String, String)> {
        let mut set = Vec::new();
        for flag in FLAGS.into_iter().chain(["LEVEL", "UNUSED"]) {
            if self.below(2) == 0 {
                set.push((flag.to_string(), self.below(4).to_string()));
            }
        }
        set
    }
}

fn ours(shader: &ShaderLayout, text: &str) -> Vec<String> {
    assert!(!shader.has_errors(), "{:#?}\n{text}", shader.diagnostics);
    let leaves = shader.blocks.iter().flat_map(|b| b.leaves.iter().map(move |leaf| (b, leaf)));
    let rows = leaves.map(|(block, leaf)| {
        let offset = leaf.offset.expect("it is in a buffer");
        format!("{} {} {offset} {:?}", block.name, leaf.path, leaf.strides)
    });
    let mut rows: Vec<String> = rows.collect();
    rows.sort();
    rows
}

fn theirs(text: &str, macros: &[(String, String)]) -> Vec<String> {
    let defines: String = macros.iter().map(|(name, v)| format!("#define {name} {v}\n")).collect();
    let text = text.replacen("#version 450\n", &format!("#version 450\n{defines}"), 1);
    let options = glslang::Options::unlisted();
    let blocks = glslang::blocks(&text, "frag", &options);
    let blocks = blocks.unwrap_or_else(|report| panic!("{report}\n{text}"));
    let leaves = blocks.iter().flat_map(|b| b.leaves.iter().map(move |leaf| (b, leaf)));
    let rows = leaves.map(|(block, leaf)| {
        let strides: Vec<u64> = leaf.strides.iter().flatten().copied().collect();
        format!("{} {} {} {strides:?}", block.name, leaf.path, leaf.offset)
    });
    let mut rows: Vec<String> = rows.collect();
    rows.sort();
    rows
}

/// 300 trees, each under six sets of macros.
#[test]
fn every_variant_of_random_conditions_is_laid_out_as_by_glslang() {
    let mut different = 0;
    for seed in sample::sample(0..300, 10) {
        let mut random = Random(seed * 7919 + 3);
        let text = random.shader();
        let sets: Vec<_> = (0..6).map(|_| random.set()).collect();
        let source = Source::new("tree.frag", text.as_str());
        let options = Options::default();
        let shader = layout(&source, &options);
        let base = ours(&shader, &text);
        assert_eq!(base, theirs(&text, &[]), "{text}");
        for variant in variants(&source, &options, &shader, &sets) {
            let rows = variant.layout.as_deref().map_or(base.clone(), |one| ours(one, &text));
            assert_eq!(rows, theirs(&text, &variant.macros), "{:?}\n{text}", variant.macros);
            different += usize::from(rows != base);
        }
    }
    assert!(different > 30, "{different} variants differ");
}

/// Sets that differ in what no file names, and equal sets, have one layout.
#[test]
fn sets_that_agree_on_the_macros_of_the_files_share_a_layout() {
    let text = "#version 450\n#ifdef SHADOWS\n#include \"x.glsl\"\n#endif\nvoid main() {}\n";
    let included = "#ifdef FOG\n#define N 2\n#else\n#define N 1\n#endif\n\
                    layout(std430, binding = 0) buffer B { float a[N]; } b;\n";
    let mut options = Options::default();
    let files = [("a.frag", text), ("x.glsl", included)];
    options.read.files =
        Some(files.map(|(path, text)| (path.to_string(), text.to_string())).to_vec());
    let source = Source::new("a.frag", text);
    let set = |names: &[&str]| -> Vec<(String, String)> {
        names.iter().map(|name| (name.to_string(), "1".to_string())).collect()
    };
    let sets = [
        set(&["SHADOWS"]),
        set(&["SHADOWS", "OTHER"]),
        set(&["FOG", "SHADOWS"]),
        set(&["OTHER", "SHADOWS", "FOG"]),
        set(&["OTHER"]),
    ];
    let found = variants(&source, &options, &layout(&source, &options), &sets);
    let sizes: Vec<Option<u64>> = found
        .iter()
        .map(|one| one.layout.as_deref().and_then(|layout| layout.blocks.first()?.size))
        .collect();
    assert_eq!(sizes, [Some(4), Some(4), Some(8), Some(8), None]);
    assert!(found[4].layout.is_none(), "no file names `OTHER`");
}
