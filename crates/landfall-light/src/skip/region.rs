//! Parts of a frame that a list of lights is made for, and what is known of all points in one.
//!
//! Made from the fragments themselves, so that a region is no larger than what is seen of it;
//! read by [`bound`](super::bound).

use std::collections::BTreeMap;

use glam::DVec3;

use super::options::Division;
use crate::compiled::{Model, Terms};
use crate::scene::{Material, Surface};
use crate::{Frame, Upload};

/// What is known of every point of a part of the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The lowest coordinates of its points.
    pub low: DVec3,
    /// The highest.
    pub high: DVec3,
    /// The lowest and highest components of its unit normals; `None` if some normal has no
    /// direction.
    pub normals: Option<[DVec3; 2]>,
    /// The most any of its materials reflects of ambient and diffuse light; infinite if that
    /// is not known.
    pub body: DVec3,
    /// The most in highlights, likewise.
    pub shine: DVec3,
}

impl Region {
    /// The region of no point; joins with any.
    pub const EMPTY: Region = Region {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
        normals: Some([DVec3::INFINITY, DVec3::NEG_INFINITY]),
        body: DVec3::ZERO,
        shine: DVec3::ZERO,
    };

    /// The smallest that holds both.
    pub fn join(&self, other: &Region) -> Region {
        let normals = match (self.normals, other.normals) {
            (Some([a, b]), Some([c, d])) => Some([a.min(c), b.max(d)]),
            _ => None,
        };
        Region {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            normals,
            body: self.body.max(other.body),
            shine: self.shine.max(other.shine),
        }
    }

    /// The distance from a point to the box around it; 0 inside.
    pub fn distance(&self, point: DVec3) -> f64 {
        (self.low - point).max(point - self.high).max(DVec3::ZERO).length()
    }

    /// Whether every coordinate is a number.
    pub fn is_finite(&self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }
}

/// The fragments of a frame in `f64`, with what their materials reflect at most.
pub(super) struct Points {
    pub position: Vec<DVec3>,
    /// Unit; zero where the fragment's has no direction.
    pub normal: Vec<DVec3>,
    material: Vec<u32>,
    most: Vec<[DVec3; 2]>,
}

impl Points {
    pub fn new(frame: &Frame, upload: &Upload, model: &Model) -> Points {
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        Points {
            position: frame.fragments.iter().map(|f| wide(f.position)).collect(),
            normal: frame.fragments.iter().map(|f| wide(f.normal).normalize_or_zero()).collect(),
            material: frame.fragments.iter().map(|f| f.material).collect(),
            most: upload.materials.iter().map(|m| reflects(m, model)).collect(),
        }
    }

    pub fn region(&self, fragments: &[u32]) -> Region {
        let mut region = Region::EMPTY;
        let [mut low, mut high] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut directed = true;
        let mut material = u32::MAX;
        for &number in fragments {
            let number = number as usize;
            let (position, normal) = (self.position[number], self.normal[number]);
            if !position.is_finite() {
                // `min` and `max` pass over NaN: such a region is told by its infinite corner.
                [region.low, region.high] = [DVec3::NEG_INFINITY, DVec3::INFINITY];
            }
            region.low = region.low.min(position);
            region.high = region.high.max(position);
            directed &= normal != DVec3::ZERO;
            [low, high] = [low.min(normal), high.max(normal)];
            if self.material[number] != material {
                material = self.material[number];
                let none = [DVec3::ZERO; 2];
                let [body, shine] = self.most.get(material as usize).copied().unwrap_or(none);
                region.body = region.body.max(body);
                region.shine = region.shine.max(shine);
            }
        }
        region.normals = directed.then_some([low, high]);
        region
    }
}

/// The most a material reflects: ambient and diffuse, then specular.
fn reflects(material: &Material, model: &Model) -> [DVec3; 2] {
    let body = most(&material.ambient).max(most(&material.diffuse));
    let specular = most(&material.specular) * model.reflected(material.reflectance);
    let mut shine = match model.terms {
        Terms::Three | Terms::Single => specular,
        // Takes one channel of the texel, and the diffuse colour.
        Terms::PlainSpecular => specular.max_element() * body,
    };
    if !(shine.cmpge(DVec3::ZERO).all() && material.shininess >= 0.0) {
        shine = DVec3::INFINITY;
    }
    [body, shine]
}

fn most(surface: &Surface) -> DVec3 {
    let color = match surface {
        Surface::Constant(color) => *color,
        // Decoding sRGB makes no channel brighter.
        Surface::Texture(texture) => {
            let brightest = texture.texels.iter().fold([0; 3], |most: [u8; 3], texel| {
                [0, 1, 2].map(|channel| most[channel].max(texel[channel]))
            });
            DVec3::from(brightest.map(|byte| f64::from(byte) / 255.0))
        }
    };
    // A bound needs terms that are not negative.
    if color.cmpge(DVec3::ZERO).all() { color } else { DVec3::INFINITY }
}

/// A part of the frame with its fragments, and the larger part that it belongs to.
pub(super) struct Cell {
    pub fragments: Vec<u32>,
    /// Where it is: column, row, slice.
    pub key: [u32; 3],
    pub region: Region,
    /// Number of the block of cells around it.
    pub block: usize,
}

/// Cells of a frame, in the order of their keys, and the blocks they form.
pub(super) struct Divided {
    pub cells: Vec<Cell>,
    pub blocks: Vec<Region>,
}

/// Cells of a block along each axis.
const BLOCK: u32 = 8;

/// Divides the fragments of a frame.
pub(super) fn divide(
    frame: &Frame,
    points: &Points,
    camera: DVec3,
    fragments: &[u32],
    division: Division,
) -> Divided {
    let mut buckets: BTreeMap<[u32; 3], Vec<u32>> = BTreeMap::new();
    let key = keys(frame, points, camera, fragments, division);
    // Fragments come in the order of the pixels: neighbours mostly share a cell.
    let mut run: Option<([u32; 3], Vec<u32>)> = None;
    for &number in fragments {
        let at = key(number);
        match &mut run {
            Some((same, list)) if *same == at => list.push(number),
            _ => {
                if let Some((last, list)) = run.replace((at, vec![number])) {
                    buckets.entry(last).or_default().extend(list);
                }
            }
        }
    }
    if let Some((last, list)) = run {
        buckets.entry(last).or_default().extend(list);
    }
    let mut blocks: Vec<Region> = Vec::new();
    let mut known: BTreeMap<[u32; 3], usize> = BTreeMap::new();
    let cells = buckets.into_iter().map(|(key, fragments)| {
        let region = points.region(&fragments);
        let block = *known.entry(key.map(|at| at / BLOCK)).or_insert_with(|| {
            blocks.push(Region::EMPTY);
            blocks.len() - 1
        });
        blocks[block] = blocks[block].join(&region);
        Cell { fragments, key, region, block }
    });
    let cells: Vec<Cell> = cells.collect();
    Divided { cells, blocks }
}

fn keys<'a>(
    frame: &'a Frame,
    points: &'a Points,
    camera: DVec3,
    fragments: &[u32],
    division: Division,
) -> Box<dyn Fn(u32) -> [u32; 3] + 'a> {
    let width = frame.width.max(1);
    let pixel = move |number: u32| {
        let pixel = frame.fragments[number as usize].pixel;
        [pixel % width, pixel / width]
    };
    match division {
        Division::Whole => Box::new(|_| [0, 0, 0]),
        Division::Tiles { size } => {
            let size = size.max(1);
            Box::new(move |number| {
                let [x, y] = pixel(number);
                [x / size, y / size, 0]
            })
        }
        Division::Clusters { columns, rows, slices } => {
            // Slices of distance that grow with it, between the nearest and the farthest seen.
            let distance = move |number: u32| (points.position[number as usize] - camera).length();
            let all = fragments.iter().map(|&n| distance(n)).filter(|d| *d > 0.0);
            let (near, far) =
                all.fold((f64::INFINITY, 0f64), |(near, far), d| (near.min(d), far.max(d)));
            let scale = f64::from(slices) / (far / near).ln().max(1e-9);
            let height = frame.height.max(1);
            Box::new(move |number| {
                let [x, y] = pixel(number);
                let slice = (scale * (distance(number) / near).ln()).max(0.0) as u32;
                let along = |at: u32, of: u32, parts: u32| {
                    (u64::from(at) * u64::from(parts) / u64::from(of)) as u32
                };
                [along(x, width, columns), along(y, height, rows), slice.min(slices - 1)]
            })
        }
    }
}
