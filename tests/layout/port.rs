//! Old GLSL ported to Vulkan's: glslang compiles it with the bindings and
//! locations as they are written, its block has the layout the loose uniforms
//! have when gathered, what need not change did not, and an OpenGL driver
//! draws the same picture with both.

use crate::support;
use crate::support::command::golden;
use snapbox::str;

use std::path::Path;

use landfall_layout::{Options, Source, layout};
use landfall_port::{Dialect, Direction, PortOptions, Ported, port};
use support::driver::{Api, Driver};
use support::picture::draw;
use support::{files, glslang};

fn fixture(name: &str) -> Source {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/port").join(name);
    let text = std::fs::read_to_string(path).expect("the fixture is there");
    Source::new(name, text)
}

fn beside(partner: &Source) -> PortOptions {
    let mut options = PortOptions::default();
    options.partner = Some(partner.clone());
    options
}

fn with_partner(partner: &str) -> PortOptions {
    beside(&fixture(partner))
}

fn ported(source: &Source, options: &PortOptions) -> Ported {
    port(source, options).unwrap_or_else(|e| panic!("{}: {e:#?}", source.path))
}

fn text(source: &str) -> Result<String, String> {
    let result = port(&Source::new("test.frag", source), &PortOptions::default());
    result.map(|p| p.source.text.to_string()).map_err(|mut e| e.swap_remove(0).message)
}

const PAIRS: [(&str, &str); 3] =
    [("room.vert", "room.frag"), ("mobile.vert", "mobile.frag"), ("desktop.vert", "desktop.frag")];

fn all() -> Vec<(Source, Ported)> {
    let mut all = Vec::new();
    for (vert, frag) in PAIRS {
        all.push((fixture(vert), ported(&fixture(vert), &with_partner(frag))));
        all.push((fixture(frag), ported(&fixture(frag), &with_partner(vert))));
    }
    all.push((
        fixture("old_blocks.frag"),
        ported(&fixture("old_blocks.frag"), &PortOptions::default()),
    ));
    all
}

#[test]
fn glslang_compiles_what_is_ported_and_lays_it_out_as_gathered() {
    for (source, ported) in all() {
        let stage = source.path.split('.').next_back().expect("an extension");
        let options = glslang::Options { auto_map: false, reflect: false, ..Default::default() };
        let blocks = glslang::blocks(&ported.source.text, stage, &options)
            .unwrap_or_else(|e| panic!("{}: {e}\n{}", source.path, ported.source.text));
        let gathered = layout(&source, &Options::default().with_gather(true));
        let gathered = gathered.blocks.iter().find(|b| &*b.name == "DefaultBlock");
        let gathered = gathered.expect("every fixture has loose uniforms");
        let block = ported.block.as_deref().expect("and so a block");
        let moved = blocks.iter().find(|b| b.name == block).expect("glslang lists it");
        assert_eq!(moved.leaves.len(), gathered.leaves.len(), "{}", source.path);
        for leaf in &gathered.leaves {
            let found = moved.leaves.iter().find(|l| l.path == ported.new_path(&leaf.path));
            let found = found.unwrap_or_else(|| panic!("{}: no {}", source.path, leaf.path));
            assert_eq!(Some(found.offset), leaf.offset, "{}: {}", source.path, leaf.path);
            let strides: Vec<u64> = found.strides.iter().flatten().copied().collect();
            assert_eq!(strides, leaf.strides, "{}: {}", source.path, leaf.path);
            assert!(!found.row_major, "{}: {}", source.path, leaf.path);
        }
    }
}

/// Our own shaders: the old ones become Vulkan's, the others stay compilable.
#[test]
fn every_shader_of_ours_is_ported() {
    let stage = |path: &Path| path.extension().map_or(String::new(), |e| e.display().to_string());
    let is_wanted = |path: &Path| ["vert", "frag", "comp"].contains(&stage(path).as_str());
    let (mut ported_files, mut gathered) = (0, 0);
    for path in files::below(["shaders"], is_wanted) {
        let source = Source::read(&path).expect("a shader");
        let ported = ported(&source, &PortOptions::default());
        let options = glslang::Options {
            auto_map: false,
            reflect: false,
            target_env: Some("vulkan1.2"),
            include_dirs: vec!["shaders/include".into()],
            ..Default::default()
        };
        glslang::blocks(&ported.source.text, &stage(&path), &options)
            .unwrap_or_else(|e| panic!("{}: {e}\n{}", source.path, ported.source.text));
        ported_files += 1;
        gathered += usize::from(ported.block.is_some());
    }
    assert!(ported_files >= 40 && gathered >= 15, "{ported_files} shaders, {gathered} gathered");
}

#[test]
fn nothing_is_bound_twice() {
    for (vert, frag) in PAIRS {
        let mut bindings = ported(&fixture(vert), &with_partner(frag)).bindings;
        bindings.extend(ported(&fixture(frag), &with_partner(vert)).bindings);
        let mut numbers: Vec<u32> = bindings.iter().map(|b| b.binding).collect();
        numbers.sort_unstable();
        let before = numbers.len();
        numbers.dedup();
        assert_eq!(numbers.len(), before, "{vert} and {frag}: {bindings:#?}");
    }
}

#[test]
fn both_stages_agree_on_locations() {
    for (vert, frag) in PAIRS {
        let out = ported(&fixture(vert), &with_partner(frag)).locations;
        let into = ported(&fixture(frag), &with_partner(vert)).locations;
        let mut shared = 0;
        for read in into.iter().filter(|l| l.direction == Direction::In) {
            let written = out.iter().find(|l| l.direction == Direction::Out && l.name == read.name);
            assert_eq!(written.map(|l| l.location), Some(read.location), "{}", read.name);
            shared += 1;
        }
        assert!(shared >= 2, "{vert}");
    }
}

/// Lines no change falls into are in the result, in order, and no comment is lost.
#[test]
fn what_need_not_change_stays_as_it_is() {
    let touched = [
        "uniform",
        "sampler",
        "attribute",
        "varying",
        "in ",
        "out ",
        "texture",
        "gl_Frag",
        "#if",
        "#version",
        "#extension",
        "shadow2D",
        "sample",
        "flat",
        "Wall w",
        "cover(",
        "light(",
        "SAMPLE",
        "gloss_of(",
        "buffer",
    ];
    for (source, ported) in all() {
        let mut rest = ported.source.text.lines();
        for line in source.text.lines().filter(|line| !line.trim().is_empty()) {
            if touched.iter().all(|word| !line.contains(word)) && !line.trim().starts_with("//") {
                assert!(rest.any(|new| new == line), "{}: lost `{line}`", source.path);
            }
        }
        for line in source.text.lines() {
            if let Some((_, comment)) = line.split_once("//") {
                let kept = ported.source.text.contains(comment);
                assert!(kept || comment.contains("its colour"), "{}: //{comment}", source.path);
            }
        }
    }
}

#[test]
fn initial_values_and_new_names_are_reported() {
    let room = ported(&fixture("room.frag"), &with_partner("room.vert"));
    let values: Vec<_> = room.values.iter().map(|v| (&*v.name, &*v.value)).collect();
    assert_eq!(values, [("exposure", "1.25")]);
    let new = |old: &str| room.renamed.iter().find(|row| row.0 == old).map(|row| row.1.as_str());
    assert_eq!(new("wall.paint"), Some("wall_paint"));
    assert_eq!(new("layers.mask"), Some("layers_mask"));
    let mobile = ported(&fixture("mobile.frag"), &PortOptions::default());
    let renamed: Vec<_> = mobile.renamed.iter().map(|(old, new)| (&**old, &**new)).collect();
    assert_eq!(renamed, [("texture", "texture_"), ("sample", "sample_")]);
}

/// The picture of a pair, and that of the pair ported: the original with each uniform set by its
/// name, the ported text with one buffer. The driver is OpenGL's, so `set = N` is taken out.
fn pictures(driver: &Driver, [vert, frag]: [&Source; 2]) -> [Vec<u32>; 2] {
    let both = [ported(vert, &beside(frag)), ported(frag, &beside(vert))];
    let before = draw(driver, [vert, frag], &[]);
    let renamed: Vec<_> = both.iter().flat_map(|p| p.renamed.clone()).collect();
    let after = draw(driver, [&both[0].source, &both[1].source], &renamed);
    let distinct: std::collections::BTreeSet<_> = before.iter().collect();
    assert!(distinct.len() > 500, "{}: a picture of {} values", frag.path, distinct.len());
    [before, after]
}

#[test]
fn a_driver_draws_the_same_picture_bit_for_bit() {
    let driver = Driver::open(Api::Gl);
    for (vert, frag) in &PAIRS[..2] {
        // OpenGL ES computes in 16 bits where it is allowed to; here nothing allows it.
        let high = |name: &str| {
            let source = fixture(name);
            let text = source.text.replace("lowp", "highp").replace("mediump", "highp");
            Source { text: text.into(), ..source }
        };
        let [before, after] = pictures(&driver, [&high(vert), &high(frag)]);
        let differ = before.iter().zip(&after).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "{frag}: values that differ of {}", before.len());
    }
}

/// Vulkan's GLSL keeps `lowp` and `mediump`, but OpenGL 4.5 takes no notice of them, so the
/// pictures differ by what 16 bits cost the original.
#[test]
fn lower_precision_costs_the_original_less_than_a_step() {
    let driver = Driver::open(Api::Gl);
    let [before, after] = pictures(&driver, [&fixture("mobile.vert"), &fixture("mobile.frag")]);
    let far = before.iter().zip(&after);
    let far = far.map(|(a, b)| (f32::from_bits(*a) - f32::from_bits(*b)).abs());
    let far = far.fold(0.0, f32::max);
    assert!(far < 1.0 / 255.0, "{far}");
}

#[test]
fn porting_twice_changes_nothing_more() {
    for (source, once) in all() {
        let twice = ported(&once.source, &PortOptions::default());
        let bound = once.source.text.contains("binding");
        assert!(bound && twice.block.is_none(), "{}", source.path);
        assert_eq!(twice.source.text, once.source.text, "{}", source.path);
    }
}

#[test]
fn what_cannot_be_ported_is_refused_by_name() {
    for (source, message) in [
        (
            "void main() { gl_FragColor = gl_Color; }",
            "`gl_Color` is state of the fixed-function pipeline, which Vulkan lacks",
        ),
        (
            "struct M { sampler2D a; float b; }; uniform M m;\nvoid f(M x) {}\n\
             void main() { M copy = m; f(copy); }",
            "this copies `M`, which contains samplers or images",
        ),
        (
            "#define U uniform vec3\nU eye;\nvoid main() { gl_FragColor = vec4(eye, 1.0); }",
            "`eye` is declared by a macro or in an include",
        ),
        (
            "uniform float a[];\nvoid main() { gl_FragColor = vec4(a[2]); }",
            "the array `a` has no size, which a block needs",
        ),
        (
            "uniform float a;\nfloat f() { return a; }\nstruct S { float x; };\nuniform S s;\n\
             void main() { gl_FragColor = vec4(f() + s.x); }",
            "`a` is used before the types of all loose uniforms are declared",
        ),
        (
            "void main() { for (int i = 0; i < 2; i++) gl_FragData[i] = vec4(1.0); }",
            "`gl_FragData` is not indexed by a literal",
        ),
        (
            "void main() { gl_FragData[4294967295] = vec4(1.0); }",
            "`gl_FragData` is not indexed by a literal",
        ),
        (
            "struct M { sampler2D a; }; uniform M m;\n#define A m.a\n\
             void main() { gl_FragColor = texture2D(A, vec2(0.5)); }",
            "a macro uses `m`, which contains samplers or images",
        ),
    ] {
        assert_eq!(text(source), Err(message.to_string()), "{source}");
    }
}

#[test]
fn declarations_stay_outside_conditions() {
    let new = text(
        "#define FANCY\nuniform float a;\n#ifdef FANCY\nuniform float b;\n#endif\n\
         void main() { gl_FragColor = vec4(a + b); }\n",
    );
    let want = "#version 450\n#define FANCY\n#ifdef FANCY\n#endif\n\
                layout(set = 0, binding = 0, std140) uniform DefaultBlock {\n    float a;\n    \
                float b;\n};\nlayout(location = 0) out vec4 FragColor;\n\
                void main() { FragColor = vec4(a + b); }\n";
    assert_eq!(new.as_deref(), Ok(want));
}

#[test]
fn each_name_of_a_declaration_keeps_its_dimensions() {
    let new = text("#version 430\nuniform sampler2D[2] a, b;\nvoid main() {}\n");
    let want = "#version 450\n\
                layout(set = 0, binding = 0) uniform sampler2D[2] a; \
                layout(set = 0, binding = 1) uniform sampler2D[2] b;\n\
                void main() {}\n";
    assert_eq!(new.as_deref(), Ok(want));
}

#[test]
fn numbers_of_layout_qualifiers_are_constant_expressions() {
    let new = text(
        "#version 450\n#define BASE 2\nconst int N = 3;\n\
         layout(std140, binding = 1 + 1) uniform U { vec4 a; };\n\
         layout(binding = BASE + N) uniform sampler2D t;\n\
         layout(location = N - 2) out vec4 c;\nuniform vec4 b;\n\
         void main() { c = a + b + texture(t, vec2(0.0)); }\n",
    )
    .expect("it is portable");
    golden().eq(
        new,
        str![[r#"
#version 450
#define BASE 2
const int N = 3;
layout(set = 0, binding = 2, std140) uniform U { vec4 a; };
layout(set = 0, binding = 5) uniform sampler2D t;
layout(location = N - 2) out vec4 c;
layout(set = 0, binding = 0, std140) uniform DefaultBlock {
    vec4 b;
};
void main() { c = a + b + texture(t, vec2(0.0)); }

"#]],
    );
}

#[test]
fn locations_that_two_names_have_are_refused() {
    let of = |outputs: &str, locations: &[(&str, u32)]| {
        let text = format!("#version 330\n{outputs}\nvoid main() {{ b = vec2(1.0); }}\n");
        let mut options = PortOptions::default();
        options.locations = locations.iter().map(|(name, at)| (name.to_string(), *at)).collect();
        let ported = port(&Source::new("a.frag", text), &options);
        ported.map(|p| p.source.text.to_string()).map_err(|mut e| e.swap_remove(0).message)
    };
    let shared = Err("`b` has a location of `a`".to_string());
    let both = "layout(location = 1) out vec2 a, b;";
    assert_eq!(of(both, &[]), shared);
    let array = "layout(location = 1) out vec2 a[2]; layout(location = 2) out vec2 b;";
    assert_eq!(of(array, &[]), shared);
    assert_eq!(of("out vec2 a, b;", &[("a", 3), ("b", 3)]), shared);
    let apart = of(both, &[("b", 2)]).expect("each has its own");
    assert!(
        apart.contains("layout(location = 1) out vec2 a; layout(location = 2) out vec2 b;"),
        "{apart}"
    );
    // Parts of one location.
    let parts = "layout(location = 1, component = 0) out vec2 a;
                 layout(location = 1, component = 2) out vec2 b;";
    assert!(of(parts, &[]).is_ok());
    // The two stages have other names for it.
    let vert = "#version 330\nlayout(location = 0) out vec2 a;\nvoid main() { a = vec2(1.0); }\n";
    let frag =
        "#version 330\nlayout(location = 0) in vec2 b;\nout vec2 c;\nvoid main() { c = b; }\n";
    let frag = Source::new("a.frag", frag);
    assert!(port(&Source::new("a.vert", vert), &beside(&frag)).is_ok());
}

#[test]
fn functions_share_the_names_of_handles_of_their_parameters() {
    let ported = text(
        "#version 330\nstruct M { sampler2D t; float f; };\nuniform M q;\n\
         vec4 a(M q) { return texture(q.t, vec2(q.f)); }\n\
         vec4 b(M q, M s) { return a(q) + a(s); }\n\
         out vec4 o;\nvoid main() { o = b(q, q); }\n",
    );
    let ported = ported.expect("it is portable");
    for line in [
        "vec4 a(M q, sampler2D q_t_) { return texture(q_t_, vec2(q.f)); }",
        "vec4 b(M q, sampler2D q_t_, M s, sampler2D s_t) { return a(q, q_t_) + a(s, s_t); }",
        "void main() { o = b(q, q_t, q, q_t); }",
    ] {
        assert!(ported.contains(line), "{line}: {ported}");
    }
}

/// Broken text is refused or ported, never a panic.
#[test]
fn broken_text_does_no_harm() {
    let mut rng = fastrand::Rng::with_seed(7);
    let names = ["room.vert", "room.frag", "mobile.frag", "desktop.frag", "old_blocks.frag"];
    let mut refused = 0;
    for round in 0..3000 {
        let source = fixture(names[round % names.len()]);
        let mut words: Vec<&str> =
            source.text.split_inclusive([' ', '(', ')', ';', '\n', ',', '.', '[']).collect();
        for _ in 0..rng.usize(1..4) {
            let (from, to) = (rng.usize(..words.len()), rng.usize(..words.len()));
            match rng.u8(..3) {
                0 => drop(words.remove(from)),
                1 => words.insert(to, words[from]),
                _ => words.swap(from, to),
            }
        }
        let broken = Source { text: words.concat().into(), ..source };
        let dialect = if round % 2 == 0 { Dialect::Vulkan } else { Dialect::Naga };
        let mut options = PortOptions::default();
        options.dialect = dialect;
        refused += usize::from(port(&broken, &options).is_err());
    }
    assert!(refused > 500 && refused < 3000, "{refused}");
}
