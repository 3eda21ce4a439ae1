//! What `port` writes compiles: functions that clash with later built-in ones get other names, and
//! what two stages share has one declaration and one binding. glslang is the oracle: for which
//! functions there are, for what compiles, and for what links.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::process::{Command, Output};

use landfall_layout::{Options, Source, layout};
use landfall_port::{PortOptions, Ported, port};

use crate::support::glslang;

/// The functions of GLSL 1.10 §8 and of GLSL ES 1.00 §8, which a shader may not declare anew in
/// Vulkan's GLSL.
const FIRST: &[&str] = &[
    "abs",
    "acos",
    "all",
    "any",
    "asin",
    "atan",
    "ceil",
    "clamp",
    "cos",
    "cross",
    "degrees",
    "distance",
    "dot",
    "equal",
    "exp",
    "exp2",
    "faceforward",
    "floor",
    "fract",
    "greaterThan",
    "greaterThanEqual",
    "inversesqrt",
    "length",
    "lessThan",
    "lessThanEqual",
    "log",
    "log2",
    "matrixCompMult",
    "max",
    "min",
    "mix",
    "mod",
    "normalize",
    "not",
    "notEqual",
    "pow",
    "radians",
    "reflect",
    "refract",
    "sign",
    "sin",
    "smoothstep",
    "sqrt",
    "step",
    "tan",
];

const VENDORS: &[&str] = &["AMD", "ARB", "EXT", "KHR", "NV"];

/// Those of GLSL 1.10, which an extension adds to GLSL ES 1.00.
const DERIVATIVES: &[&str] = &["dFdx", "dFdy", "fwidth"];

fn ported(path: &str, text: &str, options: &PortOptions) -> Ported {
    port(&Source::new(path, text), options).unwrap_or_else(|e| panic!("{e:#?}\n{text}"))
}

fn plain(path: &str, text: &str) -> Ported {
    ported(path, text, &PortOptions::default())
}

fn compiles(ported: &Ported, stage: &str) {
    let options = glslang::Options {
        auto_map: false,
        reflect: false,
        target_env: Some("vulkan1.2"),
        ..Default::default()
    };
    let text = &ported.source.text;
    glslang::blocks(text, stage, &options).unwrap_or_else(|e| panic!("{e}\n{text}"));
}

/// Every built-in function of Vulkan's GLSL 4.50 that has parameters and a result of the types
/// that all versions have, with one such list of parameters.
fn builtin_functions() -> BTreeMap<String, (String, Vec<String>)> {
    let mut command = Command::new("glslangValidator");
    let place = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("port_builtins.frag");
    std::fs::write(&place, "#version 450\nvoid main() {}\n").expect("it is written");
    command.args(["--dump-builtin-symbols", "-V", "-o", "/dev/null"]).arg(&place);
    let listed = command.output().expect("glslangValidator runs").stdout;
    let ty = |words: &str| -> Option<String> {
        let words: Vec<&str> =
            words.split_whitespace().filter(|w| *w != "in" && *w != "global").collect();
        match words[..] {
            [scalar @ ("float" | "int" | "bool"), ..] => Some(scalar.to_string()),
            [n, "vector", "of", scalar @ ("float" | "int" | "bool"), ..] => {
                let letter = scalar.trim_start_matches("float").get(..1).unwrap_or("");
                Some(format!("{letter}vec{}", &n[..1]))
            }
            [n, "matrix", "of", "float", ..] if n[..1] == n[2..] => Some(format!("mat{}", &n[..1])),
            _ => None,
        }
    };
    let mut functions = BTreeMap::new();
    for line in String::from_utf8_lossy(&listed).lines() {
        let Some((name, rest)) = line.split_once(':') else { continue };
        let Some((before, parameters)) =
            rest.split(" <").next().unwrap_or("").trim_end_matches(')').split_once('(')
        else {
            continue;
        };
        let returns = ty(&before.replace(&format!(" {name}"), "").replace("-component", " "));
        let parameters = parameters.replace("-component", " ");
        let parameters = parameters.split(',').map(ty).collect::<Option<Vec<_>>>();
        if let (Some(returns), Some(parameters)) = (returns, parameters) {
            functions.entry(name.to_string()).or_insert((returns, parameters));
        }
    }
    functions
}

#[test]
fn own_functions_give_way_to_later_built_in_ones() {
    let all = builtin_functions();
    for name in ["fma", "inverse", "isnan", "min3", "round", "transpose", "trunc"] {
        assert!(all.contains_key(name), "{all:?}");
    }
    let base: BTreeSet<&str> = FIRST.iter().chain(DERIVATIVES).copied().collect();
    for version in ["110", "100"] {
        let mut text = format!("#version {version}\n");
        let mut uses = String::new();
        if version == "100" {
            text.push_str("precision mediump float;\n");
        }
        let mut own = Vec::new();
        for (name, (returns, parameters)) in &all {
            // Names that end in a vendor's are nobody's own.
            if base.contains(name.as_str()) || VENDORS.iter().any(|end| name.ends_with(end)) {
                continue;
            }
            let named: Vec<String> =
                parameters.iter().enumerate().map(|(n, ty)| format!("{ty} p{n}")).collect();
            let values: Vec<String> = parameters.iter().map(|ty| format!("{ty}(1)")).collect();
            let one =
                format!("{returns} {name}({}) {{ return {returns}(1); }}\n", named.join(", "));
            uses.push_str(&format!("    {returns} v_{name} = {name}({});\n", values.join(", ")));
            text.push_str(&one);
            own.push(name.as_str());
        }
        text.push_str(&format!("void main() {{\n{uses}    gl_FragColor = vec4(v_round);\n}}\n"));
        assert!(glslang::accepts(&text, "frag"), "{text}");
        let ported = plain("a.frag", &text);
        compiles(&ported, "frag");
        let renamed: Vec<&str> = ported.functions.iter().map(|(old, _)| &**old).collect();
        assert_eq!(renamed, own, "{version}");
    }
}

#[test]
fn a_function_of_the_version_itself_keeps_its_name() {
    let text = "#version 330\nout vec4 c;\nvoid main() { c = vec4(round(1.5) + inverse(mat2(1.0))[0][0]); }\n";
    let ported = plain("a.frag", text);
    assert_eq!(ported.functions, []);
    compiles(&ported, "frag");
}

/// GLSL 1.20 has `transpose`, and lets a shader declare it anew.
#[test]
fn a_redefined_function_on_matrices_is_told_from_the_built_in_one() {
    let text = "#version 120\n\
                mat3 transpose(mat3 m) { return mat3(m[0], m[1], vec3(7.0)); }\n\
                mat3 turn(mat3 m) { return transpose(m); }\n\
                uniform mat4 whole;\nuniform mat3 part;\n\
                void main() {\n    gl_FragColor = transpose(whole) * vec4(turn(part)[0], 1.0)\n        \
                + transpose(mat4(1.0))[0] + vec4(transpose(part * part)[0], 0.0);\n}\n";
    assert!(glslang::accepts(text, "frag"));
    let ported = plain("a.frag", text);
    compiles(&ported, "frag");
    assert_eq!(ported.functions, [("transpose".to_string(), "transpose_".to_string())]);
    let uses = |word: &str| ported.source.text.matches(word).count();
    assert_eq!((uses("transpose_("), uses("transpose(")), (3, 2), "{}", ported.source.text);
}

#[test]
fn members_and_macros_beside_a_renamed_function_are_kept_apart() {
    let text = "#version 110\nstruct S { float round; };\nuniform S s;\n\
                float round(float x) { return floor(x + 0.5); }\n#define ROUND round\n\
                void main() { gl_FragColor = vec4(ROUND(s.round) + round(1.5)); }\n";
    assert!(glslang::accepts(text, "frag"));
    let ported = plain("a.frag", text);
    compiles(&ported, "frag");
    assert_eq!(ported.new_path("s.round"), "s.round");
    assert!(ported.source.text.contains("ROUND(s.round) + round_(1.5)"), "{}", ported.source.text);
}

const VERTEX: &str = "#version 330 core\n\
    struct Sun { vec3 way; float power; };\n\
    layout(location = 0) in vec3 position;\n\
    uniform mat4 model, view;\n\
    uniform Sun sun;\n\
    uniform float height; // of the vertices\n\
    uniform sampler2D relief;\n\
    uniform sampler2D paint;\n\
    layout(std140) uniform Frame { vec4 time; };\n\
    out vec2 uv;\n\
    void main() {\n    uv = position.xy * sun.power + time.xy + texture(paint, position.xy).xy;\n    \
    gl_Position = view * model * vec4(position + textureLod(relief, uv, 0.0).xyz * height, 1.0);\n}\n";

const FRAGMENT: &str = "#version 330 core\n\
    struct Sun { vec3 way; float power; };\n\
    in vec2 uv;\n\
    uniform vec3 eye;\n\
    // Where it shines from.\n\
    uniform Sun sun;\n\
    uniform mat4 view, own;\n\
    uniform sampler2D paint;\n\
    uniform sampler2D gloss;\n\
    layout(std140) uniform Frame { vec4 time; };\n\
    out vec4 color;\n\
    void main() {\n    color = texture(paint, uv) + texture(gloss, uv) + time;\n    \
    color.xyz += sun.way * (view * own * vec4(eye, 1.0)).xyz;\n}\n";

/// Both stages of a program, each ported beside the other.
fn pair(vertex: &str, fragment: &str) -> [Ported; 2] {
    let sources = [Source::new("a.vert", vertex), Source::new("a.frag", fragment)];
    [0, 1].map(|stage| {
        let mut options = PortOptions::default();
        options.partner = Some(sources[1 - stage].clone());
        port(&sources[stage], &options).unwrap_or_else(|e| panic!("{e:#?}"))
    })
}

/// glslang's linker, which refuses members of blocks without an instance that two stages have in
/// different blocks.
fn link(name: &str, stages: &[Ported; 2]) -> Output {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let mut command = Command::new("glslangValidator");
    command.args(["-V", "-l", "-o", "/dev/null"]);
    for (ported, stage) in stages.iter().zip(["vert", "frag"]) {
        let path = folder.join(format!("{name}.{stage}"));
        std::fs::write(&path, &*ported.source.text).expect("it is written");
        command.arg(path);
    }
    command.output().expect("glslangValidator runs")
}

#[test]
fn what_both_stages_have_is_in_one_block_with_one_binding() {
    assert!(glslang::accepts(VERTEX, "vert") && glslang::accepts(FRAGMENT, "frag"));
    let both = pair(VERTEX, FRAGMENT);
    let linked = link("port_shared", &both);
    let said = String::from_utf8_lossy(&linked.stdout);
    assert!(linked.status.success(), "{said}\n{}\n{}", both[0].source.text, both[1].source.text);
    let [first, second] = both.each_ref().map(|ported| {
        assert_eq!(ported.shared.as_deref(), Some("DefaultBlock"));
        let blocks = layout(&ported.source, &Options::default()).blocks;
        let block = blocks.into_iter().find(|block| &*block.name == "DefaultBlock");
        block.expect("it is declared").leaves
    });
    let rows = |leaves: &[landfall_layout::Leaf]| -> Vec<_> {
        leaves.iter().map(|leaf| (leaf.path.clone(), leaf.offset)).collect()
    };
    assert_eq!(rows(&first), rows(&second));
    let expected = [("view", 0), ("sun.way", 64), ("sun.power", 76)];
    assert_eq!(rows(&first), expected.map(|(path, offset)| (path.to_string(), Some(offset))));
    // The same name, the same binding; another name, another binding.
    let mut names: BTreeMap<u32, BTreeSet<&str>> = BTreeMap::new();
    for binding in both.iter().flat_map(|ported| &ported.bindings) {
        names.entry(binding.binding).or_default().insert(&binding.name);
    }
    assert!(names.values().all(|names| names.len() == 1), "{names:?}");
    let of: Vec<&str> = names.values().flatten().copied().collect();
    let all = [
        "DefaultBlock",
        "DefaultBlockVertex",
        "relief",
        "paint",
        "Frame",
        "DefaultBlockFragment",
        "gloss",
    ];
    assert_eq!(of.iter().copied().collect::<BTreeSet<_>>(), all.into_iter().collect());
    assert_eq!(of.len(), all.len(), "{of:?}");
}

#[test]
fn a_stage_without_uniforms_of_its_own_has_the_shared_block_only() {
    let vertex = "#version 330 core\nuniform vec4 a;\nvoid main() { gl_Position = a; }\n";
    let fragment = "#version 330 core\nuniform float b;\nuniform vec4 a;\nout vec4 c;\n\
                    void main() { c = a * b; }\n";
    let both = pair(vertex, fragment);
    assert!(link("port_shared_only", &both).status.success());
    let blocks = both.map(|ported| (ported.shared, ported.block));
    let name = |name: &str| Some(name.to_string());
    assert_eq!(
        blocks,
        [(name("DefaultBlock"), None), (name("DefaultBlock"), name("DefaultBlockFragment"))]
    );
}

/// A name with two types is an error for OpenGL's linker, and nothing to share.
#[test]
fn uniforms_of_another_type_are_not_shared() {
    let vertex = "#version 330 core\nuniform vec4 a[2];\nvoid main() { gl_Position = a[1]; }\n";
    let fragment =
        "#version 330 core\nuniform vec4 a[3];\nout vec4 c;\nvoid main() { c = a[2]; }\n";
    assert!(pair(vertex, fragment).iter().all(|ported| ported.shared.is_none()));
}

/// A binding written in one stage is that of the other stage, too, and nobody else's.
#[test]
fn bindings_written_in_one_stage_hold_in_both() {
    let vertex = "#version 420 core\nlayout(std140) uniform Frame { vec4 time; };\nuniform vec4 a;\n\
                  void main() { gl_Position = time + a; }\n";
    let fragment = "#version 420 core\nlayout(binding = 0) uniform sampler2D t;\n\
                    layout(std140, binding = 1) uniform Frame { vec4 time; };\nout vec4 c;\n\
                    void main() { c = time + texture(t, vec2(0.5)); }\n";
    let both = pair(vertex, fragment);
    assert!(link("port_written", &both).status.success());
    let numbers = both.map(|ported| {
        ported.bindings.into_iter().map(|b| (b.name, b.binding)).collect::<BTreeMap<_, _>>()
    });
    let row = |name: &str, binding| (name.to_string(), binding);
    assert_eq!(numbers[0], BTreeMap::from([row("Frame", 1), row("DefaultBlockVertex", 2)]));
    assert_eq!(numbers[1], BTreeMap::from([row("Frame", 1), row("t", 0)]));
}

/// Nothing is written that our own parser refuses.
#[test]
fn a_body_that_does_not_parse_is_refused() {
    let text = "#version 330\nuniform float a;\nout vec4 c;\nvoid main() { c = vec4(a + ); }\n";
    let refused = port(&Source::new("a.frag", text), &PortOptions::default());
    let found = refused.expect_err("it does not compile");
    assert_eq!(found[0].message, "expected an expression, found `)`");
}

/// Each line of the result is that of the original, except lines that `port` wrote.
#[test]
fn lines_lead_back_to_the_original() {
    let ported = plain("a.frag", FRAGMENT);
    let original: Vec<&str> = FRAGMENT.lines().collect();
    let mut same = 0;
    for (line, from) in ported.source.text.lines().zip(&ported.lines) {
        let from = original[*from as usize - 1];
        if FRAGMENT.lines().any(|l| l == line) && !line.starts_with('}') {
            assert_eq!(line, from);
            same += 1;
        }
    }
    assert!(same >= 4, "{same}");
}
