//! Heat maps of an error over two inputs; light cells are large errors.
//!
//! Draws the results of a stress run in the colours of [`color_map`];
//! undefined and non-finite results have a pattern.

use super::axis::{Axis, Tick};
use super::svg::{Anchor, Svg, number};
use landfall_light::picture::color_map;

/// A map of an error over two inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMap {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// The error; values outside have the colour of the nearest end.
    pub error: Axis,
    /// The cells in a row, all of the same width.
    pub columns: usize,
    /// The cells row by row, the bottom row first.
    pub cells: Vec<Cell>,
    /// Samples that other inputs, or inputs between cells, make worse.
    pub marks: Vec<MapMark>,
}

/// A sample beside those of the cells.
#[derive(Clone, Debug, PartialEq)]
pub struct MapMark {
    pub at: [f64; 2],
    /// What it is, in a word or two.
    pub text: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    Error(f64),
    /// A NaN or infinite result.
    NonFinite,
    Undefined,
    /// No sample.
    Empty,
}

const WIDTH: f64 = 680.0;
const HEIGHT: f64 = 480.0;
const LEFT: f64 = 76.0;
const TOP: f64 = 44.0;
const RIGHT: f64 = 516.0;
const BOTTOM: f64 = 416.0;
/// The left edge of the colour scale.
const SCALE: f64 = 544.0;
const SCALE_WIDTH: f64 = 16.0;

/// The number of distinct colours: adjacent cells of one colour share a rectangle.
const SHADES: usize = 48;

const LIGHT: &str = "\
.hatch { stroke: #0a7ea4; stroke-width: 2; }
.ground { fill: #ffffff; }
.outline { stroke: #ffffff; stroke-width: 2; }
.mark { stroke: #ffffff; stroke-width: 3; paint-order: stroke; }
";
const DARK: &str = "\
.hatch { stroke: #56d4ff; }
.ground { fill: #0d1117; }
.outline { stroke: #0d1117; }
.mark { stroke: #0d1117; }
";

#[derive(Clone, Copy, PartialEq, Eq)]
enum Fill {
    Shade(usize),
    NonFinite,
    Undefined,
    Empty,
}

pub fn heat_map(map: &HeatMap) -> String {
    let mut svg = Svg::new(WIDTH, HEIGHT, &map.title, LIGHT, DARK);
    svg.raw(
        "<defs>\n\
         <pattern id=\"nan\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\">\
         <rect class=\"ground\" width=\"6\" height=\"6\"/>\
         <path class=\"hatch\" d=\"M0 6L6 0M-1 1L1 -1M5 7L7 5\"/></pattern>\n\
         <pattern id=\"undefined\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\">\
         <rect class=\"ground\" width=\"6\" height=\"6\"/>\
         <path class=\"hatch\" d=\"M3 0V2M3 4V6\"/></pattern>\n\
         </defs>",
    );
    svg.text("title", Anchor::Start, [LEFT, 26.0], &map.title);
    let columns = map.columns.max(1);
    let rows = map.cells.len().div_ceil(columns);
    let size = [(RIGHT - LEFT) / columns as f64, (BOTTOM - TOP) / rows.max(1) as f64];
    for (row, cells) in map.cells.chunks(columns).enumerate() {
        let y = BOTTOM - (row + 1) as f64 * size[1];
        let mut column = 0;
        while column < cells.len() {
            let filled = fill(map, cells[column]);
            // Neighbours of one fill are one rectangle, which keeps the file small.
            let same =
                cells[column..].iter().take_while(|cell| fill(map, **cell) == filled).count();
            let x = LEFT + column as f64 * size[0];
            cell(&mut svg, filled, [x, y], [same as f64 * size[0], size[1]]);
            column += same;
        }
    }
    marks(&mut svg, map);
    axes(&mut svg, map);
    scale(&mut svg, map);
    svg.finish()
}

fn fill(map: &HeatMap, cell: Cell) -> Fill {
    match cell {
        Cell::Error(error) if error.is_finite() => {
            Fill::Shade((map.error.at(error) * (SHADES - 1) as f64).round() as usize)
        }
        Cell::Error(_) | Cell::NonFinite => Fill::NonFinite,
        Cell::Undefined => Fill::Undefined,
        Cell::Empty => Fill::Empty,
    }
}

fn cell(svg: &mut Svg, fill: Fill, [x, y]: [f64; 2], [w, h]: [f64; 2]) {
    let paint = match fill {
        Fill::Shade(shade) => {
            let [r, g, b] = color_map::color(shade as f64 / (SHADES - 1) as f64);
            format!("#{r:02x}{g:02x}{b:02x}")
        }
        Fill::NonFinite => "url(#nan)".to_string(),
        Fill::Undefined => "url(#undefined)".to_string(),
        Fill::Empty => return,
    };
    // Edges are rounded, not widths, so that no seam shows between neighbours.
    let [left, top, right, bottom] = [x, y, x + w, y + h].map(|edge| (edge * 10.0).round() / 10.0);
    svg.raw(&format!(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{paint}\" \
         shape-rendering=\"crispEdges\"/>",
        number(left),
        number(top),
        number(right - left),
        number(bottom - top),
    ));
}

/// Draws a ring and a text at each mark in the range of both axes.
fn marks(svg: &mut Svg, map: &HeatMap) {
    for mark in &map.marks {
        let [x, y] = [map.x.at(mark.at[0]), map.y.at(mark.at[1])];
        let place = [LEFT + x * (RIGHT - LEFT), BOTTOM - y * (BOTTOM - TOP)];
        let ring = |radius: f64, class: &str| {
            format!(
                "<circle class=\"{class}\" cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"none\"/>",
                number(place[0]),
                number(place[1]),
                number(radius)
            )
        };
        svg.raw(&ring(6.0, "outline"));
        svg.raw(&ring(4.5, "hatch"));
        // Towards the middle, so that the text stays in the drawing.
        let (anchor, by) = if x > 0.5 { (Anchor::End, -10.0) } else { (Anchor::Start, 10.0) };
        let below = if y > 0.9 { 14.0 } else { -8.0 };
        svg.text("mark", anchor, [place[0] + by, place[1] + below], &mark.text);
    }
}

fn axes(svg: &mut Svg, map: &HeatMap) {
    svg.rect("frame", [LEFT, TOP], [RIGHT - LEFT, BOTTOM - TOP]);
    for Tick { at, text } in map.x.ticks(6) {
        let x = LEFT + at * (RIGHT - LEFT);
        let long = if text.is_empty() { 3.0 } else { 6.0 };
        svg.line("frame", [x, BOTTOM], [x, BOTTOM + long]);
        svg.text("faint", Anchor::Middle, [x, BOTTOM + 18.0], &text);
    }
    for Tick { at, text } in map.y.ticks(8) {
        let y = BOTTOM - at * (BOTTOM - TOP);
        let long = if text.is_empty() { 3.0 } else { 6.0 };
        svg.line("frame", [LEFT - long, y], [LEFT, y]);
        svg.text("faint", Anchor::End, [LEFT - 9.0, y + 4.0], &text);
    }
    svg.text("", Anchor::Middle, [(LEFT + RIGHT) / 2.0, BOTTOM + 40.0], &map.x.label);
    svg.upward([18.0, (TOP + BOTTOM) / 2.0], &map.y.label);
}

fn scale(svg: &mut Svg, map: &HeatMap) {
    let has = |wanted: Fill| map.cells.iter().any(|cell| fill(map, *cell) == wanted);
    let kinds = [
        (has(Fill::NonFinite), Fill::NonFinite, "non-finite"),
        (has(Fill::Undefined), Fill::Undefined, "undefined"),
    ];
    let below = kinds.iter().filter(|(there, ..)| *there).count() as f64 * 22.0;
    let (top, bottom) = (TOP + 18.0, BOTTOM - below);
    svg.text("", Anchor::Start, [SCALE, TOP + 6.0], &map.error.label);
    let height = (bottom - top) / SHADES as f64;
    for shade in 0..SHADES {
        let y = bottom - (shade + 1) as f64 * height;
        cell(svg, Fill::Shade(shade), [SCALE, y], [SCALE_WIDTH, height]);
    }
    svg.rect("frame", [SCALE, top], [SCALE_WIDTH, bottom - top]);
    for Tick { at, text } in map.error.ticks(7) {
        if text.is_empty() {
            continue;
        }
        let y = bottom - at * (bottom - top);
        svg.line("frame", [SCALE + SCALE_WIDTH, y], [SCALE + SCALE_WIDTH + 4.0, y]);
        svg.text("faint", Anchor::Start, [SCALE + SCALE_WIDTH + 7.0, y + 4.0], &text);
    }
    let mut y = bottom + 8.0;
    for (_, kind, name) in kinds.into_iter().filter(|(there, ..)| *there) {
        cell(svg, kind, [SCALE, y], [SCALE_WIDTH, 13.0]);
        svg.rect("frame", [SCALE, y], [SCALE_WIDTH, 13.0]);
        svg.text("faint", Anchor::Start, [SCALE + SCALE_WIDTH + 7.0, y + 10.5], name);
        y += 22.0;
    }
}
