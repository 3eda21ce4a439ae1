//! The browser of the backends `webgl` and `webgpu`: found on the path, started without a window.

use landfall_exec::backend::devices::BackendEntry;
use landfall_exec::backend::{Backend, BackendKind, Failure};

/// A backend, opened or missing.
type Opened = (BackendKind, Result<Box<dyn Backend>, Failure>);

/// Starts the browser and opens both of its APIs.
#[cfg(feature = "web")]
pub fn open() -> [Opened; 2] {
    use landfall_exec::backend::web::{self, Web};

    let boxed = |web: Web| Box::new(web) as Box<dyn Backend>;
    // One browser has both APIs; if it does not start, both are missing for one reason.
    match launch().and_then(web::open) {
        Ok(apis) => [
            (BackendKind::WebGl, apis.webgl.map(boxed)),
            (BackendKind::WebGpu, apis.webgpu.map(boxed)),
        ],
        Err(failure) => {
            [(BackendKind::WebGl, Err(failure.clone())), (BackendKind::WebGpu, Err(failure))]
        }
    }
}

/// Lists both APIs of the browser, available or missing.
#[cfg(feature = "web")]
pub fn list() -> Vec<BackendEntry> {
    let missing = |failure: Failure| {
        [BackendKind::WebGl, BackendKind::WebGpu].map(|backend| BackendEntry {
            backend,
            kind: String::new(),
            outcome: Err(failure.clone()),
        })
    };
    let listed = launch().and_then(landfall_exec::backend::web::list);
    listed.unwrap_or_else(|failure| missing(failure).into())
}

#[cfg(feature = "web")]
fn launch() -> Result<landfall_exec::backend::web::Launch, Failure> {
    use landfall_exec::backend::web::{Launch, PROGRAMS};

    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut programs =
        PROGRAMS.iter().flat_map(|name| std::env::split_paths(&path).map(move |at| at.join(name)));
    let Some(program) = programs.find(|program| is_executable(program)) else {
        let names = PROGRAMS.join(", ");
        return Err(Failure::missing(format!("no browser is on the path: none of {names}"), ""));
    };
    Ok(Launch::new(program, std::env::temp_dir()))
}

#[cfg(all(feature = "web", unix))]
fn is_executable(program: &std::path::Path) -> bool {
    use std::os::unix::fs::PermissionsExt as _;

    std::fs::metadata(program)
        .is_ok_and(|about| about.is_file() && about.permissions().mode() & 0o111 != 0)
}

#[cfg(all(feature = "web", not(unix)))]
fn is_executable(program: &std::path::Path) -> bool {
    program.is_file()
}

#[cfg(not(feature = "web"))]
pub fn open() -> [Opened; 2] {
    [BackendKind::WebGl, BackendKind::WebGpu].map(|backend| {
        (backend, Err(Failure::missing("this landfall was built without the feature `web`", "")))
    })
}

#[cfg(not(feature = "web"))]
pub fn list() -> Vec<BackendEntry> {
    [BackendKind::WebGl, BackendKind::WebGpu].map(BackendEntry::not_built).into()
}
