//! Scatter plots of run time against error, with the Pareto front of each series.
//!
//! Draws the ranking of [`bench`](crate::bench). Both axes are logarithmic; errors of
//! zero and non-finite ones have a strip of their own.

use super::axis::{Axis, Tick};
use super::labels::{Area, PlotLabel, place};
use super::svg::{Anchor, Svg, number, width};

/// A drawing of run time against error.
#[derive(Clone, Debug, PartialEq)]
pub struct Scatter {
    pub title: String,
    /// The label of the time axis with its unit.
    pub time: String,
    /// The label of the error axis with its unit.
    pub error: String,
    pub marks: Vec<Mark>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    pub label: String,
    /// The runner: only marks of one series are compared and have a front.
    pub series: String,
    /// The time: lower quartile, median, upper quartile.
    pub time: [f64; 3],
    /// The error: 0 is exact; infinity and NaN are non-finite results.
    pub error: f64,
    /// Whether another variant of its series is better.
    pub dominated: bool,
}

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 460.0;
const FRAME: Area = Area { left: 70.0, top: 44.0, right: 570.0, bottom: 402.0 };
/// The height of the strips for values without a logarithm.
const STRIP: f64 = 30.0;
/// The distance from the centre of a mark to its edge.
const REACH: f64 = 5.0;

/// The colours of a series on light and dark; its shape differs as well.
const SERIES: [[&str; 2]; 6] = [
    ["#0550ae", "#79c0ff"],
    ["#bc4c00", "#ffa657"],
    ["#1a7f37", "#56d364"],
    ["#8250df", "#d2a8ff"],
    ["#bf3989", "#ff9bce"],
    ["#57606a", "#b1bac4"],
];

pub fn scatter(scatter: &Scatter) -> String {
    let styles = |screen: usize| -> String {
        SERIES
            .iter()
            .enumerate()
            .map(|(i, colors)| {
                let color = colors[screen];
                format!(
                    ".s{i} {{ stroke: {color}; fill: {color}; }}\n\
                     .s{i}.front, .s{i}.bar {{ fill: none; }}\n"
                )
            })
            .collect()
    };
    let light = styles(0) + ".front { opacity: 0.75; }\n.hollow { stroke-width: 1.3; }\n";
    let hollow = |panel: &str| -> String {
        (0..SERIES.len()).map(|i| format!(".s{i}.hollow {{ fill: {panel}; }}\n")).collect()
    };
    let light = light + &hollow("#ffffff");
    let dark = styles(1) + &hollow("#0d1117");
    let mut svg = Svg::new(WIDTH, HEIGHT, &scatter.title, &light, &dark);
    svg.text("title", Anchor::Start, [FRAME.left, 26.0], &scatter.title);
    let plan = PlotPlan::new(scatter);
    plan.axes(&mut svg, scatter);
    let fronts: Vec<Vec<[f64; 2]>> =
        plan.series.iter().map(|name| plan.front(scatter, name)).collect();
    for (i, corners) in fronts.iter().enumerate() {
        steps(&mut svg, i, corners);
    }
    let places: Vec<[f64; 2]> = scatter.marks.iter().map(|mark| plan.place(mark)).collect();
    // Better marks are drawn last, on top.
    let mut order: Vec<(&Mark, &[f64; 2])> = scatter.marks.iter().zip(&places).collect();
    order.sort_by_key(|(mark, _)| !mark.dominated);
    for (mark, at) in order {
        let series = plan.number(mark) % SERIES.len();
        let [low, high] = [mark.time[0], mark.time[2]].map(|time| plan.x(time));
        svg.raw(&format!(
            "<path class=\"s{series} bar\" d=\"M{0} {2}V{3}M{0} {4}H{1}M{1} {2}V{3}\"/>",
            number(low),
            number(high),
            number(at[1] - 3.0),
            number(at[1] + 3.0),
            number(at[1]),
        ));
        shape(&mut svg, series, mark.dominated, *at);
    }
    plan.labels(&mut svg, scatter, &places, &fronts);
    plan.legend(&mut svg);
    svg.finish()
}

struct PlotPlan {
    /// The series in the order of their first mark.
    series: Vec<String>,
    time: Axis,
    error: Axis,
    /// The top and bottom of the logarithmic part.
    inner: [f64; 2],
    exact: bool,
    broken: bool,
}

impl PlotPlan {
    fn new(scatter: &Scatter) -> PlotPlan {
        let marks = &scatter.marks;
        let mut series: Vec<String> = Vec::new();
        for mark in marks {
            if !series.contains(&mark.series) {
                series.push(mark.series.clone());
            }
        }
        let exact = marks.iter().any(|mark| mark.error <= 0.0);
        let broken = marks.iter().any(|mark| !mark.error.is_finite());
        let strip = |there: bool| if there { STRIP } else { 0.0 };
        PlotPlan {
            series,
            time: Axis::around(&*scatter.time, marks.iter().flat_map(|mark| mark.time)),
            error: Axis::around(&*scatter.error, marks.iter().map(|mark| mark.error)),
            inner: [FRAME.top + strip(broken), FRAME.bottom - strip(exact)],
            exact,
            broken,
        }
    }

    fn number(&self, mark: &Mark) -> usize {
        self.series.iter().position(|name| *name == mark.series).unwrap_or(0)
    }

    fn x(&self, time: f64) -> f64 {
        FRAME.left + self.time.at(time) * (FRAME.right - FRAME.left)
    }

    fn y(&self, error: f64) -> f64 {
        let [top, bottom] = self.inner;
        match error {
            error if !error.is_finite() => FRAME.top + STRIP / 2.0,
            error if error <= 0.0 => FRAME.bottom - STRIP / 2.0,
            error => bottom - self.error.at(error) * (bottom - top),
        }
    }

    fn place(&self, mark: &Mark) -> [f64; 2] {
        [self.x(mark.time[1]), self.y(mark.error)]
    }

    fn axes(&self, svg: &mut Svg, scatter: &Scatter) {
        let [top, bottom] = self.inner;
        for Tick { at, text } in self.time.ticks(6) {
            let x = FRAME.left + at * (FRAME.right - FRAME.left);
            let long = !text.is_empty();
            svg.line(
                "grid",
                [x, if long { FRAME.top } else { FRAME.bottom - 5.0 }],
                [x, FRAME.bottom],
            );
            svg.text("faint", Anchor::Middle, [x, FRAME.bottom + 16.0], &text);
        }
        for Tick { at, text } in self.error.ticks(8) {
            let y = bottom - at * (bottom - top);
            let long = !text.is_empty();
            svg.line(
                "grid",
                [FRAME.left, y],
                [if long { FRAME.right } else { FRAME.left + 5.0 }, y],
            );
            svg.text("faint", Anchor::End, [FRAME.left - 6.0, y + 4.0], &text);
        }
        let strips =
            [(self.exact, bottom, "exact", 0.0), (self.broken, top, "non-finite", f64::NAN)];
        for (there, edge, name, error) in strips {
            if there {
                svg.line("frame", [FRAME.left, edge], [FRAME.right, edge]);
                svg.text("faint", Anchor::End, [FRAME.left - 6.0, self.y(error) + 4.0], name);
            }
        }
        let size = [FRAME.right - FRAME.left, FRAME.bottom - FRAME.top];
        svg.rect("frame", [FRAME.left, FRAME.top], size);
        let middle = (FRAME.left + FRAME.right) / 2.0;
        svg.text("", Anchor::Middle, [middle, FRAME.bottom + 38.0], &scatter.time);
        svg.upward([18.0, (FRAME.top + FRAME.bottom) / 2.0], &scatter.error);
    }

    /// Returns the Pareto front of a series by time, without dominated marks, whose median may be
    /// lower by chance.
    fn front(&self, scatter: &Scatter, series: &str) -> Vec<[f64; 2]> {
        let mut marks: Vec<&Mark> = scatter
            .marks
            .iter()
            .filter(|mark| mark.series == series && mark.error.is_finite() && !mark.dominated)
            .collect();
        marks.sort_by(|a, b| a.time[1].total_cmp(&b.time[1]).then(a.error.total_cmp(&b.error)));
        let mut corners: Vec<[f64; 2]> = Vec::new();
        let mut least = f64::INFINITY;
        for mark in marks {
            if mark.error < least {
                least = mark.error;
                corners.push(self.place(mark));
            }
        }
        corners
    }

    /// Places the labels, those of the best marks first.
    fn labels(
        &self,
        svg: &mut Svg,
        scatter: &Scatter,
        places: &[[f64; 2]],
        fronts: &[Vec<[f64; 2]>],
    ) {
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by_key(|&i| scatter.marks[i].dominated);
        // Within its strip or the middle: elsewhere it would suggest another error.
        let [top, bottom] = self.inner;
        let frame = |y: f64| match y {
            y if y < top => Area { bottom: top, ..FRAME },
            y if y > bottom => Area { top: bottom, ..FRAME },
            _ => Area { top, bottom, ..FRAME },
        };
        let labels: Vec<PlotLabel> = order
            .iter()
            .map(|&i| PlotLabel {
                point: places[i],
                width: width(&scatter.marks[i].label),
                frame: frame(places[i][1]),
            })
            .collect();
        let mut taken: Vec<Area> = places.iter().map(|at| Area::around(*at, REACH + 1.0)).collect();
        taken.extend(scatter.marks.iter().zip(places).map(|(mark, at)| Area {
            left: self.x(mark.time[0]),
            right: self.x(mark.time[2]),
            top: at[1] - 3.0,
            bottom: at[1] + 3.0,
        }));
        // The lines of the fronts too: a label across one would hide it.
        for pair in fronts.iter().flat_map(|corners| corners.windows(2)) {
            let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
            taken.push(Area { left: x0, right: x1, top: y0 - 1.0, bottom: y0 + 1.0 });
            taken.push(Area { left: x1 - 1.0, right: x1 + 1.0, top: y0, bottom: y1 });
        }
        for (placed, &i) in place(&labels, &taken).iter().zip(&order) {
            let area = placed.area;
            if placed.leads {
                let [x, y] = places[i];
                let to = [x.clamp(area.left, area.right), y.clamp(area.top, area.bottom)];
                svg.line("lead", [x, y], to);
            }
            let class = if scatter.marks[i].dominated { "label faint" } else { "label" };
            svg.text(class, Anchor::Start, [area.left, area.bottom - 1.5], &scatter.marks[i].label);
        }
    }

    fn legend(&self, svg: &mut Svg) {
        let (x, mut y) = (FRAME.right + 24.0, FRAME.top + 10.0);
        let mut row = |svg: &mut Svg, draw: &dyn Fn(&mut Svg, [f64; 2]), text: &str| {
            draw(svg, [x, y - 4.0]);
            svg.text("", Anchor::Start, [x + 16.0, y], text);
            y += 20.0;
        };
        for (i, name) in self.series.iter().enumerate() {
            row(svg, &|svg, at| shape(svg, i, false, at), name);
        }
        row(svg, &|_, _| {}, "");
        row(svg, &|svg, at| shape(svg, 0, false, at), "not dominated");
        row(svg, &|svg, at| shape(svg, 0, true, at), "dominated");
        row(
            svg,
            &|svg, [x, y]| {
                svg.raw(&format!(
                    "<path class=\"s0 front\" d=\"M{} {}h8v10h10\"/>",
                    number(x - 10.0),
                    number(y - 5.0)
                ))
            },
            "Pareto front",
        );
        row(
            svg,
            &|svg, [x, y]| {
                svg.raw(&format!(
                    "<path class=\"s0 bar\" d=\"M{0} {2}V{3}M{0} {4}H{1}M{1} {2}V{3}\"/>",
                    number(x - 9.0),
                    number(x + 9.0),
                    number(y - 3.0),
                    number(y + 3.0),
                    number(y)
                ))
            },
            "interquartile range",
        );
        row(svg, &|_, _| {}, "");
        row(svg, &|_, _| {}, "lower left is better");
    }
}

/// Draws a front: from each mark to the next, right and then down.
fn steps(svg: &mut Svg, series: usize, corners: &[[f64; 2]]) {
    let [[x, y], rest @ ..] = corners else { return };
    if rest.is_empty() {
        return;
    }
    let mut path = format!("M{} {}", number(*x), number(*y));
    for [x, y] in rest {
        path.push_str(&format!("H{}V{}", number(*x), number(*y)));
    }
    let dashes = DASHES[series % DASHES.len()];
    let series = series % SERIES.len();
    svg.raw(&format!("<path class=\"s{series} front\"{dashes} d=\"{path}\"/>"));
}

/// The strokes of the fronts of several series.
const DASHES: [&str; 6] = [
    "",
    " stroke-dasharray=\"6 3\"",
    " stroke-dasharray=\"2 3\"",
    " stroke-dasharray=\"8 3 2 3\"",
    " stroke-dasharray=\"1 2\"",
    " stroke-dasharray=\"10 4\"",
];

/// Draws a mark in the shape of its series, filled or hollow.
fn shape(svg: &mut Svg, series: usize, hollow: bool, [x, y]: [f64; 2]) {
    let class = match hollow {
        true => format!("s{} hollow", series % SERIES.len()),
        false => format!("s{}", series % SERIES.len()),
    };
    let (x0, y0) = (number(x), number(y));
    let [left, right, top, bottom] = [x - REACH, x + REACH, y - REACH, y + REACH].map(number);
    let drawn = match series % SERIES.len() {
        0 => format!("<circle class=\"{class}\" cx=\"{x0}\" cy=\"{y0}\" r=\"{REACH}\"/>"),
        1 => format!("<path class=\"{class}\" d=\"M{left} {top}H{right}V{bottom}H{left}Z\"/>"),
        2 => format!("<path class=\"{class}\" d=\"M{x0} {top}L{right} {bottom}H{left}Z\"/>"),
        3 => format!(
            "<path class=\"{class}\" d=\"M{x0} {top}L{right} {y0}L{x0} {bottom}L{left} {y0}Z\"/>"
        ),
        4 => format!("<path class=\"{class}\" d=\"M{left} {top}H{right}L{x0} {bottom}Z\"/>"),
        _ => format!(
            "<path class=\"{class}\" d=\"M{left} {y0}L{x0} {top}H{right}V{y0}L{x0} {bottom}H{left}Z\"/>"
        ),
    };
    svg.raw(&drawn);
}
