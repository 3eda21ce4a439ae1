//! The proven error of interpolating a light over a rectangle of a plane.
//!
//! Through `m` Chebyshev nodes along a side of half length `H`, a function errs by at most
//! `2 (H / 2)^m |f_m|`, `f_m` being the `m`th coefficient of its Taylor series along that side at
//! any point; over both sides by `E_x + L E_y`, `L` being Lebesgue's constant.
//!
//! Body: of `s = r^2`, `1 / (c + l r + q r^2)` is the inverse of a complete Bernstein function, so a sum
//! of `1 / (s + z)` with positive weights and `z >= 0`, and that over `r` one of `(s + z)^(-3/2)`
//! (Schilling, Song, Vondracek, *Bernstein Functions*, theorem 7.3). The Taylor coefficients of those
//! along a line are Gegenbauer polynomials of the cosine `t` between the line and the direction to the
//! light, which `z` makes smaller, over powers of `r`, which it makes larger: of order `m` at most
//! `|C_m(t')| / r^m` of the function, with the worst `|t'| <= |t|`. On a plane `n . (D - x)` is constant.
//!
//! Highlight: a function from 0 to `M` errs by at most half of `M (1 + L^2)`. Or by Cauchy's estimate on
//! discs of radius `R` around real points. There the angles of `D - x` and of the mirrored view turn by
//! complex numbers of absolute values that sum to at most `q = sin a / (1 - a) + sin' b / (1 - b)`,
//! `a = R / d`, `b = R / e`, with the sines of their angles to the side; for turns of `X + i Y` the
//! cosine of the angle between them has the bound of [`cosine`].
//!
//! Of several lamps at once the bounds are those of one anywhere within their radius that has the terms
//! of all; that none of them is on both sides of the plane is then left to the caller.
//!
//! Bounds are computed in `f32`, of several lights at once. Coordinates are those of the plane, whose
//! rounding counts as distance from it; angles are made smaller by the error of their approximation;
//! the hundred roundings of a bound, raised to the power of the highlight, are within one percent.

use glam::DVec3;
use pulp::Simd;

use super::lamps::COMPONENTS;
use crate::lanes::Lanes;

mod errors;
mod gegenbauer;

pub(super) use errors::Errors;
use gegenbauer::Gegenbauer;

/// Larger than the error of [`angle`] and of its subtractions.
const ANGLE: f32 = 1e-4;

/// The factor above all relative errors of `f32`.
const MORE: f32 = 1.01;

/// The part of a distance by which its `f32` may be too large.
const FARTHER: f32 = 1.0 / (1 << 20) as f32;

/// The distance up to which no square overflows.
const FARTHEST: f32 = 1e15;

/// A rectangle of a plane, in coordinates along the plane's axes and normal.
pub(super) struct Rectangle {
    pub center: [f64; 2],
    /// Half its length along each axis.
    pub half: [f64; 2],
    /// The camera.
    pub eye: DVec3,
    /// The largest distance of a fragment or node from its place on the plane.
    pub off: f64,
    /// The largest error of a coordinate.
    pub rounding: f64,
    /// The largest difference of a unit normal from that of the plane.
    pub tilt: f64,
}

impl Rectangle {
    pub fn diameter(&self) -> f64 {
        2.0 * self.half[0].hypot(self.half[1])
    }
}

/// What is done with the light of a lamp.
pub(super) struct Shading {
    pub shininess: f64,
    /// Whether surfaces that face away have highlights.
    pub everywhere: bool,
}

/// The constants of interpolation through `m` nodes a side, 2 to 8.
#[derive(Clone, Copy, Default)]
pub(super) struct Order {
    m: u32,
    /// The bounds of the `m`th terms of the attenuation, and of that over the distance.
    terms: [Gegenbauer; 2],
    lebesgue: f32,
    /// The factor of an error at points and nodes.
    twice: f32,
}

impl Order {
    pub fn new(nodes: u32) -> Order {
        let lebesgue = 1.0 + 2.0 / std::f64::consts::PI * f64::from(nodes).ln();
        Order {
            m: nodes,
            terms: [1.0, 1.5].map(|of| Gegenbauer::new(nodes, of)),
            lebesgue: lebesgue as f32,
            twice: (1.0 + lebesgue * lebesgue) as f32,
        }
    }

    /// The nodes of a side.
    pub fn side(&self) -> u32 {
        self.m
    }

    /// The nodes of a grid.
    pub fn nodes(&self) -> usize {
        self.m.pow(2) as usize
    }

    /// Returns the error over both sides.
    #[inline(always)]
    fn both<S: Simd>(&self, [x, y]: [Lanes<S>; 2]) -> Lanes<S> {
        x.smaller(y).mul_add(x.splat(self.lebesgue), x.larger(y))
    }
}

/// The most orders of one rectangle.
pub(super) const ORDERS: usize = 4;

/// What the errors of all lamps over a rectangle have in common.
struct Bound {
    center: [f32; 2],
    half: [f32; 2],
    off: f32,
    /// The largest error of a distance.
    margin: f32,
    tilt: f32,
    /// The distance of the camera, inverted.
    eye: f32,
    /// The largest sines of the angles of the view to the sides.
    eye_sines: [f32; 2],
    /// The direction of the mirrored view at the centre.
    mirrored: [f32; 3],
    radius: f32,
    orders: [Order; ORDERS],
    count: usize,
    /// Whether a lamp has an ambient term.
    ambient: bool,
    shininess: f32,
    /// The power of the highlight, not above `shininess`.
    exponent: u32,
    /// Whether `shininess` is `exponent`.
    whole: bool,
    /// The turn of the highlight by its discs, inverted.
    inverse_turn: f32,
    everywhere: bool,
    /// The largest error of a lamp that is taken.
    most: f32,
    /// The highlight from which discs are worth their time.
    shines: f32,
}

impl Bound {
    /// Returns `None` if no error is known.
    fn new(
        orders: &[Order],
        at: &Rectangle,
        shading: &Shading,
        (most, ambient): (f32, bool),
    ) -> Option<Bound> {
        let margin = at.off + at.rounding;
        let beyond = |axis: usize| {
            ((at.eye.to_array()[axis] - at.center[axis]).abs() - at.half[axis]).max(0.0)
        };
        let over = at.eye.z;
        let eye = beyond(0).hypot(beyond(1)).hypot(over) * (1.0 - 1e-9) - margin;
        let known = eye > 0.0 && over.abs() > margin && shading.shininess >= 0.0;
        if !known || !(eye + at.half[0] + at.half[1]).is_finite() {
            return None;
        }
        let view = at.eye - DVec3::new(at.center[0], at.center[1], 0.0);
        let mirrored = DVec3::new(-view.x, -view.y, view.z).normalize();
        let sine = |axis: usize| {
            let across = view.to_array()[1 - axis].abs() + at.half[1 - axis];
            let across = across.hypot(over) + margin;
            across / across.hypot((beyond(axis) - margin).max(0.0))
        };
        let exponent = shading.shininess.floor().min(1024.0);
        let whole = exponent >= 1.0 && exponent == shading.shininess;
        let mut all = [Order::default(); ORDERS];
        all[..orders.len()].copy_from_slice(orders);
        let highest = orders.last().map_or(0, |order| order.m);
        let best = (f64::from(highest) / shading.shininess).sqrt();
        Some(Bound {
            center: at.center.map(|x| x as f32),
            half: at.half.map(|x| x as f32),
            off: at.off as f32,
            margin: margin as f32,
            tilt: at.tilt as f32,
            eye: (1.0 / eye) as f32,
            eye_sines: [sine(0) as f32, sine(1) as f32],
            mirrored: mirrored.to_array().map(|x| x as f32),
            radius: (at.half[0].hypot(at.half[1]) + margin) as f32,
            orders: all,
            count: orders.len(),
            ambient,
            shininess: shading.shininess as f32,
            exponent: exponent as u32,
            whole,
            inverse_turn: (1.0 / (best * 0.8).min(0.95)) as f32,
            everywhere: shading.everywhere,
            most,
            shines: most * 3e-3,
        })
    }

    /// Returns the errors of the attenuation and of that over the distance, at `1 / inverse`, by order.
    #[inline(always)]
    fn bodies<S: Simd>(
        &self,
        inverse: Lanes<S>,
        cosines: [Lanes<S>; 2],
    ) -> [[Lanes<S>; 2]; ORDERS] {
        let sides = [inverse * (0.5 * self.half[0]), inverse * (0.5 * self.half[1])];
        let mut powers = Powers::new(sides, [inverse.splat(2.0); 2]);
        let mut bodies = [[inverse; 2]; ORDERS];
        for (bodies, order) in bodies.iter_mut().zip(&self.orders[..self.count]) {
            let powers = powers.upto(order.m);
            for (at, body) in bodies.iter_mut().enumerate().skip(usize::from(!self.ambient)) {
                let terms = &order.terms[at];
                let [x, y] = cosines;
                *body = order.both([powers[0] * terms.most(x), powers[1] * terms.most(y)]);
            }
        }
        bodies
    }

    /// Returns the errors of lamps, by order. Which bound a lamp has depends on those beside it: discs bound
    /// all of a register if one is worth it.
    #[inline(always)]
    fn of<S: Simd>(&self, light: [Lanes<S>; COMPONENTS]) -> [Lanes<S>; ORDERS] {
        let [x, y, height, c, l, q, ambient, diffuse, specular, radius] = light;
        let lamp = [c, l, q];
        let (zero, unknown) = (x.splat(0.0), x.splat(f32::INFINITY));
        let (x, y) = (x - self.center[0], y - self.center[1]);
        let beyond_x = (x.abs() - self.half[0]).larger(zero);
        let beyond_y = (y.abs() - self.half[1]).larger(zero);
        let above = height * height;
        let square = beyond_x.mul_add(beyond_x, beyond_y.mul_add(beyond_y, above));
        let d = square.sqrt() * (1.0 - FARTHER) - radius - self.margin;
        let slack = (d + radius * 2.0) * self.tilt + self.margin;
        // The side of the plane is the same everywhere, in `f32` too; the caller checks those of several.
        let sided = (slack + d * 1e-5).less(height.abs() * (1.0 - FARTHER));
        let known = zero.less(d).and(d.less(d.splat(FARTHEST))).and(zero.less(radius).or(sided));
        let inverse = 1.0 / d;
        let weight = 1.0 / divisor(lamp, d);
        let ends = [x.abs() + self.half[0], y.abs() + self.half[1]];
        let within = radius + self.margin;
        let across = [beyond_y.mul_add(beyond_y, above), beyond_x.mul_add(beyond_x, above)];
        let cosines = [
            squared_cosine(ends[0], across[0], within, [d, inverse]),
            squared_cosine(ends[1], across[1], within, [d, inverse]),
        ];
        // Points off the plane and normals off its own, nodes among them: twice for the polynomial.
        let moved = inverse * self.off;
        let faces = zero.less(height + radius);
        let facing = (height.max(zero) + radius + slack) * inverse;
        let mut errors = [unknown; ORDERS];
        let bodies = self.bodies(inverse, cosines);
        for ((error, order), bodies) in
            errors.iter_mut().zip(&self.orders[..self.count]).zip(bodies)
        {
            let off = moved * 4.0 + self.tilt;
            let mut body = diffuse * bodies[1].mul_add(facing, off * order.twice);
            body = faces.select(body, zero);
            if self.ambient {
                body = body + ambient * (bodies[0] + moved * (2.0 * order.twice));
            }
            *error = known.select(body * weight, unknown);
        }
        let taken = errors[self.count - 1].less(zero + self.most);
        if !taken.any() {
            return [unknown; ORDERS];
        }
        let [mx, my, mz] = self.mirrored;
        let along = x * mx + y * my + height * mz;
        let length = x.mul_add(x, y.mul_add(y, above)).sqrt();
        let angle = angle(along / length);
        // What fragments and nodes off their places turn both by, what the rectangle does, and the
        // angle under which several lamps are seen: the arc sine is below its secant.
        let turned = moved + (4.0 * self.tilt + self.off * self.eye);
        let turn = (inverse + self.eye) * self.radius + turned;
        let turn = turn + (radius / length * std::f32::consts::FRAC_PI_2 + ANGLE);
        let least = (angle - turn).max(zero);
        let square = least * least;
        // Above the cosine, up to a right angle.
        let most = (1.0 - square * (0.5 - square * (1.0 / 24.0))).max(zero);
        let most = least.less(zero + std::f32::consts::FRAC_PI_2).select(most, zero);
        let by_size = most.powi(self.exponent) * weight * 0.5;
        let specular = if self.everywhere { specular } else { faces.select(specular, zero) };
        let orders = &self.orders[..self.count];
        let highlight = specular * by_size * self.orders[self.count - 1].twice;
        // Discs take longest: where one that might be taken has a highlight worth it.
        let shines = taken.and((zero + self.shines).less(highlight));
        if !(self.whole && shines.any()) {
            for (error, order) in errors.iter_mut().zip(orders) {
                let highlight = specular * by_size * order.twice;
                *error = (*error + highlight) * MORE + f32::MIN_POSITIVE;
            }
            return errors;
        }
        let sines =
            [sine(beyond_x, (ends[1], height), within), sine(beyond_y, (ends[0], height), within)];
        let slope = most.powi(self.exponent.saturating_sub(1));
        let flat = slope * (turned * self.shininess + moved * 2.0) * weight;
        let sides = [
            self.by_discs(0, (least, sines[0]), lamp, [d, inverse]),
            self.by_discs(1, (least, sines[1]), lamp, [d, inverse]),
        ];
        // Where it is not clamped, a whole power is a polynomial of the cosine.
        let smooth = (angle + turn).less(zero + 1.57);
        let [x, y] = sides;
        let mut powers = Powers::new([x.0, y.0], [x.1, y.1]);
        for (error, order) in errors.iter_mut().zip(orders) {
            let by_discs = order.both(powers.upto(order.m)) + flat * order.twice;
            let by_size = by_size * order.twice;
            let shine = smooth.select(by_discs, by_size).min(by_size);
            *error = (*error + specular * shine) * MORE + f32::MIN_POSITIVE;
        }
        errors
    }

    /// Returns half of a side over the radius of discs that turn the angle so far at most, and twice the
    /// largest value of a highlight of strength 1 on them; infinite or NaN if that is not known.
    #[inline(always)]
    fn by_discs<S: Simd>(
        &self,
        axis: usize,
        (least, sine): (Lanes<S>, Lanes<S>),
        lamp: [Lanes<S>; 3],
        [d, inverse]: [Lanes<S>; 2],
    ) -> (Lanes<S>, Lanes<S>) {
        let one = d.splat(1.0);
        let eye = self.eye_sines[axis];
        let nearer = inverse.larger(d.splat(self.eye));
        let turned = (sine * inverse + eye * self.eye) * self.inverse_turn;
        // So that neither `1 - a` nor `1 - b` loses its digits.
        let inverse_radius = (turned + nearer * 1.001).larger(inverse * 1.25);
        let radius = 1.0 / inverse_radius;
        let (a, b) = (radius * inverse, radius * self.eye);
        let (rest_a, rest_b) = (1.0 - a, 1.0 - b);
        let q = (sine * a * rest_b + b * eye * rest_a) / (rest_a * rest_b);
        let known = b.less(one).and(q.less(one));
        let weight = 2.0 / (divisor(lamp, d * rest_a) * (1.0 - a * a).sqrt());
        let square = cosine(least, q);
        let power = match self.exponent % 2 {
            0 => square.powi(self.exponent / 2),
            _ => square.sqrt().powi(self.exponent),
        };
        let bound = power * weight;
        let (part, unknown) = (inverse_radius * (0.5 * self.half[axis]), d.splat(f32::INFINITY));
        (known.select(part, unknown), known.select(bound, unknown))
    }
}

/// Powers of a part of each side, times factors.
struct Powers<S: Simd> {
    sides: [Lanes<S>; 2],
    squares: [Lanes<S>; 2],
    powers: [Lanes<S>; 2],
    /// How many squares there are in the powers.
    count: u32,
}

impl<S: Simd> Powers<S> {
    #[inline(always)]
    fn new([x, y]: [Lanes<S>; 2], factors: [Lanes<S>; 2]) -> Powers<S> {
        Powers { sides: [x, y], squares: [x * x, y * y], powers: factors, count: 0 }
    }

    /// Returns the powers of `m`, which does not fall from one call to the next.
    #[inline(always)]
    fn upto(&mut self, m: u32) -> [Lanes<S>; 2] {
        let Powers { sides, squares, powers: [x, y], count } = self;
        while *count < m / 2 {
            (*x, *y) = (*x * squares[0], *y * squares[1]);
            *count += 1;
        }
        match m % 2 {
            0 => [*x, *y],
            _ => [*x * sides[0], *y * sides[1]],
        }
    }
}

/// Returns the squared cosine of the smallest angle to a side of a rectangle, in which lamps `within`
/// that distance are seen at most so far along it and at least the root of `across` to its side, and
/// at least at a distance `d`.
#[inline(always)]
fn squared_cosine<S: Simd>(
    along: Lanes<S>,
    across: Lanes<S>,
    within: Lanes<S>,
    [d, inverse]: [Lanes<S>; 2],
) -> Lanes<S> {
    let along = along + within;
    // (x - w)^2 >= x^2 - 2 x w >= x^2 - w (x^2 / d + d), without a root.
    let across = (across - within * (across * inverse + d)).max(across.splat(0.0));
    let square = along * along;
    (square / (square + across)).min(square.splat(1.0))
}

/// Returns the sine of the largest angle to a side of lamps seen at least so far along it and at most
/// so far across and above.
#[inline(always)]
fn sine<S: Simd>(
    along: Lanes<S>,
    (across, height): (Lanes<S>, Lanes<S>),
    within: Lanes<S>,
) -> Lanes<S> {
    let along = (along - within).max(along.splat(0.0));
    let across = (across * across + height * height).sqrt() + within;
    across / (across * across + along * along).sqrt()
}

/// Returns the inverse of the attenuation at a distance.
#[inline(always)]
fn divisor<S: Simd>([c, l, q]: [Lanes<S>; 3], d: Lanes<S>) -> Lanes<S> {
    c + d * (l + q * d)
}

/// Returns the angle of a cosine, 7e-5 off at most (Abramowitz and Stegun, 4.4.45).
#[inline(always)]
fn angle<S: Simd>(cosine: Lanes<S>) -> Lanes<S> {
    let x = cosine.abs().min(cosine.splat(1.0));
    let series = x * (x * (x * -0.018_729_3 + 0.074_261) - 0.212_114_4) + 1.570_728_8;
    let acute = (1.0 - x).sqrt() * series;
    cosine.less(x.splat(0.0)).select(std::f32::consts::PI - acute, acute)
}

/// Returns the largest squared absolute value of the cosine of an angle of at least `least` that
/// turns by `X + i Y`, `X^2 + Y^2 <= q^2`, `q <= 1`: for directions in space
/// `(B cosh Y + (1 - B) (cosh Y - 1) / 2)^2 + (1 - B^2) sinh^2 Y`, `B = cos(least - X)`, which grows
/// with `B` and `Y`; each of three parts of `Y` has the bound of its ends. Series stand for cosines,
/// above them.
#[inline(always)]
fn cosine<S: Simd>(least: Lanes<S>, q: Lanes<S>) -> Lanes<S> {
    let first = cosine_part(least, q, [1.0 / 3.0, 1.0]);
    let second = cosine_part(least, q, [2.0 / 3.0, 0.942_81]);
    first.larger(second).larger(cosine_part(least, q, [1.0, 0.745_36]))
}

/// Returns the bound for `Y` up to a part of `q`, and `X` up to another.
#[inline(always)]
fn cosine_part<S: Simd>(least: Lanes<S>, q: Lanes<S>, [most_y, most_x]: [f32; 2]) -> Lanes<S> {
    let (zero, one) = (q.splat(0.0), q.splat(1.0));
    let high = q * most_y;
    let real = (least - q * most_x).max(zero);
    let square = real * real;
    let real = (1.0 - square * (0.5 - square * (1.0 / 24.0))).larger(zero).smaller(one);
    // The rest of the series is less than Y^4 / 600 up to 1.
    let square = high * high;
    let above = square * (square * (1.0 / 23.0) + 0.5);
    let cosh = above + 1.0;
    let grown = real * cosh + (1.0 - real) * above * 0.5;
    grown * grown + (1.0 - real * real) * (cosh * cosh - 1.0)
}

#[cfg(test)]
mod tests;
