//! GLSL of any version, bodies included, as naga IR with our offsets.
