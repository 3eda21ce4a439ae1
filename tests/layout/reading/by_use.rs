//! Lengths of arrays that are declared without one: glslang's are the oracle.

use super::{Client, compiled, leaves, read};
use landfall_layout::ArrayLen;

fn shader(block: &str, body: &str) -> String {
    format!(
        "#version 450\nlayout(location = 0) out vec4 o;\nstruct S {{ float a[9]; }};\n\
         const int K = 2;\nlayout(std140, binding = 0) uniform U {{ {block} }};\n{body}\n"
    )
}

/// The lengths of `a` in glslang's SPIR-V; what follows such an array it places as if that had one
/// element.
fn lengths(text: &str) -> Vec<u32> {
    let blocks = compiled(text, Client::Vulkan).unwrap_or_else(|log| panic!("{log}\n{text}"));
    let leaf = blocks[0].leaves.iter().find(|leaf| leaf.path.contains("a[]")).expect("it has one");
    leaf.dims.iter().map(|len| u32::try_from(len.unwrap()).unwrap()).collect()
}

#[test]
fn names_in_bodies_are_those_of_their_scope() {
    for (block, body, length) in [
        ("float a[];", "void main() { { float a[3]; o = vec4(a[2]); } o += vec4(a[4]); }", 5),
        ("float a[];", "void main() { float a = a[4]; o = vec4(a); }", 5),
        ("float a[];", "void main() { float b = a[4], a = b; o = vec4(a); }", 5),
        ("float a[];", "float f(float a[9]) { return a[8]; } void main() { o = vec4(a[4]); }", 5),
        ("float a[];", "void main() { for (int a = 0; a < 8; a++) {} o = vec4(a[4]); }", 5),
        ("float a[];", "void main() { if (o.x > 1.0) float a = 1.0; o = vec4(a[4]); }", 5),
        ("float a[];", "void main() { S s; o = vec4(a[4] + s.a[8]); }", 5),
        ("float a[];", "void main() { o = vec4((a)[6]); }", 7),
        ("float a[];", "void main() { o = vec4(((a))[1 + K]); }", 4),
        ("float a[];", "void main() { const int K = 7; o = vec4(a[K]); }", 8),
        ("float a[];", "void main() { { const int K = 7; } o = vec4(a[K]); }", 3),
        ("float[] a;", "void main() { o = vec4(a[4]); }", 5),
        ("vec4 a[];", "void main() { if (o.x > 1.0) { vec4 a = o; o = a; } else o = a[6]; }", 7),
        ("mat4 a[];", "void main() { o = a[4][3]; }", 5),
    ] {
        let text = shader(block, body);
        assert_eq!(lengths(&text), [length], "{text}");
        of_landfall(&text, &[length]);
    }
    for (instance, body, length) in [
        ("u", "void main() { float a[7]; o = vec4(u.a[4] + a[6]); }", 5),
        ("u", "void main() { o = vec4((u.a)[6]); }", 7),
        ("u", "void main() { o = vec4((u).a[6]); }", 7),
        ("u[2]", "void main() { o = vec4(u[0].a[4] + u[1].a[6]); }", 7),
        ("u", "void f() { S u; o = vec4(u.a[8]); } void main() { o = vec4(u.a[4]); f(); }", 5),
    ] {
        let text = shader("float a[];", body).replace("};\nvoid", &format!("}} {instance};\nvoid"));
        assert_eq!(lengths(&text), [length], "{text}");
        of_landfall(&text, &[length]);
    }
}

fn of_landfall(text: &str, dims: &[u32]) {
    let shader = read(text, None);
    assert!(!leaves(&shader).is_empty());
    let block = shader.blocks.iter().find(|block| &*block.name == "U").unwrap();
    let leaf = block.leaves.iter().find(|leaf| leaf.path.contains("a[]")).unwrap();
    let dims: Vec<_> = dims.iter().map(|len| ArrayLen::Fixed(*len)).collect();
    assert_eq!(leaf.dims, dims, "{text}");
}

#[test]
fn two_blocks_have_lengths_of_their_own() {
    let text = shader("float a[];", "void main() { o = vec4(a[4] + w.a[8]); }").replace(
        "void main",
        "layout(std140, binding = 1) uniform W { vec4 b; float a[]; } w;\nvoid main",
    );
    assert_eq!(lengths(&text), [5]);
    of_landfall(&text, &[5]);
    assert_eq!(read(&text, None).blocks[1].data_size, Some(160));
}

#[test]
fn only_the_outer_dimension_is_open() {
    for (block, body, dims) in [
        ("float a[][2];", "void main() { o = vec4(a[3][1]); }", Some([4, 2])),
        ("float[2] a[];", "void main() { o = vec4(a[4][0]); }", Some([5, 2])),
        ("float[][2] a;", "void main() { o = vec4(a[4][0]); }", Some([5, 2])),
        ("float a[2][];", "void main() { o = vec4(a[1][4]); }", None),
        ("float a[];", "void main() { o = vec4(a[1] + a.length()); }", None),
        ("float a[];", "void main() { int i = 1; o = vec4(a[1] + a[i]); }", None),
    ] {
        let text = shader(block, body);
        match dims {
            Some(dims) => {
                assert_eq!(lengths(&text), dims, "{text}");
                of_landfall(&text, &dims);
            }
            None => {
                assert!(compiled(&text, Client::Vulkan).is_err(), "{text}");
                assert!(read(&text, None).has_errors(), "{text}");
            }
        }
    }
}
