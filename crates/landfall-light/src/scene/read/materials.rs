//! Reads materials: colours, and small textures in the scene or in files.

use landfall_layout::diagnostic::Code;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::walk::{Object, SceneWalk, ValueAt, short};
use super::{FileOpener, MAX_PIXELS};
use crate::scene::{Material, Surface, Texture};
pub use landfall_layout::text::json::Value;

/// The default exponent of the highlight.
const SHININESS: f64 = 32.0;

pub(super) fn read(
    walk: &mut SceneWalk,
    root: &Object<'_>,
    open: &FileOpener<'_>,
) -> Option<Vec<Material>> {
    let Some(at) = root.get("materials") else { return Some(Vec::new()) };
    let mut names: HashMap<String, String> = HashMap::new();
    let mut materials = Vec::new();
    // Reading goes on after an invalid material, so that all errors are told.
    let mut whole = true;
    for at in walk.list(&at)? {
        let Some(material) = material(walk, &at, open) else {
            whole = false;
            continue;
        };
        if let Some(first) = names.get(&material.name) {
            let what = format!("has the same name as `{first}`, so objects cannot refer to it");
            walk.error(Code::GivenTwice, &at, what);
            whole = false;
        }
        names.insert(material.name.clone(), at.path.clone());
        materials.push(material);
    }
    whole.then_some(materials)
}

fn material(walk: &mut SceneWalk, at: &ValueAt<'_>, open: &FileOpener<'_>) -> Option<Material> {
    let known = &["name", "ambient", "diffuse", "specular", "shininess", "reflectance"];
    let object = walk.object(at, known)?;
    let name = walk.needed(&object, "name").and_then(|at| walk.text(&at));
    let diffuse = walk.needed(&object, "diffuse").and_then(|at| surface(walk, &at, open));
    let ambient = match object.get("ambient") {
        Some(at) => surface(walk, &at, open),
        None => diffuse.clone(),
    };
    let black = Surface::Constant(DVec3::ZERO);
    let specular = object.or("specular", black, |at| surface(walk, at, open));
    let shininess = object.or("shininess", SHININESS, |at| shininess(walk, at));
    let reflectance = object.or("reflectance", 1.0, |at| {
        walk.not_negative(at, Code::ValueOutOfRange, "a reflectance is 0 or more")
    });
    Some(Material {
        name: name?.to_string(),
        ambient: ambient?,
        diffuse: diffuse?,
        specular: specular?,
        shininess: shininess?,
        reflectance: reflectance?,
    })
}

fn shininess(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<f64> {
    let why = "a negative power makes the highlight grow where there should be none";
    let shininess = walk.not_negative(at, Code::ValueOutOfRange, why)?;
    if shininess == 0.0 {
        let what = "is 0: where the base of the highlight is 0, `pow(0, 0)` is undefined";
        walk.warning(Code::ZeroShininess, at, what);
    }
    Some(shininess)
}

fn surface(walk: &mut SceneWalk, at: &ValueAt<'_>, open: &FileOpener<'_>) -> Option<Surface> {
    match at.node.value {
        Value::Object(_) => texture(walk, at, open).map(Surface::Texture),
        Value::Number(_) | Value::List(_) => walk.color(at).map(Surface::Constant),
        Value::Null | Value::Bool(_) | Value::Text(_) => {
            walk.kind(at, "a colour, or an object with `checker`, `rows` or `png`");
            None
        }
    }
}

fn texture(walk: &mut SceneWalk, at: &ValueAt<'_>, open: &FileOpener<'_>) -> Option<Texture> {
    let object = walk.object(at, &["checker", "cells", "rows", "palette", "png", "srgb"])?;
    // Bytes are linear unless the scene says that they are sRGB.
    let srgb = object.or("srgb", false, |at| walk.boolean(at));
    let given: Vec<&str> =
        object.keys().filter(|key| matches!(*key, "checker" | "rows" | "png")).collect();
    let [kind] = given[..] else {
        let what = if given.is_empty() { "has no image" } else { "has more than one image" };
        walk.error(Code::WrongTexture, at, what).help =
            Some("give one of `checker`, `rows` and `png`".to_string());
        return None;
    };
    let others: &[(&str, &str)] = match kind {
        "checker" => &[("palette", "rows")],
        "rows" => &[("cells", "checker")],
        _ => &[("cells", "checker"), ("palette", "rows")],
    };
    for (key, of) in others {
        if let Some(at) = object.get(key) {
            walk.error(Code::WrongTexture, &at, format!("belongs to `{of}`, not to `{kind}`"));
        }
    }
    let shown = object.get(kind)?;
    let (size, texels) = match kind {
        "checker" => checker(walk, &object, &shown)?,
        "rows" => rows(walk, &object, &shown)?,
        _ => png(walk, &shown, open)?,
    };
    Some(Texture { width: size[0], height: size[1], texels, srgb: srgb? })
}

type Image = ([u32; 2], Vec<[u8; 3]>);

/// Reads a checkerboard of two colours, one texel per square.
fn checker(walk: &mut SceneWalk, object: &Object<'_>, at: &ValueAt<'_>) -> Option<Image> {
    let colors: [ValueAt<'_>; 2] = walk.items(at)?;
    let colors = colors.map(|at| texel(walk, &at));
    let cells = object.or("cells", 2, |at| walk.whole(at, 1..=1024));
    let (colors, cells) = ([colors[0]?, colors[1]?], cells?);
    let color = |row: u32| move |column: u32| colors[((row + column) % 2) as usize];
    Some(([cells, cells], (0..cells).flat_map(|row| (0..cells).map(color(row))).collect()))
}

/// Reads rows of letters, each letter a colour of the palette.
fn rows(walk: &mut SceneWalk, object: &Object<'_>, at: &ValueAt<'_>) -> Option<Image> {
    let palette = palette(walk, object);
    let rows = walk.list(at)?;
    let palette = palette?;
    let mut texels = Vec::new();
    let mut width = None;
    for at in &rows {
        let row = walk.text(at)?;
        let len = row.chars().count();
        let first = *width.get_or_insert(len);
        if len != first {
            let what = format!("is {len} texels long, but the first row {first}");
            walk.error(Code::WrongCount, at, what);
            return None;
        }
        for letter in row.chars() {
            let Some(texel) = palette.get(&letter) else {
                walk.error(
                    Code::WrongTexture,
                    at,
                    format!("has {letter:?}, which `palette` lacks"),
                );
                return None;
            };
            texels.push(*texel);
        }
        // After each row, before the memory is full.
        fits(walk, at, texels.len() as u64)?;
    }
    if texels.is_empty() {
        walk.error(Code::WrongCount, at, "has no texel");
        return None;
    }
    Some(([width.unwrap_or(0) as u32, rows.len() as u32], texels))
}

fn palette(walk: &mut SceneWalk, object: &Object<'_>) -> Option<HashMap<char, [u8; 3]>> {
    let at = walk.needed(object, "palette")?;
    let Value::Object(entries) = &at.node.value else {
        walk.kind(&at, "an object of letters with their colours");
        return None;
    };
    let mut palette = HashMap::new();
    for (key, _, node) in entries {
        let entry = ValueAt { node, path: format!("{}.{}", at.path, short(key)) };
        let mut letters = key.chars();
        let (Some(letter), None) = (letters.next(), letters.next()) else {
            walk.error(Code::WrongTexture, &entry, "is not a single letter");
            return None;
        };
        palette.insert(letter, texel(walk, &entry)?);
    }
    Some(palette)
}

fn texel(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<[u8; 3]> {
    let items: [ValueAt<'_>; 3] = walk.items(at)?;
    let channels = items.map(|at| walk.whole(&at, 0..=255).map(|channel| channel as u8));
    Some([channels[0]?, channels[1]?, channels[2]?])
}

fn fits(walk: &mut SceneWalk, at: &ValueAt<'_>, texels: u64) -> Option<()> {
    if texels <= MAX_PIXELS {
        return Some(());
    }
    let what = format!("makes {texels} texels, but a texture has at most {MAX_PIXELS}");
    walk.error(Code::TooLarge, at, what);
    None
}

fn png(walk: &mut SceneWalk, at: &ValueAt<'_>, open: &FileOpener<'_>) -> Option<Image> {
    let name = walk.text(at)?;
    let bytes = match open(name) {
        Ok(bytes) => bytes,
        Err(error) => {
            walk.error(Code::UnreadableFile, at, error.message).help = error.help;
            return None;
        }
    };
    // Without its bytes, which are no text: the file is an input, as meshes are.
    let scene = walk.files.get(0).map(|file| Path::new(&file.path).with_file_name(name));
    walk.files.add(scene.unwrap_or_default().display().to_string(), Arc::from(""));
    match decode_png(&bytes) {
        Ok(image) => Some(image),
        Err(why) => {
            walk.error(Code::WrongTexture, at, format!("is not a readable PNG: {why}"));
            None
        }
    }
}

/// Decodes a PNG: alpha is dropped, grey becomes colour, 16 bits become 8.
fn decode_png(bytes: &[u8]) -> Result<Image, String> {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let (width, height) = (reader.info().width, reader.info().height);
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(format!("{width} x {height} texels are more than {MAX_PIXELS}"));
    }
    let len = reader.output_buffer_size().ok_or("its size overflows")?;
    let mut buffer = vec![0; len];
    let frame = reader.next_frame(&mut buffer).map_err(|error| error.to_string())?;
    let samples = frame.color_type.samples();
    let texel = |texel: &[u8]| match *texel {
        [red, green, blue, ..] => [red, green, blue],
        [grey, ..] => [grey; 3],
        [] => [0; 3],
    };
    let texels = buffer[..frame.buffer_size()].chunks_exact(samples).map(texel).collect();
    Ok(([width, height], texels))
}
