//! Generated C headers, compiled and run: each leaf is filled through the
//! structure and looked for in the bytes where an oracle of `leaf` says it is.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use ::landfall_codegen::c::COutput;

use super::c_names::{CLeaf, Header};
use super::image::{self, Shape, Truth};
use super::leaf::{OracleBlock, OracleLeaf};

/// A directory of this test's own.
pub fn directory(name: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c_header").join(name);
    std::fs::create_dir_all(&directory).expect("the target directory can be written");
    directory
}

#[derive(Clone, Copy, Debug)]
pub enum Compiler {
    C11,
    Cpp17,
    Cpp20,
}

pub const BOTH: [Compiler; 2] = [Compiler::C11, Compiler::Cpp17];

/// Compiles a program without a warning.
pub fn compile(compiler: Compiler, directory: &Path, file: &str) -> Result<PathBuf, String> {
    let (name, flags) = match compiler {
        Compiler::C11 => ("gcc", ["-std=c11", "-xc"]),
        Compiler::Cpp17 => ("g++", ["-std=c++17", "-xc++"]),
        Compiler::Cpp20 => ("g++", ["-std=c++20", "-xc++"]),
    };
    // Of a designated initialiser, g++ reports the padding that it leaves out.
    let more = matches!(compiler, Compiler::Cpp20).then_some("-Wno-missing-field-initializers");
    let program = directory.join(format!("{file}.{compiler:?}"));
    let output = Command::new(name)
        .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O0"])
        .args(flags)
        .args(more)
        .arg(directory.join(file))
        .arg("-o")
        .arg(&program)
        .output()
        .unwrap_or_else(|e| panic!("cannot run {name} ({e}): install the Debian package `{name}`"));
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(program) } else { Err(log) }
}

pub fn compile_and_run(compiler: Compiler, directory: &Path, file: &str) -> Vec<u8> {
    let program = compile(compiler, directory, file).unwrap_or_else(|log| {
        panic!("{compiler:?} refuses {}/{file}:\n{log}", directory.display())
    });
    let output = Command::new(&program).output().expect("what was just compiled runs");
    assert!(
        output.status.success(),
        "{}: {}: {}",
        program.display(),
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    output.stdout
}

/// A leaf as C reaches it and as the oracle places it.
struct Filled<'a> {
    c: CLeaf<'a>,
    oracle: &'a OracleLeaf,
}

impl Filled<'_> {
    fn counts(&self) -> Vec<u64> {
        image::counts(self.oracle)
    }

    /// The C statements that fill it.
    fn fill(&self) -> String {
        let Shape { columns, rows, width, .. } = Shape::of(self.oracle);
        let counts = self.counts();
        let mut text = String::from("    ");
        for (level, count) in counts.iter().enumerate() {
            let _ = write!(text, "for (size_t i{level} = 0; i{level} < {count}; i{level}++) ");
        }
        let mut value = self.c.value.clone();
        for level in 0..counts.len() {
            value = value.replacen("[]", &format!("[i{level}]"), 1);
        }
        let of = match (columns, rows, self.oracle.row_major) {
            (1, 1, _) => "",
            (1, _, _) => "[r]",
            (_, _, false) => "[c][r]",
            (_, _, true) => "[r][c]",
        };
        let _ = writeln!(
            text,
            "for (size_t c = 0; c < {columns}; c++) for (size_t r = 0; r < {rows}; r++) \
             {{ (void)c; (void)r; {value}{of} = V{width}(k); k++; }}"
        );
        text
    }

    /// C that prints what the table and the macro say of its last element, and that wants
    /// every index past the end to be refused.
    fn look_up(&self) -> String {
        let last: Vec<u64> = self.counts().iter().map(|count| count - 1).collect();
        let path = |indices: &[u64]| {
            indices
                .iter()
                .fold(self.c.path.to_string(), |path, i| path.replacen("[]", &format!("[{i}]"), 1))
        };
        let offset = self.c.offset;
        let call = if last.is_empty() {
            offset.to_string()
        } else {
            let list: Vec<String> = last.iter().map(u64::to_string).collect();
            format!("{offset}({})", list.join(", "))
        };
        let lookup = self.c.lookup;
        let mut text = format!(
            "    found(k, {lookup}(\"{}\", NULL)); found(k, (int64_t)({call}));\n",
            path(&last)
        );
        for (level, dim) in self.oracle.dims.iter().enumerate() {
            if dim.is_some() {
                let mut past = last.clone();
                past[level] += 1;
                let _ = writeln!(text, "    refused({lookup}(\"{}\", NULL));", path(&past));
            }
        }
        text
    }
}

/// A program that prints the image of each block, then offsets by name and by macro.
fn program(blocks: &[(&OracleBlock, Vec<Filled<'_>>)]) -> String {
    let mut text = String::from(
        "#include \"blocks.h\"\n#include \"blocks.h\"\n#include <stdio.h>\n#include <stdlib.h>\n\
         #define V1(k) (uint8_t)((k) % 251 + 1)\n#define V2(k) (uint16_t)((k) % 65521 + 1)\n\
         #define V4(k) (uint32_t)((k) + 1)\n#define V8(k) (uint64_t)((k) + 1)\n\
         static void found(uint64_t k, int64_t offset) { (void)k; fwrite(&offset, 8, 1, stdout); }\n\
         static void refused(int64_t offset) { if (offset != -1) { fputs(\"taken\", stderr); exit(1); } }\n",
    );
    for (number, (_, subjects)) in blocks.iter().enumerate() {
        let first = &subjects[0].c;
        let size = &first.size;
        let _ = writeln!(
            text,
            "static void block{number}(void)\n{{\n    uint64_t k = 0, size = {size};\n    \
             unsigned char *bytes = (unsigned char *)calloc(1, size);"
        );
        for subject in subjects {
            text.push_str(&subject.fill());
        }
        text.push_str("    fwrite(&size, 8, 1, stdout);\n    fwrite(bytes, 1, size, stdout);\n");
        for subject in subjects {
            text.push_str(&subject.look_up());
        }
        let _ = writeln!(text, "    refused({}(\"no.such[0].path\", NULL));", first.lookup);
        text.push_str("    free(bytes);\n}\n");
    }
    text.push_str("int main(void)\n{\n");
    for number in 0..blocks.len() {
        let _ = writeln!(text, "    block{number}();");
    }
    text.push_str("    return 0;\n}\n");
    text
}

/// Compiles a header with both compilers, runs it, and holds every byte against the oracle.
/// Returns how many blocks were held.
pub fn hold(name: &str, output: &COutput, oracle: &[OracleBlock]) -> usize {
    hold_by(&BOTH, name, output, oracle)
}

/// The same by some compilers.
pub fn hold_by(
    compilers: &[Compiler],
    name: &str,
    output: &COutput,
    oracle: &[OracleBlock],
) -> usize {
    let directory = directory(name);
    let mut blocks: Vec<(&OracleBlock, Vec<Filled<'_>>)> = Vec::new();
    let header = Header::read(&output.text);
    for block in oracle {
        let subjects: Vec<Filled<'_>> = header
            .leaves(&block.name)
            .into_iter()
            .map(|c| {
                let oracle = block.leaves.iter().find(|leaf| leaf.path == c.path);
                let oracle = oracle.unwrap_or_else(|| panic!("{}: no {}", block.name, c.path));
                Filled { c, oracle }
            })
            .collect();
        if !subjects.is_empty() {
            assert_eq!(subjects.len(), block.leaves.len(), "leaves of {}", block.name);
            blocks.push((block, subjects));
        }
    }
    std::fs::write(directory.join("blocks.h"), &output.text).expect("written");
    std::fs::write(directory.join("main.c"), program(&blocks)).expect("written");
    for &compiler in compilers {
        let printed = compile_and_run(compiler, &directory, "main.c");
        let mut rest = printed.as_slice();
        for (block, subjects) in &blocks {
            let size = number(&mut rest) as usize;
            let (image, after) = rest.split_at(size);
            rest = after;
            let mut expected = vec![0; size];
            let mut k = 0;
            for subject in subjects {
                image::fill(subject.oracle, &mut expected, &mut k, Truth::Number);
            }
            let differs = image.iter().zip(&expected).position(|(a, b)| a != b);
            assert_eq!(differs, None, "{name}, {compiler:?}: first wrong byte of {}", block.name);
            for subject in subjects {
                let last: Vec<u64> = subject.counts().iter().map(|count| count - 1).collect();
                let want = image::element_offset(subject.oracle, &last);
                let told = [number(&mut rest), number(&mut rest)];
                assert_eq!(told, [want; 2], "{name}: {} {}", block.name, subject.c.path);
            }
        }
        assert!(rest.is_empty());
    }
    blocks.len()
}

fn number(rest: &mut &[u8]) -> u64 {
    let (head, tail) = rest.split_at(8);
    *rest = tail;
    u64::from_le_bytes(head.try_into().expect("eight bytes"))
}
