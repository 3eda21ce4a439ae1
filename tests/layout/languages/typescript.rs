//! TypeScript modules, compiled by tsc with every strict check and run by Node.js.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use landfall_codegen::languages::TYPESCRIPT;

use super::{Block, Case, Leaf, directory, hold, installed, output_of, write_shaders};
use crate::support::image::{Shape, TAIL};

/// Compiles the `.ts` files of a directory to modules beside them.
fn compile(directory: &Path) {
    super::write(directory, "package.json", "{ \"type\": \"module\" }\n");
    let mut tsc = Command::new("node");
    tsc.arg(installed("typescript/node_modules/typescript/bin/tsc")).current_dir(directory).args([
        "--strict",
        "--noUncheckedIndexedAccess",
        "--noImplicitReturns",
        "--noUnusedLocals",
        // Only the declarations of the language: those of browsers take most of the time.
        "--lib",
        "es2020",
        "--target",
        "es2020",
        "--module",
        "es2020",
        "--moduleResolution",
        "bundler",
        "main.ts",
    ]);
    output_of(&mut tsc);
}

fn run(directory: &Path) -> Vec<u8> {
    output_of(Command::new("node").arg("main.js").current_dir(directory))
}

const SUPPORT: &str = r#"import * as blocks from "./blocks.js";
declare const process: { stdout: { write(bytes: Uint8Array): void } };
declare const console: { error(text: string): void };

const number = (width: number) => (k: number): number =>
  width === 1 ? (k % 251) + 1 : width === 2 ? (k % 65521) + 1 : k + 1;
// Of signed 8-bit and 16-bit integers, the value with these bits.
const signed = (width: number) => (k: number): number => {
  const bits = number(width)(k);
  const half = 2 ** (8 * width - 1);
  return bits < half ? bits : bits - 2 * half;
};
const big = (k: number): bigint => BigInt(k + 1);
const truth = (k: number): boolean => k % 3 === 0;

function same(actual: unknown, expected: unknown): void {
  const text = (value: unknown): string =>
    Array.isArray(value) ? value.map(text).join() : String(value);
  if (text(actual) !== text(expected)) {
    throw new Error(`${text(actual)} instead of ${text(expected)}`);
  }
}

function print(view: DataView): void {
  const size = new DataView(new ArrayBuffer(8));
  size.setBigUint64(0, BigInt(view.byteLength), true);
  process.stdout.write(new Uint8Array(size.buffer));
  process.stdout.write(new Uint8Array(view.buffer));
}

void [signed, big, truth];
let k = 0;
function take<T>(count: number, value: (k: number) => T): T[] {
  return Array.from({ length: count }, () => value(k++));
}
"#;

fn program(case: &Case) -> String {
    let mut text = SUPPORT.to_string();
    for Block { name, leaves, has_tail, .. } in &case.blocks {
        let n = if *has_tail { TAIL.to_string() } else { String::new() };
        let _ = writeln!(text, "{{\n  const block = blocks.{name}.create({n});\n  k = 0;");
        for leaf in leaves {
            text.push_str(&fill(leaf));
        }
        text.push_str("  print(block.view);\n}\n");
    }
    text
}

/// Statements that write each element, read it back, and see that indices past the end are refused.
fn fill(leaf: &Leaf) -> String {
    let Shape { columns, rows, width, float, signed } = Shape::of(&leaf.oracle);
    let value = match (leaf.is_bool, width, float) {
        (true, ..) => "truth".to_string(),
        (_, 8, false) => "big".to_string(),
        (_, 1 | 2, false) if signed && !leaf.oracle.ty.contains('f') => format!("signed({width})"),
        _ => format!("number({width})"),
    };
    let mut text = String::from("  ");
    for (i, count) in leaf.counts().iter().enumerate() {
        let _ = write!(text, "for (let i{i} = 0; i{i} < {count}; i{i}++) ");
    }
    let mut at = "block".to_string();
    let mut index = 0;
    let segments = leaf.segments();
    let (last, outer) = segments.split_last().expect("a path has a name");
    let mut indices = |count: usize| {
        let list: Vec<String> = (index..index + count).map(|i| format!("i{i}")).collect();
        index += count;
        list.join(", ")
    };
    for (name, dims) in outer {
        let list = indices(*dims);
        let call = if *dims == 0 { String::new() } else { format!("({list})") };
        let _ = write!(at, ".{name}{call}");
    }
    let (name, dims) = last;
    let list = indices(*dims);
    let taken = format!("take({}, {value})", columns * rows);
    let given = if columns * rows == 1 { "values[0]!" } else { "values" };
    let (set, get) = match dims {
        0 => (format!("{at}.{name} = {given}"), format!("{at}.{name}")),
        _ => {
            let (first, rest) = name.split_at(1);
            (
                format!("{at}.set{}{rest}({list}, {given})", first.to_uppercase()),
                format!("{at}.{name}({list})"),
            )
        }
    };
    let _ = writeln!(text, "{{ const values = {taken}; {set}; same({get}, values); }}");
    text
}

#[test]
fn random_blocks_are_filled_where_glslang_reads_them() {
    hold(TYPESCRIPT, false, |directory, case| {
        super::write(directory, "blocks.ts", &case.output.text);
        super::write(directory, "main.ts", &program(case));
        compile(directory);
        run(directory)
    });
}

#[test]
fn every_shader_of_this_repository_and_hostile_names_compile() {
    let directory = write_shaders(TYPESCRIPT, "ts");
    let main = "import * as blocks from \"./blocks.js\";\nimport { Words } from \"./hostile.js\";\n\
                Words.create().constructor_ = 1;\nexport const names = Object.keys(blocks);\n";
    super::write(&directory, "main.ts", main);
    compile(&directory);
    run(&directory);
}

/// Typed arrays of members without holes, and refusals of what does not fit.
#[test]
fn typed_arrays_share_the_bytes_and_nothing_is_written_outside() {
    let text = "layout(std430) buffer B { vec4 a; mat3 m; ivec2 p[2]; float w[]; };";
    let output = super::generate(TYPESCRIPT, &[&crate::c_header::lay_out("b.comp", text)]).text;
    assert!(!output.contains("mArray"), "the columns of a mat3 have holes");
    let main = r#"import { B } from "./blocks.js";
const block = B.create(5);
block.aArray().set([1, 2, 3, 4]);
block.pArray().set([5, 6, 7, 8]);
block.wArray().fill(0.5);
function wants(what: unknown): void { if (!what) throw new Error("wrong"); }
function refuses(what: () => void): void {
  try { what(); } catch (error) { wants(error instanceof RangeError); return; }
  throw new Error("taken");
}
wants(block.a.join() === "1,2,3,4" && block.p(1).join() === "7,8");
wants(block.wLength === 5 && block.w(4) === 0.5 && block.view.byteLength === B.sizeFor(5));
wants(B.OFFSETS.w === 80 && B.STRIDES.w[0] === 4 && B.SIZE === 80);
refuses(() => block.w(5));
refuses(() => block.setP(-1, [1, 2]));
refuses(() => block.setP(0.5, [1, 2]));
refuses(() => block.setP(0, [1, 2, 3]));
refuses(() => { block.m = [1]; });
refuses(() => new B(new DataView(new ArrayBuffer(79))));
"#;
    let directory = directory(TYPESCRIPT, "typed");
    super::write(&directory, "blocks.ts", &output);
    super::write(&directory, "main.ts", main);
    compile(&directory);
    run(&directory);
}
