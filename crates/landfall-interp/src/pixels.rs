//! The pixels of a batch, and the inputs that a triangle over the image gives them.

use super::code::{Class, LANES};
use super::interface::{InterfaceVariable, Port};
use super::lanes::Lanes;
use super::machine::Machine;
use super::numbers::Numbers;
use super::real::Real;
use super::stage::set_register;

/// Returns the pixels of a tile of eight by eight, in quads: right and below are the next lanes.
pub(super) fn tile(batch: usize, across: usize) -> [[u32; 2]; LANES] {
    let (x, y) = ((batch % across.max(1)) as u32 * 8, (batch / across.max(1)) as u32 * 8);
    std::array::from_fn(|lane| {
        let (lane, quad) = (lane as u32, lane as u32 / 4);
        [x + quad % 4 * 2 + (lane & 1), y + quad / 4 * 2 + (lane >> 1 & 1)]
    })
}

/// Returns the pixels of a batch in row order.
pub(super) fn row(batch: usize, width: u32) -> [[u32; 2]; LANES] {
    let width = u64::from(width.max(1));
    let first = (batch * LANES) as u64;
    let (mut x, mut y) = ((first % width) as u32, (first / width) as u32);
    std::array::from_fn(|_| {
        let place = [x, y];
        x += 1;
        if u64::from(x) == width {
            (x, y) = (0, y + 1);
        }
        place
    })
}

/// The outputs of three vertices.
pub(super) struct Triangle {
    /// The positions in clip space.
    corners: [[f64; 4]; 3],
    /// By input of the fragment stage and scalar.
    values: Vec<Vec<[f64; 3]>>,
    words: Vec<Vec<[u64; 3]>>,
    /// Whether the image's first row is at the top, y = 1, and depth runs from 0 to 1.
    wgsl: bool,
}

impl Triangle {
    pub fn new(ports: &[(Port, Numbers)], plugs: &[InterfaceVariable], wgsl: bool) -> Triangle {
        let find = |port: Port| ports.iter().find(|(p, _)| *p == port).map(|(_, numbers)| numbers);
        let mut corners = [[0.0, 0.0, 0.0, 1.0]; 3];
        if let Some(position) = find(Port::Position) {
            for (vertex, corner) in corners.iter_mut().enumerate() {
                for (to, lanes) in corner.iter_mut().zip(&position.doubles) {
                    *to = lanes[vertex];
                }
            }
        }
        let doubles = |plug: &InterfaceVariable| match find(plug.port) {
            Some(numbers) => numbers.doubles.iter().map(|l| [l[0], l[1], l[2]]).collect(),
            None => vec![[0.0; 3]; plug.regs.len()],
        };
        let words = |plug: &InterfaceVariable| match find(plug.port) {
            Some(numbers) => numbers.words.iter().map(|l| [l[0], l[1], l[2]]).collect(),
            None => vec![[0; 3]; plug.regs.len()],
        };
        Triangle {
            corners,
            values: plugs.iter().map(doubles).collect(),
            words: plugs.iter().map(words).collect(),
            wgsl,
        }
    }

    /// Returns the perspective-correct weights of the corners at a point; `None` outside.
    fn weights(&self, x: f64, y: f64) -> Option<[f64; 3]> {
        // Corners relative to the point before the division by `w`, so that a corner behind the eye
        // needs no case of its own: the sign of each cross product tells the side of an edge.
        let across = self.corners.map(|c| c[0] - x * c[3]);
        let up = self.corners.map(|c| c[1] - y * c[3]);
        let cross = |i: usize, j: usize| across[i] * up[j] - across[j] * up[i];
        let weights = [cross(1, 2), cross(2, 0), cross(0, 1)];
        let sum: f64 = weights.iter().sum();
        let weights = weights.map(|w| w / sum);
        weights.iter().all(|w| *w >= 0.0).then_some(weights)
    }

    /// Sets the inputs of a tile and returns the lanes it covers.
    pub fn fill<R: Real>(
        &self,
        m: &mut Machine<R>,
        plugs: &[InterfaceVariable],
        places: &[[u32; 2]; LANES],
        [width, height]: [u32; 2],
    ) -> u64 {
        let mut covered = 0;
        // A lane outside of the triangle, which helps with derivatives, has the first corner's
        // values.
        let mut weights = [[1.0, 0.0, 0.0]; LANES];
        for (lane, [x, y]) in places.iter().enumerate() {
            let x = (f64::from(*x) + 0.5) / f64::from(width) * 2.0 - 1.0;
            let y = (f64::from(*y) + 0.5) / f64::from(height) * 2.0 - 1.0;
            if let Some(found) = self.weights(x, if self.wgsl { -y } else { y }) {
                weights[lane] = found;
                covered |= 1 << lane;
            }
        }
        for (number, plug) in plugs.iter().enumerate() {
            for (i, &reg) in plug.regs.iter().enumerate() {
                let values = self.values[number].get(i).copied().unwrap_or_default();
                let words = self.words[number].get(i).copied().unwrap_or_default();
                let each = |f: &dyn Fn(usize) -> f64| -> R::Lanes {
                    let mut all = R::Lanes::filled(R::default());
                    (0..LANES).for_each(|lane| all.put(lane, R::wide(f(lane))));
                    all
                };
                match (plug.port, reg.class()) {
                    (Port::Position, _) => {
                        // Depth is linear in the image. OpenGL maps its range of -1 to 1 to 0 to 1.
                        let depth = |lane: usize| {
                            let near = self.linear(weights[lane]);
                            let z = sum(near, self.corners.map(|c| c[2] / c[3]));
                            if self.wgsl { z } else { z * 0.5 + 0.5 }
                        };
                        // The inverse of the clip space `w`.
                        let inverse =
                            |lane: usize| 1.0 / sum(weights[lane], self.corners.map(|c| c[3]));
                        *m.reals_of(reg) = match i {
                            0 => each(&|lane| f64::from(places[lane][0]) + 0.5),
                            1 => each(&|lane| f64::from(places[lane][1]) + 0.5),
                            2 => each(&depth),
                            _ => each(&inverse),
                        };
                    }
                    (Port::FrontFacing, _) => *m.words_of(reg) = [1; LANES],
                    (_, Class::Real) if plug.flat => {
                        *m.reals_of(reg) = R::Lanes::filled(R::wide(values[self.provoking()]));
                    }
                    (_, Class::Real) if plug.linear => {
                        *m.reals_of(reg) = each(&|lane| sum(self.linear(weights[lane]), values));
                    }
                    (_, Class::Real) => {
                        *m.reals_of(reg) = each(&|lane| sum(weights[lane], values));
                    }
                    (_, Class::Word | Class::Wide) => {
                        set_register(m, reg, &[words[self.provoking()]]);
                    }
                }
            }
        }
        covered
    }

    /// Returns the corner whose values flat inputs have: the first in WGSL, and the last in OpenGL unless it
    /// is told otherwise, whose image and depth GLSL has here, too.
    fn provoking(&self) -> usize {
        if self.wgsl { 0 } else { 2 }
    }

    /// Returns the weights in screen space, without perspective.
    fn linear(&self, weights: [f64; 3]) -> [f64; 3] {
        let scaled: [f64; 3] = std::array::from_fn(|i| weights[i] * self.corners[i][3]);
        let all: f64 = scaled.iter().sum();
        scaled.map(|w| w / all)
    }
}

/// Returns the weighted sum; equal values are returned unchanged.
fn sum(weights: [f64; 3], values: [f64; 3]) -> f64 {
    values[0] + weights[1] * (values[1] - values[0]) + weights[2] * (values[2] - values[0])
}
