//! Domains in comments beside declarations: `float x; // in 0..1`, `vec3 n; // unit`, and `//
//! normal: unit, d in 0..100` above a function.
//!
//! Reads the text line by line; used by [`domain`](mod@super::domain).

use rustc_hash::FxHashMap;

use super::domain::{Domain, DomainError, ValueRange, range};
use super::input::Input;

/// The ranges in comments, by the enclosing structure or function (empty outside) and by name.
type StatedRanges = FxHashMap<(String, String), ValueRange>;

/// Adds the ranges in a shader's comments for the inputs of a function.
///
/// # Errors
/// A range that is empty or inverted.
pub(crate) fn add(
    domain: &mut Domain,
    text: &str,
    function: &str,
    inputs: &[Input],
) -> Result<(), DomainError> {
    let said = read(text)?;
    for (at, input) in inputs.iter().enumerate() {
        let name = input.path.rsplit('.').next().unwrap_or(&input.path);
        let name = name.split('[').next().unwrap_or(name).to_string();
        let of_member = input.member.as_ref().and_then(|key| said.get(key));
        // A member's range is stated at its structure; a parameter's at the function, or at a
        // global declaration.
        let plain = input.member.is_none();
        let within = of_member
            .or_else(|| plain.then(|| said.get(&(function.to_string(), name.clone())))?)
            .or_else(|| plain.then(|| said.get(&(String::new(), name)))?);
        match within {
            // In a comment beside a scalar, `unit` is prose.
            Some(ValueRange::Unit) if !input.is_vector() => {}
            Some(within) => domain.put(at, *within, input)?,
            None => {}
        }
    }
    Ok(())
}

fn read(text: &str) -> Result<StatedRanges, DomainError> {
    let mut said = StatedRanges::default();
    // The name of the enclosing structure, or of the function whose parameters are listed.
    let mut owner = String::new();
    let mut depth = 0usize;
    // The ranges in comments above the next function.
    let mut above: Vec<(String, ValueRange)> = Vec::new();
    for line in text.lines() {
        let (code, comment) = split(line);
        let trimmed = code.trim();
        if trimmed.is_empty() {
            for part in comment.split([',', ';']) {
                above.extend(named_range(part)?);
            }
            continue;
        }
        let words: Vec<&str> = identifiers(trimmed).collect();
        let starts_structure = depth == 0
            && words.first().is_some_and(|word| ["struct", "uniform", "layout"].contains(word))
            && trimmed.contains('{');
        let structure_below = depth == 0 && words.first() == Some(&"struct");
        if starts_structure || structure_below {
            let name = match words.first() {
                Some(&"struct") => words.get(1).copied().unwrap_or_default(),
                _ => words.last().copied().unwrap_or_default(),
            };
            owner = name.to_string();
        } else if depth == 0 && trimmed.contains('(') && !trimmed.starts_with("layout") {
            let before = trimmed.split('(').next().unwrap_or_default();
            owner = identifiers(before).last().unwrap_or_default().to_string();
            let open = owner.clone();
            said.extend(above.drain(..).map(|(name, within)| ((open.clone(), name), within)));
        }
        if let Some(within) = unnamed_range(comment)? {
            let name = declared(trimmed);
            if !name.is_empty() {
                said.insert((owner.clone(), name.to_string()), within);
            }
        }
        for part in comment.split([',', ';']) {
            if let Some((name, within)) = named_range(part)? {
                said.insert((owner.clone(), name), within);
            }
        }
        let opened = code.matches('{').count();
        depth = (depth + opened).saturating_sub(code.matches('}').count());
        // A structure or a function ends at its last brace, a declaration at its semicolon.
        let ends = depth == 0 && (code.contains('}') || code.contains(';'));
        if ends {
            owner.clear();
        }
        above.clear();
    }
    Ok(said)
}

/// Splits a line into code and comment.
fn split(line: &str) -> (&str, &str) {
    if let Some((code, comment)) = line.split_once("//") {
        return (code, comment.trim_start_matches(['/', '!']).trim());
    }
    match line.split_once("/*") {
        Some((code, rest)) => (code, rest.split("*/").next().unwrap_or_default().trim()),
        None => (line, ""),
    }
}

fn identifiers(code: &str) -> impl Iterator<Item = &str> {
    code.split(|c: char| !(c == '_' || c.is_alphanumeric())).filter(|word| !word.is_empty())
}

/// Returns the name a line declares: before the colon in WGSL, else the last word before `;`, `,`,
/// `)`.
fn declared(code: &str) -> &str {
    let code = code.split(['=', ';']).next().unwrap_or(code);
    let code = code.trim_end_matches([',', ')', '{', ' ', ']', '[']);
    if let Some((before, _)) = code.rsplit_once(':') {
        return identifiers(before).last().unwrap_or_default();
    }
    let code = code.split('[').next().unwrap_or(code);
    identifiers(code).last().unwrap_or_default()
}

/// Parses a comment that is only a range: `in 0..1`, `unit`, `cos`.
fn unnamed_range(comment: &str) -> Result<Option<ValueRange>, DomainError> {
    let first = comment.split([',', ';']).next().unwrap_or_default().trim();
    let word = first.trim_end_matches('.');
    match word {
        "unit" | "unit vector" => return Ok(Some(ValueRange::Unit)),
        "position" => return Ok(Some(ValueRange::Position)),
        "color" | "colour" => return Ok(Some(ValueRange::Color)),
        "cos" | "cosine" => return Ok(Some(ValueRange::Cosine)),
        _ => {}
    }
    match first.strip_prefix("in ") {
        Some(rest) => bounds(first, rest),
        None => Ok(None),
    }
}

/// Parses `name: unit` or `name in 0..1`.
fn named_range(part: &str) -> Result<Option<(String, ValueRange)>, DomainError> {
    let part = part.trim();
    if let Some((name, rest)) = part.split_once(" in ") {
        let is_name =
            identifiers(name).count() == 1 && name.trim() == identifiers(name).next().unwrap_or("");
        if is_name {
            return Ok(bounds(name, rest)?.map(|within| (name.trim().to_string(), within)));
        }
    }
    if let Some((name, rest)) = part.split_once(':') {
        let name = name.trim();
        if identifiers(name).next() == Some(name) {
            return Ok(unnamed_range(rest.trim())?.map(|within| (name.to_string(), within)));
        }
    }
    Ok(None)
}

/// Parses `0..1`.
fn bounds(about: &str, text: &str) -> Result<Option<ValueRange>, DomainError> {
    let Some((low, rest)) = text.split_once("..") else { return Ok(None) };
    let rest = rest.trim_start_matches(['=', ' ']);
    let end = rest
        .char_indices()
        .find(|(i, c)| {
            !(c.is_ascii_digit()
                || "+-eE".contains(*c)
                || *c == '.' && !rest[i + 1..].starts_with('.'))
        })
        .map_or(rest.len(), |(i, _)| i);
    let high = rest[..end].trim_end_matches('.');
    match (low.trim().parse::<f64>(), high.parse::<f64>()) {
        (Ok(low), Ok(high)) => range(about.trim(), low, high).map(Some),
        _ => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_beside_members_and_above_functions_are_read() {
        let text = "\
struct Light {
    vec3 position;
    float cutOff;   // cos
    float linear;   // in 0..1
};
uniform float shininess; // in 1..256, whole
// Attenuated light.
// normal: unit, d in 0..100
vec3 lit(Light light, vec3 normal, float d) {
    float near = 1.0; // in 3..4
}
";
        let said = read(text).expect("no range is wrong");
        let of =
            |owner: &str, name: &str| said.get(&(owner.to_string(), name.to_string())).copied();
        assert_eq!(of("Light", "cutOff"), Some(ValueRange::Cosine));
        assert_eq!(of("Light", "linear"), Some(ValueRange::Range(0.0, 1.0)));
        assert_eq!(of("Light", "position"), None);
        assert_eq!(of("", "shininess"), Some(ValueRange::Range(1.0, 256.0)));
        assert_eq!(of("lit", "normal"), Some(ValueRange::Unit));
        assert_eq!(of("lit", "d"), Some(ValueRange::Range(0.0, 100.0)));
    }

    #[test]
    fn an_inverted_range_in_a_comment_is_refused() {
        let refused = read("float f(float x) { // x in 2..1\n").expect_err("2 is above 1");
        assert!(refused.message.contains("from 2 to 1 is inverted"), "{}", refused.message);
    }
}
