//! The options of culling, and their notation in `--skip`.

use super::cost::Costs;

/// The options of culling.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Drop lights without effect, and what a shader holds for unused kinds of light.
    pub used: bool,
    /// The slots of the shader's arrays of directional, point and spot lights, all of which its
    /// plain loop visits; `None` for as many as there are lights.
    pub slots: [Option<u32>; 3],
    /// Count the evaluations that gates skip, including powers below that many steps.
    pub gates: Option<f64>,
    /// The regions for light lists.
    pub division: Division,
    /// The lights dropped from a region.
    pub cull: Cull,
    /// Interpolate far lights on planes.
    pub interpolate: Option<Interpolate>,
    /// When to divide the frame.
    pub choose: Choose,
    /// Measure a sample of the scene and pick the other options, at an error of at most that many
    /// steps.
    pub auto: Option<f64>,
    /// The costs on the executing backend.
    pub costs: Costs,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            used: false,
            slots: [None; 3],
            gates: None,
            division: Division::Whole,
            cull: Cull::Exact,
            interpolate: None,
            choose: Choose::Cheaper,
            auto: None,
            costs: Costs::CPU,
        }
    }
}

/// The division of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Division {
    /// No division.
    Whole,
    /// Squares of pixels, each with the box around its fragments.
    Tiles {
        /// The side in pixels.
        size: u32,
    },
    /// Columns, rows and slices of distance.
    Clusters {
        /// The columns.
        columns: u32,
        /// The rows.
        rows: u32,
        /// The slices of distance; their bounds form a geometric sequence.
        slices: u32,
    },
}

/// The lights dropped from a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cull {
    /// The lights that contribute exactly zero in it.
    Exact,
    /// As many as contribute at most that many steps together anywhere in it, by their upper
    /// bounds.
    Budget(f64),
    /// Each light that contributes less than that in it; their sum is not bounded.
    Threshold(f64),
    /// Each light beyond the distance at which it contributes that; their sum is not bounded.
    Range(f64),
}

/// The interpolation of far lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolate {
    /// The distance from which a light is far, in diameters of a patch.
    pub diameters: f64,
    /// The nodes along each side of a patch, 2 to 8.
    pub nodes: u32,
    /// A light is far where the proven errors of all far lights stay within that many steps
    /// together, instead of by `diameters`.
    pub within: Option<f64>,
}

/// When to divide a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Choose {
    /// Only if the cost model predicts a saving.
    #[default]
    Cheaper,
    /// Always.
    Always,
}

/// The parts of `--skip` with their descriptions, for help and messages; `auto` is the last one.
pub const PARTS: &[(&str, &str)] = &[
    ("used", "drop lights without effect and unused kinds of light"),
    (
        "slots=N",
        "the shader has N slots for point lights; DxPxS also for directional lights and spotlights",
    ),
    (
        "gates[=STEPS]",
        "estimate the work saved if the shader skipped lights and highlights that contribute \
         exactly zero; with STEPS also highlights below STEPS/255",
    ),
    ("tiles[=PIXELS]", "a list of lights for each tile of the picture, exact; default 8 pixels"),
    (
        "clusters[=CxRxS]",
        "a list of lights for each cell of the view volume, exact; default 32x18x48",
    ),
    (
        "budget=STEPS",
        "drop lights that together contribute at most STEPS/255 to any fragment, by the bounds of the \
         lighting model",
    ),
    ("budget-srgb=STEPS", "as `budget`, for an sRGB target"),
    (
        "interpolate[=DIAMETERS[xNODES]]",
        "on flat surfaces, light NODES by NODES points of a patch and interpolate, for lights farther \
         away than DIAMETERS patch sizes; the error is measured; default 4x3",
    ),
    (
        "far=STEPS[xNODES]",
        "as `interpolate`, for the lights whose errors add up to at most STEPS/255 at any fragment by \
         proof; point lights without a range; at most NODES nodes, fewer for lights farther away; \
         default 8",
    ),
    (
        "cut=VALUE",
        "end each light where it contributes VALUE, such as 5/256; the error is measured",
    ),
    (
        "below=VALUE",
        "drop each light that contributes less than VALUE in a region; the error is measured",
    ),
    ("always", "apply `tiles` or `clusters` even where they cost more than they save"),
    (
        "auto[=STEPS]",
        "measure `used`, `tiles` and `clusters` on a sample of the scene and apply the fastest, or \
         nothing; with STEPS also `budget`, `far` and `interpolate` within that error",
    ),
];

/// Parses the value of `--skip`: parts separated by commas.
///
/// # Errors
///
/// A message that names the invalid part.
pub fn parse(text: &str) -> Result<Options, String> {
    parse_of(text, PARTS)
}

/// Parses the parts of a plan that is given and not chosen: all but `auto`.
///
/// # Errors
///
/// A message that names the invalid part.
pub fn parse_given(text: &str) -> Result<Options, String> {
    parse_of(text, &PARTS[..PARTS.len() - 1])
}

fn parse_of(text: &str, parts: &[(&str, &str)]) -> Result<Options, String> {
    let mut options = Options::default();
    for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
        let (name, value) = part.split_once('=').map_or((part, None), |(n, v)| (n, Some(v)));
        if !parts.iter().any(|(known, _)| known.split(['[', '=']).next() == Some(name)) {
            let names: Vec<&str> = parts.iter().map(|(name, _)| *name).collect();
            return Err(format!("`{part}`: unknown part; expected one of {}", names.join(", ")));
        }
        apply(&mut options, name, value).map_err(|why| format!("`{part}`: {why}"))?;
    }
    let alone = Options { auto: options.auto, slots: options.slots, ..Options::default() };
    if options.auto.is_some() && options != alone {
        return Err("`auto` picks the parts itself: remove all others but `slots`".to_string());
    }
    let divides = !matches!(options.cull, Cull::Exact);
    if divides && options.division == Division::Whole {
        options.division = Division::Tiles { size: 8 };
    }
    if options.interpolate.is_some() && options.division != Division::Whole {
        return Err(
            "`interpolate` has its own division of the frame: remove `tiles`, `clusters`, \
                    `budget`, `cut` and `below`"
                .to_string(),
        );
    }
    Ok(options)
}

fn apply(options: &mut Options, name: &str, value: Option<&str>) -> Result<(), String> {
    let needed = || value.ok_or_else(|| "needs a value after `=`".to_string());
    match name {
        "used" => options.used = true,
        "slots" => {
            let slots = |text| integer(text, 0..=1 << 20).map(Some);
            let parts: Vec<&str> = needed()?.split('x').collect();
            options.slots = match parts[..] {
                [point] => [None, slots(point)?, None],
                [directional, point, spot] => [slots(directional)?, slots(point)?, slots(spot)?],
                _ => return Err("expects one number, or three such as `4x128x4`".to_string()),
            };
        }
        "gates" => options.gates = Some(value.map_or(Ok(0.0), positive)?),
        "tiles" => {
            let size = value.map_or(Ok(8), |v| integer(v, 1..=4096))?;
            options.division = Division::Tiles { size };
        }
        "clusters" => {
            let parts: Vec<&str> = value.unwrap_or("32x18x48").split('x').collect();
            let [columns, rows, slices] = parts[..] else {
                return Err("expects columns, rows and slices, such as `32x18x48`".to_string());
            };
            let part = |text| integer(text, 1..=4096);
            options.division = Division::Clusters {
                columns: part(columns)?,
                rows: part(rows)?,
                slices: part(slices)?,
            };
        }
        "budget" => options.cull = Cull::Budget(positive(needed()?)?),
        "budget-srgb" => options.cull = Cull::Budget(positive(needed()?)? / super::SRGB_SLOPE),
        "interpolate" => {
            let (diameters, nodes) =
                value.unwrap_or("4").split_once('x').unwrap_or((value.unwrap_or("4"), "3"));
            let (diameters, nodes) = (positive(diameters)?, integer(nodes, 2..=8)?);
            options.interpolate = Some(Interpolate { diameters, nodes, within: None });
        }
        "far" => {
            let (steps, nodes) = needed()?.split_once('x').unwrap_or((needed()?, "8"));
            let (steps, nodes) = (positive(steps)?, integer(nodes, 2..=8)?);
            options.interpolate = Some(Interpolate { diameters: 0.0, nodes, within: Some(steps) });
        }
        "cut" => options.cull = Cull::Range(positive(needed()?)?),
        "below" => options.cull = Cull::Threshold(positive(needed()?)?),
        "always" => options.choose = Choose::Always,
        "auto" => options.auto = Some(value.map_or(Ok(0.0), positive)?),
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
        let options = parse("used, slots=128,gates=1/64,tiles=16,budget=0.5,always").expect("good");
        assert!(options.used);
        assert_eq!(options.slots, [None, Some(128), None]);
        assert_eq!(options.gates, Some(1.0 / 64.0));
        assert_eq!(options.division, Division::Tiles { size: 16 });
        assert_eq!(options.cull, Cull::Budget(0.5));
        assert_eq!(options.choose, Choose::Always);
        let options = parse("interpolate=2x4").expect("good");
        assert_eq!(
            options.interpolate,
            Some(Interpolate { diameters: 2.0, nodes: 4, within: None })
        );
        assert_eq!(parse("interpolate").expect("good").interpolate.map(|i| i.nodes), Some(3));
        assert_eq!(parse("cut=5/256").expect("good").cull, Cull::Range(5.0 / 256.0));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, named) in [
            ("tile", "`tile`: unknown part"),
            ("tiles=0", "`tiles=0`: expects an integer from 1 to 4096"),
            ("budget", "`budget`: needs a value"),
            ("budget=-1", "expects a positive number"),
            ("cut=1/0", "expects a positive number"),
            ("gates=nan", "expects a positive number"),
            ("slots=3x4", "one number, or three"),
            ("clusters=3x4", "columns, rows and slices"),
            ("interpolate=4x9", "from 2 to 8"),
            ("far=0.5x9", "from 2 to 8"),
            ("tiles,interpolate", "remove `tiles`"),
            ("auto,tiles", "remove all others"),
            ("auto=0", "expects a positive number"),
        ] {
            let said = parse(text).expect_err(text);
            assert!(said.contains(named), "{text}: {said}");
        }
    }
}
