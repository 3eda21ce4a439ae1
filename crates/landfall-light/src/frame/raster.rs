//! Finds the triangle at each pixel.
//!
//! In camera space a pixel's centre is a ray from the origin, and each edge of a triangle spans a
//! plane with the origin: the ray hits the triangle if it is on the inner side of all three (Olano
//! and Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates", 1997). Triangles behind
//! the camera need no clipping; depth is the triangle's volume over the sum of the three distances,
//! and each distance over the sum is the weight of a corner, perspective included. The two
//! triangles at an edge see exactly negated planes, so that each pixel belongs to exactly one of
//! them.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;

use super::Fragment;
use super::vertices::{Corners, VertexAttributes};
use crate::Scene;
use crate::scene::Camera;
use landfall_ir::threads;

/// The rows that a thread draws at a time.
/// Enough bands for all threads; a band's depths stay in the cache.
const BAND: usize = 64;

const NONE: u32 = u32::MAX;

/// Returns the visible fragments in pixel order, and the result of `other`, which the calling
/// thread runs before it draws.
///
/// # Errors
/// That of `other`, after which no further band is drawn.
pub(super) fn fragments<O, E>(
    scene: &Scene,
    corners: &Corners,
    other: impl FnOnce() -> Result<O, E>,
) -> Result<(Vec<Fragment>, O), E> {
    let [width, height] = scene.size.map(|size| size as usize);
    // Indices of pixels are 32 bits.
    let Some(pixels) = width.checked_mul(height).filter(|pixels| *pixels < NONE as usize) else {
        return Ok((Vec::new(), other()?));
    };
    if pixels == 0 {
        return Ok((Vec::new(), other()?));
    }
    let screen = Screen::new(&scene.camera, width, height);
    let triangles = triangles(scene, corners, &screen);
    let bands: Vec<Range<usize>> =
        (0..height).step_by(BAND).map(|first| first..(first + BAND).min(height)).collect();
    // Two passes: bands find the triangle at each pixel, then the fragments are counted and filled
    // in place.
    let mut threads = vec![(); threads::number(0)];
    let failed = AtomicBool::new(false);
    let draw = |(): &mut (), number: usize| {
        let band = || Band::new(&screen, bands[number].clone()).draw(&triangles);
        (!failed.load(Ordering::Relaxed)).then(band)
    };
    let (drawn, other) = threads::run_beside(&mut threads, bands.len(), draw, || {
        other().inspect_err(|_| failed.store(true, Ordering::Relaxed))
    });
    let other = other?;
    let drawn: Vec<_> = drawn.into_iter().flatten().collect();
    // Each thread fills its bands' part of the list, which has no pages before.
    let mut fragments: Vec<Fragment> =
        bytemuck::zeroed_vec(drawn.iter().map(|band| band.covered).sum());
    let mut rest = &mut fragments[..];
    let parts = drawn.into_iter().map(|band| {
        let (part, after) = std::mem::take(&mut rest).split_at_mut(band.covered);
        rest = after;
        (band, part)
    });
    threads::each(parts, |(band, part)| band.fill(part, scene, corners, &triangles));
    Ok((fragments, other))
}

/// The directions of the pixel centres' rays: `(x[column], y[row], -1)`.
struct Screen {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Half the picture's width and height at distance 1.
    half: [f64; 2],
    depths: Range<f64>,
}

impl Screen {
    fn new(camera: &Camera, width: usize, height: usize) -> Screen {
        // The field of view is the vertical one.
        let up = (camera.fov.to_radians() / 2.0).tan();
        let right = up * (width as f64 / height as f64);
        let x = |column| ((2 * column + 1) as f64 / width as f64 - 1.0) * right;
        let y = |row| (1.0 - (2 * row + 1) as f64 / height as f64) * up;
        Screen {
            x: (0..width).map(x).collect(),
            y: (0..height).map(y).collect(),
            half: [right, up],
            depths: camera.near..camera.far,
        }
    }

    /// Returns the columns and rows that a triangle may cover, a pixel more on each side; `None` if
    /// it is entirely before the near plane or behind the far one.
    fn bounds(&self, corners: &[DVec3; 3]) -> Option<[Range<usize>; 2]> {
        // A projection is not defined behind the camera, so a triangle that crosses the near plane
        // is bounded by its part in front of it.
        let near = self.depths.start;
        let nearest = corners.iter().fold(f64::INFINITY, |depth, corner| depth.min(-corner.z));
        let (size, half) = ([self.x.len(), self.y.len()], self.half);
        if nearest > self.depths.end {
            return None;
        }
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        let mut take = |point: DVec3| {
            // From -1 to 1 across the picture, y downwards.
            let at = [point.x / -point.z / half[0], -(point.y / -point.z) / half[1]];
            for axis in 0..2 {
                let pixel = (at[axis] + 1.0) / 2.0 * size[axis] as f64;
                low[axis] = low[axis].min(pixel);
                high[axis] = high[axis].max(pixel);
            }
        };
        for (i, &corner) in corners.iter().enumerate() {
            let next = corners[(i + 1) % 3];
            let inside = |corner: DVec3| -corner.z >= near;
            if inside(corner) {
                take(corner);
            }
            if inside(corner) != inside(next) {
                // The point where the edge crosses the near plane.
                let part = (-near - corner.z) / (next.z - corner.z);
                take((corner + (next - corner) * part).with_z(-near));
            }
        }
        let range = |axis: usize| {
            // Conversion to an integer saturates.
            let first = (low[axis] - 1.0).floor() as usize;
            let last = (high[axis] + 1.0).ceil() as usize;
            first.min(size[axis])..last.min(size[axis])
        };
        let ranges = [range(0), range(1)];
        ranges.iter().all(|range| !range.is_empty()).then_some(ranges)
    }
}

struct VisibleTriangle {
    /// The planes of the edges opposite to each corner, oriented so that inside is positive.
    planes: [DVec3; 3],
    /// Whether each edge includes the pixel centres exactly on it.
    owns: [bool; 3],
    /// Six times the volume of the tetrahedron of triangle and camera.
    volume: f64,
    columns: Range<usize>,
    rows: Range<usize>,
    corners: [usize; 3],
    object: u32,
}

fn triangles(scene: &Scene, corners: &Corners, screen: &Screen) -> Vec<VisibleTriangle> {
    let mut triangles = Vec::new();
    for (number, object) in scene.objects.iter().enumerate() {
        let first = corners.first[number];
        for triangle in &object.mesh.triangles {
            if triangle.iter().any(|&corner| corner as usize >= object.mesh.vertices.len()) {
                continue;
            }
            let at = triangle.map(|corner| first + corner as usize);
            triangles.extend(VisibleTriangle::new(at, number as u32, corners, screen));
        }
    }
    // Further triangles would have no index.
    triangles.truncate(NONE as usize);
    triangles
}

impl VisibleTriangle {
    fn new(
        corners: [usize; 3],
        object: u32,
        all: &Corners,
        screen: &Screen,
    ) -> Option<VisibleTriangle> {
        let seen = corners.map(|corner| all.seen[corner]);
        let [a, b, c] = seen;
        // a . (b x c): zero for a triangle whose plane contains the camera.
        let volume = a.dot(b.cross(c));
        // Seen edge-on, or not finite.
        if volume == 0.0 || !volume.is_finite() {
            return None;
        }
        let [columns, rows] = screen.bounds(&seen)?;
        // The plane through the origin and two corners; oriented by the sign of the volume, so
        // that front and back are drawn alike.
        let planes = [b.cross(c), c.cross(a), a.cross(b)].map(|plane| plane * volume.signum());
        // Inside is to the right of a left edge, and below a top edge.
        // Of two triangles at an edge the planes are negated, so exactly one of them owns its
        // points.
        let owns = planes.map(|plane| plane.x > 0.0 || (plane.x == 0.0 && plane.y < 0.0));
        Some(VisibleTriangle { planes, owns, volume: volume.abs(), columns, rows, corners, object })
    }

    /// Returns the signed distance of a ray from each plane.
    #[inline(always)]
    fn inside(&self, x: f64, y: f64) -> [f64; 3] {
        let distance = |plane: &DVec3| plane.x * x + (plane.y * y - plane.z);
        let [a, b, c] = &self.planes;
        [distance(a), distance(b), distance(c)]
    }

    fn covers(&self, inside: [f64; 3]) -> bool {
        (0..3).all(|edge| inside[edge] > 0.0 || (inside[edge] == 0.0 && self.owns[edge]))
    }
}

/// A drawn band of rows.
struct Band<'s> {
    screen: &'s Screen,
    rows: Range<usize>,
    which: Vec<u32>,
    /// The pixels with a triangle.
    covered: usize,
}

impl Band<'_> {
    fn new(screen: &Screen, rows: Range<usize>) -> Band<'_> {
        let pixels = rows.len() * screen.x.len();
        Band { screen, rows, which: vec![NONE; pixels], covered: 0 }
    }

    fn draw(mut self, triangles: &[VisibleTriangle]) -> Self {
        let (screen, width) = (self.screen, self.screen.x.len());
        let mut nearest = vec![f64::INFINITY; self.which.len()];
        // Every triangle is tested against the band's rows: the order of the scene decides between
        // equal depths.
        for (number, triangle) in triangles.iter().enumerate() {
            let first = triangle.rows.start.max(self.rows.start);
            for row in first..triangle.rows.end.min(self.rows.end) {
                let start = (row - self.rows.start) * width;
                for column in triangle.columns.clone() {
                    let inside = triangle.inside(screen.x[column], screen.y[row]);
                    if !triangle.covers(inside) {
                        continue;
                    }
                    // The ray's parameter at the triangle's plane: its volume over the sum of the
                    // three distances.
                    let depth = triangle.volume / (inside[0] + inside[1] + inside[2]);
                    let pixel = start + column;
                    let between = depth >= screen.depths.start && depth <= screen.depths.end;
                    if between && depth < nearest[pixel] {
                        nearest[pixel] = depth;
                        self.which[pixel] = number as u32;
                    }
                }
            }
        }
        self.covered = self.which.iter().filter(|which| **which != NONE).count();
        self
    }

    /// Writes the fragments of the covered pixels.
    fn fill(&self, to: &mut [Fragment], scene: &Scene, corners: &Corners, all: &[VisibleTriangle]) {
        let width = self.screen.x.len();
        let covered = self.which.iter().enumerate().filter(|(_, which)| **which != NONE);
        for ((pixel, which), fragment) in covered.zip(to) {
            let triangle = &all[*which as usize];
            let (row, column) = (self.rows.start + pixel / width, pixel % width);
            let inside = triangle.inside(self.screen.x[column], self.screen.y[row]);
            // The same arithmetic as when it was drawn gives the same weights.
            let [a, b, c] = triangle.corners;
            let lit = between([&corners.lit[a], &corners.lit[b], &corners.lit[c]], inside);
            *fragment = Fragment {
                pixel: (row * width + column) as u32,
                material: scene.objects[triangle.object as usize].material as u32,
                object: triangle.object,
                position: lit.position.as_vec3().to_array(),
                normal: lit.normal.as_vec3().to_array(),
                uv: lit.uv.as_vec2().to_array(),
            };
        }
    }
}

/// Interpolates three corners by their weights.
fn between([a, b, c]: [&VertexAttributes; 3], weights: [f64; 3]) -> VertexAttributes {
    // The weights are distances in camera space, so perspective is in them.
    let sum = weights[0] + weights[1] + weights[2];
    let [wa, wb, wc] = [weights[0] / sum, weights[1] / sum, weights[2] / sum];
    VertexAttributes {
        position: a.position * wa + b.position * wb + c.position * wc,
        normal: a.normal * wa + b.normal * wb + c.normal * wc,
        uv: a.uv * wa + b.uv * wb + c.uv * wc,
    }
}
