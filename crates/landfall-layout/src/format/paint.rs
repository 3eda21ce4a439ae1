//! The styles of text output. Their colours can be read on white and on black: yellow, cyan and white
//! cannot.

use anstyle::{AnsiColor, Style};

use crate::text::escape::Styles;

/// Whether output uses ANSI colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Paint {
    /// Plain text.
    #[default]
    Plain,
    /// Text with ANSI escapes.
    Ansi,
}

/// No style.
pub const PLAIN: Style = Style::new();
/// Names and totals.
pub const STRONG: Style = Style::new().bold();
/// Less important text.
pub const FAINT: Style = Style::new().dimmed();
/// Types.
pub const TYPE: Style = AnsiColor::BrightBlue.on_default();
/// Headings.
pub const HEADING: Style = AnsiColor::BrightBlue.on_default().bold();
/// Removed lines and errors.
pub const REMOVED: Style = AnsiColor::Red.on_default();
/// Warnings.
pub const CAUTION: Style = AnsiColor::Magenta.on_default();
pub(super) const ADDED: Style = AnsiColor::Green.on_default();

impl Paint {
    /// Whether text of this kind may hold style sequences.
    #[doc(hidden)]
    pub fn styles(self) -> Styles {
        match self {
            Paint::Plain => Styles::Shown,
            Paint::Ansi => Styles::Kept,
        }
    }

    /// `text` in `style`.
    #[doc(hidden)]
    pub fn text(self, style: Style, text: &str) -> String {
        match self {
            Paint::Ansi if style != PLAIN && !text.is_empty() => {
                format!("{style}{text}{style:#}")
            }
            Paint::Ansi | Paint::Plain => text.to_string(),
        }
    }
}
