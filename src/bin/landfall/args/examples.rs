//! The examples at the end of each command's `--help`.
//!
//! They work in a checkout of the repository, where the tests run them in order. A purpose that
//! ends in "(exit code 1)" states the exit code, which is 0 otherwise.

/// The purpose of an example, and its shell command. An empty purpose continues the last example.
pub type Example = (&'static str, &'static str);

/// The examples of each command, by its name.
pub const EXAMPLES: [(&str, &[Example]); 23] = [
    (
        "layout",
        &[
            ("All blocks below a directory", "landfall layout shaders"),
            (
                "One block, with every array element",
                "landfall layout shaders/light_arrays/lights.wgsl -b PointLightBlock --expand",
            ),
            ("One JSON file per shader", "landfall layout shaders --format json --out layout-json"),
        ],
    ),
    (
        "explain",
        &[
            (
                "Why the offset of a member is what it is",
                "landfall explain shaders/light_arrays/lights.wgsl 'data[3].color'",
            ),
            (
                "The member at byte 172 of a block",
                "landfall explain shaders/light_arrays/lights.wgsl @172 -b PointLightBlock",
            ),
        ],
    ),
    (
        "report",
        &[
            (
                "Memory maps and findings of all shaders of a directory in one page",
                "landfall report shaders/light_arrays --out report.html",
            ),
            (
                "The same for CI, which fails for findings",
                "landfall check shaders/light_arrays --format html=report.html",
            ),
        ],
    ),
    (
        "serve",
        &[
            (
                "The address of a page that follows a shader; Ctrl-C ends it",
                "landfall serve shaders/light_arrays/lights.wgsl",
            ),
            (
                "A scene with its lights as controls",
                "landfall serve shaders/scenes/six_lights.json",
            ),
        ],
    ),
    ("lsp", &[("What an editor runs, which then writes and reads", "landfall lsp")]),
    (
        "emit",
        &[
            (
                "Rust structures for bytemuck",
                "landfall emit shaders/light_arrays/lights.wgsl --lang rust --out lights.rs",
            ),
            (
                "Fail if the generated file is out of date",
                "landfall emit shaders/light_arrays/lights.wgsl -l rust -o lights.rs --check",
            ),
            (
                "A C header whose names start with lf_",
                "landfall emit shaders/light_arrays/lights.wgsl --lang c --prefix lf_",
            ),
        ],
    ),
    (
        "port",
        &[
            (
                "GLSL 330 to Vulkan GLSL",
                "landfall port shaders/seed/view_space_330.frag --out view_space.frag",
            ),
            ("GLSL 330 to WGSL", "landfall port shaders/seed/view_space_330.frag --to wgsl"),
        ],
    ),
    (
        "encode",
        &[
            (
                "Values from stdin as a hex dump",
                "echo '{\"gamma\": 2.2}' | landfall encode shaders/ideas/nested_struct.frag --hex",
            ),
            ("The bytes of the block in a file", "echo '{\"lamps[1].cutoff\": 9}' > lamps.json"),
            ("", "landfall encode shaders/ideas/nested_struct.frag lamps.json --out lamps.bin"),
        ],
    ),
    (
        "decode",
        &[
            (
                "Encode values, then print the bytes as a table",
                "echo '{\"gamma\": 2.2}' > lamps.json",
            ),
            ("", "landfall encode shaders/ideas/nested_struct.frag lamps.json --out lamps.bin"),
            ("", "landfall decode shaders/ideas/nested_struct.frag lamps.bin"),
            (
                "One array element",
                "landfall decode shaders/ideas/nested_struct.frag lamps.bin --only 'lamps[1]'",
            ),
        ],
    ),
    (
        "schema",
        &[
            ("The schema of `layout --format json`", "landfall schema layout"),
            ("The schema of scenes", "landfall schema scene > scene.schema.json"),
        ],
    ),
    (
        "lock",
        &[
            ("Write the locks of all shaders below layouts/", "landfall lock shaders"),
            ("Fail if a lock is out of date", "landfall lock shaders --check"),
        ],
    ),
    (
        "check",
        &[
            ("All shaders, with warnings as errors", "landfall check shaders -D warnings"),
            (
                "A report in the terminal and one for GitHub code scanning",
                "landfall check shaders -f human -f sarif=check.sarif",
            ),
            (
                "With a macro that changes a locked layout (exit code 1)",
                "landfall check shaders/ideas --define SHADOWS=2",
            ),
            ("The edits that --fix would make", "landfall check shaders --diff"),
            (
                "Permit what is found today; from then on, fail on everything new",
                "landfall check shaders -W all --baseline baseline.json --write-baseline",
            ),
            ("", "landfall check shaders -W all --baseline baseline.json"),
        ],
    ),
    ("init", &[("The configuration that would be written", "landfall init shaders --print")]),
    (
        "diff",
        &[
            (
                "Two shaders (exit code 1)",
                "landfall diff shaders/six_lights/phong.wgsl shaders/many_lights/plain.wgsl",
            ),
            ("A directory and its locks", "landfall diff layouts/shaders/seed shaders/seed"),
        ],
    ),
    (
        "rule",
        &[
            ("All lints and hazards, with their levels", "landfall rule"),
            ("The explanation of one, with an example and its fix", "landfall rule vec3-array"),
        ],
    ),
    (
        "verify",
        &[
            (
                "Every member of a shader, on the interpreter",
                "landfall verify shaders/light_arrays/lights.wgsl --backend cpu",
            ),
            (
                "Also the bytes that the shader never reads",
                "landfall verify shaders/seed/six_lights.wgsl --backend cpu --coverage",
            ),
        ],
    ),
    (
        "run",
        &[
            (
                "A vector argument",
                "landfall run shaders/include/lights.glsl --fn unit --args '[[0, 3, 4]]'",
            ),
            (
                "Floats rounded to f16",
                "landfall run shaders/six_lights/phong.wgsl --fn power --args '[0.5, 8]' --half",
            ),
        ],
    ),
    (
        "devices",
        &[
            ("A table of backends and adapters", "landfall devices"),
            ("The same as JSON", "landfall devices --format json"),
        ],
    ),
    (
        "lights",
        &[
            ("Light structures and hazards of all shaders", "landfall lights shaders"),
            ("Fail on likely hazards (exit code 1)", "landfall lights shaders --deny likely"),
        ],
    ),
    (
        "render",
        &[
            (
                "A picture of a scene",
                "landfall render shaders/scenes/six_lights.json --size 64x36 --out lights.png",
            ),
            (
                "The difference from the f64 reference",
                "landfall render shaders/scenes/six_lights.json --size 64x36 \\
      --compare reference",
            ),
        ],
    ),
    (
        "stress",
        &[
            (
                "All finite inputs",
                "landfall stress shaders/include/lights.glsl --fn unit --samples 10000",
            ),
            (
                "Vectors of at most 10, with a limit of 8 ULP",
                "landfall stress shaders/include/lights.glsl --fn unit --max-ulp 8 \\
      --domain '{\"v\": [-10, 10]}' --samples 10000",
            ),
        ],
    ),
    (
        "prove",
        &[(
            "No result is NaN where vectors are of length one",
            "landfall prove shaders/include/lights.glsl --fn unit --no-nan \\
      --domain '{\"v\": \"unit\"}'",
        )],
    ),
    (
        "bench",
        &[
            (
                "A scene on the interpreter",
                "landfall bench shaders/scenes/six_lights.json --backend cpu --rounds 3 \\
      --size 32x18",
            ),
            (
                "A function against itself with f16 floats",
                "landfall bench shaders/six_lights/phong.wgsl --fn power --variant half=:half \\
      --backend cpu --rounds 3",
            ),
        ],
    ),
];
