//! The options of culling, and their notation in `--skip`.

use crate::scene::{Kind, Lights, PointLight};

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Drop lights without effect, and what a shader holds for unused kinds of light.
    pub used: bool,
    /// The slots of the shader's arrays of directional, point and spot lights, all of which its
    /// plain loop visits; `None` for as many as there are lights.
    pub slots: [Option<u32>; 3],
    /// Count the evaluations that gates skip, including powers below that many steps.
    pub gates: Option<f64>,
    /// The side in pixels of the tiles that have a list of lights each.
    pub tiles: Option<u32>,
    /// The steps that the lights left out of a tile may contribute together anywhere in it, by
    /// their upper bounds; `None` for lights that contribute exactly zero.
    pub budget: Option<f64>,
    /// Apply the parts where they cost more than they save, too.
    pub always: bool,
    /// What was shown of a shader: lights are left out by this, not by the bounds of the model.
    pub shown: Option<ShownLights>,
}

/// Where a shader's code was shown to give exactly zero for a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShownLight {
    #[default]
    Nowhere,
    /// From its range on, enlarged by [`ShownLights::MARGIN`].
    BeyondRange,
    /// At every fragment of the frame.
    Everywhere,
}

/// The same for the directional lights, point lights and spotlights of an upload.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ShownLights(pub [Vec<ShownLight>; 3]);

impl ShownLights {
    /// The factor of a range past the rounding of every operation in `f32`.
    pub const MARGIN: f64 = 1.0 + 1.0 / (1 << 18) as f64;

    /// Takes for shown that all lights end that have a range.
    pub fn of_ranges(lights: &Lights) -> ShownLights {
        let of = |point: &PointLight| match point.attenuation.range {
            Some(_) => ShownLight::BeyondRange,
            None => ShownLight::Nowhere,
        };
        ShownLights([
            vec![ShownLight::Nowhere; lights.directional.len()],
            lights.point.iter().map(of).collect(),
            lights.spot.iter().map(|spot| of(&spot.point)).collect(),
        ])
    }

    /// Returns what was shown of a light.
    pub fn of(&self, kind: Kind, number: u32) -> ShownLight {
        self.0[kind as usize].get(number as usize).copied().unwrap_or_default()
    }

    /// Returns the number of lights that may be left out somewhere.
    pub fn count(&self) -> usize {
        self.0.iter().flatten().filter(|shown| **shown != ShownLight::Nowhere).count()
    }
}

impl Options {
    /// The parts of `--skip` without a value: those that are exact.
    pub fn exact() -> Options {
        Options { used: true, tiles: Some(TILE), ..Options::default() }
    }

    pub fn leaves_out(&self) -> bool {
        self.used || self.tiles.is_some()
    }
}

/// The default side of a tile in pixels.
const TILE: u32 = 8;

/// The parts of `--skip` with their descriptions, for help and messages.
pub const PARTS: &[(&str, &str)] = &[
    (
        "used",
        "drop lights without effect, and compile the shader for the kinds of light that are left",
    ),
    (
        "gates[=STEPS]",
        "count the work saved if the shader skipped lights and highlights that contribute exactly \
         zero; with STEPS also highlights below STEPS/255",
    ),
    ("tiles[=PIXELS]", "a list of lights for each tile of the picture, exact; default 8 pixels"),
    (
        "budget=STEPS",
        "drop lights that together contribute at most STEPS/255 to any fragment, by the bounds of the \
         lighting model",
    ),
    ("budget-srgb=STEPS", "as `budget`, for an sRGB target"),
    ("always", "apply parts even where they cost more than they save"),
];

/// Parses the value of `--skip`: parts separated by commas.
///
/// # Errors
///
/// A message that names the invalid part.
pub fn parse(text: &str) -> Result<Options, String> {
    // part ("," part)*, part = name ["=" value]; spaces around a part are ignored.
    let mut options = Options::default();
    for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
        let (name, value) = part.split_once('=').map_or((part, None), |(n, v)| (n, Some(v)));
        if !PARTS.iter().any(|(known, _)| known.split(['[', '=']).next() == Some(name)) {
            let names: Vec<&str> = PARTS.iter().map(|(name, _)| *name).collect();
            return Err(format!("`{part}`: unknown part; expected one of {}", names.join(", ")));
        }
        apply(&mut options, name, value).map_err(|why| format!("`{part}`: {why}"))?;
    }
    // A budget is spent in regions, so it needs tiles.
    if options.budget.is_some() {
        options.tiles.get_or_insert(TILE);
    }
    Ok(options)
}

fn apply(options: &mut Options, name: &str, value: Option<&str>) -> Result<(), String> {
    let needed = || value.ok_or_else(|| "needs a value after `=`".to_string());
    match name {
        "used" => options.used = true,
        "gates" => options.gates = Some(value.map_or(Ok(0.0), positive)?),
        "tiles" => options.tiles = Some(value.map_or(Ok(TILE), |v| integer(v, 1..=4096))?),
        "budget" => options.budget = Some(positive(needed()?)?),
        // One sRGB step near black is 1/12.92 of a linear one: the worst case of the transfer
        // function.
        "budget-srgb" => options.budget = Some(positive(needed()?)? / super::SRGB_SLOPE),
        "always" => options.always = true,
        _ => unreachable!("the caller knows the parts"),
    }
    Ok(())
}

fn integer(text: &str, range: std::ops::RangeInclusive<u32>) -> Result<u32, String> {
    let number = text.parse().ok().filter(|n| range.contains(n));
    number.ok_or_else(|| format!("expects an integer from {} to {}", range.start(), range.end()))
}

/// Parses a positive number, or a quotient of two.
fn positive(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        None => number(text),
        Some((above, below)) => number(above).zip(number(below)).map(|(a, b)| a / b),
    };
    value
        .filter(|x| x.is_finite() && *x > 0.0)
        .ok_or_else(|| "expects a positive number, such as `0.5` or `5/256`".to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_read() {
        let options = parse("used, gates=1/64,tiles=16,budget=0.5,always").expect("good");
        assert!(options.used && options.always);
        assert_eq!(options.gates, Some(1.0 / 64.0));
        assert_eq!(options.tiles, Some(16));
        assert_eq!(options.budget, Some(0.5));
        assert_eq!(parse("budget=1").expect("good").tiles, Some(8));
        assert_eq!(parse("used,tiles"), Ok(Options::exact()));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, named) in [
            ("tile", "`tile`: unknown part"),
            ("tiles=0", "`tiles=0`: expects an integer from 1 to 4096"),
            ("budget", "`budget`: needs a value"),
            ("budget=-1", "expects a positive number"),
            ("budget=1/0", "expects a positive number"),
            ("gates=nan", "expects a positive number"),
            ("auto", "`auto`: unknown part"),
        ] {
            let said = parse(text).expect_err(text);
            assert!(said.contains(named), "{text}: {said}");
        }
    }
}
