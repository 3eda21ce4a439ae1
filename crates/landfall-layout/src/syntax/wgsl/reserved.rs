//! Names that WGSL reserves (§16.1, §16.2, §3.7), and directives that come too late (§3.5): compilers
//! refuse them, and no layout depends on them.

use super::lexer::{Kind, WgslLexer, WgslToken};
use super::outline::{Class, Outline, OutlineItem};
use super::report;
use crate::diagnostic::{Code, Diagnostic};

/// Returns an error for each such name and directive.
pub(super) fn errors(text: &str, outline: &Outline<'_>) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> =
        outline.late_directives.iter().map(|at| late(text, *at)).collect();
    for item in &outline.items {
        let mut lexer = WgslLexer::new(text, item.name_span.start);
        let name = lexer.next();
        found.extend(refused(&lexer, name));
        names_inside(text, item, &mut found);
    }
    found
}

/// Adds the errors of the names that a structure or function declares.
fn names_inside(text: &str, item: &OutlineItem<'_>, found: &mut Vec<Diagnostic>) {
    let (mut in_head, mut before) = match item.class {
        Class::Struct | Class::Fn => (true, None),
        Class::Alias | Class::Const | Class::Override | Class::Var => return,
    };
    let mut lexer = WgslLexer::new(text, item.rest);
    while let Some(token) = lexer.next_before(item.end) {
        // Members and parameters stand before a `:`; what a body declares, after a keyword.
        in_head &= item.class == Class::Struct || !token.is(b'{');
        let declares = match in_head {
            true => token.kind == Kind::Word && lexer.peek().is(b':'),
            false => token.kind == Kind::Word && matches!(before, Some("let" | "var" | "const")),
        };
        if declares {
            found.extend(refused(&lexer, token));
        }
        before = Some(lexer.text_of(token));
        if before == Some("var") && lexer.take(b'<') {
            while !lexer.take(b'>') && lexer.next().kind != Kind::End {}
        }
    }
}

fn refused(lexer: &WgslLexer<'_>, name: WgslToken) -> Option<Diagnostic> {
    let word = lexer.text_of(name);
    let why = match word {
        // As the name of a value that is not used.
        "_" => return None,
        _ if word.starts_with("__") => "begins with two underscores, which is reserved",
        _ if RESERVED.binary_search(&word).is_ok() => "is a reserved word of WGSL, not a name",
        _ => return None,
    };
    let error =
        Diagnostic::error(Code::InvalidShader, report::span(name), format!("`{word}` {why}"));
    Some(error.with_note("WGSL §16.2, §3.7").with_help("rename it"))
}

fn late(text: &str, start: u32) -> Diagnostic {
    let mut lexer = WgslLexer::new(text, start);
    let word = lexer.next();
    let message = format!("`{}` stands after a declaration", lexer.text_of(word));
    Diagnostic::error(Code::InvalidShader, report::span(word), message)
        .with_note("WGSL §3.5: directives stand before all declarations")
        .with_help("move it to the beginning of the file")
}

/// The keywords and reserved words, sorted.
const RESERVED: &[&str] = &[
    "NULL",
    "Self",
    "abstract",
    "active",
    "alias",
    "alignas",
    "alignof",
    "as",
    "asm",
    "asm_fragment",
    "async",
    "attribute",
    "auto",
    "await",
    "become",
    "break",
    "case",
    "cast",
    "catch",
    "class",
    "co_await",
    "co_return",
    "co_yield",
    "coherent",
    "column_major",
    "common",
    "compile",
    "compile_fragment",
    "concept",
    "const",
    "const_assert",
    "const_cast",
    "consteval",
    "constexpr",
    "constinit",
    "continue",
    "continuing",
    "crate",
    "debugger",
    "decltype",
    "default",
    "delete",
    "demote",
    "demote_to_helper",
    "diagnostic",
    "discard",
    "do",
    "dynamic_cast",
    "else",
    "enable",
    "enum",
    "explicit",
    "export",
    "extends",
    "extern",
    "external",
    "fallthrough",
    "false",
    "filter",
    "final",
    "finally",
    "fn",
    "for",
    "friend",
    "from",
    "fxgroup",
    "get",
    "goto",
    "groupshared",
    "highp",
    "if",
    "impl",
    "implements",
    "import",
    "inline",
    "instanceof",
    "interface",
    "layout",
    "let",
    "loop",
    "lowp",
    "macro",
    "macro_rules",
    "match",
    "mediump",
    "meta",
    "mod",
    "module",
    "move",
    "mut",
    "mutable",
    "namespace",
    "new",
    "nil",
    "noexcept",
    "noinline",
    "nointerpolation",
    "non_coherent",
    "noncoherent",
    "noperspective",
    "null",
    "nullptr",
    "of",
    "operator",
    "override",
    "package",
    "packoffset",
    "partition",
    "pass",
    "patch",
    "pixelfragment",
    "precise",
    "precision",
    "premerge",
    "priv",
    "protected",
    "pub",
    "public",
    "readonly",
    "ref",
    "regardless",
    "register",
    "reinterpret_cast",
    "require",
    "requires",
    "resource",
    "restrict",
    "return",
    "self",
    "set",
    "shared",
    "sizeof",
    "smooth",
    "snorm",
    "static",
    "static_assert",
    "static_cast",
    "std",
    "struct",
    "subroutine",
    "super",
    "switch",
    "target",
    "template",
    "this",
    "thread_local",
    "throw",
    "trait",
    "true",
    "try",
    "type",
    "typedef",
    "typeid",
    "typename",
    "typeof",
    "union",
    "unless",
    "unorm",
    "unsafe",
    "unsized",
    "use",
    "using",
    "var",
    "varying",
    "virtual",
    "volatile",
    "wgsl",
    "where",
    "while",
    "with",
    "writeonly",
    "yield",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_sorted() {
        assert!(RESERVED.is_sorted());
    }
}
