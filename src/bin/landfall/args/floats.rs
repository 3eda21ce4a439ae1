//! The precision that floats are rounded to.

use landfall_interp::Floats;

#[derive(Debug, clap::Args)]
pub struct FloatsArgs {
    /// Round every float to f16 after each operation
    #[arg(help_heading = "Precision", long, conflicts_with = "mediump")]
    pub half: bool,
    /// Round floats declared mediump or lowp in an OpenGL ES shader to f16
    ///
    /// ES also permits lowp in 10-bit fixed point between -2 and 2, which is coarser and not
    /// modelled
    #[arg(help_heading = "Precision", long)]
    pub mediump: bool,
}

impl FloatsArgs {
    pub fn floats(&self) -> Floats {
        match (self.half, self.mediump) {
            (true, _) => Floats::Half,
            (false, true) => Floats::Mediump,
            (false, false) => Floats::AsWritten,
        }
    }
}
