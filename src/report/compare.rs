//! The report of `--compare`: how far two pictures are apart.
//!
//! Formats a [`Comparison`] of [`picture`](landfall_light::picture).

use std::fmt::Write as _;

use landfall_layout::format::columns::{WIDTH, wrapped};
pub use landfall_layout::format::phrases;
use landfall_light::picture::compare::{Comparison, Psnr};

/// Returns the largest difference and the PSNR.
pub fn brief(comparison: &Comparison) -> String {
    let is_brief = |(name, _): &(&str, String)| ["linear", "psnr"].contains(name);
    rows(comparison).into_iter().filter(is_brief).map(shown).collect()
}

/// Returns a line for each measure.
pub fn human(comparison: &Comparison) -> String {
    rows(comparison).into_iter().map(shown).collect()
}

/// The width of the names of measures.
const NAMES: usize = 13;

fn shown((name, line): (&str, String)) -> String {
    // The report stands two columns further right.
    let lines = wrapped(&line, WIDTH - NAMES - 2).join(&format!("\n{:NAMES$}", ""));
    format!("{name:<12} {lines}\n")
}

fn rows(comparison: &Comparison) -> Vec<(&'static str, String)> {
    let Comparison { pixels, left_out, non_finite, linear, codes, psnr, flip, .. } = comparison;
    let mut rows = Vec::new();
    let mut row = |name: &'static str, line: String| rows.push((name, line));
    let mut compared = format!("{} compared", phrases::number(*pixels));
    if *left_out > 0 {
        let left_out = phrases::number(*left_out);
        let _ = write!(compared, ", {left_out} left out as undefined");
    }
    row("pixels", compared);
    let mut line = format!(
        "max {} steps, 99.9 % within {}, mean {}",
        phrases::figure(linear.max),
        phrases::figure(linear.p999),
        phrases::figure(linear.mean)
    );
    if let Some([x, y]) = linear.at {
        let _ = write!(line, "; largest at column {x}, row {y}");
    }
    row("linear", line);
    if linear.alpha_max > 0.0 {
        row("alpha", format!("max {} steps", phrases::figure(linear.alpha_max)));
    }
    // Equal channels are the rest, and need no number.
    let [_, one, two, more] = codes.counts;
    row(
        "8-bit",
        format!(
            "max {} {} ({}); of {} channels, {} differ by 1, {} by 2, {} by 3 or more",
            codes.max,
            if codes.max == 1 { "step" } else { "steps" },
            codes.transfer.name(),
            phrases::number(codes.channels),
            phrases::number(one),
            phrases::number(two),
            phrases::number(more)
        ),
    );
    row("flips", format!("{} % of the 8-bit values", phrases::figure(100.0 * codes.flips)));
    row(
        "psnr",
        match psnr {
            Psnr::Identical => "infinite: all 8-bit values are equal".to_string(),
            Psnr::Db(db) => format!("{db:.2} dB"),
            Psnr::Nothing => "nothing to compare".to_string(),
        },
    );
    row("FLIP", format!("mean {}, max {}", phrases::figure(flip.mean), phrases::figure(flip.max)));
    row(
        "non-finite",
        match non_finite.pixels {
            0 => "none".to_string(),
            pixels => format!(
                "{}: {} of the first picture, {} of the second",
                phrases::numbered(pixels, "pixel"),
                phrases::numbered(non_finite.a, "channel"),
                phrases::number(non_finite.b)
            ),
        },
    );
    rows
}
