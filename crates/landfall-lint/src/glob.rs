//! Globs of paths, by which settings select shaders. A matcher of its own, because the command's
//! globset would add regex-automata and aho-corasick to every program that uses this crate.
//!
//! `*` and `?` match within a directory, `**` across directories, `{a,b}` either alternative,
//! `[a-z]` one character of a set. A pattern matches a whole path, or its end from some directory
//! on: `lights/*.frag` matches `shaders/lights/point.frag`. An empty pattern matches every path.

/// The most alternatives that a pattern expands to; further ones are ignored.
const MOST_ALTERNATIVES: usize = 256;

/// Returns whether a path matches a pattern.
pub fn matches(pattern: &str, path: &str) -> bool {
    let pattern = pattern.trim().trim_start_matches("./");
    if pattern.is_empty() {
        return true;
    }
    let path: String = path.replace('\\', "/");
    let path = path.trim_start_matches("./");
    let mut patterns = vec![pattern.to_string()];
    let mut at = 0;
    while let Some(alternatives) = patterns.get(at).and_then(|p| expand(p)) {
        patterns.splice(at..=at, alternatives);
        if patterns.len() > MOST_ALTERNATIVES {
            break;
        }
        while at < patterns.len() && !patterns[at].contains('{') {
            at += 1;
        }
    }
    let starts = std::iter::once(0).chain(path.match_indices('/').map(|(at, _)| at + 1));
    let ends: Vec<Vec<char>> = starts.map(|at| path[at..].chars().collect()).collect();
    patterns.iter().any(|pattern| {
        let pattern: Vec<char> = pattern.chars().collect();
        ends.iter().any(|end| matches_whole(&pattern, end))
    })
}

/// Returns the patterns that the first `{a,b}` expands to.
fn expand(pattern: &str) -> Option<Vec<String>> {
    let open = pattern.find('{')?;
    let mut depth = 0;
    let mut commas = vec![open];
    for (at, sign) in pattern.char_indices().skip_while(|(at, _)| *at < open) {
        match sign {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => commas.push(at),
            _ => {}
        }
        if depth == 0 {
            commas.push(at);
            let (before, after) = (&pattern[..open], &pattern[at + 1..]);
            let parts = commas.windows(2).map(|pair| &pattern[pair[0] + 1..pair[1]]);
            return Some(parts.map(|part| format!("{before}{part}{after}")).collect());
        }
    }
    None
}

/// Returns whether the whole path matches, in time bounded by the product of the two lengths,
/// because the match of each star only grows.
fn matches_whole(pattern: &[char], path: &[char]) -> bool {
    // For each place in the path, whether the pattern up to here can end there.
    let mut ends = vec![false; path.len() + 1];
    ends[0] = true;
    let mut at = 0;
    while at < pattern.len() {
        let mut next = vec![false; path.len() + 1];
        let sign = pattern[at];
        at += 1;
        if sign == '*' {
            let deep = pattern.get(at) == Some(&'*');
            // `**/` also stands for no directory at all.
            let mut skipped = None;
            if deep {
                at += 1;
                if pattern.get(at) == Some(&'/') {
                    at += 1;
                    skipped = Some(ends.clone());
                }
            }
            let mut reached = false;
            for (i, end) in ends.iter().enumerate() {
                if i > 0 && path[i - 1] == '/' && !deep {
                    reached = false;
                }
                reached |= *end;
                next[i] = reached && (skipped.is_none() || i > 0 && path[i - 1] == '/');
            }
            if let Some(skipped) = skipped {
                next.iter_mut().zip(skipped).for_each(|(next, was)| *next |= was);
            }
            ends = next;
            continue;
        }
        let set = (sign == '[').then(|| class(&pattern[at..])).flatten();
        if let Some(class) = &set {
            at += class.length;
        }
        for (i, &found) in path.iter().enumerate() {
            let fits = match (&set, sign) {
                (Some(class), _) => found != '/' && class.holds(found),
                (None, '?') => found != '/',
                (None, sign) => sign == found,
            };
            next[i + 1] = ends[i] && fits;
        }
        ends = next;
    }
    ends[path.len()]
}

/// `a-z]` behind a `[`.
struct Class {
    ranges: Vec<(char, char)>,
    negated: bool,
    length: usize,
}

impl Class {
    fn holds(&self, sign: char) -> bool {
        self.ranges.iter().any(|(from, to)| (*from..=*to).contains(&sign)) != self.negated
    }
}

fn class(pattern: &[char]) -> Option<Class> {
    let close = pattern.iter().skip(1).position(|&sign| sign == ']')? + 1;
    let negated = matches!(pattern[0], '!' | '^');
    let inside = &pattern[usize::from(negated)..close];
    let mut ranges = Vec::new();
    let mut at = 0;
    while at < inside.len() {
        if inside.get(at + 1) == Some(&'-') && at + 2 < inside.len() {
            ranges.push((inside[at], inside[at + 2]));
            at += 3;
        } else {
            ranges.push((inside[at], inside[at]));
            at += 1;
        }
    }
    Some(Class { ranges, negated, length: close + 1 })
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn stars_stay_in_a_directory_and_double_stars_do_not() {
        assert!(matches("shaders/*.frag", "shaders/a.frag"));
        assert!(!matches("shaders/*.frag", "shaders/lights/a.frag"));
        assert!(matches("shaders/**/*.frag", "shaders/lights/deep/a.frag"));
        assert!(matches("shaders/**/*.frag", "shaders/a.frag"));
        assert!(matches("**", "shaders/a.frag"));
        assert!(!matches("shaders/**/*.frag", "shaders/a.vert"));
    }

    #[test]
    fn a_pattern_matches_the_end_of_a_path() {
        assert!(matches("lights/*.frag", "shaders/lights/point.frag"));
        assert!(matches("*.frag", "/home/me/shaders/point.frag"));
        assert!(!matches("ghts/*.frag", "shaders/lights/point.frag"));
        assert!(matches("", "anything.wgsl"));
        assert!(matches("./a.frag", "./a.frag"));
    }

    #[test]
    fn alternatives_and_classes_are_expanded() {
        assert!(matches("*.{vert,frag}", "a.vert"));
        assert!(!matches("*.{vert,frag}", "a.comp"));
        assert!(matches("{a,b}_{1,2}.frag", "b_2.frag"));
        assert!(matches("light[0-9].frag", "light7.frag"));
        assert!(!matches("light[!0-9].frag", "light7.frag"));
        assert!(matches("a?.frag", "ab.frag"));
        assert!(!matches("a{b", "ab"));
    }

    #[test]
    fn many_stars_are_no_trap() {
        let path = "a".repeat(2000);
        assert!(!matches(&format!("{}b", "*a".repeat(200)), &path));
    }
}
