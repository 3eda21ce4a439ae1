use super::*;

#[test]
fn stars_stay_in_a_directory_and_double_stars_do_not() {
    assert!(matches("shaders/*.frag", "shaders/a.frag"));
    assert!(!matches("shaders/*.frag", "shaders/lights/a.frag"));
    assert!(matches("shaders/**/*.frag", "shaders/lights/deep/a.frag"));
    assert!(matches("shaders/**/*.frag", "shaders/a.frag"));
    assert!(matches("**", "shaders/a.frag"));
    assert!(!matches("shaders/**/*.frag", "shaders/a.vert"));
    assert!(matches("shaders**.frag", "shaders/lights/a.frag"));
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
    assert!(matches("{a,{b,c{d,}}}", "c") && !matches("{a,{b,c{d,}}}", "d"));
    assert!(matches("light[0-9].frag", "light7.frag"));
    assert!(!matches("light[!0-9].frag", "light7.frag"));
    assert!(matches("light[]-].frag", "light-.frag"));
    assert!(matches("a?.frag", "a\u{e4}.frag"));
    assert!(matches("\\[a\\]\\*[\\]].frag", "[a]*].frag"));
}

#[test]
fn a_directory_contains_what_is_below_it() {
    let glob = Glob::new("gen/*").unwrap();
    assert!(glob.contains("gen/a") && glob.contains("gen/a/b") && !glob.matches("gen/a/b"));
    assert!(!glob.contains("gen") && !glob.contains("generated/a"));
}

#[test]
fn texts_that_are_no_globs_are_refused() {
    let error = |text: &str| Glob::new(text).expect_err(text);
    assert_eq!(error("a["), GlobError::OpenClass);
    assert_eq!(error("[]"), GlobError::OpenClass);
    assert_eq!(error("{a"), GlobError::OpenBrace);
    assert_eq!(error("a}"), GlobError::UnopenedBrace);
    assert_eq!(error("[b-a]"), GlobError::EmptyRange('b', 'a'));
    assert_eq!(error(&"{".repeat(17)), GlobError::TooDeep);
    assert_eq!(error(&"a".repeat(4097)), GlobError::TooLong);
    assert_eq!(error(&"{a,b}".repeat(9)), GlobError::TooManyAlternatives);
    assert_eq!(error(&("{a,b}".repeat(8) + &"a".repeat(4000))), GlobError::TooManyAlternatives);
    assert!(!cfg!(unix) || error("a\\") == GlobError::TrailingBackslash);
}

#[test]
fn an_escaped_text_matches_itself_alone() {
    for text in ["a[b", "{a,b}", "*?", "a]}", "[!a]", "."] {
        let glob = Glob::new(&escape(text)).expect("escaped");
        assert!(glob.matches(text) && !glob.matches("a") && !glob.matches("ab"), "{text}");
    }
}

#[test]
fn many_stars_are_no_trap() {
    let path = "a".repeat(4000);
    assert!(!matches(&format!("{}b", "*a".repeat(2000)), &path));
    assert!(!matches(&format!("{}b", "**a".repeat(1300)), &path));
    let path = ("a".repeat(250) + "/").repeat(15);
    assert!(!matches(&format!("**a*{}b", "a".repeat(125)), &path));
    let path = "a/".repeat(2000) + "a";
    assert!(!matches(&format!("{}*b", "**/a*".repeat(800)), &path));
}

/// A pattern tried in all ways, as the definition of its signs says.
fn matches_slowly(pattern: &[GlobToken], path: &str) -> bool {
    let Some((first, rest)) = pattern.split_first() else { return path.is_empty() };
    let ends = path.char_indices().map(|(at, _)| at).chain([path.len()]);
    match first {
        GlobToken::Star => {
            let mut ends = ends.take_while(|at| !path[..*at].contains('/'));
            ends.any(|at| matches_slowly(rest, &path[at..]))
        }
        GlobToken::DeepStar => ends.into_iter().any(|at| matches_slowly(rest, &path[at..])),
        GlobToken::Directories => {
            let mut ends = ends.filter(|at| *at == 0 || path[..*at].ends_with('/'));
            ends.any(|at| matches_slowly(rest, &path[at..]))
        }
        single => {
            single.length_in(path).is_some_and(|length| matches_slowly(rest, &path[length..]))
        }
    }
}

#[test]
fn matches_are_those_of_all_ways_to_match() {
    let mut seed = 7u32;
    let mut random = |below: usize| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 16) as usize % below
    };
    let mut found = [0, 0];
    for _ in 0..200_000 {
        let signs = ["a", "b", "/", "*", "*", "**", "**/", "/**/", "?", "[a/]"];
        let text: String = (0..random(8)).map(|_| signs[random(signs.len())]).collect();
        let path: String = (0..random(8)).map(|_| ["a", "b", "/"][random(3)]).collect();
        let Ok(glob) = Glob::new(&text) else { continue };
        let whole = matches_slowly(&glob.alternatives[0].tokens, &path);
        assert_eq!(glob.matches(&path), whole, "`{text}` on `{path}`");
        let mut ends = path.match_indices('/').map(|(at, _)| at);
        let inside = ends.any(|at| matches_slowly(&glob.alternatives[0].tokens, &path[..at]));
        assert_eq!(glob.contains(&path), whole || inside, "`{text}` above `{path}`");
        found[usize::from(whole)] += 1;
    }
    assert!(found.iter().all(|count| *count > 5_000), "{found:?}");
}
