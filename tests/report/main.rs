//! The HTML pages of `report`, `check` and `diff`, the playground and `serve`, in a real browser:
//! what they show against the other outputs of the command and the library, and what they must never
//! do.

mod access;
mod answers;
mod browser;
mod bytes;
mod changes;
mod editing;
mod findings;
mod hostile;
mod lights;
mod numbers;
mod playground;
mod serve;
mod support;
