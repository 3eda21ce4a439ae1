//! Text inside XML: JUnit reports and SVG pictures.

/// Text for an attribute or between tags, of characters XML 1.0 has (its production 2).
pub fn escaped(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => result.push_str("&amp;"),
            '<' => result.push_str("&lt;"),
            '>' => result.push_str("&gt;"),
            '"' => result.push_str("&quot;"),
            // A reader turns them into spaces in an attribute, and \r into \n anywhere.
            '\t' | '\n' | '\r' => result.push_str(&format!("&#{};", u32::from(c))),
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => result.push('\u{fffd}'),
            c => result.push(c),
        }
    }
    result
}
