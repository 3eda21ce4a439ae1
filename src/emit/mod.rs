//! Layouts and findings as text.
