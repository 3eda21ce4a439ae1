//! Errors in function bodies, held against glslang and naga: what they take has none, and most of what
//! they refuse is found.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::files::below;
use crate::support::sample::{everything, sampled};
use landfall_layout::syntax::body_errors;
use landfall_layout::{Options, Source, layout};

const STAGES: [&str; 6] = ["vert", "frag", "comp", "geom", "tesc", "tese"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The GLSL shaders of the repository that stand alone.
fn shaders() -> Vec<PathBuf> {
    files(&STAGES)
}

fn files(extensions: &[&str]) -> Vec<PathBuf> {
    let mut folders = ["shaders", "tests", "examples"].map(PathBuf::from).to_vec();
    // More, given by whoever runs it.
    folders.extend(std::env::var_os("LANDFALL_SHADERS").map(PathBuf::from));
    below(folders, |path| extensions.iter().any(|end| path.extension() == Some(end.as_ref())))
}

/// Whether glslang takes a text, for Vulkan or for OpenGL.
fn is_accepted(text: &str, path: &Path) -> bool {
    let stage = path.extension().and_then(|e| e.to_str()).expect("a stage");
    // One file for each test: they run beside each other.
    let test = std::thread::current().name().unwrap_or("bodies").to_string();
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{test}.{stage}"));
    fs::write(&file, text).expect("target/tmp can be written to");
    let take = |arguments: &[&str]| {
        let mut glslang = Command::new("glslangValidator");
        glslang.args(arguments).arg(format!("-I{}", root().join("shaders/include").display()));
        // It writes the SPIR-V into its own folder.
        glslang.current_dir(env!("CARGO_TARGET_TMPDIR"));
        glslang.arg(&file).output().expect("glslangValidator is installed").status.success()
    };
    take(&["--quiet"]) || take(&["-V", "--quiet"])
}

fn errors(text: &str, path: &Path) -> Option<Vec<String>> {
    let source = Source::new(path.display().to_string(), text);
    let mut options = Options::default();
    options.read.include_dirs.push(root().join("shaders/include"));
    // An error outside of bodies is not what is looked for.
    if layout(&source, &options).has_errors() {
        return None;
    }
    let found = body_errors(&source, &options.read).errors;
    Some(found.into_iter().map(|error| error.message).collect())
}

#[test]
fn what_glslang_takes_has_no_error_in_a_body() {
    let mut taken = 0;
    for path in sampled(&shaders(), 8) {
        let Ok(text) = fs::read_to_string(path) else { continue };
        if !is_accepted(&text, path) {
            continue;
        }
        taken += 1;
        let found = errors(&text, path).unwrap_or_default();
        assert!(found.is_empty(), "{}: {found:?}", path.display());
    }
    assert!(taken > if everything() { 100 } else { 12 }, "{taken} shaders");
}

#[test]
fn errors_that_glslang_finds_are_found() {
    let source = |body: &str| {
        format!(
            "#version 450\nstruct Light {{ vec3 color; float radius; }};\nuniform Lights {{ Light \
             lights[4]; }} scene;\nlayout(location = 0) out vec4 color;\nvoid main() {{\n    Light \
             light = scene.lights[1];\n    vec3 diff = vec3(1.0);\n    {body}\n}}\n"
        )
    };
    let path = Path::new("a.frag");
    for (body, expected) in [
        ("color.rgb = diff + ;", "expected an expression, found `;`"),
        ("color.rgb = light.colour;", "`Light` has no member `colour`"),
        ("color.rgb = scene.lights[2].colour;", "`Light` has no member `colour`"),
        ("color.rgb = scene.light[2].color;", "`Lights` has no member `light`"),
        ("color.rgb = dif;", "`dif` is not declared"),
        ("color.rgb = normalise(diff);", "there is no function `normalise`"),
        ("float sample = 1.0;", "`sample` is reserved in this version of GLSL, so no name"),
        ("color.rgb = diff * 1.0q;", "`1.0q` is not a number"),
        ("floatq level = 1.0;", "unknown type `floatq`"),
        ("color color = vec4(1.0);", "unknown type `color`"),
        ("color vec4(1.0);", "expected `;`, found `vec4`"),
        ("color = vec4q(1.0);", "there is no function `vec4q`"),
        ("color = vec4(diff, );", "expected an expression, found `)`"),
        ("float level = ; color = vec4(level);", "expected an expression, found `;`"),
        ("for (int i = 0; i < 4; i++) { } color.r = float(i);", "`i` is not declared"),
        ("{ float level = 1.0; } color.r = level;", "`level` is not declared"),
        ("float level = level; color.r = level;", "`level` is not declared"),
    ] {
        let text = source(body);
        assert!(!is_accepted(&text, path), "{body}");
        assert_eq!(errors(&text, path), Some(vec![expected.to_string()]), "{body}");
    }
    assert!(is_accepted(&source("color.rgb = light.color * diff;"), path));
}

#[test]
fn reserved_words_are_errors_in_the_versions_that_have_them() {
    for (word, version, is_reserved) in [
        ("precise", "330", false),
        ("precise", "400", true),
        ("sample", "330", false),
        ("sample", "450", true),
        ("double", "330", true),
        ("buffer", "420", false),
        ("buffer", "430", true),
        ("patch", "150", false),
        ("filter", "110", true),
        ("layout", "140", true),
        ("layout", "120", false),
        ("row_major", "450", false),
        ("precise", "300 es", false),
        ("precise", "310 es", true),
        ("sample", "300 es", true),
    ] {
        let text = format!(
            "#version {version}\nprecision mediump float;\nstruct S {{ float {word}; }};\n\
             uniform S s;\nvoid main() {{ }}\n"
        );
        // Desktop GLSL has `precision` from 1.30 on.
        let text = match version {
            "110" | "120" => text.replace("precision mediump float;\n", ""),
            _ => text,
        };
        assert_eq!(is_accepted(&text, Path::new("a.frag")), !is_reserved, "{word} {version}");
        let found = errors(&text, Path::new("a.frag")).unwrap_or_default();
        let expected = format!("`{word}` is reserved in this version of GLSL, so no name");
        assert_eq!(
            found,
            if is_reserved { vec![expected] } else { Vec::new() },
            "{word} {version}"
        );
    }
}

/// Texts with one token of a body changed.
fn mutants(text: &str, random: &mut fastrand::Rng) -> Vec<String> {
    let Some(main) = text.find("void main").or_else(|| text.find("\nfn ")) else {
        return Vec::new();
    };
    let body = &text[main..];
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let starts: Vec<usize> = body
        .char_indices()
        .filter(|(at, c)| {
            let before = body[..*at].chars().next_back();
            !(c.is_whitespace() || is_word(*c) && before.is_some_and(is_word))
        })
        .map(|(at, _)| at)
        .collect();
    let mut all = Vec::new();
    for _ in 0..6 {
        let at = starts[random.usize(..starts.len())];
        let token: String = match body[at..].chars().next() {
            Some(c) if is_word(c) => body[at..].chars().take_while(|c| is_word(*c)).collect(),
            Some(c) => c.to_string(),
            None => continue,
        };
        let new = match random.usize(..4) {
            0 => String::new(),
            1 => format!("{token} {token}"),
            2 => format!("{token}q"),
            _ => ["+", ";", ")", "(", ".x", "0"][random.usize(..6)].to_string(),
        };
        all.push(format!("{}{new}{}", &text[..main + at], &body[at + token.len()..]));
    }
    all
}

#[test]
fn mutants_that_glslang_takes_have_no_error_and_most_others_have_one() {
    let mut random = fastrand::Rng::with_seed(18);
    let (mut refused, mut found, mut accepted) = (0, 0, 0);
    // glslang takes most of the time.
    for path in sampled(&shaders(), 24) {
        let Ok(text) = fs::read_to_string(path) else { continue };
        if !is_accepted(&text, path) {
            continue;
        }
        for mutant in mutants(&text, &mut random) {
            let Some(errors) = errors(&mutant, path) else { continue };
            if is_accepted(&mutant, path) {
                accepted += 1;
                assert!(errors.is_empty(), "{}: {errors:?}\n{mutant}", path.display());
            } else {
                refused += 1;
                found += usize::from(!errors.is_empty());
            }
        }
    }
    println!("{accepted} mutants accepted; {found} of {refused} refused ones found");
    // A sample is of two or three files, whose mutants resemble one another.
    let (least, percent) = if everything() { (300, 92) } else { (10, 70) };
    assert!(refused > least && found * 100 >= refused * percent, "{found} of {refused}");
}

/// Whether builds with naga tell of an error.
fn is_refused_by_naga(text: &str) -> bool {
    #[cfg(feature = "naga")]
    return landfall_layout::naga_front::checked_wgsl(text).is_err();
    #[cfg(not(feature = "naga"))]
    return text.is_empty();
}

#[test]
fn names_in_bodies_of_wgsl_are_those_that_naga_knows() {
    let mut random = fastrand::Rng::with_seed(18);
    let (mut taken, mut refused, mut found, mut accepted, mut by_naga) = (0, 0, 0, 0, 0);
    for path in files(&["wgsl"]) {
        let Ok(text) = fs::read_to_string(&path) else { continue };
        if naga::front::wgsl::parse_str(&text).is_err() {
            continue;
        }
        taken += 1;
        let at_first = errors(&text, &path).unwrap_or_default();
        assert!(at_first.is_empty(), "{}: {at_first:?}", path.display());
        for _ in 0..4 {
            for mutant in mutants(&text, &mut random) {
                let Some(errors) = errors(&mutant, &path) else { continue };
                if naga::front::wgsl::parse_str(&mutant).is_ok() {
                    accepted += 1;
                    assert!(errors.is_empty(), "{}: {errors:?}\n{mutant}", path.display());
                } else {
                    refused += 1;
                    found += usize::from(!errors.is_empty());
                    by_naga += usize::from(!errors.is_empty() || is_refused_by_naga(&mutant));
                }
            }
        }
    }
    println!("{accepted} mutants accepted; {found} of {refused} refused ones found");
    println!("{by_naga} of them with the feature `analysis`");
    #[cfg(feature = "naga")]
    assert!(by_naga * 100 >= refused * 89, "{by_naga} of {refused}");
    // Without naga, syntax and types are not looked at.
    assert!(taken > 25 && refused > 200 && found * 10 >= refused * 2, "{found} of {refused}");
    let text = "struct Light { color: vec3f }\n@group(0) @binding(0) var<uniform> light: Light;\n\
                @fragment fn shade() -> @location(0) vec4f { return vec4f(BODY); }\n";
    for (body, expected) in [
        ("light.colour, 1.0", "no structure has a member `colour`"),
        ("ligth.color, 1.0", "`ligth` is not declared"),
    ] {
        let text = text.replace("BODY", body);
        assert!(naga::front::wgsl::parse_str(&text).is_err(), "{body}");
        let found = errors(&text, Path::new("a.wgsl"));
        assert_eq!(found, Some(vec![expected.to_string()]), "{body}");
    }
}
