//! A call by a driver: the user's text with a `main` that calls the function, its arguments from
//! a buffer and its results to it, bit for bit.
//!
//! The same way of adding to a text as [`probe`](crate::run::probe); the evaluator needs none of it.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::sync::Arc;

use super::Request;
use super::arguments::{held_as, paths};
use super::caller::without_interface;
use super::find::Found;
use crate::port::{PortOptions, Ported, port};
use crate::run::Module;
use crate::run::bound;
use crate::run::eval::ValueType;
use crate::run::module::{Direction, Parameter};
use crate::run::probe::{glsl, wgsl};
use crate::run::reader::{Failure, Job, Reader, Resource, ResourceKind, StageCode};
use crate::run::runs::Runs;
use crate::run::verify::{access, code, every, partner};
use crate::shape::{AddressSpace, Scalar, ScalarKind};
use crate::source::{Language, Source, Stage};
use crate::{BlockLayout, Diagnostic, Options, layout};

/// The words that came back.
#[derive(Clone, Debug, Default)]
pub(super) struct Answered {
    pub result: Vec<u64>,
    /// By parameter; of one that is not returned, what was given.
    pub parameters: Vec<Vec<u64>>,
}

/// Where each scalar of the call is in the buffer: arguments first, then the result.
struct Slots {
    parameters: Vec<u32>,
    result: u32,
    words: u32,
}

/// The entry point that is added to WGSL.
const ENTRY: &str = "landfall_main";

/// Has a driver call the function.
pub(super) fn run(
    source: &Source,
    options: &Options,
    request: &Request,
    found: &Found<'_>,
    reader: &mut dyn Reader,
) -> Result<Answered, Failure> {
    let slots = slots(found)?;
    let name = reader.device().reader;
    let made = match (name, source.language) {
        ("gl", Language::Wgsl) => return Err(Failure::refused("OpenGL takes no WGSL", "")),
        ("gl", Language::Glsl) => original(source, options, request, found, &slots)?,
        (_, Language::Glsl) => {
            let stage = Runs::or_refused(source.stage.unwrap_or(Stage::Compute))?;
            let text = glsl_text(source, &found.info.name, found, &slots, stage);
            module(source, options, request, &text, stage, "main")?
        }
        (_, Language::Wgsl) => {
            let names = Module::by_naga(source, options).ok();
            let spelled = names.as_ref().and_then(|module| {
                module.functions().iter().find(|function| function.name == found.info.name)
            });
            let parameters = spelled.map_or(&found.info.parameters, |info| &info.parameters);
            let at = |stage| {
                let text = wgsl_text(source, parameters, found, &slots, stage);
                module(source, options, request, &text, stage, ENTRY)
            };
            // Derivatives and sampling are a fragment's.
            at(Runs::Compute).or_else(|failure| at(Runs::Fragment).map_err(|_| failure))?
        }
    };
    let Made { stages, mut resources, results, stage } = made;
    let mut words: Vec<u8> = Vec::with_capacity(slots.words as usize * 4);
    for word in
        found.arguments.iter().zip(&found.signature.parameters).flat_map(|(words, p)| {
            p.ty.scalars().into_iter().zip(words.iter().map(|lanes| lanes[0]))
        })
    {
        words.extend_from_slice(&word.1.to_le_bytes()[..wide(word.0) as usize * 4]);
    }
    words.resize(slots.words as usize * 4, 0);
    let kind = ResourceKind::Storage { bytes: words, writable: true };
    resources.insert(0, Resource { kind, ..results });
    let grid = stage.once();
    let answer = reader.run(&Job { stages, resources, grid, limit: request.limit })?;
    let bytes = answer.buffers.into_iter().next().flatten();
    let bytes = bytes.ok_or_else(|| Failure::died("the results did not come back", ""))?;
    Ok(answered(found, &slots, &bytes))
}

/// What is run and what is bound, but the results.
struct Made {
    stages: Vec<StageCode>,
    resources: Vec<Resource>,
    /// Where the results are bound; its bytes are not there yet.
    results: Resource,
    stage: Runs,
}

fn slots(found: &Found<'_>) -> Result<Slots, Failure> {
    let mut next = 0u32;
    let mut place = |ty: &ValueType| {
        let at = next;
        let words: u32 = ty.scalars().iter().map(|scalar| wide(*scalar)).sum();
        next = next.checked_add(words).ok_or_else(|| Failure::refused("too large a call", ""))?;
        Ok::<u32, Failure>(at)
    };
    let mut parameters = Vec::new();
    for parameter in &found.signature.parameters {
        parameters.push(place(&parameter.ty)?);
    }
    let result = match &found.signature.result {
        Some(ty) => place(ty)?,
        None => next,
    };
    // A buffer has at least a word.
    Ok(Slots { parameters, result, words: next.max(1) })
}

/// Words of a scalar in the buffer.
fn wide(scalar: Scalar) -> u32 {
    if scalar.width == 8 { 2 } else { 1 }
}

fn answered(found: &Found<'_>, slots: &Slots, bytes: &[u8]) -> Answered {
    let word = |at: u32| -> u64 {
        let at = at as usize * 4;
        bytes.get(at..at + 4).map_or(0, |b| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])))
    };
    let value = |ty: &ValueType, mut at: u32| -> Vec<u64> {
        let each = ty.scalars().into_iter().map(|scalar| {
            let low = word(at);
            let high = if wide(scalar) == 2 { word(at + 1) << 32 } else { 0 };
            at += wide(scalar);
            low | high
        });
        each.collect()
    };
    let parameters = found.signature.parameters.iter().zip(&slots.parameters);
    Answered {
        result: found.signature.result.as_ref().map_or(Vec::new(), |ty| value(ty, slots.result)),
        parameters: parameters.map(|(parameter, at)| value(&parameter.ty, *at)).collect(),
    }
}

/// For OpenGL: the text as it is, or ported where it has loose uniforms or is too old for bits.
fn original(
    source: &Source,
    options: &Options,
    request: &Request,
    found: &Found<'_>,
    slots: &Slots,
) -> Result<Made, Failure> {
    let shader = layout(source, options);
    let head = glsl::Head::of(&source.text);
    let loose = shader.blocks.iter().any(|block| code::is_loose(source, block));
    let ported = match loose || head.es || head.version < 330 {
        true => Some(ported(source, options)?),
        false => None,
    };
    let opened = match &ported {
        Some(ported) => Cow::Borrowed(&ported.source),
        None => code::opened(source, &options.read),
    };
    let stage = Runs::or_refused(source.stage.unwrap_or(Stage::Compute))?;
    let function = match &ported {
        Some(ported) => ported.new_path(&found.info.name),
        None => found.info.name.clone(),
    };
    let text = code::without(&glsl_text(&opened, &function, found, slots, stage), "set");
    let code = |stage: Stage, text: String| StageCode {
        stage,
        entry: "main".to_string(),
        module: None,
        glsl: Some(text),
        spirv: None,
    };
    let own = code(stage.into(), text);
    let stages = match stage {
        Runs::Vertex => {
            vec![own, code(Stage::Fragment, partner::fragment(&opened).text.to_string())]
        }
        Runs::Fragment => {
            let vertex = zeroed(&partner::vertex(&opened, &options.read), &own, &opened, options);
            vec![code(Stage::Vertex, vertex), own]
        }
        Runs::Compute => vec![own],
    };
    // The module knows the textures by the names of the text.
    let made = Module::new(source, options).map_err(|found| refused(&found))?;
    let bytes =
        bound::blocks(&made, &request.data, bound::zeros).map_err(|found| refused(&[*found]))?;
    let mut resources = Vec::new();
    let skipped = |block: &BlockLayout| block.space == AddressSpace::PushConstant;
    for (block, bytes) in made.blocks().iter().zip(bytes).filter(|(b, _)| !skipped(&b.layout)) {
        let elements = every(&block.layout.count);
        let nth = block.element.and_then(|nth| elements.get(nth as usize));
        let name = match &ported {
            Some(ported) if code::is_loose(source, &block.layout) => {
                ported.block.clone().unwrap_or_default()
            }
            Some(_) | None => {
                code::gl_name(&block.layout.name, nth.map_or(&[], |nth| nth.as_slice()))
            }
        };
        let writable = access::writable(&block.layout, &shader.files, source.language);
        let kind = bound::kind(&block.layout, bytes, writable);
        resources.push(Resource { name, group: 0, binding: 0, kind });
    }
    for handle in made.handles() {
        let name = match &ported {
            Some(ported) => ported.new_path(&handle.path),
            None => handle.path.clone(),
        };
        if resources.iter().any(|known: &Resource| known.name == name) {
            continue;
        }
        let kind = bound::texture(bound::colour(&request.textures, &handle.path));
        resources.push(Resource { name, group: 0, binding: 0, kind });
    }
    Ok(Made { stages, resources, results: nothing(glsl::RESULTS), stage })
}

/// A vertex stage that writes zeros to whatever the fragment stage after it reads.
fn zeroed(vertex: &str, fragment: &StageCode, source: &Source, options: &Options) -> String {
    let text = Arc::from(fragment.glsl.as_deref().unwrap_or_default());
    let fragment = Source { text, stage: Some(Stage::Fragment), ..source.clone() };
    let Ok(module) = Module::new(&fragment, options) else { return vertex.to_string() };
    let Some((head, main)) = vertex.rsplit_once("void main() {") else {
        return vertex.to_string();
    };
    let mut text = head.to_string();
    for (scalar, vector) in [("float", "vec"), ("int", "ivec"), ("uint", "uvec")] {
        for ty in
            [scalar.to_string(), format!("{vector}2"), format!("{vector}3"), format!("{vector}4")]
        {
            let _ = writeln!(text, "void landfall_zero(out {ty} x) {{ x = {ty}(0); }}");
        }
    }
    text.push_str("void main() {");
    for input in module.inputs() {
        let _ = write!(text, "\n    landfall_zero({});", input.name);
    }
    text.push_str(main);
    text
}

fn ported(source: &Source, options: &Options) -> Result<Ported, Failure> {
    let options = PortOptions { read: options.read.clone(), ..PortOptions::default() };
    port(source, &options).map_err(|found| refused(&found))
}

fn nothing(name: &str) -> Resource {
    let kind = ResourceKind::Storage { bytes: Vec::new(), writable: true };
    Resource { name: name.to_string(), group: 0, binding: 0, kind }
}

/// For wgpu: the added text as a module.
fn module(
    source: &Source,
    options: &Options,
    request: &Request,
    text: &str,
    stage: Runs,
    entry: &str,
) -> Result<Made, Failure> {
    let text = Source { text: Arc::from(text), stage: Some(stage.into()), ..source.clone() };
    let module = Module::new(&text, options).and_then(without_interface);
    let module = module.map_err(|found| refused(&found))?;
    let is_results =
        |block: &BlockLayout| [glsl::RESULTS, "landfall_words"].contains(&&*block.name);
    let bytes =
        bound::blocks(&module, &request.data, bound::zeros).map_err(|found| refused(&[*found]))?;
    let files = module.files().clone();
    let writable = |block: &BlockLayout| access::writable(block, &files, source.language);
    let mut resources = bound::resources(&module, bytes, writable, &request.textures);
    let at = resources
        .iter()
        .position(|resource| [glsl::RESULTS, "landfall_words"].contains(&resource.name.as_str()));
    let found = module.blocks().iter().any(|block| is_results(&block.layout));
    let (Some(at), true) = (at, found) else {
        return Err(Failure::refused("the module lost its results", ""));
    };
    let results = resources.remove(at);
    let code = |stage: Stage, entry: &str, module: Module| StageCode {
        stage,
        entry: entry.to_string(),
        module: Some(Arc::new(module)),
        glsl: None,
        spirv: None,
    };
    let mut stages = vec![code(stage.into(), entry, module)];
    if stage == Runs::Vertex {
        let made = Module::new(&partner::fragment(source), &Options::default());
        stages.push(code(Stage::Fragment, "main", made.map_err(|found| refused(&found))?));
    }
    Ok(Made { stages, resources, results, stage })
}

fn refused(found: &[Diagnostic]) -> Failure {
    let first = found.first().map_or("no reason given", |first| first.message.as_str());
    Failure::refused(format!("the call cannot be run: {first}"), "")
}

fn glsl_text(
    source: &Source,
    function: &str,
    found: &Found<'_>,
    slots: &Slots,
    stage: Runs,
) -> String {
    let head = glsl::Head::of(&source.text);
    let mut text = glsl::aside(source, &head);
    glsl::results(&mut text, source, stage, &head);
    let mut body = String::new();
    let mut names = Vec::new();
    let types = found.info.parameters.iter().zip(&found.signature.parameters);
    for (at, ((info, parameter), slot)) in types.zip(&slots.parameters).enumerate() {
        let name = format!("landfall_a{at}");
        let _ = writeln!(body, "    {};", declared(&info.ty, &name));
        let mut slot = *slot;
        if info.direction != Direction::Out {
            for (path, scalar) in paths(&parameter.ty).iter().zip(parameter.ty.scalars()) {
                let value = match (held_as(scalar).kind, scalar.width) {
                    (ScalarKind::Bool, _) => format!("landfall_words[{slot}] != 0u"),
                    (ScalarKind::Uint, _) => format!("landfall_words[{slot}]"),
                    (ScalarKind::Sint, _) => format!("int(landfall_words[{slot}])"),
                    (_, 8) => format!(
                        "packDouble2x32(uvec2(landfall_words[{slot}], landfall_words[{}]))",
                        slot + 1
                    ),
                    (_, _) => format!("uintBitsToFloat(landfall_words[{slot}])"),
                };
                let _ = writeln!(body, "    {name}{path} = {value};");
                slot += wide(scalar);
            }
        }
        names.push(name);
    }
    let call = format!("{function}({})", names.join(", "));
    match &found.info.returns {
        Some(ty) => {
            let _ = writeln!(body, "    {} = {call};", declared(ty, "landfall_result"));
        }
        None => {
            let _ = writeln!(body, "    {call};");
        }
    }
    let mut store = |name: &str, ty: &ValueType, mut slot: u32| {
        for (path, scalar) in paths(ty).iter().zip(ty.scalars()) {
            let from = format!("{name}{path}");
            let _ = match (held_as(scalar).kind, scalar.width) {
                (ScalarKind::Bool, _) => {
                    writeln!(body, "    landfall_words[{slot}] = {from} ? 1u : 0u;")
                }
                (ScalarKind::Uint | ScalarKind::Sint, _) => {
                    writeln!(body, "    landfall_words[{slot}] = uint({from});")
                }
                (_, 8) => writeln!(
                    body,
                    "    {{ uvec2 landfall_halves = unpackDouble2x32({from}); \
                     landfall_words[{slot}] = landfall_halves.x; \
                     landfall_words[{}] = landfall_halves.y; }}",
                    slot + 1
                ),
                (_, _) => writeln!(body, "    landfall_words[{slot}] = floatBitsToUint({from});"),
            };
            slot += wide(scalar);
        }
    };
    for ((name, parameter), slot) in
        names.iter().zip(&found.signature.parameters).zip(&slots.parameters)
    {
        if parameter.returned {
            store(name, &parameter.ty, *slot);
        }
    }
    if let Some(ty) = &found.signature.result {
        store("landfall_result", ty, slots.result);
    }
    glsl::main(&mut text, stage, &body);
    text
}

/// `float name[4]` of the type `float[4]`.
fn declared(ty: &str, name: &str) -> String {
    let (base, dims) = ty.split_at(ty.find('[').unwrap_or(ty.len()));
    format!("{base} {name}{dims}")
}

fn wgsl_text(
    source: &Source,
    parameters: &[Parameter],
    found: &Found<'_>,
    slots: &Slots,
    stage: Runs,
) -> String {
    let mut text = source.text.to_string();
    let binding = wgsl::free_binding(&text);
    let _ = write!(
        text,
        "\n@group(0) @binding({binding}) var<storage, read_write> landfall_words: array<u32>;\n"
    );
    let mut body = String::new();
    let mut passed = Vec::new();
    for (at, parameter) in found.signature.parameters.iter().enumerate() {
        let name = format!("landfall_a{at}");
        let ty = parameters.get(at).map_or("", |parameter| parameter.ty.as_str());
        let _ = writeln!(body, "    var {name}: {ty};");
        let mut slot = slots.parameters[at];
        for (path, scalar) in paths(&parameter.ty).iter().zip(parameter.ty.scalars()) {
            let value = match held_as(scalar).kind {
                ScalarKind::Bool => format!("landfall_words[{slot}] != 0u"),
                ScalarKind::Uint => format!("landfall_words[{slot}]"),
                ScalarKind::Sint => format!("bitcast<i32>(landfall_words[{slot}])"),
                ScalarKind::Float
                | ScalarKind::Bfloat
                | ScalarKind::FloatE5m2
                | ScalarKind::FloatE4m3 => format!("bitcast<f32>(landfall_words[{slot}])"),
            };
            let _ = writeln!(body, "    {name}{path} = {value};");
            slot += wide(scalar);
        }
        passed.push(if parameter.returned { format!("&{name}") } else { name });
    }
    let call = format!("{}({})", found.info.name, passed.join(", "));
    let mut stores = Vec::new();
    if let Some(ty) = &found.signature.result {
        let _ = writeln!(body, "    var landfall_result = {call};");
        stores.push(("landfall_result".to_string(), ty, slots.result));
    } else {
        let _ = writeln!(body, "    {call};");
    }
    for (at, parameter) in found.signature.parameters.iter().enumerate() {
        if parameter.returned {
            stores.push((format!("landfall_a{at}"), &parameter.ty, slots.parameters[at]));
        }
    }
    for (name, ty, mut slot) in stores {
        for (path, scalar) in paths(ty).iter().zip(ty.scalars()) {
            let from = format!("{name}{path}");
            let value = match held_as(scalar).kind {
                ScalarKind::Bool => format!("select(0u, 1u, {from})"),
                ScalarKind::Uint => from,
                ScalarKind::Sint
                | ScalarKind::Float
                | ScalarKind::Bfloat
                | ScalarKind::FloatE5m2
                | ScalarKind::FloatE4m3 => format!("bitcast<u32>({from})"),
            };
            let _ = writeln!(body, "    landfall_words[{slot}] = {value};");
            slot += wide(scalar);
        }
    }
    wgsl::entry(&mut text, ENTRY, stage, &body);
    text
}
