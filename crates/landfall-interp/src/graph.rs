//! A function as a graph of guarded values, evaluated over boxes of its inputs.
//!
//! `function` and `control` follow the code of a [`Program`](super::Program) once for a whole box:
//! both sides of an undecided branch, loops unrolled up to a limit. [`Graph::bounds`] then encloses
//! every value over any smaller box: the values that any conformant device may give to the
//! expressions as written (`interval`), the exact reals (`exact`), or one rounded value at a point.
//! [`Graph::errors`] bounds the errors of the results from all roundings (`error`). Values that
//! depend on the same inputs are also enclosed by linear functions of those inputs (`affine`).
//!
//! An operation breaks where its result is undefined, not finite, or a difference that has lost
//! more than half of its digits. Each operation that can break is a [`Site`]; its fault is possible
//! over a box unless the enclosures of its operands exclude it. An operation after a fault is
//! followed as if the fault had not occurred, so that a box without any possible fault has none.
//!
//! Two evaluations of one expression of the same values count as one value, and comparisons take
//! subnormal operands as they are. The sine and cosine of any angle are taken to lie from -1 to 1
//! up to their permitted error. Textures may hold any numbers from their least to their greatest
//! texel. Values of double precision and 64-bit integers are not followed.

mod affine;
mod arithmetic;
mod bounds;
mod cast;
mod context;
mod control;
mod correlated;
mod distance;
mod error;
mod exact;
mod fault;
mod function;
mod guard;
mod instruction;
mod memory;
mod node;
mod paths;
mod site;
mod value;
mod vector;
mod word;

pub use bounds::Bounds;
pub use distance::Distance;
pub use error::Rounding;
pub use fault::Fault;
pub use function::{Given, GraphInputs};
pub use value::Arithmetic;

use std::collections::BTreeMap;

pub use super::interval::Interval as Range;
use super::undefined::SourceLocation;
use guard::Guard;
use node::{Node, NodeId};

/// A function as a graph of values; see the [module](self).
#[derive(Debug)]
pub struct Graph {
    nodes: Vec<Node>,
    /// The operands of the nodes.
    operands: Vec<NodeId>,
    guards: Vec<Guard>,
    /// Vectors of length one up to rounding, by the nodes of their components.
    units: Vec<Vec<NodeId>>,
    /// By unit vector component: the vectors it is part of.
    unit_of: BTreeMap<NodeId, Vec<usize>>,
    /// By value: its absolute value.
    absolute: BTreeMap<NodeId, NodeId>,
    sites: Vec<Site>,
    /// The scalars of the results.
    results: Vec<NodeId>,
    /// By input scalar: its node.
    inputs: Vec<NodeId>,
    /// By value: whether it needs an affine form.
    needs: Vec<affine::Need>,
}

/// An operation that can break, with one of its faults.
#[derive(Clone, Debug)]
pub struct Site {
    pub fault: Fault,
    /// The operation.
    pub place: SourceLocation,
    /// The inputs that its operands depend on, by scalar.
    pub inputs: Vec<usize>,
    node: NodeId,
}

/// The most values of a graph.
const MAX_NODES: usize = 1 << 16;

/// The most instructions that are followed: calls of calls compute few values many times.
const MAX_INSTRUCTIONS: u32 = 1 << 20;

/// The most iterations of a loop that are followed.
const MAX_ITERATIONS: usize = 256;

impl Graph {
    pub fn sites(&self) -> &[Site] {
        &self.sites
    }

    /// Returns the number of values.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Whether a value is an input, a constant or chosen among such.
    fn is_exact(&self, id: NodeId) -> bool {
        self.nodes[id as usize].exact
    }

    fn operands(&self, node: &Node) -> &[NodeId] {
        &self.operands[node.first as usize..(node.first + node.count) as usize]
    }
}
