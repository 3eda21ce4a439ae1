//! The signs and units of a light's members, decided by running the shader.
//!
//! A name tells neither whether a direction points towards the light, nor whether a cone is in
//! degrees, radians or cosines. Each possible reading of such members is a hypothesis: the shader
//! is run under all of them on a few fragments of a light of known values, and the reading is
//! taken whose picture has the order of the `f64` reference: lit where that is lit, dark where
//! that is dark, equal where that is equal. Orders are compared, not values, since tone curves and
//! other reflection models keep them.

mod comparison;
mod probe;
mod reading;

use landfall_exec::harness::fragments::FragmentShader;
use landfall_interp::Cpu;

use super::{BindError, BindingMap, BlockWriter, Kind, Member, Quantity, Source};
use comparison::{ReadingComparison, compare};
use reading::{BindingGroup, GroupReading, binding_groups};

pub use reading::Topic;

/// A choice between the possible sources of some members.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The subject of the choice.
    pub topic: Topic,
    /// The keys of the members, and the sources that they got.
    pub members: Vec<(String, String)>,
    pub readings: usize,
    /// The number of fragments that each was run on.
    pub probes: usize,
    /// The reason for the choice.
    pub outcome: Outcome,
}

/// The reason for a choice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Only this reading agrees with the reference.
    Agrees,
    /// All readings give the same light, so that the names decided.
    Same,
    /// No reading agrees, since the shader computes something else; the names decided.
    Named,
    /// The interpreter does not run the shader; the names decided.
    NotRun(String),
}

/// Returns the map with the signs and units that agree with the reference, as the interpreter `cpu`
/// finds. Members whose keys `given` accepts keep their sources.
///
/// # Errors
/// No reading of a direction or a cone agrees with the reference, or several do that differ.
pub fn decide(
    shader: &FragmentShader,
    mut map: BindingMap,
    given: &dyn Fn(&str) -> bool,
    cpu: &mut Cpu,
) -> Result<BindingMap, BindError> {
    // Each group is decided with the sources that those before it have got: the order of topics is
    // that of `reading::binding_groups`.
    for group in binding_groups(&map, given) {
        let decided = choose_reading(shader, &map, &group, cpu)?;
        if let (Some(reading), Outcome::Agrees) = (decided.0, &decided.1) {
            put(&mut map, &group, &group.readings[reading]);
        }
        let members = group.members.iter().map(|&at| &map.members[at]);
        let members = members.map(|member| (member.key(), member.source.to_string())).collect();
        map.decisions.push(Decision {
            topic: group.topic,
            members,
            readings: group.readings.len(),
            probes: group.probes(),
            outcome: decided.1,
        });
    }
    // Last, since it runs the shader with all signs and units settled.
    map.camera_at_origin = is_at_origin(shader, &map, cpu);
    Ok(map)
}

/// Whether highlights are where a camera at the origin sees them, though no member holds it.
fn is_at_origin(shader: &FragmentShader, map: &BindingMap, cpu: &mut Cpu) -> bool {
    let mut members = map.members.iter().map(|member| &member.source);
    if members.any(|source| source.quantity() == Some(Quantity::Camera)) {
        return false;
    }
    // A highlight is where light, surface and eye are in line, so it shows where the shader takes
    // the eye to be.
    let kinds = [Kind::Directional, Kind::Point];
    kinds.into_iter().find(|kind| map.has(*kind)).is_some_and(|kind| {
        let probe = probe::highlight(probe::ProbedLight { kind, number: 0 });
        let Ok(writer) = BlockWriter::new(shader, map) else { return false };
        let seen = probe::run(shader, &writer, std::slice::from_ref(&probe), cpu);
        seen.is_ok_and(|seen| comparison::is_ordered(&probe.reference, &seen))
    })
}

fn put(map: &mut BindingMap, group: &BindingGroup, reading: &GroupReading) {
    for (&at, source) in group.members.iter().zip(&reading.sources) {
        map.members[at].source = source.clone();
    }
}

/// Returns the index of the reading that agrees, if any, and the outcome.
fn choose_reading(
    shader: &FragmentShader,
    map: &BindingMap,
    group: &BindingGroup,
    cpu: &mut Cpu,
) -> Result<(Option<usize>, Outcome), BindError> {
    // Every reading is run on the same fragments of the same light.
    let mut seen = Vec::with_capacity(group.readings.len());
    for reading in &group.readings {
        let mut tried = map.clone();
        put(&mut tried, group, reading);
        let writer = BlockWriter::new(shader, &tried)?;
        match probe::run(shader, &writer, &group.probes, cpu) {
            Ok(light) => seen.push(light),
            Err(failure) => return Ok((None, Outcome::NotRun(failure.message))),
        }
    }
    let agreed = match compare(group, &seen) {
        ReadingComparison::One(reading) => return Ok((Some(reading), Outcome::Agrees)),
        ReadingComparison::Same => return Ok((None, Outcome::Same)),
        ReadingComparison::Several(agreed) => agreed,
        // Where a wrong reading does less harm, the names decide.
        ReadingComparison::None if !group.topic.is_refused() => {
            return Ok((None, Outcome::Named));
        }
        ReadingComparison::None => Vec::new(),
    };
    Err(undecided(map, group, &agreed))
}

fn undecided(map: &BindingMap, group: &BindingGroup, agreed: &[usize]) -> BindError {
    let keys: Vec<String> = group.members.iter().map(|&at| Member::key(&map.members[at])).collect();
    // Without any that agrees, those that differ in the sign or unit alone.
    let offered: Vec<usize> = match agreed {
        [] => (0..group.readings.len()).filter(|&at| group.readings[at].tier == 0).collect(),
        some => some.to_vec(),
    };
    let bind = |at: &usize| {
        let sources = keys.iter().zip(&group.readings[*at].sources);
        let pairs = sources.map(|(key, source)| match source {
            Source::Scene { .. } => format!("\"{key}\": \"{source}\""),
            Source::Number(_) | Source::Unknown => format!("\"{key}\": {source}"),
        });
        format!("{{{}}}", pairs.collect::<Vec<_>>().join(", "))
    };
    // Two are enough for a reader to see what to write.
    let offered = offered.iter().take(2).map(bind).collect();
    BindError::Undecided {
        keys,
        topic: group.topic,
        agreed: agreed.len(),
        readings: group.readings.len(),
        probes: group.probes(),
        offered,
    }
}
