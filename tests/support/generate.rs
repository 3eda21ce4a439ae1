//! Random blocks from a seed. `blocks` prints them.
//!
//! The one place that thinks in bytes is where an explicit `offset=` must lie
//! past the member before: there an upper bound serves, never a layout.

use std::rc::Rc;

use super::blocks::{
    Basic, Block, Dim, Major, Member, Rules, Scalar, Space, Spelling, Standing, Struct, Type,
};

/// What a random block may be made of.
#[derive(Clone, Debug)]
pub struct Diet {
    pub kinds: &'static [(Space, Rules)],
    pub scalars: &'static [Scalar],
    /// Scalars that matrices are made of.
    pub matrices: &'static [Scalar],
    /// Make the first block a push constant, of which a stage has one.
    pub push_constant: bool,
}

/// What both a desktop OpenGL driver and glslang take.
pub const COMMON: Diet = Diet {
    kinds: &[
        (Space::Uniform, Rules::Std140),
        (Space::Buffer, Rules::Std140),
        (Space::Buffer, Rules::Std430),
    ],
    scalars: &[
        Scalar::Float,
        Scalar::Float,
        Scalar::Int,
        Scalar::Uint,
        Scalar::Bool,
        Scalar::Double,
        Scalar::Int64,
        Scalar::Uint64,
    ],
    matrices: &[Scalar::Float, Scalar::Float, Scalar::Double],
    push_constant: false,
};

/// What only Vulkan GLSL has beside that.
pub const VULKAN: Diet = Diet {
    kinds: &[
        (Space::Uniform, Rules::Std140),
        (Space::Uniform, Rules::Std430),
        (Space::Uniform, Rules::Scalar),
        (Space::Buffer, Rules::Std140),
        (Space::Buffer, Rules::Std430),
        (Space::Buffer, Rules::Scalar),
    ],
    scalars: &[
        Scalar::Float,
        Scalar::Int,
        Scalar::Uint,
        Scalar::Bool,
        Scalar::Double,
        Scalar::Int64,
        Scalar::Uint64,
        Scalar::Float16,
        Scalar::Int16,
        Scalar::Uint16,
        Scalar::Int8,
        Scalar::Uint8,
    ],
    matrices: &[Scalar::Float, Scalar::Double],
    push_constant: true,
};

/// Elements that a listing of every element of a block may have.
const MAX_ELEMENTS: u64 = 200;
/// Bytes; well under the 16384 every driver takes in a uniform block.
const MAX_BYTES: u64 = 12_000;

/// A shader's worth of random blocks: the default-layout statements and the
/// blocks, which must be printed with those statements, in any selection.
pub fn random(seed: u64, blocks: usize, diet: &Diet) -> (Vec<Standing>, Vec<Block>) {
    let mut maker = Maker { rng: fastrand::Rng::with_seed(seed), diet, structs: Vec::new() };
    let standing = maker.standing();
    let mut blocks: Vec<Block> = (0..blocks).map(|number| maker.block(number, &standing)).collect();
    if diet.push_constant {
        make_push_constant(&mut blocks[0]);
    }
    (standing, blocks)
}

struct Maker<'d> {
    rng: fastrand::Rng,
    diet: &'d Diet,
    /// Those declared so far, with what a member of that type may cost.
    structs: Vec<(Rc<Struct>, Cost, u32)>,
}

/// Upper bounds, good under any of the rules.
#[derive(Clone, Copy, Debug)]
struct Cost {
    bytes: u64,
    elements: u64,
}

impl Maker<'_> {
    fn chance(&mut self, percent: u32) -> bool {
        self.rng.u32(0..100) < percent
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.rng.usize(0..from.len())]
    }

    fn standing(&mut self) -> Vec<Standing> {
        let mut standing = Vec::new();
        for space in [Space::Uniform, Space::Buffer] {
            if self.chance(20) {
                let kinds: Vec<_> =
                    self.diet.kinds.iter().filter(|k| k.0 == space).copied().collect();
                if kinds.is_empty() {
                    continue;
                }
                let rules = self.pick(&kinds).1;
                // GL_EXT_scalar_block_layout must be required before the statement.
                if rules != Rules::Scalar && !(space == Space::Uniform && rules == Rules::Std430) {
                    standing.push(Standing { space, rules, major: self.major(40) });
                }
            }
        }
        standing
    }

    fn major(&mut self, percent: u32) -> Option<Major> {
        self.chance(percent).then(|| self.pick(&[Major::Row, Major::Row, Major::Column]))
    }

    fn block(&mut self, number: usize, standing: &[Standing]) -> Block {
        let (space, rules) = self.pick(self.diet.kinds);
        let inherited = standing.iter().any(|d| d.space == space && d.rules == rules);
        let explicit = self.chance(25);
        // Half of them with no align below any member's own alignment.
        let lowest = if self.chance(50) { 5 } else { 0 };
        let instance = self.chance(80).then(|| format!("b{number}"));
        let count =
            if instance.is_some() && self.chance(4) { Some(self.rng.u32(1..4)) } else { None };
        let mut block = Block {
            name: format!("B{number}"),
            space,
            rules,
            rules_written: !inherited || self.chance(50),
            major: self.major(25),
            align: (explicit && self.chance(20)).then(|| 1 << self.rng.u32(lowest.max(2)..8)),
            members: Vec::new(),
            count,
            instance,
        };
        let tail = space == Space::Buffer && self.chance(30);
        let length = self.rng.usize(1..8);
        let prefix = if block.instance.is_some() { "m".to_owned() } else { format!("g{number}_") };
        let mut spent = Cost { bytes: 0, elements: 0 };
        let mut cursor = Cursor { end: 0 };
        for at in 0..length {
            let runtime = tail && at + 1 == length;
            let left = Cost {
                bytes: MAX_BYTES.saturating_sub(spent.bytes),
                elements: MAX_ELEMENTS.saturating_sub(spent.elements),
            };
            let name = format!("{prefix}{at}");
            let previous = block.members.last();
            let (mut member, cost) = self.member(&name, previous, 3, left);
            if runtime {
                self.make_runtime(&mut member);
            }
            if !member.joined {
                member.major = self.major(15);
            }
            if explicit && !member.joined {
                let natural = alignment_bound(&member, rules);
                if self.chance(20) {
                    member.align = Some(1 << self.rng.u32(lowest..9));
                }
                if self.chance(30) {
                    let gap = self.rng.u64(0..4) * natural;
                    member.offset = Some(cursor.end.next_multiple_of(natural) + gap);
                }
            }
            // A statement of several members may not carry an offset, which
            // would put them all in one place.
            if member.joined && block.members.last().is_some_and(|m| m.offset.is_some()) {
                member.joined = false;
            }
            cursor.past(&member, cost, rules, block.align);
            spent.bytes += cost.bytes;
            spent.elements += cost.elements;
            block.members.push(member);
        }
        block
    }

    fn member(
        &mut self,
        name: &str,
        previous: Option<&Member>,
        depth: u32,
        left: Cost,
    ) -> (Member, Cost) {
        for _ in 0..8 {
            let mut member = Member::plain(name, self.ty(depth));
            member.name_dims = self.dims();
            member.type_dims = if self.chance(20) { self.dims() } else { Vec::new() };
            member.name_dims.truncate(3 - member.type_dims.len());
            if let Some(previous) = previous {
                if self.chance(12) {
                    member.ty = previous.ty.clone();
                    member.type_dims = previous.type_dims.clone();
                    member.name_dims.truncate(3 - member.type_dims.len());
                    member.major = previous.major;
                    member.align = previous.align;
                    member.joined = true;
                }
            }
            let cost = self.cost(&member);
            if cost.bytes <= left.bytes && cost.elements <= left.elements {
                return (member, cost);
            }
        }
        let basic = Basic { scalar: self.pick(self.diet.scalars), columns: 1, rows: 1 };
        let member = Member::plain(name, Type::Basic(basic));
        let cost = self.cost(&member);
        (member, cost)
    }

    fn ty(&mut self, depth: u32) -> Type {
        match self.rng.u32(0..100) {
            0..30 => {
                Type::Basic(Basic { scalar: self.pick(self.diet.scalars), columns: 1, rows: 1 })
            }
            30..60 => Type::Basic(Basic {
                scalar: self.pick(self.diet.scalars),
                columns: 1,
                rows: self.rng.u8(2..5),
            }),
            60..80 => Type::Basic(Basic {
                scalar: self.pick(self.diet.matrices),
                columns: self.rng.u8(2..5),
                rows: self.rng.u8(2..5),
            }),
            _ if depth > 0 => Type::Struct(self.structure(depth - 1)),
            _ => Type::Basic(Basic { scalar: Scalar::Float, columns: 1, rows: 3 }),
        }
    }

    /// A new structure, or one that earlier blocks use: the same declaration
    /// is laid out anew under each block's rules.
    fn structure(&mut self, depth: u32) -> Rc<Struct> {
        let known: Vec<usize> =
            (0..self.structs.len()).filter(|&at| self.structs[at].2 <= depth).collect();
        if !known.is_empty() && self.chance(25) {
            let at = self.pick(&known);
            return Rc::clone(&self.structs[at].0);
        }
        let mut members: Vec<Member> = Vec::new();
        let mut total = Cost { bytes: 64, elements: 0 };
        for at in 0..self.rng.usize(1..5) {
            let left = Cost {
                bytes: 2000u64.saturating_sub(total.bytes),
                elements: 40u64.saturating_sub(total.elements),
            };
            let name = format!("s{at}");
            let (member, cost) = self.member(&name, members.last(), depth, left);
            total.bytes += cost.bytes;
            total.elements += cost.elements;
            members.push(member);
        }
        let name = format!("S{}", self.structs.len());
        let structure = Rc::new(Struct { name, members });
        self.structs.push((Rc::clone(&structure), total, depth));
        structure
    }

    fn dims(&mut self) -> Vec<Dim> {
        let count = match self.rng.u32(0..100) {
            0..55 => 0,
            55..83 => 1,
            83..95 => 2,
            _ => 3,
        };
        (0..count)
            .map(|_| {
                let long = count == 1 && self.chance(20);
                let length = if long { self.rng.u32(4..10) } else { self.rng.u32(1..4) };
                let spelling = match self.rng.u32(0..20) {
                    0 => Spelling::Unsigned,
                    1 => Spelling::Hexadecimal,
                    2 => Spelling::Sum,
                    3 => Spelling::Constant,
                    _ => Spelling::Decimal,
                };
                Dim { length: Some(length), spelling }
            })
            .collect()
    }

    fn make_runtime(&mut self, member: &mut Member) {
        let unsized_dim = Dim { length: None, spelling: Spelling::Decimal };
        if let Some(first) = member.name_dims.first_mut() {
            *first = unsized_dim;
        } else if member.joined || self.chance(70) {
            member.name_dims.push(unsized_dim);
        } else if let Some(first) = member.type_dims.first_mut() {
            *first = unsized_dim;
        } else {
            member.type_dims.push(unsized_dim);
        }
        if member.dims().count() > 3 {
            member.type_dims.pop();
            member.joined = false;
        }
    }

    fn cost(&self, member: &Member) -> Cost {
        let one = match &member.ty {
            // No column, row or array element is wider than 32 bytes.
            Type::Basic(basic) => {
                Cost { bytes: 32 * u64::from(basic.columns.max(basic.rows)), elements: 1 }
            }
            Type::Struct(structure) => {
                let known = self.structs.iter().find(|s| Rc::ptr_eq(&s.0, structure));
                known.expect("every structure is recorded where it is made").1
            }
        };
        let count: u64 = member.dims().map(|d| u64::from(d.length.unwrap_or(1))).product();
        Cost { bytes: one.bytes * count + 64, elements: one.elements * count }
    }
}

/// Bytes no member of the block so far reaches past.
struct Cursor {
    end: u64,
}

impl Cursor {
    fn past(&mut self, member: &Member, cost: Cost, rules: Rules, block_align: Option<u64>) {
        let align = member.align.or(block_align).unwrap_or(1).max(alignment_bound(member, rules));
        let start = member.offset.unwrap_or(self.end).next_multiple_of(align);
        self.end = start
            + match &member.ty {
                Type::Basic(b) if b.columns == 1 && member.dims().next().is_none() => {
                    component(b.scalar) * u64::from(b.rows)
                }
                _ => cost.bytes,
            };
    }
}

/// A multiple of what the member must be aligned to: exact for scalars and
/// vectors; 32, or 16 without 64-bit scalars, for the rest.
pub fn alignment_bound(member: &Member, rules: Rules) -> u64 {
    match &member.ty {
        Type::Basic(b) if b.columns == 1 && member.dims().next().is_none() => {
            let components = match (rules, b.rows) {
                (Rules::Scalar, _) | (_, 1) => 1,
                (_, 2) => 2,
                _ => 4,
            };
            component(b.scalar) * components
        }
        ty if widest(ty) == 8 => 32,
        _ => 16,
    }
}

fn widest(ty: &Type) -> u64 {
    match ty {
        Type::Basic(basic) => component(basic.scalar),
        Type::Struct(structure) => {
            structure.members.iter().map(|m| widest(&m.ty)).max().expect("no empty structures")
        }
    }
}

fn component(scalar: Scalar) -> u64 {
    match scalar {
        Scalar::Float | Scalar::Int | Scalar::Uint | Scalar::Bool => 4,
        Scalar::Double | Scalar::Int64 | Scalar::Uint64 => 8,
        Scalar::Float16 | Scalar::Int16 | Scalar::Uint16 => 2,
        Scalar::Int8 | Scalar::Uint8 => 1,
    }
}

/// The same members in a push constant, which is std430 where nothing is said
/// (GL_KHR_vulkan_glsl).
fn make_push_constant(block: &mut Block) {
    block.space = Space::PushConstant;
    block.rules = Rules::Std430;
    block.rules_written = false;
    block.align = None;
    block.count = None;
    for member in &mut block.members {
        member.offset = None;
        member.align = None;
        for dim in member.name_dims.iter_mut().chain(&mut member.type_dims) {
            dim.length = dim.length.or(Some(2));
        }
    }
}
