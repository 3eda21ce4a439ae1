//! Lints that follow lighting code. Each text is the body of `main`; `//<` marks each line that has
//! to be reported, `//?` one that is known to be missed. Which line is which follows from the
//! formula on it: what may be 0 or negative, which slots are in use, what a cosine is compared
//! with.

use super::{Fixture, Score};

/// What the bodies use.
const BEFORE: &str = "\
#version 330 core
struct Light {
    vec3 position; vec3 direction; vec3 color;
    float cutOff, outerCutOff, constant, linear, quadratic;
};
layout(std140) uniform Lights { Light lights[8]; int count; };
uniform Light light;
uniform vec3 eye;
uniform float shininess;
in vec3 at;
in vec3 normal;
out vec4 color;
";

/// The start of bodies that use unit vectors.
const UNIT: &str = "
vec3 n = normalize(normal);
vec3 l = light.position - at;
float d = length(l);
l /= max(d, 1.0e-6);
vec3 v = eye - at;
v /= max(length(v), 1.0e-6);
vec3 s = light.direction;
float sum = 0.0;
";

/// Bodies after [`UNIT`], by lint; each sets `sum`.
pub const BODIES: &[(&str, &[&str])] = &[
    (
        "attenuation-division",
        &[
            "sum = 1.0 / (light.constant + light.linear * d + light.quadratic * d * d); //<",
            "sum = 1.0 / (d * d); //<",
            "vec3 p = light.position - at;\nsum = 1.0 / dot(p, p); //<",
            "float a = light.constant + d * (light.linear + d * light.quadratic);\nsum = 1.0 / a; //<",
            "sum = 1.0;\nsum /= light.quadratic * d * d; //<",
            "sum = pow(d, -2.0); //?",
            "sum = 1.0 / (1.0 + light.linear * d + light.quadratic * d * d);",
            "sum = 1.0 / max(light.constant + light.linear * d, 1.0e-4);",
            "sum = 1.0 / (d * d + 0.01);",
            "if (d > 0.01) { sum = 1.0 / (d * d); }",
            "sum = d > 0.01 ? 1.0 / (d * d) : 0.0;",
            "float k = max(d, 0.1);\nsum = 1.0 / (k * k);",
            "sum = clamp(1.0 - d / 25.0, 0.0, 1.0);",
        ],
    ),
    (
        "cone-division",
        &[
            "sum = clamp((dot(l, s) - light.outerCutOff) / (light.cutOff - light.outerCutOff), 0.0, 1.0); //<",
            "float e = light.cutOff - light.outerCutOff;\nsum = (dot(l, s) - light.outerCutOff) / e; //<",
            "sum = (dot(l, s) - light.cutOff) / (1.0 - light.cutOff); //<",
            "sum = (dot(l, s) - light.outerCutOff) / max(light.cutOff - light.outerCutOff, 1.0e-4);",
            "if (light.cutOff - light.outerCutOff > 0.01) {\n\
             sum = (dot(l, s) - light.outerCutOff) / (light.cutOff - light.outerCutOff);\n}",
            "sum = (dot(l, s) - 0.9) / (0.95 - 0.9);",
            "sum = dot(l, s) > light.cutOff ? 1.0 : 0.0;",
        ],
    ),
    (
        "cosine-cone",
        &[
            "sum = dot(l, normalize(s)) > light.cutOff ? 1.0 : 0.0; //<",
            "sum = step(light.cutOff, dot(l, normalize(s))); //<",
            "sum = smoothstep(light.outerCutOff, light.cutOff, dot(l, normalize(s))); //<",
            "float t = dot(l, normalize(s));\nif (t > light.cutOff) { //<\nsum = 1.0;\n}",
            "vec3 e = l - normalize(s);\nsum = 0.5 * dot(e, e) < light.cutOff ? 1.0 : 0.0;",
            "sum = max(dot(n, l), 0.0);",
            "sum = dot(n, l) > 0.0 ? 1.0 : 0.0;",
        ],
    ),
    (
        "degrees-for-cosine",
        &[
            "sum = dot(l, normalize(s)) > 12.5 ? 1.0 : 0.0; //<",
            "sum = dot(l, normalize(s)) > cos(12.5) ? 1.0 : 0.0; //<",
            "float cutOffDegrees = light.cutOff;\nsum = dot(l, normalize(s)) > cutOffDegrees ? 1.0 : 0.0; //?",
            "sum = smoothstep(17.5, 12.5, dot(l, normalize(s))); //<",
            "sum = dot(l, normalize(s)) > 0.976 ? 1.0 : 0.0;",
            "sum = dot(l, normalize(s)) > cos(radians(12.5)) ? 1.0 : 0.0;",
            "sum = dot(l, normalize(s)) > light.cutOff ? 1.0 : 0.0;",
            "sum = acos(dot(l, normalize(s))) < 2.5 ? 1.0 : 0.0;",
            "sum = d > 12.5 ? 0.0 : 1.0;",
        ],
    ),
    (
        "pow-of-negative",
        &[
            "sum = pow(dot(reflect(-l, n), v), 32.0); //<",
            "sum = pow(dot(n, normalize(l + v)), shininess); //<",
            "float x = dot(n, l);\nsum = pow(x, 2.0); //<",
            "sum = pow(max(dot(reflect(-l, n), v), 0.0), 32.0);",
            "sum = pow(clamp(dot(n, l), 0.0, 1.0), 32.0);",
            "sum = pow(abs(dot(n, l)), 2.0);",
            "if (dot(n, l) > 0.0) { sum = pow(dot(n, l), 2.0); }",
            "sum = pow(dot(n, l) * 0.5 + 0.5, 2.0);",
            "sum = pow(1.0 - max(dot(n, v), 0.0), 5.0);",
        ],
    ),
    (
        "pow-of-zero",
        &[
            "sum = pow(max(dot(reflect(-l, n), v), 0.0), shininess); //<",
            "sum = pow(clamp(dot(n, normalize(l + v)), 0.0, 1.0), shininess); //<",
            "sum = pow(abs(dot(n, l)), shininess); //<",
            "sum = pow(max(dot(n, l), 0.0), 0.0); //<",
            "sum = pow(max(dot(n, l), 0.0), 32.0);",
            "sum = pow(max(dot(n, l), 0.0), max(shininess, 1.0));",
            "float x = max(dot(n, l), 0.0);\nsum = x > 0.0 ? pow(x, shininess) : 0.0;",
            "sum = pow(max(dot(n, l), 1.0e-4), shininess);",
            "sum = pow(2.0, shininess);",
        ],
    ),
    (
        "ungated-specular",
        &[
            "sum = max(dot(n, l), 0.0) + pow(max(dot(reflect(-l, n), v), 0.0), 32.0); //<",
            "sum = pow(max(dot(n, normalize(l + v)), 0.0), 32.0); //<",
            "vec3 h = normalize(l + v);\nfloat x = max(dot(n, h), 0.0);\nsum = pow(x, shininess); //<",
            "if (dot(n, l) > 0.0) { sum = pow(max(dot(reflect(-l, n), v), 0.0), 32.0); }",
            "float k = max(dot(n, l), 0.0);\nsum = k * (1.0 + pow(max(dot(reflect(-l, n), v), 0.0), 32.0));",
            "sum = step(0.0, dot(n, l)) * pow(max(dot(n, normalize(l + v)), 0.0), 32.0);",
            "sum = pow(1.0 - max(dot(normalize(l + v), v), 0.0), 5.0);",
        ],
    ),
    (
        "unnormalised-normal",
        &[
            "sum = pow(max(dot(reflect(-l, normal), v), 0.0), 32.0); //<",
            "sum = pow(max(dot(normal, normalize(l + v)), 0.0), 32.0); //<",
            "vec3 m = normal;\nsum = pow(max(dot(m, normalize(l + v)), 0.0), 32.0); //<",
            "sum = pow(max(dot(reflect(-l, n), v), 0.0), 32.0);",
            "sum = max(dot(normal, l), 0.0);",
            "vec3 m = normal / length(normal);\nsum = pow(max(dot(m, normalize(l + v)), 0.0), 32.0);",
            "vec3 m = normal * inversesqrt(dot(normal, normal));\n\
             sum = pow(max(dot(m, normalize(l + v)), 0.0), 32.0);",
        ],
    ),
    (
        "unguarded-normalize",
        &[
            "vec3 p = normalize(light.position - at); //<\nsum = p.z;",
            "vec3 p = light.position - at;\nsum = normalize(p).z; //<",
            "vec3 p = normalize(eye - at); //<\nsum = p.z;",
            "vec3 p = light.position - at;\np = p / length(p); //<\nsum = p.z;",
            "vec3 p = light.position - at;\np *= inversesqrt(dot(p, p)); //<\nsum = p.z;",
            "vec3 p = light.position - at;\nsum = (p * inversesqrt(max(dot(p, p), 1.0e-30))).z;",
            "if (light.position != at) { sum = normalize(light.position - at).z; }",
            "vec3 p = light.position - at;\nsum = length(p) > 1.0e-6 ? normalize(p).z : 0.0;",
            "vec3 p = light.position - at;\nif (dot(p, p) < 1.0e-9) { return; }\nsum = normalize(p).z;",
            "sum = normalize(vec3(1.0, 2.0, 3.0)).z;",
            "sum = normalize(normal).z;",
        ],
    ),
    (
        "unguarded-operation",
        &[
            "sum = acos(dot(n, l)); //<",
            "sum = asin(at.x); //<",
            "sum = acos(min(dot(n, l), 1.0)); //<",
            "float x = dot(n, v);\nsum = sqrt(1.0 - x * x); //<",
            "float x = max(dot(n, normalize(v)), 0.0);\nsum = inversesqrt(1.0 - x * x); //<",
            "vec3 p = at - at.zxy;\nsum = 1.0 / dot(p, p); //<",
            "sum = 1.0 / (12.56 * dot(at, at)); //<",
            "sum = 1.0 / pow(at.x, 2.0); //<",
            "sum = smoothstep(1.0, 0.0, d); //<",
            "sum = normalize(at - at.zxy).x; //<",
            "sum = log(max(at.x, 0.0)); //<",
            "sum = sqrt(at.x); //?",
            "sum = acos(clamp(dot(n, l), -1.0, 1.0));",
            "sum = acos(cos(at.x));",
            "sum = acos(light.cutOff);",
            "float x = dot(n, v);\nsum = sqrt(max(1.0 - x * x, 0.0));",
            "float x = clamp(dot(n, v), 0.0, 1.0);\nsum = sqrt(1.0 - x * x);",
            "sum = sqrt(dot(at, at));",
            "sum = 1.0 / max(dot(at, at), 1.0e-4);",
            "if (dot(at, at) > 0.0) { sum = 1.0 / (3.0 * dot(at, at)); }",
            "sum = at.x > 0.0 ? 1.0 / pow(at.x, 2.0) : 0.0;",
            "sum = 1.0 - smoothstep(0.0, 1.0, d);",
            "vec3 p = at - at.zxy;\nsum = (p * inversesqrt(max(dot(p, p), 1.0e-30))).x;",
            "sum = normalize(at + vec3(0.0, 0.0, 3.0) * at.x).x;",
            "sum = log(max(at.x, 1.0e-6));",
        ],
    ),
    (
        "unclamped-count",
        &[
            "for (int i = 0; i < count; i++) {\nsum += lights[i].color.x; //<\n}",
            "int i = 0;\nwhile (i < count) {\nsum += lights[i].color.x; //<\ni++;\n}",
            "for (int i = 0; i <= count - 1; i++) {\nsum += lights[i].color.x; //<\n}",
            "int last = count;\nfor (int i = 0; i < last; i++) {\nsum += lights[i].color.x; //<\n}",
            "for (int i = 0; i < min(count, 8); i++) {\nsum += lights[i].color.x;\n}",
            "for (int i = 0; i < 8 && i < count; i++) {\nsum += lights[i].color.x;\n}",
            "int last = clamp(count, 0, 8);\nfor (int i = 0; i < last; i++) {\nsum += lights[i].color.x;\n}",
            "for (int i = 0; i < 8; i++) {\nif (i >= count) break;\nsum += lights[i].color.x;\n}",
            "for (int i = 0; i < count; i++) {\nsum += 1.0;\n}",
        ],
    ),
    (
        "loop-past-count",
        &[
            "for (int i = 0; i < 8; i++) {\nsum += lights[i].color.x; //<\n}",
            "for (int i = 0; i < lights.length(); i++) {\nsum += lights[i].color.x; //<\n}",
            "for (int i = 7; i >= 0; i--) {\nsum += lights[i].color.x; //?\n}",
            "for (int i = 0; i < count; i++) {\nsum += lights[i].color.x;\n}",
            "for (int i = 0; i < min(count, 8); i++) {\nsum += lights[i].color.x;\n}",
            "for (int i = 0; i < 8; i++) {\nif (i >= count) break;\nsum += lights[i].color.x;\n}",
            "for (int i = 0; i < 8; i++) {\nif (i < count) { sum += lights[i].color.x; }\n}",
            "for (int i = 0; i < 8; i++) {\nsum += 1.0;\n}\nsum += lights[0].color.x;",
        ],
    ),
    (
        "uninitialised-accumulator",
        &[
            "vec3 total;\nfor (int i = 0; i < count; i++) {\ntotal += lights[i].color; //<\n}\nsum = total.x;",
            "vec3 total;\nfor (int i = 0; i < count; i++) {\ntotal = total + lights[i].color; //<\n}\nsum = total.x;",
            "float total;\ntotal += light.color.x; //<\nsum = total;",
            "vec3 total = vec3(0.0);\nfor (int i = 0; i < count; i++) {\ntotal += lights[i].color;\n}\nsum = total.x;",
            "vec3 total;\ntotal = vec3(0.0);\nfor (int i = 0; i < count; i++) {\ntotal += lights[i].color;\n}\nsum = total.x;",
            "vec3 total;\nif (count > 0) { total = light.color; } else { total = vec3(0.0); }\n\
             total += lights[0].color;\nsum = total.x;",
            "vec3 total;\ntotal.x = 0.0; total.y = 0.0; total.z = 0.0;\ntotal += light.color;\nsum = total.x;",
        ],
    ),
];

/// Whole shaders, by lint.
pub const SHADERS: &[(&str, &[&str])] = &[
    (
        "ambient-per-light",
        &[
            "#version 330 core\nstruct Light { vec3 position; vec3 ambient; vec3 diffuse; }; //<\n\
             uniform Light lights[4];\nout vec4 color;\nvoid main() {\nvec3 sum = vec3(0.0);\n\
             for (int i = 0; i < 4; i++) {\nsum += lights[i].ambient + lights[i].diffuse;\n}\n\
             color = vec4(sum, 1.0);\n}\n",
            "#version 330 core\nstruct Light { vec3 position; vec3 diffuse; };\nuniform Light lights[4];\n\
             uniform vec3 ambient;\nout vec4 color;\nvoid main() {\nvec3 sum = ambient;\n\
             for (int i = 0; i < 4; i++) {\nsum += lights[i].diffuse;\n}\ncolor = vec4(sum, 1.0);\n}\n",
            "#version 330 core\nstruct Light { vec3 position; vec3 ambient; vec3 diffuse; };\n\
             uniform Light light;\nout vec4 color;\nvoid main() {\n\
             color = vec4(light.ambient + light.diffuse, 1.0);\n}\n",
        ],
    ),
    (
        "kahan-without-precise",
        &[
            "#version 450\nstruct Light { vec3 position; float intensity; };\n\
             layout(std140, binding = 0) uniform Lights { Light data[64]; } lights;\n\
             layout(location = 0) out vec4 color;\nvoid main() {\nfloat sum = 0.0, lost = 0.0;\n\
             for (int i = 0; i < 64; i++) {\nfloat y = lights.data[i].intensity - lost;\n\
             float t = sum + y;\nlost = (t - sum) - y; //<\nsum = t;\n}\ncolor = vec4(sum);\n}\n",
            "#version 450\nstruct Light { vec3 position; float intensity; };\n\
             layout(std140, binding = 0) uniform Lights { Light data[64]; } lights;\n\
             layout(location = 0) out vec4 color;\nvoid main() {\nprecise float sum = 0.0, lost = 0.0;\n\
             for (int i = 0; i < 64; i++) {\nprecise float y = lights.data[i].intensity - lost;\n\
             precise float t = sum + y;\nlost = (t - sum) - y;\nsum = t;\n}\ncolor = vec4(sum);\n}\n",
            "#version 450\nstruct Light { vec3 position; float intensity; };\n\
             layout(std140, binding = 0) uniform Lights { Light data[64]; } lights;\n\
             layout(location = 0) out vec4 color;\nvoid main() {\nvec4 sum = vec4(0.0);\n\
             for (int i = 0; i < 64; i++) {\nsum[i & 3] += lights.data[i].intensity;\n}\n\
             color = vec4(sum.x + sum.y + sum.z + sum.w);\n}\n",
        ],
    ),
    (
        "mediump-position",
        &[
            "#version 300 es\nprecision mediump float;\nstruct Light { vec3 position; vec3 color; }; //<\n\
             uniform Light light;\nin vec3 at;\nout vec4 color;\nvoid main() {\n\
             float d = length(light.position - at);\ncolor = vec4(light.color / (1.0 + d * d), 1.0);\n}\n",
            "#version 300 es\nprecision highp float;\nuniform lowp vec3 lightPosition; //<\n\
             uniform vec3 lightColor;\nin vec3 at;\nout vec4 color;\nvoid main() {\n\
             float d = length(lightPosition - at);\ncolor = vec4(lightColor / (1.0 + d * d), 1.0);\n}\n",
            "#version 300 es\nprecision mediump float;\nstruct Light { highp vec3 position; vec3 color; };\n\
             uniform Light light;\nin highp vec3 at;\nout vec4 color;\nvoid main() {\n\
             highp float d = length(light.position - at);\ncolor = vec4(light.color / (1.0 + d * d), 1.0);\n}\n",
            "#version 330 core\nprecision mediump float;\nstruct Light { vec3 position; vec3 color; };\n\
             uniform Light light;\nin vec3 at;\nout vec4 color;\nvoid main() {\n\
             float d = length(light.position - at);\ncolor = vec4(light.color / (1.0 + d * d), 1.0);\n}\n",
        ],
    ),
    (
        "vec4-normalise",
        &[
            "#version 330 core\nuniform mat4 view;\nin vec3 n;\nout vec3 o;\nvoid main() {\n\
             o = normalize(transpose(inverse(view)) * vec4(n, 0.0)).xyz; //<\n}\n",
            "#version 330 core\nuniform mat4 view;\nin vec3 n;\nout vec3 o;\nvoid main() {\n\
             mat4 m = transpose(inverse(view));\nvec4 p = m * vec4(n, 0.0);\no = normalize(p).xyz; //<\n}\n",
            "#version 330 core\nuniform mat4 view;\nin vec3 n;\nout vec3 o;\nvoid main() {\n\
             o = normalize((transpose(inverse(view)) * vec4(n, 0.0)).xyz);\n}\n",
            "#version 330 core\nuniform mat4 view;\nin vec3 n;\nout vec3 o;\nvoid main() {\n\
             o = normalize(mat3(transpose(inverse(view))) * n);\n}\n",
            "#version 330 core\nuniform mat4 view;\nin vec3 n;\nout vec3 o;\nvoid main() {\n\
             o = normalize(view * vec4(n, 0.0)).xyz;\n}\n",
        ],
    ),
];

#[test]
fn lighting_code_on_which_one_lint_speaks_and_code_on_which_it_does_not() {
    let body = |text: &str| {
        format!("{BEFORE}void main() {{{UNIT}{text}\ncolor = vec4(light.color * sum, 1.0);\n}}\n")
    };
    let mut wrong = String::new();
    for (code, texts) in BODIES {
        let fixtures = texts.iter().map(|text| Fixture::marked(text, &body(text)));
        wrong.push_str(&Score::of(code, &fixtures.collect::<Vec<_>>()).differences(code, texts));
    }
    for (code, texts) in SHADERS {
        let fixtures = texts.iter().map(|text| Fixture::marked(text, text));
        wrong.push_str(&Score::of(code, &fixtures.collect::<Vec<_>>()).differences(code, texts));
    }
    assert_eq!(wrong, "");
}
