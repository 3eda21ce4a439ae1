//! `port --to wgsl` held against Tint: it takes what is written, and without the directive that
//! turns its check of derivatives off it refuses exactly what landfall warns of.

use std::path::Path;

use crate::support::tint;
use landfall_layout::{Diagnostic, Source};
use landfall_port::{Dialect, PortOptions, Ported, port};

const HEAD: &str = "#version 330
uniform sampler2D t;
uniform samplerCube sky;
uniform sampler2DShadow sh;
uniform bool on;
uniform int n;
uniform float k;
in vec2 uv;
in vec3 nrm;
flat in int id;
out vec4 color;
";

/// The directive of a text that samples in non-uniform control flow.
const OFF: &str = "diagnostic(off, derivative_uniformity);\n";

/// One construct of control flow or of values each.
const BODIES: &[(&str, &str)] = &[
    ("after", "void main(){ color=vec4(0); if(uv.x>.5) color=vec4(1); color+=texture(t,uv); }"),
    ("andand", "void main(){ color=vec4(0); if(uv.x>.5 && texture(t,uv).x>.5) color=vec4(1); }"),
    ("arr", "void main(){ float a[3]=float[3](1.,2.,3.); color=vec4(a[id]); }"),
    ("bias", "void main(){ color=vec4(0); if(nrm.x>.5) color=texture(t,uv,1.0); }"),
    ("branch", "void main(){ color=vec4(0); if(uv.x>0.5) color=texture(t,uv); }"),
    (
        "brk",
        "void main(){ color=vec4(0); for(int i=0;i<4;i++){ if(uv.x*float(i)>1.) break; color+=texture(t,uv*float(i));} }",
    ),
    ("const0", "void main(){ const float z=0.0; color=vec4(1.0/3.0); if(k/z>1.) color=vec4(2); }"),
    (
        "contin",
        "void main(){ color=vec4(0); for(int i=0;i<4;i++){ if(uv.x*float(i)>1.) continue; color+=texture(t,uv*float(i));} }",
    ),
    (
        "contin2",
        "void main(){ color=vec4(0); for(int i=0;i<4;i++){ color+=texture(t,uv*float(i)); if(uv.x*float(i)>1.) continue; color.x+=1.;} }",
    ),
    ("cube", "void main(){ color=vec4(0); if(nrm.x>.5) color=texture(sky,nrm); }"),
    (
        "dfdx",
        "void main(){ color=vec4(0); if(uv.x>.5) color=vec4(dFdx(uv.x),dFdy(uv.y),fwidth(uv.x),1); }",
    ),
    ("disc", "void main(){ if(uv.x<0.1) discard; color=texture(t,uv); }"),
    (
        "dowh",
        "void main(){ float a=0.; color=vec4(0); do { a+=.1; color+=texture(t,uv); } while(a<uv.x); }",
    ),
    ("earlyret", "void main(){ color=vec4(1); if(uv.x<0.1) return; color=texture(t,uv); }"),
    ("fc", "void main(){ color=vec4(0); if(gl_FragCoord.x>4.) color=texture(t,uv); }"),
    (
        "fetch",
        "void main(){ color=vec4(0); if(nrm.x>.5) color=texelFetch(t,ivec2(uv),0)+vec4(textureSize(t,0),0,0); }",
    ),
    ("front", "void main(){ color=vec4(0); if(gl_FrontFacing) color=texture(t,uv); }"),
    ("glob2", "float g=1.0; void main(){ color=vec4(0); if(g>.5) color=texture(t,uv); }"),
    (
        "global",
        "float g; void f(){ g=uv.x; } void main(){ g=k; color=vec4(0); if(g>.5) color=texture(t,uv); f(); }",
    ),
    (
        "helper",
        "vec4 f(vec2 p){ return texture(t,p);} void main(){ color=vec4(0); if(uv.x>.5) color=f(uv); }",
    ),
    (
        "helper2",
        "vec4 f(vec2 p){ if(p.x<0.) return vec4(0); return texture(t,p);} void main(){ color=f(uv)+f(uv*2.); }",
    ),
    (
        "helper3",
        "vec4 f(vec2 p,float q){ if(q<0.) return vec4(0); return texture(t,p);} void main(){ color=f(uv,k)+f(uv*2.,k); }",
    ),
    (
        "helper4",
        "bool f(vec2 p){ return p.x>0.;} void main(){ color=vec4(0); if(f(vec2(k))) color=texture(t,uv); }",
    ),
    (
        "inv",
        "uniform mat4 m; void main(){ color=inverse(m)*vec4(uv,0,1)+vec4(transpose(mat3(m))*nrm,determinant(m)); }",
    ),
    (
        "local",
        "void main(){ float a=k; if(uv.x>.5) a=1.; color=vec4(0); if(a>.5) color=texture(t,uv); }",
    ),
    ("local2", "void main(){ float a=uv.x; a=k; color=vec4(0); if(a>.5) color=texture(t,uv); }"),
    (
        "lod",
        "void main(){ color=vec4(0); if(nrm.x>.5) color=textureLod(t,uv,1.0)+textureGrad(t,uv,vec2(.1),vec2(.1)); }",
    ),
    ("loopc", "void main(){ color=vec4(0); for(int i=0;i<4;i++) color+=texture(t,uv*float(i)); }"),
    ("loopu", "void main(){ color=vec4(0); for(int i=0;i<n;i++) color+=texture(t,uv*float(i)); }"),
    ("loopv", "void main(){ color=vec4(0); for(int i=0;i<id;i++) color+=texture(t,uv*float(i)); }"),
    ("negshift", "void main(){ int a=1<<id; color=vec4(a%3, -7/2, 5%(-3), 1); }"),
    (
        "nest",
        "vec4 g(vec2 p){return texture(t,p);} vec4 f(vec2 p){ return g(p)*2.;} void main(){ color=vec4(0); if(on){ if(id>2) color=f(uv); } }",
    ),
    (
        "outp",
        "void f(out float x){ x=uv.x; } void main(){ float a; f(a); color=vec4(0); if(a>.5) color=texture(t,uv); }",
    ),
    (
        "outp2",
        "void f(inout float x){ x+=k; } void main(){ float a=1.; f(a); color=vec4(0); if(a>.5) color=texture(t,uv); }",
    ),
    ("proj", "void main(){ color=vec4(0); if(nrm.x>.5) color=textureProj(t,vec3(uv,1)); }"),
    (
        "retloop",
        "void main(){ color=vec4(0); for(int i=0;i<4;i++){ color+=texture(t,uv*float(i)); if(uv.x*float(i)>1.) return; } }",
    ),
    ("shadow", "void main(){ color=vec4(0); if(uv.x>.5) color=vec4(texture(sh,vec3(uv,.5))); }"),
    (
        "structc",
        "struct S{float a;float b;}; void main(){ S s=S(uv.x,k); color=vec4(0); if(s.b>.5) color=texture(t,uv); }",
    ),
    (
        "structw",
        "struct S{float a;float b;}; void main(){ S s; s.a=uv.x; s.b=k; color=vec4(0); if(s.b>.5) color=texture(t,uv); }",
    ),
    ("tern", "void main(){ color = uv.x>.5 ? texture(t,uv) : vec4(0); }"),
    ("tern2", "void main(){ color = on ? texture(t,uv) : vec4(0); }"),
    (
        "texcond",
        "void main(){ vec4 a=texture(t,uv); color=vec4(0); if(a.x>.5) color=texture(t,uv*2.); }",
    ),
    ("ubranch", "void main(){ color=vec4(0); if(on) color=texture(t,uv); }"),
    (
        "vecw",
        "void main(){ vec3 a=vec3(k); a.x=uv.x; color=vec4(0); if(a.y>.5) color=texture(t,uv); }",
    ),
    (
        "whil",
        "void main(){ float a=0.; color=vec4(0); while(a<uv.x){ a+=.1; color+=texture(t,uv); } }",
    ),
];

fn ported(source: &Source) -> Result<Ported, Vec<Diagnostic>> {
    let mut options = PortOptions::default();
    options.dialect = Dialect::Wgsl;
    port(source, &options)
}

/// The line and the text of the main place of each diagnostic.
fn places(text: &str, found: &[Diagnostic]) -> Vec<(usize, String)> {
    let place = |diagnostic: &Diagnostic| {
        let at = diagnostic.labels[0].at;
        let line = text[..at.start as usize].matches('\n').count() + 1;
        (line, text[at.start as usize..at.end as usize].to_string())
    };
    found.iter().map(place).collect()
}

#[test]
fn tint_refuses_what_landfall_warns_of() {
    let mut warned = 0;
    for (name, body) in BODIES {
        let text = format!("{HEAD}{body}\n");
        let made = ported(&Source::new("test.frag", text.as_str()))
            .unwrap_or_else(|found| panic!("{name}: {found:?}"));
        let wgsl = &made.source.text;
        assert!(naga::front::wgsl::parse_str(wgsl).is_ok(), "{name}: {wgsl}");
        assert_eq!(tint::errors(wgsl), "", "{name}: {wgsl}");
        assert_eq!(wgsl.starts_with(OFF), !made.warnings.is_empty(), "{name}: {wgsl}");
        let refused = tint::errors(wgsl.trim_start_matches(OFF));
        assert_eq!(refused.is_empty(), made.warnings.is_empty(), "{name}: {refused}\n{wgsl}");
        for (line, place) in places(&text, &made.warnings) {
            let named = ["texture", "dFdx", "dFdy", "fwidth"].iter().any(|it| place.contains(it));
            assert!(
                line == 12 + body[..body.find("main").unwrap_or(0)].matches('\n').count(),
                "{name}"
            );
            assert!(named, "{name}: `{place}`");
        }
        warned += usize::from(!made.warnings.is_empty());
    }
    assert!(warned >= 25 && BODIES.len() >= warned + 15, "{warned} of {}", BODIES.len());
}

#[test]
fn tint_takes_every_shader_that_is_ported() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut taken = 0;
    for folder in
        ["six_lights", "casters", "view_space", "light_arrays", "many_lights", "ideas", "seed"]
    {
        for entry in std::fs::read_dir(root.join("shaders").join(folder)).expect("a folder") {
            let path = entry.expect("an entry").path();
            let Ok(source) = Source::read(&path) else { continue };
            let Ok(made) = ported(&source) else { continue };
            assert_eq!(tint::errors(&made.source.text), "", "{}", source.path);
            taken += 1;
        }
    }
    assert!(taken >= 40, "{taken}");
}

#[test]
fn barriers_are_those_of_workgroups() {
    let text = |at: &str| {
        format!(
            "#version 450\nlayout(local_size_x = 64) in;\n\
             layout(std430, binding = 0) buffer B {{ float v[]; }};\nshared float s[64];\n\
             void main() {{\n    uint i = gl_LocalInvocationID.x;\n    s[i] = v[i];\n    {at};\n    \
             v[i] = s[63u - i];\n}}\n"
        )
    };
    let made = ported(&Source::new("test.comp", text("barrier()"))).expect("it is ported");
    assert_eq!(tint::errors(&made.source.text), "");
    let apart = text("if (i < 32u) barrier()");
    let found = ported(&Source::new("test.comp", apart.as_str())).expect_err("it is refused");
    assert_eq!(places(&apart, &found)[0].0, 8, "{found:?}");
}

#[test]
fn errors_of_naga_are_at_the_line_of_the_user() {
    for (line, place, body) in [
        (14, "noSuch", "void main() {\n  color = vec4(0);\n  color.x = noSuch(uv);\n}\n"),
        (12, "mm", "uniform mat3x2 mm;\nvoid main() { color = vec4(mm * nrm, 0, 1); }\n"),
        (13, "precise", "// x\nprecise float f(float x);\nvoid main() { color = vec4(f(k)); }\n"),
        (12, "double", "double d;\nvoid main() { color = vec4(float(d)); }\n"),
        (12, "w", "uniform float w[4];\nvoid main() { color = vec4(w[1]); }\n"),
        (
            13,
            "switch",
            "void main() {\n  switch (id) { case 0: color = vec4(1); case 1: color = vec4(2); }\n}\n",
        ),
        (
            13,
            "s",
            "struct S { sampler2D a[2]; };\nuniform S s;\nvoid main() { color = texture(s.a[0], uv); }\n",
        ),
    ] {
        let text = format!("{HEAD}{body}");
        let found = ported(&Source::new("test.frag", text.as_str())).expect_err(body);
        let (at, said) = places(&text, &found).swap_remove(0);
        assert_eq!(at, line, "{body}: {found:?}");
        assert!(said.contains(place), "{body}: `{said}`: {found:?}");
    }
}
