//! The shader's comments as C comments that no compiler warns about.

use landfall_layout::ShaderLayout;
use landfall_layout::source::Span;
use landfall_layout::text::escape::is_bidi;

/// The lines of comments, without their markers.
pub(crate) fn lines(spans: &[Span], shader: &ShaderLayout) -> Vec<String> {
    let mut lines = Vec::new();
    for span in spans {
        let text = shader.files.text(*span);
        let (text, block) = match text.strip_prefix("/*") {
            Some(rest) => (rest.strip_suffix("*/").unwrap_or(rest), true),
            None => (text.trim_start_matches('/').trim_start_matches('!'), false),
        };
        for line in text.lines() {
            let inside = line.trim();
            let line = safe(if block { inside.trim_start_matches('*').trim() } else { inside });
            if !line.is_empty() {
                lines.push(line);
            }
        }
    }
    lines
}

/// Escapes text for a C comment: no comment delimiters, trigraphs, line continuations, control or
/// bidirectional characters.
pub(crate) fn safe(text: &str) -> String {
    let text: String = text.chars().filter(|c| !c.is_control() && !is_bidi(*c)).collect();
    // `??/` and the like are trigraphs (C11 §5.2.1.1); `\` at the end of a line would continue a
    // line comment.
    let mut text = text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?");
    while text.ends_with('\\') {
        text.pop();
    }
    text.trim().to_string()
}

/// A C comment of `lines`; empty if there are none.
pub(super) fn block(lines: &[String], indent: &str) -> String {
    match lines {
        [] => String::new(),
        [line] => format!("{indent}/* {line} */\n"),
        [first, rest @ ..] => {
            let mut text = format!("{indent}/* {first}\n");
            for line in rest {
                text.push_str(&format!("{indent} * {line}\n"));
            }
            text.push_str(&format!("{indent} */\n"));
            text
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_comment_ends_it() {
        assert_eq!(safe("a */ b /* c ??/ d\u{202e} \\"), "a * / b / * c ? ?/ d");
        assert_eq!(block(&["a".to_string(), "b".to_string()], "  "), "  /* a\n   * b\n   */\n");
    }
}
