//! Edit distance between names, for suggestions.

/// Returns the known name closest to a misspelt one, if any is close.
pub fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    // One letter in short names, two in others: more would suggest names that have little in
    // common. Two names of one letter have nothing in common.
    let bound = match name.len() {
        0 | 1 => 0,
        2 | 3 => 1,
        _ => 2,
    };
    known
        .map(|other| (distance(name, other), other))
        .filter(|(distance, _)| *distance <= bound)
        .min()
        .map(|(_, other)| other)
}

/// Returns the help for a misspelt name, if a known one is close: "did you mean `x`?".
pub fn suggestion<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<String> {
    nearest(name, known).map(|near| format!("did you mean `{near}`?"))
}

/// Returns the edit distance of two names: letters inserted, deleted or replaced, ignoring case.
fn distance(a: &str, b: &str) -> usize {
    // Every letter of difference in length is an edit: such names are no suggestion in any case.
    if a.len().abs_diff(b.len()) > 2 {
        return usize::MAX;
    }
    let (a, b) = (a.to_ascii_lowercase().into_bytes(), b.to_ascii_lowercase().into_bytes());
    // Levenshtein's distance, row by row: `row` holds that of `a` up to letter i and each beginning
    // of `b`, `diagonal` that of both without their last letters.
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let change = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = change.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
