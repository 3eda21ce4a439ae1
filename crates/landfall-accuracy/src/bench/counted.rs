//! The work of a shader per fragment, counted by the interpreter for every backend, and the error
//! its arithmetic permits.
//!
//! Reads [`Uploaded`]; feeds the rows of [`shader`](super::shader).

use super::report::{Permitted, Work};
use super::uploaded::Uploaded;
use crate::permitted::off_from;
use landfall_interp::{Cpu, Floats, Settings};
use landfall_light::render::Prepared;
use landfall_light::render::planned::FragmentGroup;
use landfall_light::render::tally::Tally;

/// The fragments of a run whose operations are counted.
const COUNTED: usize = 4096;

/// The pairs of fragment and light examined for permitted errors, which takes about a second.
const EXAMINED: usize = 1 << 16;

/// The slots marked one after the other; each costs about one evaluation of a light.
const MARKED: usize = 128;
const LIGHTS: usize = 1 << 21;

/// Returns the work of a shader per fragment, with floats of that precision.
pub fn work(uploaded: &Uploaded<'_>, floats: Floats) -> Work {
    let blocks = uploaded.whole.iter().flat_map(|lot| &lot.prepared.blocks);
    let walked = uploaded.whole.iter().map(|lot| lot.walked * lot.fragments.len() as u64);
    let slots = walked.sum::<u64>() as f64 / uploaded.stage.frame.fragments.len().max(1) as f64;
    let evaluations = evaluations(uploaded, floats);
    Work {
        evaluations: evaluations.map(|(mean, _)| mean),
        evaluations_error: evaluations.map(|(_, error)| error),
        slots: Some(slots),
        powers: None,
        operations: operations(uploaded, floats),
        bytes: Some(blocks.map(|block| block.len() as u64).sum()),
    }
}

fn operations(uploaded: &Uploaded<'_>, floats: Floats) -> Option<f64> {
    let mut cpu = Cpu::rounded(Settings::default(), floats);
    let (mut tally, mut fragments) = (Tally::default(), 0);
    for FragmentGroup { prepared, .. } in uploaded.sampled_groups(COUNTED) {
        let (shader, batch) = (&uploaded.renderer.shader, prepared.batch(uploaded.limit));
        shader.run(&mut cpu, &batch, |cpu, _| tally.add(&cpu.notes)).ok()?;
        fragments += prepared.count;
    }
    (fragments > 0).then(|| tally.counts.operations() as f64 / fragments as f64)
}

/// Returns the mean number of lights evaluated per fragment and its standard error, from a sample
/// of fragments: an evaluated light shows if its colour is NaN. `None` for a shader without light
/// colours, or one that does not run.
fn evaluations(uploaded: &Uploaded<'_>, floats: Floats) -> Option<(f64, f64)> {
    // To see whether the shader skips a light, its colour is replaced by NaN: a fragment whose
    // result changes has evaluated it. Each run marks one slot, so slots are sampled where there
    // are many, and each stands for as many as were left out.
    let mut cpu = Cpu::rounded(Settings::default(), floats);
    let slots =
        |lot: &FragmentGroup| lot.slots.iter().map(|(_, slots)| *slots as usize).sum::<usize>();
    let most = uploaded.whole.iter().map(slots).max().unwrap_or(0).max(1);
    let mut run = |prepared: &Prepared| -> Option<Vec<[u32; 4]>> {
        let batch = prepared.batch(uploaded.limit);
        let shaded = uploaded.renderer.shader.run(&mut cpu, &batch, |_, _| {}).ok()?;
        Some(shaded.colors.iter().map(|color| color.map(f32::to_bits)).collect())
    };
    let mut each: Vec<f64> = Vec::new();
    // The variance from slots that were not marked, over all fragments.
    let mut open = 0.0;
    // Fragments times slots, and each mark runs over all slots again: quadratic in the slots,
    // hence the limit of the product.
    for lot in uploaded.sampled_groups((LIGHTS / most / most.min(MARKED)).clamp(16, 1024)) {
        let plain = run(&lot.prepared)?;
        let kinds = lot.slots.iter();
        let all = kinds.flat_map(|(kind, n)| (0..*n as usize).map(|at| (*kind, at)));
        let all: Vec<_> = all.collect();
        let marked = all.len().min(MARKED);
        let stands_for = all.len() as f64 / marked.max(1) as f64;
        let mut of_fragments = vec![0.0; plain.len()];
        let mut of_slots = Vec::with_capacity(marked);
        for nth in 0..marked {
            // Evenly spaced slots.
            let (kind, slot) = all[nth * all.len() / marked];
            let shaded = run(&uploaded.renderer.marked(&lot.prepared, kind, slot)?)?;
            let before: f64 = of_fragments.iter().sum();
            for (count, (ours, plain)) in of_fragments.iter_mut().zip(shaded.iter().zip(&plain)) {
                *count += if ours != plain { stands_for } else { 0.0 };
            }
            of_slots.push(of_fragments.iter().sum::<f64>() - before);
        }
        // Two-stage sampling: `open` is the variance from slots, with the factor of a finite
        // population. It is 0 where every slot was marked.
        open += variance(&of_slots) * marked as f64 * (1.0 - 1.0 / stands_for.max(1.0));
        each.extend(of_fragments);
    }
    let fragments = each.len() as f64;
    let all = uploaded.stage.frame.fragments.len() as f64;
    // The variance of the mean over fragments, again for a finite population, and that of the
    // slots.
    let spread = variance(&each) / fragments * (1.0 - fragments / all) + open / fragments.powi(2);
    let mean = each.iter().sum::<f64>() / fragments;
    (!each.is_empty()).then(|| (mean, spread.max(0.0).sqrt()))
}

fn variance(all: &[f64]) -> f64 {
    let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
    // Compared as bits: NaN is unequal to itself.
    let squares: f64 = all.iter().map(|x| (x - mean).powi(2)).sum();
    squares / all.len().saturating_sub(1).max(1) as f64
}

/// Returns the largest error of any conformant device, for the shader as written; `None` where that
/// is unknown, as for floats rounded to less than `f32`.
pub fn permitted(uploaded: &Uploaded<'_>, floats: Floats) -> Option<Permitted> {
    match floats {
        Floats::AsWritten => {}
        Floats::Half | Floats::Mediump => return None,
    }
    let slots = uploaded.whole.iter().map(|lot| lot.walked).max().unwrap_or(0);
    // The cost of a bound grows with the slots that a fragment walks.
    let about = (EXAMINED / slots.max(1) as usize).max(256);
    let (mut steps, mut unsure) = (Vec::new(), 0);
    for FragmentGroup { prepared, fragments, .. } in uploaded.sampled_groups(about) {
        let shader = &uploaded.renderer.shader;
        let around = shader.permitted(&prepared.batch(uploaded.limit)).ok()?;
        for ((around, unsure_at), at) in around.colors.iter().zip(&around.unsure).zip(fragments) {
            let Some(truth) = uploaded.stage.truth(at as usize) else { continue };
            // The largest distance of any channel.
            let each = around.iter().zip(truth).map(|(around, truth)| off_from(*around, truth));
            steps.push(255.0 * each.fold(0.0, f64::max));
            unsure += u64::from(*unsure_at);
        }
    }
    (!steps.is_empty()).then(|| Permitted::new(&mut steps, unsure))
}
