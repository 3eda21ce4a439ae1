//! The shaders of one program, and what they bind together.

mod split;

use landfall_layout::ShaderLayout;
use landfall_layout::diagnostic::{Code, Diagnostic, Severity};
use landfall_layout::interface::{EntryPoint, Resource, ResourceKind};
use landfall_layout::layout::BlockLayout;
use landfall_layout::layout::measure::fixed_elements;
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::{Language, Stage};
use landfall_layout::text::edit_distance::suggestion;

use super::super::rename::is_file;
use super::{Api, BindingOptions};

/// The shaders that a pipeline is made of.
pub(super) struct Program<'a> {
    /// The name of its module.
    pub name: String,
    pub shaders: Vec<ProgramShader<'a>>,
    /// The resources that some entry point uses, by group and binding.
    pub bindings: Vec<Binding<'a>>,
}

pub(super) struct ProgramShader<'a> {
    pub layout: &'a ShaderLayout,
    pub input: &'a str,
    /// The expression of its path in the generated code.
    pub path: Option<&'a str>,
    pub entries: Vec<&'a EntryPoint>,
}

/// A resource with the stages that use it.
pub(super) struct Binding<'a> {
    pub resource: &'a Resource,
    /// The block, if it is a buffer.
    pub block: Option<&'a BlockLayout>,
    pub stages: Vec<Stage>,
    pub shader: &'a ShaderLayout,
}

impl Program<'_> {
    /// Its shaders, for documentation and messages.
    pub(super) fn of(&self) -> String {
        let all: Vec<String> = self.shaders.iter().map(|s| format!("`{}`", s.input)).collect();
        all.join(", ")
    }

    /// Its shaders, as an option names them.
    pub(super) fn files(&self) -> String {
        self.shaders.iter().map(|shader| shader.input).collect::<Vec<_>>().join(",")
    }

    /// The groups that bindings are in, in order.
    pub(super) fn groups(&self) -> Vec<u32> {
        let mut groups: Vec<u32> =
            self.bindings.iter().filter(|one| !one.is_push()).map(Binding::group).collect();
        groups.sort_unstable();
        groups.dedup();
        groups
    }

    /// The bindings of a group.
    pub(super) fn in_group(&self, group: u32) -> impl Iterator<Item = &Binding<'_>> {
        self.bindings.iter().filter(move |one| one.group() == group && !one.is_push())
    }

    /// The push constants: the bytes of the largest block, and the stages that use one.
    pub(super) fn push_constants(&self) -> Option<(u64, Vec<Stage>)> {
        let all = self.bindings.iter().filter(|one| one.is_push());
        let mut result: Option<(u64, Vec<Stage>)> = None;
        for one in all {
            let size = one.block.and_then(|block| block.size).unwrap_or(0);
            let (largest, stages) = result.get_or_insert((0, Vec::new()));
            *largest = size.max(*largest);
            add(stages, &one.stages);
        }
        // Both APIs count in steps of 4 bytes.
        result.map(|(size, stages)| (size.next_multiple_of(4), stages))
    }
}

impl Binding<'_> {
    pub(super) fn group(&self) -> u32 {
        self.resource.group.unwrap_or(0)
    }

    pub(super) fn is_push(&self) -> bool {
        matches!(self.resource.kind, ResourceKind::Buffer(AddressSpace::PushConstant, _))
    }

    /// Whether an option names it, or its block.
    pub(super) fn is_named(&self, names: &[String]) -> bool {
        let block = self.block.map(|block| &*block.name);
        names.iter().any(|name| **name == *self.resource.name || Some(name.as_str()) == block)
    }

    /// The number of elements: 1 without an array, that of the options where none is declared.
    pub(super) fn count(&self, options: &BindingOptions) -> Option<u64> {
        let given = options.counts.iter().find(|(name, _)| **name == *self.resource.name);
        // Declared lengths count first: the option is for those without one.
        fixed_elements(&self.resource.count).or(given.map(|(_, count)| u64::from(*count)))
    }

    /// An error about it, with its place.
    pub(super) fn error(&self, message: String) -> Diagnostic {
        let found = Diagnostic::error(Code::NoBinding, self.resource.span, message);
        Diagnostic { path: Some(self.shader.path.clone()), ..found }
    }
}

fn add(stages: &mut Vec<Stage>, more: &[Stage]) {
    for stage in more {
        if !stages.contains(stage) {
            stages.push(*stage);
        }
    }
}

/// Divides shaders into programs.
pub(super) fn programs<'a>(
    shaders: &[&'a ShaderLayout],
    inputs: &'a [String],
    options: &'a BindingOptions,
    found: &mut Vec<Diagnostic>,
) -> Vec<Program<'a>> {
    let shader = |at: usize, entries: &[&str]| {
        let layout: &'a ShaderLayout = shaders[at];
        let all = layout.interface.iter().flat_map(|interface| &interface.entry_points);
        let wanted = |entry: &&EntryPoint| entries.is_empty() || entries.contains(&&*entry.name);
        ProgramShader {
            layout,
            input: &inputs[at],
            // What is given as text has an empty path: there is no file to read.
            path: options.paths.get(at).map(String::as_str).filter(|path| !path.is_empty()),
            entries: all.filter(wanted).collect(),
        }
    };
    let mut programs: Vec<Program<'a>> = Vec::new();
    // Programs that the options name come first, then one for each shader or pair that is left.
    let mut placed = vec![false; shaders.len()];
    for (name, files) in &options.programs {
        let is_here = |file: &String| {
            // `FILE:ENTRY` names a file, too.
            let path = file.split_once(':').map_or(file.as_str(), |(path, _)| path);
            inputs.iter().any(|input| is_file(path, input))
        };
        // Programs of a project may be of other shaders.
        if options.project_names.contains(name) && !files.iter().any(is_here) {
            continue;
        }
        let mut program = Program { name: name.clone(), shaders: Vec::new(), bindings: Vec::new() };
        for (at, entries) in members(name, files, shaders, inputs, found) {
            placed[at] = true;
            program.shaders.push(shader(at, &entries));
        }
        programs.push(program);
    }
    // What tells the programs from `first` on apart, in their order.
    let mut keys: Vec<String> = Vec::new();
    let first = programs.len();
    for at in (0..shaders.len()).filter(|at| !placed[*at]) {
        let one = shader(at, &[]);
        // A file that is only included has none.
        if one.entries.is_empty() {
            continue;
        }
        // A module whose entry points cannot be bound at once has several programs.
        let parts = split::parts(&one);
        if !parts.is_empty() {
            let (_, name) = key(&inputs[at], &one);
            for entries in parts {
                let name = format!("{name}_{}", entries[0]);
                let shaders = vec![shader(at, &entries)];
                keys.push(name.clone());
                programs.push(Program { name, shaders, bindings: Vec::new() });
            }
            continue;
        }
        let (key, name) = key(&inputs[at], &one);
        match keys.iter().position(|known| *known == key) {
            Some(index) => programs[first + index].shaders.push(one),
            None => {
                keys.push(key);
                programs.push(Program { name, shaders: vec![one], bindings: Vec::new() });
            }
        }
    }
    for program in &mut programs {
        bind(program, options.apis == [Api::OpenGl], found);
    }
    programs
}

/// The shaders that a program names, each with the entry points named.
fn members<'f>(
    name: &str,
    files: &'f [String],
    shaders: &[&ShaderLayout],
    inputs: &[String],
    found: &mut Vec<Diagnostic>,
) -> Vec<(usize, Vec<&'f str>)> {
    let mut all: Vec<(usize, Vec<&str>)> = Vec::new();
    for file in files {
        let position = |file: &str| inputs.iter().position(|one| is_file(file, one));
        let (at, entry) = match (position(file), file.rsplit_once(':')) {
            // A path may hold a colon: the whole text is tried as a file first.
            (Some(at), _) => (Some(at), None),
            (None, Some((file, entry))) => (position(file), Some(entry)),
            (None, None) => (None, None),
        };
        let has_entry = |at: usize, entry: &str| {
            let all = shaders[at].interface.iter().flat_map(|interface| &interface.entry_points);
            all.into_iter().any(|one| &*one.name == entry)
        };
        match (at, entry) {
            (Some(at), Some(entry)) if !has_entry(at, entry) => {
                let message = format!("{} has no entry point `{entry}`", inputs[at]);
                found.push(Diagnostic::without_place(Code::BadName, Severity::Error, message));
            }
            (Some(at), entry) => match all.iter_mut().find(|(known, _)| *known == at) {
                Some((_, entries)) => entries.extend(entry),
                None => all.push((at, entry.into_iter().collect())),
            },
            (None, _) => {
                let message = format!("program `{name}` names `{file}`, which is no shader here");
                let error = Diagnostic::without_place(Code::BadName, Severity::Error, message);
                let help = suggestion(file, inputs.iter().map(String::as_str));
                found.push(Diagnostic { help, ..error });
            }
        }
    }
    all
}

/// What tells programs apart, and a program's name: the file without its stage, and what makes a
/// variant.
fn key(input: &str, shader: &ProgramShader<'_>) -> (String, String) {
    let variant = shader.layout.condition.as_ref().map_or("", |condition| &condition.text);
    // Variants of a shader are inputs of their own, named `a.frag with SHADOWS`.
    let file = input.strip_suffix(variant).unwrap_or(input).trim_end();
    let (folder, file) = file.rsplit_once('/').unwrap_or(("", file));
    let compute = shader.entries.iter().all(|entry| entry.stage == Some(Stage::Compute));
    let mut base = file;
    if let Some((stem, extension)) = base.rsplit_once('.') {
        base = stem;
        // `a.vert.glsl` and `a.frag.glsl` are one program as well.
        if let Some((stem, stage)) = stem.rsplit_once('.') {
            let both = Stage::from_name(extension).is_none() && Stage::from_name(stage).is_some();
            base = if both { stem } else { base };
        }
    }
    let name = format!("{base} {}", variant.to_lowercase());
    let is_part = |c: char| c.is_alphanumeric();
    let name = name.trim_end().replace(|c| !is_part(c), "_");
    match shader.layout.language {
        // A module has all of its stages.
        Language::Wgsl => (input.to_string(), name),
        // A compute shader is a program by itself, whatever other shaders are called like it.
        Language::Glsl | Language::SpirV if compute => (input.to_string(), name),
        Language::Glsl | Language::SpirV => (format!("{folder}/{base} {variant}"), name),
    }
}

/// Finds what the program binds; `by_kind` where each kind of resource has bindings of its own.
fn bind<'a>(program: &mut Program<'a>, by_kind: bool, found: &mut Vec<Diagnostic>) {
    let mut bindings: Vec<Binding<'a>> = Vec::new();
    for shader in &program.shaders {
        if shader.entries.iter().any(|entry| entry.stage.is_none()) {
            let message = format!("the stage of {} is not known", shader.input);
            let error = Diagnostic::without_place(Code::NoBinding, Severity::Error, message);
            let error = Diagnostic { path: Some(shader.layout.path.clone()), ..error };
            found.push(error.with_help("name the file by its stage, such as `.vert` or `.frag`"));
        }
        let Some(interface) = &shader.layout.interface else { continue };
        for (at, resource) in interface.resources.iter().enumerate() {
            let users = shader.entries.iter().filter(|entry| entry.uses.contains(&at));
            let mut stages = Vec::new();
            let mut used = false;
            for entry in users {
                used = true;
                stages.extend(entry.stage.filter(|stage| !stages.contains(stage)));
            }
            // A pipeline binds only what its entry points use.
            if !used {
                continue;
            }
            let block = match resource.kind {
                ResourceKind::Buffer(..) => {
                    // By its place: another block may have the same name.
                    shader.layout.blocks.iter().find(|block| block.span == resource.span)
                }
                _ => None,
            };
            let new = Binding { resource, block, stages, shader: shader.layout };
            join(&mut bindings, new, by_kind, found);
        }
    }
    // In the order in which groups are printed.
    bindings.sort_by_key(|one| (one.group(), one.resource.binding));
    program.bindings = bindings;
}

/// Adds a binding, to that of another stage if both are one.
fn join<'a>(
    bindings: &mut Vec<Binding<'a>>,
    new: Binding<'a>,
    by_kind: bool,
    found: &mut Vec<Diagnostic>,
) {
    let name = |one: &Binding<'_>| match one.block {
        Some(block) => block.name.clone(),
        None => one.resource.name.clone(),
    };
    // Push constants of two stages may overlap: each keeps its own block.
    let same = |one: &&mut Binding<'a>| match (new.resource.binding, one.resource.binding) {
        _ if new.is_push() || one.is_push() => false,
        _ if by_kind && of_opengl(&new.resource.kind) != of_opengl(&one.resource.kind) => false,
        (Some(a), Some(b)) => a == b && one.group() == new.group(),
        // Without a binding, OpenGL joins them by their names.
        (None, None) => name(one) == name(&new),
        _ => false,
    };
    let Some(known) = bindings.iter_mut().find(same) else {
        bindings.push(new);
        return;
    };
    // What one stage and another declare at a binding must be the same resource.
    let different = !is_same_kind(&known.resource.kind, &new.resource.kind)
        || name(known) != name(&new)
        || known.block.map(|block| block.size) != new.block.map(|block| block.size);
    if different {
        let message = format!(
            "`{}` and `{}` of one program have the same binding",
            known.resource.name, new.resource.name
        );
        let error = new.error(message).with_note(format!(
            "the other is declared in {}; the two differ in name, kind or size",
            known.shader.path
        ));
        found.push(error.with_help(
            "give one another binding, or name two programs: `--program NAME=FILE:ENTRY`",
        ));
        return;
    }
    add(&mut known.stages, &new.stages);
}

/// Which bindings of OpenGL a resource has: those of textures, images, uniform or storage blocks, or
/// atomic counters.
fn of_opengl(kind: &ResourceKind) -> u8 {
    match kind {
        ResourceKind::Buffer(AddressSpace::Uniform, _) => 0,
        ResourceKind::Buffer(..) => 1,
        ResourceKind::StorageTexture { .. } => 2,
        ResourceKind::AtomicCounter => 3,
        _ => 4,
    }
}

/// Whether two declarations are of one kind; which textures a sampler is used with may differ.
fn is_same_kind(a: &ResourceKind, b: &ResourceKind) -> bool {
    match (a, b) {
        (
            ResourceKind::Sampler { comparison: a, .. },
            ResourceKind::Sampler { comparison: b, .. },
        ) => a == b,
        _ => a == b,
    }
}
