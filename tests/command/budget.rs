//! Ctrl-C and the budget of time and memory end every command, and leave nothing unfinished.
//!
//! Each command gets an input that takes it longer than the moment at which it is ended.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use snapbox::str;

use crate::support::command::golden;

/// A block of that many members.
fn block_of(members: usize) -> String {
    let members: String = (0..members).map(|n| format!("    vec4 m{n};\n")).collect();
    format!(
        "#version 450\nlayout(std140, binding = 0) uniform U {{\n{members}}} u;\n\
         layout(location = 0) out vec4 c;\nvoid main() {{ c = u.m0; }}\n"
    )
}

/// Functions that each call the one before twice: 2²⁶ calls of the first.
fn doubling() -> String {
    let functions: String = (1..=26)
        .map(|n| {
            let before = format!("f{}", n - 1);
            format!("float f{n}(float x) {{ return {before}(x) * 0.5 + {before}(x + 0.5); }}\n")
        })
        .collect();
    format!(
        "#version 450\nfloat f0(float x) {{ return x * 1.5; }}\n{functions}\
         layout(location = 0) out vec4 c;\nvoid main() {{ c = vec4(f26(1.0)); }}\n"
    )
}

/// A loop of as many turns as its input says.
const TURNS: &str = "#version 450
float turns(vec3 p, int count) {
    float sum = 0.0;
    for (int i = 0; i < count; i++) {
        sum += 1.0 / (dot(p, p) - float(i));
    }
    return sum / sqrt(p.x - p.y);
}
void main() {}
";

/// A function of an array of lights.
const LIGHTS: &str = "#version 450
struct Light { vec3 position; float range; vec3 direction; float cutoff; vec3 color; float power; };
layout(std140, binding = 0) uniform Scene { Light lights[64]; int count; } scene;
vec3 lit(vec3 p, vec3 n) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 64; i++) {
        Light light = scene.lights[i];
        vec3 to = light.position - p;
        float cone = dot(normalize(to), light.direction) - light.cutoff;
        float falloff = pow(cone, light.power) / (dot(to, to) * light.range);
        sum += light.color * falloff * max(dot(normalize(n), normalize(to)), 0.0);
    }
    return sum;
}
void main() {}
";

const SCENE: &str = r#"{
  "size": [640, 480],
  "camera": {"position": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 60},
  "lights": {"point": [{"position": [0, 3, 3], "color": [9, 9, 9]}]},
  "materials": [{"name": "grey", "diffuse": 0.8, "specular": 0.5, "shininess": 32}],
  "objects": [{"mesh": {"obj": "mesh.obj"}}]
}"#;

/// A folder with a tree of shaders, single large shaders, a scene and a temporary folder.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("budget").join(name);
    let _ = fs::remove_dir_all(&folder);
    for tree in ["tree", "other", "tmp"] {
        fs::create_dir_all(folder.join(tree)).unwrap();
    }
    let put = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    put("landfall.toml", "");
    let shader = block_of(400);
    for n in 0..300 {
        put(&format!("tree/{n}.frag"), &shader);
        put(&format!("other/{n}.frag"), &shader.replace("vec4 m7;", "float m7;"));
    }
    put("big.frag", &block_of(400_000));
    put("members.frag", &block_of(12_000));
    put("deep.frag", &doubling());
    put("turns.frag", TURNS);
    put("lights.frag", LIGHTS);
    let face = "f 1 2 3\n".repeat(400_000);
    put("mesh.obj", &format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{face}"));
    put("scene.json", SCENE);
    put("small.frag", "#version 330\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n");
    // Programs that do not end, and start another.
    let endless = "#!/bin/sh\nsleep 10000 &\necho $$ $! >> \"$TMPDIR/started\"\nwait\n";
    for name in ["git", "glslangValidator"] {
        put(name, endless);
        #[cfg(unix)]
        {
            let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
            fs::set_permissions(folder.join(name), mode).unwrap();
        }
    }
    folder
}

/// Nothing runs of the programs that a command started.
#[cfg(target_os = "linux")]
fn assert_nothing_runs(folder: &Path, of: &[&str]) {
    let list = folder.join("tmp/started");
    for process in fs::read_to_string(&list).unwrap_or_default().split_whitespace() {
        let stat = || fs::read_to_string(format!("/proc/{process}/stat"));
        let runs = || stat().is_ok_and(|stat| !stat.contains(") Z "));
        let asked = Instant::now();
        while runs() {
            assert!(asked.elapsed() < Duration::from_secs(60), "{of:?} leaves {process}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
    let _ = fs::remove_file(list);
}

/// The commands that read an input of any size, each with arguments that keep it busy.
fn commands() -> Vec<Vec<&'static str>> {
    [
        "layout tree",
        "layout tree --out layouts",
        "layout big.frag --format json",
        "explain big.frag @80000",
        "emit tree --lang c --out mirrors.h",
        "port big.frag --out ported.frag",
        "encode big.frag values.json --out bytes",
        "decode big.frag bytes.bin",
        "verify tree --backend cpu",
        "verify members.frag --backend cpu",
        "verify tree --backend gl",
        "verify tree --backend gpu",
        "run deep.frag --fn f26 --args [1] --backend cpu",
        "run deep.frag --fn f26 --args [1] --backend gl",
        "run deep.frag --fn f26 --args [1] --backend gpu",
        "stress deep.frag --fn f26",
        "stress turns.frag --fn turns --samples 100000000",
        "prove turns.frag --fn turns --time 30",
        "prove turns.frag --fn turns --max-ulp 0.1 --time 30",
        "prove lights.frag --fn lit --time 30",
        "prove lights.frag --fn lit --f64 --time 30",
        "bench deep.frag --fn f26",
        "render scene.json --reference --model multi --out picture.png",
        "lights tree",
        "lock tree",
        "diff tree other",
        "check tree",
        "check tree --fix",
        "check tree --against HEAD",
        "diff HEAD:tree tree",
        "port small.frag",
    ]
    .map(|line| line.split(' ').collect())
    .to_vec()
}

fn start(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
    command.current_dir(folder).args(arguments).env("TMPDIR", folder.join("tmp"));
    let path = std::env::var("PATH").unwrap_or_default();
    command.env("PATH", format!("{}:{path}", folder.display()));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("the binary was built for this test")
}

/// The state of a process by its letter and its processor time, while it is listed.
#[cfg(target_os = "linux")]
fn listed(process: u32) -> Option<(char, Duration)> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let fields: Vec<&str> = stat.rsplit(") ").next().unwrap_or_default().split(' ').collect();
    let ticks = |at: usize| fields[at].parse::<u64>().expect("a number of ticks");
    // Hundredths of a second.
    let time = Duration::from_millis(10 * (ticks(11) + ticks(12)));
    Some((fields[0].chars().next()?, time))
}

#[cfg(target_os = "linux")]
fn processor_time(process: u32) -> Option<Duration> {
    listed(process).map(|(_, time)| time)
}

/// Whether a process has ended and was not waited for, and its processor time.
#[cfg(target_os = "linux")]
fn state(process: u32) -> (bool, Duration) {
    let (letter, time) = listed(process).expect("it is listed");
    (letter == 'Z', time)
}

/// The output is read while the process runs, as it may fill the pipes.
fn output(child: Child) -> std::thread::JoinHandle<Output> {
    std::thread::spawn(|| child.wait_with_output().expect("it ends"))
}

fn assert_nothing_unfinished(folder: &Path, of: &[&str]) {
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).unwrap().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            assert!(!name.ends_with(".partial"), "{of:?} leaves {name}");
            assert!(!name.starts_with("landfall-diff-"), "{of:?} leaves {name}");
            if entry.file_type().unwrap().is_dir() {
                folders.push(entry.path());
            }
        }
    }
}

/// From the signal to the end, on a machine that may be busy: the shortest of up to five times.
#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_ends_every_command_within_half_a_second() {
    let folder = folder("interrupt");
    fs::write(folder.join("values.json"), "{}").unwrap();
    fs::write(folder.join("bytes.bin"), vec![0; 16 * 400_000]).unwrap();
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
    let most = Duration::from_millis(500) * threads;
    for arguments in commands() {
        let mut shortest = Duration::MAX;
        for _ in 0..5 {
            let child = start(&folder, &arguments);
            let process = child.id();
            let ended = output(child);
            let began = Instant::now();
            loop {
                // Its output is being waited for, so that it may be gone.
                let listed = Path::new(&format!("/proc/{process}/stat")).exists();
                assert!(listed && !ended.is_finished(), "{arguments:?} ends before the signal");
                // Drivers compute in a process of their own.
                let waits = began.elapsed() > Duration::from_secs(2);
                if waits || state(process).1 >= Duration::from_millis(100) {
                    break;
                }
                std::thread::sleep(Duration::from_millis(5));
            }
            // Processor time, as others use this machine too: of every thread half a second.
            let sent = state(process).1;
            let kill = Command::new("kill").args(["-INT", &process.to_string()]).status();
            assert!(kill.expect("kill runs").success());
            let mut last = sent;
            while !ended.is_finished() && began.elapsed() < Duration::from_secs(60) {
                last = processor_time(process).unwrap_or(last);
                std::thread::sleep(Duration::from_millis(2));
            }
            let output = ended.join().unwrap();
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(130), "{arguments:?}: {said}");
            assert_nothing_unfinished(&folder, &arguments);
            assert_nothing_runs(&folder, &arguments);
            shortest = shortest.min(last - sent);
            if shortest < most {
                break;
            }
        }
        assert!(shortest < most, "{arguments:?}: {shortest:?}");
    }
}

/// A lock of a shader that an interrupted run did not reach is not one without a shader.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_lock_removes_no_lock() {
    let folder = folder("prune");
    let whole = start(&folder, &["lock", "tree"]).wait_with_output().unwrap();
    assert!(whole.status.success(), "{}", String::from_utf8_lossy(&whole.stderr));
    let locks = || fs::read_dir(folder.join("layouts/tree")).unwrap().count();
    assert_eq!(locks(), 300);
    let child = start(&folder, &["lock", "tree", "--prune"]);
    let process = child.id();
    while state(process).1 < Duration::from_millis(50) {
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(Command::new("kill").args(["-INT", &process.to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), locks()), (Some(130), 300));
}

/// The findings of a shader before the one that takes long.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_check_prints_the_findings_so_far() {
    let folder = folder("findings");
    let array = "layout(std140, binding = 0) uniform U { vec3 a[4]; } u;";
    fs::write(folder.join("first.frag"), format!("#version 450\n{array}\nvoid main() {{}}\n"))
        .unwrap();
    let of = |arguments: &[&str], interrupt: bool| {
        let child = start(&folder, arguments);
        let process = child.id();
        if interrupt {
            while state(process).1 < Duration::from_millis(300) {
                std::thread::sleep(Duration::from_millis(5));
            }
            let kill = Command::new("kill").args(["-INT", &process.to_string()]).status();
            assert!(kill.unwrap().success());
        }
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), said)
    };
    let (_, alone, _) = of(&["check", "first.frag", "-f", "short", "-W", "all"], false);
    golden().eq(&alone, str![[r#"
first.frag:2:37: warning[unused-block] no function reads or writes block `U`, 64 bytes
first.frag:2:46: warning[vec3-array] elements of `a` are 16 bytes apart: packed `vec3`s are 12 apart, and only the first is read correctly

"#]]);
    let files = ["check", "first.frag", "big.frag", "-f", "short", "-W", "all"];
    let (code, found, said) = of(&files, true);
    assert_eq!((code, found), (Some(130), alone), "{said}");
    golden().eq(
        said,
        str![[r#"
checked 1 shader: 2 warnings
interrupted: these are the results so far, without the last file

"#]],
    );
    let (code, _, said) = of(&[&files[..], &["-q"]].concat(), true);
    assert_eq!((code, &*said), (Some(130), ""));
}

/// The error at the end of what a command said.
fn error(said: &str) -> &str {
    said.rfind("error[").map_or("", |at| &said[at..])
}

#[test]
fn every_command_ends_at_its_limit_of_time() {
    let folder = folder("time");
    fs::write(folder.join("values.json"), "{}").unwrap();
    fs::write(folder.join("bytes.bin"), vec![0; 16 * 400_000]).unwrap();
    let mut errors = BTreeSet::new();
    for arguments in commands() {
        let limited: Vec<&str> = [&arguments[..], &["--max-time", "0.05"]].concat();
        let output = output(start(&folder, &limited)).join().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        errors.insert(error(&said).to_string());
        assert_nothing_unfinished(&folder, &arguments);
        #[cfg(target_os = "linux")]
        assert_nothing_runs(&folder, &arguments);
    }
    golden().eq(
        errors.into_iter().collect::<String>(),
        str![[r#"
error[too-large]: `landfall` took longer than the limit of 0.05 s
  |
  = help: raise the limit with `--max-time SECONDS`


"#]],
    );
}

#[cfg(target_os = "linux")]
#[test]
fn every_command_ends_at_its_limit_of_memory() {
    let folder = folder("memory");
    fs::write(folder.join("values.json"), "{}").unwrap();
    fs::write(folder.join("bytes.bin"), vec![0; 16 * 400_000]).unwrap();
    let mut errors = BTreeSet::new();
    for arguments in commands() {
        let limited: Vec<&str> = [&arguments[..], &["--max-memory", "4"]].concat();
        let output = output(start(&folder, &limited)).join().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        errors.insert(error(&said).to_string());
        assert_nothing_runs(&folder, &arguments);
    }
    golden().eq(
        errors.into_iter().collect::<String>(),
        str![[r#"
error[too-large]: `landfall` needs more than the limit of 4 MiB
  |
  = help: raise the limit with `--max-memory MIB`, or use fewer files


"#]],
    );
}

#[test]
fn every_command_states_its_budget() {
    let help = |arguments: &[&str]| {
        let output = start(Path::new("."), arguments).wait_with_output().unwrap();
        assert!(output.status.success(), "{arguments:?}");
        String::from_utf8(output.stdout).expect("help is UTF-8")
    };
    let all = help(&["--help"]);
    let lines = all.lines().filter_map(|line| line.strip_prefix("  "));
    let known = "layout explain emit port encode decode schema lock check diff rule verify \
                 run devices lights render stress bench";
    let known: Vec<&str> = known.split(' ').collect();
    let listed =
        lines.filter_map(|line| line.split(' ').next().filter(|name| known.contains(name)));
    assert_eq!(listed.count(), known.len(), "{all}");
    for name in known {
        let text = help(&[name, "--help"]);
        for option in ["--max-time <SECONDS>", "--max-memory <MIB>"] {
            assert!(text.contains(option), "{name}: {text}");
        }
        for limit in ["default: 3600", "default: 8192"] {
            assert!(text.contains(limit), "{name}: {text}");
        }
    }
}

#[test]
fn one_evaluation_of_many_calls_ends_at_the_limit() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("budget").join("calls");
    fs::create_dir_all(folder.join("tmp")).unwrap();
    fs::write(folder.join("deep.frag"), doubling()).unwrap();
    for (line, expected) in [
        (
            "run deep.frag --fn f26 --args [1] --backend cpu --limit 1",
            str![[r#"
error[cannot-run]: cpu: the code was still running at the time limit: in `f[..]`, deep.frag:[..]


"#]],
        ),
        (
            "stress deep.frag --fn f26 --time 1",
            str![[r#"
error[cannot-run]: no sample ended within the time limit of 1 s
 --> --time
  |
  = help: raise the limit, or call the function with fewer calls and iterations


"#]],
        ),
    ] {
        let began = Instant::now();
        let arguments: Vec<&str> = line.split(' ').collect();
        let output = start(&folder, &arguments).wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{line}: {said}");
        golden().eq(error(&said), expected);
        // Without the limit they take more than 40 s of processor time.
        assert!(began.elapsed() < Duration::from_secs(20), "{line}: {:?}", began.elapsed());
    }
}

/// Eight times the members take less than 8 · log₂ 8 times the processor time, start included; a
/// quadratic loop takes up to 64.
#[cfg(target_os = "linux")]
#[test]
fn verification_of_many_members_takes_linear_time() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("budget").join("members");
    fs::create_dir_all(folder.join("tmp")).unwrap();
    fs::write(folder.join("landfall.toml"), "").unwrap();
    let seconds = |members: usize| {
        fs::write(folder.join("a.frag"), block_of(members)).unwrap();
        let mut child = start(&folder, &["verify", "a.frag", "--backend", "cpu"]);
        let process = child.id();
        let took = loop {
            // Times can be read until the process is waited for.
            match state(process) {
                (true, took) => break took,
                (false, _) => std::thread::sleep(Duration::from_millis(5)),
            }
        };
        assert!(child.wait().unwrap().success());
        took.as_secs_f64()
    };
    let (mut few, mut many) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..4 {
        few = few.min(seconds(1_500));
        many = many.min(seconds(12_000));
        if many < 24.0 * few {
            return;
        }
    }
    panic!("{few} s, and {many} s for eight times as many members");
}

/// 3 million triangles would fill more memory than a runner has.
#[test]
fn a_mesh_of_too_many_triangles_is_refused_with_its_limit() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("budget").join("mesh");
    fs::create_dir_all(folder.join("tmp")).unwrap();
    let faces = "f 1 2 3\n".repeat(3_000_000);
    fs::write(folder.join("mesh.obj"), format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}")).unwrap();
    fs::write(folder.join("scene.json"), SCENE).unwrap();
    let arguments = ["render", "scene.json", "--reference", "--model", "multi", "--out", "a.png"];
    let limit = ["--max-memory", "512"];
    let output = start(&folder, &[&arguments[..], &limit].concat()).wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    golden().eq(
        said,
        str![[r#"
error[wrong-mesh]: exceeds the limit of 1048576 triangles in a mesh
       --> mesh.obj:1048580:1
        |
1048580 | f 1 2 3
        | ^


"#]],
    );
    assert!(!folder.join("a.png").exists());
}
