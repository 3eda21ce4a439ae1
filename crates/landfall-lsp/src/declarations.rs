//! What a shader declares, and where it lies in memory: blocks, the structures in them, and the members
//! of both, by the place of their names.

use std::collections::HashMap;
use std::ops::Range;

use landfall_layout::layout::measure::{element_size, elements};
use landfall_layout::layout::padding::{Padding, PaddingOwner, padding};
use landfall_layout::shape::Struct;
use landfall_layout::{BlockLayout, Language, MemberLayout, Rules, ShaderLayout, Span, Type};

use crate::paths::plain;
use crate::words::words;

/// A declaration, with each of its uses in a block.
#[derive(Clone, Debug)]
pub struct PlacedDeclaration {
    pub kind: DeclarationKind,
    pub name: String,
    /// The file of the name.
    pub file: String,
    /// The bytes of the name.
    pub span: Range<u32>,
    /// The block or structure that has the member; empty otherwise.
    pub owner: String,
    /// The structure that a member is, or has as its elements.
    pub structure: Option<String>,
    /// The names of the blocks that have it.
    pub blocks: Vec<String>,
    /// At least one.
    pub uses: Vec<BlockPlacement>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeclarationKind {
    Block,
    Structure,
    /// That of a block whose structure is declared elsewhere.
    Variable,
    Member,
}

impl DeclarationKind {
    /// Whether it is a block or structure, where that is declared.
    pub fn has_members(self) -> bool {
        matches!(self, DeclarationKind::Block | DeclarationKind::Structure)
    }
}

/// The bytes of a declaration in one block.
#[derive(Clone, Debug)]
pub struct BlockPlacement {
    /// The index of the block in the shader.
    pub block: usize,
    pub rules: Rules,
    /// The path of a member or structure in the block: `data[].color`; empty for the block.
    pub path: String,
    /// The type of a member in the shader's spelling.
    pub ty: String,
    pub bytes: PlacedBytes,
    /// The first byte in the block.
    pub first: u64,
    /// Whether a member is used without a `.`: that of a GLSL block without an instance name.
    pub is_global: bool,
}

/// Numbers in bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlacedBytes {
    /// From the start of the block or structure that has the member; 0 for blocks and structures.
    pub offset: u64,
    /// `None` if runtime-sized.
    pub size: Option<u64>,
    pub align: u64,
    /// Distance between elements, outermost dimension first.
    pub strides: Vec<u64>,
    /// The hole before the first member of the text, and that after each; for blocks and structures
    /// all their padding.
    pub before: u64,
    pub after: u64,
}

/// Returns the declarations of a shader's blocks that have bytes, by place.
pub fn declarations(shader: &ShaderLayout) -> Vec<PlacedDeclaration> {
    let structures =
        if shader.language == Language::Wgsl { structures(shader) } else { HashMap::new() };
    let mut reader = PlacementReader { shader, structures, found: HashMap::new() };
    for (index, block) in shader.blocks.iter().enumerate() {
        if let Some(size) = block.size {
            reader.block(index, block, size);
        }
    }
    let mut found: Vec<PlacedDeclaration> = reader.found.into_values().collect();
    found.sort_by(|a, b| (&a.file, a.span.start).cmp(&(&b.file, b.span.start)));
    found
}

struct PlacementReader<'s> {
    shader: &'s ShaderLayout,
    /// Where WGSL declares structures.
    structures: HashMap<String, Span>,
    found: HashMap<(String, u32), PlacedDeclaration>,
}

/// The block or structure whose members are read.
struct PlacedOwner<'p> {
    block: usize,
    layout: &'p BlockLayout,
    padding: &'p [Padding],
    name: &'p str,
    /// The path of its members' owner.
    path: String,
    first: u64,
    /// How many of it the block has.
    times: u64,
}

impl PlacementReader<'_> {
    fn block(&mut self, index: usize, layout: &BlockLayout, size: u64) {
        let all = padding(layout);
        let own = all.iter().map(|one| one.size.saturating_mul(one.times));
        let bytes = PlacedBytes {
            size: Some(size),
            align: layout.align.unwrap_or_default(),
            after: own.fold(0, u64::saturating_add),
            ..PlacedBytes::default()
        };
        let owner = PlacedOwner {
            block: index,
            layout,
            padding: &all,
            name: &layout.name,
            path: String::new(),
            first: 0,
            times: 1,
        };
        // In WGSL a block is a variable; its name is that of the structure, if its type is one.
        let structure = self.structures.get(&*layout.name).copied();
        let of_span = self.shader.files.text(self.shader.files.resolve(layout.span));
        let is_variable = layout.instance.as_deref() == Some(of_span) && of_span != &*layout.name;
        if let Some(span) = structure.filter(|_| is_variable) {
            self.add(DeclarationKind::Block, (&layout.name, span), "", &owner, "", bytes.clone());
            self.add(DeclarationKind::Variable, (of_span, layout.span), "", &owner, "", bytes);
        } else {
            self.add(DeclarationKind::Block, (of_span, layout.span), "", &owner, "", bytes);
        }
        self.members(&layout.members, &owner);
    }

    fn members<'p>(&mut self, members: &'p [MemberLayout], owner: &PlacedOwner<'p>) {
        for member in members {
            let Some(offset) = member.offset else { continue };
            let mut path = owner.path.clone();
            if !path.is_empty() {
                path.push('.');
            }
            path.push_str(&member.name);
            let inner = format!("{path}{}", "[]".repeat(member.dims.len()));
            let hole = |is: &dyn Fn(&&Padding) -> bool| {
                let mut own = owner.padding.iter().filter(|one| {
                    one.path == owner.path
                        && matches!(one.owner, PaddingOwner::Block | PaddingOwner::Structure)
                });
                own.find(is).map_or(0, |one| one.size)
            };
            let bytes = PlacedBytes {
                offset,
                size: member.size,
                align: member.align.unwrap_or_default(),
                strides: member.strides.clone(),
                before: hole(&|one| one.after.is_none() && is_named(&one.before, member)),
                after: hole(&|one| is_named(&one.after, member)),
            };
            let first = owner.first + offset;
            let ty = member.ty.spelled(self.shader.language).to_string();
            let at = PlacedOwner { path: path.clone(), first, ..*owner };
            let name = (&*member.name, member.span);
            let added = self.add(DeclarationKind::Member, name, &ty, &at, owner.name, bytes);
            if let Type::Struct(structure) = member.ty.innermost() {
                if let Some(added) = added.filter(|_| !structure.name.is_empty()) {
                    added.structure = Some(structure.name.to_string());
                }
                self.structure(
                    structure,
                    member,
                    &PlacedOwner {
                        path: inner,
                        first,
                        times: owner.times.saturating_mul(elements(&member.dims)),
                        ..*owner
                    },
                );
            }
        }
    }

    fn structure<'p>(
        &mut self,
        structure: &'p Struct,
        member: &'p MemberLayout,
        at: &PlacedOwner<'p>,
    ) {
        let owner = PlacedOwner { name: &structure.name, path: at.path.clone(), ..*at };
        let inside = format!("{}.", owner.path);
        let own = owner.padding.iter().filter(|one| {
            let is_between = one.path == owner.path && one.owner == PaddingOwner::Structure;
            is_between || one.path.starts_with(&inside)
        });
        let own = own.map(|one| one.size.saturating_mul(one.times / owner.times.max(1)));
        let bytes = PlacedBytes {
            size: Some(element_size(member, owner.layout.rules)),
            align: member.align.unwrap_or_default(),
            after: own.fold(0, u64::saturating_add),
            ..PlacedBytes::default()
        };
        if !structure.name.is_empty() {
            let name = (&*structure.name, structure.span);
            self.add(DeclarationKind::Structure, name, "", &owner, "", bytes);
        }
        self.members(&member.members, &owner);
    }

    fn add(
        &mut self,
        kind: DeclarationKind,
        (name, span): (&str, Span),
        ty: &str,
        at: &PlacedOwner<'_>,
        owner: &str,
        bytes: PlacedBytes,
    ) -> Option<&mut PlacedDeclaration> {
        let span = self.shader.files.resolve(span);
        let file = self.shader.files.get(span.file)?;
        // Names that macros give stand elsewhere, or nowhere.
        if self.shader.files.text(span) != name {
            return None;
        }
        let path = plain(&file.path);
        let key = (path.clone(), span.start);
        let placement = BlockPlacement {
            block: at.block,
            rules: at.layout.rules,
            path: at.path.clone(),
            ty: ty.to_string(),
            bytes,
            first: at.first,
            is_global: at.layout.instance.is_none() && !at.path.contains(['.', '[']),
        };
        let found = self.found.entry(key).or_insert_with(|| PlacedDeclaration {
            kind,
            name: name.to_string(),
            file: path,
            span: span.start..span.end,
            owner: owner.to_string(),
            structure: None,
            blocks: Vec::new(),
            uses: Vec::new(),
        });
        // WGSL's block and the structure of its type have one name.
        if found.kind == DeclarationKind::Structure && kind == DeclarationKind::Block {
            found.kind = kind;
        }
        let block = at.layout.name.to_string();
        if !found.blocks.contains(&block) {
            found.blocks.push(block);
        }
        found.uses.push(placement);
        Some(found)
    }
}

/// The places of the names in `struct NAME`, of each name that is declared once.
fn structures(shader: &ShaderLayout) -> HashMap<String, Span> {
    let mut found: HashMap<String, Option<Span>> = HashMap::new();
    for (index, file) in shader.files.iter().enumerate() {
        // The first is the text that was put together from the others, if there are any.
        if shader.files.resolve(Span::default()).file != 0 && index == 0 {
            continue;
        }
        for pair in words(&file.text).windows(2) {
            if let [keyword, name] = pair {
                if keyword.text == "struct" {
                    let Range { start, end } = name.span;
                    let span = Span { file: index as u32, start, end };
                    let entry = found.entry(name.text.to_string());
                    entry.and_modify(|known| *known = None).or_insert(Some(span));
                }
            }
        }
    }
    found.into_iter().filter_map(|(name, span)| Some((name, span?))).collect()
}

fn is_named(name: &Option<std::sync::Arc<str>>, member: &MemberLayout) -> bool {
    name.as_deref() == Some(&*member.name)
}

impl PlacedDeclaration {
    /// Whether it is a member that is used without a `.`.
    pub fn is_global(&self) -> bool {
        self.kind == DeclarationKind::Member && self.uses.iter().any(|one| one.is_global)
    }

    /// The uses that differ in bytes, the first of each.
    pub fn distinct(&self) -> Vec<&BlockPlacement> {
        let mut found: Vec<&BlockPlacement> = Vec::new();
        for placement in &self.uses {
            if found.iter().all(|other| other.bytes != placement.bytes) {
                found.push(placement);
            }
        }
        found
    }
}
