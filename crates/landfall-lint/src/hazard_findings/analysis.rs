//! Follows the values of a shader for all lints of hazards, in builds with the feature `analysis`.
//!
//! [`hazards`](landfall_ir::analysis::hazards) follows the code; this module adds what only the
//! text shows.

use super::{finding, lint_of, mediump};
use crate::definition::Subject;
use landfall_ir::Module;
use landfall_ir::analysis::hazards::find;
use landfall_ir::analysis::identifier::identifier_words as words_of;
use landfall_ir::analysis::occurrence::{Certainty, HazardReport, Kind, Occurrence};
use landfall_ir::analysis::roles::{LightBinding, lights_in_blocks};
use landfall_layout::diagnostic::Code;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::layout::MemberLayout;
use landfall_layout::{Diagnostic, Language, ShaderLayout, Source, Span, linked, naga_front};

/// The hazards of a shader's lights.
#[derive(Debug, Default)]
pub struct Analysis {
    /// The hazards and accesses found, in the order of the text.
    pub found: HazardReport,
    /// The errors that prevented following the shader's functions; empty if they were followed.
    pub unfollowed: Vec<Diagnostic>,
}

/// Follows the values of a shader with these lights. The module need not be validated: parts of a
/// shader may be beyond naga's validator.
pub fn analyse(
    module: Result<Module, Vec<Diagnostic>>,
    source: &Source,
    shader: &ShaderLayout,
    lights: &[LightBinding<'_>],
) -> Analysis {
    let (mut found, unfollowed) = match module.and_then(|module| find(&module, source, lights)) {
        Ok(found) => (found, Vec::new()),
        Err(why) => (HazardReport::default(), why),
    };
    // The values show a hazard; names and comments may speak against it.
    found.hazards.retain_mut(|hazard| weigh(hazard, shader, lights));
    found.hazards.extend(mediump::hazards(shader, lights));
    found.hazards.sort_by_key(|h| (h.span.file, h.span.start, h.span.end, h.kind));
    Analysis { found, unfollowed }
}

/// Returns the findings of those lints in one shader; `parsed` is naga's module of its WGSL text, if
/// naga has read it.
pub(crate) fn findings(
    subject: &Subject<'_>,
    parsed: Option<naga_front::Module>,
    kinds: &[Kind],
) -> Vec<Finding> {
    if kinds.is_empty() {
        return Vec::new();
    }
    let shader = subject.shader;
    if shader.language == Language::Wgsl && parsed.is_none() {
        let text = &linked(subject.source, &subject.options.read).text;
        if let Some(excess) = naga_front::excess(text, Language::Wgsl) {
            return vec![not_analysed(shader, None, &format!("the shader {excess}"))];
        }
    }
    let lights = lights_in_blocks(&shader.blocks);
    // Vertex shaders transform normals without declaring lights.
    let dark = [Kind::Vec4Normalise];
    let candidates = if lights.is_empty() { &dark[..] } else { kinds };
    let candidates: Vec<Kind> =
        candidates.iter().copied().filter(|kind| kinds.contains(kind)).collect();
    // All that remains without lights is `vec4-normalise`, which needs this function.
    if candidates.is_empty() || (lights.is_empty() && !subject.source.text.contains("transpose")) {
        return Vec::new();
    }
    let module = match parsed {
        Some(parsed) => Ok(Module::of_wgsl(parsed, shader, subject.options)),
        None => Module::unchecked(subject.source, subject.options),
    };
    let analysis = analyse(module, subject.source, shader, &lights);
    let reported = analysis.found.hazards.iter().filter(|hazard| {
        // A warning needs a likely hazard, not a possible one.
        let least = match lint_of(hazard.kind).level {
            Level::Allow => Certainty::Possible,
            Level::Warn | Level::Deny => Certainty::Likely,
        };
        candidates.contains(&hazard.kind) && hazard.certainty >= least
    });
    let reported = reported.map(|hazard| finding(hazard, &shader.files, shader.language));
    let refused = analysis.unfollowed.first().map(|why| {
        let at = why.labels.first().map(|label| label.at);
        not_analysed(shader, at, &why.message)
    });
    refused.into_iter().chain(reported).collect()
}

/// Returns the finding that the lints that follow code could not analyse a shader.
fn not_analysed(shader: &ShaderLayout, at: Option<Span>, why: &str) -> Finding {
    let message = format!("functions are not analysed: {why}");
    // A reason without a place is one of the whole file.
    let place = match at.filter(|at| *at != Span::default()) {
        Some(at) => Place::new(&shader.files, at),
        None => Place::file(&*shader.path),
    };
    Finding::at(Code::NotAnalysed.name(), &*shader.path, place, message)
        .with_note("lints that follow code cannot find anything in this shader")
}

/// Returns whether names and comments confirm a hazard, and adjusts its certainty.
fn weigh(hazard: &mut Occurrence, shader: &ShaderLayout, lights: &[LightBinding<'_>]) -> bool {
    // Where a number shows the angle, names are not needed.
    if hazard.kind != Kind::DegreesForCosine || hazard.number.is_some() {
        return true;
    }
    let words = words_of(hazard.about.rsplit('.').next().unwrap_or_default());
    let has = |any: &[&str]| words.iter().any(|word| any.contains(&word.as_str()));
    if has(&["cos", "cosine"]) {
        return false;
    }
    let comment = comment_of(&hazard.about, shader, lights).to_lowercase();
    let cosine = ["cos", "余弦"].iter().any(|word| comment.contains(word));
    let degrees =
        ["degree", "radian", "°", "角度", "弧度"].iter().any(|word| comment.contains(word));
    if has(&["degrees", "degree", "deg", "radians", "rad"]) || (degrees && !cosine) {
        hazard.certainty = Certainty::Likely;
        return true;
    }
    has(&["angle"]) && !cosine
}

/// Returns the comments of the member at that path of a light.
fn comment_of(path: &str, shader: &ShaderLayout, lights: &[LightBinding<'_>]) -> String {
    let mut text = String::new();
    for light in lights {
        let Some(part) = light.roles.parts.iter().find(|part| light.full_path(part) == path) else {
            continue;
        };
        let Some(member) = member_at(&light.block.members, part.span) else { continue };
        for span in &member.comment {
            let Some(file) = shader.files.get(span.file) else { continue };
            text.push_str(file.text.get(span.start as usize..span.end as usize).unwrap_or(""));
        }
    }
    text
}

fn member_at(members: &[MemberLayout], span: landfall_layout::Span) -> Option<&MemberLayout> {
    members.iter().find_map(|member| match member.span == span {
        true => Some(member),
        false => member_at(&member.members, span),
    })
}
