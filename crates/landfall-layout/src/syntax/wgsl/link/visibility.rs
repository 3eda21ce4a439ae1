//! The words `public` and `private` of WESL, which say from where a declaration may be imported. Whether
//! an import may is left to WESL's own compilers; what a shader imports publicly is part of it.

use std::path::Path;

use super::super::lexer::{Kind, WgslLexer};

/// What such a word may stand before; attributes come before it.
// `public` and `private` are no keywords: elsewhere they are names like others.
const DECLARATIONS: [&str; 9] =
    ["import", "fn", "var", "let", "const", "override", "struct", "alias", "const_assert"];

/// Whether a file is WESL by its name.
pub(super) fn is_wesl(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "wesl")
}

/// Returns the text with blanks for these words, and where the `import` of each public one begins.
pub(super) fn removed(text: &str) -> (String, Vec<u32>) {
    let (mut cuts, mut public) = (Vec::new(), Vec::new());
    let mut lexer = WgslLexer::new(text, 0);
    loop {
        let token = lexer.next();
        let next = lexer.peek();
        match (token.kind, lexer.text_of(token)) {
            (Kind::End, _) => break,
            (Kind::Word, "public" | "private") if DECLARATIONS.contains(&lexer.text_of(next)) => {
                cuts.push((token.start, token.end));
                if lexer.text_of(token) == "public" && lexer.text_of(next) == "import" {
                    public.push(next.start);
                }
            }
            _ => {}
        }
    }
    (super::blanked(text, &cuts), public)
}
