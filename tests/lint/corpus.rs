//! The shaders of this repository: laid out without an error, as compilers and
//! drivers lay them out, and as `layouts/` records.
//!
//! `layouts/` is written by `landfall lock shaders --prune`.

use crate::support;

use std::fs;
use std::path::Path;
#[cfg(feature = "cli")]
use std::path::PathBuf;

use landfall_layout::{ArrayLen, Options, Rules, ShaderLayout, Source, layout};
use support::command::{Place, run};
use support::driver::{Api, Driver, Stage};
use support::files::shaders;
use support::glslang;
use support::leaf::{Difference, OracleBlock, What, differences};

fn read(path: &Path, options: &Options) -> ShaderLayout {
    layout(&Source::read(path).expect("a readable shader"), options)
}

/// What is left after the ways of speaking that are known: SPIR-V has no bool, calls the type of
/// an address a reference, and a driver's own rules are its own.
fn unexplained(ours: &ShaderLayout, theirs: &[OracleBlock]) -> Vec<Difference> {
    let mut ours_table = support::landfall::table(ours);
    ours_table.retain(|block| {
        let layout = ours.blocks.iter().find(|b| *b.name == *block.name).expect("its own block");
        layout.rules_declared
    });
    let mut theirs = theirs.to_vec();
    theirs.retain(|block| ours_table.iter().any(|b| b.name == block.name));
    let mut found = differences(&ours_table, &theirs);
    found.retain(|d| {
        // `known.rs`: glslang counts no element of a runtime-sized tail in scalar.
        let ends_open = ours.blocks.iter().any(|b| {
            let last = b.leaves.last().expect("a block has leaves");
            *b.name == *d.block
                && b.rules == Rules::Scalar
                && last.dims.contains(&ArrayLen::Runtime)
        });
        if ends_open && d.what == What::DataSize {
            return false;
        }
        let as_uint = |ty: &str| ty.replace("bool", "uint").replace("bvec", "uvec");
        d.what != What::Type
            || (as_uint(&d.left) != as_uint(&d.right) && !d.right.contains("reference"))
    });
    found
}

fn glslang_stage(shader: &ShaderLayout) -> &'static str {
    match shader.stage {
        Some(landfall_layout::Stage::Vertex) => "vert",
        Some(landfall_layout::Stage::Fragment) => "frag",
        Some(landfall_layout::Stage::Compute) => "comp",
        other => panic!("{}: {other:?} is no stage of these shaders", shader.path),
    }
}

#[test]
fn every_shader_is_laid_out_without_an_error() {
    let shaders = shaders();
    assert!(shaders.len() > 60, "{} shaders", shaders.len());
    for path in shaders {
        let shader = read(&path, &Options::default());
        assert!(!shader.has_errors(), "{}: {:#?}", path.display(), shader.diagnostics);
        let gathered = read(&path, &Options::default().with_gather(true));
        assert!(!gathered.has_errors(), "{}: {:#?}", path.display(), gathered.diagnostics);
    }
}

#[test]
fn vulkan_shaders_are_laid_out_as_glslang_does() {
    let mut blocks = 0;
    for path in shaders() {
        let shader = read(&path, &Options::default());
        let text = fs::read_to_string(&path).expect("a readable shader");
        if !text.contains("#version 450") || shader.stage.is_none() {
            continue;
        }
        let options = glslang::Options {
            target_env: Some("vulkan1.2"),
            include_dirs: vec![path.parent().expect("in a folder").to_path_buf()],
            ..glslang::Options::default()
        };
        let theirs = glslang::blocks(&text, glslang_stage(&shader), &options)
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let found = unexplained(&shader, &theirs);
        assert!(found.is_empty(), "{}: {found:#?}", path.display());
        blocks += shader.blocks.len();
    }
    assert!(blocks >= 30, "{blocks} blocks compared");
}

#[test]
fn opengl_shaders_are_laid_out_as_the_driver_does() {
    // A context is current on its thread: one after the other.
    let blocks = held_against_the_driver(Api::Gl) + held_against_the_driver(Api::Gles);
    assert!(blocks >= 15, "{blocks} blocks compared");
}

fn held_against_the_driver(api: Api) -> usize {
    let driver = Driver::open(api);
    let mut blocks = 0;
    for path in shaders() {
        let mut ours = read(&path, &Options::default());
        let text = fs::read_to_string(&path).expect("a readable shader");
        let opengl =
            !text.contains("#version 450") && ours.language == landfall_layout::Language::Glsl;
        let name = path.file_stem().expect("a file name").to_string_lossy();
        let es = name.ends_with("00es");
        let stage = match ours.stage {
            Some(landfall_layout::Stage::Vertex) if opengl => Stage::Vertex,
            Some(landfall_layout::Stage::Fragment) if opengl => Stage::Fragment,
            _ => continue,
        };
        if es != (api == Api::Gles) {
            continue;
        }
        let mut stages = vec![(stage, text.as_str())];
        // OpenGL ES links no stage alone.
        let partner = fs::read_to_string(path.with_extension("vert")).unwrap_or_default();
        if es && stage == Stage::Fragment {
            stages.insert(0, (Stage::Vertex, &partner));
        } else if es {
            continue;
        }
        let theirs = driver.blocks(&stages).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        // Loose uniforms have no offsets, neither here nor there.
        ours.blocks.retain(|block| block.size.is_some());
        let found = unexplained(&ours, &theirs);
        assert!(found.is_empty(), "{}: {found:#?}", path.display());
        blocks += ours.blocks.iter().filter(|block| block.rules_declared).count();
    }
    blocks
}

/// glslang can gather loose uniforms too (`-R`), where no structure holds a sampler.
#[test]
fn gathered_uniforms_lie_as_glslang_gathers_them() {
    let mut compared = 0;
    for path in shaders() {
        let shader = read(&path, &Options::default().with_gather(true));
        let Some(ours) = shader.blocks.iter().find(|b| &*b.name == "DefaultBlock") else {
            continue;
        };
        if shader.stage.is_none() {
            continue;
        }
        let text = fs::read_to_string(&path).expect("a readable shader");
        let text = text.replacen("#version 330 core", "#version 450", 1);
        let options = glslang::Options { relaxed: true, ..glslang::Options::default() };
        let Ok(theirs) = glslang::blocks(&text, glslang_stage(&shader), &options) else { continue };
        let Some(theirs) = theirs.iter().find(|b| b.name == "gl_DefaultUniformBlock") else {
            continue;
        };
        // A sampler left inside a structure makes glslang's block invalid SPIR-V.
        if theirs.leaves.len() != ours.leaves.len() {
            continue;
        }
        for (a, b) in ours.leaves.iter().zip(&theirs.leaves) {
            assert_eq!(a.path, b.path, "{}", path.display());
            assert_eq!(a.offset, Some(b.offset), "{} {}", path.display(), a.path);
            let strides: Vec<_> = a.strides.iter().copied().map(Some).collect();
            assert_eq!(strides, b.strides, "{} {}", path.display(), a.path);
            compared += 1;
        }
    }
    assert!(compared >= 50, "{compared} leaves compared");
}

/// The facts every tutorial's light block is judged by.
#[test]
fn the_block_of_128_point_lights_is_where_its_engine_expects_it() {
    let shader = read(Path::new("shaders/light_arrays/point_lights_330.frag"), &Options::default());
    let block = shader.blocks.iter().find(|b| &*b.name == "PointLightBlock").expect("the block");
    let color = block.leaves.iter().find(|l| l.path == "data[].color").expect("a color");
    assert_eq!(color.offset.map(|offset| offset + 3 * color.strides[0]), Some(160));
    let count = block.leaves.iter().find(|l| l.path == "actually_used_count").expect("a count");
    assert_eq!((count.offset, block.size, block.data_size), (Some(6144), Some(6160), Some(6148)));
}

#[cfg(feature = "cli")]
#[test]
fn the_locks_are_those_of_the_shaders() {
    let place = Place::new("lint-layouts");
    let out = place.path("layouts");
    run(&["lock", "shaders", "--quiet", "--locks", &out]).code(0);
    let (recorded, computed) = (tree(Path::new("layouts")), tree(Path::new(&out)));
    let names = |tree: &[(PathBuf, String)]| tree.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&recorded), names(&computed));
    for (old, new) in recorded.iter().zip(&computed) {
        assert!(
            old.1 == new.1,
            "layouts/{} is not what landfall says now; if the change is meant, run\n  \
             landfall lock shaders --prune",
            old.0.display()
        );
    }
}

#[cfg(feature = "cli")]
#[test]
fn check_finds_nothing_to_report_in_this_repository() {
    let ran = run(&["check", "--deny", "warnings"]);
    ran.code(0);
    let told = format!("checked {} shaders: no findings\n", shaders().len());
    assert!(ran.err.contains(&told), "{}", ran.err);
}

#[cfg(feature = "cli")]
fn tree(root: &Path) -> Vec<(PathBuf, String)> {
    fn walk(root: &Path, dir: &Path, found: &mut Vec<(PathBuf, String)>) {
        for entry in fs::read_dir(dir).expect("a directory of layouts") {
            let path = entry.expect("a readable directory").path();
            if path.is_dir() {
                walk(root, &path, found);
            } else {
                let name = path.strip_prefix(root).expect("below its root").to_path_buf();
                found.push((name, fs::read_to_string(&path).expect("a layout")));
            }
        }
    }
    let mut found = Vec::new();
    walk(root, root, &mut found);
    found.sort();
    found
}
