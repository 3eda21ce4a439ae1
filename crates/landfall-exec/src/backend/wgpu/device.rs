//! An open device whose errors are collected, so that none ends the process.

use std::sync::{Arc, Mutex, PoisonError};

use wgpu::{Adapter, Device, DeviceDescriptor, ErrorFilter, ExperimentalFeatures, Queue};

use super::adapter::WANTED;
use crate::backend::Failure;

pub(super) struct OpenDevice {
    pub(super) device: Device,
    pub(super) queue: Queue,
    reported: Arc<Mutex<Reported>>,
}

/// Errors that the device reported outside any call.
#[derive(Default)]
struct Reported {
    /// The reason why the device is lost.
    lost: Option<String>,
    errors: Vec<String>,
}

impl OpenDevice {
    /// Opens an adapter with all its wanted features.
    pub(super) fn new(adapter: &Adapter) -> Result<OpenDevice, Failure> {
        let descriptor = DeviceDescriptor {
            label: Some("landfall"),
            required_features: adapter.features() & WANTED,
            // The adapter's own: WebGPU's defaults are lower.
            required_limits: adapter.limits(),
            experimental_features: ExperimentalFeatures::disabled(),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            trace: wgpu::Trace::Off,
        };
        let opened = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = opened.map_err(|cause| {
            let name = adapter.get_info().name;
            Failure::missing(format!("the adapter `{name}` does not open"), cause.to_string())
        })?;
        let reported = Arc::new(Mutex::new(Reported::default()));
        let recorder = Arc::clone(&reported);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            lock(&recorder).errors.push(error.to_string());
        }));
        let recorder = Arc::clone(&reported);
        device.set_device_lost_callback(move |reason, message| {
            lock(&recorder).lost = Some(format!("{reason:?}: {message}"));
        });
        Ok(OpenDevice { device, queue, reported })
    }

    /// Runs `call`, and returns a failure if the device reports an error during it.
    pub(super) fn checked<T>(
        &self,
        doing: &str,
        call: impl FnOnce() -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        // A scope catches one kind of error; WebGPU has three.
        let filters = [ErrorFilter::Internal, ErrorFilter::OutOfMemory, ErrorFilter::Validation];
        let mut scopes = filters.map(|filter| Some(self.device.push_error_scope(filter)));
        let result = call();
        let mut errors = Vec::new();
        // Error scopes are popped in reverse order.
        for scope in scopes.iter_mut().rev() {
            let scope = scope.take().expect("each scope is popped once");
            errors.extend(pollster::block_on(scope.pop()));
        }
        self.alive()?;
        // The call may have failed because of the error, which explains more.
        match errors.first() {
            Some(error) => Err(Failure::refused(
                format!("wgpu rejects {doing}: {}", first_reason(&error.to_string())),
                error.to_string(),
            )),
            None => result,
        }
    }

    /// Fails if the device is lost or has reported errors.
    pub(super) fn alive(&self) -> Result<(), Failure> {
        let mut reported = lock(&self.reported);
        let errors = std::mem::take(&mut reported.errors);
        match &reported.lost {
            Some(lost) => {
                let log = [vec![lost.clone()], errors].concat().join("\n");
                Err(Failure::died("the device is lost", log))
            }
            None if !errors.is_empty() => {
                Err(Failure::refused("wgpu reports an error", errors.join("\n")))
            }
            None => Ok(()),
        }
    }
}

/// Returns the innermost of wgpu's reasons, which it lists one a line, outermost first.
fn first_reason(description: &str) -> String {
    let mut lines = description.lines().map(str::trim).filter(|line| !line.is_empty());
    lines.next_back().unwrap_or("no reason given").to_string()
}

fn lock(reported: &Mutex<Reported>) -> std::sync::MutexGuard<'_, Reported> {
    reported.lock().unwrap_or_else(PoisonError::into_inner)
}
