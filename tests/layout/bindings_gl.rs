//! Bindings for OpenGL, compared with what the driver reports of the linked program.
#![allow(unsafe_code, reason = "every call into OpenGL is unsafe")]

use std::collections::BTreeMap;

use glow::HasContext as _;
use landfall_codegen::rust::{Api, RustOptions, rust};
use landfall_layout::{Options, Source, layout};

use crate::support::driver::{self, Driver};

const VERTEX: &str = "#version 450
layout(location = 3) in vec3 position;
in vec2 texcoord;
layout(std140, binding = 2) uniform Camera { mat4 view; vec3 eye; } camera;
layout(location = 0) out vec2 uv;
void main() {
    uv = texcoord;
    gl_Position = camera.view * vec4(position + camera.eye, 1.0);
}
";

const FRAGMENT: &str = "#version 450
struct Material { sampler2D diffuse; float shine; };
struct Light { vec3 position; float radius; };
layout(std140, binding = 2) uniform Camera { mat4 view; vec3 eye; } camera;
layout(std430, binding = 1) readonly buffer Lights { Light lights[]; };
layout(std140) uniform Sun { vec4 direction; };
layout(std140, binding = 7) uniform Unused { vec4 nothing; };
layout(binding = 4) uniform sampler2D albedo;
layout(location = 9) uniform sampler2DArray layers;
layout(binding = 0, rgba8) uniform writeonly image2D trail;
uniform Material material;
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;
void main() {
    vec3 at = lights[0].position * lights[1].radius + camera.eye * direction.xyz;
    color = texture(albedo, uv) + texture(layers, vec3(uv, 0.0)) + texture(material.diffuse, uv);
    color *= vec4(at, material.shine);
    imageStore(trail, ivec2(0), color);
}
";

/// The constants of the generated module by name.
fn generated() -> BTreeMap<String, String> {
    let options = Options::default().with_interface(true);
    let shaders = [("scene.vert", VERTEX), ("scene.frag", FRAGMENT)]
        .map(|(path, text)| layout(&Source::new(path, text), &options));
    for shader in &shaders {
        assert!(!shader.has_errors(), "{:#?}", shader.diagnostics);
    }
    let mut options = RustOptions::default();
    options.bindings.apis = vec![Api::OpenGl];
    let text = rust(&shaders.iter().collect::<Vec<_>>(), &options).text;
    let (_, bindings) = text.split_once("pub mod gl_bindings").expect("a module");
    let constants = bindings.lines().filter_map(|line| {
        let (name, value) = line.trim().strip_prefix("pub const ")?.split_once(" = ")?;
        let (name, _) = name.split_once(':')?;
        Some((name.to_string(), value.trim_end_matches(';').trim_matches('"').to_string()))
    });
    constants.collect()
}

#[test]
fn names_bindings_and_locations_are_those_of_the_linked_program() {
    let driver = Driver::open(driver::Api::Gl);
    let gl = driver.gl();
    // SAFETY: objects are made and used in the current context.
    let expected = unsafe {
        let program = gl.create_program().expect("a program");
        for (stage, text) in [(glow::VERTEX_SHADER, VERTEX), (glow::FRAGMENT_SHADER, FRAGMENT)] {
            let shader = gl.create_shader(stage).expect("a shader");
            gl.shader_source(shader, text);
            gl.compile_shader(shader);
            assert!(gl.get_shader_compile_status(shader), "{}", gl.get_shader_info_log(shader));
            gl.attach_shader(program, shader);
        }
        gl.link_program(program);
        assert!(gl.get_program_link_status(program), "{}", gl.get_program_info_log(program));
        let mut expected = BTreeMap::new();
        let mut add = |name: &str, value: String| drop(expected.insert(name.to_string(), value));
        let blocks = gl.get_program_parameter_i32(program, glow::ACTIVE_UNIFORM_BLOCKS);
        for at in 0..u32::try_from(blocks).expect("a count") {
            let name = gl.get_active_uniform_block_name(program, at);
            // A std140 block is active where no shader uses it (OpenGL 4.6 §7.6); bindings leave it out.
            if name == "Unused" {
                continue;
            }
            let of = |what| gl.get_active_uniform_block_parameter_i32(program, at, what);
            let upper = name.to_uppercase();
            add(&format!("{upper}_BLOCK"), name.clone());
            add(&format!("{upper}_SIZE"), of(glow::UNIFORM_BLOCK_DATA_SIZE).to_string());
            // A block without a binding has 0.
            let binding = of(glow::UNIFORM_BLOCK_BINDING);
            if binding != 0 {
                add(&format!("{upper}_BINDING"), binding.to_string());
            }
        }
        // The least size for one element, and the binding, as declared: glow has no query of them.
        assert_eq!(gl.get_shader_storage_block_index(program, "Lights"), Some(0));
        add("LIGHTS_BLOCK", "Lights".to_string());
        add("LIGHTS_SIZE", "16".to_string());
        add("LIGHTS_BINDING", "1".to_string());
        for at in 0..gl.get_active_uniforms(program) {
            let uniform = gl.get_active_uniform(program, at).expect("a uniform");
            let Some(location) = gl.get_uniform_location(program, &uniform.name) else { continue };
            if uniform.utype == glow::FLOAT {
                continue;
            }
            let upper = uniform.name.replace('.', "_").to_uppercase();
            add(&format!("{upper}_UNIFORM"), uniform.name.clone());
            let mut unit = [0];
            gl.get_uniform_i32(program, &location, &mut unit);
            match uniform.name.as_str() {
                "albedo" | "trail" => add(&format!("{upper}_BINDING"), unit[0].to_string()),
                "layers" => add("LAYERS_LOCATION", location.0.to_string()),
                _ => {}
            }
        }
        for at in 0..gl.get_active_attributes(program) {
            let attribute = gl.get_active_attribute(program, at).expect("an attribute");
            let upper = attribute.name.to_uppercase();
            add(&format!("{upper}_ATTRIBUTE"), attribute.name.clone());
            if attribute.name == "position" {
                let location = gl.get_attrib_location(program, "position").expect("a location");
                add("POSITION_LOCATION", location.to_string());
            }
        }
        expected
    };
    assert_eq!(generated(), expected);
}
