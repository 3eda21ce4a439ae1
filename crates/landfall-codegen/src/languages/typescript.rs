//! Layouts as a TypeScript module: a class over a `DataView` for each structure and block.

mod members;

use std::fmt::Write as _;

use rustc_hash::FxHashSet;

use crate::assertions;
use crate::language::{CodeOptions, CodeOutput, OutputLanguage};
use crate::model::{Model, Naming, Placement, Structure, Tail, header, listed};
use landfall_layout::ShaderLayout;

/// TypeScript and JavaScript.
pub const TYPESCRIPT: OutputLanguage = OutputLanguage {
    name: "typescript",
    title: "TypeScript",
    about: "A TypeScript module of classes over a `DataView`, with typed arrays",
    options: &["--prefix"],
    write,
    assert: assertions::none,
};

const NAMING: Naming = Naming {
    reserved: "break case catch class const continue debugger default delete do else enum export \
        extends false finally for function if import in instanceof new null return super switch \
        this throw true try typeof var void while with as implements interface let package private \
        protected public static yield any boolean constructor declare get module require number \
        set string symbol type from of await async never unknown object bigint undefined abstract \
        accessor asserts infer is keyof namespace readonly unique global override satisfies using \
        arguments eval NaN Infinity Object Array ArrayLike ArrayBuffer DataView RangeError Number \
        String Boolean Symbol BigInt Math Promise Int8Array Uint8Array Int16Array Uint16Array \
        Int32Array Uint32Array Float32Array Float64Array BigInt64Array BigUint64Array Function \
        fits index exactly __proto__",
    types: "n value values view at c r i0 i1 i2 i3 i4 i5 i6 i7",
    members: "constructor view at size toString valueOf toLocaleString hasOwnProperty isPrototypeOf \
        propertyIsEnumerable",
    is_reserved: |_| false,
};

const SUPPORT: &str = "
function fits(view: DataView, at: number, size: number): void {
  if (at < 0 || at + size > view.byteLength) {
    throw new RangeError(`${size} bytes at ${at} do not fit into ${view.byteLength}`);
  }
}

function index(i: number, len: number): number {
  if (!(i >= 0 && i < len && i % 1 === 0)) {
    throw new RangeError(`index ${i} is not below ${len}`);
  }
  return i;
}

function exactly(values: ArrayLike<unknown>, count: number): void {
  if (values.length !== count) {
    throw new RangeError(`${values.length} values instead of ${count}`);
  }
}
";

fn write(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    let model = Model::new(shaders, NAMING, &options.prefix, Placement::Offsets, TYPESCRIPT.title);
    let notes = [
        "Needs TypeScript 5.1. Properties are little-endian on every machine; methods that end in",
        "`Array` give typed arrays in the byte order of the machine.",
    ];
    let mut text = header(shaders, "//", &notes);
    for (name, value) in &model.constants {
        let _ = writeln!(text, "\n/** A constant of the shader, by which it gives lengths. */");
        let _ = writeln!(text, "export const {name} = {value};");
    }
    text.push_str(SUPPORT);
    for structure in &model.structures {
        class(&model, structure, &mut text);
    }
    CodeOutput { text, diagnostics: model.diagnostics }
}

fn class(model: &Model, structure: &Structure, text: &mut String) {
    let Structure { name, size, .. } = structure;
    let mut lines = structure.comment.clone();
    lines.push(format!("{}.", structure.about()));
    text.push('\n');
    comment(&lines, "", text);
    let _ = writeln!(text, "export class {name} {{");
    constants(structure, text);
    let (parameter, bytes) = match structure.tail {
        Some(_) => ("n: number", format!("{name}.sizeFor(n)")),
        None => ("", format!("{name}.SIZE")),
    };
    let _ = write!(
        text,
        "
  /** At byte `at` of `view`. */
  constructor(readonly view: DataView, readonly at: number = 0) {{
    fits(view, at, {name}.SIZE);
  }}

  /** In a zeroed buffer of its own, which is `view.buffer`. */
  static create({parameter}): {name} {{
    return new {name}(new DataView(new ArrayBuffer({bytes})));
  }}
"
    );
    // Names that accessors add keep clear of all members.
    let mut taken: FxHashSet<String> =
        NAMING.members.split_whitespace().map(str::to_string).collect();
    taken.extend(structure.all_members().map(|(member, _)| member.name.clone()));
    if let Some(tail) = &structure.tail {
        size_for(tail, size, text);
    }
    for (member, runtime) in structure.all_members() {
        members::member(model, member, runtime, &mut taken, text);
    }
    text.push_str("}\n");
}

fn constants(structure: &Structure, text: &mut String) {
    let _ = writeln!(text, "  static readonly SIZE: number = {};", structure.size);
    let offsets: Vec<String> = structure
        .all_members()
        .map(|(member, _)| format!("{}: {}", member.name, member.offset))
        .collect();
    let _ = writeln!(text, "  static readonly OFFSETS = {{ {} }} as const;", offsets.join(", "));
    let strides: Vec<String> = structure
        .strides()
        .map(|(member, strides)| format!("{}: [{}]", member.name, listed(&strides)))
        .collect();
    let _ = writeln!(text, "  static readonly STRIDES = {{ {} }} as const;", strides.join(", "));
}

fn size_for(tail: &Tail, size: &u64, text: &mut String) {
    let Tail { member, stride, sizes } = tail;
    let least = sizes.least;
    let max = format!("Math.max({size} + n * {stride}, {least})");
    // Numbers are floating-point, whose division does not round down, as that of `Tail::size` does.
    let bytes = match sizes.must_round(*size, *stride) {
        true => format!("Math.ceil({max} / {0}) * {0}", sizes.multiple),
        false => max,
    };
    let _ = write!(
        text,
        "
  /** Bytes of a buffer in which a shader counts `n` elements of `{}`; at least {least}. */
  static sizeFor(n: number): number {{
    return {bytes};
  }}
",
        member.shader_name
    );
}

fn comment(lines: &[String], indent: &str, text: &mut String) {
    // `@ts-` would be an instruction to the compiler.
    let lines: Vec<String> = lines.iter().map(|line| line.replace("@ts", "@ ts")).collect();
    match lines.as_slice() {
        [] => {}
        [line] => {
            let _ = writeln!(text, "{indent}/** {line} */");
        }
        lines => {
            let _ = writeln!(text, "{indent}/**");
            for line in lines {
                let _ = writeln!(text, "{indent} * {line}");
            }
            let _ = writeln!(text, "{indent} */");
        }
    }
}
