//! Modules that are naga's alone, with nothing known of their blocks or text: what the tests of
//! the drivers run.

use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::Module;

impl Module {
    /// WGSL as naga reads it, numbers and all. For tests of the readers.
    ///
    /// # Errors
    /// What naga says against it.
    #[doc(hidden)]
    pub fn of_wgsl_as_naga_reads_it(text: &str) -> Result<Module, String> {
        let ir = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&ir);
        Ok(Module::bare(ir, info.map_err(|e| e.emit_to_string(text))?))
    }
}
