//! The members of a map whose names leave their sign or unit open, and the possible readings.

use super::probe;
use super::probe::{Probe, ProbedLight};
use crate::bind::quantity::{Kind, LightPart, Quantity, Slot};
use crate::bind::{BindingMap, Source};
use landfall_layout::named;

named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Topic {
        /// The sign of the direction of a directional light.
        Direction = "sign",
        /// The sign of a spotlight's direction, the units of its cone, and which angle is the inner
        /// one.
        Cone = "sign and unit",
        /// The range, its square or their inverses.
        Range = "form of the range",
        /// The order of the attenuation coefficients.
        Attenuation = "order of the coefficients",
        /// Whether the colour is already multiplied by the intensity.
        Strength = "product with the intensity",
    }
}

impl Topic {
    /// Returns the part of the brightest light from which a fragment must be lit.
    pub(super) fn lit_from(self) -> f64 {
        match self {
            // Shading in bands has none at grazing angles.
            Topic::Direction => 0.7,
            Topic::Cone | Topic::Range | Topic::Attenuation | Topic::Strength => 0.25,
        }
    }

    /// Whether a shader is refused if no reading agrees: a wrong one lights the wrong side.
    pub(super) fn is_refused(self) -> bool {
        match self {
            Topic::Direction | Topic::Cone => true,
            Topic::Range | Topic::Attenuation | Topic::Strength => false,
        }
    }
}

/// The fragments at which equal light of the reference must be equal in the shader too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ties {
    Ignored,
    /// The fragments that the reference leaves dark.
    Dark,
    All,
}

/// Members to be bound together.
#[derive(Debug)]
pub(super) struct BindingGroup {
    pub topic: Topic,
    /// The indices of the members in the map.
    pub members: Vec<usize>,
    /// The possible sources of the members; the first are those by their names.
    pub readings: Vec<GroupReading>,
    pub probes: Vec<Probe>,
    pub ties: Ties,
}

impl BindingGroup {
    /// Returns the number of fragments that each reading is run on.
    pub fn probes(&self) -> usize {
        self.probes.iter().map(|probe| probe.fragments.len()).sum()
    }
}

/// A source for each member of a group.
#[derive(Clone, Debug)]
pub(super) struct GroupReading {
    pub sources: Vec<Source>,
    /// Readings of a later tier count only where none of an earlier one agrees.
    pub tier: u8,
}

/// Returns the groups of members of lights whose sign or unit is open. Members whose keys `given`
/// accepts keep their sources.
pub(super) fn binding_groups(map: &BindingMap, given: &dyn Fn(&str) -> bool) -> Vec<BindingGroup> {
    // One group for each light, or array of lights, and topic.
    let mut lights: Vec<(Kind, Slot)> = Vec::new();
    for member in &map.members {
        if let Some(Quantity::Light { kind, slot, .. }) = member.source.quantity() {
            if !lights.contains(&(kind, slot)) {
                lights.push((kind, slot));
            }
        }
    }
    // Directions and cones first: the other probes rely on what is lit at all.
    let topics = [Topic::Direction, Topic::Cone, Topic::Attenuation, Topic::Strength, Topic::Range];
    let each = topics.into_iter().flat_map(|topic| lights.iter().map(move |light| (topic, *light)));
    let mut questions: Vec<BindingGroup> = each
        .filter_map(|(topic, (kind, slot))| {
            let group = LightMembers { map, kind, slot };
            match topic {
                Topic::Direction => group.direction(),
                Topic::Cone => group.cone(),
                Topic::Range => group.range(),
                Topic::Attenuation => group.attenuation(),
                Topic::Strength => group.strength(),
            }
        })
        .collect();
    // A source that the user states removes the readings with another.
    for question in &mut questions {
        let kept: Vec<(usize, Source)> = question
            .members
            .iter()
            .enumerate()
            .map(|(nth, &at)| (nth, &map.members[at]))
            .filter(|(_, member)| {
                given(&member.key()) || given(&format!("{}.{}", member.name, member.path))
            })
            .map(|(nth, member)| (nth, member.source.clone()))
            .collect();
        question
            .readings
            .retain(|reading| kept.iter().all(|(nth, source)| reading.sources[*nth] == *source));
    }
    // One reading is no question.
    questions.retain(|question| question.readings.len() > 1);
    questions
}

struct LightMembers<'m> {
    map: &'m BindingMap,
    kind: Kind,
    slot: Slot,
}

const INNER: [LightPart; 3] =
    [LightPart::InnerCos, LightPart::InnerRadians, LightPart::InnerDegrees];
const OUTER: [LightPart; 3] =
    [LightPart::OuterCos, LightPart::OuterRadians, LightPart::OuterDegrees];

impl LightMembers<'_> {
    /// Returns the first member with one of those properties: its index, property and source.
    fn find(&self, parts: &[LightPart]) -> Option<(usize, LightPart, &Source)> {
        let members = self.map.members.iter().enumerate();
        members.into_iter().find_map(|(at, member)| match member.source.quantity() {
            Some(Quantity::Light { kind, slot, part })
                if kind == self.kind && slot == self.slot && parts.contains(&part) =>
            {
                Some((at, part, &member.source))
            }
            _ => None,
        })
    }

    fn source(&self, part: LightPart) -> Source {
        let LightMembers { kind, slot, .. } = *self;
        Source::scene(Quantity::Light { kind, slot, part })
    }

    fn probed(&self) -> ProbedLight {
        ProbedLight {
            kind: self.kind,
            number: if let Slot::One(number) = self.slot { number } else { 0 },
        }
    }

    fn direction(&self) -> Option<BindingGroup> {
        if self.kind != Kind::Directional {
            return None;
        }
        let (at, _, own) = self.find(&[LightPart::Direction])?;
        let reading = |source| GroupReading { sources: vec![source], tier: 0 };
        Some(BindingGroup {
            topic: Topic::Direction,
            members: vec![at],
            readings: vec![reading(own.clone()), reading(opposite(own))],
            probes: vec![probe::facing(self.probed())],
            ties: Ties::Ignored,
        })
    }

    fn cone(&self) -> Option<BindingGroup> {
        if self.kind != Kind::Spot {
            return None;
        }
        let direction = self.find(&[LightPart::Direction]);
        let inner = self.find(&INNER);
        let outer = self.find(&OUTER);
        let found = [direction, inner, outer];
        let members: Vec<usize> = found.iter().flatten().map(|(at, ..)| *at).collect();
        let own = |cone: &Option<(usize, LightPart, &Source)>| {
            let (_, part, _) = (*cone)?;
            (0..3).find(|&unit| INNER[unit] == part || OUTER[unit] == part)
        };
        // The unit of the names first, then the others: ties go to the names.
        let named = own(&inner).or(own(&outer));
        let units: Vec<usize> = match named {
            Some(first) => {
                std::iter::once(first).chain((0..3).filter(|&unit| unit != first)).collect()
            }
            None => vec![0],
        };
        let signs: Vec<Option<Source>> = match direction {
            Some((.., own)) => vec![Some(own.clone()), Some(opposite(own))],
            None => vec![None],
        };
        let swaps = if inner.is_some() && outer.is_some() { 2 } else { 1 };
        let mut readings = Vec::new();
        // The second tier exchanges inner and outer angle.
        for tier in 0..swaps {
            for sign in &signs {
                for &unit in &units {
                    let (first, second) = match tier {
                        0 => (INNER[unit], OUTER[unit]),
                        _ => (OUTER[unit], INNER[unit]),
                    };
                    let mut sources: Vec<Source> = sign.iter().cloned().collect();
                    sources.extend(inner.iter().map(|_| self.source(first)));
                    sources.extend(outer.iter().map(|_| self.source(second)));
                    readings.push(GroupReading { sources, tier });
                }
            }
        }
        let probes = vec![probe::cone(self.probed(), inner.iter().chain(&outer).count())];
        let ties = Ties::Dark;
        (!members.is_empty()).then_some(BindingGroup {
            topic: Topic::Cone,
            members,
            readings,
            probes,
            ties,
        })
    }

    fn range(&self) -> Option<BindingGroup> {
        use LightPart::{InverseRange, InverseRangeSquared, Range, RangeSquared};
        let all = [Range, RangeSquared, InverseRange, InverseRangeSquared];
        let (at, own, _) = self.find(&all)?;
        let parts = std::iter::once(own).chain(all.into_iter().filter(|part| *part != own));
        let reading = |part| GroupReading { sources: vec![self.source(part)], tier: 0 };
        Some(BindingGroup {
            topic: Topic::Range,
            members: vec![at],
            readings: parts.map(reading).collect(),
            probes: vec![probe::range(self.probed())],
            ties: Ties::Dark,
        })
    }

    fn attenuation(&self) -> Option<BindingGroup> {
        let all = [LightPart::Constant, LightPart::Linear, LightPart::Quadratic];
        let found: Vec<(usize, LightPart)> = all
            .iter()
            .filter_map(|part| self.find(&[*part]))
            .map(|(at, part, _)| (at, part))
            .collect();
        // All orders of the coefficients that the shader has.
        let orders: &[&[usize]] = match found.len() {
            2 => &[&[0, 1], &[1, 0]],
            3 => &[&[0, 1, 2], &[0, 2, 1], &[1, 0, 2], &[1, 2, 0], &[2, 0, 1], &[2, 1, 0]],
            _ => return None,
        };
        let reading = |(nth, order): (usize, &&[usize])| GroupReading {
            sources: order.iter().map(|&at| self.source(found[at].1)).collect(),
            // The order by the names is tried alone first.
            tier: u8::from(nth > 0),
        };
        Some(BindingGroup {
            topic: Topic::Attenuation,
            members: found.iter().map(|(at, _)| *at).collect(),
            readings: orders.iter().enumerate().map(reading).collect(),
            probes: probe::attenuation(self.probed()),
            ties: Ties::All,
        })
    }

    fn strength(&self) -> Option<BindingGroup> {
        // Is the colour already multiplied by the intensity? Without a single colour, is the
        // intensity 1?
        let (intensity, _, factor) = self.find(&[LightPart::Intensity])?;
        let (members, readings) = match self.find(&[LightPart::Color]) {
            Some((color, _, own)) => {
                let radiance = self.source(LightPart::Radiance);
                (vec![color], [vec![own.clone()], vec![radiance]])
            }
            None => {
                self.find(&[LightPart::Diffuse])?;
                (vec![intensity], [vec![factor.clone()], vec![Source::Number(vec![1.0])]])
            }
        };
        let readings = readings.map(|sources| GroupReading { sources, tier: 0 });
        Some(BindingGroup {
            topic: Topic::Strength,
            members,
            readings: readings.to_vec(),
            probes: probe::strength(self.probed()),
            ties: Ties::All,
        })
    }
}

fn opposite(source: &Source) -> Source {
    match source {
        Source::Scene { quantity, negated } => {
            Source::Scene { quantity: *quantity, negated: !negated }
        }
        other => other.clone(),
    }
}
