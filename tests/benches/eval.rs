//! How long the evaluator takes for a fragment lit by six lights, and for an operation:
//! `cargo bench --features full --bench eval`.

use std::sync::Arc;

use landfall_exec::backend::{Backend, Job, JobOutput};
use landfall_interp::{Cpu, Precision, Settings};

mod measure;
mod scene;

const SIZE: u32 = 256;

fn main() {
    let job = scene::job(&Arc::new(scene::module()), SIZE);
    let one = Settings { threads: 1, ..Settings::default() };
    report("f32, one thread", &job, one.clone());
    report("f32, all threads", &job, Settings::default());
    let double = Settings { precision: Precision::Double, ..one.clone() };
    let both = Settings { precision: Precision::Both, ..one.clone() };
    report("f64, one thread", &job, double.clone());
    report("both, one thread", &job, both.clone());
    report("f32 watched, one thread", &job, Settings { watch: true, ..one.clone() });
    report("both watched, one thread", &job, Settings { watch: true, ..both.clone() });
    for (name, settings) in [("f64 : f32", double), ("both : f32", both)] {
        let [mut fast, mut slow] = [one.clone(), settings].map(Cpu::new);
        let run = |cpu: &mut Cpu| drop(cpu.run(&job).expect("the job runs"));
        println!("{name:26} {}", measure::interleaved(21, || run(&mut fast), || run(&mut slow)));
    }
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
