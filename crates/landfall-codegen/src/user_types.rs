//! The program's own types for types and members of shaders: `vec3`, `PointLight.position`.

use std::cell::RefCell;
use std::sync::Arc;

use rustc_hash::FxHashSet;

use landfall_layout::diagnostic::{Code, Diagnostic, Severity};
use landfall_layout::layout::MemberLayout;
use landfall_layout::shape::Type;
use landfall_layout::source::Language;

/// What a type is called in the language of an output, for messages.
pub(super) struct Spelling {
    pub(super) what: &'static str,
    pub(super) help: &'static str,
}

pub(super) const RUST: Spelling = Spelling {
    what: "path in Rust",
    help: "write a path such as `crate::engine::Pos3` or `nalgebra::Vector3<f32>`",
};

pub(super) const C: Spelling =
    Spelling { what: "type in C or C++", help: "write a name such as `Vec3` or `glm::vec3`" };

/// The types, and which of them were used.
#[derive(Debug, Default)]
pub(super) struct UserTypes {
    /// What has a type of the program, and its name there.
    all: Vec<(String, Arc<str>)>,
    /// How many of them, from the first, are for something in these shaders.
    needed: usize,
    used: RefCell<FxHashSet<usize>>,
}

impl UserTypes {
    /// Reads the types of these options and of the project; one that is no type in the language of
    /// the output is reported and left out.
    pub(super) fn new(
        given: &[(String, String)],
        project: &[(String, String)],
        spelling: &Spelling,
    ) -> (UserTypes, Vec<Diagnostic>) {
        let all = given.iter().chain(project);
        let (good, bad): (Vec<_>, Vec<_>) = all.partition(|(_, path)| is_type(path));
        let bad = bad.into_iter().map(|(of, path)| {
            let message =
                format!("`{of}` cannot have the type `{path}`: it is no {}", spelling.what);
            Diagnostic::without_place(Code::BadName, Severity::Error, message)
                .with_help(spelling.help)
        });
        let needed = good.len().min(given.len());
        let all = good.into_iter().map(|(of, path)| (of.clone(), path.as_str().into())).collect();
        (UserTypes { all, needed, used: RefCell::default() }, bad.collect())
    }

    /// The type of a member of the structure or block `owner`: by its name, or by its shader type.
    pub(super) fn of(&self, owner: &str, member: &MemberLayout) -> Option<Arc<str>> {
        // A member by its name comes before all members of a type.
        let named = |of: &str| of.split_once('.') == Some((owner, &*member.name));
        self.find(named).or_else(|| {
            let ty = member.ty.innermost();
            // A type for `mat3` holds columns.
            let is_by_rows = matches!(ty, Type::Matrix { .. }) && member.row_major;
            let spelled = |language| ty.spelled(language).to_string();
            let (glsl, wgsl) = (spelled(Language::Glsl), spelled(Language::Wgsl));
            self.find(|of| !is_by_rows && (of == glsl || whole_name(of) == wgsl))
        })
    }

    fn find(&self, is: impl Fn(&str) -> bool) -> Option<Arc<str>> {
        let at = self.all.iter().position(|(of, _)| is(of))?;
        self.used.borrow_mut().insert(at);
        Some(self.all[at].1.clone())
    }

    /// A warning for each type that nothing was found for.
    pub(super) fn unused(&self) -> Vec<Diagnostic> {
        let used = self.used.borrow();
        let rows = self.all[..self.needed].iter().enumerate();
        rows.filter(|(at, _)| !used.contains(at))
            .map(|(_, (of, _))| {
                let message = format!("the type for `{of}` has no effect: no member is one");
                Diagnostic::without_place(Code::UnusedOption, Severity::Warning, message)
                    .with_help("write a type as the shader spells it, or `STRUCTURE.MEMBER`")
            })
            .collect()
    }
}

/// A type of WGSL without its predeclared alias (WGSL §6.9): `vec3<f32>` for `vec3f`.
fn whole_name(of: &str) -> String {
    let of: String = of.split_whitespace().collect();
    let scalar = match of.as_bytes().last() {
        Some(b'f') => "f32",
        Some(b'h') => "f16",
        Some(b'i') => "i32",
        Some(b'u') => "u32",
        Some(_) | None => return of,
    };
    let dims = |count: &[u8]| count.iter().all(|digit| (b'2'..=b'4').contains(digit));
    match &of.as_bytes()[..of.len() - 1] {
        [b'v', b'e', b'c', n] if dims(&[*n]) => format!("vec{}<{scalar}>", char::from(*n)),
        [b'm', b'a', b't', c, b'x', r] if dims(&[*c, *r]) && scalar.starts_with('f') => {
            format!("mat{}x{}<{scalar}>", char::from(*c), char::from(*r))
        }
        _ => of,
    }
}

/// Whether a text is a path with generic arguments, and nothing that could end it.
pub(super) fn is_type(text: &str) -> bool {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "_:<>, ".contains(c);
    let mut depth = 0i32;
    // Separators stand between generic arguments alone: `A B` is no type, and `A, B` are two.
    let balanced = text.chars().all(|c| {
        depth += i32::from(c == '<') - i32::from(c == '>');
        depth >= 0 && (depth > 0 || !matches!(c, ',' | ' '))
    });
    let mut parts = text.split(['<', '>', ',', ' ']).filter(|part| !part.is_empty());
    let named = |name: &str| {
        name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && !name.contains(':')
    };
    // `3` is an argument for a constant.
    let is_part = |part: &str| {
        part.bytes().all(|c| c.is_ascii_digit())
            || part.strip_prefix("::").unwrap_or(part).split("::").all(named)
    };
    text.chars().all(allowed)
        && text.starts_with(|c: char| !c.is_ascii_digit() && c != '<')
        && balanced
        && depth == 0
        && parts.all(is_part)
        && !text.is_empty()
}

#[cfg(test)]
mod tests {
    use super::is_type;

    #[test]
    fn a_type_is_a_path_and_ends_nothing() {
        for good in ["crate::Pos", "::a::B", "na::SVector<f32, 3>", "u32", "A<B<C>, 4>"] {
            assert!(is_type(good), "{good}");
        }
        for bad in ["", "3", "a b", "A>", "A<B", "A;", "a::", "A, B", "A: B", "fn()", "<A>", "A{}"]
        {
            assert!(!is_type(bad), "{bad}");
        }
    }
}
