//! Fragment shaders as GLSL ES 3.00, which WebGL 2 takes, written by naga.

use naga::back::glsl::{self, PipelineOptions, Version, Writer, WriterFlags};
use naga::back::pipeline_constants::process_overrides;

use crate::Module;
use landfall_layout::naga_front;

/// A shader in GLSL ES 3.00.
#[derive(Clone, Debug)]
pub struct EsShader {
    pub text: String,
    /// The name of each block of the module in the text; `None` for those that it does not read.
    pub blocks: Vec<Option<String>>,
    /// The samplers of the text, and the index of the handle each takes its texels from; `None` for
    /// a texture that is no handle of the module's own.
    pub textures: Vec<(String, Option<usize>)>,
}

impl Module {
    /// Returns the fragment entry point of that name as GLSL ES 3.00.
    ///
    /// Uniform blocks are std140 there, which has no offsets of its own: a block that is laid out
    /// otherwise is an error, as are storage buffers.
    ///
    /// # Errors
    /// naga's error if it cannot write the module, or the name of such a block.
    pub fn es(&self, entry: &str) -> Result<EsShader, String> {
        let read = |block: &crate::module::ModuleBlock| {
            // Blocks that the entry point does not read are not written, so their layout does not
            // matter.
            let index = self.ir.entry_points.iter().position(|one| one.name == entry);
            index.is_some_and(|at| !self.info.get_entry_point(at)[block.variable].is_empty())
        };
        let wrong = self.blocks.iter().filter(|block| read(block)).find(|block| {
            block.layout.space != landfall_layout::AddressSpace::Uniform
                // WGSL's rules for uniform blocks give the same offsets as std140 wherever naga
                // accepts a block.
                || block.layout.rules != landfall_layout::Rules::Std140
                    && block.layout.rules != landfall_layout::Rules::Wgsl
        });
        if let Some(block) = wrong {
            let (name, rules) = (&block.layout.name, block.layout.rules.name());
            let space = block.layout.space.name();
            return Err(format!(
                "`{name}` is a {space} block laid out by {rules}; WebGL 2 has uniform blocks in std140"
            ));
        }
        let options = glsl::Options {
            version: Version::Embedded { version: 300, is_webgl: true },
            writer_flags: WriterFlags::empty(),
            ..glsl::Options::default()
        };
        let pipeline = PipelineOptions {
            shader_stage: naga::ShaderStage::Fragment,
            entry_point: entry.to_string(),
            multiview: None,
        };
        let write = || {
            // Overrides must have values before GLSL is written: it has no specialisation
            // constants.
            let (ir, info) = process_overrides(&self.ir, &self.info, None, &Default::default())
                .map_err(|error| error.to_string())?;
            let mut text = String::new();
            let policies = naga::proc::BoundsCheckPolicies::default();
            let reflected = Writer::new(&mut text, &ir, &info, &options, &pipeline, policies)
                .and_then(|mut writer| writer.write())
                .map_err(|error| error.to_string())?;
            // naga leaves out what the entry point does not need, and numbers the rest anew.
            let place = |variable: naga::Handle<naga::GlobalVariable>| {
                ir.global_variables[variable].binding.map(|place| (place.group, place.binding))
            };
            let name = |block: &crate::module::ModuleBlock| {
                // Handles of the processed module differ from ours; group and binding are what
                // both have.
                let wanted = Some((block.group, block.binding));
                let mut uniforms = reflected.uniforms.iter();
                uniforms
                    .find(|(variable, _)| place(**variable) == wanted)
                    .map(|(_, name)| name.clone())
            };
            let handle = |texture| {
                let wanted = place(texture);
                self.handles.iter().position(|one| Some((one.group, one.binding)) == wanted)
            };
            let mut textures: Vec<(String, Option<usize>)> = reflected
                .texture_mapping
                .iter()
                .map(|(name, mapping)| (name.clone(), handle(mapping.texture)))
                .collect();
            textures.sort();
            Ok(EsShader { text, blocks: self.blocks.iter().map(name).collect(), textures })
        };
        naga_front::caught(write)
            .unwrap_or_else(|| Err("naga panicked while writing this module".to_string()))
    }
}
