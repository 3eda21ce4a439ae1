//! Writes the page of the playground to standard output.
//!
//! usage: playground LAYOUT EVALUATOR, both WebAssembly compressed by gzip

use std::io::Write;

use landfall_web::playground::page::{Engine, page};

fn main() -> std::io::Result<()> {
    let mut paths = std::env::args_os().skip(1);
    let mut next = || std::fs::read(paths.next().unwrap_or_default());
    let (layout, evaluator) = (next()?, next()?);
    let (page, _) = page(Engine::Wasm([&layout, &evaluator]));
    std::io::stdout().write_all(page.as_bytes())
}
