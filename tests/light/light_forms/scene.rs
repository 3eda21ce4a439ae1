//! Scenes for whole fragment shaders: values of blocks by path, fragments, and the run in `f64`.
//!
//! Used by `agree`.

use landfall_exec::backend::{Resource, ResourceKind};
use landfall_interp::{Invocations, Port, Precision, Program, Settings};
use landfall_ir::Module;
use landfall_ir::module::HandleKind;
use landfall_layout::buffer::Buffer;
use landfall_layout::shape::ArrayLen;
use landfall_layout::{Language, Options, Source, Stage};

/// A value of a member.
#[derive(Clone, Copy, Debug)]
pub enum Number {
    One(f32),
    Three([f32; 3]),
    Four([f32; 4]),
    Count(u32),
}

/// A member: the block it is in, or any, the paths it has in one language or another, its value.
#[derive(Clone, Debug)]
pub struct Member {
    pub block: Option<&'static str>,
    pub paths: Vec<String>,
    pub value: Number,
}

/// Values for a family of shaders, and fragments.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub members: Vec<Member>,
    /// Places and normals, and what they are called.
    pub places: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    /// Parts of the names of textures, and their colours.
    pub textures: Vec<(&'static str, [f32; 4])>,
}

impl Scene {
    /// A member of any block.
    pub fn set(&mut self, paths: &[&str], value: Number) {
        self.put(None, paths, value);
    }

    /// A member of one block.
    pub fn put(&mut self, block: Option<&'static str>, paths: &[&str], value: Number) {
        let paths = paths.iter().map(|path| path.to_string()).collect();
        self.members.push(Member { block, paths, value });
    }
}

fn put(buffer: &mut Buffer, path: &str, value: Number) -> bool {
    let set = match value {
        Number::One(x) => buffer.set(path, x),
        Number::Three(x) => buffer.set(path, x),
        Number::Four(x) => buffer.set(path, x),
        Number::Count(x) => match buffer.set(path, x) {
            Ok(()) => Ok(()),
            Err(_) => buffer.set(path, x as i32),
        },
    };
    set.is_ok()
}

/// What is bound; a member that no block has fails.
fn resources(file: &str, module: &Module, scene: &Scene, tail: usize) -> Vec<Resource> {
    let mut known = vec![false; scene.members.len()];
    let mut all = Vec::new();
    for block in module.blocks() {
        let open = block.layout.members.iter().any(|m| m.dims.contains(&ArrayLen::Runtime));
        let buffer = match open {
            true => Buffer::with_tail(&block.layout, tail),
            false => Buffer::new(&block.layout),
        };
        let mut buffer = buffer.expect("the block is laid out");
        for (member, known) in scene.members.iter().zip(&mut known) {
            let here = member.block.is_none_or(|name| *block.layout.name == *name);
            *known |= here && member.paths.iter().any(|path| put(&mut buffer, path, member.value));
        }
        let bytes = buffer.into_bytes();
        let kind = match block.layout.space {
            landfall_layout::AddressSpace::Storage => {
                ResourceKind::Storage { bytes, writable: false }
            }
            _ => ResourceKind::Uniform(bytes),
        };
        let (group, binding) = (block.group, block.binding);
        all.push(Resource { name: block.layout.name.to_string(), group, binding, kind });
    }
    for (member, known) in scene.members.iter().zip(known) {
        assert!(known, "{file} has no {:?}", member.paths);
    }
    for handle in module.handles() {
        let kind = match handle.kind {
            HandleKind::Texture | HandleKind::Image => {
                let path = handle.path.to_lowercase();
                let colour = scene.textures.iter().find(|(part, _)| path.contains(part));
                let colour = colour.map_or([1.0; 4], |(_, colour)| *colour);
                ResourceKind::Texture { width: 1, height: 1, texels: vec![colour] }
            }
            HandleKind::Sampler => ResourceKind::Sampler,
        };
        let (group, binding) = (handle.group, handle.binding);
        all.push(Resource { name: handle.path.clone(), group, binding, kind });
    }
    all
}

/// Red, green and blue of each fragment in `f64`, and what was undefined.
pub fn light(file: &str, scene: &Scene) -> (Vec<[f64; 3]>, Vec<String>) {
    light_with(file, scene, &[])
}

/// The same of a shader some of whose numbers are known before: macros of GLSL, overrides of WGSL.
pub fn light_with(
    file: &str,
    scene: &Scene,
    known: &[(&str, i32)],
) -> (Vec<[f64; 3]>, Vec<String>) {
    let source = Source::read(file).expect("the shader is there");
    let mut options = Options::default();
    if source.language == Language::Glsl {
        options.read.defines =
            known.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
    }
    let overrides: Vec<(String, f64)> =
        known.iter().map(|(name, value)| (name.to_string(), f64::from(*value))).collect();
    let module = Module::new(&source, &options).unwrap_or_else(|f| panic!("{f:?}"));
    let entries = module.entry_points();
    let entry = entries.iter().find(|e| e.stage == Stage::Fragment).expect("a fragment stage");
    let column = |all: &[[f32; 3]]| -> Vec<Vec<u64>> {
        (0..3).map(|i| all.iter().map(|v| u64::from(v[i].to_bits())).collect()).collect()
    };
    let port = |name: &str, other: u32| {
        let input = module.inputs().iter().find(|i| i.name.to_lowercase().contains(name));
        Port::Location(input.map_or(other, |i| i.location))
    };
    let invocations = Invocations {
        count: scene.places.len(),
        inputs: vec![
            (port("pos", 0), column(&scene.places)),
            (port("normal", 1), column(&scene.normals)),
        ],
    };
    let settings =
        Settings { precision: Precision::Double, watch: true, threads: 1, ..Settings::default() };
    let bound = resources(file, &module, scene, 8);
    let outputs = Program::new(&module, &overrides)
        .run_entry(&entry.name, &invocations, &bound, &settings)
        .unwrap_or_else(|failure| panic!("{file}: {failure:?}"));
    let colour = &outputs.ports[0].1.doubles;
    let colours = (0..invocations.count).map(|i| [colour[0][i], colour[1][i], colour[2][i]]);
    // That GLSL's accumulators start as nothing is what `uninitialised` is about; the evaluator has zeros.
    let undefined = outputs.notes.undefined.iter();
    let undefined = undefined.map(|u| format!("{:?}", u.kind)).filter(|u| u != "Uninitialised");
    (colours.collect(), undefined.collect())
}
