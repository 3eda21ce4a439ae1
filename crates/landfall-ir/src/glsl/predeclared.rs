//! Built-in variables and constants: `gl_Position`, `gl_FragCoord`, `gl_MaxDrawBuffers`.

use naga::BuiltIn;

use super::ast::{Declarator, Qualifiers};
use super::constant::Const;
use super::globals::Global;
use super::io::StageVariable;
use super::types::{Kind, Ty};
use super::{Help, Lowerer, Lowering, refuse};
use landfall_layout::source::{Span, Stage};

/// A built-in variable: name, stage, whether it is an output, its type, and naga's built-in.
type Row = (&'static str, Stage, bool, Ty, BuiltIn);

/// Built once for each look-up: few names of a shader are built-ins.
fn rows() -> Vec<Row> {
    use BuiltIn as B;
    use Stage::{Compute, Fragment, Vertex};
    let vec = |size| Ty::Vector(Kind::Float, size);
    let uvec3 = || Ty::Vector(Kind::Uint, 3);
    let position = B::Position { invariant: false };
    vec![
        ("gl_VertexID", Vertex, false, Ty::INT, B::VertexIndex),
        ("gl_VertexIndex", Vertex, false, Ty::INT, B::VertexIndex),
        ("gl_InstanceID", Vertex, false, Ty::INT, B::InstanceIndex),
        ("gl_InstanceIndex", Vertex, false, Ty::INT, B::InstanceIndex),
        ("gl_BaseVertex", Vertex, false, Ty::INT, B::BaseVertex),
        ("gl_BaseVertexARB", Vertex, false, Ty::INT, B::BaseVertex),
        ("gl_BaseInstance", Vertex, false, Ty::INT, B::BaseInstance),
        ("gl_BaseInstanceARB", Vertex, false, Ty::INT, B::BaseInstance),
        ("gl_DrawID", Vertex, false, Ty::INT, B::DrawIndex),
        ("gl_DrawIDARB", Vertex, false, Ty::INT, B::DrawIndex),
        ("gl_ViewIndex", Vertex, false, Ty::INT, B::ViewIndex),
        ("gl_Position", Vertex, true, vec(4), position),
        ("gl_PointSize", Vertex, true, Ty::FLOAT, B::PointSize),
        ("gl_ClipDistance", Vertex, true, Ty::FLOAT, B::ClipDistances),
        ("gl_CullDistance", Vertex, true, Ty::FLOAT, B::CullDistance),
        ("gl_FragCoord", Fragment, false, vec(4), position),
        ("gl_FrontFacing", Fragment, false, Ty::BOOL, B::FrontFacing),
        ("gl_PointCoord", Fragment, false, vec(2), B::PointCoord),
        ("gl_PrimitiveID", Fragment, false, Ty::INT, B::PrimitiveIndex),
        ("gl_SampleID", Fragment, false, Ty::INT, B::SampleIndex),
        ("gl_SampleMaskIn", Fragment, false, Ty::INT, B::SampleMask),
        ("gl_SampleMask", Fragment, true, Ty::INT, B::SampleMask),
        ("gl_ViewIndex", Fragment, false, Ty::INT, B::ViewIndex),
        ("gl_FragDepth", Fragment, true, Ty::FLOAT, B::FragDepth),
        ("gl_FragDepthEXT", Fragment, true, Ty::FLOAT, B::FragDepth),
        ("gl_GlobalInvocationID", Compute, false, uvec3(), B::GlobalInvocationId),
        ("gl_LocalInvocationID", Compute, false, uvec3(), B::LocalInvocationId),
        ("gl_WorkGroupID", Compute, false, uvec3(), B::WorkGroupId),
        ("gl_NumWorkGroups", Compute, false, uvec3(), B::NumWorkGroups),
        ("gl_LocalInvocationIndex", Compute, false, Ty::UINT, B::LocalInvocationIndex),
        ("gl_NumSubgroups", Compute, false, Ty::UINT, B::NumSubgroups),
        ("gl_BaryCoordEXT", Fragment, false, vec(3), B::Barycentric { perspective: true }),
        ("gl_BaryCoordNoPerspEXT", Fragment, false, vec(3), B::Barycentric { perspective: false }),
        ("gl_SubgroupInvocationID", Compute, false, Ty::UINT, B::SubgroupInvocationId),
        ("gl_SubgroupSize", Compute, false, Ty::UINT, B::SubgroupSize),
        ("gl_SubgroupID", Compute, false, Ty::UINT, B::SubgroupId),
    ]
}

/// The minimum values of built-in constants (GLSL 4.60 §7.3).
/// A shader may read them; an implementation may have more.
const NUMBERS: &[(&str, i32)] = &[
    ("gl_MaxVertexAttribs", 16),
    ("gl_MaxVertexUniformComponents", 1024),
    ("gl_MaxVertexUniformVectors", 256),
    ("gl_MaxVaryingVectors", 15),
    ("gl_MaxVaryingComponents", 60),
    ("gl_MaxVertexTextureImageUnits", 16),
    ("gl_MaxCombinedTextureImageUnits", 96),
    ("gl_MaxTextureImageUnits", 16),
    ("gl_MaxTextureUnits", 2),
    ("gl_MaxTextureCoords", 8),
    ("gl_MaxFragmentUniformComponents", 1024),
    ("gl_MaxFragmentUniformVectors", 256),
    ("gl_MaxDrawBuffers", 8),
    ("gl_MaxClipDistances", 8),
    ("gl_MaxClipPlanes", 8),
    ("gl_MaxLights", 8),
];

/// The inputs of the fixed-function pipeline (GLSL 1.20 §7.3), lowered to ordinary inputs.
fn fixed_input(name: &str) -> Option<Ty> {
    Some(match name {
        "gl_Vertex" | "gl_Color" | "gl_SecondaryColor" => Ty::Vector(Kind::Float, 4),
        "gl_Normal" => Ty::Vector(Kind::Float, 3),
        "gl_FogCoord" => Ty::FLOAT,
        _ => {
            let unit: u32 = name.strip_prefix("gl_MultiTexCoord")?.parse().ok()?;
            // OpenGL has eight sets of texture coordinates.
            return (unit < 8).then_some(Ty::Vector(Kind::Float, 4));
        }
    })
}

impl<'a> Lowerer<'a> {
    /// `out float gl_ClipDistance[2];`
    pub fn redeclared(&mut self, declarator: &Declarator<'a>) {
        // A redeclaration with a size: `gl_ClipDistance` has no size otherwise (GLSL 4.60 §7.1).
        if let Some(size) = declarator.dims.first().and_then(|dim| dim.size.as_ref()) {
            if let Some(size) = self.constant(size).and_then(|c| u32::try_from(c.integer()?).ok()) {
                self.sizes.insert(declarator.name.text, size);
            }
        }
    }

    pub fn language_constant(&self, name: &str) -> Option<Const> {
        if name == "gl_WorkGroupSize" {
            let [x, y, z] = self.workgroup_size.map(Const::Uint);
            return Some(Const::List(vec![x, y, z]));
        }
        let found = NUMBERS.iter().find(|row| row.0 == name)?;
        Some(Const::Int(found.1))
    }

    /// Returns a built-in variable, created at its first use.
    pub fn predeclared(&mut self, name: &str, span: Span) -> Lowering<Option<usize>> {
        if !name.starts_with("gl_") {
            return Ok(None);
        }
        if let Some(&known) = self.predeclared.get(name) {
            return Ok(Some(known));
        }
        let made = self.make_predeclared(name, span)?;
        if let Some(global) = made {
            self.globals.push(global);
            self.predeclared.insert(name.to_string(), self.globals.len() - 1);
            return Ok(Some(self.globals.len() - 1));
        }
        Ok(None)
    }

    fn make_predeclared(&mut self, name: &str, span: Span) -> Lowering<Option<Global<'a>>> {
        // Texts without a stage are fragments of one: of the built-ins of either stage, the
        // fragment's.
        let stage = self.stage.unwrap_or(Stage::Fragment);
        let plain = Qualifiers::default();
        if let Some(row) = rows().into_iter().find(|row| row.0 == name && row.1 == stage) {
            let (_, _, output, mut ty, builtin) = row;
            let mask = builtin == BuiltIn::SampleMask;
            if mask || matches!(builtin, BuiltIn::ClipDistances | BuiltIn::CullDistance) {
                // Arrays without a redeclared size have the least that implementations offer.
                let size = self.sizes.get(name).copied().unwrap_or(if mask { 1 } else { 8 });
                ty = Ty::Array(ty.into(), Some(size));
            }
            let handle = self.private(name, &ty, span)?;
            self.io.push(StageVariable::new(name, handle, ty.clone(), &plain, output).is(builtin));
            return Ok(Some(Global::Variable { handle, ty, writable: output }));
        }
        let vec4 = Ty::Vector(Kind::Float, 4);
        // GLSL 1.20's outputs, and its vertex attributes, are ordinary inputs and outputs here.
        let (ty, output) = match (name, stage) {
            ("gl_FragColor", Stage::Fragment) => (vec4, true),
            ("gl_FragData", Stage::Fragment) => {
                let size = self.sizes.get(name).copied().unwrap_or(8);
                (Ty::Array(vec4.into(), Some(size)), true)
            }
            (_, Stage::Vertex) if fixed_input(name).is_some() => {
                (fixed_input(name).unwrap_or(vec4), false)
            }
            _ => return Err(unknown(name, span, stage)),
        };
        let handle = self.private(name, &ty, span)?;
        // A shader with `gl_FragColor` has no other output at location 0.
        let location = output.then_some(0);
        self.io.push(
            StageVariable::new(name, handle, ty.clone(), &plain, output).at(location, None, span),
        );
        Ok(Some(Global::Variable { handle, ty, writable: output }))
    }
}

fn unknown(name: &str, span: Span, stage: Stage) -> Box<landfall_layout::Diagnostic> {
    let uniform = |ty: &str| {
        let own = name.trim_start_matches("gl_");
        refuse(
            span,
            format!("`{name}` is state of the fixed-function pipeline, which is not supported"),
        )
        .help(format!("declare `uniform {ty} u_{own};` and use it instead"))
    };
    if name.starts_with("gl_NormalMatrix") {
        return uniform("mat3");
    }
    if name.contains("Matrix") {
        return uniform("mat4");
    }
    let state =
        ["gl_Light", "gl_FrontMaterial", "gl_BackMaterial", "gl_Fog", "gl_Point", "gl_Depth"];
    if state.iter().any(|s| name.starts_with(s)) {
        return uniform("vec4");
    }
    let message = format!("`{name}` is not supported in a {} shader", stage.name());
    refuse(span, message)
}
