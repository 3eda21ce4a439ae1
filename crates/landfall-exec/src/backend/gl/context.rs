//! A context without a window: EGL opened at run time, no X and no `DISPLAY`.
//!
//! Fed by nothing but the machine. Feeds every other file here with a context that is
//! current, its entry points and its limits.

#![allow(unsafe_code, reason = "every call into EGL and OpenGL is unsafe")]

use crate::backend::BackendKind;
use std::ffi::c_void;
use std::rc::Rc;
use std::sync::{Arc, Mutex, PoisonError};

use glow::HasContext as _;
use khronos_egl as egl;

use super::interface::{Interface, Separable};
use crate::backend::devices::Limits;
use crate::backend::{Device, Failure};

/// What OpenGL is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ContextKind {
    /// Desktop, core profile: `#version 140` and later.
    Core,
    /// Desktop with everything that was taken out of core: `#version 110` to `130`.
    Compat,
    /// OpenGL ES.
    Es,
}

impl ContextKind {
    /// Every kind, the usual one first.
    pub const ALL: [ContextKind; 3] = [ContextKind::Core, ContextKind::Compat, ContextKind::Es];

    /// The name in messages and JSON: `core`, `compat` or `es`.
    pub fn name(self) -> &'static str {
        match self {
            ContextKind::Core => "core",
            ContextKind::Compat => "compat",
            ContextKind::Es => "es",
        }
    }

    /// The versions to ask for, highest first; what cannot be had is refused by EGL.
    fn versions(self) -> &'static [(i32, i32)] {
        match self {
            ContextKind::Core | ContextKind::Compat => {
                &[(4, 6), (4, 5), (4, 4), (4, 3), (4, 2), (4, 1), (4, 0), (3, 3), (3, 2)]
            }
            ContextKind::Es => &[(3, 2), (3, 1), (3, 0)],
        }
    }
}

/// EGL and its display. Contexts share one; it is never terminated, since others of this
/// process may have opened the same.
pub(super) struct Display {
    egl: egl::DynamicInstance<egl::EGL1_5>,
    display: egl::Display,
}

/// `EGL_PLATFORM_SURFACELESS_MESA`, of `EGL_MESA_platform_surfaceless`.
const PLATFORM_SURFACELESS: egl::Enum = 0x31DD;
const INSTALL: &str = "the Debian packages `libegl1` and `libgl1-mesa-dri` have one in software";

impl Display {
    /// Loads libEGL and opens the surfaceless display, or else the default one.
    pub(super) fn open() -> Result<Rc<Display>, Failure> {
        // SAFETY: loading libEGL runs its initialisers, which is what it is for.
        let egl =
            unsafe { egl::DynamicInstance::<egl::EGL1_5>::load_required() }.map_err(|cause| {
                let message = format!("no OpenGL driver: libEGL 1.5 cannot be loaded; {INSTALL}");
                Failure::missing(message, cause.to_string())
            })?;
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
                    Some(Ok(_)) | None => "there is none".to_string(),
                };
                Err(Failure::missing(
                    format!("no OpenGL driver: EGL opens no display; {INSTALL}"),
                    format!("surfaceless: {cause}\ndefault: {other}"),
                ))
            }
        }
    }
}

/// A context. It belongs to the thread that opened it.
pub(super) struct Context {
    shared: Rc<Display>,
    context: egl::Context,
    surface: Option<egl::Surface>,
    pub(super) gl: glow::Context,
    pub(super) interface: Option<Interface>,
    pub(super) separable: Option<Separable>,
    pub(super) kind: ContextKind,
    pub(super) version: (u32, u32),
    pub(super) device: Device,
    pub(super) limits: Limits,
    said: Arc<Mutex<Vec<String>>>,
}

/// Messages of the driver's that are kept.
const HEARD: usize = 16;

impl Context {
    /// The highest version of that kind, current when this returns.
    pub(super) fn open(shared: &Rc<Display>, kind: ContextKind) -> Result<Context, Failure> {
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
        // The surface type is a window unless said otherwise, and this platform has none.
        let wanted =
            [egl::SURFACE_TYPE, egl::PBUFFER_BIT, egl::RENDERABLE_TYPE, renderable, egl::NONE];
        let config = egl
            .choose_first_config(display, &wanted)
            .map_err(|e| missing("eglChooseConfig", e.to_string()))?
            .ok_or_else(|| missing("eglChooseConfig", "nothing fits".to_string()))?;
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
            egl.create_context(display, config, None, &attributes).map_err(|e| last = Some(e)).ok()
        });
        let context = context.ok_or_else(|| {
            missing("eglCreateContext", last.map(|e| e.to_string()).unwrap_or_default())
        })?;
        let mut surface = None;
        if egl.make_current(display, None, None, Some(context)).is_err() {
            // Without EGL_KHR_surfaceless_context a context wants a surface, if a tiny one.
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
        let (queries, separation) = match kind {
            ContextKind::Core | ContextKind::Compat => ((4, 3), (4, 1)),
            ContextKind::Es => ((3, 1), (3, 1)),
        };
        let interface = if version >= queries { Interface::load(load) } else { None };
        let separable = if version >= separation { Separable::load(load) } else { None };
        let said = Arc::new(Mutex::new(Vec::new()));
        // SAFETY: plain queries and switches of the current context, which has them.
        let (device, limits) = unsafe {
            gl.disable(glow::DITHER);
            if gl.supports_debug() {
                gl.enable(glow::DEBUG_OUTPUT);
                gl.enable(glow::DEBUG_OUTPUT_SYNCHRONOUS);
                let heard = Arc::clone(&said);
                gl.debug_message_callback(move |_, _, _, severity, message| {
                    let mut heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
                    if severity != glow::DEBUG_SEVERITY_NOTIFICATION && heard.len() < HEARD {
                        heard.push(message.trim_end().to_string());
                    }
                });
            }
            (device(&gl), limits(&gl, kind, version))
        };
        Ok(Context {
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
            said,
        })
    }

    /// Makes it the one OpenGL calls go to.
    pub(super) fn make_current(&self) -> Result<(), Failure> {
        let Display { egl, display } = &*self.shared;
        egl.make_current(*display, self.surface, self.surface, Some(self.context))
            .map_err(|e| Failure::died("the OpenGL context is gone", e.to_string()))
    }

    /// Whether it takes compute shaders and storage blocks.
    pub(super) fn computes(&self) -> bool {
        self.interface.is_some()
    }

    /// What the driver has had to say since it was last asked.
    pub(super) fn said(&self) -> String {
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut *said).join("\n")
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        let Display { egl, display } = &*self.shared;
        // Nobody can be told if this fails, and nothing is lost but memory.
        let _ = egl.make_current(*display, None, None, None);
        if let Some(surface) = self.surface {
            let _ = egl.destroy_surface(*display, surface);
        }
        let _ = egl.destroy_context(*display, self.context);
    }
}

/// Parts of the names of drivers that compute on the processor.
const SOFTWARE: [&str; 6] =
    ["llvmpipe", "softpipe", "swrast", "SwiftShader", "Software Rasterizer", "Basic Render"];

/// # Safety
/// The context must be current.
unsafe fn device(gl: &glow::Context) -> Device {
    // SAFETY: as above.
    let [adapter, vendor, version] = unsafe {
        [glow::RENDERER, glow::VENDOR, glow::VERSION].map(|what| gl.get_parameter_string(what))
    };
    // `4.5 (Core Profile) Mesa 22.3.6`: what follows the name is the driver's own version.
    let (driver, version) = match version.split_once("Mesa ") {
        Some((_, own)) => ("Mesa".to_string(), own.to_string()),
        None => (vendor, version),
    };
    let software = SOFTWARE.iter().any(|name| adapter.contains(name));
    Device { reader: BackendKind::Gl, adapter, driver, version, software }
}

/// # Safety
/// The context must be current and be of that kind and version.
unsafe fn limits(gl: &glow::Context, kind: ContextKind, version: (u32, u32)) -> Limits {
    // SAFETY: as above; each value is asked for only where the version has it.
    let value = |name| u64::try_from(unsafe { gl.get_parameter_i32(name) }).ok();
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
