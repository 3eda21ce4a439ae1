//! Layouts as buffer formats of RenderDoc: the text that its buffer viewer takes, one for each block.
//!
//! Every member has its offset and every structure its size. `#pack` is that of the block's rules, so
//! that arrays and matrices mostly have their strides; where RenderDoc would give another one, and for
//! arrays in arrays, which it does not have, an element is a structure of that size.

use std::fmt::Write as _;

use rustc_hash::FxHashSet;

use crate::assertions;
use crate::language::{CodeOptions, CodeOutput, OutputLanguage};
use crate::model::{
    Element, Matrix, Member, Model, Naming, Placement, Structure, comment, free, header,
};
use crate::scalar_names::ScalarNames;
use landfall_layout::ShaderLayout;
use landfall_layout::shape::{Rules, Scalar, ScalarKind};

/// Buffer formats of RenderDoc.
pub const RENDERDOC: OutputLanguage = OutputLanguage {
    name: "renderdoc",
    title: "RenderDoc",
    about: "Formats for RenderDoc's buffer viewer, one for each block",
    options: &["--prefix"],
    write,
    assert: assertions::none,
};

const NAMING: Naming = Naming {
    reserved: "struct enum unsigned signed rgb row_major column_major uintten unormten floateleven \
        unormh unormb snormh snormb char",
    types: "",
    members: "",
    is_reserved: |name| {
        // `float`, `xint3`, `uint16_t`, `mat4x3`.
        let of = name.trim_end_matches(|c: char| c.is_ascii_digit() || c == 'x');
        let of = of.trim_end_matches("_t").trim_end_matches(|c: char| c.is_ascii_digit());
        let scalars = ["byte", "short", "int", "long"];
        let of = of.strip_prefix(['u', 'x']).filter(|rest| scalars.contains(rest)).unwrap_or(of);
        let vectors = ["vec", "uvec", "ivec", "dvec", "mat", "umat", "imat", "dmat"];
        let others = ["bool", "half", "float", "double"];
        scalars.contains(&of) || vectors.contains(&of) || others.contains(&of)
    },
};

const SCALARS: ScalarNames = ScalarNames {
    sint: ["byte", "short", "int", "long"],
    uint: ["ubyte", "ushort", "uint", "ulong"],
    float: ["", "half", "float", "double"],
};

fn write(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    let model = Model::new(shaders, NAMING, &options.prefix, Placement::Offsets, RENDERDOC.title);
    let blocks: Vec<usize> =
        (0..model.structures.len()).filter(|at| model.structures[*at].is_block).collect();
    let note = match blocks.len() {
        0 | 1 => "For the buffer viewer of RenderDoc 1.22 or later.",
        _ => "For the buffer viewer of RenderDoc 1.22 or later: paste the format of one block.",
    };
    let mut text = header(shaders, "//", &[note]);
    for at in blocks {
        let mut format = Format::new(&model, at);
        format.root(at);
        text.push_str(&format.text);
    }
    CodeOutput { text, diagnostics: model.diagnostics }
}

/// How RenderDoc packs what follows.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pack {
    Std140,
    Std430,
    Scalar,
}

impl Pack {
    fn from_rules(rules: Rules) -> Pack {
        match rules {
            Rules::Std140 => Pack::Std140,
            // Strides of WGSL are those of std430.
            Rules::Std430 | Rules::Wgsl => Pack::Std430,
            // The least strict: offsets and sizes say the rest.
            Rules::Scalar | Rules::Explicit(_) => Pack::Scalar,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Pack::Std140 => "std140",
            Pack::Std430 => "std430",
            Pack::Scalar => "scalar",
        }
    }

    /// The distance of vectors in an array or a matrix.
    fn stride(self, width: u8, components: u8) -> u64 {
        let aligned = match components {
            1 => 1,
            2 => 2,
            _ => 4,
        };
        match self {
            Pack::Std140 => (u64::from(width) * aligned).max(16),
            Pack::Std430 => u64::from(width) * aligned,
            Pack::Scalar => u64::from(width) * u64::from(components),
        }
    }
}

/// The format of one block.
struct Format<'m> {
    model: &'m Model,
    text: String,
    pack: Pack,
    /// The `#pack` that was written last.
    written: Option<Pack>,
    /// The structures that stand in the text, or are to come behind what they point to.
    done: Vec<usize>,
    open: Vec<usize>,
    names: FxHashSet<String>,
}

impl<'m> Format<'m> {
    fn new(model: &'m Model, root: usize) -> Format<'m> {
        let names = model.structures.iter().map(|structure| structure.name.clone()).collect();
        let pack = Pack::from_rules(model.structures[root].rules);
        let (done, open) = (Vec::new(), Vec::new());
        Format { model, text: String::new(), pack, written: None, done, open, names }
    }

    /// Writes the block, behind the structures that it uses.
    fn root(&mut self, at: usize) {
        let structure = &self.model.structures[at];
        let _ = writeln!(self.text, "\n// ---- {}", structure.about());
        self.structure(at, true);
    }

    fn structure(&mut self, at: usize, is_root: bool) {
        if self.done.contains(&at) {
            return;
        }
        self.open.push(at);
        let structure = &self.model.structures[at];
        let mut body = String::new();
        // What the members need is written first, each structure behind those that it holds.
        for (member, runtime) in structure.all_members() {
            self.member(structure, member, runtime, &mut body);
        }
        self.packing();
        comment("//", &structure.comment, "", &mut self.text);
        // A format that ends in a runtime-sized array has no size.
        if structure.tail.is_none() {
            let single = if is_root { "[[single]]\n" } else { "" };
            let _ = writeln!(self.text, "{single}[[size({})]]", self.size(structure));
        }
        let _ = writeln!(self.text, "struct {} {{\n{body}}};", structure.name);
        self.open.pop();
        self.done.push(at);
    }

    /// The bytes that RenderDoc gives a structure: not less than up to the alignment of its scalars.
    fn size(&self, structure: &Structure) -> u64 {
        structure.size.next_multiple_of(self.scalar_align(structure))
    }

    fn scalar_align(&self, structure: &Structure) -> u64 {
        let of = |member: &Member| match member.ty.element {
            Element::Structure(at) => self.scalar_align(&self.model.structures[at]),
            Element::Scalar(scalar)
            | Element::Vector { scalar, .. }
            | Element::Matrix(Matrix { scalar, .. }) => scalar.width.into(),
        };
        structure.members.iter().map(of).max().unwrap_or(1)
    }

    fn packing(&mut self) {
        if self.written != Some(self.pack) {
            let _ = writeln!(self.text, "#pack({})", self.pack.name());
            self.written = Some(self.pack);
        }
    }

    /// Writes a structure of one member that pads an element to a size; returns its name.
    fn padded(&mut self, owner: &str, member: &str, size: u64, element: &str) -> String {
        let name = free(format!("{owner}_{member}"), &mut self.names);
        self.packing();
        let _ = writeln!(self.text, "[[size({size})]]\nstruct {name} {{\n    {element};\n}};");
        name
    }

    fn member(
        &mut self,
        structure: &Structure,
        member: &Member,
        tail: Option<u64>,
        body: &mut String,
    ) {
        let Member { name, ty, offset, .. } = member;
        let (mut spelled, mut stride, mut attributes) = self.element(structure, member);
        let mut matrix = None;
        if let Element::Matrix(of) = ty.element {
            let (count, components) = of.stored();
            // RenderDoc would put the vectors elsewhere: each becomes a structure of the size of
            // the stride.
            if self.pack.stride(of.scalar.width, components) != of.stride {
                // A vector of it is an element.
                let vector = format!("{} value", vector(of.scalar, components));
                spelled =
                    self.padded(&structure.name, &format!("{name}_vector"), of.stride, &vector);
                stride = of.stride;
                attributes = "";
                matrix = Some((u64::from(count), of.stride));
            }
        }
        let sized = ty.dims.iter().map(|dim| (Some(dim.len), dim.stride));
        let of_member = tail.map(|stride| (None, stride)).into_iter().chain(sized);
        let dims: Vec<(Option<u64>, u64)> =
            of_member.chain(matrix.map(|(count, stride)| (Some(count), stride))).collect();
        let mut length = String::new();
        // From the innermost dimension outwards, as RenderDoc has arrays of one dimension.
        for (at, (len, wanted)) in dims.iter().enumerate().rev() {
            if !length.is_empty() {
                // An array in an array.
                let element = format!("{attributes}{spelled} elements{length}");
                let size = dims[at].1;
                spelled = self.padded(&structure.name, &format!("{name}_row"), size, &element);
                attributes = "";
            } else if stride != *wanted {
                let element = format!("{attributes}{spelled} value");
                spelled =
                    self.padded(&structure.name, &format!("{name}_element"), *wanted, &element);
                attributes = "";
            }
            length = len.map_or("[]".to_string(), |len| format!("[{len}]"));
        }
        comment("//", &member.comment, "    ", body);
        let _ = writeln!(body, "    [[offset({offset})]] {attributes}{spelled} {name}{length};");
    }

    /// The type of an element, the stride that RenderDoc gives it in an array, and what it is annotated
    /// with.
    fn element(&mut self, structure: &Structure, member: &Member) -> (String, u64, &'static str) {
        match member.ty.element {
            Element::Structure(at) => {
                self.structure(at, false);
                let of = &self.model.structures[at];
                (of.name.clone(), self.size(of), "")
            }
            Element::Scalar(of) => match self.pointer(structure, member) {
                Some(at) => (format!("{} *", self.model.structures[at].name), 8, ""),
                None => (vector(of, 1), self.pack.stride(of.width, 1), ""),
            },
            Element::Vector { scalar, rows } => {
                (vector(scalar, rows), self.pack.stride(scalar.width, rows), "")
            }
            Element::Matrix(of) => {
                let (count, components) = of.stored();
                let stride = self.pack.stride(of.scalar.width, components) * u64::from(count);
                // As HLSL has them: rows, then columns.
                let ty = format!("{}{}x{}", scalar(of.scalar), of.rows, of.columns);
                (ty, stride, if of.row_major { "[[row_major]] " } else { "" })
            }
        }
    }

    /// The structure that an address is one of, if it can stand before the member.
    fn pointer(&mut self, structure: &Structure, member: &Member) -> Option<usize> {
        let of = member.shader_type.split('[').next().filter(|of| !of.is_empty())?;
        let at = self.model.structures.iter().position(|one| one.shader_name == of)?;
        let is_own = self.model.structures[at].name == structure.name;
        // A structure may point to itself, or to one that is being written: an address is printed
        // as such there.
        if !self.open.contains(&at) {
            let outer = std::mem::replace(
                &mut self.pack,
                Pack::from_rules(self.model.structures[at].rules),
            );
            self.structure(at, false);
            self.pack = outer;
        }
        (is_own || self.done.contains(&at)).then_some(at)
    }
}

/// A scalar or vector: `vec3`, `half2`, `ulong`.
fn vector(of: Scalar, components: u8) -> String {
    match (of.kind, of.width, components) {
        (_, _, 1) => scalar(of).to_string(),
        (ScalarKind::Float, 4, n) => format!("vec{n}"),
        (_, _, n) => format!("{}{n}", scalar(of)),
    }
}

fn scalar(of: Scalar) -> &'static str {
    if of.kind == ScalarKind::Bool { "bool" } else { SCALARS.of(of) }
}
