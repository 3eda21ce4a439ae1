//! Escaping of untrusted text, such as file names, comments and driver logs, for each output
//! medium.
//!
//! Terminals act on control characters and reorder text at bidi marks; CI logs act on lines such as
//! `::error::`; Markdown, HTML and SVG have markup; rustc rejects bidi marks in comments and
//! strings.

use std::borrow::Cow;

use memchr::memmem;

/// Whether a text contains styles (SGR of ECMA-48) that landfall emitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Styles {
    /// Styles are landfall's own and are kept.
    Kept,
    /// Styles are not landfall's own and are made visible.
    Shown,
}

/// Whether a character changes the direction of text (UAX #9, section 2), or is one of the two line
/// separators that only some programs honour.
pub fn is_bidi(c: char) -> bool {
    matches!(
        c,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    ) || matches!(c, '\u{2028}' | '\u{2029}')
}

/// Whether a terminal acts on the character instead of displaying it.
fn is_hostile(c: char) -> bool {
    if c.is_ascii() {
        c.is_ascii_control()
    } else {
        c.is_control() || is_bidi(c) || is_invisible(c)
    }
}

/// Whether a text has no character that [`is_hostile`] finds, other than line ends and tabs. Most
/// lines are ASCII, which is found without decoding them.
fn is_plain(text: &str) -> bool {
    let plain = |byte: u8| matches!(byte, b' '..=b'~' | b'\t');
    text.split('\n').all(|line| {
        // Without an early end, several bytes are compared at a time.
        line.bytes().fold(true, |all, byte| all & plain(byte))
            || !line.contains(|c| c != '\t' && is_hostile(c))
    })
}

/// Whether a character has no width, so that two names may look the same.
fn is_invisible(c: char) -> bool {
    matches!(
        c,
        '\u{ad}' | '\u{34f}' | '\u{115f}' | '\u{1160}' | '\u{180e}' | '\u{200b}' | '\u{feff}'
    ) || matches!(
        c,
        '\u{2060}'..='\u{2064}' | '\u{3164}' | '\u{ffa0}' | '\u{e0000}'..='\u{e007f}'
    )
}

/// Returns a visible replacement for a character that has an effect.
fn picture(c: char) -> char {
    match c {
        // Unicode has a picture of each control character.
        '\0'..='\u{1f}' => char::from_u32(0x2400 + u32::from(c)).unwrap_or('\u{fffd}'),
        '\u{7f}' => '\u{2421}',
        _ => '\u{fffd}',
    }
}

/// Escapes multi-line text for a terminal: pictures for control characters except line ends, spaces
/// for tabs.
pub fn visible(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for c in text.replace("\r\n", "\n").chars() {
        match c {
            '\n' => result.push('\n'),
            '\t' => result.push_str("    "),
            c if is_hostile(c) => result.push(picture(c)),
            c => result.push(c),
        }
    }
    result
}

/// Escapes text for a terminal and joins its lines into one.
pub fn in_one_line(text: &str) -> String {
    let lines = text.split(['\r', '\n']).map(str::trim).filter(|line| !line.is_empty());
    visible(&lines.collect::<Vec<_>>().join(" "))
}

/// Escapes a name, such as a file's, into one line.
pub fn name(text: &str) -> Cow<'_, str> {
    match text.contains(is_hostile) {
        true => text.chars().map(|c| if is_hostile(c) { picture(c) } else { c }).collect(),
        false => Cow::Borrowed(text),
    }
}

/// Escapes a complete output: nothing in it moves the cursor or reorders text, and no line is a
/// command to a CI runner.
pub fn output(text: &str, styles: Styles) -> Cow<'_, str> {
    match commands(text) {
        Cow::Borrowed(text) => controls(text, styles),
        Cow::Owned(text) => Cow::Owned(controls(&text, styles).into_owned()),
    }
}

/// Escapes control characters, except for kept styles.
fn controls(text: &str, styles: Styles) -> Cow<'_, str> {
    let shown = |c: char| matches!(c, '\n' | '\t') || !is_hostile(c);
    if is_plain(text) {
        return Cow::Borrowed(text);
    }
    let mut result = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        // A style of landfall's own is taken as a whole, up to its `m`.
        let style = if styles == Styles::Kept { style(rest) } else { None };
        let len = style.unwrap_or(c.len_utf8());
        match style {
            Some(len) => result.push_str(&rest[..len]),
            None if shown(c) => result.push(c),
            // CR before LF has no effect of its own.
            None if rest.starts_with("\r\n") => {}
            None => result.push(picture(c)),
        }
        rest = &rest[len..];
    }
    Cow::Owned(result)
}

/// Returns the length of the style (SGR of ECMA-48) that a text begins with.
fn style(text: &str) -> Option<usize> {
    let inside = text.strip_prefix("\x1b[")?;
    let end = inside.find(|c: char| !c.is_ascii_digit() && c != ';')?;
    inside[end..].starts_with('m').then_some(end + 3)
}

/// Defuses lines that the runners of GitHub, Azure and TeamCity would take for commands:
/// `::error::` at their start, `##[error]` and `##vso[` anywhere. A leading `::` becomes a path,
/// which is what it mostly is.
fn commands(text: &str) -> Cow<'_, str> {
    let bytes = text.as_bytes();
    // A loop over all, which is vectorized, and not memchr, as in `source::normalized`.
    let pairs = bytes.iter().zip(bytes.get(1..).unwrap_or_default());
    let is_mark = |a: u8, b: u8| (a == b) & ((a == b':') | (a == b'#'));
    if !pairs.fold(false, |found, (a, b)| found | is_mark(*a, *b)) {
        return Cow::Borrowed(text);
    }
    if !text.lines().any(is_command) {
        return Cow::Borrowed(text);
    }
    let mut result = String::with_capacity(text.len() + 16);
    for line in text.split_inclusive('\n') {
        let mut line = Cow::Borrowed(line);
        if let Some(at) = bracket(&line) {
            let (before, after) = line.split_at(at);
            // `#` twice is what runners look for: a small number sign looks much the same.
            line = Cow::Owned(before.to_string() + &after.replace("##", "#\u{fe5f}"));
        }
        let at = command_start(&line);
        // ` ::: shaders/a.vert:2:24` opens an excerpt of another file: not a command without a
        // second `::`.
        let excerpt = line[at..].strip_prefix("::: ").is_some_and(|rest| !rest.contains("::"));
        match line[at..].starts_with("::") && !excerpt {
            true => {
                result.push_str(&line[..at]);
                result.push_str("./");
                result.push_str(&line[at..]);
            }
            false => result.push_str(&line),
        }
    }
    Cow::Owned(result)
}

fn is_command(line: &str) -> bool {
    line[command_start(line)..].starts_with("::") || bracket(line).is_some()
}

/// Returns the offset of a line's text after blanks and styles.
fn command_start(line: &str) -> usize {
    let mut at = 0;
    loop {
        let rest = &line[at..];
        match rest.chars().next() {
            Some('\x1b') => match style(rest) {
                Some(len) => at += len,
                None => return at,
            },
            Some(c) if c != '\n' && (c.is_whitespace() || is_hostile(c)) => at += c.len_utf8(),
            Some(_) | None => return at,
        }
    }
}

/// Returns the offset of `##[` or `##word[`.
fn bracket(line: &str) -> Option<usize> {
    line.match_indices("##").map(|(at, _)| at).find(|at| {
        let rest = line[at + 2..].trim_start_matches(|c: char| c.is_ascii_alphanumeric());
        rest.starts_with('[')
    })
}

/// Escapes JSON text, where only strings can hold such characters: the values stay the same,
/// without characters that a terminal acts on and without commands.
pub fn json(text: &str) -> Cow<'_, str> {
    // Serialisers have escaped all control characters of ASCII.
    let hostile = |c: char| c > '\u{7e}' && is_hostile(c);
    let shown = is_plain(text) || !text.contains(hostile);
    if shown && memmem::find(text.as_bytes(), b"##").is_none() {
        return Cow::Borrowed(text);
    }
    let mut result = String::with_capacity(text.len() + 16);
    // `\u0023` is `#` to every reader of JSON.
    for c in text.replace("##", "#\\u0023").chars() {
        match hostile(c) {
            true => result.push_str(&format!("\\u{:04x}", u32::from(c))),
            false => result.push(c),
        }
    }
    Cow::Owned(result)
}

/// Escapes text for Markdown and HTML.
pub fn markdown(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' => result.push_str("<br>"),
            '\r' => {}
            c if is_hostile(c) => result.push('\u{fffd}'),
            '\\' | '`' | '|' | '<' | '>' | '&' | '*' | '_' | '[' | ']' | '~' | '#' | '!' | '$' => {
                result.push_str(&format!("&#{};", u32::from(c)));
            }
            c => result.push(c),
        }
    }
    result
}

/// Formats code for Markdown, also inside a table.
pub fn markdown_code(text: &str) -> String {
    // In a code span a backslash is literal, even before a pipe that would end the cell.
    let simple = !text.contains(['`', '|', '\\']) && !text.contains(is_hostile);
    match text.trim() {
        "" => markdown(text),
        trimmed if simple && trimmed == text => format!("`{text}`"),
        _ => format!("<code>{}</code>", markdown(&name(text))),
    }
}

/// Formats a name for Markdown without a code span; a plain name is unchanged.
pub(crate) fn markdown_name(text: &str) -> Cow<'_, str> {
    let plain = |c: char| c.is_alphanumeric() || " _-./+,@=():".contains(c);
    match text.chars().all(plain) {
        true => Cow::Borrowed(text),
        false => Cow::Owned(markdown(&name(text))),
    }
}

/// Escapes text for XML, HTML and SVG, between tags or in an attribute; characters outside XML
/// 1.0's production 2 are replaced.
pub fn xml(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => result.push_str("&amp;"),
            '<' => result.push_str("&lt;"),
            '>' => result.push_str("&gt;"),
            '"' => result.push_str("&quot;"),
            // XML 1.0 §3.3.3, §2.11: a parser reads them as spaces in an attribute, and CR as LF.
            '\t' | '\n' | '\r' => result.push_str(&format!("&#{};", u32::from(c))),
            '\u{fffe}' | '\u{ffff}' => result.push('\u{fffd}'),
            c if is_hostile(c) => result.push('\u{fffd}'),
            c => result.push(c),
        }
    }
    result
}

/// Escapes text for a comment of generated Rust or C, in one line: rustc rejects bidi marks there
/// (`text_direction_codepoint_in_comment`).
pub fn comment(text: &str) -> String {
    name(text).replace("*/", "* /").replace("/*", "/ *").replace('`', "_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_character_acts_on_a_terminal() {
        assert_eq!(name("a\x1b[2J\n\u{9b}\u{202e}b"), "a␛[2J␊\u{fffd}\u{fffd}b");
        assert_eq!(name("ä/b c.frag"), "ä/b c.frag");
        let styled = "\x1b[1mbold\x1b[0m \x1b[2Jgone\u{2066}\n";
        assert_eq!(output(styled, Styles::Kept), "\x1b[1mbold\x1b[0m ␛[2Jgone\u{fffd}\n");
        assert_eq!(output(styled, Styles::Shown), "␛[1mbold␛[0m ␛[2Jgone\u{fffd}\n");
        assert!(matches!(output("a\tb\nä", Styles::Shown), Cow::Borrowed(_)));
    }

    #[test]
    fn no_line_is_a_command() {
        for (text, safe) in [
            ("::error::x\n", "./::error::x\n"),
            ("a\n  ::debug::x", "a\n  ./::debug::x"),
            ("a ##[error]b ##vso[task]", "a #\u{fe5f}[error]b #\u{fe5f}vso[task]"),
            ("a::b ## c", "a::b ## c"),
            (" ::: shaders/copy.vert:2:24\n", " ::: shaders/copy.vert:2:24\n"),
            ("::: a::error::x", "./::: a::error::x"),
        ] {
            assert_eq!(output(text, Styles::Shown), safe);
        }
        let painted = output("\x1b[1m::error::x\x1b[0m\n", Styles::Kept);
        assert_eq!(painted, "\x1b[1m./::error::x\x1b[0m\n");
    }

    #[test]
    fn json_keeps_its_values() {
        let text = "{\"a\u{202e}\": \"##[error]\u{9b}ä\"}";
        let safe = json(text);
        assert!(safe.chars().all(|c| !is_hostile(c)) && !safe.contains("##"));
        let value = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
        assert_eq!(value(&safe), value(text));
    }

    #[test]
    fn markdown_and_xml_take_it_for_text() {
        assert_eq!(markdown_code("a.frag"), "`a.frag`");
        assert_eq!(markdown_code("a`<b>\n|"), "<code>a&#96;&#60;b&#62;␊&#124;</code>");
        assert_eq!(markdown_name("lights/point_1.frag"), "lights/point_1.frag");
        assert_eq!(markdown_name("<b>"), "&#60;b&#62;");
        assert_eq!(xml("<a b=\"\u{202e}\x1b&"), "&lt;a b=&quot;\u{fffd}\u{fffd}&amp;");
        assert_eq!(comment("a */ `b`\u{202e}\n"), "a * / _b_\u{fffd}␊");
    }
}
