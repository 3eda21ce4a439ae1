//! Texture sampling: nearest texel, repeating, 8 bits per channel.
//!
//! Samples a [`Material`] at texture coordinates; the reference computes with the texels and a
//! renderer uploads [`color`]s, so that both use the same ones.

use std::sync::LazyLock;

use glam::DVec3;
use landfall_exec::backend::texel_index;

use super::picture::Transfer;
use super::scene::{Material, Surface, Texture};

/// The colours of a material at a point, with full scale 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texels {
    pub ambient: DVec3,
    pub diffuse: DVec3,
    pub specular: DVec3,
}

pub fn texels(material: &Material, uv: [f32; 2]) -> Texels {
    Texels {
        ambient: surface(&material.ambient, uv),
        diffuse: surface(&material.diffuse, uv),
        specular: surface(&material.specular, uv),
    }
}

pub fn surface(surface: &Surface, uv: [f32; 2]) -> DVec3 {
    match surface {
        Surface::Constant(color) => *color,
        Surface::Texture(texture) => match index(texture, uv) {
            Some(index) => color(texture.texels[index], texture.srgb),
            None => DVec3::ZERO,
        },
    }
}

/// Returns the index of the texel at texture coordinates; `None` for an empty texture.
///
/// The first texel's first corner is (0, 0). Coordinates that are not finite select the first.
pub fn index(texture: &Texture, uv: [f32; 2]) -> Option<usize> {
    let place = |coordinate: f32, size: u32| texel_index(f64::from(coordinate), size) as usize;
    let at = place(uv[1], texture.height) * texture.width as usize + place(uv[0], texture.width);
    (at < texture.texels.len()).then_some(at)
}

pub fn color([r, g, b]: [u8; 3], srgb: bool) -> DVec3 {
    let channel = |code: u8| match srgb {
        false => f64::from(code) / 255.0,
        true => LINEAR[usize::from(code)],
    };
    DVec3::new(channel(r), channel(g), channel(b))
}

/// The linear values of sRGB codes.
static LINEAR: LazyLock<[f64; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| Transfer::Srgb.decode(code as f64 / 255.0)));

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(srgb: bool) -> Texture {
        let texels = vec![[0, 10, 255], [1, 11, 200], [2, 12, 188], [3, 13, 54]];
        Texture { width: 2, height: 2, texels, srgb }
    }

    #[test]
    fn texels_are_nearest_and_repeat_in_both_directions() {
        let at = |u, v| index(&texture(false), [u, v]);
        assert_eq!(
            [at(0.0, 0.0), at(0.5, 0.0), at(0.0, 0.5), at(0.99, 0.99)].map(Option::unwrap),
            [0, 1, 2, 3]
        );
        assert_eq!([at(1.0, 1.0), at(-0.25, 0.25), at(7.75, -3.0)].map(Option::unwrap), [0, 1, 1]);
        // Rounds up to a whole: still the last texel.
        assert_eq!(at(-1e-30, -1e-30), Some(3));
        assert_eq!(at(f32::NAN, f32::INFINITY), Some(0));
        let empty = Texture { width: 0, height: 0, texels: Vec::new(), srgb: false };
        assert_eq!(index(&empty, [0.5, 0.5]), None);
    }

    #[test]
    fn srgb_codes_are_decoded_only_where_declared() {
        let linear = color([0, 51, 255], false);
        assert_eq!(linear, DVec3::new(0.0, 0.2, 1.0));
        // 188 is the code of half the light and 54 of 0.037 to the digits shown.
        let half = color([188, 54, 10], true);
        assert!((half.x - 0.502886).abs() < 1e-6 && (half.y - 0.036889).abs() < 1e-6, "{half}");
        assert!((half.z - 10.0 / 255.0 / 12.92).abs() < 1e-17);
    }
}
