//! The second oracle: an OpenGL driver, which compiles the original text and
//! says where it put every member. Surfaceless EGL, so no display is needed
//! (Debian packages `libegl1` and `libgl1-mesa-dri`).
//!
//! Uniform blocks are asked for through glGetActiveUniformsiv and
//! glGetActiveUniformBlockiv (OpenGL 4.6 §7.6), storage blocks through the
//! program interface queries (§7.3.1). `fold` turns the answers into rows.

#![allow(unsafe_code, reason = "every call into EGL and OpenGL is unsafe")]

use std::ffi::{CStr, c_char, c_void};

use glow::HasContext as _;
use khronos_egl as egl;

use super::fold::{Active, fold};
use super::gl_types::word;
use super::leaf::OracleBlock;

/// Which of the two APIs the texts are written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Api {
    /// OpenGL 4.5 core.
    Gl,
    /// OpenGL ES 3.1 or later.
    Gles,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    Vertex,
    Fragment,
    Compute,
}

/// A context, current on the thread that opened it.
pub struct Driver {
    egl: egl::DynamicInstance<egl::EGL1_5>,
    display: egl::Display,
    context: egl::Context,
    gl: glow::Context,
    resources: Resources,
    pub limits: Limits,
}

/// How many blocks a compute shader may have.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub uniform_blocks: usize,
    pub storage_blocks: usize,
    /// Bytes.
    pub uniform_block_size: u64,
}

const PLATFORM_SURFACELESS_MESA: egl::Enum = 0x31DD;
const PACKAGES: &str = "install the Debian packages `libegl1` and `libgl1-mesa-dri`";

impl Driver {
    /// Panics, naming the packages, where there is no driver to ask.
    pub fn open(api: Api) -> Self {
        Self::try_open(api).unwrap_or_else(|e| panic!("no OpenGL driver ({e}): {PACKAGES}"))
    }

    fn try_open(api: Api) -> Result<Self, String> {
        // SAFETY: loading libEGL runs its initialisers, which is what it is for.
        let egl = unsafe { egl::DynamicInstance::<egl::EGL1_5>::load_required() }
            .map_err(|e| format!("libEGL: {e}"))?;
        let fail = |what: &'static str| move |e: egl::Error| format!("{what}: {e}");
        // SAFETY: the surfaceless platform takes no native display.
        let display = unsafe {
            egl.get_platform_display(
                PLATFORM_SURFACELESS_MESA,
                egl::DEFAULT_DISPLAY,
                &[egl::ATTRIB_NONE],
            )
        }
        .map_err(fail("eglGetPlatformDisplay"))?;
        egl.initialize(display).map_err(fail("eglInitialize"))?;
        let (name, renderable, major, minor) = match api {
            Api::Gl => (egl::OPENGL_API, egl::OPENGL_BIT, 4, 5),
            Api::Gles => (egl::OPENGL_ES_API, egl::OPENGL_ES3_BIT, 3, 1),
        };
        egl.bind_api(name).map_err(fail("eglBindAPI"))?;
        // The default surface type is a window, which this platform has not.
        let wanted =
            [egl::SURFACE_TYPE, egl::PBUFFER_BIT, egl::RENDERABLE_TYPE, renderable, egl::NONE];
        let config = egl
            .choose_first_config(display, &wanted)
            .map_err(fail("eglChooseConfig"))?
            .ok_or("no EGL configuration")?;
        let version =
            [egl::CONTEXT_MAJOR_VERSION, major, egl::CONTEXT_MINOR_VERSION, minor, egl::NONE];
        let context = egl
            .create_context(display, config, None, &version)
            .map_err(fail("eglCreateContext"))?;
        egl.make_current(display, None, None, Some(context)).map_err(fail("eglMakeCurrent"))?;
        let load = |name: &str| {
            egl.get_proc_address(name).map_or(std::ptr::null(), |f| f as *const c_void)
        };
        // SAFETY: the context is current and its functions are its own.
        let gl = unsafe { glow::Context::from_loader_function(load) };
        let resources = Resources::load(load)?;
        // SAFETY: plain queries of the current context.
        let limits = unsafe {
            Limits {
                uniform_blocks: count(gl.get_parameter_i32(glow::MAX_COMPUTE_UNIFORM_BLOCKS)),
                storage_blocks: count(
                    gl.get_parameter_i32(glow::MAX_COMPUTE_SHADER_STORAGE_BLOCKS),
                ),
                uniform_block_size: bytes(gl.get_parameter_i32(glow::MAX_UNIFORM_BLOCK_SIZE)),
            }
        };
        Ok(Self { egl, display, context, gl, resources, limits })
    }

    /// The context itself, to draw with.
    pub fn gl(&self) -> &glow::Context {
        &self.gl
    }

    /// Vendor, renderer and version, for a message.
    pub fn name(&self) -> String {
        // SAFETY: the context is current.
        unsafe {
            format!(
                "{}, {}",
                self.gl.get_parameter_string(glow::RENDERER),
                self.gl.get_parameter_string(glow::VERSION)
            )
        }
    }

    /// The blocks of a program made of these stages; uniform blocks first. An
    /// error is the driver's log.
    pub fn blocks(&self, stages: &[(Stage, &str)]) -> Result<Vec<OracleBlock>, String> {
        let program = Program::link(&self.gl, stages)?;
        let mut blocks = self.uniform_blocks(&program)?;
        blocks.extend(self.storage_blocks(&program)?);
        merge_elements(blocks)
    }

    fn uniform_blocks(&self, program: &Program<'_>) -> Result<Vec<OracleBlock>, String> {
        let gl = &self.gl;
        // SAFETY: the program is linked and every index below its counts.
        unsafe {
            let uniforms: Vec<u32> = (0..gl.get_active_uniforms(program.id)).collect();
            let facts = |pname| gl.get_active_uniforms_parameter(program.id, &uniforms, pname);
            let block_index = facts(glow::UNIFORM_BLOCK_INDEX);
            let offset = facts(glow::UNIFORM_OFFSET);
            let array_stride = facts(glow::UNIFORM_ARRAY_STRIDE);
            let matrix_stride = facts(glow::UNIFORM_MATRIX_STRIDE);
            let row_major = facts(glow::UNIFORM_IS_ROW_MAJOR);
            let blocks = gl.get_program_parameter_i32(program.id, glow::ACTIVE_UNIFORM_BLOCKS);
            let mut found = Vec::new();
            for block in 0..u32::try_from(blocks).expect("a count") {
                let name = gl.get_active_uniform_block_name(program.id, block);
                let size = gl.get_active_uniform_block_parameter_i32(
                    program.id,
                    block,
                    glow::UNIFORM_BLOCK_DATA_SIZE,
                );
                let mut actives = Vec::new();
                for &index in &uniforms {
                    let at = index as usize;
                    if block_index[at] < 0 || block_index[at].cast_unsigned() != block {
                        continue;
                    }
                    let uniform = gl
                        .get_active_uniform(program.id, index)
                        .ok_or_else(|| format!("uniform {index} has no name"))?;
                    let ty = word(uniform.utype)?;
                    actives.push(Active {
                        offset: bytes(offset[at]),
                        array_size: Some(bytes(uniform.size)),
                        array_stride: bytes(array_stride[at]),
                        matrix_stride: ty.contains("mat").then(|| bytes(matrix_stride[at])),
                        row_major: row_major[at] != 0,
                        top_level: None,
                        ty: ty.to_owned(),
                        name: uniform.name,
                    });
                }
                found.push(block_of(&name, size, actives)?);
            }
            Ok(found)
        }
    }

    fn storage_blocks(&self, program: &Program<'_>) -> Result<Vec<OracleBlock>, String> {
        let mut members: Vec<Vec<Active>> = Vec::new();
        let blocks = self.resources.count(program, glow::SHADER_STORAGE_BLOCK);
        members.resize_with(blocks as usize, Vec::new);
        for index in 0..self.resources.count(program, glow::BUFFER_VARIABLE) {
            let asked = [
                glow::BLOCK_INDEX,
                glow::TYPE,
                glow::OFFSET,
                glow::ARRAY_SIZE,
                glow::ARRAY_STRIDE,
                glow::MATRIX_STRIDE,
                glow::IS_ROW_MAJOR,
                glow::TOP_LEVEL_ARRAY_SIZE,
                glow::TOP_LEVEL_ARRAY_STRIDE,
            ];
            let [block, ty, offset, size, stride, matrix, row_major, top_size, top_stride] =
                self.resources.facts(program, glow::BUFFER_VARIABLE, index, asked)?;
            let ty = word(ty.cast_unsigned())?;
            members[count(block)].push(Active {
                name: self.resources.name(program, glow::BUFFER_VARIABLE, index),
                ty: ty.to_owned(),
                offset: bytes(offset),
                array_size: length(size),
                array_stride: bytes(stride),
                matrix_stride: ty.contains("mat").then(|| bytes(matrix)),
                row_major: row_major != 0,
                top_level: (top_stride > 0).then(|| (length(top_size), bytes(top_stride))),
            });
        }
        (0..)
            .zip(members)
            .map(|(index, actives)| {
                let name = self.resources.name(program, glow::SHADER_STORAGE_BLOCK, index);
                let asked = [glow::BUFFER_DATA_SIZE];
                let [size] =
                    self.resources.facts(program, glow::SHADER_STORAGE_BLOCK, index, asked)?;
                block_of(&name, size, actives)
            })
            .collect()
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        // The display stays: other contexts of this process share it.
        let _ = self.egl.make_current(self.display, None, None, None);
        let _ = self.egl.destroy_context(self.display, self.context);
    }
}

/// A linked program, deleted when done.
struct Program<'g> {
    gl: &'g glow::Context,
    id: glow::Program,
}

impl<'g> Program<'g> {
    fn link(gl: &'g glow::Context, stages: &[(Stage, &str)]) -> Result<Self, String> {
        // SAFETY: objects are made, used and deleted in the current context.
        unsafe {
            let program = Self { gl, id: gl.create_program()? };
            for (stage, text) in stages {
                let shader = gl.create_shader(match stage {
                    Stage::Vertex => glow::VERTEX_SHADER,
                    Stage::Fragment => glow::FRAGMENT_SHADER,
                    Stage::Compute => glow::COMPUTE_SHADER,
                })?;
                gl.shader_source(shader, text);
                gl.compile_shader(shader);
                let compiled = gl.get_shader_compile_status(shader);
                let log = gl.get_shader_info_log(shader);
                gl.attach_shader(program.id, shader);
                gl.delete_shader(shader);
                if !compiled {
                    return Err(format!("{stage:?} does not compile: {log}"));
                }
            }
            gl.link_program(program.id);
            if gl.get_program_link_status(program.id) {
                Ok(program)
            } else {
                Err(format!("does not link: {}", gl.get_program_info_log(program.id)))
            }
        }
    }
}

impl Drop for Program<'_> {
    fn drop(&mut self) {
        // SAFETY: the program was made in the current context.
        unsafe { self.gl.delete_program(self.id) }
    }
}

type GetProgramInterfaceiv = extern "system" fn(u32, u32, u32, *mut i32);
type GetProgramResourceName = extern "system" fn(u32, u32, u32, i32, *mut i32, *mut c_char);
type GetProgramResourceiv =
    extern "system" fn(u32, u32, u32, i32, *const u32, i32, *mut i32, *mut i32);

/// The interface queries. glow 0.18 has no names or counts of resources, and
/// asks for their values with room for none, which Mesa answers with none.
struct Resources {
    interface: GetProgramInterfaceiv,
    name: GetProgramResourceName,
    values: GetProgramResourceiv,
}

impl Resources {
    fn load(load: impl Fn(&str) -> *const c_void) -> Result<Self, String> {
        let find = |name: &str| {
            let function = load(name);
            if function.is_null() { Err(format!("no {name}")) } else { Ok(function) }
        };
        // SAFETY: the signatures are those of OpenGL 4.6 §7.3.1.
        unsafe {
            Ok(Self {
                interface: std::mem::transmute::<*const c_void, GetProgramInterfaceiv>(find(
                    "glGetProgramInterfaceiv",
                )?),
                name: std::mem::transmute::<*const c_void, GetProgramResourceName>(find(
                    "glGetProgramResourceName",
                )?),
                values: std::mem::transmute::<*const c_void, GetProgramResourceiv>(find(
                    "glGetProgramResourceiv",
                )?),
            })
        }
    }

    fn facts<const N: usize>(
        &self,
        program: &Program<'_>,
        interface: u32,
        index: u32,
        asked: [u32; N],
    ) -> Result<[i32; N], String> {
        let room = i32::try_from(N).expect("a handful");
        let (mut values, mut written) = ([0; N], 0);
        (self.values)(
            program.id.0.get(),
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
            Err(format!("resource {index} of 0x{interface:X}: {written} of {room} values"))
        }
    }

    fn count(&self, program: &Program<'_>, interface: u32) -> u32 {
        let mut count = 0;
        (self.interface)(program.id.0.get(), interface, glow::ACTIVE_RESOURCES, &raw mut count);
        count.cast_unsigned()
    }

    fn name(&self, program: &Program<'_>, interface: u32, index: u32) -> String {
        let mut buffer = [0 as c_char; 1024];
        let mut written = 0;
        (self.name)(
            program.id.0.get(),
            interface,
            index,
            1024,
            &raw mut written,
            buffer.as_mut_ptr(),
        );
        // SAFETY: the driver ends the name with a zero within the buffer.
        unsafe { CStr::from_ptr(buffer.as_ptr()) }.to_string_lossy().into_owned()
    }
}

/// A block from its members, whose names begin with the block's where it has
/// an instance (OpenGL 4.6 §7.3.1.1).
fn block_of(name: &str, size: i32, mut actives: Vec<Active>) -> Result<OracleBlock, String> {
    let bare = name.split('[').next().expect("split yields at least one piece");
    for active in &mut actives {
        if let Some(rest) = active.name.strip_prefix(bare).and_then(|r| r.strip_prefix('.')) {
            active.name = rest.to_owned();
        }
    }
    Ok(OracleBlock {
        name: name.to_owned(),
        count: Vec::new(),
        size: Some(bytes(size)),
        data_size: None,
        leaves: fold(&actives).map_err(|e| format!("block {name}: {e}"))?,
    })
}

/// `B[0]`, `B[1]` are one array of blocks. OpenGL lists the members of the
/// first element only, or of each; those listed must agree.
fn merge_elements(blocks: Vec<OracleBlock>) -> Result<Vec<OracleBlock>, String> {
    let mut merged: Vec<OracleBlock> = Vec::new();
    for mut block in blocks {
        let Some((bare, indices)) = block.name.split_once('[') else {
            merged.push(block);
            continue;
        };
        let count: Result<Vec<Option<u64>>, _> = indices
            .trim_end_matches(']')
            .split("][")
            .map(|index| index.parse::<u64>().map(|i| Some(i + 1)))
            .collect();
        block.count = count.map_err(|_| format!("no index in `{}`", block.name))?;
        block.name = bare.to_owned();
        match merged.iter_mut().find(|b| b.name == block.name && !b.count.is_empty()) {
            None => merged.push(block),
            Some(first) => {
                if first.leaves.is_empty() {
                    first.leaves = std::mem::take(&mut block.leaves);
                }
                let same = block.leaves.is_empty() || block.leaves == first.leaves;
                if !same || block.size != first.size {
                    return Err(format!("elements of block array `{}` differ", first.name));
                }
                for (known, new) in first.count.iter_mut().zip(block.count) {
                    *known = (*known).max(new);
                }
            }
        }
    }
    Ok(merged)
}

fn bytes(value: i32) -> u64 {
    u64::try_from(value).unwrap_or_else(|_| panic!("the driver answered {value} for a size"))
}

fn count(value: i32) -> usize {
    usize::try_from(value).unwrap_or_else(|_| panic!("the driver answered {value} for a count"))
}

/// Zero stands for an array without a declared size.
fn length(value: i32) -> Option<u64> {
    (value != 0).then(|| bytes(value))
}
