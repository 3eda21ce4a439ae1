//! The blocks that a text declares between `#if` and `#endif`, whichever branches are taken.

use super::lexer::{Kind, Lexer, Token};
use super::texts::Texts;
use crate::source::Span;

/// A block whose declaration depends on macros of the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConditionalBlock {
    pub name: Span,
    /// The macros that the conditions around it test, in their order.
    pub macros: Vec<String>,
}

/// Returns the blocks of a file that a program reaches only with some macros. Conditions on what
/// the language defines, or the text itself in any case, are not the program's.
pub(crate) fn conditional_blocks(text: &str, file: u32) -> Vec<ConditionalBlock> {
    if !text.contains("#if") {
        return Vec::new();
    }
    let texts = Texts::new();
    let mut scan = Scan {
        lexer: Lexer::of_file(text, file, &texts),
        open: Vec::new(),
        fixed: Vec::new(),
        guard: None,
        brackets: 0,
        declared: None,
        found: Vec::new(),
    };
    scan.run();
    let Scan { found, fixed, .. } = scan;
    let is_open = |name: &&&str| !is_predefined(name) && !fixed.contains(name);
    let open = |names: &[&str]| names.iter().filter(is_open).map(|n| n.to_string()).collect();
    let found =
        found.into_iter().map(|(name, names)| ConditionalBlock { name, macros: open(&names) });
    found.filter(|block| !block.macros.is_empty()).collect()
}

/// Whether the language or the API defines a name in conditions (GLSL 4.60 §3.3).
fn is_predefined(name: &str) -> bool {
    let words = ["VULKAN", "defined", "true", "false"];
    name.starts_with("GL_") || name.starts_with("__") || words.contains(&name)
}

/// The limit on uses of macros in conditions around a block that are looked at.
const MAX_MACROS: usize = 256;

// No condition is evaluated, so that blocks of every branch are seen. A block is told by its
// tokens, `uniform … NAME {`, since the text with all branches at once need not parse.
struct Scan<'a> {
    lexer: Lexer<'a>,
    /// The names that each open condition tests, in all its branches so far.
    open: Vec<Vec<&'a str>>,
    /// Macros that the text defines outside of conditions.
    fixed: Vec<&'a str>,
    /// The macro of the `#ifndef` just before.
    guard: Option<&'a str>,
    brackets: u32,
    /// The last name since `uniform` or `buffer`.
    declared: Option<Token<'a>>,
    /// The names of blocks, with the names that the conditions around them test.
    found: Vec<(Span, Vec<&'a str>)>,
}

impl<'a> Scan<'a> {
    fn run(&mut self) {
        let mut comments = Vec::new();
        loop {
            let token = self.lexer.next(&mut comments);
            match token.kind {
                Kind::End => return,
                Kind::Punctuation if token.first && token.is("#") => {
                    self.directive();
                    continue;
                }
                Kind::Punctuation if token.is("{") => {
                    // `uniform {` has no name yet.
                    let name = self.declared.take().filter(|name| !is_storage(name));
                    if let (Some(name), false) = (name, self.open.is_empty()) {
                        // A set in the order of first occurrence; few conditions nest, so a search
                        // per name is cheap.
                        let mut names: Vec<&str> = Vec::new();
                        for name in self.open.iter().flatten().take(MAX_MACROS) {
                            if !names.contains(name) {
                                names.push(name);
                            }
                        }
                        self.found.push((name.span, names));
                    }
                }
                // Of `uniform layout(std140, binding = 1) B {`.
                Kind::Punctuation if token.is("(") => self.brackets += 1,
                Kind::Punctuation if token.is(")") => {
                    self.brackets = self.brackets.saturating_sub(1);
                }
                _ if self.brackets > 0 => {}
                Kind::Name if token.is("struct") => self.declared = None,
                Kind::Name if is_storage(&token) || self.declared.is_some() => {
                    self.declared = Some(token);
                }
                Kind::Name => {}
                // `;`, `=`, `[`: not a block.
                _ => self.declared = None,
            }
            self.guard = None;
        }
    }

    fn directive(&mut self) {
        let mut comments = Vec::new();
        let mut line = Vec::new();
        while let Some(token) = self.lexer.next_on_line(&mut comments) {
            line.push(token);
        }
        let guard = self.guard.take();
        let Some((name, rest)) = line.split_first() else { return };
        let names = || rest.iter().filter(|token| token.kind == Kind::Name).map(|token| token.text);
        match name.text {
            "if" | "ifdef" => self.open.push(names().collect()),
            "ifndef" => {
                self.guard = names().next();
                self.open.push(names().collect());
            }
            "elif" => {
                if let Some(open) = self.open.last_mut() {
                    open.extend(names());
                }
            }
            "endif" => drop(self.open.pop()),
            "define" => {
                let defined = names().next();
                // An include guard does not depend on the program.
                if guard.is_some() && guard == defined {
                    self.open.last_mut().into_iter().for_each(Vec::clear);
                // Within a condition on the program's macros the definition depends on the program
                // as well.
                } else if self.open.iter().all(Vec::is_empty) {
                    self.fixed.extend(defined);
                }
            }
            _ => {}
        }
    }
}

fn is_storage(token: &Token<'_>) -> bool {
    token.is("uniform") || token.is("buffer")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_within_conditions_of_the_program_are_found_with_their_macros() {
        let text = "#ifndef GUARD\n#define GUARD\n#define OWN 1\n\
            layout(std140) uniform Always { vec4 a; };\n\
            #ifdef SHADOWS\n#if LIGHTS > 2 || defined(FOG)\n\
            layout(std430, binding = 1) readonly buffer Deep { vec4 a; } deep;\n#endif\n\
            uniform layout(std140, binding = 2) Late { vec4 a; };\nuniform struct S { vec4 a; } s;\n\
            #else\nuniform Other { vec4 a; };\nuniform vec4 loose;\nvoid f() { }\n#endif\n\
            #if 0\nuniform Dead { vec4 a; };\n#endif\n\
            #ifdef GL_ES\nuniform Es { vec4 a; };\n#endif\n\
            #if OWN\nuniform Own { vec4 a; };\n#endif\n#endif\n";
        let found = conditional_blocks(text, 0);
        let found: Vec<(&str, Vec<&str>)> = found
            .iter()
            .map(|block| {
                let name = &text[block.name.start as usize..block.name.end as usize];
                (name, block.macros.iter().map(String::as_str).collect())
            })
            .collect();
        assert_eq!(
            found,
            [
                ("Deep", vec!["SHADOWS", "LIGHTS", "FOG"]),
                ("Late", vec!["SHADOWS"]),
                ("Other", vec!["SHADOWS"]),
            ]
        );
    }
}
