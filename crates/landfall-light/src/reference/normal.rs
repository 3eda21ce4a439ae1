//! Normals in view space, as in the vertex stages of the `view_space` family.
//!
//! Computes a frame's normals before interpolation; [`light`](super::light) gets them in its
//! fragments.

use glam::{DMat3, DMat4, DVec3};

use super::form::unit;
use super::model::NormalTransform;
use super::undef::UndefinedReason;

/// Returns a vertex's normal in view space, before interpolation.
///
/// # Errors
/// [`UndefinedReason::ZeroVector`] for a zero normal, [`UndefinedReason::NotFinite`] if the matrix
/// has no inverse.
pub fn view_normal(
    model_view: &DMat4,
    normal: DVec3,
    transform: NormalTransform,
) -> Result<DVec3, UndefinedReason> {
    match transform {
        NormalTransform::Mat3 => unit(DMat3::from_mat4(*model_view).inverse().transpose() * normal),
        NormalTransform::Vec4 => {
            // The matrix has a translation, so its inverse transpose puts a fourth component into
            // the normal.
            let whole = model_view.inverse().transpose() * normal.extend(0.0);
            // Normalised with four components: the last one comes from the translation.
            let length = whole.length();
            match length {
                0.0 => Err(UndefinedReason::ZeroVector),
                _ if length.is_finite() => Ok(whole.truncate() / length),
                _ => Err(UndefinedReason::NotFinite),
            }
        }
    }
}
