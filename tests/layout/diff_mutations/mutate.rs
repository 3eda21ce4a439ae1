//! Random edits of a block's declarations: what a person does to one between two commits.

use std::rc::Rc;

use crate::support::blocks::{
    Basic, Block, Dim, Major, Member, Rules, Scalar, Space, Spelling, Struct, Type,
};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Edit {
    Swap,
    Retype,
    ArraySize,
    MatrixLayout,
    Rules,
    Offset,
    Rename,
    Comment,
    Add,
    Remove,
}

pub const EDITS: [Edit; 10] = [
    Edit::Swap,
    Edit::Retype,
    Edit::ArraySize,
    Edit::MatrixLayout,
    Edit::Rules,
    Edit::Offset,
    Edit::Rename,
    Edit::Comment,
    Edit::Add,
    Edit::Remove,
];

/// The block after that edit; `None` where the block has nothing to edit so.
pub fn mutate(rng: &mut fastrand::Rng, block: &Block, edit: Edit) -> Option<Block> {
    let mut block = block.clone();
    match edit {
        Edit::Comment => {}
        Edit::Rules => {
            let others: Vec<Rules> = [Rules::Std140, Rules::Std430, Rules::Scalar]
                .into_iter()
                .filter(|rules| *rules != block.rules)
                .collect();
            block.rules = others[rng.usize(0..others.len())];
        }
        Edit::MatrixLayout if rng.bool() => {
            block.major = match block.major {
                Some(Major::Row) => None,
                Some(Major::Column) | None => Some(Major::Row),
            };
        }
        Edit::Swap
        | Edit::Retype
        | Edit::ArraySize
        | Edit::MatrixLayout
        | Edit::Offset
        | Edit::Rename
        | Edit::Add
        | Edit::Remove => {
            let lists = structures(&block);
            // The block itself half of the time, else one of its structures.
            let inside = edit != Edit::Offset && !lists.is_empty() && rng.bool();
            if inside {
                let old = lists[rng.usize(0..lists.len())].clone();
                let mut members = old.members.clone();
                edit_members(rng, &mut members, edit, &block)?;
                let new = Rc::new(Struct { name: old.name.clone(), members });
                block.members = with(&block.members, &new);
            } else {
                let mut members = std::mem::take(&mut block.members);
                edit_members(rng, &mut members, edit, &block)?;
                block.members = members;
            }
        }
    }
    Some(block)
}

fn edit_members(
    rng: &mut fastrand::Rng,
    members: &mut Vec<Member>,
    edit: Edit,
    block: &Block,
) -> Option<()> {
    // Each member is a statement of its own from here on.
    members.iter_mut().for_each(|member| member.joined = false);
    let at = rng.usize(0..members.len());
    let is_runtime = |member: &Member| member.dims().any(|dim| dim.length.is_none());
    match edit {
        Edit::Swap => {
            let other = rng.usize(0..members.len());
            let (a, b) = (at.min(other), at.max(other));
            // A runtime-sized array is the last member of its block.
            if a == b || is_runtime(&members[b]) {
                return None;
            }
            members.swap(a, b);
        }
        Edit::Retype => {
            if let Type::Basic(basic) = members[at].ty {
                members[at].ty = Type::Basic(other_type(rng, basic));
            } else {
                members[at].ty = Type::Basic(any_type(rng));
            }
        }
        Edit::ArraySize => {
            let dims = &mut members[at].name_dims;
            match dims.iter().position(|dim| dim.length.is_some()) {
                Some(i) if rng.u32(0..4) > 0 => {
                    let length = dims[i].length?;
                    let longer = length + rng.u32(1..3);
                    let shorter = length.saturating_sub(1).max(1);
                    dims[i].length = Some(if rng.bool() { longer } else { shorter });
                }
                Some(i) => {
                    dims.remove(i);
                }
                None if members[at].dims().count() < 3 && !is_runtime(&members[at]) => {
                    let length = Some(rng.u32(1..4));
                    members[at].name_dims.push(Dim { length, spelling: Spelling::Decimal });
                }
                None => return None,
            }
        }
        Edit::MatrixLayout => {
            members[at].major = match members[at].major {
                Some(Major::Row) => Some(Major::Column),
                Some(Major::Column) | None => Some(Major::Row),
            };
        }
        Edit::Offset => {
            members[at].offset = match members[at].offset {
                Some(offset) if rng.bool() => Some(offset + 32),
                Some(_) => None,
                None => Some(32 * rng.u64(0..24)),
            };
        }
        Edit::Rename => {
            members[at].name = match rng.u32(0..4) {
                // The name of a neighbour, which has to take another one then.
                0 if members.len() > 1 => {
                    let next = (at + 1) % members.len();
                    let name = members[next].name.clone();
                    members[next].name = format!("{name}_was");
                    name
                }
                _ => format!("{}_renamed", members[at].name),
            };
        }
        Edit::Add => {
            let name = format!("added_{}", block.name);
            let mut member = Member::plain(&name, Type::Basic(any_type(rng)));
            if rng.u32(0..4) == 0 {
                let length = Some(rng.u32(1..4));
                member.name_dims.push(Dim { length, spelling: Spelling::Decimal });
            }
            let last = members.len() - usize::from(members.last().is_some_and(is_runtime));
            members.insert(if rng.bool() { last } else { at.min(last) }, member);
        }
        Edit::Remove => {
            if members.len() < 2 {
                return None;
            }
            members.remove(at);
        }
        Edit::Rules | Edit::Comment => return None,
    }
    Some(())
}

fn any_type(rng: &mut fastrand::Rng) -> Basic {
    let scalars = [Scalar::Float, Scalar::Int, Scalar::Uint, Scalar::Double];
    let scalar = scalars[rng.usize(0..scalars.len())];
    match rng.u32(0..4) {
        0 => Basic { scalar, columns: 1, rows: 1 },
        1 | 2 => Basic { scalar, columns: 1, rows: rng.u8(2..5) },
        _ => Basic { scalar: Scalar::Float, columns: rng.u8(2..5), rows: rng.u8(2..5) },
    }
}

/// Another type, often one of the same bytes.
fn other_type(rng: &mut fastrand::Rng, was: Basic) -> Basic {
    let twin = match was.scalar {
        Scalar::Int => Scalar::Uint,
        Scalar::Uint => Scalar::Float,
        Scalar::Float => Scalar::Int,
        other => other,
    };
    if !was.is_matrix() && twin != was.scalar && rng.bool() {
        return Basic { scalar: twin, ..was };
    }
    any_type(rng)
}

/// The structures a block is made of, each once.
fn structures(block: &Block) -> Vec<Rc<Struct>> {
    fn collect(members: &[Member], found: &mut Vec<Rc<Struct>>) {
        for member in members {
            if let Type::Struct(s) = &member.ty {
                if !found.iter().any(|other| other.name == s.name) {
                    found.push(Rc::clone(s));
                    collect(&s.members, found);
                }
            }
        }
    }
    let mut found = Vec::new();
    collect(&block.members, &mut found);
    found
}

/// Members with a structure put in the place of the one of its name, at any depth.
fn with(members: &[Member], new: &Rc<Struct>) -> Vec<Member> {
    let replaced = |member: &Member| {
        let ty = match &member.ty {
            Type::Struct(s) if s.name == new.name => Type::Struct(Rc::clone(new)),
            Type::Struct(s) => {
                let members = with(&s.members, new);
                Type::Struct(Rc::new(Struct { name: s.name.clone(), members }))
            }
            Type::Basic(basic) => Type::Basic(*basic),
        };
        Member { ty, ..member.clone() }
    };
    members.iter().map(replaced).collect()
}

/// The block with structures of its own, so that it can stand in one text with others.
pub fn named_apart(block: &Block, number: usize) -> Block {
    let mut block = block.clone();
    for s in structures(&block) {
        let name = format!("{}_{number}", s.name);
        block.members = renamed(&block.members, &s.name, &name);
    }
    block
}

fn renamed(members: &[Member], old: &str, new: &str) -> Vec<Member> {
    let one = |member: &Member| {
        let ty = match &member.ty {
            Type::Struct(s) => {
                let name = if s.name == old { new.to_owned() } else { s.name.clone() };
                Type::Struct(Rc::new(Struct { name, members: renamed(&s.members, old, new) }))
            }
            Type::Basic(basic) => Type::Basic(*basic),
        };
        Member { ty, ..member.clone() }
    };
    members.iter().map(one).collect()
}

/// The text with comments in it that say nothing true.
pub fn commented(rng: &mut fastrand::Rng, text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        out.push_str(line);
        if line.trim_end().ends_with(';') && rng.u32(0..3) == 0 {
            out.push_str(if rng.bool() { " // offset 12" } else { " /* vec3 old;\n float x; */" });
        }
        out.push('\n');
    }
    out
}

/// Only what SPIR-V tells apart, without what glslang is known to get wrong: a bool is a uint
/// there, and a block takes no alignment from a default-layout statement.
pub fn plain(mut block: Block) -> Block {
    block.rules_written = true;
    block.align = None;
    if block.space == Space::PushConstant {
        block.space = Space::Uniform;
    }
    block
}
