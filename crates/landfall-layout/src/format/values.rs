//! Output of decoded values: a row for each element of each leaf, or JSON.
//!
//! Reads [`Decoded`] and writes incrementally, as a storage buffer may hold millions of values.

use std::io::{self, Write};

use unicode_width::UnicodeWidthStr;

use super::json::write_lines;
use super::paint::{CAUTION, FAINT, Paint, TYPE};
use super::phrases;
use super::table::heading;
use crate::buffer::{ComponentBits, Decoded, Element, Finding};
use crate::source::Language;

/// The label of padding in the path column.
const PADDING: &str = "-- padding";

/// The most bytes of padding that are shown.
const MAX_BYTES: usize = 16;

/// Writes the values as JSON that [`encode`](crate::buffer::encode()) accepts, each structure of
/// an array on its own line.
///
/// # Errors
/// Returns the errors of `out`.
pub fn json(decoded: &Decoded<'_>, out: &mut dyn Write) -> io::Result<()> {
    write_lines(decoded, 0, out)?;
    out.write_all(b"\n")
}

/// Writes the values as a table in source order, including padding that is not zero.
///
/// # Errors
/// Returns the errors of `out`.
pub fn table(
    decoded: &Decoded<'_>,
    language: Language,
    paint: Paint,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut table = ValueTable { widths: ["offset", "type", "path"].map(str::len), paint, out };
    let mut padding = decoded.findings.list.iter().filter_map(hole).peekable();
    if padding.peek().is_some() {
        table.widths[2] = PADDING.len();
    }
    // The elements are decoded twice, once for the widths and once to write, as rows that were kept
    // would take many times the bytes of the buffer.
    decoded.for_each(|element| {
        let widths = [digits(element.offset), element.ty.width(), element.path.width()];
        for (width, new) in table.widths.iter_mut().zip(widths) {
            *width = new.max(*width);
        }
    });
    table.out.write_all(heading(decoded.block(), language, paint).as_bytes())?;
    table.titles()?;
    decoded.try_for_each(|element| {
        // Padding that lies before an element comes before it.
        while let Some((offset, bytes)) = padding.next_if(|hole| hole.0 < element.offset) {
            table.padding(offset, bytes)?;
        }
        table.element(&element)
    })?;
    padding.try_for_each(|(offset, bytes)| table.padding(offset, bytes))?;
    if let Some(length) = length(decoded) {
        writeln!(table.out, "  {}", paint.text(FAINT, &length))?;
    }
    Ok(())
}

/// The offset and bytes of padding that is not zero.
fn hole(finding: &Finding) -> Option<(u64, &[u8])> {
    match finding {
        Finding::Padding { offset, bytes, .. } => Some((*offset, bytes)),
        Finding::Nan { .. } | Finding::Infinite { .. } | Finding::OddBool { .. } => None,
    }
}

/// The number of elements of a runtime-sized array that the bytes hold.
fn length(decoded: &Decoded<'_>) -> Option<String> {
    let (name, _) = phrases::endless(decoded.block())?;
    let bytes = phrases::bytes(decoded.len() as u64);
    Some(format!("{bytes} hold {} of `{name}`", decoded.tail_len()))
}

fn digits(number: u64) -> usize {
    number.checked_ilog10().unwrap_or(0) as usize + 1
}

struct ValueTable<'o> {
    /// The widths of all columns but the last.
    widths: [usize; 3],
    paint: Paint,
    out: &'o mut dyn Write,
}

impl ValueTable<'_> {
    fn titles(&mut self) -> io::Result<()> {
        let [offset, ty, path] = self.widths;
        let titles = format!("  {:>offset$}  {:ty$}  {:path$}  value", "offset", "type", "path");
        writeln!(self.out, "{}", self.paint.text(FAINT, &titles))
    }

    fn element(&mut self, element: &Element<'_>) -> io::Result<()> {
        let [offset, ty, path] = self.widths;
        let fill = |text: &str, width: usize| " ".repeat(width - text.width());
        let (ty_fill, path_fill) = (fill(element.ty, ty), fill(element.path, path));
        let ty = self.paint.text(TYPE, element.ty);
        write!(self.out, "  {:>offset$}  {ty}{ty_fill}  ", element.offset)?;
        write!(self.out, "{}{path_fill} ", element.path)?;
        for (i, cell) in element.cells.iter().enumerate() {
            // A bar separates the columns of a matrix.
            let bar = if i > 0 && i % element.rows == 0 { " |" } else { "" };
            write!(self.out, "{bar} {cell}")?;
        }
        self.flag(&suspicious(element))?;
        self.out.write_all(b"\n")
    }

    fn padding(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        let [offset_width, ty, path] = self.widths;
        let mut hex: Vec<String> =
            bytes.iter().take(MAX_BYTES).map(|byte| format!("{byte:02x}")).collect();
        if bytes.len() > MAX_BYTES {
            hex.push(format!("… ({})", phrases::bytes(bytes.len() as u64)));
        }
        let row =
            format!("  {offset:>offset_width$}  {:ty$}  {PADDING:path$}  {}", "", hex.join(" "));
        write!(self.out, "{}", self.paint.text(FAINT, &row))?;
        self.flag("not zero")?;
        self.out.write_all(b"\n")
    }

    fn flag(&mut self, text: &str) -> io::Result<()> {
        if text.is_empty() {
            return Ok(());
        }
        write!(self.out, "  {}", self.paint.text(CAUTION, &format!("<- {text}")))
    }
}

/// A description of suspicious components (NaN, infinite, invalid `bool`); empty without any.
fn suspicious(element: &Element<'_>) -> String {
    let any = |is: fn(ComponentBits) -> bool| element.cells.iter().any(|cell| is(*cell));
    let kinds = [
        (any(ComponentBits::is_nan), "not a number"),
        (any(ComponentBits::is_infinite), "infinite"),
        (any(ComponentBits::is_odd_bool), "neither 0 nor 1"),
    ];
    let names: Vec<&str> = kinds.iter().filter(|(is, _)| *is).map(|(_, name)| *name).collect();
    names.join(", ")
}
