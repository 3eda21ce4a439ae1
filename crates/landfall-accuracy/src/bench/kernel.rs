//! An empty function with the parameters and results of another one, to measure the cost of a call.
//!
//! Used by [`called`](super::called), which subtracts its time.

use std::fmt::Write as _;

use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
use landfall_layout::Options;
use landfall_layout::shape::{Scalar, ScalarKind};
use landfall_layout::source::Source;

/// Returns the empty function; `None` if GLSL has no type for a parameter or result.
pub(super) fn kernel(pure: &PureFunction) -> Option<PureFunction> {
    let given = spelled(pure.parameters.iter().flat_map(|parameter| parameter.ty.scalars()))?;
    let gives = spelled(pure.results.iter().flat_map(|result| result.ty.scalars()))?;
    let source = Source::new("trivial.frag", text(&given, &gives));
    // Results come from parameters where possible, so that a compiler cannot drop the uploads.
    let request = PureRequest { function: "trivial".to_string(), ..PureRequest::default() };
    PureFunction::new(&source, &Options::default(), &request).ok()
}

fn text(given: &[&str], gives: &[&str]) -> String {
    let mut text = String::from("#version 450\n");
    if !given.is_empty() {
        text += "struct Given {\n";
        given.iter().enumerate().for_each(|(i, ty)| _ = writeln!(text, "    {ty} g{i};"));
        text += "};\n";
    }
    text += "struct Gives {\n";
    gives.iter().enumerate().for_each(|(i, ty)| _ = writeln!(text, "    {ty} r{i};"));
    let taken = if given.is_empty() { "" } else { "Given given" };
    let _ = writeln!(text, "}};\nGives trivial({taken}) {{\n    Gives gives;");
    for (i, ty) in gives.iter().enumerate() {
        // Nothing is converted: the result is a parameter of its type, or zero.
        let same = given.iter().enumerate().filter(|(_, known)| known == &ty).map(|(i, _)| i);
        let same: Vec<usize> = same.collect();
        let value = match same.get(i % same.len().max(1)) {
            Some(at) => format!("given.g{at}"),
            None => format!("{ty}(0)"),
        };
        let _ = writeln!(text, "    gives.r{i} = {value};");
    }
    text + "    return gives;\n}\nvoid main() {}\n"
}

/// Returns the GLSL types of scalars; a half is a float, as in uploads.
fn spelled(scalars: impl Iterator<Item = Scalar>) -> Option<Vec<&'static str>> {
    let spelled = |scalar: Scalar| match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => Some("bool"),
        (ScalarKind::Sint, 4) => Some("int"),
        (ScalarKind::Uint, 4) => Some("uint"),
        (ScalarKind::Float, 2 | 4) => Some("float"),
        (ScalarKind::Float, 8) => Some("double"),
        _ => None,
    };
    scalars.map(spelled).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use landfall_interp::Settings;

    #[test]
    fn what_computes_nothing_is_given_the_same_words_and_gives_as_many() {
        let text = "#version 450
struct Light { vec3 position; bool on; };
layout(binding = 0) uniform Block { Light light; int count; };
vec2 f(mat2 m, out uint n) { n = 7u; return light.on ? m[0] * light.position.x : m[count]; }
void main() {}
";
        let source = Source::new("f.frag", text);
        let request = PureRequest { function: "f".to_string(), ..PureRequest::default() };
        let pure = PureFunction::new(&source, &Options::default(), &request).expect("it is pure");
        let kernel = kernel(&pure).expect("GLSL has all of its types");
        let scalars = |pure: &PureFunction| -> Vec<Scalar> {
            pure.parameters.iter().flat_map(|parameter| parameter.ty.scalars()).collect()
        };
        assert_eq!(scalars(&kernel), scalars(&pure));
        let gives = |pure: &PureFunction| -> Vec<Scalar> {
            pure.results.iter().flat_map(|result| result.ty.scalars()).collect()
        };
        assert_eq!(gives(&kernel), gives(&pure));
        let columns = vec![vec![0; 3]; scalars(&pure).len()];
        let called = kernel.call(&columns, 3, &Settings::default()).expect("it ends");
        assert_eq!(called.called.notes.counts.operations(), 0);
    }
}
