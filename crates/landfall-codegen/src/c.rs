//! Layouts as a C11 and C++17 header: structures with explicit padding and static assertions
//! on their offsets, offset macros, and a table of names.
//!
//! `types` (with `plain`) maps members to C types and keeps each structure once, `structs`
//! writes them, `table` writes the macros and table of a block, `names` makes C identifiers, and
//! `prelude` is the text all headers share.

pub(super) mod comments;
pub(super) mod names;
mod plain;
mod prelude;
mod structs;
mod table;
mod types;

use landfall_layout::diagnostic::{Code, Severity};
use landfall_layout::layout::BlockLayout;
use landfall_layout::{Diagnostic, ShaderLayout};
use names::Names;
use types::Types;

use crate::refusal::{Refusal, blocks, length_constants};
use crate::user_types::{self, UserTypes};

/// Options of the C header.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct COptions {
    /// The header's file name, from which its include guard is made: `lights.h`.
    pub file: String,
    /// The prefix of every type, macro and function: `engine_` gives `engine_PointLight`
    /// and `ENGINE_POINT_LIGHT_BLOCK_SIZE`.
    pub prefix: String,
    /// The namespace of types and functions in C++: `engine::gpu`. Macros are outside of it.
    pub namespace: String,
    /// The types of vectors and matrices.
    pub vectors: CVectors,
    /// Types of the program for a type (`vec3`) or a member (`Light.position`): `Vec3`,
    /// `engine::Vec3`.
    pub types: Vec<(String, String)>,
    /// The same of a project, of which those for other shaders are no mistake.
    pub project_types: Vec<(String, String)>,
    /// Headers that the header includes, such as those of these types: `engine/math.h`, `<glm/glm.hpp>`.
    pub includes: Vec<String>,
}

impl CVectors {
    /// The name in `--vectors`.
    pub fn name(self) -> &'static str {
        match self {
            CVectors::Array => "array",
            CVectors::Glm => "glm",
        }
    }

    /// The variant with this name.
    pub fn from_name(name: &str) -> Option<CVectors> {
        [CVectors::Array, CVectors::Glm].into_iter().find(|vectors| vectors.name() == name)
    }
}

/// The types of vectors and matrices in C and C++.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum CVectors {
    /// `float position[3]`.
    #[default]
    Array,
    /// `glm::vec3 position`, in C++ alone.
    Glm,
}

impl COptions {
    /// An error for a namespace or a header that would not compile.
    fn bad_names(&self) -> Vec<Diagnostic> {
        let is_name = |part: &str| {
            !part.starts_with(|c: char| c.is_ascii_digit())
                && !part.is_empty()
                && part.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_')
        };
        let mut bad = Vec::new();
        let mut add = |message: String, help: &str| {
            let found = Diagnostic::without_place(Code::BadName, Severity::Error, message);
            bad.push(found.with_help(help));
        };
        if !self.namespace.is_empty() && !self.namespace.split("::").all(is_name) {
            let message = format!("`{}` is no namespace in C++", self.namespace);
            add(message, "write names with `::` between them, such as `engine::gpu`");
        }
        for header in self.includes.iter().filter(|header| include(header).is_none()) {
            let message = format!("`{header}` cannot be included");
            add(message, "write a header such as `engine/math.h` or `<glm/glm.hpp>`");
        }
        bad
    }
}

/// The directive that includes a header, if it has a name that can stand there.
pub(crate) fn include(header: &str) -> Option<String> {
    let angled = header.strip_prefix('<').and_then(|rest| rest.strip_suffix('>'));
    let name = angled.unwrap_or(header);
    // What would end the name, or has a meaning of its own in it.
    let ends = |c: char| c.is_control() || matches!(c, '"' | '<' | '>' | '\\');
    let is_name = !name.is_empty() && !name.contains(ends);
    is_name.then(|| match angled {
        Some(_) => format!("#include {header}\n"),
        None => format!("#include \"{header}\"\n"),
    })
}

/// A header, and the diagnostics of the blocks it leaves out.
#[derive(Clone, Debug)]
pub struct COutput {
    /// The text of the header.
    pub text: String,
    /// One error for every block that no C structure can mirror; `text` holds the others. Errors
    /// for names that are none, and warnings for types that no member has.
    pub diagnostics: Vec<Diagnostic>,
}

/// Writes one header for the blocks of `shaders`. Skips loose uniforms, which have no offsets;
/// lay the shader out with `gather` to include them.
pub fn c(shaders: &[&ShaderLayout], options: &COptions) -> COutput {
    let mut names = Names::new(&options.prefix, shaders);
    let (user, bad) = UserTypes::new(&options.types, &options.project_types, &user_types::C);
    let mut types = Types::new(user, options.vectors == CVectors::Glm);
    let mut sections: Vec<table::Section> = Vec::new();
    let mut earlier = table::Earlier::default();
    let mut diagnostics = bad;
    diagnostics.extend(options.bad_names());
    for (shader, block) in blocks(shaders) {
        // A block that is refused leaves no structure behind, in which a later block could find
        // itself.
        let mark = types.structs.len();
        match check(block).and_then(|()| types.block(block, shader, &mut names)) {
            Ok(mirror) => {
                // A block that several shaders declare alike has one section.
                sections.extend(table::section(block, shader, &mirror, &mut earlier, &mut names));
            }
            Err(refusal) => {
                types.roll_back(mark, &mut names);
                diagnostics.push(refusal.diagnostic(Code::NoCMirror, "C header", block, shader));
            }
        }
    }
    diagnostics.extend(types.user.unused());
    // The constant of an enumeration is an `int`.
    let constants = length_constants(shaders, |name| names.upper(name)).into_iter();
    let constants = constants.filter_map(|(name, value)| Some((name, i32::try_from(value).ok()?)));
    let constants: Vec<_> = constants.filter(|(name, _)| names.global.claim_free(name)).collect();
    let text = structs::header(shaders, options, &types, &sections, &constants, &names);
    COutput { text, diagnostics }
}

/// Checks for blocks that C cannot mirror: no layout, override-sized arrays, too many dimensions.
fn check(block: &BlockLayout) -> Result<(), Refusal> {
    Refusal::check(block)?;
    for leaf in &block.leaves {
        if leaf.dims.len() > table::MAX_DIMS {
            let why = format!(
                "`{}` has {} array dimensions, the header's table holds {}",
                leaf.path,
                leaf.dims.len(),
                table::MAX_DIMS
            );
            return Err(Refusal { span: leaf.span, why });
        }
    }
    Ok(())
}
