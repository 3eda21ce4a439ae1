//! Lists and selects the adapters of this machine, and converts their limits.

use crate::backend::BackendKind;
use wgpu::{Adapter, Backend, Backends, DeviceType, Features, Instance, InstanceDescriptor};

use crate::backend::devices::{BackendEntry, Limits};
use crate::backend::{Device, Failure};

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AdapterChoice {
    /// Part of the adapter's or its API's name, in any case. If `None`, hardware is preferred to
    /// software, and OpenGL is excluded: wgpu's OpenGL goes through GLSL text, which loses offsets.
    pub adapter: Option<String>,
}

/// The wgpu backends that take a module as it is.
const DIRECT: Backends = Backends::VULKAN.union(Backends::METAL).union(Backends::DX12);

/// Features a job may need, enabled where the adapter has them.
pub(super) const WANTED: Features = Features::SHADER_F64
    .union(Features::SHADER_F16)
    .union(Features::SHADER_INT64)
    .union(Features::SHADER_I16)
    .union(Features::IMMEDIATES)
    .union(Features::VERTEX_WRITABLE_STORAGE)
    .union(Features::PASSTHROUGH_SHADERS)
    .union(Features::TIMESTAMP_QUERY)
    .union(Features::SUBGROUP);

/// Returns the adapter that matches.
pub(super) fn choose(choice: &AdapterChoice) -> Result<Adapter, Failure> {
    // OpenGL only for those who ask for it by name.
    let backends = if choice.adapter.is_some() { Backends::all() } else { DIRECT };
    let mut adapters = enumerate(backends);
    adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
    let Some(part) = &choice.adapter else {
        return adapters.into_iter().next().ok_or_else(|| Failure::missing(none(DIRECT), ""));
    };
    let wanted = part.to_lowercase();
    let names: Vec<String> = adapters.iter().map(full_name).collect();
    let found = names.iter().position(|name| name.to_lowercase().contains(&wanted));
    found.map(|at| adapters.swap_remove(at)).ok_or_else(|| {
        let there = match names.as_slice() {
            [] => "none is available".to_string(),
            names => format!("there are {}", names.join(", ")),
        };
        Failure::missing(format!("no GPU adapter matches `{part}`; {there}"), "")
    })
}

/// Lists every adapter of every wgpu backend in this build, and each wgpu backend without one.
pub(super) fn list() -> Vec<BackendEntry> {
    let mut found = Vec::new();
    for backend in [Backend::Vulkan, Backend::Metal, Backend::Dx12, Backend::Gl] {
        let backends = Backends::from(backend);
        if !Instance::enabled_backend_features().contains(backends) {
            continue;
        }
        let adapters = enumerate(backends);
        let kind = backend.to_str().to_string();
        if adapters.is_empty() {
            let outcome = Err(Failure::missing(none(backends), ""));
            found.push(BackendEntry { backend: BackendKind::Gpu, kind: kind.clone(), outcome });
        }
        found.extend(adapters.iter().map(|adapter| {
            let outcome = Ok((device(adapter), limits(adapter)));
            BackendEntry { backend: BackendKind::Gpu, kind: kind.clone(), outcome }
        }));
    }
    found
}

pub(super) fn device(adapter: &Adapter) -> Device {
    let info = adapter.get_info();
    // A driver without a name is named by its API.
    let driver =
        if info.driver.is_empty() { info.backend.to_str().to_string() } else { info.driver };
    Device {
        backend: BackendKind::Gpu,
        adapter: info.name,
        driver,
        version: info.driver_info,
        software: info.device_type == DeviceType::Cpu,
    }
}

pub(super) fn limits(adapter: &Adapter) -> Limits {
    let limits = adapter.limits();
    let immediates = adapter.features().contains(Features::IMMEDIATES);
    Limits {
        uniform_block_size: Some(limits.max_uniform_buffer_binding_size),
        storage_block_size: Some(limits.max_storage_buffer_binding_size),
        uniform_blocks: Some(limits.max_uniform_buffers_per_shader_stage.into()),
        storage_blocks: Some(limits.max_storage_buffers_per_shader_stage.into()),
        push_constant_size: immediates.then_some(limits.max_immediate_size.into()),
        image_side: Some(limits.max_texture_dimension_2d.into()),
        workgroup_invocations: Some(limits.max_compute_invocations_per_workgroup.into()),
        workgroups: Some(limits.max_compute_workgroups_per_dimension.into()),
    }
}

fn enumerate(backends: Backends) -> Vec<Adapter> {
    let descriptor = InstanceDescriptor {
        backends,
        // The validation layers are meant for developers of Vulkan programs.
        flags: wgpu::InstanceFlags::empty(),
        ..InstanceDescriptor::new_without_display_handle()
    };
    let instance = Instance::new(descriptor);
    if backends.contains(Backends::GL) {
        // wgpu 30 terminates EGL's display with its instance, and with it other contexts of this
        // process on that display: this instance is never dropped.
        std::mem::forget(instance.clone());
    }
    pollster::block_on(instance.enumerate_adapters(backends))
}

fn full_name(adapter: &Adapter) -> String {
    let info = adapter.get_info();
    format!("{} ({})", info.name, info.backend.to_str())
}

/// Returns the preference of a device type; lower is preferred.
fn rank(kind: DeviceType) -> u32 {
    match kind {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

fn none(backends: Backends) -> String {
    let names: Vec<&str> = [
        (Backends::VULKAN, "Vulkan"),
        (Backends::METAL, "Metal"),
        (Backends::DX12, "DX12"),
        (Backends::GL, "OpenGL"),
    ]
    .into_iter()
    .filter(|row| backends.intersection(Instance::enabled_backend_features()).contains(row.0))
    .map(|row| row.1)
    .collect();
    let mut message = format!("no {} adapter", names.join(" or "));
    if backends.contains(Backends::VULKAN) && cfg!(target_os = "linux") {
        message.push_str(
            "; the Debian packages `mesa-vulkan-drivers` and `libvulkan1` provide a software \
             driver",
        );
    }
    message
}
