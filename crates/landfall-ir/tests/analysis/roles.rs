//! Lights by their names, in both languages, and what is none.

use landfall_ir::analysis::roles::{LightBinding, lights_in_blocks};
use landfall_layout::{Options, Source, layout};

/// Kind, path and parts of every light, as text.
fn lights(name: &str, text: &str) -> Vec<String> {
    let shader = layout(&Source::new(name, text), &Options::default());
    assert!(shader.diagnostics.is_empty(), "{:?}", shader.diagnostics);
    let all = lights_in_blocks(&shader.blocks);
    let line = |light: &LightBinding<'_>| {
        let parts = light.roles.parts.iter().map(|p| format!("{}={}", p.path, p.role.name()));
        let count = light.count.map(|c| format!(" count {}", c.member.name));
        format!(
            "{} {} {}: {}{}",
            light.roles.kind.name(),
            light.block.name,
            light.path,
            parts.collect::<Vec<_>>().join(" "),
            count.unwrap_or_default(),
        )
    };
    all.iter().map(line).collect()
}

#[test]
fn a_counted_array_of_point_lights() {
    let text = "#version 330\nstruct PointLight { vec3 pos; vec3 color; float intensity; \
                float constant; float linear; float quadratic; };\n\
                layout(std140) uniform B { PointLight data[128]; int actually_used_count; } u;\n\
                void main() {}";
    assert_eq!(
        lights("a.frag", text),
        ["point B data[]: pos=position color=color intensity=intensity constant=constant \
          linear=linear quadratic=quadratic count actually_used_count"]
    );
}

#[test]
fn a_light_in_a_light_lends_it_its_parts() {
    let text = "#version 330\nstruct Attenuation { float constant; float linear; float exponent; };\n\
                struct PointLight { vec3 position; vec3 colour; float intensity; Attenuation att; };\n\
                struct SpotLight { PointLight pl; vec3 conedir; float cutoff; };\n\
                struct Material { vec4 ambient; vec4 diffuse; vec4 specular; float reflectance; };\n\
                uniform Material material;\nuniform SpotLight spotLights[5];\n\
                uniform int numPointLights;\nvoid main() {}";
    let all = lights("a.frag", text);
    assert_eq!(all.len(), 1, "{all:?}");
    assert!(
        all[0].starts_with("spot DefaultBlock spotLights[]:") || all[0].contains("spotLights[]:")
    );
    for part in
        ["pl.position=position", "pl.att.exponent=quadratic", "conedir=direction", "cutoff=cone"]
    {
        assert!(all[0].contains(part), "{part}: {}", all[0]);
    }
    assert!(!all[0].contains("count"), "counts another kind: {}", all[0]);
}

#[test]
fn an_inner_and_an_outer_cone() {
    let text = "#version 330\nstruct SpotLight { vec3 position; vec3 direction; float cutOff; \
                float outerCutOff; vec3 ambient; vec3 diffuse; vec3 specular; };\n\
                uniform SpotLight spotLight;\nvoid main() {}";
    let all = lights("a.frag", text);
    assert!(all[0].contains("cutOff=inner_cone outerCutOff=outer_cone"), "{all:?}");
}

#[test]
fn a_block_whose_members_are_a_light_and_members_named_after_one() {
    let block = "#version 330\nlayout(std140) uniform LightBlock { vec3 position; vec3 color; } light;\n\
                 void main() {}";
    assert_eq!(lights("a.frag", block), ["point LightBlock : position=position color=color"]);
    let wgsl = "struct Sun { direction: vec3f, color: vec3f }\n@group(0) @binding(0) var<uniform> sun: Sun;\n";
    assert_eq!(lights("a.wgsl", wgsl), ["directional Sun : direction=direction color=color"]);
    let loose = "#version 330\nuniform vec3 lightPos;\nuniform vec3 lightColor;\nuniform vec3 viewPos;\nvoid main() {}";
    let all = lights("a.frag", loose);
    assert!(all[0].ends_with(": lightPos=position lightColor=color"), "{all:?}");
}

#[test]
fn materials_cameras_and_matrices_are_no_lights() {
    let text = "#version 330\nstruct Material { vec3 ambient; vec3 diffuse; vec3 specular; float shininess; };\n\
                struct Particle { vec3 position; vec4 color; float radius_; };\n\
                layout(std140) uniform Camera { mat4 view; vec3 position; } camera;\n\
                layout(std140) uniform Shadow { mat4 lightSpaceMatrix; } shadow;\n\
                uniform Material material;\nvoid main() {}";
    assert_eq!(lights("a.frag", text), Vec::<String>::new());
}
