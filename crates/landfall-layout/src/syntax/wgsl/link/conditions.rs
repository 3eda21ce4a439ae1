//! Conditional declarations of WESL: `@if(FLAGS)`, `@elif(FLAGS)` and `@else` before declarations,
//! members, parameters and statements, and before `{ declarations }`.

use super::super::lexer::{Kind, WgslLexer, WgslToken};
use super::super::report;
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

const DEEPEST_CONDITION: usize = 100;

/// What a bracket holds.
// Decides how far the part after a condition reaches: to `;` or `}` for declarations and
// statements, to `,` for members, parameters and arguments.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Enclosing {
    Module,
    /// Members, or parameters and arguments: each ends with a comma.
    List,
    Body,
}

struct OpenBracket {
    level: Enclosing,
    /// Whether its braces are those of a condition, and removed with it.
    is_removed: bool,
    /// The condition before the next part, if any.
    chain: Option<IfChain>,
}

impl OpenBracket {
    fn new(level: Enclosing) -> OpenBracket {
        OpenBracket { level, is_removed: false, chain: None }
    }
}

/// An `@if` and what follows it so far.
#[derive(Clone, Copy)]
struct IfChain {
    /// Whether one of its parts is kept.
    is_taken: bool,
    /// The end of its last part.
    end: u32,
}

/// Attributes that stand together.
struct AttributeRun {
    start: u32,
    end: u32,
    /// The condition among them: its name, its own range, and the start of its expression.
    condition: Option<(&'static str, u32, u32, u32)>,
}

/// Returns a text of the same length in which blanks stand for what conditions leave out.
///
/// # Errors
/// `@elif` or `@else` without `@if`, and expressions that are none.
// WESL, conditional translation:
// `@if` `(` expression `)` part ( `@elif` `(` expression `)` part )* ( `@else` part )?
// One pass over the tokens with a stack of open brackets. A part that is left out is jumped over;
// of one that is kept only the attribute goes, and what is in it is read on for conditions of its
// own.
pub(super) fn applied(text: &str, is_set: &dyn Fn(&str) -> bool) -> Result<String, Diagnostic> {
    let mut cuts: Vec<(u32, u32)> = Vec::new();
    let mut blank = |from: u32, to: u32| cuts.push((from, to));
    let mut lexer = WgslLexer::new(text, 0);
    let mut open = vec![OpenBracket::new(Enclosing::Module)];
    let (mut last_end, mut is_struct) = (0, false);
    // The ends of the parts that are read on, each inside the one before.
    let mut ends: Vec<u32> = Vec::new();
    loop {
        let token = lexer.peek();
        if token.kind == Kind::End {
            break;
        }
        if token.is(b'@') {
            let all = attributes(&mut lexer);
            let Some((name, from, to, expression)) = all.condition else { continue };
            let here = open.last_mut().expect("the module stays open");
            let end = extent(text, all.end, here.level);
            // `@elif` and `@else` belong to an `@if` only if nothing stands between.
            let before = here.chain.filter(|chain| chain.end == last_end);
            let value = match (name, before) {
                ("if", _) => condition(text, expression, is_set)?,
                (_, None) => {
                    let span = Span { file: 0, start: from, end: to };
                    let message = format!("`@{name}` without an `@if` before it");
                    return Err(Diagnostic::error(Code::Syntax, span, message));
                }
                ("elif", Some(chain)) => condition(text, expression, is_set)? && !chain.is_taken,
                (_, Some(chain)) => !chain.is_taken,
            };
            let was_taken = name != "if" && before.is_some_and(|chain| chain.is_taken);
            here.chain = Some(IfChain { is_taken: was_taken || value, end });
            if !value {
                blank(all.start, end);
                lexer.jump(end);
                last_end = end;
                continue;
            }
            blank(from, to);
            ends.retain(|end| *end > from);
            ends.push(end);
            // The end of each was looked for through all that is in it.
            if ends.len() > DEEPEST_CONDITION {
                return Err(too_deep(Span { file: 0, start: from, end: to }));
            }
            let level = here.level;
            // `@if(F) { … }` around declarations or members: the braces are not WGSL's and go as
            // well. In a body they are a compound statement and stay.
            if level != Enclosing::Body && lexer.peek().is(b'{') {
                let brace = lexer.next();
                blank(brace.start, brace.end);
                open.push(OpenBracket { is_removed: true, ..OpenBracket::new(level) });
            }
            continue;
        }
        let token = lexer.next();
        last_end = token.end;
        let level = open.last().map_or(Enclosing::Module, |here| here.level);
        match token.kind {
            Kind::Word => {
                is_struct |= level == Enclosing::Module && lexer.text_of(token) == "struct"
            }
            // A struct's braces hold a list, all others statements; those of a condition were taken
            // above.
            Kind::Sign(b'{') => {
                let list = std::mem::take(&mut is_struct);
                open.push(OpenBracket::new(if list { Enclosing::List } else { Enclosing::Body }));
            }
            Kind::Sign(b'(' | b'[') => open.push(OpenBracket::new(Enclosing::List)),
            Kind::Sign(b'}' | b')' | b']') if open.len() > 1 => {
                if open.pop().is_some_and(|closed| closed.is_removed) {
                    blank(token.start, token.end);
                }
            }
            Kind::Sign(_) | Kind::Number | Kind::End => {}
        }
    }
    Ok(super::blanked(text, &cuts))
}

fn too_deep(at: Span) -> Diagnostic {
    let message = format!("conditions are nested more than {DEEPEST_CONDITION} deep");
    Diagnostic::error(Code::NestedTooDeep, at, message)
}

/// Reads attributes that stand together.
// `@group(0) @if(F) @binding(1) var …`: a condition may stand among other attributes, and is for
// all.
fn attributes(lexer: &mut WgslLexer<'_>) -> AttributeRun {
    let start = lexer.peek().start;
    let mut all = AttributeRun { start, end: start, condition: None };
    while lexer.peek().is(b'@') {
        let sign = lexer.next();
        let name = lexer.next();
        all.end = name.end;
        let mut expression = name.end;
        if lexer.peek().is(b'(') {
            expression = lexer.next().end;
            all.end = past_closing(lexer).unwrap_or(expression);
        }
        let name = match lexer.text_of(name) {
            "if" => "if",
            "elif" => "elif",
            "else" => "else",
            _ => continue,
        };
        all.condition.get_or_insert((name, sign.start, all.end, expression));
    }
    all
}

/// Skips to the bracket that closes the one before; returns its end.
fn past_closing(lexer: &mut WgslLexer<'_>) -> Option<u32> {
    let mut depth = 1u32;
    loop {
        let token = lexer.next();
        match token.kind {
            Kind::Sign(b'(' | b'[' | b'{') => depth += 1,
            Kind::Sign(b')' | b']' | b'}') => depth -= 1,
            Kind::End => return None,
            Kind::Word | Kind::Number | Kind::Sign(_) => {}
        }
        if depth == 0 {
            return Some(token.end);
        }
    }
}

/// Returns the end of the declaration, member, parameter or statement that starts at `at`.
fn extent(text: &str, at: u32, level: Enclosing) -> u32 {
    let mut lexer = WgslLexer::new(text, at);
    let first = lexer.peek();
    if first.is(b'{') {
        lexer.next();
        return past_closing(&mut lexer).unwrap_or(text.len() as u32);
    }
    if level == Enclosing::List {
        return list_item(&mut lexer, at);
    }
    match lexer.text_of(first) {
        // `if … { } else if … { } else { }` is one statement.
        "if" => loop {
            let end = braces(&mut lexer, text);
            if lexer.text_of(lexer.clone().peek()) != "else" {
                return end;
            }
            lexer.next();
        },
        "fn" | "struct" | "for" | "while" | "loop" | "switch" | "case" | "default" => {
            braces(&mut lexer, text)
        }
        _ => statement(&mut lexer, at),
    }
}

/// Skips past the next `{ … }` outside other brackets; returns its end.
fn braces(lexer: &mut WgslLexer<'_>, text: &str) -> u32 {
    loop {
        let token = lexer.next();
        let end = match token.kind {
            Kind::Sign(b'{') => return past_closing(lexer).unwrap_or(text.len() as u32),
            Kind::Sign(b'(' | b'[') => past_closing(lexer),
            Kind::End => None,
            Kind::Word | Kind::Number | Kind::Sign(_) => continue,
        };
        if end.is_none() {
            return text.len() as u32;
        }
    }
}

/// Skips past `;`; returns the end.
fn statement(lexer: &mut WgslLexer<'_>, mut end: u32) -> u32 {
    loop {
        let token = lexer.peek();
        match token.kind {
            Kind::End | Kind::Sign(b'}') => return end,
            Kind::Sign(b';') => return lexer.next().end,
            Kind::Sign(b'(' | b'[' | b'{') => {
                lexer.next();
                end = past_closing(lexer).unwrap_or(token.end);
            }
            Kind::Word | Kind::Number | Kind::Sign(_) => end = lexer.next().end,
        }
    }
}

/// Skips past `,` outside brackets and templates; returns the end.
// `array<f32, 4>`: the comma in a template list ends no member.
fn list_item(lexer: &mut WgslLexer<'_>, mut end: u32) -> u32 {
    let mut templates = 0u32;
    loop {
        let token = lexer.peek();
        match token.kind {
            Kind::End | Kind::Sign(b'}' | b')' | b']') => return end,
            Kind::Sign(b',') if templates == 0 => return lexer.next().end,
            Kind::Sign(b'<') => templates += 1,
            Kind::Sign(b'>') => templates = templates.saturating_sub(1),
            Kind::Word | Kind::Number | Kind::Sign(_) => {}
        }
        lexer.next();
        end = match token.kind {
            Kind::Sign(b'(' | b'[' | b'{') => past_closing(lexer).unwrap_or(token.end),
            _ => token.end,
        };
    }
}

/// The value of a condition whose expression starts at `at`.
fn condition(text: &str, at: u32, is_set: &dyn Fn(&str) -> bool) -> Result<bool, Diagnostic> {
    let mut lexer = WgslLexer::new(text, at);
    let value = any(&mut lexer, is_set, 0)?;
    report::expect(&mut lexer, b')').map(|_| value)
}

// expression: all ( `||` all )*
// all: one ( `&&` one )*
// one: `!`* ( flag | `true` | `false` | `(` expression `)` )
fn any(
    lexer: &mut WgslLexer<'_>,
    is_set: &dyn Fn(&str) -> bool,
    depth: usize,
) -> Result<bool, Diagnostic> {
    let mut value = all(lexer, is_set, depth)?;
    while twice(lexer, b'|') {
        value |= all(lexer, is_set, depth)?;
    }
    Ok(value)
}

fn all(
    lexer: &mut WgslLexer<'_>,
    is_set: &dyn Fn(&str) -> bool,
    depth: usize,
) -> Result<bool, Diagnostic> {
    let mut value = one(lexer, is_set, depth)?;
    while twice(lexer, b'&') {
        value &= one(lexer, is_set, depth)?;
    }
    Ok(value)
}

/// Consumes a sign that stands twice.
fn twice(lexer: &mut WgslLexer<'_>, sign: u8) -> bool {
    lexer.take(sign) && lexer.take(sign)
}

fn one(
    lexer: &mut WgslLexer<'_>,
    is_set: &dyn Fn(&str) -> bool,
    depth: usize,
) -> Result<bool, Diagnostic> {
    let mut is_negated = false;
    while lexer.take(b'!') {
        is_negated = !is_negated;
    }
    let token: WgslToken = lexer.next();
    let value = match token.kind {
        Kind::Sign(b'(') if depth == DEEPEST_CONDITION => {
            return Err(too_deep(report::span(token)));
        }
        Kind::Sign(b'(') => {
            let value = any(lexer, is_set, depth + 1)?;
            report::expect(lexer, b')')?;
            value
        }
        Kind::Word => match lexer.text_of(token) {
            "true" => true,
            "false" => false,
            flag => is_set(flag),
        },
        Kind::Number | Kind::Sign(_) | Kind::End => {
            return Err(report::unexpected(lexer, token, "a flag"));
        }
    };
    Ok(value != is_negated)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tokens that are left with the flags `A` and `B`.
    fn left(text: &str) -> Vec<&str> {
        let text = applied(text, &|flag| matches!(flag, "A" | "B")).expect("it is right");
        super::super::super::tokens(Box::leak(text.into_boxed_str()))
    }

    #[test]
    fn declarations_members_parameters_and_statements_are_kept_or_left_out_whole() {
        for (text, expected) in [
            ("@if(A) const a = 1; const b = 2;", "const a = 1 ; const b = 2 ;"),
            ("@if(C) const a = vec2(1, 2); const b = 2;", "const b = 2 ;"),
            ("@if(C) fn f(a: i32) { if x { } } @else fn g() {}", "fn g ( ) { }"),
            ("@group(0) @if(C) @binding(1) var<uniform> a: A; var b: B;", "var b : B ;"),
            ("@group(0) @if(A) var<uniform> a: A;", "@ group ( 0 ) var < uniform > a : A ;"),
            (
                "struct S { @if(C) a: array<f32, 4>, @else b: u32, c: f32 }",
                "struct S { b : u32 , c : f32 }",
            ),
            ("struct S { a: f32, @if(C) @size(16) b: f32 }", "struct S { a : f32 , }"),
            ("fn f(a: i32, @if(C) b: vec2<f32>) {}", "fn f ( a : i32 , ) { }"),
            (
                "fn f() { @if(C) if a { b(); } else if c { d(); } else { e(); } g(); }",
                "fn f ( ) { g ( ) ; }",
            ),
            (
                "fn f() { @if(C) { a(); } @elif(A && !C) { b(); } @else { c(); } }",
                "fn f ( ) { { b ( ) ; } }",
            ),
            (
                "@if(A || C) { struct S { a: f32 } @if(C) const x = 1; } const y = 2;",
                "struct S { a : f32 } const y = 2 ;",
            ),
            ("@if(!(A && B)) { const a = 1; } @else { const b = 2; }", "const b = 2 ;"),
            ("@if(C) enable f16; @if(false) import a::b;", ""),
        ] {
            assert_eq!(left(text).join(" "), expected, "{text}");
        }
    }

    #[test]
    fn the_rest_keeps_its_place_and_lines() {
        let text = "@if(C)\nconst é = 1;\nconst b = 2;";
        let given = applied(text, &|_| false).expect("it is right");
        assert_eq!(given.len(), text.len());
        assert_eq!(given.find("const b"), text.find("const b"));
        assert_eq!(given.matches('\n').count(), 2);
    }

    #[test]
    fn an_else_needs_its_if_right_before_it() {
        for text in [
            "@else const a = 1;",
            "@if(A) const a = 1; const b = 2; @else const c = 3;",
            "@if(A const a = 1;",
            "@if() const a = 1;",
            "@elif(A) const a = 1;",
        ] {
            assert!(applied(text, &|_| true).is_err(), "{text}");
        }
    }
}
