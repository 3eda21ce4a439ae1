//! What floats are rounded to.

use landfall_exec::interp::Floats;

#[derive(Debug, clap::Args)]
pub struct FloatsArgs {
    /// Round every float to f16 at each operation
    #[arg(long, conflicts_with = "mediump")]
    pub half: bool,
    /// Round to f16 what a shader of OpenGL ES says is mediump or lowp; a lowp of 10 bits in fixed
    /// point between -2 and 2, which ES permits, is coarser and is not modelled
    #[arg(long)]
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
