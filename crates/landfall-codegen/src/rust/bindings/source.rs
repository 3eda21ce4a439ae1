//! The text of shaders in the generated code.

use std::fmt::Write as _;

use landfall_layout::ShaderLayout;
use landfall_layout::interface::Include;
use landfall_layout::source::Language;

use super::super::names::{Scope, screaming};
use super::program::{Program, ProgramShader};
use super::text::{Module, PUB};
use super::{BindingOptions, Sources};

/// Prints the text of a shader. Returns the expression of it, for those who ask for a module.
pub(super) fn source(
    program: &Program<'_>,
    shader: &ProgramShader<'_>,
    options: &BindingOptions,
    scope: &mut Scope,
    out: &mut Module,
) -> Option<String> {
    let path = shader.path.filter(|_| options.sources != Sources::Without)?;
    let several = program.shaders.len() > 1;
    let stage = shader.entries.first().and_then(|entry| entry.stage).filter(|_| several);
    let (wanted, function) = match stage {
        Some(stage) => {
            (format!("{}_SOURCE", screaming(stage.name())), format!("{}_source", stage.name()))
        }
        None => ("SOURCE".to_string(), "source".to_string()),
    };
    let name = scope.take(&wanted);
    let function = scope.take(&function);
    let includes = shader.layout.interface.as_ref().map_or(&[][..], |found| &found.includes);
    let with_includes = !includes.is_empty();
    let (about, value) = match with_includes {
        true => ("with the files that it includes, as they were", literal(shader.layout, includes)),
        false => ("", format!("include_str!({path})")),
    };
    let about = format!("The text of `{}` {about}", shader.input);
    out.constant(&format!("{}.", about.trim_end()), &format!("{name}: &str"), &value);
    match options.sources {
        Sources::LoadedInDebug if with_includes => {
            out.item(
                &format!("[`{name}`]: a build replaces it when one of its files changes."),
                &format!(
                    "{PUB} fn {function}() -> std::borrow::Cow<'static, str> {{\n    \
                     {name}.into()\n}}"
                ),
            );
            Some(format!("{function}()"))
        }
        Sources::LoadedInDebug => {
            let file = format!("{name}_FILE");
            let about = format!("The file of [`{name}`] on the machine that compiled the program.");
            out.constant(&about, &format!("{file}: &str"), path);
            out.item(
                &format!(
                    "[`{name}`]; with `debug_assertions` the file's text as it is now, if it can be \
                     read."
                ),
                &format!(
                    "{PUB} fn {function}() -> std::borrow::Cow<'static, str> {{\n    \
                     if cfg!(debug_assertions) {{\n        \
                     if let Ok(text) = std::fs::read_to_string({file}) {{\n            \
                     return text.into();\n        }}\n    }}\n    {name}.into()\n}}"
                ),
            );
            Some(format!("{function}()"))
        }
        Sources::Embedded | Sources::Without => Some(format!("{name}.into()")),
    }
}

/// Prints the text of a shader, and for WGSL what makes a module of it.
pub(super) fn with_module(
    program: &Program<'_>,
    shader: &ProgramShader<'_>,
    options: &BindingOptions,
    scope: &mut Scope,
    out: &mut Module,
) {
    let Some(text) = source(program, shader, options, scope, out) else { return };
    if shader.layout.language == Language::Wgsl {
        out.item(
            &format!("Creates the module of `{}`.", shader.input),
            &format!(
                "{PUB} fn shader_module(device: &wgpu::Device) -> wgpu::ShaderModule {{\n    \
                 device.create_shader_module(wgpu::ShaderModuleDescriptor {{\n        \
                 label: Some({:?}),\n        \
                 source: wgpu::ShaderSource::Wgsl({text}),\n    }})\n}}",
                shader.input
            ),
        );
    }
}

/// The text of a shader as a literal, with each `#include` that was executed replaced by its file:
/// compilers of GLSL open none.
fn literal(shader: &ShaderLayout, mut includes: &[Include]) -> String {
    let mut text = String::new();
    append(shader, (0, 1), &mut includes, &mut text);
    let mut literal = "\"\\\n".to_string();
    for line in text.split_inclusive('\n') {
        // As Rust spells a string, without its quotes.
        let shown = format!("{line:?}");
        let shown = &shown[1..shown.len() - 1];
        // Rust leaves out white space after a line that ends in `\`.
        match shown.strip_prefix(' ') {
            Some(rest) => writeln!(literal, "\\x20{rest}\\"),
            None => writeln!(literal, "{shown}\\"),
        }
        .expect("a string takes text");
    }
    literal.push('"');
    literal
}

/// Appends the text of a file that is included at a depth; `rest` are the directives that follow.
fn append(
    shader: &ShaderLayout,
    (file, depth): (u32, usize),
    rest: &mut &[Include],
    out: &mut String,
) {
    let text = shader.files.get(file).map_or("", |file| &file.text);
    let mut at = 0;
    // Directives are listed in the order of the text, each before those of the file it includes.
    while let Some((next, others)) = rest.split_first().filter(|(next, _)| next.depth == depth) {
        *rest = others;
        // Whatever precedes the directive's name on its line, `#` and spaces, goes with it.
        let hash = text[..next.span.start as usize].rfind('#').expect("a directive has a `#`");
        append_own(&text[at..hash], out);
        append(shader, (next.file, depth + 1), rest, out);
        // The line's own end follows.
        out.truncate(out.trim_end_matches('\n').len());
        at = next.span.end as usize;
    }
    append_own(&text[at..], out);
}

/// Appends a text without the lines that enable `#include`, which drivers refuse. One that was not
/// executed becomes a comment: naga refuses its quotes in a branch that is left out.
fn append_own(text: &str, out: &mut String) {
    for line in text.split_inclusive('\n') {
        let directive = line.trim_start().strip_prefix('#').map_or("", str::trim_start);
        let extension = directive.strip_prefix("extension").map_or("", str::trim_start);
        if INCLUDE_EXTENSIONS.iter().any(|name| extension.starts_with(name)) {
            out.push('\n');
            continue;
        }
        if directive.starts_with("include") {
            out.push_str("// ");
        }
        out.push_str(line);
    }
}

/// The extensions that allow `#include`.
const INCLUDE_EXTENSIONS: [&str; 3] = [
    "GL_GOOGLE_include_directive",
    "GL_GOOGLE_cpp_style_line_directive",
    "GL_ARB_shading_language_include",
];
