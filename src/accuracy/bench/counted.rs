//! What a shader does for a fragment, counted by the evaluator whoever is measured; and what its
//! arithmetic permits.
//!
//! Reads [`Uploaded`]; feeds the rows of [`shader`](super::shader).

use super::report::{Permitted, Work};
use super::uploaded::Uploaded;
use crate::accuracy::permitted::off_from;
use crate::light::render::tally::Tally;
use crate::run::eval::{Cpu, Floats, Settings};
use crate::run::fragments::Shaded;

/// Fragments whose operations are counted, of those of a run.
const COUNTED: usize = 4096;

/// Lights at fragments that are looked at for what is permitted: about a second of it.
const LOOKED_AT: usize = 1 << 16;

/// Slots that are marked one after the other, and about how often a light is computed for that.
const MARKED: usize = 128;
const LIGHTS: usize = 1 << 21;

/// Work of a shader for a fragment, its floats rounded like that.
pub fn work(uploaded: &Uploaded<'_>, floats: Floats) -> Work {
    let blocks = uploaded.whole.iter().flat_map(|prepared| &prepared.blocks);
    let slots: u64 = uploaded.slots.iter().map(|(_, slots)| slots).sum();
    Work {
        evaluations: evaluations(uploaded, floats),
        slots: Some(slots as f64),
        powers: None,
        operations: operations(uploaded, floats),
        bytes: Some(blocks.map(|block| block.len() as u64).sum()),
    }
}

fn operations(uploaded: &Uploaded<'_>, floats: Floats) -> Option<f64> {
    let mut cpu = Cpu::rounded(Settings::default(), floats);
    let (mut tally, mut fragments) = (Tally::default(), 0);
    for (some, _) in uploaded.some(COUNTED) {
        let shader = &uploaded.renderer.shader;
        let ran = shader.run(&mut cpu, &some.batch(uploaded.limit), |cpu, _| tally.add(&cpu.notes));
        ran.ok()?;
        fragments += some.count;
    }
    (fragments > 0).then(|| tally.counts.operations() as f64 / fragments as f64)
}

/// Lights that are really evaluated at a fragment, on average over some: whether one is shows
/// where its colours are no numbers. None where the shader is given no colours, or does not run.
fn evaluations(uploaded: &Uploaded<'_>, floats: Floats) -> Option<f64> {
    let mut cpu = Cpu::rounded(Settings::default(), floats);
    let all: u64 = uploaded.slots.iter().map(|(_, slots)| slots).sum();
    let all = usize::try_from(all).ok()?;
    if all == 0 {
        return Some(0.0);
    }
    let marked = all.min(MARKED);
    let some = uploaded.some((LIGHTS / all / marked).clamp(16, 1024));
    let run = |cpu: &mut Cpu, prepared: &crate::light::render::Prepared| -> Option<Shaded> {
        uploaded.renderer.shader.run(cpu, &prepared.batch(uploaded.limit), |_, _| {}).ok()
    };
    let mut plain = Vec::with_capacity(some.len());
    for (prepared, _) in &some {
        plain.push(run(&mut cpu, prepared)?);
    }
    let slots = uploaded.slots.iter().flat_map(|(kind, n)| (0..*n as usize).map(|at| (*kind, at)));
    let slots: Vec<_> = slots.collect();
    let (mut seen, mut looked_at) = (0u64, 0u64);
    for nth in 0..marked {
        let (kind, slot) = slots[nth * all / marked];
        for ((prepared, _), plain) in some.iter().zip(&plain) {
            let marked = uploaded.renderer.marked(prepared, kind, slot)?;
            let shaded = run(&mut cpu, &marked)?;
            let bits = |color: &[f32; 4]| color.map(f32::to_bits);
            let each = shaded.colors.iter().zip(&plain.colors);
            seen += each.filter(|(ours, plain)| bits(ours) != bits(plain)).count() as u64;
            looked_at += prepared.count as u64;
        }
    }
    (looked_at > 0).then(|| all as f64 * seen as f64 / looked_at as f64)
}

/// How far from the reference any conformant device may be, as the shader is written; none where
/// that is not known, as of floats that are rounded to less.
pub fn permitted(uploaded: &Uploaded<'_>, floats: Floats) -> Option<Permitted> {
    match floats {
        Floats::AsWritten => {}
        Floats::Half | Floats::Mediump => return None,
    }
    let slots: u64 = uploaded.slots.iter().map(|(_, slots)| slots).sum();
    let fragments = (LOOKED_AT / slots.max(1) as usize).max(256);
    let (mut steps, mut unsure) = (Vec::new(), 0);
    for (prepared, places) in uploaded.some(fragments) {
        let shader = &uploaded.renderer.shader;
        let around = shader.permitted(&prepared.batch(uploaded.limit)).ok()?;
        for ((around, is_unsure), place) in around.colors.iter().zip(&around.unsure).zip(places) {
            let Some(truth) = uploaded.stage.truth(place) else { continue };
            let each = around.iter().zip(truth).map(|(around, truth)| off_from(*around, truth));
            steps.push(255.0 * each.fold(0.0, f64::max));
            unsure += u64::from(*is_unsure);
        }
    }
    (!steps.is_empty()).then(|| Permitted::of(&mut steps, unsure))
}
