//! Lamps by component at their places in space, for planes in any direction.

use super::bound::AWAY;
use super::lamps::{Each, GROUP, Lamp, Lamps};
use super::plane::Plane;

/// A group of neighbouring lamps. The last group, if it has fewer, is filled up with its first lamp.
pub(super) struct Group {
    position: [Each<f64>; 3],
    radius: Each<f64>,
    /// Whether they add nothing to surfaces that face away, if those have no highlights.
    dark: Each<bool>,
    /// The same if they have.
    dark_and_dull: Each<bool>,
}

impl Group {
    fn new(lamps: &[Lamp]) -> Group {
        let lamp = |at: usize| lamps.get(at).unwrap_or(&lamps[0]);
        let position = |axis: usize| std::array::from_fn(|at| lamp(at).position[axis]);
        Group {
            position: [0, 1, 2].map(position),
            radius: std::array::from_fn(|at| f64::from(lamp(at).radius)),
            dark: std::array::from_fn(|at| lamp(at).terms[0] == 0.0),
            dark_and_dull: std::array::from_fn(|at| {
                let [ambient, _, specular] = lamp(at).terms;
                ambient == 0.0 && specular == 0.0
            }),
        }
    }

    /// Whether lamps add nothing to surfaces that face away; `back` if those have highlights.
    pub fn dark_behind(&self, back: bool) -> &Each<bool> {
        if back { &self.dark_and_dull } else { &self.dark }
    }

    /// Returns the coordinates of each along the axes and the normal of a plane.
    #[inline(always)]
    pub fn along(&self, plane: &Plane) -> [Each<f64>; 3] {
        let [x, y, z] = &self.position;
        let Plane { origin, axes: [first, second], normal, .. } = plane;
        let mut along = [[0.0; GROUP]; 3];
        for (along, axis) in along.iter_mut().zip([first, second, normal]) {
            for at in 0..GROUP {
                let [x, y, z] = [x[at] - origin.x, y[at] - origin.y, z[at] - origin.z];
                along[at] = x * axis.x + y * axis.y + z * axis.z;
            }
        }
        along
    }

    /// Returns whether lamps at these coordinates are above a plane, and whether that is so for all
    /// fragments as they compute it.
    #[inline(always)]
    pub fn sides(&self, [x, y, height]: &[Each<f64>; 3], plane: &Plane) -> [Each<bool>; 2] {
        // Fragments are off the plane, their normals off its own, and distances rounded.
        let off = 2.0 * (plane.off + plane.moved + plane.rounding);
        let tilt = plane.tilt + 2e-5;
        let [mut above, mut known] = [[false; GROUP]; 2];
        for at in 0..GROUP {
            let far = x[at].abs() + y[at].abs() + height[at].abs() + self.radius[at];
            let off = off + tilt * (far + plane.diameter);
            above[at] = height[at] > 0.0;
            known[at] = height[at].abs() > self.radius[at] + off;
        }
        [above, known]
    }

    /// Returns whether all fragments of a plane face away from lamps at these coordinates.
    #[inline(always)]
    pub fn behind(&self, [x, y, height]: &[Each<f64>; 3], plane: &Plane) -> Each<bool> {
        let off = plane.off + plane.rounding;
        let mut behind = [false; GROUP];
        for at in 0..GROUP {
            let square = x[at] * x[at] + y[at] * y[at] + height[at] * height[at];
            let far = square.sqrt() + self.radius[at] + plane.diameter;
            behind[at] = height[at] + self.radius[at] + off + plane.tilt * far < -AWAY * far;
        }
        behind
    }
}

/// Lamps in groups.
pub(super) struct Placed {
    pub groups: Vec<Group>,
    /// The same by component, whose coordinates are not of a plane.
    pub lamps: Lamps,
}

impl Placed {
    pub fn new(all: &[Lamp]) -> Placed {
        let mut lamps = Lamps::for_many(all.len());
        lamps.extend(all);
        Placed { groups: all.chunks(GROUP).map(Group::new).collect(), lamps }
    }

    /// Returns the places of a group.
    #[inline(always)]
    pub fn places(&self, group: usize) -> &[u32] {
        let all = self.lamps.places();
        &all[group * GROUP..all.len().min((group + 1) * GROUP)]
    }
}
