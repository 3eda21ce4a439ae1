//! The thread that checks all shaders of a project while the client is answered on another.

use std::sync::Arc;

use crossbeam_channel::{Receiver, Sender};
use landfall_check::stop::StopFlag;
use landfall_layout::source::OpenFiles;

use crate::project::{CheckSetup, PassMemory, ProjectFindings};

/// A pass over all shaders that is to be run.
pub struct PassJob {
    /// The index of the project, and its generation.
    pub project: usize,
    pub generation: u64,
    pub setup: Arc<CheckSetup>,
    pub open: Arc<OpenFiles>,
    pub memory: PassMemory,
    pub stop: StopFlag,
}

/// A pass that has ended.
pub struct PassResult {
    pub project: usize,
    pub generation: u64,
    /// `None` if it was stopped.
    pub found: Option<ProjectFindings>,
    pub memory: PassMemory,
}

/// Runs passes until no more come.
pub fn run(jobs: &Receiver<PassJob>, results: &Sender<PassResult>) {
    for mut job in jobs {
        let found = job.setup.check_all(&job.open, &mut job.memory, &job.stop);
        let result = PassResult {
            project: job.project,
            generation: job.generation,
            found,
            memory: job.memory,
        };
        if results.send(result).is_err() {
            return;
        }
    }
}
