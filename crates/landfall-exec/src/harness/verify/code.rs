//! The code of a probe in the form its backend takes: the user's text for OpenGL, ported if it has
//! loose uniforms, which have no offsets in OpenGL, and for WebGPU; the block's declaration for
//! WebGL; and a module for the interpreter and wgpu.

use crate::backend::BackendKind;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::Arc;

use super::request::{
    BoundBuffer, ProbeCode, ProbeRequest, ResultsPlace, failure, gl_name, is_loose, opened,
    refused, without_qualifier,
};
use super::{Form, VerifyOptions};
use super::{declared, partner, web};
use crate::backend::{Failure, Resource, StageCode};
use crate::harness::bindings;
use crate::harness::probe::{glsl, wgsl};
use landfall_ir::{Module, call_graph};
use landfall_layout::layout::BlockLayout;
use landfall_layout::shape::{AddressSpace, ArrayLen, Rules};
use landfall_layout::source::{ExecutableStage, Language, Source, Stage};
use landfall_layout::{Options, layout};
use landfall_port::{PortOptions, port};

/// The binding of the results if the text goes through naga's GLSL front end.
const NAGA_BINDING: u32 = 99;

/// Returns the form of code for a backend.
pub(super) fn form(backend: BackendKind, source: &Source, block: &BlockLayout, naga: bool) -> Form {
    match (backend, naga) {
        (BackendKind::Gl | BackendKind::WebGl, _) if is_loose(source, block) => Form::Ported,
        (BackendKind::WebGl, _) => Form::Declared,
        (BackendKind::WebGpu, _) if source.language == Language::Glsl => Form::Ported,
        (BackendKind::Gl | BackendKind::WebGpu, _) => Form::Original,
        (_, false) => Form::Module,
        (_, true) => Form::Naga,
    }
}

/// Returns the stage a probe runs in on a backend, or why it cannot run.
pub(super) fn fits(
    backend: BackendKind,
    source: &Source,
    block: &BlockLayout,
    stage: Stage,
) -> Result<ExecutableStage, String> {
    let Some(runs) = ExecutableStage::from_stage(stage) else {
        return Err(format!("probes do not run in {} stages", stage.name()));
    };
    match backend {
        BackendKind::Cpu | BackendKind::Gpu => return Ok(runs),
        BackendKind::WebGl => {
            // The declaration is the same in every stage, and there is no compute stage.
            let fragment = runs == ExecutableStage::Compute;
            let runs = if fragment { ExecutableStage::Fragment } else { runs };
            return declared::refusal(source, block).map_or(Ok(runs), Err);
        }
        BackendKind::WebGpu => return web::for_webgpu(block, runs),
        BackendKind::Gl => {}
    }
    match (source.language, block.space) {
        (Language::Wgsl, _) => Err("OpenGL does not accept WGSL".to_string()),
        (Language::Glsl | Language::SpirV, AddressSpace::PushConstant) => {
            Err("OpenGL has no push constants".to_string())
        }
        (Language::Glsl | Language::SpirV, _) if block.rules == Rules::Scalar => {
            Err("OpenGL has no scalar layout".to_string())
        }
        (Language::Glsl | Language::SpirV, _) => Ok(runs),
    }
}

/// Returns the code of a probe.
///
/// # Errors
/// Fails if the shader does not run.
pub(super) fn code(need: &ProbeRequest<'_>) -> Result<ProbeCode, Failure> {
    let form = form(need.backend, need.source, need.block, need.options.naga);
    match form {
        Form::Declared => web::declared(need, need.source, need.block),
        Form::Original if need.backend == BackendKind::WebGpu => {
            web::of_wgsl(need, need.source, need.block)
        }
        Form::Original => {
            let source = raised(opened(need.source, &need.options.layout.read));
            let text = glsl::text(&source, need.block, need.element, need.plan, need.stage);
            for_gl(need, &source, &text)
        }
        Form::Ported if need.backend == BackendKind::WebGpu => web::ported_to_wgsl(need),
        Form::Ported => ported(need),
        Form::Module | Form::Naga | Form::Spirv => module(need, form),
    }
}

/// Returns an ES 3.00 shader as ES 3.10, which has storage buffers and the same std140.
fn raised(source: Cow<'_, Source>) -> Cow<'_, Source> {
    let head = glsl::Head::from_text(&source.text);
    if !head.es || head.version != 300 {
        return source;
    }
    let Some(at) = source.text[..head.end].rfind("300") else { return source };
    // As long as before, so that positions stay.
    let text = format!("{}310{}", &source.text[..at], &source.text[at + 3..]);
    Cow::Owned(Source { text: Arc::from(text), ..source.into_owned() })
}

/// Returns a probe with its results at a binding of their own, which ES takes from the text alone.
fn bound_apart(need: &ProbeRequest<'_>, source: &Source, text: &str) -> String {
    if !glsl::Head::from_text(text).es {
        return text.to_string();
    }
    let shader = layout(source, &need.options.layout);
    let storage = |block: &&BlockLayout| matches!(block.space, AddressSpace::Storage);
    let taken: Vec<u32> =
        // A block without a binding is at 0.
        shader.blocks.iter().filter(storage).map(|block| block.binding.unwrap_or(0)).collect();
    let free = (0..).find(|binding| !taken.contains(binding)).unwrap_or(0);
    let declaration = format!("layout(std430) buffer {}", glsl::RESULTS);
    let bound = format!("layout(std430, binding = {free}) buffer {}", glsl::RESULTS);
    text.replace(&declaration, &bound)
}

/// Returns the texts of a program without a probe, as the backend's compiler takes them: the user's
/// own where it does, otherwise the block's declaration.
pub(super) fn texts_without_probe(
    backend: BackendKind,
    source: &Source,
    block: &BlockLayout,
    options: &VerifyOptions,
    stage: Stage,
) -> Vec<(Stage, String)> {
    let read = &options.layout.read;
    match backend {
        BackendKind::WebGpu if source.language == Language::Glsl => {
            let ported = web::to_wgsl(source, block, options).ok();
            ported.map(|ported| (stage, ported.source.text.to_string())).into_iter().collect()
        }
        BackendKind::WebGpu => vec![(stage, source.text.to_string())],
        BackendKind::WebGl => declared::whole(source, read, block, stage),
        // OpenGL's compilers do not know the qualifier.
        BackendKind::Cpu | BackendKind::Gl | BackendKind::Gpu => {
            vec![(stage, without_qualifier(&opened(source, read).text, "set"))]
        }
    }
}

fn for_gl(need: &ProbeRequest<'_>, source: &Source, text: &str) -> Result<ProbeCode, Failure> {
    let name = gl_name(&need.block.name, need.element);
    let text = bound_apart(need, source, text);
    let probe = StageCode::of_text(need.stage.into(), without_qualifier(&text, "set"));
    let stages = match need.stage {
        ExecutableStage::Vertex => vec![probe, fragment(need, source)?],
        ExecutableStage::Fragment => {
            let vertex = partner::vertex(source, &need.options.layout.read);
            vec![StageCode::of_text(Stage::Vertex, vertex), probe]
        }
        ExecutableStage::Compute => vec![probe],
    };
    Ok(ProbeCode {
        stages,
        block: BoundBuffer { name, ..BoundBuffer::default() },
        results: ResultsPlace::Buffer(BoundBuffer {
            name: glsl::RESULTS.to_string(),
            ..BoundBuffer::default()
        }),
        others: Vec::new(),
        writable: need.writable,
    })
}

/// Returns the fragment stage that a vertex stage needs to run.
fn fragment(need: &ProbeRequest<'_>, source: &Source) -> Result<StageCode, Failure> {
    let source = partner::fragment(source, &need.options.layout.read);
    let module = match need.backend {
        // OpenGL compiles the text itself.
        BackendKind::Gl => None,
        BackendKind::Cpu | BackendKind::Gpu | BackendKind::WebGl | BackendKind::WebGpu => {
            let made = Module::new(&source, &Options::default());
            Some(Arc::new(made.map_err(|found| refused("run", &found))?))
        }
    };
    Ok(StageCode { module, ..StageCode::of_text(Stage::Fragment, &*source.text) })
}

/// Returns the code with loose uniforms in a block, members in their order.
fn ported(need: &ProbeRequest<'_>) -> Result<ProbeCode, Failure> {
    let mut options = PortOptions::default();
    options.read = need.options.layout.read.clone();
    let ported = port(need.source, &options).map_err(|found| refused("ported", &found))?;
    let shader = layout(&ported.source, &need.options.layout);
    let name = ported.block.as_deref().unwrap_or_default();
    let block = shader.blocks.iter().find(|block| &*block.name == name);
    // The port's block is probed, but the loose uniforms are reported.
    let places = |block: &BlockLayout| -> Vec<_> {
        block.leaves.iter().map(|leaf| (leaf.offset, leaf.strides.clone())).collect()
    };
    let Some(block) = block.filter(|block| places(block) == places(need.block)) else {
        return Err(failure(
            "its uniforms have other offsets in the shader that `landfall port` writes".to_string(),
        ));
    };
    if need.backend == BackendKind::WebGl {
        return web::declared(need, &ported.source, block);
    }
    let source = raised(Cow::Borrowed(&ported.source));
    let text = glsl::text(&source, block, need.element, need.plan, need.stage);
    let mut code = for_gl(need, &source, &text)?;
    // Loose uniforms are in no block that has a name.
    code.block.name = name.to_string();
    Ok(code)
}

fn module(need: &ProbeRequest<'_>, form: Form) -> Result<ProbeCode, Failure> {
    let (text, entry) = match need.source.language {
        Language::Glsl | Language::SpirV => {
            (glsl::text(need.source, need.block, need.element, need.plan, need.stage), "main")
        }
        Language::Wgsl => (wgsl::text(need.source, need.block, need.plan, need.stage), wgsl::ENTRY),
    };
    // naga needs explicit bindings.
    let text = match form {
        Form::Naga => text.replace(
            &format!("layout(std430) buffer {}", glsl::RESULTS),
            &format!("layout(std430, binding = {NAGA_BINDING}) buffer {}", glsl::RESULTS),
        ),
        Form::Original | Form::Ported | Form::Declared | Form::Module | Form::Spirv => text,
    };
    let source =
        Source { text: Arc::from(text), stage: Some(need.stage.into()), ..need.source.clone() };
    let options = need.options.layout.clone().with_gather(true).with_naga(false);
    let made = match form {
        Form::Naga => Module::by_naga(&source, &options),
        Form::Original | Form::Ported | Form::Declared | Form::Module | Form::Spirv => {
            Module::new(&source, &options)
        }
    };
    let module = made.map_err(|found| refused("run", &found))?;
    let block = bound(&module, need.block, need.element)?;
    let written = module
        .blocks()
        .iter()
        .find(|block| [glsl::RESULTS, "landfall_words"].contains(&&*block.layout.name))
        .ok_or_else(|| failure("the module lacks the buffer of results".to_string()))?;
    let results = BoundBuffer {
        name: written.layout.name.to_string(),
        group: written.group,
        binding: written.binding,
    };
    let others = others(&module, &block, &results);
    let mut stages = vec![StageCode::of_module(need.stage.into(), entry, module)];
    if need.stage == ExecutableStage::Vertex {
        stages.push(fragment(need, need.source)?);
    }
    Ok(ProbeCode {
        stages,
        block,
        results: ResultsPlace::Buffer(results),
        others,
        writable: need.writable,
    })
}

/// Returns buffers of zeros and textures of one colour for all that a module's entry points reach but
/// those buffers: the initialisers of its global variables run before the probe.
fn others(module: &Module, block: &BoundBuffer, results: &BoundBuffer) -> Vec<Resource> {
    let entries = module.ir.entry_points.iter();
    let reached: BTreeSet<_> =
        entries.flat_map(|entry| call_graph::variables(&module.ir, &entry.function)).collect();
    let own = [(block.group, block.binding), (results.group, results.binding)];
    let is_written = |variable: naga::Handle<naga::GlobalVariable>| match module.ir.global_variables
        [variable]
        .space
    {
        naga::AddressSpace::Storage { access } => access.contains(naga::StorageAccess::STORE),
        _ => false,
    };
    let blocks = module.blocks().iter().filter(|block| {
        let is_own = own.contains(&(block.group, block.binding));
        // Push constants have no binding of their own: theirs says nothing.
        reached.contains(&block.variable)
            && (!is_own || block.layout.space == AddressSpace::PushConstant)
    });
    let blocks = blocks.filter(|other| *other.layout.name != *block.name).map(|block| Resource {
        name: block.layout.name.to_string(),
        group: block.group,
        binding: block.binding,
        kind: bindings::kind(
            &block.layout,
            bindings::zeros(&block.layout),
            is_written(block.variable),
        ),
    });
    let handles = module.handles().iter().filter(|handle| reached.contains(&handle.variable));
    blocks.chain(handles.filter_map(|handle| bindings::dummy(handle, &[]))).collect()
}

/// Returns the binding of the probed block in the module.
fn bound(module: &Module, block: &BlockLayout, element: &[u32]) -> Result<BoundBuffer, Failure> {
    let nth = nth_buffer(block, element);
    let found = module.blocks().iter().find(|other| {
        other.layout.name == block.name
            && other.layout.instance == block.instance
            && other.element == nth
    });
    let found =
        found.ok_or_else(|| failure(format!("the module has no block `{}`", block.name)))?;
    Ok(BoundBuffer { name: block.name.to_string(), group: found.group, binding: found.binding })
}

/// Returns the index of a buffer in an array of blocks, flattened over all dimensions.
fn nth_buffer(block: &BlockLayout, element: &[u32]) -> Option<u32> {
    let counted = element.iter().zip(&block.count).fold(0, |sum, (index, len)| match len {
        ArrayLen::Fixed(length) => sum * length + index,
        ArrayLen::Runtime | ArrayLen::Override(_) => sum,
    });
    (!block.count.is_empty()).then_some(counted)
}
