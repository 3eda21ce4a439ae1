//! Cases of vectors and matrices: products, lengths, directions, inverses. Fed by the
//! intervals, feeds the families.

use super::case::{Allowed, Case};
use super::draw::Draw;
use super::interval::{ANY, Interval, dot, length};
use super::scalars::floats;

const ROOT: f32 = 1e9;

/// Vectors of so many components below `most`, none of them all but zero.
fn vectors(count: usize, size: usize, most: f32) -> impl Fn(&mut Draw) -> Vec<u32> {
    move |d| {
        let mut words = Vec::new();
        for _ in 0..count {
            let at = words.len();
            let v: Vec<f32> = (0..size).map(|_| d.float(-most, most)).collect();
            words.extend(v.iter().map(|x| x.to_bits()));
            if v.iter().all(|x| x.abs() < 1e-12) {
                words[at] = 1f32.to_bits();
            }
        }
        words
    }
}

fn intervals(v: &[f32]) -> Vec<Interval> {
    v.iter().map(|x| Interval::of(*x)).collect()
}

fn true_dot(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

pub fn all() -> Vec<Case> {
    vec![
        products("dot", "f4 f4", 4),
        products("dot of vec2", "f2 f2", 2),
        cross(),
        lengths(),
        distance(),
        normalize(),
        reflect(),
        refract(),
        faceforward(),
        transpose(),
        matrix_vector(),
        matrix_matrix(),
        determinant("determinant", "m3", &["f determinant(a)"], 3),
        determinant("determinant of mat4", "m4", &["f determinant(a)"], 4),
        inverse(),
    ]
}

fn products(name: &'static str, operands: &'static str, n: usize) -> Case {
    let permitted = "from the sum of products, in any order";
    let draw = vectors(2, n, ROOT);
    Case::new(name, permitted, operands, &["f dot(a, b)"], draw, move |w| {
        let v = floats(w);
        let (a, b) = v.split_at(n);
        vec![Allowed::Within(true_dot(a, b), dot(&intervals(a), &intervals(b)))]
    })
}

fn cross() -> Case {
    let permitted = "from differences of products";
    Case::new("cross", permitted, "f3 f3", &["f3 cross(a, b)"], vectors(2, 3, ROOT), |w| {
        let v = floats(w);
        let (a, b) = v.split_at(3);
        let (i, j) = (intervals(a), intervals(b));
        let part = |x: usize, y: usize| {
            let (left, right) = ([a[x], a[y]], [b[y], -b[x]]);
            Allowed::Within(true_dot(&left, &right), i[x].mul(j[y]).sub(i[y].mul(j[x])))
        };
        vec![part(1, 2), part(2, 0), part(0, 1)]
    })
}

fn lengths() -> Case {
    let permitted = "from `sqrt(dot(a, a))`";
    Case::new("length", permitted, "f3", &["f length(a)"], vectors(1, 3, ROOT), |w| {
        let v = floats(w);
        vec![Allowed::Within(true_dot(&v, &v).sqrt(), length(&intervals(&v)))]
    })
}

fn distance() -> Case {
    let permitted = "from `length(a - b)`";
    let draw = vectors(2, 3, ROOT);
    Case::new("distance", permitted, "f3 f3", &["f distance(a, b)"], draw, |w| {
        let v = floats(w);
        let between: Vec<f64> = (0..3).map(|i| f64::from(v[i]) - f64::from(v[i + 3])).collect();
        let truth = between.iter().map(|x| x * x).sum::<f64>().sqrt();
        let i = intervals(&v);
        let parts: Vec<Interval> = (0..3).map(|k| i[k].sub(i[k + 3])).collect();
        vec![Allowed::Within(truth, length(&parts))]
    })
}

fn normalize() -> Case {
    // WGSL divides by the length, Vulkan multiplies by the inverse root of the dot product.
    let permitted = "from `a / length(a)`";
    Case::new("normalize", permitted, "f3", &["f3 normalize(a)"], vectors(1, 3, ROOT), |w| {
        let v = floats(w);
        let i = intervals(&v);
        let truth = true_dot(&v, &v).sqrt();
        let (over, inverse) = (length(&i), dot(&i, &i).inverse_sqrt());
        let each = |k: usize| {
            let within = i[k].div(over).or(i[k].mul(inverse));
            Allowed::Within(f64::from(v[k]) / truth, within)
        };
        (0..3).map(each).collect()
    })
}

fn reflect() -> Case {
    let permitted = "from `a - 2 * dot(b, a) * b`";
    let draw = vectors(2, 3, 1e6);
    Case::new("reflect", permitted, "f3 f3", &["f3 reflect(a, b)"], draw, |w| {
        let v = floats(w);
        let (a, b) = v.split_at(3);
        let (i, n) = (intervals(a), intervals(b));
        let (truth, dot) = (true_dot(b, a), dot(&n, &i));
        let two = Interval::of(2.0);
        let each = |k: usize| {
            // The formula may be reassociated.
            let along = two.mul(dot).mul(n[k]).or(two.mul(dot.mul(n[k])));
            let along = along.or(dot.mul(two.mul(n[k])));
            Allowed::Within(f64::from(a[k]) - 2.0 * truth * f64::from(b[k]), i[k].sub(along))
        };
        (0..3).map(each).collect()
    })
}

fn refract() -> Case {
    let permitted = "from `k = 1 - c * c * (1 - dot(b, a) * dot(b, a))` and its root";
    let draw = |d: &mut Draw| {
        let mut words = Vec::new();
        for _ in 0..2 {
            let v: Vec<f64> = (0..3).map(|_| d.0.f64() * 2.0 - 1.0).collect();
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-3);
            words.extend(v.iter().map(|x| ((x / length) as f32).to_bits()));
        }
        words.push(d.float(0.3, 3.0).to_bits());
        words
    };
    Case::new("refract", permitted, "f3 f3 f", &["f3 refract(a, b, c)"], draw, |w| {
        let v = floats(w);
        let (a, b, eta) = (&v[..3], &v[3..6], v[6]);
        let (i, n, e) = (intervals(a), intervals(b), Interval::of(eta));
        let (one, cosine) = (Interval::of(1.0), dot(&n, &i));
        let sine = one.sub(cosine.mul(cosine));
        let k = one.sub(e.mul(e).mul(sine).or(e.mul(e.mul(sine))));
        let (true_cosine, true_eta) = (true_dot(a, b), f64::from(eta));
        let true_k = 1.0 - true_eta * true_eta * (1.0 - true_cosine * true_cosine);
        let each = |at: usize| {
            if k.low < 0.0 && k.high >= 0.0 {
                return Allowed::Within(f64::NAN, ANY);
            }
            if k.high < 0.0 {
                return Allowed::Correct(0.0);
            }
            let factor = e.mul(cosine).add(k.sqrt());
            let truth = true_eta * f64::from(a[at])
                - (true_eta * true_cosine + true_k.sqrt()) * f64::from(b[at]);
            Allowed::Within(truth, e.mul(i[at]).sub(factor.mul(n[at])))
        };
        (0..3).map(each).collect()
    })
}

fn faceforward() -> Case {
    let results = &["f3 faceforward(a, b, c)"];
    let draw = vectors(3, 3, ROOT);
    Case::new("faceForward", "`a` or `-a`", "f3 f3 f3", results, draw, |w| {
        let v = floats(w);
        let toward = dot(&intervals(&v[6..]), &intervals(&v[3..6]));
        let each = |k: usize| match (toward.high < 0.0, toward.low >= 0.0) {
            (true, _) => Allowed::Correct(f64::from(v[k])),
            (_, true) => Allowed::Correct(-f64::from(v[k])),
            (false, false) => Allowed::Either(v[k].to_bits(), (-v[k]).to_bits()),
        };
        (0..3).map(each).collect()
    })
}

fn transpose() -> Case {
    let draw = vectors(1, 9, f32::MAX);
    Case::new("transpose", "exact", "m3", &["m3 transpose(a)"], draw, |w| {
        (0..9).map(|i| Allowed::Word(w[i % 3 * 3 + i / 3])).collect()
    })
}

fn matrix_vector() -> Case {
    let permitted = "from sums of products, in any order";
    let draw = vectors(2, 4, ROOT);
    let draw = move |d: &mut Draw| {
        let all: Vec<u32> = (0..3).flat_map(|_| draw(d)).collect();
        all[..20].to_vec()
    };
    Case::new("matrix * vector", permitted, "m4 f4", &["f4 a * b"], draw, |w| {
        let v = floats(w);
        let each = |row: usize| {
            let line: Vec<f32> = (0..4).map(|column| v[column * 4 + row]).collect();
            Allowed::Within(true_dot(&line, &v[16..]), dot(&intervals(&line), &intervals(&v[16..])))
        };
        (0..4).map(each).collect()
    })
}

fn matrix_matrix() -> Case {
    let permitted = "from sums of products, in any order";
    let draw = vectors(6, 3, ROOT);
    Case::new("matrix * matrix", permitted, "m3 m3", &["m3 a * b"], draw, |w| {
        let v = floats(w);
        let each = |i: usize| {
            let line: Vec<f32> = (0..3).map(|k| v[k * 3 + i % 3]).collect();
            let column = &v[9 + i / 3 * 3..][..3];
            Allowed::Within(true_dot(&line, column), dot(&intervals(&line), &intervals(column)))
        };
        (0..9).map(each).collect()
    })
}

/// Rows left when a row and a column are struck out.
fn minor(m: &[Vec<f64>], row: usize, column: usize) -> Vec<Vec<f64>> {
    let kept = |i: &usize| *i != row;
    let line = |i: usize| (0..m.len()).filter(|j| *j != column).map(|j| m[i][j]).collect();
    (0..m.len()).filter(kept).map(line).collect()
}

fn laplace(m: &[Vec<f64>]) -> f64 {
    if m.len() == 1 {
        return m[0][0];
    }
    let signed = |j: usize| if j.is_multiple_of(2) { m[0][j] } else { -m[0][j] };
    (0..m.len()).map(|j| signed(j) * laplace(&minor(m, 0, j))).sum()
}

fn rows(v: &[f32], n: usize) -> Vec<Vec<f64>> {
    v.chunks(n).map(|line| line.iter().map(|x| f64::from(*x)).collect()).collect()
}

/// No specification bounds it. Of small whole numbers every step is exact, in any order.
fn determinant(
    name: &'static str,
    operands: &'static str,
    results: &'static [&'static str],
    n: usize,
) -> Case {
    let permitted = "not bounded; exact of small whole numbers";
    let draw = move |d: &mut Draw| {
        let whole = d.0.bool();
        let mut number = || match whole {
            true => d.0.i32(-9..=9) as f32,
            false => d.0.f32() * 4.0 - 2.0,
        };
        (0..n * n).map(|_| number().to_bits()).collect()
    };
    Case::new(name, permitted, operands, results, draw, move |w| {
        let v = floats(w);
        let truth = laplace(&rows(&v, n));
        match v.iter().all(|x| x.trunc() == *x) {
            true => vec![Allowed::Correct(truth)],
            false => vec![Allowed::Within(truth, ANY)],
        }
    })
}

/// Rotations and their like: far from singular.
fn inverse() -> Case {
    let draw = |d: &mut Draw| {
        let number = |i: usize, d: &mut Draw| {
            let x = d.0.f32() - 0.5;
            if i.is_multiple_of(4) { x + 3.0 } else { x }
        };
        (0..9).map(|i| number(i, d).to_bits()).collect()
    };
    Case::new("inverse", "not bounded; held to 2^-20", "m3", &["m3 inverse(a)"], draw, |w| {
        let m = rows(&floats(w), 3);
        let whole = laplace(&m);
        let each = |i: usize| {
            let (row, column) = (i / 3, i % 3);
            let sign = if (row + column).is_multiple_of(2) { 1.0 } else { -1.0 };
            let truth = sign * laplace(&minor(&m, column, row)) / whole;
            Allowed::Within(truth, Interval::constant(truth).absolute(2f64.powi(-20)))
        };
        (0..9).map(each).collect()
    })
}
