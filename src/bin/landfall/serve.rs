//! `landfall serve`: the playground with files that are read again when they change.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use data_encoding::BASE64;
use landfall_check::files;
use landfall_layout::buffer::read_json;
use landfall_layout::{Error, Options, ReadOptions, Source, layout, other_language, source};
use landfall_light::render::SceneShader;
use landfall_light::scene;
use landfall_web::playground::page::Opened;
use landfall_web::serve::{ServedFiles, serve};
use serde::Serialize;

use crate::args::ServeArgs;
use crate::output::{CommandFailure, Outcome, Streams};
use crate::render::request::relative_to_scene;
use crate::watch;

/// Time between two looks at the interrupt flag.
const INTERVAL: Duration = Duration::from_millis(20);

pub fn run(args: &ServeArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    // It ends by Ctrl-C, even while it reads its files.
    watch::end_with(Outcome::Clean);
    let include_dirs: Vec<String> =
        args.include_dirs.iter().map(|dir| dir.display().to_string()).collect();
    let files = Files::open(args, streams)?;
    let opened = Opened {
        files: files.paths(),
        defines: args.defines.iter().map(|(name, text)| format!("{name}={text}")).collect(),
        include_dirs: &include_dirs,
    };
    let served = serve(args.port, &opened, files)?;
    streams.product(&format!("{}\n", served.url))?;
    streams.finish()?;
    streams.notes("open this address in a browser; Ctrl-C ends the server\n");
    while !watch::is_stopped() {
        std::thread::sleep(INTERVAL);
    }
    Ok(Outcome::Clean)
}

struct Files {
    options: Options,
    /// Raised by every change.
    version: u64,
    files: Vec<NamedFile>,
}

/// A named file: a shader, or a scene with its shader.
#[derive(Serialize)]
struct NamedFile {
    path: String,
    shader: String,
    /// Its text.
    text: String,
    /// Its includes: paths and texts.
    includes: Vec<(String, String)>,
    scene: Option<String>,
    /// The meshes and textures that the scene names: names, and bytes in base64.
    assets: Vec<(String, String)>,
    /// Why it could not be read.
    error: Option<String>,
    #[serde(skip)]
    stamps: Vec<ReadFile>,
}

impl NamedFile {
    /// A file that cannot be read now.
    fn unread(path: &Path, error: &Error) -> NamedFile {
        let shown = path.display().to_string();
        NamedFile {
            path: shown.clone(),
            shader: shown,
            text: String::new(),
            includes: Vec::new(),
            scene: None,
            assets: Vec::new(),
            error: Some(told(error)),
            stamps: vec![ReadFile::from_path(path)],
        }
    }
}

/// An error in one line.
fn told(Error { path, message, .. }: &Error) -> String {
    format!("{path} {message}")
}

/// A file as it was when it was read.
#[derive(PartialEq)]
struct ReadFile {
    path: PathBuf,
    state: Option<(SystemTime, u64)>,
}

impl ReadFile {
    fn from_path(path: &Path) -> ReadFile {
        let found = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file);
        // Only ordinary files: a directory of the name counts as missing.
        let state = found.and_then(|found| Some((found.modified().ok()?, found.len())));
        ReadFile { path: path.to_path_buf(), state }
    }
}

impl Files {
    /// Reads the named files, and says which cannot be read.
    ///
    /// # Errors
    ///
    /// None can be read.
    fn open(args: &ServeArgs, streams: &Streams) -> Result<Files, Error> {
        let mut read = ReadOptions::default();
        read.defines.clone_from(&args.defines);
        read.include_dirs.clone_from(&args.include_dirs);
        let options = Options::default().with_read(read);
        let mut files = Vec::new();
        let mut errors = Vec::new();
        for path in &args.files {
            files.push(read_file(path, &options).unwrap_or_else(|error| {
                let file = NamedFile::unread(path, &error);
                errors.push(error);
                file
            }));
        }
        // A file that cannot be read may still be written while the server runs, unless there is
        // nothing to show at all.
        if !errors.is_empty() && errors.len() == files.len() {
            return Err(errors.swap_remove(0));
        }
        for error in errors {
            streams.finding(error.into());
        }
        Ok(Files { options, version: 1, files })
    }

    fn paths(&self) -> Vec<String> {
        self.files.iter().map(|file| file.path.clone()).collect()
    }

    fn read_again(&mut self) {
        for file in &mut self.files {
            if file.stamps.iter().all(|stamp| ReadFile::from_path(&stamp.path) == *stamp) {
                continue;
            }
            // Raised also by a failure, of which the page is to be told.
            self.version += 1;
            match read_file(Path::new(&file.path), &self.options) {
                Ok(read) => *file = read,
                Err(error) => {
                    // The page keeps the text it has.
                    file.error = Some(told(&error));
                    // Only the named file is watched then, since its includes are not known.
                    file.stamps = vec![ReadFile::from_path(Path::new(&file.path))];
                }
            }
        }
    }
}

impl ServedFiles for Files {
    fn look(&mut self) -> u64 {
        self.read_again();
        self.version
    }

    fn json(&self) -> String {
        serde_json::to_string(&self.files).expect("keys are strings")
    }

    fn save(&self, path: &str, text: &str) -> Result<(), Error> {
        // Only scenes are saved, and only those that the command named: the page can write no
        // other file.
        if !self.files.iter().any(|file| file.path == path && file.scene.is_some()) {
            return Err(Error::new(path, "is no scene of this server"));
        }
        // Broken text would be refused when it is read again, and the scene be lost.
        read_json(text).map_err(|cause| Error::new(path, format!("would not be JSON: {cause}")))?;
        files::writer().write(Path::new(path), text).map(drop)
    }
}

fn read_file(path: &Path, options: &Options) -> Result<NamedFile, Error> {
    match path.extension().is_some_and(|end| end == "json") {
        true => read_scene(path, options),
        false => read_shader(path, options),
    }
}

fn read_shader(path: &Path, options: &Options) -> Result<NamedFile, Error> {
    // Before it is read: a change in between is seen at the next look.
    let mut stamps = vec![ReadFile::from_path(path)];
    let shown = path.display().to_string();
    other_language::refuse(path)?;
    let read = Source::from_bytes(shown.as_str(), source::read_bytes(path, None)?)?;
    let shader = layout(&read, options);
    let included = shader.files.iter().skip(1).filter(|file| !file.path.starts_with("-D "));
    let mut includes = Vec::new();
    for file in included {
        stamps.push(ReadFile::from_path(Path::new(&file.path)));
        includes.push((file.path.clone(), file.text.to_string()));
    }
    Ok(NamedFile {
        path: shown.clone(),
        shader: shown,
        text: read.text.to_string(),
        includes,
        scene: None,
        assets: Vec::new(),
        error: None,
        stamps,
    })
}

/// Reads a scene, its shader, and the files that it names.
fn read_scene(path: &Path, options: &Options) -> Result<NamedFile, Error> {
    let mut stamps = vec![ReadFile::from_path(path)];
    let text = files::text(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    // The page gets the files that reading the scene opens, under the names that the scene has for
    // them.
    let opened = RefCell::new(Vec::new());
    let open = |name: &str| {
        let bytes = files::bytes(&folder.join(name))?;
        opened.borrow_mut().push((name.to_string(), bytes.clone()));
        Ok(bytes)
    };
    let shown = path.display().to_string();
    let reading = scene::read(&shown, &text, &open);
    let Some(scene) = reading.scene else {
        let found = reading.diagnostics.into_iter().map(|found| found.message).collect::<Vec<_>>();
        return Err(Error::new(shown, format!("is not a scene: {}", found.join("; "))));
    };
    let Some(shader) = SceneShader::new(&scene, &shown)?.path else {
        return Err(Error::new(shown, "names no shader"));
    };
    let shader = read_shader(&relative_to_scene(path, &shader), options)?;
    stamps.extend(shader.stamps);
    let mut assets = Vec::new();
    for (name, bytes) in opened.into_inner() {
        stamps.push(ReadFile::from_path(&folder.join(&name)));
        assets.push((name, BASE64.encode(&bytes)));
    }
    Ok(NamedFile { path: shown, scene: Some(text), assets, stamps, ..shader })
}
