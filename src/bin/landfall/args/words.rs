//! The words that `stress`, `prove` and `bench` share, as their help states them.

/// The words as a literal, for `concat!`.
macro_rules! words {
    () => {
        "\
Words: a step is 1/255 of full scale, which is at least 1; a ULP is the distance
of neighbouring f32 at the result; 99.9 % is what 99.9 % of errors stay below;
permitted is within the errors that WGSL and Vulkan allow operations."
    };
}

pub(super) use words;
