//! What a shader's text says, as a tree: whole, bodies included, names not yet looked up.
//!
//! Made by [`parse`](super::parse), read by the lowering beside it.

use std::rc::Rc;

use landfall_layout::source::Span;

/// A name and where it stands.
#[derive(Clone, Copy, Debug)]
pub struct Name<'a> {
    pub text: &'a str,
    pub span: Span,
}

/// An expression and where it stands.
#[derive(Debug)]
pub struct Expr<'a> {
    pub kind: ExprKind<'a>,
    pub span: Span,
    /// Levels below it, itself included: what recursion over it costs.
    pub depth: u32,
}

#[derive(Debug)]
pub enum ExprKind<'a> {
    Number(&'a str),
    Bool(bool),
    Name(&'a str),
    Unary(Unary, Box<Expr<'a>>),
    Binary(Binary, Box<Expr<'a>>, Box<Expr<'a>>),
    /// `a = b`, or `a OP= b`.
    Assign(Option<Binary>, Box<Expr<'a>>, Box<Expr<'a>>),
    /// `++a`, `a--` and so on.
    Step(Step, Box<Expr<'a>>),
    Choose(Box<[Expr<'a>; 3]>),
    Comma(Box<Expr<'a>>, Box<Expr<'a>>),
    Index(Box<Expr<'a>>, Box<Expr<'a>>),
    Member(Box<Expr<'a>>, Name<'a>),
    /// A function, or a structure's constructor.
    Call(Name<'a>, Vec<Expr<'a>>),
    /// `vec3(…)`, `float[](…)`.
    Construct(Box<TypeSpec<'a>>, Vec<Expr<'a>>),
    Length(Box<Expr<'a>>),
    /// `{ a, b }`
    List(Vec<Expr<'a>>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    Plus,
    Minus,
    Not,
    Complement,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    pub increment: bool,
    /// `++a`: the value is the new one.
    pub before: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Modulo,
    ShiftLeft,
    ShiftRight,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
    BitAnd,
    BitXor,
    BitOr,
    And,
    Xor,
    Or,
}

/// A type as written, its own dimensions included.
#[derive(Debug)]
pub struct TypeSpec<'a> {
    pub base: TypeBase<'a>,
    pub dims: Vec<Dim<'a>>,
    pub span: Span,
    /// Of floats and what is sampled, where the dialect has precisions: said, or the default.
    pub precision: Option<Precision>,
}

/// How precisely a dialect of OpenGL ES wants numbers, the least first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Precision {
    Low,
    Medium,
    High,
}

#[derive(Debug)]
pub enum TypeBase<'a> {
    Name(&'a str),
    Struct(Rc<StructDecl<'a>>),
}

/// `[SIZE]` or `[]`.
#[derive(Debug)]
pub struct Dim<'a> {
    pub size: Option<Expr<'a>>,
}

#[derive(Debug)]
pub struct StructDecl<'a> {
    /// Empty when there is none.
    pub name: Name<'a>,
    pub members: Vec<Declaration<'a>>,
}

/// Where a variable lives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Storage {
    #[default]
    Plain,
    Const,
    In,
    Out,
    InOut,
    Uniform,
    Buffer,
    Shared,
    /// Anything landfall does not run: ray payloads and the like.
    Foreign,
}

/// What stands before a type.
#[derive(Debug, Default)]
pub struct Qualifiers<'a> {
    pub storage: Storage,
    /// `const` beside `in`.
    pub constant: bool,
    pub flat: bool,
    pub noperspective: bool,
    pub centroid: bool,
    pub sample: bool,
    pub patch: bool,
    pub subroutine: bool,
    pub readonly: bool,
    pub writeonly: bool,
    pub layout: Vec<LayoutId<'a>>,
    pub any: bool,
}

/// One entry of `layout(…)`.
#[derive(Debug)]
pub struct LayoutId<'a> {
    pub name: Name<'a>,
    pub value: Option<Expr<'a>>,
}

impl<'a> Qualifiers<'a> {
    /// The last entry of that name; names in `layout(…)` are not case sensitive.
    pub fn find(&self, name: &str) -> Option<&LayoutId<'a>> {
        self.layout.iter().rev().find(|id| id.name.text.eq_ignore_ascii_case(name))
    }
}

/// `QUALIFIERS TYPE a, b[2] = …;`
#[derive(Debug)]
pub struct Declaration<'a> {
    pub qualifiers: Qualifiers<'a>,
    pub ty: TypeSpec<'a>,
    pub names: Vec<Declarator<'a>>,
}

#[derive(Debug)]
pub struct Declarator<'a> {
    pub name: Name<'a>,
    pub dims: Vec<Dim<'a>>,
    pub init: Option<Expr<'a>>,
}

/// `QUALIFIERS NAME { … } INSTANCE[N];`
#[derive(Debug)]
pub struct BlockDecl<'a> {
    pub qualifiers: Qualifiers<'a>,
    pub name: Name<'a>,
    pub members: Vec<Declaration<'a>>,
    pub instance: Option<Name<'a>>,
    pub dims: Vec<Dim<'a>>,
}

#[derive(Debug)]
pub struct Parameter<'a> {
    pub qualifiers: Qualifiers<'a>,
    pub ty: TypeSpec<'a>,
    /// Empty when there is none.
    pub name: Name<'a>,
    pub dims: Vec<Dim<'a>>,
}

#[derive(Debug)]
pub struct FunctionDecl<'a> {
    pub name: Name<'a>,
    pub returns: TypeSpec<'a>,
    pub parameters: Vec<Parameter<'a>>,
    /// `None` for a prototype.
    pub body: Option<Vec<Statement<'a>>>,
}

#[derive(Debug)]
pub enum Item<'a> {
    Variables(Rc<Declaration<'a>>),
    Block(BlockDecl<'a>),
    Function(Rc<FunctionDecl<'a>>),
    /// `layout(…) in;`
    Defaults(Qualifiers<'a>),
}

#[derive(Debug)]
pub struct Statement<'a> {
    pub kind: StatementKind<'a>,
    pub span: Span,
}

#[derive(Debug)]
pub enum StatementKind<'a> {
    Empty,
    Declaration(Declaration<'a>),
    Expression(Expr<'a>),
    Block(Vec<Statement<'a>>),
    If(Condition<'a>, Box<Statement<'a>>, Option<Box<Statement<'a>>>),
    For(Box<For<'a>>),
    While(Condition<'a>, Box<Statement<'a>>),
    DoWhile(Box<Statement<'a>>, Expr<'a>),
    Switch(Expr<'a>, Vec<Statement<'a>>),
    Case(Expr<'a>),
    Default,
    Break,
    Continue,
    Discard,
    Return(Option<Expr<'a>>),
}

/// An expression, or `bool a = …` in its place.
#[derive(Debug)]
pub enum Condition<'a> {
    Expression(Expr<'a>),
    Declaration(Declaration<'a>),
}

#[derive(Debug)]
pub struct For<'a> {
    pub init: Statement<'a>,
    pub condition: Option<Condition<'a>>,
    pub step: Option<Expr<'a>>,
    pub body: Statement<'a>,
}
