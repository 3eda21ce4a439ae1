//! Names in function bodies that no declaration has: variables, types, functions, and members of
//! structures and blocks. Numbers that are none.
//!
//! Local names follow scopes; a global name or a structure may be declared anywhere. A variable's
//! type is known only where all declarations of its name agree, and a member of unknown type need
//! only be one of some structure. A function is unknown only if its name is near to a known one,
//! because extensions have many. So nothing is reported that a compiler accepts.

use rustc_hash::{FxHashMap, FxHashSet};

use super::ast::{
    BlockDecl, Declaration, Expr, ExprKind, FunctionDecl, Item, Name, StructDecl, TypeBase,
    TypeSpec,
};
use super::evaluate::{NotANumber, literal};
use super::functions::may_be_of_extension;
use super::members::COMMON_TYPES;
use super::parser::Parser;
use super::types::builtin;
use crate::Diagnostic;
use crate::diagnostic::Code;
use crate::source::Span;
use crate::syntax::first_name_errors;
use crate::text::edit_distance::suggestion;

use super::walk::{self, Part};

/// The members of a structure or block with the names of their types; `None` where two
/// declarations differ or the type is not a name.
type Types<'a> = FxHashMap<&'a str, Option<&'a str>>;

/// What a shader declares, and the names it uses.
// Two passes: the walk collects all declarations and uses, then each use is looked up. Global order
// is thereby ignored, since includes and macros make it uncertain.
#[derive(Default)]
struct NameChecker<'t, 'a> {
    /// Global and local ones.
    variables: Types<'a>,
    globals: FxHashSet<&'a str>,
    /// The local names of each scope that is open.
    locals: Vec<FxHashSet<&'a str>>,
    /// `None` for a name that two structures have.
    structures: FxHashMap<&'a str, Option<Types<'a>>>,
    members: FxHashSet<&'a str>,
    uses: Vec<NameUse<'t, 'a>>,
    functions: FxHashSet<&'a str>,
}

/// What is looked up when all declarations are known.
enum NameUse<'t, 'a> {
    /// A member, a function, a number, or a variable that is not local.
    Expression(&'t Expr<'a>),
    Type(&'t TypeSpec<'a>),
}

/// Returns an error for each such name in declarations whose expressions and bodies are parsed.
pub(super) fn undeclared<'a>(items: &[Item<'a>], parser: &Parser<'a>) -> Vec<Diagnostic> {
    let mut names = NameChecker::default();
    for item in items {
        match item {
            Item::Variables(declaration) => names.declaration(declaration),
            Item::Block(block) | Item::Interface(block) => names.block(block),
            Item::Function(function) => {
                names.function(function);
            }
            Item::Requalified(_, name) => names.any(name.text),
            // Whatever it declares, it may be any name in it.
            Item::Other(tokens) => {
                for token in &parser.tokens()[tokens.clone()] {
                    names.any(token.text);
                    names.structures.insert(token.text, None);
                    names.members.insert(token.text);
                }
            }
            Item::Defaults(_) | Item::Precision(_) => {}
        }
    }
    let error = |one: &NameUse<'_, 'a>| match one {
        NameUse::Expression(e) => names.error(e),
        NameUse::Type(ty) => names.type_error(ty),
    };
    first_name_errors(names.uses.iter().filter_map(error))
}

impl<'t, 'a> NameChecker<'t, 'a> {
    fn declare(&mut self, name: &'a str, ty: Option<&'a str>) {
        add(&mut self.variables, name, ty);
        self.locals.last_mut().unwrap_or(&mut self.globals).insert(name);
    }

    /// Declares a global variable of any type.
    fn any(&mut self, name: &'a str) {
        self.variables.insert(name, None);
        self.globals.insert(name);
    }

    fn function(&mut self, function: &'t FunctionDecl<'a>) {
        self.functions.insert(function.name.text);
        self.ty(&function.returns);
        self.locals.push(FxHashSet::default());
        for parameter in &function.parameters {
            self.ty(&parameter.ty);
            self.declare(parameter.name.text, parameter.ty.base_name());
        }
        if let Some(body) = &function.body {
            walk::scope(body, &mut |part| match part {
                Part::Open => self.locals.push(FxHashSet::default()),
                Part::Close => drop(self.locals.pop()),
                Part::Declaration(declaration) => {
                    self.uses.push(NameUse::Type(&declaration.ty));
                    self.declaration(declaration);
                }
                Part::Expression(e) => self.expression(e),
            });
        }
        self.locals.pop();
    }

    fn ty(&mut self, ty: &'t TypeSpec<'a>) {
        if let TypeBase::Struct(structure) = &ty.base {
            self.structure(structure);
        }
    }

    fn structure(&mut self, structure: &'t StructDecl<'a>) {
        let members = self.members_of(&structure.members);
        self.named(structure.name.text, members);
    }

    fn named(&mut self, name: &'a str, members: Types<'a>) {
        // Two structures of one name (in branches, in scopes): its members are not known.
        let known = self.structures.insert(name, Some(members));
        if known.is_some() {
            self.structures.insert(name, None);
        }
    }

    fn members_of(&mut self, declared: &'t [Declaration<'a>]) -> Types<'a> {
        let mut members = Types::default();
        for declaration in declared {
            self.ty(&declaration.ty);
            for declarator in &declaration.names {
                self.members.insert(declarator.name.text);
                add(&mut members, declarator.name.text, declaration.ty.base_name());
            }
        }
        members
    }

    fn block(&mut self, block: &'t BlockDecl<'a>) {
        let members = self.members_of(&block.members);
        match &block.instance {
            Some(instance) => self.declare(instance.text, Some(block.name.text)),
            None => members.iter().for_each(|(name, ty)| self.declare(name, *ty)),
        }
        // The type of a buffer reference is its block.
        self.named(block.name.text, members);
    }

    fn declaration(&mut self, declaration: &'t Declaration<'a>) {
        self.ty(&declaration.ty);
        for declarator in &declaration.names {
            if let Some(init) = &declarator.init {
                self.expression(init);
            }
            // A name is known from the end of its initialiser on (GLSL 4.60 §4.2.2).
            self.declare(declarator.name.text, declaration.ty.base_name());
        }
    }

    fn expression(&mut self, e: &'t Expr<'a>) {
        let is_local = |name: &str| self.locals.iter().any(|scope| scope.contains(name));
        match &e.kind {
            ExprKind::Name(name) if is_local(name) => {}
            ExprKind::Name(_) | ExprKind::Member(..) | ExprKind::Call(..) | ExprKind::Number(_) => {
                self.uses.push(NameUse::Expression(e));
            }
            ExprKind::Construct(ty, _) => self.ty(ty),
            _ => {}
        }
        walk::operands(e, &mut |operand| self.expression(operand));
    }

    fn error(&self, e: &Expr<'a>) -> Option<Diagnostic> {
        match &e.kind {
            ExprKind::Name(name) => {
                let is_known = self.globals.contains(name)
                    || self.structures.contains_key(name)
                    || is_predeclared(name);
                let message = format!("`{name}` is not declared");
                let help = || suggestion(name, self.variables.keys().copied());
                (!is_known).then(|| error(Code::UnknownName, e.span, message, help()))
            }
            ExprKind::Member(base, member) => self.member_error(base, member),
            ExprKind::Call(name, _) => self.function_error(name),
            ExprKind::Number(text) if literal(text) == Err(NotANumber::Malformed) => {
                Some(Diagnostic::error(Code::Syntax, e.span, format!("`{text}` is not a number")))
            }
            _ => None,
        }
    }

    fn type_error(&self, ty: &TypeSpec<'a>) -> Option<Diagnostic> {
        let TypeBase::Name(name) = ty.base else { return None };
        let is_known = builtin(name).is_some()
            || self.structures.contains_key(name)
            || is_predeclared(name)
            || may_be_of_extension(name);
        let known = self.structures.keys().chain(COMMON_TYPES).copied();
        let message = format!("unknown type `{name}`");
        (!is_known).then(|| error(Code::UnknownType, ty.span, message, suggestion(name, known)))
    }

    fn function_error(&self, name: &Name<'a>) -> Option<Diagnostic> {
        let text = name.text;
        let is_known = self.functions.contains(text)
            || self.structures.contains_key(text)
            // Of `Item::Other`, or a parameter of a macro of the includer.
            || self.variables.contains_key(text)
            || is_predeclared(text)
            // A name in capitals is a macro that the program defines.
            || text.chars().all(|c| c.is_ascii_uppercase() || c == '_' || c.is_ascii_digit())
            || FAMILIES.iter().any(|start| text.starts_with(start))
            || EXTENSIONS.iter().any(|end| text.ends_with(end))
            || FUNCTIONS.split(' ').any(|known| known == text);
        if is_known {
            return None;
        }
        let types = self.structures.keys().chain(COMMON_TYPES).copied();
        let known = self.functions.iter().copied().chain(FUNCTIONS.split(' ')).chain(types);
        let help = suggestion(text, known)?;
        let message = format!("there is no function `{text}`");
        Some(error(Code::UnknownFunction, name.span, message, Some(help)))
    }

    // Of a known structure its members are looked up; otherwise any structure's, and swizzles. So a
    // wrong member of a wrong structure may pass.
    fn member_error(&self, base: &Expr<'a>, member: &Name<'a>) -> Option<Diagnostic> {
        if is_predeclared(base.root()?) {
            return None;
        }
        let of = self.type_of(base);
        let message = match of.and_then(|ty| Some((ty, self.structures.get(ty)?.as_ref()?))) {
            Some((_, members)) if members.contains_key(member.text) => return None,
            Some((ty, _)) => format!("`{ty}` has no member `{}`", member.text),
            None if is_swizzle(member.text) || self.members.contains(member.text) => return None,
            None => format!("no structure has a member `{}`", member.text),
        };
        let known = of.and_then(|ty| self.structures.get(ty)?.as_ref());
        let help = match known {
            Some(members) => suggestion(member.text, members.keys().copied()),
            None => suggestion(member.text, self.members.iter().copied()),
        };
        Some(error(Code::UnknownMember, member.span, message, help))
    }

    /// The name of the type of an expression or of its elements, if it is known.
    // An index does not change the name: elements of arrays, vectors and matrices are reached by
    // it, and only structures are looked up.
    fn type_of(&self, e: &Expr<'a>) -> Option<&'a str> {
        match &e.kind {
            ExprKind::Name(name) => *self.variables.get(name)?,
            ExprKind::Index(base, _) => self.type_of(base),
            ExprKind::Member(base, member) => {
                let members = self.structures.get(self.type_of(base)?)?.as_ref()?;
                *members.get(member.text)?
            }
            _ => None,
        }
    }
}

fn add<'a>(types: &mut Types<'a>, name: &'a str, ty: Option<&'a str>) {
    let known = types.entry(name).or_insert(ty);
    if *known != ty {
        *known = None;
    }
}

/// Whether the language, an extension or the preprocessor may declare a name.
fn is_predeclared(name: &str) -> bool {
    name.starts_with("gl_") || name.contains("__")
}

/// Whether a member may be components of a vector.
fn is_swizzle(member: &str) -> bool {
    let sets = ["xyzw", "rgba", "stpq"];
    member.len() <= 4 && sets.iter().any(|set| member.chars().all(|c| set.contains(c)))
}

fn error(code: Code, span: Span, message: String, help: Option<String>) -> Diagnostic {
    Diagnostic { help, ..Diagnostic::error(code, span, message) }
}

/// The functions of GLSL (4.60 §8, and those of earlier versions), without the families below.
const FUNCTIONS: &str = "radians degrees sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh pow exp log \
     exp2 log2 sqrt inversesqrt abs sign floor trunc round roundEven ceil fract mod modf min \
     max clamp mix step smoothstep isnan isinf floatBitsToInt floatBitsToUint intBitsToFloat \
     uintBitsToFloat fma frexp ldexp packUnorm2x16 packSnorm2x16 packUnorm4x8 packSnorm4x8 \
     unpackUnorm2x16 unpackSnorm2x16 unpackUnorm4x8 unpackSnorm4x8 packHalf2x16 unpackHalf2x16 \
     packDouble2x32 unpackDouble2x32 length distance dot cross normalize ftransform faceforward \
     reflect refract matrixCompMult outerProduct transpose determinant inverse lessThan \
     lessThanEqual greaterThan greaterThanEqual equal notEqual any all not uaddCarry usubBorrow \
     umulExtended imulExtended bitfieldExtract bitfieldInsert bitfieldReverse bitCount findLSB \
     findMSB dFdx dFdy dFdxFine dFdyFine dFdxCoarse dFdyCoarse fwidth fwidthFine fwidthCoarse \
     interpolateAtCentroid interpolateAtSample interpolateAtOffset noise1 noise2 noise3 noise4 \
     EmitStreamVertex EndStreamPrimitive EmitVertex EndPrimitive barrier memoryBarrier \
     memoryBarrierAtomicCounter memoryBarrierBuffer memoryBarrierShared memoryBarrierImage \
     groupMemoryBarrier subpassLoad anyInvocation allInvocations allInvocationsEqual min3 max3 \
     mid3 mul24 debugPrintf controlBarrier";

/// The beginnings of names of functions of which versions and extensions have many.
const FAMILIES: &[&str] = &[
    "texture",
    "texel",
    "shadow",
    "image",
    "atomic",
    "subgroup",
    "sparse",
    "coopMat",
    "coopVec",
    "rayQuery",
    "hitObject",
    "tensor",
    "pack",
    "unpack",
    "bitfield",
    "clock",
];

/// The ends of names of extensions' functions.
const EXTENSIONS: &[&str] =
    &["EXT", "ARB", "KHR", "NV", "AMD", "OES", "INTEL", "ATI", "QCOM", "ARM", "HUAWEI", "APPLE"];
