//! The values of a graph that need affine forms, and their forms over a box.

use super::super::code::{Class, RealBinary, RealTernary, RealUnary};
use super::super::interval::Interval;
use super::affine::{Affine, Need, VALUE, halves};
use super::bounds::Bounds;
use super::error::{Rounding, slope_of};
use super::exact::{between, intersection, is_empty, point};
use super::node::{Node, NodeId, NodeOp};
use super::value::Arithmetic;
use super::{Graph, arithmetic};

/// The most values of a graph with affine forms.
const MAX_NODES: usize = 1 << 12;

/// A form this many times wider than the interval of its value is given up.
const WIDE: f64 = 8.0;

impl Graph {
    /// Finds the values that need affine forms; `reaches` has the inputs of each value.
    pub(super) fn find_correlated(&mut self, reaches: &[Vec<usize>]) {
        let mut uses = vec![0u32; self.nodes.len()];
        let mut needs = vec![Need::None; self.nodes.len()];
        if self.nodes.len() > MAX_NODES {
            return;
        }
        // Backwards, so that a value's uses are known when it is reached. One whose operands share
        // an input needs a form, and so does each of its operands, down to the inputs.
        for (at, node) in self.nodes.iter().enumerate().rev() {
            let ids = self.operands(node);
            let mut different: Vec<NodeId> = ids.to_vec();
            different.sort_unstable();
            different.dedup();
            different.iter().for_each(|&id| uses[id as usize] += 1);
            let mut inputs: Vec<usize> =
                different.iter().flat_map(|&id| &reaches[id as usize]).copied().collect();
            let all = inputs.len();
            inputs.sort_unstable();
            inputs.dedup();
            let linear = node.class == Class::Real && is_followed(node.act);
            let correlated = linear && inputs.len() < all;
            if correlated || needs[at] != Need::None && linear {
                needs[at] = need(uses[at]);
                for &id in ids {
                    let operand = &mut needs[id as usize];
                    *operand = if *operand == Need::None { Need::Once } else { *operand };
                }
            }
        }
        for (need_of, uses) in needs.iter_mut().zip(&uses) {
            *need_of = if *need_of == Need::None { Need::None } else { need(*uses) };
        }
        self.needs = needs;
    }
}

fn need(uses: u32) -> Need {
    if uses > 1 { Need::Often } else { Need::Once }
}

/// Whether the operands' forms give the result's.
fn is_followed(act: NodeOp) -> bool {
    match act {
        NodeOp::RealUnary(f) => !matches!(
            f,
            RealUnary::Sign
                | RealUnary::Floor
                | RealUnary::Ceil
                | RealUnary::Round
                | RealUnary::Trunc
                | RealUnary::FrexpFract
                | RealUnary::Quantize
        ),
        NodeOp::RealBinary(f) => matches!(
            f,
            RealBinary::Add
                | RealBinary::Sub
                | RealBinary::Mul
                | RealBinary::Div
                | RealBinary::Min
                | RealBinary::Max
        ),
        NodeOp::RealTernary(f) => {
            matches!(f, RealTernary::Fma | RealTernary::Mix | RealTernary::Clamp)
        }
        NodeOp::Dot | NodeOp::Cross(_) => true,
        _ => false,
    }
}

impl Bounds {
    /// Gives the last value its affine form, where it needs one, and narrows it to that.
    pub(super) fn follow(&mut self, graph: &Graph, id: NodeId) {
        let need = graph.needs.get(id as usize).copied().unwrap_or(Need::None);
        if need == Need::None || !self.is_wide || self.arithmetic == Arithmetic::Nearest {
            self.forms.push(None);
            return;
        }
        let node = &graph.nodes[id as usize];
        let value = self.values[id as usize];
        if node.class != Class::Real || is_empty(value) {
            self.forms.push(None);
            return;
        }
        let (_, half) = halves(value);
        let useful = |form: &Affine| form.is_finite() && form.radius() <= WIDE * half;
        let found = self.form(graph, node, id, value).filter(useful);
        let form =
            found.map(|form| if need == Need::Often { form.named(VALUE | id) } else { form });
        // Without one it has a symbol of its own, which still cancels against itself.
        let form = form.or_else(|| Affine::symbol(VALUE | id, value));
        if let Some(form) = &form {
            let narrower = intersection(value, form.interval());
            if !is_empty(narrower) {
                self.values[id as usize] = narrower;
            }
        }
        self.forms.push(form);
    }

    /// Returns the form of a value from those of its operands.
    fn form(&self, graph: &Graph, node: &Node, id: NodeId, value: Interval) -> Option<Affine> {
        let ids = graph.operands(node);
        let of = |nth: usize| self.forms[ids[nth] as usize].as_ref();
        let seen = |nth: usize| self.enclosure_under(graph, node.guard, ids[nth]);
        let product = |i: usize, j: usize| match ids[i] == ids[j] {
            true => Some(of(i)?.squared()),
            false => Some(of(i)?.product(of(j)?)),
        };
        let sum = |a: &Affine, b: &Affine| a.combined(1.0, b, 1.0);
        let exact = match node.act {
            NodeOp::Input(n) => return Affine::symbol(n, value),
            NodeOp::Constant(bits) => return Some(Affine::constant(f64::from_bits(bits))),
            NodeOp::RealUnary(RealUnary::Neg) => return Some(of(0)?.scaled(-1.0)),
            NodeOp::RealUnary(RealUnary::Abs | RealUnary::Saturate)
            | NodeOp::RealTernary(RealTernary::Clamp) => {
                return self.piece(graph, node);
            }
            NodeOp::RealBinary(RealBinary::Min | RealBinary::Max) => {
                return self.piece(graph, node);
            }
            NodeOp::RealUnary(f) if is_followed(node.act) => {
                let at = |x: f64| arithmetic::f1(Arithmetic::Exact, f, point(x)).value;
                of(0)?.applied(seen(0), slope_of(f, seen(0), value), at)?
            }
            NodeOp::RealBinary(RealBinary::Add) => sum(of(0)?, of(1)?),
            NodeOp::RealBinary(RealBinary::Sub) => of(0)?.combined(1.0, of(1)?, -1.0),
            NodeOp::RealBinary(RealBinary::Mul) => product(0, 1)?,
            NodeOp::RealBinary(RealBinary::Div) => {
                let divisor = seen(1);
                let normal = between(-f64::from(f32::MIN_POSITIVE), f64::from(f32::MIN_POSITIVE));
                if !is_empty(intersection(divisor, normal)) {
                    return None;
                }
                of(0)?.quotient(of(1)?, divisor)?
            }
            NodeOp::RealTernary(RealTernary::Fma) => sum(&product(0, 1)?, of(2)?),
            // a + (b - a) * t
            NodeOp::RealTernary(RealTernary::Mix) => {
                let apart = of(1)?.combined(1.0, of(0)?, -1.0);
                sum(of(0)?, &apart.product(of(2)?))
            }
            NodeOp::Dot => {
                let half = ids.len() / 2;
                let mut all = product(0, half)?;
                for i in 1..half {
                    all = sum(&all, &product(i, i + half)?);
                }
                all
            }
            NodeOp::Cross(i) => {
                let (j, k) = ((usize::from(i) + 1) % 3, (usize::from(i) + 2) % 3);
                product(j, k + 3)?.combined(1.0, &product(k, j + 3)?, -1.0)
            }
            _ => return None,
        };
        // The forms are of exact arithmetic; the operation's own rounding comes on top.
        let error = match self.arithmetic {
            Arithmetic::Permitted => graph.local(self, Rounding::Permitted, id),
            Arithmetic::Exact | Arithmetic::Nearest => 0.0,
        };
        error.is_finite().then(|| exact.widened(error))
    }

    /// Returns the form of a function that is one of its operands, where it is known which.
    fn piece(&self, graph: &Graph, node: &Node) -> Option<Affine> {
        let ids = graph.operands(node);
        let of = |nth: usize| self.forms[ids[nth] as usize].clone();
        let seen = |nth: usize| self.enclosure_under(graph, node.guard, ids[nth]);
        let below = |a: usize, b: usize| seen(a).high <= seen(b).low;
        match node.act {
            NodeOp::RealUnary(RealUnary::Abs) if seen(0).low >= 0.0 => of(0),
            NodeOp::RealUnary(RealUnary::Abs) if seen(0).high <= 0.0 => Some(of(0)?.scaled(-1.0)),
            NodeOp::RealUnary(RealUnary::Saturate) if seen(0).low >= 0.0 && seen(0).high <= 1.0 => {
                of(0)
            }
            NodeOp::RealBinary(RealBinary::Min) if below(0, 1) => of(0),
            NodeOp::RealBinary(RealBinary::Min) if below(1, 0) => of(1),
            NodeOp::RealBinary(RealBinary::Max) if below(0, 1) => of(1),
            NodeOp::RealBinary(RealBinary::Max) if below(1, 0) => of(0),
            NodeOp::RealTernary(RealTernary::Clamp) if below(1, 0) && below(0, 2) => of(0),
            _ => None,
        }
    }
}
