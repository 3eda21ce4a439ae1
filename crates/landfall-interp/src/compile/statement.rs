//! Compiles statements: blocks, branches, loops, calls, stores.

use std::rc::Rc;

use landfall_ir::call_graph;
use naga::{AtomicFunction, Block, Expression, Handle, Statement, SwitchCase, SwitchValue};

use super::super::code::{Access, AtomicChange, Class, Op, Reg, Values, WordBinary};
use super::super::flatten::stored;
use super::function::{Function, Returned, compiled_argument};
use super::nowhere;
use super::operators::scalar_of;
use super::value::{PointerRoot, Value};

/// The registers of a function that was called.
struct CalleeRegs {
    arguments: Vec<Rc<[Reg]>>,
    result: Rc<[Reg]>,
}

impl Function<'_, '_> {
    /// Compiles a block. When no lane is left in it, the machine continues at its end.
    pub fn block(&mut self, block: &Block) -> Result<(), String> {
        let mut skips = Vec::new();
        for (statement, span) in block.span_iter() {
            self.at(*span);
            skips.extend(self.statement(statement)?);
        }
        skips.into_iter().for_each(|skip| self.b.patch_jump(skip));
        Ok(())
    }

    /// Compiles a statement; returns the instruction that leaves the block when no lane is left.
    fn statement(&mut self, statement: &Statement) -> Result<Option<u32>, String> {
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    let span = self.arena.get_span(handle);
                    self.at(span);
                    self.value(handle)?;
                    // A loop evaluates it again in the same registers by the same instructions.
                }
            }
            Statement::Block(block) => self.block(block)?,
            Statement::If { condition, accept, reject } => {
                return self.branch(*condition, accept, reject).map(Some);
            }
            Statement::Switch { selector, cases } => {
                return self.switch(*selector, cases).map(Some);
            }
            Statement::Loop { body, continuing, break_if } => {
                return self.repeat(body, continuing, *break_if).map(Some);
            }
            Statement::Break => {
                self.b.push(Op::Break, &[], &[]);
            }
            Statement::Continue => {
                self.b.push(Op::Continue, &[], &[]);
            }
            Statement::Return { value } => {
                let from = value.map_or(Ok(Rc::from([])), |value| self.regs(value))?;
                // An inlined function returns at its end only, so the value itself is the result.
                match &mut self.returned {
                    Returned::Inline(result) => *result = from,
                    Returned::In(to) => {
                        let to = to.clone();
                        self.copy(Op::Store, &to, &from);
                        self.b.push(Op::Return, &[], &[]);
                    }
                }
            }
            Statement::Kill => {
                self.b.push(Op::Kill, &[], &[]);
            }
            Statement::ControlBarrier(_) => {
                self.b.push(Op::Barrier, &[], &[]);
            }
            // Every store is visible to all lanes at once.
            Statement::MemoryBarrier(_) => {}
            Statement::Store { pointer, value } => {
                let from = self.regs(*value)?;
                let pointer = self.pointer(*pointer)?;
                self.store(&pointer, &from)?;
            }
            Statement::Atomic { pointer, fun, value, result } => {
                self.atomic(*pointer, *fun, *value, *result)?;
            }
            Statement::WorkGroupUniformLoad { pointer, result } => {
                // A barrier before and after the load: WGSL §17.11.
                self.b.push(Op::Barrier, &[], &[]);
                let pointer = self.pointer(*pointer)?;
                let loaded = self.load_all(&pointer)?;
                self.b.push(Op::Barrier, &[], &[]);
                self.values[result.index()] = Some(Value::Regs(loaded));
            }
            Statement::Call { function, arguments, result } => {
                self.call(*function, arguments, *result)?;
            }
            Statement::ImageStore { .. } | Statement::ImageAtomic { .. } => {
                return Err("storage textures".into());
            }
            Statement::RayQuery { .. } | Statement::RayPipelineFunction(_) => {
                return Err("ray tracing".into());
            }
            Statement::SubgroupBallot { .. }
            | Statement::SubgroupGather { .. }
            | Statement::SubgroupCollectiveOperation { .. } => {
                return Err("subgroup operations".into());
            }
            Statement::CooperativeStore { .. } => return Err("cooperative matrices".into()),
        }
        Ok(None)
    }

    /// Compiles an `if`; returns the instruction that leaves it.
    fn branch(
        &mut self,
        condition: Handle<Expression>,
        accept: &Block,
        reject: &Block,
    ) -> Result<u32, String> {
        let condition = self.scalar(condition)?;
        // `If`, accept, `Else`, reject, `EndIf`; without a reject no `Else`.
        let branch = self.b.push(Op::If(0), &[condition], &[]);
        self.block(accept)?;
        self.b.patch_jump(branch);
        if !reject.is_empty() {
            let branch = self.b.push(Op::Else(0), &[], &[]);
            self.block(reject)?;
            self.b.patch_jump(branch);
        }
        Ok(self.b.push(Op::EndIf(0), &[], &[]))
    }

    /// Compiles a loop; returns the instruction that leaves it.
    fn repeat(
        &mut self,
        body: &Block,
        continuing: &Block,
        break_if: Option<Handle<Expression>>,
    ) -> Result<u32, String> {
        // `Loop`, body, `Continuing`, continuing, `BreakIf`, `LoopBack` (to the body), `LoopEnd`.
        self.b.push(Op::Loop, &[], &[]);
        let head = self.b.next_index();
        let origin = self.b.body.origin;
        self.block(body)?;
        let leave = self.b.push(Op::Continuing(0), &[], &[]);
        self.block(continuing)?;
        if let Some(condition) = break_if {
            let condition = self.scalar(condition)?;
            self.b.push(Op::BreakIf, &[condition], &[]);
        }
        // The origin is the loop's, which an endless loop is reported by.
        self.b.body.origin = origin;
        self.b.push(Op::LoopBack(head), &[], &[]);
        self.b.patch_jump(leave);
        Ok(self.b.push(Op::LoopEnd(0), &[], &[]))
    }

    fn switch(
        &mut self,
        selector: Handle<Expression>,
        cases: &[SwitchCase],
    ) -> Result<u32, String> {
        let selector = self.scalar(selector)?;
        if selector.class() != Class::Word {
            return Err("a switch over 64-bit integers".into());
        }
        let bits = |value: &SwitchValue| match value {
            SwitchValue::I32(value) => Some(*value as u32),
            SwitchValue::U32(value) => Some(*value),
            SwitchValue::Default => None,
        };
        let all: Vec<u32> = cases.iter().filter_map(|case| bits(&case.value)).collect();
        // `Switch`; for each case `Case`, `CaseSkip`, body, and `CaseEnd` unless it falls through;
        // `SwitchEnd`.
        self.b.push(Op::Switch, &[], &[]);
        for case in cases {
            let values = match bits(&case.value) {
                Some(bits) => Values { bits: vec![bits], default: false },
                None => Values { bits: all.clone(), default: true },
            };
            self.b.values.push(values);
            let table = self.b.values.len() as u32 - 1;
            self.b.push(Op::Case(table), &[selector], &[]);
            let skip = self.b.push(Op::CaseSkip(0), &[], &[]);
            self.block(&case.body)?;
            self.b.patch_jump(skip);
            if !case.fall_through {
                self.b.push(Op::CaseEnd, &[], &[]);
            }
        }
        Ok(self.b.push(Op::SwitchEnd(0), &[], &[]))
    }

    fn call(
        &mut self,
        function: Handle<naga::Function>,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
    ) -> Result<(), String> {
        let functions = self.functions;
        let callee = &functions[function.index()];
        if let Err(why) = &callee.state {
            return Err(why.clone());
        }
        // A pointer is passed by copying in and out: GLSL 4.60 §6.1.1 defines `inout` by it, and
        // WGSL forbids the aliases that would tell the difference.
        let mut back = Vec::new();
        let mut given = Vec::new();
        for (argument, handle) in callee.arguments.iter().zip(arguments) {
            let from = if argument.pointer {
                let pointer = self.pointer(*handle)?;
                let from = self.load_all(&pointer)?;
                back.push((pointer, given.len()));
                from
            } else {
                self.regs(*handle)?
            };
            given.push(from);
        }
        let called = match self.is_inlined(function) {
            true => self.inline(function, given)?,
            false => self.jump(function, &given),
        };
        for (pointer, number) in back {
            self.store(&pointer, &called.arguments[number])?;
        }
        if let Some(result) = result {
            let rounded = self.is_rounded(result).then(|| self.round_to_half(&called.result));
            self.values[result.index()] = Some(Value::Regs(rounded.unwrap_or(called.result)));
        }
        Ok(())
    }

    /// Calls a function with copies of its arguments; returns its registers, those of the result
    /// copied.
    fn jump(&mut self, function: Handle<naga::Function>, given: &[Rc<[Reg]>]) -> CalleeRegs {
        let functions = self.functions;
        let callee = &functions[function.index()];
        let arguments = callee.arguments.iter().map(|argument| Rc::from(&argument.regs[..]));
        let arguments: Vec<Rc<[Reg]>> = arguments.collect();
        for (to, from) in arguments.iter().zip(given) {
            self.copy(Op::Move, to, from);
        }
        self.b.push(Op::Call(function.index() as u32), &[], &[]);
        // The next call of the function writes the same registers.
        let result = callee.result.iter().map(|reg| self.b.temporary(reg.class()));
        let result: Rc<[Reg]> = result.collect();
        self.copy(Op::Move, &result, &callee.result);
        CalleeRegs { arguments, result }
    }

    /// Whether the code of a callee stands in place of its call: if it ends where its text does, and
    /// if it is short.
    fn is_inlined(&self, function: Handle<naga::Function>) -> bool {
        let body = &self.b.ir.functions[function].body;
        let last = matches!(body.last(), Some(Statement::Return { .. }));
        returns(body) == usize::from(last) && self.b.has_room_for(function.index())
    }

    /// Compiles a callee in place of a call.
    fn inline(
        &mut self,
        function: Handle<naga::Function>,
        given: Vec<Rc<[Reg]>>,
    ) -> Result<CalleeRegs, String> {
        self.b.take_room_for(function.index());
        let (ir, info) = (self.b.ir, self.b.info);
        let callee = &ir.functions[function];
        let mut arguments = Vec::new();
        for (argument, from) in callee.arguments.iter().zip(given) {
            let argument = compiled_argument(self.b, argument, Some(from.clone()))?;
            if argument.pointer {
                self.copy(Op::Move, &argument.regs, &from);
            }
            arguments.push(argument);
        }
        let registers = arguments.iter().map(|argument| Rc::from(&argument.regs[..])).collect();
        let origin = self.b.body.origin;
        let number = function.index() as u32;
        self.b.push(Op::Inlined(number), &[], &[]);
        // From here on, instructions are of the callee.
        self.b.body.origin = Some(nowhere(number));
        let parts = (arguments, Returned::Inline(Rc::from([])));
        let within = (self.globals, self.functions);
        let mut inner = Function::with(self.b, callee, &info[function], within, parts)?;
        inner.body()?;
        let (Returned::In(result) | Returned::Inline(result)) = inner.returned;
        self.b.body.origin = origin;
        Ok(CalleeRegs { arguments: registers, result })
    }

    fn atomic(
        &mut self,
        pointer: Handle<Expression>,
        fun: AtomicFunction,
        value: Handle<Expression>,
        result: Option<Handle<Expression>>,
    ) -> Result<(), String> {
        let pointer = self.pointer(pointer)?;
        let scalar = scalar_of(pointer.ty.inner_with(&self.b.ir.types))?;
        let sint = scalar.kind == naga::ScalarKind::Sint;
        let float = scalar.kind == naga::ScalarKind::Float;
        let mut compare = None;
        let change = match fun {
            AtomicFunction::Add => AtomicChange::Int(WordBinary::Add),
            AtomicFunction::Subtract => AtomicChange::Int(WordBinary::Sub),
            AtomicFunction::And => AtomicChange::Int(WordBinary::And),
            AtomicFunction::ExclusiveOr => AtomicChange::Int(WordBinary::Xor),
            AtomicFunction::InclusiveOr => AtomicChange::Int(WordBinary::Or),
            AtomicFunction::Min if sint => AtomicChange::Int(WordBinary::MinSint),
            AtomicFunction::Min => AtomicChange::Int(WordBinary::MinUint),
            AtomicFunction::Max if sint => AtomicChange::Int(WordBinary::MaxSint),
            AtomicFunction::Max => AtomicChange::Int(WordBinary::MaxUint),
            AtomicFunction::Exchange { compare: None } => AtomicChange::Exchange,
            AtomicFunction::Exchange { compare: Some(with) } => {
                compare = Some(self.scalar(with)?);
                AtomicChange::CompareExchange
            }
        };
        if scalar.width != 4 || float {
            return Err("atomics other than of 32-bit integers".into());
        }
        let PointerRoot::Buffer { number, .. } = pointer.root else {
            return Err("an atomic outside a buffer".into());
        };
        let value = self.scalar(value)?;
        // The operand is always there; only a compare-exchange looks at it.
        let compare = compare.unwrap_or(value);
        let (old, exchanged) = (self.b.temporary(Class::Word), self.b.temporary(Class::Word));
        let head: Vec<Reg> = pointer.indices.iter().map(|i| i.0).collect();
        let dynamics = pointer.indices.iter().map(|i| i.1).collect();
        let access = self.b.access(Access { buffer: number, dynamics, change: Some(change) });
        let operands =
            [old.0, exchanged.0, value.0, compare.0, pointer.bytes, stored(scalar) as u32];
        self.b.push(Op::Atomic(access), &head, &operands);
        if let Some(result) = result {
            let regs: Rc<[Reg]> = match change {
                AtomicChange::CompareExchange => [old, exchanged].into(),
                _ => [old].into(),
            };
            self.values[result.index()] = Some(Value::Regs(regs));
        }
        Ok(())
    }
}

/// Returns the number of returns in a block.
fn returns(block: &Block) -> usize {
    let statements = call_graph::statements(block);
    statements.filter(|statement| matches!(statement, Statement::Return { .. })).count()
}
