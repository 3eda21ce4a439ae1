//! Assertions about structures of the program.

use std::path::Path;

use super::{Build, OutputBase, OutputFile};
use crate::OutputLanguage;
use crate::languages::RUST;

impl Build {
    /// Asserts that a structure of the program, `crate::engine::PointLight`, lies in memory as a
    /// structure (`PointLight`), block or member of a block (`Lights.data[]`) of the shaders is read.
    ///
    /// ```
    /// # extern crate landfall_codegen as landfall;
    /// # fn main() -> Result<(), landfall::BuildError> {
    /// landfall::Build::new()
    ///     .source("light.wgsl", "struct Light { at: vec3f, power: f32 }
    ///         @group(0) @binding(0) var<uniform> light: Light;")
    ///     .assert("crate::Light", "Light")
    ///     .assert_field("Light.at", "position")
    ///     .assertions("assertions.rs");
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// Include the file in the crate: `include!(concat!(env!("OUT_DIR"), "/assertions.rs"));`.
    pub fn assert(mut self, host: &str, shader: &str) -> Build {
        self.code.assertions.structures.push((host.to_string(), shader.to_string()));
        self
    }

    /// Gives the program's name of a member, `Light.at`, or an empty one where the program's
    /// structure does not have it.
    pub fn assert_field(mut self, member: &str, name: &str) -> Build {
        self.code.assertions.fields.push((member.to_string(), name.to_string()));
        self
    }

    /// Writes the assertions in Rust to `file` in `OUT_DIR`.
    pub fn assertions(self, file: impl AsRef<Path>) -> Build {
        self.assertion_output(RUST, OutputBase::OutDir, file.as_ref())
    }

    /// Writes the assertions in a [language](crate::languages) to `file` in the package, to be
    /// checked in.
    pub fn assertions_in_package(self, language: OutputLanguage, file: impl AsRef<Path>) -> Build {
        self.assertion_output(language, OutputBase::Package, file.as_ref())
    }

    fn assertion_output(
        mut self,
        language: OutputLanguage,
        place: OutputBase,
        file: &Path,
    ) -> Build {
        let generate = OutputLanguage::assertions;
        self.outputs.push(OutputFile { language, place, file: file.to_path_buf(), generate });
        self
    }
}
