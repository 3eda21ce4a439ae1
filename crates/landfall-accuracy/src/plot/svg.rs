//! Writes SVG elements: numbers with one decimal, escaped text, light and dark colours.
//!
//! Used by the drawings of [`plot`](super).

use std::fmt::Write as _;

use landfall_layout::text::escape::xml;

/// The height of a line of text.
pub const TEXT: f64 = 11.0;

/// The colours on a light and a dark background, and the shared style.
const STYLE: &str = "\
text { font: 11px system-ui, 'DejaVu Sans', Verdana, sans-serif; fill: #24292f; }
.title { font-size: 14px; font-weight: 600; }
.faint { fill: #57606a; }
.panel { fill: #ffffff; }
.frame { fill: none; stroke: #8c959f; }
.grid { stroke: #d8dee4; }
.lead { stroke: #8c959f; stroke-width: 0.7; }
.front { fill: none; stroke-width: 1.6; }
.label { paint-order: stroke; stroke: #ffffff; stroke-width: 3; stroke-linejoin: round; }
";
const DARK: &str = "\
@media (prefers-color-scheme: dark) {
text { fill: #e6edf3; }
.faint { fill: #9198a1; }
.panel { fill: #0d1117; }
.frame { stroke: #6e7681; }
.grid { stroke: #262c36; }
.lead { stroke: #6e7681; }
.label { stroke: #0d1117; }
}
";

pub struct Svg {
    text: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

impl Svg {
    /// A drawing of that size with additional light and dark styles.
    pub fn new(width: f64, height: f64, title: &str, light: &str, dark: &str) -> Svg {
        let dark = DARK.replacen('\n', &format!("\n{dark}"), 1);
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\">\n"
        );
        let _ = writeln!(text, "<title>{}</title>", xml(title));
        let _ = writeln!(text, "<style>\n{STYLE}{light}{dark}</style>");
        let _ = writeln!(
            text,
            "<rect class=\"panel\" width=\"{width}\" height=\"{height}\" rx=\"6\"/>"
        );
        Svg { text }
    }

    /// Adds any element.
    pub fn raw(&mut self, element: &str) {
        self.text.push_str(element);
        self.text.push('\n');
    }

    pub fn line(&mut self, class: &str, from: [f64; 2], to: [f64; 2]) {
        let [x1, y1, x2, y2] = [from[0], from[1], to[0], to[1]].map(number);
        let _ = writeln!(
            self.text,
            "<line class=\"{class}\" x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"/>"
        );
    }

    pub fn rect(&mut self, class: &str, at: [f64; 2], size: [f64; 2]) {
        let [x, y, w, h] = [at[0], at[1], size[0], size[1]].map(number);
        let _ = writeln!(
            self.text,
            "<rect class=\"{class}\" x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/>"
        );
    }

    /// Adds a line of text at its baseline.
    pub fn text(&mut self, class: &str, anchor: Anchor, at: [f64; 2], text: &str) {
        self.turned(class, anchor, at, None, text);
    }

    /// Adds a centred line of text, rotated to read upwards.
    pub fn upward(&mut self, at: [f64; 2], text: &str) {
        self.turned("", Anchor::Middle, at, Some(-90), text);
    }

    fn turned(&mut self, class: &str, anchor: Anchor, at: [f64; 2], turn: Option<i32>, text: &str) {
        let [x, y] = at.map(number);
        let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let turn =
            turn.map(|by| format!(" transform=\"rotate({by} {x} {y})\"")).unwrap_or_default();
        let text = xml(text);
        let _ = writeln!(self.text, "<text{class}{anchor} x=\"{x}\" y=\"{y}\"{turn}>{text}</text>");
    }

    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// Formats a coordinate to a tenth of a pixel.
pub fn number(value: f64) -> String {
    let text = format!("{value:.1}");
    let text = text.strip_suffix(".0").unwrap_or(&text);
    // A small negative number is rounded to it.
    if text == "-0" { "0".to_string() } else { text.to_string() }
}

/// Returns an upper estimate of a text's width at 11 pixels, by the widest of the usual fonts.
pub fn width(text: &str) -> f64 {
    let em = |c: char| match c {
        'i' | 'j' | 'l' | 't' | 'f' | 'I' | '.' | ',' | ':' | ';' | '\'' | '|' | ' ' => 0.38,
        'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.96,
        'A'..='Z' => 0.72,
        '⁰'..='⁹' | '⁻' | '¹' | '²' | '³' => 0.45,
        _ => 0.64,
    };
    text.chars().map(em).sum::<f64>() * TEXT
}
