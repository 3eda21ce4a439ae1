//! A probe whose results are pixels, for WebGL 2, which has no buffers that a shader writes.
//!
//! Each pixel (or vertex, in the vertex stage) makes all reads of the plan and returns one of their
//! words; indices known only at run time come from uniforms.

use std::fmt::Write as _;

use super::glsl::reads;
use super::plan::Plan;
use crate::backend::LooseUniform;
use landfall_layout::layout::BlockLayout;
use landfall_layout::source::Stage;

/// The uniform that holds the indices, four in an element.
const INDICES: &str = "landfall_indices";

/// Returns a declaration in GLSL ES 3.00 followed by a probe, which runs in the fragment stage
/// unless it is asked for in the vertex stage; and the text of the other stage.
pub(crate) fn texts(
    declared: &str,
    block: &BlockLayout,
    element: &[u32],
    plan: &Plan,
    stage: Stage,
) -> [(Stage, String); 2] {
    let mut text = declared.to_string();
    let vectors = plan.indices.len().div_ceil(4);
    if vectors > 0 {
        let _ = writeln!(text, "uniform uvec4 {INDICES}[{vectors}];");
    }
    // The reads write an array of that name, as those of the other stages write a buffer.
    let _ = writeln!(text, "uint landfall_words[{}];", plan.words.max(1));
    let vertex = stage == Stage::Vertex;
    text.push_str(match vertex {
        true => "flat out uvec4 landfall_result;\n",
        false => "layout(location = 0) out uvec4 landfall_result;\n",
    });
    let mut body = String::new();
    for at in 0..plan.indices.len() {
        let component = ["x", "y", "z", "w"][at % 4];
        let _ = writeln!(body, "    landfall_words[{at}] = {INDICES}[{}].{component};", at / 4);
    }
    reads(&mut text, &mut body, block, element, plan);
    let own = if vertex { "gl_VertexID" } else { "int(gl_FragCoord.x)" };
    let _ = writeln!(body, "    landfall_result = uvec4(landfall_words[{own}], 0u, 0u, 0u);");
    // Each vertex is drawn in the pixel of its number.
    if vertex {
        let _ = writeln!(
            body,
            "    gl_Position = vec4((float(gl_VertexID) + 0.5) / {}.0 * 2.0 - 1.0, 0.0, 0.0, 1.0);\n    \
             gl_PointSize = 1.0;",
            plan.words.max(1)
        );
    }
    let _ = writeln!(text, "void main() {{\n{body}}}");
    match vertex {
        true => [(Stage::Vertex, text), (Stage::Fragment, PASSING.to_string())],
        false => [(Stage::Vertex, COVERING.to_string()), (Stage::Fragment, text)],
    }
}

/// A vertex stage of a triangle over the image.
pub(crate) const COVERING: &str = "#version 300 es\nvoid main() {\n    gl_Position = \
     vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n}\n";

/// A fragment stage that returns what the vertex stage found.
const PASSING: &str = "#version 300 es\nprecision highp float;\nprecision highp int;\n\
     flat in uvec4 landfall_result;\nlayout(location = 0) out uvec4 landfall_pixel;\n\
     void main() { landfall_pixel = landfall_result; }\n";

/// Returns the values of the indices.
pub(crate) fn indices(plan: &Plan) -> Vec<LooseUniform> {
    let element = |(at, four): (usize, &[u32])| {
        let mut words = four.to_vec();
        words.resize(4, 0);
        LooseUniform { name: format!("{INDICES}[{at}]"), words }
    };
    plan.indices.chunks(4).enumerate().map(element).collect()
}
