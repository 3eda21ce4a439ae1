//! Classifies a structure by the roles of its members: whether it is a light, and of which kind.
//!
//! Finds the roles of members with [`role`]; used by [`roles`](super).

use std::sync::Arc;

use super::names::{is_about_something_else, is_light};
use super::{Kind, Part, Role, Roles, of_struct, role};
use crate::analysis::identifier::identifier_words;
use landfall_layout::shape::Type;
use landfall_layout::source::Span;

/// The members of a structure and of the structures in it, with their roles.
#[derive(Default)]
pub struct RoleEvidence {
    parts: Vec<Part>,
    others: Vec<String>,
    /// Structures in it that are lights themselves, and arrays of structures.
    lights: usize,
    arrays: usize,
    /// The number of roles of its own members, without those of nested structures.
    own: usize,
}

impl RoleEvidence {
    pub fn descend<'m>(
        &mut self,
        members: &mut dyn Iterator<Item = (&'m str, &'m Type, Span)>,
        parent: &str,
    ) {
        for (name, ty, span) in members {
            let path = format!("{parent}{name}");
            match ty.innermost() {
                Type::Struct(inner) => {
                    // An array of structures is no part of one light.
                    if !ty.dims().is_empty() {
                        self.arrays += 1;
                        continue;
                    }
                    // A light inside of a light, as in `struct Spot { PointLight pl; float cutoff;
                    // }`: its members belong to the outer one, if that has some of its own.
                    let is_light = parent.is_empty() && of_struct(inner).is_some();
                    self.lights += usize::from(is_light);
                    let mut below = inner.members.iter().map(|m| (&*m.name, &m.ty, m.span));
                    self.descend(&mut below, &format!("{path}."));
                }
                leaf => match role(name, leaf) {
                    Some(role) => {
                        self.own += usize::from(parent.is_empty());
                        let path = format!("{path}{}", "[]".repeat(ty.dims().len()));
                        self.parts.push(Part { path, role, ty: leaf.clone(), span });
                    }
                    None => self.others.push(path),
                },
            }
        }
    }

    /// Returns whether it is not a light but a structure around lights.
    pub fn holds_lights(&self) -> bool {
        self.arrays > 0 || self.lights > 1 || (self.lights == 1 && self.own == 0)
    }
}

/// The evidence for a light besides its members.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Evidence {
    Structure,
    Block,
    Members,
}

pub(super) fn classify(
    name: &str,
    found: RoleEvidence,
    span: Span,
    evidence: Evidence,
) -> Option<Roles> {
    let said = identifier_words(name);
    // `LightGrid`, `LightProbe`, `shadowLight` are about light without being one.
    if evidence != Evidence::Members && is_about_something_else(&said) {
        return None;
    }
    let RoleEvidence { mut parts, mut others, .. } = found;
    // Agreement first, since it may turn two members of one role into two roles.
    agree_on_cones(&mut parts);
    agree_on_quadratic(&mut parts);
    keep_first(&mut parts, &mut others);
    let mut roles = Roles { name: Arc::from(name), kind: Kind::Tagged, parts, others, span };
    let placed = roles.any(|r| matches!(r, Role::Position | Role::Direction));
    let shines = roles.any(Role::is_emission);
    let weakens = roles.any(|r| r.is_attenuation() || r.is_cone());
    let named = is_light(&said);
    let ambient = said.iter().any(|word| word == "ambient");
    // The less a name says, the more the members must: a structure called light needs a colour or
    // a place, any other a colour, a place and an attenuation. A block has many members by nature,
    // so it needs its name.
    let is_one = match evidence {
        Evidence::Structure => {
            (named && (shines || placed))
                || (ambient && shines && !placed)
                || (placed && shines && weakens)
        }
        Evidence::Block => shines && if placed { named } else { ambient },
        Evidence::Members => placed,
    };
    // A structure of scalars with nothing but an intensity could be anything.
    let colour = roles
        .parts
        .iter()
        .any(|p| p.role.is_emission() && matches!(p.ty, Type::Vector { rows: 3 | 4, .. }));
    if !is_one || !(colour || placed) {
        return None;
    }
    roles.kind = kind(&said, &roles);
    Some(roles)
}

fn kind(said: &[String], roles: &Roles) -> Kind {
    let says = |any: &[&str]| said.iter().any(|word| any.contains(&word.as_str()));
    let has = |role| roles.part(role).is_some();
    // Names first, the most specific before; then the members that only one kind has.
    if says(&["ambient"]) && !has(Role::Position) && !has(Role::Direction) {
        return Kind::Ambient;
    }
    if says(&["spot", "spotlight", "cone", "torch", "flashlight"]) {
        return Kind::Spot;
    }
    if says(&["dir", "direct", "directional", "sun", "sunlight", "parallel"]) {
        return Kind::Directional;
    }
    if says(&["point", "omni", "omnidirectional"]) {
        return Kind::Point;
    }
    // A number for the kind beside position and direction: all kinds share the structure.
    if has(Role::Kind) && has(Role::Position) && has(Role::Direction) {
        return Kind::Tagged;
    }
    if roles.any(Role::is_cone) {
        Kind::Spot
    } else if has(Role::Position) {
        Kind::Point
    } else if has(Role::Direction) {
        Kind::Directional
    } else if says(&["hemi", "hemisphere"]) {
        Kind::Ambient
    } else {
        Kind::Tagged
    }
}

/// One angle beside an inner or outer one is the other.
fn agree_on_cones(parts: &mut [Part]) {
    let has = |role| parts.iter().any(|p: &Part| p.role == role);
    let (inner, outer) = (has(Role::InnerCone), has(Role::OuterCone));
    for part in parts.iter_mut().filter(|p| p.role == Role::Cone) {
        if outer && !inner {
            part.role = Role::InnerCone;
        } else if inner && !outer {
            part.role = Role::OuterCone;
        }
    }
}

/// An exponent beside a constant and a linear coefficient is the quadratic one.
fn agree_on_quadratic(parts: &mut [Part]) {
    let has = |role| parts.iter().any(|p: &Part| p.role == role);
    let (linear, quadratic) = (has(Role::Linear), has(Role::Quadratic));
    // `exp`, `exponent` of attenuation, as in `constant, linear, exp`.
    if linear && !quadratic {
        if let Some(part) = parts.iter_mut().find(|p| p.role == Role::ConeExponent) {
            part.role = Role::Quadratic;
        }
    }
}

/// The first of several members of one role has it.
fn keep_first(parts: &mut Vec<Part>, others: &mut Vec<String>) {
    let mut kept: Vec<Part> = Vec::with_capacity(parts.len());
    for part in parts.drain(..) {
        if kept.iter().any(|known| known.role == part.role) {
            others.push(part.path);
        } else {
            kept.push(part);
        }
    }
    *parts = kept;
}
