//! Drawings of measurements: well-formed, the same each time, legible.
//!
//! They are to be looked at, too: the tests leave `scatter.svg` and `heat_map.svg` in cargo's
//! folder for files of tests.

use landfall_accuracy::plot::{Axis, Cell, HeatMap, MapMark, Mark, Scatter, heat_map, scatter};
use roxmltree::{Document, Node};

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
        marks: vec![MapMark { at: [10.0, 1.9], text: "319 steps".to_string() }],
    }
}

/// Elements of a class.
fn of_class<'a>(document: &'a Document<'_>, class: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    document.descendants().filter(move |node| {
        node.attribute("class").is_some_and(|classes| classes.split(' ').any(|c| c == class))
    })
}

fn number(node: &Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("{node:?}"))
}

fn keep(name: &str, text: &str) {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(folder.join(name), text).unwrap();
}

#[test]
fn a_scatter_is_xml_with_every_label_and_the_same_each_time() {
    let text = scatter(&drawing(marks()));
    keep("scatter.svg", &text);
    assert_eq!(text, scatter(&drawing(marks())));
    let document = Document::parse(&text).unwrap();
    let labels: Vec<&str> = of_class(&document, "label").filter_map(|n| n.text()).collect();
    assert_eq!(labels.len(), marks().len());
    for mark in marks() {
        assert!(labels.contains(&mark.label.as_str()), "{}", mark.label);
    }
    assert!(!text.contains("NaN") && !text.contains("inf"), "no coordinate is no number");
}

#[test]
fn dominated_marks_are_hollow_and_the_others_filled() {
    let text = scatter(&drawing(marks()));
    let document = Document::parse(&text).unwrap();
    let dominated = marks().iter().filter(|mark| mark.dominated).count();
    // One more is in the legend.
    assert_eq!(of_class(&document, "hollow").count(), dominated + 1);
    let hollow = of_class(&document, "hollow").next().unwrap();
    let series = hollow.attribute("class").unwrap().split(' ').next().unwrap();
    assert!(text.contains(&format!(".{series}.hollow {{ fill: #ffffff; }}")), "{series}");
}

#[test]
fn the_front_steps_through_those_that_no_other_beats() {
    let text = scatter(&drawing(marks()));
    let document = Document::parse(&text).unwrap();
    let blue = of_class(&document, "s0").find(|n| n.attribute("class") == Some("s0 front"));
    let path = blue.unwrap().attribute("d").unwrap();
    // M x y, then H and V from mark to mark: of the series only 9.7, 10.5 and 12.8 ns are on it.
    let steps: Vec<f64> = path
        .trim_start_matches('M')
        .split([' ', 'H', 'V'])
        .map(|number| number.parse().unwrap())
        .collect();
    assert_eq!(steps.len(), 2 + 2 * 2, "{path}");
    let (xs, ys): (Vec<f64>, Vec<f64>) = steps.chunks(2).map(|p| (p[0], p[1])).unzip();
    assert!(xs.is_sorted() && ys.is_sorted(), "to the right and down: {path}");
}

#[test]
fn a_front_leaves_out_what_is_faster_by_chance() {
    let mark = |label: &str, time: f64, error: f64, dominated: bool| Mark {
        label: label.to_string(),
        series: "gl".to_string(),
        time: [time * 0.9, time, time * 1.1],
        error,
        dominated,
    };
    let both = |dominated| {
        scatter(&drawing(vec![mark("a", 59.1, 1.6e-3, dominated), mark("b", 59.3, 2.9e-4, false)]))
    };
    let has_front = |text: &str| {
        let document = Document::parse(text).unwrap();
        of_class(&document, "front").any(|n| n.attribute("d").is_some_and(|d| d.contains('H')))
    };
    assert!(has_front(&both(false)) && !has_front(&both(true)));
}

#[test]
fn labels_are_apart_and_inside() {
    let mut random = fastrand::Rng::with_seed(4);
    for _ in 0..50 {
        let marks = (0..14).map(|i| {
            let time = 10f64.powf(1.0 + 2.0 * random.f64());
            Mark {
                label: format!("variant {i} of many"),
                series: ["cpu", "gpu"][i % 2].to_string(),
                time: [time * 0.95, time, time * 1.05],
                error: 10f64.powf(-4.0 * random.f64()),
                dominated: random.bool(),
            }
        });
        let text = scatter(&drawing(marks.collect()));
        let document = Document::parse(&text).unwrap();
        let boxes: Vec<[f64; 4]> = of_class(&document, "label")
            .map(|node| {
                let (x, y) = (number(&node, "x"), number(&node, "y"));
                // Half an em a letter: less than any font takes would hide an overlap, and more
                // is not the claim.
                let width = 5.5 * node.text().unwrap().chars().count() as f64;
                [x, y - 8.0, x + width, y]
            })
            .collect();
        for (i, a) in boxes.iter().enumerate() {
            assert!(a[0] > 60.0 && a[2] < 590.0, "{a:?}");
            for b in &boxes[..i] {
                let apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
                assert!(apart, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn odd_numbers_are_drawn_without_a_panic() {
    let odd = [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-320, 1e308];
    for time in odd {
        for error in odd {
            let mark = Mark {
                label: "\u{1}odd & <even>".to_string(),
                series: String::new(),
                time: [time; 3],
                error,
                dominated: false,
            };
            let text = scatter(&drawing(vec![mark.clone(), mark]));
            Document::parse(&text).unwrap_or_else(|e| panic!("{time} {error}: {e}"));
        }
    }
    Document::parse(&scatter(&drawing(Vec::new()))).unwrap();
    let empty = HeatMap { columns: 0, cells: Vec::new(), ..map() };
    Document::parse(&heat_map(&empty)).unwrap();
}

#[test]
fn a_heat_map_shows_no_numbers_by_patterns_and_lies_right_way_up() {
    let text = heat_map(&map());
    keep("heat_map.svg", &text);
    let document = Document::parse(&text).unwrap();
    let filled = |paint: &str| {
        document.descendants().filter(|node| node.attribute("fill") == Some(paint)).count()
    };
    // 40 rows begin with it, and the scale has one.
    assert_eq!(filled("url(#nan)"), 41);
    assert_eq!(filled("url(#undefined)"), 4);
    // Of seven powers of ten along the axis, 10 is past four; 1.9 is 0.95 of the way up.
    let ring = document.descendants().find(|node| node.has_tag_name("circle")).unwrap();
    assert!((number(&ring, "cx") - (76.0 + 440.0 * 4.0 / 7.0)).abs() < 0.1);
    assert!((number(&ring, "cy") - (416.0 - 372.0 * 0.95)).abs() < 0.1);
    assert!(text.contains("319 steps"));
    let two = HeatMap {
        columns: 1,
        cells: vec![Cell::Error(1e-6), Cell::Error(1e2)],
        error: Axis::log("steps", 1e-6, 1e2),
        ..map()
    };
    let text = heat_map(&two);
    let document = Document::parse(&text).unwrap();
    let y = |paint: &str| {
        let all = document.descendants().filter(|node| node.attribute("fill") == Some(paint));
        // The widest is the cell, the others are of the scale.
        let widest = all.max_by(|a, b| number(a, "width").total_cmp(&number(b, "width")));
        number(&widest.unwrap(), "y")
    };
    // Dark is little, and the first row is the lowest.
    assert!(y("#000004") > y("#fcfdbf"));
}

#[test]
fn numbers_along_axes_are_round() {
    let texts = |axis: Axis, most| -> Vec<String> {
        let ticks = axis.ticks(most).into_iter();
        ticks.filter(|tick| !tick.text.is_empty()).map(|tick| tick.text).collect()
    };
    assert_eq!(
        texts(Axis::log("", 1e-3, 1e4), 8),
        ["0.001", "0.01", "0.1", "1", "10", "100", "1000", "10⁴"]
    );
    assert_eq!(texts(Axis::log("", 1e-8, 1e8), 5), ["10⁻⁸", "0.0001", "1", "10⁴", "10⁸"]);
    assert_eq!(texts(Axis::log("", 9.0, 60.0), 6), ["10", "20", "50"]);
    assert_eq!(texts(Axis::linear("", 0.0, 2.0), 4), ["0", "0.5", "1.0", "1.5", "2.0"]);
    let axis = Axis::log("", 1.0, 100.0);
    assert!((axis.at(10.0) - 0.5).abs() < 1e-12 && (axis.number(0.5) - 10.0).abs() < 1e-12);
    assert_eq!((axis.at(0.0), axis.at(1e9), axis.at(f64::NAN)), (0.0, 1.0, 0.0));
}
