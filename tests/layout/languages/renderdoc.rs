//! Formats for RenderDoc, which views a captured buffer by them: of each member it shows what lies at
//! the byte where glslang's SPIR-V has it.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use landfall_codegen::languages::RENDERDOC;

use super::{Block, Leaf, cases, directory, hostile, output_of};
use crate::support::image::Shape;

const TESTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/layout/languages/renderdoc");

/// The bytes of the buffer: word `i` is the float `1000 + i`.
const BYTES: u64 = 65536;

/// The formats in a generated file, by their blocks.
fn formats(text: &str) -> BTreeMap<&str, &str> {
    let parts = text.split("\n// ---- `").skip(1);
    parts.filter_map(|part| Some((part.split('`').next()?, part.split_once('\n')?.1))).collect()
}

/// What RenderDoc shows by the formats of a directory: by format and path the rest of the line.
fn shown(directory: &Path) -> BTreeMap<(String, String), Vec<String>> {
    let words = (0..BYTES / 4).flat_map(|word| (1000.0 + word as f32).to_le_bytes());
    fs::write(directory.join("bytes"), words.collect::<Vec<u8>>()).expect("it can be written");
    let program = directory.join("capture");
    output_of(
        Command::new("gcc")
            .arg("-o")
            .arg(&program)
            .arg(format!("{TESTS}/capture.c"))
            .args(["-Wall", "-Wextra", "-lvulkan", "-ldl"]),
    );
    output_of(
        Command::new(&program)
            .args([directory.join("bytes"), directory.join("frame")])
            .env("LD_PRELOAD", "/usr/lib/librenderdoc.so")
            .env("ENABLE_VULKAN_RENDERDOC_CAPTURE", "1"),
    );
    // Answers of the questions that a first start asks.
    let settings = directory.join(".local/share/qrenderdoc");
    fs::create_dir_all(&settings).expect("it can be written");
    let answers = r#"{"rdocConfigData": 1, "Analytics_TotalOptOut": true,
        "CheckUpdate_AllowChecks": false, "Tips_HasSeenFirst": true}"#;
    fs::write(settings.join("UI.config"), answers).expect("it can be written");
    output_of(
        Command::new("xvfb-run")
            .args(["-a", "qrenderdoc", "--ui-py"])
            .arg(format!("{TESTS}/view.py"))
            .env("HOME", directory)
            .env("LANDFALL_VIEW", directory)
            .env("PYTHONPATH", "/usr/lib/python3/dist-packages"),
    );
    let failed = fs::read_to_string(directory.join("failed")).unwrap_or_default();
    assert!(failed.is_empty(), "{failed}");
    let lines = fs::read_to_string(directory.join("shown")).expect("RenderDoc ran");
    let parts = lines.lines().map(|line| {
        let mut parts = line.split('\t').map(str::to_string);
        let mut next = || parts.next().unwrap_or_default();
        ((next(), next()), parts.collect())
    });
    parts.collect()
}

/// The numbers in a value: `{1.00, 2.00} {3.00, 4.00}`, `true`.
fn numbers(value: &str) -> Vec<f64> {
    let parts = value.split([' ', ',', '{', '}']).filter(|part| !part.is_empty());
    let number = |part: &str| match part {
        "true" => 1.0,
        "false" => 0.0,
        _ => part.parse().unwrap_or(f64::NAN),
    };
    parts.map(number).collect()
}

/// What a scalar at a byte of the buffer is.
fn expected(leaf: &Leaf, at: u64) -> f64 {
    let Shape { width, float, signed, .. } = Shape::of(&leaf.oracle);
    let byte = |at: u64| (1000.0 + (at / 4) as f32).to_le_bytes()[(at % 4) as usize];
    let bits = (0..width).fold(0, |bits, i| bits | u64::from(byte(at + i)) << (8 * i));
    let unused = 64 - 8 * width as u32;
    match (float, width) {
        _ if leaf.is_bool => f64::from(u8::from(bits != 0)),
        (false, 2) if leaf.oracle.ty.contains("f") => half::f16::from_bits(bits as u16).to_f64(),
        (true, 4) => f64::from(f32::from_bits(bits as u32)),
        (true, _) => f64::from_bits(bits),
        (false, _) if signed => ((bits << unused) as i64 >> unused) as f64,
        (false, _) => bits as f64,
    }
}

/// Compares a value of a leaf, row by row, with what lies at a byte.
fn same(what: &str, leaf: &Leaf, at: u64, value: &str) {
    let oracle = &leaf.oracle;
    let Shape { columns, rows, width, .. } = Shape::of(oracle);
    let stride = oracle.matrix_stride.unwrap_or(0);
    let mut words = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let within = match oracle.row_major && columns > 1 {
                true => row * stride + column * width,
                false => column * stride + row * width,
            };
            words.push(expected(leaf, at + within));
        }
    }
    let found = numbers(value);
    // It shows a few digits of large and small numbers.
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 0.006 + b.abs() * 1e-5;
    let is_same = found.len() == words.len() && found.iter().zip(&words).all(near);
    assert!(is_same, "{what}: {value} is shown, {words:?} lies there");
}

/// Compares what is shown of a leaf; returns how many of its elements were.
fn hold(format: &str, leaf: &Leaf, shown: &BTreeMap<(String, String), Vec<String>>) -> usize {
    let oracle = &leaf.oracle;
    let Shape { columns, rows, .. } = Shape::of(oracle);
    if leaf.is_in_tail() {
        // A table, of which columns of scalars are looked at; in it a bool is a number.
        if oracle.dims.len() > 1 || columns > 1 || rows > 1 || leaf.is_bool {
            return 0;
        }
        let name = oracle.path.replacen("[]", "", 1);
        let of = |between: &str| shown.get(&(format.to_string(), format!("{name}{between}")));
        let values = of("").or_else(|| of(".value"));
        let values = values.unwrap_or_else(|| panic!("{format}: `{name}` is not shown"));
        for (element, value) in values.iter().enumerate() {
            let at = oracle.offset + element as u64 * oracle.strides[0].expect("a stride");
            same(&format!("{format}: {name} of element {element}"), leaf, at, value);
        }
        return values.len();
    }
    let counts: Vec<u64> = oracle.dims.iter().map(|len| len.unwrap_or(1)).collect();
    let elements: u64 = counts.iter().product();
    for element in 0..elements {
        let (mut rest, mut path, mut at) = (element, oracle.path.clone(), oracle.offset);
        for (dim, count) in counts.iter().enumerate().rev() {
            let (before, after) = path.rsplit_once("[]").expect("a dimension");
            // Of an array of one element RenderDoc shows the element.
            let index = if *count == 1 { String::new() } else { format!("[{}]", rest % count) };
            path = format!("{before}{index}{after}");
            at += rest % count * oracle.strides[dim].unwrap_or(0);
            rest /= count;
        }
        let Some(found) = shown.get(&(format.to_string(), path.clone())) else {
            panic!("{format}: `{path}` is not shown")
        };
        // The column of bytes, the first, lacks the structure's own byte in some versions.
        same(&format!("{format}: {path}"), leaf, at, &found[1]);
    }
    elements as usize
}

#[test]
#[ignore = "needs RenderDoc: ./tests/run codegen"]
fn renderdoc_shows_of_each_member_what_lies_at_its_byte() {
    let directory = directory(RENDERDOC, "view");
    let _ = fs::remove_dir_all(&directory);
    fs::create_dir_all(&directory).expect("it can be written");
    let mut blocks: Vec<(String, Block)> = Vec::new();
    for case in cases(RENDERDOC) {
        let formats = formats(&case.output.text);
        for block in case.blocks {
            if block.ours.size.is_none_or(|size| size > BYTES / 2) || blocks.len() >= 80 {
                continue;
            }
            let name = format!("{}_{}.format", case.name, block.name);
            let format = formats.get(&*block.name).unwrap_or_else(|| panic!("{name} is written"));
            fs::write(directory.join(&name), format).expect("it can be written");
            blocks.push((name, block));
        }
    }
    let shown = shown(&directory);
    let mut held = 0;
    for (name, block) in &blocks {
        held += block.leaves.iter().map(|leaf| hold(name, leaf, &shown)).sum::<usize>();
    }
    println!("{} blocks, {held} members as RenderDoc shows them", blocks.len());
    assert!(blocks.len() >= 40 && held > 400, "{} blocks, {held} members", blocks.len());
}

#[test]
fn names_that_renderdoc_reads_otherwise_get_another() {
    let text = super::generate(RENDERDOC, &[&hostile()]).text;
    // No word of it may begin a comment, a structure or an annotation.
    for line in text.lines().filter(|line| !line.trim_start().starts_with("//")) {
        let rest = line.trim_start();
        assert!(
            ["#pack(", "[[size(", "[[offset(", "[[single]]", "struct ", "};", ""].iter().any(
                |start| if start.is_empty() { rest.is_empty() } else { rest.starts_with(start) }
            ) || rest.contains(" value;")
                || rest.contains(" elements["),
            "{line}"
        );
    }
}
