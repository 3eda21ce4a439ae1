//! A shader over a stage's fragments on a reader, as a workload.
//!
//! What is uploaded is made once before ([`Uploaded`]); a run is the jobs of [`fragments`](landfall_exec::harness::fragments)
//! with their upload and read-back, of which a shader that only adds its inputs up has as much.

use landfall_exec::backend::BackendKind;
use std::cell::RefCell;
use std::rc::Rc;

use super::clock::{Stopwatch, Took};
use super::errors::Errors;
use super::rounds::{Part, Workload};
use super::uploaded::Uploaded;
use crate::render::Prepared;
use crate::render::planned::Lot;
use landfall_exec::backend::Reader;
use landfall_exec::harness::fragments::{FragmentShader, Input, InputKind};
use landfall_layout::Options;
use landfall_layout::source::Source;

/// A reader that several workloads take turns with.
pub type Shared = Rc<RefCell<Box<dyn Reader>>>;

/// A shader over a stage's fragments, on a reader.
pub struct Shader<'a> {
    uploaded: &'a Uploaded<'a>,
    reader: Shared,
    trivial: Option<(FragmentShader, Prepared)>,
}

impl<'a> Shader<'a> {
    /// A shader by a reader.
    pub fn new(uploaded: &'a Uploaded<'a>, reader: Shared) -> Shader<'a> {
        let is_gl = reader.borrow().device().reader == BackendKind::Gl;
        let fragments = uploaded.stage.frame.fragments.len();
        let trivial = trivial(&uploaded.renderer.shader, is_gl, fragments);
        Shader { uploaded, reader, trivial }
    }

    /// How far what it gives is from the reference.
    ///
    /// # Errors
    /// What the reader says.
    pub fn judged(&mut self) -> Result<Errors, String> {
        let Uploaded { stage, renderer, limit, whole, .. } = self.uploaded;
        let mut colors = vec![[0.0; 3]; stage.frame.fragments.len()];
        for Lot { fragments, prepared, .. } in whole {
            let mut reader = self.reader.borrow_mut();
            let shaded = renderer
                .shader
                .run(reader.as_mut(), &prepared.batch(*limit), |_, _| {})
                .map_err(|failure| failure.brief())?;
            for (at, [r, g, b, _]) in fragments.iter().zip(&shaded.colors) {
                colors[*at as usize] = [*r, *g, *b];
            }
        }
        Ok(stage.errors(&colors))
    }
}

impl Workload for Shader<'_> {
    fn has(&self, part: Part) -> bool {
        match part {
            Part::Whole => true,
            Part::Unlit => self.uploaded.unlit.is_some(),
            Part::Trivial => self.trivial.is_some(),
        }
    }

    fn run(&mut self, part: Part) -> Result<Option<Took>, String> {
        let Uploaded { renderer, limit, whole, unlit, .. } = self.uploaded;
        let shader = &renderer.shader;
        let (shader, prepared): (_, Vec<&Prepared>) = match (part, unlit, &self.trivial) {
            (Part::Whole, ..) => (shader, whole.iter().map(|lot| &lot.prepared).collect()),
            (Part::Unlit, Some(unlit), _) => (shader, unlit.iter().collect()),
            (Part::Trivial, _, Some((shader, prepared))) => (shader, vec![prepared]),
            (Part::Unlit, None, _) | (Part::Trivial, _, None) => {
                return Err("it has no such part".to_string());
            }
        };
        let mut reader = self.reader.borrow_mut();
        let mut watched = Stopwatch::new(reader.as_mut());
        for prepared in prepared {
            shader
                .run(&mut watched, &prepared.batch(*limit), |_, _| {})
                .map_err(|failure| failure.brief())?;
        }
        Ok(watched.took())
    }
}

/// A shader of the same inputs that only adds them up.
fn trivial(
    shader: &FragmentShader,
    is_gl: bool,
    count: usize,
) -> Option<(FragmentShader, Prepared)> {
    let mut text = String::from(if is_gl { "#version 330\n" } else { "#version 450\n" });
    let mut sum = String::from("vec4(0.0)");
    let mut inputs: Vec<&Input> = shader.inputs().iter().collect();
    inputs.sort_by_key(|input| input.location);
    for (i, input) in inputs.iter().enumerate() {
        let (vector, scalar, flat) = match input.kind {
            InputKind::Float => ("vec", "float", ""),
            InputKind::Sint => ("ivec", "int", "flat "),
            InputKind::Uint => ("uvec", "uint", "flat "),
        };
        let ty = match input.components {
            1 => scalar.to_string(),
            n => format!("{vector}{n}"),
        };
        let place = if is_gl { String::new() } else { format!("layout(location = {i}) ") };
        text += &format!("{place}{flat}in {ty} i{i};\n");
        let first = if input.components == 1 { "" } else { ".x" };
        sum += &format!(" + vec4(float(i{i}{first}))");
    }
    let place = if is_gl { "" } else { "layout(location = 0) " };
    text += &format!("{place}out vec4 color;\nvoid main() {{ color = {sum}; }}\n");
    // The extension says the stage.
    let source = Source::new("trivial.frag", text);
    let shader = FragmentShader::new(&source, &Options::default(), None).ok()?;
    let inputs = vec![vec![[0.5; 4]; count]; shader.inputs().len()];
    Some((shader, Prepared { inputs, count, ..Prepared::default() }))
}
