//! Fragment shaders over fragments whose inputs are given, on the evaluator and both drivers.

use snapbox::str;

use crate::support::command::golden;
use crate::support::sample::sampled;
use std::time::Duration;

use landfall_exec::backend::gl::Gl;
use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_exec::backend::{Backend, Device, Failure, Job, JobOutput};
use landfall_exec::harness::fragments::{Batch, FragmentShader, Image, Inputs, Shaded};
use landfall_interp::{Cpu, Settings};
use landfall_layout::buffer::{Buffer, decode};
use landfall_layout::{Options, Source};

const LIMIT: Duration = Duration::from_secs(120);

fn backends() -> Vec<Box<dyn Backend>> {
    let gl = Gl::open().unwrap_or_else(|failure| panic!("{failure}"));
    let gpu = Gpu::open(&AdapterChoice::default()).unwrap_or_else(|failure| panic!("{failure}"));
    vec![Box::new(Cpu::default()), Box::new(gl), Box::new(gpu)]
}

fn shader(path: &str, text: &str) -> FragmentShader {
    FragmentShader::new(&Source::new(path, text), &Options::default(), None)
        .unwrap_or_else(|found| panic!("{path}: {found:?}"))
}

/// Words that are neither special nor close to each other.
fn values(count: usize, seed: u64) -> Vec<[f32; 4]> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut value =
        || f32::from_bits(random.u32(0x3800_0000..0x4780_0000)) * (random.f32() - 0.5).signum();
    (0..count).map(|_| [value(), value(), value(), value()]).collect()
}

fn run(
    backend: &mut dyn Backend,
    shader: &FragmentShader,
    blocks: &[Vec<u8>],
    inputs: &dyn Inputs,
) -> Shaded {
    let count = inputs.counts().first().copied().unwrap_or(0);
    let texel = Image { width: 1, height: 1, texels: vec![[0.5, 0.25, 0.75, 1.0]] };
    let textures = vec![texel; shader.textures().count()];
    let batch = Batch { blocks, textures: &textures, inputs, count, limit: LIMIT };
    let name = backend.device().backend.name();
    shader.run(backend, &batch, |_, _| {}).unwrap_or_else(|f| panic!("{name}: {f}"))
}

/// Texts that give back their inputs: two vectors and a number.
fn echoes() -> Vec<(&'static str, String)> {
    let body = "p + vec3(q, 0.0), k";
    let old = |line: &str, precision: &str| {
        format!(
            "{line}\nvarying {precision}vec3 p; varying {precision}vec2 q;\n\
             varying {precision}float k;\nvoid main() {{ gl_FragColor = vec4({body}); }}\n"
        )
    };
    let new = |line: &str, precision: &str| {
        format!(
            "{line}\nin {precision}vec3 p; in {precision}vec2 q; flat in {precision}float k;\n\
             out {precision}vec4 color;\nvoid main() {{ color = vec4({body}); }}\n"
        )
    };
    let mut texts = vec![
        ("none.frag", old("", "")),
        ("precise.frag", old("#ifdef GL_ES\nprecision mediump float;\n#endif", "highp ")),
        ("110.frag", old("#version 110", "")),
        ("120.frag", old("#version 120", "")),
        ("100es.frag", old("#version 100", "highp ")),
        ("300es.frag", new("#version 300 es", "highp ")),
        ("310es.frag", new("#version 310 es", "highp ")),
        ("320es.frag", new("#version 320 es", "highp ")),
    ];
    for version in [130, 140, 150, 330, 400, 410, 420, 430, 440, 450, 460] {
        let name: &'static str = Box::leak(format!("{version}.frag").into_boxed_str());
        texts.push((name, new(&format!("#version {version}"), "")));
    }
    let wgsl = "struct In { @builtin(position) at: vec4f, @location(2) p: vec3f,
            @location(0) q: vec2f, @location(5) @interpolate(flat) k: f32 }
        @fragment fn shade(in: In) -> @location(0) vec4f {
            return vec4f(in.p + vec3f(in.q, 0.0), in.k);
        }";
    texts.push(("echo.wgsl", wgsl.to_string()));
    texts
}

#[test]
fn inputs_arrive_bit_for_bit_in_every_version_on_every_reader() {
    let mut backends = backends();
    // More than a row and no multiple of it.
    for count in [1, 7, 64, 1000] {
        for (name, text) in echoes() {
            if count != 1000 && !name.contains("330") && !name.contains("wgsl") {
                continue;
            }
            let shader = shader(name, &text);
            let all = 0..shader.inputs().len() as u64;
            let inputs: Vec<_> = all.map(|seed| values(count, seed)).collect();
            let of = |name: &str| {
                let found = shader.inputs().iter().position(|input| input.name == name);
                &inputs[found.unwrap_or_else(|| panic!("no `{name}`"))]
            };
            let (p, q, k) = (of("p"), of("q"), of("k"));
            let expected: Vec<[f32; 4]> = (0..count)
                .map(|i| [p[i][0] + q[i][0], p[i][1] + q[i][1], p[i][2], k[i][0]])
                .collect();
            for backend in &mut backends {
                // Mesa 22.3 ends at GLSL 4.50.
                let other = name.ends_with("wgsl") || name.starts_with("460");
                if backend.device().backend.name() == "gl" && other {
                    continue;
                }
                let shaded = run(backend.as_mut(), &shader, &[], &inputs);
                let who = backend.device().backend.name();
                assert_eq!(shaded.colors, expected, "{name} on {who}, {count} fragments");
                assert!(shaded.discarded.is_empty());
            }
        }
    }
}

/// Coordinates at the borders of texels and next to them, where the product with the size is rounded.
fn borders(size: u32) -> Vec<[f32; 4]> {
    let mut all = Vec::new();
    for k in 0..=size {
        for whole in [0.0f32, 1.0, 7.0, -1.0, -3.0] {
            let mut at = (f64::from(k) / f64::from(size) + f64::from(whole)) as f32;
            at = at.next_down().next_down();
            for _ in 0..5 {
                // Drivers may flush subnormal numbers to zero.
                if !at.is_subnormal() {
                    all.push([at, 0.0, 0.0, 0.0]);
                }
                at = at.next_up();
            }
        }
    }
    all
}

#[test]
fn coordinates_at_the_borders_of_texels_select_those_of_the_drivers() {
    let text = "#version 330\nuniform sampler2D t; in float u; out vec4 c;\n\
        void main() { c = texture(t, vec2(u, 0.5)); }";
    let shader = shader("t.frag", text);
    let mut backends = backends();
    for size in [1, 2, 3, 7, 16, 20, 64, 100, 243, 1000] {
        let texels = (0..size).map(|i| [i as f32, 0.0, 0.0, 1.0]).collect();
        let textures = [Image { width: size, height: 1, texels }];
        let inputs = vec![borders(size)];
        let count = inputs[0].len();
        let of = |backend: &mut Box<dyn Backend>| {
            let batch =
                Batch { blocks: &[], textures: &textures, inputs: &inputs, count, limit: LIMIT };
            shader.run(backend.as_mut(), &batch, |_, _| {}).expect("it runs").colors
        };
        let [cpu, gl, gpu] = [0, 1, 2].map(|i| of(&mut backends[i]));
        for (i, at) in inputs[0].iter().enumerate() {
            assert_eq!([cpu[i][0]; 2], [gl[i][0], gpu[i][0]], "{:e} of {size} texels", at[0]);
        }
    }
}

#[test]
fn blocks_matrices_structures_and_integers_among_inputs_arrive() {
    let text = "#version 450
#define INPUT in
struct Lamp { vec3 color; float power; };
layout(location = 0) INPUT Stage { vec2 uv[2]; flat int id; } stage;
layout(location = 4) INPUT mat3 basis;
layout(location = 8) INPUT Bare { flat uvec2 pair; };
layout(location = 9) INPUT Lamp lamp;
vec3 second = basis[0], first = second * 2.0;
float side = stage.uv[1].y, number = float(pair.y);
layout(location = 0) out vec4 color;
void main() {
    color = vec4(side + float(stage.id), first.z + basis[2].x, number,
                 lamp.color.z * lamp.power);
}";
    let shader = shader("mixed.frag", text);
    let whole = |seed| -> Vec<[f32; 4]> {
        let mut random = fastrand::Rng::with_seed(seed);
        (0..300).map(|_| [0; 4].map(|_| random.u8(..) as f32)).collect()
    };
    let inputs: Vec<_> = (0..shader.inputs().len() as u64).map(whole).collect();
    let names: Vec<&str> = shader.inputs().iter().map(|input| input.name.as_str()).collect();
    let of = |name: &str| {
        &inputs[names.iter().position(|n| *n == name).unwrap_or_else(|| panic!("{names:?}"))]
    };
    let expected: Vec<[f32; 4]> = (0..300)
        .map(|i| {
            [
                of("Stage.uv[1]")[i][1] + of("Stage.id")[i][0],
                of("basis[0]")[i][2] * 2.0 + of("basis[2]")[i][0],
                of("Bare.pair")[i][1],
                of("lamp.color")[i][2] * of("lamp.power")[i][0],
            ]
        })
        .collect();
    for mut backend in backends() {
        let shaded = run(backend.as_mut(), &shader, &[], &inputs);
        assert_eq!(shaded.colors, expected, "{}", backend.device().backend.name());
    }
}

#[test]
fn discarded_fragments_are_marked() {
    let texts = [
        (
            "d.frag",
            "#version 330\nin float x; out vec4 c;\nvoid main() { if (x < 0.0) discard; c = vec4(0.0); }",
        ),
        (
            "d.wgsl",
            "@fragment fn main(@location(0) x: f32) -> @location(0) vec4f { if x < 0.0 { discard; } return vec4f(); }",
        ),
        (
            "d2.frag",
            "#version 110\nvarying float x;\nvoid main() { if (x < 0.0) discard; gl_FragColor = vec4(0.0); }",
        ),
    ];
    let inputs = vec![values(500, 3)];
    let expected: Vec<bool> = inputs[0].iter().map(|value| value[0] < 0.0).collect();
    assert!(expected.contains(&true) && expected.contains(&false));
    let mut backends = backends();
    for (name, text) in texts {
        let shader = shader(name, text);
        for backend in &mut backends {
            let who = backend.device().backend.name();
            if who == "gl" && name.ends_with("wgsl") {
                continue;
            }
            let shaded = run(backend.as_mut(), &shader, &[], &inputs);
            assert_eq!(shaded.discarded, expected, "{name} on {who}");
        }
    }
}

/// Writes its input to all channels; negative ones are discarded.
const DISCARDS: &str =
    "#version 330\nin float x; out vec4 c;\nvoid main() { if (x < 0.0) discard; c = vec4(x); }";

#[test]
fn fragments_of_several_jobs_are_in_their_order() {
    let shader = shader("d.frag", DISCARDS);
    let check = |backend: &mut dyn Backend, count: usize, who: &str| {
        let inputs = vec![values(count, 3)];
        let is_out = |value: &[f32; 4]| value[0] < 0.0;
        let shown = |value: &[f32; 4]| if is_out(value) { [0.0; 4] } else { [value[0]; 4] };
        let colors: Vec<[f32; 4]> = inputs[0].iter().map(shown).collect();
        let discarded: Vec<bool> = inputs[0].iter().map(is_out).collect();
        let batch = Batch { blocks: &[], textures: &[], inputs: &inputs, count, limit: LIMIT };
        let mut counted = 0;
        let shaded = shader.run(backend, &batch, |_, count| counted += count);
        let shaded = shaded.unwrap_or_else(|failure| panic!("{who}: {failure}"));
        assert_eq!(counted, count, "{who}");
        assert!(shaded.colors == colors && shaded.discarded == discarded, "{who}, {count}");
    };
    for threads in [1, 2, 3] {
        for count in [0, 65_536, 65_537, 81_920, 81_921, 150_001] {
            let mut cpu = Cpu::new(Settings { threads, ..Settings::default() });
            check(&mut cpu, count, &format!("{threads} threads"));
        }
    }
    for mut backend in backends() {
        let who = backend.device().backend.name();
        check(backend.as_mut(), 150_001, who);
    }
}

/// The interpreter, which fails at a job.
struct Failing {
    cpu: Cpu,
    /// The jobs before it.
    works: usize,
}

impl Backend for Failing {
    fn device(&self) -> &Device {
        self.cpu.device()
    }

    fn run(&mut self, job: &Job) -> Result<JobOutput, Failure> {
        // Each job runs once for the colours and once for what is discarded.
        let left = self.works.checked_sub(1).ok_or_else(|| Failure::refused("as planned", ""))?;
        self.works = left;
        self.cpu.run(job)
    }
}

#[test]
fn colours_of_jobs_before_a_failure_are_taken_once() {
    let shader = shader("d.frag", DISCARDS);
    let inputs = vec![values(150_001, 3)];
    let batch = Batch { blocks: &[], textures: &[], inputs: &inputs, count: 150_001, limit: LIMIT };
    // The colours of the second and of the third job fail, and what the second one discards.
    for (works, taken) in [(0, 0), (1, 0), (2, 16_384), (3, 16_384), (4, 81_920)] {
        let mut backend = Failing { cpu: Cpu::default(), works };
        let mut count = 0;
        let failed =
            shader.run_into(&mut backend, &batch, |colors, _| count += colors.len(), |_, _| {});
        assert_eq!(failed.map_err(|failure| failure.message), Err("as planned".to_string()));
        assert_eq!(count, taken, "{works}");
    }
}

#[test]
fn the_pixel_is_given_like_any_other_input() {
    let texts = [
        (
            "p.frag",
            "#version 450\nout vec4 c;\nvec4 at() { return gl_FragCoord; }\nvoid main() { c = at(); }",
        ),
        ("p1.frag", "#version 110\nvoid main() { gl_FragColor = gl_FragCoord; }"),
        (
            "p.wgsl",
            "@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f { return at; }",
        ),
    ];
    let inputs = vec![values(300, 9)];
    let mut backends = backends();
    for (name, text) in texts {
        let shader = shader(name, text);
        assert_eq!(shader.inputs()[0].location, None);
        for backend in &mut backends {
            let who = backend.device().backend.name();
            if who == "gl" && name.ends_with("wgsl") {
                continue;
            }
            let shaded = run(backend.as_mut(), &shader, &[], &inputs);
            assert_eq!(shaded.colors, inputs[0], "{name} on {who}");
        }
    }
}

#[test]
fn differences_between_pixels_are_refused() {
    let text =
        "#version 330\nin vec2 uv; out vec4 c;\nvoid main() { c = vec4(dFdx(uv), 0.0, 1.0); }";
    let source = Source::new("d.frag", text);
    let found = FragmentShader::new(&source, &Options::default(), None).expect_err("no neighbours");
    golden().eq(found[0].message.clone(), str!["the shader uses derivatives (`dFdx`, `fwidth`), but fragments are shaded one by one, without neighbours"]);
}

#[test]
fn the_evaluator_runs_no_pixel_too_many() {
    let mut cpu = Cpu::default();
    let shader =
        shader("a.frag", "#version 330\nin float x; out vec4 c;\nvoid main() { c = vec4(x); }");
    for count in [1, 63, 65, 300] {
        let inputs = vec![values(count, 5)];
        run(&mut cpu, &shader, &[], &inputs);
        let calls = cpu.notes.counts.calls.iter().map(|(_, n)| *n).max();
        assert_eq!(calls, Some(count as u64));
    }
}

/// Every float some number between a half and one, every integer two.
fn filled(shader: &FragmentShader) -> Vec<Vec<u8>> {
    let blocks = shader.blocks().iter().map(|block| {
        let zeros = Buffer::new(&block.layout).expect("it has a size").into_bytes();
        let mut bytes = zeros.clone();
        let mut next = 0u32;
        decode(&block.layout, &zeros).expect("they are its bytes").for_each(|element| {
            for (at, cell) in element.cells.iter().enumerate() {
                next += 1;
                let value = match cell.scalar.kind {
                    landfall_layout::shape::ScalarKind::Float => {
                        (0.5 + (next * 7 % 16) as f32 / 32.0).to_bits()
                    }
                    _ => 2,
                };
                let at = element.offset as usize + at * 4;
                bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            }
        });
        bytes
    });
    blocks.collect()
}

#[test]
fn the_readers_agree_on_our_lighting_shaders() {
    let mut backends = backends();
    for folder in ["six_lights", "light_arrays", "casters", "view_space"] {
        let folder = format!("{}/shaders/{folder}", env!("CARGO_MANIFEST_DIR"));
        let mut files: Vec<_> = std::fs::read_dir(&folder)
            .unwrap_or_else(|e| panic!("{folder}: {e}"))
            .map(|entry| entry.expect("a file").path())
            .filter(|path| path.extension().is_some_and(|e| e == "frag" || e == "wgsl"))
            .collect();
        files.sort();
        for path in sampled(&files, 4) {
            let source = Source::read(path).expect("it is there");
            let shader = shader(&source.path, &source.text);
            let blocks = filled(&shader);
            let unit = |seed| -> Vec<[f32; 4]> {
                let mut random = fastrand::Rng::with_seed(seed);
                (0..513).map(|_| [0; 4].map(|_| random.f32() - 0.5)).collect()
            };
            let inputs: Vec<_> = (0..shader.inputs().len() as u64).map(unit).collect();
            let mut first: Option<Shaded> = None;
            for backend in &mut backends {
                let who = backend.device().backend.name();
                if who == "gl" && source.path.ends_with("wgsl") {
                    continue;
                }
                let shaded = run(backend.as_mut(), &shader, &blocks, &inputs);
                let some = shaded.colors.iter().flatten().any(|c| *c != 0.0 && *c != 1.0);
                assert!(some, "{} is black on {who}", source.path);
                // What is `mediump` is half as wide on some drivers.
                let es = source.path.contains("es.frag");
                let tolerance = if es { 2e-2 } else { 2e-4 };
                let Some(first) = &first else {
                    first = Some(shaded);
                    continue;
                };
                for (one, two) in first.colors.iter().flatten().zip(shaded.colors.iter().flatten())
                {
                    let near = (one - two).abs() <= tolerance * one.abs().max(1.0);
                    assert!(near, "{} on {who}: {one} and {two}", source.path);
                }
            }
        }
    }
}
