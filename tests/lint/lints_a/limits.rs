//! `over-limit`, `webgl2-size` and `push-constant-limit`.

use landfall_lint::settings::{Figure, Table, Target};
use landfall_lint::{Settings, lint};
use snapbox::str;

use super::{found, found_in, messages, only, place, with_targets};
use crate::support::command::golden;

fn over(path: &str, text: &str, targets: &[Target]) -> Vec<landfall_layout::finding::Finding> {
    found("over-limit", &[(path, text)], &with_targets(targets))
}

fn frag(declaration: &str) -> String {
    format!("#version 330 core\n{declaration}\nout vec4 o;\nvoid main() {{ o = vec4(0.0); }}\n")
}

#[test]
fn a_uniform_block_of_16_kib_fits_and_one_of_16_bytes_more_does_not() {
    let of = |count: u32| frag(&format!("layout(std140) uniform B {{ vec4 data[{count}]; }} b;"));
    for target in [Target::Gl33, Target::Gles30, Target::WebGl2, Target::Vulkan] {
        assert_eq!(messages(&over("a.frag", &of(1024), &[target])), [""; 0]);
        assert_eq!(over("a.frag", &of(1025), &[target]).len(), 1, "{}", target.name());
    }
    assert_eq!(messages(&over("a.frag", &of(4096), &[Target::WebGpu])), [""; 0]);
    assert_eq!(over("a.frag", &of(4097), &[Target::WebGpu]).len(), 1);
    let finding = only(over("a.frag", &of(1025), &[Target::WebGpu, Target::Gl33]));
    assert_eq!(
        finding.message,
        "block `B` is 16,400 bytes, but OpenGL 3.3 guarantees only 16,384 bytes per uniform block"
    );
    assert_eq!(place(&finding), "2:24");
    assert_eq!(
        finding.notes,
        ["OpenGL 3.3: MAX_UNIFORM_BLOCK_SIZE is at least 16384 (OpenGL 3.3 §6.2)"]
    );
    assert_eq!(
        finding.help.as_deref(),
        Some("make `data` an array of at most 1,024 elements, or split the block")
    );
}

#[test]
fn without_targets_there_is_no_limit() {
    let text = frag("layout(std140) uniform B { vec4 data[4096]; } b;");
    assert_eq!(messages(&found_in("over-limit", "a.frag", &text)), [""; 0]);
    let example = lint("over-limit").unwrap().example;
    assert_eq!(messages(&found_in("over-limit", "a.vert", example)), [""; 0]);
    assert_eq!(over("a.vert", example, &[Target::Gl33]).len(), 1);
}

#[test]
fn a_storage_buffer_of_128_mib_fits() {
    let of = |count: u32| {
        format!(
            "#version 450\nlayout(set = 0, binding = 0) buffer B {{ vec4 data[{count}]; }} b;\n\
             void main() {{ }}"
        )
    };
    let mut all = Vec::new();
    for target in [Target::Vulkan, Target::WebGpu] {
        assert_eq!(messages(&over("a.comp", &of(8 << 20), &[target])), [""; 0]);
        let finding = only(over("a.comp", &of((8 << 20) + 1), &[target]));
        all.push(finding.message);
    }
    golden().eq(
        all.join("\n"),
        str![[r#"
block `B` is 134,217,744 bytes, but Vulkan guarantees only 134,217,728 bytes per storage block
block `B` is 134,217,744 bytes, but WebGPU guarantees only 134,217,728 bytes per storage block
"#]],
    );
    // OpenGL 3.3 has no storage buffers, so no limit of theirs.
    assert_eq!(messages(&over("a.comp", &of((8 << 20) + 1), &[Target::Gl33])), [""; 0]);
}

#[test]
fn the_thirteenth_uniform_block_of_a_stage_is_one_too_many() {
    let of = |count: usize| {
        let block = |n| format!("layout(std140) uniform B{n} {{ vec4 v; }} b{n};\n");
        frag(&(0..count).map(block).collect::<String>())
    };
    assert_eq!(messages(&over("a.frag", &of(12), &[Target::Gl33])), [""; 0]);
    let finding = only(over("a.frag", &of(14), &[Target::Gl33]));
    assert_eq!(
        finding.message,
        "the fragment stage has 14 uniform blocks, but OpenGL 3.3 guarantees only 12"
    );
    assert_eq!(place(&finding), "14:24");
    // An array of blocks is that many.
    let array = frag("layout(std140) uniform B { vec4 v; } b[13];").replace("330", "400");
    assert_eq!(over("a.frag", &array, &[Target::Gles30]).len(), 1);
    // In Vulkan what is declared and not used takes no binding.
    let used = |count: usize, uses: usize| {
        let block =
            |n| format!("layout(set = 0, binding = {n}) buffer B{n} {{ vec4 v{n}; }} b{n};\n");
        let blocks: String = (0..count).map(block).collect();
        let sum: String = (0..uses).map(|n| format!(" + b{n}.v{n}")).collect();
        format!("#version 450\n{blocks}vec4 sum() {{ return vec4(0){sum}; }} void main() {{ }}")
    };
    assert_eq!(messages(&over("a.frag", &used(6, 4), &[Target::Vulkan])), [""; 0]);
    let finding = only(over("a.frag", &used(6, 5), &[Target::Vulkan]));
    golden().eq(
        &finding.message,
        str!["the fragment stage has 5 storage blocks, but Vulkan guarantees only 4"],
    );
}

#[test]
fn loose_uniforms_are_counted_in_components() {
    let of = |count: u32| frag(&format!("uniform mat4 bones[{count}];"));
    // 64 × 16 = 1024 components.
    assert_eq!(messages(&over("a.vert", &of(64), &[Target::Gl33])), [""; 0]);
    let finding = only(over("a.vert", &of(65), &[Target::Gl33]));
    assert_eq!(
        finding.message,
        "the vertex stage has loose uniforms of 1040 components, but OpenGL 3.3 guarantees only 1024"
    );
    assert_eq!(place(&finding), "2:14");
    // A fragment shader of OpenGL ES 3.0 has 224 vectors: 56 matrices.
    assert_eq!(messages(&over("a.frag", &of(56), &[Target::Gles30])), [""; 0]);
    assert_eq!(over("a.frag", &of(57), &[Target::Gles30]).len(), 1);
}

#[test]
fn push_constants_end_by_byte_128() {
    let code = "push-constant-limit";
    let of = |members: &str| {
        format!(
            "#version 450\nlayout(push_constant) uniform P {{ {members} }} p;\nvoid main() {{ }}"
        )
    };
    assert_eq!(messages(&found_in(code, "a.frag", &of("mat4 a; mat4 b;"))), [""; 0]);
    // 124 bytes of members; padded to their alignment it is 128.
    assert_eq!(messages(&found_in(code, "a.frag", &of("mat4 a; vec4 b[3]; vec3 c;"))), [""; 0]);
    let finding = only(found_in(code, "a.frag", &of("mat4 a; mat4 b; float c;")));
    assert_eq!(
        finding.message,
        "push constants `P` end at byte 132, but Vulkan guarantees only 128 bytes"
    );
    assert_eq!(place(&finding), "2:31");
    assert_eq!(finding.related()[0].text, "the first member past it: it ends at byte 132");
    assert_eq!(finding.help.as_deref(), Some("move `c` and what follows it into a uniform block"));
    // A range that starts late has to end in time all the same.
    assert_eq!(found_in(code, "a.frag", &of("layout(offset = 112) vec4 a; vec4 b;")).len(), 1);
    let wgsl = "struct P { a: mat4x4f, b: mat4x4f, c: f32 } var<immediate> p: P;";
    assert_eq!(found_in(code, "a.wgsl", wgsl).len(), 1);
}

/// WebGPU, default limits: maxImmediateSize is 64.
#[test]
fn immediate_data_of_wgsl_end_by_byte_64_unless_vulkan_alone_is_the_target() {
    let code = "push-constant-limit";
    let of = |members: &str| format!("struct P {{ {members} }} var<immediate> p: P;");
    let found = |members: &str, targets: &[Target]| {
        found(code, &[("a.wgsl", &of(members))], &with_targets(targets)).len()
    };
    let (fits, over) = ("a: mat4x4f", "a: mat4x4f, b: f32");
    let cases: [(&[Target], usize); 4] = [
        (&[], 1),
        (&[Target::WebGpu], 1),
        (&[Target::WebGpu, Target::Vulkan], 1),
        (&[Target::Vulkan], 0),
    ];
    for (targets, of_over) in cases {
        assert_eq!((found(fits, targets), found(over, targets)), (0, of_over), "{targets:?}");
    }
    let finding = only(found_in(code, "a.wgsl", &of(over)));
    golden().eq(
        &finding.message,
        str!["immediate data `P` end at byte 68, but WebGPU guarantees only 64 bytes"],
    );
    assert_eq!(found_in(code, "a.frag", lint(code).unwrap().example).len(), 1);
}

#[test]
fn webgl_2_wants_whole_rows_of_16_bytes() {
    let code = "webgl2-size";
    let webgl = with_targets(&[Target::WebGl2]);
    let fog = lint(code).unwrap().example;
    let finding = only(found(code, &[("a.frag", fog)], &webgl));
    assert_eq!(
        finding.message,
        "the members of block `Fog` end at byte 24, but WebGL 2 requires a buffer of 32 bytes"
    );
    assert_eq!(place(&finding), "4:24");
    assert_eq!(
        finding.help.as_deref(),
        Some("make the buffer 32 bytes, or end the block with 8 bytes of padding")
    );
    assert_eq!(messages(&found_in(code, "a.frag", fog)), [""; 0]);
    let padded = fog.replace("float end;", "float end; vec2 pad;");
    assert_eq!(messages(&found(code, &[("a.frag", &padded)], &webgl)), [""; 0]);
    let wgsl = "struct T { time: f32, delta: f32, size: vec2u, seed: u32 }
                @group(0) @binding(0) var<uniform> t: T;
                @group(0) @binding(1) var<storage> s: T;";
    let finding = only(found(code, &[("a.wgsl", wgsl)], &webgl));
    assert_eq!(
        finding.message,
        "block `T` is 24 bytes, but WebGL 2 requires a multiple of 16: 32 bytes"
    );
    // A buffer that is written down as large enough is.
    let table = |bytes| Table {
        block: "Fog".to_string(),
        size: Some(Figure { bytes, ..Figure::default() }),
        ..Table::default()
    };
    let with = |bytes| Settings { tables: vec![table(bytes)], ..webgl.clone() };
    assert_eq!(messages(&found(code, &[("a.frag", fog)], &with(32))), [""; 0]);
    assert_eq!(found(code, &[("a.frag", fog)], &with(24)).len(), 1);
}
