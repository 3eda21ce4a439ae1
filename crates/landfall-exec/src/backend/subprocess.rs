//! Drivers crash and hang: a reader whose driver is loaded in a process of its own.
//!
//! [`Remote`] is the near side: it sends jobs, waits no longer than their limit, and starts
//! a new process for the next job when one has died. [`serve`] is the far side, which a
//! program calls when it is started with what [`Launch`] says; `landfall reader gl` is one.

mod child;
mod frame;
#[cfg(feature = "gpu")]
mod ir;
mod serve;
mod wire;

use crate::backend::BackendKind;
use std::ffi::OsString;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

pub use self::serve::{Behind, serve};

use super::devices::Found;
use crate::backend::{Answer, Device, Failure, FailureKind, Job, Reader};
use child::Process;
use frame::Frame;
use landfall_ir::Module;
use wire::{Ask, Reply, Times, WireFound, WireJob};

/// How the process of a driver is started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Launch {
    /// A program that calls [`serve`].
    pub program: PathBuf,
    /// Its arguments.
    pub arguments: Vec<OsString>,
    /// Variables of its environment beside those of this process.
    pub environment: Vec<(OsString, OsString)>,
    /// The driver must have opened by then.
    pub opening: Duration,
    /// Whether the device times its jobs by timestamps of its own, where it has those.
    pub timed: bool,
}

impl Launch {
    /// The program `landfall`, or another that takes `reader gl` and `reader gpu`.
    pub fn new(program: impl Into<PathBuf>, behind: &Behind) -> Launch {
        let arguments = match behind {
            Behind::Gl => vec!["reader".into(), "gl".into()],
            Behind::Gpu(None) => vec!["reader".into(), "gpu".into()],
            Behind::Gpu(Some(adapter)) => {
                vec!["reader".into(), "gpu".into(), "--adapter".into(), adapter.into()]
            }
        };
        Launch {
            program: program.into(),
            arguments,
            environment: Vec::new(),
            opening: Duration::from_secs(60),
            timed: false,
        }
    }
}

/// A reader in a process of its own.
pub struct Remote {
    launch: Launch,
    device: Device,
    session: Option<Session>,
    /// How long the last job took.
    times: Times,
}

/// A process and what it has been told.
struct Session {
    process: Process,
    modules: Vec<(Arc<Module>, u64)>,
    next: u64,
}

/// Beyond this many modules the other side forgets all: nobody runs more in turn.
const KEPT: usize = 64;

impl Remote {
    /// Starts the process and opens its driver.
    ///
    /// # Errors
    /// Why there is no driver; [`FailureKind::Died`] or [`FailureKind::TimedOut`] where one
    /// crashes or hangs when it is opened.
    pub fn open(launch: Launch) -> Result<Remote, Failure> {
        let (session, device) = Session::open(&launch)?;
        Ok(Remote { launch, device, session: Some(session), times: Times::default() })
    }

    /// The number of the process, while there is one.
    pub fn process(&self) -> Option<u32> {
        self.session.as_ref().map(|session| session.process.id())
    }

    /// [`Gl::reflect`](super::gl::Gl::reflect) in the other process.
    ///
    /// # Errors
    /// What the compiler says against the texts, or how the process ended.
    #[cfg(feature = "gl")]
    pub fn reflect(
        &mut self,
        sources: &[(landfall_layout::Stage, &str)],
        limit: Duration,
    ) -> Result<super::reflection::Reflection, Failure> {
        let text = |&(stage, text): &(landfall_layout::Stage, &str)| {
            (stage.name().to_string(), text.to_string())
        };
        let ask = Ask::Reflect { sources: sources.iter().map(text).collect() };
        let reflected = self.session().and_then(|session| {
            match session.ask(&ask, Frame::default(), limit)?.0 {
                Reply::Reflected(reflection) => Ok(reflection),
                other => Err(unexpected(other)),
            }
        });
        self.bury(reflected)
    }

    /// The process, a new one if the last has ended.
    fn session(&mut self) -> Result<&mut Session, Failure> {
        // Asked first, so that a job is not blamed for what came before it.
        let last = self
            .session
            .take()
            .and_then(|mut session| session.device(&self.launch).ok().map(|_| session));
        let session = match last {
            Some(session) => session,
            None => {
                let (session, device) = Session::open(&self.launch)?;
                self.device = device;
                session
            }
        };
        Ok(self.session.insert(session))
    }

    /// Lets go of a process that is of no more use.
    fn bury<T>(&mut self, result: Result<T, Failure>) -> Result<T, Failure> {
        if let Err(failure) = &result {
            match failure.kind {
                FailureKind::Died | FailureKind::TimedOut => self.session = None,
                FailureKind::Missing | FailureKind::Refused | FailureKind::Unfit => {}
            }
        }
        result
    }
}

impl Reader for Remote {
    fn device(&self) -> &Device {
        &self.device
    }

    fn run(&mut self, job: &Job) -> Result<Answer, Failure> {
        let reader = self.device.reader;
        self.times = Times::default();
        let ran = self.session().and_then(|session| session.run(job, reader));
        let (answer, times) = self.bury(ran)?;
        self.times = times;
        Ok(answer)
    }

    fn device_time(&self) -> Option<Duration> {
        self.times.device
    }

    fn processor_time(&self) -> Option<Duration> {
        self.times.processor
    }

    #[cfg(feature = "gl")]
    fn reflect(
        &mut self,
        texts: &[(landfall_layout::Stage, &str)],
        limit: Duration,
    ) -> Option<Result<super::reflection::Reflection, Failure>> {
        (self.device.reader == BackendKind::Gl).then(|| Remote::reflect(self, texts, limit))
    }
}

/// Everything a driver has to offer, asked of a process of its own.
///
/// # Errors
/// Why there is no driver, or how the process ended.
pub fn list(launch: &Launch) -> Result<Vec<Found>, Failure> {
    let mut session = Session::start(launch)?;
    match session.ask(&Ask::List, Frame::default(), launch.opening)?.0 {
        Reply::Listed(found) => {
            found.into_iter().map(|found| WireFound::found(found).map_err(garbled)).collect()
        }
        other => Err(unexpected(other)),
    }
}

impl Session {
    fn start(launch: &Launch) -> Result<Session, Failure> {
        Ok(Session { process: Process::start(launch)?, modules: Vec::new(), next: 0 })
    }

    fn open(launch: &Launch) -> Result<(Session, Device), Failure> {
        let mut session = Session::start(launch)?;
        let device = session.device(launch)?;
        Ok((session, device))
    }

    fn device(&mut self, launch: &Launch) -> Result<Device, Failure> {
        let open = Ask::Open { timed: launch.timed };
        match self.ask(&open, Frame::default(), launch.opening)?.0 {
            Reply::Opened(device) => device.device().map_err(garbled),
            other => Err(unexpected(other)),
        }
    }

    fn run(&mut self, job: &Job, reader: BackendKind) -> Result<(Answer, Times), Failure> {
        let mut frame = Frame::default();
        let wire = WireJob::new(job, reader, &mut frame, |module| self.number(module))
            .map_err(unsendable)?;
        let (reply, mut frame) = self.ask(&Ask::Run(wire), frame, job.limit)?;
        match reply {
            Reply::Ran { buffers, pixels, times } => {
                let answer = Reply::answer(buffers, pixels, &mut frame).map_err(garbled)?;
                Ok((answer, times))
            }
            other => Err(unexpected(other)),
        }
    }

    fn ask(&mut self, ask: &Ask, frame: Frame, limit: Duration) -> Result<(Reply, Frame), Failure> {
        self.process.send(frame.with(ask).map_err(unsendable)?);
        let frame = self.process.receive(limit)?;
        let reply = frame.header().map_err(garbled)?;
        Ok((reply, frame))
    }

    /// The number the other side knows a module by; it is sent when it is new there.
    fn number(&mut self, module: &Arc<Module>) -> io::Result<u64> {
        if let Some((_, id)) = self.modules.iter().find(|known| Arc::ptr_eq(&known.0, module)) {
            return Ok(*id);
        }
        if self.modules.len() >= KEPT {
            self.modules.clear();
            self.process.send(Frame::default().with(&Ask::Forget)?);
        }
        let id = self.next;
        self.next += 1;
        let mut frame = Frame::default();
        let json = frame.put(json(module)?);
        self.process.send(frame.with(&Ask::Module { id, json })?);
        self.modules.push((Arc::clone(module), id));
        Ok(id)
    }
}

#[cfg(feature = "gpu")]
fn json(module: &Module) -> io::Result<Vec<u8>> {
    ir::write(module)
}

#[cfg(not(feature = "gpu"))]
fn json(_: &Module) -> io::Result<Vec<u8>> {
    Err(frame::invalid("this build runs no modules"))
}

fn unexpected(reply: Reply) -> Failure {
    match reply {
        Reply::Failed(failure) => failure,
        other => Failure::died(
            "the process of the driver answers another question",
            format!("{other:?}"),
        ),
    }
}

fn garbled(cause: io::Error) -> Failure {
    Failure::died("the process of the driver talks nonsense", cause.to_string())
}

fn unsendable(cause: io::Error) -> Failure {
    Failure::refused("the job cannot be sent to the process of the driver", cause.to_string())
}
