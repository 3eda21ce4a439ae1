//! A backend whose driver is loaded in a separate process, since drivers crash and hang.
//!
//! [`Subprocess`] is the client: it sends jobs, enforces their limits, and starts a new process for
//! the next job after one has died. [`serve`] is the server, called by a program that is started as
//! [`Launch`] describes, such as `landfall __reader gl`.

mod frame;
#[cfg(feature = "gpu")]
mod ir;
mod serve;
mod wire;

use crate::backend::BackendKind;
use std::ffi::OsString;
use std::io::{self, BufReader};
use std::path::PathBuf;
use std::process::{ChildStdin, ChildStdout, Command};
use std::sync::Arc;
use std::time::Duration;

pub use self::serve::{DriverKind, serve};

use super::devices::BackendEntry;
use crate::backend::child::{ChildRole, Message, Process};
use crate::backend::{Backend, Device, Failure, FailureKind, Job, JobOutput};
use frame::{Blob, WireFrame};
use landfall_ir::Module;
use wire::{JobTimes, Reply, Request, WireJob};

/// The command that starts a driver's process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Launch {
    /// A program that calls [`serve`].
    pub program: PathBuf,
    pub arguments: Vec<OsString>,
    /// Environment variables in addition to those of this process.
    pub environment: Vec<(OsString, OsString)>,
    /// The time limit for opening the driver.
    pub opening: Duration,
    /// Whether to time jobs by the device's timestamps, if it has any.
    pub timed: bool,
}

impl Launch {
    /// Starts the program `landfall`, or another that accepts `__reader gl` and `__reader gpu`.
    pub fn new(program: impl Into<PathBuf>, driver_kind: &DriverKind) -> Launch {
        let arguments = match driver_kind {
            DriverKind::Gl => vec!["__reader".into(), "gl".into()],
            DriverKind::Gpu(None) => vec!["__reader".into(), "gpu".into()],
            DriverKind::Gpu(Some(adapter)) => {
                vec!["__reader".into(), "gpu".into(), "--adapter".into(), adapter.into()]
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

    /// Has Mesa's software drivers leave out what takes longer than a shader that runs for a few
    /// invocations: LLVM's optimisations and threads that rasterize. A variable that the environment
    /// sets keeps its value.
    #[must_use]
    pub fn for_few_invocations(mut self) -> Launch {
        for (name, value) in [("GALLIVM_PERF", "nopt"), ("LP_NUM_THREADS", "0")] {
            if std::env::var_os(name).is_none() {
                self.environment.push((name.into(), value.into()));
            }
        }
        self
    }
}

/// A backend in a separate process.
pub struct Subprocess {
    launch: Launch,
    device: Device,
    session: Option<Session>,
    /// The times of the last job.
    times: JobTimes,
}

/// A process and the modules it knows.
struct Session {
    process: Process<WireFrame>,
    modules: Vec<(Arc<Module>, u64)>,
    next: u64,
}

/// The number of modules kept; a job with a new one after them begins with the server forgetting all.
const KEPT: usize = 64;

impl Subprocess {
    /// Starts the process and opens its driver.
    ///
    /// # Errors
    /// Fails if there is no driver; [`FailureKind::Died`] or [`FailureKind::TimedOut`] if it
    /// crashes or hangs while it is opened.
    pub fn open(launch: Launch) -> Result<Subprocess, Failure> {
        let (session, device) = Session::open(&launch)?;
        Ok(Subprocess { launch, device, session: Some(session), times: JobTimes::default() })
    }

    /// Returns the process ID, if a process runs.
    pub fn process(&self) -> Option<u32> {
        self.session.as_ref().map(|session| session.process.id())
    }

    /// Runs [`Gl::reflect`](super::gl::Gl::reflect) in the process.
    ///
    /// # Errors
    /// The compiler's errors in the texts, or how the process ended.
    #[cfg(feature = "gl")]
    pub fn reflect(
        &mut self,
        sources: &[(landfall_layout::Stage, &str)],
        limit: Duration,
    ) -> Result<super::reflection::Reflection, Failure> {
        let text = |&(stage, text): &(landfall_layout::Stage, &str)| {
            (stage.name().to_string(), text.to_string())
        };
        let request = Request::Reflect { sources: sources.iter().map(text).collect() };
        let reflected = self.session().and_then(|session| match session.ask(&request, limit)? {
            Reply::Reflected(reflection) => Ok(reflection),
            other => Err(unexpected(other)),
        });
        self.end_if_unusable(reflected)
    }

    /// Returns the process, a new one if the last has ended.
    fn session(&mut self) -> Result<&mut Session, Failure> {
        // Checked first, so that the job is not blamed for an earlier crash.
        let last = self
            // `Open` is answered at once by a process that is alive: its driver is open already.
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

    /// Drops the process if the failure makes it unusable.
    fn end_if_unusable<T>(&mut self, result: Result<T, Failure>) -> Result<T, Failure> {
        if let Err(failure) = &result {
            match failure.kind {
                FailureKind::Died | FailureKind::TimedOut => self.session = None,
                FailureKind::Missing | FailureKind::Refused | FailureKind::Unfit => {}
            }
        }
        result
    }
}

impl Backend for Subprocess {
    fn device(&self) -> &Device {
        &self.device
    }

    fn run(&mut self, job: &Job) -> Result<JobOutput, Failure> {
        let backend = self.device.backend;
        self.times = JobTimes::default();
        let ran = self.session().and_then(|session| session.run(job, backend));
        let (answer, times) = self.end_if_unusable(ran)?;
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
        (self.device.backend == BackendKind::Gl).then(|| Subprocess::reflect(self, texts, limit))
    }
}

/// Lists the devices of a driver, queried in a separate process.
///
/// # Errors
/// Fails if there is no driver or the process ended.
pub fn list(launch: &Launch) -> Result<Vec<BackendEntry>, Failure> {
    let mut session = Session::start(launch)?;
    match session.ask(&Request::List, launch.opening)? {
        Reply::Listed(found) => Ok(found),
        other => Err(unexpected(other)),
    }
}

/// A driver's process is killed as soon as it is not needed.
const ROLE: ChildRole = ChildRole { name: "driver process", works: true, parting: Duration::ZERO };

fn start(launch: &Launch) -> Result<Process<WireFrame>, Failure> {
    let mut command = Command::new(&launch.program);
    command
        .args(&launch.arguments)
        // Mesa's device selection layer complains without a desktop session.
        .env("NODEVICE_SELECT", "1")
        // A panic without a backtrace is one line, so that the last lines hold it.
        .env("RUST_BACKTRACE", "0")
        // Last, so that they override the others.
        .envs(launch.environment.iter().map(|(name, value)| (name, value)));
    Process::start(command, ROLE)
}

impl Message for WireFrame {
    fn write(&self, to: &mut ChildStdin) -> io::Result<()> {
        WireFrame::write(self, to)
    }

    fn read(from: &mut BufReader<ChildStdout>) -> io::Result<Option<WireFrame>> {
        WireFrame::read(from)
    }
}

impl Session {
    fn start(launch: &Launch) -> Result<Session, Failure> {
        Ok(Session { process: start(launch)?, modules: Vec::new(), next: 0 })
    }

    fn open(launch: &Launch) -> Result<(Session, Device), Failure> {
        let mut session = Session::start(launch)?;
        let device = session.device(launch)?;
        Ok((session, device))
    }

    fn device(&mut self, launch: &Launch) -> Result<Device, Failure> {
        let open = Request::Open { timed: launch.timed };
        match self.ask(&open, launch.opening)? {
            Reply::Opened(device) => Ok(device),
            other => Err(unexpected(other)),
        }
    }

    fn run(&mut self, job: &Job, backend: BackendKind) -> Result<(JobOutput, JobTimes), Failure> {
        // Not within the job, whose first module it may be that is forgotten for its second.
        let sent = job.stages.iter().filter(|code| code.spirv.is_none());
        let is_new = |module: &Arc<Module>| self.known(module).is_none();
        let is_any_new = sent.filter_map(|code| code.module.as_ref()).any(is_new);
        if self.modules.len() >= KEPT && is_any_new {
            self.modules.clear();
            self.process.send(WireFrame::new(&Request::Forget).map_err(unsendable)?);
        }
        let wire = WireJob::new(job, backend, |module| self.number(module)).map_err(unsendable)?;
        match self.ask(&Request::Run(wire), job.limit)? {
            Reply::Ran { buffers, pixels, times } => Ok((Reply::answer(buffers, &pixels), times)),
            other => Err(unexpected(other)),
        }
    }

    fn ask(&mut self, request: &Request, limit: Duration) -> Result<Reply, Failure> {
        self.process.send(WireFrame::new(request).map_err(unsendable)?);
        self.process.receive(limit)?.value().map_err(garbled)
    }

    /// Returns the server's number of a module that was sent.
    fn known(&self, module: &Arc<Module>) -> Option<u64> {
        // By identity: a module that is shared does not change, and to compare it would take as
        // long as to send it.
        let known = self.modules.iter().find(|known| Arc::ptr_eq(&known.0, module));
        known.map(|(_, id)| *id)
    }

    /// Returns the server's number of a module, and sends the module if it is new.
    fn number(&mut self, module: &Arc<Module>) -> io::Result<u64> {
        if let Some(id) = self.known(module) {
            return Ok(id);
        }
        let id = self.next;
        self.next += 1;
        let ir = Blob(serialised(module)?);
        // Messages are read in the order in which they were sent: it is there before the job that
        // names it.
        self.process.send(WireFrame::new(&Request::Module { id, ir })?);
        self.modules.push((Arc::clone(module), id));
        Ok(id)
    }
}

#[cfg(feature = "gpu")]
fn serialised(module: &Module) -> io::Result<Vec<u8>> {
    ir::write(module)
}

#[cfg(not(feature = "gpu"))]
fn serialised(_: &Module) -> io::Result<Vec<u8>> {
    Err(frame::invalid("this build lacks the feature `gpu`"))
}

fn unexpected(reply: Reply) -> Failure {
    match reply {
        Reply::Failed(failure) => failure,
        other => Failure::died(
            "the driver process sent a reply that does not fit the request",
            format!("{other:?}"),
        ),
    }
}

fn garbled(cause: io::Error) -> Failure {
    Failure::died("a message of the driver process cannot be decoded", cause.to_string())
}

fn unsendable(cause: io::Error) -> Failure {
    Failure::refused("the job cannot be sent to the driver process", cause.to_string())
}
