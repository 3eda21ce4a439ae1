//! Meshes from Wavefront OBJ text: `v`, `vt`, `vn` and `f`; names, groups, lines and materials are
//! ignored.
//!
//! Polygons become a fan from their first corner. The triangles of a face without normals get their
//! own normals and look flat.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::{Mesh, Vertex};
use landfall_layout::text::edit_distance::suggestion;

/// An error in a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObjFault {
    /// The byte range of the text.
    pub at: std::ops::Range<usize>,
    /// The message, to follow the place.
    pub message: String,
    pub help: Option<String>,
}

/// A mesh with the number of its triangles without normals.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ObjMesh {
    pub mesh: Mesh,
    /// The triangles of the file, including those without area, which are not drawn.
    pub triangles: usize,
    /// The triangles that got flat normals.
    pub flat: usize,
    /// The first face without normals.
    pub first_flat: Option<std::ops::Range<usize>>,
}

const IGNORED: &[&str] = &[
    "o",
    "g",
    "s",
    "usemtl",
    "mtllib",
    "l",
    "p",
    "vp",
    "mg",
    "lod",
    "usemap",
    "maplib",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "ctech",
    "stech",
];

const READ: &[&str] = &["v", "vt", "vn", "f"];

/// The most triangles of a mesh and of a scene: each takes up to 400 bytes while a picture is made.
pub const MAX_TRIANGLES: usize = 1 << 20;

/// The most errors reported for one file.
const MAX_FAULTS: usize = 20;

/// Parses a mesh.
///
/// # Errors
/// The errors by line, at most twenty.
pub fn read_obj(text: &str) -> Result<ObjMesh, Vec<ObjFault>> {
    let mut reader = ObjReader::default();
    let mut faults = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let code = line.split('#').next().unwrap_or("");
        let words = words(code, start);
        start += line.len();
        if let Err(fault) = reader.line(&words) {
            faults.push(fault);
            // The rest of a mesh that is too large would still fill the memory.
            if faults.len() == MAX_FAULTS || reader.read.triangles > MAX_TRIANGLES {
                return Err(faults);
            }
        }
    }
    if faults.is_empty() && reader.read.mesh.triangles.is_empty() {
        let message = "has no faces: a mesh is made of lines such as `f 1 2 3`".to_string();
        faults.push(ObjFault { at: 0..text.len().min(1), message, help: None });
    }
    if faults.is_empty() { Ok(reader.read) } else { Err(faults) }
}

/// A word of a line and its start in the text.
#[derive(Clone, Copy)]
struct ObjWord<'t> {
    text: &'t str,
    at: usize,
}

impl ObjWord<'_> {
    fn fault(&self, message: String) -> ObjFault {
        ObjFault { at: self.at..self.at + self.text.len(), message, help: None }
    }
}

fn words(line: &str, start: usize) -> Vec<ObjWord<'_>> {
    let place = |word: &str| word.as_ptr() as usize - line.as_ptr() as usize;
    line.split_ascii_whitespace().map(|text| ObjWord { text, at: start + place(text) }).collect()
}

/// A corner of a face: the indices of position, texture coordinates and normal.
type Corner = (usize, Option<usize>, Option<usize>);

#[derive(Default)]
struct ObjReader {
    positions: Vec<DVec3>,
    coordinates: Vec<DVec2>,
    normals: Vec<DVec3>,
    made: HashMap<Corner, u32>,
    read: ObjMesh,
}

impl ObjReader {
    fn line(&mut self, words: &[ObjWord<'_>]) -> Result<(), ObjFault> {
        let Some((keyword, rest)) = words.split_first() else { return Ok(()) };
        match keyword.text {
            // A fourth number is a weight, further ones a colour; neither moves a corner.
            "v" => {
                let read = numbers(keyword, rest, "v 0 1 0").map(DVec3::from_array);
                ObjReader::keep(&mut self.positions, read)?;
            }
            "vn" => {
                let read = numbers(keyword, rest, "vn 0 1 0").map(DVec3::from_array);
                if read == Ok(DVec3::ZERO) {
                    let message = "`vn 0 0 0` is a normal without a direction".to_string();
                    return ObjReader::keep(&mut self.normals, Err(keyword.fault(message)));
                }
                ObjReader::keep(&mut self.normals, read)?;
            }
            "vt" => {
                let read = match rest {
                    [_] => numbers(keyword, rest, "vt 0 1").map(|[u]| DVec2::new(u, 0.0)),
                    _ => numbers(keyword, rest, "vt 0 1").map(DVec2::from_array),
                };
                ObjReader::keep(&mut self.coordinates, read)?;
            }
            "f" => self.face(keyword, rest)?,
            other if IGNORED.contains(&other) => {}
            other => {
                let mut fault =
                    keyword.fault(format!("`{}` is not an OBJ statement", short(other)));
                fault.help = suggestion(other, READ.iter().chain(IGNORED).copied());
                return Err(fault);
            }
        }
        Ok(())
    }

    /// Stores a default for an invalid value, so that the indices of faces stay right.
    fn keep<T: Default>(all: &mut Vec<T>, read: Result<T, ObjFault>) -> Result<(), ObjFault> {
        let (kept, told) = match read {
            Ok(read) => (read, Ok(())),
            Err(fault) => (T::default(), Err(fault)),
        };
        all.push(kept);
        told
    }

    fn face(&mut self, keyword: &ObjWord<'_>, rest: &[ObjWord<'_>]) -> Result<(), ObjFault> {
        if rest.len() < 3 {
            let message = format!("a face has 3 corners or more, not {}", rest.len());
            return Err(keyword.fault(message));
        }
        let corners: Vec<Corner> =
            rest.iter().map(|word| self.corner(word)).collect::<Result<_, _>>()?;
        for pair in corners[1..].windows(2) {
            let triangle = [corners[0], pair[0], pair[1]];
            self.read.triangles += 1;
            if self.read.triangles > MAX_TRIANGLES {
                let message = format!("exceeds the limit of {MAX_TRIANGLES} triangles in a mesh");
                return Err(keyword.fault(message));
            }
            if triangle.iter().all(|corner| corner.2.is_some()) {
                let triangle = triangle.map(|corner| self.shared(corner));
                self.read.mesh.triangles.push(triangle);
            } else {
                self.flat(triangle);
                let end = rest.last().map_or(keyword.at, |word| word.at + word.text.len());
                self.read.first_flat.get_or_insert(keyword.at..end);
            }
        }
        Ok(())
    }

    /// Parses `position`, `position/uv`, `position//normal` or `position/uv/normal`.
    fn corner(&self, word: &ObjWord<'_>) -> Result<Corner, ObjFault> {
        let mut parts = word.text.split('/');
        let position = parts.next().unwrap_or("");
        let position = index(word, position, "v", self.positions.len())?;
        let mut optional = |keyword, len| match parts.next() {
            None | Some("") => Ok(None),
            Some(part) => index(word, part, keyword, len).map(Some),
        };
        let uv = optional("vt", self.coordinates.len())?;
        let normal = optional("vn", self.normals.len())?;
        if parts.next().is_some() {
            return Err(word.fault(format!("`{}` has more than two `/`", short(word.text))));
        }
        Ok((position, uv, normal))
    }

    fn shared(&mut self, corner: Corner) -> u32 {
        if let Some(&made) = self.made.get(&corner) {
            return made;
        }
        let normal = corner.2.map_or(DVec3::ZERO, |normal| self.normals[normal]);
        // Equal corners are stored once.
        let made = self.push(corner, normal);
        self.made.insert(corner, made);
        made
    }

    fn push(&mut self, corner: Corner, normal: DVec3) -> u32 {
        let uv = corner.1.map_or(DVec2::ZERO, |uv| self.coordinates[uv]);
        let vertices = &mut self.read.mesh.vertices;
        vertices.push(Vertex { position: self.positions[corner.0], normal, uv });
        vertices.len() as u32 - 1
    }

    /// Adds a triangle with its own normal, unless it has no area.
    fn flat(&mut self, triangle: [Corner; 3]) {
        let [a, b, c] = triangle.map(|corner| self.positions[corner.0]);
        let across = (b - a).cross(c - a);
        self.read.flat += 1;
        if let Some(normal) = across.try_normalize() {
            let triangle = triangle.map(|corner| self.push(corner, normal));
            self.read.mesh.triangles.push(triangle);
        }
    }
}

/// Parses the first numbers of a statement.
fn numbers<const N: usize>(
    keyword: &ObjWord<'_>,
    rest: &[ObjWord<'_>],
    example: &str,
) -> Result<[f64; N], ObjFault> {
    if rest.len() < N {
        let message =
            format!("`{}` has {N} numbers, not {}: `{example}`", keyword.text, rest.len());
        return Err(keyword.fault(message));
    }
    let mut numbers = [0.0; N];
    for (number, word) in numbers.iter_mut().zip(rest) {
        *number = match word.text.parse::<f64>() {
            Ok(number) if number.abs() <= super::LARGEST => number,
            Ok(_) => {
                let message = format!("`{}` is not a finite number up to 1e18", short(word.text));
                return Err(word.fault(message));
            }
            Err(_) => return Err(word.fault(format!("`{}` is not a number", short(word.text)))),
        };
    }
    Ok(numbers)
}

/// Parses an index, which counts from 1, or back from the last line so far if negative.
fn index(word: &ObjWord<'_>, part: &str, keyword: &str, len: usize) -> Result<usize, ObjFault> {
    let Ok(number) = part.parse::<i64>() else {
        let message = format!("`{}` is not an index of a `{keyword}` line", short(part));
        return Err(word.fault(message));
    };
    let len = len as i64;
    let found = match number {
        0 => None,
        1.. => Some(number - 1),
        _ => len.checked_add(number),
    };
    match found.filter(|found| (0..len).contains(found)) {
        Some(found) => Ok(found as usize),
        None => {
            let message = format!("`{number}` is outside the {len} `{keyword}` lines so far");
            Err(word.fault(message))
        }
    }
}

pub(super) fn short(text: &str) -> String {
    if text.chars().count() <= 40 {
        text.to_string()
    } else {
        text.chars().take(39).chain(['…']).collect()
    }
}
