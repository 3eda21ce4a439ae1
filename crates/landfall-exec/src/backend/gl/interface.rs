//! Entry points that glow lacks: the program interface queries (OpenGL 4.6 §7.3.1), which list the
//! members of storage blocks, and the parameter that makes a program separable (§7.3).
//!
//! glow cannot query counts and names of resources, and passes no buffer for values.

#![allow(unsafe_code, reason = "entry points of a driver")]

use std::ffi::{CStr, c_char, c_void};

type GetProgramInterfaceiv = extern "system" fn(u32, u32, u32, *mut i32);
type GetProgramResourceName = extern "system" fn(u32, u32, u32, i32, *mut i32, *mut c_char);
type GetProgramResourceiv =
    extern "system" fn(u32, u32, u32, i32, *const u32, i32, *mut i32, *mut i32);

type ProgramParameteri = extern "system" fn(u32, u32, i32);

/// `glProgramParameteri`, of OpenGL 4.1 and ES 3.1.
pub(super) struct Separable(ProgramParameteri);

impl Separable {
    pub(super) fn load(load: impl Fn(&str) -> *const c_void) -> Option<Separable> {
        let found = Some(load("glProgramParameteri")).filter(|f| !f.is_null())?;
        // SAFETY: the signature is that of OpenGL 4.6 §7.3.
        Some(Separable(unsafe { std::mem::transmute::<*const c_void, ProgramParameteri>(found) }))
    }

    /// Lets a program link with missing stages.
    pub(super) fn make(&self, program: glow::Program) {
        (self.0)(program.0.get(), glow::PROGRAM_SEPARABLE, 1);
    }
}

pub(super) struct ProgramInterface {
    interface: GetProgramInterfaceiv,
    name: GetProgramResourceName,
    values: GetProgramResourceiv,
}

impl ProgramInterface {
    /// Loads the three entry points; `None` if the driver lacks one.
    pub(super) fn load(load: impl Fn(&str) -> *const c_void) -> Option<ProgramInterface> {
        let find = |name: &str| Some(load(name)).filter(|f| !f.is_null());
        let interface = find("glGetProgramInterfaceiv")?;
        let name = find("glGetProgramResourceName")?;
        let values = find("glGetProgramResourceiv")?;
        // SAFETY: the signatures are those of OpenGL 4.6 §7.3.1.
        unsafe {
            Some(ProgramInterface {
                interface: std::mem::transmute::<*const c_void, GetProgramInterfaceiv>(interface),
                name: std::mem::transmute::<*const c_void, GetProgramResourceName>(name),
                values: std::mem::transmute::<*const c_void, GetProgramResourceiv>(values),
            })
        }
    }

    /// Returns the number of active resources of an interface.
    pub(super) fn count(&self, program: glow::Program, interface: u32) -> u32 {
        self.about(program, interface, glow::ACTIVE_RESOURCES)
    }

    /// Returns the length of the longest name of an interface's resources, for [`ProgramInterface::name`].
    pub(super) fn longest(&self, program: glow::Program, interface: u32) -> u32 {
        // A driver's number is trusted up to a megabyte.
        self.about(program, interface, glow::MAX_NAME_LENGTH).clamp(1, 1 << 20)
    }

    /// Returns the name of a resource.
    pub(super) fn name(
        &self,
        program: glow::Program,
        interface: u32,
        index: u32,
        longest: u32,
    ) -> String {
        let mut buffer: Vec<c_char> = vec![0; longest as usize + 1];
        let (room, mut written) = (longest.cast_signed(), 0);
        let program = program.0.get();
        (self.name)(program, interface, index, room, &raw mut written, buffer.as_mut_ptr());
        // SAFETY: the buffer has a terminating zero beyond the length passed to the driver.
        unsafe { CStr::from_ptr(buffer.as_ptr()) }.to_string_lossy().into_owned()
    }

    /// Returns properties of a resource, in the order of the request; fails if the driver returns
    /// fewer.
    pub(super) fn values<const N: usize>(
        &self,
        program: glow::Program,
        interface: u32,
        index: u32,
        asked: [u32; N],
    ) -> Result<[i32; N], String> {
        let room = i32::try_from(N).expect("a handful of properties");
        let (mut values, mut written) = ([0; N], 0);
        (self.values)(
            program.0.get(),
            interface,
            index,
            room,
            asked.as_ptr(),
            room,
            &raw mut written,
            values.as_mut_ptr(),
        );
        if written == room {
            Ok(values)
        } else {
            Err(format!("{written} of {room} values of resource {index}"))
        }
    }

    fn about(&self, program: glow::Program, interface: u32, what: u32) -> u32 {
        let mut value = 0;
        (self.interface)(program.0.get(), interface, what, &raw mut value);
        u32::try_from(value).unwrap_or(0)
    }
}
