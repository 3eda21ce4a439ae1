//! Places labels beside points without overlap.
//!
//! Used by [`scatter`](mod@super::scatter): each label tries places around its point, nearest
//! first, and takes the first free one, or else the least covered.

use super::svg::TEXT;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Area {
    pub fn around([x, y]: [f64; 2], reach: f64) -> Area {
        Area { left: x - reach, top: y - reach, right: x + reach, bottom: y + reach }
    }

    pub fn shared(&self, other: &Area) -> f64 {
        let width = self.right.min(other.right) - self.left.max(other.left);
        let height = self.bottom.min(other.bottom) - self.top.max(other.top);
        if width > 0.0 && height > 0.0 { width * height } else { 0.0 }
    }

    fn contains(&self, other: &Area) -> bool {
        other.left >= self.left
            && other.right <= self.right
            && other.top >= self.top
            && other.bottom <= self.bottom
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabelPosition {
    pub area: Area,
    /// Whether it is far enough from its point to need a leader line.
    pub leads: bool,
}

/// The directions from a point, best first.
const DIRECTIONS: [[f64; 2]; 8] = [
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.7, -0.7],
    [0.7, 0.7],
    [-0.7, -0.7],
    [-0.7, 0.7],
    [0.0, -1.0],
    [0.0, 1.0],
];

#[derive(Clone, Copy, Debug)]
pub struct PlotLabel {
    /// The point it belongs to.
    pub point: [f64; 2],
    pub width: f64,
    /// The area it must stay in.
    pub frame: Area,
}

/// Places labels near their points and off the `taken` areas, the first ones first.
pub fn place(labels: &[PlotLabel], taken: &[Area]) -> Vec<LabelPosition> {
    let mut taken = taken.to_vec();
    labels
        .iter()
        .map(|label| {
            let placed = place_label(label, &taken);
            taken.push(placed.area);
            placed
        })
        .collect()
}

fn place_label(label: &PlotLabel, taken: &[Area]) -> LabelPosition {
    let PlotLabel { point, width, frame } = *label;
    let mut best: Option<(f64, LabelPosition)> = None;
    for ring in 0..12 {
        let reach = 9.0 + 10.0 * f64::from(ring);
        for [dx, dy] in DIRECTIONS {
            let (x, y) = (point[0] + dx * reach, point[1] + dy * reach);
            let left = match dx {
                dx if dx > 0.0 => x,
                dx if dx < 0.0 => x - width,
                _ => x - width / 2.0,
            };
            let top = y - TEXT / 2.0 + dy * TEXT / 2.0;
            let area = Area { left, top, right: left + width, bottom: top + TEXT };
            let covered: f64 = taken.iter().map(|other| area.shared(other)).sum();
            // Larger than any overlap, so that a label leaves its frame only if it must.
            let outside = if frame.contains(&area) { 0.0 } else { 1e6 };
            let placed = LabelPosition { area, leads: ring > 0 };
            if covered + outside == 0.0 {
                return placed;
            }
            if best.is_none_or(|(least, _)| covered + outside < least) {
                best = Some((covered + outside, placed));
            }
        }
    }
    best.expect("there are directions").1
}
