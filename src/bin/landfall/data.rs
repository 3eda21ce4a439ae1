//! JSON arguments: contents of blocks, function arguments, colours.

use landfall_check::files;
use std::path::Path;

use landfall_exec::harness::bindings::Data;
use landfall_exec::harness::call::pure::PureRequest;
use landfall_interp::Floats;
use landfall_layout::Error;
use landfall_layout::buffer::read_json;
use serde_json::{Map, Value};

use crate::args::FunctionArgs;

/// Reads the contents of blocks from a JSON object or from the file of that name.
pub fn blocks(text: Option<&str>) -> Result<Data, Error> {
    let Some(text) = text else { return Ok(Data::new()) };
    let help = |error: Error| match error.help {
        None if error.message == NO_OBJECT => {
            Error::new(error.path, "is not a JSON object of blocks by name")
                .with_help("write `{\"Lights\": {\"count\": 1}}`")
        }
        Some(_) | None => error,
    };
    object("--data", text).map_err(help)
}

const NO_OBJECT: &str = "is not a JSON object";

/// Reads a JSON object from an argument or from the file of that name.
pub fn object(option: &str, text: &str) -> Result<Data, Error> {
    // An argument that begins with `{` is JSON, any other is the name of a file.
    let (about, json) = match text.trim_start().starts_with('{') {
        true => (option.to_string(), text.to_string()),
        false => (files::display_path(Path::new(text)), files::text(Path::new(text))?),
    };
    match value(&about, &json)? {
        Value::Object(map) => Ok(map),
        _ => Err(Error::new(about, NO_OBJECT)),
    }
}

/// Reads a JSON array or object from an argument, or any value from the file of that name.
pub fn file_or_value(about: &str, text: &str) -> Result<Value, Error> {
    match text.trim_start().starts_with(['{', '[']) {
        true => value(about, text),
        false => value(&files::display_path(Path::new(text)), &files::text(Path::new(text))?),
    }
}

/// Parses JSON; errors name their source.
pub fn value(about: &str, text: &str) -> Result<Value, Error> {
    read_json(text).map_err(|error| Error::new(about, format!("is not JSON: {error}")))
}

/// Returns the function that the arguments name, its resources and the domain of its inputs.
pub fn function(
    args: &FunctionArgs,
    floats: Floats,
) -> Result<(PureRequest, Option<Value>), Error> {
    let pure = PureRequest {
        function: args.function.clone(),
        data: blocks(args.data.as_deref())?,
        textures: textures(&args.textures)?,
        floats,
    };
    Ok((pure, domain(args.domain.as_deref())?))
}

/// Reads the domain of a function's inputs, and the files of its histograms.
pub fn domain(text: Option<&str>) -> Result<Option<Value>, Error> {
    let Some(text) = text else { return Ok(None) };
    let mut domain = file_or_value("--domain", text)?;
    // A histogram may be in a file of its own, named by a string.
    for stated in domain.as_object_mut().into_iter().flat_map(Map::values_mut) {
        if let Some(histogram) = stated.get_mut("histogram")
            && let Some(file) = histogram.as_str().map(Path::new)
        {
            *histogram = value(&files::display_path(file), &files::text(file)?)?;
        }
    }
    Ok(Some(domain))
}

/// Parses the colours of textures by name.
pub fn textures(given: &[(String, String)]) -> Result<Vec<(String, [f32; 4])>, Error> {
    let colours = given
        .iter()
        .map(|(name, text)| Ok((name.clone(), colour(&value("--texture", text)?, name)?)));
    colours.collect()
}

/// Converts an array of four numbers to a colour.
fn colour(value: &Value, name: &str) -> Result<[f32; 4], Error> {
    let numbers: Option<Vec<f32>> = value
        .as_array()
        .and_then(|items| items.iter().map(|item| item.as_f64().map(|x| x as f32)).collect());
    numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| {
        Error::new("--texture", format!("needs a colour of four numbers for `{name}`"))
            .with_help(format!("write `{name}=[1, 1, 1, 1]`"))
    })
}
