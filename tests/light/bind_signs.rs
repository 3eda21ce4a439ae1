//! Signs and units of lights that names do not tell: small shaders of every spelling, each bound as
//! the reference lights the scene, or refused.

use std::path::Path;
use std::time::Duration;

use glam::DVec3;
use landfall_interp::Cpu;
use landfall_layout::Source;
use landfall_light::bind::{BindError, BlockWriter, OverflowPolicy, infer};
use landfall_light::culling::LightSet;
use landfall_light::picture::Transfer;
use landfall_light::picture::compare::{Compare, compare};
use landfall_light::reference::{AmbientTerm, ConeEdge, Family, Model, SpecularGate, Window};
use landfall_light::render::truth::truth;
use landfall_light::render::{Draw, RenderError, RenderOptions, Renderer, Work};
use landfall_light::scene::{
    Attenuation, Cone, DirectionalLight, Emission, Lights, PointLight, Space, SpotLight, read_file,
};
use landfall_light::{Frame, FrameOptions, Scene, Upload};
use snapbox::str;

use crate::support::command::golden;

/// A shader of one light.
#[derive(Clone, Debug)]
struct Case {
    name: String,
    kind: Kind,
    /// The members of the light besides its colours.
    members: String,
    /// Statements that declare `vec3 l`, towards the light, and `float k`, its factor.
    code: String,
    /// One colour and an intensity instead of three colours.
    single: Option<&'static str>,
    space: Space,
    model: Model,
    /// Whether no reading of the members is right.
    refused: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Sun,
    Lamp,
    Spot,
    HardSpot,
}

fn multi() -> Model {
    Model { specular_gate: SpecularGate::Facing, ..Model::new(Family::Multi) }
}

impl Case {
    fn new(name: &str, kind: Kind, members: &str, code: &str) -> Case {
        let (name, members, code) = (name.to_string(), members.to_string(), code.to_string());
        let (space, model) = (Space::World, multi());
        Case { name, kind, members, code, single: None, space, model, refused: false }
    }

    fn refused(self) -> Case {
        Case { refused: true, ..self }
    }

    fn in_view_space(self) -> Case {
        Case { space: Space::View, name: format!("{}, view space", self.name), ..self }
    }

    fn text(&self) -> String {
        let view = match self.space {
            Space::View => "normalize(-FragPos)",
            Space::World | Space::CameraRelative => "normalize(viewPos - FragPos)",
        };
        let camera = if self.space == Space::View { "" } else { "uniform vec3 viewPos;" };
        let (colours, sum) = match self.single {
            None => (
                "vec3 ambient; vec3 diffuse; vec3 specular;",
                "light.ambient * d + light.diffuse * nl * d + light.specular * s * g".to_string(),
            ),
            Some(strength) => {
                ("vec3 color; float intensity;", format!("{strength} * (nl * d + s * g)"))
            }
        };
        format!(
            "#version 330 core
in vec3 FragPos; in vec3 Normal; in vec2 TexCoords; out vec4 FragColor;
{camera}
struct Material {{ sampler2D diffuse; sampler2D specular; float shininess; }};
struct {} {{ {} {colours} }};
uniform {} light;
uniform Material material;
void main() {{
    vec3 n = normalize(Normal);
    vec3 v = {view};
    vec3 d = texture(material.diffuse, TexCoords).rgb;
    vec3 g = texture(material.specular, TexCoords).rgb;
    {}
    float nl = max(dot(n, l), 0.0);
    float s = nl > 0.0 ? pow(max(dot(v, reflect(-l, n)), 0.0), material.shininess) : 0.0;
    FragColor = vec4(({sum}) * k, 1.0);
}}
",
            self.kind.name(),
            self.members,
            self.kind.name(),
            self.code,
        )
    }
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Kind::Sun => "DirLight",
            Kind::Lamp => "PointLight",
            Kind::Spot | Kind::HardSpot => "SpotLight",
        }
    }
}

/// The crates of the casters under one light of a kind.
fn scene(kind: Kind, space: Space) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/scenes/caster_point.json");
    let reading = read_file(path).unwrap_or_else(|error| panic!("{error}"));
    let mut scene = reading.scene.unwrap_or_else(|| panic!("{:?}", reading.diagnostics));
    (scene.size, scene.space) = ([64, 48], space);
    let color = DVec3::new(1.0, 0.8, 0.6);
    let emission = Emission {
        ambient: DVec3::splat(0.1),
        diffuse: DVec3::new(0.9, 0.7, 0.5),
        specular: DVec3::new(0.5, 0.6, 0.7),
        color,
        intensity: 0.6,
    };
    let attenuation =
        Attenuation { constant: 1.0, linear: 0.15, quadratic: 0.02, range: Some(8.0) };
    let lamp = PointLight { position: DVec3::new(0.8, 0.9, 2.0), emission, attenuation };
    let direction = DVec3::new(-0.2, -0.3, -1.0).normalize();
    let angles: [f64; 2] = if kind == Kind::HardSpot { [17.0; 2] } else { [11.0, 24.0] };
    let [inner_cos, outer_cos] = angles.map(|angle| angle.to_radians().cos());
    let cone = Cone { inner_cos, outer_cos, degrees: Some(angles) };
    scene.lights = match kind {
        Kind::Sun => {
            let directional = vec![DirectionalLight { direction, emission }];
            Lights { directional, ..Lights::default() }
        }
        Kind::Lamp => Lights { point: vec![lamp], ..Lights::default() },
        Kind::Spot | Kind::HardSpot => {
            Lights { spot: vec![SpotLight { point: lamp, direction, cone }], ..Lights::default() }
        }
    };
    scene
}

/// The largest difference from the reference in codes; an error where the shader is refused.
fn error(case: &Case, renderer: &Renderer) -> u8 {
    let scene = scene(case.kind, case.space);
    let (upload, frame) = (Upload::new(&scene), Frame::new(&scene, &FrameOptions::default()));
    let limit = Duration::from_secs(600);
    let work = Work { upload: &upload, frame: &frame, background: scene.background, limit };
    let all: Vec<u32> = (0..frame.fragments.len() as u32).collect();
    let lit = LightSet { ambient: false, ..LightSet::all(&upload.lights) };
    let draws = [Draw { fragments: &all, lights: &lit, tiles: None }];
    let rendered = renderer.render(&mut Cpu::default(), &work, &draws, &mut |_: &mut Cpu, _| {});
    let rendered = rendered.unwrap_or_else(|error| panic!("{}: {error}", case.name));
    let truth = truth(&case.model, &upload, &frame, scene.background);
    let lit = truth.picture.pixels.iter().filter(|pixel| pixel[0] > 0.15).count();
    assert!(lit > 40, "{}: the scene shows {lit} lit pixels", case.name);
    let options = Compare { transfer: Transfer::Linear, leave_out: Some(&truth.leave_out) };
    let compared = compare(&truth.picture, &rendered.picture, &options).expect("of one size");
    compared.codes.max
}

fn renderer(case: &Case, options: &RenderOptions<'_>) -> Result<Renderer, RenderError> {
    Renderer::new(&Source::new("case.frag", case.text()), options)
}

/// The light of a sun: who uses its direction how, and under which name.
fn suns() -> Vec<Case> {
    let travel = [
        ("negated at once", "vec3 l = normalize(-light.direction);"),
        ("negated at the dot", "vec3 t = normalize(light.direction); vec3 l = -t;"),
        ("negated dot", "vec3 t = light.direction; float c = -dot(n, t); vec3 l = t * sign(-1.0);"),
        ("subtracted", "vec3 l = vec3(0.0) - light.direction;"),
        ("times minus one", "vec3 l = light.direction * -1.0;"),
        (
            "reflected",
            "vec3 m = reflect(light.direction, n); vec3 l = reflect(m, n) - 2.0 * light.direction; l = normalize(-light.direction);",
        ),
        ("by parts", "vec3 l; l.x = -light.direction.x; l.yz = -light.direction.yz;"),
    ];
    let towards = [
        ("as it is", "vec3 l = normalize(light.direction);"),
        ("a minus that does nothing", "vec3 l = light.direction; l += 0.0 * -light.direction;"),
        ("two minus signs", "vec3 a = -light.direction; vec3 l = -a;"),
        ("swizzled", "vec3 l = light.direction.xyz / length(light.direction);"),
    ];
    let mut cases = Vec::new();
    for (name, code) in travel.into_iter().chain(towards) {
        let code = format!("{code} float k = 1.0;");
        cases.push(Case::new(&format!("sun {name}"), Kind::Sun, "vec3 direction;", &code));
    }
    for (member, code) in [
        ("toLightDirection", "vec3 l = -normalize(light.toLightDirection);"),
        ("travelDirection", "vec3 l = normalize(light.travelDirection);"),
    ] {
        let (members, code) = (format!("vec3 {member};"), format!("{code} float k = 1.0;"));
        cases.push(Case::new(&format!("sun misnamed {member}"), Kind::Sun, &members, &code));
    }
    let view = [&cases[0], &cases[1], &cases[7]].map(|case| case.clone().in_view_space());
    cases.extend(view);
    let wrong = |name, code| Case::new(name, Kind::Sun, "vec3 direction;", code).refused();
    cases.extend([
        wrong(
            "angles of a sun",
            "vec3 a = radians(light.direction); vec3 l = vec3(cos(a.y) * cos(a.x), sin(a.x), sin(a.y)); float k = 1.0;",
        ),
        wrong(
            "a sun with a place",
            "vec3 l = normalize(light.direction * 3.0 - FragPos); float k = 1.0;",
        ),
    ]);
    cases
}

/// Spotlights: both signs, three units, soft and hard edges, and names that are swapped.
fn spots() -> Vec<Case> {
    let path = "vec3 p = light.position - FragPos; float r = length(p); vec3 l = p / r;";
    let weak = "k / (light.constant + light.linear * r + light.quadratic * r * r)";
    let coefficients = "float constant; float linear; float quadratic;";
    let units = [("cosines", "", ""), ("radians", "cos(", ")"), ("degrees", "cos(radians(", "))")];
    let mut cases = Vec::new();
    for (unit, open, close) in units {
        for (sign, minus) in [("travel", "-"), ("towards", "")] {
            for (order, first, second) in
                [("named", "cutOff", "outerCutOff"), ("swapped", "outerCutOff", "cutOff")]
            {
                let members = format!(
                    "vec3 position; vec3 direction; float cutOff; float outerCutOff; {coefficients}"
                );
                let code = format!(
                    "{path} vec3 t = normalize(light.direction); float c = {minus}dot(l, t);
    float i = {open}light.{first}{close}; float o = {open}light.{second}{close};
    float k = clamp((c - o) / (i - o), 0.0, 1.0); k = {weak};"
                );
                let name = format!("soft spot in {unit}, {sign}, {order}");
                cases.push(Case::new(&name, Kind::Spot, &members, &code));
            }
            let members = format!("vec3 position; vec3 direction; float coneAngle; {coefficients}");
            let code = format!(
                "{path} float c = {minus}dot(l, normalize(light.direction));
    float k = c > {open}light.coneAngle{close} ? 1.0 : 0.0; k = {weak};"
            );
            let name = format!("hard spot in {unit}, {sign}");
            let case = Case::new(&name, Kind::HardSpot, &members, &code);
            cases.push(Case { model: Model { cone_edge: ConeEdge::Hard, ..multi() }, ..case });
        }
    }
    cases.push(cases[0].clone().in_view_space());
    let members = format!("vec3 position; vec3 direction; float angle; {coefficients}");
    let wrong = |name, cone: &str| {
        let code = format!(
            "{path} float c = dot(-l, normalize(light.direction));
    float k = {cone} ? 1.0 : 0.0; k = {weak};"
        );
        Case::new(name, Kind::HardSpot, &members, &code).refused()
    };
    cases.extend([
        wrong("the whole angle of a cone", "c > cos(radians(light.angle) * 0.5)"),
        wrong("the tangent of a cone", "c > 0.0 && sqrt(1.0 - c * c) / c < light.angle"),
        wrong("a cone lit outside", "c < cos(radians(light.angle))"),
    ]);
    cases
}

/// Point lights: squares and inverses of ranges, coefficients and colours.
fn lamps() -> Vec<Case> {
    let path = "vec3 p = light.position - FragPos; float d2 = dot(p, p); float r = sqrt(d2); vec3 l = p / r;";
    let weak = "1.0 / (light.constant + light.linear * r + light.quadratic * d2)";
    let coefficients = "float constant; float linear; float quadratic;";
    let mut cases = Vec::new();
    let windowed = Model { window: Window::Quartic, ..multi() };
    for (name, member, squared) in [
        ("a range", "range", "d2 / (light.range * light.range)"),
        ("a range of a radius", "radius", "d2 / (light.radius * light.radius)"),
        ("a squared range", "rangeSquared", "d2 / light.rangeSquared"),
        ("a squared range without saying so", "range", "d2 / light.range"),
        ("an inverse range", "inverseRange", "d2 * light.inverseRange * light.inverseRange"),
        ("an inverse range without saying so", "reach", "r * light.reach * r * light.reach"),
        ("an inverse squared radius", "invRadiusSq", "d2 * light.invRadiusSq"),
        ("an inverse squared radius without saying so", "radius", "d2 * light.radius"),
    ] {
        let members = format!("vec3 position; float {member}; {coefficients}");
        let code = format!(
            "{path} float q = {squared}; float w = max(1.0 - q * q, 0.0); float k = w * w * {weak};"
        );
        let case = Case::new(name, Kind::Lamp, &members, &code);
        cases.push(Case { model: windowed, ..case });
    }
    for (name, [c, l, q]) in [
        ("coefficients as named", ["constant", "linear", "quadratic"]),
        ("linear and quadratic swapped", ["constant", "quadratic", "linear"]),
        ("coefficients from the highest", ["quadratic", "linear", "constant"]),
    ] {
        let members = format!("vec3 position; {coefficients}");
        let code = format!("{path} float k = 1.0 / (light.{c} + light.{l} * r + light.{q} * d2);");
        cases.push(Case::new(name, Kind::Lamp, &members, &code));
    }
    let array = Model {
        ambient: AmbientTerm::None,
        specular_gate: SpecularGate::Facing,
        ..Model::new(Family::Array)
    };
    for (name, strength, kind) in [
        ("a colour and its intensity", "light.color * light.intensity", Kind::Lamp),
        ("a premultiplied colour", "light.color", Kind::Lamp),
        ("a colour with a gate", "(light.intensity > 0.0 ? light.color : vec3(0.0))", Kind::Lamp),
        ("a premultiplied sun", "light.color", Kind::Sun),
    ] {
        let (members, code) = match kind {
            Kind::Sun => (
                "vec3 direction;".to_string(),
                "vec3 l = -light.direction; float k = 1.0;".to_string(),
            ),
            Kind::Lamp | Kind::Spot | Kind::HardSpot => {
                (format!("vec3 position; {coefficients}"), format!("{path} float k = {weak};"))
            }
        };
        let case = Case::new(name, kind, &members, &code);
        cases.push(Case { single: Some(strength), model: array, ..case });
    }
    cases
}

/// Whether the picture by the names alone, without running anything, is the reference's.
fn names_suffice(case: &Case, renderer: &Renderer) -> bool {
    let text = case.text();
    let map = infer(&renderer.shader, "case.frag", &text).expect("it has lights");
    let json: serde_json::Map<String, serde_json::Value> = map
        .members
        .iter()
        .map(|member| (member.key(), serde_json::Value::from(member.source.to_string())))
        .collect();
    assert!(BlockWriter::new(&renderer.shader, &map).is_ok());
    let options = RenderOptions { bind: vec![&json], ..RenderOptions::default() };
    let named = self::renderer(case, &options).unwrap_or_else(|e| panic!("{}: {e}", case.name));
    error(case, &named) <= 1
}

#[test]
fn every_spelling_of_a_light_is_bound_as_the_reference_lights_it_or_refused() {
    let cases: Vec<Case> = [suns(), spots(), lamps()].concat();
    assert!(cases.len() >= 40, "{}", cases.len());
    let (mut bound, mut refused, mut wrong, mut misnamed) = (0, 0, Vec::new(), 0);
    for case in &cases {
        match (renderer(case, &RenderOptions::default()), case.refused) {
            (Ok(renderer), false) => {
                let steps = error(case, &renderer);
                if steps > 1 {
                    wrong.push(format!("{}: {steps} steps", case.name));
                }
                bound += 1;
                misnamed += usize::from(!names_suffice(case, &renderer));
            }
            (Err(RenderError::Bind(BindError::Undecided { .. })), true) => refused += 1,
            (Ok(_), true) => wrong.push(format!("{}: not refused", case.name)),
            (Err(error), _) => wrong.push(format!("{}: {error}", case.name)),
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    println!("{bound} bound, {misnamed} of them otherwise than by name; {refused} refused");
    assert!(misnamed >= 15 && refused >= 5, "{misnamed} {refused}");
}

/// A shader in view space lights a scene in world space from the wrong eye.
#[test]
fn a_camera_at_the_origin_is_refused_where_the_scenes_is_elsewhere() {
    let refused = |case: &Case, space| {
        let made = renderer(case, &RenderOptions::default());
        let made = made.unwrap_or_else(|error| panic!("{}: {error}", case.name));
        made.lights(&Upload::new(&scene(case.kind, space)), OverflowPolicy::Refuse).err()
    };
    for case in suns().iter().chain(&lamps()).filter(|case| !case.refused) {
        let own = refused(case, case.space);
        assert_eq!(own, None, "{}", case.name);
        let view = Case { space: Space::View, ..case.clone() };
        assert_eq!(refused(&view, Space::View), None, "{}", case.name);
        let error = refused(&view, Space::World);
        assert_eq!(error, Some(BindError::CameraElsewhere), "{}", case.name);
    }
}

#[test]
fn what_is_refused_says_what_to_write_and_takes_it() {
    let case = suns().pop().expect("the last is refused");
    let refused = match renderer(&case, &RenderOptions::default()) {
        Err(RenderError::Bind(refused)) => refused,
        Err(other) => panic!("{other}"),
        Ok(renderer) => panic!("bound: {:?}", renderer.map.decisions),
    };
    golden().eq(refused.to_string(), str!["the sign of `light.direction` cannot be inferred: of 2 interpretations, none matches the reference on 24 test fragments"]);
    golden().eq(refused.help().unwrap_or_default(), str![[r#"say what they hold, with `--bind '{"light.direction": "-directional[0].direction"}'` or `--bind '{"light.direction": "directional[0].direction"}'`"#]]);
    let bind = serde_json::json!({"light.direction": "-directional[0].direction"});
    let bind = bind.as_object().expect("an object");
    let options = RenderOptions { bind: vec![bind], ..RenderOptions::default() };
    let said = renderer(&case, &options).unwrap_or_else(|error| panic!("{error}"));
    assert!(said.map.decisions.is_empty(), "{:?}", said.map.decisions);
}
