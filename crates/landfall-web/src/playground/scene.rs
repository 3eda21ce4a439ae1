//! What a browser needs to draw a scene of lights with a shader: the shader in GLSL ES 3.00 or its own
//! WGSL, the fragments with the values of their inputs, and the bytes of its blocks.
//!
//! All of it is what `landfall render` gives to a backend: the browser is one more.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use data_encoding::BASE64;
use landfall_exec::harness::fragments::{EsText, WgslTexts};
use landfall_layout::format::{Paint, diagnostics};
use landfall_layout::{Error, Options, Source};
use landfall_light::bind::{Kind, OverflowPolicy};
use landfall_light::culling::{LightSet, parse};
use landfall_light::reference::Model;
use landfall_light::render::truth::{likely_model, truth};
use landfall_light::render::{Draw, RenderError, RenderOptions, Renderer, SceneShader, Work};
use landfall_light::scene::{Attenuation, MAX_PIXELS, PointLight, read};
use landfall_light::shading_f32;
use landfall_light::{Chosen, Fragment, Frame, Scene, Upload};
use serde::{Deserialize, Serialize};

use super::json;

/// A scene, and the parts of it that are asked for.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct SceneRequest {
    /// The path of the scene, for messages and for what it names.
    path: String,
    /// Its text.
    scene: String,
    /// What it names, meshes and textures: names, and bytes in base64.
    assets: Vec<(String, String)>,
    /// The size of the picture, instead of the scene's.
    size: Option<[u32; 2]>,
    /// Whether to give the text of the shader.
    shader: bool,
    /// Whether to give the fragments.
    frame: bool,
    /// Whether to give the point lights, random ones last.
    points: bool,
    /// What is left out, as in `--skip`, to count it.
    skip: Option<String>,
    /// A pixel whose light by the reference is asked for.
    probe: Option<[u32; 2]>,
}

#[derive(Serialize)]
struct SceneAnswer {
    /// Errors and warnings as the command prints them; without a scene there is nothing else.
    findings: String,
    #[serde(flatten)]
    drawn: Option<DrawnScene>,
}

#[derive(Serialize)]
struct DrawnScene {
    size: [u32; 2],
    background: [f64; 3],
    camera: CameraObject,
    /// The slots of the shader for directional, point and spot lights; `None` for any number.
    slots: [Option<usize>; 3],
    /// The lights that every fragment evaluates.
    evaluated: u64,
    /// The evaluations of lights over all fragments that remain with `skip`, and those without it.
    skipping: Option<[u64; 2]>,
    /// For each material: the bytes of the blocks, and the textures.
    materials: Vec<MaterialObject>,
    /// The blocks by name and instance.
    blocks: Vec<[String; 2]>,
    notes: Vec<String>,
    shader: Option<ShaderObject>,
    frame: Option<FrameObject>,
    points: Option<Vec<PointObject>>,
    /// The light of the probe by the reference; `None` where nothing is drawn or it is undefined.
    probe: Option<[f32; 3]>,
}

#[derive(Serialize)]
struct CameraObject {
    position: [f64; 3],
    front: [f64; 3],
    up: [f64; 3],
    fov: f64,
}

/// A point light as scenes have it.
#[derive(Serialize)]
struct PointObject {
    position: [f64; 3],
    color: [f64; 3],
    intensity: f64,
    attenuation: AttenuationObject,
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<f64>,
}

#[derive(Serialize)]
struct AttenuationObject {
    constant: f64,
    linear: f64,
    quadratic: f64,
}

impl PointObject {
    fn of(PointLight { position, emission, attenuation }: &PointLight) -> PointObject {
        let Attenuation { constant, linear, quadratic, range } = *attenuation;
        PointObject {
            position: position.to_array(),
            color: emission.color.to_array(),
            intensity: emission.intensity,
            attenuation: AttenuationObject { constant, linear, quadratic },
            range,
        }
    }
}

#[derive(Serialize)]
struct MaterialObject {
    /// In base64.
    blocks: Vec<String>,
    textures: Vec<TextureObject>,
}

#[derive(Serialize)]
struct TextureObject {
    width: u32,
    height: u32,
    /// Four `f32` a texel, in base64.
    texels: String,
}

/// The shader for the interfaces of a browser.
#[derive(Serialize)]
struct ShaderObject {
    /// Name, components and kind of each input: the frame's values are for these.
    inputs: Vec<String>,
    webgl: Result<EsObject, String>,
    /// `None` for GLSL.
    webgpu: Option<Result<WgslObject, String>>,
}

#[derive(Serialize)]
struct EsObject {
    text: String,
    blocks: Vec<Option<String>>,
    samplers: Vec<(String, Option<usize>)>,
}

#[derive(Serialize)]
struct WgslObject {
    vertex: String,
    fragment: String,
    entry: String,
    /// The inputs that are attributes, by their index among those of the frame.
    attributes: Vec<usize>,
    /// Group, binding and type.
    blocks: Vec<(u32, u32, &'static str)>,
    textures: Vec<(u32, u32)>,
    samplers: Vec<(u32, u32)>,
}

#[derive(Serialize)]
struct FrameObject {
    /// The pixel of each fragment, counted from the top left: `u32` in base64.
    pixels: String,
    /// The material of each: `u32` in base64.
    materials: String,
    /// The values of each input: components, and `f32` of all fragments in base64.
    inputs: Vec<(u8, String)>,
}

/// What is kept between requests: a slider changes lights alone.
struct KeptScene {
    key: String,
    renderer: Renderer,
    frame: Option<Frame>,
}

static KEPT: Mutex<Option<KeptScene>> = Mutex::new(None);

/// Answers with the parts of a scene that are asked for.
pub(super) fn scene(
    given: &SceneRequest,
    source: &Source,
    options: &Options,
) -> Result<String, Error> {
    // Files that were dropped into the page have no folders.
    let base = |path: &str| path.rsplit('/').next().unwrap_or_default().to_string();
    let open = |name: &str| {
        let by = |same: &dyn Fn(&str) -> bool| given.assets.iter().find(|(path, _)| same(path));
        let found = by(&|path| path == name).or_else(|| by(&|path| base(path) == base(name)));
        let bytes = found.and_then(|(_, text)| BASE64.decode(text.as_bytes()).ok());
        bytes.ok_or_else(|| Error::new(name, "is not among the files of the page"))
    };
    let reading = read(&given.path, &given.scene, &open);
    let findings = diagnostics::human(&reading.diagnostics, &reading.files, Paint::Plain);
    let Some(mut scene) = reading.scene else {
        return Ok(json(&SceneAnswer { findings, drawn: None }));
    };
    if let Some(size) = given.size {
        scene.size = size;
    }
    if u64::from(scene.size[0]) * u64::from(scene.size[1]) > MAX_PIXELS {
        return Err(Error::new("the picture", format!("has more than {MAX_PIXELS} pixels")));
    }
    match draw(given, &scene, source, options) {
        Ok(drawn) => Ok(json(&SceneAnswer { findings, drawn: Some(drawn) })),
        Err(message) => Err(Error::new(&source.path, message)),
    }
}

fn draw(
    given: &SceneRequest,
    scene: &Scene,
    source: &Source,
    options: &Options,
) -> Result<DrawnScene, String> {
    let named = SceneShader::new(scene, &given.path).map_err(|error| error.message)?;
    let mut read = options.read.clone();
    read.defines.splice(0..0, named.defines);
    let layout = options.clone().with_read(read);
    let key = format!("{source:?} {layout:?} {:?} {:?}", named.entry, scene.bind);
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if kept.as_ref().is_none_or(|kept| kept.key != key) {
        let bind = scene.bind.iter().collect();
        let options = RenderOptions { layout, entry: named.entry.as_deref(), bind };
        let renderer = Renderer::new(source, &options).map_err(|error| said(&error))?;
        *kept = Some(KeptScene { key, renderer, frame: None });
    }
    let kept = kept.as_mut().expect("it was put there");
    let mut upload = Upload::new(scene);
    let lit = kept.renderer.lights(&upload, OverflowPolicy::LeaveOut);
    let lit = lit.map_err(|error| error.to_string())?;
    upload.lights.truncate(lit.counts());
    // A new shader has none yet.
    let counts = kept.frame.is_none() && (given.probe.is_some() || given.skip.is_some());
    if given.frame || counts {
        kept.frame = Some(Frame::new(scene, &named.frame));
    }
    let renderer = &kept.renderer;
    let draw = Draw { fragments: &[], lights: &lit, tiles: None };
    let empty = Frame::default();
    let frame = kept.frame.as_ref().unwrap_or(&empty);
    let work = Work { upload: &upload, frame, background: scene.background, limit: Duration::MAX };
    let materials = (0..upload.materials.len() as u32).map(|material| {
        let fragment = Fragment { material, ..ORIGIN };
        let one = Chosen { all: std::slice::from_ref(&fragment), numbers: &[0] };
        let prepared = renderer.prepare(&work, one, &draw).map_err(|error| said(&error))?;
        let textures = prepared.textures.iter().map(|image| TextureObject {
            width: image.width,
            height: image.height,
            texels: floats(image.texels.iter().flatten().copied()),
        });
        let blocks = prepared.blocks.iter().map(|bytes| BASE64.encode(bytes)).collect();
        Ok(MaterialObject { blocks, textures: textures.collect() })
    });
    let slots = Kind::ALL.map(|kind| Some(renderer.slots(kind)).filter(|n| *n != usize::MAX));
    let camera = &scene.camera;
    Ok(DrawnScene {
        size: scene.size,
        background: scene.background.to_array(),
        camera: CameraObject {
            position: camera.position.to_array(),
            front: camera.front.to_array(),
            up: camera.up.to_array(),
            fov: camera.fov,
        },
        slots,
        evaluated: renderer.evaluated(&lit),
        skipping: match &given.skip {
            Some(skip) => Some(skipping(renderer, skip, model_of(renderer, scene), &work)?),
            None => None,
        },
        materials: materials.collect::<Result<_, String>>()?,
        blocks: renderer
            .shader
            .blocks()
            .iter()
            .map(|block| {
                let instance = block.layout.instance.as_deref().unwrap_or_default();
                [block.layout.name.to_string(), instance.to_string()]
            })
            .collect(),
        notes: renderer.notes(&upload),
        shader: given.shader.then(|| shader(renderer)),
        frame: given.frame.then(|| fragments(renderer, &work, &draw)).transpose()?,
        points: given.points.then(|| scene.lights.point.iter().map(PointObject::of).collect()),
        probe: given
            .probe
            .and_then(|pixel| probe(&model_of(renderer, scene), &upload, frame, pixel)),
    })
}

/// A fragment of which only the material counts.
const ORIGIN: Fragment = Fragment {
    pixel: 0,
    material: 0,
    object: 0,
    position: [0.0; 3],
    normal: [0.0; 3],
    uv: [0.0; 2],
};

/// The model of the scene, or the most likely one of the shader.
fn model_of(renderer: &Renderer, scene: &Scene) -> Model {
    let own = scene.model.clone().and_then(|model| serde_json::from_value(model).ok());
    own.unwrap_or_else(|| likely_model(&renderer.map))
}

/// The evaluations of lights with a plan, and without one.
fn skipping(
    renderer: &Renderer,
    skip: &str,
    model: Model,
    work: &Work<'_>,
) -> Result<[u64; 2], String> {
    let plan = renderer.plan(work, &shading_f32::Model::new(&model)?, &parse(skip)?);
    let whole = LightSet::all(&work.upload.lights);
    let draws = plan.draws.iter();
    let rest =
        draws.map(|draw| draw.fragments.len() as u64 * renderer.evaluated(&draw.lights)).sum();
    Ok([rest, work.frame.fragments.len() as u64 * renderer.evaluated(&whole)])
}

fn shader(renderer: &Renderer) -> ShaderObject {
    let shader = &renderer.shader;
    let es = |es: EsText| EsObject { text: es.text, blocks: es.blocks, samplers: es.samplers };
    let located = shader.inputs().iter().enumerate().filter(|(_, input)| input.location.is_some());
    let wgsl = |texts: WgslTexts| WgslObject {
        vertex: texts.vertex,
        fragment: texts.fragment,
        entry: texts.entry,
        attributes: located.map(|(number, _)| number).collect(),
        blocks: texts.blocks.iter().map(|(group, at, kind)| (*group, *at, kind.name())).collect(),
        textures: texts.textures,
        samplers: texts.samplers,
    };
    ShaderObject {
        inputs: shader.inputs().iter().map(|input| format!("{input:?}")).collect(),
        webgl: shader.es().map(es),
        webgpu: shader.wgsl().map(|texts| texts.map(wgsl)).transpose(),
    }
}

fn fragments(renderer: &Renderer, work: &Work<'_>, draw: &Draw<'_>) -> Result<FrameObject, String> {
    let all = &work.frame.fragments;
    let numbers = work.frame.numbers();
    let chosen = Chosen { all, numbers: &numbers };
    let prepared = renderer.prepare(work, chosen, draw).map_err(|error| said(&error))?;
    let words = |word: fn(&Fragment) -> u32| {
        let bytes: Vec<u8> = all.iter().flat_map(|one| word(one).to_le_bytes()).collect();
        BASE64.encode(&bytes)
    };
    let inputs = renderer.shader.inputs().iter().zip(&prepared.inputs).map(|(input, values)| {
        let count = usize::from(input.components);
        let numbers = values.iter().flat_map(|value| value[..count].iter().copied());
        (input.components, floats(numbers))
    });
    Ok(FrameObject {
        inputs: inputs.collect(),
        pixels: words(|fragment| fragment.pixel),
        materials: words(|fragment| fragment.material),
    })
}

fn probe(
    model: &Model,
    upload: &Upload,
    frame: &Frame,
    [column, row]: [u32; 2],
) -> Option<[f32; 3]> {
    let pixel = row.checked_mul(frame.width)?.checked_add(column)?;
    let at = frame.fragments.binary_search_by_key(&pixel, |fragment| fragment.pixel).ok()?;
    let fragment = Fragment { pixel: 0, ..frame.fragments[at] };
    let one = Frame { width: 1, height: 1, fragments: vec![fragment] };
    // Every pixel of it has a fragment: the colour behind is not seen.
    let truth = truth(model, upload, &one, upload.camera);
    let [r, g, b, _] = *truth.picture.pixels.first()?;
    (truth.undefined.is_empty()).then_some([r, g, b])
}

fn said(error: &RenderError) -> String {
    match error {
        RenderError::Bind(bind) => match bind.help() {
            Some(help) => format!("{bind}: {help}"),
            None => bind.to_string(),
        },
        RenderError::Shader(_) | RenderError::Backend(_) => error.to_string(),
    }
}

fn floats(values: impl Iterator<Item = f32>) -> String {
    let bytes: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
    BASE64.encode(&bytes)
}
