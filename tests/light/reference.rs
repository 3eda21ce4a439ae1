//! The reference of lighting against published values, 80 digits, and itself.
//!
//! The tables are points.py's: `python3 tests/reference/points.py` writes them again.

mod draw;

use std::collections::BTreeSet;

use draw::{FAMILIES, draw, fragment, six_lights};
use glam::DVec3;
use landfall_light::bind::Kind;
use landfall_light::reference::*;
use landfall_light::sample::Texels;
use snapbox::str;

use crate::support::command::golden;

const TABLES: [&str; 4] = [
    include_str!("../reference/multi.txt"),
    include_str!("../reference/array.txt"),
    include_str!("../reference/view_space.txt"),
    include_str!("../reference/casters.txt"),
];

const WHITE: Texels = Texels { ambient: DVec3::ONE, diffuse: DVec3::ONE, specular: DVec3::ONE };

/// The sum within 1e-12 of its value. A term too, unless it is less than 1e-20 and nothing
/// beside any light that is seen: a highlight of 1e-50 is the power 4096 of a rounded number.
#[test]
fn lights_agree_with_80_digits_to_1e_12_and_hazards_are_tags() {
    let (mut tags, mut ramps, mut highlights) = (BTreeSet::new(), 0, 0);
    for (family, (name, _)) in FAMILIES.iter().enumerate() {
        let (mut numbers, mut worst) = (0, 0.0f64);
        for (number, line) in TABLES[family].lines().enumerate() {
            let p = draw(family, number as u64);
            let got = shade(&p.model, &p.upload, &p.fragment, &p.texels);
            if line.starts_with(char::is_alphabetic) {
                let tag = got.expect_err(line);
                assert_eq!(code(tag), line, "point {number} of {name}: {tag}");
                tags.insert(tag);
                continue;
            }
            let got = got.unwrap_or_else(|tag| panic!("point {number} of {name}: {tag}"));
            let gots = [got.total.x, got.total.y, got.diffuse.y, got.specular.y];
            let wanted: Vec<f64> = line.split(' ').map(|x| x.parse().unwrap()).collect();
            assert_eq!(wanted.len(), gots.len());
            for (i, (got, wanted)) in gots.into_iter().zip(wanted).enumerate() {
                let floor = if i < 2 { 1e-290 } else { 1e-20 };
                let off = (got - wanted).abs() / wanted.abs().max(floor);
                assert!(off <= 1e-12, "number {i} of point {number} of {name}: {got} for {wanted}");
                worst = worst.max(off);
            }
            let seen = see(&p.model, &p.upload, &p.fragment, &p.texels).unwrap();
            let spots = (0..p.upload.lights.spot.len()).map(|spot| seen.light(Kind::Spot, spot));
            let cones = spots.filter_map(Result::ok).map(|light| light.cone);
            ramps += cones.filter(|&cone| cone > 0.0 && cone < 1.0).count();
            highlights += usize::from(got.specular.y > 1e-3 * got.total.y);
            numbers += 1;
        }
        println!("{name}: {numbers} points with a value, off by at most {worst:.1e}");
        assert!(numbers >= 1000, "{name} has {numbers} points with a value");
    }
    assert_eq!(tags, BTreeSet::from(UndefinedReason::ALL), "every tag is in the tables");
    println!("{ramps} on a cone's ramp, {highlights} with a highlight");
    assert!(ramps > 500 && highlights > 1000, "the points see little: {ramps}, {highlights}");
}

/// A position, a normal, and what the sun, four lamps and the flashlight give, then the sum.
/// Made at 50 digits from the published parameters.
const GOLDEN: [([f64; 3], [f64; 3], [&str; 7]); 7] = [
    (
        [0.0, 0.0, 0.5],
        [0.0, 0.0, 1.0],
        [
            ".162886510702",
            ".648587183427",
            ".0184571625189",
            ".00638175710067",
            ".0292911539737",
            "1.40350875377",
            "2.26911252149039",
        ],
    ),
    (
        [0.4, 0.3, 0.5],
        [0.0, 0.0, 1.0],
        [
            ".162886510702",
            "1.15525295212",
            ".0183529653141",
            ".00631757017912",
            ".0291002540505",
            ".735869414475",
            "2.1077796668398",
        ],
    ),
    (
        [0.5, 0.1, 0.2],
        [1.0, 0.0, 0.0],
        [
            ".125257672181",
            ".108953964584",
            ".118723855053",
            ".0713419604169",
            ".599395324213",
            "0",
            "1.02367277644811",
        ],
    ),
    (
        [0.75, 0.0, -1.0],
        [0.3, 0.2, 1.0],
        [
            ".248230224223",
            ".517350577225",
            ".0233831224785",
            ".00733645796649",
            ".0373625037751",
            ".460165239996",
            "1.29382812566422",
        ],
    ),
    (
        [-1.3, 1.5, -1.5],
        [0.0, 1.0, 0.0],
        [
            ".426288352316",
            ".0255717754724",
            ".0170241743331",
            ".0367200298443",
            ".0351618573161",
            "0",
            ".540766189282212",
        ],
    ),
    (
        [0.0, 0.0, -3.5],
        [0.0, 0.0, 1.0],
        [
            ".162886510702",
            ".644232644096",
            ".0264471144877",
            ".0103811504264",
            "1.75688509863",
            ".680966952823",
            "3.28179947116479",
        ],
    ),
    (
        [0.61, 0.0, 0.5],
        [0.0, 0.0, 1.0],
        [
            ".162886510702",
            "1.06739279101",
            ".019137797923",
            ".00623396946729",
            ".0290081157318",
            ".369866580314",
            "1.65452576515039",
        ],
    ),
];

/// To the digits the values have, and no further than 1e-12.
fn as_printed(got: f64, text: &str) -> bool {
    let wanted: f64 = text.parse().unwrap();
    let digits = text.split_once('.').map_or(0, |(_, digits)| digits.len());
    (got - wanted).abs() <= 0.5 * 10f64.powi(-(digits as i32)) + 1e-15 * wanted.abs()
        || text.ends_with('0') && got == wanted
}

#[test]
fn six_lights_give_the_published_values() {
    let (model, upload) = (Model::new(Family::Multi), six_lights());
    for (at, n, values) in GOLDEN {
        let fragment = fragment(DVec3::from_array(at), DVec3::from_array(n));
        let seen = see(&model, &upload, &fragment, &WHITE).unwrap();
        for ((kind, light), value) in seen.lights().zip(values) {
            let got = seen.light(kind, light).unwrap().total();
            assert!(as_printed(got.x, value), "{kind:?} {light} at {at:?}: {got} for {value}");
        }
        let got = seen.shade().unwrap().total;
        assert!(as_printed(got.z, values[6]), "sum at {at:?}: {got} for {}", values[6]);
    }
}

#[test]
fn a_sum_is_its_lights_in_order_and_its_terms() {
    for number in [0, 4, 5, 6, 9, 10] {
        let p = draw(0, number);
        let Ok(seen) = see(&p.model, &p.upload, &p.fragment, &p.texels) else { continue };
        let Ok(all) = seen.shade() else { continue };
        let mut sum = seen.ambient();
        for (kind, light) in seen.lights() {
            sum += seen.light(kind, light).unwrap().total();
        }
        assert_eq!(sum, all.total, "point {number}");
        let terms = all.ambient + all.diffuse + all.specular;
        assert!((terms - all.total).abs().max_element() <= 1e-15 * all.total.max_element());
    }
}

/// Beside the edge of a cone without a ramp, rounding decides; how far it is away is told.
#[test]
fn a_hard_cone_tells_how_far_its_edge_is() {
    let model = Model { cone_edge: ConeEdge::Hard, ..Model::new(Family::Casters) };
    let mut upload = six_lights();
    upload.lights.point.clear();
    let inside = fragment(DVec3::new(0.1, 0.0, 0.5), DVec3::Z);
    let outside = fragment(DVec3::new(0.9, 0.0, 0.5), DVec3::Z);
    for (fragment, cone) in [(inside, 1.0), (outside, 0.0)] {
        let seen = see(&model, &upload, &fragment, &WHITE).unwrap();
        let light = seen.light(Kind::Spot, 0).unwrap();
        assert_eq!(light.cone, cone);
        let x = f64::from(fragment.position[0]);
        let cosine = 2.5 / (2.5f64 * 2.5 + x * x).sqrt();
        let edge = (cosine - upload.lights.spot[0].cone.inner_cos).abs();
        assert!((light.edge.unwrap() - edge).abs() < 1e-15);
        assert_eq!(seen.shade().unwrap().edge, light.edge);
    }
    let soft = Model { cone_edge: ConeEdge::Soft, ..model };
    assert_eq!(shade(&soft, &upload, &inside, &WHITE).unwrap().edge, None);
}

#[test]
fn a_model_is_a_name_or_what_differs_from_it() {
    let read = |text: &str| serde_json::from_str::<Model>(text).map_err(|e| e.to_string());
    for (name, family) in FAMILIES {
        assert_eq!(read(&format!("\"{name}\"")), Ok(Model::new(family)));
        assert_eq!(read(&format!(r#"{{"family": "{name}"}}"#)), Ok(Model::new(family)));
        let written = serde_json::to_string(&Model::new(family)).unwrap();
        assert_eq!(read(&written), Ok(Model::new(family)), "{written}");
    }
    let blinn = read(r#"{"family": "view_space", "highlight": "blinn", "power": "material"}"#);
    let model = Model::new(Family::ViewSpace);
    let wanted = Model { highlight: Highlight::Blinn, power: Power::Material, ..model };
    assert_eq!(blinn, Ok(wanted));
    // As published, highlights mirror at the normal as it comes.
    let published = read(r#"{"family": "array", "array_specular": "as_published"}"#).unwrap();
    assert_eq!(published.normal, Normal::AsInterpolated);
    let said = r#"{"normal": "unit", "family": "array", "array_specular": "as_published"}"#;
    assert_eq!(read(said).unwrap().normal, Normal::Unit);

    golden().eq(read("\"phong\"").unwrap_err(), str!["unknown variant `phong`, expected one of `multi`, `array`, `view_space`, `casters` at line 1 column 7"]);
    golden().eq(read("{}").unwrap_err(), str!["missing field `family` at line 1 column 2"]);
    let unknown = read(r#"{"family": "multi", "shiny": 1}"#).unwrap_err();
    golden().eq(&unknown, str!["unknown field `shiny`, expected one of `family`, `normal`, `ambient`, `specular_gate`, `highlight`, `window`, `cone_edge`, `cone_numbers`, `caster_attenuation`, `array_specular`, `reflectance`, `power`, `normal_transform` at line 1 column 27"]);
    let number = read("3").unwrap_err();
    golden().eq(&number, str!["invalid type: integer `3`, expected the name of a lighting model, or a map whose `family` names it at line 1 column 1"]);
}

/// Normals 30 degrees apart, seen from so far away, may bend by so many degrees.
#[test]
fn a_normal_of_four_components_bends_with_the_distance() {
    let both = [-15f64, 15.0].map(|a| DVec3::new(a.to_radians().sin(), 0.0, a.to_radians().cos()));
    let blend = |[a, b]: [DVec3; 2], t: f64| (a * (1.0 - t) + b * t).normalize();
    for (distance, degrees) in [(1.0, 1.35), (2.0, 3.3), (10.0, 10.0), (100.0, 14.4)] {
        let mut most = 0.0f64;
        for direction in 0..720 {
            let at = f64::from(direction) * std::f64::consts::PI / 360.0;
            let away = DVec3::new(at.sin(), 0.0, at.cos()) * distance;
            let seen = glam::DMat4::from_translation(away);
            let normals = |form| both.map(|n| view_normal(&seen, n, form).unwrap());
            let (right, wrong) = (normals(NormalTransform::Mat3), normals(NormalTransform::Vec4));
            for step in 0..=100 {
                let t = f64::from(step) / 100.0;
                most = most.max(blend(right, t).angle_between(blend(wrong, t)).to_degrees());
            }
        }
        println!("{most:.2} degrees at a distance of {distance}");
        // Never past the other normal; a search of fewer directions found the figures.
        assert!(most >= 0.99 * degrees && most < 30.0, "{most} at {distance}");
        assert!(distance > 2.0 || most <= 1.01 * degrees, "{most} at {distance}");
    }
    let flat = glam::DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0));
    let flat = view_normal(&flat, DVec3::Z, NormalTransform::Mat3);
    assert_eq!(flat, Err(UndefinedReason::NotFinite));
    let zero = view_normal(&glam::DMat4::IDENTITY, DVec3::ZERO, NormalTransform::Vec4);
    assert_eq!(zero, Err(UndefinedReason::ZeroVector));
}

/// What points.py calls the tag: it has one code for vectors that are zero, one for powers that
/// are undefined whatever their base, and one for what the host should refuse.
fn code(tag: UndefinedReason) -> &'static str {
    match tag {
        UndefinedReason::NoHalfVector => "light-at-fragment",
        UndefinedReason::ZeroToNegative => "pow-of-negative",
        UndefinedReason::NotFinite => "zero-direction",
        tag => tag.hazard().code(),
    }
}
