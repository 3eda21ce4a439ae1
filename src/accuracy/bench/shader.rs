//! A shader over a stage's fragments on a reader, as a workload.
//!
//! What is uploaded is made once before; a run is the jobs of [`fragments`](crate::run::fragments)
//! with their upload and read-back, of which a shader that only adds its inputs up has as much.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use super::clock::{self, Took, took};
use super::errors::Errors;
use super::report::Work;
use super::rounds::{Part, Workload};
use super::scene::Stage;
use crate::Options;
use crate::light::bind::{Excess, Lit};
use crate::light::render::tally::Tally;
use crate::light::render::{self, Draw, Prepared, RenderError, Renderer};
use crate::run::eval::{Cpu, Settings};
use crate::run::fragments::{FragmentShader, Input, InputKind};
use crate::run::reader::Reader;
use crate::source::Source;

/// A reader that several workloads take turns with.
pub type Shared = Rc<RefCell<Box<dyn Reader>>>;

/// A shader over a stage's fragments.
pub struct Shader<'a> {
    stage: &'a Stage,
    renderer: &'a Renderer,
    reader: Shared,
    limit: Duration,
    whole: Vec<Prepared>,
    unlit: Option<Vec<Prepared>>,
    trivial: Option<(FragmentShader, Prepared)>,
    /// Lights that a whole run evaluates at a fragment, and one without lights.
    evaluated: [u64; 2],
}

impl<'a> Shader<'a> {
    /// A shader by a reader, which has `limit` for a job.
    ///
    /// # Errors
    /// The scene does not go into the shader.
    pub fn new(
        stage: &'a Stage,
        renderer: &'a Renderer,
        reader: Shared,
        limit: Duration,
    ) -> Result<Shader<'a>, RenderError> {
        let [directional, point, spot] = renderer.lights(&stage.upload, Excess::Refuse)?;
        let all = Lit { ambient: true, directional: &directional, point: &point, spot: &spot };
        let none = Lit { ambient: true, directional: &[], point: &[], spot: &[] };
        let work = render::Work {
            upload: &stage.upload,
            frame: &stage.frame,
            background: Default::default(),
            limit,
        };
        let prepare = |lights: Lit<'_>| -> Result<Vec<Prepared>, RenderError> {
            stage
                .by_material()
                .map(|fragments| {
                    let fragments: Vec<_> = fragments.iter().collect();
                    let draw = Draw { fragments: &[], lights, tiles: None };
                    renderer.prepare(&work, &fragments, &draw)
                })
                .collect()
        };
        let evaluated = [renderer.evaluated(&all), renderer.evaluated(&none)];
        let whole = prepare(all)?;
        // A shader without counts evaluates lights of zeros.
        let unlit = if evaluated[1] == 0 { Some(prepare(none)?) } else { None };
        let is_gl = reader.borrow().device().reader == "gl";
        let trivial = trivial(&renderer.shader, is_gl, stage.frame.fragments.len());
        Ok(Shader { stage, renderer, reader, limit, whole, unlit, trivial, evaluated })
    }

    /// What it gives, how far that is from the reference, and what it does for that.
    ///
    /// # Errors
    /// What the reader says.
    pub fn judged(&mut self) -> Result<(Errors, Work), String> {
        let mut colors: Vec<[f32; 3]> = Vec::with_capacity(self.stage.frame.fragments.len());
        for prepared in &self.whole {
            let mut reader = self.reader.borrow_mut();
            let shaded = self
                .renderer
                .shader
                .run(reader.as_mut(), &prepared.batch(self.limit), |_, _| {})
                .map_err(|failure| failure.message)?;
            colors.extend(shaded.colors.iter().map(|[r, g, b, _]| [*r, *g, *b]));
        }
        let blocks = self.whole.iter().flat_map(|prepared| &prepared.blocks);
        let work = Work {
            evaluations: Some(self.evaluated[0] as f64),
            slots: None,
            powers: None,
            operations: self.operations(),
            bytes: Some(blocks.map(|block| block.len() as u64).sum()),
        };
        Ok((self.stage.errors(&colors), work))
    }

    /// Operations for a fragment, which the evaluator counts whoever is measured; of some
    /// fragments where there are many.
    fn operations(&self) -> Option<f64> {
        const ENOUGH: usize = 4096;
        let mut cpu = Cpu::new(Settings::default());
        let (mut tally, mut fragments) = (Tally::default(), 0);
        for prepared in &self.whole {
            let share = (ENOUGH * prepared.count).div_ceil(self.stage.frame.fragments.len().max(1));
            let stride = prepared.count.div_ceil(share.max(1)).max(1);
            let inputs: Vec<Vec<[f32; 4]>> = prepared
                .inputs
                .iter()
                .map(|values| values.iter().copied().step_by(stride).collect())
                .collect();
            let count = prepared.count.div_ceil(stride);
            let some = Prepared { inputs, count, ..prepared.clone() };
            let ran = self.renderer.shader.run(&mut cpu, &some.batch(self.limit), |cpu, _| {
                tally.add(&cpu.notes);
            });
            ran.ok()?;
            fragments += count;
        }
        (fragments > 0).then(|| tally.counts.operations() as f64 / fragments as f64)
    }
}

impl Workload for Shader<'_> {
    fn has(&self, part: Part) -> bool {
        match part {
            Part::Whole => true,
            Part::Unlit => self.unlit.is_some(),
            Part::Trivial => self.trivial.is_some(),
        }
    }

    fn run(&mut self, part: Part) -> Result<Option<Took>, String> {
        let shader = &self.renderer.shader;
        let (shader, prepared): (_, &[Prepared]) = match (part, &self.unlit, &self.trivial) {
            (Part::Whole, ..) => (shader, &self.whole),
            (Part::Unlit, Some(unlit), _) => (shader, unlit),
            (Part::Trivial, _, Some((shader, prepared))) => {
                (shader, std::slice::from_ref(prepared))
            }
            (Part::Unlit, None, _) | (Part::Trivial, _, None) => {
                return Err("it has no such part".to_string());
            }
        };
        let mut reader = self.reader.borrow_mut();
        let mut own = Vec::new();
        for prepared in prepared {
            let mut began = Instant::now();
            shader
                .run(reader.as_mut(), &prepared.batch(self.limit), |reader, _| {
                    own.push(took(reader, began));
                    began = Instant::now();
                })
                .map_err(|failure| failure.message)?;
        }
        Ok(clock::sum(own))
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
