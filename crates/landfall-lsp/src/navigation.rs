//! From a name to its declaration, its uses, and the Rust field that feeds it; the symbols of a file and
//! of all shaders.

use std::path::{Path, PathBuf};

use gen_lsp_types::{
    BaseSymbolInformation, DocumentSymbol, DocumentSymbolParams, ImplementationParams, Location,
    ReferenceParams, SymbolKind, TextDocumentPositionParams, WorkspaceSymbol,
    WorkspaceSymbolParams,
};
use landfall_layout::format::phrases::counted;
use landfall_layout::text::glob;

use crate::declarations::{DeclarationKind, PlacedDeclaration};
use crate::owners::OwnerResolver;
use crate::paths::plain;
use crate::projects::is_shader;
use crate::publish::TextCache;
use crate::server::EditorServer;

/// Symbols that one answer has.
const MAX_SYMBOLS: usize = 500;

/// Shaders in which the members of a Rust structure are looked up.
const MAX_SHADERS: usize = 16;

impl EditorServer {
    /// The declarations of the name at a position, and the file of an include or import.
    pub fn definition(&mut self, params: &gen_lsp_types::DefinitionParams) -> Vec<Location> {
        let at = &params.text_document_position_params;
        let files = self.files_at(at);
        if !files.is_empty() {
            return files.iter().filter_map(|file| self.start_of(file)).collect();
        }
        let found = self.declarations_at(at);
        let mut places: Vec<Location> = Vec::new();
        for one in &found {
            let place = self.location_of(&one.file, one.span.clone());
            places.extend(place.filter(|place| !places.contains(place)));
        }
        places
    }

    /// The declarations that the name at a position may mean, in all shaders of its document.
    pub fn declarations_at(&mut self, at: &TextDocumentPositionParams) -> Vec<PlacedDeclaration> {
        let Some(document) = self.layouts_in(&at.text_document.uri) else { return Vec::new() };
        let offset = document.text.offset(at.position);
        let mut found: Vec<PlacedDeclaration> = Vec::new();
        for laid_out in &document.layouts {
            let named = laid_out.name_at(&document.shown, &document.text, offset);
            for one in named.into_iter().flat_map(|name| name.declarations) {
                if found.iter().all(|known| (&known.file, &known.span) != (&one.file, &one.span)) {
                    found.push(one.clone());
                }
            }
        }
        found
    }

    /// The files that the include or import at a position names.
    fn files_at(&mut self, at: &TextDocumentPositionParams) -> Vec<PathBuf> {
        let Some(document) = self.layouts_in(&at.text_document.uri) else { return Vec::new() };
        let offset = document.text.offset(at.position);
        let file = document.layouts.iter().find_map(|laid_out| {
            let include = laid_out.include_at(&document.shown, offset).map(PathBuf::from);
            include.or_else(|| laid_out.import_at(&document.text, offset))
        });
        file.into_iter().collect()
    }

    fn start_of(&self, file: &Path) -> Option<Location> {
        self.location_of(&file.to_string_lossy(), 0..0)
    }

    /// The fields of the program that feed the member at a position.
    pub fn implementation(&mut self, params: &ImplementationParams) -> Vec<Location> {
        let at = &params.text_document_position_params;
        let declarations = self.declarations_at(at);
        let path = crate::uris::path(&at.text_document.uri);
        let Some((index, setup, shown)) = path.and_then(|path| self.setup_of(&path)) else {
            return Vec::new();
        };
        let mirrors = &self.projects[index].found.mirrors;
        let mut places = Vec::new();
        for declaration in &declarations {
            for mirror in mirrors {
                match declaration.kind {
                    DeclarationKind::Member if mirror.is_of(&shown, &declaration.owner) => {
                        places.extend(mirror.field(&declaration.name).map(|field| &field.place));
                    }
                    kind if kind.has_members() && mirror.is_of(&shown, &declaration.name) => {
                        places.push(&mirror.place);
                    }
                    _ => {}
                }
            }
        }
        let mut texts = TextCache::new();
        let members = declarations.iter().filter(|one| one.kind == DeclarationKind::Member);
        let fields = members.flat_map(|one| self.program_fields(&setup, one));
        let in_headers = fields.filter_map(|field| {
            let place = field.place?;
            self.location_of(&place.path.to_string_lossy(), place.span)
        });
        let in_rust = places.iter().map(|place| self.location(place, &mut texts));
        in_rust.chain(in_headers).collect()
    }

    /// The members that the field at a position of Rust, C or C++ feeds; in a shader, the declarations of a
    /// name.
    pub fn declaration(&mut self, params: &gen_lsp_types::DeclarationParams) -> Vec<Location> {
        let at = &params.text_document_position_params;
        let Some(path) = crate::uris::path(&at.text_document.uri) else { return Vec::new() };
        if is_shader(&path) {
            let places = self.declarations_at(at);
            let place = |one: &PlacedDeclaration| self.location_of(&one.file, one.span.clone());
            return places.iter().filter_map(place).collect();
        }
        let Some(text) = self.documents.text(&path) else { return Vec::new() };
        let offset = text.offset(at.position);
        let mut found = Vec::new();
        for index in 0..self.projects.len() {
            for (shader, owner, member) in self.fed_at(index, &path, offset) {
                let Some(laid_out) = self.laid_out(index, &shader) else { continue };
                for one in &laid_out.declarations {
                    let is_it = match &member {
                        Some(name) => one.owner == owner && one.name.eq_ignore_ascii_case(name),
                        None => one.name == owner && one.kind.has_members(),
                    };
                    let place = self.location_of(&one.file, one.span.clone()).filter(|_| is_it);
                    found.extend(place.filter(|place| !found.contains(place)));
                }
            }
        }
        found
    }

    /// What the mirror at a byte of a Rust file or header copies: shader, block and member.
    fn fed_at(
        &self,
        index: usize,
        path: &Path,
        offset: u32,
    ) -> Vec<(String, String, Option<String>)> {
        let found = &self.projects[index].found;
        let mut fed = Vec::new();
        for mirror in &found.mirrors {
            let holds = |place: &landfall_layout::finding::Place| {
                (place.start..=place.end).contains(&offset) && self.absolute(&place.path) == path
            };
            let field = mirror.fields.iter().find(|field| holds(&field.place));
            if field.is_none() && !holds(&mirror.place) {
                continue;
            }
            let member = field.map(|field| mirror.member(&field.name).to_string());
            let shaders = found.shaders.keys().filter(|one| glob::matches(&mirror.shader, one));
            let shaders = shaders.take(MAX_SHADERS);
            fed.extend(shaders.map(|one| (one.clone(), mirror.block.clone(), member.clone())));
        }
        if let Some(setup) = &self.projects[index].setup {
            for (file, owner, member) in self.held_at(setup, path, offset) {
                let shaders = found.shaders.keys().filter(|one| file.takes(one));
                let shaders = shaders.take(MAX_SHADERS);
                fed.extend(shaders.map(|one| (one.clone(), owner.clone(), member.clone())));
            }
        }
        fed
    }

    /// The uses of the name at a position in all shaders that have a file which declares it.
    pub fn references(&mut self, params: &ReferenceParams) -> Vec<Location> {
        let at = &params.text_document_position_params;
        let declarations = self.declarations_at(at);
        let path = crate::uris::path(&at.text_document.uri);
        let Some((index, _, shown)) = path.and_then(|path| self.setup_of(&path)) else {
            return Vec::new();
        };
        let mut found = Vec::new();
        for declaration in &declarations {
            for shader in self.shaders_declaring(index, &shown, declaration) {
                let Some(laid_out) = self.laid_out(index, &shader) else { continue };
                for file in laid_out.shader.files.written() {
                    let path = plain(&file.path);
                    let resolver = OwnerResolver::new(&laid_out, &file.text);
                    let named =
                        resolver.words().iter().filter(|word| word.text == declaration.name);
                    for word in named {
                        let is_declaration =
                            path == declaration.file && word.span == declaration.span;
                        let is_meant = laid_out.meant(&path, &resolver, word).iter().any(|one| {
                            one.span == declaration.span && one.file == declaration.file
                        });
                        if !is_meant || is_declaration && !params.context.include_declaration {
                            continue;
                        }
                        let place = self.location_of(&path, word.span.clone());
                        found.extend(place.filter(|place| !found.contains(place)));
                    }
                }
            }
        }
        found
    }

    /// The shaders that have the file of a declaration, that of a document first.
    pub fn shaders_declaring(
        &self,
        index: usize,
        shown: &str,
        declaration: &PlacedDeclaration,
    ) -> Vec<String> {
        let project = &self.projects[index];
        let mut shaders = vec![shown.to_string()];
        if project.shader(&declaration.file).is_some() {
            shaders.push(declaration.file.clone());
        }
        shaders.extend(project.shaders_with(&declaration.file).into_iter().map(str::to_string));
        let mut seen = std::collections::HashSet::new();
        shaders.retain(|shader| seen.insert(shader.clone()));
        shaders
    }

    /// The blocks and structures of a document, with their members.
    pub fn document_symbols(&mut self, params: &DocumentSymbolParams) -> Vec<DocumentSymbol> {
        let Some(document) = self.layouts_in(&params.text_document.uri) else { return Vec::new() };
        let declarations = document.declarations();
        let owners = declarations.iter().filter(|one| one.kind.has_members());
        let symbol = |one: &PlacedDeclaration,
                      kind,
                      detail: Option<String>,
                      children: Vec<DocumentSymbol>| {
            let own = document.text.range(one.span.clone());
            let end = children.iter().map(|child| child.range.end).max().unwrap_or(own.end);
            #[allow(deprecated)]
            DocumentSymbol {
                name: one.name.clone(),
                detail,
                kind,
                tags: None,
                deprecated: None,
                range: gen_lsp_types::Range { start: own.start, end: end.max(own.end) },
                selection_range: own,
                children: (!children.is_empty()).then_some(children),
            }
        };
        let of_owner = |owner: &PlacedDeclaration| {
            let next = declarations
                .iter()
                .find(|one| one.kind.has_members() && one.span.start > owner.span.start);
            let own = declarations.iter().filter(|one| {
                one.owner == owner.name
                    && one.span.start > owner.span.start
                    && next.is_none_or(|next| one.span.start < next.span.start)
            });
            let members = own.map(|one| {
                let placement = one.uses.first();
                let detail = placement.map(|at| format!("@{} {}", at.bytes.offset, at.ty));
                symbol(one, SymbolKind::Field, detail, Vec::new())
            });
            let size = owner.uses.first().and_then(|at| at.bytes.size);
            let detail = size.map(|size| counted(size as usize, "byte"));
            symbol(owner, SymbolKind::Struct, detail, members.collect())
        };
        owners.map(of_owner).collect()
    }

    /// The blocks of all shaders whose names have the letters of a query in order.
    pub fn workspace_symbols(&mut self, params: &WorkspaceSymbolParams) -> Vec<WorkspaceSymbol> {
        let mut texts = TextCache::new();
        let blocks = self.projects.iter().flat_map(|project| &project.found.blocks);
        let named = blocks.flat_map(|(shader, blocks)| blocks.iter().map(move |one| (shader, one)));
        let mut named: Vec<_> =
            named.filter(|(_, (name, _))| has_letters(name, &params.query)).collect();
        named.sort();
        let symbol = |(shader, (name, place)): (&String, &(String, _))| WorkspaceSymbol {
            location: self.location(place, &mut texts).into(),
            data: None,
            base_symbol_information: BaseSymbolInformation {
                name: name.clone(),
                kind: SymbolKind::Struct,
                tags: None,
                container_name: Some(shader.clone()),
            },
        };
        named.into_iter().take(MAX_SYMBOLS).map(symbol).collect()
    }
}

fn has_letters(name: &str, query: &str) -> bool {
    let mut letters = name.chars().flat_map(char::to_lowercase);
    query.chars().flat_map(char::to_lowercase).all(|wanted| letters.any(|c| c == wanted))
}
