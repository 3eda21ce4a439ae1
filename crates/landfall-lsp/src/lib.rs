//! The server of the Language Server Protocol: the layouts, findings and fixes of shaders in an editor.
//!
//! [`serve`] answers a client until it leaves. `messages` reads and writes, `server` dispatches; the
//! `documents` are the texts as they are edited, a `project` is checked by the engine of
//! `landfall check`: the shader in hand after each edit, all others on a thread in the `background`.
//! Answers come from the layouts (`laid_out`) and their `declarations`.

// The parts of a program; what others call is `serve`.
#![allow(missing_docs)]

mod actions;
mod answers;
mod background;
mod client;
mod command_texts;
mod commands;
mod declarations;
mod documents;
mod function_hover;
mod headers;
mod hints;
mod hover;
mod insert_padding;
mod laid_out;
mod lifecycle;
mod lookup;
mod memory_map;
mod messages;
mod navigation;
mod owners;
mod paths;
mod positions;
mod processes;
mod program_fields;
mod project;
mod projects;
mod publish;
mod rename;
mod server;
mod settings;
mod uris;
mod words;
mod write_files;

pub use command_texts::{CommandTexts, FunctionLights, FunctionQuery};
pub use server::serve;
