//! Scenes and shaders of the repository, made ready to light, and their pictures.

use std::path::{Path, PathBuf};
use std::time::Duration;

use landfall_exec::backend::Backend;
use landfall_layout::Source;
use landfall_light::culling::{LightSet, Plan};
use landfall_light::reference::Model;
use landfall_light::render::truth::{Truth, truth};
use landfall_light::render::{RenderOptions, Rendered, Renderer, Work};
use landfall_light::scene::read_file;
use landfall_light::{Frame, FrameOptions, Scene, Upload};

fn shaders() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders")
}

/// A scene of the repository with a picture of that size.
pub fn scene(name: &str, size: [u32; 2]) -> Scene {
    let reading = read_file(shaders().join("scenes").join(name)).expect("a scene of ours");
    let scene = reading.scene.unwrap_or_else(|| panic!("{:?}", reading.diagnostics));
    Scene { size, ..scene }
}

/// A shader of the repository, by its path below `shaders`.
pub fn source(shader: &str) -> Source {
    let text = std::fs::read_to_string(shaders().join(shader));
    Source::new(shader, text.unwrap_or_else(|error| panic!("{shader}: {error}")))
}

pub fn renderer(source: &Source) -> Renderer {
    Renderer::new(source, &RenderOptions::default())
        .unwrap_or_else(|error| panic!("{}: {error}\n{}", source.path, source.text))
}

/// A scene with its fragments, and its lights as uploaded.
pub struct Made {
    pub scene: Scene,
    pub upload: Upload,
    pub frame: Frame,
}

impl Made {
    pub fn of(scene: Scene) -> Made {
        let frame = Frame::new(&scene, &FrameOptions::default());
        Made { upload: Upload::new(&scene), scene, frame }
    }

    pub fn work(&self) -> Work<'_> {
        let (upload, frame) = (&self.upload, &self.frame);
        let background = self.scene.background;
        Work { upload, frame, background, limit: Duration::from_secs(600) }
    }

    /// The picture with all lights.
    pub fn whole(&self, renderer: &Renderer, backend: &mut dyn Backend) -> Rendered {
        let all = LightSet::all(&self.upload.lights);
        self.by_plan(renderer, backend, &Plan::all_lights(self.frame.fragments.len(), all))
    }

    pub fn by_plan(&self, renderer: &Renderer, backend: &mut dyn Backend, plan: &Plan) -> Rendered {
        let rendered = renderer.render_plan(backend, &self.work(), plan, &mut |_, _| {});
        rendered.unwrap_or_else(|error| panic!("{}: {error}", backend.device().backend))
    }

    pub fn truth(&self, model: &Model) -> Truth {
        truth(model, &self.upload, &self.frame, self.scene.background)
    }
}

pub fn bits(rendered: &Rendered) -> Vec<[u32; 4]> {
    rendered.picture.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}
