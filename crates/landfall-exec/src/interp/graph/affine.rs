//! Affine forms: values as linear functions of the inputs, so that operands that depend on the same
//! inputs are not taken as independent.
//!
//! A form encloses what an operation may give on any device, as the interval of the value does; the
//! value is in both. Its numbers are computed in `f64`, whose roundings are added to its rest.
//! After Stolfi and de Figueiredo, Self-Validated Numerical Methods and Applications (1997), with
//! the mean value form for quotients and functions of one operand.

use super::super::code::{Class, F1, F2, F3};
use super::super::interval::Interval;
use super::super::outward::Outward;
use super::bounds::Bounds;
use super::error::{Rounding, slope_of};
use super::exact::{self, between, is_empty, meet, point, size};
use super::node::{Node, NodeId, NodeOp};
use super::value::Arithmetic;
use super::{Graph, arithmetic};

/// A number `middle + Σ share * e`, up to `rest`, for some `e` from -1 to 1 of each symbol.
#[derive(Clone, Debug, Default)]
pub(super) struct Affine {
    middle: f64,
    /// By symbol, in ascending order: its share.
    shares: Vec<(u32, f64)>,
    rest: f64,
}

/// Whether a value needs an affine form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Need {
    /// No operation uses it together with a value that depends on the same inputs.
    None,
    /// It is used once.
    Once,
    /// It is used more often, and has a symbol for what is not linear in it.
    Often,
}

/// The largest number of symbols of a form.
const MOST_SHARES: usize = 16;

/// The most values of a graph with affine forms.
const MOST_NODES: usize = 1 << 12;

/// Symbols of values rather than inputs.
const VALUE: u32 = 1 << 31;

/// More than the relative error of three operations of `f64`.
const ROUNDED: f64 = 4.0 * f64::EPSILON;

/// A form this many times wider than the interval of its value is given up.
const WIDE: f64 = 8.0;

/// Inputs and values beyond have no form.
const MOST: f64 = 1e30;

/// Rounds the sum of at most [`MOST_SHARES`] numbers that are not negative up.
fn up(x: f64) -> f64 {
    x * (1.0 + 64.0 * f64::EPSILON) + f64::MIN_POSITIVE
}

/// Returns a middle of an interval, and how far its ends are from there at most.
fn halves(x: Interval) -> (f64, f64) {
    let middle = x.low / 2.0 + x.high / 2.0;
    (middle, up((x.high - middle).max(middle - x.low)))
}

impl Affine {
    fn constant(x: f64) -> Affine {
        Affine { middle: x, ..Affine::default() }
    }

    /// A value of which only an interval is known.
    fn symbol(symbol: u32, x: Interval) -> Option<Affine> {
        let (middle, half) = halves(x);
        let shares = if x.low == x.high { Vec::new() } else { vec![(symbol, half)] };
        (size(x) <= MOST).then_some(Affine { middle, shares, rest: 0.0 })
    }

    /// Returns how far it may be from its middle.
    fn radius(&self) -> f64 {
        up(self.shares.iter().map(|(_, share)| share.abs()).sum::<f64>() + self.rest)
    }

    fn interval(&self) -> Interval {
        let rest = if Outward::Rest.is_reversed() { -2.0 * self.rest } else { 0.0 };
        let radius = self.radius() + rest;
        between((self.middle - radius).next_down(), (self.middle + radius).next_up())
    }

    /// Returns `x * self + y * other`.
    fn combined(&self, x: f64, other: &Affine, y: f64) -> Affine {
        let (a, b) = (x * self.middle, y * other.middle);
        let mut lost = a.abs() + b.abs();
        let mut shares = Vec::with_capacity(self.shares.len() + other.shares.len());
        let (mut mine, mut others) = (self.shares.iter(), other.shares.iter());
        let (mut one, mut two) = (mine.next(), others.next());
        loop {
            let (symbol, first, second) = match (one, two) {
                (None, None) => break,
                (Some(&(i, p)), Some(&(j, q))) if i == j => {
                    (one, two) = (mine.next(), others.next());
                    (i, x * p, y * q)
                }
                (Some(&(i, p)), second) if second.is_none_or(|&(j, _)| i < j) => {
                    one = mine.next();
                    (i, x * p, 0.0)
                }
                (_, Some(&(j, q))) => {
                    two = others.next();
                    (j, 0.0, y * q)
                }
                (Some(_), None) => unreachable!("the case before holds"),
            };
            lost += first.abs() + second.abs();
            if first + second != 0.0 {
                shares.push((symbol, first + second));
            }
        }
        let rest = x.abs() * self.rest + y.abs() * other.rest;
        Affine { middle: a + b, shares, rest: up(rest + ROUNDED * lost) }.limited()
    }

    fn scaled(&self, by: f64) -> Affine {
        self.combined(by, &Affine::default(), 0.0)
    }

    fn plus(&self, x: f64) -> Affine {
        self.combined(1.0, &Affine::constant(x), 1.0)
    }

    fn widened(mut self, by: f64) -> Affine {
        self.rest = up(self.rest + by);
        self
    }

    /// Adds the smallest shares to the rest where there are too many.
    fn limited(mut self) -> Affine {
        while self.shares.len() > MOST_SHARES {
            let sizes = self.shares.iter().map(|(_, share)| share.abs()).enumerate();
            let Some((at, share)) = sizes.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            self.shares.remove(at);
            self.rest = up(self.rest + share);
        }
        self
    }

    fn product(&self, other: &Affine) -> Affine {
        let (a, b) = (self.middle, other.middle);
        let mut linear = self.combined(b, other, a);
        linear.middle = a * b;
        linear.widened(self.radius() * other.radius() + ROUNDED * (a * b).abs())
    }

    fn squared(&self) -> Affine {
        let half = self.radius() * self.radius() / 2.0;
        let square = self.middle * self.middle;
        let mut linear = self.scaled(2.0 * self.middle);
        linear.middle = square + half;
        linear.widened(half + ROUNDED * (square + half))
    }

    /// Returns the quotient by a divisor of one sign: `q + (self - q * by) / by` for a number `q`.
    fn quotient(&self, by: &Affine, divisor: Interval) -> Option<Affine> {
        let q = self.middle / by.middle;
        if !q.is_finite() {
            return None;
        }
        let off = self.combined(1.0, by, -q);
        let most = off.middle.abs() + off.radius();
        let (inverse, half) = halves(exact::div(point(1.0), divisor));
        Some(off.scaled(inverse).plus(q).widened(up(most * half)))
    }

    /// Returns a function of it, whose operand is in an interval, by the mean value theorem.
    fn applied(&self, f: F1, x: Interval, value: Interval) -> Option<Affine> {
        let slope = slope_of(f, x, value);
        let at = self.middle.clamp(x.low, x.high);
        let there = arithmetic::f1(Arithmetic::Exact, f, point(at)).value;
        let (slope, steeper) = halves(slope);
        let (start, off) = halves(there);
        let far = up((x.high - at).max(at - x.low));
        let known = [slope, steeper, start, off].iter().all(|x| x.is_finite());
        known.then(|| self.plus(-at).scaled(slope).plus(start).widened(up(off + steeper * far)))
    }

    /// Whether its numbers are usable.
    fn is_finite(&self) -> bool {
        self.middle.abs() <= MOST && self.radius() <= MOST
    }
}

impl Graph {
    /// Finds the values that need affine forms; `reaches` has the inputs of each value.
    pub(super) fn find_correlated(&mut self, reaches: &[Vec<usize>]) {
        let mut uses = vec![0u32; self.nodes.len()];
        let mut needs = vec![Need::None; self.nodes.len()];
        if self.nodes.len() > MOST_NODES {
            return;
        }
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
        NodeOp::F1(f) => !matches!(
            f,
            F1::Sign | F1::Floor | F1::Ceil | F1::Round | F1::Trunc | F1::FrexpFract | F1::Quantize
        ),
        NodeOp::F2(f) => matches!(f, F2::Add | F2::Sub | F2::Mul | F2::Div | F2::Min | F2::Max),
        NodeOp::F3(f) => matches!(f, F3::Fma | F3::Mix | F3::Clamp),
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
        let form = found.map(|mut form| {
            if need == Need::Often && form.rest > 0.0 {
                form.shares.push((VALUE | id, form.rest));
                form.rest = 0.0;
                form.shares.sort_unstable_by_key(|(symbol, _)| *symbol);
                form = form.limited();
            }
            form
        });
        let form = form.or_else(|| Affine::symbol(VALUE | id, value));
        if let Some(form) = &form {
            let narrower = meet(value, form.interval());
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
        let seen = |nth: usize| self.seen(graph, node.guard, ids[nth]);
        let product = |i: usize, j: usize| match ids[i] == ids[j] {
            true => Some(of(i)?.squared()),
            false => Some(of(i)?.product(of(j)?)),
        };
        let sum = |a: &Affine, b: &Affine| a.combined(1.0, b, 1.0);
        let exact = match node.act {
            NodeOp::Input(n) => return Affine::symbol(n, value),
            NodeOp::Constant(x) => return Some(Affine::constant(x)),
            NodeOp::F1(F1::Neg) => return Some(of(0)?.scaled(-1.0)),
            NodeOp::F1(F1::Abs | F1::Saturate) | NodeOp::F3(F3::Clamp) => {
                return self.piece(graph, node);
            }
            NodeOp::F2(F2::Min | F2::Max) => return self.piece(graph, node),
            NodeOp::F1(f) if is_followed(node.act) => of(0)?.applied(f, seen(0), value)?,
            NodeOp::F2(F2::Add) => sum(of(0)?, of(1)?),
            NodeOp::F2(F2::Sub) => of(0)?.combined(1.0, of(1)?, -1.0),
            NodeOp::F2(F2::Mul) => product(0, 1)?,
            NodeOp::F2(F2::Div) => {
                let divisor = seen(1);
                let normal = between(-f64::from(f32::MIN_POSITIVE), f64::from(f32::MIN_POSITIVE));
                if !is_empty(meet(divisor, normal)) {
                    return None;
                }
                of(0)?.quotient(of(1)?, divisor)?
            }
            NodeOp::F3(F3::Fma) => sum(&product(0, 1)?, of(2)?),
            // a + (b - a) * t
            NodeOp::F3(F3::Mix) => {
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
        let seen = |nth: usize| self.seen(graph, node.guard, ids[nth]);
        let below = |a: usize, b: usize| seen(a).high <= seen(b).low;
        match node.act {
            NodeOp::F1(F1::Abs) if seen(0).low >= 0.0 => of(0),
            NodeOp::F1(F1::Abs) if seen(0).high <= 0.0 => Some(of(0)?.scaled(-1.0)),
            NodeOp::F1(F1::Saturate) if seen(0).low >= 0.0 && seen(0).high <= 1.0 => of(0),
            NodeOp::F2(F2::Min) if below(0, 1) => of(0),
            NodeOp::F2(F2::Min) if below(1, 0) => of(1),
            NodeOp::F2(F2::Max) if below(0, 1) => of(1),
            NodeOp::F2(F2::Max) if below(1, 0) => of(0),
            NodeOp::F3(F3::Clamp) if below(1, 0) && below(0, 2) => of(0),
            _ => None,
        }
    }
}
