//! The web backends: WebGL 2 and WebGPU of a Chromium without a window.
//!
//! WebGL runs GLSL ES 3.00 and WebGPU runs WGSL, both as text, through ANGLE and Tint. One browser
//! serves both; it is a process of its own, started by [`open`] and once more after it has died,
//! and ends with its last [`Web`]. Shader text reaches its page as data only.

mod browser;
mod wire;

use std::cell::RefCell;
use std::ffi::OsString;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Duration;

use super::devices::{BackendEntry, Limits};
use super::reflection::Reflection;
use crate::backend::{Backend, BackendKind, Device, Failure, FailureKind, Job, JobOutput};
use browser::Browser;
use landfall_layout::source::Stage;
use wire::{PageReply, WebJob, WebTexts};

/// The names of Chromium and its kin on the path, the preferred first.
pub const PROGRAMS: [&str; 5] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];

/// How a browser is started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Launch {
    /// Chromium, or a browser made of it.
    pub program: PathBuf,
    /// Arguments in addition to Landfall's own, such as `--use-angle=gl-egl`.
    pub arguments: Vec<OsString>,
    /// The directory in which a directory for the browser's profile is made, and removed with it.
    pub scratch: PathBuf,
    /// The time limit for opening the browser, and for the answers about its devices.
    pub opening: Duration,
}

impl Launch {
    /// Starts a browser whose profile is below `scratch`.
    pub fn new(program: impl Into<PathBuf>, scratch: impl Into<PathBuf>) -> Launch {
        Launch {
            program: program.into(),
            arguments: Vec::new(),
            scratch: scratch.into(),
            opening: Duration::from_secs(60),
        }
    }
}

/// One API of a browser.
pub struct Web {
    shared: Rc<RefCell<Shared>>,
    device: Device,
    limits: Limits,
}

/// A browser, started again after it has died.
struct Shared {
    launch: Launch,
    browser: Option<Browser>,
}

/// The APIs of a browser, available or missing.
pub struct Apis {
    /// [`BackendKind::WebGl`].
    pub webgl: Result<Web, Failure>,
    /// [`BackendKind::WebGpu`].
    pub webgpu: Result<Web, Failure>,
}

/// Starts a browser and opens both APIs.
///
/// # Errors
/// Fails if the browser does not start.
pub fn open(launch: Launch) -> Result<Apis, Failure> {
    let browser = Browser::start(&launch).map_err(opening)?;
    let version = browser.version.clone();
    let shared = Rc::new(RefCell::new(Shared { launch, browser: Some(browser) }));
    let api = |backend| Web::open(&shared, backend, &version);
    Ok(Apis { webgl: api(BackendKind::WebGl), webgpu: api(BackendKind::WebGpu) })
}

/// Lists both APIs of a browser, available or missing.
///
/// # Errors
/// Fails if the browser does not start.
pub fn list(launch: Launch) -> Result<Vec<BackendEntry>, Failure> {
    let Apis { webgl, webgpu } = open(launch)?;
    let entry = |backend, kind: &str, api: Result<Web, Failure>| BackendEntry {
        backend,
        kind: kind.to_string(),
        outcome: api.map(|web| (web.device.clone(), web.limits)),
    };
    Ok(vec![
        entry(BackendKind::WebGl, "webgl 2", webgl),
        entry(BackendKind::WebGpu, "webgpu", webgpu),
    ])
}

/// A browser that does not start is missing; the reason goes into the message.
fn opening(failure: Failure) -> Failure {
    Failure::missing(format!("the browser does not start: {}", failure.summary()), failure.log)
}

impl Web {
    fn open(
        shared: &Rc<RefCell<Shared>>,
        backend: BackendKind,
        version: &str,
    ) -> Result<Web, Failure> {
        let limit = shared.borrow().launch.opening;
        let reply = shared.borrow_mut().call("open", backend, &(), limit)?;
        let PageReply::Opened { adapter, software, limits } = reply else {
            return Err(unexpected(reply));
        };
        // The name and version of the browser, such as `Chrome/156.0.8078.79`.
        let (driver, version) = version.split_once('/').unwrap_or((version, ""));
        let device = Device {
            backend,
            adapter,
            driver: driver.to_string(),
            version: version.to_string(),
            software,
        };
        Ok(Web { shared: Rc::clone(shared), device, limits })
    }

    /// Returns the ID of the process that supervises the browser, if it runs.
    pub fn process(&self) -> Option<u32> {
        self.shared.borrow().browser.as_ref().map(Browser::process)
    }
}

impl Shared {
    /// Calls a function of the page.
    fn call(
        &mut self,
        function: &str,
        backend: BackendKind,
        argument: &impl serde::Serialize,
        limit: Duration,
    ) -> Result<PageReply, Failure> {
        let mut browser = match self.browser.take() {
            Some(browser) => browser,
            None => Browser::start(&self.launch)?,
        };
        let reply = browser.call(function, backend, argument, limit);
        let reply = reply.and_then(|reply| match reply {
            PageReply::Failed(failure) => Err(failure),
            reply => Ok(reply),
        });
        // A browser that died or hangs is not put back: it ends here, and the next call starts
        // another.
        let over = reply.as_ref().is_err_and(|failure| {
            matches!(failure.kind, FailureKind::Died | FailureKind::TimedOut)
        });
        if !over {
            self.browser = Some(browser);
        }
        reply
    }
}

impl Backend for Web {
    fn device(&self) -> &Device {
        &self.device
    }

    fn run(&mut self, job: &Job) -> Result<JobOutput, Failure> {
        let sent = WebJob::new(job, self.device.backend)?;
        let reply = self.shared.borrow_mut().call("run", self.device.backend, &sent, job.limit)?;
        match reply {
            PageReply::Ran { buffers, pixels } => Ok(wire::output(job, buffers, &pixels)),
            reply => Err(unexpected(reply)),
        }
    }

    fn reflect(
        &mut self,
        texts: &[(Stage, &str)],
        limit: Duration,
    ) -> Option<Result<Reflection, Failure>> {
        let sent = WebTexts::new(texts);
        let reply = self.shared.borrow_mut().call("reflect", self.device.backend, &sent, limit);
        Some(reply.and_then(|reply| match reply {
            PageReply::Reflected(reflection) => Ok(reflection),
            reply => Err(unexpected(reply)),
        }))
    }
}

fn unexpected(reply: PageReply) -> Failure {
    Failure::died("the page sent a reply that does not fit the request", format!("{reply:?}"))
}
