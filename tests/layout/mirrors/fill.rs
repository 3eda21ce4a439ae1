//! A program that fills every leaf of a block through its mirror and writes the
//! bytes, and the bytes that the oracle would have there.
//!
//! Both count the components of a block from 1 in the order of its leaves, so
//! that every component has a value of its own where its type has room for it.

use std::collections::HashMap;
use std::fmt::Write as _;

use landfall_codegen::rust::Vectors;

use super::support::blocks::{Basic, Scalar};

/// A leaf: its type from the declaration, its place from the oracle.
pub struct Leaf {
    pub path: String,
    pub basic: Basic,
    pub offset: u64,
    /// `None` is runtime-sized.
    pub dims: Vec<Option<u64>>,
    pub strides: Vec<u64>,
    pub matrix_stride: u64,
    pub row_major: bool,
}

pub struct Block {
    pub name: String,
    pub leaves: Vec<Leaf>,
}

/// Elements that a runtime-sized tail is given.
const ELEMENTS: u64 = 3;

impl Leaf {
    fn lens(&self) -> Vec<u64> {
        self.dims.iter().map(|len| len.unwrap_or(ELEMENTS)).collect()
    }

    fn components(&self) -> u64 {
        u64::from(self.basic.columns) * u64::from(self.basic.rows)
    }

    fn count(&self) -> u64 {
        self.lens().iter().product::<u64>() * self.components()
    }
}

impl Block {
    /// The name of its runtime-sized member.
    fn tail(&self) -> Option<&str> {
        self.leaves
            .iter()
            .find(|leaf| leaf.dims.contains(&None))
            .map(|leaf| leaf.path.split(['[', '.']).next().expect("split yields something"))
    }
}

/// Bytes of a component, and its bytes when it is the `n`th of its block.
fn value(scalar: Scalar, n: u64) -> Vec<u8> {
    match scalar {
        Scalar::Float => (n as f32).to_le_bytes().to_vec(),
        Scalar::Double => (n as f64).to_le_bytes().to_vec(),
        Scalar::Int | Scalar::Uint => (n as u32).to_le_bytes().to_vec(),
        Scalar::Bool => u32::from(truth(n)).to_le_bytes().to_vec(),
        Scalar::Int64 | Scalar::Uint64 => n.to_le_bytes().to_vec(),
        Scalar::Float16 | Scalar::Int16 | Scalar::Uint16 => (n as u16).to_le_bytes().to_vec(),
        Scalar::Int8 | Scalar::Uint8 => vec![n as u8],
    }
}

/// A `bool` cannot be distinct; it can be irregular.
fn truth(n: u64) -> bool {
    n * 2_654_435_761 % 7 < 4
}

/// The bytes of a block of `size` bytes by the oracle: padding is zero.
pub fn expected(block: &Block, size: usize) -> Vec<u8> {
    let mut bytes = vec![0; size];
    let mut n = 0;
    for leaf in &block.leaves {
        let lens = leaf.lens();
        for element in 0..lens.iter().product() {
            let mut rest = element;
            let mut offset = leaf.offset;
            for (len, stride) in lens.iter().zip(&leaf.strides).rev() {
                offset += rest % len * stride;
                rest /= len;
            }
            for column in 0..leaf.basic.columns {
                for row in 0..leaf.basic.rows {
                    n += 1;
                    let bytes_of = value(leaf.basic.scalar, n);
                    let (line, lane) = if leaf.row_major { (row, column) } else { (column, row) };
                    let at = offset
                        + u64::from(line) * leaf.matrix_stride
                        + u64::from(lane) * bytes_of.len() as u64;
                    let at = at as usize;
                    bytes[at..at + bytes_of.len()].copy_from_slice(&bytes_of);
                }
            }
        }
    }
    bytes
}

/// A program that writes the length and the bytes of each block. `text` is the output it
/// includes from `file`.
pub fn program(blocks: &[Block], text: &str, file: &str, vectors: Vectors) -> String {
    let mut program = format!("pub mod mirrors {{\n    include!({file:?});\n}}\nuse mirrors::*;\n");
    program.push_str(
        "pub fn put<T: From<V>, V>(to: &mut T, value: V) {
    *to = T::from(value);
}
pub fn array<T, const N: usize>(n: u64, value: impl Fn(u64) -> T) -> [T; N] {
    core::array::from_fn(|c| value(n + c as u64))
}
pub fn truth(n: u64) -> bool {
    n * 2_654_435_761 % 7 < 4
}
pub trait Bools<const N: usize> {
    fn put(&mut self, value: [bool; N]);
}
fn write(bytes: &[u8]) {
    use std::io::Write;
    let mut out = std::io::stdout().lock();
    out.write_all(&(bytes.len() as u64).to_le_bytes()).unwrap();
    out.write_all(bytes).unwrap();
}
",
    );
    bools(&mut program, text);
    again(&mut program, text);
    for block in blocks {
        fill(&mut program, block, vectors);
    }
    program.push_str("fn main() {\n");
    for block in blocks {
        let _ = writeln!(program, "    fill_{}();", block.name.to_lowercase());
    }
    program.push_str("}\n");
    program
}

/// Vectors of `bool` are arrays of `Bool`, or types of their own where those do not fit.
fn bools(program: &mut String, text: &str) {
    if text.contains("pub struct Bool(") {
        program.push_str(
            "impl<const N: usize> Bools<N> for [Bool; N] {
    fn put(&mut self, value: [bool; N]) {
        *self = value.map(Into::into);
    }
}
",
        );
    }
    for line in text.lines() {
        let Some(name) = line.trim_start().strip_prefix("pub struct ") else { continue };
        let name = name.split(['(', ' ']).next().expect("split yields something");
        let of = name.strip_prefix("BVec").or_else(|| name.strip_prefix("BoolX"));
        if let Some(len) = of.and_then(|rest| rest.chars().next()) {
            let _ = writeln!(
                program,
                "impl Bools<{len}> for {name} {{
    fn put(&mut self, value: [bool; {len}]) {{
        *self = value.into();
    }}
}}"
            );
        }
    }
}

/// The fields of a structure of the output, by name.
type Fields<'a> = Vec<(&'a str, &'a str)>;

/// Functions that make every mirror again from the structure of its members.
fn again(program: &mut String, text: &str) {
    let mut structures: HashMap<&str, Fields<'_>> = HashMap::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let Some(name) = line.trim_start().strip_prefix("pub struct ") else { continue };
        let Some(name) = name.strip_suffix(" {") else { continue };
        let mut fields = Vec::new();
        let mut pending = "";
        for line in lines.by_ref().take_while(|line| line.trim_start() != "}") {
            let line = line.trim();
            if let Some((field, ty)) = line.strip_suffix(',').and_then(|line| line.split_once(": "))
            {
                fields.push((field.trim_start_matches("pub "), ty));
            } else if let Some(field) = line.strip_suffix(':') {
                pending = field.trim_start_matches("pub ");
            } else if let Some(ty) = line.strip_suffix(',') {
                fields.push((pending, ty));
            }
        }
        structures.insert(name, fields);
    }
    for (name, fields) in &structures {
        let Some(init) = structures.get(format!("{name}Init").as_str()) else { continue };
        let _ = writeln!(program, "#[allow(dead_code, non_snake_case)]");
        let _ = writeln!(program, "pub fn again_{name}(old: {name}) -> {name} {{");
        let _ = writeln!(program, "    {name}Init {{");
        for (field, host) in init {
            let (_, ty) = fields.iter().find(|(name, _)| name == field).expect("a field");
            let value = host_value(&structures, ty, host, &format!("old.{field}"));
            let _ = writeln!(program, "        {field}: {value},");
        }
        let _ = writeln!(program, "    }}.into()\n}}");
    }
}

/// The expression that turns `value` of type `ty` into the type that the structure of members has.
fn host_value(structures: &HashMap<&str, Fields<'_>>, ty: &str, host: &str, value: &str) -> String {
    let array = |ty: &str| {
        let (element, len) = ty.strip_prefix('[')?.strip_suffix(']')?.rsplit_once("; ")?;
        Some((element.to_string(), len.to_string()))
    };
    // Types that depend on no shader are in a module of their own.
    let field = |name: &str| {
        let fields = structures.get(ty.rsplit("::").next()?)?;
        fields.iter().find(|field| field.0 == name).map(|field| field.1)
    };
    if structures.contains_key(format!("{ty}Init").as_str()) {
        return format!("again_{ty}({value})");
    }
    if let Some(last) = field("last") {
        let (element, len) = array(host).expect("an array");
        let one = host_value(structures, last, &element, "x");
        return format!("<[_; {len}]>::from({value}).map(|x| {one})");
    }
    if let Some(inner) = field("value") {
        return host_value(structures, inner, host, &format!("{value}.value"));
    }
    match (array(ty), array(host)) {
        (Some((of, _)), Some((to, _))) => {
            format!("{value}.map(|x| {})", host_value(structures, &of, &to, "x"))
        }
        _ if ty == host => value.to_string(),
        _ => format!("<{host}>::from({value})"),
    }
}

fn fill(program: &mut String, block: &Block, vectors: Vectors) {
    let name = &block.name;
    let tail = block.tail();
    let ty = if tail.is_some() { format!("{name}Header") } else { name.clone() };
    let module = name.to_lowercase();
    // A header without members is never written to.
    let _ = writeln!(
        program,
        "#[allow(unused_mut)]\nfn fill_{module}() {{\n    let mut block = {ty}::default();"
    );
    if tail.is_some() {
        let _ = writeln!(program, "    let mut elements = [{name}Element::default(); {ELEMENTS}];");
    }
    let mut n = 1;
    for leaf in &block.leaves {
        fill_leaf(program, leaf, tail, &module, n, vectors);
        n += leaf.count();
    }
    // Made from its members by name it has the same bytes.
    if block.leaves.iter().any(|leaf| tail.is_none_or(|tail| !leaf.path.starts_with(tail))) {
        let _ = writeln!(
            program,
            "    assert_eq!(bytemuck::bytes_of(&again_{ty}(block)), bytemuck::bytes_of(&block));"
        );
    }
    if tail.is_some() {
        let _ = writeln!(
            program,
            "    let mut bytes = vec![0; {ty}::size_for({ELEMENTS})];
    block.write_to(&elements, &mut bytes).unwrap();
    assert_eq!(block.to_bytes(&elements), bytes);
    write(&bytes);"
        );
    } else {
        program.push_str("    write(bytemuck::bytes_of(&block));\n");
        let _ =
            writeln!(program, "    assert_eq!({module}::SIZE, core::mem::size_of_val(&block));");
    }
    program.push_str("}\n");
}

/// One loop a dimension, so that the program stays small.
fn fill_leaf(
    program: &mut String,
    leaf: &Leaf,
    tail: Option<&str>,
    module: &str,
    first: u64,
    vectors: Vectors,
) {
    let lens = leaf.lens();
    let mut parts = leaf.path.split("[]");
    let (mut place, mut path) = (String::new(), String::new());
    let head = parts.next().expect("split yields something");
    // The tail's elements are an array beside its header.
    match tail {
        Some(tail) if tail == head => place.push_str("elements"),
        _ => {
            let _ = write!(place, "block.{head}");
        }
    }
    path.push_str(head);
    for (dim, part) in parts.enumerate() {
        let _ = write!(place, "[i{dim}]{part}");
        let _ = write!(path, "[{{i{dim}}}]{part}");
    }
    let mut linear = "0".to_string();
    let mut offset = leaf.offset.to_string();
    for (dim, (len, stride)) in lens.iter().zip(&leaf.strides).enumerate() {
        let _ = write!(program, "    for i{dim} in 0..{len} {{");
        linear = format!("({linear} * {len} + i{dim})");
        let _ = write!(offset, " + i{dim} * {stride}");
    }
    let components = leaf.components();
    let _ = writeln!(program, "\n    let n = {first} + {linear} as u64 * {components};");
    if lens.is_empty() {
        let _ = writeln!(program, "    let _ = n;");
    }
    let Basic { scalar, columns, rows } = leaf.basic;
    let ty = component_type(scalar);
    let one = match scalar {
        Scalar::Bool => "truth(n)".to_string(),
        Scalar::Float16 => "F16::from_bits(n as u16)".to_string(),
        _ => format!("n as {ty}"),
    };
    let statement = match (columns, rows, scalar) {
        (1, 1, _) => format!("put(&mut {place}, {one});"),
        (1, _, Scalar::Bool) => format!("Bools::put(&mut {place}, array(n, truth));"),
        (1, _, _) => {
            let array = format!("array::<{ty}, {rows}>(n, |n| {one})");
            match glam_vector(scalar, rows).filter(|_| vectors == Vectors::Glam) {
                Some(glam) => format!("put(&mut {place}, {glam}::from_array({array}));"),
                None => format!("put(&mut {place}, {array});"),
            }
        }
        _ => {
            let column = format!("array::<{ty}, {rows}>(n, |n| {one})");
            let glam = glam_vector(scalar, rows).filter(|_| vectors == Vectors::Glam);
            let d = if scalar == Scalar::Double { "D" } else { "" };
            match glam {
                Some(_) if columns == rows => format!(
                    "put(&mut {place}, glam::{d}Mat{columns}::from_cols_array(&array(n, |n| {one})));"
                ),
                Some(glam) => format!(
                    "put(&mut {place}, array::<_, {columns}>(0, |c| {{ let n = n + c * {rows}; \
                     {glam}::from_array({column}) }}));"
                ),
                None => format!(
                    "put(&mut {place}, array::<_, {columns}>(0, |c| {{ let n = n + c * {rows}; \
                     {column} }}));"
                ),
            }
        }
    };
    let _ = writeln!(program, "    {statement}");
    // The table says the same.
    let _ = writeln!(
        program,
        "    assert_eq!({module}::lookup(&format!({path:?})).unwrap().offset, {offset});"
    );
    let item = leaf.path.replace("[]", "").replace('.', "_");
    let item = if lens.is_empty() {
        item.to_uppercase()
    } else {
        let of: Vec<String> = (0..lens.len()).map(|dim| format!("i{dim}")).collect();
        format!("{item}({})", of.join(", "))
    };
    let _ = writeln!(program, "    assert_eq!({module}::{item}, {offset});");
    let _ = writeln!(program, "    {}", "}".repeat(lens.len()));
}

fn component_type(scalar: Scalar) -> &'static str {
    match scalar {
        Scalar::Float => "f32",
        Scalar::Int => "i32",
        Scalar::Uint => "u32",
        Scalar::Bool => "bool",
        Scalar::Double => "f64",
        Scalar::Int64 => "i64",
        Scalar::Uint64 => "u64",
        Scalar::Float16 => "F16",
        Scalar::Int16 => "i16",
        Scalar::Uint16 => "u16",
        Scalar::Int8 => "i8",
        Scalar::Uint8 => "u8",
    }
}

fn glam_vector(scalar: Scalar, rows: u8) -> Option<String> {
    let prefix = match scalar {
        Scalar::Float => "",
        Scalar::Int => "I",
        Scalar::Uint => "U",
        Scalar::Double => "D",
        Scalar::Int64 => "I64",
        Scalar::Uint64 => "U64",
        Scalar::Int16 => "I16",
        Scalar::Uint16 => "U16",
        Scalar::Int8 => "I8",
        Scalar::Uint8 => "U8",
        Scalar::Bool | Scalar::Float16 => return None,
    };
    Some(format!("glam::{prefix}Vec{rows}"))
}
