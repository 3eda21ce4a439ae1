//! The OpenGL backend: a driver without a window, which runs jobs and reports the layout of the
//! blocks of an unchanged text.
//!
//! llvmpipe (Mesa 22.3.6) ends all loops of an invocation after 65535 iterations in total, without
//! an error: results of longer loops are wrong.
//!
//! [`Gl`] keeps one context of each kind that texts need. The driver may crash or hang;
//! [`subprocess`](crate::backend::subprocess) runs it in a separate process.

mod bindings;
mod context;
mod default_uniforms;
mod interface;
mod program;
mod reflect;
mod run;
mod types;
mod version;

use crate::backend::BackendKind;
use std::rc::Rc;

pub use context::ContextKind;

use super::devices::BackendEntry;
use super::reflection::Reflection;
use crate::backend::{Backend, Device, Failure, Job, JobOutput};
use context::{Display, GlContext};
use landfall_layout::source::Stage;
use program::{GlPrograms, PartnerStage};

/// An OpenGL driver in this process, bound to the thread that opened it.
pub struct Gl {
    display: Rc<Display>,
    slots: Vec<ContextSlot>,
    device: Device,
}

/// An open context and its programs.
struct ContextSlot {
    context: GlContext,
    programs: GlPrograms,
}

impl Gl {
    /// Opens the driver. The device is that of a core context, or of the first context available.
    ///
    /// # Errors
    /// [`FailureKind::Missing`](super::FailureKind::Missing) if there is no driver.
    pub fn open() -> Result<Gl, Failure> {
        let display = Display::open()?;
        let mut missing = None;
        // A system may have ES alone, as with ANGLE, or desktop OpenGL alone.
        for kind in ContextKind::ALL {
            match GlContext::open(&display, kind) {
                Ok(context) => {
                    let device = context.device.clone();
                    let slots = vec![ContextSlot { context, programs: GlPrograms::default() }];
                    return Ok(Gl { display, slots, device });
                }
                Err(failure) => missing = missing.or(Some(failure)),
            }
        }
        Err(missing.expect("there is at least one kind of context"))
    }

    /// Lists every kind of context, available or missing.
    ///
    /// # Errors
    /// Fails if no driver can be opened at all.
    pub fn list() -> Result<Vec<BackendEntry>, Failure> {
        let display = Display::open()?;
        let found = ContextKind::ALL.map(|kind| match GlContext::open(&display, kind) {
            Ok(context) => {
                let (major, minor) = context.version;
                let kind = format!("{} {major}.{minor}", kind.name());
                let outcome = Ok((context.device.clone(), context.limits));
                BackendEntry { backend: BackendKind::Gl, kind, outcome }
            }
            Err(failure) => BackendEntry {
                backend: BackendKind::Gl,
                kind: kind.name().to_string(),
                outcome: Err(failure),
            },
        });
        Ok(found.into())
    }

    /// Compiles and links texts unchanged and returns the active blocks and uniforms.
    ///
    /// A single stage is enough. The first text's `#version` selects the kind of context.
    ///
    /// # Errors
    /// [`FailureKind::Refused`](super::FailureKind::Refused) with the compiler's log.
    pub fn reflect(&mut self, sources: &[(Stage, &str)]) -> Result<Reflection, Failure> {
        let slot = self.slot(sources)?;
        let program = slot.programs.get(&slot.context, sources, PartnerStage::None)?;
        program.reflection(&slot.context).cloned()
    }

    /// Returns the context for the given texts, made current.
    fn slot(&mut self, texts: &[(Stage, &str)]) -> Result<&mut ContextSlot, Failure> {
        let Some((_, text)) = texts.first() else {
            return Err(Failure::refused("there is no shader to run", ""));
        };
        let kind = ContextKind::of_text(text);
        // Opened by the first text of its kind, and kept.
        let at = match self.slots.iter().position(|slot| slot.context.kind == kind) {
            Some(at) => at,
            None => {
                let context = GlContext::open(&self.display, kind)?;
                self.slots.push(ContextSlot { context, programs: GlPrograms::default() });
                self.slots.len() - 1
            }
        };
        let slot = &mut self.slots[at];
        slot.context.make_current()?;
        Ok(slot)
    }
}

impl Backend for Gl {
    fn device(&self) -> &Device {
        &self.device
    }

    fn run(&mut self, job: &Job) -> Result<JobOutput, Failure> {
        let texts = run::texts(job)?;
        let slot = self.slot(&texts)?;
        run::run(&slot.context, &mut slot.programs, job, &texts)
    }

    fn reflect(
        &mut self,
        texts: &[(Stage, &str)],
        _limit: std::time::Duration,
    ) -> Option<Result<Reflection, Failure>> {
        Some(Gl::reflect(self, texts))
    }
}

/// Opens a driver for a single [`Gl::reflect`].
///
/// # Errors
/// Fails if there is no driver or its compiler rejects the texts.
pub fn reflect(sources: &[(Stage, &str)]) -> Result<Reflection, Failure> {
    Gl::open()?.reflect(sources)
}
