//! The words a name is made of: `u_outerCutOff` says *outer* and *cutoff*.
//!
//! Feeds [`roles`](super::roles), which knows what they mean.

use landfall_layout::text::word_list::WordList;

/// Words that are written together with others: `lightpos`, `conedir`.
const TOGETHER: WordList = WordList(
    "ambient angle axis color colour cone count cut cutoff diffuse dir direction directional \
     inner intensity lamp light lights num off outer point points pos position range radius \
     specular spot sun view",
);

/// The words of a name in lower case, in order; prefixes such as `u_` and numbers are left out.
pub fn identifier_words(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut words = Vec::new();
    let mut word = String::new();
    for (i, &c) in letters.iter().enumerate() {
        if !c.is_alphabetic() {
            end(&mut word, &mut words);
            continue;
        }
        // lightPos: an upper letter after a lower one begins a word. UVMap: so does the last upper
        // letter of a run before a lower one.
        let after_lower = i > 0 && letters[i - 1].is_lowercase();
        let before_lower = letters.get(i + 1).is_some_and(|next| next.is_lowercase());
        let after_upper = i > 0 && letters[i - 1].is_uppercase();
        if c.is_uppercase() && (after_lower || (after_upper && before_lower)) {
            end(&mut word, &mut words);
        }
        word.extend(c.to_lowercase());
    }
    end(&mut word, &mut words);
    // A letter before others says what the variable is, not what it holds.
    // `u_`, `m_`, `v_`.
    if words.len() > 1 && words[0].len() == 1 {
        words.remove(0);
    }
    joined(words)
}

fn end(word: &mut String, words: &mut Vec<String>) {
    let word = std::mem::take(word);
    if word.is_empty() {
        return;
    }
    // `cutoff` is a word itself, although `cut` and `off` are.
    if TOGETHER.contains(&word) {
        words.push(word);
        return;
    }
    // `lightpos` is split in two, if both halves are known words.
    let split = TOGETHER.iter().find_map(|first| {
        let rest = word.strip_prefix(first)?;
        TOGETHER.contains(rest).then(|| [first.to_string(), rest.to_string()])
    });
    match split {
        Some(parts) => words.extend(parts),
        None => words.push(word),
    }
}

/// `cut off` is one word.
fn joined(words: Vec<String>) -> Vec<String> {
    let mut result: Vec<String> = Vec::with_capacity(words.len());
    for word in words {
        match result.last_mut() {
            Some(last) if last == "cut" && word == "off" => last.push_str("off"),
            Some(_) | None => result.push(word),
        }
    }
    result
}
