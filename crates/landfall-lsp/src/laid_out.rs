//! The layouts of shaders as they are edited, each computed when a request first needs it.

use std::collections::HashMap;
use std::sync::Arc;

use landfall_check::caught::caught;
use landfall_layout::source::OpenFiles;
use landfall_layout::{ShaderLayout, Source};

use crate::declarations::{PlacedDeclaration, declarations};
use crate::project::CheckSetup;

/// A shader with the layout of its blocks.
pub struct LaidOut {
    pub source: Source,
    pub shader: ShaderLayout,
    pub declarations: Vec<PlacedDeclaration>,
}

impl LaidOut {
    fn new(setup: &CheckSetup, shown: &str, open: &Arc<OpenFiles>) -> Option<LaidOut> {
        let (source, shader) = setup.layout(shown, open)?;
        let declarations = caught(shown, || declarations(&shader)).ok()?;
        Some(LaidOut { source, shader, declarations })
    }
}

/// The layouts since the last change of a document.
#[derive(Default)]
pub struct LayoutCache {
    generation: u64,
    laid_out: HashMap<String, Option<Arc<LaidOut>>>,
}

impl LayoutCache {
    /// The layout of a shader while the open documents are those of `generation`.
    pub fn get(
        &mut self,
        generation: u64,
        setup: &CheckSetup,
        shown: &str,
        open: impl FnOnce() -> Arc<OpenFiles>,
    ) -> Option<Arc<LaidOut>> {
        if self.generation != generation {
            self.generation = generation;
            self.laid_out.clear();
        }
        if let Some(known) = self.laid_out.get(shown) {
            return known.clone();
        }
        let new = LaidOut::new(setup, shown, &open()).map(Arc::new);
        self.laid_out.insert(shown.to_string(), new.clone());
        new
    }
}
