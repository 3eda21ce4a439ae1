//! The text of a hazard's finding, and what the lints write it from.

use landfall_ir::analysis::hazard::Threshold;
use landfall_ir::analysis::occurrence::Occurrence;
use landfall_layout::source::Language;

/// Writes the text of a hazard's finding.
pub type HazardText = fn(&HazardSite<'_>) -> HazardMessage;

/// The text of a finding.
pub struct HazardMessage {
    pub message: String,
    /// The label at the place.
    pub label: &'static str,
    pub notes: Vec<String>,
    pub help: String,
}

impl HazardMessage {
    pub fn new(
        message: impl Into<String>,
        label: &'static str,
        help: impl Into<String>,
    ) -> HazardMessage {
        HazardMessage { message: message.into(), label, notes: Vec::new(), help: help.into() }
    }

    pub fn with_note(mut self, note: impl Into<String>) -> HazardMessage {
        self.notes.push(note.into());
        self
    }
}

/// A hazard at its place in a shader.
pub struct HazardSite<'a> {
    pub occurrence: &'a Occurrence,
    pub language: Language,
}

impl<'a> HazardSite<'a> {
    /// The path of the operand: `lights[].position`; `None` if it has no name.
    pub fn path(&self) -> Option<&'a str> {
        Some(self.occurrence.about.as_str()).filter(|path| !path.is_empty())
    }

    /// The path in backticks, or `it`.
    pub fn about(&self) -> String {
        self.path().map_or("it".to_string(), |path| format!("`{path}`"))
    }

    /// The paths of an array of lights and of its count.
    pub fn array_and_count(&self) -> (&'a str, &'a str) {
        let about = self.occurrence.about.as_str();
        // The analysis joins the two paths by a space.
        about.split_once(' ').unwrap_or((about, "count"))
    }

    /// The length of the array of lights.
    pub fn slots(&self) -> f64 {
        self.occurrence.number.unwrap_or(0.0)
    }

    /// The hazard's threshold as GLSL and WGSL write it: `1.0e-4`.
    pub fn least(&self) -> String {
        self.occurrence.hazard.info().threshold.map(Threshold::literal).unwrap_or_default()
    }

    /// The square of the threshold, for guards of squared lengths.
    pub fn least_square(&self) -> String {
        self.occurrence.hazard.info().threshold.map(Threshold::squared_literal).unwrap_or_default()
    }

    /// The name of the function that returns `1 / sqrt(x)`.
    pub fn inverse_sqrt(&self) -> &'static str {
        match self.language {
            Language::Glsl | Language::SpirV => "inversesqrt",
            Language::Wgsl => "inverseSqrt",
        }
    }
}
