//! Reads the lights of a scene: emission, attenuation and cones.

use glam::DVec3;
use landfall_layout::diagnostic::Code;

use super::walk::{Object, SceneWalk, ValueAt, round_to_four_digits};
use crate::scene::{
    Ambient, Attenuation, Cone, DirectionalLight, Emission, Lights, PointLight, SpotLight,
};

/// The attenuations that tutorials copy from the Ogre wiki: distance, constant, linear, quadratic.
pub(in crate::scene) const ATTENUATIONS: [[f64; 4]; 12] = [
    [7.0, 1.0, 0.7, 1.8],
    [13.0, 1.0, 0.35, 0.44],
    [20.0, 1.0, 0.22, 0.20],
    [32.0, 1.0, 0.14, 0.07],
    [50.0, 1.0, 0.09, 0.032],
    [65.0, 1.0, 0.07, 0.017],
    [100.0, 1.0, 0.045, 0.0075],
    [160.0, 1.0, 0.027, 0.0028],
    [200.0, 1.0, 0.022, 0.0019],
    [325.0, 1.0, 0.014, 0.0007],
    [600.0, 1.0, 0.007, 0.0002],
    [3250.0, 1.0, 0.0014, 0.000_007],
];

/// The emission members of all lights but the ambient one.
const EMISSION: &[&str] = &["color", "intensity", "ambient", "diffuse", "specular"];

const NONE: Attenuation = Attenuation { constant: 1.0, linear: 0.0, quadratic: 0.0, range: None };

pub(super) fn read(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Lights> {
    let object = walk.object(at, &["ambient", "directional", "point", "spot"])?;
    let ambient = object.optional("ambient", |at| ambient(walk, at));
    let directional = all(walk, &object, "directional", directional);
    let point = all(walk, &object, "point", |walk, at| {
        let point = walk.object(at, &[EMISSION, POINT].concat())?;
        self::point(walk, &point)
    });
    let spot = all(walk, &object, "spot", spot);
    Some(Lights { ambient: ambient?, directional: directional?, point: point?, spot: spot? })
}

/// Reads all lights of a list; `None` if one is invalid.
fn all<T>(
    walk: &mut SceneWalk,
    object: &Object<'_>,
    key: &str,
    one: impl Fn(&mut SceneWalk, &ValueAt<'_>) -> Option<T>,
) -> Option<Vec<T>> {
    let Some(at) = object.get(key) else { return Some(Vec::new()) };
    let lights: Vec<Option<T>> = walk.list(&at)?.iter().map(|at| one(walk, at)).collect();
    lights.into_iter().collect()
}

fn ambient(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Ambient> {
    let object = walk.object(at, &["color", "intensity"])?;
    let color = walk.needed(&object, "color").and_then(|at| walk.color(&at));
    let intensity = intensity(walk, &object);
    Some(Ambient { color: color?, intensity: intensity? })
}

fn intensity(walk: &mut SceneWalk, object: &Object<'_>) -> Option<f64> {
    object.or("intensity", 1.0, |at| {
        walk.not_negative(at, Code::NegativeColor, "an intensity is 0 or more")
    })
}

fn directional(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<DirectionalLight> {
    let object = walk.object(at, &[EMISSION, &["direction", "normalize"]].concat())?;
    let direction = direction(walk, &object);
    let emission = emission(walk, &object);
    Some(DirectionalLight { direction: direction?, emission: emission? })
}

/// Reads a direction; normalised, unless the light has `"normalize": false`.
fn direction(walk: &mut SceneWalk, object: &Object<'_>) -> Option<DVec3> {
    let at = walk.needed(object, "direction")?;
    match object.or("normalize", true, |at| walk.boolean(at))? {
        true => walk.direction(&at),
        false => walk.some_vector(&at),
    }
}

fn emission(walk: &mut SceneWalk, object: &Object<'_>) -> Option<Emission> {
    let mut given = |key| object.optional(key, |at| walk.color(at));
    let [color, ambient, diffuse, specular] =
        [given("color"), given("ambient"), given("diffuse"), given("specular")];
    let intensity = intensity(walk, object);
    let (color, ambient, diffuse, specular) = (color?, ambient?, diffuse?, specular?);
    let intensity = intensity?;
    let Some(first) = color.or(diffuse) else {
        walk.error(Code::MissingMember, &object.at, "has no emission").help =
            Some("add `color` and `intensity`, or `ambient`, `diffuse` and `specular`".to_string());
        return None;
    };
    if let (None, Some(at)) = (color, object.get("intensity")) {
        walk.error(Code::WrongValue, &at, "has no effect without `color`, which it multiplies")
            .help = Some("add `color`, or remove `intensity`".to_string());
        return None;
    }
    let sent = color.map_or(first, |color| color * intensity);
    if !sent.as_vec3().is_finite() {
        let what = "is brighter than any `f32`: its colour times its intensity is above 3.4e38";
        walk.error(Code::ValueOutOfRange, &object.at, what);
        return None;
    }
    let diffuse = diffuse.unwrap_or(sent);
    Some(Emission {
        ambient: ambient.unwrap_or(DVec3::ZERO),
        diffuse,
        specular: specular.unwrap_or(if color.is_some() { sent } else { diffuse }),
        color: first,
        intensity,
    })
}

/// The members of a point light besides its emission.
const POINT: &[&str] = &["position", "attenuation", "range"];

fn point(walk: &mut SceneWalk, object: &Object<'_>) -> Option<PointLight> {
    let position = walk.needed(object, "position").and_then(|at| walk.vector(&at));
    let emission = emission(walk, object);
    let attenuation = object.or("attenuation", NONE, |at| attenuation(walk, at));
    let range = object.optional("range", |at| walk.positive(at));
    let attenuation = Attenuation { range: range?, ..attenuation? };
    Some(PointLight { position: position?, emission: emission?, attenuation })
}

fn attenuation(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Attenuation> {
    let object = walk.object(at, &["constant", "linear", "quadratic", "distance"])?;
    if let Some(distance) = object.get("distance") {
        if object.keys().count() > 1 {
            let what = "sets all three coefficients, but some are given as well";
            walk.error(Code::GivenTwice, &distance, what).help =
                Some("keep either `distance` or the coefficients".to_string());
            return None;
        }
        return by_distance(walk, &distance);
    }
    let why = "with a negative coefficient the attenuation divides by zero at some distance";
    let mut coefficient = |key, default| {
        object.or(key, default, |at| walk.not_negative(at, Code::NegativeAttenuation, why))
    };
    let constant = coefficient("constant", 1.0);
    let linear = coefficient("linear", 0.0);
    let quadratic = coefficient("quadratic", 0.0);
    let found =
        Attenuation { constant: constant?, linear: linear?, quadratic: quadratic?, range: None };
    // As uploaded: what rounds to zero divides by zero.
    let none = |number: f64| number as f32 == 0.0;
    if none(found.constant) && none(found.linear) && none(found.quadratic) {
        walk.error(Code::ZeroAttenuation, at, "divides by zero at every distance").help =
            Some("write `\"constant\": 1` for a light without attenuation".to_string());
        return None;
    }
    if let Some(constant) = object.get("constant").filter(|_| object.keys().count() == 1) {
        warn_single_coefficient(walk, &constant, found.constant);
    }
    Some(found)
}

/// Warns about a single coefficient, where three were probably meant.
fn warn_single_coefficient(walk: &mut SceneWalk, at: &ValueAt<'_>, constant: f64) {
    if constant == 1.0 {
        return;
    }
    let what = format!(
        "is {constant} without other coefficients: at every distance the light is {} times as bright",
        round_to_four_digits(1.0 / constant)
    );
    walk.warning(Code::LoneConstant, at, what).help =
        Some("add `linear` and `quadratic`; to only brighten or dim, use `intensity`".to_string());
}

/// Returns a row of the published table, which defines nothing between its rows.
pub(super) fn by_distance(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Attenuation> {
    let distance = walk.number(at)?;
    if let Some([_, constant, linear, quadratic]) =
        ATTENUATIONS.iter().find(|row| row[0] == distance)
    {
        let (constant, linear, quadratic) = (*constant, *linear, *quadratic);
        return Some(Attenuation { constant, linear, quadratic, range: None });
    }
    let rows = ATTENUATIONS.map(|row| row[0].to_string()).join(", ");
    let what = format!("is {distance}, for which the table of attenuations has no row");
    walk.error(Code::WrongValue, at, what).help =
        Some(format!("its rows are {rows}; or give `constant`, `linear` and `quadratic`"));
    None
}

fn spot(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<SpotLight> {
    let object =
        walk.object(at, &[EMISSION, POINT, &["direction", "normalize", "cone"]].concat())?;
    let point = point(walk, &object);
    let direction = direction(walk, &object);
    let cone = walk.needed(&object, "cone").and_then(|at| cone(walk, &at));
    Some(SpotLight { point: point?, direction: direction?, cone: cone? })
}

enum ConeNotation {
    Degrees,
    Cosines,
    Half,
}

fn cone(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Cone> {
    let forms = [
        (ConeNotation::Degrees, &["inner_degrees", "outer_degrees"][..]),
        (ConeNotation::Cosines, &["inner_cos", "outer_cos"]),
        (ConeNotation::Half, &["half_degrees"]),
    ];
    let object =
        walk.object(at, &forms.iter().flat_map(|form| form.1).copied().collect::<Vec<_>>())?;
    let is_given = |keys: &[&str]| keys.iter().any(|key| object.get(key).is_some());
    let given: Vec<_> = forms.iter().filter(|(_, keys)| is_given(keys)).collect();
    let [(form, keys)] = given[..] else {
        let what = match (given.is_empty(), object.keys().next()) {
            (false, _) => "has more than one kind of angle",
            (true, None) => "has no angle",
            // Another member is unknown, which was reported.
            (true, Some(_)) => return None,
        };
        walk.error(Code::WrongCone, at, what).help = Some(
            "give `inner_degrees` and `outer_degrees`, or `inner_cos` and `outer_cos`, \
             or `half_degrees` for a hard edge"
                .to_string(),
        );
        return None;
    };
    let found: Vec<Option<ValueAt<'_>>> =
        keys.iter().map(|key| walk.needed(&object, key)).collect();
    let found: Vec<ValueAt<'_>> = found.into_iter().collect::<Option<_>>()?;
    match form {
        ConeNotation::Degrees => degrees(walk, at, &found[0], &found[1]),
        ConeNotation::Cosines => cosines(walk, at, &found[0], &found[1]),
        ConeNotation::Half => half(walk, &found[0]),
    }
}

/// Reads half of a cone's opening, at most half a turn.
fn angle(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<f64> {
    let degrees = walk.number(at)?;
    if (0.0..=180.0).contains(&degrees) {
        return Some(degrees);
    }
    let what = format!("is {degrees}: half of a cone's opening is from 0 to 180 degrees");
    walk.error(Code::ValueOutOfRange, at, what);
    None
}

fn degrees(
    walk: &mut SceneWalk,
    at: &ValueAt<'_>,
    inner_at: &ValueAt<'_>,
    outer_at: &ValueAt<'_>,
) -> Option<Cone> {
    let (inner, outer) = (angle(walk, inner_at), angle(walk, outer_at));
    let (inner, outer) = (inner?, outer?);
    if inner > outer {
        let what = format!("has its angles swapped: inside {inner} degrees, outside {outer}");
        let mut help = format!("write `\"inner_degrees\": {outer}, \"outer_degrees\": {inner}`");
        if inner <= 1.0 {
            help = format!(
                "if these are cosines, write `\"inner_cos\": {inner}, \"outer_cos\": {outer}`"
            );
        }
        walk.error(Code::SwappedCone, at, what).help = Some(help);
        return None;
    }
    wide_enough(walk, outer_at, outer)?;
    if inner == outer {
        walk.warning(
            Code::HardCone,
            at,
            "has no ramp: a soft cone divides by its width, which is 0",
        )
        .help = Some(format!("write `\"half_degrees\": {outer}` if a hard edge is meant"));
    } else if outer < 1.0 {
        narrow(walk, outer_at, outer).help = Some(format!(
            "if these are radians, write `\"inner_degrees\": {}, \"outer_degrees\": {}`",
            round_to_four_digits(inner.to_degrees()),
            round_to_four_digits(outer.to_degrees()),
        ));
    }
    Some(Cone { inner_cos: cos(inner), outer_cos: cos(outer), degrees: Some([inner, outer]) })
}

fn half(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Cone> {
    let half = angle(walk, at)?;
    wide_enough(walk, at, half)?;
    if half < 1.0 {
        let degrees = round_to_four_digits(half.acos().to_degrees());
        narrow(walk, at, half).help =
            Some(format!("if that is a cosine, write `\"half_degrees\": {degrees}`"));
    }
    Some(Cone { inner_cos: cos(half), outer_cos: cos(half), degrees: Some([half, half]) })
}

fn wide_enough(walk: &mut SceneWalk, at: &ValueAt<'_>, outer: f64) -> Option<()> {
    if outer > 0.0 {
        return Some(());
    }
    walk.error(
        Code::EmptyCone,
        at,
        "is 0: in a cone of zero width rounding alone decides what is lit",
    );
    None
}

fn narrow<'w>(
    walk: &'w mut SceneWalk,
    at: &ValueAt<'_>,
    outer: f64,
) -> &'w mut landfall_layout::Diagnostic {
    let what =
        format!("is {outer} degrees: below 1 degree cosines in `f32` cannot tell a cone's edges");
    walk.warning(Code::NarrowCone, at, what)
}

fn cosines(
    walk: &mut SceneWalk,
    at: &ValueAt<'_>,
    inner_at: &ValueAt<'_>,
    outer_at: &ValueAt<'_>,
) -> Option<Cone> {
    let (inner, outer) = (cosine(walk, inner_at), cosine(walk, outer_at));
    let (inner, outer) = (inner?, outer?);
    if inner < outer {
        let what = format!(
            "has its cosines swapped: the inner one, {inner}, is of a wider angle than the outer \
             one, {outer}"
        );
        walk.error(Code::SwappedCone, at, what).help = Some(format!(
            "write `\"inner_cos\": {outer}, \"outer_cos\": {inner}`; if these are radians, write \
             `\"inner_degrees\": {}, \"outer_degrees\": {}`",
            round_to_four_digits(inner.to_degrees()),
            round_to_four_digits(outer.to_degrees()),
        ));
        return None;
    }
    // As uploaded: such a cone has no width in `f32`.
    if outer as f32 >= 1.0 {
        walk.error(
            Code::EmptyCone,
            outer_at,
            "is 1: in a cone of zero width rounding alone decides what is lit",
        );
        return None;
    }
    if inner == outer {
        walk.warning(
            Code::HardCone,
            at,
            "has no ramp: a soft cone divides by its width, which is 0",
        )
        .help = Some("give the angle as `half_degrees` if a hard edge is meant".to_string());
    }
    Some(Cone { inner_cos: inner, outer_cos: outer, degrees: None })
}

fn cosine(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<f64> {
    let cosine = walk.number(at)?;
    if (-1.0..=1.0).contains(&cosine) {
        return Some(cosine);
    }
    let found = walk.error(Code::WrongUnit, at, format!("is {cosine}: a cosine is from -1 to 1"));
    if (1.0..=180.0).contains(&cosine) {
        let member = if at.path.ends_with("inner_cos") { "inner" } else { "outer" };
        found.help = Some(format!(
            "if that is an angle, write `\"{member}_degrees\": {cosine}`, or its cosine, {}",
            round_to_four_digits(cos(cosine))
        ));
    }
    None
}

/// Returns the cosine of an angle in degrees, exact where it is 1, 0 and -1.
fn cos(degrees: f64) -> f64 {
    if degrees <= 45.0 {
        degrees.to_radians().cos()
    } else if degrees <= 135.0 {
        // The sine is exact at 0, where the cosine of 90 degrees in radians is not.
        (90.0 - degrees).to_radians().sin()
    } else {
        -(180.0 - degrees).to_radians().cos()
    }
}
