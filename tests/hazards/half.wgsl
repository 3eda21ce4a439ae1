// What mediump may be computed in.

enable f16;

fn attenuation_half(d: f32) -> f32 {
    let h = f16(d);
    return f32(1.0h / (1.0h + 0.09h * h + 0.032h * (h * h)));
}

fn attenuation_single(d: f32) -> f32 {
    return 1.0 / (1.0 + d * (0.09 + 0.032 * d));
}
