//! Keeps only the lights in use: those with an effect and a slot in the shader.

use glam::DVec3;

use super::bound::Bounded;
use super::options::{Options, ShownLight, ShownLights};
use crate::plan::{Claim, Compiled, Evaluations, OptionEffect, Plan, Savings};
use crate::scene::Kind;
use crate::shading_f32::Model;
use crate::{Frame, Upload};

/// Returns the lights to plan for, and the savings so far.
pub(super) fn used(
    upload: &Upload,
    frame: &Frame,
    model: &Model,
    all: &[Bounded],
    options: &Options,
) -> (Vec<Bounded>, Savings) {
    let fragments = frame.fragments.len() as u64;
    let uploaded = upload.lights.counts();
    // The loop of the shader visits every slot, filled or not: that is what the savings compare
    // with.
    let slots = [0, 1, 2].map(|at| options.slots[at].map_or(uploaded[at], |n| n as usize));
    let looped = slots.iter().sum::<usize>() as u64;
    let before = fragments * looped;
    let mut savings = Savings { fragments, before, ..Savings::default() };
    for kind in Kind::ALL {
        let (uploaded, slots) = (uploaded[kind as usize], slots[kind as usize]);
        if uploaded > slots {
            savings.notes.push(format!(
                "{uploaded} {} lights, but the shader's array has {slots} slots: the last {} are left \
                 out",
                kind.name(),
                uploaded - slots
            ));
        }
    }
    let has_slot = |light: &Bounded| (light.number as usize) < slots[light.kind as usize];
    let mut lights: Vec<Bounded> = all.iter().filter(|light| has_slot(light)).cloned().collect();
    // Where the shader's code was shown, the model's bounds are of no interest, nor is their
    // absence.
    for light in lights.iter().filter(|_| options.shown.is_none()) {
        if let Err(why) = light.shape {
            savings.notes.push(format!(
                "{} light {} {}: no bound is known, so it is never dropped",
                light.kind.name(),
                light.number,
                why.reason()
            ));
        }
    }
    if options.used {
        let there = lights.len();
        // A dark light still adds NaN where its attenuation is 1/0; `Claim::Exact` says under
        // which condition.
        lights.retain(|light| match &options.shown {
            Some(shown) => shown.of(light.kind, light.number) != ShownLight::Everywhere,
            None => !is_dark(upload, light, model),
        });
        let dark = there - lights.len();
        let empty = looped as usize - there;
        let after = fragments * lights.len() as u64;
        let did = format!(
            "{} of {looped} slots kept: {empty} empty and {dark} with a black light dropped",
            lights.len(),
        );
        let error = match &options.shown {
            Some(_) => "the shader's code was shown to give exactly zero for these lights",
            None => {
                "a black light adds exactly zero where its attenuation is finite; a zeroed slot \
                 in a loop over all slots adds 0 * (1 / 0), which is NaN"
            }
        };
        let error = Claim::Exact { why: error.to_string() };
        savings.steps.push(OptionEffect {
            option: "used".to_string(),
            did,
            evaluations: Some(Evaluations { before, after }),
            error,
            tests: 0,
        });
    }
    if let Some(shown) = &options.shown {
        lights = lights.into_iter().map(|light| only_shown(upload, shown, light)).collect();
    }
    (lights, savings)
}

/// Returns a light that ends where the shader's code was shown to give zero for it.
fn only_shown(upload: &Upload, shown: &ShownLights, light: Bounded) -> Bounded {
    let point = upload.lights.positioned(light.kind, light.number as usize);
    let ends = shown.of(light.kind, light.number) == ShownLight::BeyondRange;
    let range = point.and_then(|point| point.attenuation.range).filter(|_| ends);
    // NaN for directional lights: `of_range` then makes them unbounded.
    let position = point.map_or(DVec3::NAN, |point| point.position);
    light.of_range(range.map(|range| range * ShownLights::MARGIN), position)
}

/// Whether ambient light is present, or cannot be left out.
pub(super) fn ambient(upload: &Upload, model: &Model, options: &Options) -> bool {
    let dark = |a: &crate::scene::Ambient| a.color * a.intensity == DVec3::ZERO;
    // Without knowledge of the shader, it stays as it is without a plan.
    options.shown.is_some()
        || model.counts_ambient()
            && upload.lights.ambient.is_some_and(|ambient| !(options.used && dark(&ambient)))
}

/// Returns what a shader must hold for the lights that some draw uses.
pub(super) fn compiled(plan: &Plan, ambient: bool) -> Compiled {
    let sets = plan.draws.iter().map(|draw| &draw.lights);
    let none = Compiled { ambient, ..Compiled::default() };
    // One shader serves all draws, so it must hold the longest list of each kind.
    sets.fold(none, |most, set| {
        let [directional, point, spot] = set.counts().map(|count| count as u32);
        Compiled {
            ambient,
            directional: most.directional.max(directional),
            point: most.point.max(point),
            spot: most.spot.max(spot),
        }
    })
}

fn is_dark(upload: &Upload, light: &Bounded, model: &Model) -> bool {
    let emission = upload.lights.emission(light.kind, light.number as usize);
    model.colors(emission).iter().all(|color| *color == DVec3::ZERO)
}
