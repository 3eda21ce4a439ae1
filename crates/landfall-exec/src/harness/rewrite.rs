//! Rewrites the user's GLSL so that a new `main` can fill the inputs of its stage: inputs,
//! built-in ones too, and selected blocks become variables, and the old `main` a function.
//!
//! Everything else is unchanged; includes are inlined and macros expanded first, so that a
//! declaration made by a macro is found. Used by [`fragments`](super::fragments) and
//! [`call`](super::call).

mod declarator;

use std::fmt::Write as _;
use std::sync::Arc;

use rustc_hash::FxHashSet;

use landfall_layout::source::{ReadOptions, Source};
use landfall_layout::syntax::glsl::ast::Item;
use landfall_layout::syntax::glsl::lexer::Kind;
pub use landfall_layout::syntax::glsl::raw;
pub use landfall_layout::syntax::glsl::raw::{RawText, RawToken};

use declarator::{RewrittenDeclarator, elements, split};

/// The new name of the old `main`.
pub(super) const MAIN: &str = "landfall_main";

/// The names that a rewrite turns into variables.
#[derive(Clone, Debug, Default)]
pub(super) struct RewriteTargets {
    /// Names without a value until the new `main` assigns one: inputs, members of blocks.
    pub late: Vec<String>,
    /// Built-in variables and their replacements.
    pub builtins: Vec<ReplacedBuiltin>,
    /// Names of the blocks that become variables.
    pub blocks: Vec<String>,
}

/// A built-in variable and its replacement.
#[derive(Clone, Debug)]
pub(super) struct ReplacedBuiltin {
    /// The built-in name, such as `gl_FragCoord`.
    pub name: String,
    /// The replacement's name.
    pub own: String,
    /// The type of both.
    pub ty: &'static str,
}

/// A rewritten text, which has no `main`.
#[derive(Debug)]
pub(super) struct Rewritten {
    /// The text.
    pub text: String,
    /// The names of blocks that became variables, and of their instances.
    pub blocks: Vec<(String, Option<String>)>,
    /// Postponed assignments, to be made by the new `main` after all others.
    pub late: Vec<String>,
    /// The tokens of the flattened text.
    pub raw: RawText,
    /// The flattened text.
    pub flat: Source,
}

impl Rewritten {
    /// Returns a path as `main` accesses it: GLSL names a block's member by the block's instance.
    pub fn renamed(&self, path: &str) -> String {
        let Some((block, rest)) = path.split_once('.') else { return path.to_string() };
        match self.blocks.iter().find(|(name, _)| name == block) {
            Some((_, Some(instance))) => format!("{instance}.{rest}"),
            Some((_, None)) => rest.to_string(),
            None => path.to_string(),
        }
    }
}

/// Returns the first name of a path.
pub(super) fn root(path: &str) -> &str {
    path.split(['.', '[']).next().unwrap_or(path)
}

pub(super) fn rewritten(
    source: &Source,
    options: &ReadOptions,
    wanted: &RewriteTargets,
) -> Rewritten {
    let flat = Source { text: Arc::from(raw::flattened(source, options)), ..source.clone() };
    // Macros are expanded already, those of the command line too.
    let raw = raw::read(&flat, &ReadOptions::default());
    let mut rewriter = Rewriter {
        text: &flat.text,
        wanted,
        out: String::new(),
        blocks: Vec::new(),
        late: Vec::new(),
        late_names: wanted.late.iter().map(String::as_str).collect(),
    };
    let highp = if raw.es { "highp " } else { "" };
    let tokens = &raw.tokens;
    let mut at = 0;
    let mut declared = false;
    // Conditions are evaluated too: the directives left are between declarations.
    let mut declarations = raw.declarations(&flat.text).into_iter();
    while at < tokens.len() {
        if tokens[at].directive.is_none() && !std::mem::replace(&mut declared, true) {
            for builtin in &wanted.builtins {
                let precision = if builtin.ty == "bool" { "" } else { highp };
                let _ = writeln!(rewriter.out, "{precision}{} {};", builtin.ty, builtin.own);
            }
        }
        if let Some(directive) = tokens[at].directive {
            let same = |t: &&RawToken| t.directive == Some(directive);
            let count = tokens[at..].iter().take_while(same).count();
            let line = &flat.text[tokens[at].start..tokens[at + count - 1].end];
            let _ = writeln!(rewriter.out, "{line}");
            at += count;
            continue;
        }
        let Some(declaration) = declarations.next() else { break };
        let function = matches!(&declaration.item, Item::Function(f) if f.body_tokens.is_some());
        at = declaration.tokens.last().map_or(at, |last| last + 1);
        let own = declaration.tokens.iter().map(|&token| tokens[token].clone());
        rewriter.statement(&own.collect::<Vec<_>>(), function);
    }
    let Rewriter { out, blocks, late, .. } = rewriter;
    Rewritten { text: out, blocks, late, raw, flat }
}

/// Qualifiers of inputs, which variables do not have.
const INPUT_QUALIFIERS: [&str; 9] = [
    "in",
    "varying",
    "attribute",
    "flat",
    "smooth",
    "noperspective",
    "centroid",
    "sample",
    "invariant",
];

/// Qualifiers of blocks and their members, which structures do not have.
const BLOCK_QUALIFIERS: [&str; 7] =
    ["uniform", "buffer", "readonly", "writeonly", "coherent", "volatile", "restrict"];

struct Rewriter<'t> {
    text: &'t str,
    wanted: &'t RewriteTargets,
    out: String,
    blocks: Vec<(String, Option<String>)>,
    late: Vec<String>,
    /// The names found so far that have no value before the new `main` runs.
    late_names: FxHashSet<&'t str>,
}

impl<'t> Rewriter<'t> {
    fn word(&self, token: &RawToken) -> &'t str {
        &self.text[token.start..token.end]
    }

    fn statement(&mut self, tokens: &[RawToken], function: bool) {
        // The words outside of parentheses, up to a body or an initialiser.
        let mut depth = 0u32;
        let mut head = Vec::new();
        for token in tokens {
            match self.word(token) {
                "(" => depth += 1,
                ")" => depth = depth.saturating_sub(1),
                "{" | "=" if depth == 0 => break,
                word if depth == 0 => head.push(word),
                _ => {}
            }
        }
        let has = |name: &str| head.contains(&name);
        // Not `layout(…) in;`, which states a property of the stage.
        let is_input =
            has("in") && !(head.len() <= 3 && has(";")) || has("varying") || has("attribute");
        let own = head.iter().any(|word| word.starts_with("gl_"));
        // `invariant normal;` of an input.
        let again = matches!(head[..], ["invariant" | "centroid", name, ";"] if self.is_late(name));
        // A built-in input that is declared again has its replacement already.
        if own && is_input && head.iter().any(|word| self.builtin(word).is_some()) {
            return;
        }
        let opening = tokens.iter().position(|token| self.word(token) == "{");
        if let (false, true, Some(opening)) =
            (function, has("uniform") || has("buffer"), opening.filter(|_| !has(";")))
        {
            let named = |name: &&str| self.wanted.blocks.iter().any(|block| block == name);
            if head.last().is_some_and(named) {
                return self.block(tokens, opening, &BLOCK_QUALIFIERS);
            }
        }
        if function || !(is_input || again) || own {
            return self.other(tokens, &head, function);
        }
        if again {
            return;
        }
        match opening {
            Some(opening) => self.block(tokens, opening, &INPUT_QUALIFIERS),
            None => {
                let words = self.plain(tokens, &INPUT_QUALIFIERS);
                let _ = writeln!(self.out, "{}", words.join(" "));
            }
        }
    }

    /// Returns the replacement of a built-in variable.
    fn builtin(&self, word: &str) -> Option<&'t ReplacedBuiltin> {
        self.wanted.builtins.iter().find(|builtin| builtin.name == word)
    }

    fn is_late(&self, name: &str) -> bool {
        self.wanted.late.iter().any(|late| late == name)
    }

    /// Returns the tokens of a declaration without layout qualifiers and those in `without`.
    fn plain(&self, tokens: &[RawToken], without: &[&str]) -> Vec<&'t str> {
        let mut words = Vec::new();
        let mut at = 0;
        while at < tokens.len() {
            let word = self.word(&tokens[at]);
            at += 1;
            if word == "layout" {
                let close = tokens[at..].iter().position(|t| self.word(t) == ")");
                at += close.map_or(0, |close| close + 1);
            } else if !without.contains(&word) {
                words.push(word);
            }
        }
        words
    }

    /// Appends a block as a structure and a variable, or as a variable for each member.
    fn block(&mut self, tokens: &[RawToken], opening: usize, without: &[&str]) {
        let name = match opening.checked_sub(1) {
            Some(before) => self.word(&tokens[before]).to_string(),
            None => String::new(),
        };
        let close = tokens.iter().rposition(|token| self.word(token) == "}");
        let close = close.unwrap_or(tokens.len() - 1);
        let members = self.plain(&tokens[opening + 1..close], without);
        let rest = self.plain(&tokens[close + 1..], without);
        match rest.first().filter(|word| **word != ";") {
            // As a structure, it keeps the paths to its members.
            Some(instance) => {
                self.late_names.insert(instance);
                let members = members.join(" ");
                self.blocks.push((name.clone(), Some((*instance).to_string())));
                let rest = rest.join(" ");
                let _ = writeln!(self.out, "struct landfall_{name} {{ {members} }};");
                let _ = writeln!(self.out, "landfall_{name} {rest}");
            }
            // Without an instance, its members are names of the shader.
            None => {
                let each = split(&members, ";").flat_map(|member| split(member, ","));
                self.late_names.extend(each.filter_map(|one| RewrittenDeclarator::new(one).name()));
                self.blocks.push((name, None));
                let _ = writeln!(self.out, "{}", members.join(" "));
            }
        }
    }

    /// Appends a declaration unchanged, unless its initialiser is postponed.
    fn other(&mut self, tokens: &[RawToken], head: &[&str], function: bool) {
        if self.postpones(tokens, head, function) {
            return;
        }
        let mut before = tokens.first().map_or(0, |token| token.start);
        let mut last = "";
        for token in tokens {
            // A gap may hold comments: a space or a line break stands for it.
            let gap = &self.text[before..token.start];
            self.out.push_str(if gap.contains('\n') {
                "\n"
            } else if gap.is_empty() {
                ""
            } else {
                " "
            });
            before = token.end;
            let word = self.word(token);
            // Other names may be `main`, but not after `void`.
            let is_main = word == "main" && last == "void" && token.kind == Kind::Name;
            self.out.push_str(match word {
                _ if is_main => MAIN,
                word => self.builtin(word).map_or(word, |builtin| builtin.own.as_str()),
            });
            last = word;
        }
        self.out.push('\n');
    }

    /// Postpones initialisers that read a late name, such as `vec3 n = normalize(v);` of an input
    /// `v`, for the new `main` to assign. The declared name becomes late too, as does a function
    /// that reads a late name. Returns whether an initialiser was postponed.
    fn postpones(&mut self, tokens: &[RawToken], head: &[&str], function: bool) -> bool {
        let words: Vec<&'t str> = tokens.iter().map(|token| self.word(token)).collect();
        let mut depth = 0u32;
        let opening = words.iter().position(|word| {
            match *word {
                "[" | "{" => depth += 1,
                "]" | "}" => depth = depth.saturating_sub(1),
                _ => {}
            }
            depth == 0 && *word == "("
        });
        let called = opening.and_then(|at| at.checked_sub(1));
        if function {
            if let Some(called) = called.filter(|_| self.reads(&words)) {
                self.late_names.insert(words[called]);
            }
            return false;
        }
        let fixed = ["const", "uniform", "out", "buffer", "shared"];
        if head.iter().any(|word| fixed.contains(word)) {
            return false;
        }
        let words = words.strip_suffix(&[";"]).unwrap_or(&words);
        let declared: Vec<RewrittenDeclarator<'_, 't>> =
            split(words, ",").map(RewrittenDeclarator::new).collect();
        if declared.iter().all(|one| one.value.is_none()) {
            // A prototype: the reads of its body are not known yet.
            self.late_names.extend(called.map(|called| words[called]));
            return false;
        }
        let mut list = Vec::new();
        let mut waits = false;
        for one in &declared {
            let (to, value) = (self.joined(one.target), one.value.unwrap_or_default());
            if !self.reads(value) {
                let value = one.value.map(|value| format!(" = {}", self.joined(value)));
                list.push(to + &value.unwrap_or_default());
                continue;
            }
            let Some((at, ty)) = one.name_index().zip(declared[0].ty()) else { return false };
            let name = one.target[at];
            waits = true;
            self.late_names.insert(name);
            // An array without an initialiser needs sizes: those of the name, then of the type.
            let dims = &one.target[at + 1..];
            let inner = dims.iter().filter(|word| **word == "[").count();
            let before = self.sized(&one.target[..at], value, inner);
            let (ty, dims) = (self.sized(&ty, value, inner), self.sized(dims, value, 0));
            let value = self.joined(value);
            self.late.push(match value.starts_with('{') {
                // A list is an initialiser only, not an expression.
                true => {
                    format!("{{ {ty} landfall_late {dims} = {value} ; {name} = landfall_late ; }}")
                }
                false => format!("{name} = {value} ;"),
            });
            let declared = [before.as_str(), name, dims.as_str()];
            let parts = declared.into_iter().filter(|part| !part.is_empty());
            list.push(parts.collect::<Vec<_>>().join(" "));
        }
        if waits {
            let _ = writeln!(self.out, "{};", list.join(", "));
        }
        waits
    }

    /// Returns whether tokens read a late name; members of that name do not count.
    fn reads(&self, words: &[&str]) -> bool {
        let before = std::iter::once("").chain(words.iter().copied());
        before.zip(words).any(|(before, word)| before != "." && self.late_names.contains(word))
    }

    /// Returns tokens joined by spaces, with the sizes of missing dimensions taken from a value;
    /// the first dimension is at that nesting level.
    fn sized(&self, words: &[&'t str], value: &[&'t str], mut level: usize) -> String {
        let mut sized = Vec::new();
        let mut depth = 0u32;
        for (at, word) in words.iter().enumerate() {
            sized.push(self.joined(&[word]));
            if *word == "[" && depth == 0 {
                if words.get(at + 1) == Some(&"]") {
                    sized.push(elements(value, level).to_string());
                }
                level += 1;
            }
            match *word {
                "[" | "{" | "(" => depth += 1,
                "]" | "}" | ")" => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
        sized.join(" ")
    }

    /// Returns tokens joined by spaces, built-in variables replaced.
    fn joined(&self, words: &[&'t str]) -> String {
        let own = |word: &&'t str| self.builtin(word).map_or(*word, |builtin| builtin.own.as_str());
        words.iter().map(own).collect::<Vec<&str>>().join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rewrites a text whose `v` is an input: returns declarations and postponed assignments.
    fn made(text: &str) -> (String, Vec<String>) {
        let wanted = RewriteTargets { late: vec!["v".to_string()], ..RewriteTargets::default() };
        let source = Source::new("a.frag", format!("#version 450\nin vec3 v;\n{text}\n"));
        let made = rewritten(&source, &ReadOptions::default(), &wanted);
        let text = made.text.split_once("vec3 v ;\n").expect("the input comes first").1;
        (text.trim().to_string(), made.late)
    }

    #[test]
    fn what_reads_a_late_variable_is_late_too() {
        let (text, late) = made("vec3 n = v * 2.0;\nvec3 k = n * 3.0;\nfloat c = 2.0;");
        assert_eq!(text, "vec3 n;\nvec3 k;\nfloat c = 2.0;");
        assert_eq!(late, ["n = v * 2.0 ;", "k = n * 3.0 ;"]);
    }

    #[test]
    fn only_the_late_ones_of_a_list_wait() {
        let (text, late) = made("float a[2] = float[2](v.x, 1.0), b = 3.0, c = min(a[1], b), d;");
        assert_eq!(text, "float a [ 2 ], b = 3.0, c, d;");
        assert_eq!(late, ["a = float [ 2 ] ( v . x , 1.0 ) ;", "c = min ( a [ 1 ] , b ) ;"]);
    }

    #[test]
    fn arrays_keep_their_sizes_and_lists_of_values() {
        let (text, late) = made("float a[] = float[](v.x, max(v.y, 0.0));\nfloat[] b = { v.z, };");
        assert_eq!(text, "float a [ 2 ];\nfloat [ 1 ] b;");
        let own = "{ float [ 1 ] landfall_late  = { v . z , } ; b = landfall_late ; }";
        assert_eq!(late, ["a = float [ ] ( v . x , max ( v . y , 0.0 ) ) ;", own]);
        // The sizes of the name come first, then those of the type: both are 3 of 2.
        let value = "{ { v.x, 1.0 }, { v.y, 2.0 }, { v.z, 3.0 } }";
        let (text, _) = made(&format!("float c[][] = {value};\nfloat[] d[] = {value};"));
        assert_eq!(text, "float c [ 3 ] [ 2 ];\nfloat [ 2 ] d [ 3 ];");
        let (text, _) = made(&format!("float e[3][] = {value}, f[][2] = {value};"));
        assert_eq!(text, "float e [ 3 ] [ 2 ], f [ 3 ] [ 2 ];");
    }

    #[test]
    fn what_reads_a_block_of_inputs_is_late() {
        let (_, late) = made(
            "in S { vec2 uv; } s;\nin T { flat int id, of[2]; };\nvec2 a = s.uv;\nint b = id;\n\
             int c = of[1];\nvec2 d = vec2(1.0);",
        );
        assert_eq!(late, ["a = s . uv ;", "b = id ;", "c = of [ 1 ] ;"]);
    }

    #[test]
    fn functions_that_read_an_input_are_late() {
        let text = "float after();\nfloat f() { return v.x; }\nfloat g(S s) { return s.v; }\n\
                    float a = f();\nfloat b = g(s);\nfloat c = after();";
        let late = made(text).1;
        assert_eq!(late, ["a = f ( ) ;", "c = after ( ) ;"]);
    }

    #[test]
    fn constants_and_what_reads_nothing_stay_as_they_were_written() {
        for text in ["const float a = 1.0, b = 2.0;", "float v2 = s.v;"] {
            assert_eq!(made(text), (text.to_string(), Vec::new()), "{text}");
        }
    }
}
