//! What a hover over the name of a function tells: the lights that it reads, and what was found in it.

use std::ops::Range;

use gen_lsp_types::{Contents, Hover, MarkupContent, MarkupKind};
use landfall_check::caught::caught;
use landfall_layout::Span;

use crate::answers::DocumentLayouts;
use crate::command_texts::{FunctionLights, FunctionQuery};
use crate::laid_out::LaidOut;
use crate::owners::OwnerResolver;
use crate::paths::plain;
use crate::server::EditorServer;
use crate::words::function_at;

impl EditorServer {
    /// The hover over the function whose name is at a byte.
    pub fn function_hover(&self, document: &DocumentLayouts, offset: u32) -> Option<Hover> {
        let (name, body) = function_at(document.text.plain(), offset)?;
        let lights = document.layouts.iter().find_map(|laid_out| {
            let lights = self.lights_in(document, laid_out, &body)?;
            (!lights.text.is_empty() || !lights.hazards.is_empty()).then_some(lights)
        });
        let FunctionLights { text, hazards, unfollowed } = lights.unwrap_or_default();
        let path = self.absolute(&document.shown);
        let mut findings = self.findings_in(&path);
        for hazard in hazards {
            let is_it = |one: &landfall_layout::finding::Finding| {
                one.code == hazard.code && one.place().start == hazard.place().start
            };
            if !findings.iter().any(is_it) {
                findings.push(hazard);
            }
        }
        findings.retain(|one| body.contains(&one.place().start));
        findings.sort_by_key(|one| one.place().start);
        let lines = findings
            .iter()
            .map(|one| format!("- line {}: {} (`{}`)\n", one.place().line, one.message, one.code));
        let mut value = match lines.collect::<String>() {
            none if none.is_empty() => format!("`{name}`: nothing was found in it\n"),
            lines => format!("`{name}`:\n\n{lines}"),
        };
        if !text.is_empty() {
            value.push_str(&format!("\n```text\n{}\n```\n", text.trim_end()));
        }
        if let Some(why) = unfollowed {
            value.push_str(&format!("\nits loops and hazards are unknown: {why}\n"));
        }
        let value = value.trim_end().to_string();
        let contents = Contents::from(MarkupContent { kind: MarkupKind::Markdown, value });
        Some(Hover { contents, range: None })
    }

    /// What `lights` says of a function of a document, as a part of one of its shaders.
    fn lights_in(
        &self,
        document: &DocumentLayouts,
        laid_out: &LaidOut,
        body: &Range<u32>,
    ) -> Option<FunctionLights> {
        let lights = self.texts.lights?;
        let LaidOut { source, shader, .. } = laid_out;
        if shader.has_errors() {
            return None;
        }
        let setup = self.projects[document.index].setup.as_ref()?;
        let options = setup.options(&self.open_files());
        let options = &setup.basis.settings.own_options(source, &options);
        let resolver = OwnerResolver::new(laid_out, document.text.plain());
        let words = resolver.words().iter().filter(|word| body.contains(&word.span.start));
        let words: Vec<_> = words.collect();
        let reads = |block: &str, path: &str| {
            let mut names = path.split(['.', '[', ']']).filter(|name| !name.is_empty());
            let Some(first) = names.next() else { return false };
            let has_bytes = laid_out.declarations.iter().any(|one| one.owner == block);
            let is_first = words.iter().filter(|word| word.text == first).any(|word| {
                // Uniforms outside blocks are no declarations with bytes, and structures no members.
                let mut meant = match has_bytes && !block.is_empty() {
                    true => laid_out.meant(&document.shown, &resolver, word).into_iter(),
                    false => return !word.is_behind_dot,
                };
                meant.any(|one| one.owner == block)
            });
            is_first && names.all(|name| words.iter().any(|word| word.text == name))
        };
        let holds = |span: Span| {
            let span = shader.files.resolve(span);
            let file = shader.files.get(span.file);
            file.is_some_and(|file| plain(&file.path) == document.shown)
                && body.contains(&span.start)
        };
        let query = FunctionQuery { source, options, shader, holds: &holds, reads: &reads };
        caught(&shader.path, || lights(&query)).ok()
    }
}
