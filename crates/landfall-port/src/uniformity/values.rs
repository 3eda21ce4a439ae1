//! The sources of expressions, and of the variables that pointers lead to.

use naga::{
    AddressSpace, Binding, BuiltIn, Expression, Handle, SampleLevel, Span, StorageAccess, TypeInner,
};

use super::{Operation, PointedVariable, Sources, UniformityWalk, VARIES, argument};

impl UniformityWalk<'_> {
    /// Adds sources to the variable a pointer leads to; they replace the former if it is the whole
    /// variable.
    pub fn assign(&mut self, pointer: Handle<Expression>, sources: Sources) {
        let (root, indices) = self.root(pointer);
        let whole = matches!(
            self.function.expressions[pointer],
            Expression::LocalVariable(_) | Expression::FunctionArgument(_)
        );
        let slot = match root {
            PointedVariable::Local(variable) => self.state.locals.get_mut(variable.index()),
            PointedVariable::Argument(index) => self.state.pointees.get_mut(index as usize),
            PointedVariable::Other(_) => None,
        };
        if let Some(slot) = slot {
            // A write of a part keeps what the rest has.
            let kept = if whole { 0 } else { *slot };
            *slot = kept | sources | indices;
        }
    }

    /// Returns the sources of what a pointer points to; 0 for values.
    pub fn contents(&self, pointer: Handle<Expression>) -> Sources {
        let (root, indices) = self.root(pointer);
        indices
            | match root {
                PointedVariable::Local(variable) => self.state.locals[variable.index()],
                PointedVariable::Argument(index) => {
                    self.state.pointees.get(index as usize).copied().unwrap_or(VARIES)
                }
                PointedVariable::Other(sources) => sources,
            }
    }

    /// Returns the variable a pointer leads to, and the sources of the indices on the way.
    fn root(&self, pointer: Handle<Expression>) -> (PointedVariable, Sources) {
        let (mut at, mut indices) = (pointer, 0);
        loop {
            match self.function.expressions[at] {
                Expression::AccessIndex { base, .. } => at = base,
                Expression::Access { base, index } => {
                    indices |= self.value(index);
                    at = base;
                }
                Expression::LocalVariable(variable) => {
                    return (PointedVariable::Local(variable), indices);
                }
                Expression::FunctionArgument(index) if self.is_pointer(at) => {
                    return (PointedVariable::Argument(index), indices);
                }
                Expression::GlobalVariable(variable) => {
                    // What no invocation writes is the same for all, if the same place is read.
                    let varies = match self.module.global_variables[variable].space {
                        AddressSpace::Uniform | AddressSpace::Immediate | AddressSpace::Handle => 0,
                        AddressSpace::Storage { access }
                            if !access.contains(StorageAccess::STORE) =>
                        {
                            0
                        }
                        _ => VARIES,
                    };
                    return (PointedVariable::Other(varies), indices);
                }
                _ => return (PointedVariable::Other(0), indices),
            }
        }
    }

    pub fn is_pointer(&self, expression: Handle<Expression>) -> bool {
        let mut at = expression;
        loop {
            match self.function.expressions[at] {
                Expression::AccessIndex { base, .. } | Expression::Access { base, .. } => at = base,
                Expression::LocalVariable(_) => return true,
                Expression::FunctionArgument(index) => {
                    let ty = self.function.arguments[index as usize].ty;
                    let inner = &self.module.types[ty].inner;
                    return matches!(
                        inner,
                        TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. }
                    );
                }
                _ => return false,
            }
        }
    }

    /// Returns the sources of an expression where it is used.
    pub fn value(&self, expression: Handle<Expression>) -> Sources {
        match self.function.expressions[expression] {
            Expression::FunctionArgument(index) => match self.entry {
                // WGSL §15.2: the same for all invocations of a workgroup; other inputs of a stage
                // vary.
                None => argument(index),
                Some(_) => match self.function.arguments[index as usize].binding {
                    Some(Binding::BuiltIn(BuiltIn::WorkGroupId | BuiltIn::NumWorkGroups)) => 0,
                    _ => VARIES,
                },
            },
            Expression::Literal(_)
            | Expression::Constant(_)
            | Expression::Override(_)
            | Expression::ZeroValue(_)
            | Expression::LocalVariable(_)
            | Expression::GlobalVariable(_) => 0,
            _ => self.values[expression.index()],
        }
    }

    /// Returns the sources of an expression that is evaluated now.
    pub fn evaluated(
        &mut self,
        expression: Handle<Expression>,
        statement: Span,
        control: Sources,
    ) -> Sources {
        let own = self.function.expressions.get_span(expression);
        let span = if own.is_defined() { own } else { statement };
        match &self.function.expressions[expression] {
            Expression::Load { pointer } => self.contents(*pointer),
            Expression::Derivative { .. } => {
                self.need(Operation::Derivative, span, control);
                VARIES
            }
            Expression::ImageSample {
                gather: None,
                level: SampleLevel::Auto | SampleLevel::Bias(_),
                ..
            } => {
                self.need(Operation::Derivative, span, control);
                VARIES
            }
            // Other invocations may write in between.
            Expression::ImageLoad { image, .. } if self.is_written(*image) => VARIES,
            Expression::AtomicResult { .. }
            | Expression::RayQueryProceedResult
            | Expression::RayQueryGetIntersection { .. }
            | Expression::RayQueryVertexPositions { .. }
            | Expression::SubgroupBallotResult
            | Expression::SubgroupOperationResult { .. }
            | Expression::CooperativeLoad { .. }
            | Expression::CooperativeMultiplyAdd { .. } => VARIES,
            Expression::CallResult(_) | Expression::WorkGroupUniformLoadResult { .. } => {
                self.values[expression.index()]
            }
            Expression::ArrayLength(_) => 0,
            other => {
                let mut all = 0;
                operands(other, &mut |operand| all |= self.value(operand));
                all
            }
        }
    }

    /// Whether invocations may write the image that others read.
    fn is_written(&self, image: Handle<Expression>) -> bool {
        let variable = match self.function.expressions[image] {
            Expression::GlobalVariable(variable) => variable,
            _ => return false,
        };
        let ty = self.module.global_variables[variable].ty;
        match self.module.types[ty].inner {
            TypeInner::Image { class: naga::ImageClass::Storage { access, .. }, .. } => {
                access.contains(StorageAccess::STORE)
            }
            _ => false,
        }
    }
}

/// Calls `visit` with the operands of an expression whose value depends on nothing else.
fn operands(expression: &Expression, visit: &mut impl FnMut(Handle<Expression>)) {
    let mut each = |all: &[Option<Handle<Expression>>]| {
        all.iter().flatten().for_each(|operand| visit(*operand));
    };
    match expression {
        Expression::Compose { components, .. } => {
            components.iter().for_each(|component| each(&[Some(*component)]));
        }
        Expression::Access { base, index } => each(&[Some(*base), Some(*index)]),
        Expression::AccessIndex { base, .. } => each(&[Some(*base)]),
        Expression::Splat { value, .. } => each(&[Some(*value)]),
        Expression::Swizzle { vector, .. } => each(&[Some(*vector)]),
        Expression::ImageSample {
            coordinate,
            array_index,
            offset,
            level,
            depth_ref,
            image,
            ..
        } => {
            each(&[Some(*image), Some(*coordinate), *array_index, *offset, *depth_ref]);
            match level {
                SampleLevel::Auto | SampleLevel::Zero => {}
                SampleLevel::Exact(level) | SampleLevel::Bias(level) => each(&[Some(*level)]),
                SampleLevel::Gradient { x, y } => each(&[Some(*x), Some(*y)]),
            }
        }
        Expression::ImageLoad { image, coordinate, array_index, sample, level } => {
            each(&[Some(*image), Some(*coordinate), *array_index, *sample, *level]);
        }
        Expression::ImageQuery { image, query } => {
            each(&[Some(*image)]);
            if let naga::ImageQuery::Size { level } = query {
                each(&[*level]);
            }
        }
        Expression::Unary { expr, .. } | Expression::As { expr, .. } => each(&[Some(*expr)]),
        Expression::Binary { left, right, .. } => each(&[Some(*left), Some(*right)]),
        Expression::Select { condition, accept, reject } => {
            each(&[Some(*condition), Some(*accept), Some(*reject)]);
        }
        Expression::Relational { argument, .. } => each(&[Some(*argument)]),
        Expression::Math { arg, arg1, arg2, arg3, .. } => each(&[Some(*arg), *arg1, *arg2, *arg3]),
        _ => {}
    }
}
