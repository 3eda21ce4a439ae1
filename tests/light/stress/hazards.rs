//! Every hazard of the table, where it is and where it is not.

use landfall_ir::analysis::hazard::Hazard;
use snapbox::str;

use super::{Request, all, domain, line, request, run, shader};
use crate::support::command::golden;

/// The hazards of a function: the code, and a part of the line it is in.
fn meets(path: &str, function: &str, hazards: &[(&str, &str)]) {
    // Bounded by samples: how many fit into a time depends on the machine.
    let report = run(&shader(path), &Request { time: None, ..request(function) });
    for (code, text) in hazards {
        let here = report
            .findings
            .iter()
            .any(|found| found.hazard.code() == *code && line(&report, found).contains(text));
        assert!(here, "{path}, {function}: no {code} at `{text}` in\n{}", all(&report));
    }
}

const POWER: &str = "return pow(max(dot(viewDir, mirrored), 0.0), shininess);";

#[test]
fn a_spot_light_of_a_tutorial_has_its_hazards_at_their_lines() {
    meets(
        "shaders/seed/six_lights_330.frag",
        "CalcSpotLight",
        &[
            ("light-at-fragment", "vec3 toLight = normalize(light.position - fragPos);"),
            ("attenuation-at-light", "return 1.0 / (constant + linear * d"),
            ("attenuation-unset", "return 1.0 / (constant + linear * d"),
            ("overflow", "return 1.0 / (constant + linear * d"),
            ("equal-cut-offs", "return clamp((theta - outerCutOff) / epsilon"),
            ("cone-out-of-range", "return clamp((theta - outerCutOff) / epsilon"),
            ("pow-of-zero", POWER),
            ("base-above-one", POWER),
            ("highlight-from-behind", POWER),
            ("unnormalised-normal", "vec3 mirrored = reflect(-toLight, normal);"),
            ("narrow-cone", "return clamp((theta - outerCutOff) / epsilon"),
            ("large-exponent", POWER),
        ],
    );
}

#[test]
fn a_spot_light_in_view_space_has_its_hazards_at_their_lines() {
    let power = "return pow(x, reflectance > 0.0 ? SPECULAR_POWER : 0.0);";
    meets(
        "shaders/seed/view_space_330.frag",
        "calcSpotLight",
        &[
            ("light-at-fragment", "vec3 toLight = normalize(light.pl.position - position);"),
            ("attenuation-at-light", "return 1.0 / (constant + linear * d"),
            ("zero-width-cone", "return clamp((x - cutoff) / (1.0 - cutoff)"),
            ("pow-of-zero", power),
            ("highlight-from-behind", power),
        ],
    );
}

#[test]
fn a_light_of_an_array_has_its_hazards_at_their_lines() {
    let power = "return pow(max(dot(view_dir, reflect_dir), 0.0), shininess);";
    meets(
        "shaders/seed/light_arrays_330.frag",
        "point_light",
        &[
            ("light-at-fragment", "vec3 light_dir = normalize(light.pos - frag_pos);"),
            ("attenuation-unset", "return 1.0 / (constant + linear * d"),
            ("highlight-from-behind", power),
            ("unnormalised-normal", "vec3 reflect_dir = reflect(-light_dir, normal);"),
            ("large-exponent", power),
        ],
    );
}

#[test]
fn wgsl_has_the_same_hazards() {
    meets(
        "shaders/seed/caster_spot_soft.wgsl",
        "cone",
        &[("equal-cut-offs", "clamp((theta"), ("narrow-cone", "clamp((theta")],
    );
}

#[test]
fn a_power_of_a_negative_number_is_found() {
    meets(
        "tests/hazards/power.frag",
        "bare",
        &[("pow-of-negative", "return pow(x, n);"), ("pow-of-zero", "return pow(x, n);")],
    );
}

#[test]
fn robust_forms_have_none_in_their_domain() {
    let lights = r#"
        "light.position": "position", "light.direction": "unit",
        "light.ambient": "color", "light.diffuse": "color", "light.specular": "color",
        "light.constant": [1, 2], "light.linear": [0, 1], "light.quadratic": [0, 2],
        "normal": "unit", "viewDir": "unit", "fragPos": "position""#;
    let apart = r#""no_coincidence": [["light.cutOff", "light.outerCutOff", 1e-3]]"#;
    for (path, function, json) in [
        (
            "shaders/six_lights/phong_330.frag",
            "CalcPointLight",
            format!(r#"{{{lights}, "material.shininess": [1, 256]}}"#)
                .replace(r#""light.direction": "unit","#, ""),
        ),
        (
            "shaders/six_lights/phong_330.frag",
            "CalcSpotLight",
            format!(
                r#"{{{lights}, "light.cutOff": "cos", "light.outerCutOff": "cos",
                   "material.shininess": [1, 256], {apart}}}"#
            ),
        ),
    ] {
        let mut request = request(function);
        request.domain = domain(&json);
        let report = run(&shader(path), &request);
        assert!(report.findings.is_empty(), "{path}, {function}:\n{}", all(&report));
        assert!(!report.has_non_finite(), "{path}, {function}");
        assert!(report.total.samples >= 10_000, "{} samples", report.total.samples);
    }
}

#[test]
fn a_hazard_is_not_named_where_the_domain_leaves_it_out() {
    let mut request = request("attenuation");
    let path = "shaders/seed/six_lights_330.frag";
    let free = run(&shader(path), &request);
    assert!(
        free.findings.iter().any(|found| found.hazard == Hazard::AttenuationUnset),
        "{}",
        all(&free)
    );
    request.domain =
        domain(r#"{"constant": [1, 1], "linear": [0, 1], "quadratic": [0, 2], "d": [0, 10000]}"#);
    let kept = run(&shader(path), &request);
    assert!(kept.findings.is_empty(), "{}", all(&kept));
}

#[test]
fn half_precision_breaks_what_single_does_not() {
    use landfall_interp::Floats;
    let mut request = request("attenuation");
    request.samples = 10_000;
    request.domain =
        domain(r#"{"constant": [1, 1], "linear": [0, 1], "quadratic": [0, 2], "d": [0, 1000]}"#);
    request.pure.floats = Floats::Half;
    let report = run(&shader("shaders/seed/six_lights_330.frag"), &request);
    // The square of 256 is 65536, which no half holds.
    assert!(
        report.findings.iter().any(|found| found.hazard == Hazard::Overflow),
        "{}",
        all(&report)
    );
}

#[test]
fn a_finding_says_what_any_device_may_do_and_what_the_robust_form_gains() {
    let path = "shaders/seed/six_lights_330.frag";
    let mut request = request("CalcSpotLight");
    let robust = shader("shaders/six_lights/phong_330.frag");
    request.against = Some((robust, request.pure.clone()));
    let report = run(&shader(path), &request);
    let narrow = report.findings.iter().find(|found| found.hazard == Hazard::NarrowCone);
    let narrow = narrow.unwrap_or_else(|| panic!("no narrow-cone in\n{}", all(&report)));
    let permitted = narrow.permitted.expect("it is known of f32");
    assert!(permitted.any && permitted.steps > 0.5, "{permitted:?}");
    let gain = narrow.gain.as_ref().expect("there is a form by the chord");
    assert!(gain.after < gain.before / 10.0, "{gain:?}");
    assert!(narrow.against.is_some());
}

#[test]
fn errors_are_drawn_over_two_inputs() {
    use landfall_accuracy::stress::{MapRequest, error_map};
    let source = shader("shaders/seed/six_lights_330.frag");
    let mut request = request("attenuation");
    request.samples = 2_000;
    request.domain = domain(r#"{"d": [0.001, 1000], "quadratic": [0, 1]}"#);
    let report = run(&source, &request);
    let map = |x: &str| {
        let map = MapRequest { x: x.to_string(), y: "quadratic".to_string(), ..Default::default() };
        error_map(&source, &landfall_layout::Options::default(), &request, &report, &map)
    };
    let svg = map("d").unwrap_or_else(|refusal| panic!("{:?}", refusal.found));
    assert!(svg.starts_with("<svg") && svg.contains("quadratic"), "{}", &svg[..200]);
    let refused = map("dd").expect_err("there is no such input");
    golden().eq(refused.found[0].help.as_deref().expect("it is there"), str!["did you mean `d`?"]);
}
