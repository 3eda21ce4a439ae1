//! The options of C headers.

use std::path::Path;

use super::{Build, OutputBase};
use crate::c::CVectors;
use crate::languages::C;

impl Build {
    /// Writes a C11 and C++17 header of all blocks to `file` in `OUT_DIR`.
    pub fn c_header(self, file: impl AsRef<Path>) -> Build {
        self.output(C, OutputBase::OutDir, file.as_ref())
    }

    /// Writes a C11 and C++17 header of all blocks to `file` in the package, to be checked in.
    pub fn c_header_in_package(self, file: impl AsRef<Path>) -> Build {
        self.output(C, OutputBase::Package, file.as_ref())
    }

    /// Puts the types and functions of C headers into a namespace in C++, `engine::gpu`.
    pub fn c_namespace(mut self, namespace: &str) -> Build {
        self.code.c.namespace = namespace.to_string();
        self
    }

    /// Makes the vectors and matrices of C headers those of glm, where size and alignment match.
    pub fn glm(mut self) -> Build {
        self.code.c.vectors = CVectors::Glm;
        self
    }

    /// Gives a type (`vec3`) or member (`Light.position`) of the shaders a type of the program in C
    /// headers, `Vec3` or `engine::Vec3`, of the same size, which is asserted.
    pub fn map_c_type(mut self, of: &str, name: &str) -> Build {
        self.code.c.types.push((of.to_string(), name.to_string()));
        self
    }

    /// Lets C headers include a header, `engine/math.h` or `<glm/gtc/quaternion.hpp>`.
    pub fn c_include(mut self, header: &str) -> Build {
        self.code.c.includes.push(header.to_string());
        self
    }
}
