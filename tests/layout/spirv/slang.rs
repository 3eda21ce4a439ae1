//! Modules of Slang's compiler, from its registry package, against what it says itself of the layout.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use landfall_layout::{Options, Source, layout};
use serde_json::Value;

const SHADER: &str = "
struct Light { float3 color; float power; float3x3 basis; float weights[3]; bool on; };
struct Inner { half h; float2 uv; int64_t big; };
struct Scene {
    float4 ambient; Light lights[4]; float2x3 turn; int count; Inner inner; float tail[2][3];
};
struct Push { float4x4 model; float3 tint; float gain; };
ConstantBuffer<Scene> scene;
StructuredBuffer<Light> list;
RWStructuredBuffer<Inner> inners;
RWStructuredBuffer<float> result;
[[vk::push_constant]] Push push;
cbuffer Loose {
    float3 eye; float2 size; float gamma; row_major float3x4 rows; column_major float3x4 cols;
}
[shader(\"compute\")] [numthreads(4, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
    Light l = list[id.x];
    float3 v = mul(l.basis, l.color) + mul(scene.turn, l.color).xyx + push.tint * push.gain + eye;
    v += mul(rows, float4(v, 1)) + mul(cols, float4(v, 1)) + mul(push.model, float4(v, 1)).xyz;
    float sum = inners[0].uv.x + scene.inner.uv.y + scene.tail[1][2] + (l.on ? l.weights[1] : gamma);
    sum += (float)inners[1].big + (float)scene.inner.h + (float)scene.inner.big + size.x;
    result[id.x] = dot(v, scene.lights[scene.count].color) + sum;
}
";

/// The offset and strides of each leaf of a type in the reflection, below a path.
fn leaves(ty: &Value, (path, base): (String, u64), out: &mut BTreeMap<String, (u64, Vec<u64>)>) {
    match ty["kind"].as_str().expect("a kind") {
        "struct" => {
            for field in ty["fields"].as_array().expect("fields") {
                let name = field["name"].as_str().expect("a name");
                let path = if path.is_empty() { name.into() } else { format!("{path}.{name}") };
                let at = base + field["binding"]["offset"].as_u64().expect("an offset");
                leaves(&field["type"], (path, at), out);
            }
        }
        "array" => {
            let mut inner = BTreeMap::new();
            leaves(&ty["elementType"], (format!("{path}[]"), base), &mut inner);
            let stride = ty["uniformStride"].as_u64().expect("a stride");
            out.extend(inner.into_iter().map(|(path, (at, mut strides))| {
                strides.insert(0, stride);
                (path, (at, strides))
            }));
        }
        _ => drop(out.insert(path, (base, Vec::new()))),
    }
}

#[test]
fn modules_of_slang_are_laid_out_as_it_reflects_them() {
    let slangc =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("target/languages/slang/slangtorch/bin/slangc");
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("slang");
    std::fs::create_dir_all(&directory).expect("the target directory can be written");
    std::fs::write(directory.join("a.slang"), SHADER).expect("it can be written");
    for (flag, of_scene) in [
        ("-DSTANDARD", "std140"),
        ("-fvk-use-scalar-layout", "scalar"),
        ("-fvk-use-gl-layout", "std140"),
        ("-fvk-use-dx-layout", "d3d"),
    ] {
        let out = Command::new(&slangc)
            .current_dir(&directory)
            .env("LD_LIBRARY_PATH", slangc.parent().expect("a folder"))
            .args(["a.slang", "-target", "spirv", "-profile", "spirv_1_5", "-entry", "main", "-O0"])
            .args(["-stage", "compute", "-o", "a.spv", "-reflection-json", "a.json", flag])
            .output()
            .expect("tests/run installs slangc");
        assert!(out.status.success(), "{flag}: {}", String::from_utf8_lossy(&out.stderr));
        let bytes = std::fs::read(directory.join("a.spv")).expect("a module");
        let source = Source::from_bytes("a.spv", bytes).expect("a module");
        let shader = layout(&source, &Options::default());
        assert!(!shader.has_errors(), "{flag}: {:#?}", shader.diagnostics);
        let json = std::fs::read_to_string(directory.join("a.json")).expect("a reflection");
        let json: Value = serde_json::from_str(&json).expect("JSON");
        let mut held = 0;
        for parameter in json["parameters"].as_array().expect("parameters") {
            let (name, ty) = (parameter["name"].as_str().expect("a name"), &parameter["type"]);
            let is_list = ty["kind"] == "resource";
            let mut theirs = BTreeMap::new();
            let element = if is_list { &ty["resultType"] } else { &ty["elementType"] };
            leaves(element, (String::new(), 0), &mut theirs);
            let of_name =
                |block: &&landfall_layout::BlockLayout| block.instance.as_deref() == Some(name);
            let block = shader.blocks.iter().find(of_name);
            let block = block.unwrap_or_else(|| panic!("{flag}: no block `{name}`"));
            if name == "scene" {
                assert_eq!(block.rules.name(), of_scene, "{flag}");
            }
            // Slang wraps arrays in structures of a member `data`, and lists in one without a name.
            let ours = block.leaves.iter().map(|leaf| {
                let path = leaf.path.replace(".data[]", "[]");
                let path = match is_list {
                    true => {
                        path.split_once("[]").map_or("", |(_, rest)| rest.trim_start_matches('.'))
                    }
                    false => &path,
                };
                let strides = leaf.strides[usize::from(is_list)..].to_vec();
                (path.to_string(), (leaf.offset.expect("an offset"), strides))
            });
            assert_eq!(ours.collect::<BTreeMap<_, _>>(), theirs, "{flag}: {name}");
            held += theirs.len();
        }
        assert_eq!(held, 29, "{flag}");
    }
}
