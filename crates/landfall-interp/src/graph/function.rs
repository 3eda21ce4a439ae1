//! Follows the code of a function over a box of inputs and writes down its values.

use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

use super::super::code::Class;
use super::super::interval::Interval;
use super::super::machine::Image;
use super::super::program::Program;
use super::bounds::Bounds;
use super::fault::faults_of;
use super::guard::{ALWAYS, Guard};
use super::node::{GuardId, Node, NodeId, NodeOp};
use super::paths::{Path, State};
use super::value::Arithmetic;
use super::{Graph, MAX_INSTRUCTIONS, MAX_NODES};

/// A scalar that a function is called with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Given {
    /// A scalar of the inputs.
    Input(usize),
    /// Zero.
    Zero,
}

/// The arguments of a function, and the box of its inputs.
#[derive(Clone, Copy, Debug)]
pub struct GraphInputs<'a> {
    /// The name of the function.
    pub function: &'a str,
    /// The scalars of each argument; none for one that is only written.
    pub arguments: &'a [Vec<Given>],
    /// By input scalar: its range.
    pub ranges: &'a [Interval],
    /// Vectors of length one among the inputs.
    pub units: &'a [Vec<usize>],
    /// The results: an argument's scalars, or `None` for the return value.
    pub results: &'a [Option<usize>],
}

/// The key of values that are equal: the operation and its operands.
type Key = (NodeOp, Class, Vec<NodeId>);

/// The state of following the code.
pub(super) struct GraphBuilder<'p> {
    pub program: &'p Program,
    pub buffers: Vec<&'p [u8]>,
    pub images: Vec<Image<'p>>,
    pub graph: Graph,
    /// By operation and operands: the values computed so, under any guards.
    known: FxHashMap<Key, Vec<NodeId>>,
    pub guards: FxHashMap<(GuardId, NodeId, bool), GuardId>,
    /// The values over the whole box.
    pub bounds: Bounds,
    /// The path being followed; `None` after it left.
    pub path: Option<Path>,
    /// The branches of the path.
    pub guard: GuardId,
    /// The current instruction.
    pub pc: usize,
    /// The number of instructions that may still be followed.
    pub left: u32,
}

/// The code is too large to follow.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CodeTooLarge;

pub(super) type Followed<T> = Result<T, CodeTooLarge>;

impl Program {
    /// Follows a function; `None` if it is too large or does not exist.
    pub fn graph(
        &self,
        called: &GraphInputs<'_>,
        resources: &[crate::backend::Resource],
    ) -> Option<Graph> {
        let named = |f: &super::super::program::FunctionCode| {
            f.name == called.function && f.interface.is_none()
        };
        let number = self.functions.iter().position(named)?;
        let bound = self.bind(number as u32, resources).ok()?;
        let (buffers, images) = bound.contents();
        let graph = Graph {
            nodes: Vec::new(),
            operands: Vec::new(),
            guards: vec![Guard { parent: ALWAYS, cond: 0, truth: true, affected: Vec::new() }],
            units: Vec::new(),
            unit_of: BTreeMap::new(),
            absolute: BTreeMap::new(),
            sites: Vec::new(),
            results: Vec::new(),
            inputs: Vec::new(),
            needs: Vec::new(),
        };
        // Bounds of the whole box decide branches while the code is followed.
        let mut bounds = Bounds::default();
        bounds.begin(called.ranges, Arithmetic::Permitted);
        let mut follow = GraphBuilder {
            program: self,
            buffers,
            images,
            graph,
            known: FxHashMap::default(),
            guards: FxHashMap::default(),
            bounds,
            path: None,
            guard: ALWAYS,
            pc: 0,
            left: MAX_INSTRUCTIONS,
        };
        follow.call_from_outside(number, called).ok()?;
        let mut graph = follow.graph;
        graph.find_affected();
        graph.find_sites(self);
        Some(graph)
    }
}

impl GraphBuilder<'_> {
    fn call_from_outside(&mut self, number: usize, called: &GraphInputs<'_>) -> Followed<()> {
        let program = self.program;
        let classes = [Class::Real, Class::Word, Class::Wide];
        let mut files: [Vec<NodeId>; 3] = Default::default();
        for class in classes {
            // Registers that are not written hold zero.
            let nothing = self.constant(class, 0.0)?;
            let count = program.registers[class as usize] as usize;
            let mut file = vec![nothing; count];
            for (reg, &bits) in program.constants[class as usize].iter().enumerate() {
                file[reg] = self.literal(class, bits)?;
            }
            files[class as usize] = file;
        }
        self.path = Some(Path { guard: ALWAYS, state: State::new(files) });
        let mut inputs = Vec::new();
        for n in 0..called.ranges.len() {
            inputs.push((n, None));
        }
        let code = &program.functions[number];
        // As in a run, private variables are filled first.
        if let Ok(super::super::program::FunctionCode { state: Ok(globals), .. }) = &program.start {
            self.body(*globals as usize)?;
        }
        for (argument, given) in code.arguments.iter().zip(called.arguments) {
            for (&reg, given) in argument.regs.iter().zip(given) {
                let class = reg.class();
                let id = match given {
                    Given::Zero => self.constant(class, 0.0)?,
                    Given::Input(n) => {
                        let id = self.node(NodeOp::Input(*n as u32), class, &[])?;
                        inputs[*n].1 = Some(id);
                        id
                    }
                };
                self.set(class, reg.number(), id);
            }
        }
        for unit in called.units {
            // An input that no argument takes has no node.
            let ids: Option<Vec<NodeId>> = unit.iter().map(|&n| inputs[n].1).collect();
            if let Some(ids) = ids {
                self.unit(ids);
            }
        }
        self.graph.inputs = inputs.into_iter().map(|(_, id)| id.unwrap_or(NodeId::MAX)).collect();
        self.body(program.starts[number] as usize)?;
        let result = |at: &Option<usize>| match at {
            None => code.result.as_slice(),
            Some(at) => code.arguments[*at].regs.as_slice(),
        };
        for reg in called.results.iter().flat_map(result) {
            let id = self.get(reg.class(), reg.number());
            self.graph.results.push(id);
        }
        Ok(())
    }

    /// Notes that values are the components of a vector of length one.
    pub fn unit(&mut self, ids: Vec<NodeId>) {
        let number = self.graph.units.len();
        for &id in &ids {
            self.graph.unit_of.entry(id).or_default().push(number);
        }
        self.graph.units.push(ids);
    }

    pub fn get(&self, class: Class, reg: u32) -> NodeId {
        self.path.as_ref().map_or(0, |path| path.state.get(class, reg))
    }

    pub fn set(&mut self, class: Class, reg: u32, to: NodeId) {
        if let Some(path) = &mut self.path {
            path.state.set(class, reg, to);
        }
    }

    fn literal(&mut self, class: Class, bits: u64) -> Followed<NodeId> {
        let most = f64::from(f32::MAX);
        match class {
            Class::Real => match f64::from(f32::from_bits(bits as u32)) {
                x if x.is_finite() => self.constant(class, x),
                // What is not finite may become any number.
                _ => self.node(NodeOp::within(-most, most), class, &[]),
            },
            // As a signed number; it stands for its lowest 32 bits.
            Class::Word => self.constant(class, f64::from(bits as u32 as i32)),
            Class::Wide => self.constant(class, 0.0),
        }
    }

    pub fn constant(&mut self, class: Class, x: f64) -> Followed<NodeId> {
        // A constant is known on every path.
        let guard = std::mem::replace(&mut self.guard, ALWAYS);
        let id = self.node(NodeOp::Constant(x.to_bits()), class, &[]);
        self.guard = guard;
        id
    }

    /// Adds a value, unless the same is known on the path.
    pub fn node(&mut self, act: NodeOp, class: Class, operands: &[NodeId]) -> Followed<NodeId> {
        // One operation may be computed in several classes.
        let key = (act, class, operands.to_vec());
        if act.is_pure() {
            let known = self.known.get(&key).into_iter().flatten();
            let guard = self.guard;
            // A value computed in another branch may not exist here, or be narrowed by other
            // conditions.
            let mut on_path = known
                .filter(|&&id| self.graph.is_within(guard, self.graph.nodes[id as usize].guard));
            if let Some(&id) = on_path.next() {
                return Ok(id);
            }
        }
        let id = self.graph.nodes.len();
        if id >= MAX_NODES {
            return Err(CodeTooLarge);
        }
        let graph = &mut self.graph;
        let exact = act.keeps_exact() && operands.iter().all(|&id| graph.is_exact(id));
        let (first, count) = (graph.operands.len() as u32, operands.len() as u32);
        graph.operands.extend(operands);
        let (guard, pc) = (self.guard, self.pc as u32);
        graph.nodes.push(Node { act, class, first, count, guard, pc, exact });
        let id = id as NodeId;
        if let NodeOp::RealUnary(super::super::code::RealUnary::Abs) = act {
            graph.absolute.insert(operands[0], id);
        }
        // At once, over the whole box, as values decide which branches are followed.
        self.bounds.contexts.resize_with(graph.guards.len(), Default::default);
        self.bounds.extend(&self.graph, id);
        let value = self.bounds.values[id as usize];
        // Loop counters and what they decide are known.
        let is_known = class == Class::Word && value.low == value.high;
        if is_known && faults_of(act).is_empty() && !matches!(act, NodeOp::Constant(_)) {
            let known = self.constant(class, value.low)?;
            self.known.entry(key).or_default().push(known);
            return Ok(known);
        }
        self.known.entry(key).or_default().push(id);
        Ok(id)
    }
}
