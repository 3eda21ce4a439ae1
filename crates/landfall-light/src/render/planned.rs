//! Renders a scene by a plan: a draw for each set of lights, or a single draw for a shader that
//! reads light lists.

use glam::Vec3;

use super::{Draw, Prepared, RenderError, Rendered, Renderer, Work};
use crate::Chosen;
use crate::bind::{Kind, Quantity};
use crate::culling;
use crate::culling::{LightSet, Measured, Options, Plan, TileLists};
use crate::picture::Picture;
use crate::shading_f32::Model;
use landfall_exec::backend::Backend;

/// Fragments of one material lit by the same lights, prepared for repeated runs.
#[derive(Clone, Debug, PartialEq)]
pub struct FragmentGroup {
    /// The indices of the fragments in the frame.
    pub fragments: Vec<u32>,
    pub prepared: Prepared,
    /// The slots of each kind in use by some of them.
    pub slots: [(Kind, u64); 3],
    /// The slots that each fragment visits; lists of tiles omit some.
    pub walked: u64,
}

impl FragmentGroup {
    /// Returns every `stride`-th of its fragments from `first` on.
    pub fn step_by(&self, first: usize, stride: usize) -> FragmentGroup {
        let fragments: Vec<u32> =
            self.fragments.iter().copied().skip(first).step_by(stride.max(1)).collect();
        let some = |values: &Vec<[f32; 4]>| {
            values.iter().copied().skip(first).step_by(stride.max(1)).collect()
        };
        let inputs = self.prepared.inputs.iter().map(some).collect();
        let count = fragments.len();
        let prepared = Prepared { inputs, count, ..self.prepared.clone() };
        FragmentGroup { fragments, prepared, ..self.clone() }
    }
}

impl Renderer {
    /// Returns the fragments of a draw, grouped by material.
    ///
    /// # Errors
    /// More lights than slots.
    pub fn fragment_groups(
        &self,
        work: &Work<'_>,
        draw: &Draw<'_>,
    ) -> Result<Vec<FragmentGroup>, RenderError> {
        let all = &work.frame.fragments;
        let mut numbers = draw.fragments.to_vec();
        // A stable sort keeps the caller's order within a material.
        numbers.sort_by_key(|number| all[*number as usize].material);
        let slots = Kind::ALL.map(|kind| (kind, self.walked(kind, draw.lights)));
        let same = |a: &u32, b: &u32| all[*a as usize].material == all[*b as usize].material;
        let each = numbers.chunk_by(same).map(|fragments| {
            let prepared = self.prepare(work, Chosen { all, numbers: fragments }, draw)?;
            let walked = slots.iter().map(|(_, slots)| slots).sum();
            Ok(FragmentGroup { fragments: fragments.to_vec(), prepared, slots, walked })
        });
        each.collect()
    }

    /// Returns the fragments of all draws of a plan.
    ///
    /// # Errors
    /// More lights than slots.
    pub fn plan_fragment_groups(
        &self,
        work: &Work<'_>,
        plan: &Plan,
    ) -> Result<Vec<FragmentGroup>, RenderError> {
        if let (true, Some(lists)) = (self.reads_tile_lists(), &plan.tiles) {
            let mut lots =
                self.listed(work, plan, lists, |draw| self.fragment_groups(work, draw))?;
            let mut listed = vec![0u64; work.frame.fragments.len()];
            for draw in &plan.draws {
                let len = self.in_lists(&draw.lights);
                draw.fragments.iter().for_each(|number| listed[*number as usize] = len);
            }
            for lot in &mut lots {
                let listed: u64 = lot.fragments.iter().map(|number| listed[*number as usize]).sum();
                let others = lot.slots.iter().filter(|(kind, _)| !self.lists(*kind));
                let others: u64 = others.map(|(_, slots)| slots).sum();
                // The average over the fragments: each tile has a list of its own length.
                lot.walked = others + listed.div_ceil(lot.fragments.len().max(1) as u64);
            }
            return Ok(lots);
        }
        let mut lots = Vec::new();
        for draw in draws(plan) {
            lots.extend(self.fragment_groups(work, &draw)?);
        }
        Ok(lots)
    }

    /// Makes a plan for this shader, whose loops without a count visit every slot.
    pub fn plan(&self, work: &Work<'_>, model: &Model, options: &Options) -> Plan {
        culling::plan(work.upload, work.frame, model, &self.with_slots(options))
    }

    /// Makes a plan for this shader without what gates would skip, as every picture needs one.
    pub fn plan_only(&self, work: &Work<'_>, model: &Model, options: &Options) -> Plan {
        culling::plan_only(work.upload, work.frame, model, &self.with_slots(options))
    }

    fn with_slots(&self, options: &Options) -> Options {
        let mut options = options.clone();
        for (slots, kind) in options.slots.iter_mut().zip(Kind::ALL) {
            let fixed = self.slots(kind);
            // Such a loop visits every slot, so fewer lights cost no less.
            if slots.is_none() && !self.counts(kind) && fixed != usize::MAX {
                *slots = u32::try_from(fixed).ok();
            }
        }
        options
    }

    /// Whether the shader reads lights of some kind from lists of tiles.
    pub fn reads_tile_lists(&self) -> bool {
        Kind::ALL.into_iter().any(|kind| self.lists(kind))
    }

    /// Whether the shader reads its lights of a kind from lists of tiles.
    pub fn lists(&self, kind: Kind) -> bool {
        let of = |quantity| match quantity {
            Some(Quantity::Tiles(part)) => part.kind() == Some(kind),
            _ => false,
        };
        self.map.members.iter().any(|member| of(member.source.quantity()))
    }

    /// Returns how many of some lights the shader reads from lists.
    fn in_lists(&self, lights: &LightSet) -> u64 {
        let listed = Kind::ALL.into_iter().filter(|kind| self.lists(*kind));
        listed.map(|kind| lights.of(kind).len() as u64).sum()
    }

    /// Renders the picture by a plan. `after` receives the fragments done after each job.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the backend.
    pub fn render_plan<R: Backend + ?Sized>(
        &self,
        backend: &mut R,
        work: &Work<'_>,
        plan: &Plan,
        after: &mut dyn FnMut(&mut R, usize),
    ) -> Result<Rendered, RenderError> {
        self.render_plan_onto(work.picture(), backend, work, plan, after)
    }

    /// Renders by a plan onto a picture; one without pixels stays so.
    pub(super) fn render_plan_onto<R: Backend + ?Sized>(
        &self,
        picture: Picture,
        backend: &mut R,
        work: &Work<'_>,
        plan: &Plan,
        after: &mut dyn FnMut(&mut R, usize),
    ) -> Result<Rendered, RenderError> {
        if let (true, Some(lists)) = (self.reads_tile_lists(), &plan.tiles) {
            return self.render_lists(picture, backend, work, plan, lists, after);
        }
        let draws: Vec<Draw<'_>> = draws(plan).collect();
        self.render_onto(picture, backend, work, &draws, after)
    }

    /// Returns the difference of a picture made by a plan from the shader's own with all lights, at
    /// every fragment.
    pub fn apart(&self, work: &Work<'_>, by_plan: &Picture, all: &Picture) -> Measured {
        let lit = work.upload.lights.counts();
        // Slots without a light may divide by zero, which a plan may mend.
        let mends = Kind::ALL.into_iter().any(|kind| {
            let slots = self.slots(kind);
            !self.counts(kind) && slots != usize::MAX && slots > lit[kind as usize]
        });
        let fragments = &work.frame.fragments;
        let color = |picture: &Picture, pixel: u32| {
            let [r, g, b, _] = picture.pixels[pixel as usize];
            Vec3::new(r, g, b)
        };
        let pairs = fragments.iter().map(|f| (color(by_plan, f.pixel), color(all, f.pixel)));
        culling::compare(pairs.filter(|(_, all)| all.is_finite() || !mends))
    }

    /// Lights all fragments in one draw, whose shader reads the lists.
    fn render_lists<R: Backend + ?Sized>(
        &self,
        picture: Picture,
        backend: &mut R,
        work: &Work<'_>,
        plan: &Plan,
        lists: &TileLists,
        after: &mut dyn FnMut(&mut R, usize),
    ) -> Result<Rendered, RenderError> {
        let (mut rendered, others) = self.listed(work, plan, lists, |draw| {
            let draws = std::slice::from_ref(draw);
            let rendered = self.render_onto(picture, backend, work, draws, after)?;
            // All lights of the other kinds, which have no lists.
            let others = Kind::ALL.into_iter().filter(|kind| !self.lists(*kind));
            Ok((rendered, others.map(|kind| self.walked(kind, draw.lights)).sum::<u64>()))
        })?;
        let listed = plan.draws.iter();
        let listed = listed.map(|d| d.fragments.len() as u64 * self.in_lists(&d.lights));
        rendered.evaluations = listed.sum::<u64>() + rendered.fragments * others;
        Ok(rendered)
    }

    /// Runs `with` on the single draw of a plan whose shader reads the lists.
    fn listed<T>(
        &self,
        work: &Work<'_>,
        plan: &Plan,
        lists: &TileLists,
        with: impl FnOnce(&Draw<'_>) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let counts = work.upload.lights.counts();
        // All lights of a listed kind, since the lists hold indices into the upload.
        let numbers = Kind::ALL.map(|kind| match self.lists(kind) {
            true => (0..counts[kind as usize] as u32).collect(),
            false => union(plan, kind),
        });
        let ambient = plan.draws.iter().any(|draw| draw.lights.ambient);
        let (lights, all) = (LightSet { ambient, numbers }, work.frame.numbers());
        with(&Draw { fragments: &all, lights: &lights, tiles: Some(lists) })
    }
}

/// Returns the draws of a plan, for a shader without lists.
fn draws(plan: &Plan) -> impl Iterator<Item = Draw<'_>> {
    plan.draws.iter().map(|draw| Draw {
        fragments: &draw.fragments,
        lights: &draw.lights,
        tiles: None,
    })
}

/// Returns the lights of a kind that some draw has.
fn union(plan: &Plan, kind: Kind) -> Vec<u32> {
    let mut all: Vec<u32> =
        plan.draws.iter().flat_map(|draw| draw.lights.of(kind).iter().copied()).collect();
    all.sort_unstable();
    all.dedup();
    all
}
