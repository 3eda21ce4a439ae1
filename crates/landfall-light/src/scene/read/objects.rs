//! Reads the objects of a scene: meshes, transforms and materials.

use landfall_layout::diagnostic::Code;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3};

use super::FileOpener;
use super::walk::{Object as Members, SceneWalk, ValueAt, short};
use crate::scene::{LARGEST, MAX_TRIANGLES};
use crate::scene::{Material, Mesh, Object, mesh, read_obj};
use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::source::{Span, decode};
use landfall_layout::text::edit_distance::suggestion;
pub use landfall_layout::text::json::Value;

pub(super) fn read(
    walk: &mut SceneWalk,
    root: &Members<'_>,
    materials: Option<&[Material]>,
    path: &str,
    open: &FileOpener<'_>,
) -> Option<Vec<Object>> {
    let Some(at) = root.get("objects") else { return Some(Vec::new()) };
    let mut reader = ObjectReader { materials, path, open, obj: HashMap::new() };
    let mut objects = Vec::new();
    let mut triangles = 0;
    let mut whole = true;
    for at in walk.list(&at)? {
        match reader.object(walk, &at) {
            Some(object) => {
                triangles += object.mesh.triangles.len();
                objects.push(object);
            }
            None => whole = false,
        }
        if triangles > MAX_TRIANGLES {
            let what = format!("exceeds the limit of {MAX_TRIANGLES} triangles in a scene");
            walk.error(Code::TooLarge, &at, what);
            return None;
        }
    }
    whole.then_some(objects)
}

struct ObjectReader<'r> {
    materials: Option<&'r [Material]>,
    /// The path of the scene, to whose directory file names are relative.
    path: &'r str,
    open: &'r FileOpener<'r>,
    /// The files read so far; `None` for an invalid one.
    obj: HashMap<String, Option<Mesh>>,
}

impl ObjectReader<'_> {
    fn object(&mut self, walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Object> {
        let object =
            walk.object(at, &["name", "mesh", "material", "position", "rotation", "scale"])?;
        object.get("name").and_then(|at| walk.text(&at).map(drop));
        let mesh = walk.needed(&object, "mesh").and_then(|at| self.mesh(walk, &at));
        let material = material(walk, &object, self.materials);
        let position = object.or("position", DVec3::ZERO, |at| walk.vector(at));
        let rotation = object.or("rotation", DMat3::IDENTITY, |at| rotation(walk, at));
        let scale = object.or("scale", DVec3::ONE, |at| scale(walk, at));
        // Scaled first, then rotated, then moved.
        let mut transform = DMat4::from_mat3(rotation? * DMat3::from_diagonal(scale?));
        transform.w_axis = position?.extend(1.0);
        let object = Object { mesh: mesh?, material: material?, transform };
        near_enough(walk, at, &object)?;
        Some(object)
    }

    fn mesh(&mut self, walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Mesh> {
        let simple = [
            ("cube", mesh::cube as fn() -> Mesh),
            ("plane", || mesh::plane(1.0)),
            ("sphere", || mesh::sphere(32, 16)),
        ];
        match &at.node.value {
            Value::Text(name) if name.to_ascii_lowercase().ends_with(".obj") => {
                let found = walk.error(
                    Code::WrongValue,
                    at,
                    format!("is {:?}, which is a file", short(name)),
                );
                found.help = Some(format!("write `{{\"obj\": {:?}}}`", short(name)));
                None
            }
            Value::Text(_) => walk.one_of(at, &simple).map(|make| make()),
            Value::Object(_) => self.shaped(walk, at),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::List(_) => {
                walk.kind(at, "`\"cube\"`, `\"plane\"`, `\"sphere\"`, or an object with one of `plane`, `sphere` and `obj`");
                None
            }
        }
    }

    fn shaped(&mut self, walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Mesh> {
        let object = walk.object(at, &["plane", "sphere", "obj"])?;
        if object.keys().count() != 1 {
            walk.error(Code::WrongValue, at, "is not exactly one of `plane`, `sphere` and `obj`");
            return None;
        }
        if let Some(at) = object.get("plane") {
            let plane = walk.object(&at, &["repeat"])?;
            return plane.or("repeat", 1.0, |at| walk.positive(at)).map(mesh::plane);
        }
        if let Some(at) = object.get("sphere") {
            let sphere = walk.object(&at, &["segments", "rings"])?;
            let mut part =
                |key, least, default| sphere.or(key, default, |at| walk.whole(at, least..=1024));
            let (segments, rings) = (part("segments", 3, 32), part("rings", 2, 16));
            return Some(mesh::sphere(segments?, rings?));
        }
        self.obj(walk, &object.get("obj")?)
    }

    fn obj(&mut self, walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Mesh> {
        let name = walk.text(at)?;
        if let Some(read) = self.obj.get(name) {
            return read.clone();
        }
        let mesh = self.new_obj(walk, at, name);
        // A file that cannot be read is remembered too, so that its errors are told once.
        self.obj.insert(name.to_string(), mesh.clone());
        mesh
    }

    fn new_obj(&self, walk: &mut SceneWalk, at: &ValueAt<'_>, name: &str) -> Option<Mesh> {
        let text = match (self.open)(name).and_then(|bytes| decode(name, bytes)) {
            Ok(text) => text,
            Err(error) => {
                walk.error(Code::UnreadableFile, at, error.message).help = error.help;
                return None;
            }
        };
        // The file is added to the scene's, so that its errors show its lines.
        let read = read_obj(&text);
        let shown = Path::new(self.path).with_file_name(name).display().to_string();
        let file = walk.files.add(shown, Arc::from(text));
        let span =
            |at: &std::ops::Range<usize>| Span { file, start: at.start as u32, end: at.end as u32 };
        match read {
            Err(faults) => {
                for fault in faults {
                    let mut found =
                        Diagnostic::error(Code::WrongMesh, span(&fault.at), fault.message);
                    found.help = fault.help;
                    walk.push(found);
                }
                None
            }
            Ok(read) => {
                if let Some(first) = &read.first_flat {
                    let message = format!(
                        "`{}` has no normals for {} of its {} triangles: they are drawn flat",
                        short(name),
                        read.flat,
                        read.triangles
                    );
                    let found = Diagnostic::warning(Code::MeshWithoutNormals, span(first), message);
                    walk.push(
                        found.with_help(
                            "write the file with normals, as corners `position/uv/normal`",
                        ),
                    );
                }
                Some(read.mesh)
            }
        }
    }
}

/// Reports corners farther out than positions may be.
fn near_enough(walk: &mut SceneWalk, at: &ValueAt<'_>, object: &Object) -> Option<()> {
    let corners = object.mesh.vertices.iter();
    let out = |at: DVec3| object.transform.transform_point3(at).abs().max_element() > LARGEST;
    if !corners.map(|vertex| vertex.position).any(out) {
        return Some(());
    }
    walk.error(Code::TooLarge, at, "has corners beyond 1e18, whose squares overflow an `f32`");
    None
}

/// Returns the index of a material by its name. A scene's only material need not be named.
pub(super) fn material(
    walk: &mut SceneWalk,
    object: &Members<'_>,
    materials: Option<&[Material]>,
) -> Option<usize> {
    let given = object.optional("material", |at| Some((walk.text(at)?, at.clone())))?;
    // Errors in the materials were already reported.
    let materials = materials?;
    let Some((name, at)) = given else {
        if materials.len() == 1 {
            return Some(0);
        }
        let what =
            format!("has no `material`, and the scene has {} to choose from", materials.len());
        walk.error(Code::MissingMaterial, &object.at, what);
        return None;
    };
    let found = materials.iter().position(|material| material.name == name);
    if found.is_none() {
        let help = suggestion(name, materials.iter().map(|material| material.name.as_str()))
            .unwrap_or_else(|| "add a material of that name to `materials`".to_string());
        let what = format!("is {:?}, which is not a material of the scene", short(name));
        walk.error(Code::MissingMaterial, &at, what).help = Some(help);
    }
    found
}

fn rotation(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<DMat3> {
    let object = walk.object(at, &["axis", "degrees"])?;
    let axis = walk.needed(&object, "axis").and_then(|at| walk.direction(&at));
    let degrees = walk.needed(&object, "degrees").and_then(|at| walk.number(&at));
    let (sin, cos) = sin_cos(degrees?);
    let axis = axis?;
    // Rodrigues: the component along the axis stays, the component across it turns.
    let turned = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    Some(DMat3::from_cols(turned(DVec3::X), turned(DVec3::Y), turned(DVec3::Z)))
}

/// Returns the sine and cosine of an angle in degrees, exact at quarter turns.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let quarters = (degrees / 90.0).round();
    let (sin, cos) = (degrees - quarters * 90.0).to_radians().sin_cos();
    match quarters.rem_euclid(4.0) as u8 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

fn scale(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<DVec3> {
    let scale = match at.node.value {
        Value::Number(_) => DVec3::splat(walk.number(at)?),
        _ => walk.vector(at)?,
    };
    // Normals grow by what the mesh shrinks; below that their squares underflow an `f32`.
    if scale.abs().min_element() < 1e-18 || scale.abs().max_element() > 1e18 {
        let what = "flattens the mesh, or makes it larger than light can be computed for";
        walk.error(Code::ValueOutOfRange, at, what).help =
            Some("scale by 1e-18 to 1e18 along each axis".to_string());
        return None;
    }
    Some(scale)
}
