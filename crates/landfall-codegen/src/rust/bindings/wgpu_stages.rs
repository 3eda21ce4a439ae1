//! Stages and pipelines for wgpu, with everything filled that the shaders say.

use landfall_layout::interface::EntryPoint;
use landfall_layout::source::Stage;
use landfall_layout::text::escape;

use super::super::names::{Scope, snake};
use super::WgpuMajor;
use super::program::Program;
use super::text::{Module, PUB, WIDTH};

/// What an entry point's functions refer to.
pub(super) struct StageNames<'a> {
    pub entry: &'a EntryPoint,
    /// The constant that is its name.
    pub constant: String,
    /// Its vertex structure, if it has inputs.
    pub vertex: Option<String>,
    /// Whether its shader has constants that a pipeline sets.
    pub has_constants: bool,
}

/// Prints a function for each entry point, and one for the descriptor of render pipelines.
pub(super) fn stages(
    program: &Program<'_>,
    names: &[StageNames<'_>],
    major: WgpuMajor,
    scope: &mut Scope,
    out: &mut Module,
) {
    for one in names {
        match one.entry.stage {
            Some(Stage::Vertex) => vertex(one, scope, out),
            Some(Stage::Fragment) => fragment(one, scope, out),
            Some(Stage::Compute) => compute(one, scope, out),
            _ => {}
        }
    }
    if names.iter().any(|one| one.entry.stage == Some(Stage::Vertex)) {
        // Renamed in wgpu 28.
        let multiview = if major == WgpuMajor::V27 { "multiview" } else { "multiview_mask" };
        let name = scope.take("render_pipeline");
        out.item(
            "The descriptor of a render pipeline of these stages; what no shader says is the default.",
            &format!(
                "{PUB} fn {name}<'a>(\n    layout: &'a wgpu::PipelineLayout,\n    \
                 vertex: wgpu::VertexState<'a>,\n    fragment: Option<wgpu::FragmentState<'a>>,\n) \
                 -> wgpu::RenderPipelineDescriptor<'a> {{\n    \
                 wgpu::RenderPipelineDescriptor {{\n        label: Some({:?}),\n        \
                 layout: Some(layout),\n        vertex,\n        \
                 primitive: wgpu::PrimitiveState::default(),\n        depth_stencil: None,\n        \
                 multisample: wgpu::MultisampleState::default(),\n        fragment,\n        \
                 {multiview}: None,\n        cache: None,\n    }}\n}}",
                program.name
            ),
        );
    }
}

fn vertex(one: &StageNames<'_>, scope: &mut Scope, out: &mut Module) {
    let name = scope.take(&snake(&format!("{}_vertex_state", one.entry.name)));
    let shown = escape::name(&one.entry.name);
    let (about, buffers) = match &one.vertex {
        Some(vertex) => (
            format!("The vertex stage `{shown}`, with a buffer of [`{vertex}`] for each vertex."),
            // A constant, so that a reference to it lives as long as the program.
            format!("const {{ &[{vertex}::layout(wgpu::VertexStepMode::Vertex)] }}"),
        ),
        None => (format!("The vertex stage `{shown}`, without buffers."), "&[]".to_string()),
    };
    let head = one.head(out, &name, &[], "wgpu::VertexState<'a>");
    let mut line = format!("        buffers: {buffers},\n");
    // rustfmt breaks a `const` block that is too long.
    if line.len() > WIDTH + 1 {
        line = line.replace("const { ", "const {\n            ").replace(" },", "\n        },");
    }
    out.item(
        &about,
        &format!("{head}    wgpu::VertexState {{\n{}{line}    }}\n}}", one.shared("        ")),
    );
}

fn fragment(one: &StageNames<'_>, scope: &mut Scope, out: &mut Module) {
    let name = scope.take(&snake(&format!("{}_fragment_state", one.entry.name)));
    let targets = "targets: &'a [Option<wgpu::ColorTargetState>]";
    let head = one.head(out, &name, &[targets], "wgpu::FragmentState<'a>");
    out.item(
        &format!(
            "The fragment stage `{}`, which writes these targets.",
            escape::name(&one.entry.name)
        ),
        &format!(
            "{head}    wgpu::FragmentState {{\n{}        targets,\n    }}\n}}",
            one.shared("        ")
        ),
    );
}

fn compute(one: &StageNames<'_>, scope: &mut Scope, out: &mut Module) {
    let name = scope.take(&snake(&format!("{}_pipeline", one.entry.name)));
    let device = "device: &wgpu::Device,\n    ";
    let constants = if one.has_constants { "    constants: &[(&'static str, f64)],\n" } else { "" };
    out.item(
        &format!("Creates the compute pipeline `{}`.", escape::name(&one.entry.name)),
        &format!(
            "{PUB} fn {name}(\n    {device}module: &wgpu::ShaderModule,\n{constants}) -> \
             wgpu::ComputePipeline {{\n    \
             device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {{\n        \
             label: Some({:?}),\n        layout: Some(&pipeline_layout(device)),\n{}        \
             cache: None,\n    }})\n}}",
            &*one.entry.name,
            one.shared("        ")
        ),
    );
}

impl StageNames<'_> {
    /// The head of a function that returns a stage: in one line if there is room, as rustfmt has it.
    fn head(&self, out: &Module, name: &str, more: &[&str], result: &str) -> String {
        let mut parameters = vec!["module: &'a wgpu::ShaderModule"];
        if self.has_constants {
            parameters.push("constants: &'a [(&'static str, f64)]");
        }
        parameters.extend(more);
        let line = format!("fn {name}<'a>({}) -> {result} {{\n", parameters.join(", "));
        if out.public.len() + line.len() <= WIDTH {
            return format!("{PUB} {line}");
        }
        let parameters: String =
            parameters.iter().map(|parameter| format!("    {parameter},\n")).collect();
        format!("{PUB} fn {name}<'a>(\n{parameters}) -> {result} {{\n")
    }

    /// The fields that every stage has.
    fn shared(&self, indent: &str) -> String {
        let options = match self.has_constants {
            true => format!(
                "wgpu::PipelineCompilationOptions {{\n{indent}    constants,\n{indent}    \
                 ..Default::default()\n{indent}}}"
            ),
            false => "wgpu::PipelineCompilationOptions::default()".to_string(),
        };
        let constant = &self.constant;
        format!(
            "{indent}module,\n{indent}entry_point: Some({constant}),\n{indent}compilation_options: \
             {options},\n"
        )
    }
}
