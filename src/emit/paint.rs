//! Colours: the few styles the formats for the eye use.

use anstyle::{AnsiColor, Style};

/// Whether text carries ANSI colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Paint {
    /// Text alone.
    #[default]
    Plain,
    /// Text with ANSI escapes.
    Ansi,
}

pub(super) const PLAIN: Style = Style::new();
pub(super) const STRONG: Style = Style::new().bold();
pub(super) const FAINT: Style = Style::new().dimmed();
pub(super) const TYPE: Style = AnsiColor::Cyan.on_default();
pub(super) const HEADING: Style = AnsiColor::Green.on_default().bold();
#[cfg(feature = "cli")]
pub(super) const REMOVED: Style = AnsiColor::Red.on_default();
pub(super) const CAUTION: Style = AnsiColor::Yellow.on_default();

impl Paint {
    /// The text in that style.
    pub(super) fn text(self, style: Style, text: &str) -> String {
        match self {
            Paint::Ansi if style != PLAIN && !text.is_empty() => {
                format!("{style}{text}{style:#}")
            }
            Paint::Ansi | Paint::Plain => text.to_string(),
        }
    }
}
