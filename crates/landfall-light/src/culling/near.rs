//! The lights near a plane, and groups of neighbouring lamps, which are tested in one.

use glam::DVec3;
use pulp::NullaryFnOnce;

use super::bound::{Bounded, Shape};
use super::lamps::{GROUP, Lamp, Lamps};
use super::placed::Placed;
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

/// The lights of a material.
pub(super) struct Prepared {
    /// Neighbours follow each other.
    lamps: Placed,
    /// The bounds of each [`GROUP`] lamps, which are in groups in turn.
    groups: Placed,
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
        let groups = (0..).zip(lamps.chunks(GROUP)).map(|(at, lamps)| group(at, lamps));
        let groups: Vec<Lamp> = groups.collect();
        Prepared { groups: Placed::new(&groups), others, lamps: Placed::new(&lamps) }
    }

    /// Prepares lights of which no error is to be bounded.
    pub fn unbounded(lights: &[Bounded]) -> Prepared {
        let others = (0..lights.len() as u32).collect();
        Prepared { lamps: Placed::new(&[]), groups: Placed::new(&[]), others }
    }

    /// Returns the groups of lamps that may contribute to a plane; `back` if surfaces that face away
    /// have highlights.
    pub fn groups(&self, plane: &Plane, back: bool) -> Lamps {
        let all: Vec<_> = (0..self.groups.groups.len() as u32).map(|at| (at, u16::MAX)).collect();
        pulp::Arch::new().dispatch(Finding { from: &self.groups, groups: &all, plane, back })
    }

    /// Returns the lamps of those bits of groups that may contribute to a plane.
    pub fn lamps(&self, groups: &[(u32, u16)], plane: &Plane, back: bool) -> Lamps {
        pulp::Arch::new().dispatch(Finding { from: &self.lamps, groups, plane, back })
    }

    /// Returns the places of those lamps of these groups that may contribute to a plane; adds the bits of
    /// those whose side of it is not the same everywhere to `between`.
    pub fn far(
        &self,
        groups: &[u32],
        plane: &Plane,
        back: bool,
        between: &mut Vec<(u32, u16)>,
    ) -> Vec<u32> {
        let prepared = self;
        pulp::Arch::new().dispatch(FindingFar { prepared, groups, plane, back, between })
    }
}

struct FindingFar<'a> {
    prepared: &'a Prepared,
    groups: &'a [u32],
    plane: &'a Plane,
    back: bool,
    between: &'a mut Vec<(u32, u16)>,
}

impl NullaryFnOnce for FindingFar<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn call(self) -> Vec<u32> {
        let FindingFar { prepared, groups, plane, back, between } = self;
        let fronts = fronts(&prepared.groups, plane);
        let mut far = vec![0; groups.len() * GROUP];
        let mut len = 0;
        for &number in groups {
            let at = number as usize;
            let places = prepared.lamps.places(at);
            if fronts[at] {
                far[len..len + places.len()].copy_from_slice(places);
                len += places.len();
                continue;
            }
            let group = &prepared.lamps.groups[at];
            let [above, known] = group.sides(&group.along(plane), plane);
            let dark = group.dark_behind(back);
            let mut bits = 0;
            for (lamp, place) in places.iter().enumerate() {
                // Written without a branch, which would be taken at random.
                far[len] = *place;
                len += usize::from(known[lamp] & (above[lamp] | !dark[lamp]));
                bits |= u16::from(!known[lamp]) << lamp;
            }
            if bits != 0 {
                between.push((number, bits));
            }
        }
        far.truncate(len);
        far
    }
}

/// Returns for each of several lamps whether it is above a plane for all fragments.
#[inline(always)]
fn fronts(lamps: &Placed, plane: &Plane) -> Vec<bool> {
    let mut fronts = Vec::with_capacity(lamps.groups.len() * GROUP);
    for group in &lamps.groups {
        let [mut above, known] = group.sides(&group.along(plane), plane);
        for at in 0..GROUP {
            above[at] &= known[at];
        }
        fronts.extend_from_slice(&above);
    }
    fronts
}

struct Finding<'a> {
    from: &'a Placed,
    groups: &'a [(u32, u16)],
    plane: &'a Plane,
    back: bool,
}

impl NullaryFnOnce for Finding<'_> {
    type Output = Lamps;

    #[inline(always)]
    fn call(self) -> Lamps {
        let Finding { from, groups, plane, back } = self;
        let mut near = Lamps::for_many(groups.len() * GROUP);
        for &(number, bits) in groups {
            let group = &from.groups[number as usize];
            let at = group.along(plane);
            let behind = group.behind(&at, plane);
            let dark = group.dark_behind(back);
            let mut kept = [0; GROUP];
            let mut len = 0;
            for lamp in 0..from.places(number as usize).len() {
                kept[len] = lamp as u32;
                len += usize::from(!(behind[lamp] & dark[lamp]) & (bits >> lamp & 1 == 1));
            }
            near.extend_from(&from.lamps, number as usize * GROUP, &kept[..len], &at);
        }
        near
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Of far groups those lamps are near whose side of a plane is not the same for all fragments, and
    /// those are left out that light none.
    #[test]
    fn lamps_on_both_sides_of_a_plane_stay_near() {
        let mut random = fastrand::Rng::with_seed(5);
        let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
        let [mut are_far, mut are_near, mut are_out, mut in_front] = [0; 4];
        for round in 0..20 {
            // Some groups are in front of the plane.
            let over = |place: u32| f64::from(u8::from((place / 16).is_multiple_of(3))) * 9.0;
            let lamps: Vec<Lamp> = (0..100u32)
                .map(|place| Lamp {
                    place,
                    position: DVec3::new(
                        between(-5.0, 5.0),
                        between(-5.0, 5.0),
                        between(-0.1, 0.1) + over(place),
                    ),
                    radius: 0.0,
                    attenuation: [1.0, 0.0, 0.1],
                    terms: [0.0, 1.0, (place % 2) as f32],
                })
                .collect();
            let groups: Vec<Lamp> =
                (0..).zip(lamps.chunks(GROUP)).map(|(at, lamps)| group(at, lamps)).collect();
            let all: Vec<u32> = groups.iter().map(|group| group.place).collect();
            let (groups, placed) = (Placed::new(&groups), Placed::new(&lamps));
            let prepared = Prepared { lamps: placed, groups, others: Vec::new() };
            let normal = DVec3::new(between(-0.02, 0.02), 0.0, 1.0).normalize();
            let (first, second) = normal.any_orthonormal_pair();
            let plane = Plane {
                material: 0,
                region: Region::EMPTY,
                origin: DVec3::new(0.0, 1.0, between(-0.05, 0.05)),
                axes: [first, second],
                normal,
                off: 0.005,
                tilt: 1e-3,
                diameter: 3.0,
                rounding: 1e-6,
                moved: 1e-6,
            };
            let back = round % 2 == 0;
            let mut some = Vec::new();
            let far = prepared.far(&all, &plane, back, &mut some);
            let near = prepared.lamps(&some, &plane, back);
            in_front += fronts(&prepared.groups, &plane).iter().filter(|front| **front).count();
            let mut all = [&far, near.places()].concat();
            let count = all.len();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), count);
            for lamp in &lamps {
                let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
                for corner in 0..8 {
                    let sign = |bit: u32| f64::from(corner >> bit & 1) * 2.0 - 1.0;
                    let along = (first * sign(0) + second * sign(1)) * 1.06;
                    let point = plane.origin + along + normal * (plane.off * sign(2));
                    let normal = (normal - along / along.length() * plane.tilt).normalize();
                    let height = (lamp.position - point).dot(normal);
                    (low, high) = (low.min(height), high.max(height));
                }
                let lights = high >= 0.0 || (back && lamp.terms[2] != 0.0);
                match (far.contains(&lamp.place), near.places().contains(&lamp.place)) {
                    (true, near) => {
                        assert!(!near && lights && (low > 0.0 || high < 0.0), "{low} {high}");
                        are_far += 1;
                    }
                    (false, true) => are_near += 1,
                    (false, false) => {
                        assert!(!lights, "{low} {high}");
                        are_out += 1;
                    }
                }
            }
        }
        assert!(are_far > 500 && are_near > 50 && are_out > 200, "{are_far} {are_near} {are_out}");
        assert!(in_front >= 20, "{in_front}");
    }
}
