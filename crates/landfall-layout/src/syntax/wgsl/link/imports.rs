//! Import declarations: `import a::{b, c::d as e};` of WESL and `#import` of naga_oil, which differ
//! in their ends only.

use super::super::lexer::{Kind, WgslLexer};
use super::super::report;
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// The most names before a list: each list in a list has more.
const LONGEST_PATH: usize = 100;

/// A name that a module takes from another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Import {
    /// The name in this module.
    pub(super) alias: String,
    /// The path as it is written, its braces resolved. The first part may be a file in quotes.
    pub(super) path: Vec<String>,
    /// Where the path's last name stands.
    pub(super) at: Span,
    /// Whether the module has it for those that import it: `public import`.
    pub(super) is_public: bool,
}

/// What stands before the declarations of a module of WESL.
pub(super) struct ModuleHead {
    /// The text with blanks for the imports.
    pub(super) text: String,
    pub(super) imports: Vec<Import>,
    /// The ranges of `enable`, `requires` and `diagnostic`.
    pub(super) directives: Vec<(u32, u32)>,
}

/// Reads what stands before the declarations; `public` has where public imports begin.
///
/// # Errors
/// An import that is none.
// module: ( import | enable | requires | diagnostic | `;` )* declarations
// import: `import` tree ( `,` tree )* `;`
pub(super) fn head(text: &str, public: &[u32]) -> Result<ModuleHead, Diagnostic> {
    let (mut imports, mut directives, mut cuts) = (Vec::new(), Vec::new(), Vec::new());
    let mut lexer = WgslLexer::new(text, 0);
    loop {
        let token = lexer.peek();
        match lexer.text_of(token) {
            "import" if token.kind == Kind::Word => {
                lexer.next();
                let is_public = public.contains(&token.start);
                let all = read(&mut lexer)?.into_iter();
                imports.extend(all.map(|import| Import { is_public, ..import }));
                let end = report::expect(&mut lexer, b';')?;
                cuts.push((token.start, end.end));
            }
            "enable" | "requires" | "diagnostic" => {
                let mut end = token.end;
                while !matches!(lexer.peek().kind, Kind::End | Kind::Sign(b';' | b'{')) {
                    end = lexer.next().end;
                }
                end = if lexer.peek().is(b';') { lexer.next().end } else { end };
                directives.push((token.start, end));
            }
            ";" => drop(lexer.next()),
            _ => break,
        }
    }
    Ok(ModuleHead { text: super::blanked(text, &cuts), imports, directives })
}

/// Reads imports that are divided by commas, to the first token that does not belong to them.
///
/// # Errors
/// A token that no import has.
pub(super) fn read(lexer: &mut WgslLexer<'_>) -> Result<Vec<Import>, Diagnostic> {
    let mut imports = Vec::new();
    tree(lexer, &[], &mut imports)?;
    while lexer.take(b',') {
        tree(lexer, &[], &mut imports)?;
    }
    Ok(imports)
}

/// Reads a path after `prefix`, which may end with a list in braces.
// tree: name ( `::` name )* ( `as` name )?
//     | name ( `::` name )* `::` `{` ( tree ( `,` tree )* `,`? )? `}`
// `name` may be a file in quotes at the start, which naga_oil has.
fn tree(
    lexer: &mut WgslLexer<'_>,
    prefix: &[String],
    imports: &mut Vec<Import>,
) -> Result<(), Diagnostic> {
    let mut path = prefix.to_vec();
    loop {
        let token = lexer.next();
        let at = match token.kind {
            Kind::Word => {
                path.push(lexer.text_of(token).to_string());
                report::span(token)
            }
            Kind::Sign(b'"') => {
                let rest = &lexer.text()[token.end as usize..];
                let Some(length) = rest.find(['"', '\n']) else {
                    return Err(report::unexpected(lexer, token, "a file in quotes"));
                };
                path.push(rest[..length].to_string());
                let end = token.end + length as u32;
                lexer.jump(end + 1);
                Span { file: 0, start: token.end, end }
            }
            Kind::Sign(b'{') if path.len() > LONGEST_PATH => {
                let message = format!("a path of more than {LONGEST_PATH} names has a list");
                return Err(Diagnostic::error(Code::NestedTooDeep, report::span(token), message));
            }
            Kind::Sign(b'{') if path.len() > prefix.len() => loop {
                if lexer.take(b'}') {
                    return Ok(());
                }
                tree(lexer, &path, imports)?;
                if !lexer.take(b',') && !lexer.peek().is(b'}') {
                    let token = lexer.next();
                    return Err(report::unexpected(lexer, token, "`,` or `}`"));
                }
            },
            Kind::Number | Kind::Sign(_) | Kind::End => {
                return Err(report::unexpected(lexer, token, "a name"));
            }
        };
        if super::take_path_separator(lexer) {
            continue;
        }
        let mut alias = path.last().cloned().unwrap_or_default();
        if lexer.peek().kind == Kind::Word && lexer.text_of(lexer.clone().next()) == "as" {
            lexer.next();
            let name = report::word(lexer, "a name")?;
            alias = lexer.text_of(name).to_string();
        }
        imports.push(Import { alias, path, at, is_public: false });
        return Ok(());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_lists_files_and_other_names_are_read() {
        let text = "a::{b, c::{d as e, f,}}, \"x/y.wgsl\"::{g}, h as i ; rest";
        let mut lexer = WgslLexer::new(text, 0);
        let read = read(&mut lexer).expect("it is right");
        let read: Vec<(String, String)> =
            read.into_iter().map(|import| (import.alias, import.path.join("::"))).collect();
        let expected =
            [("b", "a::b"), ("e", "a::c::d"), ("f", "a::c::f"), ("g", "x/y.wgsl::g"), ("i", "h")];
        assert_eq!(read, expected.map(|(a, b)| (a.to_string(), b.to_string())));
        assert!(lexer.take(b';'));
        for wrong in ["a::", "a::{b", "a::{b c}", "1", "a as 2", "\"open", "a::{{b}}"] {
            assert!(super::read(&mut WgslLexer::new(wrong, 0)).is_err(), "{wrong}");
        }
    }
}
