//! Follows statements: branches, loops, calls.

use naga::{Block, Expression, Handle, Span, Statement};

use super::{
    BREAK, CALLER, CONTINUE, NEXT, Operation, RETURN, Sources, UniformityWalk, VARIES, argument,
    merge, pointee,
};

impl<'a> UniformityWalk<'a> {
    /// Follows a block; returns the control flow at its end, and the ways in which it is left.
    pub fn block(&mut self, block: &'a Block, control: Sources) -> (Sources, u8) {
        let (mut control, mut ways) = (control, NEXT);
        for (statement, span) in block.span_iter() {
            let (after, left) = self.statement(statement, *span, control);
            control = after;
            // A block is left in the ways of its statements; the next one runs only if one way is
            // `NEXT`.
            ways = (ways & !NEXT) | left;
            if left & NEXT == 0 {
                break;
            }
        }
        (control, ways)
    }

    fn statement(
        &mut self,
        statement: &'a Statement,
        span: Span,
        control: Sources,
    ) -> (Sources, u8) {
        match statement {
            Statement::Emit(range) => {
                for expression in range.clone() {
                    self.values[expression.index()] = self.evaluated(expression, span, control);
                }
            }
            Statement::Block(block) => return self.block(block, control),
            Statement::If { condition, accept, reject } => {
                return self.branch(*condition, accept, reject, control);
            }
            Statement::Switch { selector, cases } => {
                let bodies = cases.iter().map(|case| (&case.body, case.fall_through));
                return self.switch(*selector, bodies, control);
            }
            Statement::Loop { body, continuing, break_if } => {
                return self.repeated(body, continuing, *break_if, control);
            }
            Statement::Break => {
                if let Some(breaks) = self.breaks.last_mut() {
                    merge(breaks, &self.state);
                }
                return (control, BREAK);
            }
            Statement::Continue => {
                if let Some(continues) = self.continues.last_mut() {
                    match continues {
                        Some((state, at)) => {
                            state.join(&self.state);
                            *at |= control;
                        }
                        None => *continues = Some((self.state.clone(), control)),
                    }
                }
                return (control, CONTINUE);
            }
            Statement::Return { value } => {
                // Which value is returned, and whether it is here that the function ends, may vary.
                let value = value.map_or(0, |value| self.value(value));
                self.summary.result |= value | control;
                merge(&mut self.returned, &self.state);
                return (control, RETURN);
            }
            Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => {
                self.need(Operation::Barrier, span, control);
            }
            Statement::Store { pointer, value } => {
                let sources = self.value(*value) | control;
                self.assign(*pointer, sources);
            }
            Statement::WorkGroupUniformLoad { pointer, result } => {
                // The load has a barrier of its own, and its result is the same for a workgroup.
                let pointer = self.value(*pointer);
                self.need(Operation::Barrier, span, control | pointer);
                self.values[result.index()] = 0;
            }
            Statement::Call { function, arguments, result } => {
                self.call(function.index(), arguments, *result, control);
            }
            Statement::Atomic { result: Some(result), .. } => {
                self.values[result.index()] = VARIES;
            }
            // A discarded fragment goes on as a helper; the others have no result that is followed.
            _ => {}
        }
        (control, NEXT)
    }

    fn branch(
        &mut self,
        condition: Handle<Expression>,
        accept: &'a Block,
        reject: &'a Block,
        control: Sources,
    ) -> (Sources, u8) {
        // Within the branches control flow depends on the condition, too.
        let inside = control | self.value(condition);
        let before = self.state.clone();
        let (first, first_ways) = self.block(accept, inside);
        let after = std::mem::replace(&mut self.state, before);
        let (second, second_ways) = self.block(reject, inside);
        // Variables come from the branches that reach the end.
        match (first_ways & NEXT != 0, second_ways & NEXT != 0) {
            (true, true) => self.state.join(&after),
            (true, false) => self.state = after,
            (false, _) => {}
        }
        let ways = first_ways | second_ways;
        // If no branch leaves, control flow is after it as before (WGSL §15.2): all invocations
        // meet again.
        (if ways == NEXT { control } else { first | second }, ways)
    }

    fn switch(
        &mut self,
        selector: Handle<Expression>,
        cases: impl Iterator<Item = (&'a Block, bool)>,
        control: Sources,
    ) -> (Sources, u8) {
        let inside = control | self.value(selector);
        let before = self.state.clone();
        self.breaks.push(None);
        let (mut after, mut ways, mut falls) = (inside, 0, false);
        for (body, fall_through) in cases {
            // A case that is fallen into has two ways in.
            match falls {
                true => self.state.join(&before),
                false => self.state = before.clone(),
            }
            let (end, left) = self.block(body, inside);
            after |= end;
            falls = fall_through && left & NEXT != 0;
            if left & NEXT != 0 && !falls {
                let breaks = self.breaks.last_mut().expect("the switch has pushed its own");
                merge(breaks, &self.state);
            }
            ways |= left;
        }
        let left = self.breaks.pop().flatten();
        if let Some(state) = left {
            self.state = state;
            ways |= NEXT;
        }
        ways &= !BREAK;
        (if ways == NEXT { control } else { after }, ways)
    }

    fn repeated(
        &mut self,
        body: &'a Block,
        continuing: &'a Block,
        break_if: Option<Handle<Expression>>,
        control: Sources,
    ) -> (Sources, u8) {
        // The address tells the loop in each pass.
        let key = std::ptr::from_ref(body);
        let (state, inside) = match self.loops.get(&key) {
            Some((known, at)) => {
                self.state.join(known);
                (self.state.clone(), control | *at)
            }
            None => (self.state.clone(), control),
        };
        // The body, from the states of all iterations of the passes so far.
        self.breaks.push(None);
        self.continues.push(None);
        let (mut end, mut ways) = self.block(body, inside);
        // `continue` joins the end of the body: both go on in the continuing block.
        if let Some((continued, at)) = self.continues.pop().flatten() {
            if ways & NEXT != 0 {
                self.state.join(&continued)
            } else {
                self.state = continued
            }
            end |= at;
            ways |= NEXT;
        }
        let repeats = ways & NEXT != 0;
        if repeats {
            (end, _) = self.block(continuing, end);
            if let Some(condition) = break_if {
                end |= self.value(condition);
                let breaks = self.breaks.last_mut().expect("the loop has pushed its own");
                merge(breaks, &self.state);
            }
        }
        let left = self.breaks.pop().flatten();
        let mut start = (state, inside);
        // The next iteration begins where this one ends; what is new there needs another pass.
        if repeats {
            start.0.join(&self.state);
            start.1 |= end;
        }
        let at_start = start.1;
        if self.loops.get(&key) != Some(&start) {
            self.loops.insert(key, start);
            self.grown = true;
        }
        let mut ways = ways & RETURN;
        if let Some(state) = left {
            self.state = state;
            ways |= NEXT;
        }
        // A loop that is left by its end or `break` alone is one that all invocations leave.
        (if ways == NEXT { control } else { at_start }, ways)
    }

    fn call(
        &mut self,
        function: usize,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
        control: Sources,
    ) {
        let Some(summary) = self.summaries.get(function) else { return };
        let values: Vec<Sources> = arguments.iter().map(|at| self.value(*at)).collect();
        let contents: Vec<Sources> = arguments.iter().map(|at| self.contents(*at)).collect();
        // Sources of the callee in terms of the caller: control flow at the call, values and
        // contents of the arguments.
        let mapped = |sources: Sources| {
            let mut all = sources & VARIES;
            if sources & CALLER != 0 {
                all |= control;
            }
            for (index, (value, contents)) in (0u32..).zip(values.iter().zip(&contents)) {
                if sources & argument(index) != 0 {
                    all |= value;
                }
                if sources & pointee(index) != 0 {
                    all |= contents;
                }
            }
            all
        };
        for (operation, span, sources) in &summary.needs {
            self.need(*operation, *span, mapped(*sources));
        }
        for (argument, sources) in arguments.iter().zip(&summary.pointees) {
            if self.is_pointer(*argument) {
                self.assign(*argument, mapped(*sources));
            }
        }
        if let Some(result) = result {
            self.values[result.index()] = mapped(summary.result);
        }
    }
}
