//! What the rest of a program needs beside the mirrors: layouts of bind groups and pipelines,
//! vertex structures, entry points, constants and the shader's text, for one API each.
//!
//! `program` joins the shaders of one program; `wgpu` (with `wgpu_stages`, `wgpu_types` and
//! `constants`), `ash` and `gl` print one module each, with `vertex` and `source`.

mod ash;
mod constants;
mod gl;
mod program;
mod source;
mod text;
mod vertex;
mod wgpu;
mod wgpu_stages;
mod wgpu_types;

use std::fmt::Write as _;

use landfall_layout::ShaderLayout;
use landfall_layout::diagnostic::{Code, Diagnostic, Severity};
use landfall_layout::text::edit_distance::nearest;

use super::RustOptions;
use super::names::{Scope, module};
use program::Program;

/// The API that bindings are written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Api {
    /// wgpu, the newest major version that this version of landfall knows: 30.
    Wgpu,
    /// wgpu of that major version.
    WgpuMajor(WgpuMajor),
    /// Vulkan through ash 0.38.
    Ash,
    /// OpenGL: names, bindings and locations as constants, and a check of a linked program.
    OpenGl,
}

/// The major versions of wgpu whose API is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum WgpuMajor {
    V27,
    V28,
    V29,
    V30,
}

impl WgpuMajor {
    /// The newest one.
    pub const NEWEST: WgpuMajor = WgpuMajor::V30;

    fn number(self) -> u32 {
        match self {
            WgpuMajor::V27 => 27,
            WgpuMajor::V28 => 28,
            WgpuMajor::V29 => 29,
            WgpuMajor::V30 => 30,
        }
    }
}

impl Api {
    /// The names in `--bindings`, in the order of their documentation.
    pub const NAMES: &[(&'static str, Api)] = &[
        ("wgpu", Api::Wgpu),
        ("wgpu-30", Api::WgpuMajor(WgpuMajor::V30)),
        ("wgpu-29", Api::WgpuMajor(WgpuMajor::V29)),
        ("wgpu-28", Api::WgpuMajor(WgpuMajor::V28)),
        ("wgpu-27", Api::WgpuMajor(WgpuMajor::V27)),
        ("ash", Api::Ash),
        ("gl", Api::OpenGl),
    ];

    /// The variant with this name.
    pub fn from_name(name: &str) -> Option<Api> {
        Api::NAMES.iter().find(|(known, _)| *known == name).map(|(_, api)| *api)
    }

    /// The name of the module that is written.
    fn module(self) -> &'static str {
        match self {
            Api::Wgpu | Api::WgpuMajor(_) => "wgpu_bindings",
            Api::Ash => "ash_bindings",
            Api::OpenGl => "gl_bindings",
        }
    }

    /// The API in prose.
    fn described(self) -> String {
        match self {
            Api::Wgpu => format!("wgpu {}", WgpuMajor::NEWEST.number()),
            Api::WgpuMajor(major) => format!("wgpu {}", major.number()),
            Api::Ash => "Vulkan, through ash 0.38".to_string(),
            Api::OpenGl => "OpenGL".to_string(),
        }
    }
}

/// Where the generated code takes the text of a shader from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sources {
    /// Nowhere: no text is written.
    #[default]
    Without,
    /// The text is part of the program.
    Embedded,
    /// With `debug_assertions` the file is read when the program asks; else the text is embedded.
    LoadedInDebug,
}

/// Options of the bindings.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct BindingOptions {
    /// The APIs, one module each.
    pub apis: Vec<Api>,
    /// Programs of several shaders: a name and the shaders' files, or `FILE:ENTRY` for some entry
    /// points of a WGSL module. Without, `a.vert` and `a.frag` are one program, and every other
    /// shader is one; a WGSL module whose entry points use one binding for two resources is one
    /// for each fragment and compute entry point.
    pub programs: Vec<(String, Vec<String>)>,
    /// Names of buffers that are bound with a dynamic offset.
    pub dynamic_offsets: Vec<String>,
    /// Names of textures of floats that are not filtered, and of samplers that do not filter.
    pub unfilterable: Vec<String>,
    /// The number of elements of each array of resources whose declaration gives none, by name.
    pub counts: Vec<(String, u32)>,
    /// Those names above, of programs too, that are a project's: none has to be of these shaders.
    pub project_names: Vec<String>,
    /// Where the text of the shaders comes from.
    pub sources: Sources,
    /// The expression of each shader's path, in the order of the shaders: `"a.wgsl"`, or
    /// `concat!(env!("CARGO_MANIFEST_DIR"), "/a.wgsl")`. A shader without one has no text.
    pub paths: Vec<String>,
}

/// Prints the modules of all APIs; returns errors about what an API cannot bind. `items` are the
/// names that the file has already.
///
/// The modules stand in one that is named after the first program, and are imported from it: two
/// files in one module then both have a `wgpu_bindings`, which neither has as an item of its own.
pub(super) fn modules(
    shaders: &[&ShaderLayout],
    inputs: &[String],
    options: &RustOptions,
    public: &str,
    items: &mut Scope,
    text: &mut String,
) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let bindings = &options.bindings;
    if bindings.apis.is_empty() {
        return found;
    }
    let mut programs = program::programs(shaders, inputs, bindings, &mut found);
    let mut scope = Scope::default();
    // Names of programs are names of modules: unique, whatever API they are written for.
    for program in &mut programs {
        let usual = module(&program.name);
        // As for the modules of shaders, directories are put before a name that another has.
        let folder = program.shaders.first().and_then(|shader| shader.input.rsplit_once('/'));
        let folders: Vec<&str> = folder.map_or("", |(folder, _)| folder).split('/').collect();
        let longer = (0..folders.len()).rev().map(|at| {
            let folders = folders[at..].join("_").replace(|c: char| !c.is_alphanumeric(), "_");
            module(&format!("{folders}_{}", program.name))
        });
        // The usual name, then with one more directory before it each time.
        let free = std::iter::once(usual.clone()).chain(longer).find(|name| scope.is_free(name));
        let given = scope.take(&free.unwrap_or_else(|| usual.clone()));
        if given != usual {
            let message =
                format!("the program of {} is named `{given}`: another is `{usual}`", program.of());
            found.push(
                Diagnostic::without_place(Code::NumberedName, Severity::Warning, message)
                    .with_help(format!("give it a name: `--program NAME={}`", program.files())),
            );
        }
        program.name = given;
    }
    found.extend(unused(&programs, bindings));
    // Two versions of wgpu would be two modules of one name.
    let mut seen = Vec::new();
    let mut all = text::Module::new(public);
    for &api in &bindings.apis {
        if seen.contains(&api.module()) {
            let message = format!("bindings for {} are asked for twice", api.module());
            let error = Diagnostic::without_place(Code::BadName, Severity::Error, message);
            found.push(error.with_help("name one version of an API"));
            continue;
        }
        seen.push(api.module());
        let mut inside = text::Module::new(public);
        // Behind the names of programs.
        let driver = scope.take("driver");
        for program in &programs {
            let mut body = text::Module::new(public);
            let mut errors = match api {
                Api::Wgpu => wgpu::program(program, bindings, WgpuMajor::NEWEST, &mut body),
                Api::WgpuMajor(major) => wgpu::program(program, bindings, major, &mut body),
                Api::Ash => ash::program(program, bindings, &mut body),
                Api::OpenGl => gl::program(program, bindings, &driver, &mut body),
            };
            found.append(&mut errors);
            let about = format!("The program of {}.", program.of());
            inside.module(&about, &program.name, body);
        }
        if api == Api::OpenGl {
            gl::driver(&programs, &driver, &mut inside);
        }
        let about = format!("Bindings for {}.", api.described());
        all.module(&about, api.module(), inside);
    }
    // No API has anything to bind.
    let Some(first) = programs.first().filter(|_| !all.is_empty()) else { return found };
    let name = items.take(&format!("{}_bindings", first.name.trim_start_matches("r#")));
    let mut whole = text::Module::new(public);
    whole.module_of_any("What programs need beside the mirrors.", &name, all);
    if !text.ends_with("\n\n") {
        text.push('\n');
    }
    let import = "#[allow(unused_imports, ambiguous_glob_reexports)]";
    let _ = write!(text, "{import}\n{public} use {name}::*;\n\n{}", whole.finished().trim_end());
    text.push('\n');
    found
}

/// A warning for each name in the options that no resource has.
// Names of a project may be of other shaders, which this file has nothing of.
fn unused(programs: &[Program<'_>], options: &BindingOptions) -> Vec<Diagnostic> {
    let known: Vec<&str> = programs
        .iter()
        .flat_map(|program| &program.bindings)
        .flat_map(|one| [one.block.map(|block| &*block.name), Some(&*one.resource.name)])
        .flatten()
        .collect();
    let counts = options.counts.iter().map(|(name, _)| ("number of elements", name));
    let named = options.dynamic_offsets.iter().map(|name| ("dynamic offset", name)).chain(counts);
    let named = named.chain(options.unfilterable.iter().map(|name| ("filtering", name)));
    named
        .filter(|(_, name)| !known.contains(&name.as_str()))
        .filter(|(_, name)| !options.project_names.contains(name))
        .map(|(what, name)| {
            let message = format!("the {what} of `{name}` has no effect: nothing has that name");
            let found = Diagnostic::without_place(Code::UnusedOption, Severity::Warning, message);
            match nearest(name, known.iter().copied()) {
                Some(near) => found.with_help(format!("did you mean `{near}`?")),
                None => found.with_help("write the name of a resource that the program uses"),
            }
        })
        .collect()
}
