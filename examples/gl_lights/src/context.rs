//! An OpenGL 3.3 context without a window, from EGL.

use std::error::Error;
use std::ffi::c_void;

use khronos_egl as egl;

/// `EGL_PLATFORM_SURFACELESS_MESA`, of the extension `EGL_MESA_platform_surfaceless`.
const PLATFORM_SURFACELESS: egl::Enum = 0x31DD;

/// Opens a context, current on this thread until the process ends, and returns its functions.
pub fn open() -> Result<glow::Context, Box<dyn Error>> {
    // SAFETY: loading libEGL runs its initialisers; they have no requirement.
    let egl = unsafe { egl::DynamicInstance::<egl::EGL1_5>::load_required() }?;
    // SAFETY: the surfaceless platform takes no native display.
    let display = unsafe {
        egl.get_platform_display(PLATFORM_SURFACELESS, egl::DEFAULT_DISPLAY, &[egl::ATTRIB_NONE])
    }?;
    egl.initialize(display)?;
    egl.bind_api(egl::OPENGL_API)?;
    let wanted =
        [egl::SURFACE_TYPE, egl::PBUFFER_BIT, egl::RENDERABLE_TYPE, egl::OPENGL_BIT, egl::NONE];
    let config = egl.choose_first_config(display, &wanted)?.ok_or("EGL has no OpenGL config")?;
    let version = [
        egl::CONTEXT_MAJOR_VERSION,
        3,
        egl::CONTEXT_MINOR_VERSION,
        3,
        egl::CONTEXT_OPENGL_PROFILE_MASK,
        egl::CONTEXT_OPENGL_CORE_PROFILE_BIT,
        egl::NONE,
    ];
    let context = egl.create_context(display, config, None, &version)?;
    egl.make_current(display, None, None, Some(context))?;
    // SAFETY: the context is current, and the functions are its own.
    let gl = unsafe {
        glow::Context::from_loader_function(|name| {
            egl.get_proc_address(name).map_or(std::ptr::null(), |found| found as *const c_void)
        })
    };
    // The functions belong to the library, which must stay loaded.
    std::mem::forget(egl);
    Ok(gl)
}
