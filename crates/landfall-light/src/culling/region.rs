//! Regions: parts of a frame with their own light list, and the bounds of the points in each.
//!
//! Made from the fragments themselves, so that a region is no larger than its visible part; read by
//! [`bound`](super::bound).

use std::ops::Range;

use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;

use crate::scene::{Material, Surface};
use crate::shading_f32::{Model, Terms};
use crate::{Fragment, Frame, Upload};

/// The bounds of all points in a part of the frame.
#[derive(Clone, Debug, PartialEq)]
// Boxes rather than spheres or frusta: a visible surface is thin, mostly aligned with an axis or a
// tile, and the distance to a box takes few operations.
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
    /// `low > high` on purpose: `min` and `max` with any point give that point.
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
        // One of the two differences is positive outside of the slab of an axis, none inside.
        (self.low - point).max(point - self.high).max(DVec3::ZERO).length()
    }

    pub fn is_finite(&self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }
}

/// The fragments of a frame, with the largest reflectance of their materials.
pub(super) struct Points<'a> {
    fragments: &'a [Fragment],
    most: Vec<[DVec3; 2]>,
    /// Whether regions have the bounds of their normals.
    directed: bool,
}

impl<'a> Points<'a> {
    pub fn new(frame: &'a Frame, upload: &Upload, model: &Model) -> Points<'a> {
        let most = upload.materials.iter().map(|m| reflects(m, model)).collect();
        Points { fragments: &frame.fragments, most, directed: true }
    }

    /// Returns the points without normals, if nothing depends on them.
    pub fn undirected(self) -> Points<'a> {
        Points { directed: false, ..self }
    }

    /// Whether some material has no highlight in some channel.
    pub fn has_dull(&self) -> bool {
        self.most.iter().any(|[_, shine]| shine.cmpeq(DVec3::ZERO).any())
    }

    /// Returns the unit normal; zero for one without a direction.
    fn normal(&self, number: u32) -> DVec3 {
        Vec3::from(self.fragments[number as usize].normal).as_dvec3().normalize_or_zero()
    }

    pub fn region(&self, numbers: &[u32]) -> Region {
        // Bounds in `f32`, in which positions and normals are given: no rounding, half the width.
        let [mut low, mut high] = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let mut finite = true;
        let mut materials = Region::EMPTY;
        let mut material = u32::MAX;
        for &number in numbers {
            let fragment = &self.fragments[number as usize];
            let position = Vec3::from(fragment.position);
            // Of a normal without a direction a shader may make NaN, which zero times a light is,
            // too.
            let normal = Vec3::from(fragment.normal).length_squared();
            finite &= position.is_finite() && normal > 0.0 && normal.is_finite();
            // `<` ignores NaN, as `min` does, and is one instruction.
            low = Vec3::select(position.cmplt(low), position, low);
            high = Vec3::select(position.cmpgt(high), position, high);
            // Neighbours mostly share a material; the last one is remembered.
            if fragment.material != material {
                material = fragment.material;
                let none = [DVec3::ZERO; 2];
                // A fragment without a material is black, as in `surface`.
                let [body, shine] = self.most.get(material as usize).copied().unwrap_or(none);
                materials.body = materials.body.max(body);
                materials.shine = materials.shine.max(shine);
            }
        }
        let (low, high) = match finite {
            true => (low.as_dvec3(), high.as_dvec3()),
            // Comparisons ignore NaN: mark such a region with infinite corners.
            false => (DVec3::NEG_INFINITY, DVec3::INFINITY),
        };
        Region { low, high, normals: self.normals(numbers), ..materials }
    }

    fn normals(&self, numbers: &[u32]) -> Option<[DVec3; 2]> {
        // Component-wise bounds of unit normals are no cone, but `may_face` needs the ends of
        // components only, and they join by min and max.
        let [mut low, mut high] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        // Neighbours on a plane share their normal.
        let mut last = [f32::NAN; 3];
        for &number in numbers.iter().filter(|_| self.directed) {
            let given = self.fragments[number as usize].normal;
            if given != last {
                last = given;
                let normal = self.normal(number);
                if normal == DVec3::ZERO {
                    return None;
                }
                [low, high] = [low.min(normal), high.max(normal)];
            }
        }
        self.directed.then_some([low, high])
    }
}

/// Returns the largest reflectance of a material: ambient and diffuse, then specular.
fn reflects(material: &Material, model: &Model) -> [DVec3; 2] {
    let body = most(&material.ambient).max(most(&material.diffuse));
    let specular = most(&material.specular) * model.reflectance.factor(material.reflectance);
    // In the published shaders of the array family the highlight has one channel.
    let mut shine = match model.terms {
        Terms::Three | Terms::Single => specular,
        // One channel of the specular texel times the diffuse colour.
        Terms::PlainSpecular => specular.max_element() * body,
    };
    // `0^0` and powers of negative exponents are undefined or infinite: no bound.
    if !(shine.cmpge(DVec3::ZERO).all() && material.shininess >= 0.0) {
        shine = DVec3::INFINITY;
    }
    [body, shine]
}

fn most(surface: &Surface) -> DVec3 {
    let color = match surface {
        Surface::Constant(color) => *color,
        // The brightest texel of the whole texture, since a region's texture coordinates are not
        // followed. Decoding sRGB makes no channel brighter.
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

/// A tile with its fragments and the index of its block.
pub(super) struct RegionCell {
    pub fragments: Vec<u32>,
    /// The column and the row.
    pub key: [u32; 2],
    pub region: Region,
    /// The index of the block of cells around it.
    pub block: usize,
}

/// The tiles of a frame that show an object, row by row, and their blocks.
pub(super) struct DividedFrame {
    pub cells: Vec<RegionCell>,
    pub blocks: Vec<Region>,
}

/// The cells of a block along each axis.
/// 64 cells share a block's test.
const BLOCK: u32 = 8;

/// Divides the fragments of a frame into tiles of that side.
pub(super) fn divide(frame: &Frame, points: &Points<'_>, size: u32) -> DividedFrame {
    let (width, columns) = (frame.width.max(1), frame.width.div_ceil(size).max(1));
    let pixel = |number: usize| frame.fragments[number].pixel;
    // Fragments are in pixel order: neighbours mostly share a tile, up to its end in the row.
    // A run is a range of fragments in one row of a tile: the tile is looked up once a run, not
    // once a fragment.
    let mut runs: Vec<(u32, Range<usize>)> = Vec::new();
    let mut rest = 0..frame.fragments.len();
    while !rest.is_empty() {
        let first = pixel(rest.start);
        let (x, y) = (first % width, first / width);
        // The first pixel past the tile or the row, whichever is nearer.
        let end = (first - x).saturating_add((x - x % size).saturating_add(size).min(width));
        // The fragments of a bench are in an order of their own.
        let same = rest.clone().take_while(|number| (first..end).contains(&pixel(*number)));
        let len = same.count();
        runs.push((y / size * columns + x / size, rest.start..rest.start + len));
        rest.start += len;
    }
    // Tiles are counted to the last one with a fragment, then filled without reallocation.
    let tiles = runs.iter().map(|(tile, _)| *tile as usize + 1).max().unwrap_or(0);
    let mut counts = vec![0; tiles];
    runs.iter().for_each(|(tile, run)| counts[*tile as usize] += run.len());
    let mut numbers: Vec<Vec<u32>> = counts.into_iter().map(Vec::with_capacity).collect();
    for (tile, run) in runs {
        numbers[tile as usize].extend(run.start as u32..run.end as u32);
    }
    let mut blocks: Vec<Region> = Vec::new();
    let mut known: FxHashMap<[u32; 2], usize> = FxHashMap::default();
    // Tiles with only background need no list.
    let cells = (0..).zip(numbers).filter(|(_, fragments)| !fragments.is_empty());
    let cells = cells.map(|(tile, fragments): (u32, Vec<u32>)| {
        let key = [tile % columns, tile / columns];
        let region = points.region(&fragments);
        let block = *known.entry(key.map(|at| at / BLOCK)).or_insert_with(|| {
            blocks.push(Region::EMPTY);
            blocks.len() - 1
        });
        blocks[block] = blocks[block].join(&region);
        RegionCell { fragments, key, region, block }
    });
    let cells: Vec<RegionCell> = cells.collect();
    DividedFrame { cells, blocks }
}
