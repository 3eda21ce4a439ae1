//! Hand-built blocks for tests.

use std::sync::Arc;

use crate::layout::{BlockLayout, lay_out};
use crate::shape::*;
use crate::source::{Files, Language, Span};
use crate::{ShaderLayout, Source};

pub fn member(name: &str, ty: Type) -> Member {
    Member::unqualified(name.into(), ty, Span::default())
}

pub fn float() -> Type {
    Type::Scalar(Scalar::F32)
}

pub fn int() -> Type {
    Type::Scalar(Scalar::I32)
}

pub fn vec(rows: u8) -> Type {
    Type::Vector { scalar: Scalar::F32, rows }
}

pub fn mat(columns: u8, rows: u8) -> Type {
    Type::Matrix { scalar: Scalar::F32, columns, rows }
}

pub fn array(element: Type, n: u32) -> Type {
    Type::Array { element: Arc::new(element), len: ArrayLen::Fixed(n) }
}

pub fn runtime(element: Type) -> Type {
    Type::Array { element: Arc::new(element), len: ArrayLen::Runtime }
}

pub fn structure(name: &str, members: Vec<Member>) -> Type {
    Type::Struct(Arc::new(Struct::new(name.into(), members, vec![], Span::default())))
}

pub fn declared(name: &str, rules: Rules, members: Vec<Member>) -> Block {
    Block {
        name: name.into(),
        instance: None,
        space: AddressSpace::Uniform,
        rules,
        rules_declared: true,
        gathered: false,
        group: None,
        binding: None,
        count: vec![],
        matrix_layout: MatrixLayout::Column,
        members,
        opaque: vec![],
        offset_order: crate::shape::OffsetOrder::Ascending,
        span: Span::default(),
        comment: vec![],
    }
}

pub fn block(rules: Rules, members: Vec<Member>) -> BlockLayout {
    lay_out(&declared("B", rules, members)).expect("the example is possible")
}

/// The block of 128 point lights: `data[3].color` at 160, 6160 bytes.
pub fn point_lights() -> BlockLayout {
    let light = structure(
        "PointLight",
        vec![
            member("pos", vec(3)),
            member("color", vec(3)),
            member("intensity", float()),
            member("constant", float()),
            member("linear", float()),
            member("quadratic", float()),
        ],
    );
    let members = vec![member("data", array(light, 128)), member("actually_used_count", int())];
    lay_out(&Block {
        instance: Some("u_point_light_array".into()),
        ..declared("PointLightBlock", Rules::Std140, members)
    })
    .expect("the example is possible")
}

/// Everything that pads: a hole, a `mat3`, a `float` array, arrays of arrays, a nested structure.
pub fn padded(rules: Rules) -> BlockLayout {
    let inner = structure("Inner", vec![member("a", float()), member("b", vec(2))]);
    let outer = structure(
        "Outer",
        vec![member("i", array(inner, 2)), member("m", mat(3, 3)), member("f", float())],
    );
    let members = vec![
        member("s", float()),
        member("v", vec(3)),
        member("w", array(float(), 7)),
        member("o", array(array(outer, 3), 2)),
        Member { matrix_layout: Some(MatrixLayout::Row), ..member("r", array(mat(2, 3), 2)) },
        member("end", float()),
    ];
    block(rules, members)
}

/// Structures whose last element has no tail padding under scalar rules.
pub fn doubles(rules: Rules) -> BlockLayout {
    let wide = Type::Scalar(Scalar::F64);
    let s = structure("Wide", vec![member("d", wide), member("f", float())]);
    let t =
        structure("Outer", vec![member("s", array(array(s.clone(), 3), 2)), member("g", float())]);
    let members = vec![
        member("one", array(s.clone(), 3)),
        member("f", float()),
        member("many", array(t, 2)),
        member("h", float()),
        member("end", runtime(s)),
    ];
    block(rules, members)
}

/// A storage block with a runtime-sized tail.
pub fn particles() -> BlockLayout {
    let particle = structure("Particle", vec![member("pos", vec(3)), member("age", float())]);
    let members =
        vec![member("count", Type::Scalar(Scalar::U32)), member("particles", runtime(particle))];
    lay_out(&Block {
        space: AddressSpace::Storage,
        group: Some(0),
        binding: Some(3),
        ..declared("Particles", Rules::Std430, members)
    })
    .expect("the example is possible")
}

/// Loose uniforms: `view_pos` and six lights.
pub fn loose() -> BlockLayout {
    let light = structure("Light", vec![member("position", vec(3)), member("linear", float())]);
    let members = vec![member("view_pos", vec(3)), member("lights", array(light, 6))];
    lay_out(&Block {
        space: AddressSpace::Default,
        rules_declared: false,
        gathered: true,
        opaque: vec!["diffuse".into()],
        ..declared("", Rules::Std140, members)
    })
    .expect("the example is possible")
}

/// A shader with these blocks.
pub fn shader(path: &str, language: Language, blocks: Vec<BlockLayout>) -> ShaderLayout {
    let source = Source::new(path, "// nothing but blocks built by hand\n");
    let mut files = Files::default();
    files.add(path, source.text);
    let empty = ShaderLayout::empty(path.to_string(), language, source.stage);
    ShaderLayout { blocks, files, ..empty }
}
