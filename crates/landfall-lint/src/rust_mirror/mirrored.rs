//! The Rust structures that mirror blocks, with the place and offset of each field, for editors.

use super::file::{self, Structure};
use super::library::MirrorWriter;
use super::rust_type::Shape;
use super::same_file;
use super::types::Types;
use crate::settings::Settings;
use landfall_layout::finding::Place;
use landfall_layout::text::glob;

/// A Rust structure that mirrors a block or a structure of a shader.
#[derive(Clone, Debug)]
pub struct MirroredStructure {
    /// The name in Rust.
    pub name: String,
    /// The place of the name.
    pub place: Place,
    /// The shaders, as a glob; empty for any.
    pub shader: String,
    /// The block or structure.
    pub block: String,
    /// Members whose fields have other names: the member's, and the field's.
    pub aliases: Vec<(String, String)>,
    /// The fields in the order of the text.
    pub fields: Vec<MirroredField>,
}

#[derive(Clone, Debug)]
pub struct MirroredField {
    pub name: String,
    /// The place of the name.
    pub place: Place,
    /// The type as it is written.
    pub ty: String,
    /// The offset in bytes, if the layout of the structure in memory is known.
    pub offset: Option<u64>,
}

impl MirroredStructure {
    /// Whether it mirrors a block or structure of that name in that shader.
    pub fn is_of(&self, shader: &str, name: &str) -> bool {
        self.block == name && glob::matches(&self.shader, shader)
    }

    /// The field that feeds a member.
    pub fn field(&self, member: &str) -> Option<&MirroredField> {
        let alias = self.aliases.iter().find(|(of, _)| of == member);
        let name = alias.map_or(member, |(_, field)| field);
        self.fields.iter().find(|field| field.name.eq_ignore_ascii_case(name))
    }

    /// The name of the member that a field feeds.
    pub fn member<'a>(&'a self, field: &'a str) -> &'a str {
        let alias = self.aliases.iter().find(|(_, name)| name == field);
        alias.map_or(field, |(member, _)| member)
    }
}

/// Returns the structures that the configuration and comments name, of the files that are valid Rust.
pub fn mirrored(settings: &Settings) -> Vec<MirroredStructure> {
    let mut found = Vec::new();
    for file in &settings.rust_files {
        let Ok(read) = file::read(file) else { continue };
        let types = Types::new(&read, MirrorWriter::Memory);
        let mut add = |name: &str, shader: &str, block: &str, aliases: &[(String, String)]| {
            let index = read.structures.iter().position(|structure| structure.name == name);
            let Some(index) = index else { return };
            let structure = &read.structures[index];
            found.push(MirroredStructure {
                name: structure.name.clone(),
                place: structure.place.clone(),
                shader: shader.to_string(),
                block: block.to_string(),
                aliases: aliases.to_vec(),
                fields: fields(structure, index, &types),
            });
        };
        let own = settings.rust_mirrors.iter().filter(|one| same_file(&one.file, &file.path));
        for mirror in own {
            add(&mirror.structure, &mirror.shader, &mirror.block, &mirror.aliases);
        }
        for comment in &read.comments {
            for (shader, block) in &comment.blocks {
                add(comment.structure.as_deref().unwrap_or_default(), shader, block, &[]);
            }
        }
    }
    found
}

fn fields(structure: &Structure, index: usize, types: &Types<'_>) -> Vec<MirroredField> {
    let laid_out = types.structure(index).ok();
    let offset = |name: &str| match &laid_out.as_ref()?.shape {
        Shape::Struct(laid) => laid.fields.iter().find(|f| f.name == name).map(|f| f.offset),
        Shape::Scalar { .. } | Shape::Array { .. } => None,
    };
    let of = |field: &file::Field| MirroredField {
        offset: offset(&field.name),
        name: field.name.clone(),
        place: field.place.clone(),
        ty: field.written.clone(),
    };
    structure.fields.iter().map(of).collect()
}
