//! An OpenGL driver without a window.
