//! Interpolates far lights between the nodes of grids, for the compiled models and the backends.

use glam::{DVec3, Vec3};

use super::{Grid, Plan};

/// Adds the interpolated light of every draw's grid to `colors`, the colours of the frame's
/// fragments; `nodes` holds the light of each grid at its nodes.
pub fn interpolate(
    plan: &Plan,
    nodes: &[Vec<Vec3>],
    position: impl Fn(u32) -> Option<Vec3>,
    colors: &mut [Vec3],
) {
    let mut surfaces: Vec<Polynomial<'_>> = Vec::with_capacity(plan.grids.len());
    for (grid, own) in plan.grids.iter().zip(nodes) {
        let mut values = own.clone();
        if let Some(parent) = grid.parent {
            for (value, node) in values.iter_mut().zip(&grid.nodes) {
                *value += surfaces[parent as usize].at(Vec3::from(node.position));
            }
        }
        surfaces.push(Polynomial::through(grid, &values));
    }
    for draw in &plan.draws {
        let Some(surface) = draw.grid.and_then(|grid| surfaces.get(grid as usize)) else {
            continue;
        };
        for &number in &draw.fragments {
            if let (Some(at), Some(color)) = (position(number), colors.get_mut(number as usize)) {
                *color += surface.at(at);
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
struct Polynomial<'a> {
    grid: &'a Grid,
    /// For each power of the second variable, the coefficients of the first.
    coefficients: Vec<Vec3>,
}

impl<'a> Polynomial<'a> {
    fn through(grid: &'a Grid, values: &[Vec3]) -> Polynomial<'a> {
        let side = grid.side as usize;
        let basis = basis(&places(grid.side));
        let mut coefficients = vec![DVec3::ZERO; side * side];
        for (node, value) in values.iter().enumerate() {
            let (row, column) = (node / side, node % side);
            for (power, coefficient) in coefficients.iter_mut().enumerate() {
                let (y, x) = (power / side, power % side);
                *coefficient += value.as_dvec3() * (basis[row][y] * basis[column][x]);
            }
        }
        Polynomial { grid, coefficients: coefficients.iter().map(|c| c.as_vec3()).collect() }
    }

    fn at(&self, position: Vec3) -> Vec3 {
        let Grid { center, axes, half, side, .. } = self.grid;
        let from = position.as_dvec3() - *center;
        let x = (from.dot(axes[0]) / half[0]) as f32;
        let y = (from.dot(axes[1]) / half[1]) as f32;
        let horner = |terms: &[Vec3]| terms.iter().rev().fold(Vec3::ZERO, |sum, c| sum * x + *c);
        let rows = self.coefficients.chunks_exact(*side as usize).rev();
        rows.fold(Vec3::ZERO, |sum, row| sum * y + horner(row))
    }
}

/// Returns the coefficients of the polynomials that are 1 at one node and 0 at the others.
fn basis(places: &[f64]) -> Vec<Vec<f64>> {
    let one = |i: usize| {
        let mut polynomial = vec![1.0];
        for (j, place) in places.iter().enumerate().filter(|&(j, _)| j != i) {
            let scale = 1.0 / (places[i] - place);
            let mut next = vec![0.0; polynomial.len() + 1];
            for (power, coefficient) in polynomial.iter().enumerate() {
                next[power + 1] += coefficient * scale;
                next[power] -= coefficient * place * scale;
            }
            polynomial = next;
            debug_assert!(j < places.len());
        }
        polynomial
    };
    (0..places.len()).map(one).collect()
}
