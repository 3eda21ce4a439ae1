//! A device with its ears open: nothing it says may end the process.

use std::sync::{Arc, Mutex, PoisonError};

use wgpu::{Adapter, Device, DeviceDescriptor, ErrorFilter, ExperimentalFeatures, Queue};

use super::adapter::WANTED;
use crate::backend::Failure;

/// An open device.
pub(super) struct Open {
    pub(super) device: Device,
    pub(super) queue: Queue,
    said: Arc<Mutex<Said>>,
}

/// What a device has said that belonged to no call.
#[derive(Default)]
struct Said {
    /// Why it is gone.
    lost: Option<String>,
    errors: Vec<String>,
}

impl Open {
    /// Opens an adapter with all it has.
    pub(super) fn new(adapter: &Adapter) -> Result<Open, Failure> {
        let descriptor = DeviceDescriptor {
            label: Some("landfall"),
            required_features: adapter.features() & WANTED,
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
        let said = Arc::new(Mutex::new(Said::default()));
        let heard = Arc::clone(&said);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            lock(&heard).errors.push(error.to_string());
        }));
        let heard = Arc::clone(&said);
        device.set_device_lost_callback(move |reason, message| {
            lock(&heard).lost = Some(format!("{reason:?}: {message}"));
        });
        Ok(Open { device, queue, said })
    }

    /// Calls it, and makes a failure of any error it reports meanwhile.
    pub(super) fn hear<T>(
        &self,
        doing: &str,
        call: impl FnOnce() -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let filters = [ErrorFilter::Internal, ErrorFilter::OutOfMemory, ErrorFilter::Validation];
        let mut scopes = filters.map(|filter| Some(self.device.push_error_scope(filter)));
        let result = call();
        let mut errors = Vec::new();
        // The scope pushed last is popped first.
        for scope in scopes.iter_mut().rev() {
            let scope = scope.take().expect("each scope is popped once");
            errors.extend(pollster::block_on(scope.pop()));
        }
        self.alive()?;
        // What was called may have stopped on account of the error; the error says more.
        match errors.first() {
            Some(error) => Err(Failure::refused(
                format!("wgpu refuses {doing}: {}", first_reason(&error.to_string())),
                error.to_string(),
            )),
            None => result,
        }
    }

    /// Whether the device is still there.
    pub(super) fn alive(&self) -> Result<(), Failure> {
        let mut said = lock(&self.said);
        let errors = std::mem::take(&mut said.errors);
        match &said.lost {
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

/// The innermost of the reasons wgpu lists, one a line, outermost first.
fn first_reason(description: &str) -> String {
    let mut lines = description.lines().map(str::trim).filter(|line| !line.is_empty());
    lines.next_back().unwrap_or("it says no more").to_string()
}

fn lock(said: &Mutex<Said>) -> std::sync::MutexGuard<'_, Said> {
    said.lock().unwrap_or_else(PoisonError::into_inner)
}
