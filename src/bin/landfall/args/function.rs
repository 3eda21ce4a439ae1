//! Arguments of the commands that examine a function over ranges of its inputs.

use std::path::PathBuf;

use super::setting;

/// A function of a shader, with what its inputs may be.
#[derive(Debug, clap::Args)]
pub struct FunctionArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The function: NAME, or an overload such as 'NAME(vec3, float)'
    #[arg(long = "fn", value_name = "NAME")]
    pub function: String,
    /// Ranges of the inputs by path, as a JSON file or object [default: from comments beside them,
    /// such as `// in 0..1`, else every finite value]
    ///
    /// For example {"normal": "unit", "normal.z": [0, 1], "shininess": {"log": [1, 256]},
    /// "no_coincidence": [["light.position", "fragPos"]]}. The names of ranges are any, unit,
    /// position, color and cos. Values are drawn uniformly, unless distributed as {"log": [lo, hi]},
    /// {"normal": [mean, deviation], "in": [lo, hi]} or {"histogram": FILE}, a JSON object of
    /// "edges" and "counts"
    #[arg(help_heading = "Inputs", long, value_name = "FILE|JSON")]
    pub domain: Option<String>,
    /// Contents of blocks by name, as a JSON file or object in the form of `landfall encode`
    /// [default: their members are inputs]
    #[arg(help_heading = "Inputs", long, value_name = "FILE|JSON")]
    pub data: Option<String>,
    /// Uniform colour of a texture [default: white]
    #[arg(
        help_heading = "Inputs", long = "texture", value_name = "NAME=[R,G,B,A]",
        value_parser = setting
    )]
    pub textures: Vec<(String, String)>,
}
