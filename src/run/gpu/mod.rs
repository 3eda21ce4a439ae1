//! wgpu: Vulkan, Metal, DX12, fed the module itself.
