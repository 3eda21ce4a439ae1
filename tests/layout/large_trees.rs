//! Trees of many modules: what they cost grows with their number, and a chain of imports may be long.

#![cfg(target_os = "linux")]

use std::fs;
use std::path::PathBuf;

use landfall_layout::{Options, Severity, Source, layout};

/// A folder with modules, removed when done.
struct Tree(PathBuf);

impl Tree {
    fn new(name: &str, modules: impl Iterator<Item = (String, String)>) -> Tree {
        let root = std::env::temp_dir().join(format!("landfall-{name}-{}", std::process::id()));
        fs::create_dir_all(&root).expect("created");
        // The root of the package.
        fs::write(root.join("wesl.toml"), "root = \".\"\n").expect("written");
        for (file, text) in modules {
            fs::write(root.join(file), text).expect("written");
        }
        Tree(root)
    }
}

impl Drop for Tree {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Nanoseconds of the processor that this thread has used.
fn processor() -> u64 {
    let stat = fs::read_to_string("/proc/thread-self/schedstat").expect("Linux has it");
    stat.split(' ').next().and_then(|time| time.parse().ok()).expect("a number")
}

/// The size of the first block of a tree's main file, and the nanoseconds that it took.
fn size(tree: &Tree) -> (Option<u64>, u64) {
    let source = Source::read(tree.0.join("main.wesl")).expect("it is there");
    let before = processor();
    let shader = layout(&source, &Options::default());
    let taken = processor() - before;
    let errors = shader.diagnostics.iter().filter(|found| found.severity == Severity::Error);
    assert_eq!(errors.map(|found| &found.message).collect::<Vec<_>>(), [""; 0]);
    (shader.blocks[0].size, taken)
}

/// A main file whose structure holds one of each of so many modules.
fn wide(count: usize) -> Tree {
    let members: String = (0..count).map(|at| format!("m{at}: package::m{at}::S{at},\n")).collect();
    let main =
        format!("struct All {{ {members} }}\n@group(0) @binding(0) var<storage> all: All;\n");
    let modules = (0..count)
        .map(|at| (format!("m{at}.wesl"), format!("struct S{at} {{ a: f32, b: vec3f }}\n")));
    Tree::new(&format!("wide{count}"), modules.chain([("main.wesl".to_string(), main)]))
}

#[test]
fn time_grows_with_the_number_of_modules() {
    let (few, many) = (wide(1_000), wide(10_000));
    let (few_size, few_time) = size(&few);
    let (many_size, many_time) = size(&many);
    // WGSL 14.4.1: `a` at 0, `b` at 16, 32 in all.
    assert_eq!((few_size, many_size), (Some(32_000), Some(320_000)));
    println!("1,000 modules: {} ms, 10,000: {} ms", few_time / 1_000_000, many_time / 1_000_000);
    assert!(many_time < 30 * few_time, "{many_time} ns for ten times the modules of {few_time} ns");
}

#[test]
fn a_chain_of_imports_may_be_a_thousand_deep() {
    let deep = 1_000;
    let link = |at: usize| match at {
        at if at + 1 == deep => "const N = 7u;\n".to_string(),
        at => format!("import package::m{}::N as Next;\nconst N = Next;\n", at + 1),
    };
    let main = "import package::m0::N;\n@group(0) @binding(0) var<storage> a: array<vec4f, N>;\n";
    let modules = (0..deep).map(|at| (format!("m{at}.wesl"), link(at)));
    let tree = Tree::new("deep", modules.chain([("main.wesl".to_string(), main.to_string())]));
    let (size, time) = size(&tree);
    assert_eq!(size, Some(7 * 16));
    println!("a chain of 1,000: {} ms", time / 1_000_000);
    assert!(time < 30_000_000_000, "{time} ns");
}
