//! How long the evaluator takes for a fragment lit by six lights, and for an operation:
//! `cargo bench --features full --bench eval`.

use std::sync::Arc;

use landfall_exec::backend::{Backend, Job, JobOutput};
use landfall_exec::interp::{Cpu, Precision, Settings};

mod measure;
mod scene;

const SIZE: u32 = 256;

fn main() {
    let job = scene::job(&Arc::new(scene::module()), SIZE);
    let one = Settings { threads: 1, ..Settings::default() };
    report("f32, one thread", &job, one.clone());
    report("f32, all threads", &job, Settings::default());
    report("f64, one thread", &job, Settings { precision: Precision::Double, ..one.clone() });
    report("both, one thread", &job, Settings { precision: Precision::Both, ..one.clone() });
    report("f32 watched, one thread", &job, Settings { watch: true, ..one.clone() });
    report(
        "both watched, one thread",
        &job,
        Settings { watch: true, precision: Precision::Both, ..one },
    );
}

fn report(name: &str, job: &Job, settings: Settings) {
    let mut cpu = Cpu::new(settings);
    let run = |cpu: &mut Cpu| -> JobOutput { cpu.run(job).expect("the job runs") };
    let answer = run(&mut cpu);
    let times: Vec<f64> = (0..9).map(|_| measure::seconds(&mut || drop(run(&mut cpu)))).collect();
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    let median = measure::median(times);
    let fragments = f64::from(SIZE * SIZE);
    let operations = cpu.notes.counts.operations() as f64;
    let sum: f64 = answer.pixels.iter().map(|p| f64::from(f32::from_bits(p[0]))).sum();
    println!(
        "{name:26} {:7.0} ns/fragment median, {:7.0} least; {:4.0} operations each, \
         {:5.0} million a second; mean red {:.6}",
        1e9 * median / fragments,
        1e9 * least / fragments,
        operations / fragments,
        1e-6 * operations / median,
        sum / fragments,
    );
}
