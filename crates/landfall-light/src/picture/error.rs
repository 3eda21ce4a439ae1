//! Errors in reading, writing and comparing pictures.

use std::fmt;

use super::MAX_PIXELS;

/// An error of a picture; the caller puts the file's name before it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PictureError {
    /// No pixels.
    Empty { width: u32, height: u32 },
    /// More pixels than supported.
    TooLarge { width: u32, height: u32 },
    /// Another number of pixels than the size requires.
    WrongCount { wanted: u64, given: u64 },
    /// Two pictures of different sizes.
    SizesDiffer { a: [u32; 2], b: [u32; 2] },
    /// Another number of marks than of pixels.
    WrongMask { pixels: u64, marks: u64 },
    /// Bytes that are not a valid file of the format.
    Broken { format: &'static str, cause: String },
    /// A file with an unsupported feature of the format.
    Unsupported { format: &'static str, what: String, instead: &'static str },
    /// A file name without a known extension.
    UnknownFormat { path: String },
}

impl std::error::Error for PictureError {}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PictureError::Empty { width, height } => {
                write!(f, "a picture of {width} x {height} pixels is empty")
            }
            PictureError::TooLarge { width, height } => {
                let pixels = u64::from(*width) * u64::from(*height);
                write!(
                    f,
                    "a picture of {width} x {height} has {pixels} pixels; at most {MAX_PIXELS} \
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
                write!(f, "{marks} marks for {pixels} pixels; there must be one for each")
            }
            PictureError::Broken { format, cause } => write!(f, "is not a valid {format}: {cause}"),
            PictureError::Unsupported { format, what, instead } => {
                write!(f, "is a {format} with {what}, which is not supported; {instead}")
            }
            PictureError::UnknownFormat { .. } => {
                f.write_str("has no known extension; use `.png`, `.exr` or `.pfm`")
            }
        }
    }
}
