//! Macro expansion: parses arguments and puts the expansion in front of the stream.
//!
//! Called by [`preprocess`](super) for every name.

use rustc_hash::FxHashMap;

use super::{Preprocessor, TokenSource};
use crate::diagnostic::{Code, Diagnostic};
use crate::syntax::glsl::lexer::{Kind, Token};
use crate::syntax::glsl::macros::{Macro, paste};

/// The limit on tokens that macros may expand to in one shader; guards against exhausting memory.
const MAX_EXPANDED: usize = 1 << 20;

/// The limit on nested macro calls in arguments.
// `expand` calls itself for arguments by `expand_alone`; the limit is one on the stack.
const DEEPEST_ARGUMENTS: u32 = 64;

impl<'a> Preprocessor<'a> {
    /// Expands a name if it is a macro; `None` if its expansion was put in front of the stream.
    pub(super) fn expand(&mut self, mut token: Token<'a>) -> Option<Token<'a>> {
        // `__LINE__` and `__FILE__` differ at each use, so they have no entry in the table.
        if token.text.starts_with("__") {
            if let Some(text) = self.line_or_file(&token) {
                return Some(Token { kind: Kind::Number, text, ..token });
            }
        }
        let Some(definition) = self.macros.get(token.text).cloned() else {
            if self.undefined.contains(token.text) {
                return Some(token);
            }
            return Some(match self.predefined(token.text) {
                Some(text) => Token { kind: Kind::Number, text, ..token },
                None => token,
            });
        };
        // The name of a macro in its own expansion is never expanded, not even after that has
        // ended: hence a mark on the token, which goes with it into other arguments.
        if definition.expanding.get() {
            token.frozen = true;
            return Some(token);
        }
        let tokens = match &definition.parameters {
            None => definition.body.iter().map(|t| at_use(t, &token)).collect(),
            Some(parameters) => {
                // The `(` may be past the end of the expansion that the name is from, in the text
                // after it.
                let open = self.next_raw();
                // `F` alone, where `F` has parameters, is a name like others.
                if !open.is("(") {
                    if open.kind != Kind::End {
                        self.frames.push(TokenSource::Tokens { tokens: vec![open], at: 0 });
                    }
                    return Some(token);
                }
                let arguments = self.arguments(&token, parameters.len())?;
                self.substitute(&definition, parameters, &arguments, &token)
            }
        };
        // One more than the tokens: macros that double and end in nothing (`#define A B B`,
        // `#define B C C` and so on) take exponential time without yielding any.
        if !self.count_expanded(tokens.len() + 1, &token) {
            return None;
        }
        let tokens = paste(tokens, self.texts);
        definition.expanding.set(true);
        self.frames.push(TokenSource::Macro { definition, tokens, at: 0 });
        None
    }

    /// Counts tokens produced by or passed to macros; returns whether they are within the limit.
    fn count_expanded(&mut self, tokens: usize, at: &Token<'a>) -> bool {
        self.expanded += tokens;
        if self.expanded > MAX_EXPANDED && !self.stopped {
            self.stopped = true;
            let message = format!("macros expand to more than {MAX_EXPANDED} tokens");
            self.diagnostics.push(
                Diagnostic::error(Code::MacroBomb, at.span, message)
                    .with_help("look for macros that use each other several times over"),
            );
        }
        !self.stopped
    }

    /// Returns the arguments of a macro call, after its `(`; `None` if the call is broken.
    // Read without expansion: `substitute` decides by parameter. Parentheses alone nest, so that
    // the comma in `F(a[1, 2])` separates, as in C.
    fn arguments(&mut self, name: &Token<'a>, wanted: usize) -> Option<Vec<Vec<Token<'a>>>> {
        let mut arguments = vec![Vec::new()];
        let mut depth = 0u32;
        loop {
            let token = self.next_raw();
            match token.text {
                _ if token.kind == Kind::End => {
                    let message = format!("the call of macro `{}` is never closed", name.text);
                    self.report(Diagnostic::error(Code::MacroCall, name.span, message));
                    return None;
                }
                ")" if depth == 0 => break,
                "," if depth == 0 => {
                    arguments.push(Vec::new());
                    continue;
                }
                "(" => depth += 1,
                ")" => depth -= 1,
                _ => {}
            }
            arguments.last_mut().expect("there is always a current argument").push(token);
        }
        // Nested calls read their arguments again at each level.
        let given = arguments.iter().map(Vec::len).sum();
        if !self.count_expanded(given, name) {
            return None;
        }
        // `F()` has no argument if F has no parameters, and one empty argument otherwise.
        if wanted == 0 && arguments.len() == 1 && arguments[0].is_empty() {
            arguments.clear();
        }
        if arguments.len() != wanted {
            let message = format!(
                "macro `{}` takes {wanted} arguments, but {} were given",
                name.text,
                arguments.len()
            );
            self.report(Diagnostic::error(Code::MacroCall, name.span, message));
            return None;
        }
        Some(arguments)
    }

    /// Returns the body of a function-like macro with its parameters replaced.
    fn substitute(
        &mut self,
        definition: &Macro<'a>,
        parameters: &[&'a str],
        arguments: &[Vec<Token<'a>>],
        site: &Token<'a>,
    ) -> Vec<Token<'a>> {
        let indices: FxHashMap<&str, usize> =
            parameters.iter().enumerate().rev().map(|(index, name)| (*name, index)).collect();
        let mut expanded: Vec<Option<Vec<Token<'a>>>> = vec![None; arguments.len()];
        let mut tokens = Vec::new();
        for (i, token) in definition.body.iter().enumerate() {
            let parameter = indices.get(token.text).filter(|_| token.kind == Kind::Name);
            let Some(&parameter) = parameter else {
                tokens.push(at_use(token, site));
                continue;
            };
            // Operands of `##` are used as written, other arguments are expanded first.
            let pasted = (i > 0 && definition.body[i - 1].is("##"))
                || definition.body.get(i + 1).is_some_and(|next| next.is("##"));
            if pasted {
                tokens.extend(&arguments[parameter]);
            } else {
                if expanded[parameter].is_none() {
                    expanded[parameter] = Some(self.expand_alone(&arguments[parameter]));
                }
                tokens.extend(expanded[parameter].as_ref().expect("just filled"));
            }
            // `#define F(x) x x x x x` on a long argument: the caller counts only what is returned.
            if self.expanded + tokens.len() > MAX_EXPANDED {
                break;
            }
        }
        tokens
    }

    /// Expands tokens as if nothing followed them.
    // C's rule for arguments and lines of directives: they are expanded completely by themselves.
    // `floor` hides the frames below, so that a macro whose `(` is missing does not take it from
    // the text after.
    pub(in crate::syntax::glsl) fn expand_alone(&mut self, tokens: &[Token<'a>]) -> Vec<Token<'a>> {
        if !tokens.iter().any(|t| t.kind == Kind::Name && !t.frozen) {
            return tokens.to_vec();
        }
        if self.argument_depth == DEEPEST_ARGUMENTS {
            let message = format!("macro calls are nested more than {DEEPEST_ARGUMENTS} deep");
            self.stop(Diagnostic::error(Code::MacroBomb, tokens[0].span, message));
            return Vec::new();
        }
        self.argument_depth += 1;
        let floor = std::mem::replace(&mut self.floor, self.frames.len());
        self.frames.push(TokenSource::Tokens { tokens: tokens.to_vec(), at: 0 });
        let mut result = Vec::new();
        loop {
            let token = self.next();
            if token.kind == Kind::End {
                break;
            }
            result.push(token);
        }
        self.frames.truncate(self.floor);
        self.floor = floor;
        self.argument_depth -= 1;
        result
    }
}

/// Returns a token of a macro's body with the span of the macro's use.
// The span is the outermost use in the user's text, which `site` has if it is from a macro itself;
// so is the definition. A `#` from a macro begins no directive, hence `first`.
fn at_use<'a>(token: &Token<'a>, site: &Token<'a>) -> Token<'a> {
    Token {
        span: site.span,
        definition: site.definition.or(Some(token.span)),
        comments: site.comments,
        first: false,
        ..*token
    }
}
