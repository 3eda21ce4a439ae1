//! Text that cannot move the cursor, colour what follows or run backwards, for formats people
//! see: file names and shaders may be anybody's.

/// The text with a picture for each control character but the end of a line.
pub(super) fn visible(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for c in text.replace("\r\n", "\n").chars() {
        match c {
            '\n' => result.push('\n'),
            '\t' => result.push_str("    "),
            // Unicode has a picture of each.
            '\0'..='\u{1f}' => result.extend(char::from_u32(0x2400 + u32::from(c))),
            '\u{7f}' => result.push('\u{2421}'),
            // Those that turn the direction of text: UAX #9, section 2.
            '\u{80}'..='\u{9f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
                result.push('\u{fffd}');
            }
            c => result.push(c),
        }
    }
    result
}

/// The same in one line.
pub fn in_one_line(text: &str) -> String {
    let lines = text.split(['\r', '\n']).map(str::trim).filter(|line| !line.is_empty());
    visible(&lines.collect::<Vec<_>>().join(" "))
}
