//! An OpenGL context without a window: EGL loaded at run time, without X or `DISPLAY`.
//!
//! The other files of this directory use its current context, entry points and limits.

#![allow(unsafe_code, reason = "every call into EGL and OpenGL is unsafe")]

use crate::backend::BackendKind;
use std::ffi::c_void;
use std::rc::Rc;
use std::sync::{Arc, Mutex, PoisonError};

use glow::HasContext as _;
use khronos_egl as egl;

use super::interface::{ProgramInterface, Separable};
use crate::backend::devices::Limits;
use crate::backend::{Device, Failure};
use landfall_layout::named;

named! {
    /// The kinds of OpenGL context.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum ContextKind {
        /// Desktop, core profile: `#version 140` and later.
        Core = "core",
        /// Desktop, compatibility profile, which keeps what core removed: `#version 110` to `130`.
        Compat = "compat",
        /// OpenGL ES.
        Es = "es",
    }

    const ALL;
}

impl ContextKind {
    /// Returns the versions to try, highest first; EGL rejects those that are not available.
    fn versions(self) -> &'static [(i32, i32)] {
        match self {
            ContextKind::Core | ContextKind::Compat => {
                // Profiles exist from OpenGL 3.2 on.
                &[(4, 6), (4, 5), (4, 4), (4, 3), (4, 2), (4, 1), (4, 0), (3, 3), (3, 2)]
            }
            ContextKind::Es => &[(3, 2), (3, 1), (3, 0)],
        }
    }
}

/// EGL and its display, shared by the contexts. It is never terminated, since other code in this
/// process may have opened the same display.
pub(super) struct Display {
    egl: egl::DynamicInstance<egl::EGL1_5>,
    display: egl::Display,
}

/// `EGL_PLATFORM_SURFACELESS_MESA`, of `EGL_MESA_platform_surfaceless`.
const PLATFORM_SURFACELESS: egl::Enum = 0x31DD;

/// Returns how to get EGL on an operating system, by its name in `std::env::consts::OS`.
fn provider(system: &str) -> &'static str {
    match system {
        "windows" => {
            "Windows has WGL, which landfall does not use: put `libEGL.dll` and \
             `libGLESv2.dll` of ANGLE on PATH, for ES shaders, or use `--backend gpu`"
        }
        "macos" => {
            "macOS has CGL, which landfall does not use: put `libEGL.dylib` and \
             `libGLESv2.dylib` of ANGLE on DYLD_LIBRARY_PATH, for ES shaders, or use \
             `--backend gpu`"
        }
        _ => "the Debian packages `libegl1` and `libgl1-mesa-dri` provide a software driver",
    }
}

/// The failure of a system without an OpenGL driver.
fn no_driver(why: &str, cause: String) -> Failure {
    let provider = provider(std::env::consts::OS);
    Failure::missing(format!("no OpenGL driver: {why}; {provider}"), cause)
}

impl Display {
    /// Loads libEGL and opens the surfaceless display, or else the default one.
    pub(super) fn open() -> Result<Rc<Display>, Failure> {
        // SAFETY: loading libEGL runs its initialisers, which is what it is for.
        let egl = unsafe { egl::DynamicInstance::<egl::EGL1_5>::load_required() }
            .map_err(|cause| no_driver("libEGL 1.5 cannot be loaded", cause.to_string()))?;
        // SAFETY: the surfaceless platform takes no native display.
        let surfaceless = unsafe {
            let nothing = [egl::ATTRIB_NONE];
            egl.get_platform_display(PLATFORM_SURFACELESS, egl::DEFAULT_DISPLAY, &nothing)
        };
        let surfaceless = surfaceless.and_then(|display| {
            egl.initialize(display)?;
            Ok(display)
        });
        let cause = match surfaceless {
            Ok(display) => return Ok(Rc::new(Display { egl, display })),
            Err(cause) => cause,
        };
        // SAFETY: the default display needs no native one.
        let usual = unsafe { egl.get_display(egl::DEFAULT_DISPLAY) };
        match usual.map(|display| egl.initialize(display).map(|_| display)) {
            Some(Ok(display)) => Ok(Rc::new(Display { egl, display })),
            other => {
                let other = match other {
                    Some(Err(cause)) => cause.to_string(),
                    Some(Ok(_)) | None => "EGL has no default display".to_string(),
                };
                let cause = format!("surfaceless: {cause}\ndefault: {other}");
                Err(no_driver("EGL cannot open a display", cause))
            }
        }
    }
}

/// An OpenGL context, bound to the thread that opened it.
pub(super) struct GlContext {
    shared: Rc<Display>,
    context: egl::Context,
    surface: Option<egl::Surface>,
    pub(super) gl: glow::Context,
    pub(super) interface: Option<ProgramInterface>,
    pub(super) separable: Option<Separable>,
    pub(super) kind: ContextKind,
    pub(super) version: (u32, u32),
    pub(super) device: Device,
    pub(super) limits: Limits,
    messages: Arc<Mutex<Vec<String>>>,
}

/// The number of driver messages that are kept.
const MESSAGES_KEPT: usize = 16;

impl GlContext {
    /// Opens the highest available version of a kind and makes it current.
    pub(super) fn open(shared: &Rc<Display>, kind: ContextKind) -> Result<GlContext, Failure> {
        let Display { egl, display } = &**shared;
        let (display, missing) = (*display, |what: &str, cause: String| {
            let message = format!("no OpenGL {} context: {what} failed", kind.name());
            Failure::missing(message, cause)
        });
        let (api, renderable) = match kind {
            ContextKind::Core | ContextKind::Compat => (egl::OPENGL_API, egl::OPENGL_BIT),
            ContextKind::Es => (egl::OPENGL_ES_API, egl::OPENGL_ES3_BIT),
        };
        egl.bind_api(api).map_err(|e| missing("eglBindAPI", e.to_string()))?;
        // The surface type defaults to a window, which this platform lacks.
        let wanted =
            [egl::SURFACE_TYPE, egl::PBUFFER_BIT, egl::RENDERABLE_TYPE, renderable, egl::NONE];
        let config = egl
            .choose_first_config(display, &wanted)
            .map_err(|e| missing("eglChooseConfig", e.to_string()))?
            .ok_or_else(|| {
                missing("eglChooseConfig", "no EGL configuration supports it".to_string())
            })?;
        let mut last = None;
        let context = kind.versions().iter().find_map(|&(major, minor)| {
            let mut attributes =
                vec![egl::CONTEXT_MAJOR_VERSION, major, egl::CONTEXT_MINOR_VERSION, minor];
            match kind {
                ContextKind::Core => attributes.extend([
                    egl::CONTEXT_OPENGL_PROFILE_MASK,
                    egl::CONTEXT_OPENGL_CORE_PROFILE_BIT,
                ]),
                ContextKind::Compat => attributes.extend([
                    egl::CONTEXT_OPENGL_PROFILE_MASK,
                    egl::CONTEXT_OPENGL_COMPATIBILITY_PROFILE_BIT,
                ]),
                ContextKind::Es => {}
            }
            attributes.push(egl::NONE);
            // The error of the lowest version tells why there is none.
            egl.create_context(display, config, None, &attributes).map_err(|e| last = Some(e)).ok()
        });
        let context = context.ok_or_else(|| {
            missing("eglCreateContext", last.map(|e| e.to_string()).unwrap_or_default())
        })?;
        let mut surface = None;
        if egl.make_current(display, None, None, Some(context)).is_err() {
            // Without EGL_KHR_surfaceless_context a context needs a surface, however small.
            let size = [egl::WIDTH, 1, egl::HEIGHT, 1, egl::NONE];
            surface = egl.create_pbuffer_surface(display, config, &size).ok();
            egl.make_current(display, surface, surface, Some(context))
                .map_err(|e| missing("eglMakeCurrent", e.to_string()))?;
        }
        let load = |name: &str| {
            egl.get_proc_address(name).map_or(std::ptr::null(), |f| f as *const c_void)
        };
        // SAFETY: the context is current and its functions are its own.
        let mut gl = unsafe { glow::Context::from_loader_function(load) };
        let version = (gl.version().major, gl.version().minor);
        // The first versions with program interface queries and with separable programs.
        let (queries, separation) = match kind {
            ContextKind::Core | ContextKind::Compat => ((4, 3), (4, 1)),
            ContextKind::Es => ((3, 1), (3, 1)),
        };
        let interface = if version >= queries { ProgramInterface::load(load) } else { None };
        let separable = if version >= separation { Separable::load(load) } else { None };
        let messages = Arc::new(Mutex::new(Vec::new()));
        // SAFETY: plain queries and switches of the current context, which has them.
        let (device, limits) = unsafe {
            // Results are compared by their bits.
            gl.disable(glow::DITHER);
            if gl.supports_debug() {
                gl.enable(glow::DEBUG_OUTPUT);
                // A message is there when the call that caused it returns.
                gl.enable(glow::DEBUG_OUTPUT_SYNCHRONOUS);
                let recorder = Arc::clone(&messages);
                gl.debug_message_callback(move |_, _, _, severity, message| {
                    let mut recorded = recorder.lock().unwrap_or_else(PoisonError::into_inner);
                    if severity != glow::DEBUG_SEVERITY_NOTIFICATION
                        && recorded.len() < MESSAGES_KEPT
                    {
                        recorded.push(message.trim_end().to_string());
                    }
                });
            }
            (device(&gl), limits(&gl, kind, version))
        };
        Ok(GlContext {
            shared: Rc::clone(shared),
            context,
            surface,
            gl,
            interface,
            separable,
            kind,
            version,
            device,
            limits,
            messages,
        })
    }

    /// Makes this the current context.
    pub(super) fn make_current(&self) -> Result<(), Failure> {
        let Display { egl, display } = &*self.shared;
        egl.make_current(*display, self.surface, self.surface, Some(self.context))
            .map_err(|e| Failure::died("the OpenGL context is gone", e.to_string()))
    }

    /// Returns whether compute shaders and storage blocks are supported.
    pub(super) fn computes(&self) -> bool {
        self.interface.is_some()
    }

    /// Returns and clears the driver's messages since the last call.
    pub(super) fn take_messages(&self) -> String {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut *messages).join("\n")
    }
}

impl Drop for GlContext {
    fn drop(&mut self) {
        let Display { egl, display } = &*self.shared;
        // A failure here leaks memory and nothing else; there is no one to report it to.
        let _ = egl.make_current(*display, None, None, None);
        if let Some(surface) = self.surface {
            let _ = egl.destroy_surface(*display, surface);
        }
        let _ = egl.destroy_context(*display, self.context);
    }
}

/// Parts of the names of software renderers.
const SOFTWARE: [&str; 6] =
    ["llvmpipe", "softpipe", "swrast", "SwiftShader", "Software Rasterizer", "Basic Render"];

/// # Safety
/// The context must be current.
unsafe fn device(gl: &glow::Context) -> Device {
    // SAFETY: as above.
    let [adapter, vendor, version] = unsafe {
        [glow::RENDERER, glow::VENDOR, glow::VERSION].map(|what| gl.get_parameter_string(what))
    };
    // `4.5 (Core Profile) Mesa 22.3.6`: the driver's own version follows its name.
    let (driver, version) = match version.split_once("Mesa ") {
        Some((_, own)) => ("Mesa".to_string(), own.to_string()),
        None => (vendor, version),
    };
    let software = SOFTWARE.iter().any(|name| adapter.contains(name));
    Device { backend: BackendKind::Gl, adapter, driver, version, software }
}

/// # Safety
/// The context must be current and be of that kind and version.
unsafe fn limits(gl: &glow::Context, kind: ContextKind, version: (u32, u32)) -> Limits {
    // SAFETY: as above; each value is queried only in versions that have it.
    let value = |name| u64::try_from(unsafe { gl.get_parameter_i32(name) }).ok();
    // With compute shaders and storage blocks.
    let newer = match kind {
        ContextKind::Core | ContextKind::Compat => version >= (4, 3),
        ContextKind::Es => version >= (3, 1),
    };
    let later = |name| if newer { value(name) } else { None };
    let stages = [glow::MAX_VERTEX_UNIFORM_BLOCKS, glow::MAX_FRAGMENT_UNIFORM_BLOCKS];
    Limits {
        uniform_block_size: value(glow::MAX_UNIFORM_BLOCK_SIZE),
        storage_block_size: later(glow::MAX_SHADER_STORAGE_BLOCK_SIZE),
        uniform_blocks: stages.into_iter().filter_map(value).min(),
        storage_blocks: later(glow::MAX_COMPUTE_SHADER_STORAGE_BLOCKS),
        push_constant_size: None,
        image_side: value(glow::MAX_TEXTURE_SIZE),
        workgroup_invocations: later(glow::MAX_COMPUTE_WORK_GROUP_INVOCATIONS),
        workgroups: if newer {
            // SAFETY: the version has compute shaders.
            u64::try_from(unsafe {
                gl.get_parameter_indexed_i32(glow::MAX_COMPUTE_WORK_GROUP_COUNT, 0)
            })
            .ok()
        } else {
            None
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_driver_is_named_for_each_system() {
        for (system, names) in [
            ("linux", ["libegl1", "libgl1-mesa-dri"]),
            ("windows", ["WGL", "libEGL.dll"]),
            ("macos", ["CGL", "libEGL.dylib"]),
        ] {
            assert!(names.iter().all(|name| provider(system).contains(name)), "{system}");
        }
    }
}
