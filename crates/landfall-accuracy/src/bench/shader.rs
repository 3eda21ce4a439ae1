//! A shader over a scene's fragments on a backend, as a workload.
//!
//! The uploads are prepared once ([`Uploaded`]); a run is the jobs of
//! [`fragments`](landfall_exec::harness::fragments), including upload and read-back, which a shader
//! that only sums up its inputs measures alone.

use landfall_exec::backend::BackendKind;
use std::cell::RefCell;
use std::rc::Rc;

use super::clock::{BackendStopwatch, Elapsed};
use super::errors::Errors;
use super::rounds::{Part, Workload};
use super::uploaded::Uploaded;
use landfall_exec::backend::Backend;
use landfall_exec::harness::fragments::{FragmentShader, Input, InputKind};
use landfall_layout::Options;
use landfall_layout::source::Source;
use landfall_light::render::Prepared;
use landfall_light::render::limits::check_iterations;
use landfall_light::render::planned::FragmentGroup;

pub type SharedBackend = Rc<RefCell<Box<dyn Backend>>>;

/// A shader over a scene's fragments on a backend.
pub struct Shader<'a> {
    uploaded: &'a Uploaded<'a>,
    backend: SharedBackend,
    trivial: Option<(FragmentShader, Prepared)>,
}

impl<'a> Shader<'a> {
    pub fn new(uploaded: &'a Uploaded<'a>, backend: SharedBackend) -> Shader<'a> {
        let is_gl = backend.borrow().device().backend == BackendKind::Gl;
        let fragments = uploaded.stage.frame.fragments.len();
        let trivial = trivial(&uploaded.renderer.shader, is_gl, fragments);
        Shader { uploaded, backend, trivial }
    }

    /// Returns the errors of its colours against the reference.
    ///
    /// # Errors
    /// A failure of the backend, or more lights than its driver loops over.
    pub fn measure_errors(&mut self) -> Result<Errors, String> {
        let Uploaded { stage, renderer, limit, whole, .. } = self.uploaded;
        let mut colors = vec![[0.0; 3]; stage.frame.fragments.len()];
        for FragmentGroup { fragments, prepared, walked, .. } in whole {
            let mut backend = self.backend.borrow_mut();
            check_iterations(backend.device(), *walked).map_err(|failure| failure.summary())?;
            let shaded = renderer
                .shader
                .run(backend.as_mut(), &prepared.batch(*limit), |_, _| {})
                .map_err(|failure| failure.summary())?;
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

    fn run(&mut self, part: Part) -> Result<Option<Elapsed>, String> {
        let Uploaded { renderer, limit, whole, unlit, .. } = self.uploaded;
        let shader = &renderer.shader;
        let (shader, prepared): (_, Vec<&Prepared>) = match (part, unlit, &self.trivial) {
            (Part::Whole, ..) => (shader, whole.iter().map(|lot| &lot.prepared).collect()),
            (Part::Unlit, Some(unlit), _) => (shader, unlit.iter().collect()),
            (Part::Trivial, _, Some((shader, prepared))) => (shader, vec![prepared]),
            (Part::Unlit, None, _) | (Part::Trivial, _, None) => {
                return Err(
                    "internal error: the fragments of this run were not prepared".to_string()
                );
            }
        };
        let mut backend = self.backend.borrow_mut();
        let mut watched = BackendStopwatch::new(backend.as_mut());
        for prepared in prepared {
            shader
                .run(&mut watched, &prepared.batch(*limit), |_, _| {})
                .map_err(|failure| failure.summary())?;
        }
        Ok(watched.elapsed())
    }
}

/// Returns a shader with the same inputs that only sums them up.
fn trivial(
    shader: &FragmentShader,
    is_gl: bool,
    count: usize,
) -> Option<(FragmentShader, Prepared)> {
    // GLSL 3.30 is the oldest version with matching inputs by name; Vulkan wants locations.
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
        // Every input is read, or the compiler would drop it with its upload.
        sum += &format!(" + vec4(float(i{i}{first}))");
    }
    let place = if is_gl { "" } else { "layout(location = 0) " };
    text += &format!("{place}out vec4 color;\nvoid main() {{ color = {sum}; }}\n");
    // The file extension determines the stage.
    let source = Source::new("trivial.frag", text);
    let shader = FragmentShader::new(&source, &Options::default(), None).ok()?;
    let inputs = vec![vec![[0.5; 4]; count]; shader.inputs().len()];
    Some((shader, Prepared { inputs, count, ..Prepared::default() }))
}
