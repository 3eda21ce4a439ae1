//! Links each program on the OpenGL driver and prints what `check` of its bindings says.
#![deny(warnings)]

mod generated {
    #![allow(dead_code)]
    use super::*;
    include!(env!("LANDFALL_GENERATED"));
}

use std::ffi::c_void;

use glow::HasContext as _;
use khronos_egl as egl;

/// The entry point of OpenGL with a name.
pub type Load<'a> = &'a mut dyn FnMut(&str) -> *const c_void;

/// A program, and the `check` of bindings, which may be those of another.
pub struct Program {
    pub name: &'static str,
    pub stages: Vec<(u32, &'static str)>,
    pub check: fn(u32, Load<'_>) -> Result<(), String>,
}

const SURFACELESS: egl::Enum = 0x31DD;

fn main() {
    // SAFETY: the driver's libraries are what they are; the context stays current to the end.
    unsafe {
        let egl = egl::DynamicInstance::<egl::EGL1_5>::load_required().expect("libEGL");
        let display = egl
            .get_platform_display(SURFACELESS, egl::DEFAULT_DISPLAY, &[egl::ATTRIB_NONE])
            .expect("a display without a screen");
        egl.initialize(display).expect("EGL");
        egl.bind_api(egl::OPENGL_API).expect("OpenGL");
        let wanted = [egl::SURFACE_TYPE, egl::PBUFFER_BIT, egl::RENDERABLE_TYPE, egl::OPENGL_BIT];
        let wanted = [&wanted[..], &[egl::NONE]].concat();
        let config = egl.choose_first_config(display, &wanted).expect("configs").expect("one");
        let version = [egl::CONTEXT_MAJOR_VERSION, 4, egl::CONTEXT_MINOR_VERSION, 5, egl::NONE];
        let context = egl.create_context(display, config, None, &version).expect("OpenGL 4.5");
        egl.make_current(display, None, None, Some(context)).expect("a context without surface");
        let mut load = |name: &str| {
            egl.get_proc_address(name).map_or(std::ptr::null(), |at| at as *const c_void)
        };
        let gl = glow::Context::from_loader_function(&mut load);
        for program in generated::programs() {
            println!("program {}", program.name);
            match link(&gl, &program) {
                Ok(linked) => match (program.check)(linked.0.get(), &mut load) {
                    Ok(()) => println!("as the constants say"),
                    Err(differences) => println!("{differences}"),
                },
                Err(why) => println!("not linked: {}", why.replace('\n', " ")),
            }
        }
        let unlinked = gl.create_program().expect("a program");
        let first = &generated::programs()[0];
        println!("program unlinked\n{:?}", (first.check)(unlinked.0.get(), &mut load));
        println!("program unloaded\n{:?}", (first.check)(1, &mut |_| std::ptr::null()));
    }
}

/// Compiles and links the stages of a program.
unsafe fn link(gl: &glow::Context, of: &Program) -> Result<glow::NativeProgram, String> {
    unsafe {
        let program = gl.create_program()?;
        for (stage, text) in &of.stages {
            let shader = gl.create_shader(*stage)?;
            gl.shader_source(shader, text);
            gl.compile_shader(shader);
            if !gl.get_shader_compile_status(shader) {
                return Err(gl.get_shader_info_log(shader));
            }
            gl.attach_shader(program, shader);
        }
        gl.link_program(program);
        match gl.get_program_link_status(program) {
            true => Ok(program),
            false => Err(gl.get_program_info_log(program)),
        }
    }
}
