//! Regions: parts of a frame with their own light list, and the bounds of the points in each.
//!
//! Made from the fragments themselves, so that a region is no larger than its visible part; read by
//! [`bound`](super::bound).

use std::collections::BTreeMap;

use glam::DVec3;

use super::options::Division;
use crate::scene::{Material, Surface};
use crate::shading_f32::{Model, Terms};
use crate::{Frame, Upload};

/// The bounds of all points in a part of the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The lowest coordinates of its points.
    pub low: DVec3,
    /// The highest coordinates of its points.
    pub high: DVec3,
    /// The lowest and highest components of its unit normals; `None` if a normal has no direction.
    pub normals: Option<[DVec3; 2]>,
    /// The largest reflectance of ambient and diffuse light by its materials; infinite if unknown.
    pub body: DVec3,
    /// The largest reflectance in highlights; infinite if unknown.
    pub shine: DVec3,
}

impl Region {
    /// The empty region, the neutral element of [`join`](Region::join).
    pub const EMPTY: Region = Region {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
        normals: Some([DVec3::INFINITY, DVec3::NEG_INFINITY]),
        body: DVec3::ZERO,
        shine: DVec3::ZERO,
    };

    /// Returns the smallest region that contains both.
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

    /// Returns the distance from a point to the box; 0 inside.
    pub fn distance(&self, point: DVec3) -> f64 {
        (self.low - point).max(point - self.high).max(DVec3::ZERO).length()
    }

    /// Whether every coordinate is finite.
    pub fn is_finite(&self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }
}

/// The fragments of a frame in `f64`, with the largest reflectance of their materials.
pub(super) struct Points {
    pub position: Vec<DVec3>,
    /// The unit normals; zero where a fragment's has no direction.
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
                // `min` and `max` ignore NaN: mark such a region with infinite corners.
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

/// Returns the largest reflectance of a material: ambient and diffuse, then specular.
fn reflects(material: &Material, model: &Model) -> [DVec3; 2] {
    let body = most(&material.ambient).max(most(&material.diffuse));
    let specular = most(&material.specular) * model.reflected(material.reflectance);
    let mut shine = match model.terms {
        Terms::Three | Terms::Single => specular,
        // One channel of the specular texel times the diffuse colour.
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

/// A part of the frame with its fragments and the index of its block.
pub(super) struct Cell {
    pub fragments: Vec<u32>,
    /// The position: column, row, slice.
    pub key: [u32; 3],
    pub region: Region,
    /// The index of the block of cells around it.
    pub block: usize,
}

/// The cells of a frame, in the order of their keys, and their blocks.
pub(super) struct Divided {
    pub cells: Vec<Cell>,
    pub blocks: Vec<Region>,
}

/// The cells of a block along each axis.
const BLOCK: u32 = 8;

/// Divides the fragments of a frame into cells.
pub(super) fn divide(
    frame: &Frame,
    points: &Points,
    camera: DVec3,
    fragments: &[u32],
    division: Division,
) -> Divided {
    let mut buckets: BTreeMap<[u32; 3], Vec<u32>> = BTreeMap::new();
    let key = keys(frame, points, camera, fragments, division);
    // Fragments are in pixel order: neighbours mostly share a cell.
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
            // Slices grow with distance, between the nearest and the farthest fragment.
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
