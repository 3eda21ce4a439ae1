//! Whose member a name behind a `.` is: followed through the expression before it, as far as blocks,
//! structures and declared types tell.
//!
//! Calls, aliases and pointers that are dereferenced are not followed; what then is meant is unknown.

use landfall_layout::Language;

use crate::declarations::{DeclarationKind, PlacedDeclaration};
use crate::laid_out::LaidOut;
use crate::words::{TextWord, words};

/// Expressions that are followed through `let a = b.c;` from one to the next.
const DEEPEST: usize = 8;

/// The words of a file, and the shader whose blocks they may mean.
pub struct OwnerResolver<'l> {
    laid_out: &'l LaidOut,
    text: &'l str,
    words: Vec<TextWord<'l>>,
}

impl<'l> OwnerResolver<'l> {
    pub fn new(laid_out: &'l LaidOut, text: &'l str) -> OwnerResolver<'l> {
        OwnerResolver { laid_out, text, words: words(text) }
    }

    pub fn words(&self) -> &[TextWord<'l>] {
        &self.words
    }

    /// The block or structure whose member a word behind a `.` is; `None` if that is unknown.
    pub fn owner(&self, word: &TextWord<'_>) -> Option<String> {
        if !word.is_behind_dot {
            return None;
        }
        self.type_of(self.before_dot(word.span.start)?, DEEPEST)
    }

    /// Whether a word is a parameter or local variable of GLSL, declared in the function that it is in.
    pub fn is_local(&self, word: &TextWord<'_>) -> bool {
        let start = item_start(self.text, word.span.start as usize) as u32;
        let inside = self.words.iter().enumerate().filter(|(_, other)| {
            other.text == word.text && (start..=word.span.start).contains(&other.span.start)
        });
        inside
            .filter(|(_, other)| !other.is_behind_dot)
            .any(|(index, _)| self.declared(index, DEEPEST).is_some())
    }

    /// The words of the expression before the `.` before a byte, from its first.
    fn before_dot(&self, end: u32) -> Option<Vec<usize>> {
        let before = self.text[..end as usize].trim_end().strip_suffix('.')?;
        self.chain(before)
    }

    /// The words of an expression of names, members and indices that a text ends with.
    fn chain(&self, mut before: &str) -> Option<Vec<usize>> {
        let mut chain = Vec::new();
        loop {
            before = before.trim_end();
            while before.ends_with(']') {
                before = &before[..opening(before)?];
                before = before.trim_end();
            }
            let end = before.len() as u32;
            let at = self.words.binary_search_by_key(&end, |word| word.span.end).ok()?;
            chain.insert(0, at);
            before = &before[..self.words[at].span.start as usize];
            match before.trim_end().strip_suffix('.') {
                Some(rest) => before = rest,
                None => return Some(chain),
            }
        }
    }

    /// The structure or block of an expression.
    fn type_of(&self, chain: Vec<usize>, depth: usize) -> Option<String> {
        let (root, members) = chain.split_first()?;
        let mut owner = self.type_of_name(*root, depth)?;
        for member in members {
            owner = self.member(&owner, self.words[*member].text)?.structure.clone()?;
        }
        Some(owner)
    }

    fn member(&self, owner: &str, name: &str) -> Option<&'l PlacedDeclaration> {
        let is_it = |one: &&PlacedDeclaration| {
            one.kind == DeclarationKind::Member && one.owner == owner && one.name == name
        };
        self.laid_out.declarations.iter().find(is_it)
    }

    /// The structure or block of a variable: as it is declared last before its use, or as a block is.
    fn type_of_name(&self, at: usize, depth: usize) -> Option<String> {
        let name = self.words[at].text;
        let depth = depth.checked_sub(1)?;
        let before = self.words[..at].iter().enumerate().rev();
        let mut declared = before
            .filter(|(_, word)| word.text == name && !word.is_behind_dot)
            .filter_map(|(index, _)| self.declared(index, depth));
        declared.next().or_else(|| self.of_block(name))
    }

    /// The type that a declaration gives its name, if a word is that name.
    fn declared(&self, index: usize, depth: usize) -> Option<String> {
        let word = &self.words[index];
        let after = self.text[word.span.end as usize..].trim_start();
        let previous = index.checked_sub(1).map(|before| &self.words[before]);
        let is_beside = |other: &TextWord<'_>| {
            let between = &self.text[other.span.end as usize..word.span.start as usize];
            between.trim().is_empty()
        };
        if self.laid_out.shader.language == Language::Wgsl {
            if let Some(ty) = after.strip_prefix(':') {
                return self.structure_in(&ty[..end_of_type(ty)]);
            }
            let value = after.strip_prefix('=').filter(|rest| !rest.starts_with('='))?;
            let is_let = previous.is_some_and(|word| matches!(word.text, "let" | "var" | "const"));
            let end = self.text.len() - value.len() + value.find(';')?;
            let start = self.text.len() - value.len();
            let first = self.text[start..end].trim_start_matches([' ', '\n', '\r', '\t', '&']);
            let chain = self.chain(&self.text[..end]).filter(|_| is_let)?;
            // An operator before the last names would make it another value.
            let begins = self.words[*chain.first()?].span.start as usize;
            return (end - first.len() == begins).then(|| self.type_of(chain, depth)).flatten();
        }
        let ty = previous.filter(|word| is_beside(word) && !word.is_behind_dot)?;
        let is_declared = after.starts_with([';', '=', ',', ')', '[']) && !after.starts_with("==");
        let is_keyword = matches!(ty.text, "return" | "else" | "in" | "out" | "inout" | "const");
        (is_declared && !is_keyword).then(|| ty.text.to_string())
    }

    /// The first structure that the text of a WGSL type names, or its last name.
    fn structure_in(&self, ty: &str) -> Option<String> {
        let names = words(ty);
        let is_owner = |name: &str| {
            self.laid_out
                .declarations
                .iter()
                .any(|one| one.name == name && one.kind != DeclarationKind::Member)
        };
        let known = names.iter().find(|word| is_owner(word.text));
        known.or(names.last()).map(|word| word.text.to_string())
    }

    fn of_block(&self, name: &str) -> Option<String> {
        let blocks = &self.laid_out.shader.blocks;
        let variable = blocks.iter().find(|block| block.instance.as_deref() == Some(name));
        if let Some(block) = variable {
            // WGSL: a variable that is an array of structures is a block of one member.
            let only = self.member(&block.name, name).and_then(|one| one.structure.clone());
            return only.or_else(|| Some(block.name.to_string()));
        }
        let mut all = self.laid_out.declarations.iter();
        let global = all.find(|one| one.name == name && one.is_global());
        global.and_then(|one| one.structure.clone())
    }
}

/// The start of the function, block or variable that a byte is in.
fn item_start(text: &str, byte: usize) -> usize {
    let (mut depth, mut start) = (0_usize, 0);
    for (at, c) in text[..byte].char_indices() {
        match c {
            '{' => depth += 1,
            '}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    start = at + 1;
                }
            }
            ';' if depth == 0 => start = at + 1,
            _ => {}
        }
    }
    start
}

/// The start of the `[` that belongs to the `]` at the end.
fn opening(text: &str) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, c) in text.char_indices().rev() {
        match c {
            ']' => depth += 1,
            '[' if depth == 1 => return Some(at),
            '[' => depth -= 1,
            ';' | '{' | '}' => return None,
            _ => {}
        }
    }
    None
}

/// The end of a WGSL type: before the `,`, `;`, `=`, `)` or `{` behind it.
fn end_of_type(text: &str) -> usize {
    let mut depth = 0_usize;
    for (at, c) in text.char_indices() {
        match c {
            '<' | '(' => depth += 1,
            '>' => depth = depth.saturating_sub(1),
            ')' if depth > 0 => depth -= 1,
            ',' | ')' | '=' if depth == 0 => return at,
            ';' | '{' | '}' => return at,
            _ => {}
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use landfall_layout::{Options, Source, layout};

    use super::*;
    use crate::declarations::declarations;

    fn owners(path: &str, text: &str, name: &str) -> Vec<Option<String>> {
        let source = Source::new(path, text);
        let shader = layout(&source, &Options::default());
        assert!(!shader.has_errors(), "{:?}", shader.diagnostics);
        let declarations = declarations(&shader);
        let laid_out = LaidOut { source, shader, declarations };
        let text: Arc<str> = text.into();
        let resolver = OwnerResolver::new(&laid_out, &text);
        let behind = resolver.words().iter().filter(|word| word.text == name && word.is_behind_dot);
        behind.map(|word| resolver.owner(word)).collect()
    }

    #[test]
    fn members_of_glsl_are_followed_to_their_structures() {
        let text = "#version 450\n\
            struct Light { vec3 color; }; struct Sun { vec3 color; }; struct Local { vec3 color; };\n\
            layout(std140, binding = 0) uniform Lights { Light data[4]; Sun sun; } lights;\n\
            layout(std140, binding = 1) uniform Bare { Light first; };\n\
            Light pick(int i) { return lights.data[i]; }\n\
            void main() {\n\
              vec3 a = lights.data[ int(lights.sun.color.x) ].color + first.color;\n\
              Light l = lights.data[0]; a += l.color; Local o; a += o.color; a += pick(1).color;\n\
            }\n";
        let some = |name: &str| Some(name.to_string());
        let expected =
            [some("Sun"), some("Light"), some("Light"), some("Light"), some("Local"), None];
        assert_eq!(owners("a.frag", text, "color"), expected);
    }

    #[test]
    fn members_of_wgsl_are_followed_to_their_structures() {
        let text = "struct Light { color: vec3f } struct Lights { data: array<Light, 4>, sun: Light }\n\
            struct Local { color: vec3f }\n\
            @group(0) @binding(0) var<uniform> lights: Lights;\n\
            @group(0) @binding(1) var<storage> many: array<Light>;\n\
            fn shade(light: Light, at: ptr<function, Local>) -> vec3f {\n\
              let sun = lights.sun; let chosen = many[2]; let sum = lights.sun.color + sun.color;\n\
              var local: Local; let p = &lights.data[1];\n\
              return light.color + at.color + sum + chosen.color + local.color + (*p).color + p.color;\n\
            }\n\
            @fragment fn main() -> @location(0) vec4f { return vec4f(); }\n";
        let some = |name: &str| Some(name.to_string());
        let expected = [
            some("Light"),
            some("Light"),
            some("Light"),
            some("Local"),
            some("Light"),
            some("Local"),
            None,
            some("Light"),
        ];
        assert_eq!(owners("a.wgsl", text, "color"), expected);
    }
}
