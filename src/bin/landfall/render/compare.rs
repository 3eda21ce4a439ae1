//! `--compare`: compares the picture with the reference, another backend or a file.

use landfall_check::files;
use std::path::Path;

use clap::ValueEnum as _;
use landfall::report::render::Compared;
use landfall_layout::Error;
use landfall_light::picture::compare::{Compare, compare_and_map};
use landfall_light::picture::difference::{amplification, difference, flip_picture};
use landfall_light::picture::{Picture, file, png};
use landfall_light::reference::Model;

use super::lighting::Lighting;
use super::{PreparedScene, RenderStop, transfer};
use crate::args::{BackendName, RenderArgs};
use crate::output::Streams;

/// A comparison, and pictures of the difference with their file names.
pub struct ComparisonOutput {
    pub compared: Compared,
    pub pictures: Vec<(String, Picture)>,
    /// The model of the reference and whether it was given, for a comparison with the reference.
    pub model: Option<(Model, bool)>,
}

pub fn needs_shader(what: &[String]) -> bool {
    what.iter().any(|what| BackendName::from_str(what, true).is_ok())
}

/// The files of the pictures of a difference.
fn files(out: &Path, what: &str) -> [String; 2] {
    let stem = out.with_extension("");
    let name = Path::new(what).file_stem().unwrap_or_default().to_string_lossy().to_string();
    ["difference", "flip"].map(|kind| format!("{}.{name}.{kind}.png", stem.display()))
}

/// Fails if a picture of a difference would overwrite a file that landfall did not write.
pub fn refuse_foreign(out: &Path, compare: &[String]) -> Result<(), Error> {
    for path in compare.iter().flat_map(|what| files(out, what)) {
        let is_foreign = Path::new(&path).symlink_metadata().is_ok()
            // landfall marks its pictures of differences, so a rerun replaces its own.
            && !files::file(Path::new(&path)).is_some_and(|bytes| png::is_landfalls(&bytes));
        if is_foreign {
            let message = "exists and is not a picture of landfall";
            let help = "move it, or choose another name for `--out`";
            return Err(Error::unwritten(path, message).with_help(help));
        }
    }
    Ok(())
}

pub fn compare(
    made: &PreparedScene<'_>,
    what: &str,
    picture: &Picture,
    args: &RenderArgs,
    streams: &Streams,
) -> Result<ComparisonOutput, RenderStop> {
    let (mut leave_out, mut hazards, mut model) = (None, Vec::new(), None);
    let backend = BackendName::from_str(what, true).ok();
    let other = match (what, backend) {
        ("reference", _) => {
            // Without a given model, the one nearest to the picture is taken.
            let (truth, nearest) = made.truth_near(picture)?;
            model = Some(nearest);
            // Left out are pixels without a defined colour, and those at a hard edge, where
            // rounding decides.
            hazards = Compared::hazards(&truth);
            leave_out = Some(truth.leave_out);
            truth.picture
        }
        (_, Some(name)) => {
            // The whole scene is lit again, without a plan: a plan of the first picture must not
            // hide a difference.
            let mut lighting = Lighting::open(name, args, made, streams)?;
            lighting.light_all(made)?.rendered.picture
        }
        (path, None) => {
            let bytes = files::bytes(Path::new(path))?;
            let format = file::PictureFormat::from_path(path);
            let read = format.and_then(|format| file::read(&bytes, format, transfer(args)));
            read.map_err(|error| Error::new(path, error.to_string()))?
        }
    };
    let options = Compare { transfer: transfer(args), leave_out: leave_out.as_deref() };
    let wrong = |error: landfall_light::picture::PictureError| Error::new(what, error.to_string());
    let (comparison, map) = compare_and_map(&other, picture, &options).map_err(wrong)?;
    let mut pictures = Vec::new();
    if let Some(out) = &args.out {
        let amplify = amplification(comparison.linear.max);
        let [of_difference, of_flip] = files(out, what);
        let mut drawn = difference(&other, picture, amplify).map_err(wrong)?;
        // Pixels that were left out are dark blue.
        for (pixel, left_out) in drawn.pixels.iter_mut().zip(leave_out.iter().flatten()) {
            if *left_out {
                *pixel = [0.0, 0.0, 0.25, 1.0];
            }
        }
        pictures.push((of_difference, drawn));
        pictures.push((of_flip, flip_picture(&map)));
    }
    let notes = notes(made, model.as_ref(), [Some(args.backend), backend])?;
    let compared = Compared { with: what.to_string(), comparison, hazards, notes };
    Ok(ComparisonOutput { compared, pictures, model })
}

/// The causes of a difference other than arithmetic.
fn notes(
    made: &PreparedScene<'_>,
    model: Option<&(Model, bool)>,
    backends: [Option<BackendName>; 2],
) -> Result<Vec<String>, RenderStop> {
    let Some(renderer) = &made.renderer else { return Ok(Vec::new()) };
    let mut notes = match model {
        Some((model, _)) => renderer.ignored(&made.work(), model)?,
        None => Vec::new(),
    };
    let driver = backends.contains(&Some(BackendName::Gl));
    if driver && renderer.shader.is_mediump() {
        notes.push(
            "the shader is `mediump` in part, which OpenGL drivers may compute in 16 bits"
                .to_string(),
        );
    }
    Ok(notes)
}
