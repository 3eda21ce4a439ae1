//! The syntax tree of a shader, with names unresolved.
//!
//! Built by [`parser`](super::parser). Declarations keep the tokens of their expressions and
//! bodies, which [`Parser::complete`](super::parser::Parser::complete) parses.

#![allow(missing_docs)] // fields and variants are named after the grammar's own productions

use std::ops::Range;
use std::rc::Rc;

use crate::source::Span;
use crate::text::named::named;

pub type Tokens = Range<usize>;

#[derive(Clone, Copy, Debug)]
pub struct Name<'a> {
    pub text: &'a str,
    pub span: Span,
    pub at: usize,
}

// GLSL 4.60 §9, from `primary_expression` to `expression`: parentheses leave no node, only a wider
// span.
#[derive(Debug)]
pub struct Expr<'a> {
    pub kind: ExprKind<'a>,
    pub span: Span,
    /// The span of the operator, called name or literal.
    pub mark: Span,
    /// Levels of expressions in it, itself included: the cost of recursion over it.
    pub depth: u32,
}

impl<'a> Expr<'a> {
    /// The variable that the expression is a part of, if it is one.
    // `a` of `a[i].b.c`.
    pub fn root(&self) -> Option<&'a str> {
        match &self.kind {
            ExprKind::Name(name) => Some(name),
            ExprKind::Index(base, _) | ExprKind::Member(base, _) => base.root(),
            _ => None,
        }
    }
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
    Step(IncrementOp, Box<Expr<'a>>),
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

named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Unary {
        Plus = "+",
        Minus = "-",
        Not = "!",
        Complement = "~",
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IncrementOp {
    pub increment: bool,
    /// `++a`: the value is the new one.
    pub before: bool,
}

named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Binary {
        Add = "+",
        Subtract = "-",
        Multiply = "*",
        Divide = "/",
        Modulo = "%",
        ShiftLeft = "<<",
        ShiftRight = ">>",
        Less = "<",
        LessEqual = "<=",
        Greater = ">",
        GreaterEqual = ">=",
        Equal = "==",
        NotEqual = "!=",
        BitAnd = "&",
        BitXor = "^",
        BitOr = "|",
        And = "&&",
        Xor = "^^",
        Or = "||",
    }
}

/// A type as written, its own dimensions included.
// `fully_specified_type` without its qualifiers, which are with the declaration.
#[derive(Debug)]
pub struct TypeSpec<'a> {
    pub base: TypeBase<'a>,
    /// The token of the name, or `struct`.
    pub at: usize,
    pub dims: Vec<Dim<'a>>,
    pub span: Span,
    /// Whether `<…>` follows the name.
    pub parameters: bool,
    /// The precision of float and sampler types, written or by default, in dialects that have
    /// precisions.
    pub precision: Option<PrecisionQualifier>,
}

/// The precision qualifiers of OpenGL ES, the lowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PrecisionQualifier {
    Low,
    Medium,
    High,
}

impl<'a> TypeSpec<'a> {
    /// The name of the type; `None` for a structure declared in place.
    pub fn base_name(&self) -> Option<&'a str> {
        match &self.base {
            TypeBase::Name(name) => Some(name),
            TypeBase::Struct(structure) => {
                Some(structure.name.text).filter(|name| !name.is_empty() && *name != "struct")
            }
        }
    }
}

#[derive(Debug)]
pub enum TypeBase<'a> {
    Name(&'a str),
    Struct(Rc<StructDecl<'a>>),
}

/// `[SIZE]` or `[]`.
#[derive(Debug)]
pub struct Dim<'a> {
    pub tokens: Tokens,
    /// The span, both brackets included.
    pub span: Span,
    pub size: Option<Box<Expr<'a>>>,
}

#[derive(Debug)]
pub struct StructDecl<'a> {
    /// The name; if there is none, empty with the place of `struct`.
    pub name: Name<'a>,
    pub members: Vec<Declaration<'a>>,
    pub closed: bool,
    /// From `struct` to `}`.
    pub tokens: Tokens,
}

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
    /// `varying`: an input of a fragment shader, an output of a vertex shader.
    Varying,
    /// Storage that landfall does not execute, such as ray payloads.
    Foreign,
}

// `type_qualifier`, whose words may come in any order: what matters of them is a flag each.
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
    pub tokens: Tokens,
}

/// One entry of `layout(…)`.
#[derive(Debug)]
pub struct LayoutId<'a> {
    pub name: Name<'a>,
    pub tokens: Tokens,
    pub value: Option<Box<Expr<'a>>>,
}

impl LayoutId<'_> {
    /// Whether the entry has that name; names in `layout(…)` are not case sensitive (GLSL 4.60
    /// §4.4).
    #[inline]
    pub fn is(&self, name: &str) -> bool {
        self.name.text.eq_ignore_ascii_case(name)
    }

    pub(super) fn is_among(&self, names: &[&str]) -> bool {
        names.iter().any(|name| self.is(name))
    }
}

impl<'a> Qualifiers<'a> {
    /// Returns the last layout entry with that name; later ones override earlier ones.
    #[inline]
    pub fn find(&self, name: &str) -> Option<&LayoutId<'a>> {
        self.layout.iter().rev().find(|id| id.is(name))
    }
}

/// `QUALIFIERS TYPE a, b[2] = …;`
#[derive(Debug)]
pub struct Declaration<'a> {
    /// From the first token to `;`.
    pub tokens: Tokens,
    pub qualifiers: Qualifiers<'a>,
    pub ty: TypeSpec<'a>,
    pub names: Vec<Declarator<'a>>,
    /// Whether a syntax error in it was reported.
    pub broken: bool,
}

#[derive(Debug)]
pub struct Declarator<'a> {
    pub name: Name<'a>,
    pub dims: Vec<Dim<'a>>,
    pub tokens: Tokens,
    pub init: Option<Box<Expr<'a>>>,
}

/// `QUALIFIERS NAME { … } INSTANCE[N];`
#[derive(Debug)]
pub struct BlockDecl<'a> {
    /// From the first token to `;`.
    pub tokens: Tokens,
    pub qualifiers: Qualifiers<'a>,
    pub name: Name<'a>,
    /// The members of a block of inputs or outputs, parsed on demand.
    pub members: Vec<Declaration<'a>>,
    pub instance: Option<Name<'a>>,
    pub dims: Vec<Dim<'a>>,
    pub closed: bool,
    /// The number of diagnostics before the members.
    pub diagnostics: usize,
}

#[derive(Debug)]
pub struct Parameter<'a> {
    pub tokens: Tokens,
    pub qualifiers: Qualifiers<'a>,
    pub ty: TypeSpec<'a>,
    /// The name; empty if there is none.
    pub name: Name<'a>,
    pub dims: Vec<Dim<'a>>,
}

#[derive(Debug)]
pub struct FunctionDecl<'a> {
    /// From the first token to `;` or `}`.
    pub tokens: Tokens,
    pub name: Name<'a>,
    pub returns: TypeSpec<'a>,
    /// The tokens between the parentheses.
    pub parameter_tokens: Tokens,
    pub parameters: Vec<Parameter<'a>>,
    /// The tokens between the braces; empty where bodies are skipped.
    pub body_tokens: Option<Tokens>,
    /// The body, parsed on demand; `None` for a prototype.
    pub body: Option<Vec<Statement<'a>>>,
}

/// The default precisions set by `precision` statements.
#[derive(Clone, Copy, Debug)]
pub struct Precisions {
    /// The precision of floats; `None` before any statement sets it: then the stage decides.
    pub float: Option<PrecisionQualifier>,
    /// The precision of values sampled from a `sampler2D` or `samplerCube`; other samplers have no
    /// default.
    pub sampled: PrecisionQualifier,
}

impl Default for Precisions {
    // GLSL ES 3.20 §4.7.4.
    fn default() -> Precisions {
        Precisions { float: None, sampled: PrecisionQualifier::Low }
    }
}

// Functions and variables are in an `Rc`, since lowering keeps them by name, beside the list.
#[derive(Debug)]
pub enum Item<'a> {
    Variables(Rc<Declaration<'a>>),
    /// A `uniform` or `buffer` block.
    Block(BlockDecl<'a>),
    /// A block of inputs or outputs.
    Interface(BlockDecl<'a>),
    Function(Rc<FunctionDecl<'a>>),
    /// `layout(…) in;`
    Defaults(Qualifiers<'a>),
    /// `invariant gl_Position;`
    Requalified(Qualifiers<'a>, Name<'a>),
    /// `precision mediump float;`
    Precision(Tokens),
    /// A declaration without effect, or a reported syntax error.
    Other(Tokens),
}

#[derive(Debug)]
pub struct Statement<'a> {
    pub kind: StatementKind<'a>,
    pub span: Span,
}

// `case` and `default` are labels between the statements of a `Switch`, as the grammar has them.
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

/// An expression, or a declaration `bool a = …` in its place.
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
