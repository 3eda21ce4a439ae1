//! Prints the generated descriptors, push constants and vertex attributes of each program, and makes
//! its layouts and a pipeline of its SPIR-V with them.
#![deny(warnings)]

mod generated {
    #![allow(dead_code)]
    use super::*;
    include!(env!("LANDFALL_GENERATED"));
}

use ash::vk;

/// The constants of a program.
pub struct Program {
    pub name: &'static str,
    pub sets: Vec<(u32, Vec<vk::DescriptorSetLayoutBinding<'static>>)>,
    pub push: Option<vk::PushConstantRange>,
    pub vertex:
        Option<(vk::VertexInputBindingDescription, Vec<vk::VertexInputAttributeDescription>)>,
    /// The SPIR-V of each stage.
    pub stages: Vec<(vk::ShaderStageFlags, &'static [u8])>,
}

fn main() {
    for program in generated::programs() {
        println!("program {}", program.name);
        for (set, bindings) in &program.sets {
            for one in bindings {
                println!(
                    "set {set} binding {} {:?} x{} {:?}",
                    one.binding, one.descriptor_type, one.descriptor_count, one.stage_flags
                );
            }
        }
        if let Some(push) = program.push {
            println!("push {} {:?}", push.size, push.stage_flags);
        }
        if let Some((_, attributes)) = &program.vertex {
            for one in attributes {
                println!("location {} {:?}", one.location, one.format);
            }
        }
        // SAFETY: the program's layouts are those of its shaders, as the test compares.
        unsafe { pipeline(&program) }
    }
}

/// Makes the pipeline of a program.
unsafe fn pipeline(program: &Program) {
    unsafe {
        let entry = ash::Entry::load().expect("a Vulkan loader");
        let version = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let create = vk::InstanceCreateInfo::default().application_info(&version);
        let instance = entry.create_instance(&create, None).expect("an instance");
        let physical = instance.enumerate_physical_devices().expect("devices")[0];
        let queue = vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0]);
        let features = instance.get_physical_device_features(physical);
        let mut dynamic =
            vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
        // Mesa 22's driver makes pipelines of unsized arrays without the feature.
        let mut indexing = vk::PhysicalDeviceDescriptorIndexingFeatures::default();
        let mut known = vk::PhysicalDeviceFeatures2::default().push_next(&mut indexing);
        instance.get_physical_device_features2(physical, &mut known);
        let create = vk::DeviceCreateInfo::default()
            .queue_create_infos(std::slice::from_ref(&queue))
            .enabled_features(&features)
            .push_next(&mut indexing)
            .push_next(&mut dynamic);
        let device = instance.create_device(physical, &create, None).expect("a device");
        let count = program.sets.iter().map(|(set, _)| set + 1).max().unwrap_or(0);
        let layouts: Vec<_> = (0..count)
            .map(|set| {
                let of = program.sets.iter().find(|(known, _)| *known == set);
                let bindings = of.map_or(&[][..], |(_, bindings)| bindings);
                let create = vk::DescriptorSetLayoutCreateInfo::default().bindings(bindings);
                device.create_descriptor_set_layout(&create, None).expect("a set layout")
            })
            .collect();
        let push: Vec<_> = program.push.into_iter().collect();
        let create = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(&layouts)
            .push_constant_ranges(&push);
        let layout = device.create_pipeline_layout(&create, None).expect("a pipeline layout");
        let stages: Vec<_> = program
            .stages
            .iter()
            .map(|(stage, code)| {
                let code = ash::util::read_spv(&mut std::io::Cursor::new(code)).expect("SPIR-V");
                let create = vk::ShaderModuleCreateInfo::default().code(&code);
                let module = device.create_shader_module(&create, None).expect("a module");
                vk::PipelineShaderStageCreateInfo::default()
                    .stage(*stage)
                    .module(module)
                    .name(c"main")
            })
            .collect();
        let cache = vk::PipelineCache::null();
        if stages[0].stage == vk::ShaderStageFlags::COMPUTE {
            let create = vk::ComputePipelineCreateInfo::default().layout(layout).stage(stages[0]);
            device.create_compute_pipelines(cache, &[create], None).expect("a pipeline");
            return;
        }
        let (binding, attributes) = program.vertex.clone().unzip();
        let binding: Vec<_> = binding.into_iter().collect();
        let attributes = attributes.unwrap_or_default();
        let input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&binding)
            .vertex_attribute_descriptions(&attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport =
            vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&states);
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let attachment = vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::RGBA);
        let blend = vk::PipelineColorBlendStateCreateInfo::default()
            .attachments(std::slice::from_ref(&attachment));
        let formats = [vk::Format::R8G8B8A8_UNORM];
        let mut rendering =
            vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&formats);
        let create = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .dynamic_state(&dynamic)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .color_blend_state(&blend)
            .layout(layout)
            .push_next(&mut rendering);
        device.create_graphics_pipelines(cache, &[create], None).expect("a pipeline");
    }
}
