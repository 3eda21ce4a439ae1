//! Highlights of lights behind the surface: powers that no condition on the light's side cuts off.
//!
//! Powers are recorded during the walk; their factors are known at the end.

use naga::{BinaryOperator as B, MathFunction as M};

use super::graph::{GraphOp, Id};
use super::walk::Walk;
use super::{Certainty, Hazard};
use landfall_layout::source::Span;

/// The number of values above a power that are examined.
const MAX_ABOVE: usize = 400;

#[derive(Clone, Copy, Debug)]
pub struct SpecularPower {
    node: Id,
    base: Id,
    normal: Id,
    span: Span,
    /// Whether an enclosing condition tests the light's side.
    gated: bool,
}

impl Walk<'_> {
    pub fn note_power(&mut self, base: Id, node: Id, span: Span) {
        let Some(normal) = self.normal_of_highlight(base) else { return };
        // `if (dot(n, l) > 0.0)` around it: an assumption about the cosine with another vector
        // than the highlight's own.
        let gated = self.assumed.iter().any(|(id, facts)| {
            (facts.low >= 0.0 || facts.nonzero) && self.depends_on_side(*id, normal, base)
        });
        self.powers.push(SpecularPower { node, base, normal, span, gated });
    }

    /// Returns the normal of `dot(v, reflect(-l, n))` or `dot(n, normalize(l + v))`.
    fn normal_of_highlight(&self, base: Id) -> Option<Id> {
        let mut found = None;
        self.graph.contains(base, &mut |id| {
            let &[a, b] = self.graph.args(id) else { return false };
            if !self.graph.is_math(id, M::Dot) || a == b {
                return false;
            }
            // Phong: the cosine with a reflected vector; the normal is the second argument of
            // `reflect`. Blinn-Phong: the cosine with a normalised sum of two directions; the
            // normal is the other factor.
            for (x, other) in [(a, b), (b, a)] {
                let mut mirrored = x;
                if self.graph.is_math(mirrored, M::Normalize) {
                    mirrored = self.graph.args(mirrored)[0];
                }
                if self.graph.is_math(mirrored, M::Reflect) {
                    found = self.graph.args(mirrored).get(1).copied();
                } else if let Some((l, v)) = self.graph.binary(mirrored, B::Add) {
                    // With one of the two it is half of, it is Fresnel's term and no highlight.
                    if mirrored != x && other != l && other != v {
                        found = Some(other);
                    }
                }
            }
            found.is_some()
        });
        found
    }

    /// Returns whether a value contains the normal's cosine with a direction other than the
    /// highlight's.
    fn depends_on_side(&self, id: Id, normal: Id, base: Id) -> bool {
        self.graph.contains(id, &mut |id| {
            self.graph.is_math(id, M::Dot)
                && self.graph.args(id).contains(&normal)
                && !self.graph.contains(base, &mut |below| below == id)
        })
    }

    pub fn look_at_specular(&mut self) {
        if self.powers.is_empty() {
            return;
        }
        // The graph has edges to arguments; here they are turned round, once for all powers.
        let mut above: Vec<Vec<Id>> = vec![Vec::new(); self.graph.nodes.len()];
        for (id, node) in self.graph.nodes.iter().enumerate() {
            for &arg in &node.args {
                above[arg as usize].push(id as Id);
            }
        }
        for power in std::mem::take(&mut self.powers) {
            if power.gated || self.is_multiplied(&above, &power) {
                continue;
            }
            let (hazard, sure) = (Hazard::HighlightFromBehind, Certainty::Possible);
            self.report(hazard, sure, power.span, String::new());
        }
    }

    /// Returns whether the highlight is multiplied by a factor that depends on the light's side.
    fn is_multiplied(&self, above: &[Vec<Id>], power: &SpecularPower) -> bool {
        // Upwards from the power to where it is used: a product with `max(dot(n, l), 0)` or a
        // choice by it turns the highlight off behind the surface.
        let mut todo = vec![power.node];
        let mut seen = 0;
        while let Some(id) = todo.pop() {
            for &user in &above[id as usize] {
                seen += 1;
                // Too much to examine: it counts as not multiplied, and is reported as possible.
                if seen > MAX_ABOVE {
                    return false;
                }
                match (self.graph.op(user), self.graph.args(user)) {
                    (GraphOp::Binary(B::Multiply), &[a, b]) => {
                        let other = if a == id { b } else { a };
                        if self.depends_on_side(other, power.normal, power.base) {
                            return true;
                        }
                        todo.push(user);
                    }
                    (GraphOp::Chosen, &[condition, ..]) => {
                        if self.depends_on_side(condition, power.normal, power.base) {
                            return true;
                        }
                        todo.push(user);
                    }
                    // What it is added to is multiplied with it.
                    (
                        GraphOp::Binary(B::Add | B::Subtract)
                        | GraphOp::Joined(_)
                        | GraphOp::Part(_)
                        | GraphOp::Compose
                        | GraphOp::Swizzle(_),
                        _,
                    ) => {
                        todo.push(user);
                    }
                    _ => {}
                }
            }
        }
        false
    }
}
