//! Loads the scene and the shader of a render.

use landfall_check::walk::joined;
use landfall_layout::diagnostic::Code;
use std::path::{Path, PathBuf};

use landfall_layout::source::{Files, kind_of_path};
use landfall_layout::{Diagnostic, Error, Options, ReadOptions, Severity, Source};
use landfall_light::bind::BindError;
use landfall_light::culling::{Compiled, Setting};
use landfall_light::reference::Model;
use landfall_light::render::SceneShader;
use landfall_light::render::{RenderError, RenderOptions, Renderer};
use landfall_light::scene::{MAX_PIXELS, Reading, read_file};
use landfall_light::{FrameOptions, Scene};
use serde_json::{Map, Value};

use crate::args::{ReadArgs, RenderArgs};
use crate::output::{CommandFailure, FindingStyle, Streams};
use crate::{data, read, write};

#[derive(Clone)]
pub struct RenderRequest {
    pub scene: Scene,
    pub shader: Option<Source>,
    pub model: Option<Model>,
    pub frame: FrameOptions,
    reading: Reading,
    path: String,
    pub options: Options,
    entry: Option<String>,
    bind: Vec<(String, Map<String, Value>)>,
    /// The shader's files, for findings.
    files: Files,
}

/// The arguments about a scene and its shader; the fields are those of [`RenderArgs`].
pub struct RenderArguments<'a> {
    pub scene: &'a Path,
    pub shader: Option<PathBuf>,
    pub entry: Option<String>,
    pub size: Option<[u32; 2]>,
    pub model: Option<String>,
    pub bind: Vec<String>,
    pub read: &'a ReadArgs,
}

impl<'a> RenderArguments<'a> {
    /// Those of the command.
    pub fn new(args: &'a RenderArgs) -> Result<RenderArguments<'a>, Error> {
        let Some(scene) = &args.scene else {
            let given = "`landfall render SCENE.json --skip`";
            return Err(Error::new("SCENE.json", "is missing").with_help(match args.skip {
                Some(_) => format!("the scene is first, since `--skip` takes a value: {given}"),
                None => "name a scene".to_string(),
            }));
        };
        Ok(RenderArguments {
            scene,
            shader: args.shader.clone(),
            entry: args.entry.clone(),
            size: args.size,
            model: args.model.clone(),
            bind: args.bind.clone(),
            read: &args.read,
        })
    }
}

/// Reads the scene and the shader; reports errors in the scene.
pub fn load(
    args: &RenderArguments<'_>,
    streams: &Streams,
    style: &FindingStyle,
) -> Result<RenderRequest, CommandFailure> {
    let mut reading = read_file(args.scene)?;
    // The two arguments are easily confused, and a shader gives useless errors about JSON.
    if reading.scene.is_none() && kind_of_path(args.scene).is_some() {
        let shown = args.scene.display().to_string();
        return Err(Error::new(shown, "is a shader, not a scene")
            .with_help("name it in a scene, or call a function of it by `landfall run`")
            .into());
    }
    let found = style.text(&reading.diagnostics, &reading.files);
    let Some(mut scene) = reading.scene.take() else { return Err(CommandFailure::Findings(found)) };
    streams.report(&found);
    if let Some(size) = args.size {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        if pixels > MAX_PIXELS {
            let what = format!("is {pixels} pixels, but a picture has at most {MAX_PIXELS}");
            return Err(Error::new("--size", what).into());
        }
        scene.size = size;
    }
    let path = args.scene.display().to_string();
    let mut options = read::options(args.read);
    let named = SceneShader::new(&scene, &path)?;
    let (entry, frame) = (args.entry.clone().or(named.entry), named.frame);
    // The command line's macros are last and take precedence.
    options.read.defines.splice(0..0, named.defines);
    let own = named.path.map(|name| relative_to_scene(args.scene, &name));
    let shader = match args.shader.clone().or(own) {
        Some(file) => Some(read::shader_text(&file, args.read)?),
        None => None,
    };
    // `--model` comes before the model of the scene.
    let model = match (&args.model, &scene.model) {
        (Some(text), _) => Some(model("--model", model_json("--model", text)?)?),
        (None, Some(value)) => Some(model(&path, value.clone())?),
        (None, None) => None,
    };
    let mut bind = Vec::new();
    for text in &args.bind {
        bind.push((text.clone(), data::object("--bind", text)?));
    }
    let mut files = Files::default();
    if let Some(shader) = &shader {
        files.add(shader.path.clone(), shader.text.clone());
    }
    Ok(RenderRequest { scene, shader, model, frame, reading, path, options, entry, bind, files })
}

pub fn relative_to_scene(scene: &Path, name: &str) -> PathBuf {
    // Shorten `scenes/../lit.frag` to `lit.frag`, as in messages.
    joined(scene.parent().unwrap_or(Path::new("")), Path::new(name))
}

/// Parses the name of a model, or its JSON object.
pub fn model_json(option: &str, text: &str) -> Result<Value, Error> {
    match text.trim_start().starts_with('{') {
        true => data::value(option, text),
        false => Ok(Value::String(text.to_string())),
    }
}

pub fn model(about: &str, value: Value) -> Result<Model, Error> {
    serde_json::from_value(value).map_err(|error| {
        Error::new(about, format!("names an unknown lighting model: {error}"))
            .with_help("the models are `multi`, `array`, `view_space` and `casters`")
    })
}

impl RenderRequest {
    /// The shader with its bindings; `None` if none is named.
    pub fn renderer(&self) -> Result<Option<Renderer>, RenderError> {
        self.renderer_with(|_| {})
    }

    pub fn with_shader(&self, shader: Source) -> RenderRequest {
        let mut files = Files::default();
        files.add(shader.path.clone(), shader.text.clone());
        RenderRequest { shader: Some(shader), files, ..self.clone() }
    }

    /// The shader with its bindings, with changed options for reading it.
    pub fn renderer_with(
        &self,
        say: impl FnOnce(&mut ReadOptions),
    ) -> Result<Option<Renderer>, RenderError> {
        let Some(shader) = &self.shader else { return Ok(None) };
        // Those of the command line come last, and replace those of the scene.
        let bind = self.scene.bind.iter().chain(self.bind.iter().map(|(_, map)| map)).collect();
        let (mut layout, entry) = (self.options.clone(), self.entry.as_deref());
        say(&mut layout.read);
        Renderer::new(shader, &RenderOptions { layout, entry, bind }).map(Some)
    }

    /// The constants that a plan sets in the shader, except those already set.
    pub fn settings(&self, compiled: &Compiled) -> Vec<Setting> {
        let text = self.shader.as_ref().map_or("", |shader| &shader.text);
        let read = &self.options.read;
        let is_said = |setting: &Setting| {
            let mut names = read.defines.iter().chain(&read.overrides).map(|(name, _)| name);
            names.any(|name| *name == setting.name)
        };
        // A constant that the user set is left as it is.
        let mut settings = compiled.settings(text);
        settings.retain(|setting| !is_said(setting));
        settings
    }

    /// The files read: the scene, its meshes, the shader and its includes.
    pub fn files_read(&self) -> Vec<Files> {
        let shader = self.shader.iter().map(|shader| write::files_of(shader, &self.options));
        shader.chain([self.reading.files.clone()]).collect()
    }

    pub fn no_shader(&self) -> Error {
        Error::new(&self.path, "names no shader")
            .with_help("add `--shader FILE`, or `--reference` to render the model alone")
    }

    /// The failure of a command because of this one.
    pub fn failure(&self, error: &RenderError, style: &FindingStyle) -> CommandFailure {
        let (found, files) = self.findings(error);
        style.failure(&found, files)
    }

    /// Converts a failure to findings, with their files.
    fn findings(&self, error: &RenderError) -> (Vec<Diagnostic>, &Files) {
        let plain = |code, message, help, path: &str| Diagnostic {
            path: Some(path.to_string()),
            help,
            ..Diagnostic::without_place(code, Severity::Error, message)
        };
        let shader = self.shader.as_ref().map_or("", |shader| shader.path.as_str());
        match error {
            RenderError::Shader(found) => (found.clone(), &self.files),
            RenderError::Bind(error) => {
                let message = error.to_string();
                let mut found = plain(error.code(), message, error.help(), &self.path);
                let place = |path: &str| self.reading.place(path);
                let at = error.at().and_then(|path| place(&path)).or_else(|| match error {
                    // Generated lights have no place in the file; their count does.
                    BindError::TooManyLights { .. } => place("generate.lights.count"),
                    BindError::NoLights { .. }
                    | BindError::CameraElsewhere
                    | BindError::Undecided { .. }
                    | BindError::UnknownTarget { .. }
                    | BindError::UnknownQuantity { .. }
                    | BindError::Misfit { .. } => None,
                });
                if let Some(span) = at {
                    found.labels.push(landfall_layout::Label { at: span, text: String::new() });
                }
                (vec![found], &self.reading.files)
            }
            RenderError::Backend(failure) => {
                let mut found = plain(Code::Backend, failure.message.clone(), None, shader);
                // The log of a driver can be long; its first lines name the cause.
                found.notes.extend(failure.log.lines().take(8).map(str::to_string));
                (vec![found], &self.files)
            }
        }
    }
}
