//! The fields of C and C++ that `[[assert]]` holds to members, with their places in the headers that it names.

use std::collections::HashSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use landfall_check::config::AssertionFile;

use crate::declarations::PlacedDeclaration;
use crate::headers::{HeaderStructure, included, structures};
use crate::project::CheckSetup;
use crate::server::EditorServer;

/// Headers that are read for one file of assertions.
const MAX_HEADERS: usize = 32;

/// A field of the program that is held to a member.
pub struct ProgramField {
    /// Its name with that of its structure.
    pub name: String,
    /// The file of the assertions.
    pub out: PathBuf,
    /// Its place in a header; `None` where no header that is named declares it.
    pub place: Option<HeaderPlace>,
}

/// A name in a header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeaderPlace {
    pub path: PathBuf,
    pub span: Range<u32>,
    /// From 1.
    pub line: u32,
}

/// The name that a structure of the program has for a member; `None` if it has none.
fn field_of(file: &AssertionFile, owner: &str, member: &str) -> Option<String> {
    let assertions = &file.options.assertions;
    let key = format!("{owner}.{member}");
    let renamed = assertions.fields.iter().find(|(member, _)| *member == key);
    match renamed {
        Some((_, field)) => Some(field.clone()).filter(|field| !field.is_empty()),
        None => Some(format!("{}{member}", assertions.field_prefix)),
    }
}

/// The member that a field of the program is held to.
fn member_of(file: &AssertionFile, owner: &str, field: &str) -> Option<String> {
    let assertions = &file.options.assertions;
    let of_owner = |key: &str| key.strip_prefix(owner)?.strip_prefix('.').map(str::to_string);
    let renamed = assertions.fields.iter().filter(|(_, name)| name == field);
    let renamed = renamed.filter_map(|(key, _)| of_owner(key)).next();
    renamed.or_else(|| field.strip_prefix(assertions.field_prefix.as_str()).map(str::to_string))
}

/// Whether a name of the configuration, `engine::Light` or `struct light`, is that of a structure.
fn is_named(structure: &HeaderStructure, own: &str) -> bool {
    let own = own.trim_start_matches("struct ").trim_start_matches("::");
    structure.name == own
}

impl EditorServer {
    /// The fields of the program that assertions hold to a member.
    pub fn program_fields(
        &self,
        setup: &CheckSetup,
        declaration: &PlacedDeclaration,
    ) -> Vec<ProgramField> {
        let mut found = Vec::new();
        for file in &setup.config.assertions {
            let structures = &file.options.assertions.structures;
            let own = structures.iter().filter(|(_, of)| *of == declaration.owner);
            for (own, _) in own {
                let field = field_of(file, &declaration.owner, &declaration.name);
                let Some(field) = field else { continue };
                let headers = self.headers(setup, file);
                let place = headers.iter().find_map(|(path, structures)| {
                    let one = structures.iter().find(|one| is_named(one, own))?;
                    let (_, span) = one.fields.iter().find(|(name, _)| *name == field)?;
                    let line = self.documents.text(path)?.position(span.start).line + 1;
                    Some(HeaderPlace { path: path.clone(), span: span.clone(), line })
                });
                let name = format!("{own}.{field}");
                found.push(ProgramField { name, out: file.out.clone(), place });
            }
        }
        found
    }

    /// What the field or structure at a byte of a header is held to: the file of the assertions, the
    /// block or structure, and the member.
    pub fn held_at<'s>(
        &self,
        setup: &'s CheckSetup,
        path: &Path,
        offset: u32,
    ) -> Vec<(&'s AssertionFile, String, Option<String>)> {
        let mut held = Vec::new();
        let is_here = |span: &Range<u32>| (span.start..=span.end).contains(&offset);
        for file in &setup.config.assertions {
            let headers = self.headers(setup, file);
            let here = headers.iter().filter(|(header, _)| header == path);
            for structure in here.flat_map(|(_, structures)| structures) {
                let field = structure.fields.iter().find(|(_, span)| is_here(span));
                if field.is_none() && !is_here(&structure.span) {
                    continue;
                }
                let all = file.options.assertions.structures.iter();
                for (_, owner) in all.filter(|(own, _)| is_named(structure, own)) {
                    let member = field.map(|(name, _)| member_of(file, owner, name));
                    // A field that stands for no member is held to nothing.
                    if !matches!(member, Some(None)) {
                        held.push((file, owner.clone(), member.flatten()));
                    }
                }
            }
        }
        held
    }

    /// The headers that a file of assertions includes, and those that these include, as they are edited.
    fn headers(
        &self,
        setup: &CheckSetup,
        file: &AssertionFile,
    ) -> Vec<(PathBuf, Vec<HeaderStructure>)> {
        let out = self.absolute(&file.out.to_string_lossy());
        let folder = out.parent().unwrap_or(Path::new(""));
        let config = setup.config.file.as_ref().and_then(|config| config.parent());
        let base = config.map(|base| self.absolute(&base.to_string_lossy()));
        let base = base.unwrap_or_else(|| self.current.clone());
        // A compiler has folders of its own: those that projects usually have are tried.
        let mut folders: Vec<PathBuf> = folder
            .ancestors()
            .take_while(|one| one.starts_with(&base))
            .map(Path::to_path_buf)
            .collect();
        folders.extend([base.join("include"), base.join("src"), base]);
        let mut waiting: Vec<(PathBuf, String)> = file
            .options
            .c
            .includes
            .iter()
            .rev()
            .map(|name| (folder.into(), name.clone()))
            .collect();
        let mut seen = HashSet::new();
        let mut found = Vec::new();
        while let Some((beside, name)) = waiting.pop() {
            let places = std::iter::once(&beside).chain(&folders).map(|folder| folder.join(&name));
            let mut texts = places.filter_map(|path| {
                let path = self.absolute(&crate::paths::plain(&path.to_string_lossy()));
                Some((self.documents.text(&path)?, path))
            });
            let Some((text, path)) = texts.next() else { continue };
            if found.len() >= MAX_HEADERS || !seen.insert(path.clone()) {
                continue;
            }
            let beside = path.parent().unwrap_or(Path::new("")).to_path_buf();
            let plain = text.plain();
            waiting.extend(included(plain).map(|name| (beside.clone(), name.to_string())));
            found.push((path, structures(plain)));
        }
        found
    }
}
