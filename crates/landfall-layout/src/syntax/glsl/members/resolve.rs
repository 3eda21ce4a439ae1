//! Resolution of type names to data types or opaque handles.
//!
//! Uses the structures that [`declarations`](crate::syntax::glsl::declarations) has read.

use std::sync::Arc;

use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{Struct, Type};
use crate::syntax::glsl::declarations::{DeclarationReader, Named};
use crate::syntax::glsl::lexer::Token;
use crate::syntax::glsl::report::diagnostic_at;
use crate::syntax::glsl::types::{Builtin, builtin};
use crate::text::edit_distance::suggestion;

/// The type of a declaration, as written.
#[derive(Clone, Debug)]
pub(in crate::syntax::glsl) enum TypeName<'a> {
    Name(Token<'a>),
    Declared(Named<'a>),
}

pub(in crate::syntax::glsl) enum Resolved {
    Data(Type),
    Opaque,
    /// Unusable, as reported before.
    Broken,
}

impl<'a> TypeName<'a> {
    pub(super) fn text(&self) -> &'a str {
        match self {
            TypeName::Name(token) => token.text,
            TypeName::Declared(_) => "struct",
        }
    }
}

impl<'a> DeclarationReader<'a> {
    /// Resolves a type name; errors about unknown and broken types are added to `problems`.
    pub(in crate::syntax::glsl) fn resolve(
        &mut self,
        ty: &TypeName<'a>,
        owner: &Token<'a>,
        problems: &mut Vec<Diagnostic>,
    ) -> Resolved {
        let token = match ty {
            TypeName::Name(token) => *token,
            TypeName::Declared(Named::Struct(s)) => return of_struct(s),
            TypeName::Declared(Named::Reference) => return Resolved::Broken,
            TypeName::Declared(Named::Broken { why, .. }) => {
                problems.extend(why.iter().cloned());
                return Resolved::Broken;
            }
        };
        // A structure of the text hides a built-in type of its name.
        match self.types.get_mut(token.text) {
            Some(Named::Struct(s)) => return of_struct(s),
            Some(Named::Reference) => return Resolved::Data(Type::Address(token.text.into())),
            // The first use shows the reasons, later ones refer to it.
            Some(Named::Broken { why, reported, .. }) => {
                if !*reported {
                    *reported = true;
                    problems.append(&mut why.clone());
                } else {
                    let message = format!("`{}` cannot be laid out, see above", token.text);
                    problems.push(diagnostic_at(&token, Code::BrokenType, message));
                }
                return Resolved::Broken;
            }
            None => {}
        }
        match builtin(token.text) {
            Some(Builtin::Data(ty)) => return Resolved::Data(ty),
            Some(Builtin::Opaque) => return Resolved::Opaque,
            Some(Builtin::Void) | None => {}
        }
        // The name of a structure is not in scope in its own body, so a structure that contains
        // itself is an unknown type to the rules of scope (§4.2.2).
        problems.push(if token.text == owner.text {
            let message = format!("structure `{}` contains itself", token.text);
            diagnostic_at(&token, Code::RecursiveStruct, message)
                .with_note("its size would be infinite")
        } else {
            self.unknown_type(&token)
        });
        Resolved::Broken
    }

    pub(in crate::syntax::glsl) fn unknown_type(&self, token: &Token<'a>) -> Diagnostic {
        let message = format!("unknown type `{}`", token.text);
        let known = self.types.keys().copied().chain(COMMON_TYPES.iter().copied());
        let help =
            suggestion(token.text, known).unwrap_or_else(|| match self.parser.misses_include() {
                true => "an include that is not found may declare it".to_string(),
                false => "declare a structure before its use".to_string(),
            });
        diagnostic_at(token, Code::UnknownType, message).with_help(help)
    }
}

/// A structure that holds only handles is a handle itself.
fn of_struct(s: &Arc<Struct>) -> Resolved {
    if s.members.is_empty() { Resolved::Opaque } else { Resolved::Data(Type::Struct(s.clone())) }
}

/// Suggestions for misspelt names of types.
pub(in crate::syntax::glsl) const COMMON_TYPES: &[&str] = &[
    "float",
    "int",
    "uint",
    "bool",
    "double",
    "vec2",
    "vec3",
    "vec4",
    "ivec2",
    "ivec3",
    "ivec4",
    "uvec2",
    "uvec3",
    "uvec4",
    "mat2",
    "mat3",
    "mat4",
    "sampler2D",
    "samplerCube",
];
