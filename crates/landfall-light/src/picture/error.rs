//! Why a picture could not be read, written or compared.

use std::fmt;

use super::MOST_PIXELS;

/// What is wrong with a picture; whoever knows its file names it before this.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum PictureError {
    /// No pixels.
    Empty { width: u32, height: u32 },
    /// More pixels than are read.
    TooLarge { width: u32, height: u32 },
    /// Not as many pixels as its size says.
    WrongCount { wanted: u64, given: u64 },
    /// Two pictures that cannot be compared.
    SizesDiffer { a: [u32; 2], b: [u32; 2] },
    /// Not as many marks as there are pixels.
    WrongMask { pixels: u64, marks: u64 },
    /// Bytes that are not what a file of this kind has.
    Broken { format: &'static str, cause: String },
    /// A file of this kind, but of a sort that is not read.
    Unsupported { format: &'static str, what: String, instead: &'static str },
    /// A file name that tells no format.
    UnknownFormat { path: String },
}

impl std::error::Error for PictureError {}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PictureError::Empty { width, height } => {
                write!(f, "a picture of {width} x {height} pixels has none")
            }
            PictureError::TooLarge { width, height } => {
                let pixels = u64::from(*width) * u64::from(*height);
                write!(
                    f,
                    "a picture of {width} x {height} has {pixels} pixels; at most {MOST_PIXELS} \
                     are read"
                )
            }
            PictureError::WrongCount { wanted, given } => {
                write!(f, "the picture's size needs {wanted} pixels, it has {given}")
            }
            PictureError::SizesDiffer { a: [aw, ah], b: [bw, bh] } => write!(
                f,
                "one picture is {aw} x {ah} pixels and the other {bw} x {bh}; render both at one \
                 size"
            ),
            PictureError::WrongMask { pixels, marks } => {
                write!(f, "{marks} marks for {pixels} pixels; give one for each")
            }
            PictureError::Broken { format, cause } => write!(f, "is no whole {format}: {cause}"),
            PictureError::Unsupported { format, what, instead } => {
                write!(f, "is a {format} with {what}, which is not read; {instead}")
            }
            PictureError::UnknownFormat { path } => {
                write!(f, "`{path}` names no format; end it in `.png`, `.exr` or `.pfm`")
            }
        }
    }
}
