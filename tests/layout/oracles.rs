//! Holds the oracles against each other, so that what the crate is held
//! against is worth trusting: random blocks, every block of two members, and
//! the list of known disagreements with who follows the specification.
//!
//! The crate itself is the third party, held against each of them.

use crate::support;

use std::collections::HashMap;

use support::blocks::{Block, Rules, declared};
use support::driver::{Api, Driver, Stage};
use support::generate::{COMMON, VULKAN, random};
use support::glslang::Client;
use support::known::{KNOWN, Oracle, Shown, Subject, explains, within_the_driver};
use support::leaf::{Difference, OracleBlock, What, differences};
use support::pairs::{pair_count, pairs};
use support::run::{Batch, ask_driver, ask_glslang, spread};
use support::sample::sample;
use support::{glslang, landfall, naga_wgsl, wgsl};

use ::landfall::Target;

/// Random blocks to a batch, which is one glslang process.
const BATCH: usize = 150;
/// Pairs to a batch.
const PAIRS: usize = 400;

#[test]
fn random_blocks_are_laid_out_alike() {
    let seeds: Vec<u64> = sample(0..140, 10).collect();
    let found = spread(&seeds, |driver, &seed| {
        let (standing, blocks) = random(seed, BATCH, &COMMON);
        judge(Some(driver), &Batch { name: format!("seed {seed}"), standing, blocks })
    });
    assert_none(&found);
}

#[test]
fn random_vulkan_blocks_are_listed_as_declared() {
    let seeds: Vec<u64> = sample(0..40, 10).collect();
    let found = spread(&seeds, |_, &seed| {
        let (standing, blocks) = random(seed, BATCH, &VULKAN);
        judge(None, &Batch { name: format!("Vulkan seed {seed}"), standing, blocks })
    });
    assert_none(&found);
}

/// Otherwise the tests above would hold little against anything.
#[test]
fn the_driver_is_asked_about_most_random_blocks() {
    let (mut all, mut asked, mut explicit) = (0, 0, 0);
    for seed in 0..20 {
        let (standing, blocks) = random(seed, BATCH, &COMMON);
        for block in &blocks {
            all += 1;
            if within_the_driver(Subject { block, standing: &standing }) {
                asked += 1;
                explicit += usize::from(block.members.iter().any(|m| m.align.is_some()));
            }
        }
    }
    assert!(asked * 10 > all * 8, "{asked} of {all}");
    assert!(explicit * 50 > all, "{explicit} of {all} with align");
}

#[test]
fn every_pair_of_members_is_laid_out_alike_in_std140() {
    pairs_are_laid_out_alike(Rules::Std140);
}

#[test]
fn every_pair_of_members_is_laid_out_alike_in_std430() {
    pairs_are_laid_out_alike(Rules::Std430);
}

#[test]
fn every_pair_of_members_is_listed_as_declared_in_scalar() {
    pairs_are_laid_out_alike(Rules::Scalar);
}

fn pairs_are_laid_out_alike(rules: Rules) {
    let numbers: Vec<u64> = sample(0..pair_count(), 10).collect();
    let batches: Vec<&[u64]> = numbers.chunks(PAIRS).collect();
    let found = spread(&batches, |driver, numbers| {
        let blocks = pairs(rules, numbers);
        let driver = (rules != Rules::Scalar).then_some(driver);
        judge(driver, &Batch { name: format!("{rules:?} pairs"), standing: Vec::new(), blocks })
    });
    assert_none(&found);
}

/// Everything the parties say differently of a batch that no known
/// disagreement explains, each with the shader that shows it.
fn judge(driver: Option<&Driver>, batch: &Batch) -> Vec<String> {
    let subjects: HashMap<&str, Subject<'_>> = batch
        .blocks
        .iter()
        .map(|block| (block.name.as_str(), Subject { block, standing: &batch.standing }))
        .collect();
    let mut found = Vec::new();
    let mut complain = |who: &str, block: &str, what: &str| {
        let text = batch.text_of(block);
        found.push(format!("{}: {who}: {what}\n{text}", batch.name));
    };
    let mut weigh = |who: &str, differences: Vec<Difference>, wrong: Option<Oracle>| {
        for difference in differences {
            let subject = subjects[difference.block.as_str()];
            if explains(subject, &difference, wrong).is_none() {
                complain(who, &difference.block, &difference.to_string());
            }
        }
    };

    let glslang = ask_glslang(batch);
    let asked = |block: &Block| within_the_driver(Subject { block, standing: &batch.standing });
    let (driven, refused) = match driver {
        Some(driver) => ask_driver(driver, batch, asked),
        None => (Vec::new(), Vec::new()),
    };
    let also_driven = |blocks: &[OracleBlock]| -> Vec<OracleBlock> {
        let answered = |name: &str| {
            driver.is_some()
                && asked(subjects[name].block)
                && refused.iter().all(|(block, _)| block != name)
        };
        blocks.iter().filter(|b| answered(&b.name)).cloned().collect()
    };
    weigh(
        "glslang against the driver",
        differences(&with_buffer_size(also_driven(&glslang)), &driven),
        None,
    );
    // The driver reads the text as OpenGL's, glslang as Vulkan's where there is no driver.
    let target = if driver.is_some() { Target::OpenGl } else { Target::Vulkan };
    let ours = landfall::glsl_blocks(&batch.text(), target);
    weigh("landfall against glslang", differences(&ours, &glslang), Some(Oracle::Glslang));
    let ours = also_driven(&ours);
    weigh("landfall against the driver", differences(&ours, &driven), Some(Oracle::Driver));
    for (block, log) in &refused {
        complain("the driver refuses", block, log);
    }
    for block in &batch.blocks {
        if let Some(what) = not_as_declared(block, &glslang) {
            complain("glslang", &block.name, &what);
        }
    }
    found
}

/// What is missing or too much in a block's listing, going by its text alone.
fn not_as_declared(block: &Block, listed: &[OracleBlock]) -> Option<String> {
    let Some(listed) = listed.iter().find(|b| b.name == block.name) else {
        return Some(format!("{} is not listed", block.name));
    };
    let as_uint = |ty: &str| ty.replace("bool", "uint").replace("bvec", "uvec");
    let declared = declared(block);
    let same = declared.len() == listed.leaves.len()
        && declared
            .iter()
            .zip(&listed.leaves)
            .all(|(d, l)| d.path == l.path && as_uint(&d.ty) == as_uint(&l.ty) && d.dims == l.dims);
    (!same).then(|| format!("{declared:#?}\nis listed as\n{:#?}", listed.leaves))
}

/// glslang says where the last member ends; a driver wants a buffer of that,
/// rounded up to a vec4.
fn with_buffer_size(mut blocks: Vec<OracleBlock>) -> Vec<OracleBlock> {
    for block in &mut blocks {
        block.size = block.data_size.map(|end| end.next_multiple_of(16));
    }
    blocks
}

fn assert_none(found: &[String]) {
    let shown: Vec<&str> = found.iter().take(5).map(String::as_str).collect();
    assert!(found.is_empty(), "{} in all; the first:\n{}", found.len(), shown.join("\n"));
}

#[test]
fn every_known_disagreement_still_shows() {
    let driver = Driver::open(Api::Gl);
    for known in KNOWN {
        let text = format!(
            "#version 450\nlayout(local_size_x = 1) in;\n{}\n\
             shared float sink;\nvoid main() {{ sink = float(b.a{}); }}\n",
            known.example,
            touch(known.example)
        );
        let name = known.name;
        let glslang = glslang::blocks(&text, "comp", &glslang::Options::default())
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let driven = driver.blocks(&[(Stage::Compute, &text)]);
        match known.shown {
            Shown::DataSize { glslang: theirs, right } => {
                let ours = landfall::glsl_blocks(&text, Target::Vulkan);
                assert_eq!(block(&glslang).data_size, Some(theirs), "{name}");
                assert_eq!(block(&ours).data_size, Some(right), "{name}");
            }
            Shown::Refused { log } => {
                let answer = driven.expect_err(name);
                assert!(answer.contains(log), "{name}: {answer}");
            }
            Shown::Unlisted { path } => {
                let driven = driven.unwrap_or_else(|e| panic!("{name}: {e}"));
                assert!(leaf(&glslang, path).is_some(), "{name}");
                assert_eq!(leaf(&driven, path), None, "{name}");
            }
            Shown::Offset { path, glslang: ours, driver: theirs } => {
                let driven = driven.unwrap_or_else(|e| panic!("{name}: {e}"));
                assert_eq!(leaf(&glslang, path).map(|l| l.offset), Some(ours), "{name}");
                assert_eq!(leaf(&driven, path).map(|l| l.offset), Some(theirs), "{name}");
            }
            Shown::Type { path, glslang: ours, driver: theirs } => {
                let driven = driven.unwrap_or_else(|e| panic!("{name}: {e}"));
                assert_eq!(leaf(&glslang, path).map(|l| l.ty.as_str()), Some(ours), "{name}");
                assert_eq!(leaf(&driven, path).map(|l| l.ty.as_str()), Some(theirs), "{name}");
            }
            Shown::Size { glslang: ours, driver: theirs } => {
                let driven = driven.unwrap_or_else(|e| panic!("{name}: {e}"));
                assert_eq!(block(&glslang).data_size, Some(ours), "{name}");
                assert_eq!(block(&driven).size, Some(theirs), "{name}");
            }
        }
    }
}

/// What to read of `b.a` so that the block is in use.
fn touch(example: &str) -> &'static str {
    if example.contains("T a;") {
        ".t.x"
    } else if example.contains("mat") {
        "[0].x"
    } else if example.contains("vec3 a;") {
        ".x"
    } else {
        ""
    }
}

fn block(blocks: &[OracleBlock]) -> &OracleBlock {
    blocks.iter().find(|b| b.name == "B").expect("the examples declare a block B")
}

fn leaf<'b>(blocks: &'b [OracleBlock], path: &str) -> Option<&'b support::leaf::OracleLeaf> {
    block(blocks).leaves.iter().find(|l| l.path == path)
}
/// OpenGL ES lists through glGetActiveUniform; the rules are the same.
#[test]
fn es_blocks_are_laid_out_as_on_the_desktop() {
    let uniform = "struct Light { vec3 pos; float range; mat3 turn; bool on; };
        layout(std140, row_major) uniform Lights {
            int count; Light data[3]; layout(column_major) mat4x3 view; vec2 w[2]; } lights;";
    let storage = "struct Light { vec3 pos; float range; mat3 turn; bool on; };
        layout(std430) buffer Lights { int count; vec2 w[2]; Light data[]; } lights;";
    let vertex = "out vec3 colour;
        void main() { colour = lights.data[1].pos; gl_Position = vec4(0.0); }";
    let fragment = "in vec3 colour; out vec4 o; void main() { o = vec4(colour, 1.0); }";
    let compute = "layout(local_size_x = 1) in; void main() { lights.count = 1; }";
    let drawn = |header: &str| {
        let texts = [
            (Stage::Vertex, format!("{header}\n{uniform}\n{vertex}")),
            (Stage::Fragment, format!("{header}\n{fragment}")),
        ];
        texts.to_vec()
    };
    let computed = |header: &str| vec![(Stage::Compute, format!("{header}\n{storage}\n{compute}"))];
    let ask = |driver: &Driver, stages: Vec<(Stage, String)>| {
        let stages: Vec<_> = stages.iter().map(|(stage, text)| (*stage, text.as_str())).collect();
        driver.blocks(&stages).unwrap_or_else(|e| panic!("{}: {e}", driver.name()))
    };
    let precision = "precision highp float;";
    let es = Driver::open(Api::Gles);
    let es_uniform = ask(&es, drawn(&format!("#version 300 es\n{precision}")));
    let es_storage = ask(&es, computed(&format!("#version 310 es\n{precision}")));
    drop(es);
    let desktop = Driver::open(Api::Gl);
    assert_eq!(es_uniform, ask(&desktop, drawn("#version 330")));
    assert_eq!(es_storage, ask(&desktop, computed("#version 430")));
    assert_eq!(es_uniform[0].leaves.len(), 7, "{es_uniform:#?}");
    assert_eq!(es_storage[0].leaves.len(), 6, "{es_storage:#?}");

    let options = glslang::Options { client: Client::OpenGl, reflect: false, ..Default::default() };
    for (stages, stage, listed) in [
        (drawn(&format!("#version 310 es\n{precision}")), "vert", &es_uniform),
        (computed(&format!("#version 310 es\n{precision}")), "comp", &es_storage),
    ] {
        let read = glslang::blocks(&stages[0].1, stage, &options).unwrap_or_else(|e| panic!("{e}"));
        let beyond_bool: Vec<_> =
            differences(&read, listed).into_iter().filter(|d| d.what != What::Type).collect();
        assert_eq!(beyond_bool, []);
    }
}

/// What only Vulkan GLSL has, and every option of the call.
#[test]
fn glslang_is_read_where_the_driver_cannot_follow() {
    let include = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("oracle-include");
    std::fs::create_dir_all(&include).expect("a folder under target");
    std::fs::write(include.join("light.glsl"), "struct Light { vec3 pos; float range; };\n")
        .expect("a file under target");
    let text = "#version 460
        #extension GL_GOOGLE_include_directive : require
        #extension GL_EXT_buffer_reference : require
        #include \"light.glsl\"
        layout(constant_id = 3) const int N = 5;
        layout(buffer_reference, std430) buffer Node { vec3 p; float w[]; };
        layout(push_constant) uniform Push { vec2 g; float a[COUNT]; Node first; } push;
        layout(std140) uniform Sized { Light data[N + 1]; } sized[2];
        uniform float loose;
        void main() { gl_Position = vec4(push.first.w[0] + sized[1].data[0].range + loose); }";
    let options = glslang::Options {
        relaxed: true,
        target_env: Some("vulkan1.3"),
        defines: vec!["COUNT=2".to_owned()],
        include_dirs: vec![include],
        ..Default::default()
    };
    let blocks = glslang::blocks(text, "vert", &options).unwrap_or_else(|e| panic!("{e}"));
    let mut told: Vec<String> = Vec::new();
    for block in &blocks {
        for leaf in &block.leaves {
            told.push(format!(
                "{}{:?} {} {} {:?}",
                block.name, block.count, leaf.path, leaf.ty, leaf.dims
            ));
        }
    }
    told.sort();
    assert_eq!(
        told,
        [
            "Node[] p vec3 []",
            "Node[] w[] float [None]",
            "Push[] a[] float [Some(2)]",
            "Push[] first reference []",
            "Push[] g vec2 []",
            "Sized[Some(2)] data[].pos vec3 [Some(6)]",
            "Sized[Some(2)] data[].range float [Some(6)]",
            "gl_DefaultUniformBlock[] loose float []",
        ]
    );
}

/// encase and naga agree but for the structures that hold one with `@align`
/// on a member (gfx-rs/wgpu#4377, naga 30.0.1): WGSL §14.4.2 has the member's
/// alignment count towards its structure's, and encase does so.
#[test]
fn wgsl_structures_are_laid_out_alike() {
    const NAGA_IS_WRONG: [&str; 4] =
        ["InnerAligned", "InnerAlignedFirst", "ArrayOfAligned", "TailOfAligned"];
    let text = wgsl::text();
    let encase: Vec<OracleBlock> = wgsl::cases().into_iter().map(|case| case.block).collect();
    assert!(encase.len() >= 60, "{}", encase.len());
    let naga = naga_wgsl::blocks(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let ours = differences(&landfall::wgsl_blocks(&text), &encase);
    assert!(ours.is_empty(), "{}", ours.iter().map(|d| format!("{d}\n")).collect::<String>());
    let differ = differences(&encase, &naga);
    let mut names: Vec<&str> = differ.iter().map(|d| d.block.as_str()).collect();
    names.dedup();
    let shown: Vec<String> = differ.iter().map(ToString::to_string).collect();
    assert_eq!(names, NAGA_IS_WRONG, "{}", shown.join("\n"));
}

/// OpenGL leaves a block without rules (`shared`) to the driver: Mesa packs it
/// as std430. In Vulkan GLSL the same text is std140. Neither is wrong, and
/// numbers for such a block hold for one of them at most.
#[test]
fn a_uniform_block_without_rules_differs_between_opengl_and_vulkan() {
    let text = "#version 450
        layout(local_size_x = 1) in;
        uniform B { float a; float w[2]; } b;
        shared float sink;
        void main() { sink = b.a; }";
    let vulkan = glslang::blocks(text, "comp", &glslang::Options::default())
        .unwrap_or_else(|e| panic!("{e}"));
    let opengl =
        Driver::open(Api::Gl).blocks(&[(Stage::Compute, text)]).unwrap_or_else(|e| panic!("{e}"));
    let place = |blocks: &[OracleBlock]| leaf(blocks, "w[]").map(|l| (l.offset, l.strides[0]));
    assert_eq!(place(&vulkan), Some((16, Some(16))));
    assert_eq!(place(&opengl), Some((4, Some(4))));
}
