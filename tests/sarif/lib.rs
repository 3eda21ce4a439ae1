//! Nothing: only the manifest beside it is read.
