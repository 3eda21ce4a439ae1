//! The resources of a module for one run: blocks filled from JSON, textures of one colour.
//!
//! Used by [`call`](super::call), [`coverage`](super::coverage) and [`verify`](super::verify).

use landfall_layout::diagnostic::Code;
use serde_json::{Map, Value};

use super::probe::plan::TAIL;
use crate::backend::{Resource, ResourceKind};
use landfall_ir::module::{HandleKind, Module, ModuleBlock, ModuleHandle};
use landfall_layout::Diagnostic;
use landfall_layout::buffer::{Buffer, Missing, encode};
use landfall_layout::layout::BlockLayout;
use landfall_layout::shape::{AddressSpace, ArrayLen};
use landfall_layout::text::edit_distance::suggestion;

/// Contents of blocks: values as `landfall encode` takes them, by the name of the block or its
/// instance; `Name[1]` for one buffer of an array of blocks.
pub type Data = Map<String, Value>;

/// White, the default colour of a texture.
pub(super) const WHITE: [f32; 4] = [1.0; 4];

/// Returns the bytes of each block of the module; `other` makes those of blocks without values.
pub(super) fn blocks(
    module: &Module,
    data: &Data,
    other: impl Fn(&BlockLayout) -> Vec<u8>,
) -> Result<Vec<Vec<u8>>, Box<Diagnostic>> {
    let blocks = module.blocks();
    for key in data.keys() {
        if !blocks.iter().any(|block| means(key, block)) {
            return Err(unknown(key, blocks));
        }
    }
    let bytes = blocks.iter().map(|block| match values_for_block(data, block) {
        Some((key, values)) => encode(&block.layout, values, Missing::Zero)
            .map_err(|error| Box::new(finding(error.code(), format!("in `{key}`, {error}"), None))),
        None => Ok(other(&block.layout)),
    });
    bytes.collect()
}

/// Returns the key and values given for a block.
pub(super) fn values_for_block<'d>(
    data: &'d Data,
    block: &ModuleBlock,
) -> Option<(&'d String, &'d Value)> {
    // A key for one buffer takes precedence over a key for the whole array.
    let exact = data.iter().find(|(key, _)| key.ends_with(']') && means(key, block));
    exact.or_else(|| data.iter().find(|(key, _)| means(key, block)))
}

fn means(key: &str, block: &ModuleBlock) -> bool {
    let (name, index) = match key.split_once('[') {
        Some((name, rest)) => (name, rest.strip_suffix(']')),
        None => (key, None),
    };
    let named = *block.layout.name == *name || block.layout.instance.as_deref() == Some(name);
    let index = index.map(str::parse::<u32>);
    named && index.is_none_or(|index| index.ok() == block.element)
}

fn unknown(key: &str, blocks: &[ModuleBlock]) -> Box<Diagnostic> {
    let names = || blocks.iter().map(|block| &*block.layout.name).filter(|name| !name.is_empty());
    let help = suggestion(key, names()).or_else(|| {
        let mut all: Vec<String> = names().map(|name| format!("`{name}`")).collect();
        // The buffers of an array have one name, side by side.
        all.dedup();
        (!all.is_empty()).then(|| format!("there is {}", all.join(", ")))
    });
    Box::new(finding(Code::UnknownBlock, format!("no block named `{key}`"), help))
}

fn finding(code: Code, message: String, help: Option<String>) -> Diagnostic {
    // The error's help is a separate line.
    let (message, advice) = match message.split_once("\nhelp: ") {
        Some((message, advice)) => (message.to_string(), Some(advice.to_string())),
        None => (message, None),
    };
    Diagnostic::about(code, message, help.or(advice), "--data")
}

/// Returns the zeros of a block, with a few elements of a runtime-sized tail.
pub(super) fn zeros(block: &BlockLayout) -> Vec<u8> {
    let has_tail = block.members.iter().any(|member| member.dims.contains(&ArrayLen::Runtime));
    let buffer = match has_tail {
        true => Buffer::with_tail(block, TAIL as usize),
        false => Buffer::new(block),
    };
    buffer.map(Buffer::into_bytes).unwrap_or_default()
}

/// Returns the resources of a module at its own bindings.
pub(super) fn resources(
    module: &Module,
    bytes: Vec<Vec<u8>>,
    writable: impl Fn(&BlockLayout) -> bool,
    textures: &[(String, [f32; 4])],
) -> Vec<Resource> {
    let blocks = module.blocks().iter().zip(bytes).map(|(block, bytes)| Resource {
        name: block.layout.name.to_string(),
        group: block.group,
        binding: block.binding,
        kind: kind(&block.layout, bytes, writable(&block.layout)),
    });
    let handles = module.handles().iter().filter_map(|handle| dummy(handle, textures));
    blocks.chain(handles).collect()
}

/// Returns what is bound to a texture or a sampler; images are not bound.
pub(super) fn dummy(handle: &ModuleHandle, textures: &[(String, [f32; 4])]) -> Option<Resource> {
    let kind = match handle.kind {
        HandleKind::Texture => texture(colour(textures, &handle.path)),
        HandleKind::Sampler => ResourceKind::Sampler,
        HandleKind::Image => return None,
    };
    let name = handle.path.clone();
    Some(Resource { name, group: handle.group, binding: handle.binding, kind })
}

/// Returns the resource kind of a block's buffer.
pub(super) fn kind(block: &BlockLayout, mut bytes: Vec<u8>, writable: bool) -> ResourceKind {
    // Drivers bind multiples of four bytes.
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    match block.space {
        AddressSpace::Storage => ResourceKind::Storage { bytes, writable },
        AddressSpace::PushConstant => ResourceKind::PushConstant(bytes),
        // Lowering refuses other address spaces.
        _ => ResourceKind::Uniform(bytes),
    }
}

/// Returns the colour given for a texture, by its name or that of its array.
pub(super) fn colour(textures: &[(String, [f32; 4])], path: &str) -> Option<[f32; 4]> {
    let named = |name: &str| {
        let rest = path.strip_prefix(name);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
    };
    textures.iter().find(|(name, _)| named(name)).map(|(_, colour)| *colour)
}

/// Fails if a colour is given for a texture that does not exist.
pub(super) fn textures_are_there(
    module: &Module,
    textures: &[(String, [f32; 4])],
) -> Result<(), Box<Diagnostic>> {
    let handles = module.handles().iter();
    let mut paths: Vec<&str> = handles
        .filter(|handle| matches!(handle.kind, HandleKind::Texture))
        .map(|handle| handle.path.as_str())
        .collect();
    paths.dedup();
    let is_there = |given: &(String, [f32; 4])| {
        paths.iter().any(|path| colour(std::slice::from_ref(given), path).is_some())
    };
    let Some((name, _)) = textures.iter().find(|given| !is_there(given)) else { return Ok(()) };
    let help = suggestion(name, paths.iter().copied()).or_else(|| {
        let all: Vec<String> = paths.iter().map(|path| format!("`{path}`")).collect();
        (!all.is_empty()).then(|| format!("there is {}", all.join(", ")))
    });
    let message = format!("the shader has no texture `{name}`");
    Err(Box::new(Diagnostic::about(Code::UnknownTexture, message, help, "--texture")))
}

/// Returns a texture of one texel, white by default.
pub(super) fn texture(colour: Option<[f32; 4]>) -> ResourceKind {
    ResourceKind::Texture { width: 1, height: 1, texels: vec![colour.unwrap_or(WHITE)] }
}
