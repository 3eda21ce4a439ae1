//! Texture functions, old and new (GLSL 4.60 §8.9, GLSL 1.20 §8.7).

use naga::{BinaryOperator as B, Expression, Handle, ImageDimension, ImageQuery, SampleLevel};

use super::Lowering;
use super::ast::{Binary, Expr};
use super::body::{Body, TypedValue};
use super::opaque::{HandleChoice, HandlePair};
use super::types::{Image, Kind, Opaque, Ty};
use landfall_layout::source::Stage;

/// The properties of a texture function, from its name.
#[derive(Clone, Copy, Debug, Default)]
struct TextureForm {
    /// Coordinates are divided by their last component.
    projected: bool,
    lod: bool,
    grad: bool,
    offset: bool,
    fetch: bool,
    gather: bool,
    /// GLSL 1.20's `shadow2D`: the result is a vec4.
    shadow_vector: bool,
}

/// Returns the properties of a texture function by its name.
fn form(name: &str) -> Option<TextureForm> {
    // A base, then suffixes: texture [dimension, in GLSL 1.20] ["Proj"] ["Lod" | "Grad"] ["Offset"]
    // | "textureGather" ["Offset"] | "texelFetch" ["Offset"] | GLSL 1.20's `shadow2D`.
    let legacy = ["1D", "2D", "3D", "Cube", "2DRect", "1DArray", "2DArray", "2DShadow"];
    let (base, shadow_vector) = match name.strip_prefix("texture") {
        Some(rest) => (rest, false),
        None => match name.strip_prefix("texelFetch") {
            Some("") => return Some(TextureForm { fetch: true, ..TextureForm::default() }),
            Some("Offset") => {
                return Some(TextureForm { fetch: true, offset: true, ..TextureForm::default() });
            }
            Some(_) => return None,
            None => (name.strip_prefix("shadow")?, true),
        },
    };
    let mut rest = base;
    // The longest name first: `2DRect` begins with `2D`.
    let mut names: Vec<&str> = legacy.to_vec();
    names.sort_by_key(|n| std::cmp::Reverse(n.len()));
    let old = names.iter().find_map(|dim| base.strip_prefix(dim));
    match old {
        Some(after) => rest = after,
        None if shadow_vector => return None,
        None => {}
    }
    let mut form = TextureForm { shadow_vector, ..TextureForm::default() };
    for suffix in ["ARB", "EXT"] {
        rest = rest.strip_suffix(suffix).unwrap_or(rest);
    }
    while !rest.is_empty() {
        let (found, after) = [("Proj", 0), ("Lod", 1), ("Grad", 2), ("Offset", 3), ("Gather", 4)]
            .iter()
            .find_map(|(word, which)| Some((*which, rest.strip_prefix(word)?)))?;
        match found {
            0 => form.projected = true,
            1 => form.lod = true,
            2 => form.grad = true,
            3 => form.offset = true,
            _ => form.gather = true,
        }
        rest = after;
    }
    Some(form)
}

const QUERIES: &[&str] =
    &["textureSize", "textureQueryLevels", "textureSamples", "imageSize", "imageSamples"];

pub fn is_known(name: &str) -> bool {
    QUERIES.contains(&name) || form(name).is_some()
}

/// The arguments after the handle that are not consumed yet.
struct Operands {
    values: Vec<TypedValue>,
    next: usize,
}

impl Operands {
    fn take(&mut self) -> Option<TypedValue> {
        self.next += 1;
        self.values.get(self.next - 1).cloned()
    }
}

impl<'a> Body<'_, 'a> {
    /// Returns the handle, a call's first argument, and the values of the others.
    pub(super) fn handle_and_values(
        &mut self,
        name: &str,
        arguments: &[Expr<'a>],
        e: &Expr<'a>,
    ) -> Lowering<(HandleChoice, Vec<TypedValue>)> {
        let Some((first, rest)) = arguments.split_first() else {
            return self.refuse(format!("`{name}` takes at least one argument"));
        };
        let chosen = self.chosen(first)?;
        let values = self.values(rest)?;
        self.span = e.span;
        Ok((chosen, values))
    }

    /// Lowers a texture function; `None` if it is not one.
    pub fn texture_call(
        &mut self,
        name: &str,
        arguments: &[Expr<'a>],
        e: &Expr<'a>,
    ) -> Lowering<Option<TypedValue>> {
        if !is_known(name) {
            return Ok(None);
        }
        let (chosen, values) = self.handle_and_values(name, arguments, e)?;
        let image = match &chosen {
            HandleChoice::At(_, Ty::Opaque(opaque)) => opaque.clone(),
            HandleChoice::At(_, ty) => {
                return self.refuse(format!("`{name}` does not take a `{ty}`"));
            }
            HandleChoice::Joined(opaque, _) => opaque.clone(),
        };
        let (Opaque::Combined(image) | Opaque::Texture(image) | Opaque::Storage(image)) = image
        else {
            return self.refuse(format!("`{name}` does not take a `{image}`"));
        };
        if QUERIES.contains(&name) {
            return self.query(name, &chosen, &image, values).map(Some);
        }
        let Some(form) = form(name) else { return Ok(None) };
        let kind = image.kind;
        let vec4 = Ty::Vector(kind, 4);
        if form.fetch {
            let value = self.with_handle(&chosen, &vec4, |this, pair| {
                this.fetch(pair, &image, form, &mut Operands { values: values.clone(), next: 0 })
            })?;
            return Ok(Some(value));
        }
        let scalar = image.depth && !form.gather;
        let ty = if scalar { Ty::FLOAT } else { vec4 };
        let value = self.with_handle(&chosen, &ty, |this, pair| {
            this.sample(pair, &image, form, &mut Operands { values: values.clone(), next: 0 })
        })?;
        if scalar && form.shadow_vector {
            // GLSL 1.20's result is a vec4 whose first three components are the comparison.
            let one = self.number(Kind::Float, 1.0);
            let parts = vec![value.expr, value.expr, value.expr, one.expr];
            return self.compose(&Ty::Vector(Kind::Float, 4), parts).map(Some);
        }
        Ok(Some(value))
    }

    fn sample(
        &mut self,
        pair: &HandlePair,
        image: &Image,
        form: TextureForm,
        arguments: &mut Operands,
    ) -> Lowering<TypedValue> {
        let (texture, sampler) = (self.source(pair.image)?, self.source(pair.sampler)?);
        let Some(given) = arguments.take() else { return self.refuse("missing coordinates") };
        let given = self.float(&given)?;
        // Coordinates, the layer, the reference of a comparison, in this order (GLSL 4.60 §8.9).
        let own = coordinates(image);
        let (_, count) = given.ty.components().unwrap_or((Kind::Float, 1));
        let given = if form.projected { self.project(&given, count)? } else { given };
        let count = if form.projected { count - 1 } else { count };
        let first: Vec<u8> = (0..own).collect();
        if count < own + u8::from(image.arrayed) {
            return self.refuse(format!("expected coordinates, found `{}`", given.ty));
        }
        let mut coordinate =
            if own == count { given.clone() } else { self.select(&given, &first)? };
        let array_index = match image.arrayed {
            true => Some(self.layer(&given, own)?),
            false => None,
        };
        let depth = match image.depth {
            true => Some(self.reference(image, form, &given, arguments)?),
            false => None,
        };
        // A rectangle texture takes texels, naga's sampling takes 0 to 1.
        if image.rectangle && !form.gather {
            let size = self.texels(texture, 2)?;
            coordinate = self.operate(Binary::Divide, &coordinate, &size)?;
        }
        let mut level = self.level(image, form, arguments)?;
        let mut offset = None;
        if form.offset {
            let Some(by) = arguments.take() else { return self.refuse("missing offset") };
            if self.is_constant(by.expr) {
                offset = Some(by.expr);
            } else {
                // naga takes constant offsets only: others are added in texels.
                let size = self.texels(texture, own)?;
                let by = self.convert(&by, &Ty::new(Kind::Float, own))?;
                let by = self.operate(Binary::Divide, &by, &size)?;
                coordinate = self.operate(Binary::Add, &coordinate, &by)?;
            }
        }
        let mut gather = None;
        if form.gather {
            level = SampleLevel::Zero;
            gather = Some(self.gathered(arguments)?);
        } else if let (Some(bias), SampleLevel::Auto, false) =
            (arguments.take(), level, image.depth)
        {
            level = SampleLevel::Bias(self.coerce(&bias, &Ty::FLOAT)?.expr);
        }
        if image.kind != Kind::Float && gather.is_none() {
            return self.nearest(texture, image, &coordinate, array_index);
        }
        let expr = self.add(Expression::ImageSample {
            image: texture,
            sampler,
            gather,
            coordinate: coordinate.expr,
            array_index,
            offset,
            level,
            depth_ref: depth,
            clamp_to_edge: false,
        });
        let scalar = image.depth && gather.is_none();
        let ty = if scalar { Ty::FLOAT } else { Ty::Vector(image.kind, 4) };
        Ok(TypedValue { expr, ty })
    }

    /// Returns the array layer of coordinates, rounded (GLSL 4.60 §8.9).
    fn layer(&mut self, given: &TypedValue, at: u8) -> Lowering<Handle<Expression>> {
        let written = self.select(given, &[at])?;
        let half = self.number(Kind::Float, 0.5);
        let above = self.binary(B::Add, written.expr, half.expr);
        let layer = self.math(naga::MathFunction::Floor, &[above]);
        Ok(self.convert(&TypedValue { expr: layer, ty: Ty::FLOAT }, &Ty::INT)?.expr)
    }

    /// Returns the reference value of a depth comparison: the last component of the coordinates, or
    /// a separate argument for cube arrays and gathers.
    fn reference(
        &mut self,
        image: &Image,
        form: TextureForm,
        given: &TypedValue,
        arguments: &mut Operands,
    ) -> Lowering<Handle<Expression>> {
        let (_, count) = given.ty.components().unwrap_or((Kind::Float, 1));
        let used = coordinates(image) + u8::from(image.arrayed);
        // `sampler1DShadow` has an unused second coordinate.
        let inside = if image.dim == ImageDimension::D1 { used.max(2) } else { used };
        if !form.gather && count > inside {
            return Ok(self.select(given, &[inside])?.expr);
        }
        let Some(reference) = arguments.take() else {
            return self.refuse("missing reference value of the depth comparison");
        };
        Ok(self.coerce(&reference, &Ty::FLOAT)?.expr)
    }

    /// Returns the size of a texture as floats.
    fn texels(&mut self, texture: Handle<Expression>, components: u8) -> Lowering<TypedValue> {
        let query = ImageQuery::Size { level: None };
        let size = self.add(Expression::ImageQuery { image: texture, query });
        let size = TypedValue { expr: size, ty: Ty::new(Kind::Uint, components) };
        self.convert(&size, &Ty::new(Kind::Float, components))
    }

    /// Returns the explicit level of detail of a function, or the automatic one.
    fn level(
        &mut self,
        image: &Image,
        form: TextureForm,
        arguments: &mut Operands,
    ) -> Lowering<SampleLevel> {
        if form.lod {
            let Some(lod) = arguments.take() else { return self.refuse("missing level of detail") };
            let lod = self.coerce(&lod, &Ty::FLOAT)?;
            return Ok(match image.depth {
                // naga compares at the first level only.
                true => SampleLevel::Zero,
                false => SampleLevel::Exact(lod.expr),
            });
        }
        if form.grad {
            let (Some(x), Some(y)) = (arguments.take(), arguments.take()) else {
                return self.refuse("missing derivatives");
            };
            let ty = Ty::new(Kind::Float, coordinates(image));
            let (x, y) = (self.coerce(&x, &ty)?.expr, self.coerce(&y, &ty)?.expr);
            return Ok(match image.depth {
                true => SampleLevel::Zero,
                false => SampleLevel::Gradient { x, y },
            });
        }
        Ok(self.automatic_level())
    }

    /// Returns the component that `textureGather` reads.
    fn gathered(&mut self, arguments: &mut Operands) -> Lowering<naga::SwizzleComponent> {
        use naga::Literal::I32;
        use naga::SwizzleComponent as Component;
        let component = arguments.take().map(|v| self.function.expressions[v.expr].clone());
        match component {
            None | Some(Expression::Literal(I32(0))) => Ok(Component::X),
            Some(Expression::Literal(I32(1))) => Ok(Component::Y),
            Some(Expression::Literal(I32(2))) => Ok(Component::Z),
            Some(Expression::Literal(I32(3))) => Ok(Component::W),
            Some(_) => self.refuse("the component to gather must be a constant"),
        }
    }

    /// Returns the automatic level where derivatives exist, else level 0.
    fn automatic_level(&self) -> SampleLevel {
        match self.cx.stage {
            Some(Stage::Fragment) | None => SampleLevel::Auto,
            Some(_) => SampleLevel::Zero,
        }
    }

    /// Lowers sampling of integer textures, which naga does not support, to a load of the texel
    /// that a nearest, repeating sampler returns.
    fn nearest(
        &mut self,
        texture: Handle<Expression>,
        image: &Image,
        coordinate: &TypedValue,
        array_index: Option<Handle<Expression>>,
    ) -> Lowering<TypedValue> {
        let own = coordinates(image);
        if image.dim == ImageDimension::Cube {
            return self.refuse("integer cube textures cannot be sampled");
        }
        let zero = self.number(Kind::Int, 0.0);
        let query = ImageQuery::Size { level: Some(zero.expr) };
        let texels = self.add(Expression::ImageQuery { image: texture, query });
        let texels = TypedValue { expr: texels, ty: Ty::new(Kind::Uint, own) };
        let size = self.convert(&texels, &Ty::new(Kind::Float, own))?;
        let inside = self.math(naga::MathFunction::Fract, &[coordinate.expr]);
        let inside = TypedValue { expr: inside, ty: coordinate.ty.clone() };
        let texel = self.operate(Binary::Multiply, &inside, &size)?;
        let texel = self.convert(&texel, &Ty::new(Kind::Int, own))?;
        let expr = self.add(Expression::ImageLoad {
            image: texture,
            coordinate: texel.expr,
            array_index,
            sample: None,
            level: Some(zero.expr),
        });
        Ok(TypedValue { expr, ty: Ty::Vector(image.kind, 4) })
    }

    /// Returns the coordinates divided by the last one.
    fn project(&mut self, given: &TypedValue, count: u8) -> Lowering<TypedValue> {
        let last = self.select(given, &[count - 1])?;
        let rest: Vec<u8> = (0..count - 1).collect();
        let rest = self.select(given, &rest)?;
        self.operate(Binary::Divide, &rest, &last)
    }

    fn is_constant(&self, expr: Handle<Expression>) -> bool {
        match &self.function.expressions[expr] {
            Expression::Literal(_) | Expression::ZeroValue(_) => true,
            Expression::Compose { components, .. } => {
                components.iter().all(|&part| self.is_constant(part))
            }
            Expression::Splat { value, .. } => self.is_constant(*value),
            _ => false,
        }
    }

    /// `texelFetch`.
    fn fetch(
        &mut self,
        pair: &HandlePair,
        image: &Image,
        form: TextureForm,
        arguments: &mut Operands,
    ) -> Lowering<TypedValue> {
        let texture = self.source(pair.image)?;
        let Some(given) = arguments.take() else { return self.refuse("missing coordinates") };
        let (mut coordinate, array_index) = self.texel(image, &given)?;
        let extra = if image.rectangle { None } else { arguments.take() };
        let extra = match extra {
            Some(extra) => self.coerce(&extra, &Ty::INT)?,
            None => self.number(Kind::Int, 0.0),
        };
        if form.offset {
            let Some(by) = arguments.take() else { return self.refuse("missing offset") };
            coordinate = self.operate(Binary::Add, &coordinate, &by)?;
        }
        let (sample, level) =
            if image.multi { (Some(extra.expr), None) } else { (None, Some(extra.expr)) };
        let expr = self.add(Expression::ImageLoad {
            image: texture,
            coordinate: coordinate.expr,
            array_index,
            sample,
            level,
        });
        if image.depth {
            let value = TypedValue { expr, ty: Ty::FLOAT };
            return self.splat(&value, 4);
        }
        Ok(TypedValue { expr, ty: Ty::Vector(image.kind, 4) })
    }

    /// Returns integer coordinates, and the layer of an array.
    pub fn texel(
        &mut self,
        image: &Image,
        given: &TypedValue,
    ) -> Lowering<(TypedValue, Option<Handle<Expression>>)> {
        let own = coordinates(image);
        // The sides of a cube are layers of it to images.
        let Some((_, count)) = given.ty.components().filter(|(k, _)| k.is_integer()) else {
            return self.refuse(format!("expected texel coordinates, found `{}`", given.ty));
        };
        let wanted = own + u8::from(image.arrayed);
        if count < wanted {
            return self.refuse(format!("expected coordinates, found `{}`", given.ty));
        }
        let first: Vec<u8> = (0..own).collect();
        let coordinate = if count == own { given.clone() } else { self.select(given, &first)? };
        let coordinate = self.convert(&coordinate, &Ty::new(Kind::Int, own))?;
        let mut layer = None;
        if image.arrayed {
            let value = self.select(given, &[own])?;
            layer = Some(self.convert(&value, &Ty::INT)?.expr);
        }
        Ok((coordinate, layer))
    }

    fn query(
        &mut self,
        name: &str,
        chosen: &HandleChoice,
        image: &Image,
        values: Vec<TypedValue>,
    ) -> Lowering<TypedValue> {
        let count = image_size(image);
        let sized = name == "textureSize" || name == "imageSize";
        let ty = if sized { Ty::new(Kind::Int, count) } else { Ty::INT };
        let image = *image;
        self.with_handle(chosen, &ty, |this, pair| {
            let texture = this.source(pair.image)?;
            if !sized {
                let query = match name {
                    "textureQueryLevels" => ImageQuery::NumLevels,
                    _ => ImageQuery::NumSamples,
                };
                let expr = this.add(Expression::ImageQuery { image: texture, query });
                return this.convert(&TypedValue { expr, ty: Ty::UINT }, &Ty::INT);
            }
            let level = match values.first() {
                Some(level) if !image.multi && !image.rectangle => {
                    Some(this.coerce(level, &Ty::INT)?.expr)
                }
                _ => None,
            };
            let query = ImageQuery::Size { level };
            let own = count - u8::from(image.arrayed);
            let expr = this.add(Expression::ImageQuery { image: texture, query });
            let size = TypedValue { expr, ty: Ty::new(Kind::Uint, own) };
            let size = this.convert(&size, &Ty::new(Kind::Int, own))?;
            if !image.arrayed {
                return Ok(size);
            }
            let query = ImageQuery::NumLayers;
            let layers = this.add(Expression::ImageQuery { image: texture, query });
            let layers = this.convert(&TypedValue { expr: layers, ty: Ty::UINT }, &Ty::INT)?;
            this.compose(&ty, vec![size.expr, layers.expr])
        })
    }
}

/// Returns the number of coordinates without the layer.
fn coordinates(image: &Image) -> u8 {
    match image.dim {
        ImageDimension::D1 => 1,
        ImageDimension::D2 => 2,
        ImageDimension::D3 | ImageDimension::Cube => 3,
    }
}

/// Returns the number of components of `textureSize`.
fn image_size(image: &Image) -> u8 {
    let own = match image.dim {
        ImageDimension::D1 => 1,
        ImageDimension::D2 | ImageDimension::Cube => 2,
        ImageDimension::D3 => 3,
    };
    own + u8::from(image.arrayed)
}
