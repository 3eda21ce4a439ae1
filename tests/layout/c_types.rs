//! Types of the program in generated C headers: glm's and its own, in namespaces, filled by
//! designated initialisers. Bytes are held against glslang's SPIR-V.

use landfall_codegen::c::{COptions, CVectors, c};
use snapbox::str;

use crate::c_header::{awkward_blocks_by, random_blocks_by};
use crate::support::c::{Compiler, compile, compile_and_run, directory};
use crate::support::generate::{COMMON, VULKAN};
use crate::support::glslang;
use crate::support::landfall::laid_out_for_vulkan as lay_out;
use crate::support::sample::everything;

fn options(change: impl FnOnce(&mut COptions)) -> COptions {
    let mut options = COptions::default();
    options.file = "blocks.h".to_string();
    change(&mut options);
    options
}

#[test]
fn blocks_with_types_of_glm_are_filled_where_glslang_reads_them() {
    let glm = options(|options| options.vectors = CVectors::Glm);
    awkward_blocks_by(&[Compiler::Cpp17], &glm, "glm_");
    let count = if everything() { 60 } else { 20 };
    let (common, refused) =
        random_blocks_by(&[Compiler::Cpp17], &glm, "glm_common", (7, count, &COMMON));
    assert_eq!(refused, 0, "std140 and std430 fit C++");
    let (vulkan, _) = random_blocks_by(&[Compiler::Cpp17], &glm, "glm_vulkan", (7, count, &VULKAN));
    assert!(common + vulkan >= count * 5 / 3, "{common} and {vulkan} held");
}

const SHADER: &str = "#version 450
    struct Light { vec3 position; float radius; vec3 color; };
    layout(std140) uniform Scene { mat4 view; float exposure; Light lights[2]; vec3 ways[2]; } scene;
    layout(std430) buffer Points { vec3 all[]; } points;
    void main() {}\n";

/// What each leaf is set to, by its path.
const VALUES: &[(&str, &[f32])] = &[
    (
        "view",
        &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0],
    ),
    ("exposure", &[17.0]),
    ("lights[1].position", &[18.0, 19.0, 20.0]),
    ("lights[1].color", &[21.0, 22.0, 23.0]),
    ("ways[0]", &[24.0, 25.0, 26.0]),
];

/// The bytes of `Scene`, from the offsets of glslang.
fn expected() -> Vec<u8> {
    let blocks = glslang::blocks(SHADER, "frag", &glslang::Options::default()).expect("compiles");
    let scene = blocks.iter().find(|block| block.name == "Scene").expect("a block");
    // Two directions of 16 bytes follow two lights of 32, from byte 80: std140.
    let mut bytes = vec![0; 80 + 2 * 32 + 2 * 16];
    for (path, values) in VALUES {
        let pattern = path.replace("[0]", "[]").replace("[1]", "[]");
        let leaf = scene.leaves.iter().find(|leaf| leaf.path == pattern).expect("a leaf");
        let index = u64::from(path.contains("[1]"));
        let at = leaf.offset + index * leaf.strides.first().copied().flatten().unwrap_or(0);
        for (n, value) in values.iter().enumerate() {
            let at = at as usize + 4 * n;
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
    }
    bytes
}

/// A program that prints a scene with all other bytes zero, whatever was on the stack before.
fn initialised(name: &str, compiler: Compiler, options: &COptions, value: &str) -> Vec<u8> {
    let directory = directory(name);
    let shader = lay_out("scene.frag", SHADER);
    let output = c(&[&shader], options);
    assert!(output.diagnostics.is_empty(), "{:?}", output.diagnostics);
    std::fs::write(directory.join("blocks.h"), output.text).expect("written");
    std::fs::write(directory.join("types.h"), TYPES).expect("written");
    let using = match options.namespace.as_str() {
        "" => String::new(),
        space => format!("using namespace {space};\n"),
    };
    let text = format!(
        "#include \"blocks.h\"\n#include <stdio.h>\n#include <string.h>\n{using}\
         static void dirty(void) {{ volatile unsigned char all[4096]; memset((void *)all, 255, 4096); }}\n\
         static void print(void) {{\n    Scene scene = {value};\n    \
         unsigned char bytes[sizeof scene];\n    memcpy(bytes, &scene, sizeof scene);\n    \
         fwrite(bytes, 1, sizeof bytes, stdout);\n}}\n\
         int main(void) {{ dirty(); print(); return 0; }}\n"
    );
    std::fs::write(directory.join("main.c"), text).expect("written");
    compile_and_run(compiler, &directory, "main.c")
}

/// Types of a program, in C and in C++.
const TYPES: &str = "\
#ifndef TYPES_H
#define TYPES_H
typedef struct Vec3 { float x, y, z; } Vec3;
typedef struct Color { float r, g, b; } Color;
typedef struct Mat4 { float m[4][4]; } Mat4;
typedef struct Wide { float x, y, z, w; } Wide;
#endif
";

const VIEW: &str = "{ 1, 2, 3, 4 }, { 5, 6, 7, 8 }, { 9, 10, 11, 12 }, { 13, 14, 15, 16 }";

#[test]
fn designated_initialisers_make_zero_padded_values() {
    let arrays = format!(
        "{{ .view = {{ {VIEW} }}, .exposure = 17,
        .lights = {{ {{ .radius = 0 }}, {{ .position = {{ 18, 19, 20 }}, .color = {{ 21, 22, 23 }} }} }},
        .ways = {{ {{ .value = {{ 24, 25, 26 }} }} }} }}"
    );
    let glm = arrays
        .replace(&format!("{{ {VIEW} }}"), &format!("glm::mat4({})", VIEW.replace(['{', '}'], "")));
    let own = arrays.replace(&format!("{{ {VIEW} }}"), &format!("{{ {{ {VIEW} }} }}"));
    let of_glm = options(|options| {
        options.vectors = CVectors::Glm;
        options.namespace = "engine::gpu".to_string();
    });
    let of_program = options(|options| {
        let types = [("vec3", "Vec3"), ("Light.color", "Color"), ("mat4", "Mat4")];
        options.types = types.map(|(of, name)| (of.to_string(), name.to_string())).to_vec();
        options.includes = vec!["types.h".to_string()];
    });
    let expected = expected();
    for (name, compiler, options, value) in [
        ("init_c", Compiler::C11, options(|_| ()), &arrays),
        ("init_cpp", Compiler::Cpp20, options(|_| ()), &arrays),
        ("init_glm", Compiler::Cpp20, of_glm, &glm),
        ("init_own_c", Compiler::C11, of_program.clone(), &own),
        ("init_own_cpp", Compiler::Cpp20, of_program, &own),
    ] {
        assert_eq!(initialised(name, compiler, &options, value), expected, "{name}");
    }
}

/// A type of another size or alignment stops the compiler, also at a tail without a head.
#[test]
fn a_type_that_does_not_fit_does_not_compile() {
    let directory = directory("unfit");
    let shader = lay_out("scene.frag", SHADER);
    let text = "#include \"blocks.h\"\nint main(void) { return 0; }\n";
    std::fs::write(directory.join("main.c"), text).expect("written");
    std::fs::write(directory.join("types.h"), TYPES).expect("written");
    for (of, name, told) in [
        (
            "Light.color",
            "Wide",
            "`Wide` has 12 bytes in the shader, aligned to 16 at most at byte 16",
        ),
        (
            "Points.all",
            "Wide",
            "`Wide` has 12 bytes in the shader, aligned to 16 at most at byte 0",
        ),
        ("mat4", "Vec3", "`Vec3` has 64 bytes in the shader"),
    ] {
        let options = options(|options| {
            options.types = vec![(of.to_string(), name.to_string())];
            options.includes = vec!["types.h".to_string()];
        });
        let output = c(&[&shader], &options);
        std::fs::write(directory.join("blocks.h"), output.text).expect("written");
        for compiler in [Compiler::C11, Compiler::Cpp17] {
            let log = compile(compiler, &directory, "main.c").expect_err("of another size");
            assert!(log.contains(told), "{compiler:?} {of}: {log}");
        }
    }
}

/// Two headers have one name for different structures, each in its namespace.
#[test]
fn namespaces_keep_equal_names_apart() {
    let directory = directory("namespaces");
    for (space, member) in [("first", "float a;"), ("second::inner", "vec4 b; float c;")] {
        let text = format!(
            "#version 450\nstruct S {{ {member} }};\nlayout(std430) buffer B_{} {{ S all[]; }};\n\
             void main() {{}}\n",
            &space[..1]
        );
        let file = format!("{}.h", &space[..1]);
        let options = options(|options| {
            options.namespace = space.to_string();
            options.file = file.clone();
        });
        std::fs::write(directory.join(file), c(&[&lay_out("a.frag", &text)], &options).text)
            .expect("written");
    }
    let text = "#include \"f.h\"\n#include \"s.h\"\n\
        static_assert(sizeof(first::S) == 4 && sizeof(second::inner::S) == 32, \"\");\n\
        int main(void) {\n    unsigned char bytes[64] = {};\n    \
        second::inner::b_s_all(bytes)[1].c = 1;\n    first::b_f_all(bytes)[0].a = 1;\n    \
        return second::inner::b_s_lookup(\"all[1].c\", NULL) == 48 ? 0 : 1;\n}\n";
    std::fs::write(directory.join("main.c"), text).expect("written");
    assert_eq!(compile_and_run(Compiler::Cpp17, &directory, "main.c"), b"");
}

#[test]
fn names_that_are_none_are_errors() {
    let shader = lay_out("scene.frag", SHADER);
    let options = options(|options| {
        options.namespace = "a::1".to_string();
        options.includes = vec!["a\"b".to_string(), "<ok.h>".to_string()];
        options.types =
            vec![("vec3".to_string(), "Vec3;".to_string()), ("vec9".to_string(), "V".to_string())];
    });
    let messages: Vec<String> =
        c(&[&shader], &options).diagnostics.into_iter().map(|found| found.message).collect();
    snapbox::assert_data_eq!(
        messages.join("\n"),
        str![[r#"
`vec3` cannot have the type `Vec3;`: it is no type in C or C++
`a::1` is no namespace in C++
`a"b` cannot be included
the type for `vec9` has no effect: no member is one
"#]]
    );
}
