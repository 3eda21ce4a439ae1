//! Lays out whatever text the fuzzer comes up with, in both languages.

#![no_main]

use landfall::{Language, Options, Source, Stage, layout};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    for language in [Language::Glsl, Language::Wgsl] {
        let source =
            Source { language, stage: Some(Stage::Fragment), ..Source::new("fuzz", text) };
        layout(&source, &Options::default().with_gather(true));
    }
});
