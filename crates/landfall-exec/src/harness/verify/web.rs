//! The code of a probe for a browser: the block's declaration in GLSL ES 3.00 for WebGL, the user's
//! WGSL for WebGPU, and that of `landfall port --to wgsl`.

use super::VerifyOptions;
use super::declared;
use super::request::{
    BoundBuffer, ProbeCode, ProbeRequest, ResultsPlace, gl_name, is_loose, refused, unfit,
};
use crate::backend::{Failure, StageCode};
use crate::harness::probe::{pixels, wgsl};
use landfall_layout::layout;
use landfall_layout::layout::{BlockLayout, Leaf};
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::{ExecutableStage, Source};
use landfall_port::{Dialect, PortOptions, Ported, port};

/// Returns the stage a probe runs in on WebGPU, or why it cannot run.
pub(super) fn for_webgpu(
    block: &BlockLayout,
    stage: ExecutableStage,
) -> Result<ExecutableStage, String> {
    match (block.space, stage) {
        (AddressSpace::PushConstant, _) => {
            Err("the browser's WebGPU has no push constants".to_string())
        }
        // A module has all stages, and vertex shaders cannot write the results.
        (_, ExecutableStage::Vertex) => Ok(ExecutableStage::Fragment),
        (_, ExecutableStage::Fragment | ExecutableStage::Compute) => Ok(stage),
    }
}

/// Returns the block's declaration in GLSL ES 3.00 with a probe.
pub(super) fn declared(
    need: &ProbeRequest<'_>,
    source: &Source,
    block: &BlockLayout,
) -> Result<ProbeCode, Failure> {
    let text = declared::text(source, &need.options.layout.read, block)
        .map_err(|message| unfit(&message))?;
    let stages = pixels::texts(&text, block, need.element, need.plan, need.stage.into());
    Ok(ProbeCode {
        stages: stages.map(|(stage, text)| StageCode::of_text(stage, text)).into(),
        block: BoundBuffer { name: gl_name(&block.name, need.element), ..BoundBuffer::default() },
        results: ResultsPlace::Pixels(pixels::indices(need.plan)),
        others: Vec::new(),
        // WebGL has no buffers that shaders write.
        writable: false,
    })
}

/// Returns the user's WGSL with a probe.
pub(super) fn of_wgsl(
    need: &ProbeRequest<'_>,
    source: &Source,
    block: &BlockLayout,
) -> Result<ProbeCode, Failure> {
    let (Some(group), Some(binding)) = (block.group, block.binding) else {
        return Err(unfit("its binding is not known"));
    };
    let text = wgsl::text(source, block, need.plan, need.stage);
    let entry = wgsl::ENTRY.to_string();
    let results =
        BoundBuffer { binding: wgsl::free_binding(&source.text), ..BoundBuffer::default() };
    Ok(ProbeCode {
        stages: vec![StageCode { entry, ..StageCode::of_text(need.stage.into(), text) }],
        block: BoundBuffer { name: block.name.to_string(), group, binding },
        results: ResultsPlace::Buffer(results),
        others: Vec::new(),
        writable: need.writable,
    })
}

/// Returns the WGSL of `landfall port --to wgsl` with a probe. naga may rename members, but keeps
/// their order.
pub(super) fn ported_to_wgsl(need: &ProbeRequest<'_>) -> Result<ProbeCode, Failure> {
    let ported = to_wgsl(need.source, need.block, need.options)?;
    let name = match &ported.block {
        Some(name) if is_loose(need.source, need.block) => name,
        _ => &*need.block.name,
    };
    // Ports number bindings over all sets.
    let bound = ported.bindings.iter().find(|bound| bound.name == *name);
    let bound = bound.map_or(need.block.binding, |bound| Some(bound.binding));
    let shader = layout(&ported.source, &need.options.layout);
    let block = shader.blocks.iter().find(|block| block.binding == bound);
    let places = |block: &BlockLayout| -> Vec<_> {
        let place = |leaf: &Leaf| (leaf.offset, leaf.strides.clone(), leaf.ty.clone());
        block.leaves.iter().map(place).collect()
    };
    match block.filter(|block| places(block) == places(need.block)) {
        Some(block) => of_wgsl(need, &ported.source, block),
        None => Err(unfit("`landfall port --to wgsl` gives its members other types")),
    }
}

/// Returns a shader in WGSL; of one that has more than WGSL the block's declaration alone.
pub(super) fn to_wgsl(
    source: &Source,
    block: &BlockLayout,
    options: &VerifyOptions,
) -> Result<Ported, Failure> {
    let mut to = PortOptions::default();
    to.read = options.layout.read.clone();
    to.dialect = Dialect::Wgsl;
    let ported =
        |source: &Source| port(source, &to).map_err(|found| refused("ported to WGSL", &found));
    ported(source).or_else(|whole| match declared::alone(source, &options.layout.read, block) {
        Ok(alone) if !is_loose(source, block) => ported(&alone),
        _ => Err(whole),
    })
}
