//! The names by which a C program reaches the leaves of a block, read off the text of a header:
//! the declarations of fields, the assertions that name their members, macros and functions.

use std::collections::HashMap;

use super::image::TAIL;

/// A leaf as the header has it.
pub struct CLeaf<'t> {
    /// Its path in the shader: `data[].pos`.
    pub path: &'t str,
    /// The field, without indices: `((B *)bytes)->data[].pos`, `b_tail(bytes)[].value`.
    pub value: String,
    /// The size of its block, with [`TAIL`] elements in a runtime-sized tail.
    pub size: String,
    /// The macro of its offset.
    pub offset: &'t str,
    /// The function of its block from a path to an offset.
    pub lookup: &'t str,
}

/// A type and the number of brackets behind it.
type Declared<'t> = (&'t str, usize);

#[derive(Default)]
pub struct Header<'t> {
    text: &'t str,
    /// The fields of each structure, and what they are declared as.
    structures: HashMap<&'t str, Vec<(&'t str, Declared<'t>)>>,
    /// By structure, the field of each member of the shader; elements with padding have none.
    members: HashMap<&'t str, HashMap<&'t str, &'t str>>,
    /// The structure of each block, by the name in the shader.
    blocks: HashMap<&'t str, &'t str>,
    /// Names of arrays.
    arrays: HashMap<&'t str, Declared<'t>>,
}

/// What stands between two marks, the first of each.
fn between<'t>(text: &'t str, from: &str, to: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(from)?;
    rest.split_once(to).map(|(inner, _)| inner)
}

/// `float value[3][4];`: the name, and what it is.
fn declared(line: &str) -> Option<(&str, Declared<'_>)> {
    let (declaration, _) = line.split_once(';')?;
    let (ty, name) = declaration.split('[').next()?.rsplit_once(' ')?;
    Some((name, (ty, declaration.matches('[').count())))
}

impl<'t> Header<'t> {
    pub fn read(text: &'t str) -> Header<'t> {
        let mut header = Header { text, ..Header::default() };
        for made in text.split("typedef struct ").skip(1) {
            let (name, rest) = made.split_once(" {\n").expect("a body");
            let lines = rest.split("\n}").next().unwrap_or_default().lines().map(str::trim);
            let fields = lines.filter(|line| !line.starts_with(['#', '/', '*']));
            header.structures.insert(name, fields.filter_map(declared).collect());
        }
        for line in text.lines() {
            if let Some(array) = line.strip_prefix("typedef ").filter(|line| line.contains('[')) {
                header.arrays.extend(declared(array));
            } else if let Some(place) = between(line, "static_assert(offsetof(", ")") {
                let (structure, field) = place.split_once(", ").expect("a structure and a field");
                let mut names = line.split('`').skip(1).step_by(2);
                let (member, owner) = (names.next().expect("it"), names.next().expect("its"));
                header.members.entry(structure).or_default().insert(member, field);
                header.blocks.insert(owner, structure);
            }
        }
        header
    }

    /// The leaves of a block; none if the header leaves it out.
    pub fn leaves(&self, block: &str) -> Vec<CLeaf<'t>> {
        let mut sections = self.text.split("#ifndef LANDFALL_BLOCK_").skip(1);
        let is_of = |section: &&str| {
            // `/* uniform B b of shader.frag, std140. */`.
            let heading = between(section, "/* ", " of ").unwrap_or_default();
            heading.split(' ').nth(1) == Some(block)
        };
        let Some(section) = sections.find(is_of) else { return Vec::new() };
        let lookup = between(section, "static inline int64_t ", "(").expect("a function");
        let tail = between(section, "/* The elements of `", "(void *block)").map(|text| {
            let (member, rest) = text.split_once('`').expect("a member");
            let (_, declared) = rest.split_once("static inline ").expect("a function");
            let (ty, function) = declared.rsplit_once(" *").expect("it returns a pointer");
            (member, function, self.arrays.get(ty).copied().unwrap_or((ty, 0)))
        });
        let paths = section.lines().filter_map(|line| between(line, "    { \"", "\""));
        let names = section.lines().filter_map(|line| line.strip_prefix("#define "));
        let names: Vec<&str> = names.filter_map(|name| name.split([' ', '(']).next()).collect();
        // The guard is before the size; the offsets are last, in the order of the table.
        let size = match names.iter().find(|name| name.ends_with("_SIZE_FOR")) {
            Some(name) => format!("{name}({TAIL})"),
            None => names[1].to_string(),
        };
        let offsets = names[names.len() - paths.clone().count()..].iter();
        let leaf = |(path, &offset): (&'t str, &&'t str)| {
            let (first, rest) = path.split_once('.').unwrap_or((path, ""));
            let dims = first.matches('[').count();
            let tail = tail.filter(|(member, ..)| *member == first.trim_end_matches("[]"));
            let value = match tail {
                Some((_, function, ty)) => {
                    let value = format!("{function}(bytes)[]");
                    let (value, ty) = self.element(value, ty, dims - 1);
                    self.reach(value, ty, rest, ".")
                }
                None => {
                    let structure = self.blocks[block];
                    self.reach(format!("(({structure} *)bytes)"), structure, path, "->")
                }
            };
            CLeaf { path, value, size: size.clone(), offset, lookup }
        };
        paths.zip(offsets).map(leaf).collect()
    }

    /// Goes from a structure along a path.
    fn reach(&self, mut value: String, mut ty: &'t str, path: &str, mut dot: &str) -> String {
        for part in path.split('.').filter(|part| !part.is_empty()) {
            let field = self.members[ty][part.trim_end_matches("[]")];
            let mut fields = self.structures[ty].iter();
            let (_, declared) = fields.find(|(name, _)| *name == field).expect("it is declared");
            let dims = part.matches('[').count();
            (value, ty) = self.element(format!("{value}{dot}{field}"), *declared, dims);
            dot = ".";
        }
        value
    }

    /// Goes into an array by all its dimensions, and through elements that end with padding.
    fn element(&self, value: String, ty: Declared<'t>, dims: usize) -> (String, &'t str) {
        let (ty, brackets) = ty;
        let structure = self.structures.get(ty);
        // Brackets behind plain types are vectors and matrices, too.
        let here = if structure.is_some() { brackets } else { dims };
        let value = format!("{value}{}", "[]".repeat(here));
        match structure.and_then(|fields| fields.first()) {
            Some((field, inner)) if !self.members.contains_key(ty) => {
                self.element(format!("{value}.{field}"), *inner, dims - here)
            }
            _ => (value, ty),
        }
    }
}
