//! What is asked of [`bindings`](super::bindings): APIs, programs, and what a shader leaves open.

/// The API that bindings are written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Api {
    /// wgpu, the newest major version that this version of landfall knows: 30.
    Wgpu,
    /// wgpu of that major version.
    WgpuMajor(WgpuMajor),
    /// Vulkan through ash 0.38.
    Ash,
    /// OpenGL: names, bindings and locations as constants, and a check of a linked program.
    OpenGl,
}

/// The major versions of wgpu whose API is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum WgpuMajor {
    V27,
    V28,
    V29,
    V30,
}

impl WgpuMajor {
    /// The newest one.
    pub const NEWEST: WgpuMajor = WgpuMajor::V30;
}

impl Api {
    /// The names in `--bindings`, in the order of their documentation.
    pub const NAMES: &[(&'static str, Api)] = &[
        ("wgpu", Api::Wgpu),
        ("wgpu-30", Api::WgpuMajor(WgpuMajor::V30)),
        ("wgpu-29", Api::WgpuMajor(WgpuMajor::V29)),
        ("wgpu-28", Api::WgpuMajor(WgpuMajor::V28)),
        ("wgpu-27", Api::WgpuMajor(WgpuMajor::V27)),
        ("ash", Api::Ash),
        ("gl", Api::OpenGl),
    ];

    /// The variant with this name.
    pub fn from_name(name: &str) -> Option<Api> {
        Api::NAMES.iter().find(|(known, _)| *known == name).map(|(_, api)| *api)
    }
}

/// Where the generated code takes the text of a shader from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sources {
    /// Nowhere: no text is written.
    #[default]
    Without,
    /// The text is part of the program.
    Embedded,
    /// With `debug_assertions` the file is read when the program asks; else the text is embedded.
    LoadedInDebug,
}

/// Options of the bindings.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct BindingOptions {
    /// The APIs, one module each.
    pub apis: Vec<Api>,
    /// Programs of several shaders: a name and the shaders' files, or `FILE:ENTRY` for some entry
    /// points of a WGSL module. Without, `a.vert` and `a.frag` are one program, and every other
    /// shader is one; a WGSL module whose entry points use one binding for two resources is one
    /// for each fragment and compute entry point.
    pub programs: Vec<(String, Vec<String>)>,
    /// Names of buffers that are bound with a dynamic offset.
    pub dynamic_offsets: Vec<String>,
    /// Names of textures of floats that are not filtered, and of samplers that do not filter.
    pub unfilterable: Vec<String>,
    /// The number of elements of each array of resources whose declaration gives none, by name.
    pub counts: Vec<(String, u32)>,
    /// Those names above, of programs too, that are a project's: none has to be of these shaders.
    pub project_names: Vec<String>,
    /// Where the text of the shaders comes from.
    pub sources: Sources,
    /// The expression of each shader's path, in the order of the shaders: `"a.wgsl"`, or
    /// `concat!(env!("CARGO_MANIFEST_DIR"), "/a.wgsl")`. A shader without one has no text.
    pub paths: Vec<String>,
}
