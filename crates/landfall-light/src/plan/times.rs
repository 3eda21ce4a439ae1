//! The time of lighting by a plan, beside the time without one.

use std::time::Duration;

/// The time from the start of planning to the picture, by one clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// Planning: analysis and compilation of the shader, the trial on a sample, and the lists.
    pub planning: Duration,
    pub lighting: Duration,
    /// Lighting every fragment with all lights to measure the error of the plan.
    pub checking: Duration,
    /// Lighting the picture with all lights.
    pub whole: Option<Whole>,
}

/// The time of lighting a picture with all lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whole {
    pub time: Duration,
    /// The fragments that were lit; the time is scaled to those of the picture.
    pub fragments: u64,
    /// Whether these are all.
    pub measured: bool,
}

impl Times {
    /// Returns the time from the start of planning to the picture.
    pub fn total(&self) -> Duration {
        self.planning + self.lighting
    }

    /// Returns it in relation to lighting the picture with all lights.
    pub fn ratio(&self) -> Option<f64> {
        let whole = self.whole?.time.as_secs_f64();
        // An empty picture takes no time, and has no ratio.
        (whole > 0.0).then(|| self.total().as_secs_f64() / whole)
    }
}
