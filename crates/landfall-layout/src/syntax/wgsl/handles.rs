//! The kinds of textures and samplers, from their types (WGSL §6.5, §6.6).

use super::lengths;
use super::lexer::{Kind, WgslLexer};
use super::outline::Class;
use super::reader::ModuleReader;
use super::report::{self, Refused};
use super::types;
use crate::interface::{Access, Dimension, ResourceKind, Sampled, Texture};
use crate::shape::ArrayLen;

/// Parses the type of a variable without an address space.
// sampler | sampler_comparison | texture_[storage_ | depth_][multisampled_]DIMENSION[_array] [<…>]
// binding_array<T, N>
pub(super) fn read<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
) -> Result<(ResourceKind, Vec<ArrayLen>), Refused> {
    let word = lexer.next();
    if word.kind != Kind::Word {
        return Err(Refused);
    }
    let name = lexer.text_of(word);
    if let Some(mut target) = alias(reader, name) {
        return reader.deeper_type(report::span(word), |reader| read(reader, &mut target));
    }
    if name == "binding_array" {
        types::expect(reader, lexer, b'<', "`<`")?;
        let (kind, mut inner) =
            reader.deeper_type(report::span(word), |reader| read(reader, lexer))?;
        let len = match lexer.take(b',') && !lexer.peek().is(b'>') {
            true => lengths::read(reader, lexer)?.len,
            false => ArrayLen::Runtime,
        };
        lexer.take(b',');
        types::expect(reader, lexer, b'>', "`>`")?;
        inner.insert(0, len);
        return Ok((kind, inner));
    }
    let mut parameters = Vec::new();
    if lexer.take(b'<') {
        while !lexer.take(b'>') {
            let token = lexer.next();
            match token.kind {
                Kind::Word => parameters.push(base(reader, lexer.text_of(token))),
                Kind::Sign(b',') => {}
                Kind::Number | Kind::Sign(_) | Kind::End => return Err(Refused),
            }
        }
    }
    Ok((kind(name, &parameters), Vec::new()))
}

/// The type that an alias stands for.
// Textures have no size, so `types` does not keep what they are: their names are resolved here
// again.
fn alias<'a>(reader: &ModuleReader<'a>, name: &str) -> Option<WgslLexer<'a>> {
    let item = &reader.outline.items[*reader.outline.names.get(name)?];
    let mut lexer = WgslLexer::new(reader.text, item.rest);
    (item.class == Class::Alias && lexer.take(b'=')).then_some(lexer)
}

/// The name of a scalar type behind aliases.
fn base<'a>(reader: &ModuleReader<'a>, name: &'a str) -> &'a str {
    let mut name = name;
    // An alias cannot stand for itself; the limit is for texts where it does.
    for _ in 0..32 {
        let Some(mut target) = alias(reader, name) else { break };
        let word = target.next();
        name = target.text_of(word);
    }
    name
}

// The first parameter is the sampled type or the texel format, the second the access mode (§6.5).
fn kind(name: &str, parameters: &[&str]) -> ResourceKind {
    match name {
        "sampler" => return ResourceKind::Sampler { comparison: false, filtering: true },
        "sampler_comparison" => {
            return ResourceKind::Sampler { comparison: true, filtering: true };
        }
        "texture_external" => return ResourceKind::ExternalTexture,
        "acceleration_structure" => return ResourceKind::AccelerationStructure,
        _ => {}
    }
    let Some(rest) = name.strip_prefix("texture_") else { return ResourceKind::Other };
    let (rest, storage) = stripped(rest, "storage_");
    let (rest, depth) = stripped(rest, "depth_");
    let (rest, multisampled) = stripped(rest, "multisampled_");
    let (dimension, arrayed) = match rest.strip_suffix("_array") {
        Some(rest) => (rest, true),
        None => (rest, false),
    };
    let dimension = match dimension {
        "1d" => Dimension::D1,
        "2d" => Dimension::D2,
        "3d" => Dimension::D3,
        "cube" => Dimension::Cube,
        _ => return ResourceKind::Other,
    };
    let sampled = match parameters.first() {
        _ if depth => Sampled::Depth,
        Some(&"i32") => Sampled::Sint,
        Some(&"u32") => Sampled::Uint,
        Some(_) | None => Sampled::Float,
    };
    let texture = Texture { sampled, dimension, arrayed, multisampled };
    if !storage {
        return ResourceKind::Texture(texture);
    }
    let access = match parameters.get(1) {
        Some(&"read") => Access::Read,
        Some(&"read_write") => Access::ReadWrite,
        Some(&"atomic") => Access::Atomic,
        Some(_) | None => Access::Write,
    };
    let format = parameters.first().and_then(|format| glsl_format(format));
    ResourceKind::StorageTexture { texture, format, access }
}

fn stripped<'t>(text: &'t str, prefix: &str) -> (&'t str, bool) {
    match text.strip_prefix(prefix) {
        Some(rest) => (rest, true),
        None => (text, false),
    }
}

/// A texel format in GLSL's spelling.
fn glsl_format(format: &str) -> Option<&'static str> {
    FORMATS.iter().find(|(wgsl, _)| *wgsl == format).map(|(_, glsl)| *glsl)
}

/// Texel formats (§6.5.1, and naga's extensions) with GLSL's spelling.
const FORMATS: &[(&str, &str)] = &[
    ("r8unorm", "r8"),
    ("r8snorm", "r8_snorm"),
    ("r8uint", "r8ui"),
    ("r8sint", "r8i"),
    ("r16unorm", "r16"),
    ("r16snorm", "r16_snorm"),
    ("r16uint", "r16ui"),
    ("r16sint", "r16i"),
    ("r16float", "r16f"),
    ("rg8unorm", "rg8"),
    ("rg8snorm", "rg8_snorm"),
    ("rg8uint", "rg8ui"),
    ("rg8sint", "rg8i"),
    ("r32uint", "r32ui"),
    ("r32sint", "r32i"),
    ("r32float", "r32f"),
    ("r64uint", "r64ui"),
    ("rg16unorm", "rg16"),
    ("rg16snorm", "rg16_snorm"),
    ("rg16uint", "rg16ui"),
    ("rg16sint", "rg16i"),
    ("rg16float", "rg16f"),
    ("rgba8unorm", "rgba8"),
    ("rgba8snorm", "rgba8_snorm"),
    ("rgba8uint", "rgba8ui"),
    ("rgba8sint", "rgba8i"),
    ("bgra8unorm", "bgra8"),
    ("rgb10a2uint", "rgb10_a2ui"),
    ("rgb10a2unorm", "rgb10_a2"),
    ("rg11b10ufloat", "r11f_g11f_b10f"),
    ("rg32uint", "rg32ui"),
    ("rg32sint", "rg32i"),
    ("rg32float", "rg32f"),
    ("rgba16unorm", "rgba16"),
    ("rgba16snorm", "rgba16_snorm"),
    ("rgba16uint", "rgba16ui"),
    ("rgba16sint", "rgba16i"),
    ("rgba16float", "rgba16f"),
    ("rgba32uint", "rgba32ui"),
    ("rgba32sint", "rgba32i"),
    ("rgba32float", "rgba32f"),
];
