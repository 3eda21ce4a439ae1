//! The lights near a plane, and groups of neighbouring lamps, which are tested in one.

use glam::DVec3;

use super::bound::{AWAY, Bounded, Shape};
use super::lamps::{Lamp, Lamps};
use super::plane::Plane;
use super::region::Region;

/// The lights that may contribute to a patch and are in no grid around it.
#[derive(Clone)]
pub(super) struct Near {
    /// Those with a bound of the error of interpolating them.
    pub lamps: Lamps,
    pub others: Vec<u32>,
}

/// The sizes of numbers with which no `f32` of a bound overflows or loses digits.
const LARGEST: f64 = 1e15;
const SMALLEST: f64 = 1e-20;

/// The lamps of a group.
pub(super) const GROUP: usize = 16;

/// The lights of a material.
pub(super) struct Prepared {
    /// Neighbours follow each other.
    lamps: Vec<Lamp>,
    /// The bounds of each [`GROUP`] lamps.
    groups: Vec<Lamp>,
    /// Lights without a bound of the error of interpolating them.
    pub others: Vec<u32>,
}

impl Prepared {
    /// Prepares lights for a material with the reflectance of a region.
    pub fn new(lights: &[Bounded], region: &Region) -> Prepared {
        let (mut lamps, mut others) = (Vec::new(), Vec::new());
        for (place, light) in lights.iter().enumerate() {
            match plain(light, region, place as u32) {
                Some(lamp) => lamps.push(lamp),
                None => others.push(place as u32),
            }
        }
        let lamps = by_place(lamps);
        let groups = lamps.chunks(GROUP).enumerate().map(|(at, lamps)| group(at as u32, lamps));
        Prepared { groups: groups.collect(), others, lamps }
    }

    /// Prepares lights of which no error is to be bounded.
    pub fn unbounded(lights: &[Bounded]) -> Prepared {
        let others = (0..lights.len() as u32).collect();
        Prepared { lamps: Vec::new(), groups: Vec::new(), others }
    }

    /// Returns the groups of lamps that may contribute to a plane; `back` if surfaces that face away
    /// have highlights.
    pub fn groups(&self, plane: &Plane, back: bool) -> Lamps {
        let mut near = Lamps::for_many(self.groups.len());
        push(&self.groups, plane, back, &mut near);
        near
    }

    /// Returns the lamps of these groups, and these, that may contribute to a plane.
    pub fn lamps(&self, groups: &[u32], some: &[Lamp], plane: &Plane, back: bool) -> Lamps {
        let mut near = Lamps::for_many(groups.len() * GROUP + some.len());
        for &group in groups {
            push(self.group(group), plane, back, &mut near);
        }
        push(some, plane, back, &mut near);
        near
    }

    /// Returns the places of those lamps of these groups that may contribute to a plane; adds those whose
    /// side of it is not the same everywhere to `between`.
    pub fn far(
        &self,
        groups: &[u32],
        plane: &Plane,
        back: bool,
        between: &mut Vec<Lamp>,
    ) -> Vec<u32> {
        let mut far = Vec::with_capacity(groups.len() * GROUP);
        for &number in groups {
            let lamps = self.group(number);
            if side(&self.groups[number as usize], plane) == Side::Front {
                far.extend(lamps.iter().map(|lamp| lamp.place));
                continue;
            }
            for lamp in lamps {
                match side(lamp, plane) {
                    Side::Back if is_dark_behind(lamp, back) => {}
                    Side::Front | Side::Back => far.push(lamp.place),
                    Side::Between => between.push(*lamp),
                }
            }
        }
        far
    }

    fn group(&self, group: u32) -> &[Lamp] {
        let first = group as usize * GROUP;
        &self.lamps[first..self.lamps.len().min(first + GROUP)]
    }
}

/// The side of a plane.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Front,
    Back,
    /// Not the same for all fragments, or unknown.
    Between,
}

/// Returns the side of a plane that a lamp, or several, are on, as all fragments compute it.
fn side(lamp: &Lamp, plane: &Plane) -> Side {
    let from = lamp.position - plane.origin;
    let height = from.dot(plane.normal);
    let radius = f64::from(lamp.radius);
    let far = from.abs().element_sum() + radius + plane.diameter;
    // Fragments are off the plane, their normals off its own, and distances rounded.
    let off = 2.0 * (plane.off + plane.moved + plane.rounding) + (plane.tilt + 2e-5) * far;
    match height.abs() > radius + off {
        true if height > 0.0 => Side::Front,
        true => Side::Back,
        false => Side::Between,
    }
}

/// Whether a lamp adds nothing to surfaces that face away; `back` if those have highlights.
fn is_dark_behind(lamp: &Lamp, back: bool) -> bool {
    let [ambient, _, specular] = lamp.terms;
    ambient == 0.0 && !(back && specular != 0.0)
}

/// Adds the lamps that may contribute to a plane.
fn push(lamps: &[Lamp], plane: &Plane, back: bool, near: &mut Lamps) {
    for lamps in lamps.chunks(GROUP) {
        let mut kept = [(&lamps[0], [0.0; 3]); GROUP];
        let mut len = 0;
        for lamp in lamps {
            let at = plane.coordinates(lamp.position);
            let behind = at.z < 0.0 && is_dark_behind(lamp, back) && {
                let radius = f64::from(lamp.radius);
                let far = at.length() + radius + plane.diameter;
                at.z + radius + plane.off + plane.rounding + plane.tilt * far < -AWAY * far
            };
            if !behind {
                kept[len] = (lamp, at.as_vec3().to_array());
                len += 1;
            }
        }
        near.extend(&kept[..len]);
    }
}

/// Returns a point light without range; `None` for other lights.
fn plain(light: &Bounded, region: &Region, place: u32) -> Option<Lamp> {
    let Ok(Shape::Around(lamp)) = &light.shape else { return None };
    let [ambient, diffuse, specular] = light.terms();
    let terms = [ambient * region.body, diffuse * region.body, specular * region.shine];
    let terms = terms.map(|term| term.max_element());
    let fits = |x: &f64| *x == 0.0 || (SMALLEST..LARGEST).contains(&x.abs());
    let known = lamp.cone.is_none()
        && lamp.range.is_infinite()
        && lamp.position.abs().max_element() < LARGEST
        && lamp.attenuation.iter().all(fits)
        && terms.iter().all(|term| *term < LARGEST);
    let [attenuation, terms] = [lamp.attenuation, terms].map(|numbers| numbers.map(|x| x as f32));
    known.then_some(Lamp { place, position: lamp.position, radius: 0.0, attenuation, terms })
}

/// Returns the bounds of several lamps.
pub(super) fn group(place: u32, lamps: &[Lamp]) -> Lamp {
    let positions = || lamps.iter().map(|lamp| lamp.position);
    let low = positions().fold(DVec3::INFINITY, DVec3::min);
    let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
    let position = (low + high) / 2.0;
    let radius = positions().map(|at| at.distance(position)).fold(0.0, f64::max);
    let least = |at: usize| lamps.iter().map(|l| l.attenuation[at]).fold(f32::INFINITY, f32::min);
    let sum = |at: usize| lamps.iter().map(|lamp| lamp.terms[at]).sum();
    Lamp {
        place,
        position,
        radius: (radius * (1.0 + 1e-6)) as f32,
        attenuation: [0, 1, 2].map(least),
        terms: [0, 1, 2].map(sum),
    }
}

/// Orders lamps so that neighbours follow each other: along a curve through the cells of a grid.
fn by_place(mut lamps: Vec<Lamp>) -> Vec<Lamp> {
    let positions = || lamps.iter().map(|lamp| lamp.position);
    let low = positions().fold(DVec3::INFINITY, DVec3::min);
    let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
    let scale = 1023.0 / (high - low).max_element().max(f64::MIN_POSITIVE);
    // Every third bit of a number of ten.
    let spread = |x: f64| (0..10).fold(0u32, |all, bit| all | (x as u32 >> bit & 1) << (3 * bit));
    lamps.sort_by_cached_key(|lamp| {
        let [x, y, z] = ((lamp.position - low) * scale).to_array().map(spread);
        x | y << 1 | z << 2
    });
    lamps
}
