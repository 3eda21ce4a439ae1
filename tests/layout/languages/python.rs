//! Python modules, imported by Python with NumPy.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use landfall_codegen::languages::PYTHON;

use super::{Block, Case, Leaf, hold, installed, output_of, said, write_moved, write_shaders};
use crate::support::image::{Shape, TAIL};

fn python(directory: &Path, file: &str) -> Command {
    let mut command = Command::new("python3");
    command.arg(file).current_dir(directory).env("PYTHONPATH", installed("python"));
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// Steps into padded elements and matrices whose columns are padded.
const SUPPORT: &str = "import struct, sys
import numpy as np
import blocks

def into(a):
    while a.dtype.names == ('value',):
        a = a['value']
    return a

def fill(a, k, columns, rows, width, floats, row_major, is_bool):
    a = into(a)
    n = a.size
    ks = np.arange(k, k + n, dtype=np.uint64)
    if is_bool:
        values = (ks % 3 == 0).astype(np.uint32)
    elif width == 1:
        values = (ks % 251 + 1).astype(np.uint8).view(a.dtype)
    elif width == 2:
        values = (ks % 65521 + 1).astype(np.uint16).view(a.dtype)
    else:
        values = (ks + 1).astype({(4, True): 'f4', (8, True): 'f8', (4, False): 'u4', (8, False): 'u8'}[width, floats])
    if columns > 1:
        shape = a.shape[:-2] + (columns, rows)
        values = values.reshape(shape)
        if row_major:
            values = values.swapaxes(-1, -2)
    a[...] = values.reshape(a.shape)
    return k + n
";

fn program(case: &Case) -> String {
    let mut text = SUPPORT.to_string();
    for Block { name, leaves, has_tail, .. } in &case.blocks {
        let lower = name.to_lowercase();
        let _ = match has_tail {
            true => writeln!(text, "buffer, head, tail = blocks.{lower}_allocate({TAIL})"),
            false => writeln!(
                text,
                "buffer = np.zeros(blocks.{name}_SIZE, np.uint8)\n\
                 head = np.ndarray((), blocks.{name}, buffer)"
            ),
        };
        text.push_str("k = 0\n");
        for leaf in leaves {
            let Shape { columns, rows, width, float, .. } = Shape::of(&leaf.oracle);
            let flag = |is: bool| if is { "True" } else { "False" };
            let _ = writeln!(
                text,
                "k = fill({}, k, {columns}, {rows}, {width}, {}, {}, {})",
                access(leaf),
                flag(float),
                flag(leaf.oracle.row_major),
                flag(leaf.is_bool)
            );
        }
        text.push_str(
            "sys.stdout.buffer.write(struct.pack('<Q', buffer.size) + buffer.tobytes())\n",
        );
    }
    text
}

fn access(leaf: &Leaf) -> String {
    let segments = leaf.segments();
    let (first, names) = match leaf.is_in_tail() {
        true => ("tail", &segments[1..]),
        false => ("head", &segments[..]),
    };
    names.iter().fold(first.to_string(), |at, (name, _)| format!("into({at})['{name}']"))
}

#[test]
fn random_blocks_are_filled_where_glslang_reads_them() {
    hold(PYTHON, true, |directory, case| {
        super::write(directory, "blocks.py", &case.output.text);
        super::write(directory, "main.py", &program(case));
        output_of(&mut python(directory, "main.py"))
    });
}

#[test]
fn every_shader_of_this_repository_and_hostile_names_are_imported() {
    let directory = write_shaders(PYTHON, "py");
    super::write(&directory, "main.py", "import blocks, hostile\nhostile.Words['Padded']\n");
    output_of(&mut python(&directory, "main.py"));
}

/// What NumPy makes of a type is compared with the shader.
#[test]
fn a_type_of_another_size_stops_the_import() {
    let text = "layout(std140) uniform B { vec3 a; float b; };";
    let change = ("(\"<f4\", (3,)), 0", "(\"<f4\", (4,)), 0");
    let directory = write_moved(PYTHON, text, change, "b.py");
    let log = said(&mut python(&directory, "b.py")).expect_err("`a` has 16 bytes");
    assert!(log.contains("`a` has 16 bytes at 0, in the shader 12 at 0"), "{log}");
}
