//! The text of shaders in the generated code.

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
    // Neither naga nor OpenGL opens includes.
    if shader.layout.files.iter().count() > 1 {
        return None;
    }
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
    let about = format!("The text of `{}`.", shader.input);
    out.constant(&about, &format!("{name}: &str"), &format!("include_str!({path})"));
    match options.sources {
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
