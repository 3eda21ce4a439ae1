//! The public parameters of the caller: inputs of the stage, arguments and members of blocks; and
//! its results.
//!
//! Used by [`make`](super::make).

use super::arguments;
use super::globals::SampledBlock;
use super::pure::{Origin, ParameterSlot, PureParameter, PureResult};
use crate::harness::origins::instance;
use landfall_interp::{FunctionSignature, ValueType};
use landfall_ir::Module;
use landfall_ir::module::{Direction, FunctionInfo};
use landfall_layout::layout::BlockLayout;
use landfall_layout::source::Language;

/// The caller's parameters in order: inputs, arguments, blocks, and written variables.
pub(super) struct CallerParameters<'a> {
    pub module: &'a Module,
    pub language: Language,
    pub inputs: &'a [String],
    /// By input: whether it is read.
    pub read_inputs: Vec<bool>,
    pub info: &'a FunctionInfo,
    pub blocks: &'a [SampledBlock],
}

/// The public parameters and results of a function, and the caller's parameters they stand for.
#[derive(Default)]
pub(super) struct PublicParameters {
    pub parameters: Vec<PureParameter>,
    /// By parameter of the caller.
    pub slots: Vec<ParameterSlot>,
    pub results: Vec<PureResult>,
}

/// Lists parameters and results.
pub(super) fn list(
    known: &CallerParameters<'_>,
    signature: &FunctionSignature,
) -> PublicParameters {
    let mut listed = PublicParameters::default();
    if let Some(ty) = signature.result.clone() {
        listed.results.push(PureResult { name: "result".to_string(), ty, at: None });
    }
    // In this order they were added to the caller.
    let (inputs, rest) = signature.parameters.split_at(known.inputs.len());
    let (arguments, rest) = rest.split_at(known.info.parameters.len());
    let (blocks, written) = rest.split_at(known.blocks.len());
    for (nth, parameter) in inputs.iter().enumerate() {
        let ty = parameter.ty.clone();
        match known.read_inputs[nth] {
            true => {
                listed.push_slot(vec![new_parameter(known.inputs[nth].clone(), Origin::Input, ty)])
            }
            // An input that is not read needs no values.
            false => listed.slots.push(ParameterSlot::Zero(ty.scalars().len())),
        }
    }
    for (nth, parameter) in arguments.iter().enumerate() {
        let (argument, ty) = (&known.info.parameters[nth], parameter.ty.clone());
        let name = match argument.name.as_str() {
            "" => format!("args[{nth}]"),
            name => name.to_string(),
        };
        // A parameter that is returned is a result, too.
        if parameter.returned {
            let (name, at) = (name.clone(), Some(listed.slots.len()));
            listed.results.push(PureResult { name, ty: ty.clone(), at });
        }
        match argument.direction {
            Direction::Out => listed.slots.push(ParameterSlot::Out),
            Direction::In | Direction::InOut => {
                listed.push_slot(vec![new_parameter(name, Origin::Argument(nth), ty)]);
            }
        }
    }
    for block in &known.blocks[..blocks.len()] {
        listed.push_slot(members(block, &known.module.blocks[block.number].layout, known.language));
    }
    for parameter in written {
        let (name, ty, at) = (parameter.name.clone(), parameter.ty.clone(), listed.slots.len());
        listed.results.push(PureResult { name, ty, at: Some(at) });
        listed.slots.push(ParameterSlot::Out);
    }
    listed.disambiguated()
}

impl PublicParameters {
    /// Adds the parameters that fill one parameter of the caller.
    fn push_slot(&mut self, parameters: Vec<PureParameter>) {
        let first = self.parameters.len();
        self.parameters.extend(parameters);
        self.slots.push(ParameterSlot::Given((first..self.parameters.len()).collect()));
    }

    /// Prefixes a uniform with its block's name if another parameter has the same name.
    fn disambiguated(mut self) -> PublicParameters {
        let paths: Vec<String> = self.parameters.iter().map(|p| p.path.clone()).collect();
        for parameter in &mut self.parameters {
            let twice = paths.iter().filter(|path| **path == parameter.path).count() > 1;
            if let (true, Origin::Block(block, member)) = (twice, &parameter.origin) {
                parameter.path = format!("{block}.{member}");
                parameter.scalars = scalars(&parameter.path, &parameter.ty);
            }
        }
        self
    }
}

/// Returns the members of a block as parameters.
fn members(block: &SampledBlock, layout: &BlockLayout, language: Language) -> Vec<PureParameter> {
    let named = instance(layout, language);
    let members = block.members.iter().map(|member| {
        let name = member.name.clone();
        let path = named.map_or(name.clone(), |named| format!("{named}.{name}"));
        let origin = Origin::Block(layout.name.to_string(), name);
        let parameter = new_parameter(path, origin, member.ty.clone());
        PureParameter { read: member.read, block: Some(block.number), ..parameter }
    });
    members.collect()
}

fn new_parameter(path: String, origin: Origin, ty: ValueType) -> PureParameter {
    let scalars = scalars(&path, &ty);
    PureParameter { path, origin, ty, scalars, read: true, block: None }
}

/// Returns the path of each scalar of a value.
fn scalars(path: &str, ty: &ValueType) -> Vec<String> {
    arguments::paths(ty).into_iter().map(|rest| format!("{path}{rest}")).collect()
}
