//! Inputs made to exhaust: each is read in time linear in its size, or refused with a limit.
//! Time is the processor time of the thread, which other programs on the machine do not change.

use snapbox::str;

use crate::support::command::golden;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::landfall::{Options, Source, layout};
use landfall_codegen::c::{COptions, c};
use landfall_layout::file::{MAX_BYTES, read_whole};
use landfall_layout::naga_front::glsl_module;
use landfall_layout::source::{Files, OpenFiles, Span};
use landfall_port::{PortOptions, port};

use super::read;

/// Seconds that this thread has computed so far.
fn computed() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fn seconds(work: impl FnOnce()) -> f64 {
    let before = computed();
    work();
    computed() - before
}

fn block_of(members: usize) -> String {
    let members: String = (0..members).map(|n| format!("float m{n};\n")).collect();
    format!("#version 450\nlayout(std140, binding = 0) uniform U {{\n{members}}} u;\n")
}

fn blocks(count: usize) -> String {
    let block = |n| format!("layout(std140) uniform B{n} {{ vec4 position; vec4 color; }} b{n};\n");
    format!("#version 450\n{}", (0..count).map(block).collect::<String>())
}

/// Structures of two members each, every one holding the one before it twice.
fn doubled(depth: usize) -> String {
    let rest = (1..depth).map(|n| format!("struct S{n} {{ S{0} a; S{0} b; }};\n", n - 1));
    let first = "struct S0 { float a; float b; };\n".to_string();
    let tail = "layout(std140) uniform U { vec4 a; } u;\nout vec4 o;\nvoid main() { o = u.a; }\n";
    format!("#version 330\n{}{tail}", std::iter::once(first).chain(rest).collect::<String>())
}

/// Eight times the size takes less than 8 · log₂ 8 times as long; a quadratic loop takes 64.
///
/// The two sizes take turns and the shortest time of each counts, in at most 20 rounds: whatever
/// else uses the caches lengthens times, and never shortens them.
fn assert_near_linear(
    name: &str,
    small: usize,
    work: impl Fn(&str),
    text: impl Fn(usize) -> String,
) {
    let (few, many) = (text(small), text(8 * small));
    let (mut least_few, mut least_many) = (f64::INFINITY, f64::INFINITY);
    for round in 0..20 {
        least_few = least_few.min(seconds(|| work(&few)));
        least_many = least_many.min(seconds(|| work(&many)));
        if round >= 2 && least_many < 24.0 * least_few {
            return;
        }
    }
    panic!("{name}: {least_few} s, and {least_many} s for eight times as much");
}

#[test]
fn texts_of_many_members_and_blocks_take_linear_time() {
    let lay_out = |text: &str| drop(read(text, None));
    let header = |text: &str| drop(c(&[&read(text, None)], &COptions::default()));
    let lock = |text: &str| {
        let lock = landfall_layout::lock::write(&read(text, None));
        landfall_layout::lock::read("a.json", &lock).expect("a lock");
    };
    for (name, text) in [("members", &block_of as &dyn Fn(usize) -> String), ("blocks", &blocks)] {
        assert_near_linear(&format!("layout of {name}"), 1_500, lay_out, text);
        assert_near_linear(&format!("C header of {name}"), 1_500, header, text);
        assert_near_linear(&format!("lock of {name}"), 1_500, lock, text);
    }
}

/// A chain of constants, each the length of a member.
fn lengths(count: usize) -> String {
    let constants: String = (1..count).map(|n| format!("const int K{n} = K{};\n", n - 1)).collect();
    let members: String = (0..count).map(|n| format!("float m{n}[K{n}];\n")).collect();
    let specialised = "layout(constant_id = 0) const int S = 1;\nconst int K0 = 1;\n";
    format!("#version 450\n{specialised}{constants}layout(std140) uniform U {{ {members} }};\n")
}

fn undefined(count: usize) -> String {
    let lines: String = (0..count).map(|n| format!("#undef U{n}\n")).collect();
    block_of(count).replacen("450\n", &format!("450\n{lines}"), 1)
}

#[test]
fn texts_of_many_names_take_linear_time() {
    let glsl = |text: &str| drop(read(text, None));
    assert_near_linear("lengths by constants", 1_500, glsl, lengths);
    assert_near_linear("macros that are undefined", 1_500, glsl, undefined);
    let wgsl = |text: &str| drop(layout(&Source::new("a.wgsl", text), &Options::default()));
    let conditions = |count: usize| -> String {
        let lines: String = (0..count).map(|n| format!("#if N{n} == 1\n#endif\n")).collect();
        format!("{lines}var<uniform> v: vec4f;\n")
    };
    assert_near_linear("conditions of naga_oil", 1_500, wgsl, conditions);
    // Modules whose structures have one name; the text is their number.
    let linked = |count: &str| {
        let numbers = || 0..count.parse::<usize>().expect("a number");
        let import = |n| format!("import package::m{n}::S as A{n};\n");
        let variable = |n| format!("@group(0) @binding({n}) var<uniform> v{n}: A{n};\n");
        let own = numbers().map(import).chain(numbers().map(variable)).collect::<String>();
        let module = |n| (format!("m{n}.wesl").into(), "struct S { a: vec4f }".into());
        let mut options = Options::default();
        options.read.open_files =
            Some(Arc::new(OpenFiles::new(PathBuf::new(), numbers().map(module))));
        let shader = layout(&Source::new("a.wesl", own), &options);
        assert_eq!((shader.diagnostics, shader.blocks.len()), (vec![], numbers().len()));
    };
    assert_near_linear("structures of one name", 100, linked, |count| count.to_string());
}

#[test]
fn ports_of_many_inputs_and_functions_take_linear_time() {
    let ported = |text: &str| {
        let ported = port(&Source::new("a.frag", text), &PortOptions::default());
        let locations = ported.expect("it is portable").locations;
        // Around the one that has its location, in the order of names.
        let first: Vec<u32> = locations.iter().take(3).map(|found| found.location).collect();
        assert_eq!(first, [1, 0, 3]);
    };
    assert_near_linear("inputs without a location", 300, ported, |count| {
        let inputs: String = (1..count).map(|n| format!("in vec2 v{n:05};\n")).collect();
        let first = "layout(location = 1) in mat2 u;\nin float a;\n";
        format!("#version 330\n{first}{inputs}out vec4 o;\nvoid main() {{ o = vec4(a); }}\n")
    });
    let ported = |text: &str| {
        port(&Source::new("a.frag", text), &PortOptions::default()).expect("it is portable");
    };
    assert_near_linear("functions that take samplers in structures", 100, ported, |count| {
        let function = |n| format!("vec4 f{n}(M m) {{ return texture(m.t, vec2(1.0)); }}\n");
        let functions: String = (0..count).map(function).collect();
        let tail = "uniform M m;\nout vec4 o;\nvoid main() { o = f0(m); }\n";
        format!("#version 330\nstruct M {{ sampler2D t; float f; }};\n{functions}{tail}")
    });
}

#[test]
fn places_in_one_line_take_linear_time() {
    let locate = |text: &str| {
        let mut files = Files::default();
        let file = files.add("a.frag", text.into());
        for start in (0..text.len() as u32).step_by(32) {
            let found = files.locate(Span { file, start, end: start });
            assert_eq!((found.line, found.column), (1, start / 2 + 1));
        }
    };
    assert_near_linear("places in one line", 50_000, locate, |count| "é".repeat(count));
}

#[test]
fn stages_and_conditions_without_end_are_refused() {
    let mut options = Options::default();
    options.read.defines = vec![("A".to_string(), "true".to_string())];
    let (open, close) = ("@if(A) {".repeat(20_000), "}".repeat(20_000));
    for (path, text, code) in [
        ("a.glsl", "#[vertex]\n".repeat(20_000), "too-large"),
        ("a.glsl", "#pragma stage vertex\n".repeat(20_000), "too-large"),
        ("a.glsl", "@vs a\n@end\n".repeat(20_000), "too-large"),
        ("a.wesl", format!("{open}var<uniform> v: vec4f;{close}"), "nested-too-deep"),
        ("a.wesl", format!("@if({}A) const a = 1;", "(".repeat(200_000)), "nested-too-deep"),
        ("a.wesl", format!("import {}b;", "a::{".repeat(200_000)), "nested-too-deep"),
    ] {
        let took = seconds(|| {
            let shader = layout(&Source::new(path, text), &options);
            assert_eq!(shader.diagnostics[0].code, code, "{path}");
        });
        assert!(took < 2.0, "{code}: {took} s");
    }
}

#[test]
fn names_that_no_body_declares_are_reported_up_to_a_limit() {
    let declared: String = (0..4_000).map(|n| format!("const float vara{n} = 1.0;\n")).collect();
    let used: String = (0..4_000).map(|n| format!("x += unkn{n};\n")).collect();
    let glsl = format!("#version 450\n{declared}void main() {{ float x = 0.0; {used} }}\n");
    let wgsl = format!("@fragment fn main() {{ var x = 0.0; {used} }}\n");
    for source in [Source::new("a.frag", glsl), Source::new("a.wgsl", wgsl)] {
        let took = seconds(|| {
            let found = landfall_layout::syntax::body_errors(&source, &Options::default().read);
            assert_eq!(found.errors.len(), 100);
            let notes: Vec<&String> = found.errors.iter().flat_map(|error| &error.notes).collect();
            assert_eq!(notes, ["more names of the file are unknown; they are not shown"]);
        });
        assert!(took < 5.0, "{took} s");
    }
}

/// Blocks for sokol-shdc of which each includes the next one, and many stages that include all.
#[test]
fn blocks_that_many_stages_include_are_searched_once() {
    let block = |n: usize| format!("@block b{n}\n@include_block b{}\n@end\n", n + 1);
    let blocks: String = (0..1_000).map(block).collect();
    let stages = "@vs v\n@include_block b0\nvoid main() {}\n@end\n".repeat(256);
    let source = Source::new("a.glsl", blocks + &stages);
    let took = seconds(|| assert!(!layout(&source, &Options::default()).has_errors()));
    assert!(took < 5.0, "{took} s");
}

#[test]
fn structures_that_double_are_ported_and_never_handed_to_naga() {
    let text = doubled(28);
    let source = Source::new("a.frag", &*text);
    let ported = seconds(|| {
        port(&source, &PortOptions::default()).expect("it is portable");
    });
    assert!(ported < 1.0, "{ported} s");
    let asked = seconds(|| assert!(glsl_module(&text, None).is_none()));
    assert!(asked < 1.0, "{asked} s");
    let naga = Options::default().with_naga(true);
    let laid_out = seconds(|| assert!(!layout(&source, &naga).has_errors()));
    assert!(laid_out < 1.0, "{laid_out} s");
}

/// 2¹¹ samplers in one structure are more than variables are made of.
#[test]
fn more_handles_than_the_limit_are_refused_by_number() {
    let text = doubled(11)
        .replace("struct S0 { float a; float b; }", "struct S0 { sampler2D a; sampler2D b; }");
    let source = Source::new("a.frag", text.replace("out vec4", "uniform S10 s;\nout vec4"));
    let found = port(&source, &PortOptions::default()).expect_err("too many");
    let found: Vec<&str> = found.iter().map(|found| found.message.as_str()).collect();
    golden()
        .eq(found.join("\n"), str!["structure `S10` contains more than 1024 samplers and images"]);
}

#[test]
fn macro_calls_nested_without_end_are_refused() {
    let deep = 100_000;
    let text = format!(
        "#version 450\n#define F(x) x\nlayout(std140) uniform U {{ float a[{}3{}]; }};\n",
        "F(".repeat(deep),
        ")".repeat(deep)
    );
    let took = seconds(|| {
        let shader = read(&text, None);
        assert_eq!(shader.diagnostics[0].code, "macro-bomb");
        golden().eq(
            shader.diagnostics[0].message.clone(),
            str!["macros expand to more than 1048576 tokens"],
        );
    });
    assert!(took < 5.0, "{took} s");
}

/// 10 tokens a case: the limit falls into one, where a parser would expect its colon.
#[test]
fn the_limit_on_tokens_is_no_syntax_error() {
    let cases: String = (0..105_000).map(|i| format!("case {i}: x += {i}.0; break;\n")).collect();
    let text = format!(
        "#version 450\nuniform vec4 tint;\nout vec4 o;\n\
         void main() {{ float x = tint.x; switch (int(x)) {{ {cases} }} o = vec4(x); }}\n"
    );
    let source = Source::new("a.frag", &*text);
    let limit = str!["the shader has more than 1048576 tokens"];
    let found = port(&source, &PortOptions::default()).expect_err("too many tokens");
    golden().eq(found[0].message.clone(), limit.clone());
    let found = landfall_layout::syntax::body_errors(&source, &Options::default().read).errors;
    golden().eq(found[0].message.clone(), limit);
}

fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("bounds-{}-{name}", std::process::id()))
}

#[test]
fn what_is_no_file_of_a_bounded_size_is_refused_by_its_kind_or_limit() {
    let refused = |path: &Path| Source::read(path).expect_err("refused").to_string();
    let link = scratch("zero.frag");
    let _ = std::fs::remove_file(&link);
    std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
    golden().eq(
        refused(&link),
        str!["`[TMP]/bounds-[..]-zero.frag` is a device, pipe or socket, not a file"],
    );
    std::fs::remove_file(&link).unwrap();
    let pipe = scratch("pipe.frag");
    let _ = std::fs::remove_file(&pipe);
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    golden().eq(
        refused(&pipe),
        str!["`[TMP]/bounds-[..]-pipe.frag` is a device, pipe or socket, not a file"],
    );
    std::fs::remove_file(&pipe).unwrap();
    let folder = scratch("folder.frag");
    std::fs::create_dir_all(&folder).unwrap();
    golden().eq(
        refused(&folder),
        str!["`[TMP]/bounds-[..]-folder.frag` is a directory, not a shader file"],
    );
    std::fs::remove_dir(&folder).unwrap();
    // A hole of 2 GB, and one byte more than the limit.
    let large = scratch("large.frag");
    let file = std::fs::File::create(&large).unwrap();
    for size in [2 << 30, MAX_BYTES + 1] {
        file.set_len(size).unwrap();
        golden().eq(
            refused(&large),
            str![[r#"
`[TMP]/bounds-[..]-large.frag` is larger than the limit of 67,108,864 bytes
"#]],
        );
    }
    std::fs::write(&large, "0123").unwrap();
    assert_eq!(read_whole(&large, 4).unwrap(), b"0123");
    golden().eq(
        read_whole(&large, 3).unwrap_err().to_string(),
        str![[r#"
`[TMP]/bounds-[..]-large.frag` is larger than the limit of 3 bytes
"#]],
    );
    std::fs::remove_file(&large).unwrap();
    // Its size is said to be 0.
    assert!(read_whole(Path::new("/proc/self/maps"), 8).is_err());
}
