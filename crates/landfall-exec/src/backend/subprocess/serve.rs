//! The side that loads the driver: questions from stdin, replies to stdout, until stdin ends.

#[cfg(not(all(feature = "gl", feature = "gpu")))]
use crate::backend::BackendKind;
use std::collections::HashMap;
use std::io::{self, BufReader};
use std::sync::{Arc, mpsc};
use std::thread;

use super::frame::{Frame, invalid};
use super::wire::{Ask, Reply, Times, WireDevice, WireFound, stage};
use crate::backend::devices::Found;
use crate::backend::{Answer, Failure, Job, Reader};
use crate::processor;
use landfall_ir::Module;

/// Which driver is loaded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Behind {
    /// [`gl`](crate::backend::gl).
    Gl,
    /// [`gpu`](crate::backend::wgpu), and part of the name of the adapter it takes.
    Gpu(Option<String>),
}

/// Stack of the thread that runs jobs: naga and serde call themselves for each level of a
/// shader's nesting. Only what is used of it is ever memory.
const STACK: usize = 256 << 20;

/// Runs jobs for the process at the other end of stdin and stdout, until stdin ends.
///
/// A driver that hangs would hold on when that process is gone: `alone` is called then, on
/// another thread, and should end the process.
///
/// # Errors
/// Why a message cannot be read or written.
pub fn serve(behind: &Behind, alone: impl FnOnce() + Send + 'static) -> io::Result<()> {
    let (questions, asked) = mpsc::channel();
    let reads = move || {
        let mut stdin = BufReader::new(io::stdin());
        loop {
            match Frame::read(&mut stdin) {
                Ok(None) => break,
                frame => {
                    let over = frame.is_err();
                    if questions.send(frame).is_err() || over {
                        break;
                    }
                }
            }
        }
        drop(questions);
        alone();
    };
    thread::Builder::new().spawn(reads)?;
    let behind = behind.clone();
    let runs = thread::Builder::new().stack_size(STACK).spawn(move || run(&behind, &asked))?;
    match runs.join() {
        Ok(done) => done,
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

fn run(behind: &Behind, asked: &mpsc::Receiver<io::Result<Option<Frame>>>) -> io::Result<()> {
    let mut server = Server { behind, driver: None, timed: false, modules: HashMap::new() };
    while let Ok(frame) = asked.recv() {
        let Some(mut frame) = frame? else { break };
        let mut out = Frame::default();
        let ask = frame.header()?;
        if let Some(reply) = server.reply(ask, &mut frame, &mut out)? {
            out.with(&reply)?.write(&mut io::stdout().lock())?;
        }
    }
    Ok(())
}

/// A driver that has been opened.
enum Driver {
    #[cfg(feature = "gl")]
    Gl(crate::backend::gl::Gl),
    #[cfg(feature = "gpu")]
    Gpu(Box<crate::backend::wgpu::Gpu>),
}

struct Server<'b> {
    behind: &'b Behind,
    driver: Option<Driver>,
    timed: bool,
    modules: HashMap<u64, Arc<Module>>,
}

impl Server<'_> {
    fn reply(&mut self, ask: Ask, frame: &mut Frame, out: &mut Frame) -> io::Result<Option<Reply>> {
        let reply = match ask {
            Ask::Open { timed } => {
                self.timed = timed;
                self.reader().map(|reader| Reply::Opened(WireDevice::from(reader.device())))
            }
            Ask::List => list(self.behind)
                .map(|found| Reply::Listed(found.into_iter().map(WireFound::from).collect())),
            Ask::Module { id, json } => {
                self.modules.insert(id, Arc::new(module(&frame.take(json)?)?));
                return Ok(None);
            }
            Ask::Forget => {
                self.modules.clear();
                return Ok(None);
            }
            Ask::Run(job) => {
                let job = job.job(frame, |id| self.modules.get(&id).cloned())?;
                self.run(&job).map(|(answer, times)| Reply::of_answer(answer, times, out))
            }
            Ask::Reflect { sources } => {
                let mut staged = Vec::with_capacity(sources.len());
                for (name, text) in &sources {
                    staged.push((stage(name)?, text.as_str()));
                }
                self.reflect(&staged)
            }
        };
        Ok(Some(reply.unwrap_or_else(Reply::Failed)))
    }

    fn run(&mut self, job: &Job) -> Result<(Answer, Times), Failure> {
        let reader = self.reader()?;
        let before = processor::time();
        let answer = reader.run(job)?;
        let processor = processor::time().zip(before).map(|(now, then)| now.saturating_sub(then));
        Ok((answer, Times { device: reader.device_time(), processor }))
    }

    fn reader(&mut self) -> Result<&mut dyn Reader, Failure> {
        if self.driver.is_none() {
            self.driver = Some(open(self.behind, self.timed)?);
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
        self.reader()?;
        match self.driver.as_mut() {
            Some(Driver::Gl(gl)) => gl.reflect(sources).map(Reply::Reflected),
            #[cfg(feature = "gpu")]
            Some(Driver::Gpu(_)) => Err(Failure::refused("only OpenGL says what is active", "")),
            None => Err(Failure::died("the driver was not opened", "")),
        }
    }

    #[cfg(not(feature = "gl"))]
    fn reflect(&mut self, _: &[(landfall_layout::Stage, &str)]) -> Result<Reply, Failure> {
        Err(absent(BackendKind::Gl))
    }
}

/// Opens a driver; `timed` has its device time jobs, where it can.
fn open(behind: &Behind, timed: bool) -> Result<Driver, Failure> {
    match behind {
        #[cfg(feature = "gl")]
        Behind::Gl => crate::backend::gl::Gl::open().map(Driver::Gl),
        #[cfg(not(feature = "gl"))]
        Behind::Gl => Err(absent(BackendKind::Gl)),
        #[cfg(feature = "gpu")]
        Behind::Gpu(adapter) => {
            let choice = crate::backend::wgpu::Choice { adapter: adapter.clone() };
            let gpu = crate::backend::wgpu::Gpu::open(&choice)?;
            Ok(Driver::Gpu(Box::new(if timed { gpu.timed() } else { gpu })))
        }
        #[cfg(not(feature = "gpu"))]
        Behind::Gpu(_) => Err(absent(BackendKind::Gpu)),
    }
}

fn list(behind: &Behind) -> Result<Vec<Found>, Failure> {
    match behind {
        #[cfg(feature = "gl")]
        Behind::Gl => crate::backend::gl::Gl::list(),
        #[cfg(not(feature = "gl"))]
        Behind::Gl => Err(absent(BackendKind::Gl)),
        #[cfg(feature = "gpu")]
        Behind::Gpu(_) => Ok(crate::backend::wgpu::Gpu::list()),
        #[cfg(not(feature = "gpu"))]
        Behind::Gpu(_) => Err(absent(BackendKind::Gpu)),
    }
}

#[cfg(feature = "gpu")]
fn module(json: &[u8]) -> io::Result<Module> {
    super::ir::read(json).map_err(|e| invalid(&format!("a module cannot be read: {e}")))
}

#[cfg(not(feature = "gpu"))]
fn module(_: &[u8]) -> io::Result<Module> {
    Err(invalid("this build runs no modules"))
}

#[cfg(not(all(feature = "gl", feature = "gpu")))]
fn absent(reader: BackendKind) -> Failure {
    match Found::not_built(reader).outcome {
        Err(failure) => failure,
        Ok(_) => unreachable!("what was not built is missing"),
    }
}
