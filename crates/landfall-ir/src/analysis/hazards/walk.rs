//! Walks statements in order, with calls inlined; [`control`](super::control) handles branches and
//! loops.

use naga::{AddressSpace, Block, Expression, Function, Handle, Statement};
use rustc_hash::{FxHashMap, FxHashSet};

use super::abstract_domain::Facts;
use super::checks::Candidate;
use super::graph::{Graph, GraphOp, Id, Origin};
use super::memory::Value;
use super::specular::SpecularPower;
use super::{Access, HazardReport, HazardSetting};
use crate::analysis::roles::LightBinding;
use crate::{Module, call_graph};
use landfall_layout::source::Language;

/// The most expressions that are evaluated, with calls inlined and loops run twice.
/// The most expressions that are evaluated, with calls inlined and loops run twice: a bound for
/// hostile texts.
const MAX_STEPS: u32 = 400_000;

const DEEPEST_CALL: u32 = 64;

pub struct Walk<'m> {
    pub module: &'m Module,
    pub ir: &'m naga::Module,
    pub lights: &'m [LightBinding<'m>],
    pub setting: HazardSetting,
    pub in_fragment: bool,
    pub graph: Graph,
    /// The facts assumed from conditions, in order.
    pub assumed: Vec<(Id, Facts)>,
    /// Pairs of values of which the first is at most the second.
    pub relations: Vec<(Id, Id)>,
    /// Facts about joined values, computed at the join.
    pub settled: FxHashMap<Id, Facts>,
    pub cells: Vec<Id>,
    /// Compositions that have one argument for each part.
    pub whole_parts: FxHashSet<Id>,
    pub candidates: Vec<Candidate>,
    /// Accesses to arrays of lights, and the index of each.
    pub accesses: Vec<(Id, Access)>,
    pub powers: Vec<SpecularPower>,
    globals: FxHashMap<Handle<naga::GlobalVariable>, Value>,
    /// The index of the block that each variable holds.
    blocks: FxHashMap<Handle<naga::GlobalVariable>, usize>,
    constants: FxHashMap<Handle<Expression>, Id>,
    /// The values of variables at each `break` and `continue` of a loop.
    pub left: Vec<Vec<Id>>,
    /// The conditions of branches, for [`falloff`](super::falloff).
    pub control: ControlRecord,
    steps: u32,
    depth: u32,
}

/// The conditions of branches, and the operands of opaque values.
#[derive(Debug, Default)]
pub struct ControlRecord {
    /// The conditions of the branches around a statement.
    pub conditions: Vec<Id>,
    /// The conditions on which the entry point is left, or a fragment discarded.
    pub exits: Vec<Id>,
    /// The conditions on which loops are left.
    pub breaks: Vec<Id>,
    /// The conditions on which the loop of a variable is left.
    pub loops: FxHashMap<Id, Vec<Id>>,
    /// The conditions that select one of the values of a joined node.
    pub guards: FxHashMap<Id, Vec<Id>>,
    /// The values that a variable of a loop has after an iteration.
    pub next_values: FxHashMap<Id, Vec<Id>>,
    /// The operands of each opaque value.
    pub hidden: FxHashMap<Id, Vec<Id>>,
    /// The conditions at each `break` and `continue` of a loop.
    pub left: Vec<Id>,
    pub too_deep: bool,
}

pub struct WalkFrame<'m> {
    pub function: &'m Function,
    pub values: FxHashMap<Handle<Expression>, Value>,
    pub arguments: Vec<Value>,
    /// The index of its first variable.
    pub locals: usize,
    returns: Vec<(Id, Facts)>,
    /// The conditions of its branches at each `return`, and where those of its caller end.
    guards: Vec<Id>,
    outer: usize,
    /// The variables of its callers as it began.
    before: Vec<Id>,
}

/// The way in which a block ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    Falls,
    /// By a `break`, which also leaves a `switch`.
    Breaks,
    Leaves,
}

/// Walks every entry point, or, if there is none, every function that no other calls.
pub fn follow(
    module: &Module,
    lights: &[LightBinding<'_>],
    setting: HazardSetting,
) -> HazardReport {
    let mut walk = Walk::new(module, lights, setting);
    for entry in &walk.ir.entry_points {
        walk.in_fragment = entry.stage == naga::ShaderStage::Fragment;
        walk.root(&entry.function, true);
    }
    if walk.ir.entry_points.is_empty() {
        // A text without an entry point is an include or a lighting function: its callers would
        // pass anything.
        let functions = walk.ir.functions.iter();
        let called: FxHashSet<Handle<Function>> =
            functions.flat_map(|(_, function)| call_graph::calls(function)).collect();
        for (handle, function) in walk.ir.functions.iter() {
            if !called.contains(&handle) {
                walk.root(function, false);
            }
        }
    }
    walk.into_report()
}

impl<'m> Walk<'m> {
    pub fn new(
        module: &'m Module,
        lights: &'m [LightBinding<'m>],
        setting: HazardSetting,
    ) -> Walk<'m> {
        Walk {
            module,
            ir: &module.ir,
            lights,
            setting,
            in_fragment: setting.fragment,
            graph: Graph::default(),
            assumed: Vec::new(),
            relations: Vec::new(),
            settled: FxHashMap::default(),
            cells: Vec::new(),
            whole_parts: FxHashSet::default(),
            candidates: Vec::new(),
            accesses: Vec::new(),
            powers: Vec::new(),
            globals: FxHashMap::default(),
            blocks: module.blocks.iter().enumerate().map(|(n, b)| (b.variable, n)).collect(),
            constants: FxHashMap::default(),
            left: Vec::new(),
            control: ControlRecord::default(),
            steps: 0,
            depth: 0,
        }
    }

    /// Returns the values of all variables; copying many counts as steps.
    pub fn copied_cells(&mut self) -> Vec<Id> {
        // Each 64 variables count one step: a text with thousands of variables and branches would
        // copy them quadratically.
        self.steps += (self.cells.len() / 64) as u32;
        self.cells.clone()
    }

    pub fn is_cut_short(&self) -> bool {
        self.steps > MAX_STEPS
    }

    /// Walks an entry point, or a function of its own, and returns its result.
    pub fn root(&mut self, function: &'m Function, is_entry: bool) -> Option<Id> {
        self.cells.clear();
        self.assumed.clear();
        self.relations.clear();
        self.globals.clear();
        self.steps += (self.ir.global_variables.len() / 64) as u32;
        if self.is_cut_short() {
            return None;
        }
        // Blocks and inputs are the same node for each entry point, but variables of the shader
        // begin anew.
        for (handle, variable) in self.ir.global_variables.iter() {
            let value = self.global(handle, variable, is_entry);
            self.globals.insert(handle, value);
        }
        let mut arguments = Vec::new();
        for argument in &function.arguments {
            let name = argument.name.clone().unwrap_or_default();
            let origin = argument.binding.as_ref().map_or(Origin::Other, |b| self.origin(b));
            let value = match self.ir.types[argument.ty].inner {
                // `inout` and `out` parameters of functions without a caller: a variable with an
                // unknown value.
                naga::TypeInner::Pointer { base, .. } => {
                    let id = self.outside(&name, base, Origin::Other);
                    self.cells.push(id);
                    Value::At(self.cells.len() - 1, Vec::new())
                }
                _ => Value::Is(self.outside(&name, argument.ty, origin)),
            };
            arguments.push(value);
        }
        self.call(function, arguments)
    }

    fn global(
        &mut self,
        handle: Handle<naga::GlobalVariable>,
        variable: &'m naga::GlobalVariable,
        is_entry: bool,
    ) -> Value {
        let name = variable.name.clone().unwrap_or_default();
        let own = matches!(variable.space, AddressSpace::Private | AddressSpace::WorkGroup);
        if !own {
            let block = self.blocks.get(&handle).copied();
            let fresh = self.graph.next();
            let path = if block.is_some() { String::new() } else { name.clone() };
            let leaf = super::graph::Leaf {
                // Inputs differ by number, since two entry points may have inputs of one name.
                // Blocks are the same for every entry point.
                key: format!("{name}@{}", block.map_or(fresh, |block| block as u32)),
                path,
                name,
                ty: variable.ty,
                origin: Origin::Block,
                block,
                light: None,
                role: None,
            };
            return Value::Is(self.leaf(leaf));
        }
        let id = match (variable.init, variable.space) {
            (Some(init), _) => self.constant(init),
            // WGSL §7.3: variables without an initialiser are zero. GLSL leaves them undefined.
            (None, AddressSpace::Private) if self.setting.language == Language::Wgsl => {
                self.graph.number(0.0)
            }
            (None, AddressSpace::Private) if is_entry => {
                let fresh = self.graph.next();
                self.graph.add(GraphOp::Undefined(fresh), &[])
            }
            // A function of a library may find its globals initialised by the program.
            (None, _) => self.outside(&name, variable.ty, Origin::Other),
        };
        self.cells.push(id);
        Value::At(self.cells.len() - 1, Vec::new())
    }

    pub fn global_value(&self, handle: Handle<naga::GlobalVariable>) -> Value {
        self.globals[&handle].clone()
    }

    /// Returns the value of a global expression.
    pub fn constant(&mut self, handle: Handle<Expression>) -> Id {
        if let Some(&id) = self.constants.get(&handle) {
            return id;
        }
        let id = match &self.ir.global_expressions[handle] {
            Expression::Literal(literal) => self.literal(literal),
            Expression::Constant(constant) => self.constant(self.ir.constants[*constant].init),
            Expression::Splat { value, .. } => self.constant(*value),
            Expression::ZeroValue(_) => self.graph.number(0.0),
            Expression::Compose { components, .. } => {
                let parts: Vec<Id> = components.iter().map(|&part| self.constant(part)).collect();
                self.composed(&parts)
            }
            Expression::Unary { op: naga::UnaryOperator::Negate, expr } => {
                let of = self.constant(*expr);
                match self.graph.value(of) {
                    Some(number) => self.graph.number(-number),
                    None => self.graph.add(GraphOp::Negate, &[of]),
                }
            }
            _ => self.graph.opaque(&[]),
        };
        self.constants.insert(handle, id);
        id
    }

    pub fn call(&mut self, function: &'m Function, arguments: Vec<Value>) -> Option<Id> {
        // Calls are inlined: a lighting function that is called for two lights is walked for each,
        // with their own values.
        if self.depth > DEEPEST_CALL || self.is_cut_short() {
            self.control.too_deep = true;
            return None;
        }
        self.depth += 1;
        let (locals, mark) = (self.cells.len(), self.mark());
        for (_, variable) in function.local_variables.iter() {
            let id = match (variable.init, self.setting.language) {
                // Initialisers are constants of the function; their value is read when it is used.
                (Some(_), _) => self.graph.opaque(&[]),
                (None, Language::Wgsl) => self.graph.number(0.0),
                (None, Language::Glsl | Language::SpirV) => {
                    let fresh = self.graph.next();
                    self.graph.add(GraphOp::Undefined(fresh), &[])
                }
            };
            self.cells.push(id);
        }
        let values = FxHashMap::default();
        let (outer, before) = (self.control.conditions.len(), self.cells[..locals].to_vec());
        let (returns, guards) = (Vec::new(), Vec::new());
        let mut frame =
            WalkFrame { function, values, arguments, locals, returns, guards, outer, before };
        // In two passes, since the initialiser of one variable may read another's.
        for (number, (_, variable)) in function.local_variables.iter().enumerate() {
            if let Some(init) = variable.init {
                let value = self.value(&mut frame, init);
                self.cells[locals + number] = value;
            }
        }
        self.block(&mut frame, &function.body);
        // The function's conditions do not hold after it.
        self.forget(mark);
        self.cells.truncate(locals);
        self.depth -= 1;
        match &frame.returns[..] {
            [] => None,
            [(value, _)] => Some(*value),
            // Several `return`s: one of their values, with the facts that each had where it was
            // returned.
            several => {
                let values: Vec<Id> = several.iter().map(|(value, _)| *value).collect();
                let facts = several.iter().map(|(_, facts)| *facts).reduce(Facts::or);
                let joined = self.joined(&values);
                self.settled.insert(joined, facts.unwrap_or(Facts::NOTHING));
                self.guard(joined, &frame.guards);
                Some(joined)
            }
        }
    }

    /// Returns a node for one of several values.
    pub fn joined(&mut self, values: &[Id]) -> Id {
        match values {
            [first, rest @ ..] if rest.iter().all(|other| other == first) => *first,
            values => {
                let fresh = self.graph.next();
                self.graph.add(GraphOp::Joined(fresh), values)
            }
        }
    }

    /// Records what selects one of the values of a joined node; equal values are not joined.
    pub fn guard(&mut self, id: Id, guards: &[Id]) {
        if matches!(self.graph.op(id), GraphOp::Joined(_)) {
            self.control.guards.entry(id).or_default().extend(guards);
        }
    }

    pub fn block(&mut self, frame: &mut WalkFrame<'m>, block: &'m Block) -> Flow {
        let mark = self.mark();
        let mut flow = Flow::Falls;
        for statement in block {
            if self.is_cut_short() {
                break;
            }
            flow = self.statement(frame, statement);
            // What follows a `return`, `break` or `continue` in a block is dead.
            if flow != Flow::Falls {
                break;
            }
        }
        self.forget(mark);
        flow
    }

    fn statement(&mut self, frame: &mut WalkFrame<'m>, statement: &'m Statement) -> Flow {
        self.steps += 1;
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    self.steps += 1;
                    let value = self.evaluate(frame, handle);
                    frame.values.insert(handle, value);
                }
            }
            Statement::Block(inner) => return self.block(frame, inner),
            Statement::If { condition, accept, reject } => {
                let condition = self.value(frame, *condition);
                return self.branches(frame, condition, accept, reject);
            }
            Statement::Switch { selector, cases } => {
                let selector = self.value(frame, *selector);
                return self.switch(frame, selector, cases);
            }
            Statement::Loop { body, continuing, break_if } => {
                self.run_loop(frame, body, continuing, *break_if);
            }
            Statement::Break | Statement::Continue => {
                // The values of variables at this point, joined with those at the end of the loop
                // or of the iteration.
                let cells = self.copied_cells();
                self.left.push(cells);
                let breaks = matches!(statement, Statement::Break);
                self.control.left.extend(&self.control.conditions);
                if breaks {
                    self.control.breaks.extend(&self.control.conditions);
                }
                return if breaks { Flow::Breaks } else { Flow::Leaves };
            }
            Statement::Return { value } => {
                let control = &mut self.control;
                // Whether this `return` is taken decides the value. It is an exit as well if the
                // function has written something before, or is the entry point.
                frame.guards.extend(&control.conditions[frame.outer..]);
                // Other effects of the function before that point are not joined.
                let changes = value.is_none() || self.cells[..frame.locals] != frame.before[..];
                if changes || self.depth == 1 {
                    control.exits.extend(&control.conditions[frame.outer..]);
                }
                if let Some(value) = value {
                    let id = self.value(frame, *value);
                    let facts = self.facts(id);
                    frame.returns.push((id, facts));
                }
                return Flow::Leaves;
            }
            Statement::Kill => {
                // A discarded fragment writes nothing: its conditions decide about all outputs.
                self.control.exits.extend(&self.control.conditions);
                return Flow::Leaves;
            }
            Statement::Store { pointer, value } => {
                let to = self.pointer(frame, *pointer);
                let span = self.place(frame, *value);
                let value = self.value(frame, *value);
                self.check_store(frame, &to, value, span);
                self.store(&to, value);
            }
            Statement::Call { function, arguments, result } => {
                let given = arguments.iter().map(|&argument| self.pointer(frame, argument));
                let given: Vec<Value> = given.collect();
                let returned = self.call(&self.ir.functions[*function], given);
                if let Some(result) = result {
                    let id = returned.unwrap_or_else(|| self.graph.opaque(&[]));
                    frame.values.insert(*result, Value::Is(id));
                }
            }
            // The rest has results that nothing is known of, or none.
            // Images, atomics and barriers: what they return is unknown.
            _ => {}
        }
        Flow::Falls
    }
}
