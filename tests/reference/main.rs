//! The reference of lighting against published values, 80 digits, and itself.
//!
//! The tables are points.py's: `python3 tests/reference/points.py` writes them again.

mod draw;

use draw::{FAMILIES, Point, draw, fragment, six_lights, turned};
use glam::DVec3;
use landfall::light::reference::*;
use landfall::light::sample::{Texels, texels};

const TABLES: [&str; 4] = [
    include_str!("multi.txt"),
    include_str!("array.txt"),
    include_str!("view_space.txt"),
    include_str!("casters.txt"),
];

fn shaded(point: &Point) -> Result<Shaded, Undef> {
    shade(&point.model, &point.upload, &point.fragment, &point.texels)
}

const WHITE: Texels = Texels { ambient: DVec3::ONE, diffuse: DVec3::ONE, specular: DVec3::ONE };

/// Relative, of numbers an `f64` has.
fn off(got: f64, wanted: f64) -> f64 {
    if wanted.abs() < 1e-290 { (got - wanted).abs() } else { ((got - wanted) / wanted).abs() }
}

#[test]
fn lights_agree_with_80_digits_to_1e_12_and_hazards_are_tags() {
    for (family, (name, _)) in FAMILIES.iter().enumerate() {
        let lines: Vec<&str> = TABLES[family].lines().collect();
        let (mut numbers, mut worst, mut terms) = (0, (0.0, 0), (0.0, 0));
        for (number, line) in lines.iter().enumerate() {
            let point = draw(family, number as u64);
            let got = shaded(&point);
            if line.starts_with('H') {
                let hazard = got.map_err(Undef::hazard).expect_err(line);
                assert_eq!(hazard, *line, "point {number} of {name}");
                continue;
            }
            let wanted: Vec<f64> = line.split(' ').map(|x| x.parse().unwrap()).collect();
            let got = got.unwrap_or_else(|undef| panic!("point {number} of {name}: {undef}"));
            numbers += 1;
            let total = off(got.total.x, wanted[0]).max(off(got.total.y, wanted[1]));
            if total > worst.0 {
                worst = (total, number);
            }
            for (term, got) in [got.diffuse.y, got.specular.y].iter().enumerate() {
                let off = off(*got, wanted[2 + term]);
                if off > 1e-12 { println!("term {term} of {name} {number}: {off:e} {got} {}", wanted[2+term]); }
                if off > terms.0 {
                    terms = (off, number);
                }
            }
        }
        println!("{name}: {numbers} points, off by {:.1e} at {}; terms {:.1e} at {}", worst.0, worst.1, terms.0, terms.1);
        assert!(numbers >= 1000, "{name} has {numbers} points with a value");
        assert!(worst.0 <= 1e-12, "{name}: {worst:?}");
    }
}
