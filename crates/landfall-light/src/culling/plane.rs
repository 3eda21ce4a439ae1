//! The planes of a frame: fragments of an object and a material in one plane.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::Job;
use super::region::{Points, Region};
use crate::scene::Surface;

/// A plane.
pub(super) struct Plane {
    pub material: u32,
    /// The bounds of its fragments.
    pub region: Region,
    /// A point of it.
    pub origin: DVec3,
    pub axes: [DVec3; 2],
    pub normal: DVec3,
    /// The largest distance of a fragment from it.
    pub off: f64,
    /// The largest difference of a unit normal from its own.
    pub tilt: f64,
    /// The longest distance between two fragments, or more.
    pub diameter: f64,
    /// The largest error of a coordinate along the axes in `f32`.
    pub rounding: f64,
    /// The largest error of a position in `f32`.
    pub moved: f64,
}

impl Plane {
    /// Returns the coordinates of a point along the axes and the normal.
    pub fn coordinates(&self, point: DVec3) -> DVec3 {
        let from = point - self.origin;
        DVec3::new(from.dot(self.axes[0]), from.dot(self.axes[1]), from.dot(self.normal))
    }
}

/// The indices of fragments, in their order.
pub(super) type Group = Vec<u32>;

/// The fewest fragments for a plane of its own.
const FEWEST: usize = 10;
/// The resolution at which normals are compared.
const SAME_NORMAL: f64 = 65_536.0;
/// The distance, in diameters of a plane, beyond which a fragment is off it.
const FLAT: f64 = 1e-4;

/// Returns the fragments of each plane of each object, and those on no plane by object.
pub(super) fn planes(job: &Job<'_>, points: &Points<'_>) -> (Vec<(Plane, Group)>, Vec<Group>) {
    let (groups, mut rest) = by_normal(job, points);
    let mut planes = Vec::new();
    for (object, group) in groups {
        match plane(points, &group).filter(|_| group.len() >= FEWEST) {
            Some(plane) => planes.push((plane, group)),
            None => rest.entry(object).or_default().extend(group),
        }
    }
    let mut rest: Vec<(u32, Group)> = rest.into_iter().collect();
    rest.sort_unstable_by_key(|(object, _)| *object);
    (planes, rest.into_iter().map(|(_, group)| group).collect())
}

/// Returns the fragments with one normal of each object and material, and those of textures and without
/// a normal by object.
fn by_normal(job: &Job<'_>, points: &Points<'_>) -> (Vec<(u32, Group)>, FxHashMap<u32, Group>) {
    let plain: Vec<bool> = job
        .upload
        .materials
        .iter()
        .map(|m| {
            let surfaces = [&m.ambient, &m.diffuse, &m.specular];
            surfaces.iter().all(|surface| matches!(surface, Surface::Constant(_)))
        })
        .collect();
    let mut groups: Vec<(u32, Group)> = Vec::new();
    let mut known: FxHashMap<(u32, u32, [i32; 3]), usize> = FxHashMap::default();
    let mut rest: FxHashMap<u32, Group> = FxHashMap::default();
    // Neighbours mostly share their group.
    let mut last = None;
    for (number, fragment) in job.frame.fragments.iter().enumerate() {
        let like = (fragment.object, fragment.material, fragment.normal);
        if let Some((_, at)) = last.filter(|(of, _)| *of == like) {
            let (_, group): &mut (u32, Group) = &mut groups[at];
            group.push(number as u32);
            continue;
        }
        let normal = points.normal(number as u32);
        let flat = plain.get(fragment.material as usize).copied().unwrap_or(false);
        if !flat || normal == DVec3::ZERO {
            rest.entry(fragment.object).or_default().push(number as u32);
            continue;
        }
        let key = (normal * SAME_NORMAL).round().to_array().map(|at| at as i32);
        let at = *known.entry((fragment.object, fragment.material, key)).or_insert_with(|| {
            groups.push((fragment.object, Vec::new()));
            groups.len() - 1
        });
        last = Some((like, at));
        groups[at].1.push(number as u32);
    }
    (groups, rest)
}

/// Returns the plane of fragments with one normal; `None` if they are on several.
fn plane(points: &Points<'_>, group: &[u32]) -> Option<Plane> {
    let normal = points.normal(group[0]);
    let (first, second) = normal.any_orthonormal_pair();
    let region = points.region(group);
    let diameter = (region.high - region.low).length();
    let at = points.position(group[0]);
    let off = |n: &u32| (points.position(*n) - at).dot(normal).abs();
    let off = group.iter().map(off).fold(0.0, f64::max);
    if off.is_nan() || off > FLAT * diameter {
        return None;
    }
    let tilt = points.tilt(group, normal);
    let middle = (region.low + region.high) / 2.0 - at;
    let origin = at + first * middle.dot(first) + second * middle.dot(second);
    let largest = region.low.abs().max(region.high.abs()).max_element().max(1.0);
    let rounding = (largest + diameter) * 2f64.powi(-21);
    let moved = largest * 2f64.powi(-23);
    let (axes, material) = ([first, second], points.material(group[0]));
    Some(Plane { material, region, origin, axes, normal, off, tilt, diameter, rounding, moved })
}
