//! Constants used in array sizes: `const` variables and specialisation constants.

use rustc_hash::FxHashMap;
use std::sync::Arc;

use super::ast::{Declarator, Dim, LayoutId, Name, Qualifiers, Tokens};
use super::declarations::DeclarationReader;
use super::evaluate::{Names, Problem, converted, evaluate_tokens};
use super::lexer::Token;
use super::report::diagnostic_at;
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{Override, Scalar, SpecialisedLength};
use crate::source::Span;
use crate::syntax::constant::{Kind, Value};

/// The limit on chains of constants defined by other constants.
const DEEPEST_CHAIN: u32 = 64;

#[derive(Clone, Debug)]
pub(super) struct Constant<'a> {
    definition: Definition<'a>,
    /// The value in a pipeline specialised with the values set by `-O`, where they matter.
    specialised: Option<Value>,
    /// Its index in [`Constants::uses`].
    index: usize,
}

/// The names that the value of a constant depends on.
// A node of a graph, by its edges to the constants in its initialiser. All of them are declared
// before it, so the graph has no cycles.
#[derive(Clone, Debug, Default)]
struct ConstantUses {
    constants: Vec<usize>,
    /// The index of the specialisation constant that it is.
    of_override: Option<usize>,
    /// Whether it is one, or depends on one.
    is_specialised: bool,
    /// Whether an array size depends on it.
    sizes_depend: bool,
}

// Vectors and arrays stay tokens until a length uses one, which is rare.
#[derive(Clone, Debug)]
enum Definition<'a> {
    /// A scalar, evaluated where it is declared.
    Value(Result<Value, Problem>),
    /// A vector or array, evaluated where it is used.
    Later(Vec<Token<'a>>),
}

#[derive(Debug, Default)]
pub(super) struct Constants<'a> {
    by_name: FxHashMap<&'a str, Constant<'a>>,
    /// The uses of each constant, including those hidden by a later constant of the same name.
    uses: Vec<ConstantUses>,
    /// The specialisation constants in declaration order.
    pub overrides: Vec<Override>,
    /// Whether an array size depends on each of them.
    pub used: Vec<bool>,
    /// Whether `-O` sets one of them.
    any_given: bool,
}

/// Resolves names during the evaluation of one expression.
struct Lookup<'c, 'a> {
    constants: &'c Constants<'a>,
    used: Vec<usize>,
    /// Whether the values set by `-O` count, instead of the defaults.
    specialised: bool,
    depth: u32,
}

impl Names for Lookup<'_, '_> {
    fn value(&mut self, name: &str, span: Span) -> Result<Value, Problem> {
        let Some(constant) = self.constants.by_name.get(name) else {
            if name.starts_with("gl_Max") {
                let message =
                    format!("depends on the driver's `{name}`; define it with `--define {name}=N`");
                return Err(Problem::new(span, message));
            }
            let message = format!("is not constant: `{name}` is not a constant of this shader");
            let unknown = Some(name.to_string());
            return Err(Problem { unknown, ..Problem::new(span, message) });
        };
        // Noted before the value, so that uses are known even where there is none.
        self.used.push(constant.index);
        if let (true, Some(value)) = (self.specialised, &constant.specialised) {
            return Ok(value.clone());
        }
        match &constant.definition {
            Definition::Value(value) => {
                value.clone().map_err(|problem| Problem::new(span, problem.message))
            }
            Definition::Later(tokens) => {
                if self.depth == DEEPEST_CHAIN {
                    return Err(Problem::new(
                        span,
                        format!("is defined by a chain of more than {DEEPEST_CHAIN} constants"),
                    ));
                }
                self.depth += 1;
                let value = evaluate_tokens(tokens, span, self);
                self.depth -= 1;
                value
            }
        }
    }
}

impl<'a> Constants<'a> {
    pub(super) fn names(&self) -> impl Iterator<Item = &'a str> + '_ {
        self.by_name.keys().copied()
    }

    pub(super) fn value(&self, name: &str, span: Span) -> Result<Value, Problem> {
        self.lookup(false).value(name, span)
    }

    fn lookup(&self, specialised: bool) -> Lookup<'_, 'a> {
        Lookup { constants: self, used: Vec::new(), specialised, depth: 0 }
    }

    fn evaluate(&self, tokens: &[Token<'a>], span: Span) -> (Result<Value, Problem>, Vec<usize>) {
        let mut names = self.lookup(false);
        let value = evaluate_tokens(tokens, span, &mut names);
        names.used.sort_unstable();
        names.used.dedup();
        (value, names.used)
    }

    /// Evaluates with the values set by `-O`, if there are any.
    fn specialised(&self, tokens: &[Token<'a>], span: Span) -> Option<Value> {
        let names = &mut self.lookup(true);
        self.any_given.then(|| evaluate_tokens(tokens, span, names).ok()).flatten()
    }

    /// Returns the value of an expression of a length; `None` if it has none, or if it depends on
    /// specialisation constants.
    pub(super) fn unspecialised(&self, tokens: &[Token<'a>], span: Span) -> Option<u32> {
        let (value, used) = self.evaluate(tokens, span);
        let value = u32::try_from(value.ok()?.integer()?).ok()?;
        self.overrides_among(&used).is_empty().then_some(value)
    }

    /// Marks the specialisation constants that a size depends on.
    // A walk over the graph in which each constant is entered once for the whole shader, since its
    // mark stays.
    fn mark(&mut self, used: Vec<usize>) {
        let mut left = used;
        while let Some(index) = left.pop() {
            let uses = &mut self.uses[index];
            if std::mem::replace(&mut uses.sizes_depend, true) {
                continue;
            }
            left.extend(&uses.constants);
            if let Some(index) = uses.of_override {
                self.used[index] = true;
            }
        }
    }

    /// Returns the names of the specialisation constants among the constants and what those use.
    // As `mark`, but for one length, with marks of its own.
    fn overrides_among(&self, used: &[usize]) -> Vec<Arc<str>> {
        let is_specialised = |index: &usize| self.uses[*index].is_specialised;
        let mut left: Vec<usize> = used.iter().copied().filter(is_specialised).collect();
        if left.is_empty() {
            return Vec::new();
        }
        let (mut seen, mut found) = (vec![false; self.uses.len()], Vec::new());
        while let Some(index) = left.pop() {
            if std::mem::replace(&mut seen[index], true) {
                continue;
            }
            left.extend(self.uses[index].constants.iter().copied().filter(is_specialised));
            found.extend(self.uses[index].of_override);
        }
        found.sort_unstable();
        found.into_iter().map(|index| Arc::clone(&self.overrides[index].name)).collect()
    }
}

impl<'a> DeclarationReader<'a> {
    /// Evaluates an integer constant expression that a size depends on.
    pub(super) fn constant_integer(
        &mut self,
        tokens: &Tokens,
        span: Span,
    ) -> Result<i128, Problem> {
        let tokens = &self.parser.tokens()[tokens.clone()];
        let (value, used) = self.constants.evaluate(tokens, span);
        self.constants.mark(used);
        let first = tokens.first().map_or(span, |token| token.span);
        value?.integer().ok_or_else(|| Problem::new(first, "is not an integer"))
    }

    /// Records a length that depends on specialisation constants.
    pub(super) fn note_specialised(&mut self, member: &Token<'a>, dim: &Dim<'a>) {
        if self.constants.overrides.is_empty() {
            return;
        }
        let tokens = &self.parser.tokens()[dim.tokens.clone()];
        let (value, used) = self.constants.evaluate(tokens, dim.span);
        let constants = self.constants.overrides_among(&used);
        if constants.is_empty() {
            return;
        }
        let given = self.constants.specialised(tokens, dim.span).and_then(|value| value.integer());
        // A value that leaves the length as it is by default is no difference worth recording.
        let given = given.filter(|given| value.ok().and_then(|v| v.integer()) != Some(*given));
        let given = given.and_then(|given| u32::try_from(given).ok());
        self.specialised.push(SpecialisedLength { member: member.span, constants, given });
    }

    /// Records a `const`; `scalar` is its type if it is a scalar.
    pub(super) fn add_constant(
        &mut self,
        declarator: &Declarator<'a>,
        scalar: Option<Scalar>,
        qualifiers: &Qualifiers<'a>,
    ) {
        let name = declarator.name;
        let initialiser = &self.parser.tokens()[declarator.tokens.clone()];
        let (definition, uses, specialised) = match scalar {
            None => (Definition::Later(initialiser.to_vec()), ConstantUses::default(), None),
            Some(scalar) => {
                let (value, used) = self.constants.evaluate(initialiser, name.span);
                let is_specialised =
                    used.iter().any(|index| self.constants.uses[*index].is_specialised);
                let mut uses =
                    ConstantUses { constants: used, is_specialised, ..ConstantUses::default() };
                let convert = |value: Value| {
                    let wrong = |_| Problem::new(name.span, "has an initialiser of another type");
                    converted(&value, scalar).map_err(wrong)
                };
                let mut value = value.and_then(convert);
                let mut specialised = self.constants.specialised(initialiser, name.span);
                // A specialisation constant depends on itself alone: its initialiser is only its
                // default (§4.11).
                if qualifiers.find("constant_id").is_some() {
                    (value, specialised) = self.specialise(name, scalar.into(), qualifiers, value);
                    let of_override = Some(self.constants.overrides.len() - 1);
                    uses = ConstantUses {
                        of_override,
                        is_specialised: true,
                        ..ConstantUses::default()
                    };
                }
                let specialised = specialised.and_then(|value| converted(&value, scalar).ok());
                (Definition::Value(value), uses, specialised)
            }
        };
        let index = self.constants.uses.len();
        self.constants.uses.push(uses);
        self.constants.by_name.insert(name.text, Constant { definition, specialised, index });
    }

    /// Returns the value of a layout entry, a non-negative integer.
    pub(super) fn layout_number(&mut self, id: &LayoutId<'a>) -> Result<u64, Diagnostic> {
        let name = self.parser.token_of(&id.name);
        if id.tokens.is_empty() {
            let message = format!("`{}` needs a value: `{} = N`", name.text, name.text);
            return Err(diagnostic_at(&name, Code::LayoutQualifier, message));
        }
        let value = self.constant_integer(&id.tokens, name.span);
        let value = value.map_err(|problem| {
            let message = format!("the value of `{}` {}", name.text, problem.message);
            Diagnostic::error(Code::LayoutQualifier, problem.span, message)
        })?;
        u64::try_from(value).map_err(|_| {
            let message = format!("`{} = {value}` is negative", name.text);
            diagnostic_at(&self.parser.tokens()[id.tokens.start], Code::LayoutQualifier, message)
        })
    }

    /// Records a specialisation constant and returns its default, by which blocks are laid out:
    /// "Changing the specialized size will not re-layout the block" (GL_KHR_vulkan_glsl). The value
    /// set by `-O` is returned beside it.
    fn specialise(
        &mut self,
        name: Name<'a>,
        kind: Kind,
        qualifiers: &Qualifiers<'a>,
        default: Result<Value, Problem>,
    ) -> (Result<Value, Problem>, Option<Value>) {
        let id = qualifiers.find("constant_id").and_then(|id| {
            let tokens = &self.parser.tokens()[id.tokens.clone()];
            let value = self.constants.evaluate(tokens, name.span).0.ok()?;
            u32::try_from(value.integer()?).ok()
        });
        let number = id.map(|id| id.to_string());
        // The last setting counts, by the constant's name or by its id.
        let given = self
            .options()
            .overrides
            .iter()
            .rev()
            .find(|(key, _)| key == name.text || Some(key) == number.as_ref());
        let mut specialised = None;
        let value = match given {
            None => default,
            Some((_, text)) => {
                let fits = |value: &Value| match (value, kind) {
                    (Value::Bool(_), kind) => kind == Kind::Bool,
                    (Value::Float(_), kind) => kind == Kind::Float,
                    (value, Kind::Bool) => matches!(value.integer(), Some(0 | 1)),
                    _ => true,
                };
                let given = parse_given(text).filter(fits);
                match given.and_then(|value| value.convert(kind).ok()) {
                    Some(given) => {
                        specialised = Some(given);
                        default
                    }
                    None => {
                        let wanted = match kind {
                            Kind::Bool => "true or false",
                            Kind::Float => "a number",
                            Kind::Int | Kind::Uint | Kind::Long | Kind::Ulong => "an integer",
                        };
                        let message = format!("is set to `{text}`, which is not {wanted}");
                        Err(Problem::new(name.span, message))
                    }
                }
            }
        };
        let integer = value.as_ref().ok().and_then(Value::integer);
        self.constants.overrides.push(Override {
            name: name.text.into(),
            id,
            value: integer.and_then(|v| i64::try_from(v).ok()),
        });
        self.constants.used.push(false);
        self.constants.any_given |= specialised.is_some();
        (value, specialised)
    }
}

/// Parses a number from the command line.
fn parse_given(text: &str) -> Option<Value> {
    match text {
        "true" => Some(Value::Bool(true)),
        "false" => Some(Value::Bool(false)),
        _ => match text.parse() {
            Ok(integer) => Some(Value::Long(integer)),
            Err(_) => text.parse().ok().map(Value::Float),
        },
    }
}
