//! Shows that a shader adds exactly zero for a light: beyond its range, or anywhere in the frame.
//!
//! Follows the shader's own code with
//! [`falloff`](landfall_ir::analysis::hazards::falloff), for the numbers of each light.

use glam::DVec3;

use rustc_hash::FxHashMap;

use super::{Renderer, Work};
use crate::bind::quantity::TilePart;
use crate::bind::{Kind, LightPart, Quantity, Slot, Source as Bound};
use crate::culling::{ShownLight, ShownLights};
use crate::scene::{Attenuation, Emission, PointLight};
use landfall_exec::harness::fragments::FragmentShader;
use landfall_ir::analysis::hazards::falloff::{FalloffNumbers, FalloffTerms, LightArray, terms};
use landfall_ir::analysis::roles;
use landfall_ir::analysis::roles::{LightBinding, Role};
use landfall_layout::source::Source;
use landfall_layout::{BlockLayout, Options, Stage};

/// Farther than any fragment may be from a light.
const FAR: f64 = 1e19;

struct Lit<'w> {
    emission: &'w Emission,
    point: Option<&'w PointLight>,
}

impl Renderer {
    /// Returns where the shader is shown to add exactly zero for each light; nowhere where nothing
    /// is known. `source` and `options` are those of the shader.
    pub fn shown_lights(&self, source: &Source, options: &Options, work: &Work<'_>) -> ShownLights {
        let counts = work.upload.lights.counts();
        let mut shown = ShownLights(counts.map(|count| vec![ShownLight::Nowhere; count]));
        // A slot without a light is lit by zeros, which nothing is known about.
        let counted = |kind| self.counts(kind) || self.slots(kind) == usize::MAX;
        let is_idle = |kind: Kind| !counted(kind) && self.slots(kind) > counts[kind as usize];
        let Some(position) = self.position() else { return shown };
        // Lights bound one by one are not elements of an array, which the proof follows.
        if Kind::ALL.into_iter().any(is_idle) || self.has_single() {
            return shown;
        }
        let source = Source { stage: source.stage.or(Some(Stage::Fragment)), ..source.clone() };
        let blocks = blocks(&self.shader);
        let lights = roles::lights_in_blocks(&blocks);
        let Ok(terms) = terms(&source, options, &lights, position) else { return shown };
        for kind in Kind::ALL.into_iter().filter(|kind| self.map.has(*kind)) {
            self.shown_of(&terms, &lights, (kind, work), &mut shown.0[kind as usize]);
        }
        shown
    }

    /// Whether some light is bound on its own, outside of an array.
    fn has_single(&self) -> bool {
        self.map.members.iter().any(|member| {
            let digit = member.path.split('[').skip(1).any(|rest| !rest.starts_with(']'));
            let source = member.source.quantity();
            digit || matches!(source, Some(Quantity::Light { slot: Slot::One(_), .. }))
        })
    }

    /// Returns the last name of the input that holds the fragment's position.
    fn position(&self) -> Option<&str> {
        let is_position = |source: &Bound| *source == Bound::scene(Quantity::Position);
        let mut inputs = self.map.inputs.iter().filter(|input| is_position(&input.source));
        let name = &inputs.next()?.name;
        Some(name.rsplit('.').next().unwrap_or(name))
    }

    /// Finds what is shown of the lights of a kind, by every array that holds such lights.
    fn shown_of(
        &self,
        terms: &FalloffTerms,
        lights: &[LightBinding<'_>],
        (kind, work): (Kind, &Work<'_>),
        shown: &mut [ShownLight],
    ) {
        // The arrays whose members hold such a light.
        let holds = |held: &LightBinding<'_>| {
            held.roles.parts.iter().any(|part| {
                let path = held.full_path(part);
                matches!(self.part_at(&held.block.name, &path), Some((of, _)) if of == kind)
            })
        };
        let [counts, lists] = self.counted_by(lights, kind, &holds);
        let arrays = lights.iter().enumerate().filter(|(_, held)| holds(held));
        let mut arrays: Vec<_> = arrays
            .map(|(index, held)| {
                // What the members of the array hold of a light, by role.
                let parts = held.roles.parts.iter().map(|part| {
                    let own = self.part_at(&held.block.name, &held.full_path(part));
                    (part.role, own.filter(|(of, _)| *of == kind).map(|(_, own)| own))
                });
                let parts: Vec<(Role, Option<LightPart>)> = parts.collect();
                let array = LightArray { index, counts: &counts, lists: &lists };
                (parts, terms.of_array(array))
            })
            .collect();
        let part = |parts: &[(Role, Option<LightPart>)], role| {
            parts.iter().find(|(of, _)| *of == role).and_then(|(_, part)| *part)
        };
        let is_placed = |parts: &[(Role, Option<LightPart>)]| {
            parts.iter().all(|(role, _)| *role != Role::Position)
                || part(parts, Role::Position) == Some(LightPart::Position)
        };
        if arrays.is_empty() || !arrays.iter().all(|(parts, _)| is_placed(parts)) {
            return;
        }
        let mut adds_zero = |number: &dyn Fn(LightPart) -> Option<[f64; 2]>, near: f64| {
            arrays.iter_mut().all(|(parts, terms)| {
                let of = |role| number(part(parts, role)?);
                terms.adds_zero(&FalloffNumbers { of: &of, distance: [near, FAR] })
            })
        };
        // Lights that fade alike are shown at once, whatever they emit.
        let mut alike: FxHashMap<[u64; 4], Vec<usize>> = FxHashMap::default();
        let lit: Vec<Lit<'_>> = lit(work, kind).collect();
        for (at, light) in lit.iter().enumerate().filter(|(_, light)| light.is_finite()) {
            if light.is_black() && adds_zero(&|part| light.number(part), 0.0) {
                shown[at] = ShownLight::Everywhere;
            } else if let Some(fading) = light.point.map(|point| point.attenuation) {
                let Attenuation { constant, linear, quadratic, range } = fading;
                // By bits, so that equal keys are equal numbers.
                let numbers = [constant, linear, quadratic, range.unwrap_or(f64::INFINITY)];
                alike.entry(numbers.map(f64::to_bits)).or_default().push(at);
            }
        }
        for group in alike.into_values() {
            let fading = lit[group[0]].point.map(|point| point.attenuation);
            let Some(range) = fading.and_then(|fading| fading.range) else { continue };
            // The bounds of the whole group: what holds for them holds for each light.
            let number = |part| {
                let each = group.iter().map(|at| lit[*at].number(part));
                each.reduce(|a, b| a.zip(b).map(|([a, b], [c, d])| [a.min(c), b.max(d)]))?
            };
            // Beyond the range and a margin for the rounding in `f32`.
            if adds_zero(&number, range * ShownLights::MARGIN) {
                group.iter().for_each(|at| shown[*at] = ShownLight::BeyondRange);
            }
        }
    }

    /// Returns the paths of what counts the lights of a kind that a draw has, and of what lists
    /// their indices. Beside lists of tiles, all point lights are there in every draw.
    fn counted_by(
        &self,
        lights: &[LightBinding<'_>],
        kind: Kind,
        holds: &dyn Fn(&LightBinding<'_>) -> bool,
    ) -> [Vec<String>; 2] {
        let listed = kind != Kind::Directional && self.lists(kind);
        let [mut counts, mut lists] = [Vec::new(), Vec::new()];
        for member in &self.map.members {
            match member.source.quantity() {
                Some(Quantity::Tiles(TilePart::Index)) if listed => lists.push(member.path.clone()),
                Some(Quantity::Tiles(part)) if listed && part.kind() == Some(kind) => {
                    counts.push(member.path.clone());
                }
                Some(Quantity::Count(of)) if of == kind && !listed => {
                    counts.push(member.path.clone());
                }
                _ => {}
            }
        }
        if !listed {
            let arrays = lights.iter().filter(|held| holds(held));
            let path =
                |held: &LightBinding<'_>| format!("{}.length()", held.path.trim_end_matches("[]"));
            counts.extend(arrays.map(path));
        }
        [counts, lists]
    }

    /// Returns the property of a light that a member of a block holds, as it is.
    fn part_at(&self, block: &str, path: &str) -> Option<(Kind, LightPart)> {
        let member = self.map.members.iter().find(|m| m.name == block && m.path == path)?;
        match member.source {
            Bound::Scene { quantity: Quantity::Light { kind, part, .. }, negated: false } => {
                Some((kind, part))
            }
            _ => None,
        }
    }
}

fn blocks(shader: &FragmentShader) -> Vec<BlockLayout> {
    shader.blocks().iter().map(|block| block.layout.clone()).collect()
}

impl Lit<'_> {
    /// Whether what it emits is finite: zero times infinity is no zero.
    fn is_finite(&self) -> bool {
        let Emission { ambient, diffuse, specular, color, intensity } = *self.emission;
        let colors = [ambient, diffuse, specular, color, color * intensity];
        colors.iter().all(|color| color.as_vec3().is_finite()) && intensity.is_finite()
    }

    /// Whether it emits nothing, by its intensity or by its colours.
    fn is_black(&self) -> bool {
        let Emission { ambient, diffuse, specular, color, intensity } = *self.emission;
        let none = |colors: &[DVec3]| colors.iter().all(|color| *color == DVec3::ZERO);
        intensity == 0.0 || none(&[color]) || none(&[ambient, diffuse, specular])
    }

    /// Returns the least and greatest component of a property; `None` if it is not followed.
    fn number(&self, part: LightPart) -> Option<[f64; 2]> {
        let ends = |color: DVec3| Some([color.min_element(), color.max_element()]);
        let one = |number: f64| {
            // As uploaded.
            let number = f64::from(number as f32);
            Some([number; 2])
        };
        let Emission { ambient, diffuse, specular, color, intensity } = *self.emission;
        let fading = self.point.map(|point| point.attenuation);
        match part {
            LightPart::Color => ends(color),
            LightPart::Radiance => ends((color * intensity).as_vec3().as_dvec3()),
            LightPart::Ambient => ends(ambient),
            LightPart::Diffuse => ends(diffuse),
            LightPart::Specular => ends(specular),
            LightPart::Intensity => one(intensity),
            LightPart::Constant => one(fading?.constant),
            LightPart::Linear => one(fading?.linear),
            LightPart::Quadratic => one(fading?.quadratic),
            LightPart::Range => one(fading?.range?),
            LightPart::RangeSquared => one(fading?.range?.powi(2)),
            LightPart::InverseRange => one(fading?.range?.recip()),
            LightPart::InverseRangeSquared => one(fading?.range?.powi(2).recip()),
            LightPart::Position
            | LightPart::Direction
            | LightPart::Attenuation
            | LightPart::InnerCos
            | LightPart::OuterCos
            | LightPart::InnerDegrees
            | LightPart::OuterDegrees
            | LightPart::InnerRadians
            | LightPart::OuterRadians
            | LightPart::Enabled => None,
        }
    }
}

fn lit<'w>(work: &Work<'w>, kind: Kind) -> impl Iterator<Item = Lit<'w>> {
    let lights = &work.upload.lights;
    (0..lights.counts()[kind as usize]).map(move |number| Lit {
        emission: lights.emission(kind, number),
        point: lights.positioned(kind, number),
    })
}
