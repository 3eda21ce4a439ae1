//! What a plan is asked to skip, and how `--skip` spells it.

use super::cost::Costs;

/// What to skip.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Leave out lights that give nothing, and what a shader holds for lights there are none of.
    pub used: bool,
    /// Slots of the shader's arrays of directional, point and spot lights, all of which its
    /// plain loop goes over; as many as there are lights if not told.
    pub slots: [Option<u32>; 3],
    /// Count what gates leave out, powers below so many steps included.
    pub gates: Option<f64>,
    /// The regions lists of lights are made for.
    pub division: Division,
    /// Which lights of a region are left out.
    pub cull: Cull,
    /// Interpolate far lights on planes.
    pub interpolate: Option<Interpolate>,
    /// When to divide.
    pub choose: Choose,
    /// What things cost where the plan is executed.
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
            costs: Costs::CPU,
        }
    }
}

/// How a frame is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Division {
    /// Not at all.
    Whole,
    /// In squares of pixels, each with the box around what is seen in it.
    Tiles {
        /// Pixels along a side.
        size: u32,
    },
    /// In columns, rows and slices of distance.
    Clusters {
        /// Parts across.
        columns: u32,
        /// Parts down.
        rows: u32,
        /// Parts away from the camera, each as many times as far as the one before.
        slices: u32,
    },
}

/// Which lights of a region are left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cull {
    /// Those that give exactly zero in it.
    Exact,
    /// As many as give together at most that many steps anywhere in it, by their upper bounds.
    Budget(f64),
    /// Each one that gives less than that in it: no bound on what they give together.
    Threshold(f64),
    /// Each one that is farther than where it would give that: no bound on what they give
    /// together.
    Range(f64),
}

/// How far lights are interpolated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolate {
    /// A light is far if it is that many diameters of a patch away.
    pub diameters: f64,
    /// Nodes along each side of a patch, 2 to 8.
    pub nodes: u32,
}

/// When to divide a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Choose {
    /// Only if the model of costs says that it saves more than it costs.
    #[default]
    Cheaper,
    /// Always.
    Always,
}

/// The parts `--skip` is made of, with what they do: for help and for messages.
pub const PARTS: &[(&str, &str)] = &[
    ("used", "leave out lights that give nothing and types of lights there are none of"),
    ("slots=N", "the shader has N slots for point lights; DxPxS also for suns and spots"),
    ("gates[=STEPS]", "count what gates leave out; powers below STEPS of 1/255 too"),
    ("tiles[=PIXELS]", "a list of lights for each tile, exact; 8 pixels"),
    ("clusters[=CxRxS]", "a list for each cluster, exact; 32x18x48"),
    ("budget=STEPS", "drop lights that give together at most STEPS of 1/255, proven"),
    ("budget-srgb=STEPS", "as `budget`, of a target that stores sRGB"),
    ("interpolate[=DIAMETERS[xNODES]]", "interpolate lights so far away on planes, measured; 4x3"),
    ("cut=VALUE", "cut each light where it gives VALUE, as 5/256; measured"),
    ("below=VALUE", "drop each light that gives less than VALUE in a region; measured"),
    ("always", "divide even where that costs more than it saves"),
];

/// Reads what `--skip` was given: parts with commas between them.
///
/// # Errors
///
/// With a message that names the part.
pub fn parse(text: &str) -> Result<Options, String> {
    let mut options = Options::default();
    for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
        let (name, value) = part.split_once('=').map_or((part, None), |(n, v)| (n, Some(v)));
        apply(&mut options, name, value).map_err(|why| format!("`{part}`: {why}"))?;
    }
    let divides = !matches!(options.cull, Cull::Exact);
    if divides && options.division == Division::Whole {
        options.division = Division::Tiles { size: 8 };
    }
    if options.interpolate.is_some() && options.division != Division::Whole {
        return Err("`interpolate` divides the frame by itself: take `tiles`, `clusters`, \
                    `budget`, `cut` and `below` away"
            .to_string());
    }
    Ok(options)
}

fn apply(options: &mut Options, name: &str, value: Option<&str>) -> Result<(), String> {
    let needed = || value.ok_or_else(|| "needs a value after `=`".to_string());
    match name {
        "used" => options.used = true,
        "slots" => {
            let slots = |text| whole(text, 0..=1 << 20).map(Some);
            let parts: Vec<&str> = needed()?.split('x').collect();
            options.slots = match parts[..] {
                [point] => [None, slots(point)?, None],
                [directional, point, spot] => [slots(directional)?, slots(point)?, slots(spot)?],
                _ => return Err("wants one number, or three as `4x128x4`".to_string()),
            };
        }
        "gates" => options.gates = Some(value.map_or(Ok(0.0), positive)?),
        "tiles" => {
            let size = value.map_or(Ok(8), |v| whole(v, 1..=4096))?;
            options.division = Division::Tiles { size };
        }
        "clusters" => {
            let parts: Vec<&str> = value.unwrap_or("32x18x48").split('x').collect();
            let [columns, rows, slices] = parts[..] else {
                return Err("wants columns, rows and slices, as `32x18x48`".to_string());
            };
            let part = |text| whole(text, 1..=4096);
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
            let (diameters, nodes) = (positive(diameters)?, whole(nodes, 2..=8)?);
            options.interpolate = Some(Interpolate { diameters, nodes });
        }
        "cut" => options.cull = Cull::Range(positive(needed()?)?),
        "below" => options.cull = Cull::Threshold(positive(needed()?)?),
        "always" => options.choose = Choose::Always,
        _ => {
            let names: Vec<&str> = PARTS.iter().map(|(name, _)| *name).collect();
            return Err(format!("no such part; there are {}", names.join(", ")));
        }
    }
    Ok(())
}

fn whole(text: &str, range: std::ops::RangeInclusive<u32>) -> Result<u32, String> {
    let number = text.parse().ok().filter(|n| range.contains(n));
    number.ok_or_else(|| format!("wants a whole number from {} to {}", range.start(), range.end()))
}

/// A positive number, or a quotient of two.
fn positive(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        None => number(text),
        Some((above, below)) => number(above).zip(number(below)).map(|(a, b)| a / b),
    };
    value
        .filter(|x| x.is_finite() && *x > 0.0)
        .ok_or_else(|| "wants a positive number, as `0.5` or `5/256`".to_string())
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
        assert_eq!(options.interpolate, Some(Interpolate { diameters: 2.0, nodes: 4 }));
        assert_eq!(parse("interpolate").expect("good").interpolate.map(|i| i.nodes), Some(3));
        assert_eq!(parse("cut=5/256").expect("good").cull, Cull::Range(5.0 / 256.0));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, named) in [
            ("tile", "`tile`: no such part"),
            ("tiles=0", "`tiles=0`: wants a whole number from 1 to 4096"),
            ("budget", "`budget`: needs a value"),
            ("budget=-1", "wants a positive number"),
            ("cut=1/0", "wants a positive number"),
            ("gates=nan", "wants a positive number"),
            ("slots=3x4", "one number, or three"),
            ("clusters=3x4", "columns, rows and slices"),
            ("interpolate=4x9", "from 2 to 8"),
            ("tiles,interpolate", "by itself"),
        ] {
            let said = parse(text).expect_err(text);
            assert!(said.contains(named), "{text}: {said}");
        }
    }
}
