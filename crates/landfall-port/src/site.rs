//! The place of the new declarations: after the types they use, before their first use, and
//! outside conditions if possible.

use rustc_hash::FxHashSet;

use super::edits::Edits;
use super::shader::{Shader, refusal, span};
use super::uniforms::Gathered;
use landfall_layout::Diagnostic;

/// The byte at which to insert the declarations of `needed`.
pub(super) fn find(
    shader: &Shader<'_>,
    gathered: &Gathered,
    needed: &[String],
) -> Result<usize, Diagnostic> {
    // New declarations come before the first function that uses one; else where the last of the
    // original ones was.
    let limit = first_use(shader, needed);
    let wanted = match gathered.last {
        Some(end) => shader.next_line(end),
        None => limit.unwrap_or(shader.text.len()),
    };
    let most = limit.unwrap_or(shader.text.len());
    let mut at = wanted.max(gathered.after).min(most);
    // Within a condition the declarations would be missing where it does not hold.
    if let Some(after) = after_condition(shader, at).filter(|after| *after <= most) {
        at = after;
    }
    if at >= gathered.after {
        return Ok(at);
    }
    let first = needed.first().map_or("", String::as_str);
    let message = format!("`{first}` is used before the types of all loose uniforms are declared");
    Err(refusal(span(most..most), message)
        .with_note("one block holds all loose uniforms, so it must follow all their types")
        .with_help("move the structures above the first function"))
}

/// Inserts whole lines at a byte.
pub(super) fn insert(shader: &Shader<'_>, at: usize, mut text: String, edits: &mut Edits) {
    if at > 0 && !shader.text[..at].ends_with('\n') {
        text.insert(0, '\n');
    }
    // The text's own line ends.
    if shader.text.contains("\r\n") {
        text = text.replace("\r\n", "\n").replace('\n', "\r\n");
    }
    edits.insert_lines(at, text);
}

/// The start of the first function that uses one of the names, with the comments above it.
fn first_use(shader: &Shader<'_>, needed: &[String]) -> Option<usize> {
    let needed: FxHashSet<&str> = needed.iter().map(String::as_str).collect();
    let uses = |word: &str| needed.contains(word);
    // A macro that uses one of them may be used in any function.
    let in_macro =
        shader.words().any(|at| shader.raw.tokens[at].directive.is_some() && uses(shader.word(at)));
    let function = shader.functions().find(|function| {
        let body = function.body_tokens.clone();
        body.is_some_and(|body| in_macro || shader.code[body].iter().any(|t| uses(t.text)))
    })?;
    Some(shader.lines_of(&function.tokens).bytes.start)
}

/// The line after the outermost `#endif` around a byte; `None` outside conditions.
// Directives before the byte tell how deep it is; the first one after it that closes the outermost
// condition is the answer.
fn after_condition(shader: &Shader<'_>, at: usize) -> Option<usize> {
    let mut depth = 0usize;
    let mut inside = false;
    for directive in shader.directives() {
        let start = shader.raw.tokens[directive.start].start;
        let word = if directive.len() > 1 { shader.word(directive.start + 1) } else { "" };
        if start >= at && depth == 0 {
            return None;
        }
        inside |= start >= at;
        match word {
            "if" | "ifdef" | "ifndef" => depth += 1,
            "endif" => depth = depth.saturating_sub(1),
            _ => {}
        }
        if inside && depth == 0 {
            return Some(shader.next_line(start));
        }
    }
    None
}
