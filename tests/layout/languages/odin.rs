//! Odin files. No registry that the tests reach has Odin's compiler, so a reader of its own takes the
//! structures from the text, places fields by Odin's rules, and compares every leaf with glslang's
//! SPIR-V: fields in order, each at the next multiple of its alignment; a structure ends at a multiple
//! of its alignment; `#packed` has none.

use std::collections::HashMap;

use landfall_codegen::languages::ODIN;

use super::{Block, Leaf, all_shaders, cases, hostile};
use crate::support::image::Shape;
use crate::support::sample::everything;

/// A type as Odin lays it out.
#[derive(Clone, Debug)]
struct Type {
    size: u64,
    align: u64,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Scalar,
    Array(u64, Box<Type>),
    /// Name, offset and type of each field.
    Struct(Vec<(String, u64, Type)>),
}

/// The types and procedures of a file.
#[derive(Default)]
struct File {
    types: HashMap<String, Type>,
    /// Expressions in `#assert`.
    asserts: Vec<(String, u64)>,
    packages: usize,
}

/// Reads a file; every line must be one that the generator is to write.
fn read(text: &str) -> File {
    let mut file = File::default();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.is_empty() || line.starts_with("//") {
        } else if line.starts_with("package ") {
            file.packages += 1;
        } else if let Some((name, rest)) = line.split_once(" :: struct") {
            assert!(rest.ends_with('{'), "{line}");
            let parameters = rest.starts_with("($T");
            let fields = read_fields(&mut lines, &file, parameters);
            if !parameters {
                let packed = rest.contains("#packed");
                let made = structure(fields, packed);
                assert!(file.types.insert(name.to_string(), made).is_none(), "{name} twice");
            }
        } else if let Some(rest) = line.strip_prefix("#assert(") {
            let (what, number) = rest.trim_end_matches(')').split_once(" == ").expect("equal");
            file.asserts.push((what.to_string(), number.parse().expect("a number")));
        } else if line.contains(" :: proc ") {
            assert!(lines.by_ref().any(|line| line == "}"), "{line} has no end");
        } else {
            let (name, value) = line.split_once(" :: ").unwrap_or_else(|| panic!("{line}"));
            let is_number = value.parse::<u64>().is_ok() || value.contains("]int{");
            if !is_number {
                let ty = parse(value, &file);
                assert!(file.types.insert(name.to_string(), ty).is_none(), "{name} twice");
            }
        }
    }
    file
}

fn read_fields<'t>(
    lines: &mut impl Iterator<Item = &'t str>,
    file: &File,
    parameters: bool,
) -> Vec<(String, Type)> {
    let mut fields: Vec<(String, Type)> = Vec::new();
    for line in lines.take_while(|line| *line != "}") {
        let line = line.trim();
        if parameters || line.starts_with("//") {
            continue;
        }
        let code = line.split(" // ").next().unwrap_or(line);
        let (name, ty) = code.trim_end_matches(',').split_once(": ").expect("a field");
        assert!(name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'), "{line}");
        assert!(name == "_" || fields.iter().all(|(other, _)| other != name), "{name} twice");
        fields.push((name.to_string(), parse(ty, file)));
    }
    fields
}

fn structure(fields: Vec<(String, Type)>, packed: bool) -> Type {
    let (mut end, mut most) = (0u64, 1);
    let mut placed = Vec::new();
    for (name, ty) in fields {
        let align = if packed { 1 } else { ty.align };
        most = most.max(align);
        end = end.next_multiple_of(align);
        let size = ty.size;
        placed.push((name, end, ty));
        end += size;
    }
    Type { size: end.next_multiple_of(most), align: most, kind: Kind::Struct(placed) }
}

fn parse(text: &str, file: &File) -> Type {
    if let Some(rest) = text.strip_prefix('[') {
        let (len, element) = rest.split_once(']').expect("a length");
        let (len, element) = (len.parse().expect("a number"), parse(element, file));
        let (size, align) = (element.size * len, element.align);
        return Type { size, align, kind: Kind::Array(len, Box::new(element)) };
    }
    if let Some(rest) = text.strip_prefix("Padded(") {
        let (element, bytes) =
            rest.strip_suffix(')').and_then(|rest| rest.rsplit_once(", ")).expect("two arguments");
        let padding = parse(&format!("[{bytes}]u8"), file);
        let value = ("value".to_string(), parse(element, file));
        return structure(vec![value, ("_".to_string(), padding)], false);
    }
    let size = match text {
        "i8" | "u8" => 1,
        "i16" | "u16" | "f16" => 2,
        "i32" | "u32" | "f32" | "b32" => 4,
        "i64" | "u64" | "f64" => 8,
        name => {
            let known = file.types.get(name);
            return known.unwrap_or_else(|| panic!("no type {name}")).clone();
        }
    };
    Type { size, align: size, kind: Kind::Scalar }
}

impl File {
    /// Checks that each `#assert` holds.
    fn check(&self) {
        assert_eq!(self.packages, 1);
        for (what, number) in &self.asserts {
            let inside = what.split_once('(').expect("a call").1.trim_end_matches(')');
            let found = match inside.split_once(", ") {
                None => self.types[inside].size,
                Some((name, field)) => field_of(&self.types[name], field).0,
            };
            assert_eq!(found, *number, "{what}");
        }
    }
}

fn field_of<'t>(ty: &'t Type, name: &str) -> (u64, &'t Type) {
    let Kind::Struct(fields) = &ty.kind else { panic!("no structure: {ty:?}") };
    let found = fields.iter().find(|(field, ..)| field == name);
    let (_, offset, ty) = found.unwrap_or_else(|| panic!("no field {name}"));
    (*offset, ty)
}

/// Steps into an element with padding.
fn into(ty: &Type) -> &Type {
    match &ty.kind {
        Kind::Struct(fields) if fields[0].0 == "value" && fields.len() == 2 => &fields[0].2,
        _ => ty,
    }
}

/// Steps into an array: its length, its stride and its element.
fn element(ty: &Type) -> (u64, u64, &Type) {
    match &ty.kind {
        Kind::Array(len, element) => (*len, element.size, into(element)),
        _ => panic!("no array: {ty:?}"),
    }
}

fn compare(file: &File, block: &Block, leaf: &Leaf) {
    let oracle = &leaf.oracle;
    let at = format!("{} {}", block.name, oracle.path);
    let mut ty = file.types.get(&block.name);
    let (mut offset, mut dims, mut strides) = (0, Vec::new(), Vec::new());
    for (segment, (name, count)) in leaf.segments().iter().enumerate() {
        let mut count = *count;
        let here = if segment == 0 && leaf.is_in_tail() {
            let tail = &file.types[&format!("{}_Tail", block.name)];
            offset = ty.map_or(0, |head| head.size);
            dims.push(None);
            strides.push(Some(tail.size));
            count -= 1;
            into(tail)
        } else {
            let (start, here) = field_of(ty.expect("a structure"), name);
            offset += start;
            here
        };
        ty = Some((0..count).fold(here, |ty, _| {
            let (len, stride, inner) = element(ty);
            dims.push(Some(len));
            strides.push(Some(stride));
            inner
        }));
    }
    assert_eq!((offset, &dims, &strides), (oracle.offset, &oracle.dims, &oracle.strides), "{at}");
    let Shape { columns, rows, width, .. } = Shape::of(oracle);
    let mut ty = ty.expect("a leaf");
    if columns > 1 {
        let (len, stride, vector) = element(ty);
        let want = if oracle.row_major { rows } else { columns };
        assert_eq!((len, Some(stride)), (want, oracle.matrix_stride), "{at}");
        ty = vector;
    }
    if rows > 1 {
        let (len, _, inner) = element(ty);
        assert_eq!(len, if columns > 1 && oracle.row_major { columns } else { rows }, "{at}");
        ty = inner;
    }
    assert!(matches!(ty.kind, Kind::Scalar) && ty.size == width, "{at}: {ty:?}");
}

#[test]
fn random_blocks_are_placed_where_glslang_reads_them() {
    let mut compared = 0;
    for case in cases(ODIN) {
        let file = read(&case.output.text);
        file.check();
        for block in &case.blocks {
            for leaf in &block.leaves {
                compare(&file, block, leaf);
                compared += 1;
            }
        }
    }
    assert!(compared >= if everything() { 1000 } else { 100 }, "{compared} leaves");
}

#[test]
fn every_shader_of_this_repository_and_hostile_names_are_read() {
    read(&all_shaders(ODIN).text).check();
    let hostile = super::generate(ODIN, &[&hostile()]);
    assert!(hostile.diagnostics.is_empty(), "{:?}", hostile.diagnostics);
    read(&hostile.text).check();
}

/// The reader finds a field that moved.
#[test]
fn a_field_that_moved_is_found() {
    let text = "layout(std140) uniform B { vec3 a; vec3 b; };";
    let output = super::generate(ODIN, &[&crate::c_header::lay_out("b.frag", text)]).text;
    let moved = output.replacen("\t_: [4]u8,\n", "", 1);
    assert_ne!(moved, output);
    let file = read(&moved);
    assert_eq!(field_of(&file.types["B"], "b").0, 12);
}
