//! Textures of a scene that a shader ignores though the reference applies them.
//!
//! Found by running: the shader's light of a few fragments is the same, bit for bit, with the
//! surface black and white, while the reference's is not.

use glam::DVec3;

use super::{Draw, RenderError, Renderer, Work};
use crate::bind::MaterialPart;
use crate::plan::LightSet;
use crate::reference::{Model, shade};
use crate::scene::{Material, Surface};
use crate::{Upload, sample};
use landfall_interp::{Cpu, Settings};

/// The most fragments of a material that are run.
const ENOUGH: usize = 64;

/// The least difference of the reference, in linear light: half a step of 8 bits.
const SEEN: f64 = 0.5 / 255.0;

impl Renderer {
    /// Returns a line for each texture that the shader ignores and the reference applies.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the interpreter.
    pub fn ignored(&self, work: &Work<'_>, model: &Model) -> Result<Vec<String>, RenderError> {
        let mut lines = Vec::new();
        for (number, material) in work.upload.materials.iter().enumerate() {
            let of_material: Vec<u32> = (0..work.frame.fragments.len() as u32)
                .filter(|at| work.frame.fragments[*at as usize].material as usize == number)
                .collect();
            let step = of_material.len().div_ceil(ENOUGH).max(1);
            let some: Vec<u32> = of_material.into_iter().step_by(step).collect();
            for (part, surface) in [
                (MaterialPart::Diffuse, &material.diffuse),
                (MaterialPart::Specular, &material.specular),
            ] {
                if !matches!(surface, Surface::Texture(_)) || some.is_empty() {
                    continue;
                }
                if self.ignores(work, model, number, part, &some)? {
                    lines.push(format!(
                        "the shader ignores the {} texture of `{}`, which the reference applies",
                        part.name(),
                        material.name
                    ));
                }
            }
        }
        Ok(lines)
    }

    fn ignores(
        &self,
        work: &Work<'_>,
        model: &Model,
        number: usize,
        part: MaterialPart,
        fragments: &[u32],
    ) -> Result<bool, RenderError> {
        // With the surface black and white, a shader that reads it gives different light.
        let flat = |color: DVec3| {
            let mut upload = work.upload.clone();
            *surface(&mut upload.materials[number], part) = Surface::Constant(color);
            upload
        };
        let uploads = [flat(DVec3::ZERO), flat(DVec3::ONE)];
        let differs = fragments.iter().any(|at| {
            let fragment = &work.frame.fragments[*at as usize];
            let light = |upload: &Upload| {
                let texels = sample::texels(&upload.materials[number], fragment.uv);
                shade(model, upload, fragment, &texels).ok().map(|shaded| shaded.total)
            };
            let [black, white] = [light(&uploads[0]), light(&uploads[1])];
            black.zip(white).is_some_and(|(a, b)| (a - b).abs().max_element() > SEEN)
        });
        // Where the reference does not differ either, the texture has no effect to ignore.
        if !differs {
            return Ok(false);
        }
        let lights = &LightSet::all(&work.upload.lights);
        let mut cpu = self.cpu(Settings::default());
        let mut run = |upload: &Upload| {
            let work = Work { upload, ..*work };
            let draw = Draw { fragments, lights, tiles: None };
            self.render(&mut cpu, &work, &[draw], &mut |_: &mut Cpu, _| {})
        };
        let [black, white] = [run(&uploads[0])?, run(&uploads[1])?];
        let bits = |pixel: &[f32; 4]| pixel.map(f32::to_bits);
        let mut pairs = black.picture.pixels.iter().zip(&white.picture.pixels);
        Ok(pairs.all(|(a, b)| bits(a) == bits(b)))
    }
}

fn surface(material: &mut Material, part: MaterialPart) -> &mut Surface {
    match part {
        MaterialPart::Specular => &mut material.specular,
        MaterialPart::Ambient => &mut material.ambient,
        MaterialPart::Diffuse | MaterialPart::Shininess | MaterialPart::Reflectance => {
            &mut material.diffuse
        }
    }
}
