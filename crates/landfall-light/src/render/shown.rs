//! Shows that a shader adds exactly zero for each light that a plan leaves out.
//!
//! Follows the shader's own code with
//! [`falloff`](landfall_ir::analysis::hazards::falloff), for the numbers of each light and its
//! distance from the nearest fragment that is lit without it.

use glam::DVec3;

use super::{Renderer, Work};
use crate::bind::quantity::TilePart;
use crate::bind::{Kind, LightPart, Quantity, Slot, Source as Bound};
use crate::culling::Plan;
use crate::scene::{Emission, PointLight};
use landfall_exec::harness::fragments::FragmentShader;
use landfall_ir::analysis::hazards::falloff::{LightArray, Numbers, Terms, terms};
use landfall_ir::analysis::roles;
use landfall_ir::analysis::roles::{LightBinding, Role};
use landfall_layout::source::Source;
use landfall_layout::{BlockLayout, Options, Stage};

/// Farther than any fragment may be from a light.
const FAR: f64 = 1e19;

/// A light that a plan leaves out.
struct SkippedLight<'w> {
    kind: Kind,
    emission: &'w Emission,
    lamp: Option<&'w PointLight>,
    /// The distance of the nearest fragment that is lit without it.
    near: f64,
}

impl Renderer {
    /// Returns whether every light that a plan leaves out at a fragment is shown to add exactly zero
    /// there; false where nothing is known. `source` and `options` are those of the shader.
    pub fn proves_plan(
        &self,
        source: &Source,
        options: &Options,
        work: &Work<'_>,
        plan: &Plan,
    ) -> bool {
        let ambient = work.upload.lights.ambient.filter(|a| a.color * a.intensity != DVec3::ZERO);
        let kept = ambient.is_none() || plan.draws.iter().all(|draw| draw.lights.ambient);
        // A shader that reads lists, for a plan without lists.
        let unlisted = self.reads_tile_lists() && plan.tiles.is_none();
        if !plan.grids.is_empty() || !kept || unlisted {
            return false;
        }
        let lights = &work.upload.lights;
        let slots = [
            (Kind::Directional, lights.directional.len()),
            (Kind::Point, lights.point.len()),
            (Kind::Spot, lights.spot.len()),
        ];
        // A slot without a light is lit by zeros, which nothing is known about.
        let counted = |kind| self.counts(kind) || self.slots(kind) == usize::MAX;
        if slots.iter().any(|(kind, lit)| !counted(*kind) && self.slots(*kind) > *lit) {
            return false;
        }
        let left_out = left_out(work, plan);
        if left_out.is_empty() {
            return true;
        }
        let Some(position) = self.position() else { return false };
        let single = self.map.members.iter().any(|member| {
            let digit = member.path.split('[').skip(1).any(|rest| !rest.starts_with(']'));
            digit
                || matches!(
                    member.source.quantity(),
                    Some(Quantity::Light { slot: Slot::One(_), .. })
                )
        });
        if single || !left_out.iter().all(|light| self.map.has(light.kind)) {
            return false;
        }
        let source = Source { stage: source.stage.or(Some(Stage::Fragment)), ..source.clone() };
        let blocks = blocks(&self.shader);
        let lights = roles::lights_in_blocks(&blocks);
        let Ok(terms) = terms(&source, options, &lights, position) else { return false };
        Kind::ALL.into_iter().all(|kind| {
            let mut of_kind = left_out.iter().filter(|light| light.kind == kind).peekable();
            of_kind.peek().is_none() || self.vanish(&terms, &lights, kind, of_kind)
        })
    }

    /// Returns the last name of the input that holds the fragment's position.
    fn position(&self) -> Option<&str> {
        let is_position = |source: &Bound| *source == Bound::scene(Quantity::Position);
        let mut inputs = self.map.inputs.iter().filter(|input| is_position(&input.source));
        let name = &inputs.next()?.name;
        Some(name.rsplit('.').next().unwrap_or(name))
    }

    /// Whether lights of a kind add exactly zero, by every array that holds such lights.
    fn vanish<'l>(
        &self,
        terms: &Terms,
        lights: &[LightBinding<'_>],
        kind: Kind,
        left_out: impl Iterator<Item = &'l SkippedLight<'l>> + Clone,
    ) -> bool {
        // The arrays whose members hold such a light.
        let holds = |held: &LightBinding<'_>| {
            held.roles.parts.iter().any(|part| {
                let path = held.full_path(part);
                matches!(self.part_at(&held.block.name, &path), Some((of, _)) if of == kind)
            })
        };
        let [counts, lists] = self.counted_by(lights, kind, &holds);
        let mut arrays = lights.iter().enumerate().filter(|(_, held)| holds(held)).peekable();
        let any = arrays.peek().is_some();
        any && arrays.all(|(index, held)| {
            // What the members of the array hold of a light, by role.
            let parts = held.roles.parts.iter().map(|part| {
                let own = self.part_at(&held.block.name, &held.full_path(part));
                (part.role, own.filter(|(of, _)| *of == kind).map(|(_, own)| own))
            });
            let parts: Vec<(Role, Option<LightPart>)> = parts.collect();
            let part = |role| parts.iter().find(|(of, _)| *of == role).and_then(|(_, part)| *part);
            let placed = held.roles.part(Role::Position).is_none()
                || part(Role::Position) == Some(LightPart::Position);
            let array = LightArray { index, counts: &counts, lists: &lists };
            let mut terms = terms.of_array(array);
            placed
                && left_out.clone().all(|light| {
                    let of = |role| light.number(part(role)?);
                    terms.adds_zero(&Numbers { of: &of, distance: [light.near, FAR] })
                })
        })
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

impl SkippedLight<'_> {
    /// Returns the least and greatest component of a property; `None` if it is not followed.
    fn number(&self, part: LightPart) -> Option<[f64; 2]> {
        let ends = |color: DVec3| Some([color.min_element(), color.max_element()]);
        let one = |number: f64| {
            // As uploaded.
            let number = f64::from(number as f32);
            Some([number; 2])
        };
        let Emission { ambient, diffuse, specular, color, intensity } = *self.emission;
        let fading = self.lamp.map(|lamp| lamp.attenuation);
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

/// Returns the lights that some draw leaves out.
fn left_out<'w>(work: &Work<'w>, plan: &Plan) -> Vec<SkippedLight<'w>> {
    let position =
        |at: &u32| DVec3::from(work.frame.fragments[*at as usize].position.map(f64::from));
    let draws = plan.draws.iter().filter(|draw| !draw.fragments.is_empty());
    let draws: Vec<_> = draws
        .map(|draw| {
            let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let places = draw.fragments.iter().map(position);
            let bounds = places.fold(empty, |(low, high), at| (low.min(at), high.max(at)));
            (draw, bounds)
        })
        .collect();
    let lights = &work.upload.lights;
    let mut all: Vec<SkippedLight<'w>> = Vec::new();
    for kind in Kind::ALL {
        let count = match kind {
            Kind::Directional => lights.directional.len(),
            Kind::Point => lights.point.len(),
            Kind::Spot => lights.spot.len(),
        };
        for number in 0..count {
            let (emission, lamp) = match kind {
                Kind::Directional => (&lights.directional[number].emission, None),
                Kind::Point => (&lights.point[number].emission, Some(&lights.point[number])),
                Kind::Spot => (&lights.spot[number].lamp.emission, Some(&lights.spot[number].lamp)),
            };
            let enough = lamp.and_then(|lamp| lamp.attenuation.range).unwrap_or(f64::INFINITY);
            // Past the rounding of every operation in `f32`.
            let enough = enough * (1.0 + 1.0 / (1 << 18) as f64);
            let mut near: Option<f64> = None;
            for (draw, (low, high)) in &draws {
                let set = match kind {
                    Kind::Directional => &draw.lights.directional,
                    Kind::Point => &draw.lights.point,
                    Kind::Spot => &draw.lights.spot,
                };
                if set.binary_search(&(number as u32)).is_ok() {
                    continue;
                }
                let apart = match lamp.map(|lamp| lamp.position) {
                    None => 0.0,
                    Some(place) => {
                        let outside = (*low - place).max(place - *high).max(DVec3::ZERO).length();
                        // The box first, each fragment only where it does not suffice.
                        match outside >= enough {
                            true => outside,
                            false => {
                                let each = draw.fragments.iter().map(position);
                                each.map(|at| at.distance(place)).fold(f64::INFINITY, f64::min)
                            }
                        }
                    }
                };
                near = Some(near.map_or(apart, |known| known.min(apart)));
            }
            if let Some(near) = near {
                all.push(SkippedLight { kind, emission, lamp, near });
            }
        }
    }
    all
}
