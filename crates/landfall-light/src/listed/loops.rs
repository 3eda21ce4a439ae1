//! The loops over lights in a text, and why a loop is none.

use std::ops::Range;

use super::tokens::{ListedToken, closing};
use crate::bind::Kind;
use landfall_layout::source::Language;

/// An array of lights, or of one property of lights.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Array {
    pub kind: Kind,
    /// The names before its index: `points`, `pointLights`.
    pub names: Vec<String>,
}

impl Array {
    /// Returns the index of the `[` behind the array, if the text names it at that token.
    fn index(&self, tokens: &[ListedToken<'_>], at: usize) -> Option<usize> {
        let is = |at: usize, text: &str| tokens.get(at).is_some_and(|token| token.text == text);
        // `a.points[i]` is another array than `points[i]`.
        let begins = at.checked_sub(1).is_none_or(|before| !is(before, "."));
        let mut next = at;
        for (number, name) in self.names.iter().enumerate() {
            if number > 0 {
                if !is(next, ".") {
                    return None;
                }
                next += 1;
            }
            if !is(next, name) {
                return None;
            }
            next += 1;
        }
        (begins && is(next, "[")).then_some(next)
    }
}

/// A `for` loop; all numbers are indices of tokens.
#[derive(Clone, Debug)]
pub(super) struct Loop<'t> {
    /// The `for`; its `(` is the next.
    pub at: usize,
    /// The `)`.
    pub close: usize,
    pub condition: Range<usize>,
    pub body: Range<usize>,
    pub braced: bool,
    pub variable: &'t str,
    pub ty: &'t str,
    /// Why its iterations cannot be taken from a list.
    fault: Option<&'static str>,
}

/// Returns the `for` loops that declare a variable, in the order of the text.
pub(super) fn loops<'t>(tokens: &[ListedToken<'t>], language: Language) -> Vec<Loop<'t>> {
    let at = (0..tokens.len()).filter(|at| tokens[*at].text == "for");
    at.filter_map(|at| read(tokens, at, language)).collect()
}

fn read<'t>(tokens: &[ListedToken<'t>], at: usize, language: Language) -> Option<Loop<'t>> {
    let open = at + 1;
    // "for" "(" init ";" condition ";" update ")" body.
    let close = closing(tokens, open).filter(|_| tokens[open].text == "(")?;
    let mut semicolons = (open..close).filter(|at| tokens[*at].text == ";");
    let (first, second) = (semicolons.next()?, semicolons.next()?);
    let (declared, condition) = (&tokens[open + 1..first], first + 1..second);
    let next = close + 1;
    let braced = tokens.get(next)?.text == "{";
    // A body without braces ends at its semicolon.
    let end = match braced {
        true => closing(tokens, next)?,
        false => (next..tokens.len()).find(|at| tokens[*at].text == ";")?,
    };
    let body = next..end + 1;
    let (variable, ty, start) = match language {
        Language::Glsl | Language::SpirV => glsl(declared)?,
        Language::Wgsl => wgsl(declared)?,
    };
    let words =
        |range: &[ListedToken<'t>]| range.iter().map(|t| t.text).collect::<Vec<_>>().join(" ");
    let update = words(&tokens[second + 1..close]);
    let one = ["1", "1u", "1i", "1U"];
    let counts = [format!("{variable} + +"), format!("+ + {variable}")].contains(&update)
        || one.iter().any(|one| {
            update == format!("{variable} + = {one}")
                || update == format!("{variable} = {variable} + {one}")
        });
    // A list replaces a loop only if all iterations are alike: from 0 by 1, independent of each
    // other.
    let fault = if !["0", "0u", "0i", "0U"].contains(&start.as_str()) {
        Some("starts elsewhere than at 0")
    } else if !counts {
        Some("does not count one by one")
    } else if condition.is_empty() {
        Some("has no condition")
    } else if !braced && ["for", "if", "while", "do", "switch"].contains(&tokens[body.start].text) {
        Some("has a body without braces that is no plain statement")
    } else {
        fault(&tokens[body.clone()], variable)
    };
    Some(Loop { at, close, condition, body, braced, variable, ty, fault })
}

/// Reads `int i = 0`: the name, its type, and the start.
fn glsl<'t>(declared: &[ListedToken<'t>]) -> Option<(&'t str, &'t str, String)> {
    let precisions = ["highp", "mediump", "lowp"];
    let declared = match declared {
        [first, rest @ ..] if precisions.contains(&first.text) => rest,
        all => all,
    };
    match declared {
        [ty, name, equals, start @ ..]
            if ["int", "uint"].contains(&ty.text) && equals.text == "=" =>
        {
            Some((name.text, ty.text, start.iter().map(|t| t.text).collect()))
        }
        _ => None,
    }
}

/// Reads `var i = 0u` or `var i: u32 = 0`.
fn wgsl<'t>(declared: &[ListedToken<'t>]) -> Option<(&'t str, &'t str, String)> {
    match declared {
        [var, name, equals, start @ ..] if var.text == "var" && equals.text == "=" => {
            let start: String = start.iter().map(|t| t.text).collect();
            let ty = if start.ends_with('u') { "u32" } else { "i32" };
            Some((name.text, ty, start))
        }
        [var, name, colon, ty, equals, start @ ..]
            if var.text == "var"
                && colon.text == ":"
                && equals.text == "="
                && ["u32", "i32"].contains(&ty.text) =>
        {
            Some((name.text, ty.text, start.iter().map(|t| t.text).collect()))
        }
        _ => None,
    }
}

/// Returns what in a body makes later iterations depend on earlier ones.
fn fault(body: &[ListedToken<'_>], variable: &str) -> Option<&'static str> {
    let word = |at: usize| body.get(at).map_or("", |token| token.text);
    // The ends of the loops and switches around a token, which `break` leaves instead.
    // `break` in an inner loop or `switch` does not end this one.
    let mut inner: Vec<usize> = Vec::new();
    for at in 0..body.len() {
        inner.retain(|end| at < *end);
        match word(at) {
            "for" | "while" | "switch" | "loop" => inner.push(end_of(body, at)),
            "break" if inner.is_empty() => return Some("ends by `break`"),
            "return" => return Some("ends by `return`"),
            "discard" => return Some("ends by `discard`"),
            name if name == variable => {
                let before = at.checked_sub(1).map_or("", word);
                // Assignments are seen as tokens of one character: `=` not followed by `=`, `+ =`,
                // `+ +`.
                let [next, after] = [word(at + 1), word(at + 2)];
                let member = before == ".";
                let assigned = next == "=" && after != "="
                    || ["+", "-", "*", "/", "%", "&", "|", "^"].contains(&next) && after == "="
                    || ["+", "-"].contains(&next) && after == next
                    || ["+", "-"].contains(&before) && at >= 2 && word(at - 2) == before;
                if assigned && !member {
                    return Some("changes its variable in its body");
                }
            }
            _ => {}
        }
    }
    None
}

/// Returns the end of the loop or switch at a token.
fn end_of(body: &[ListedToken<'_>], at: usize) -> usize {
    let is = |at: usize, text: &str| body.get(at).is_some_and(|token| token.text == text);
    let mut next = at + 1;
    if is(next, "(") {
        next = closing(body, next).map_or(body.len(), |close| close + 1);
    }
    while next < body.len() && !is(next, "{") && !is(next, ";") {
        next += 1;
    }
    match is(next, "{") {
        true => closing(body, next).map_or(body.len(), |close| close + 1),
        false => (next + 1).min(body.len()),
    }
}

/// Returns the loops over all lights of a kind.
///
/// # Errors
/// The reason why there are none, or why the lights of one cannot be taken from a list.
pub(super) fn over<'l, 't>(
    kind: Kind,
    arrays: &[Array],
    tokens: &[ListedToken<'t>],
    loops: &'l [Loop<'t>],
) -> Result<Vec<&'l Loop<'t>>, String> {
    if !arrays.iter().any(|array| array.kind == kind) {
        return Err("the shader has single ones, in no array".to_string());
    }
    // Uses outside of functions are declarations.
    let bodies = functions(tokens);
    let mut found: Vec<&Loop<'_>> = Vec::new();
    for at in (0..tokens.len()).filter(|at| bodies.iter().any(|body| body.contains(at))) {
        let Some((array, open)) =
            arrays.iter().find_map(|array| Some((array, array.index(tokens, at)?)))
        else {
            continue;
        };
        if array.kind != kind {
            continue;
        }
        let name = array.names.join(".");
        let Some(index) = variable(tokens, open) else {
            return Err(format!("`{name}[…]` has an index that is not the variable of a loop"));
        };
        let inside =
            |one: &&Loop<'_>| one.variable == index && (one.at..one.body.end).contains(&at);
        // The innermost comes last.
        let Some(one) = loops.iter().rev().find(inside) else {
            return Err(format!(
                "`{index}` of `{name}[{index}]` is not the variable of a `for` loop \
                                around it"
            ));
        };
        if at <= one.close {
            return Err(format!("the loop over `{name}` reads a light in its condition"));
        }
        // A fault of one loop leaves the kind as it is: its lights must all be visited somewhere.
        if let Some(fault) = one.fault {
            return Err(format!("the loop over `{name}` {fault}"));
        }
        // A list of point lights must not select spotlights.
        let others = |at: usize| {
            arrays.iter().any(|other| {
                other.kind != kind && {
                    let open = other.index(tokens, at);
                    open.and_then(|open| variable(tokens, open)) == Some(one.variable)
                }
            })
        };
        if one.body.clone().any(others) {
            return Err(format!("the loop over `{name}` visits other lights by the same index"));
        }
        if !found.iter().any(|known| known.at == one.at) {
            found.push(one);
        }
    }
    match found.is_empty() {
        true => Err("no loop of the text indexes their array".to_string()),
        false => Ok(found),
    }
}

/// Returns the name between brackets, converted or not: `[i]`, `[int(i)]`.
fn variable<'t>(tokens: &[ListedToken<'t>], open: usize) -> Option<&'t str> {
    let close = closing(tokens, open)?;
    let conversions = ["int", "uint", "i32", "u32"];
    let name = match &tokens[open + 1..close] {
        [name] => name.text,
        [to, _, name, _] if conversions.contains(&to.text) => name.text,
        _ => return None,
    };
    name.starts_with(|c: char| c.is_alphabetic() || c == '_').then_some(name)
}

fn functions(tokens: &[ListedToken<'_>]) -> Vec<Range<usize>> {
    let mut bodies = Vec::new();
    let mut at = 0;
    // The first token of the declaration at hand.
    let mut first = 0;
    // Declarations end at `;` or with a body; a function's head ends with `)` or has `fn`.
    while at < tokens.len() {
        match tokens[at].text {
            "{" => {
                let close = closing(tokens, at).unwrap_or(tokens.len() - 1);
                let head = &tokens[first..at];
                let is_function = head.last().is_some_and(|token| token.text == ")")
                    || head.iter().any(|token| token.text == "fn");
                if is_function {
                    bodies.push(at..close);
                }
                at = close;
                first = at + 1;
            }
            ";" => first = at + 1,
            _ => {}
        }
        at += 1;
    }
    bodies
}
