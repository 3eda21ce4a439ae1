//! The kinds of textures and samplers, from their types (WGSL §6.5, §6.6).

use super::lengths;
use super::lexer::{Kind, WgslLexer};
use super::outline::Class;
use super::reader::{ModuleReader, TYPE_LEVEL};
use super::report::{self, Refused};
use crate::interface::{Access, Dimension, ResourceKind, Sampled, Texture};
use crate::shape::ArrayLen;
use crate::syntax::glsl::image_format;
use crate::syntax::stripped;

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
        return reader.deeper(report::span(word), TYPE_LEVEL, |reader| read(reader, &mut target));
    }
    if name == "binding_array" {
        reader.expect(lexer, b'<')?;
        let (kind, mut inner) =
            reader.deeper(report::span(word), TYPE_LEVEL, |reader| read(reader, lexer))?;
        let len = match lexer.take(b',') && !lexer.peek().is(b'>') {
            true => lengths::read(reader, lexer)?.len,
            false => ArrayLen::Runtime,
        };
        lexer.take(b',');
        reader.expect(lexer, b'>')?;
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
    let (rest, storage) = stripped(rest, rest.strip_prefix("storage_"));
    let (rest, depth) = stripped(rest, rest.strip_prefix("depth_"));
    let (rest, multisampled) = stripped(rest, rest.strip_prefix("multisampled_"));
    let (dimension, arrayed) = stripped(rest, rest.strip_suffix("_array"));
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

/// A texel format (§6.5.1, and naga's extensions) in GLSL's spelling: channels and bits, then the kind.
fn glsl_format(format: &str) -> Option<&'static str> {
    match format {
        // GLSL has no such format.
        "bgra8unorm" => return Some("bgra8"),
        "rg11b10ufloat" => return Some("r11f_g11f_b10f"),
        _ => {}
    }
    let kinds = [("unorm", ""), ("snorm", "_snorm"), ("uint", "ui"), ("sint", "i"), ("float", "f")];
    let (channels, kind) =
        kinds.iter().find_map(|(wgsl, glsl)| Some((format.strip_suffix(wgsl)?, glsl)))?;
    let channels = if channels == "rgb10a2" { "rgb10_a2" } else { channels };
    image_format(&format!("{channels}{kind}"))
}

#[cfg(test)]
mod tests {
    use super::glsl_format;

    #[test]
    fn texel_formats_are_those_of_glsl_by_another_name() {
        for (wgsl, glsl) in [
            ("r8unorm", "r8"),
            ("rg16snorm", "rg16_snorm"),
            ("r64uint", "r64ui"),
            ("rgba32sint", "rgba32i"),
            ("rgba16float", "rgba16f"),
            ("rgb10a2uint", "rgb10_a2ui"),
            ("rgb10a2unorm", "rgb10_a2"),
            ("rg11b10ufloat", "r11f_g11f_b10f"),
            ("bgra8unorm", "bgra8"),
        ] {
            assert_eq!(glsl_format(wgsl), Some(glsl));
        }
        assert!(
            ["r8", "rgb10a2float", "unorm", "R8unorm"].map(glsl_format).iter().all(Option::is_none)
        );
    }
}
