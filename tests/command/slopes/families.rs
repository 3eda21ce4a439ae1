//! Inputs of any size, each of which repeats one construct.

/// Inputs that grow in one way.
pub struct Family {
    pub name: &'static str,
    /// The files of a size.
    pub files: fn(usize) -> Vec<(String, String)>,
    /// Further commands that read them.
    pub commands: &'static [&'static str],
}

const fn family(name: &'static str, files: fn(usize) -> Vec<(String, String)>) -> Family {
    Family { name, files, commands: &[] }
}

const fn with(
    name: &'static str,
    files: fn(usize) -> Vec<(String, String)>,
    commands: &'static [&'static str],
) -> Family {
    Family { name, files, commands }
}

fn repeated(count: usize, part: impl Fn(usize) -> String) -> String {
    (0..count).map(part).collect()
}

const BLOCK: &str = "layout(std140, binding = 0) uniform U { vec4 a; } u;\n";
const MAIN: &str = "layout(location = 0) out vec4 o;\nvoid main() { o = vec4(1.0); }\n";

/// A shader of declarations before its block.
fn glsl(before: &str) -> Vec<(String, String)> {
    one("a.frag", format!("#version 450\n{before}\n{BLOCK}{MAIN}"))
}

/// A shader whose `main` has these statements.
fn body(statements: &str) -> Vec<(String, String)> {
    let head = "layout(location = 0) out vec4 o;\nvoid main() {\n float x = u.a.x;\n";
    one("a.frag", format!("#version 450\n{BLOCK}{head}{statements}\n o = vec4(x);\n}}\n"))
}

/// A block with these members.
fn block(members: &str) -> Vec<(String, String)> {
    let block = format!("layout(std140, binding = 0) uniform U {{\n{members} vec4 last; }} u;\n");
    one("a.frag", format!("#version 450\n{block}{MAIN}"))
}

fn wgsl(before: &str) -> Vec<(String, String)> {
    let tail = "struct U { a: vec4f }\n@group(0) @binding(0) var<uniform> u: U;\n\
                @fragment fn main() -> @location(0) vec4f { return u.a; }\n";
    one("a.wgsl", format!("{before}\n{tail}"))
}

fn one(file: &str, text: String) -> Vec<(String, String)> {
    vec![(file.to_string(), text)]
}

pub const GLSL: &[Family] = &[
    with(
        "members",
        |n| block(&repeated(n, |i| format!("float m{i};\n"))),
        &["verify a.frag --backend cpu", "explain a.frag u.last"],
    ),
    family("members of one line", |n| block(&repeated(n, |i| format!("float m{i}; ")))),
    family("members with comments", |n| {
        block(&repeated(n, |i| format!("vec4 m{i}; // offset {}, 16 bytes\n", 16 * i)))
    }),
    family("members with offsets", |n| {
        block(&repeated(n, |i| format!("layout(offset = {}) vec4 m{i};\n", 16 * i)))
    }),
    family("members that are arrays of structures", |n| {
        let light = "struct Light { vec3 position; float range; vec3 color; float power; };\n";
        let members = repeated(n, |i| format!("Light lights{i}[4]; int count{i};\n"));
        let block = format!("{light}layout(std140, binding = 0) uniform U {{\n{members}}} u;\n");
        one("a.frag", format!("#version 450\n{block}{MAIN}"))
    }),
    family("blocks", |n| {
        glsl(&repeated(n, |i| {
            format!(
                "layout(std140, binding = {}) uniform B{i} {{ vec4 a; float b; }} b{i};\n",
                i + 1
            )
        }))
    }),
    with(
        "blocks on conditions",
        |n| {
            glsl(&repeated(n, |i| {
                format!("#ifdef A{i}\nlayout(std140) uniform B{i} {{ vec4 a; }};\n#endif\n")
            }))
        },
        &["lock a.frag --locks locks"],
    ),
    with(
        "findings",
        |n| {
            let block = |i| format!("layout(std140) uniform B{i} {{\n vec3 a[4]; }} b{i};\n");
            glsl(&repeated(n, block))
        },
        &["check a.frag -W all -f html", "check a.frag -W all --write-baseline"],
    ),
    family("loose uniforms", |n| {
        let uniforms = repeated(n, |i| format!("uniform vec4 m{i};\n"));
        one("a.frag", format!("#version 330\n{uniforms}out vec4 o;\nvoid main() {{ o = m0; }}\n"))
    }),
    family("structures", |n| {
        glsl(&repeated(n, |i| format!("struct S{i} {{ vec3 a; float b; }};\n")))
    }),
    family("structures in structures", |n| {
        let rest = repeated(n, |i| format!("struct S{} {{ S{i} a; float b; }};\n", i + 1));
        let tail = format!("layout(std140) uniform V {{ S{n} s; }} v;");
        glsl(&format!("struct S0 {{ float a; }};\n{rest}{tail}"))
    }),
    family("structures that double", |n| {
        let rest = repeated(n, |i| format!("struct S{} {{ S{i} a; S{i} b; }};\n", i + 1));
        glsl(&format!("struct S0 {{ float a; float b; }};\n{rest}"))
    }),
    family("dimensions of an array", |n| block(&format!("float a{};\n", "[1]".repeat(n)))),
    family("constants", |n| {
        let rest = repeated(n, |i| format!("const int C{} = C{i} + 1;\n", i + 1));
        glsl(&format!("const int C0 = 1;\n{rest}layout(std140) uniform V {{ float a[C{n}]; }} v;"))
    }),
    family("terms of an expression", |n| block(&format!("float a[1{}];\n", " + 1".repeat(n)))),
    family("parentheses", |n| block(&format!("float a[{}1{}];\n", "(".repeat(n), ")".repeat(n)))),
    family("conditional operators", |n| {
        block(&format!("float a[{}1];\n", "true ? 2 : ".repeat(n)))
    }),
    family("specialisation constants", |n| {
        let rest = repeated(n, |i| format!("const int C{} = C{i} + C{i};\n", i + 1));
        let first = "layout(constant_id = 0) const int C0 = 0;\n";
        glsl(&format!("{first}{rest}layout(std140) uniform V {{ float a[C{n} + 1]; }} v;"))
    }),
    family("parameters of a macro", |n| {
        let names = repeated(n, |i| format!("{}a{i}", if i == 0 { "" } else { ", " }));
        let body = repeated(n, |i| format!(" a{i}"));
        glsl(&format!("#define F({names}){body}\nF({})\n", ",".repeat(n - 1)))
    }),
    family("macros", |n| {
        let rest = repeated(n, |i| format!("#define M{} M{i}\n", i + 1));
        glsl(&format!("#define M0 4\n{rest}layout(std140) uniform V {{ float a[M{n}]; }} v;"))
    }),
    family("macros that are not used", |n| glsl(&repeated(n, |i| format!("#define M{i} {i}\n")))),
    family("calls of macros", |n| {
        glsl(&format!("#define F(x) x\n{}", repeated(n, |i| format!("F(const int C{i} = {i};)\n"))))
    }),
    family("arguments of a macro", |n| {
        let names = repeated(n, |i| format!("{}a{i}", if i == 0 { "" } else { ", " }));
        let given = repeated(n, |i| format!("{}{i}", if i == 0 { "" } else { ", " }));
        glsl(&format!("#define F({names}) a0\nconst int c = F({given});"))
    }),
    family("macros pasted", |n| {
        glsl(&format!(
            "#define P(x, y) x ## y\n{}",
            repeated(n, |i| { format!("const int P(c, {i}) = 1;\n") })
        ))
    }),
    family("conditions", |n| {
        glsl(&repeated(n, |i| format!("#ifdef A{i}\nuniform vec4 m{i};\n#else\n#endif\n")))
    }),
    family("conditions in conditions", |n| {
        glsl(&format!("{}{}", "#if 1\n".repeat(n), "#endif\n".repeat(n)))
    }),
    family("branches of a condition", |n| {
        glsl(&format!("#if 0\n{}#endif\n", repeated(n, |i| format!("#elif A{i}_ == 7{i}\n"))))
    }),
    family("comments", |n| glsl(&"/* x */ // y\n".repeat(n))),
    family("stars in a comment", |n| glsl(&format!("/*{}*/", "* /".repeat(n)))),
    family("line splices", |n| block(&"\\\n".repeat(n))),
    family("comments that allow", |n| glsl(&"// landfall: allow(vec3-array)\n".repeat(n))),
    family("precision statements", |n| glsl(&"precision highp float;\n".repeat(n))),
    family("extensions", |n| glsl(&"#extension GL_EXT_scalar_block_layout : enable\n".repeat(n))),
    family("lines given", |n| glsl(&repeated(n, |i| format!("#line {} 0\n", i + 1)))),
    family("qualifiers", |n| {
        let all = "binding = 0, ".repeat(n);
        one(
            "a.frag",
            format!("#version 450\nlayout({all}std140) uniform U {{ vec4 a; }} u;\n{MAIN}"),
        )
    }),
    family("semicolons", |n| glsl(&";".repeat(n))),
    family("a long name", |n| block(&format!("float {};\n", "n".repeat(n)))),
    family("functions", |n| {
        glsl(&repeated(n, |i| format!("float f{i}(float x) {{ return x * {i}.0; }}\n")))
    }),
    family("overloads", |n| {
        glsl(&repeated(n, |i| format!("float f(float x[{}]) {{ return x[0]; }}\n", i + 1)))
    }),
    family("functions that call the one before", |n| {
        let rest =
            repeated(n, |i| format!("float f{}(float x) {{ return f{i}(x) + 1.0; }}\n", i + 1));
        glsl(&format!("float f0(float x) {{ return x; }}\n{rest}"))
    }),
    family("statements", |n| body(&repeated(n, |i| format!("x = x * {i}.5 + u.a.y;\n")))),
    family("variables", |n| body(&repeated(n, |i| format!("float v{i} = x; x += v{i};\n")))),
    family("powers", |n| body(&repeated(n, |_| "x = pow(x, u.a.y) / length(u.a);\n".to_string()))),
    family("loops", |n| {
        body(&repeated(n, |i| format!("for (int i{i} = 0; i{i} < 4; i{i}++) {{ x += u.a.x; }}\n")))
    }),
    family("loops in loops", |n| {
        let open = repeated(n, |i| format!("for (int i{i} = 0; i{i} < 2; i{i}++) {{\n"));
        body(&format!("{open} x += 1.0; {}", "}".repeat(n)))
    }),
    family("branches", |n| body(&"if (x > 0.5) { x -= 0.25; } else { x += 0.25; }\n".repeat(n))),
    family("branches in branches", |n| {
        body(&format!("{} x = 1.0; {}", "if (x > 0.5) {".repeat(n), "}".repeat(n)))
    }),
    family("cases", |n| {
        body(&format!(
            "switch (int(x)) {{ {} }}",
            repeated(n, |i| { format!("case {i}: x += {i}.0; break;\n") })
        ))
    }),
    family("scopes", |n| body(&format!("{}x = 2.0;{}", "{".repeat(n), "}".repeat(n)))),
    family("terms in a body", |n| body(&format!("x = x{};\n", " + u.a.x".repeat(n)))),
    family("calls in calls", |n| body(&format!("x = {}x{};\n", "sin(".repeat(n), ")".repeat(n)))),
    family("elements of an initialiser", |n| {
        body(&format!("float t[] = float[]({}0.0); x = t[0];\n", "1.0, ".repeat(n)))
    }),
];

pub const WGSL: &[Family] = &[
    with(
        "members",
        |n| {
            wgsl(&format!(
                "struct S {{ {} }}\n@group(0) @binding(1) var<storage> s: S;",
                repeated(n, |i| { format!("m{i}: f32,\n") })
            ))
        },
        &["verify a.wgsl --backend cpu"],
    ),
    family("structures", |n| {
        wgsl(&repeated(n, |i| format!("struct S{i} {{ a: vec3f, b: f32 }}\n")))
    }),
    family("variables", |n| {
        wgsl(&repeated(n, |i| {
            format!("@group(1) @binding({i}) var<uniform> v{i}: array<vec4f, 4>;\n")
        }))
    }),
    family("structures in structures", |n| {
        let rest = repeated(n, |i| format!("struct S{} {{ a: S{i}, b: f32 }}\n", i + 1));
        wgsl(&format!("struct S0 {{ a: f32 }}\n{rest}@group(0) @binding(1) var<storage> s: S{n};"))
    }),
    family("constants", |n| {
        let rest = repeated(n, |i| format!("const C{} = C{i} + 1;\n", i + 1));
        wgsl(&format!(
            "const C0 = 1;\n{rest}@group(0) @binding(1) var<storage> s: array<f32, C{n}>;"
        ))
    }),
    family("constants backwards", |n| {
        let rest = repeated(n, |i| format!("const C{i} = C{} + 1;\n", i + 1));
        wgsl(&format!(
            "{rest}const C{n} = 1;\n@group(0) @binding(1) var<storage> s: array<f32, C0>;"
        ))
    }),
    family("aliases", |n| {
        let rest = repeated(n, |i| format!("alias A{} = A{i};\n", i + 1));
        wgsl(&format!("alias A0 = vec4f;\n{rest}@group(0) @binding(1) var<storage> s: A{n};"))
    }),
    family("comments in comments", |n| wgsl(&format!("{}{}", "/* ".repeat(n), "*/ ".repeat(n)))),
    family("arrays of arrays", |n| {
        let ty = format!("{}f32{}", "array<".repeat(n), ", 1>".repeat(n));
        wgsl(&format!("@group(0) @binding(1) var<storage> s: {ty};"))
    }),
    family("terms", |n| wgsl(&format!("const C = 1{};", " + 1".repeat(n)))),
    family("parentheses", |n| wgsl(&format!("const C = {}1{};", "(".repeat(n), ")".repeat(n)))),
    family("functions", |n| {
        wgsl(&repeated(n, |i| format!("fn f{i}(x: f32) -> f32 {{ return x * {i}.0; }}\n")))
    }),
    family("statements", |n| {
        wgsl(&format!(
            "fn f() -> f32 {{ var x = u.a.x;\n{} return x; }}",
            repeated(n, |i| { format!("x = x * {i}.5 + u.a.y;\n") })
        ))
    }),
    family("attributes", |n| {
        let members = repeated(n, |i| format!("@align(16) @size(16) m{i}: f32,\n"));
        wgsl(&format!("struct S {{ {members} }}"))
    }),
    family("overrides", |n| wgsl(&repeated(n, |i| format!("override o{i}: f32 = {i}.0;\n")))),
    family("semicolons", |n| wgsl(&";".repeat(n))),
];

/// A block of many members, with values for them.
fn values(n: usize) -> Vec<(String, String)> {
    let members = repeated(n, |i| format!("vec4 m{i};\n"));
    let values =
        repeated(n, |i| format!("{}\"m{i}\": [1, 2, 3, 4]", if i == 0 { "" } else { ", " }));
    let mut files = block(&members);
    files.push(("values.json".to_string(), format!("{{{values}}}")));
    files.push(("bytes.bin".to_string(), "\0".repeat(16 * n + 16)));
    files
}

/// A function of an array of lights.
fn lit(n: usize) -> Vec<(String, String)> {
    let text = format!(
        "#version 450\nstruct Light {{ vec3 position; float range; vec3 color; float power; }};\n\
         layout(std140, binding = 0) uniform Scene {{ Light lights[{n}]; }} scene;\n\
         vec3 lit(vec3 p) {{\n vec3 sum = vec3(0.0);\n for (int i = 0; i < {n}; i++) {{\n\
         vec3 to = scene.lights[i].position - p;\n\
         sum += scene.lights[i].color / (dot(to, to) * scene.lights[i].range);\n }}\n\
         return sum;\n}}\nvoid main() {{}}\n"
    );
    one("lit.frag", text)
}

/// A scene of many lights of small reach.
fn scene(n: usize) -> Vec<(String, String)> {
    let lights = repeated(n, |i| {
        let x = i as f64 * 0.01;
        format!(
            "{}{{\"position\": [{x}, 3, 3], \"color\": [9, 9, 9]}}",
            if i == 0 { "" } else { ", " }
        )
    });
    one(
        "scene.json",
        format!(
            "{{\"size\": [8, 8], \"camera\": {{\"position\": [0, 0, 4], \"target\": [0, 0, 0], \
             \"up\": [0, 1, 0], \"fov\": 60}}, \"lights\": {{\"point\": [{lights}]}}, \
             \"materials\": [{{\"name\": \"grey\", \"diffuse\": 0.8, \"specular\": 0.5, \
             \"shininess\": 32}}], \"objects\": [{{\"mesh\": \"plane\"}}]}}"
        ),
    )
}

/// A configuration of many rows.
fn configuration(n: usize) -> Vec<(String, String)> {
    let mut files = glsl("");
    let tables =
        repeated(n, |i| format!("[[table]]\nfile = \"b{i}/*.frag\"\nblock = \"U\"\nsize = 16\n"));
    files.push(("landfall.toml".to_string(), tables));
    files
}

/// Many shaders that declare one block, and Rust mirrors of it.
fn tree(n: usize) -> Vec<(String, String)> {
    let shader = |i| glsl("").pop().map(|(_, text)| (format!("tree/{i}.frag"), text));
    let mut files: Vec<(String, String)> = (0..n).filter_map(shader).collect();
    files.push(("landfall.toml".to_string(), String::new()));
    files
}

pub const INPUTS: &[Family] = &[
    with(
        "values",
        values,
        &[
            "encode a.frag values.json --out bytes",
            "decode a.frag bytes.bin",
            "decode a.frag bytes.bin -f json",
        ],
    ),
    with("configuration", configuration, &["check a.frag"]),
    with("tree", tree, &["layout tree", "check tree", "lock tree --locks locks", "diff tree tree"]),
    with(
        "lights of a function",
        lit,
        &[
            "run lit.frag --fn lit --args [[1,2,3]] --backend cpu",
            "prove lit.frag --fn lit --time 1",
        ],
    ),
    with(
        "lights of a scene",
        scene,
        &["render scene.json --reference --model multi --out picture.png"],
    ),
];
