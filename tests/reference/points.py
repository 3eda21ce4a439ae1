#!/usr/bin/env python3
"""The light of random fragments at 80 digits: writes tests/reference/FAMILY.txt.

    python3 tests/reference/points.py

Needs mpmath. Written from the formulas as textbooks have them (cosines, not chords; a power of a
cosine, not an exponential), which at 80 digits lose nothing. What a point is comes from `draw`;
tests/reference/draw.rs draws the same. A line is one point, from number 0: the sum's red and
green, then the green of all diffuse terms and of all highlights; or the hazard it is undefined by.

The draws: splitmix64, started at `seed = family << 32 | number`; `whole(n)` is the next output
modulo n, `part()` its upper 24 bits over 2^24, `sign()` is 2 part() - 1, and `log(a, b)` is
(1 + m / 2^23) 2^e with e = a + whole(b - a), then m the upper 23 bits of the next. Arithmetic on
draws is IEEE double, in the order written; `f32` rounds to single.
"""

import math
import os
import struct
import sys

from mpmath import mp, mpf, cos, pi, sqrt

mp.dps = 80

FAMILIES = ["multi", "array", "view_space", "casters"]
POINTS = 1300
HAZARDS = 14


def f32(x):
    return struct.unpack("f", struct.pack("f", x))[0]


class Draw:
    def __init__(self, seed):
        self.state = seed

    def next(self):
        self.state = (self.state + 0x9E3779B97F4A7C15) & (2**64 - 1)
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & (2**64 - 1)
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & (2**64 - 1)
        return z ^ (z >> 31)

    def whole(self, n):
        return self.next() % n

    def part(self):
        return (self.next() >> 40) / 2.0**24

    def sign(self):
        return self.part() * 2.0 - 1.0

    def log(self, a, b):
        e = a + self.whole(b - a)
        return (1.0 + (self.next() >> 41) / 2.0**23) * 2.0**e

    def color(self):
        return [self.part() for _ in range(3)]

    def direction(self):
        """Of about unit length."""
        v = [self.sign() for _ in range(3)]
        return scaled(v, 1.0 / math.sqrt(dot(v, v)))

    def texel(self):
        return [self.whole(256) / 255.0 for _ in range(3)]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def scaled(v, k):
    return [x * k for x in v]


def plus(a, b):
    return [x + y for x, y in zip(a, b)]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def rounded(v):
    return [f32(x) for x in v]


def draw(family, number):
    """A point: switches, fragment, lights, material."""
    d = Draw(family << 32 | number)
    p = {"family": FAMILIES[family]}
    switches = {
        "normal": d.whole(2),  # unit, as_interpolated
        "ambient": d.whole(3),  # per_light, once, none
        "gate": d.whole(2),  # none, facing
        "blinn": d.whole(2),
        "window": d.whole(2),
        "hard": d.whole(4) // 3,
        "angles": d.whole(2),
        "caster": d.whole(3),  # none, direct, all
        "published": d.whole(2),
        "reflectance": d.whole(3),  # ignored, gate, factor
        "ten": d.whole(2),
    }
    if number % 4 == 0:
        # The family as it is.
        view = family == 2
        once = family in (1, 2)
        switches.update(normal=0, ambient=int(once), gate=0, blinn=0, window=0, hard=0, caster=1)
        switches.update(published=0, reflectance=int(view), ten=int(view))
    p.update(switches)

    at = scaled([d.sign() for _ in range(3)], 8.0)
    far = [d.sign() for _ in range(3)]
    if d.whole(6) == 0:
        at = plus(at, scaled(far, 1e6))
    p["at"] = at = rounded(at)
    shorter, other, which = d.part(), d.sign(), d.whole(2)
    length = 1.0 - shorter / 4.0 if which else 1.0 + other / 1024.0
    p["n"] = n = rounded(scaled(d.direction(), length))

    emission = lambda: {
        "ambient": scaled(d.color(), 0.25),
        "diffuse": d.color(),
        "specular": d.color(),
        "color": d.color(),
        "intensity": d.log(-3, 3),
    }

    def lamp():
        light = emission()
        away = d.direction()
        far = d.log(-10, 13)
        light["position"] = rounded(plus(at, scaled(away, far)))
        light["c"], light["l"], light["q"] = d.log(-2, 1), d.log(-10, 0), d.log(-20, 0)
        light["range"] = f32(far * d.log(-1, 3))
        return light

    sun = emission()
    sun["direction"] = rounded(d.direction())
    point = lamp()
    spot = lamp()
    j = d.whole(23)
    outer = 2**j + d.whole(2**j)
    inner = d.whole(outer)
    same = d.whole(8) == 0
    if same:
        inner = outer
    spot["outer"], spot["inner"] = 1.0 - outer / 2.0**24, 1.0 - inner / 2.0**24
    wide = d.log(-7, 6)
    narrow = f32(wide * d.part())
    spot["degrees"] = [wide if same else narrow, wide]
    aside = wide / 57.0 if p["angles"] else math.sqrt(outer / 2.0**23)
    down = minus(at, spot["position"])
    size = math.sqrt(dot(down, down))
    down = scaled(down, 1.0 / size) if size > 0.0 else [0.0, 0.0, 1.0]
    aside = aside * (d.part() * 1.25)
    spot["direction"] = rounded(plus(down, scaled(d.direction(), aside)))
    p["suns"], p["points"], p["spots"] = [sun], [point], [spot]
    if p["family"] == "casters":
        keep = number % 3
        p["suns"] = [sun] if keep == 0 else []
        p["points"] = [point] if keep == 1 else []
        p["spots"] = [spot] if keep == 2 else []
    p["fog"] = {"color": d.color(), "intensity": d.part()}

    # The camera: anywhere, or near the mirror image of the light that is looked at.
    looked = [sun["direction"], minus(at, point["position"]), minus(at, spot["position"])][number % 3]
    size = math.sqrt(dot(looked, looked))
    to_light = scaled(looked, -1.0 / size) if size > 0.0 else [0.0, 0.0, 1.0]
    unit = scaled(n, 1.0 / math.sqrt(dot(n, n)))
    mirror = minus(scaled(unit, 2.0 * dot(unit, to_light)), to_light)
    mirror = plus(mirror, scaled(d.direction(), 2.0 ** -float(d.whole(12))))
    anywhere = d.direction()
    away = d.log(-10, 13)
    p["camera"] = rounded(plus(at, scaled(anywhere if d.whole(2) else mirror, away)))

    p["shininess"] = d.log(0, 12)
    p["shine"] = d.part() if d.whole(4) else 0.0
    p["tex"] = {"ambient": d.texel(), "diffuse": d.texel(), "specular": d.texel()}
    if number % 8 == 7:
        spoil(p, number // 8 % HAZARDS)
    return p


def spoil(p, hazard):
    """Makes a point one of the edges at which light is undefined, or nearly."""
    lamps = p["points"] + p["spots"]
    if hazard == 0 or hazard == 1:
        for lamp in lamps:
            lamp["position"] = p["at"]
            lamp["c"] = 0.0 if hazard == 1 else 1.0
    elif hazard == 2:
        p["camera"] = p["at"]
    elif hazard == 3:
        for lamp in lamps:
            lamp["c"] = lamp["l"] = lamp["q"] = 0.0
    elif hazard == 4:
        for lamp in lamps:
            lamp["position"] = rounded([0.0, 1e19, 3e18])
    elif hazard == 5:
        p["at"] = [0.0, 0.0, 0.0]
        for lamp in lamps:
            lamp["position"] = rounded([1e-20, 0.0, 1e-17])
    elif hazard == 6 or hazard == 7:
        # On the axis of a cone of 0.02 degrees, or of none.
        p["at"] = [1.0, 2.0, 3.0]
        for spot in p["spots"]:
            spot["position"], spot["direction"] = [4.0, 6.0, 5.0], [-3.0, -4.0, -2.0]
            spot["inner"] = spot["outer"] = 1.0 - 2.0**-24 if hazard == 6 else 1.0
            spot["degrees"] = [0.0078125, 0.0078125] if hazard == 6 else [0.0, 0.0]
    elif hazard == 8 or hazard == 13:
        # Every light behind the surface, with a power of zero, or less.
        p["at"], p["n"], p["camera"] = [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0]
        for sun in p["suns"]:
            sun["direction"] = [0.0, 0.0, 1.0]
        for lamp in lamps:
            lamp["position"] = [0.0, 0.0, -1.0]
        for spot in p["spots"]:
            spot["direction"] = [0.0, 0.0, 1.0]
        p["shininess"] = 0.0 if hazard == 8 else -1.0
        p["ten"] = 0
    elif hazard == 9:
        for light in p["suns"] + p["spots"]:
            light["direction"] = [0.0, 0.0, 0.0]
    elif hazard == 10:
        p["n"] = [0.0, 0.0, 0.0]
    elif hazard == 11:
        for light in p["suns"] + lamps:
            light["diffuse"] = light["color"] = [0.5, math.nan, 0.5]
    elif hazard == 12:
        p["at"], p["camera"], p["blinn"] = [1.0, 2.0, 3.0], [2.0, 4.0, 6.0], 1
        for sun in p["suns"]:
            sun["direction"] = [1.0, 2.0, 3.0]
        for lamp in lamps:
            lamp["position"] = [0.0, 0.0, 0.0]
    else:
        raise ValueError(hazard)


# From here on the truth, at 80 digits.


class Undefined(Exception):
    pass


def exact(v):
    return [mpf(x) for x in v]


def normalized(v, hazard):
    size = sqrt(dot(v, v))
    if size == 0:
        raise Undefined(hazard)
    return scaled(v, 1 / size)


def power(x, n):
    if x > 0:
        return x**n
    if n > 0:
        return mpf(0)
    raise Undefined("pow-of-zero" if n == 0 else "pow-of-negative")


def tinted(*colors):
    out = [mpf(1)] * 3
    for color in colors:
        out = [x * mpf(y) for x, y in zip(out, color)]
    return out


def truth(p):
    """Sum, and of each kind of term the sum."""
    family, tex = p["family"], p["tex"]
    at, n_given = exact(p["at"]), exact(p["n"])
    to_camera = minus(exact(p["camera"]), at)
    if sqrt(dot(to_camera, to_camera)) < mpf(1e-15):
        raise Undefined("camera-at-fragment")
    if sqrt(dot(to_camera, to_camera)) > mpf(1e18):
        raise Undefined("overflow")
    view = normalized(to_camera, "camera-at-fragment")
    n = normalized(n_given, "zero-direction")
    mirror_n = n_given if p["normal"] else n
    exponent = mpf(10) if p["ten"] else mpf(p["shininess"])

    def highlight(l, facing):
        strength = {0: mpf(1), 1: mpf(p["shine"] > 0), 2: mpf(p["shine"])}[p["reflectance"]]
        if strength == 0 or (p["gate"] and facing <= 0):
            return mpf(0)
        if p["blinn"]:
            half = normalized(plus(l, view), "light-at-fragment")
            return strength * power(max(dot(mirror_n, half), mpf(0)), exponent)
        back = plus(scaled(l, -1), scaled(mirror_n, 2 * dot(mirror_n, l)))
        return strength * power(max(dot(view, back), mpf(0)), exponent)

    def attenuation(light, d):
        divisor = mpf(light["c"]) + mpf(light["l"]) * d + mpf(light["q"]) * d**2
        if divisor <= 0:
            raise Undefined("attenuation-unset")
        window = mpf(1)
        if p["window"]:
            window = max(1 - (d / mpf(light["range"])) ** 4, mpf(0)) ** 2
        return window / divisor

    def cone(light, l):
        axis = normalized(scaled(exact(light["direction"]), -1), "zero-direction")
        theta = dot(l, axis)
        if p["angles"]:
            inner, outer = [cos(mpf(x) * pi / 180) for x in light["degrees"]]
        else:
            inner, outer = mpf(light["inner"]), mpf(light["outer"])
        if family == "view_space":
            if p["hard"]:
                return mpf(theta > outer)
            if outer == 1:
                raise Undefined("zero-width-cone")
            return max((theta - outer) / (1 - outer), mpf(0))
        if p["hard"]:
            return mpf(theta > inner)
        if inner == outer:
            if abs(theta - outer) < mpf(1e-7):
                raise Undefined("equal-cut-offs")
            return mpf(theta > outer)
        return min(max((theta - outer) / (inner - outer), mpf(0)), mpf(1))

    def terms(light, l, ambient_part, direct_part, dark=False):
        facing = max(dot(n, l), mpf(0))
        shine = mpf(0) if dark else highlight(l, facing)
        if family in ("multi", "casters"):
            diffuse = tinted(light["diffuse"], tex["diffuse"])
            specular = tinted(light["specular"], tex["specular"])
        else:
            one = scaled(exact(light["color"]), mpf(light["intensity"]))
            diffuse = tinted(one, tex["diffuse"])
            specular = tinted(one, tex["specular"])
            if family == "array" and p["published"]:
                specular = tinted(light["color"], [tex["specular"][0]] * 3, tex["diffuse"])
        ambient = tinted(light["ambient"], tex["ambient" if family == "view_space" else "diffuse"])
        if p["ambient"] != 0:
            ambient = [mpf(0)] * 3
        return [
            scaled(ambient, ambient_part),
            scaled(diffuse, facing * direct_part),
            scaled(specular, shine * direct_part),
        ]

    def lamp(light, is_spot):
        path = minus(exact(light["position"]), at)
        d = sqrt(dot(path, path))
        if d == 0:
            raise Undefined("attenuation-at-light" if light["c"] == 0 else "light-at-fragment")
        if d < mpf(1e-15):
            raise Undefined("underflow")
        if d > mpf(1e18):
            raise Undefined("overflow")
        l = scaled(path, 1 / d)
        if not is_spot:
            weak = attenuation(light, d)
            return terms(light, l, weak, weak)
        weak = mpf(1)
        if family != "casters" or p["caster"] != 0:
            weak = attenuation(light, d)
        inside = cone(light, l)
        dark = bool(p["hard"]) and inside == 0
        if family == "casters":
            return terms(light, l, weak if p["caster"] == 2 else mpf(1), weak * inside, dark)
        return terms(light, l, weak * inside, weak * inside, dark)

    lights = []
    skipped = lambda light: family == "view_space" and light["intensity"] <= 0
    for light in p["suns"]:
        if not skipped(light):
            lights.append(terms(light, normalized(scaled(exact(light["direction"]), -1), "zero-direction"), 1, 1))
    for light in p["points"]:
        if not skipped(light):
            lights.append(lamp(light, False))
    for light in p["spots"]:
        if not skipped(light):
            lights.append(lamp(light, True))

    total = [mpf(0)] * 3
    if p["ambient"] == 1:
        surface = tex["ambient" if family == "view_space" else "diffuse"]
        total = scaled(tinted(p["fog"]["color"], surface), mpf(p["fog"]["intensity"]))
    for light in lights:
        for term in light:
            total = plus(total, term)
    if any(mp.isnan(x) for x in total):
        raise Undefined("zero-direction")
    sums = [sum((light[i][1] for light in lights), mpf(0)) for i in (1, 2)]
    return [total[0], total[1]] + sums


def main():
    here = os.path.dirname(os.path.abspath(sys.argv[0]))
    for family, name in enumerate(FAMILIES):
        with open(os.path.join(here, name + ".txt"), "w") as table:
            for number in range(POINTS):
                try:
                    red, green, diffuse, specular = truth(draw(family, number))
                    long = [mp.nstr(x, 30, strip_zeros=True) for x in (red, green)]
                    short = [mp.nstr(x, 20, strip_zeros=True) for x in (diffuse, specular)]
                    table.write(" ".join(long + short) + "\n")
                except Undefined as hazard:
                    table.write(f"{hazard}\n")


if __name__ == "__main__":
    main()
