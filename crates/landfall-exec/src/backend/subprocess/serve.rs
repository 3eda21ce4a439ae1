//! The server, which loads the driver: requests from stdin, replies to stdout, until stdin ends.

#[cfg(not(all(feature = "gl", feature = "gpu")))]
use crate::backend::BackendKind;
use std::collections::HashMap;
use std::io::{self, BufReader};
use std::sync::{Arc, mpsc};
use std::thread;

use super::frame::{WireFrame, invalid};
use super::wire::{JobTimes, Reply, Request, stage};
use crate::backend::devices::BackendEntry;
use crate::backend::{Backend, Failure, Job, JobOutput};
use crate::processor;
use landfall_ir::Module;

/// The driver to load.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DriverKind {
    /// [`gl`](crate::backend::gl).
    Gl,
    /// [`gpu`](crate::backend::wgpu), with a part of the adapter's name.
    Gpu(Option<String>),
}

/// Stack size of the thread that runs jobs: naga and serde recurse for each level of a shader's
/// nesting. Only the used part is committed.
const STACK: usize = 256 << 20;

/// Runs jobs sent over stdin, with replies on stdout, until stdin ends.
///
/// A hanging driver would outlive its parent: when stdin ends, `on_stdin_end` is called on another
/// thread and should end the process.
///
/// # Errors
/// Fails if a message cannot be read or written.
pub fn serve(
    driver_kind: &DriverKind,
    on_stdin_end: impl FnOnce() + Send + 'static,
) -> io::Result<()> {
    // The end of stdin has to be noticed while a driver hangs: one thread reads, another runs the
    // jobs.
    let (questions, asked) = mpsc::channel();
    let reads = move || {
        let mut stdin = BufReader::new(io::stdin());
        loop {
            match WireFrame::read(&mut stdin) {
                Ok(None) => break,
                frame => {
                    // An error of reading is passed on, and is the last.
                    let over = frame.is_err();
                    if questions.send(frame).is_err() || over {
                        break;
                    }
                }
            }
        }
        // Ends the thread of the jobs.
        drop(questions);
        on_stdin_end();
    };
    thread::Builder::new().spawn(reads)?;
    let driver_kind = driver_kind.clone();
    let runs = thread::Builder::new().stack_size(STACK).spawn(move || run(&driver_kind, &asked))?;
    match runs.join() {
        Ok(done) => done,
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

fn run(
    driver_kind: &DriverKind,
    asked: &mpsc::Receiver<io::Result<Option<WireFrame>>>,
) -> io::Result<()> {
    let mut server = Server { driver_kind, driver: None, timed: false, modules: HashMap::new() };
    while let Ok(frame) = asked.recv() {
        let Some(frame) = frame? else { break };
        if let Some(reply) = server.reply(frame.value()?)? {
            WireFrame::new(&reply)?.write(&mut io::stdout().lock())?;
        }
    }
    Ok(())
}

enum Driver {
    #[cfg(feature = "gl")]
    Gl(crate::backend::gl::Gl),
    #[cfg(feature = "gpu")]
    Gpu(Box<crate::backend::wgpu::Gpu>),
}

struct Server<'b> {
    driver_kind: &'b DriverKind,
    driver: Option<Driver>,
    timed: bool,
    modules: HashMap<u64, Arc<Module>>,
}

impl Server<'_> {
    fn reply(&mut self, request: Request) -> io::Result<Option<Reply>> {
        let reply = match request {
            Request::Open { timed } => {
                self.timed = timed;
                self.backend().map(|backend| Reply::Opened(backend.device().clone()))
            }
            Request::List => list(self.driver_kind).map(Reply::Listed),
            Request::Module { id, ir } => {
                self.modules.insert(id, Arc::new(module(&ir.0)?));
                return Ok(None);
            }
            Request::Forget => {
                self.modules.clear();
                return Ok(None);
            }
            Request::Run(job) => {
                let job = job.job(|id| self.modules.get(&id).cloned())?;
                self.run(&job).map(|(answer, times)| Reply::of_answer(answer, times))
            }
            Request::Reflect { sources } => {
                let mut staged = Vec::with_capacity(sources.len());
                for (name, text) in &sources {
                    staged.push((stage(name)?, text.as_str()));
                }
                self.reflect(&staged)
            }
        };
        Ok(Some(reply.unwrap_or_else(Reply::Failed)))
    }

    fn run(&mut self, job: &Job) -> Result<(JobOutput, JobTimes), Failure> {
        let backend = self.backend()?;
        // Of all threads of this process: drivers have threads of their own.
        let before = processor::time();
        let answer = backend.run(job)?;
        let processor = processor::time().zip(before).map(|(now, then)| now.saturating_sub(then));
        Ok((answer, JobTimes { device: backend.device_time(), processor }))
    }

    fn backend(&mut self) -> Result<&mut dyn Backend, Failure> {
        // A driver that could not be opened is tried again for the next job.
        if self.driver.is_none() {
            self.driver = Some(open(self.driver_kind, self.timed)?);
        }
        match self.driver.as_mut().expect("it has just been opened") {
            #[cfg(feature = "gl")]
            Driver::Gl(gl) => Ok(gl),
            #[cfg(feature = "gpu")]
            Driver::Gpu(gpu) => Ok(&mut **gpu),
        }
    }

    #[cfg(feature = "gl")]
    fn reflect(&mut self, sources: &[(landfall_layout::Stage, &str)]) -> Result<Reply, Failure> {
        self.backend()?;
        match self.driver.as_mut() {
            Some(Driver::Gl(gl)) => gl.reflect(sources).map(Reply::Reflected),
            #[cfg(feature = "gpu")]
            Some(Driver::Gpu(_)) => Err(Failure::refused(
                "only OpenGL reports the offsets of uniforms",
                "use the backend `gl`",
            )),
            None => Err(Failure::died("the driver was not opened", "")),
        }
    }

    #[cfg(not(feature = "gl"))]
    fn reflect(&mut self, _: &[(landfall_layout::Stage, &str)]) -> Result<Reply, Failure> {
        Err(absent(BackendKind::Gl))
    }
}

/// Opens a driver; with `timed`, its device times jobs if it can.
#[cfg_attr(not(feature = "gpu"), expect(unused_variables, reason = "only wgpu times jobs"))]
fn open(driver_kind: &DriverKind, timed: bool) -> Result<Driver, Failure> {
    match driver_kind {
        #[cfg(feature = "gl")]
        DriverKind::Gl => crate::backend::gl::Gl::open().map(Driver::Gl),
        #[cfg(not(feature = "gl"))]
        DriverKind::Gl => Err(absent(BackendKind::Gl)),
        #[cfg(feature = "gpu")]
        DriverKind::Gpu(adapter) => {
            let choice = crate::backend::wgpu::AdapterChoice { adapter: adapter.clone() };
            let gpu = crate::backend::wgpu::Gpu::open(&choice)?;
            Ok(Driver::Gpu(Box::new(if timed { gpu.timed() } else { gpu })))
        }
        #[cfg(not(feature = "gpu"))]
        DriverKind::Gpu(_) => Err(absent(BackendKind::Gpu)),
    }
}

fn list(driver_kind: &DriverKind) -> Result<Vec<BackendEntry>, Failure> {
    match driver_kind {
        #[cfg(feature = "gl")]
        DriverKind::Gl => crate::backend::gl::Gl::list(),
        #[cfg(not(feature = "gl"))]
        DriverKind::Gl => Err(absent(BackendKind::Gl)),
        #[cfg(feature = "gpu")]
        DriverKind::Gpu(_) => Ok(crate::backend::wgpu::Gpu::list()),
        #[cfg(not(feature = "gpu"))]
        DriverKind::Gpu(_) => Err(absent(BackendKind::Gpu)),
    }
}

#[cfg(feature = "gpu")]
fn module(ir: &[u8]) -> io::Result<Module> {
    super::ir::read(ir)
        .map_err(|e| invalid(&format!("the shader module in the message cannot be decoded: {e}")))
}

#[cfg(not(feature = "gpu"))]
fn module(_: &[u8]) -> io::Result<Module> {
    Err(invalid("this build lacks the feature `gpu`"))
}

#[cfg(not(all(feature = "gl", feature = "gpu")))]
fn absent(backend: BackendKind) -> Failure {
    match BackendEntry::not_built(backend).outcome {
        Err(failure) => failure,
        Ok(_) => unreachable!("what was not built is missing"),
    }
}
