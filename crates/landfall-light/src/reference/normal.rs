//! A normal in view space, as the vertex stages of the `view_space` family have it.
//!
//! What a frame's normals are made with before they are interpolated;
//! [`light`](super::light) gets them in its fragments.

use glam::{DMat3, DMat4, DVec3};

use super::form::unit;
use super::model::NormalTransform;
use super::undef::Undef;

/// A vertex's normal in view space, before it is interpolated.
///
/// # Errors
/// [`Undef::ZeroVector`] of a zero normal, [`Undef::NotFinite`] where the matrix has no inverse.
pub fn view_normal(
    model_view: &DMat4,
    normal: DVec3,
    transform: NormalTransform,
) -> Result<DVec3, Undef> {
    match transform {
        NormalTransform::Mat3 => unit(DMat3::from_mat4(*model_view).inverse().transpose() * normal),
        NormalTransform::Vec4 => {
            let whole = model_view.inverse().transpose() * normal.extend(0.0);
            // Of four components: the last is what the translation leaves in it.
            let length = whole.length();
            match length {
                0.0 => Err(Undef::ZeroVector),
                _ if length.is_finite() => Ok(whole.truncate() / length),
                _ => Err(Undef::NotFinite),
            }
        }
    }
}
