//! What a hover tells: the bytes of a member with the reasons, the listing of a block, the field that
//! feeds it, and where an include leads.

use std::path::Path;

use landfall_layout::format::explain::{Answer, text as explained};
use landfall_layout::format::phrases::{counted, numbered};
use landfall_layout::format::{EmitOptions, Format, Paint, shader as listed};
use landfall_layout::layout::explain::explain;
use landfall_layout::{BlockLayout, Language, Options, Rules, ShaderLayout, layout};
use landfall_lint::rust_mirror::MirroredStructure;

use crate::declarations::{BlockPlacement, DeclarationKind, PlacedDeclaration};
use crate::laid_out::LaidOut;
use crate::memory_map::memory_map;
use crate::program_fields::ProgramField;

/// Declarations of one name that a hover shows.
const LIMIT: usize = 3;

/// Lines of a listing that a hover shows.
const MAX_LINES: usize = 48;

/// What a hover needs to know.
pub struct HoverContext<'a> {
    pub laid_out: &'a LaidOut,
    /// By which it was laid out.
    pub options: &'a Options,
    pub mirrors: &'a [MirroredStructure],
    /// The layout in the lock, if there is one.
    pub locked: Option<&'a ShaderLayout>,
    /// The fields of the program that assertions hold to a member.
    pub program_fields: &'a dyn Fn(&PlacedDeclaration) -> Vec<ProgramField>,
    /// A path as findings have it.
    pub shown: &'a dyn Fn(&Path) -> String,
    /// The address of a file and line.
    pub link: &'a dyn Fn(&Path, u32) -> String,
}

impl HoverContext<'_> {
    /// The text of a hover over a name that may mean these declarations.
    pub fn of_name(&self, declarations: &[&PlacedDeclaration]) -> String {
        let shown = declarations.iter().take(LIMIT).map(|one| self.of_declaration(one));
        let mut text = shown.collect::<Vec<_>>().join("\n\n---\n\n");
        if let Some(more @ 1..) = declarations.len().checked_sub(LIMIT) {
            text.push_str(&format!("\n\nand {} of this name", counted(more, "more declaration")));
        }
        text
    }

    fn of_declaration(&self, declaration: &PlacedDeclaration) -> String {
        match declaration.kind {
            DeclarationKind::Member => self.member(declaration),
            DeclarationKind::Block | DeclarationKind::Structure | DeclarationKind::Variable => {
                self.whole(declaration)
            }
        }
    }

    fn member(&self, declaration: &PlacedDeclaration) -> String {
        let mut text = String::new();
        for placement in declaration.distinct() {
            let block = &self.laid_out.shader.blocks[placement.block];
            let bytes = &placement.bytes;
            text.push_str(&format!(
                "`{}` of `{}`, {}: `{}`\n\n",
                placement.path,
                block.name,
                placement.rules.name(),
                placement.ty
            ));
            let mut numbers = vec![format!("offset **{}**", bytes.offset)];
            if placement.first != bytes.offset {
                numbers.push(format!("byte {} of the block", placement.first));
            }
            numbers.push(match bytes.size {
                Some(size) => counted(size as usize, "byte"),
                None => "runtime-sized".to_string(),
            });
            numbers.push(format!("aligned to {}", bytes.align));
            let strides = bytes.strides.iter().map(|stride| format!("stride {stride}"));
            numbers.extend(strides);
            for (padding, place) in [(bytes.before, "before"), (bytes.after, "after")] {
                if padding > 0 {
                    numbers.push(format!("{padding} of padding {place} it"));
                }
            }
            text.push_str(&format!("{}\n\n", numbers.join(", ")));
            let others = self.under_other_rules(placement);
            if !others.is_empty() {
                text.push_str(&format!("{others}\n\n"));
            }
        }
        text.push_str(&self.fields(declaration));
        text.push_str(&self.asserted(declaration));
        if let Some(first) = declaration.uses.first() {
            text.push_str(&self.reasons(first));
        }
        text.trim_end().to_string()
    }

    /// The places of a member under other rules, where they differ.
    fn under_other_rules(&self, placement: &BlockPlacement) -> String {
        let shader = &self.laid_out.shader;
        let block = &shader.blocks[placement.block];
        let place = |shader: &ShaderLayout| {
            let block = shader.blocks.iter().find(|other| other.span == block.span)?;
            let found = explain(block, &placement.path, shader.language).ok()?;
            Some((found.offset, found.size))
        };
        let own = place(shader);
        let others = Rules::OF_TEXT.into_iter().filter(|rules| *rules != placement.rules);
        let differing = others.filter_map(|rules| {
            let options = self.options.clone().with_rules(Some(rules));
            let there = place(&layout(&self.laid_out.source, &options))?;
            (Some(there) != own).then(|| {
                let size =
                    there.1.map_or(String::new(), |size| format!(", {}", numbered(size, "byte")));
                format!("{}: byte {}{size}", rules.name(), there.0)
            })
        });
        differing.collect::<Vec<_>>().join(" · ")
    }

    /// The fields of Rust that feed a member.
    fn fields(&self, declaration: &PlacedDeclaration) -> String {
        let mut text = String::new();
        for mirror in self.mirrors {
            let is_fed = mirror.is_of(&self.laid_out.shader.path, &declaration.owner);
            let Some(field) = mirror.field(&declaration.name).filter(|_| is_fed) else { continue };
            let place = &field.place;
            let offset = field.offset.map_or(String::new(), |at| format!(", byte {at}"));
            text.push_str(&format!(
                "Fed by `{}.{}: {}`{offset}: [{}:{}]({})\n\n",
                mirror.name,
                field.name,
                field.ty,
                place.path,
                place.line,
                (self.link)(Path::new(&place.path), place.line)
            ));
        }
        text
    }

    /// The fields of structures of the program that assertions hold to a member.
    fn asserted(&self, declaration: &PlacedDeclaration) -> String {
        let mut text = String::new();
        for field in (self.program_fields)(declaration) {
            let out = field.out.display().to_string();
            let link = (self.link)(&field.out, 1);
            let name = &field.name;
            let place = field.place.map_or(String::new(), |place| {
                let path = (self.shown)(&place.path);
                let link = (self.link)(&place.path, place.line);
                format!(", [{path}:{}]({link}),", place.line)
            });
            text.push_str(&format!("`{name}`{place} is held to it by [{out}]({link})\n\n"));
        }
        text
    }

    fn reasons(&self, placement: &BlockPlacement) -> String {
        let shader = &self.laid_out.shader;
        let block = &shader.blocks[placement.block];
        match explain(block, &placement.path, shader.language) {
            Ok(found) => {
                let text = explained(block, shader.language, &Answer::Path(found), Paint::Plain);
                format!("```text\n{}\n```\n", text.trim_end())
            }
            Err(_) => String::new(),
        }
    }

    fn whole(&self, declaration: &PlacedDeclaration) -> String {
        let mut text = String::new();
        for placement in declaration.distinct() {
            let block = &self.laid_out.shader.blocks[placement.block];
            let bytes = &placement.bytes;
            let padding = match bytes.after {
                0 => "no padding".to_string(),
                padding => format!("{padding} of them padding"),
            };
            text.push_str(&format!(
                "`{}`, {}: **{}**, {padding}, aligned to {}\n\n",
                declaration.name,
                placement.rules.name(),
                counted(bytes.size.unwrap_or_default() as usize, "byte"),
                bytes.align
            ));
            if declaration.kind != DeclarationKind::Structure {
                let language = match self.laid_out.shader.language {
                    Language::Wgsl => "wgsl",
                    Language::Glsl | Language::SpirV => "glsl",
                };
                let options = EmitOptions::new(Format::Listing);
                let listing = listed(&self.laid_out.shader.of_block(block), &options);
                let lines: Vec<&str> = listing.trim().lines().skip(1).collect();
                let cut = if lines.len() > MAX_LINES { "\n…" } else { "" };
                let lines = lines[..lines.len().min(MAX_LINES)].join("\n");
                text.push_str(&format!("```{language}\n{}{cut}\n```\n\n", lines.trim()));
                text.push_str(&self.maps(block));
            }
        }
        for mirror in self.mirrors {
            if mirror.is_of(&self.laid_out.shader.path, &declaration.name) {
                let place = &mirror.place;
                let link = (self.link)(Path::new(&place.path), place.line);
                let (name, path, line) = (&mirror.name, &place.path, place.line);
                text.push_str(&format!("Mirrored by `{name}`: [{path}:{line}]({link})\n\n"));
            }
        }
        text.trim_end().to_string()
    }

    /// The map of a block, and that in the lock where it differs.
    fn maps(&self, block: &BlockLayout) -> String {
        let map = memory_map(block);
        let mut text = format!("```text\n{map}```\n\n");
        let locked = self.locked.and_then(|locked| locked.block(&block.name));
        if let Some(old) = locked.map(memory_map).filter(|old| *old != map) {
            text.push_str(&format!("In the lock:\n\n```text\n{old}```\n\n"));
        }
        text
    }

    /// The text of a hover over an include.
    pub fn of_include(&self, path: &str) -> String {
        let declarations = self.laid_out.in_file(path);
        let names: Vec<String> = declarations
            .filter(|one| one.kind.has_members())
            .map(|one| format!("`{}`", one.name))
            .collect();
        let link = (self.link)(Path::new(path), 1);
        let what = match names.as_slice() {
            [] => String::new(),
            names => format!("\n\ndeclares {}", names.join(", ")),
        };
        format!("[{path}]({link}){what}")
    }
}
