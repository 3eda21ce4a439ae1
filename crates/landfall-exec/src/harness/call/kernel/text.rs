//! Adapts a function for OpenGL: the user's text, ported if it has loose uniforms or is too old for
//! buffers, with the function's inputs as variables and a `main` that fills them, calls the
//! function and stores the results, once per lane.
//!
//! The stage is kept, so that stage-specific code still compiles: lanes are the pixels of a
//! fragment shader, the vertices of a vertex shader, the invocations of a compute shader.

use std::borrow::Cow;
use std::fmt::Write as _;

use super::packing::LaneWords;
use super::pieces::{ONE, Piece, WordDirection, member, moves, value_pieces};
use super::{KernelCode, LaneMap, ROW, buffer, refused};
use crate::backend::{Failure, Resource, StageCode};
use crate::harness::access;
use crate::harness::bindings as bound;
use crate::harness::call::pure::{CallPurpose, Origin, ParameterSlot, PureFunction};
use crate::harness::probe::glsl::is_sized;
use crate::harness::rewrite::{ReplacedBuiltin, RewriteTargets, Rewritten, rewritten, root};
use crate::harness::verify::{all_buffers, partner, request as texts};
use landfall_interp::ValueType;
use landfall_layout::layout;
use landfall_layout::layout::BlockLayout;
use landfall_layout::shape::{AddressSpace, ScalarKind};
use landfall_layout::source::{ExecutableStage, Language, Source, Stage};
pub use landfall_layout::syntax::glsl::raw;
use landfall_port::{Direction, PortOptions, Ported, port};

/// The blocks that hold the words, and their arrays.
const INPUTS: [&str; 2] = ["LandfallIn", "landfall_in"];
const OUTPUTS: [&str; 2] = ["LandfallOut", "landfall_out"];

/// The variables for a lane's first input and output words.
const FROM: &str = "landfall_from";
const TO: &str = "landfall_to";

/// The workgroup size if the text declares none.
const GROUP: u32 = 64;

/// Returns the code that runs a function.
pub(super) fn code(pure: &PureFunction, places: &LaneWords) -> Result<KernelCode, Failure> {
    if pure.language == Language::Wgsl {
        return Err(Failure::refused("OpenGL does not accept WGSL", ""));
    }
    let source = &pure.source;
    for block in pure.module.blocks() {
        let pushed = block.layout.space == AddressSpace::PushConstant;
        if pushed && bound::values_for_block(&pure.data, block).is_some() {
            let name = &block.layout.name;
            let message = format!("OpenGL has no push constants to hold the values of `{name}`");
            return Err(Failure::refused(message, ""));
        }
    }
    let stage = stage(pure)?;
    let user = User::new(pure)?;
    let wanted = user.wanted(pure);
    let text = rewritten(&user.text, &pure.options.read, &wanted);
    let (text, lanes) = user.finished(pure, places, text, stage)?;
    // OpenGL has neither; a specialisation constant keeps its default.
    let text = texts::without_qualifier(&texts::without_qualifier(&text, "set"), "constant_id");
    let mut stages = vec![StageCode::of_text(stage.into(), text)];
    if stage == ExecutableStage::Vertex {
        stages.push(StageCode::of_text(
            Stage::Fragment,
            partner::fragment(&user.text, &pure.options.read).text.to_string(),
        ));
    }
    let mut resources = Vec::new();
    let bytes = bound::blocks(&pure.module, &pure.data, bound::zeros)
        .map_err(|found| refused(Some(&found)))?;
    for (block, bytes) in pure.module.blocks().iter().zip(bytes) {
        // Blocks whose members are parameters have become variables.
        if wanted.blocks.contains(&user.block_name(source, &block.layout)) {
            continue;
        }
        let elements = all_buffers(&block.layout.count);
        let nth = block.element.and_then(|nth| elements.get(nth as usize));
        let name = user.block_name(source, &block.layout);
        let name = texts::gl_name(&name, nth.map_or(&[], |nth| nth.as_slice()));
        let writable = access::writable(&block.layout, &pure.files, source.language);
        let kind = bound::kind(&block.layout, bytes, writable);
        resources.push(Resource { name, group: 0, binding: 0, kind });
    }
    for handle in pure.module.handles() {
        let name = user.new_path(&handle.path);
        // The texture and the sampler of a combined one have the same path.
        if resources.iter().any(|known: &Resource| known.name == name) {
            continue;
        }
        let kind = bound::texture(bound::colour(&pure.textures, &handle.path));
        resources.push(Resource { name, group: 0, binding: 0, kind });
    }
    let buffers = [buffer(INPUTS[0], (0, 0)), buffer(OUTPUTS[0], (0, 0))];
    Ok(KernelCode { stages, resources, buffers, lanes })
}

/// Returns the stage the text is compiled for.
fn stage(pure: &PureFunction) -> Result<ExecutableStage, Failure> {
    let entry = pure.module.entry_points().first().map(|entry| entry.stage);
    // A text of functions alone runs as a compute shader.
    crate::backend::executable(pure.source.stage.or(entry).unwrap_or(Stage::Compute))
}

/// The user's text in the form for OpenGL's compiler.
struct User<'p> {
    text: Cow<'p, Source>,
    ported: Option<Ported>,
}

impl<'p> User<'p> {
    fn new(pure: &'p PureFunction) -> Result<User<'p>, Failure> {
        let source = &pure.source;
        let shader = layout(source, &pure.options);
        let head = raw::read(source, &pure.options.read);
        let loose = shader.blocks.iter().any(|block| texts::is_loose(source, block));
        // Storage blocks need GLSL 4.30.
        if !(loose || head.es || head.version < 430) {
            return Ok(User { text: Cow::Borrowed(source), ported: None });
        }
        let mut options = PortOptions::default();
        options.read = pure.options.read.clone();
        let ported = port(source, &options).map_err(|found| refused(found.first()))?;
        Ok(User { text: Cow::Owned(ported.source.clone()), ported: Some(ported) })
    }

    /// Returns the name of a path in the adapted text.
    fn new_path(&self, path: &str) -> String {
        self.ported.as_ref().map_or_else(|| path.to_string(), |ported| ported.new_path(path))
    }

    /// Returns the name of a block in the adapted text.
    fn block_name(&self, source: &Source, block: &BlockLayout) -> String {
        match &self.ported {
            Some(ported) if texts::is_loose(source, block) => {
                ported.block.clone().unwrap_or_default()
            }
            Some(_) | None => block.name.to_string(),
        }
    }

    /// Returns the inputs and blocks that become variables.
    fn wanted(&self, pure: &PureFunction) -> RewriteTargets {
        let mut wanted = RewriteTargets::default();
        for (name, ty) in &pure.inputs {
            wanted.late.push(root(&self.new_path(name)).to_string());
            if let (Some(rest), Some(ty)) = (name.strip_prefix("gl_"), builtin_type(name, ty)) {
                let own = format!("landfall_{rest}");
                wanted.builtins.push(ReplacedBuiltin { name: name.clone(), own, ty });
            }
        }
        for parameter in &pure.parameters {
            let (Origin::Block(_, name), Some(nth)) = (&parameter.origin, parameter.block) else {
                continue;
            };
            let block = &pure.module.blocks()[nth].layout;
            wanted.late.push(self.new_path(block.instance.as_deref().unwrap_or(name)));
            wanted.blocks.push(self.block_name(&pure.source, block));
        }
        // OpenGL has none of the rest; those that the function does not read stay empty.
        let pushed = pure.module.blocks().iter();
        let pushed = pushed.filter(|block| block.layout.space == AddressSpace::PushConstant);
        wanted.blocks.extend(pushed.map(|block| block.layout.name.to_string()));
        wanted
    }

    /// Returns the text with its new `main`, and the assignment of lanes.
    fn finished(
        &self,
        pure: &PureFunction,
        places: &LaneWords,
        rewritten: Rewritten,
        stage: ExecutableStage,
    ) -> Result<(String, LaneMap), Failure> {
        let mut text = rewritten.text.clone();
        let own = pure.module.entry_points().into_iter().find(|entry| entry.stage == stage.into());
        let size: u32 = own.map_or(1, |entry| entry.workgroup_size.iter().product());
        let sized = is_sized(&text);
        let (lanes, lane) = match (stage, pure.purpose) {
            (ExecutableStage::Fragment, CallPurpose::Pure) => (
                LaneMap::pixels(pure)?,
                format!("uint(gl_FragCoord.y) * {ROW}u + uint(gl_FragCoord.x)"),
            ),
            (ExecutableStage::Vertex, CallPurpose::Pure) => {
                (LaneMap::Vertices, "uint(gl_VertexID)".to_string())
            }
            // Other pixels run for the derivatives only.
            (ExecutableStage::Fragment, CallPurpose::Call) => {
                (LaneMap::pixels(pure)?, "0u".to_string())
            }
            (ExecutableStage::Vertex, CallPurpose::Call) => (LaneMap::Vertices, "0u".to_string()),
            (ExecutableStage::Compute, CallPurpose::Pure | CallPurpose::Call) => {
                let size = if sized { size } else { GROUP };
                (
                    LaneMap::Groups(size),
                    format!("gl_WorkGroupID.x * {size}u + gl_LocalInvocationIndex"),
                )
            }
        };
        if stage == ExecutableStage::Compute && !sized {
            let _ = writeln!(text, "layout(local_size_x = {GROUP}) in;");
        }
        for ([block, array], readonly) in [(INPUTS, "readonly "), (OUTPUTS, "")] {
            let _ =
                writeln!(text, "layout(std430) {readonly}buffer {block} {{ uint {array}[]; }};");
        }
        let _ = writeln!(text, "void main() {{\n    uint landfall_lane = {lane};");
        if stage == ExecutableStage::Compute && pure.purpose == CallPurpose::Call {
            // The other invocations of the user's workgroup would repeat it.
            text.push_str("    if (landfall_lane != 0u) return;\n");
        }
        // A 1 that compilers do not know.
        let length = format!("uint({}.length())", OUTPUTS[1]);
        let _ = writeln!(text, "    uint {ONE} = min({length}, 1u);");
        let (words_in, words_out) = (places.words_in, places.words_out);
        let _ = writeln!(text, "    uint {FROM} = landfall_lane * {words_in}u;");
        let _ = writeln!(text, "    uint {TO} = landfall_lane * {words_out}u;");
        self.surroundings(pure, places, &rewritten, &mut text)?;
        for assignment in &rewritten.late {
            let _ = writeln!(text, "    {assignment}");
        }
        self.call(pure, places, &mut text);
        let _ = writeln!(text, "    {}[{TO} + {}u] = 1u;", OUTPUTS[1], places.done);
        // A vertex has to have a position; the results are in a buffer.
        if stage == ExecutableStage::Vertex {
            text.push_str("    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);\n");
        }
        text.push_str("}\n");
        Ok((text, lanes))
    }

    /// Appends statements that fill inputs and blocks.
    fn surroundings(
        &self,
        pure: &PureFunction,
        places: &LaneWords,
        rewritten: &Rewritten,
        text: &mut String,
    ) -> Result<(), Failure> {
        let new = |name: &str| self.new_path(name);
        for (parameter, first) in pure.parameters.iter().zip(&places.parameters) {
            let (place, pieces) = match &parameter.origin {
                Origin::Argument(_) => continue,
                Origin::Input => match builtin_type(&parameter.path, &parameter.ty) {
                    // Signed in GLSL, whatever type the module has.
                    Some("int") => {
                        let name = parameter.path.replacen("gl_", "landfall_", 1);
                        let value = format!("int({}[{FROM} + {first}u])", INPUTS[1]);
                        let _ = writeln!(text, "    {name} = {value};");
                        continue;
                    }
                    Some(_) => {
                        let name = parameter.path.replacen("gl_", "landfall_", 1);
                        (name, value_pieces(&parameter.ty, &new))
                    }
                    None => {
                        let path = rewritten.renamed(&self.new_path(&parameter.path));
                        (path, value_pieces(&parameter.ty, &new))
                    }
                },
                Origin::Block(name, member_name) => {
                    let block = parameter.block.map(|nth| &pure.module.blocks()[nth]);
                    let found = block.and_then(|block| {
                        let mut members = block.layout.members.iter();
                        let layout = members.find(|m| *m.name == **member_name)?;
                        let elements = all_buffers(&block.layout.count);
                        let nth = block.element.and_then(|nth| elements.get(nth as usize));
                        let subscripts: String =
                            nth.into_iter().flatten().map(|i| format!("[{i}]")).collect();
                        let own = self.new_path(member_name);
                        let path = match &block.layout.instance {
                            Some(instance) => format!("{instance}{subscripts}.{own}"),
                            None => own,
                        };
                        Some((path, member(layout, &parameter.ty, &new)?))
                    });
                    found.ok_or_else(|| {
                        let message = format!(
                            "OpenGL: `{name}` has a byte layout that cannot be filled member \
                             by member; set it with --data"
                        );
                        Failure::refused(message, "")
                    })?
                }
            };
            load(text, &place, *first, &pieces);
        }
        Ok(())
    }

    /// Appends the call and statements that store its results.
    fn call(&self, pure: &PureFunction, places: &LaneWords, text: &mut String) {
        let new = |name: &str| self.new_path(name);
        let base = pure.inputs.len();
        let mut names = Vec::new();
        for (nth, info) in pure.info.parameters.iter().enumerate() {
            let name = format!("landfall_a{nth}");
            let _ = writeln!(text, "    {};", declared(&self.new_type(&info.ty), &name));
            if let Some(ParameterSlot::Given(given)) = pure.slots.get(base + nth) {
                for &parameter in given {
                    let pieces = value_pieces(&pure.parameters[parameter].ty, &new);
                    load(text, &name, places.parameters[parameter], &pieces);
                }
            }
            names.push(name);
        }
        // The user's `main` was renamed.
        let function = match pure.info.name.as_str() {
            "main" => crate::harness::rewrite::MAIN.to_string(),
            name => self.new_path(name),
        };
        let call = format!("{function}({})", names.join(", "));
        let _ = match &pure.info.returns {
            Some(ty) => {
                let declared = declared(&self.new_type(ty), "landfall_result");
                writeln!(text, "    {declared} = {call};")
            }
            None => writeln!(text, "    {call};"),
        };
        for (result, first) in pure.results.iter().zip(&places.results) {
            let name = match result.at {
                None => "landfall_result".to_string(),
                // What is no argument is a written variable.
                Some(at) => match names.get(at.wrapping_sub(base)) {
                    Some(name) => name.clone(),
                    None => self.output(&result.name),
                },
            };
            let pieces = value_pieces(&result.ty, &new);
            let from = format!("{TO} + {first}u");
            moves(text, &pieces, WordDirection::Store, (&name, OUTPUTS[1], &from));
        }
    }

    /// Returns the name of a written variable in the adapted text.
    fn output(&self, name: &str) -> String {
        // A port declares an output of its own for those that GLSL 1.30 replaced.
        let old = ["gl_FragColor", "gl_FragData"].contains(&name);
        let locations = self.ported.iter().filter(|_| old).flat_map(|ported| &ported.locations);
        let mut outputs = locations.filter(|location| location.direction == Direction::Out);
        outputs.next().map_or_else(|| self.new_path(name), |output| output.name.clone())
    }

    /// Returns the name of a type in the adapted text.
    fn new_type(&self, ty: &str) -> String {
        let (base, dims) = ty.split_at(ty.find('[').unwrap_or(ty.len()));
        format!("{}{dims}", self.new_path(base))
    }
}

fn load(text: &mut String, place: &str, first: u32, pieces: &[Piece]) {
    let from = format!("{FROM} + {first}u");
    moves(text, pieces, WordDirection::Load, (place, INPUTS[1], &from));
}

/// Returns the declaration `float name[4]` for the type `float[4]`.
fn declared(ty: &str, name: &str) -> String {
    let (base, dims) = ty.split_at(ty.find('[').unwrap_or(ty.len()));
    format!("{base} {name}{dims}")
}

/// Returns the type of a built-in variable.
fn builtin_type(name: &str, ty: &ValueType) -> Option<&'static str> {
    // GLSL has signed integers where naga's IR has unsigned ones.
    const WHOLE: [&str; 9] = [
        "gl_VertexID",
        "gl_VertexIndex",
        "gl_InstanceID",
        "gl_InstanceIndex",
        "gl_BaseVertex",
        "gl_BaseInstance",
        "gl_PrimitiveID",
        "gl_SampleID",
        "gl_Layer",
    ];
    if !name.starts_with("gl_") {
        return None;
    }
    if WHOLE.contains(&name) {
        return Some("int");
    }
    let kinds: [&str; 4] = match ty.scalars().first()?.kind {
        ScalarKind::Bool => ["bool", "bvec2", "bvec3", "bvec4"],
        ScalarKind::Uint => ["uint", "uvec2", "uvec3", "uvec4"],
        ScalarKind::Sint => ["int", "ivec2", "ivec3", "ivec4"],
        kind if kind.is_float() => ["float", "vec2", "vec3", "vec4"],
        _ => return None,
    };
    match ty {
        ValueType::Scalar(_) => Some(kinds[0]),
        ValueType::Vector { rows, .. } => kinds.get(usize::from(*rows) - 1).copied(),
        ValueType::Matrix { .. } | ValueType::Array { .. } | ValueType::Struct { .. } => None,
    }
}
