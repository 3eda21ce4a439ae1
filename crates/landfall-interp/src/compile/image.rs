//! Compiles image expressions: two-dimensional, one level, four floats a texel, nearest sampling.

use std::rc::Rc;

use naga::{Expression, Handle, ImageClass, ImageDimension, ImageQuery, ScalarKind, TypeInner};

use super::super::code::{Class, Op, Reg};
use super::function::Function;

impl Function<'_, '_> {
    pub fn image(&mut self, handle: Handle<Expression>) -> Result<Rc<[Reg]>, String> {
        // The result may be of lower precision than the coordinates.
        self.b.rounds = false;
        let arena = self.arena;
        match &arena[handle] {
            Expression::ImageSample {
                image,
                coordinate,
                array_index,
                offset,
                depth_ref,
                gather,
                ..
            } => {
                self.plain_image(*image)?;
                if array_index.is_some() || depth_ref.is_some() || gather.is_some() {
                    return Err("array textures, shadow lookups and gathers".into());
                }
                if offset.is_some() {
                    return Err("texture lookups with an offset".into());
                }
                self.texel(Op::Sample, *image, *coordinate)
            }
            Expression::ImageLoad { image, coordinate, array_index, sample, .. } => {
                self.plain_image(*image)?;
                if array_index.is_some() || sample.is_some() {
                    return Err("array and multisampled textures".into());
                }
                self.texel(Op::Texel, *image, *coordinate)
            }
            Expression::ImageQuery { image, query } => {
                self.plain_image(*image)?;
                let image = self.scalar(*image)?;
                match query {
                    // There is one level, so its number is not looked at.
                    ImageQuery::Size { .. } => {
                        let to = self.b.temporaries(Class::Word, 2);
                        self.b.push(Op::ImageSize, &[], &[to[0].0, to[1].0, image.0]);
                        Ok(to.into())
                    }
                    ImageQuery::NumLevels | ImageQuery::NumLayers | ImageQuery::NumSamples => {
                        Ok([self.b.word(1)].into())
                    }
                }
            }
            _ => Err("an image expression of another kind".into()),
        }
    }

    fn texel(
        &mut self,
        op: Op,
        image: Handle<Expression>,
        coordinate: Handle<Expression>,
    ) -> Result<Rc<[Reg]>, String> {
        let image = self.scalar(image)?;
        let at = self.regs(coordinate)?;
        let to = self.b.temporaries(Class::Real, 4);
        let mut operands: Vec<u32> = to.iter().map(|reg| reg.0).collect();
        operands.extend([image.0, at[0].0, at[1].0]);
        self.b.push(op, &[], &operands);
        Ok(to.into())
    }

    fn plain_image(&self, image: Handle<Expression>) -> Result<(), String> {
        let floats = ImageClass::Sampled { kind: ScalarKind::Float, multi: false };
        match self.ty(image) {
            TypeInner::Image { dim: ImageDimension::D2, arrayed: false, class }
                if *class == floats =>
            {
                Ok(())
            }
            _ => Err("textures other than `texture_2d<f32>`".into()),
        }
    }
}
