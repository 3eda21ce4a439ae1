//! The readers a command asks: the evaluator here, each driver in a process of its own.

use landfall_exec::backend::{Failure, Reader};
use landfall_exec::harness::verify::report::Attendance;

use crate::args::ReaderName;

/// The readers that could be had, and who they are or why they are missing.
pub struct Readers {
    pub here: Vec<Box<dyn Reader>>,
    pub attendance: Vec<Attendance>,
}

/// The readers that are asked for, each once; all there are where none is named.
pub fn asked(names: &[ReaderName]) -> Vec<ReaderName> {
    let all = ReaderName::ALL.iter().copied();
    all.filter(|name| names.is_empty() || names.contains(name)).collect()
}

/// Opens readers by name; all there are where none is named.
pub fn open(names: &[ReaderName], adapter: Option<&str>) -> Readers {
    let mut readers = Readers { here: Vec::new(), attendance: Vec::new() };
    for name in asked(names) {
        match one(name, adapter) {
            Ok(reader) => {
                readers.attendance.push(Attendance::Here(reader.device().clone()));
                readers.here.push(reader);
            }
            Err(failure) => {
                readers.attendance.push(Attendance::Missing { reader: name.kind(), failure });
            }
        }
    }
    readers
}

/// Opens one reader.
pub fn one(name: ReaderName, adapter: Option<&str>) -> Result<Box<dyn Reader>, Failure> {
    opened(name, adapter, Timing::Off)
}

/// Opens one reader whose device times its jobs itself, where it can.
pub fn timed(name: ReaderName, adapter: Option<&str>) -> Result<Box<dyn Reader>, Failure> {
    opened(name, adapter, Timing::On)
}

/// Whether the device times its jobs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Timing {
    Off,
    On,
}

fn opened(
    name: ReaderName,
    adapter: Option<&str>,
    timing: Timing,
) -> Result<Box<dyn Reader>, Failure> {
    match name {
        ReaderName::Cpu => Ok(Box::new(landfall_exec::interp::Cpu::new(Default::default()))),
        ReaderName::Gl => gl(timing),
        ReaderName::Gpu => gpu(adapter, timing),
    }
}

#[cfg(feature = "gl")]
fn gl(timing: Timing) -> Result<Box<dyn Reader>, Failure> {
    remote(&landfall_exec::backend::subprocess::Behind::Gl, timing)
}

#[cfg(not(feature = "gl"))]
fn gl(_timing: Timing) -> Result<Box<dyn Reader>, Failure> {
    Err(Failure::missing("this landfall was built without the feature `gl`", ""))
}

#[cfg(feature = "gpu")]
fn gpu(adapter: Option<&str>, timing: Timing) -> Result<Box<dyn Reader>, Failure> {
    remote(&landfall_exec::backend::subprocess::Behind::Gpu(adapter.map(str::to_string)), timing)
}

#[cfg(not(feature = "gpu"))]
fn gpu(_adapter: Option<&str>, _timing: Timing) -> Result<Box<dyn Reader>, Failure> {
    Err(Failure::missing("this landfall was built without the feature `gpu`", ""))
}

#[cfg(any(feature = "gl", feature = "gpu"))]
fn remote(
    behind: &landfall_exec::backend::subprocess::Behind,
    timing: Timing,
) -> Result<Box<dyn Reader>, Failure> {
    use landfall_exec::backend::subprocess::{Launch, Remote};

    let program = std::env::current_exe().map_err(|cause| {
        let message = "the path of this program is not to be had, to start it again";
        Failure::missing(message, cause.to_string())
    })?;
    let launch = Launch { timed: timing == Timing::On, ..Launch::new(program, behind) };
    Ok(Box::new(Remote::open(launch)?))
}
