//! Drawings of measurements: well-formed, the same each time, legible.

use landfall::accuracy::plot::{Axis, Cell, HeatMap, Mark, Scatter, heat_map, scatter};

fn marks() -> Vec<Mark> {
    let mark = |label: &str, series: &str, time: f64, error: f64, dominated| Mark {
        label: label.to_string(),
        series: series.to_string(),
        time: [time * 0.93, time, time * 1.08],
        error,
        dominated,
    };
    vec![
        mark("seed", "rust, f32", 27.0, 1.03e-3, true),
        mark("robust", "rust, f32", 15.2, 9.0e-4, false),
        mark("robust, gate 2^-24", "rust, f32", 12.8, 9.0e-4, false),
        mark("robust, gate 1/64 step", "rust, f32", 10.5, 6.3e-3, false),
        mark("robust, gate 1/8 step", "rust, f32", 9.7, 7.2e-2, false),
        mark("seed", "gpu: llvmpipe", 12.9, 1.02e-3, true),
        mark("robust", "gpu: llvmpipe", 8.5, 9.0e-4, false),
        mark("half <floats>", "gpu: llvmpipe", 8.4, 35.0, false),
        mark("reference", "rust, f64", 36.0, 0.0, false),
        mark("loop to 128 & zeros", "gpu: llvmpipe", 400.0, f64::NAN, true),
    ]
}

fn drawing(marks: Vec<Mark>) -> Scatter {
    Scatter {
        title: "six lights, 800 x 600".to_string(),
        time: "ns a fragment and light".to_string(),
        error: "largest error, steps of 1/255".to_string(),
        marks,
    }
}

fn map() -> HeatMap {
    let (columns, rows) = (60, 40);
    let cells = (0..columns * rows).map(|i| {
        let (x, y) = ((i % columns) as f64 / columns as f64, (i / columns) as f64 / rows as f64);
        match (x, y) {
            (x, _) if x < 0.05 => Cell::NonFinite,
            (x, y) if x > 0.9 && y > 0.9 => Cell::Undefined,
            (x, y) if (x - 0.7).hypot(y - 0.2) < 0.05 => Cell::Empty,
            (x, y) => Cell::Error(10f64.powf(-6.0 + 8.0 * x * y)),
        }
    });
    HeatMap {
        title: "error of `attenuation` over distance and quadratic".to_string(),
        x: Axis::log("distance", 1e-3, 1e4),
        y: Axis::linear("quadratic", 0.0, 2.0),
        error: Axis::log("steps", 1e-6, 1e2),
        columns,
        cells: cells.collect(),
    }
}

#[test]
fn drawings_are_for_looking_at() {
    // Not a claim: what to look at after a change, in the folder of this test's files.
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(folder.join("scatter.svg"), scatter(&drawing(marks()))).unwrap();
    std::fs::write(folder.join("heat_map.svg"), heat_map(&map())).unwrap();
}
