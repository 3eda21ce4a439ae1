//! `landfall lsp`, by a client that knows nothing of the server but the protocol.

mod client;
mod edits;
mod hints;
mod navigation;
mod projects;
mod session;
mod written;
