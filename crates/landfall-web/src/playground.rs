//! The engine of the playground: answers requests in JSON with what the commands print for the text
//! of a shader.
//!
//! `landfall serve` calls it for its page, `landfall-web` makes WebAssembly of it. No file is read:
//! a request holds the text of its shader and of what that includes.

mod answers;
mod check;
pub mod page;
#[cfg(feature = "exec")]
mod run;
#[cfg(feature = "exec")]
mod scene;

use std::sync::Arc;

use landfall_layout::source::Target;
use landfall_layout::{Error, Language, Options, ReadOptions, Rules, Source, Stage};
use landfall_lint::settings::Target as Limits;
use serde::{Deserialize, Serialize};

pub use answers::Output;

/// The most bytes of a request.
pub const MAX_BYTES: usize = 8 << 20;

/// The text of a shader, how to read it, and what is asked of it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Request {
    /// The path in messages, which gives the language and the stage as in the commands.
    path: String,
    text: String,
    /// What the text includes: paths and texts.
    files: Vec<(String, String)>,
    language: Option<String>,
    stage: Option<String>,
    /// Macros as `NAME` or `NAME=TEXT`.
    defines: Vec<String>,
    /// The directories of `#include`, for the paths of `files`.
    include_dirs: Vec<String>,
    /// Target APIs, as in `--target`.
    targets: Vec<String>,
    rules: Option<String>,
    gather: bool,
    want: Vec<Want>,
}

/// One question about the shader.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
enum Want {
    /// The blocks as the page of `report` draws them, and the findings.
    Map,
    /// `landfall layout --format FORMAT`.
    Layout { format: String },
    /// `landfall check --format FORMAT`.
    Check { format: String },
    /// `landfall emit --lang LANG`.
    Emit { lang: String },
    /// The functions that `run` may call.
    #[cfg(feature = "exec")]
    Functions,
    /// The inputs of a stage of GLSL, with values that fit.
    #[cfg(feature = "exec")]
    Inputs,
    /// `landfall run --fn FUNCTION`.
    #[cfg(feature = "exec")]
    Run(run::RunRequest),
    /// What a browser needs to draw a scene with the shader.
    #[cfg(feature = "exec")]
    Scene(scene::SceneRequest),
}

/// Returns the answers to a request as `{"answers": […]}`, one for each thing wanted, or
/// `{"error": "…"}` for a request that cannot be answered.
pub fn answer(request: &str) -> String {
    match answers(request) {
        Ok(answers) => format!("{{\"answers\":[{}]}}", answers.join(",")),
        Err(error) => {
            let help = error.help.map(|help| format!(": {help}")).unwrap_or_default();
            format!("{{\"error\":{}}}", json(&format!("{} {}{help}", error.path, error.message)))
        }
    }
}

fn answers(request: &str) -> Result<Vec<String>, Error> {
    if request.len() > MAX_BYTES {
        return Err(Error::new("the request", format!("has more than {MAX_BYTES} bytes")));
    }
    let request: Request = serde_json::from_str(request)
        .map_err(|cause| Error::new("the request", format!("cannot be read: {cause}")))?;
    let (source, options) = (request.source()?, request.options()?);
    let answer = |want: &Want| match want {
        Want::Map => {
            let findings = check::findings(&request, &source)?;
            Ok(answers::map(&request, &source, &options, &findings))
        }
        Want::Layout { format } => Ok(json(&answers::layout(&source, &options, format)?)),
        Want::Check { format } => Ok(json(&check::output(&request, &source, format)?)),
        Want::Emit { lang } => Ok(json(&answers::emit(&source, &options, lang)?)),
        #[cfg(feature = "exec")]
        Want::Functions => Ok(json(&run::functions(&source, &options))),
        #[cfg(feature = "exec")]
        Want::Inputs => Ok(json(&run::inputs(&source, &options))),
        #[cfg(feature = "exec")]
        Want::Run(given) => Ok(json(&run::run(&source, &options, given)?)),
        #[cfg(feature = "exec")]
        Want::Scene(given) => scene::scene(given, &source, &options),
    };
    request.want.iter().map(answer).collect()
}

impl Request {
    fn source(&self) -> Result<Source, Error> {
        let mut source = Source::from_bytes(self.path.as_str(), self.text.clone().into_bytes())?;
        match self.language.as_deref() {
            Some("glsl") => source.language = Language::Glsl,
            Some("wgsl") => source.language = Language::Wgsl,
            Some(other) => return Err(unknown("--language", other)),
            None => {}
        }
        let stage = match self.stage.as_deref() {
            Some(name) => Some(Stage::from_name(name).ok_or_else(|| unknown("--stage", name))?),
            None => None,
        };
        source.stage = match source.language {
            Language::Glsl => stage.or(source.stage),
            Language::Wgsl | Language::SpirV => None,
        };
        Ok(source)
    }

    fn options(&self) -> Result<Options, Error> {
        let mut read = ReadOptions::default();
        for define in &self.defines {
            let (name, text) = define.split_once('=').unwrap_or((define, "1"));
            let mut letters = name.chars();
            let starts = letters.next().is_some_and(|c| c == '_' || c.is_ascii_alphabetic());
            if !starts || !letters.all(|c| c == '_' || c.is_ascii_alphanumeric()) {
                let error = Error::new("-D", format!("cannot define `{define}`"));
                return Err(error.with_help("a macro is NAME or NAME=TEXT"));
            }
            read.defines.push((name.to_string(), text.to_string()));
        }
        let dialects: Vec<Target> = self
            .targets
            .iter()
            .filter_map(|name| dialect(name).transpose())
            .collect::<Result<_, _>>()?;
        read.target = dialects.first().copied().filter(|first| dialects.iter().all(|d| d == first));
        read.include_dirs = self.include_dirs.iter().map(Into::into).collect();
        read.files = Some(self.files.clone());
        let rules = match self.rules.as_deref() {
            Some(name) => Some(Rules::from_name(name).ok_or_else(|| unknown("--rules", name))?),
            None => None,
        };
        Ok(Options::default().with_read(read).with_rules(rules).with_gather(self.gather))
    }

    /// The text of a file by its path in findings.
    fn text_of(&self, source: &Source, path: &str) -> Option<Arc<str>> {
        let own = (path == source.path).then(|| source.text.clone());
        let other = || self.files.iter().find(|(other, _)| other == path);
        own.or_else(|| other().map(|(_, text)| Arc::from(text.as_str())))
    }

    /// The APIs whose limits apply.
    fn limits(&self) -> Vec<Limits> {
        self.targets.iter().filter_map(|name| Limits::from_name(name)).collect()
    }
}

/// The dialect of GLSL that a target implies.
fn dialect(target: &str) -> Result<Option<Target>, Error> {
    match target {
        "opengl" => Ok(Some(Target::OpenGl)),
        name => match Limits::from_name(name) {
            Some(Limits::Gl33 | Limits::Gles30 | Limits::WebGl2) => Ok(Some(Target::OpenGl)),
            Some(Limits::Vulkan) => Ok(Some(Target::Vulkan)),
            Some(Limits::WebGpu) => Ok(None),
            None => Err(unknown("--target", name)),
        },
    }
}

fn unknown(option: &str, value: &str) -> Error {
    Error::new(option, format!("has no value `{value}`"))
}

fn json<T: Serialize + ?Sized>(value: &T) -> String {
    serde_json::to_string(value).expect("keys are strings")
}
