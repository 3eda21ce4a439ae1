//! The inputs and outputs of an entry point: locations and builtins.

use naga::{Binding, BuiltIn, ShaderStage, TypeInner};

use super::body::Compiled;
use super::code::Reg;
use super::flatten::Types;
use landfall_layout::source::Stage;

/// An input or output of an entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Port {
    Location(u32),
    /// `@builtin(position)`: in clip space for vertices, in pixels for fragments.
    Position,
    VertexIndex,
    InstanceIndex,
    FrontFacing,
    FragDepth,
    PointSize,
    PointCoord,
    SampleIndex,
    SampleMask,
    PrimitiveIndex,
    ViewIndex,
    GlobalInvocationId,
    LocalInvocationId,
    LocalInvocationIndex,
    WorkgroupId,
    WorkgroupSize,
    NumWorkgroups,
}

#[derive(Clone, Debug)]
pub(super) struct InterfaceVariable {
    pub port: Port,
    pub regs: Vec<Reg>,
    pub flat: bool,
    pub linear: bool,
}

#[derive(Clone, Debug)]
pub(super) struct StageInterface {
    pub stage: Option<Stage>,
    pub workgroup: [u32; 3],
    pub inputs: Vec<InterfaceVariable>,
    pub outputs: Vec<InterfaceVariable>,
}

impl StageInterface {
    pub fn regs_mut(&mut self) -> impl Iterator<Item = &mut Reg> {
        self.inputs.iter_mut().chain(&mut self.outputs).flat_map(|plug| plug.regs.iter_mut())
    }
}

/// Returns the interface of an entry point.
pub(super) fn interface(
    ir: &naga::Module,
    types: &Types,
    entry: &naga::EntryPoint,
    compiled: &Compiled,
) -> Result<StageInterface, String> {
    let mut inputs = Vec::new();
    for (argument, compiled) in entry.function.arguments.iter().zip(&compiled.arguments) {
        let inner = &ir.types[argument.ty].inner;
        plugs(ir, types, inner, argument.binding.as_ref(), &compiled.regs, &mut inputs)?;
    }
    let mut outputs = Vec::new();
    if let Some(result) = &entry.function.result {
        let inner = &ir.types[result.ty].inner;
        let regs = &compiled.result;
        plugs(ir, types, inner, result.binding.as_ref(), regs, &mut outputs)?;
    }
    let stage = match entry.stage {
        ShaderStage::Vertex => Some(Stage::Vertex),
        ShaderStage::Fragment => Some(Stage::Fragment),
        ShaderStage::Compute => Some(Stage::Compute),
        _ => None,
    };
    Ok(StageInterface { stage, workgroup: entry.workgroup_size, inputs, outputs })
}

fn plugs(
    ir: &naga::Module,
    types: &Types,
    inner: &TypeInner,
    binding: Option<&Binding>,
    regs: &[Reg],
    to: &mut Vec<InterfaceVariable>,
) -> Result<(), String> {
    if let Some(binding) = binding {
        to.push(plug(binding, regs)?);
        return Ok(());
    }
    // A structure without a location has one for each member.
    let TypeInner::Struct { members, .. } = inner else {
        return Err("an input or output without a location".into());
    };
    // The registers of the members are one after the other.
    let mut at = 0;
    for member in members {
        let inner = &ir.types[member.ty].inner;
        let count = types.leaf_count(inner)? as usize;
        let part = &regs[at..at + count];
        plugs(ir, types, inner, member.binding.as_ref(), part, to)?;
        at += count;
    }
    Ok(())
}

fn plug(binding: &Binding, regs: &[Reg]) -> Result<InterfaceVariable, String> {
    let (port, interpolation) = match binding {
        Binding::Location { location, interpolation, .. } => {
            (Port::Location(*location), *interpolation)
        }
        Binding::BuiltIn(builtin) => (port(*builtin)?, None),
    };
    Ok(InterfaceVariable {
        port,
        regs: regs.to_vec(),
        flat: interpolation == Some(naga::Interpolation::Flat),
        linear: interpolation == Some(naga::Interpolation::Linear),
    })
}

fn port(builtin: BuiltIn) -> Result<Port, String> {
    Ok(match builtin {
        BuiltIn::Position { .. } => Port::Position,
        BuiltIn::VertexIndex => Port::VertexIndex,
        BuiltIn::InstanceIndex => Port::InstanceIndex,
        BuiltIn::FrontFacing => Port::FrontFacing,
        BuiltIn::FragDepth => Port::FragDepth,
        BuiltIn::PointSize => Port::PointSize,
        BuiltIn::PointCoord => Port::PointCoord,
        BuiltIn::SampleIndex => Port::SampleIndex,
        BuiltIn::SampleMask => Port::SampleMask,
        BuiltIn::PrimitiveIndex => Port::PrimitiveIndex,
        BuiltIn::ViewIndex => Port::ViewIndex,
        BuiltIn::GlobalInvocationId => Port::GlobalInvocationId,
        BuiltIn::LocalInvocationId => Port::LocalInvocationId,
        BuiltIn::LocalInvocationIndex => Port::LocalInvocationIndex,
        BuiltIn::WorkGroupId => Port::WorkgroupId,
        BuiltIn::WorkGroupSize => Port::WorkgroupSize,
        BuiltIn::NumWorkGroups => Port::NumWorkgroups,
        other => return Err(format!("the builtin `{other:?}`")),
    })
}
