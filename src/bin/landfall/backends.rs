//! Opens backends: the interpreter in this process, each driver and the browser in its own.

use std::panic::resume_unwind;
use std::thread;

use landfall_exec::backend::{Backend, BackendKind, Device, Failure};
use landfall_exec::harness::verify::report::BackendStatus;

use crate::args::{BackendName, VerifierName};

/// The available backends, and the status of every requested one.
pub struct Backends {
    pub here: Vec<Box<dyn Backend>>,
    pub statuses: Vec<BackendStatus>,
}

/// The named backends without duplicates; all if none is named.
pub fn requested(names: &[BackendName]) -> Vec<BackendName> {
    let all = BackendName::ALL.iter().copied();
    all.filter(|name| names.is_empty() || names.contains(name)).collect()
}

/// Opens the backends of `verify` by name; if none is named all, the browser only where it is
/// required.
pub fn open(names: &[VerifierName], required: &[VerifierName], adapter: Option<&str>) -> Backends {
    let mut backends = Backends { here: Vec::new(), statuses: Vec::new() };
    let is_named = |name| names.contains(&name);
    let is_wanted = |name: &BackendName| {
        let as_verifier = match name {
            BackendName::Cpu => VerifierName::Cpu,
            BackendName::Gl => VerifierName::Gl,
            BackendName::Gpu => VerifierName::Gpu,
        };
        names.is_empty() || is_named(as_verifier)
    };
    let wanted: Vec<BackendName> = BackendName::ALL.into_iter().filter(is_wanted).collect();
    let open = |name| open_backend(name, adapter, JobPurpose::FewInvocations);
    // Each driver has a process of its own, which takes as long to start as many probes to run.
    thread::scope(|scope| {
        let opening: Vec<_> = wanted
            .iter()
            .map(|&name| (name, thread::Builder::new().spawn_scoped(scope, move || open(name))))
            .collect();
        // Joined in the order of the backends, whichever was opened first.
        for (name, running) in opening {
            let opened = match running {
                Ok(running) => running.join().unwrap_or_else(|panic| resume_unwind(panic)),
                // Where no thread can be started, one is opened after the other.
                // A panic of the opening is a fault of this program and goes on.
                Err(_) => open(name),
            };
            backends.add(name.kind(), opened.map(|backend| backend as Box<dyn Backend>));
        }
    });
    let browser = VerifierName::Web;
    if is_named(browser) || names.is_empty() && required.contains(&browser) {
        for (backend, opened) in crate::browser::open() {
            backends.add(backend, opened);
        }
    }
    backends
}

impl Backends {
    /// Whether these are the same devices.
    pub fn are_on(&self, statuses: &[BackendStatus]) -> bool {
        fn device(status: &BackendStatus) -> Option<&Device> {
            match status {
                BackendStatus::Here(device) => Some(device),
                BackendStatus::Missing { .. } => None,
            }
        }
        self.statuses.iter().map(device).eq(statuses.iter().map(device))
    }

    fn add(&mut self, backend: BackendKind, opened: Result<Box<dyn Backend>, Failure>) {
        self.statuses.push(match opened {
            Ok(opened) => {
                let status = BackendStatus::Here(opened.device().clone());
                self.here.push(opened);
                status
            }
            Err(failure) => BackendStatus::Missing { backend, failure },
        });
    }
}

pub fn open_one(name: BackendName, adapter: Option<&str>) -> Result<Box<dyn Backend>, Failure> {
    Ok(open_backend(name, adapter, JobPurpose::Results)?)
}

/// Opens one backend with timing by the device, if it can.
pub fn timed(name: BackendName, adapter: Option<&str>) -> Result<Box<dyn Backend>, Failure> {
    Ok(open_backend(name, adapter, JobPurpose::Times)?)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum JobPurpose {
    /// Results of a few invocations: compiling takes longer than running.
    FewInvocations,
    Results,
    /// Times, by the clock of the device if it has one.
    Times,
}

fn open_backend(
    name: BackendName,
    adapter: Option<&str>,
    purpose: JobPurpose,
) -> Result<Box<dyn Backend + Send>, Failure> {
    match name {
        BackendName::Cpu => Ok(Box::new(landfall_interp::Cpu::new(Default::default()))),
        BackendName::Gl => gl(purpose),
        BackendName::Gpu => gpu(adapter, purpose),
    }
}

#[cfg(feature = "gl")]
fn gl(purpose: JobPurpose) -> Result<Box<dyn Backend + Send>, Failure> {
    remote(&landfall_exec::backend::subprocess::DriverKind::Gl, purpose)
}

#[cfg(not(feature = "gl"))]
fn gl(_purpose: JobPurpose) -> Result<Box<dyn Backend + Send>, Failure> {
    Err(Failure::missing("this landfall was built without the feature `gl`", ""))
}

#[cfg(feature = "gpu")]
fn gpu(adapter: Option<&str>, purpose: JobPurpose) -> Result<Box<dyn Backend + Send>, Failure> {
    remote(
        &landfall_exec::backend::subprocess::DriverKind::Gpu(adapter.map(str::to_string)),
        purpose,
    )
}

#[cfg(not(feature = "gpu"))]
fn gpu(_adapter: Option<&str>, _purpose: JobPurpose) -> Result<Box<dyn Backend + Send>, Failure> {
    Err(Failure::missing("this landfall was built without the feature `gpu`", ""))
}

#[cfg(any(feature = "gl", feature = "gpu"))]
fn remote(
    driver_kind: &landfall_exec::backend::subprocess::DriverKind,
    purpose: JobPurpose,
) -> Result<Box<dyn Backend + Send>, Failure> {
    use landfall_exec::backend::subprocess::{Launch, Subprocess};

    let program = std::env::current_exe().map_err(|cause| {
        let message = "the path of the landfall executable is unknown; drivers run in a copy of it";
        Failure::missing(message, cause.to_string())
    })?;
    let launch = Launch::new(program, driver_kind);
    let launch = match purpose {
        JobPurpose::FewInvocations => launch.for_few_invocations(),
        JobPurpose::Results => launch,
        JobPurpose::Times => Launch { timed: true, ..launch },
    };
    Ok(Box::new(Subprocess::open(launch)?))
}
