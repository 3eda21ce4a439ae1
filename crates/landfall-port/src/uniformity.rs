//! Finds the operations of a naga module that WGSL's uniformity analysis rejects (WGSL §15.2):
//! derivatives, samples with an implicit level of detail, and barriers, at places that only some
//! invocations of a draw or workgroup may reach.
//!
//! Every value has a set of sources: variation from invocation to invocation, the control flow of
//! the function's caller, and the function's arguments. A function is followed statement by
//! statement, loops until their sets no longer grow, with those of the functions it calls at hand.

mod flow;
mod values;

use naga::{Block, Function, Handle, LocalVariable, Module, ShaderStage, Span};
use rustc_hash::FxHashMap;

// Two bits, and two for each argument that is told apart: 122.
/// A set of sources.
type Sources = u128;

/// Variation from invocation to invocation.
const VARIES: Sources = 1;
/// The control flow at the call of the function.
const CALLER: Sources = 2;
/// The number of arguments told apart; values from any other vary.
const MAX_ARGUMENTS: u32 = 60;
/// The number of passes over a function after which what its loops change varies.
const MAX_PASSES: usize = 20;

/// Ways to leave a block.
const NEXT: u8 = 1;
const BREAK: u8 = 2;
const CONTINUE: u8 = 4;
const RETURN: u8 = 8;

/// The kind of an operation that needs uniform control flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Operation {
    /// A derivative, explicit or of a texture's coordinates.
    Derivative,
    Barrier,
}

/// Returns the operations in control flow that may not be uniform, each once.
pub(super) fn non_uniform(module: &Module) -> Vec<(Operation, Span)> {
    let mut summaries: Vec<FunctionSummary> = Vec::with_capacity(module.functions.len());
    let mut found = Vec::new();
    // A function of naga's stands behind those that it calls.
    for (_, function) in module.functions.iter() {
        let summary = UniformityWalk::new(module, function, None, &summaries, &mut found).summary();
        summaries.push(summary);
    }
    for entry in &module.entry_points {
        UniformityWalk::new(module, &entry.function, Some(entry.stage), &summaries, &mut found)
            .summary();
    }
    let mut unique: Vec<(Operation, Span)> = Vec::new();
    for one in found {
        if !unique.contains(&one) {
            unique.push(one);
        }
    }
    unique
}

/// The facts about a function that its callers need.
#[derive(Clone, Debug, Default)]
struct FunctionSummary {
    /// The sources of its result.
    result: Sources,
    /// The sources of what its pointer arguments point to after the call.
    pointees: Vec<Sources>,
    /// The sources that must not vary, for which operation.
    needs: Vec<(Operation, Span, Sources)>,
}

/// The sources of the variables at one place.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct VariableSources {
    locals: Vec<Sources>,
    pointees: Vec<Sources>,
}

impl VariableSources {
    fn join(&mut self, other: &VariableSources) {
        let pairs = self.locals.iter_mut().zip(&other.locals);
        for (own, other) in pairs.chain(self.pointees.iter_mut().zip(&other.pointees)) {
            *own |= other;
        }
    }
}

/// The variable that a pointer leads to.
enum PointedVariable {
    Local(Handle<LocalVariable>),
    Argument(u32),
    /// Not followed: its contents' sources.
    Other(Sources),
}

/// A function being followed.
struct UniformityWalk<'a> {
    module: &'a Module,
    function: &'a Function,
    entry: Option<ShaderStage>,
    summaries: &'a [FunctionSummary],
    found: &'a mut Vec<(Operation, Span)>,
    state: VariableSources,
    /// The sources of expressions that were evaluated.
    values: Vec<Sources>,
    /// The states in which the enclosing loops and switches are left, and loops are continued.
    breaks: Vec<Option<VariableSources>>,
    continues: Vec<Option<(VariableSources, Sources)>>,
    /// The sources and control flow at the start of each loop.
    loops: FxHashMap<*const Block, (VariableSources, Sources)>,
    grown: bool,
    returned: Option<VariableSources>,
    summary: FunctionSummary,
}

fn argument(index: u32) -> Sources {
    // Bit 2 + 2 * index: the value of an argument. The bit above it: what it points to.
    if index < MAX_ARGUMENTS { 4 << (2 * index) } else { VARIES }
}

fn pointee(index: u32) -> Sources {
    if index < MAX_ARGUMENTS { 8 << (2 * index) } else { VARIES }
}

fn merge(into: &mut Option<VariableSources>, state: &VariableSources) {
    match into {
        Some(known) => known.join(state),
        None => *into = Some(state.clone()),
    }
}

impl<'a> UniformityWalk<'a> {
    fn new(
        module: &'a Module,
        function: &'a Function,
        entry: Option<ShaderStage>,
        summaries: &'a [FunctionSummary],
        found: &'a mut Vec<(Operation, Span)>,
    ) -> UniformityWalk<'a> {
        UniformityWalk {
            module,
            function,
            entry,
            summaries,
            found,
            state: VariableSources::default(),
            values: vec![0; function.expressions.len()],
            breaks: Vec::new(),
            continues: Vec::new(),
            loops: FxHashMap::default(),
            grown: false,
            returned: None,
            summary: FunctionSummary::default(),
        }
    }

    fn summary(mut self) -> FunctionSummary {
        let start = VariableSources {
            locals: vec![0; self.function.local_variables.len()],
            pointees: (0..self.function.arguments.len() as u32).map(pointee).collect(),
        };
        let control = if self.entry.is_some() { 0 } else { CALLER };
        // To a fixed point: sets only grow from pass to pass, and are finite. After too many passes
        // everything that loops change is taken to vary, which no later pass can enlarge.
        for pass in 0..=MAX_PASSES {
            self.grown = false;
            self.state = start.clone();
            let (_, ways) = self.block(&self.function.body, control);
            if ways & NEXT != 0 {
                let state = std::mem::take(&mut self.state);
                merge(&mut self.returned, &state);
            }
            if !self.grown {
                break;
            }
            if pass + 1 == MAX_PASSES {
                for (state, control) in self.loops.values_mut() {
                    state.locals.fill(VARIES);
                    state.pointees.fill(VARIES);
                    *control |= VARIES;
                }
            }
        }
        self.summary.pointees = self.returned.unwrap_or(start).pointees;
        self.summary
    }

    /// Records that an operation at `span` needs sources that do not vary.
    fn need(&mut self, operation: Operation, span: Span, sources: Sources) {
        // An error wherever the function is called from; otherwise it depends on the caller.
        if sources & VARIES != 0 {
            self.found.push((operation, span));
        } else if sources != 0 && !self.summary.needs.contains(&(operation, span, sources)) {
            self.summary.needs.push((operation, span, sources));
        }
    }
}
