//! Random GLSL expressions of a `vec3 p`, within the domains of their functions.

/// One that computes something.
pub fn expression(random: &mut fastrand::Rng) -> String {
    call(random, 3)
}

fn grow(random: &mut fastrand::Rng, depth: u32) -> String {
    if depth > 0 && random.u32(0..5) > 0 {
        return call(random, depth - 1);
    }
    match random.u32(0..4) {
        0 => format!("{:.3}", random.f32() * 4.0 - 2.0),
        i => format!("p.{}", ["x", "y", "z"][i as usize - 1]),
    }
}

fn call(random: &mut fastrand::Rng, depth: u32) -> String {
    let which = random.u32(0..20);
    let mut next = || grow(random, depth);
    let a = next();
    match which {
        0..=2 => format!("({a} + {})", next()),
        3..=4 => format!("({a} - {})", next()),
        5..=7 => format!("({a} * {})", next()),
        8 => format!("({a} / (abs({}) + 0.5))", next()),
        9 => format!("sqrt(abs({a}) + 0.1)"),
        10 => format!("inversesqrt(abs({a}) + 0.1)"),
        11 => format!("exp2(clamp({a}, -8.0, 8.0))"),
        12 => format!("log2(abs({a}) + 0.1)"),
        13 => format!("pow(abs({a}) + 0.1, clamp({}, -4.0, 4.0))", next()),
        14 => format!("sin(clamp({a}, -3.0, 3.0))"),
        15 => format!("min({a}, max({}, {}))", next(), next()),
        16 => format!("dot(vec3({a}, {}, {}), p)", next(), next()),
        17 => format!("length(vec3({a}, {}, 1.0))", next()),
        18 => format!("normalize(vec3({a}, {}, 1.0)).x", next()),
        _ => format!("reflect(vec3({a}, {}, {}), p.zyx).y", next(), next()),
    }
}
