//! The C access expression of each leaf of a block.

use rustc_hash::FxHashMap;

use super::CLeaf;
use super::table::Section;
use super::types::{Field, Mirror, Types};
use landfall_layout::layout::{BlockLayout, MemberLayout};

impl Mirror {
    /// The C names that access each leaf of the block.
    pub fn c_leaves(&self, block: &BlockLayout, section: &Section, types: &Types) -> Vec<CLeaf> {
        let mut leaves = Vec::with_capacity(block.leaves.len());
        let mut add = |path: String, access: String, tail: Option<String>| {
            leaves.push(CLeaf {
                block: block.name.to_string(),
                macros: section.macros.clone(),
                offset: section.offsets[leaves.len()].clone(),
                lookup: section.lookup.clone(),
                structure: self.structure.clone(),
                path,
                access,
                tail,
            });
        };
        let fields = by_member(&self.fields);
        for member in &block.members {
            let tail = self.tail.as_ref().filter(|(field, _)| field.member == *member.name);
            match tail {
                Some((field, _)) => {
                    // Behind the tail's function, which returns a pointer to the first element.
                    let access = field.ty.access.strip_prefix("[]").unwrap_or("").to_string();
                    walk(types, member, field, access, "", &mut |path, access| {
                        add(path, access, section.tail.clone());
                    });
                }
                None => {
                    let field = fields.get(&*member.name);
                    let field = field.expect("every member before the tail has a field");
                    let access = format!(".{}{}", field.name, field.ty.access);
                    walk(types, member, field, access, "", &mut |path, access| {
                        add(path, access, None);
                    });
                }
            }
        }
        leaves
    }
}

fn walk(
    types: &Types,
    member: &MemberLayout,
    field: &Field,
    access: String,
    path: &str,
    add: &mut dyn FnMut(String, String),
) {
    let dot = if path.is_empty() { "" } else { "." };
    let path = format!("{path}{dot}{}{}", member.name, "[]".repeat(member.dims.len()));
    if member.members.is_empty() {
        return add(path, access);
    }
    let fields = by_member(members_of(types, &field.ty.base));
    for child in &member.members {
        let field = fields.get(&*child.name);
        let field = field.expect("every member of a structure has a field");
        let access = format!("{access}.{}{}", field.name, field.ty.access);
        walk(types, child, field, access, &path, add);
    }
}

/// Indexes fields by their member's name in the shader.
fn by_member(fields: &[Field]) -> FxHashMap<&str, &Field> {
    // The first of two equal names wins, as in a linear search.
    fields.iter().rev().map(|field| (field.member.as_str(), field)).collect()
}

/// The fields of a structure, looking through padded elements.
fn members_of<'t>(types: &'t Types, name: &str) -> &'t [Field] {
    // A padded element has no name in the shader, and one field beside its padding.
    let found = types.get(name).expect("a field's structure is kept");
    match found.fields.first() {
        Some(value) if found.shader_name.is_empty() => members_of(types, &value.ty.base),
        _ => &found.fields,
    }
}
