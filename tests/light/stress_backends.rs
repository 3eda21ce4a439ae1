//! Functions stressed on drivers: each sample runs there too, and what a driver does otherwise
//! than the evaluator is said, counted and can be repeated.
//!
//! Needs drivers (Debian packages `mesa-vulkan-drivers`, `libvulkan1`, `libegl1` and
//! `libgl1-mesa-dri`); a missing one fails.

use crate::support::backends;
use crate::support::command::golden;
use crate::support::command::{self, Place, Ran};
use crate::support::schema;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use backends::with_readers;
use landfall_accuracy::stress::{BackendReport, Report, Request, Verdict, stress};
use landfall_exec::backend::{Backend, BackendKind, Device, Failure, Job, JobOutput};
use landfall_exec::harness::call::pure::PureRequest;
use landfall_interp::Cpu;
use landfall_layout::finding::Level;
use landfall_layout::{Options, Source};
use snapbox::str;

fn request(function: &str, domain: &str) -> Request {
    Request {
        pure: PureRequest { function: function.to_string(), ..PureRequest::default() },
        domain: Some(serde_json::from_str(domain).expect("the test's domain is JSON")),
        samples: 20_000,
        time: Some(Duration::from_secs(20)),
        ..Request::default()
    }
}

fn on(source: &Source, request: &Request, backends: &mut [Box<dyn Backend>]) -> Report {
    let report = stress(source, &Options::default(), request, backends, &|_| ());
    report.unwrap_or_else(|refusal| panic!("{:?}", refusal.found))
}

/// The report of a function of one line on both drivers.
fn line(text: &str, domain: &str) -> Report {
    let text = format!("#version 450\n{text}\nvoid main() {{}}\n");
    let source = Source::new("line.frag", text);
    with_readers(|backends| on(&source, &request("f", domain), backends))
}

/// Both drivers, each of which ran all that the evaluator ran.
fn both(report: &Report) -> &[BackendReport] {
    let names: Vec<&str> = report.backends.iter().map(|backend| backend.backend.name()).collect();
    assert_eq!(names, ["gl", "gpu"]);
    for backend in &report.backends {
        assert_eq!(backend.failure, None, "{}", backend.backend);
        assert!(report.total.samples >= 20_000, "{}", report.total.samples);
        assert_eq!(backend.tally.samples, report.total.samples, "{}", backend.backend);
    }
    &report.backends
}

#[test]
fn a_half_is_exact_on_every_driver() {
    let report = line("float f(float x) { return x * 0.5; }", r#"{"x": [1e-30, 1e30]}"#);
    for backend in both(&report) {
        // A power of two times a number loses nothing.
        assert_eq!(backend.tally.ulp.max, 0.0, "{}", backend.backend);
        assert_eq!(backend.tally.ulp.count, report.total.samples, "{}", backend.backend);
    }
    assert!(report.findings.is_empty(), "{}", report.findings[0].message());
}

#[test]
fn a_mean_of_colours_is_off_by_next_to_nothing() {
    let text = "vec3 f(vec3 a, vec3 b) { return 0.25 * a + 0.75 * b; }";
    let report = line(text, r#"{"a": [0.1, 1], "b": [0.1, 1]}"#);
    for backend in both(&report) {
        // Two roundings of products below 3/4 and one of a sum below 1, each at most 2^-25, the
        // last 2^-25 too: below 255 * 2^-23 steps.
        let most = backend.tally.steps.max;
        assert!(most > 0.0 && most <= 255.0 * f64::powi(2.0, -23), "{} {most}", backend.backend);
        assert_eq!(backend.apart.count, 0, "{}", backend.backend);
    }
}

#[test]
fn a_power_by_logarithm_is_farther_off_than_the_evaluators() {
    // exp2(32 * log2(x)): the product, from -32 to 0, is rounded by up to 2^-20, and a 2^-20th of
    // log 2 is 5.5 to 11 units of the last place of the power.
    let report = line("float f(float x) { return pow(x, 32.0); }", r#"{"x": [0.5, 0.99999]}"#);
    assert!(report.total.ulp.max <= 0.51, "{}", report.total.ulp.max);
    for backend in both(&report) {
        let most = backend.tally.ulp.max;
        assert!(most > 4.0, "{}: {most} ULP", backend.backend);
        let worst = &backend.worst[0];
        assert_eq!(worst.off().map(|off| off.ulp), Some(most), "{}", backend.backend);
        // Vulkan and GLSL derive `pow` from exp2 and log2, whose bounds are wider than that.
        assert_eq!(worst.verdict, Some(Verdict::Permitted), "{}", backend.backend);
    }
}

#[test]
fn a_normalised_zero_is_told_of_whether_the_driver_hides_it_or_not() {
    let report = line("vec3 f(vec3 v) { return normalize(v); }", r#"{"v": [-8, 8]}"#);
    let zero =
        report.findings.iter().find(|f| f.hazard.code() == "zero-vector").expect("it is met");
    for (nth, backend) in both(&report).iter().enumerate() {
        let (nan, hidden) = (backend.tally.nan, backend.hidden.count);
        assert!(nan + hidden > 0, "{}: {nan} NaN, {hidden} hidden", backend.backend);
        assert!(nan + hidden >= report.total.nan, "{}", backend.backend);
        let asked = &zero.backends[nth];
        assert_eq!((asked.backend, asked.results.len()), (backend.backend, 3));
        // A driver divides by the length or multiplies by its inverse: all are NaN, or none is.
        let finite = asked.results.iter().all(|x| x.is_finite());
        assert!(finite || asked.results.iter().all(|x| x.is_nan()), "{}", backend.backend);
        assert!(finite || nan > 0, "{}: {:?} and no NaN", backend.backend, asked.results);
    }
}

#[test]
fn a_seed_shader_with_inputs_and_blocks_runs_on_whoever_takes_it() {
    let read = |path: &str| {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        Source::read(&file).expect("the shader is there")
    };
    let glsl = read("shaders/seed/caster_spot_soft_330.frag");
    let report = with_readers(|backends| on(&glsl, &request("main", "{}"), backends));
    let paths: Vec<&str> = report.inputs.iter().map(|(input, _)| input.path.as_str()).collect();
    assert!(paths.contains(&"FragPos") && paths.contains(&"light.cutOff"), "{paths:?}");
    both(&report);
    let wgsl = read("shaders/seed/caster_spot_soft.wgsl");
    let report = with_readers(|backends| on(&wgsl, &request("fragment_main", "{}"), backends));
    let [gl, gpu] = &report.backends[..] else { panic!("both were asked") };
    assert_eq!(gl.failure.as_deref(), Some("OpenGL does not accept WGSL"));
    assert!(!gl.ran());
    assert_eq!((gpu.failure.as_deref(), gpu.tally.samples), (None, report.total.samples));
}

#[test]
fn the_robust_spot_light_has_no_finding_on_any_driver_in_its_domain() {
    let domain = r#"{
        "light.position": "position", "light.direction": "unit",
        "light.ambient": "color", "light.diffuse": "color", "light.specular": "color",
        "light.constant": [1, 2], "light.linear": [0, 1], "light.quadratic": [0, 2],
        "normal": "unit", "viewDir": "unit", "fragPos": "position",
        "light.cutOff": "cos", "light.outerCutOff": "cos", "material.shininess": [1, 256],
        "no_coincidence": [["light.cutOff", "light.outerCutOff", 1e-3]]
    }"#;
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/six_lights/phong_330.frag");
    let source = Source::read(&file).expect("the shader is there");
    let report = with_readers(|backends| on(&source, &request("CalcSpotLight", domain), backends));
    let all: Vec<String> = report.findings.iter().map(|found| found.message()).collect();
    assert!(all.is_empty(), "{all:?}");
    for backend in both(&report) {
        assert_eq!(backend.tally.nan + backend.tally.infinite, 0, "{}", backend.backend);
        // Half a step is what a finding begins at.
        assert!(backend.tally.steps.max < 0.5, "{} {}", backend.backend, backend.tally.steps.max);
    }
}

/// What a bad driver does.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    /// Adds a quarter to results of certain bits.
    Adds,
    /// Gives NaN for them.
    Nan,
    /// Dies after so many jobs.
    Dies(usize),
    /// Takes so long for each job, and no longer than it may.
    Slow(Duration),
}

/// Milliseconds that jobs of [`Fault::Slow`] took by their own account, however busy the machine.
static SLOW: AtomicU64 = AtomicU64::new(0);

/// A driver that is the evaluator but for its fault.
struct Faulty {
    fault: Fault,
    jobs: usize,
    cpu: Cpu,
    device: Device,
}

fn faulty(fault: Fault) -> Box<dyn Backend> {
    let cpu = Cpu::default();
    let device = Device {
        backend: BackendKind::Gpu,
        adapter: "bad luck".to_string(),
        ..cpu.device().clone()
    };
    Box::new(Faulty { fault, jobs: 0, cpu, device })
}

impl Backend for Faulty {
    fn device(&self) -> &Device {
        &self.device
    }

    fn run(&mut self, job: &Job) -> Result<JobOutput, Failure> {
        self.jobs += 1;
        if matches!(self.fault, Fault::Dies(jobs) if self.jobs > jobs) {
            return Err(Failure::died("the device is lost", ""));
        }
        if let Fault::Slow(time) = self.fault {
            let taken = time.min(job.limit);
            SLOW.fetch_add(taken.as_millis() as u64, Ordering::Relaxed);
            std::thread::sleep(taken);
            if time > job.limit {
                return Err(Failure::timed_out(job.limit));
            }
        }
        let mut answer = self.cpu.run(job)?;
        for bytes in answer.buffers.iter_mut().flatten() {
            // The result of a lane, and the word that says it came back.
            for lane in bytes.chunks_exact_mut(8) {
                let x = f32::from_le_bytes([lane[0], lane[1], lane[2], lane[3]]);
                let wrong = match self.fault {
                    _ if x.to_bits() % 64 != 5 => x,
                    Fault::Adds => x + 0.25,
                    Fault::Nan => f32::NAN,
                    Fault::Dies(_) | Fault::Slow(_) => x,
                };
                lane[..4].copy_from_slice(&wrong.to_le_bytes());
            }
        }
        Ok(answer)
    }
}

fn half() -> Source {
    Source::new("half.frag", "#version 450\nfloat f(float x) { return x * 0.5; }\nvoid main() {}\n")
}

#[test]
fn an_adapter_that_is_wrong_is_told_from_a_formula_that_is() {
    for (fault, code) in [(Fault::Adds, "driver-apart"), (Fault::Nan, "driver-not-finite")] {
        let mut backends = [faulty(fault)];
        let report = on(&half(), &request("f", r#"{"x": [1, 2]}"#), &mut backends);
        let [backend] = &report.backends[..] else { panic!("one was asked") };
        let odd = if fault == Fault::Nan { &backend.not_finite } else { &backend.apart };
        // One in 64 by chance, fewer where inputs are round, more where climbs lead there.
        let share = odd.count as f64 / report.total.samples as f64;
        assert!((0.001..=0.2).contains(&share), "{share}");
        assert_eq!(odd.cases[0].verdict, Some(Verdict::Wrong));
        let [found] = &report.findings[..] else { panic!("{}", report.findings.len()) };
        assert_eq!((found.hazard.code(), found.level), (code, Level::Deny));
        assert!(found.message().starts_with("gpu "), "{}", found.message());
        assert_eq!(report.has_non_finite(), fault == Fault::Nan);
        // What the evaluator gives is at most 1, a quarter of that is 63.75 steps.
        let steps = if fault == Fault::Adds { 255.0 * 0.25 } else { 0.0 };
        assert!((report.max_steps() - steps).abs() < 1e-9, "{}", report.max_steps());
    }
}

#[test]
fn a_driver_that_dies_is_left_out_and_the_others_go_on() {
    let mut backends = [faulty(Fault::Dies(3)), faulty(Fault::Dies(usize::MAX))];
    let report = on(&half(), &request("f", r#"{"x": [1, 2]}"#), &mut backends);
    let [dead, alive] = &report.backends[..] else { panic!("two were asked") };
    let why = dead.failure.as_deref().expect("it died");
    golden().eq(why, str!["after [..] samples: the device is lost"]);
    assert!(dead.ran() && dead.tally.samples < report.total.samples);
    assert_eq!((alive.failure.as_deref(), alive.tally.samples), (None, report.total.samples));
}

#[test]
fn who_says_stop_gets_what_there_is() {
    let mut request = request("f", r#"{"x": [1, 2]}"#);
    request.samples = 10_000_000;
    let progress = |samples: u64| {
        if samples >= 5_000 {
            request.stop.store(true, Ordering::Relaxed);
        }
    };
    let mut backends = [faulty(Fault::Dies(usize::MAX))];
    let options = Options::default();
    let report = stress(&half(), &options, &request, &mut backends, &progress).expect("it runs");
    assert!(report.stopped && report.total.samples < 100_000, "{}", report.total.samples);
    // What was still to be run there is left out.
    let there = report.backends[0].tally.samples;
    assert!(there > 0 && there <= report.total.samples, "{there} of {}", report.total.samples);
}

#[test]
fn a_slow_driver_is_waited_for_no_longer_than_was_asked() {
    // A job of two seconds, of which half a dozen wait for it when the second is over.
    let mut request = request("f", r#"{"x": [1, 2]}"#);
    (request.samples, request.time) = (10_000_000, Some(Duration::from_secs(1)));
    request.threads = 4;
    let mut backends = [faulty(Fault::Slow(Duration::from_secs(2)))];
    let report = on(&half(), &request, &mut backends);
    // The second, that to finish a job, and as much and half as much for what was found: less than
    // the six jobs of those that waited.
    let slow = SLOW.load(Ordering::Relaxed);
    assert!((1_000..9_000).contains(&slow), "{slow} ms");
    assert!(report.stopped);
    // It was cut off, which is no fault of its own.
    let failure = report.backends[0].failure.as_deref();
    assert!(failure.is_none_or(|why| why == "time ran out before it finished"), "{failure:?}");
}

const POWER: &str = "#version 450\nlayout(location = 0) in float v_x;\n\
                     float f(float n) { return pow(v_x, n); }\nvoid main() { f(v_x); }\n";

/// `landfall stress` of that function in a folder of the name.
fn stressed(name: &str, arguments: &[&str]) -> Ran {
    let place = Place::new(&format!("stress-backends-{name}"));
    let domain = r#"{"v_x": [0.5, 0.99999], "n": [31, 33]}"#;
    let function = ["stress", "power.frag", "--fn", "f", "--domain", domain, "--samples", "20000"];
    place.write("power.frag", POWER).run(&[&function[..], arguments].concat())
}

#[test]
fn a_limit_holds_on_the_drivers_too() {
    stressed("limit", &["--max-ulp", "3"]).code(0);
    for backend in ["gl", "gpu"] {
        let ran = stressed("limit", &["--max-ulp", "3", "--backend", backend, "--details"]);
        let text = &ran.code(1).out;
        assert!(text.contains(&format!("finite on {backend}")), "{text}");
        // The error beside it is the driver's. Lines are wrapped.
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("which the specification permits"), "{text}");
        // Why it fails is said without details, too.
        let brief = stressed("limit", &["--max-ulp", "3", "--backend", backend]);
        let text = &brief.code(1).out;
        assert!(text.contains(&format!("  {backend}: off by ")), "{text}");
    }
}

#[test]
fn json_holds_to_its_schema_and_its_command_repeats_the_worst() {
    let stressed = stressed("json", &["--backend", "gl,gpu", "--format", "json"]);
    let validator = schema::validator(&command::run(&["schema", "stress"]).out);
    let value = schema::holds(&validator, &stressed.out, "stress");
    for (nth, name) in ["gl", "gpu"].into_iter().enumerate() {
        let backend = &value["backends"][nth];
        assert_eq!(backend["backend"], name);
        assert_eq!(backend["samples"], value["total"]["samples"], "{name}");
        let worst = &backend["worst"][0];
        let line = worst["case"]["command"].as_str().expect("it has a command");
        assert!(line.ends_with(&format!("--backend {name}")), "{line}");
        // The shell's quotes are single ones around JSON, which has none itself.
        let mut words = Vec::new();
        for (nth, part) in line.split('\'').enumerate() {
            match nth % 2 {
                0 => words.extend(part.split_whitespace().map(str::to_string)),
                _ => words.push(part.to_string()),
            }
        }
        // `--input 'v_x=0.9'` and `--input v_x=0.9` are both one word.
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stress-backends-json");
        let mut again = command::landfall(&[]);
        again.args(&words[1..]).args(["--format", "json"]).current_dir(folder);
        let again = Ran::of(again.output().expect("the command of this package"));
        let text = again.json().to_string();
        let given = worst["results"][0].to_string();
        assert!(text.contains(&given), "{name}: {given} is not in {text}");
    }
}

#[test]
fn a_driver_that_is_not_here_is_said_after_the_report() {
    let ran =
        stressed("missing", &["--backend", "gl,gpu", "--adapter", "no such adapter", "--details"]);
    let text = &ran.code(2).out;
    assert!(text.contains("finite on gl"), "{text}");
    // Lines are wrapped.
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let absent = "gpu did not run: no GPU adapter matches `no such adapter`; there are ";
    assert!(words.contains(absent), "{text}");
    ran.stderr_eq(str![[r#"
error[cannot-run]: `gpu` did not run: no GPU adapter matches `no such adapter`; there are [DRIVER]
  |
  = help: `landfall devices` lists the available backends


"#]]);
}
