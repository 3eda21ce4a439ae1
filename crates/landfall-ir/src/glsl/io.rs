//! The entry point: inputs in, `main`, outputs out.
//!
//! Inputs and outputs are private variables; structures, arrays and matrices are split into scalars
//! and vectors, each with a location.

use naga::{
    Binding, BuiltIn, EarlyDepthTest, EntryPoint, Expression, FunctionArgument, FunctionResult,
    Handle, Interpolation, Sampling, ShaderStage, Statement, StructMember,
};
use rustc_hash::FxHashSet;
use std::collections::BTreeSet;

use super::ast::Qualifiers;
use super::body::{Body, TypedValue};
use super::lvalue::{Index, Lvalue, LvalueMemory};
use super::types::{Kind, Ty};
use super::{Lowerer, Lowering, refuse};
use crate::call_graph;
use crate::module::{EntryInterface, Inputs};
pub use landfall_layout::source::{ExecutableStage, Span, Stage};
pub use landfall_layout::syntax::glsl::lexer::Token;

/// The most locations of a shader's inputs or outputs.
const MAX_LOCATIONS: u32 = 1024;

#[derive(Clone, Debug)]
pub struct StageVariable {
    pub name: String,
    pub variable: Handle<naga::GlobalVariable>,
    /// The instance name, for a member of an interface block.
    pub member: Option<u32>,
    pub ty: Ty,
    pub output: bool,
    pub location: Option<u32>,
    /// `index = 1`: the second colour of a blend.
    pub blend: Option<u32>,
    pub binding: Option<Binding>,
    flat: bool,
    noperspective: bool,
    centroid: bool,
    sample: bool,
    span: Span,
}

impl StageVariable {
    pub fn new(
        name: &str,
        variable: Handle<naga::GlobalVariable>,
        ty: Ty,
        qualifiers: &Qualifiers<'_>,
        output: bool,
    ) -> StageVariable {
        StageVariable {
            name: name.to_string(),
            variable,
            member: None,
            ty,
            output,
            location: None,
            blend: None,
            binding: None,
            flat: qualifiers.flat,
            noperspective: qualifiers.noperspective,
            centroid: qualifiers.centroid,
            sample: qualifiers.sample,
            span: Span::default(),
        }
    }

    pub fn with_block_qualifiers(mut self, qualifiers: &Qualifiers<'_>) -> StageVariable {
        self.flat |= qualifiers.flat;
        self.noperspective |= qualifiers.noperspective;
        self.centroid |= qualifiers.centroid;
        self.sample |= qualifiers.sample;
        self
    }

    pub fn at(self, location: Option<u32>, blend: Option<u32>, span: Span) -> StageVariable {
        StageVariable { location, blend, span, ..self }
    }

    pub fn is(self, builtin: BuiltIn) -> StageVariable {
        StageVariable { binding: Some(Binding::BuiltIn(builtin)), ..self }
    }

    pub fn member(self, member: u32) -> StageVariable {
        StageVariable { member: Some(member), ..self }
    }
}

/// Returns the number of locations of a type (GLSL 4.60 §4.4.1).
pub fn locations(ty: &Ty) -> u32 {
    match ty {
        Ty::Matrix(_, columns, _) => (*columns).into(),
        Ty::Array(element, len) => locations(element).saturating_mul(len.unwrap_or(1)),
        Ty::Struct(s) => {
            s.members.iter().fold(0u32, |sum, field| sum.saturating_add(locations(&field.ty)))
        }
        Ty::Void | Ty::Scalar(_) | Ty::Vector(..) | Ty::Opaque(_) => 1,
    }
}

/// Returns the stage of a text without a declared one, by the built-in variables in it.
pub fn stage_of(tokens: &[Token<'_>]) -> Option<Stage> {
    // Only for texts without a declared stage: the first name that exists in one stage alone.
    tokens.iter().find_map(|token| match token.text {
        "gl_Position" | "gl_VertexID" | "gl_VertexIndex" | "gl_Vertex" => Some(Stage::Vertex),
        "gl_FragColor" | "gl_FragCoord" | "gl_FragDepth" | "gl_FragData" | "discard" | "dFdx"
        | "fwidth" => Some(Stage::Fragment),
        "local_size_x" | "gl_GlobalInvocationID" | "gl_LocalInvocationID" => Some(Stage::Compute),
        _ => None,
    })
}

/// Returns an error for unsupported stages.
pub fn check_stage(stage: Option<Stage>) -> Lowering<()> {
    match stage {
        Some(other) if ExecutableStage::from_stage(other).is_none() => {
            let message = format!("{} shaders are not supported", other.name());
            let diagnostic = refuse(Span::default(), message);
            Err(Box::new(diagnostic.with_note("supported stages: vertex, fragment and compute")))
        }
        Some(_) | None => Ok(()),
    }
}

/// A scalar or vector of an input or output.
struct IoSlot {
    io: usize,
    path: Vec<u32>,
    ty: Ty,
    location: u32,
    name: String,
}

impl Lowerer<'_> {
    /// Creates the entry point for `main`, if there is one.
    pub fn entry_point(&mut self) -> Lowering<(Vec<EntryInterface>, Vec<EntryInterface>)> {
        let Some(main) = self.main_function() else { return Ok((Vec::new(), Vec::new())) };
        let stage = match self.stage {
            Some(Stage::Vertex) => ShaderStage::Vertex,
            Some(Stage::Compute) => ShaderStage::Compute,
            Some(_) => ShaderStage::Fragment,
            None => {
                return Err(refuse(
                    Span::default(),
                    "the stage of this shader is unknown: name it with --stage",
                ));
            }
        };
        if stage == ShaderStage::Vertex {
            // naga wants it whether the shader writes it or not.
            self.predeclared("gl_Position", Span::default())?;
        }
        // Slots of all inputs and outputs, then those that the code reaches: locations must not
        // depend on what is used.
        let (mut inputs, mut outputs) = (self.slots(false)?, self.slots(true)?);
        let initialise = self.initialise_globals()?;
        // What `main` and the initialisers reach through calls.
        let run = || initialise.iter().chain([&main]).map(|&of| &self.ir.functions[of]);
        let reached: BTreeSet<_> =
            run().flat_map(|function| call_graph::variables(&self.ir, function)).collect();
        let position = |io: &StageVariable| {
            matches!(io.binding, Some(Binding::BuiltIn(BuiltIn::Position { .. })))
        };
        let of_any: BTreeSet<_> = match self.wanted_inputs {
            Inputs::OfMain => reached.clone(),
            Inputs::OfAny => {
                let all = self.ir.functions.iter();
                all.flat_map(|(_, function)| call_graph::direct_variables(function)).collect()
            }
        };
        inputs.retain(|slot| of_any.contains(&self.io[slot.io].variable));
        // A vertex stage writes its position, used or not.
        outputs.retain(|slot| {
            let io = &self.io[slot.io];
            reached.contains(&io.variable) || position(io)
        });
        let workgroup_size = match stage {
            ShaderStage::Compute => self.workgroup_size,
            _ => [0; 3],
        };
        let early_depth_test = (self.early_fragment_tests && stage == ShaderStage::Fragment)
            .then_some(EarlyDepthTest::Force);
        let mut body = Body::new(self, Ty::Void, Span::default());
        // The entry point copies inputs to private variables, runs initialisers and `main`, and
        // returns outputs from private variables: naga has no global inputs and outputs.
        for slot in &inputs {
            body.input(slot, stage)?;
        }
        for function in initialise.into_iter().chain([main]) {
            body.statement(Statement::Call { function, arguments: Vec::new(), result: None });
        }
        body.outputs(&outputs, stage)?;
        let mut function = body.finish();
        function.name = Some("main".to_string());
        self.ir.entry_points.push(EntryPoint {
            name: "main".to_string(),
            stage,
            early_depth_test,
            workgroup_size,
            workgroup_size_overrides: None,
            function,
            mesh_info: None,
            task_payload: None,
            incoming_ray_payload: None,
        });
        let interface = |slots: &[IoSlot], all: &[StageVariable]| {
            let slots = slots.iter().filter(|slot| all[slot.io].binding.is_none());
            let entry = |slot: &IoSlot| {
                let (name, location) = (slot.name.clone(), slot.location);
                EntryInterface { name, location, variable: all[slot.io].variable }
            };
            slots.map(entry).collect()
        };
        Ok((interface(&inputs, &self.io), interface(&outputs, &self.io)))
    }

    /// Creates the function that gives global variables their first values, if any needs code.
    fn initialise_globals(&mut self) -> Lowering<Option<Handle<naga::Function>>> {
        let initialisers = std::mem::take(&mut self.initialisers);
        if initialisers.is_empty() {
            return Ok(None);
        }
        let mut body = Body::new(self, Ty::Void, Span::default());
        for (global, declaration, index) in initialisers {
            body.initialise(global, &declaration, index)?;
        }
        let mut function = body.finish();
        function.name = Some("initialise_globals".to_string());
        Ok(Some(self.ir.functions.append(function, naga::Span::UNDEFINED)))
    }

    /// Returns every scalar and vector of the interface, with its location.
    fn slots(&self, output: bool) -> Lowering<Vec<IoSlot>> {
        let all = || self.io.iter().enumerate().filter(|(_, io)| io.output == output);
        // Stated locations first, so that automatic ones are put around them.
        let mut taken = FxHashSet::default();
        for (_, io) in all() {
            let Some(location) = io.location else { continue };
            let past = location.saturating_add(locations(&io.ty)).min(MAX_LOCATIONS);
            taken.extend(location..past);
        }
        let mut given = FxHashSet::default();
        let mut slots = Vec::new();
        for (index, io) in all() {
            if io.binding.is_some() {
                // Built-ins have no location.
                let (ty, name) = (io.ty.clone(), io.name.clone());
                slots.push(IoSlot { io: index, path: Vec::new(), ty, location: 0, name });
                continue;
            }
            let count = locations(&io.ty);
            // Two that share a location by `component` have one each here.
            let own = io.location.filter(|l| {
                io.blend == Some(1) || (*l..l.saturating_add(count)).all(|l| !given.contains(&l))
            });
            // The first gap that is large enough.
            let first = own.or_else(|| {
                (0..MAX_LOCATIONS).find(|first| {
                    (*first..first + count).all(|l| !taken.contains(&l) && !given.contains(&l))
                })
            });
            let Some(first) = first.filter(|first| first.saturating_add(count) <= MAX_LOCATIONS)
            else {
                let message = format!("`{}` takes more than {MAX_LOCATIONS} locations", io.name);
                return Err(refuse(io.span, message));
            };
            given.extend(first..first + count);
            let mut next = first;
            flatten(index, &io.ty, Vec::new(), io.name.clone(), &mut next, &mut slots);
        }
        Ok(slots)
    }
}

fn flatten(
    io: usize,
    ty: &Ty,
    path: Vec<u32>,
    name: String,
    next: &mut u32,
    slots: &mut Vec<IoSlot>,
) {
    let deeper = |i: u32| {
        let mut path = path.clone();
        path.push(i);
        path
    };
    // One location for each scalar or vector, in order of declaration (GLSL 4.60 §4.4.1).
    match ty {
        Ty::Array(element, len) => {
            for i in 0..len.unwrap_or(0) {
                flatten(io, element, deeper(i), format!("{name}[{i}]"), next, slots);
            }
        }
        Ty::Struct(s) => {
            for (i, field) in s.members.iter().enumerate() {
                let name = format!("{name}.{}", field.name);
                flatten(io, &field.ty, deeper(i as u32), name, next, slots);
            }
        }
        Ty::Matrix(kind, columns, rows) => {
            for i in 0..*columns {
                let ty = Ty::Vector(*kind, *rows);
                flatten(io, &ty, deeper(i.into()), format!("{name}[{i}]"), next, slots);
            }
        }
        Ty::Void | Ty::Scalar(_) | Ty::Vector(..) | Ty::Opaque(_) => {
            slots.push(IoSlot { io, path, ty: ty.clone(), location: *next, name });
            *next += 1;
        }
    }
}

impl Body<'_, '_> {
    /// Returns the binding of a slot and naga's type for it.
    fn bound(
        &mut self,
        slot: &IoSlot,
        stage: ShaderStage,
    ) -> Lowering<(Binding, Handle<naga::Type>, Ty)> {
        let io = self.cx.io[slot.io].clone();
        if let Some(binding) = io.binding {
            // naga's counterparts of whole numbers are all unsigned.
            let ty = match &slot.ty {
                Ty::Array(element, _) if **element == Ty::INT => Ty::UINT,
                Ty::Scalar(Kind::Int) => Ty::UINT,
                other => other.clone(),
            };
            return Ok((binding, self.cx.value_type(&ty, io.span)?, ty));
        }
        // Interpolated are outputs of the vertex stage and inputs of the fragment stage.
        let varies = (stage == ShaderStage::Vertex) == io.output;
        let float = slot.ty.kind().is_some_and(Kind::is_float);
        // Integers cannot be interpolated (GLSL 4.60 §4.5).
        let (interpolation, sampling) = match (varies, io.flat || !float, io.noperspective) {
            (false, ..) => (None, None),
            (true, true, _) => (Some(Interpolation::Flat), Some(Sampling::First)),
            (true, false, linear) => {
                let sampling = match (io.centroid, io.sample) {
                    (true, _) => Sampling::Centroid,
                    (_, true) => Sampling::Sample,
                    _ => Sampling::Center,
                };
                let linear =
                    if linear { Interpolation::Linear } else { Interpolation::Perspective };
                (Some(linear), Some(sampling))
            }
        };
        // Dual-source blending: two outputs at location 0.
        let dual = self.cx.io.iter().any(|io| io.blend == Some(1));
        let blends = io.output && stage == ShaderStage::Fragment && slot.location == 0 && dual;
        let binding = Binding::Location {
            location: slot.location,
            interpolation,
            sampling,
            blend_src: blends.then(|| io.blend.unwrap_or(0)),
            per_primitive: false,
        };
        Ok((binding, self.cx.value_type(&slot.ty, io.span)?, slot.ty.clone()))
    }

    /// Returns a pointer to the private variable of a slot, or to a part of it.
    fn slot_place(&mut self, slot: &IoSlot) -> Lowering<Lvalue> {
        let io = self.cx.io[slot.io].clone();
        let mut pointer = self.global_pointer(io.variable);
        if let Some(member) = io.member {
            pointer = self.part(pointer, member);
        }
        let mut ty = io.ty.clone();
        for &i in &slot.path {
            pointer = self.part(pointer, i);
            ty = match &ty {
                Ty::Struct(s) => s.members[i as usize].ty.clone(),
                other => match other.indexed() {
                    Some((element, _)) => element,
                    None => return self.refuse("the input has no such component"),
                },
            };
        }
        Ok(Lvalue::new(LvalueMemory::Own(pointer), ty))
    }

    fn input(&mut self, slot: &IoSlot, stage: ShaderStage) -> Lowering<()> {
        let (binding, handle, given) = self.bound(slot, stage)?;
        let index = self.function.arguments.len() as u32;
        let name = Some(slot.name.replace(['.', '[', ']'], "_"));
        let binding = Some(binding);
        self.function.arguments.push(FunctionArgument { name, ty: handle, binding });
        let expr = self.add(Expression::FunctionArgument(index));
        let mut place = self.slot_place(slot)?;
        // `gl_SampleMask` and the like are arrays in GLSL and scalars in naga.
        if let (Ty::Array(..), Ty::Scalar(_)) = (&place.ty, &given) {
            place = self.element_of(&place, Index::Fixed(0))?;
        }
        let value = self.convert(&TypedValue { expr, ty: given }, &place.ty)?;
        self.store(&place, &value)
    }

    fn outputs(&mut self, slots: &[IoSlot], stage: ShaderStage) -> Lowering<()> {
        let mut members = Vec::new();
        let mut values = Vec::new();
        let mut offset = 0u32;
        for slot in slots {
            let (binding, handle, wanted) = self.bound(slot, stage)?;
            let mut place = self.slot_place(slot)?;
            if let (Ty::Array(..), Ty::Scalar(_)) = (&place.ty, &wanted) {
                place = self.element_of(&place, Index::Fixed(0))?;
            }
            let value = self.load(&place)?;
            values.push(self.convert(&value, &wanted)?.expr);
            let name = Some(slot.name.replace(['.', '[', ']'], "_"));
            members.push(StructMember { name, ty: handle, binding: Some(binding), offset });
            // naga wants ascending offsets of the result's members; they have no other meaning.
            let size = match &slot.ty {
                Ty::Array(_, len) => len.unwrap_or(1).saturating_mul(16),
                _ => 16,
            };
            offset += size;
        }
        if members.is_empty() {
            self.statement(Statement::Return { value: None });
            return Ok(());
        }
        let inner = naga::TypeInner::Struct { members, span: offset };
        let name = Some("Outputs".to_string());
        let ty = self.cx.ir.types.insert(naga::Type { name, inner }, naga::Span::UNDEFINED);
        self.function.result = Some(FunctionResult { ty, binding: None });
        let value = self.add(Expression::Compose { ty, components: values });
        self.statement(Statement::Return { value: Some(value) });
        Ok(())
    }
}
