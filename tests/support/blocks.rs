//! GLSL blocks as data, printed as GLSL text. `generate` makes them; both
//! oracles read the text. Nothing here computes a byte.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::rc::Rc;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rules {
    Std140,
    Std430,
    Scalar,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Space {
    Uniform,
    Buffer,
    PushConstant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Major {
    Row,
    Column,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scalar {
    Float,
    Int,
    Uint,
    Bool,
    Double,
    Int64,
    Uint64,
    Float16,
    Int16,
    Uint16,
    Int8,
    Uint8,
}

impl Scalar {
    pub fn word(self) -> &'static str {
        match self {
            Self::Float => "float",
            Self::Int => "int",
            Self::Uint => "uint",
            Self::Bool => "bool",
            Self::Double => "double",
            Self::Int64 => "int64_t",
            Self::Uint64 => "uint64_t",
            Self::Float16 => "float16_t",
            Self::Int16 => "int16_t",
            Self::Uint16 => "uint16_t",
            Self::Int8 => "int8_t",
            Self::Uint8 => "uint8_t",
        }
    }

    fn prefix(self) -> &'static str {
        match self {
            Self::Float => "",
            Self::Int => "i",
            Self::Uint => "u",
            Self::Bool => "b",
            Self::Double => "d",
            Self::Int64 => "i64",
            Self::Uint64 => "u64",
            Self::Float16 => "f16",
            Self::Int16 => "i16",
            Self::Uint16 => "u16",
            Self::Int8 => "i8",
            Self::Uint8 => "u8",
        }
    }

    fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Float | Self::Int | Self::Uint | Self::Bool | Self::Double => &[],
            Self::Int64 | Self::Uint64 => &["GL_ARB_gpu_shader_int64"],
            Self::Float16 | Self::Int16 | Self::Uint16 => &["GL_EXT_shader_16bit_storage"],
            Self::Int8 | Self::Uint8 => &["GL_EXT_shader_8bit_storage"],
        }
    }
}

/// A scalar (1 × 1), vector (1 column) or matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Basic {
    pub scalar: Scalar,
    pub columns: u8,
    pub rows: u8,
}

impl Basic {
    pub fn is_matrix(self) -> bool {
        self.columns > 1
    }

    pub fn word(self) -> String {
        let prefix = self.scalar.prefix();
        match (self.columns, self.rows) {
            (1, 1) => self.scalar.word().to_owned(),
            (1, rows) => format!("{prefix}vec{rows}"),
            (columns, rows) if columns == rows => format!("{prefix}mat{columns}"),
            (columns, rows) => format!("{prefix}mat{columns}x{rows}"),
        }
    }
}

#[derive(Clone, Debug)]
pub enum Type {
    Basic(Basic),
    Struct(Rc<Struct>),
}

#[derive(Debug)]
pub struct Struct {
    pub name: String,
    pub members: Vec<Member>,
}

/// How a length is written; the value is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spelling {
    Decimal,
    Unsigned,
    Hexadecimal,
    Sum,
    /// A global constant of the shader.
    Constant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dim {
    /// `None` is runtime-sized.
    pub length: Option<u32>,
    pub spelling: Spelling,
}

#[derive(Clone, Debug)]
pub struct Member {
    pub name: String,
    pub ty: Type,
    /// `T a[2][3]`, outermost first.
    pub name_dims: Vec<Dim>,
    /// `T[3] a`, outermost first; inside those of the name.
    pub type_dims: Vec<Dim>,
    /// Written in the same statement as the member before: `float a, b[2];`.
    pub joined: bool,
    pub major: Option<Major>,
    pub offset: Option<u64>,
    pub align: Option<u64>,
}

impl Member {
    pub fn plain(name: &str, ty: Type) -> Self {
        Self {
            name: name.to_owned(),
            ty,
            name_dims: Vec::new(),
            type_dims: Vec::new(),
            joined: false,
            major: None,
            offset: None,
            align: None,
        }
    }

    pub fn dims(&self) -> impl Iterator<Item = &Dim> {
        self.name_dims.iter().chain(&self.type_dims)
    }
}

#[derive(Clone, Debug)]
pub struct Block {
    pub name: String,
    pub space: Space,
    pub rules: Rules,
    /// False where the shader's default-layout statement says it.
    pub rules_written: bool,
    pub major: Option<Major>,
    pub align: Option<u64>,
    /// Without one, the members' names are global to the shader.
    pub instance: Option<String>,
    /// An array of blocks; needs an instance.
    pub count: Option<u32>,
    pub members: Vec<Member>,
}

/// `layout(std140, row_major) uniform;`
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    pub space: Space,
    pub rules: Rules,
    pub major: Option<Major>,
}

/// A leaf as it is declared: path, type and dimensions, and no bytes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Declared {
    pub path: String,
    pub ty: String,
    pub dims: Vec<Option<u64>>,
}

/// Every leaf of a block in order of declaration.
pub fn declared(block: &Block) -> Vec<Declared> {
    let mut leaves = Vec::new();
    declared_in(&block.members, "", &[], &mut leaves);
    leaves
}

fn declared_in(
    members: &[Member],
    prefix: &str,
    outer: &[Option<u64>],
    leaves: &mut Vec<Declared>,
) {
    for member in members {
        let mut dims = outer.to_vec();
        dims.extend(member.dims().map(|d| d.length.map(u64::from)));
        let path = format!("{prefix}{}{}", member.name, "[]".repeat(member.dims().count()));
        match &member.ty {
            Type::Basic(basic) => leaves.push(Declared { path, ty: basic.word(), dims }),
            Type::Struct(structure) => {
                declared_in(&structure.members, &format!("{path}."), &dims, leaves);
            }
        }
    }
}

/// A compute shader that declares the blocks and reads one value of each, so
/// that no listing leaves any out.
pub fn print(standing: &[Standing], blocks: &[&Block]) -> String {
    let mut parts = Parts::default();
    for block in blocks {
        parts.of_block(block);
    }
    let mut text = String::from("#version 450\n");
    for extension in &parts.extensions {
        let _ = writeln!(text, "#extension {extension} : require");
    }
    text.push_str("layout(local_size_x = 1) in;\n");
    for length in &parts.constants {
        let _ = writeln!(text, "const int N{length} = {length};");
    }
    for default in standing {
        let mut words = vec![rules(default.rules)];
        words.extend(default.major.map(major));
        let _ = writeln!(text, "layout({}) {};", words.join(", "), space(default.space));
    }
    for structure in &parts.structs {
        let _ = writeln!(text, "struct {} {{", structure.name);
        members(&structure.members, &mut text);
        text.push_str("};\n");
    }
    for block in blocks {
        print_block(block, &mut text);
    }
    text.push_str("shared float sink;\nvoid main() {\n    float sum = 0.0;\n");
    for block in blocks {
        let _ = writeln!(text, "    sum += {};", touch(block));
    }
    text.push_str("    sink = sum;\n}\n");
    text
}

fn print_block(block: &Block, text: &mut String) {
    let mut words = Vec::new();
    if block.rules_written {
        words.push(rules(block.rules).to_owned());
    }
    if block.space == Space::PushConstant {
        words.push("push_constant".to_owned());
    }
    words.extend(block.major.map(|m| major(m).to_owned()));
    words.extend(block.align.map(|a| format!("align = {a}")));
    if !words.is_empty() {
        let _ = write!(text, "layout({}) ", words.join(", "));
    }
    let _ = writeln!(text, "{} {} {{", space(block.space), block.name);
    members(&block.members, text);
    text.push('}');
    if let Some(instance) = &block.instance {
        let _ = write!(text, " {instance}");
        if let Some(count) = block.count {
            let _ = write!(text, "[{count}]");
        }
    }
    text.push_str(";\n");
}

fn members(members: &[Member], text: &mut String) {
    for (at, member) in members.iter().enumerate() {
        if !member.joined {
            text.push_str("    ");
            let mut words = Vec::new();
            words.extend(member.major.map(|m| major(m).to_owned()));
            words.extend(member.offset.map(|o| format!("offset = {o}")));
            words.extend(member.align.map(|a| format!("align = {a}")));
            if !words.is_empty() {
                let _ = write!(text, "layout({}) ", words.join(", "));
            }
            match &member.ty {
                Type::Basic(basic) => text.push_str(&basic.word()),
                Type::Struct(structure) => text.push_str(&structure.name),
            }
            dims(&member.type_dims, text);
        }
        let _ = write!(text, " {}", member.name);
        dims(&member.name_dims, text);
        let goes_on = members.get(at + 1).is_some_and(|next| next.joined);
        text.push_str(if goes_on { "," } else { ";\n" });
    }
}

fn dims(dims: &[Dim], text: &mut String) {
    for dim in dims {
        let _ = match (dim.length, dim.spelling) {
            (None, _) => write!(text, "[]"),
            (Some(n), Spelling::Decimal) => write!(text, "[{n}]"),
            (Some(n), Spelling::Unsigned) => write!(text, "[{n}u]"),
            (Some(n), Spelling::Hexadecimal) => write!(text, "[0x{n:X}]"),
            (Some(n), Spelling::Sum) => write!(text, "[{} + 1]", n - 1),
            (Some(n), Spelling::Constant) => write!(text, "[N{n}]"),
        };
    }
}

/// An expression that reads one float's worth of the block.
fn touch(block: &Block) -> String {
    let mut path = match (&block.instance, block.count) {
        (Some(instance), Some(_)) => format!("{instance}[0]."),
        (Some(instance), None) => format!("{instance}."),
        (None, _) => String::new(),
    };
    let mut member = &block.members[0];
    loop {
        path.push_str(&member.name);
        path.push_str(&"[0]".repeat(member.dims().count()));
        match &member.ty {
            Type::Struct(structure) => {
                path.push('.');
                member = &structure.members[0];
            }
            Type::Basic(basic) => {
                if basic.is_matrix() {
                    path.push_str("[0]");
                }
                if basic.rows > 1 {
                    path.push_str(".x");
                }
                return match basic.scalar {
                    // 8-bit storage converts to 32-bit integers only.
                    Scalar::Int8 | Scalar::Int16 => format!("float(int({path}))"),
                    Scalar::Uint8 | Scalar::Uint16 => format!("float(uint({path}))"),
                    _ => format!("float({path})"),
                };
            }
        }
    }
}

fn rules(rules: Rules) -> &'static str {
    match rules {
        Rules::Std140 => "std140",
        Rules::Std430 => "std430",
        Rules::Scalar => "scalar",
    }
}

fn space(space: Space) -> &'static str {
    match space {
        Space::Uniform | Space::PushConstant => "uniform",
        Space::Buffer => "buffer",
    }
}

fn major(major: Major) -> &'static str {
    match major {
        Major::Row => "row_major",
        Major::Column => "column_major",
    }
}

/// What blocks need declared before them.
#[derive(Default)]
struct Parts<'b> {
    extensions: BTreeSet<&'static str>,
    constants: BTreeSet<u32>,
    structs: Vec<&'b Rc<Struct>>,
}

impl<'b> Parts<'b> {
    fn of_block(&mut self, block: &'b Block) {
        let loose = block.rules == Rules::Std430 && block.space == Space::Uniform;
        if block.rules == Rules::Scalar || loose {
            self.extensions.insert("GL_EXT_scalar_block_layout");
        }
        self.of_members(&block.members);
    }

    fn of_members(&mut self, members: &'b [Member]) {
        for member in members {
            for dim in member.dims() {
                if dim.spelling == Spelling::Constant {
                    self.constants.extend(dim.length);
                }
            }
            match &member.ty {
                Type::Basic(basic) => self.extensions.extend(basic.scalar.extensions()),
                Type::Struct(structure) => {
                    if !self.structs.iter().any(|s| s.name == structure.name) {
                        self.of_members(&structure.members);
                        self.structs.push(structure);
                    }
                }
            }
        }
    }
}
