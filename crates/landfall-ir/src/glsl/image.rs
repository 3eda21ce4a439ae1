//! Images, atomic functions, barriers (GLSL 4.60 §8.11, §8.12, §8.16, §8.17).

use naga::{AtomicFunction, Barrier, Expression, Statement};

use super::Lowering;
use super::ast::Expr;
use super::block_types::BlockTypeKind;
use super::body::{Body, TypedValue};
use super::lvalue::{Address, LvalueMemory};
use super::opaque::HandleChoice;
use super::types::{Kind, Opaque, Ty};

impl<'a> Body<'_, 'a> {
    /// Lowers a function of images, atomics or barriers; `None` if it is not one.
    pub fn memory_call(
        &mut self,
        name: &str,
        arguments: &[Expr<'a>],
        e: &Expr<'a>,
        for_effect: bool,
    ) -> Lowering<Option<TypedValue>> {
        match name {
            // GLSL 4.60 §8.16: `barrier` waits for the work group; memory barriers (§8.17) order
            // accesses only.
            "barrier" => self.barrier(Barrier::WORK_GROUP, true),
            "memoryBarrier" => {
                let all = Barrier::WORK_GROUP | Barrier::STORAGE | Barrier::TEXTURE;
                self.barrier(all, false)
            }
            "memoryBarrierBuffer" => self.barrier(Barrier::STORAGE, false),
            "memoryBarrierImage" => self.barrier(Barrier::TEXTURE, false),
            "memoryBarrierShared" | "groupMemoryBarrier" => {
                self.barrier(Barrier::WORK_GROUP, false)
            }
            "subgroupBarrier" => self.barrier(Barrier::SUB_GROUP, true),
            "subpassLoad" => self.subpass(arguments, e).map(Some),
            "imageLoad" | "imageStore" => self.image_access(name, arguments, e).map(Some),
            "EmitVertex"
            | "EndPrimitive"
            | "ftransform"
            | "interpolateAtCentroid"
            | "interpolateAtSample"
            | "interpolateAtOffset"
            | "traceRayEXT"
            | "textureQueryLod"
            | "atomicCounterIncrement"
            | "atomicCounterDecrement"
            | "atomicCounter"
            | "noise1"
            | "noise2"
            | "noise3"
            | "noise4" => self.refuse(format!("`{name}` is not supported by naga")),
            _ if name.starts_with("imageAtomic") => {
                self.image_atomic(name, arguments, e, for_effect).map(Some)
            }
            _ if name.starts_with("atomic") => self.atomic(name, arguments, e).map(Some),
            _ => Ok(None),
        }
    }

    fn nothing(&mut self) -> TypedValue {
        TypedValue { expr: self.u32(0), ty: Ty::Void }
    }

    fn barrier(&mut self, barrier: Barrier, waits: bool) -> Lowering<Option<TypedValue>> {
        self.statement(if waits {
            Statement::ControlBarrier(barrier)
        } else {
            Statement::MemoryBarrier(barrier)
        });
        Ok(Some(self.nothing()))
    }

    fn image_access(
        &mut self,
        name: &str,
        arguments: &[Expr<'a>],
        e: &Expr<'a>,
    ) -> Lowering<TypedValue> {
        let (chosen, values) = self.handle_and_values(name, arguments, e)?;
        let (HandleChoice::At(_, Ty::Opaque(Opaque::Storage(image))), Some(at)) =
            (chosen.clone(), values.first().cloned())
        else {
            return self.refuse(format!("`{name}` takes an image and coordinates"));
        };
        if image.multi || image.dim == naga::ImageDimension::Cube {
            return self.refuse("multisampled images and cube images are not supported by naga");
        }
        let vec4 = Ty::Vector(image.kind, 4);
        // `imageStore` has the texel as its third argument.
        let stored = values.get(1).cloned();
        let ty = if name == "imageLoad" { vec4.clone() } else { Ty::Void };
        self.with_handle(&chosen, &ty, |this, pair| {
            let source = this.source(pair.image)?;
            let (coordinate, array_index) = this.texel(&image, &at)?;
            if name == "imageLoad" {
                let expr = this.add(Expression::ImageLoad {
                    image: source,
                    coordinate: coordinate.expr,
                    array_index,
                    sample: None,
                    level: None,
                });
                return Ok(TypedValue { expr, ty: vec4.clone() });
            }
            let Some(value) = &stored else { return this.refuse("missing texel argument") };
            let value = this.coerce(value, &vec4)?;
            this.statement(Statement::ImageStore {
                image: source,
                coordinate: coordinate.expr,
                array_index,
                value: value.expr,
            });
            Ok(this.nothing())
        })
    }

    /// Lowers the load of an input attachment at the fragment (GL_KHR_vulkan_glsl).
    fn subpass(&mut self, arguments: &[Expr<'a>], e: &Expr<'a>) -> Lowering<TypedValue> {
        let Some((first, rest)) = arguments.split_first() else {
            return self.refuse("`subpassLoad` takes an input attachment");
        };
        let chosen = self.chosen(first)?;
        let mut sample = self.number(Kind::Int, 0.0);
        if let Some(given) = rest.first() {
            sample = self.value(given)?;
        }
        self.span = e.span;
        let HandleChoice::At(_, Ty::Opaque(Opaque::Texture(image))) = chosen.clone() else {
            return self.refuse("`subpassLoad` takes an input attachment");
        };
        // The fragment's own pixel: x and y of `gl_FragCoord`, without its fraction.
        let place = self.named("gl_FragCoord")?;
        let place = self.value_of_operand(place)?;
        let place = self.select(&place, &[0, 1])?;
        let texel = self.convert(&place, &Ty::Vector(Kind::Int, 2))?;
        let ty = Ty::Vector(image.kind, 4);
        self.with_handle(&chosen, &ty, |this, pair| {
            let source = this.source(pair.image)?;
            let (sample, level) = match image.multi {
                true => (Some(sample.expr), None),
                false => (None, Some(sample.expr)),
            };
            let coordinate = texel.expr;
            let array_index = None;
            let load =
                Expression::ImageLoad { image: source, coordinate, array_index, sample, level };
            Ok(TypedValue { expr: this.add(load), ty: ty.clone() })
        })
    }

    fn image_atomic(
        &mut self,
        name: &str,
        arguments: &[Expr<'a>],
        e: &Expr<'a>,
        for_effect: bool,
    ) -> Lowering<TypedValue> {
        // `imageAtomicAdd` and its like return the value before (GLSL 4.60 §8.12).
        if !for_effect {
            return self.refuse(format!("naga does not return the value of `{name}`"));
        }
        let fun = match name {
            "imageAtomicAdd" => AtomicFunction::Add,
            "imageAtomicMin" => AtomicFunction::Min,
            "imageAtomicMax" => AtomicFunction::Max,
            "imageAtomicAnd" => AtomicFunction::And,
            "imageAtomicOr" => AtomicFunction::InclusiveOr,
            "imageAtomicXor" => AtomicFunction::ExclusiveOr,
            _ => return self.refuse(format!("`{name}` is not supported by naga")),
        };
        let [first, at, value] = arguments else {
            return self.refuse(format!("`{name}` takes an image, coordinates and a value"));
        };
        let chosen = self.chosen(first)?;
        let (at, value) = (self.value(at)?, self.value(value)?);
        self.span = e.span;
        let HandleChoice::At(_, Ty::Opaque(Opaque::Storage(image))) = chosen.clone() else {
            return self.refuse(format!("`{name}` takes an image"));
        };
        let value = self.coerce(&value, &Ty::Scalar(image.kind))?;
        self.with_handle(&chosen, &Ty::Void, |this, pair| {
            let source = this.source(pair.image)?;
            let (coordinate, array_index) = this.texel(&image, &at)?;
            this.statement(Statement::ImageAtomic {
                image: source,
                coordinate: coordinate.expr,
                array_index,
                fun,
                value: value.expr,
            });
            Ok(this.nothing())
        })
    }

    fn atomic(&mut self, name: &str, arguments: &[Expr<'a>], e: &Expr<'a>) -> Lowering<TypedValue> {
        let Some((first, rest)) = arguments.split_first() else {
            return self.refuse(format!("`{name}` takes at least one argument"));
        };
        let place = self.place(first)?;
        let values = self.values(rest)?;
        self.span = e.span;
        // naga has atomics only on memory of an atomic type, which blocks get from
        // `name_usage::atomics`.
        let pointer = match &place.mem {
            LvalueMemory::BlockType(Address::Pointer(pointer), block_type)
                if matches!(block_type.kind, BlockTypeKind::Atomic) =>
            {
                *pointer
            }
            LvalueMemory::Own(_)
            | LvalueMemory::BlockType(..)
            | LvalueMemory::Column(..)
            | LvalueMemory::Nothing => {
                return self.refuse(format!(
                    "`{name}` takes an `int` or `uint` in a buffer or in `shared` memory"
                ));
            }
        };
        let mut given = Vec::new();
        for value in &values {
            given.push(self.coerce(value, &place.ty)?.expr);
        }
        let (fun, value) = match (name, &given[..]) {
            ("atomicAdd", [value]) => (AtomicFunction::Add, *value),
            ("atomicMin", [value]) => (AtomicFunction::Min, *value),
            ("atomicMax", [value]) => (AtomicFunction::Max, *value),
            ("atomicAnd", [value]) => (AtomicFunction::And, *value),
            ("atomicOr", [value]) => (AtomicFunction::InclusiveOr, *value),
            ("atomicXor", [value]) => (AtomicFunction::ExclusiveOr, *value),
            ("atomicExchange", [value]) => (AtomicFunction::Exchange { compare: None }, *value),
            ("atomicCompSwap", [compare, value]) => {
                (AtomicFunction::Exchange { compare: Some(*compare) }, *value)
            }
            _ => return self.refuse(format!("`{name}` is not supported by naga")),
        };
        let kind = place.ty.kind().unwrap_or(Kind::Uint);
        let comparison = matches!(fun, AtomicFunction::Exchange { compare: Some(_) });
        // naga's compare-and-exchange returns a structure of the old value and whether it was
        // exchanged.
        let ty = if comparison {
            let scalar = kind.scalar();
            let special = naga::PredeclaredType::AtomicCompareExchangeWeakResult(scalar);
            self.cx.ir.generate_predeclared_type(special)
        } else {
            self.cx.value_type(&place.ty, self.span)?
        };
        let result = self.add_result(Expression::AtomicResult { ty, comparison });
        self.statement(Statement::Atomic { pointer, fun, value, result: Some(result) });
        let expr = if comparison { self.part(result, 0) } else { result };
        Ok(TypedValue { expr, ty: place.ty.clone() })
    }
}
