//! Scripts for Godot, which no registry has for tests: gdtoolkit parses them, and Python runs them with
//! classes in place of Godot's, written from its documentation of `PackedByteArray`.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use landfall_codegen::languages::GDSCRIPT;

use super::{Block, Case, all_shaders, directory, hold, hostile, installed, output_of, said};
use crate::support::image::{Shape, TAIL};

fn python(directory: &Path) -> Command {
    let mut command = Command::new("python3");
    command.current_dir(directory).env("PYTHONPATH", installed("gdscript"));
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// gdtoolkit's parser for a file.
fn parse(directory: &Path, file: &str) -> Command {
    let mut command = python(directory);
    let run =
        "import sys; from gdtoolkit.parser import parser; parser.parse(open(sys.argv[1]).read())";
    command.args(["-c", run, file]);
    command
}

/// Runs `blocks.gd` as Python, and fills members by its functions.
const SUPPORT: &str = include_str!("gdscript/run.py");

fn program(case: &Case) -> String {
    let mut text = SUPPORT.to_string();
    for Block { name, leaves, has_tail, .. } in &case.blocks {
        let count = if *has_tail { TAIL.to_string() } else { String::new() };
        let _ = writeln!(text, "buffer, k = scope['{name}'].create({count}), 0");
        for leaf in leaves {
            let Shape { columns, rows, width, signed, .. } = Shape::of(&leaf.oracle);
            let is_half = ["f16", "float16"].iter().any(|of| leaf.oracle.ty.starts_with(of));
            let flag = |is: bool| if is { "True" } else { "False" };
            let _ = writeln!(
                text,
                "k = fill(buffer, k, '{name}', {:?}, {:?}, {columns}, {rows}, {width}, {}, {}, {})",
                leaf.segments(),
                leaf.counts(),
                flag(is_half),
                flag(signed),
                flag(leaf.is_bool),
            );
        }
        text.push_str("sys.stdout.buffer.write(struct.pack('<Q', len(buffer)) + buffer)\n");
    }
    text
}

#[test]
fn random_blocks_are_filled_where_glslang_reads_them() {
    hold(GDSCRIPT, false, |directory, case| {
        super::write(directory, "blocks.gd", &case.output.text);
        super::write(directory, "main.py", &program(case));
        output_of(&mut parse(directory, "blocks.gd"));
        output_of(python(directory).arg("main.py"))
    });
}

#[test]
fn every_shader_of_this_repository_and_hostile_names_are_parsed() {
    let directory = directory(GDSCRIPT, "shaders");
    super::write(&directory, "blocks.gd", &all_shaders(GDSCRIPT).text);
    output_of(&mut parse(&directory, "blocks.gd"));
    let hostile = super::generate(GDSCRIPT, &[&hostile()]);
    super::write(&directory, "hostile.gd", &hostile.text);
    output_of(&mut parse(&directory, "hostile.gd"));
    super::write(&directory, "broken.gd", &hostile.text.replacen("static func", "static", 1));
    assert!(said(&mut parse(&directory, "broken.gd")).is_err());
}

/// Every class has the functions of Godot's `Object`.
#[test]
fn no_function_is_one_that_every_object_has() {
    let text = "layout(std140) uniform B { float meta; float script; float power; };";
    let output = super::generate(GDSCRIPT, &[&crate::c_header::lay_out("b.frag", text)]).text;
    for (function, is_there) in
        [("get_meta(", false), ("get_meta_(", true), ("set_script(", false), ("get_power(", true)]
    {
        assert_eq!(output.contains(function), is_there, "{function}");
    }
}
