//! JSON with line breaks that suit diffs: before each object of an array, and before each entry
//! of `offsets`.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::{CharEscape, CompactFormatter, Formatter, Serializer};

/// Serialises a value as JSON with one line per object of an array.
pub fn to_lines<T: Serialize>(value: &T) -> String {
    let mut text = Vec::with_capacity(1 << 13);
    write_lines(value, 0, &mut text).expect("memory takes every byte, and keys are strings");
    String::from_utf8(text).expect("JSON of strings is UTF-8")
}

/// Writes the JSON of [`to_lines`] incrementally, indented from `depth`.
pub fn write_lines<T: Serialize>(value: &T, depth: usize, out: &mut dyn Write) -> io::Result<()> {
    let lines = LineWriter { depth, ..LineWriter::default() };
    Ok(value.serialize(&mut Serializer::with_formatter(out, lines))?)
}

/// The only object whose entries get a line each: it may have a million.
const LONG_OBJECT: &str = "offsets";

#[derive(Default)]
struct LineWriter {
    depth: usize,
    /// Whether an array element starts, which is put on a new line if it is an object.
    element: bool,
    /// For each enclosing array and object, whether its entries are on separate lines.
    broken: Vec<bool>,
    in_key: bool,
    long: bool,
}

impl LineWriter {
    fn new_line<W: ?Sized + Write>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b"\n")?;
        for _ in 0..=self.depth {
            writer.write_all(b"  ")?;
        }
        Ok(())
    }

    fn open<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        bracket: u8,
        broken: bool,
    ) -> io::Result<()> {
        self.broken.push(broken);
        writer.write_all(&[bracket])
    }

    fn close<W: ?Sized + Write>(&mut self, writer: &mut W, bracket: u8) -> io::Result<()> {
        if self.broken.pop() == Some(true) {
            self.depth -= 1;
            self.new_line(writer)?;
        }
        writer.write_all(&[bracket])
    }
}

impl Formatter for LineWriter {
    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.element = false;
        self.open(writer, b'[', false)
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b']')
    }

    fn begin_array_value<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.element = true;
        if first { Ok(()) } else { writer.write_all(b",") }
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.element = false;
        Ok(())
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        // An object that is an element of an array begins a line; the first one makes the array one
        // whose bracket closes on a line of its own.
        if std::mem::take(&mut self.element) {
            if let Some(broken @ false) = self.broken.last_mut() {
                *broken = true;
                self.depth += 1;
            }
            self.new_line(writer)?;
        }
        // The object behind the key `offsets`: its entries have lines of their own.
        let long = std::mem::take(&mut self.long);
        self.depth += usize::from(long);
        self.open(writer, b'{', long)
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b'}')
    }

    fn begin_object_key<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.in_key = true;
        if !first {
            writer.write_all(b",")?;
        }
        if self.broken.last() == Some(&true) { self.new_line(writer) } else { Ok(()) }
    }

    fn end_object_key<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.in_key = false;
        Ok(())
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.element = false;
        writer.write_all(b":")
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.long = false;
        Ok(())
    }

    fn write_string_fragment<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        part: &str,
    ) -> io::Result<()> {
        if self.in_key {
            // Keys are known as they are written, just before their value begins.
            self.long = part == LONG_OBJECT;
        }
        CompactFormatter.write_string_fragment(writer, part)
    }

    fn write_char_escape<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        escape: CharEscape,
    ) -> io::Result<()> {
        CompactFormatter.write_char_escape(writer, escape)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_of_an_array_take_a_line_each() {
        let value = serde_json::json!({"a": [1, 2], "b": [{"c": []}, {"c": [{"d": {}}]}]});
        assert_eq!(
            to_lines(&value),
            "{\"a\":[1,2],\"b\":[\n    {\"c\":[]},\n    {\"c\":[\n      {\"d\":{}}\n    ]}\n  ]}"
        );
    }

    #[test]
    fn offsets_take_a_line_each() {
        let value = serde_json::json!({"offsets": {"a[0]": 0, "a[1]": 4}, "z": {"offsets": 1}});
        assert_eq!(
            to_lines(&value),
            "{\"offsets\":{\n    \"a[0]\":0,\n    \"a[1]\":4\n  },\"z\":{\"offsets\":1}}"
        );
    }
}
