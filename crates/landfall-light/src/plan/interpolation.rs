//! Interpolates far lights between the nodes of grids, for the compiled models and the backends.

use glam::{DVec3, Vec3};
use pulp::{Simd, WithSimd};

use super::{Draw, Grid, Plan};
use crate::lanes::{Lanes, MOST};

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

/// The positions of fragments.
pub(crate) type Position<'a> = &'a dyn Fn(u32) -> Option<Vec3>;

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
            surfaces.push(match parent {
                Some(parent) => parent.within(grid).plus(own),
                None => own,
            });
        }
        Interpolation { surfaces }
    }

    /// Adds the light of a draw's grid to the colours of its fragments.
    pub fn add(&self, draw: &Draw, position: Position<'_>, colors: &mut [Vec3]) {
        if let Some(surface) = draw.grid.and_then(|grid| self.surfaces.get(grid as usize)) {
            pulp::Arch::new().dispatch(Fragments { draw, surface, position, colors });
        }
    }
}

/// The fragments of a draw, to whose colours a polynomial is added.
struct Fragments<'a> {
    draw: &'a Draw,
    surface: &'a Polynomial,
    position: Position<'a>,
    colors: &'a mut [Vec3],
}

impl WithSimd for Fragments<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Fragments { draw, surface, position, colors } = self;
        let axes = [0, 1].map(|at| (surface.axes[at] / surface.half[at]).as_vec3());
        let coefficients = surface.chebyshev();
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
            // By Clenshaw's recurrence, which rounds less than powers of the variables.
            let (twice_x, twice_y) = (x + x, y + y);
            let (mut sums, mut last) = ([zero; 3], [zero; 3]);
            for (power, row) in coefficients.chunks_exact(surface.side.max(1)).enumerate().rev() {
                let (mut values, mut before) = ([zero; 3], [zero; 3]);
                for (power, coefficient) in row.iter().enumerate().rev() {
                    let by = if power == 0 { x } else { twice_x };
                    for channel in 0..3 {
                        let value = values[channel] * by - before[channel] + coefficient[channel];
                        (before[channel], values[channel]) = (values[channel], value);
                    }
                }
                let by = if power == 0 { y } else { twice_y };
                for channel in 0..3 {
                    let sum = sums[channel] * by - last[channel] + values[channel];
                    (last[channel], sums[channel]) = (sums[channel], sum);
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

/// A polynomial in two variables, from -1 to 1 on a rectangle.
struct Polynomial {
    center: DVec3,
    axes: [DVec3; 2],
    half: [f64; 2],
    side: usize,
    /// For each power of the second variable, the coefficients of the first.
    coefficients: Vec<DVec3>,
}

impl Polynomial {
    /// Returns the polynomial of these values at a grid's nodes.
    fn through(grid: &Grid, basis: &Basis, values: &[Vec3]) -> Polynomial {
        let side = basis.places.len();
        // Along the first variable, then along the second.
        let mut along = vec![DVec3::ZERO; side * side];
        for (along, values) in
            along.chunks_exact_mut(side.max(1)).zip(values.chunks_exact(side.max(1)))
        {
            for (value, of) in values.iter().zip(&basis.coefficients) {
                let value = value.as_dvec3();
                along.iter_mut().zip(of).for_each(|(sum, of)| *sum += value * *of);
            }
        }
        let mut coefficients = vec![DVec3::ZERO; side * side];
        for (along, of) in along.chunks_exact(side.max(1)).zip(&basis.coefficients) {
            for (sums, of) in coefficients.chunks_exact_mut(side.max(1)).zip(of) {
                sums.iter_mut().zip(along).for_each(|(sum, along)| *sum += *along * *of);
            }
        }
        let Grid { center, axes, half, .. } = *grid;
        Polynomial { center, axes, half, side, coefficients }
    }

    /// Returns this polynomial in the variables of a grid on the same axes.
    fn within(&self, grid: &Grid) -> Polynomial {
        debug_assert_eq!(self.axes, grid.axes);
        let from = grid.center - self.center;
        let [x, y] = [0, 1].map(|axis| {
            (from.dot(self.axes[axis]) / self.half[axis], grid.half[axis] / self.half[axis])
        });
        let side = self.side;
        let mut coefficients = self.coefficients.clone();
        for row in 0..side {
            substitute(&mut coefficients, (row * side, 1), side, x);
        }
        for column in 0..side {
            substitute(&mut coefficients, (column, side), side, y);
        }
        let Grid { center, axes, half, .. } = *grid;
        Polynomial { center, axes, half, side, coefficients }
    }

    /// Returns the coefficients of Chebyshev polynomials in place of powers.
    fn chebyshev(&self) -> Vec<Vec3> {
        let side = self.side;
        let mut coefficients = self.coefficients.clone();
        for row in 0..side {
            expand(&mut coefficients, (row * side, 1), side);
        }
        for column in 0..side {
            expand(&mut coefficients, (column, side), side);
        }
        coefficients.iter().map(|coefficient| coefficient.as_vec3()).collect()
    }

    /// Returns the sum of two polynomials in the same variables.
    fn plus(self, other: Polynomial) -> Polynomial {
        let (mut more, less) = if self.side < other.side { (other, self) } else { (self, other) };
        let rows = more.coefficients.chunks_exact_mut(more.side.max(1));
        for (row, other) in rows.zip(less.coefficients.chunks_exact(less.side.max(1))) {
            row.iter_mut().zip(other).for_each(|(sum, other)| *sum += *other);
        }
        more
    }
}

/// Puts Chebyshev polynomials for the powers of a polynomial, whose coefficients are `step` apart.
fn expand(of: &mut [DVec3], (first, step): (usize, usize), side: usize) {
    let mut sum = vec![DVec3::ZERO; side + 1];
    for power in (0..side).rev() {
        // Times `x`: `x T_0 = T_1`, `2 x T_n = T_(n + 1) + T_(n - 1)`.
        let mut next = vec![DVec3::ZERO; side + 1];
        for n in 0..side {
            match n {
                0 => next[1] += sum[0],
                _ => {
                    next[n + 1] += sum[n] * 0.5;
                    next[n - 1] += sum[n] * 0.5;
                }
            }
        }
        next[0] += of[first + power * step];
        sum = next;
    }
    for (power, coefficient) in sum.iter().take(side).enumerate() {
        of[first + power * step] = *coefficient;
    }
}

/// Puts `a + b x` for the variable of a polynomial, whose coefficients are `step` apart.
fn substitute(of: &mut [DVec3], (first, step): (usize, usize), side: usize, (a, b): (f64, f64)) {
    let at = |power: usize| first + power * step;
    // By Horner's rule: the rows of Pascal's triangle in place.
    for lowest in (0..side.saturating_sub(1)).rev() {
        for power in lowest..side - 1 {
            let next = of[at(power + 1)];
            of[at(power)] += next * a;
        }
    }
    let mut scale = 1.0;
    for power in 0..side {
        of[at(power)] *= scale;
        scale *= b;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Draw, LightSet};

    /// Grids in each other give the sum of their polynomials, here those of degree 2 of known values.
    #[test]
    fn a_fragment_has_the_sum_of_all_grids_around_it() {
        let value = |at: DVec3| Vec3::new((at.x * at.x) as f32, (at.x * at.y) as f32, 1.0);
        let grid = |side: u32, center: DVec3, half: [f64; 2], parent: Option<u32>| Grid {
            nodes: Vec::new(),
            side,
            lights: LightSet::default(),
            parent,
            center,
            axes: [DVec3::X, DVec3::Y],
            half,
        };
        let grids = vec![
            grid(4, DVec3::new(1.0, 2.0, 0.0), [8.0, 4.0], None),
            grid(3, DVec3::new(-1.0, 1.0, 0.0), [2.0, 1.0], Some(0)),
            grid(6, DVec3::new(-1.5, 1.5, 0.0), [1.0, 0.5], Some(1)),
        ];
        let values = |grid: &Grid| -> Vec<Vec3> {
            let places = places(grid.side);
            let rows = places.iter().flat_map(|y| places.iter().map(move |x| (x, y)));
            rows.map(|(x, y)| {
                value(grid.center + DVec3::new(x * grid.half[0], y * grid.half[1], 0.0))
            })
            .collect()
        };
        let nodes: Vec<Vec<Vec3>> = grids.iter().map(values).collect();
        let draw = Draw { fragments: vec![0, 2], grid: Some(2), ..Draw::default() };
        let plan = Plan { draws: vec![draw], grids, ..Plan::default() };
        let at = [Vec3::new(-1.2, 1.1, 0.0), Vec3::ZERO, Vec3::new(-2.0, 1.9, 0.0)];
        let mut colors = [Vec3::ONE; 3];
        interpolate(&plan, &nodes, |number| at.get(number as usize).copied(), &mut colors);
        assert_eq!(colors[1], Vec3::ONE);
        for number in [0, 2] {
            let expected = 3.0 * value(at[number].as_dvec3()) + Vec3::ONE;
            assert!((colors[number] - expected).abs().max_element() < 1e-5, "{}", colors[number]);
        }
    }
}
