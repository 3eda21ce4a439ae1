//! The light of a fragment, term by term, from the uploaded bits.
//!
//! Reads a [`Model`], an [`Upload`], a [`Fragment`] and its [`Texels`]; used by comparisons and
//! culling. Written from the formulas of lighting, not from any shader.

use glam::DVec3;

use super::form::{
    attenuation, chord, distance, off_axis, power, ramp, ramp_to_axis, squared_less_one, unit,
};
use super::model::{
    AmbientTerm, ArraySpecular, CasterAttenuation, ConeEdge, ConeNumbers, Family, Highlight, Model,
    Normal, Power, SpecularGate,
};
use super::undef::UndefinedReason;
use crate::sample::Texels;
use crate::scene::{Cone, Emission, Kind, PointLight};
use crate::{Fragment, Upload};

/// The contribution of one light to a fragment, each term attenuated.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Contribution {
    pub ambient: DVec3,
    pub diffuse: DVec3,
    pub specular: DVec3,
    /// The attenuation factor; 1 if there is none.
    pub attenuation: f64,
    /// The cone factor; 1 if there is none.
    pub cone: f64,
    /// The distance of the fragment from the edge of a hard cone, in cosines.
    pub edge: Option<f64>,
}

impl Contribution {
    pub fn total(&self) -> DVec3 {
        self.ambient + self.diffuse + self.specular
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Shaded {
    /// The ambient light, or the sum of all ambient terms.
    pub ambient: DVec3,
    pub diffuse: DVec3,
    pub specular: DVec3,
    /// The total, summed light by light: directional, point, spot, each in order.
    pub total: DVec3,
    /// The distance of the fragment from the nearest hard edge, in cosines: rounding in a shader
    /// may put it on the other side.
    pub edge: Option<f64>,
}

/// A fragment with everything that does not depend on a light.
#[derive(Clone, Copy, Debug)]
pub struct FragmentContext<'a> {
    model: &'a Model,
    upload: &'a Upload,
    texels: Texels,
    position: DVec3,
    normal: DVec3,
    /// The squared length of the interpolated normal minus one, for mirroring at it.
    excess: f64,
    /// The direction towards the camera.
    view: DVec3,
    /// The view direction mirrored at the normal.
    mirrored: DVec3,
    power: f64,
    reflectance: f64,
}

/// Returns the light of a fragment.
///
/// # Errors
/// The hazard that leaves it undefined.
///
/// # Panics
/// If the fragment's material is not in the upload.
pub fn shade(
    model: &Model,
    upload: &Upload,
    fragment: &Fragment,
    texels: &Texels,
) -> Result<Shaded, UndefinedReason> {
    see(model, upload, fragment, texels)?.shade()
}

/// Prepares a fragment for evaluating single lights.
///
/// # Errors
/// A hazard of the fragment itself: its normal or the camera.
///
/// # Panics
/// If the fragment's material is not in the upload.
pub fn see<'a>(
    model: &'a Model,
    upload: &'a Upload,
    fragment: &Fragment,
    texels: &Texels,
) -> Result<FragmentContext<'a>, UndefinedReason> {
    let material = upload.materials.get(fragment.material as usize);
    let material = material.expect("a fragment's material is one of the upload's");
    let position = wide(fragment.position);
    let towards = upload.camera - position;
    // The camera at the fragment is undefined whatever the shader: every highlight needs the
    // direction to it.
    let view = towards
        / distance(towards, UndefinedReason::CameraAtFragment, UndefinedReason::CameraAtFragment)?;
    let given = wide(fragment.normal);
    let normal = unit(given)?;
    let excess = match model.normal {
        Normal::Unit => 0.0,
        Normal::AsInterpolated => squared_less_one(given),
    };
    // The mirrored view is the same for all lights: (2 (n.l) n - l).v = l.(2 (n.v) n - v).
    Ok(FragmentContext {
        model,
        upload,
        texels: *texels,
        position,
        normal,
        excess,
        view,
        mirrored: 2.0 * normal.dot(view) * normal - view,
        power: match model.power {
            Power::Material => material.shininess,
            Power::Ten => 10.0,
        },
        reflectance: material.reflectance,
    })
}

impl FragmentContext<'_> {
    /// Returns the light of the fragment.
    ///
    /// # Errors
    /// The hazard that leaves it undefined.
    pub fn shade(&self) -> Result<Shaded, UndefinedReason> {
        let ambient = self.ambient();
        let mut shaded = Shaded { ambient, total: ambient, ..Shaded::default() };
        // The order of the sum is that of the shaders, so that rounding is compared like with
        // like.
        for (kind, number) in self.lights() {
            let light = self.light(kind, number)?;
            shaded.ambient += light.ambient;
            shaded.diffuse += light.diffuse;
            shaded.specular += light.specular;
            shaded.total += light.total();
            if let Some(edge) = light.edge {
                shaded.edge = Some(shaded.edge.map_or(edge, |nearest| nearest.min(edge)));
            }
        }
        if shaded.total.is_finite() { Ok(shaded) } else { Err(UndefinedReason::NotFinite) }
    }

    /// Returns all lights, in the order of the sum.
    pub fn lights(&self) -> impl Iterator<Item = (Kind, usize)> + use<> {
        let counts = Kind::ALL.into_iter().zip(self.upload.lights.counts());
        counts.flat_map(|(kind, count)| (0..count).map(move |number| (kind, number)))
    }

    pub fn ambient(&self) -> DVec3 {
        match (self.model.ambient, &self.upload.lights.ambient) {
            (AmbientTerm::Once, Some(light)) => {
                light.color * light.intensity * self.ambient_texel()
            }
            (AmbientTerm::Once, None) | (AmbientTerm::PerLight | AmbientTerm::None, _) => {
                DVec3::ZERO
            }
        }
    }

    /// Returns the contribution of one light.
    ///
    /// # Errors
    /// The hazard that leaves it undefined.
    ///
    /// # Panics
    /// If there is no such light.
    pub fn light(&self, kind: Kind, number: usize) -> Result<Contribution, UndefinedReason> {
        let lights = &self.upload.lights;
        match kind {
            Kind::Directional => {
                let light = &lights.directional[number];
                // This family's loop skips a light whose intensity is not positive, hazards
                // included.
                if self.unlit(&light.emission) {
                    return Ok(Contribution::default());
                }
                let factors = Factors { attenuation: 1.0, cone: 1.0, edge: None };
                self.lit(&light.emission, unit(-light.direction)?, factors, [1.0, 1.0])
            }
            Kind::Point => {
                let light = &lights.point[number];
                if self.unlit(&light.emission) {
                    return Ok(Contribution::default());
                }
                let (path, d) = self.path(light)?;
                let attenuation = attenuation(&light.attenuation, self.model.window, d)?;
                let factors = Factors { attenuation, cone: 1.0, edge: None };
                self.lit(&light.emission, path / d, factors, [attenuation; 2])
            }
            Kind::Spot => {
                let light = &lights.spot[number];
                if self.unlit(&light.point.emission) {
                    return Ok(Contribution::default());
                }
                let (path, d) = self.path(&light.point)?;
                let attenuation = match (self.model.family, self.model.caster_attenuation) {
                    (Family::Casters, CasterAttenuation::None) => 1.0,
                    (Family::Casters, CasterAttenuation::Direct | CasterAttenuation::All)
                    | (Family::Multi | Family::Array | Family::ViewSpace, _) => {
                        attenuation(&light.point.attenuation, self.model.window, d)?
                    }
                };
                // Shaders compare with the direction in which the light travels, an upload's; the
                // path leads the other way.
                let (cone, edge) = self.cone(&light.cone, off_axis(path, -light.direction)?)?;
                let all = attenuation * cone;
                // First the factor of the ambient term, then that of diffuse and specular.
                let weakened = match (self.model.family, self.model.caster_attenuation) {
                    (Family::Multi | Family::Array | Family::ViewSpace, _) => [all, all],
                    (Family::Casters, CasterAttenuation::None | CasterAttenuation::Direct) => {
                        [1.0, all]
                    }
                    (Family::Casters, CasterAttenuation::All) => [attenuation, all],
                };
                let factors = Factors { attenuation, cone, edge };
                self.lit(&light.point.emission, path / d, factors, weakened)
            }
        }
    }

    /// Whether a family skips a light because of its intensity.
    fn unlit(&self, emission: &Emission) -> bool {
        match self.model.family {
            Family::ViewSpace => emission.intensity <= 0.0,
            Family::Multi | Family::Array | Family::Casters => false,
        }
    }

    fn path(&self, light: &PointLight) -> Result<(DVec3, f64), UndefinedReason> {
        let path = light.position - self.position;
        // Without a constant coefficient the attenuation divides by zero at the light, whatever
        // its direction: another hazard than the direction that cannot be normalised.
        let zero = match light.attenuation.constant {
            0.0 => UndefinedReason::LightAtFragmentUnattenuated,
            _ => UndefinedReason::LightAtFragment,
        };
        Ok((path, distance(path, zero, UndefinedReason::TooNear)?))
    }

    /// Returns the cone factor at one minus the cosine from its axis, and the distance to a hard
    /// edge.
    fn cone(&self, cone: &Cone, m: f64) -> Result<(f64, Option<f64>), UndefinedReason> {
        // 1 - cos(x) = 2 sin(x/2)^2, which keeps the digits of narrow cones.
        let from_angle = |degrees: f64| 2.0 * (degrees.to_radians() * 0.5).sin().powi(2);
        let (inner, outer) = match (self.model.cone_numbers, cone.degrees) {
            (ConeNumbers::Angles, Some([inner, outer])) => (from_angle(inner), from_angle(outer)),
            (ConeNumbers::Angles, None) | (ConeNumbers::Cosines, _) => {
                (1.0 - cone.inner_cos, 1.0 - cone.outer_cos)
            }
        };
        let to_axis = self.model.family == Family::ViewSpace;
        match self.model.cone_edge {
            ConeEdge::Hard => {
                let edge = if to_axis { outer } else { inner };
                Ok((if m < edge { 1.0 } else { 0.0 }, Some((m - edge).abs())))
            }
            ConeEdge::Soft if to_axis => Ok((ramp_to_axis(m, outer)?, None)),
            ConeEdge::Soft => {
                // A ramp of width 0 is a step: a shader's rounding may be on its other side.
                let edge = (inner == outer).then_some((m - outer).abs());
                Ok((ramp(m, outer, inner)?, edge))
            }
        }
    }

    /// Returns a light's terms: the ambient one times the first of `weakened`, the others times the
    /// second.
    fn lit(
        &self,
        emission: &Emission,
        to_light: DVec3,
        factors: Factors,
        weakened: [f64; 2],
    ) -> Result<Contribution, UndefinedReason> {
        let texels = &self.texels;
        let one = emission.color * emission.intensity;
        let (diffuse, specular) = match self.model.family {
            Family::Multi | Family::Casters => {
                (emission.diffuse, emission.specular * texels.specular)
            }
            Family::ViewSpace => (one, one * texels.specular),
            Family::Array => match self.model.array_specular {
                ArraySpecular::Fixed => (one, one * texels.specular),
                ArraySpecular::AsPublished => {
                    (one, emission.color * texels.specular.x * texels.diffuse)
                }
            },
        };
        let ambient = match self.model.ambient {
            AmbientTerm::PerLight => emission.ambient * self.ambient_texel(),
            AmbientTerm::Once | AmbientTerm::None => DVec3::ZERO,
        };
        // Lambert's cosine; light from behind gives 0.
        let facing = self.normal.dot(to_light).max(0.0);
        // A hard cone is a branch in shaders: what lies in the dark is not evaluated, so its
        // hazards (`pow(0, 0)`) do not count there. A soft cone multiplies, and they count.
        let dark = self.model.cone_edge == ConeEdge::Hard && factors.cone == 0.0;
        let highlight = if dark { 0.0 } else { self.highlight(to_light, facing)? };
        Ok(Contribution {
            ambient: ambient * weakened[0],
            diffuse: diffuse * texels.diffuse * (facing * weakened[1]),
            specular: specular * (highlight * weakened[1]),
            attenuation: factors.attenuation,
            cone: factors.cone,
            edge: factors.edge,
        })
    }

    fn ambient_texel(&self) -> DVec3 {
        match self.model.family {
            Family::ViewSpace => self.texels.ambient,
            Family::Multi | Family::Array | Family::Casters => self.texels.diffuse,
        }
    }

    fn highlight(&self, to_light: DVec3, facing: f64) -> Result<f64, UndefinedReason> {
        let gated = match self.model.specular_gate {
            SpecularGate::Facing => facing <= 0.0,
            SpecularGate::None => false,
        };
        let factor = self.model.reflectance.factor(self.reflectance);
        // A highlight that is not evaluated leaves nothing undefined.
        if gated || factor == 0.0 {
            return Ok(0.0);
        }
        let value = match self.model.highlight {
            Highlight::Phong => {
                // V.(2 (n.L) n - L) for n of any length, less 1.
                let both = self.normal.dot(to_light) * self.normal.dot(self.view);
                power(chord(to_light, self.mirrored) - 2.0 * self.excess * both, self.power)?
            }
            Highlight::Blinn => {
                // `l + v` is zero where light and view are opposite: there is no half vector.
                let half = unit(to_light + self.view).map_err(|_| UndefinedReason::NoHalfVector)?;
                let unit = power(chord(self.normal, half), self.power)?;
                // The normal's length to the same power.
                unit * (self.power * 0.5 * self.excess.ln_1p()).exp()
            }
        };
        Ok(value * factor)
    }
}

struct Factors {
    attenuation: f64,
    cone: f64,
    edge: Option<f64>,
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}
