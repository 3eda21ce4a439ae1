//! Parses declarations and expressions with the part of syn that derive macros use, which compiles
//! in half the time of the whole.
//!
//! Expressions that only the whole of syn parses, such as `if` and `match`, have no known value.
//! Used by [`file`](super::file) and [`types`](super::types).

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use syn::ext::IdentExt;
use syn::parse::{Parse, ParseStream};
use syn::{Attribute, DeriveInput, Expr, Generics, Ident, Token, Type, Visibility, WhereClause};

/// How syn's message begins where only the whole of syn could go on.
const UNSUPPORTED: &str = "unsupported expression";

/// Parses a structure declaration.
pub(super) fn structure(item: &[TokenTree]) -> syn::Result<DeriveInput> {
    let parsed = parse(item);
    match parsed {
        // Once more without the values that this part of syn does not parse.
        Err(cause) if is_unsupported(&cause) => syn::parse2(readable(item.iter().cloned())),
        parsed => parsed,
    }
}

/// Parses an expression; [`Expr::Verbatim`] without tokens if its value cannot be known.
pub(super) fn expression(tokens: TokenStream) -> syn::Result<Expr> {
    match syn::parse2(tokens) {
        Err(cause) if is_unsupported(&cause) => Ok(Expr::Verbatim(TokenStream::new())),
        parsed => parsed,
    }
}

/// Returns the expression in a block of nothing else.
pub(super) fn inside_block(block: &TokenStream) -> Option<Expr> {
    let mut tokens = block.clone().into_iter();
    match (tokens.next(), tokens.next()) {
        (Some(TokenTree::Group(group)), None) if group.delimiter() == Delimiter::Brace => {
            expression(group.stream()).ok()
        }
        _ => None,
    }
}

pub(super) fn parse<T: Parse>(item: &[TokenTree]) -> syn::Result<T> {
    syn::parse2(item.iter().cloned().collect())
}

fn is_unsupported(cause: &syn::Error) -> bool {
    cause.to_string().starts_with(UNSUPPORTED)
}

/// Replaces the lengths of arrays and the blocks that syn cannot parse by `()`.
fn readable(tokens: impl Iterator<Item = TokenTree>) -> TokenStream {
    tokens
        .map(|token| {
            let TokenTree::Group(group) = token else { return token };
            let inside: Vec<TokenTree> = group.stream().into_iter().collect();
            // `[f32; LENGTH]`, `Name<{ LENGTH }>`
            let from = match group.delimiter() {
                Delimiter::Bracket => inside.iter().position(is_semicolon).map(|at| at + 1),
                Delimiter::Brace => Some(0),
                Delimiter::Parenthesis | Delimiter::None => None,
            };
            let (type_part, value) = inside.split_at(from.unwrap_or(inside.len()));
            let parsed: syn::Result<Expr> = parse(value);
            let mut stream = readable(type_part.iter().cloned());
            match parsed {
                Err(cause) if is_unsupported(&cause) => {
                    let unit = Group::new(Delimiter::Parenthesis, TokenStream::new());
                    stream.extend([TokenTree::Group(unit)]);
                }
                _ => stream.extend(readable(value.iter().cloned())),
            }
            let mut replaced = Group::new(group.delimiter(), stream);
            replaced.set_span(group.span());
            TokenTree::Group(replaced)
        })
        .collect()
}

fn is_semicolon(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == ';')
}

/// `type NAME = TYPE;`
pub(super) struct Alias {
    pub name: Ident,
    pub generic: bool,
    pub ty: Type,
}

impl Parse for Alias {
    fn parse(input: ParseStream<'_>) -> syn::Result<Alias> {
        Attribute::parse_outer(input)?;
        input.parse::<Visibility>()?;
        input.parse::<Token![type]>()?;
        let name = input.parse()?;
        let generic = !input.parse::<Generics>()?.params.is_empty();
        input.parse::<Option<WhereClause>>()?;
        input.parse::<Token![=]>()?;
        let ty = input.parse()?;
        input.parse::<Token![;]>()?;
        Ok(Alias { name, generic, ty })
    }
}

/// The imported names of `use PATHS;` with their paths; a glob import has `*` and the path as its
/// name.
pub(super) struct Imports(pub Vec<(String, Vec<String>)>);

impl Parse for Imports {
    fn parse(input: ParseStream<'_>) -> syn::Result<Imports> {
        Attribute::parse_outer(input)?;
        input.parse::<Visibility>()?;
        input.parse::<Token![use]>()?;
        input.parse::<Option<Token![::]>>()?;
        let mut found = Vec::new();
        imports(input, &mut Vec::new(), &mut found)?;
        input.parse::<Token![;]>()?;
        Ok(Imports(found))
    }
}

fn imports(
    input: ParseStream<'_>,
    path: &mut Vec<String>,
    found: &mut Vec<(String, Vec<String>)>,
) -> syn::Result<()> {
    if input.parse::<Option<Token![*]>>()?.is_some() {
        found.push((format!("*{}", path.join("::")), path.clone()));
        return Ok(());
    }
    if input.peek(syn::token::Brace) {
        let list;
        syn::braced!(list in input);
        while !list.is_empty() {
            imports(&list, path, found)?;
            if !list.is_empty() {
                list.parse::<Token![,]>()?;
            }
        }
        return Ok(());
    }
    let name = unraw(&Ident::parse_any(input)?);
    if input.parse::<Option<Token![::]>>()?.is_some() {
        path.push(name);
        imports(input, path, found)?;
        path.pop();
        return Ok(());
    }
    let full = if name == "self" { path.clone() } else { [&path[..], &[name]].concat() };
    if input.parse::<Option<Token![as]>>()?.is_some() {
        // `_` is no word to `parse_any`.
        let renamed = match input.parse::<Option<Token![_]>>()? {
            Some(_) => "_".to_string(),
            None => unraw(&Ident::parse_any(input)?),
        };
        found.push((renamed, full));
    } else if let Some(last) = full.last().cloned() {
        found.push((last, full));
    }
    Ok(())
}

/// A name without its `r#`.
pub(super) fn unraw(name: &syn::Ident) -> String {
    let name = name.to_string();
    name.strip_prefix("r#").map_or(name.clone(), str::to_string)
}
