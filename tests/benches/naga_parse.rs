//! A text parsed by naga.

use landfall_layout::{Language, Source, Stage};

/// Whether naga's front end takes a text, all of it parsed.
pub fn parsed(source: &Source) -> bool {
    match source.language {
        Language::Wgsl => naga::front::wgsl::parse_str(&source.text).is_ok(),
        Language::SpirV => panic!("the corpus is texts"),
        Language::Glsl => {
            let stage = match source.stage {
                Some(Stage::Vertex) => naga::ShaderStage::Vertex,
                Some(Stage::Fragment) => naga::ShaderStage::Fragment,
                Some(Stage::Compute) => naga::ShaderStage::Compute,
                _ => return false,
            };
            let options = naga::front::glsl::Options::from(stage);
            naga::front::glsl::Frontend::default().parse(&options, &source.text).is_ok()
        }
    }
}
