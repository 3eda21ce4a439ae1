//! Attributes and keywords of WGSL declarations, held against naga and Tint: what both refuse has an
//! error, and what both take has none.

use std::fs;
use std::path::{Path, PathBuf};

use landfall_layout::syntax::body_errors;
use landfall_layout::{Options, Source, layout};

use crate::support::{files, tint};

/// The WGSL shaders of the repository that naga and Tint take.
fn shaders() -> Vec<(PathBuf, String)> {
    let is_wgsl = |path: &Path| path.extension().is_some_and(|extension| extension == "wgsl");
    let texts = files::below(["shaders", "tests", "examples"], is_wgsl)
        .into_iter()
        .filter_map(|path| Some((fs::read_to_string(&path).ok()?, path)));
    texts
        .filter(|(text, _)| naga_takes(text) && tint::errors(text).is_empty())
        .map(|(text, path)| (path, text))
        .collect()
}

fn naga_takes(text: &str) -> bool {
    let Ok(module) = naga::front::wgsl::parse_str(text) else { return false };
    let flags = naga::valid::ValidationFlags::all();
    let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::all());
    validator.validate(&module).is_ok()
}

/// The errors of a text, without and with a compiler.
fn errors(text: &str) -> (Vec<String>, bool) {
    let source = Source::new("a.wgsl", text);
    let shader = layout(&source, &Options::default());
    let mut found: Vec<String> = shader
        .diagnostics
        .iter()
        .filter(|found| found.severity == landfall_layout::Severity::Error)
        .map(|found| found.message.clone())
        .collect();
    if found.is_empty() {
        found.extend(
            body_errors(&source, &Options::default().read).errors.into_iter().map(|e| e.message),
        );
    }
    #[cfg(feature = "naga")]
    let by_naga = landfall_layout::naga_front::checked_wgsl(text).is_err();
    #[cfg(not(feature = "naga"))]
    let by_naga = false;
    let is_told = !found.is_empty() || by_naga;
    (found, is_told)
}

const TOP: &str = "@fragment fn main() -> @location(0) vec4f { return vec4f(u.a); }\n";

fn with_member(member: &str) -> String {
    format!("struct U {{ first: f32, {member} }}\n@group(0) @binding(0) var<storage> u: U;\n{TOP}")
}

#[test]
fn attributes_that_no_compiler_knows_are_errors_with_the_nearest_name() {
    for (attribute, expected) in [
        ("@aling(16)", "unknown attribute `aling`"),
        ("@Size(16)", "unknown attribute `Size`"),
        ("@foo", "unknown attribute `foo`"),
        ("@group(0)", "`@group` is not for a member of a structure"),
        ("@must_use", "`@must_use` is not for a member of a structure"),
        ("@align", "`@align` takes one argument, found 0"),
        ("@invariant(1)", "`@invariant` takes no arguments"),
        ("@align(16) @align(16)", "`@align` is given twice"),
    ] {
        let text = with_member(&format!("{attribute} a: f32"));
        assert!(!naga_takes(&text), "{attribute}");
        assert!(!tint::errors(&text).is_empty(), "{attribute}");
        assert_eq!(errors(&text).0, [expected], "{attribute}");
    }
    for attribute in ["@align(16)", "@size(16)", "@align(16) @size(32,)", "@location(0)", ""] {
        let text = with_member(&format!("{attribute} a: f32"));
        assert!(naga_takes(&text) && tint::errors(&text).is_empty(), "{attribute}");
        assert_eq!(errors(&text).0, [""; 0], "{attribute}");
    }
    let source = Source::new("a.wgsl", with_member("@aling(16) a: f32"));
    let found = layout(&source, &Options::default()).diagnostics;
    assert_eq!(found[0].help.as_deref(), Some("did you mean `align`?"));
    assert_eq!(found[0].code.name(), "unknown-attribute");
}

#[test]
fn an_else_without_its_if_is_refused() {
    for attribute in ["@else", "@elif(X)"] {
        let text = with_member(&format!("{attribute} a: f32"));
        assert!(!naga_takes(&text));
        let name = attribute.split('(').next().unwrap_or_default();
        assert_eq!(errors(&text).0, [format!("`{name}` without an `@if` before it")]);
    }
}

#[test]
fn attributes_of_every_place_and_dialect_are_known() {
    for (text, by_naga) in [
        ("@diagnostic(off, derivative_uniformity) @must_use fn f() -> f32 { return 1.0; }", false),
        ("@compute @workgroup_size(8, 4,) fn main() {}", true),
        ("@compute @workgroup_size(array<u32, 2>(8, 4)[0]) fn main() {}", false),
        ("@id(7) override scale: f32 = 1.0;", true),
        (
            "@vertex fn v(@builtin(vertex_index) i: u32) -> @invariant @builtin(position) vec4f { return vec4f(f32(i)); }",
            true,
        ),
        ("@fragment @early_depth_test(force) fn f() {}", true),
        (
            "enable wgpu_mesh_shader;\nstruct P { a: u32 }\nvar<task_payload> p: P;\n@task @payload(p) @workgroup_size(1) fn t() -> @builtin(mesh_task_size) vec3u { return vec3u(1); }",
            true,
        ),
        ("@coherent @group(0) @binding(0) var<storage, read_write> b: array<u32>;", true),
        ("fn f() { @diagnostic(off, derivative_uniformity) if true { } }", false),
        (
            "enable chromium_experimental_framebuffer_fetch; @fragment fn f(@color(0) a: vec4f) {}",
            false,
        ),
        (
            "enable dual_source_blending;\nstruct O { @location(0) @blend_src(0) a: vec4f, @location(0) @blend_src(1) b: vec4f }\n@fragment fn f() -> O { return O(vec4f(1), vec4f(1)); }",
            true,
        ),
        (
            "struct S { @location(0) @interpolate(perspective, centroid) a: vec4f }\n@fragment fn f(s: S) {}",
            true,
        ),
    ] {
        assert_eq!(errors(text).0, [""; 0], "{text}");
        assert!(naga_takes(text) || !by_naga, "{text}");
        assert!(by_naga || tint::errors(text).is_empty(), "{text}");
    }
}

#[test]
fn reserved_words_and_late_directives_are_errors() {
    let shader = "@group(0) @binding(0) var<uniform> u: U;\n";
    for (text, expected) in [
        (format!("struct U {{ filter: f32 }}\n{shader}"), "`filter` is a reserved word"),
        (format!("struct U {{ __a: f32 }}\n{shader}"), "`__a` begins with two underscores"),
        (format!("struct U {{ a: f32 }}\nenable f16;\n{shader}"), "`enable` stands after"),
        (format!("struct U {{ a: f32 }}\n{shader}fn f(class: f32) {{}}"), "`class` is a reserved"),
        (
            format!("struct U {{ a: f32 }}\n{shader}fn f() {{ var<function> final = 1; }}"),
            "`final`",
        ),
    ] {
        assert!(!naga_takes(&text) && !tint::errors(&text).is_empty(), "{text}");
        let found = errors(&text).0;
        assert!(found.len() == 1 && found[0].starts_with(expected), "{text}: {found:?}");
    }
}

/// The ranges of attributes, and of the keywords of declarations, outside function bodies.
fn targets(text: &str) -> Vec<(usize, usize, bool)> {
    let bytes = text.as_bytes();
    let is_word = |c: u8| c.is_ascii_alphanumeric() || c == b'_';
    let (mut at, mut depth, mut is_body) = (0, 0u32, false);
    let mut all = Vec::new();
    while at < bytes.len() {
        let rest = &text[at..];
        if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            at += rest.find("*/").map_or(rest.len(), |end| end + 2);
        } else if bytes[at] == b'@' && !(is_body && depth > 0) {
            let mut end = at + 1;
            while bytes.get(end).is_some_and(|c| is_word(*c)) {
                end += 1;
            }
            if bytes.get(end) == Some(&b'(') {
                end += text[end..].find(')').map_or(1, |close| close + 1);
            }
            all.push((at, end, true));
            at = end;
        } else if is_word(bytes[at]) {
            let length = bytes[at..].iter().take_while(|c| is_word(**c)).count();
            let word = &text[at..at + length];
            let declares =
                ["struct", "var", "fn", "const", "override", "alias", "enable", "uniform"];
            if word == "fn" && depth == 0 {
                is_body = true;
            } else if word == "struct" && depth == 0 {
                is_body = false;
            }
            if !(is_body && depth > 0) && declares.contains(&word) {
                all.push((at, at + length, false));
            }
            at += length;
        } else {
            match bytes[at] {
                b'{' => depth += 1,
                b'}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            at += 1;
        }
    }
    all
}

/// What may stand in place of a part of a declaration.
fn changes(part: &str, is_attribute: bool) -> Vec<String> {
    let mut all = vec![String::new(), format!("{part} {part}")];
    let name = part.trim_start_matches('@').split('(').next().unwrap_or_default();
    let swapped = {
        let mut letters: Vec<char> = name.chars().collect();
        if letters.len() > 2 {
            letters.swap(1, 2);
        }
        letters.into_iter().collect::<String>()
    };
    let upper = format!("{}{}", name[..1].to_uppercase(), &name[1..]);
    for wrong in [swapped, format!("{name}s"), upper, name[..name.len() - 1].to_string()] {
        all.push(part.replacen(name, &wrong, 1));
    }
    match is_attribute {
        true => {
            all.extend(
                ["@align(16)", "@must_use", "@location(3)", "@group(9)", "@invariant", "@vertex"]
                    .map(str::to_string),
            );
            all.push(format!("@{name}"));
            all.push(format!("@{name}()"));
            all.push(format!("@{name}(0, 1)"));
        }
        false => all.extend(["const", "struct", "let"].map(str::to_string)),
    }
    all
}

/// Tries every `step`-th mutant; returns how many both refuse, and how many of those are told without
/// and with a compiler.
fn campaign(step: usize) -> (usize, usize, usize) {
    let (mut number, mut tried, mut refused, mut told, mut told_by_any) = (0, 0, 0, 0, 0);
    let mut missed = std::collections::BTreeMap::<String, usize>::new();
    for (path, text) in shaders() {
        for (start, end, is_attribute) in targets(&text) {
            for change in changes(&text[start..end], is_attribute) {
                number += 1;
                if number % step != 0 || change == text[start..end] {
                    continue;
                }
                tried += 1;
                let mutant = format!("{}{change}{}", &text[..start], &text[end..]);
                let (found, is_told) = errors(&mutant);
                let said = tint::errors(&mutant);
                match (naga_takes(&mutant), said.is_empty()) {
                    (true, true) => assert!(
                        !is_told,
                        "{}: `{}` as `{change}`: {found:?}",
                        path.display(),
                        &text[start..end]
                    ),
                    (false, false) => {
                        refused += 1;
                        told += usize::from(!found.is_empty());
                        told_by_any += usize::from(is_told);
                        if found.is_empty() {
                            let line = said.lines().next().unwrap_or_default();
                            let why = line.split("error: ").nth(1).unwrap_or(line).to_string();
                            *missed.entry(why).or_default() += 1;
                        }
                    }
                    (true, false) | (false, true) => {}
                }
            }
        }
    }
    println!("{tried} mutants; {told} of {refused} refused ones told, {told_by_any} with naga");
    let mut missed: Vec<_> = missed.into_iter().collect();
    missed.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    for (why, count) in missed.iter().take(25) {
        println!("{count:6} {why}");
    }
    (refused, told, told_by_any)
}

#[test]
fn most_changed_attributes_and_keywords_that_compilers_refuse_are_told() {
    let (refused, told, _) = campaign(61);
    assert!(refused > 100 && told * 100 >= refused * 90, "{told} of {refused}");
}

#[test]
#[ignore = "at length: ./tests/run layout"]
fn changed_attributes_and_keywords_at_length() {
    let (refused, told, told_by_any) = campaign(1);
    assert!(told * 100 >= refused * 88, "{told} of {refused}");
    #[cfg(feature = "naga")]
    assert!(told_by_any * 100 >= refused * 94, "{told_by_any} of {refused}");
    let _ = told_by_any;
}
