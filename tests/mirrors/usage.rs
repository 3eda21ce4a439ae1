//! What a program does with the mirrors and the tables of `usage.frag`.

mod mirrors {
    include!("mirrors.rs");
}

use glam::{Mat3, Mat4, Vec3};
use mirrors::*;

const SECOND_COLOR: usize = point_light_block::data_color(1);

fn main() {
    mirrors_are_made_without_typing_a_pad();
    matrices_and_bools_convert_both_ways();
    padded_elements_act_like_what_they_hold();
    a_runtime_sized_tail_is_written_after_its_header();
    tables_agree_with_the_mirrors();
    lookup_tells_unknown_names_from_indices_out_of_range();
}

fn mirrors_are_made_without_typing_a_pad() {
    const LIGHT: PointLight =
        PointLight::new(PointLightInit { color: Vec3::Y, range: 2.0, pos: Vec3::X });
    let light = LIGHT;
    let same = PointLight { pos: Vec3::X, range: 2.0, color: Vec3::Y, ..Default::default() };
    assert_eq!(light, same);
    let mut block = PointLightBlock::default();
    assert!(bytemuck::bytes_of(&block).iter().all(|byte| *byte == 0));
    block.data[3].color = Vec3::ONE;
    assert_eq!(bytemuck::bytes_of(&block)[3 * 32 + 16..][..4], 1.0f32.to_le_bytes());
}

fn matrices_and_bools_convert_both_ways() {
    let projection = Mat4::from_cols_array(&core::array::from_fn(|i| i as f32));
    let normal = Mat3::from_cols_array(&core::array::from_fn(|i| i as f32));
    let two = [[Vec3::X, Vec3::Y], [Vec3::Z, Vec3::ONE]];
    let camera = Camera::new(CameraInit {
        view: Mat4::IDENTITY,
        projection,
        normal,
        two,
        on: true,
        which: [true, false, true],
        weights: [1.0, 2.0, 3.0],
        grid: [[1.0, 2.0], [3.0, 4.0]],
        bones: [normal, Mat3::IDENTITY],
    });
    assert_eq!(Mat4::from(camera.projection), projection);
    assert_eq!(Mat3::from(camera.normal), normal);
    assert_eq!(<[[f32; 3]; 3]>::from(camera.normal), normal.to_cols_array_2d());
    assert_eq!(<[Vec3; 2]>::from(camera.two[1]), two[1]);
    assert!(bool::from(camera.on));
    assert_eq!(camera.which.map(bool::from), [true, false, true]);
    assert_eq!(Mat3::from(camera.bones[0]), normal);
    // Rows one after the other: the second float is the first of the second column.
    let stored = &bytemuck::bytes_of(&camera)[camera::PROJECTION + 4..][..4];
    assert_eq!(stored, 4.0f32.to_le_bytes());
}

fn padded_elements_act_like_what_they_hold() {
    let mut camera = Camera::default();
    camera.weights = F32Stride16::array([1.0, 2.0, 3.0]);
    *camera.weights[1] += 0.5;
    camera.weights[2] = 4.0.into();
    assert_eq!(F32Stride16::values(camera.weights), [1.0, 2.5, 4.0]);
    assert_eq!(f32::from(camera.weights[1]), 2.5);
    assert_eq!(camera.weights[1].sqrt(), 2.5f32.sqrt());
    camera.bones[1] = Mat3::IDENTITY.into();
    assert_eq!(Mat3::from(camera.bones[1]), Mat3::IDENTITY);
}

fn a_runtime_sized_tail_is_written_after_its_header() {
    let list: [PointLight; 3] =
        [PointLightInit { pos: Vec3::X, range: 1.0, color: Vec3::Y }.into(); 3];
    let header = ParticlesHeader::new(ParticlesHeaderInit { count: 3 });
    let mut bytes = [0xffu8; 128];
    let size = ParticlesHeader::size_for(list.len());
    assert_eq!(size, 16 + 3 * 32);
    assert_eq!(header.write_to(&list, &mut bytes), Ok(size));
    assert_eq!(bytes[0], 3);
    assert_eq!(bytes[16..size], *bytemuck::bytes_of(&list));
    assert_eq!(bytes[size], 0xff);
    let error = header.write_to(&list, &mut bytes[..20]).unwrap_err();
    assert_eq!(error.to_string(), "the block takes 112 bytes, there are 20");
    let element: ParticlesElement = list[0];
    assert_eq!(element, list[1]);
    // OpenGL demands room for one element; a longer buffer would add elements.
    assert_eq!(SamplesHeader::size_for(0), 16 + 4);
    assert_eq!(SamplesHeader::size_for(1), 16 + 4);
    assert_eq!(SamplesHeader::size_for(5), 16 + 5 * 4);
}

fn tables_agree_with_the_mirrors() {
    assert_eq!(SECOND_COLOR, 32 + 16);
    assert_eq!(point_light_block::SIZE, core::mem::size_of::<PointLightBlock>());
    assert_eq!(point_light_block::DATA_SIZE, 4100);
    assert_eq!(point_light_block::BINDING, 2);
    assert_eq!(camera::GROUP, 1);
    assert_eq!(point_light_block::ACTUALLY_USED_COUNT, 4096);
    assert_eq!(camera::grid(1, 0), core::mem::offset_of!(Camera, grid) + 32);
    assert_eq!(particles::list_color(1_000_000), 16 + 32_000_000 + 16);
    assert!(std::panic::catch_unwind(|| point_light_block::data_color(128)).is_err());
}

fn lookup_tells_unknown_names_from_indices_out_of_range() {
    use point_light_block::lookup;
    let color = lookup("data[3].color").unwrap();
    assert_eq!((color.offset, color.size, color.ty), (3 * 32 + 16, 12, "vec3"));
    assert_eq!((color.dims, color.strides), (&[Some(128)][..], &[32][..]));
    assert_eq!(lookup("data[].color").unwrap().offset, 16);
    assert_eq!(lookup("actually_used_count").unwrap().offset, 4096);
    let out = LookupError::OutOfRange { dimension: 0, index: 128, len: 128 };
    assert_eq!(lookup("data[128].color"), Err(out));
    assert_eq!(out.to_string(), "index 128 of dimension 0 is not below 128");
    for huge in ["data[99999999999999999999999].color", "data[18446744073709551615].color"] {
        assert!(matches!(lookup(huge), Err(LookupError::OutOfRange { .. })), "{huge}");
    }
    for unknown in [
        "",
        "data",
        "data[3]",
        "data[3].",
        "data.color",
        "data[3].colour",
        "data[-1].color",
        "data[+1].color",
        "data[ 1].color",
        "data[1]].color",
        "data[[1].color",
        "data[1.color",
        "actually_used_count[0]",
        "Data[3].color",
        "data[3].color ",
        "data[0x3].color",
        "[]",
    ] {
        assert_eq!(lookup(unknown), Err(LookupError::Unknown), "{unknown}");
    }
    let far = particles::lookup("list[100000].pos").unwrap();
    assert_eq!((far.offset, far.dims), (16 + 3_200_000, &[None][..]));
    let overflow = format!("list[{}].pos", usize::MAX / 16);
    assert!(matches!(particles::lookup(&overflow), Err(LookupError::OutOfRange { .. })));
    let matrix = camera::lookup("bones[1]").unwrap();
    assert_eq!((matrix.matrix_stride, matrix.row_major), (Some(16), false));
    assert!(camera::lookup("projection").unwrap().row_major);
}
