//! The user's GLSL with what a stage is given turned into variables that a new `main` can fill:
//! inputs, built-in ones among them, and the blocks that are named. What was `main` becomes a
//! function.
//!
//! Everything else stays as it was written; includes are put in and macros expanded first, so
//! that a declaration made by a macro is found. Reads a text flattened by
//! [`raw::flattened`]; feeds [`fragments`](super::fragments) and [`call`](super::call).

use std::fmt::Write as _;
use std::sync::Arc;

use crate::parse::glsl::lexer::Kind;
use crate::parse::glsl::raw::{self, RawText, RawToken};
use crate::run::verify::partner;
use crate::source::{ReadOptions, Source};

/// The name of what was `main`.
pub(super) const MAIN: &str = "landfall_main";

/// What is to become variables besides inputs.
#[derive(Clone, Debug, Default)]
pub(super) struct Wanted {
    /// Names that have no value before the new `main` gives them one: inputs, members of blocks.
    pub late: Vec<String>,
    /// Variables of the language's own, and what stands for them.
    pub builtins: Vec<Builtin>,
    /// Names of the blocks that become variables.
    pub blocks: Vec<String>,
}

/// A variable of the language's own that another stands for.
#[derive(Clone, Debug)]
pub(super) struct Builtin {
    /// `gl_FragCoord`.
    pub name: String,
    /// The variable's name.
    pub own: String,
    /// The variable's type.
    pub ty: &'static str,
}

/// A text without a `main`.
#[derive(Debug)]
pub(super) struct Rewritten {
    /// Its text.
    pub text: String,
    /// Blocks that became variables, and their instances.
    pub blocks: Vec<(String, Option<String>)>,
    /// Assignments for the new `main` to make when all else has its value.
    pub late: Vec<String>,
    /// Its tokens, for who looks for more.
    pub raw: RawText,
    /// What the tokens are of.
    pub flat: Source,
}

impl Rewritten {
    /// A path as `main` can write it: a member of a block is named by GLSL after its instance.
    pub fn renamed(&self, path: &str) -> String {
        let Some((block, rest)) = path.split_once('.') else { return path.to_string() };
        match self.blocks.iter().find(|(name, _)| name == block) {
            Some((_, Some(instance))) => format!("{instance}.{rest}"),
            Some((_, None)) => rest.to_string(),
            None => path.to_string(),
        }
    }
}

/// Rewrites a text.
pub(super) fn rewritten(source: &Source, options: &ReadOptions, wanted: &Wanted) -> Rewritten {
    let flat = Source { text: Arc::from(raw::flattened(source, options)), ..source.clone() };
    // Macros are gone, and definitions of the command line with them.
    let raw = raw::read(&flat, &ReadOptions::default());
    let mut rewriter = Rewriter {
        text: &flat.text,
        wanted,
        out: String::new(),
        blocks: Vec::new(),
        late: Vec::new(),
    };
    let highp = if raw.es { "highp " } else { "" };
    let tokens = &raw.tokens;
    let mut at = 0;
    let mut declared = false;
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
        let word = |token: &RawToken| &flat.text[token.start..token.end];
        let found = partner::statement(&tokens[at..], &word);
        let statement = &tokens[at..at + found.end];
        at += found.end;
        rewriter.statement(statement, found.function);
    }
    let Rewriter { out, blocks, late, .. } = rewriter;
    Rewritten { text: out, blocks, late, raw, flat }
}

/// Words before a type that mean something of inputs alone.
const INPUT_WORDS: [&str; 9] = [
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

/// Words of a block or its members that a structure has none of.
const BLOCK_WORDS: [&str; 7] =
    ["uniform", "buffer", "readonly", "writeonly", "coherent", "volatile", "restrict"];

struct Rewriter<'t> {
    text: &'t str,
    wanted: &'t Wanted,
    out: String,
    blocks: Vec<(String, Option<String>)>,
    late: Vec<String>,
}

impl<'t> Rewriter<'t> {
    fn word(&self, token: &RawToken) -> &'t str {
        &self.text[token.start..token.end]
    }

    fn statement(&mut self, tokens: &[RawToken], function: bool) {
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
        let of_inputs =
            has("in") && !(head.len() <= 3 && has(";")) || has("varying") || has("attribute");
        let own = head.iter().any(|word| word.starts_with("gl_"));
        // `invariant normal;` of an input.
        let again = matches!(head[..], ["invariant" | "centroid", name, ";"] if self.waiting(name));
        if own && of_inputs && head.iter().any(|word| self.builtin(word).is_some()) {
            return;
        }
        let opening = tokens.iter().position(|token| self.word(token) == "{");
        if let (false, true, Some(opening)) =
            (function, has("uniform") || has("buffer"), opening.filter(|_| !has(";")))
        {
            let named = |name: &&str| self.wanted.blocks.iter().any(|block| block == name);
            if head.last().is_some_and(named) {
                return self.block(tokens, opening, &BLOCK_WORDS);
            }
        }
        if function || !(of_inputs || again) || own {
            return self.other(tokens, &head, function);
        }
        if again {
            return;
        }
        match opening {
            Some(opening) => self.block(tokens, opening, &INPUT_WORDS),
            None => {
                let words = self.plain(tokens, &INPUT_WORDS);
                let _ = writeln!(self.out, "{}", words.join(" "));
            }
        }
    }

    /// What stands for a variable of the language's own.
    fn builtin(&self, word: &str) -> Option<&'t Builtin> {
        self.wanted.builtins.iter().find(|builtin| builtin.name == word)
    }

    fn waiting(&self, name: &str) -> bool {
        self.wanted.late.iter().any(|late| late == name)
    }

    /// The words of a declaration without its layout and those that are left out.
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

    /// A block: a structure and a variable, or a variable for each member.
    fn block(&mut self, tokens: &[RawToken], opening: usize, without: &[&str]) {
        let name = match opening.checked_sub(1) {
            Some(before) => self.word(&tokens[before]).to_string(),
            None => String::new(),
        };
        let close = tokens.iter().rposition(|token| self.word(token) == "}");
        let close = close.unwrap_or(tokens.len() - 1);
        let members = self.plain(&tokens[opening + 1..close], without).join(" ");
        let rest = self.plain(&tokens[close + 1..], without);
        match rest.first().filter(|word| **word != ";") {
            Some(instance) => {
                self.blocks.push((name.clone(), Some((*instance).to_string())));
                let rest = rest.join(" ");
                let _ = writeln!(self.out, "struct landfall_{name} {{ {members} }};");
                let _ = writeln!(self.out, "landfall_{name} {rest}");
            }
            None => {
                self.blocks.push((name, None));
                let _ = writeln!(self.out, "{members}");
            }
        }
    }

    /// What declares no input, as it stands.
    fn other(&mut self, tokens: &[RawToken], head: &[&str], function: bool) {
        if self.waits(tokens, head, function) {
            return;
        }
        let mut before = tokens.first().map_or(0, |token| token.start);
        let mut last = "";
        for token in tokens {
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
            let is_main = word == "main" && last == "void" && token.kind == Kind::Name;
            self.out.push_str(match word {
                _ if is_main => MAIN,
                word => self.builtin(word).map_or(word, |builtin| builtin.own.as_str()),
            });
            last = word;
        }
        self.out.push('\n');
    }

    /// Splits `vec3 n = normalize(v);` where `v` is an input, which has no value there yet.
    fn waits(&mut self, tokens: &[RawToken], head: &[&str], function: bool) -> bool {
        let words: Vec<&str> = tokens.iter().map(|token| self.word(token)).collect();
        let Some(equals) = words.iter().position(|word| *word == "=") else { return false };
        let fixed = ["const", "uniform", "out", "buffer", "shared"];
        if function || equals == 0 || head.iter().any(|word| fixed.contains(word)) {
            return false;
        }
        let reads = words[equals..].iter().any(|word| self.waiting(word));
        let mut depth = 0i32;
        let several = words[equals..].iter().any(|word| {
            match *word {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            depth == 0 && *word == ","
        });
        if !reads || several {
            return false;
        }
        let _ = writeln!(self.out, "{};", words[..equals].join(" "));
        self.late.push(format!("{} {}", words[equals - 1], words[equals..].join(" ")));
        true
    }
}
