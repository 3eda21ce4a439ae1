//! The report of `landfall run`: the result of a call, as columns and as JSON.
//!
//! Formats the data of [`harness::call`](crate::harness::call).

use std::fmt::Write as _;

use serde::Serialize;
use serde_json::Value;
use unicode_width::UnicodeWidthStr;

use super::device::about;
use crate::backend::Device;
pub use crate::harness::call::report::{ValueObject, function_name, number};
use crate::harness::call::{CallReport, ResultCause, ReturnedValue, UndefinedOperation};
use crate::harness::origins::{ReadValue, comes_from};
use landfall_ir::module::Direction;
use landfall_layout::buffer::ComponentBits;
use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::columns::{WIDTH, wrapped};
use landfall_layout::format::json::{Tool, to_lines};
pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, PLAIN, Paint, STRONG};
use landfall_layout::layout::targets;
use landfall_layout::shape::Scalar;
use landfall_layout::source::Target;
use landfall_layout::text::escape;

/// The difference in ULP above which a row is highlighted: twice the error Vulkan allows a
/// division.
const FAR: f64 = 5.0;

struct Row {
    name: String,
    value: String,
    double: String,
    ulp: String,
    far: bool,
}

/// Returns the text of one call: a row for each scalar returned.
pub fn text(report: &CallReport, paint: Paint) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}  {}",
        paint.text(STRONG, &report.function),
        paint.text(FAINT, &escape::name(&report.path))
    );
    let _ = writeln!(
        text,
        "  {}  {}",
        paint.text(HEADING, report.backend.backend.name()),
        paint.text(PLAIN, &about(&report.backend))
    );
    if let Some(note) = targets::note(report.assumed_target) {
        let _ = writeln!(text, "  {}", paint.text(CAUTION, &note));
    }
    let mut rows = Vec::new();
    if let Some(given) = &report.result {
        push(&mut rows, "result", given);
    }
    for (name, _, given) in &report.parameters {
        push(&mut rows, name, given);
    }
    if rows.is_empty() {
        text.push_str("  returns nothing\n");
    } else {
        table(&rows, paint, &mut text);
    }
    for ResultCause { results, is_nan, cause } in &report.causes {
        let are = if results.len() > 1 { "are" } else { "is" };
        let what = if *is_nan { "NaN" } else { "infinite" };
        let by = cause.operation.as_ref().map(|(kind, _)| format!(", by {kind}"));
        let line = format!("{} {are} {what}{}", results.join(", "), by.unwrap_or_default());
        let place = cause.operation.as_ref().map(|(_, place)| &place.shown);
        let place = place.filter(|place| !place.is_empty()).map(|place| format!("at {place}"));
        let more = place.into_iter().chain(comes_from(&cause.from));
        // Continued lines are indented by 4.
        let more = more.flat_map(|line| wrapped(&line, WIDTH - 4));
        for (nth, line) in wrapped(&line, WIDTH - 4).into_iter().chain(more).enumerate() {
            let indent = if nth == 0 { "  " } else { "    " };
            let _ = writeln!(text, "{indent}{}", paint.text(CAUTION, &line));
        }
    }
    if report.discarded {
        let _ = writeln!(text, "  {}", paint.text(CAUTION, "executed `discard`"));
    }
    for note in &report.notes {
        let _ = writeln!(text, "  {}", paint.text(FAINT, note));
    }
    text
}

fn push(rows: &mut Vec<Row>, name: &str, given: &ReturnedValue) {
    for scalar in &given.scalars {
        let shown = |datum: ComponentBits| match datum.is_nan() {
            true => "nan".to_string(),
            false => datum.to_string(),
        };
        let double =
            |double: f64| shown(ComponentBits { scalar: Scalar::F64, bits: double.to_bits() });
        // Only one of the two is finite, or a number.
        let apart = scalar.double.is_some() && scalar.ulp.is_none();
        rows.push(Row {
            name: format!("{name}{}", scalar.path),
            value: shown(scalar.value),
            double: scalar.double.map(double).unwrap_or_default(),
            ulp: match scalar.ulp {
                Some(ulp) if ulp < 1000.0 => format!("{ulp:.2}"),
                Some(ulp) => format!("{ulp:.3e}"),
                None if apart => "differs".to_string(),
                None => String::new(),
            },
            far: apart || scalar.ulp.is_some_and(|ulp| ulp > FAR),
        });
    }
}

fn table(rows: &[Row], paint: Paint, text: &mut String) {
    let widest = |of: fn(&Row) -> &str, least: usize| {
        rows.iter().map(|row| of(row).width()).max().unwrap_or(0).max(least)
    };
    let widths =
        // 3: the width of the headings `f32` and `f64`.
        [widest(|row| &row.name, 0), widest(|row| &row.value, 3), widest(|row| &row.double, 3)];
    let pad = |text: &str, width: usize| " ".repeat(width - text.width());
    // A single column of values needs no heading.
    let has_doubles = rows.iter().any(|row| !row.double.is_empty());
    if has_doubles {
        let heading = format!(
            "  {}  f32{}  f64{}  ulp",
            pad("", widths[0]),
            pad("f32", widths[1]),
            pad("f64", widths[2])
        );
        let _ = writeln!(text, "{}", paint.text(FAINT, &heading));
    }
    for row in rows {
        let mut line = format!(
            "  {}{}  {}{}  {}{}  ",
            row.name,
            pad(&row.name, widths[0]),
            row.value,
            pad(&row.value, widths[1]),
            row.double,
            pad(&row.double, widths[2]),
        );
        line.push_str(&paint.text(if row.far { CAUTION } else { PLAIN }, &row.ulp));
        let _ = writeln!(text, "{}", line.trim_end());
    }
}

/// The result of one call of a shader's function.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RunObject<'a> {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA_VERSION)))]
    schema_version: u32,
    tool: Tool,
    path: &'a str,
    /// The API assumed for a shader that tests `VULKAN` without declaring its API, if its blocks
    /// depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    /// The function with its parameter types: phong(vec3, Light).
    function: &'a str,
    backend: &'a Device,
    /// Null if the function returns nothing.
    result: Option<ValueObject>,
    /// The values of out and inout parameters after the call; of a function that returns nothing,
    /// also of the global variables it writes, such as the outputs of main.
    parameters: Vec<ParameterObject<'a>>,
    discarded: bool,
    /// The interpreter's operations; null where it did not run.
    operations: Option<u64>,
    /// The operations without a defined value, in source order.
    undefined: Vec<UndefinedObject<'a>>,
    /// What made results NaN or infinite.
    causes: Vec<CauseObject<'a>>,
    /// The assumptions made for values not given.
    notes: &'a [String],
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ParameterObject<'a> {
    name: &'a str,
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["out", "inout"])))]
    direction: &'static str,
    #[serde(flatten)]
    given: ValueObject,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct UndefinedObject<'a> {
    what: &'static str,
    function: &'a str,
    path: Option<String>,
    line: Option<u32>,
    column: Option<u32>,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    count: u64,
    #[cfg_attr(
        feature = "schema",
        schemars(extend("items" = serde_json::json!({"type": ["number", "string"]})))
    )]
    operands: Vec<Value>,
    /// The arguments, inputs and members of blocks whose values led to it, with those values.
    from: Vec<FromObject<'a>>,
}

/// A value that led to another, in JSON.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FromObject<'a> {
    path: &'a str,
    #[cfg_attr(
        feature = "schema",
        schemars(extend("items" = serde_json::json!({"type": ["number", "string"]})))
    )]
    values: Vec<Value>,
}

impl FromObject<'_> {
    /// The value that was read, and where.
    pub fn new(read: &ReadValue) -> FromObject<'_> {
        FromObject { path: &read.path, values: read.values.iter().map(|x| number(*x)).collect() }
    }
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct CauseObject<'a> {
    /// The paths of the results.
    results: &'a [String],
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["nan", "inf"])))]
    value: &'static str,
    /// The operation; null if the value was read so.
    what: Option<&'static str>,
    path: Option<String>,
    line: Option<u32>,
    column: Option<u32>,
    /// The arguments, inputs and members of blocks whose values led to it, with those values.
    from: Vec<FromObject<'a>>,
}

/// The schema of the JSON of calls.
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text::<RunObject<'_>>("landfall run --format json")
}

/// Returns one call as JSON, in the form of `landfall schema run`.
pub fn json(report: &CallReport) -> String {
    let parameters = report.parameters.iter().map(|(name, direction, given)| ParameterObject {
        name,
        direction: match direction {
            Direction::In => "in",
            Direction::Out => "out",
            Direction::InOut => "inout",
        },
        given: ValueObject::new(given),
    });
    let undefined = report.undefined.iter().map(|UndefinedOperation { seen, from }| {
        let known = !seen.place.shown.is_empty();
        let place = known.then(|| report.files.locate(seen.place.span));
        UndefinedObject {
            what: seen.kind.name(),
            function: function_name(&seen.place.function),
            line: place.as_ref().map(|place| place.line),
            column: place.as_ref().map(|place| place.column),
            path: place.map(|place| place.path),
            count: seen.count,
            operands: seen.operands.iter().map(|operand| number(*operand)).collect(),
            from: from.iter().map(FromObject::new).collect(),
        }
    });
    let causes = report.causes.iter().map(|ResultCause { results, is_nan, cause }| {
        let operation = cause.operation.as_ref();
        let place = operation.filter(|(_, place)| !place.shown.is_empty());
        let place = place.map(|(_, place)| report.files.locate(place.span));
        CauseObject {
            results,
            value: if *is_nan { "nan" } else { "inf" },
            what: operation.map(|(kind, _)| kind.name()),
            line: place.as_ref().map(|place| place.line),
            column: place.as_ref().map(|place| place.column),
            path: place.map(|place| place.path),
            from: cause.from.iter().map(FromObject::new).collect(),
        }
    });
    let object = RunObject {
        schema_version: SCHEMA_VERSION,
        tool: Tool::LANDFALL,
        path: &report.path,
        assumed_target: report.assumed_target,
        function: &report.function,
        backend: &report.backend,
        result: report.result.as_ref().map(ValueObject::new),
        parameters: parameters.collect(),
        discarded: report.discarded,
        operations: report.operations,
        undefined: undefined.collect(),
        causes: causes.collect(),
        notes: &report.notes,
    };
    format!("{}\n", to_lines(&object))
}
