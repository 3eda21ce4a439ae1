//! Counts in text for people.
//!
//! Every count has thousands separators. What a user may type again has none: bytes by their
//! offsets, strides, indices, lines, seeds and code; nor has what programs read.

/// Formats a number of bytes: `1 byte`, `6,160 bytes`.
pub fn bytes(n: u64) -> String {
    numbered(n, "byte")
}

/// As [`numbered`], of what a program holds: `1 block`, `13 blocks`.
pub fn counted(n: usize, noun: &str) -> String {
    numbered(n as u64, noun)
}

/// Formats a count of a noun: `6,160 fragments`.
pub fn numbered(n: u64, noun: &str) -> String {
    format!("{} {noun}{}", number(n), if n == 1 { "" } else { "s" })
}

/// Formats a count for people, with thousands separators: `6,160`.
pub fn number(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (at, digit) in digits.char_indices() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
