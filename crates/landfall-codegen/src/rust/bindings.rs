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
use landfall_layout::text::edit_distance::suggestion;

use super::RustOptions;
use super::binding_options::{Api, BindingOptions, Sources, WgpuMajor};
use super::names::{Scope, module};
use program::Program;

impl WgpuMajor {
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

/// Prints the modules of all APIs; returns errors about what an API cannot bind. `items` are the
/// names that the file has already.
///
/// The modules stand in one that is named after the first program, and are imported from it: two
/// files in one module then both have a `wgpu_bindings`, which neither has as an item of its own.
pub(super) fn modules(
    shaders: &[&ShaderLayout],
    inputs: &[String],
    options: &RustOptions,
    items: &mut Scope,
    text: &mut String,
) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let bindings = &options.bindings;
    if bindings.apis.is_empty() {
        return found;
    }
    let public = options.visibility.keyword();
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
            let help = suggestion(name, known.iter().copied()).unwrap_or_else(|| {
                "write the name of a resource that the program uses".to_string()
            });
            Diagnostic::without_place(Code::UnusedOption, Severity::Warning, message)
                .with_help(help)
        })
        .collect()
}
