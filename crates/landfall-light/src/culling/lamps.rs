//! Lamps by component, in coordinates of a plane.

use glam::DVec3;
use pulp::Simd;

use crate::lanes::Lanes;

/// A lamp without range and cone, or several as the bounds of each.
#[derive(Clone, Copy)]
pub(super) struct Lamp {
    /// The index among all lights, or among groups of lamps.
    pub place: u32,
    pub position: DVec3,
    /// The largest distance of one of several from `position`.
    pub radius: f32,
    /// The coefficients by powers of the distance.
    pub attenuation: [f32; 3],
    /// The largest channels of the reflected ambient, diffuse and specular light.
    pub terms: [f32; 3],
}

/// The lamps of a group.
pub(super) const GROUP: usize = 16;

/// A value of each lamp of a group. Loops over them are compiled for whole registers.
pub(super) type Each<T> = [T; GROUP];

/// The numbers of a lamp: position along the plane's axes and normal, attenuation, terms, radius.
pub(super) const COMPONENTS: usize = 10;

/// Lamps by component.
#[derive(Clone, Default)]
pub(super) struct Lamps {
    places: Vec<u32>,
    /// The numbers of a component follow each other, and components so many numbers apart.
    values: Vec<f32>,
    stride: usize,
    /// Whether one may have an ambient term.
    ambient: bool,
}

impl Lamps {
    /// Returns no lamps, with room for so many.
    pub fn for_many(most: usize) -> Lamps {
        let values = vec![0.0; most * COMPONENTS];
        Lamps { places: Vec::with_capacity(most), values, stride: most, ambient: false }
    }

    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// The indices among all lights, in their order.
    pub fn places(&self) -> &[u32] {
        &self.places
    }

    /// Adds lamps, for which there is room, with their positions as coordinates.
    pub fn extend(&mut self, lamps: &[Lamp]) {
        for axis in 0..3 {
            self.fill(axis, lamps, |lamp| lamp.position[axis] as f32);
            self.fill(3 + axis, lamps, |lamp| lamp.attenuation[axis]);
            self.fill(6 + axis, lamps, |lamp| lamp.terms[axis]);
        }
        self.fill(9, lamps, |lamp| lamp.radius);
        self.places.extend(lamps.iter().map(|lamp| lamp.place));
        self.ambient |= lamps.iter().any(|lamp| lamp.terms[0] != 0.0);
    }

    /// Adds those of others, for which there is room, at these indices behind the first, with coordinates
    /// by axis.
    #[inline(always)]
    pub fn extend_from(
        &mut self,
        others: &Lamps,
        first: usize,
        indices: &[u32],
        at: &[Each<f64>; 3],
    ) {
        for (axis, at) in at.iter().enumerate() {
            self.fill(axis, indices, |index| at[*index as usize] as f32);
        }
        for component in 3..COMPONENTS {
            let all = &others.component(component)[first..];
            self.fill(component, indices, |index| all[*index as usize]);
        }
        let all = &others.places[first..];
        self.places.extend(indices.iter().map(|index| all[*index as usize]));
        self.ambient |= others.ambient;
    }

    /// Whether one of them may have an ambient term.
    pub fn is_ambient(&self) -> bool {
        self.ambient
    }

    /// Writes a component of lamps behind those that there are.
    #[inline(always)]
    fn fill<T>(&mut self, component: usize, lamps: &[T], value: impl Fn(&T) -> f32) {
        let first = component * self.stride + self.places.len();
        for (to, lamp) in self.values[first..].iter_mut().zip(lamps) {
            *to = value(lamp);
        }
    }

    /// Returns those at these indices.
    pub fn some(&self, indices: &[u32]) -> Lamps {
        let mut values = Vec::with_capacity(indices.len() * COMPONENTS);
        for component in 0..COMPONENTS {
            let all = self.component(component);
            values.extend(indices.iter().map(|at| all[*at as usize]));
        }
        Lamps { values, stride: indices.len(), ambient: self.ambient, ..self.some_places(indices) }
    }

    /// Returns the places of those at these indices, without their numbers.
    pub fn some_places(&self, indices: &[u32]) -> Lamps {
        let places = indices.iter().map(|at| self.places[*at as usize]).collect();
        Lamps { places, ..Lamps::default() }
    }

    #[inline(always)]
    fn component(&self, component: usize) -> &[f32] {
        &self.values[component * self.stride..][..self.places.len()]
    }

    /// Reads a register of each component.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, first: usize, count: usize) -> [Lanes<S>; COMPONENTS] {
        let mut light = [Lanes::zero(simd); COMPONENTS];
        for (component, lanes) in light.iter_mut().enumerate() {
            *lanes = Lanes::load(simd, &self.component(component)[first..first + count]);
        }
        light
    }
}
