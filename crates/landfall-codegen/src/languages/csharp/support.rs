//! The types that members need: vectors, matrices, booleans of 32 bits, and the class of checks.

use std::fmt::Write as _;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::c::names::identifier_part;
use crate::model::{Matrix, Model, free};
use crate::scalar_names::ScalarNames;
use landfall_layout::shape::{Scalar, ScalarKind};

const SCALARS: ScalarNames = ScalarNames {
    sint: ["sbyte", "short", "int", "long"],
    uint: ["byte", "ushort", "uint", "ulong"],
    float: ["", "", "float", "double"],
};

/// Their parts of the names of vectors and matrices.
const WORDS: ScalarNames = ScalarNames {
    sint: ["SByte", "Short", "Int", "Long"],
    uint: ["Byte", "UShort", "UInt", "ULong"],
    float: ["", "", "Float", "Double"],
};

fn word(scalar: Scalar) -> &'static str {
    if scalar.kind == ScalarKind::Bool { "Bool" } else { WORDS.of(scalar) }
}

/// The types used so far.
pub(super) struct Support {
    prefix: String,
    taken: FxHashSet<String>,
    check: String,
    /// The name of each type by its preferred name.
    names: FxHashMap<String, String>,
    text: String,
}

impl Support {
    pub fn new(model: &Model, prefix: &str) -> Support {
        // Names of structures first: what the members need keeps clear of them.
        let mut taken: FxHashSet<String> =
            model.structures.iter().map(|structure| structure.name.clone()).collect();
        let prefix = identifier_part(prefix);
        let check = free(format!("{prefix}Layouts"), &mut taken);
        let mut text = format!(
            "
// Checks of layouts and indices.
public static class {check}
{{
    // Throws if a size or offset of a structure is not the shader's.
    public static void Check()
    {{
"
        );
        // A block of a runtime-sized array alone is a static class, without a check.
        for structure in model.structures.iter().filter(|structure| structure.size > 0) {
            let _ = writeln!(text, "        {}.Check();", structure.name);
        }
        text.push_str(
            "    }

    internal static void Same(string what, int actual, int expected)
    {
        if (actual != expected)
        {
            throw new InvalidOperationException(
                what + \" is \" + actual + \", in the shader \" + expected);
        }
    }

    internal static long Index(long i, long n)
    {
        if (i < 0 || i >= n)
        {
            throw new IndexOutOfRangeException(\"index \" + i + \" is not below \" + n);
        }
        return i;
    }
}
",
        );
        Support { prefix, taken, check, names: FxHashMap::default(), text }
    }

    /// The name of the class of the shaders' constants.
    pub fn constants_class(&mut self) -> String {
        free(format!("{}Constants", self.prefix), &mut self.taken)
    }

    /// The class of checks, by a name that no member hides.
    pub fn check(&self) -> String {
        format!("global::{}", self.check)
    }

    pub fn text(self) -> String {
        self.text
    }

    /// The type of a scalar.
    pub fn scalar(&mut self, scalar: Scalar) -> String {
        if scalar.kind != ScalarKind::Bool {
            return SCALARS.of(scalar).to_string();
        }
        self.named("Bool32", |name| {
            format!(
                "
// A `bool` of a buffer: 32 bits, 0 or 1.
[StructLayout(LayoutKind.Sequential, Pack = 1, Size = 4)]
public struct {name}
{{
    public uint Bits;

    public static implicit operator {name}(bool value)
    {{
        return new {name} {{ Bits = value ? 1u : 0u }};
    }}

    public static implicit operator bool({name} value)
    {{
        return value.Bits != 0;
    }}
}}
"
            )
        })
    }

    /// The type of a vector: fields `X`, `Y`, `Z` and `W`.
    pub fn vector(&mut self, scalar: Scalar, rows: u8) -> String {
        let part = self.scalar(scalar);
        let fields = &["X", "Y", "Z", "W"][..usize::from(rows)];
        let parameters: Vec<String> =
            fields.iter().map(|field| format!("{part} {}", field.to_lowercase())).collect();
        let sets: String = fields
            .iter()
            .map(|field| format!("        {field} = {};\n", field.to_lowercase()))
            .collect();
        let declared = fields.join(", ");
        self.named(&format!("{}{rows}", word(scalar)), |name| {
            format!(
                "
[StructLayout(LayoutKind.Sequential, Pack = 1)]
public struct {name}
{{
    public {part} {declared};

    public {name}({})
    {{
{sets}    }}
}}
",
                parameters.join(", ")
            )
        })
    }

    /// The type of a matrix, with an indexer by column and row.
    pub fn matrix(&mut self, matrix: Matrix) -> String {
        let Matrix { scalar, columns, rows, stride, row_major } = matrix;
        let (part, word) = (SCALARS.of(scalar), word(scalar));
        let order = if row_major { "Rows" } else { "" };
        let size = stride * u64::from(matrix.stored().0);
        let (vector, lane) = if row_major { ("row", "column") } else { ("column", "row") };
        let (check, width) = (self.check(), scalar.width);
        // In memory: vector by vector, and within it component by component.
        let place = format!("{vector}Place * {stride} + {lane}Place * {width}");
        let body = |statement: &str, name: &str| {
            format!(
                "        {{
            long columnPlace = {check}.Index(column, {columns}), rowPlace = {check}.Index(row, {rows});
            fixed ({name}* self = &this)
            {{
                {statement}
            }}
        }}
"
            )
        };
        self.named(&format!("{word}{columns}x{rows}Stride{stride}{order}"), |name| {
            let at = format!("*({part}*)((byte*)self + {place})");
            let get = body(&format!("return {at};"), name);
            let set = body(&format!("{at} = value;"), name);
            format!(
                "
// {columns} columns of {rows} rows, {stride} bytes from one {vector} to the next.
[StructLayout(LayoutKind.Sequential, Pack = 1, Size = {size})]
public unsafe struct {name}
{{
    public {part} this[int column, int row]
    {{
        get
{get}        set
{set}    }}
}}
"
            )
        })
    }

    /// The name of a type; `print` returns its text, which is added once.
    fn named(&mut self, preferred: &str, print: impl Fn(&str) -> String) -> String {
        if let Some(known) = self.names.get(preferred) {
            return known.clone();
        }
        let name = free(format!("{}{preferred}", self.prefix), &mut self.taken);
        self.text.push_str(&print(&name));
        self.names.insert(preferred.to_string(), name.clone());
        name
    }
}
