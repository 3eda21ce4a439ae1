//! The results that any conformant device may give for fragments: the interpreter runs the shader
//! with the error bounds of WGSL and Vulkan.
//!
//! Packs as [`batch`](super::batch) does; used by `bench` of landfall-light.

use super::batch::Batch;
use super::{ATLAS, FragmentShader};
use crate::backend::{Failure, Resource, ResourceKind};
use landfall_interp::{Invocations, Port, Precision, Program, Settings};

/// The permitted results of a list of fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Permitted {
    /// The least and greatest value of each channel of each fragment; infinite if any value is
    /// permitted.
    pub colors: Vec<[[f64; 2]; 4]>,
    /// Whether a branch of the fragment may go the other way on another device.
    pub unsure: Vec<bool>,
}

impl FragmentShader {
    /// Runs the shader over fragments and returns all results that conformant devices may give.
    ///
    /// # Errors
    /// Fails if the batch does not fit the shader, or the interpreter has no bounds for it, as for
    /// `f16`.
    pub fn permitted(&self, batch: &Batch<'_>) -> Result<Permitted, Failure> {
        self.fits(batch)?;
        if batch.count == 0 {
            return Ok(Permitted::default());
        }
        let program = Program::new(&self.module, &[]);
        let packed = self.pack(batch, 0, batch.count, batch.count);
        let mut resources = self.for_module(batch);
        let (group, binding) = self.atlas;
        let kind = ResourceKind::Texture {
            width: packed.width,
            height: packed.height,
            texels: packed.texels,
        };
        resources.push(Resource { name: ATLAS.to_string(), group, binding, kind });
        let single = |x: f32| u64::from(x.to_bits());
        // One row: fragment number `x` is the pixel at `x`.
        let columns = (0..batch.count).map(|x| single(x as f32 + 0.5)).collect();
        let same = |x: f32| vec![single(x); batch.count];
        let place = vec![columns, same(0.5), same(0.0), same(1.0)];
        let inputs = vec![(Port::Position, place), (Port::FrontFacing, vec![vec![1; batch.count]])];
        let invocations = Invocations { count: batch.count, inputs };
        let settings = Settings {
            precision: Precision::Permitted,
            deadline: landfall_interp::backend::deadline(batch.limit),
            ..Settings::default()
        };
        let outputs = program.run_entry(&self.entry, &invocations, &resources, &settings)?;
        let first = outputs.ports.iter().find(|(port, _)| *port == Port::Location(0));
        let spans = match first {
            Some((_, numbers)) => match &numbers.permitted {
                Some(spans) => &spans[..],
                None => {
                    return Err(Failure::refused(
                        "the output at location 0 is not a float, so no error bound is known for it",
                        "",
                    ));
                }
            },
            None => &[],
        };
        // Outputs that are not written are black, as on every backend.
        let at = |lane: usize, channel: usize| spans.get(channel).map_or([0.0; 2], |s| s[lane]);
        let color = |lane: usize| [0, 1, 2, 3].map(|channel| at(lane, channel));
        Ok(Permitted { colors: (0..batch.count).map(color).collect(), unsure: outputs.unsure })
    }
}
