//! Reads scenes from JSON: checks every value and reports all errors at once, each with its place.
//!
//! [`landfall_layout::text::json`] parses values with their spans, `walk` traverses them and
//! collects errors; a file each reads lights, materials, objects and random scenes.

mod generate;
mod lights;
mod materials;
mod objects;
mod walk;

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use serde_json::{Map, Value};

use super::{Camera, Lights, Scene, Space};
use landfall_layout::diagnostic::Code;
use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::error::Error;
use landfall_layout::file::read_whole;
use landfall_layout::source::{Files, Span, decode};
use landfall_layout::text::json;
pub use landfall_layout::text::json::Fault;
#[cfg(feature = "schema")]
pub(super) use lights::ATTENUATIONS;
use walk::{Object, SceneWalk, ValueAt};

pub const MAX_PIXELS: u64 = 1 << 24;

/// The largest size in bytes of a file that a scene names.
const MAX_BYTES: u64 = 1 << 28;

/// Opens a file that a scene names, by the name as written; returns its bytes.
pub type FileOpener<'a> = dyn Fn(&str) -> Result<Vec<u8>, Error> + 'a;

#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// The scene, if there are no errors.
    pub scene: Option<Scene>,
    /// The scene's own text, then the meshes it names, and its textures without their bytes.
    pub files: Files,
    pub diagnostics: Vec<Diagnostic>,
}

impl Reading {
    /// Returns the span of a value by its path in messages: `bind.count`, `lights.point[3]`. Used
    /// for diagnostics about members that only a renderer understands.
    pub fn place(&self, path: &str) -> Option<Span> {
        let text = &self.files.get(0)?.text;
        let found = landfall_layout::text::locate::locate(text, path)?.value;
        Some(Span { file: 0, start: found.start as u32, end: found.end as u32 })
    }
}

/// Reads a scene from a file; paths in it are relative to its directory.
///
/// # Errors
/// The file cannot be read or is not UTF-8. Errors inside it are among the diagnostics.
pub fn read_file(path: impl AsRef<Path>) -> Result<Reading, Error> {
    let path = path.as_ref();
    let shown = path.display().to_string();
    let text = decode(&shown, bytes(path)?)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(read(&shown, &text, &|name| bytes(&folder.join(name))))
}

/// Reads a scene from its text; `open` opens the files it names.
pub fn read(path: &str, text: &str, open: &FileOpener<'_>) -> Reading {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut walk = SceneWalk::default();
    if u32::try_from(text.len()).is_err() {
        let error = Error::new(path, "is longer than 4 GiB");
        return Reading { diagnostics: vec![error.into()], ..Reading::default() };
    }
    walk.files.add(path, Arc::from(text));
    let scene = match json::parse(text) {
        Ok(root) => scene(&mut walk, ValueAt::root(&root), text, path, open),
        Err(fault) => {
            walk.push(invalid_json(text, &fault));
            None
        }
    };
    // A scene with an error is none, even if all of its values could be read.
    let SceneWalk { files, diagnostics, wrong } = walk;
    Reading { scene: scene.filter(|_| !wrong), files, diagnostics }
}

const MEMBERS: &[&str] = &[
    "$schema",
    "name",
    "description",
    "size",
    "background",
    "space",
    "camera",
    "lights",
    "materials",
    "objects",
    "generate",
    "shader",
    "model",
    "bind",
];

fn scene(
    walk: &mut SceneWalk,
    at: ValueAt<'_>,
    text: &str,
    path: &str,
    open: &FileOpener<'_>,
) -> Option<Scene> {
    let root = walk.object(&at, MEMBERS)?;
    // For people and editors; only their type is checked.
    for key in ["$schema", "description"] {
        root.get(key).and_then(|at| walk.text(&at).map(drop));
    }
    let name = root.optional("name", |at| walk.text(at).map(str::to_string));
    let size = walk.needed(&root, "size").and_then(|at| size(walk, &at));
    let background = root.or("background", DVec3::ZERO, |at| walk.color(at));
    let space = root.or("space", Space::World, |at| space(walk, at));
    let camera = walk.needed(&root, "camera").and_then(|at| camera(walk, &at));
    let mut lights = root.or("lights", Lights::default(), |at| lights::read(walk, at));
    let materials = materials::read(walk, &root, open);
    let mut objects = objects::read(walk, &root, materials.as_deref(), path, open);
    if let Some(at) = root.get("generate") {
        // Generated lights and objects follow those that are listed, so that their indices stay.
        let made = generate::read(walk, &at, materials.as_deref());
        if let (Some((points, strewn)), Some(lights), Some(objects)) =
            (made, &mut lights, &mut objects)
        {
            lights.point.extend(points);
            objects.extend(strewn);
        }
    }
    // Kept as JSON: only a renderer understands them.
    let shader = unparsed(walk, &root, "shader", text, &["a path", "an object"]);
    let model = unparsed(walk, &root, "model", text, &["a name", "an object"]);
    let bind = unparsed(walk, &root, "bind", text, &["an object"]);
    let bind: Option<Map<String, Value>> = match bind {
        Some(Value::Object(map)) => Some(map),
        _ => None,
    };
    Some(Scene {
        name: name?.unwrap_or_else(|| stem(path)),
        size: size?,
        background: background?,
        camera: camera?,
        lights: lights?,
        materials: materials?,
        objects: objects?,
        space: space?,
        shader,
        model,
        bind,
    })
}

fn size(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<[u32; 2]> {
    let [width, height] = walk.items(at)?;
    let most = 1 << 15;
    let (width, height) = (walk.whole(&width, 1..=most), walk.whole(&height, 1..=most));
    let size = [width?, height?];
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    if pixels > MAX_PIXELS {
        let what = format!("is {pixels} pixels, but a picture has at most {MAX_PIXELS}");
        walk.error(Code::TooLarge, at, what);
        return None;
    }
    Some(size)
}

fn space(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Space> {
    let spaces = [
        ("world", Space::World),
        ("view", Space::View),
        ("camera-relative", Space::CameraRelative),
    ];
    walk.one_of(at, &spaces)
}

fn camera(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Camera> {
    let known = &["position", "front", "target", "up", "fov", "near", "far"];
    let object = walk.object(at, known)?;
    let position = walk.needed(&object, "position").and_then(|at| walk.vector(&at));
    let front = front(walk, &object, position);
    let up = object.or("up", DVec3::Y, |at| walk.direction(at));
    if let (Some(front), Some(up)) = (front, up) {
        check_up(walk, &object, front, up);
    }
    let fov = walk.needed(&object, "fov").and_then(|at| fov(walk, &at));
    let near = object.or("near", 0.1, |at| walk.positive(at));
    let far = object.or("far", 100.0, |at| walk.positive(at));
    if let (Some(near), Some(far)) = (near, far) {
        in_order(walk, &object, near, far);
    }
    Some(Camera { position: position?, front: front?, up: up?, fov: fov?, near: near?, far: far? })
}

/// Below a millionth of a radian the cross product has lost half of its digits.
fn check_up(walk: &mut SceneWalk, object: &Object<'_>, front: DVec3, up: DVec3) {
    if front.cross(up).length() >= 1e-6 {
        return;
    }
    let at = object.get("up").or_else(|| object.get("front")).or_else(|| object.get("target"));
    let what = "is parallel to the direction of the camera, so no direction is up";
    walk.error(Code::UpAlongFront, &at.unwrap_or(object.at.clone()), what).help = Some(
        "give an `up` across the direction, such as `[0, 0, -1]` when looking down".to_string(),
    );
}

fn in_order(walk: &mut SceneWalk, object: &Object<'_>, near: f64, far: f64) {
    if near < far {
        return;
    }
    let (near_at, far_at) = (object.get("near"), object.get("far"));
    let help = if near_at.is_some() && far_at.is_some() {
        format!("swap them: `\"near\": {far}, \"far\": {near}`")
    } else {
        "give both `near` and `far`, the near plane in front of the far one".to_string()
    };
    let at = far_at.or(near_at).unwrap_or(object.at.clone());
    let what = format!("leaves nothing to see: the near plane is at {near}, the far one at {far}");
    walk.error(Code::BadPlanes, &at, what).help = Some(help);
}

fn front(walk: &mut SceneWalk, object: &Object<'_>, position: Option<DVec3>) -> Option<DVec3> {
    match (object.get("front"), object.get("target")) {
        (Some(_), Some(target)) => {
            walk.error(Code::GivenTwice, &target, "repeats `front`, the direction of the camera")
                .help = Some("keep one of `front` and `target`".to_string());
            None
        }
        (Some(front), None) => walk.direction(&front),
        (None, Some(at)) => {
            let target = walk.vector(&at)?;
            let front = walk::unit(target - position?);
            if front.is_none() {
                walk.error(
                    Code::ZeroDirection,
                    &at,
                    "is the position of the camera, so the camera has no direction",
                );
            }
            front
        }
        (None, None) => {
            walk.error(Code::MissingMember, &object.at, "has no direction").help =
                Some("add `front`, a direction, or `target`, a position".to_string());
            None
        }
    }
}

fn fov(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<f64> {
    let fov = walk.number(at)?;
    if fov <= 0.0 || fov >= 180.0 {
        let what = format!("is {fov} degrees: a field of view lies between 0 and 180");
        walk.error(Code::ValueOutOfRange, at, what);
        return None;
    }
    if fov <= std::f64::consts::FRAC_PI_2 {
        let degrees = walk::round_to_four_digits(fov.to_degrees());
        walk.warning(Code::SuspiciousUnit, at, format!("is {fov} degrees, a very narrow view"))
            .help = Some(format!("if that is in radians, write {degrees}"));
    }
    Some(fov)
}

/// Returns a member as unparsed JSON.
fn unparsed(
    walk: &mut SceneWalk,
    root: &Object<'_>,
    key: &str,
    text: &str,
    wanted: &[&str],
) -> Option<Value> {
    let at = root.get(key)?;
    let fits = match at.node.value {
        json::Value::Text(_) => wanted.len() > 1,
        json::Value::Object(_) => true,
        _ => false,
    };
    if !fits {
        walk.kind(&at, &wanted.join(" or "));
        return None;
    }
    match serde_json::from_str(&text[at.node.start..at.node.end]) {
        Ok(value) => Some(value),
        Err(_) => {
            walk.error(Code::WrongValue, &at, "is nested too deeply");
            None
        }
    }
}

fn stem(path: &str) -> String {
    Path::new(path).file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into())
}

/// Returns the bytes of a file, up to the size limit.
fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    if !path.metadata().is_ok_and(|found| found.len() > MAX_BYTES) {
        return read_whole(path, MAX_BYTES);
    }
    let shown = path.display().to_string();
    let message = format!("is over {} MiB long, too large for a part of a scene", MAX_BYTES >> 20);
    Err(Error::new(&shown, message).unreadable())
}

fn invalid_json(text: &str, fault: &Fault) -> Diagnostic {
    let span = |start: usize, len: usize| {
        let start = start.min(text.len());
        let mut end = (start + len).min(text.len());
        while !text.is_char_boundary(end) {
            end += 1;
        }
        Span { file: 0, start: start as u32, end: end as u32 }
    };
    match fault {
        Fault::Truncated => {
            let message = "the text ends before the scene is complete";
            Diagnostic::error(Code::JsonSyntax, span(text.trim_end().len(), 1), message)
        }
        Fault::Twice { at, key } => {
            let message = format!("`{}` occurs twice in one object", walk::short(key));
            Diagnostic::error(Code::GivenTwice, span(*at, key.len() + 2), message)
        }
        Fault::Deep { at } => {
            let message = "the scene is nested too deeply";
            Diagnostic::error(Code::JsonSyntax, span(*at, 1), message)
        }
        Fault::Expected { at, wanted } => {
            let rest = &text[*at..];
            let is_part = |c: char| c.is_ascii_alphanumeric() || "+-.".contains(c);
            let word = &rest[..rest.find(|c| !is_part(c)).unwrap_or(rest.len())];
            let at = span(*at, word.len().max(1));
            match word.parse::<f64>() {
                Ok(number) if !number.is_finite() => {
                    let message = format!("`{}` is not finite", walk::short(word));
                    Diagnostic::error(Code::NotFinite, at, message)
                        .with_note("JSON has neither NaN nor infinity")
                }
                _ => Diagnostic::error(Code::JsonSyntax, at, format!("expected {wanted}")),
            }
        }
    }
}
