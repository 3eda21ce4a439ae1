//! The uses of names that lowering has to know in advance.

use rustc_hash::FxHashSet;

use super::ast::*;
use landfall_layout::syntax::glsl::walk;

/// Returns the names of variables and members that atomic functions change.
pub fn atomics<'a>(items: &[Item<'a>]) -> FxHashSet<&'a str> {
    // By name alone: a member of the same name in another structure becomes atomic as well, which
    // changes no result.
    let mut names = FxHashSet::default();
    for item in items {
        let Item::Function(function) = item else { continue };
        // `atomicAdd(s.count[i], 1)` changes `count`.
        walk::expressions(function.body.as_deref().unwrap_or_default(), &mut |e| {
            let ExprKind::Call(name, arguments) = &e.kind else { return };
            if name.text.starts_with("atomic") || name.text.starts_with("imageAtomic") {
                names.extend(arguments.first().and_then(last_name));
            }
        });
    }
    names
}

/// Returns the names that a body visibly writes to; `writes` returns whether a function writes to
/// its arguments.
pub fn written_names<'a>(
    // Visibly: not through `inout` parameters of functions that are passed on, which `writes`
    // tells.
    body: &[Statement<'a>],
    writes: &dyn Fn(&str) -> bool,
) -> FxHashSet<&'a str> {
    let mut names = FxHashSet::default();
    walk::expressions(body, &mut |e| match &e.kind {
        ExprKind::Assign(_, left, _) => names.extend(left.root()),
        ExprKind::Step(_, inner) => names.extend(inner.root()),
        ExprKind::Call(name, arguments) if writes(name.text) => {
            names.extend(arguments.iter().filter_map(Expr::root));
        }
        _ => {}
    });
    names
}

/// Returns the last member name of an expression: `b` for `a.b[2]`.
fn last_name<'a>(e: &Expr<'a>) -> Option<&'a str> {
    match &e.kind {
        ExprKind::Name(name) => Some(name),
        ExprKind::Index(base, _) => last_name(base),
        ExprKind::Member(_, name) => Some(name.text),
        _ => None,
    }
}

/// Returns whether an expression has no side effects, cannot fail and is cheap, so that it may be
/// evaluated even if its value is not needed.
pub fn is_simple(e: &Expr<'_>) -> bool {
    // The depth is known from the parser, so that long chains are not walked again for each
    // operator.
    e.depth <= 8 && simple(e)
}

fn simple(e: &Expr<'_>) -> bool {
    match &e.kind {
        ExprKind::Number(_) | ExprKind::Bool(_) | ExprKind::Name(_) => true,
        ExprKind::Unary(_, inner) | ExprKind::Member(inner, _) => simple(inner),
        ExprKind::Binary(op, a, b) => {
            // Division by zero and an index past the end would be executed needlessly.
            !matches!(op, Binary::Divide | Binary::Modulo) && simple(a) && simple(b)
        }
        ExprKind::Construct(ty, arguments) => {
            ty.dims.is_empty() && arguments.len() <= 4 && arguments.iter().all(simple)
        }
        ExprKind::Index(base, index) => simple(base) && matches!(index.kind, ExprKind::Number(_)),
        ExprKind::Assign(..)
        | ExprKind::Step(..)
        | ExprKind::Choose(_)
        | ExprKind::Comma(..)
        | ExprKind::Call(..)
        | ExprKind::Length(_)
        | ExprKind::List(_) => false,
    }
}
