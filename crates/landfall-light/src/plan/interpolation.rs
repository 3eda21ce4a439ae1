//! Interpolates far lights between the nodes of grids, for the compiled models and the backends.

use glam::{DVec3, Vec3, Vec3A};
use pulp::{Simd, WithSimd};

use super::{Draw, Grid, Plan};
use crate::lanes::Lanes;

/// Adds the interpolated light of every draw's grid to `colors`, the colours of the frame's
/// fragments; `nodes` holds the light of each grid at its nodes.
pub fn interpolate(
    plan: &Plan,
    nodes: &[Vec<Vec3>],
    position: impl Fn(u32) -> Option<Vec3>,
    colors: &mut [Vec3],
) {
    let grids = Interpolation::new(plan, nodes);
    plan.draws.iter().for_each(|draw| grids.add(draw, &position, colors));
}

/// The light of a plan's grids between their nodes.
pub(crate) struct Interpolation {
    /// Of each grid, that of its parents included.
    surfaces: Vec<Polynomial>,
}

impl Interpolation {
    /// Returns the light for that at the nodes of each grid.
    pub fn new(plan: &Plan, nodes: &[Vec<Vec3>]) -> Interpolation {
        let most = plan.grids.iter().map(|grid| grid.side).max().unwrap_or_default();
        let bases: Vec<Basis> = (0..=most).map(Basis::new).collect();
        let mut surfaces: Vec<Polynomial> = Vec::with_capacity(plan.grids.len());
        for (grid, own) in plan.grids.iter().zip(nodes) {
            let own = Polynomial::through(grid, &bases[grid.side as usize], own);
            let parent = grid.parent.and_then(|parent| surfaces.get(parent as usize));
            let whole = parent.map(|parent| {
                // A polynomial of the higher degree has the values of both.
                let basis = &bases[own.side.max(parent.side)];
                let value = |y: &f64, x: &f64| {
                    let at = grid.center
                        + grid.axes[0] * (x * grid.half[0])
                        + grid.axes[1] * (y * grid.half[1]);
                    Vec3::from(own.at(at) + parent.at(at))
                };
                let row = |y| basis.places.iter().map(move |x| value(y, x));
                let values: Vec<Vec3> = basis.places.iter().flat_map(row).collect();
                Polynomial::through(grid, basis, &values)
            });
            surfaces.push(whole.unwrap_or(own));
        }
        Interpolation { surfaces }
    }

    /// Adds the light of a draw's grid to the colours of its fragments.
    pub fn add(&self, draw: &Draw, position: &impl Fn(u32) -> Option<Vec3>, colors: &mut [Vec3]) {
        if let Some(surface) = draw.grid.and_then(|grid| self.surfaces.get(grid as usize)) {
            pulp::Arch::new().dispatch(Fragments { draw, surface, position, colors });
        }
    }
}

/// The fragments of a draw, to whose colours a polynomial is added.
struct Fragments<'a, F> {
    draw: &'a Draw,
    surface: &'a Polynomial,
    position: &'a F,
    colors: &'a mut [Vec3],
}

/// The most lanes of any processor.
const MOST: usize = 16;

impl<F: Fn(u32) -> Option<Vec3>> WithSimd for Fragments<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Fragments { draw, surface, position, colors } = self;
        let axes = surface.axes.map(|axis| axis.as_vec3());
        let center = surface.center.as_vec3();
        let rest = (surface.center - center.as_dvec3()).as_vec3();
        for numbers in draw.fragments.chunks(S::F32_LANES.min(MOST)) {
            let mut at = [[0.0; MOST]; 3];
            for (lane, &number) in numbers.iter().enumerate() {
                let position = position(number).unwrap_or_default();
                (at[0][lane], at[1][lane], at[2][lane]) = position.into();
            }
            let lanes = numbers.len();
            // The coordinates of a small patch are differences of large ones, which are exact.
            let [dx, dy, dz] = [
                Lanes::load(simd, &at[0][..lanes]) - center.x - rest.x,
                Lanes::load(simd, &at[1][..lanes]) - center.y - rest.y,
                Lanes::load(simd, &at[2][..lanes]) - center.z - rest.z,
            ];
            let x = dx * axes[0].x + dy * axes[0].y + dz * axes[0].z;
            let y = dx * axes[1].x + dy * axes[1].y + dz * axes[1].z;
            let zero = x.splat(0.0);
            let mut sums = [zero; 3];
            for row in surface.coefficients.chunks_exact(surface.side).rev() {
                let mut values = [zero; 3];
                for coefficient in row.iter().rev() {
                    for channel in 0..3 {
                        values[channel] = values[channel] * x + coefficient[channel];
                    }
                }
                for channel in 0..3 {
                    sums[channel] = sums[channel] * y + values[channel];
                }
            }
            let mut stored = [[0.0; MOST]; 3];
            for channel in 0..3 {
                sums[channel].store(&mut stored[channel][..lanes]);
            }
            for (lane, &number) in numbers.iter().enumerate() {
                if let (Some(color), true) =
                    (colors.get_mut(number as usize), position(number).is_some())
                {
                    *color += Vec3::new(stored[0][lane], stored[1][lane], stored[2][lane]);
                }
            }
        }
    }
}

/// Returns the nodes along an axis from -1 to 1: the roots of a Chebyshev polynomial.
pub(crate) fn places(side: u32) -> Vec<f64> {
    let place = |i: u32| -(std::f64::consts::PI * f64::from(2 * i + 1) / f64::from(2 * side)).cos();
    (0..side).map(place).collect()
}

/// A polynomial in two variables.
struct Polynomial {
    center: DVec3,
    /// The axes over half the length of their sides.
    axes: [DVec3; 2],
    side: usize,
    /// For each power of the second variable, the coefficients of the first.
    coefficients: Vec<Vec3A>,
}

impl Polynomial {
    fn through(grid: &Grid, basis: &Basis, values: &[Vec3]) -> Polynomial {
        let side = basis.places.len();
        // Along the first variable, then along the second.
        let mut along = vec![DVec3::ZERO; side * side];
        for (at, coefficient) in along.iter_mut().enumerate() {
            let row = values.iter().skip(at / side * side).zip(&basis.coefficients);
            *coefficient = row.map(|(value, of)| value.as_dvec3() * of[at % side]).sum();
        }
        let coefficient = |at: usize| {
            let column = along.iter().skip(at % side).step_by(side).zip(&basis.coefficients);
            column.map(|(value, of)| *value * of[at / side]).sum::<DVec3>().as_vec3a()
        };
        let coefficients = (0..side * side).map(coefficient).collect();
        let axes = [0, 1].map(|axis| grid.axes[axis] / grid.half[axis]);
        Polynomial { center: grid.center, axes, side, coefficients }
    }

    fn at(&self, position: DVec3) -> Vec3A {
        let from = position - self.center;
        let (x, y) = (from.dot(self.axes[0]) as f32, from.dot(self.axes[1]) as f32);
        let mut sum = Vec3A::ZERO;
        for row in self.coefficients.chunks_exact(self.side).rev() {
            let mut value = Vec3A::ZERO;
            for coefficient in row.iter().rev() {
                value = value * x + *coefficient;
            }
            sum = sum * y + value;
        }
        sum
    }
}

/// The polynomials that are 1 at one node of a side and 0 at the others.
struct Basis {
    places: Vec<f64>,
    /// The coefficients of each.
    coefficients: Vec<Vec<f64>>,
}

impl Basis {
    fn new(side: u32) -> Basis {
        let places = places(side);
        let one = |i: usize| {
            let mut polynomial = vec![1.0];
            for (_, place) in places.iter().enumerate().filter(|&(j, _)| j != i) {
                let scale = 1.0 / (places[i] - place);
                let mut next = vec![0.0; polynomial.len() + 1];
                for (power, coefficient) in polynomial.iter().enumerate() {
                    next[power + 1] += coefficient * scale;
                    next[power] -= coefficient * place * scale;
                }
                polynomial = next;
            }
            polynomial
        };
        let coefficients = (0..places.len()).map(one).collect();
        Basis { places, coefficients }
    }
}
