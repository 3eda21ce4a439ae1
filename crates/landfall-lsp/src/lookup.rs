//! What a position of a text is about: a declaration, a use of its name, or the name of a file.

use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::declarations::{DeclarationKind, PlacedDeclaration};
use crate::laid_out::LaidOut;
use crate::owners::OwnerResolver;
use crate::paths::plain;
use crate::positions::LineText;
use crate::words::TextWord;

/// A name at a position, and the declarations that it may mean.
pub struct NameAt<'l> {
    pub span: Range<u32>,
    pub declarations: Vec<&'l PlacedDeclaration>,
}

impl LaidOut {
    /// The declarations in a file of the shader.
    pub fn in_file(&self, shown: &str) -> impl Iterator<Item = &PlacedDeclaration> {
        self.declarations.iter().filter(move |one| one.file == shown)
    }

    /// The declarations that a word of one of its files may mean: of its owner, or all of its name where
    /// that is unknown.
    pub fn meant<'l>(
        &'l self,
        shown: &str,
        resolver: &OwnerResolver<'_>,
        word: &TextWord<'_>,
    ) -> Vec<&'l PlacedDeclaration> {
        if let Some(own) = self.in_file(shown).find(|one| one.span == word.span) {
            return vec![own];
        }
        let owner = resolver.owner(word);
        let named = self.declarations.iter().filter(|one| one.name == word.text);
        let fits = |one: &&PlacedDeclaration| match one.kind {
            DeclarationKind::Member if word.is_behind_dot => {
                owner.as_ref().is_none_or(|owner| one.owner == *owner)
            }
            DeclarationKind::Member => one.is_global() && !resolver.is_local(word),
            DeclarationKind::Block | DeclarationKind::Structure | DeclarationKind::Variable => {
                !word.is_behind_dot
            }
        };
        named.filter(fits).collect()
    }

    /// The name at a byte of one of its files.
    pub fn name_at(&self, shown: &str, text: &LineText, offset: u32) -> Option<NameAt<'_>> {
        let span = text.word(offset)?;
        let plain = text.plain();
        let resolver = OwnerResolver::new(self, plain);
        let word = resolver.words().iter().find(|word| word.span == span)?;
        let declarations = self.meant(shown, &resolver, word);
        (!declarations.is_empty()).then_some(NameAt { span, declarations })
    }

    /// The file that the `#include` at a byte of one of its files has opened.
    pub fn include_at(&self, shown: &str, offset: u32) -> Option<String> {
        let interface = self.shader.interface.as_ref()?;
        let include = interface.includes.iter().find(|include| {
            let span = self.shader.files.resolve(include.span);
            let is_here =
                self.shader.files.get(span.file).is_some_and(|file| plain(&file.path) == shown);
            let line = self.shader.files.locate(span).line;
            is_here && line == self.line_of(shown, offset)
        })?;
        self.shader.files.get(include.file).map(|file| plain(&file.path))
    }

    fn line_of(&self, shown: &str, offset: u32) -> u32 {
        let file = self.shader.files.iter().find(|file| plain(&file.path) == shown);
        let before = file.and_then(|file| file.text.get(..offset as usize)).unwrap_or_default();
        before.matches('\n').count() as u32 + 1
    }

    /// The file that an import at a byte names, by the last words of its path that is the name of a
    /// file of the shader: `import package::lights::{Light}`.
    pub fn import_at(&self, text: &LineText, offset: u32) -> Option<PathBuf> {
        let plain = text.plain();
        let at = offset as usize;
        let start = plain.get(..at)?.rfind(['\n', ';']).map_or(0, |end| end + 1);
        let end = plain.get(at..)?.find(['\n', ';']).map_or(plain.len(), |end| at + end);
        let line = &plain[start..end];
        let is_import = ["import", "#import"].iter().any(|word| {
            line.trim_start().strip_prefix(word).is_some_and(|rest| rest.starts_with([' ', '\t']))
        });
        if !is_import {
            return None;
        }
        let span = text.word(offset)?;
        let name = text.slice(span);
        let files = self.shader.files.written();
        let stem_is = |path: &str| Path::new(path).file_stem().is_some_and(|stem| stem == name);
        let mut found = files.map(|file| &file.path).filter(|path| stem_is(path));
        found.next().map(PathBuf::from)
    }
}
