//! An OpenGL driver without a window: it runs jobs, and says where it put every member
//! of the blocks of a text as the user wrote it.
//!
//! llvmpipe (Mesa 22.3.6) lets an invocation have 65535 turns of all its loops together and
//! leaves them then, without a word: an answer of longer loops is not the shader's.
//!
//! [`Gl`] keeps one context of each kind a text asks for. It calls a driver, which may
//! crash or hang: [`subprocess`](crate::backend::subprocess) does the same in a process of its own.

mod bind;
mod context;
mod interface;
mod loose;
mod program;
mod reflect;
mod run;
mod types;
mod version;

use crate::backend::BackendKind;
use std::rc::Rc;

pub use context::ContextKind;

use super::devices::Found;
use super::reflection::Reflection;
use crate::backend::{Answer, Device, Failure, Job, Reader};
use context::{Context, Display};
use landfall_layout::source::Stage;
use program::{Partner, Programs};

/// An OpenGL driver in this process, for the thread that opened it.
pub struct Gl {
    display: Rc<Display>,
    slots: Vec<Slot>,
    device: Device,
}

/// A context that has been opened, and its programs.
struct Slot {
    context: Context,
    programs: Programs,
}

impl Gl {
    /// Opens the driver; a core context, or what there is instead, says who it is.
    ///
    /// # Errors
    /// [`FailureKind::Missing`](super::FailureKind::Missing) where there is none.
    pub fn open() -> Result<Gl, Failure> {
        let display = Display::open()?;
        let mut missing = None;
        for kind in ContextKind::ALL {
            match Context::open(&display, kind) {
                Ok(context) => {
                    let device = context.device.clone();
                    let slots = vec![Slot { context, programs: Programs::default() }];
                    return Ok(Gl { display, slots, device });
                }
                Err(failure) => missing = missing.or(Some(failure)),
            }
        }
        Err(missing.expect("there is at least one kind of context"))
    }

    /// Every kind of context, opened or missing.
    ///
    /// # Errors
    /// Why no driver can be opened at all.
    pub fn list() -> Result<Vec<Found>, Failure> {
        let display = Display::open()?;
        let found = ContextKind::ALL.map(|kind| match Context::open(&display, kind) {
            Ok(context) => {
                let (major, minor) = context.version;
                let kind = format!("{} {major}.{minor}", kind.name());
                let outcome = Ok((context.device.clone(), context.limits));
                Found { reader: BackendKind::Gl, kind, outcome }
            }
            Err(failure) => Found {
                reader: BackendKind::Gl,
                kind: kind.name().to_string(),
                outcome: Err(failure),
            },
        });
        Ok(found.into())
    }

    /// Compiles and links texts as they are and says what is active in the program.
    ///
    /// A lone stage is enough. The context is of the kind that the first text's `#version`
    /// asks for.
    ///
    /// # Errors
    /// [`FailureKind::Refused`](super::FailureKind::Refused) with the compiler's log.
    pub fn reflect(&mut self, sources: &[(Stage, &str)]) -> Result<Reflection, Failure> {
        let slot = self.slot(sources)?;
        let program = slot.programs.get(&slot.context, sources, Partner::None)?;
        reflect::reflect(&slot.context, program.id)
    }

    /// The context for those texts, made current.
    fn slot(&mut self, texts: &[(Stage, &str)]) -> Result<&mut Slot, Failure> {
        let Some((_, text)) = texts.first() else {
            return Err(Failure::refused("there is no shader to run", ""));
        };
        let kind = ContextKind::of_text(text);
        let at = match self.slots.iter().position(|slot| slot.context.kind == kind) {
            Some(at) => at,
            None => {
                let context = Context::open(&self.display, kind)?;
                self.slots.push(Slot { context, programs: Programs::default() });
                self.slots.len() - 1
            }
        };
        let slot = &mut self.slots[at];
        slot.context.make_current()?;
        Ok(slot)
    }
}

impl Reader for Gl {
    fn device(&self) -> &Device {
        &self.device
    }

    fn run(&mut self, job: &Job) -> Result<Answer, Failure> {
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

/// Asks a driver opened for this alone: [`Gl::reflect`].
///
/// # Errors
/// Why there is no driver, or what its compiler says against the texts.
pub fn reflect(sources: &[(Stage, &str)]) -> Result<Reflection, Failure> {
    Gl::open()?.reflect(sources)
}
