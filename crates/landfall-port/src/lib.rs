//! Ports old GLSL to GLSL 4.50 for Vulkan, gathering loose uniforms into one std140 block that
//! takes a single upload.
//!
//! The text is edited, not reprinted: comments, macros, blank lines and everything unaffected
//! stay byte for byte. `outline` parses the declarations, and each kind of change has a module:
//! `environment` (version, extensions, conditions), `reserved`, `hoist` (handles in structures),
//! `uniforms`, `interface` (locations). `edits` applies them. `separate` and `wgsl` translate
//! the result to naga's GLSL and to WGSL.
//!
//! Clip space stays as it is: a vertex shader written for OpenGL's depth range and upward y
//! still writes those.

mod check;
mod edits;
mod environment;
mod hoist;
mod interface;
mod later_functions;
#[cfg(feature = "naga")]
mod origin;
mod outline;
mod partner;
mod ported;
mod reserved;
#[cfg(feature = "naga")]
mod separate;
mod shader;
mod site;
#[cfg(feature = "naga")]
mod uniformity;
mod uniforms;
#[cfg(feature = "naga")]
mod wgsl;

use edits::Edits;
use hoist::Handles;
#[cfg(feature = "naga")]
use landfall_layout::Options;
use landfall_layout::shape::{AddressSpace, DEFAULT_BLOCK};
use landfall_layout::source::{Language, ReadOptions, Source, Span, Stage, Target};
use landfall_layout::syntax;
use landfall_layout::syntax::glsl::ast::Item;
use landfall_layout::syntax::glsl::raw;
use landfall_layout::{Diagnostic, Severity};
#[cfg(feature = "naga")]
use origin::Origin;
use partner::Partner;
pub use ported::{Binding, Direction, InitialValue, Location, Ported};
use rustc_hash::FxHashSet;
use shader::{Shader, refusal};
use uniforms::Bindings;

/// The target language of a ported shader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Dialect {
    /// Vulkan's GLSL 4.50, with combined samplers.
    #[default]
    Vulkan,
    /// GLSL 4.50 for naga and wgpu, with separate textures and samplers, checked with naga.
    Naga,
    /// WGSL, if its rules put every member at the same offset.
    Wgsl,
}

/// Options of [`port`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PortOptions {
    /// The target language.
    pub dialect: Dialect,
    /// The options for reading the shader.
    pub read: ReadOptions,
    /// The name of the block of loose uniforms.
    pub block: String,
    /// The descriptor set of everything without one.
    pub set: u32,
    /// The first binding to assign; the block of loose uniforms gets it if it is free.
    pub first_binding: u32,
    /// The preceding or following stage of the same program, to match locations with.
    pub partner: Option<Source>,
    /// Locations by name, which override the assigned ones.
    pub locations: Vec<(String, u32)>,
}

impl Default for PortOptions {
    fn default() -> PortOptions {
        PortOptions {
            dialect: Dialect::Vulkan,
            read: ReadOptions::default(),
            block: DEFAULT_BLOCK.to_string(),
            set: 0,
            first_binding: 0,
            partner: None,
            locations: Vec::new(),
        }
    }
}

/// Ports a GLSL shader to GLSL 4.50 for Vulkan.
///
/// # Errors
/// Returns an error for each construct that cannot be ported: fixed-function state, copies of
/// structures that contain samplers, declarations in macros or includes, unsized uniform arrays.
pub fn port(source: &Source, options: &PortOptions) -> Result<Ported, Vec<Diagnostic>> {
    let mut options = options.clone();
    options.read.target = options.read.target.or_else(|| target_of(source));
    if options.dialect != Dialect::Vulkan && has_include(source) {
        return with_includes(source, options);
    }
    let (ported, edits) = edit(source, &options)?;
    check::check(source, &options, &ported)?;
    match options.dialect {
        Dialect::Vulkan => Ok(ported),
        Dialect::Naga | Dialect::Wgsl => through_naga(source, ported, &edits, &options),
    }
}

/// Rejects dialects that need naga in builds without it.
#[cfg(not(feature = "naga"))]
fn through_naga(
    _: &Source,
    ported: Ported,
    _: &Edits,
    _: &PortOptions,
) -> Result<Ported, Vec<Diagnostic>> {
    let path = &ported.source.path;
    let message = format!("porting `{path}` to this dialect needs naga, which this build lacks");
    let problem = refusal(Span::default(), message);
    Err(vec![problem.with_help("enable landfall's feature `naga`")])
}

#[cfg(feature = "naga")]
fn through_naga(
    source: &Source,
    mut ported: Ported,
    edits: &Edits,
    options: &PortOptions,
) -> Result<Ported, Vec<Diagnostic>> {
    let user = Shader::new(source, &options.read);
    // What WGSL lacks is refused by the original, whose places need no way back.
    if options.dialect == Dialect::Wgsl {
        wgsl::refuse(&user)?;
    }
    let read = options.read.clone().with_target(Target::Vulkan);
    let layouts = Options::default().with_read(read.clone());
    let before = ported.source.clone();
    let mut problems = Vec::new();
    let mut bindings = std::mem::take(&mut ported.bindings);
    let further = separate::separate(&Shader::new(&before, &read), &mut bindings, &mut problems);
    ported.bindings = bindings;
    let origin = Origin { user: &user, edits, before: &before, renamed: &ported.renamed };
    if !problems.is_empty() {
        origin.move_back(&mut problems, None);
        return Err(problems);
    }
    // Two texts are between the user's and naga's: that for Vulkan, and that with textures and
    // samplers separated.
    let text = further.render(&before.text, 0..before.text.len());
    let separated = Source { text: text.into(), ..before.clone() };
    let back = |mut found: Vec<Diagnostic>| {
        origin.move_back(&mut found, Some(&further));
        found
    };
    wgsl::check(&separated, &layouts).map_err(back)?;
    let mut warnings = Vec::new();
    let lines = further.lines(&before.text);
    // From lines of the text made last, by those for Vulkan, to the user's.
    ported.lines = lines.iter().map(|line| ported.lines[*line as usize - 1]).collect();
    let made = match options.dialect {
        Dialect::Wgsl => {
            ported.lines.clear();
            wgsl::write(&separated, &layouts, &mut warnings).map_err(back)?
        }
        Dialect::Vulkan | Dialect::Naga => separated,
    };
    ported.warnings = back(warnings);
    ported.source = made;
    Ok(ported)
}

/// Whether a GLSL text includes files, which naga does not.
fn has_include(source: &Source) -> bool {
    let is_directive = |at: &[&str]| at == ["#", "include"];
    source.language == Language::Glsl
        && source.text.contains("include")
        && syntax::tokens(&source.text, Language::Glsl).windows(2).any(is_directive)
}

/// Ports a shader with its includes inlined and its macros expanded. Places in that text are not those
/// of the shader, so that problems name no line.
fn with_includes(source: &Source, mut options: PortOptions) -> Result<Ported, Vec<Diagnostic>> {
    let parsed = syntax::parse(source, &options.read, false);
    let errors = parsed.diagnostics.into_iter().filter(|found| found.severity == Severity::Error);
    let errors: Vec<Diagnostic> = errors.collect();
    if !errors.is_empty() {
        return Err(errors);
    }
    let raw = raw::read(source, &options.read);
    // The flattened text has no `#extension` or macro left that would tell the API.
    options.read.target = options.read.target.or(raw.target);
    let text = raw::flattened(source, &options.read);
    options.read.defines.clear();
    let flat = Source { text: text.into(), ..source.clone() };
    let placeless = |found: Diagnostic| {
        let note = "found in the shader with its includes inlined and its macros expanded";
        Diagnostic { path: Some(source.path.clone()), labels: Vec::new(), ..found }.with_note(note)
    };
    let placeless = |found: Vec<Diagnostic>| found.into_iter().map(placeless).collect::<Vec<_>>();
    let mut ported = port(&flat, &options).map_err(placeless)?;
    ported.warnings = placeless(ported.warnings);
    ported.lines.clear();
    Ok(ported)
}

/// OpenGL for versions older than Vulkan, even if the text mentions Vulkan.
fn target_of(source: &Source) -> Option<Target> {
    let raw = raw::read(source, &ReadOptions::default());
    (raw.version < 400).then_some(Target::OpenGl)
}

fn edit(source: &Source, options: &PortOptions) -> Result<(Ported, Edits), Vec<Diagnostic>> {
    if source.language != Language::Glsl {
        let message =
            format!("`{}` is {}, but only GLSL can be ported", source.path, source.language.name());
        return Err(vec![refusal(Span::default(), message)]);
    }
    let shader = Shader::new(source, &options.read);
    let mut problems = readable(source, options, &shader);
    if !problems.is_empty() {
        return Err(problems);
    }
    let Some(stage) = source.stage.or_else(|| stage_of(&shader)) else {
        let message = "the file name does not tell the shader's stage";
        let help = "name the file `.vert`, `.frag` and so on, or pass `--stage`";
        return Err(vec![refusal(Span::default(), message).with_help(help)]);
    };
    let mut edits = Edits::default();
    // What has no place in the result is refused, and each kind of change recorded in `edits`.
    reserved::refuse(&shader, &mut problems);
    environment::adapt(&shader, &mut edits);
    let mut renamed = reserved::rename(&shader, &mut edits);
    let output = interface::fragment_output(&shader, &mut edits, &mut problems);

    let handles = Handles::new(&shader);
    handles.strip(&mut edits);
    handles.rewrite(&mut edits, &mut problems);
    let partner = Partner::new(source, options, stage);
    let gathered = uniforms::gather(&shader, &handles, &partner.shared, &mut edits, &mut problems);
    for name in gathered.names.clone() {
        for (own, path) in handles.of_global(&name) {
            renamed.names.push((format!("{name}.{}", path.fields.join(".")), own.to_string()));
        }
    }

    // The blocks come first, so that they have the first bindings.
    let mut bindings =
        Bindings::new(&shader, options.set, options.first_binding, &partner.bindings);
    let shared = (!gathered.shared.is_empty()).then(|| shader.unused(&options.block));
    let block = (!gathered.members.is_empty()).then(|| block_name(&shader, options, stage));
    let mut text = String::new();
    if let Some(block) = &shared {
        let place = bindings.shared(block, partner.block);
        text.push_str(&block_text(&shader, block, &gathered.shared_members(), place));
    }
    if let Some(block) = &block {
        let place = bindings.give(block);
        text.push_str(&block_text(&shader, block, &gathered.members, place));
    }
    uniforms::bind(&shader, &mut bindings, &mut edits, &mut problems);
    for (ty, declared) in &gathered.handles {
        let name = declared.split('[').next().unwrap_or("");
        let (set, binding) = bindings.known_or_new(name);
        text.push_str(&format!(
            "layout(set = {set}, binding = {binding}) uniform {ty} {declared};\n"
        ));
    }
    let mut needed = gathered.names.clone();
    if let Some((declared, location)) = &output {
        text.push_str(declared);
        needed.push(location.name.clone());
        needed.extend(["gl_FragColor".to_string(), "gl_FragData".to_string()]);
    }
    // All that is declared anew stands in one place, before its first use.
    if !text.is_empty() {
        match site::find(&shader, &gathered, &needed) {
            Ok(at) => site::insert(&shader, at, text, &mut edits),
            Err(problem) => problems.push(problem),
        }
    }

    let passed = interface::inputs_and_outputs(&shader, source, stage, &options.read);
    let mut locations =
        interface::locate(stage, &passed, &partner.passed, &options.locations, &mut problems);
    interface::write(&shader, stage, &passed, &locations, &mut edits);
    locations.extend(output.map(|(_, location)| location));
    if !problems.is_empty() {
        return Err(problems);
    }
    let text = edits.render(&source.text, 0..source.text.len());
    let ported = Ported {
        lines: edits.lines(&source.text),
        source: Source { text: text.into(), stage: Some(stage), ..source.clone() },
        block,
        shared,
        bindings: bindings.given,
        locations,
        values: gathered.values,
        renamed: renamed.names,
        functions: renamed.functions,
        warnings: Vec::new(),
    };
    Ok((ported, edits))
}

/// Errors that prevent porting, found before any edit.
fn readable(source: &Source, options: &PortOptions, shader: &Shader<'_>) -> Vec<Diagnostic> {
    let parsed = syntax::parse(source, &options.read, false);
    let mut problems = parsed.diagnostics;
    problems.retain(|diagnostic| diagnostic.severity == Severity::Error);
    // A uniform that parsing finds but the outline of this file does not is declared elsewhere.
    let found: FxHashSet<&str> = shader
        .variables()
        .filter(|variables| shader.has_word(&variables.qualifiers, "uniform"))
        .flat_map(|variables| &variables.names)
        .map(|declarator| declarator.name.text)
        .collect();
    let loose = parsed.shape.blocks.iter().filter(|block| block.space == AddressSpace::Default);
    for member in loose.flat_map(|block| &block.members) {
        if member.span.file != 0 || !found.contains(&*member.name) {
            let message = format!("`{}` is declared by a macro or in an include", member.name);
            problems.push(
                refusal(member.span, message)
                    .with_note("only one file is edited; macros and includes stay as they are")
                    .with_help("write the declaration out in the shader itself"),
            );
        }
    }
    // An included file is not edited: it may have nothing that would have to be.
    for (index, file) in shader.raw.files.iter().enumerate().skip(1) {
        if file.path.starts_with("-D ") {
            continue;
        }
        let legacy =
            ["uniform", "varying", "attribute", "texture2D", "gl_FragColor", "gl_FragData"];
        let mut words = file.text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
        if let Some(word) = words.find(|word| legacy.contains(word)) {
            let message = format!("the included file `{}` uses `{word}`", file.path);
            let span = Span { file: index as u32, start: 0, end: 0 };
            let help = "paste the included file into the shader and port the result";
            problems.push(refusal(span, message).with_help(help));
        }
    }
    for item in &shader.items {
        let Item::Other(tokens) = item else { continue };
        // Qualifiers stand at the beginning of a declaration.
        let words = &shader.code[tokens.clone()];
        let passes = ["uniform", "buffer", "attribute", "varying", "in", "out"];
        let edited = words.iter().take(6).any(|token| passes.contains(&token.text));
        // `in vec4 gl_FragCoord;` and the forward declaration of a buffer reference stay.
        let builtin = words
            .iter()
            .any(|token| token.text.starts_with("gl_") || token.text == "buffer_reference");
        if edited && !builtin {
            let message = "cannot parse this declaration";
            let problem = refusal(shader.span(tokens.start), message);
            problems.push(problem.with_help("write it without macros"));
        }
    }
    let subroutine = shader.code.iter().position(|token| token.text == "subroutine");
    if let Some(at) = subroutine {
        problems.push(refusal(shader.span(at), "Vulkan has no subroutines"));
    }
    problems
}

/// The stage of a shader, from the words it uses.
fn stage_of(shader: &Shader<'_>) -> Option<Stage> {
    let has = |word: &str| shader.code.iter().any(|token| token.text == word);
    if has("gl_Position") || has("attribute") {
        return Some(Stage::Vertex);
    }
    let fragment = ["gl_FragColor", "gl_FragData", "gl_FragCoord", "gl_FragDepth", "discard"];
    fragment.into_iter().any(has).then_some(Stage::Fragment)
}

/// The name of the block of loose uniforms, including the stage if there is a partner, since the
/// stages have different members.
fn block_name(shader: &Shader<'_>, options: &PortOptions, stage: Stage) -> String {
    let mut name = options.block.clone();
    if options.partner.is_some() {
        let words = stage.name().split('_');
        name.extend(words.map(|word| format!("{}{}", word[..1].to_uppercase(), &word[1..])));
    }
    shader.unused(&name)
}

fn block_text(
    shader: &Shader<'_>,
    block: &str,
    members: &str,
    (set, binding): (u32, u32),
) -> String {
    // A default `row_major` for blocks never applied to loose uniforms.
    let row_major = shader.code.iter().any(|token| token.text == "row_major");
    let major = if row_major { ", column_major" } else { "" };
    format!(
        "layout(set = {set}, binding = {binding}, std140{major}) uniform {block} {{\n{members}}};\n"
    )
}
