//! The thresholds of hazards, each with its reason.

/// A number below or above which a hazard occurs.
#[derive(Debug, PartialEq)]
#[non_exhaustive]
pub struct Threshold {
    pub value: f64,
    /// The quantity compared with it, with its unit.
    pub of: &'static str,
    pub why: &'static str,
}

impl Threshold {
    /// Returns the number as GLSL and WGSL write it: `1.0e-4`.
    pub fn literal(&self) -> String {
        format!("{:.1e}", self.value)
    }

    /// Returns its square as GLSL and WGSL write it, for guards of squared lengths.
    pub fn squared_literal(&self) -> String {
        format!("{:.1e}", self.value * self.value)
    }
}

/// The smallest length that is not treated as zero.
pub static LENGTH: Threshold = Threshold {
    value: 1e-15,
    of: "length of the vector",
    why: "its square, 1e-30, is 8.5e7 times the smallest normal f32 (1.2e-38), so that the squares \
          of the components keep their digits where subnormals are flushed; without a guard \
          errors begin at lengths of 1e-20 and lengths below 1.1e-19 vanish on devices that flush. \
          No two points of a scene in f32 coordinates above 1e-7 are so near without being equal.",
};

/// The largest coordinate or distance whose square does not overflow.
pub static COORDINATE: Threshold = Threshold {
    value: 1e18,
    of: "coordinate or distance",
    why: "the square of a distance between two such points is at most 1.2e37, below the largest \
          f32 (3.4e38); squares overflow at distances of 1.85e19.",
};

/// The smallest divisor of an attenuation.
pub static ATTENUATION: Threshold = Threshold {
    value: 1e-4,
    of: "denominator of the attenuation",
    why: "the squared distance of 1 cm in metres: nearer than that a light has a size. It is the \
          smallest power of ten that is a normal number in 16-bit floats (6.1e-5), and its \
          reciprocal, 1e4, is finite there (65504) and in f32 sums; 1e-6 is subnormal in 16 bits \
          and its reciprocal infinite. Every row of the published table of attenuations divides \
          by 1 or more, so none of them changes.",
};

/// The smallest difference of cosines that a cone divides by.
pub static CONE_WIDTH: Threshold = Threshold {
    value: 1e-4,
    of: "difference of cosines in the denominator",
    why: "a dot product of two normalised f32 vectors is up to 2.4e-7 above 1, and the division \
          multiplies that by the reciprocal of this number: 0.6 steps of 1/255 at 1e-4, 61 at 1e-6 \
          and all 255 at 1e-7, where a cone of zero width still sparkles. A cone of 0.5 and 1 degrees divides by 1.14e-4 and keeps its width; cosines \
          cannot draw narrower ones anyway (`narrow-cone`).",
};

/// The largest absolute value of a cosine, rounded.
pub static COSINE: Threshold = Threshold {
    value: 1.0001,
    of: "absolute value of the cosine",
    why: "cosines are at most 1, and one rounded to four digits is still accepted.",
};

/// The largest excess above one that rounding causes in a cosine.
pub static ABOVE_ONE: Threshold = Threshold {
    value: 1e-5,
    of: "excess of the base over 1",
    why: "the length of a normalised f32 vector is within 3 ULP (4e-7) of 1 and its dot product \
          within twice that; vectors scaled by a matrix of rounded entries reach ten times as \
          far. What exceeds 1 by more is no cosine.",
};

/// The smallest change of a result that is reported.
pub static CHANGE: Threshold = Threshold {
    value: 1e-3,
    of: "change of the result, as a share of full scale",
    why: "a quarter of a step of 1/255: a smaller change alters an 8-bit picture only where a value is halfway between two 8-bit values.",
};

/// Distance from the origin at which coordinates begin to cancel.
pub static ORIGIN: Threshold = Threshold {
    value: 1e3,
    of: "coordinate",
    why: "with light, eye and surface in a cube of 3 m, 1 m or more apart, and exponent 32: 0.08 \
          steps of 1/255 at this distance, 1 at 1e4. It is the last power of ten below half a step.",
};

/// The cosine of the half angle of a narrow cone.
pub static NARROW: Threshold = Threshold {
    value: 0.999,
    of: "cosine of the cone's half angle",
    why: "2.6 degrees: by cosines a cone of 12.5 and 15 degrees is 0.01 steps of 1/255 off, one of 1 \
          and 2 degrees 0.2, one of 0.5 and 1 degrees 0.7 and one of 0.05 and 0.06 degrees all \
          255; by the difference of the vectors none is off by more than 0.15.",
};

/// Distance from the edge of a hard cone, in cosines.
pub static EDGE: Threshold = Threshold {
    value: 1e-6,
    of: "distance of the cosines from the edge of the cone",
    why: "a dot product of two normalised f32 vectors and the uploaded cosine are together up to \
          3e-7 off; three times that covers every fragment that a device may put on the other \
          side of the edge, a band of 2.6e-4 degrees at 12.5 degrees.",
};

/// The exponent from which the loss of accuracy in a power is attributed to the exponent.
pub static EXPONENT: Threshold = Threshold {
    value: 16.0,
    of: "exponent",
    why: "the relative error of the base is multiplied by the exponent: by 16 it loses four bits, \
          more than `pow` itself may; below that the error was there before. What shows depends \
          on the picture: from f32 vectors it is up to 0.005 steps of 1/255 at 32, 0.04 at 256, 0.65 \
          at 4096 and 10 at 65536.",
};

/// Distance at which squares overflow in 16 bits.
pub static HALF_DISTANCE: Threshold = Threshold {
    value: 256.0,
    of: "distance",
    why: "the largest 16-bit float is 65504, just below the square of 256.",
};
