//! Symbolic values: each operation is a node, and equal operations share a node.
//!
//! Built by [`walk`](super::walk), read by [`abstract_domain`](super::abstract_domain) and
//! [`checks`](super::checks).

use naga::{BinaryOperator, MathFunction};
use rustc_hash::FxHashMap;

use crate::analysis::roles::Role;

pub type Id = u32;

/// The operation of a node.
/// Numbers are equal by bits, and operations by operator and arguments, so that `a - b` written
/// twice is one node: a guard of the first is known for the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GraphOp {
    /// The bits of a number, or of the equal components of a vector.
    Number(u64),
    /// A value from outside the shader: its index in [`Graph::leaves`].
    Leaf(u32),
    /// The value of an uninitialised variable.
    /// Numbered, so that two undefined variables differ.
    Undefined(u32),
    /// A variable that a loop changes, at the start of an iteration; the argument is its value
    /// before the loop.
    Looping(u32),
    /// One of its arguments.
    Joined(u32),
    /// The second argument if the first is true, else the third.
    Chosen,
    Part(u32),
    Element,
    /// The first argument with its part replaced by the second.
    Insert(u32),
    Compose,
    Swizzle([u8; 4]),
    Negate,
    Not,
    Convert,
    Binary(BinaryOperator),
    Math(MathFunction),
    /// Any other value; no two are equal.
    Opaque(u32),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    Block,
    Interpolated,
    /// Another input, an argument, an override.
    Other,
}

/// A value from outside the shader.
#[derive(Clone, Debug)]
pub struct Leaf {
    /// The path from its block or input, with indices as nodes.
    pub key: String,
    /// The path in messages, with `[]` for indices.
    pub path: String,
    pub name: String,
    pub ty: naga::Handle<naga::Type>,
    pub origin: Origin,
    /// The block's index in the module.
    pub block: Option<usize>,
    /// The light it belongs to, and the path from there.
    pub light: Option<(usize, String)>,
    pub role: Option<Role>,
}

#[derive(Clone, Debug)]
pub struct Node {
    pub op: GraphOp,
    pub args: Vec<Id>,
}

#[derive(Debug, Default)]
pub struct Graph {
    pub nodes: Vec<Node>,
    pub leaves: Vec<Leaf>,
    known: FxHashMap<(GraphOp, Vec<Id>), Id>,
    leaf_keys: FxHashMap<String, u32>,
    fresh: u32,
}

impl Graph {
    // Hash consing. No simplification and no commutation: `a + b` and `b + a` are two nodes.
    pub fn add(&mut self, op: GraphOp, args: &[Id]) -> Id {
        let key = (op, args.to_vec());
        if let Some(&id) = self.known.get(&key) {
            return id;
        }
        let id = self.nodes.len() as Id;
        self.nodes.push(Node { op, args: args.to_vec() });
        self.known.insert(key, id);
        id
    }

    pub fn number(&mut self, value: f64) -> Id {
        // -0 is 0 to every test here.
        // One node for both zeros, since numbers are compared by bits.
        let value = if value == 0.0 { 0.0f64 } else { value };
        self.add(GraphOp::Number(value.to_bits()), &[])
    }

    pub fn next(&mut self) -> u32 {
        self.fresh += 1;
        self.fresh
    }

    pub fn opaque(&mut self, args: &[Id]) -> Id {
        let fresh = self.next();
        self.add(GraphOp::Opaque(fresh), args)
    }

    pub fn leaf(&mut self, leaf: Leaf) -> Id {
        // Leaves are one by their key: reading `light.position` twice is the same value.
        let number = match self.leaf_keys.get(&leaf.key) {
            Some(&number) => number,
            None => {
                let number = self.leaves.len() as u32;
                self.leaf_keys.insert(leaf.key.clone(), number);
                self.leaves.push(leaf);
                number
            }
        };
        self.add(GraphOp::Leaf(number), &[])
    }

    pub fn op(&self, id: Id) -> GraphOp {
        self.nodes[id as usize].op
    }

    pub fn args(&self, id: Id) -> &[Id] {
        &self.nodes[id as usize].args
    }

    pub fn value(&self, id: Id) -> Option<f64> {
        match self.op(id) {
            GraphOp::Number(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub fn as_leaf(&self, id: Id) -> Option<&Leaf> {
        match self.op(id) {
            GraphOp::Leaf(number) => Some(&self.leaves[number as usize]),
            _ => None,
        }
    }

    pub fn is_math(&self, id: Id, fun: MathFunction) -> bool {
        self.op(id) == GraphOp::Math(fun)
    }

    /// Returns the operands of a value if it is such an operation.
    pub fn binary(&self, id: Id, op: BinaryOperator) -> Option<(Id, Id)> {
        match (self.op(id), self.args(id)) {
            (GraphOp::Binary(own), &[a, b]) if own == op => Some((a, b)),
            _ => None,
        }
    }

    /// Returns the value below parts, signs and conversions.
    pub fn underlying_value(&self, mut id: Id) -> Id {
        loop {
            id = match (self.op(id), self.args(id)) {
                (
                    GraphOp::Part(_) | GraphOp::Swizzle(_) | GraphOp::Negate | GraphOp::Convert,
                    &[of],
                ) => of,
                // `.xyz` of a block's vector, component by component.
                (GraphOp::Compose, args) if !args.is_empty() => {
                    // `vec3(v.x, v.y, v.z)` and its like are `v`, as long as every part is of the
                    // same vector.
                    let mut inner = args.iter().map(|&arg| match (self.op(arg), self.args(arg)) {
                        (GraphOp::Part(_), &[of]) => Some(of),
                        _ => None,
                    });
                    match inner.next().flatten() {
                        Some(first) if inner.all(|other| other == Some(first)) => first,
                        _ => return id,
                    }
                }
                _ => return id,
            };
        }
    }

    /// Returns the leaf that a value is, or is a part of.
    pub fn bare_leaf(&self, id: Id) -> Option<&Leaf> {
        self.as_leaf(self.underlying_value(id))
    }

    /// Returns whether a predicate holds for a node or one below it; the number of nodes visited is
    /// limited.
    pub fn contains(&self, id: Id, is: &mut dyn FnMut(Id) -> bool) -> bool {
        // As in queries: what lies deeper than 400 nodes is not part of what a person wrote in one
        // place.
        let mut left = 400;
        let mut seen = rustc_hash::FxHashSet::default();
        let mut todo = vec![id];
        while let Some(id) = todo.pop() {
            if !seen.insert(id) {
                continue;
            }
            if is(id) {
                return true;
            }
            left -= 1;
            if left == 0 {
                return false;
            }
            todo.extend(self.args(id));
        }
        false
    }

    /// Returns a leaf below a node that has such a role.
    pub fn leaf_below(&self, id: Id, wanted: &dyn Fn(&Leaf) -> bool) -> Option<&Leaf> {
        let mut found = None;
        self.contains(id, &mut |id| match self.as_leaf(id) {
            Some(leaf) if wanted(leaf) => {
                found = Some(id);
                true
            }
            _ => false,
        });
        found.and_then(|id| self.as_leaf(id))
    }
}
