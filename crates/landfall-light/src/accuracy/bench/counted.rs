//! What a shader does for a fragment, counted by the evaluator whoever is measured; and what its
//! arithmetic permits.
//!
//! Reads [`Uploaded`]; feeds the rows of [`shader`](super::shader).

use super::report::{Permitted, Work};
use super::uploaded::Uploaded;
use crate::accuracy::permitted::off_from;
use crate::render::Prepared;
use crate::render::planned::Lot;
use crate::render::tally::Tally;
use landfall_exec::interp::{Cpu, Floats, Settings};

/// Fragments whose operations are counted, of those of a run.
const COUNTED: usize = 4096;

/// Lights at fragments that are looked at for what is permitted: about a second of it.
const LOOKED_AT: usize = 1 << 16;

/// Slots that are marked one after the other, and about how often a light is computed for that.
const MARKED: usize = 128;
const LIGHTS: usize = 1 << 21;

/// Work of a shader for a fragment, its floats rounded like that.
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
    for Lot { prepared, .. } in uploaded.some(COUNTED) {
        let (shader, batch) = (&uploaded.renderer.shader, prepared.batch(uploaded.limit));
        shader.run(&mut cpu, &batch, |cpu, _| tally.add(&cpu.notes)).ok()?;
        fragments += prepared.count;
    }
    (fragments > 0).then(|| tally.counts.operations() as f64 / fragments as f64)
}

/// Lights that are really evaluated at a fragment, on average over some: whether one is shows
/// where its colours are no numbers; and the standard error of that. None where the shader is
/// given no colours, or does not run.
fn evaluations(uploaded: &Uploaded<'_>, floats: Floats) -> Option<(f64, f64)> {
    let mut cpu = Cpu::rounded(Settings::default(), floats);
    let slots = |lot: &Lot| lot.slots.iter().map(|(_, slots)| *slots as usize).sum::<usize>();
    let most = uploaded.whole.iter().map(slots).max().unwrap_or(0).max(1);
    let mut run = |prepared: &Prepared| -> Option<Vec<[u32; 4]>> {
        let batch = prepared.batch(uploaded.limit);
        let shaded = uploaded.renderer.shader.run(&mut cpu, &batch, |_, _| {}).ok()?;
        Some(shaded.colors.iter().map(|color| color.map(f32::to_bits)).collect())
    };
    let mut each: Vec<f64> = Vec::new();
    // What not every slot having been marked leaves open, of all fragments together.
    let mut open = 0.0;
    for lot in uploaded.some((LIGHTS / most / most.min(MARKED)).clamp(16, 1024)) {
        let plain = run(&lot.prepared)?;
        let kinds = lot.slots.iter();
        let all = kinds.flat_map(|(kind, n)| (0..*n as usize).map(|at| (*kind, at)));
        let all: Vec<_> = all.collect();
        let marked = all.len().min(MARKED);
        let stands_for = all.len() as f64 / marked.max(1) as f64;
        let mut of_fragments = vec![0.0; plain.len()];
        let mut of_slots = Vec::with_capacity(marked);
        for nth in 0..marked {
            let (kind, slot) = all[nth * all.len() / marked];
            let shaded = run(&uploaded.renderer.marked(&lot.prepared, kind, slot)?)?;
            let before: f64 = of_fragments.iter().sum();
            for (count, (ours, plain)) in of_fragments.iter_mut().zip(shaded.iter().zip(&plain)) {
                *count += if ours != plain { stands_for } else { 0.0 };
            }
            of_slots.push(of_fragments.iter().sum::<f64>() - before);
        }
        open += variance(&of_slots) * marked as f64 * (1.0 - 1.0 / stands_for.max(1.0));
        each.extend(of_fragments);
    }
    let fragments = each.len() as f64;
    let all = uploaded.stage.frame.fragments.len() as f64;
    let spread = variance(&each) / fragments * (1.0 - fragments / all) + open / fragments.powi(2);
    let mean = each.iter().sum::<f64>() / fragments;
    (!each.is_empty()).then(|| (mean, spread.max(0.0).sqrt()))
}

/// Of a sample.
fn variance(all: &[f64]) -> f64 {
    let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
    let squares: f64 = all.iter().map(|x| (x - mean).powi(2)).sum();
    squares / all.len().saturating_sub(1).max(1) as f64
}

/// How far from the reference any conformant device may be, as the shader is written; none where
/// that is not known, as of floats that are rounded to less.
pub fn permitted(uploaded: &Uploaded<'_>, floats: Floats) -> Option<Permitted> {
    match floats {
        Floats::AsWritten => {}
        Floats::Half | Floats::Mediump => return None,
    }
    let slots = uploaded.whole.iter().map(|lot| lot.walked).max().unwrap_or(0);
    let about = (LOOKED_AT / slots.max(1) as usize).max(256);
    let (mut steps, mut unsure) = (Vec::new(), 0);
    for Lot { prepared, fragments, .. } in uploaded.some(about) {
        let shader = &uploaded.renderer.shader;
        let around = shader.permitted(&prepared.batch(uploaded.limit)).ok()?;
        for ((around, unsure_at), at) in around.colors.iter().zip(&around.unsure).zip(fragments) {
            let Some(truth) = uploaded.stage.truth(at as usize) else { continue };
            let each = around.iter().zip(truth).map(|(around, truth)| off_from(*around, truth));
            steps.push(255.0 * each.fold(0.0, f64::max));
            unsure += u64::from(*unsure_at);
        }
    }
    (!steps.is_empty()).then(|| Permitted::of(&mut steps, unsure))
}
