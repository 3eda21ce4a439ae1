//! The lines of a lock: the keys of the lock and of its blocks have a line each, as have members,
//! devices and the lock's sets of macros; anything else stays on the line of its key.

use std::io::{Result, Write};

use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::Formatter;

/// Returns the JSON of a lock, with a newline at its end.
pub fn text(document: &impl Serialize) -> String {
    let mut bytes = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut bytes, LockLines::default());
    document.serialize(&mut serializer).expect("keys are strings, and memory takes all bytes");
    bytes.push(b'\n');
    String::from_utf8(bytes).expect("JSON is UTF-8")
}

#[derive(Default)]
struct LockLines {
    /// The objects and arrays around the place, outermost first.
    around: Vec<Nesting>,
    /// The last key, or its part so far.
    key: String,
    is_key: bool,
}

struct Nesting {
    /// Whether each item has a line of its own.
    is_divided: bool,
    /// Whether the keys of objects in it have.
    divides_objects: bool,
    is_empty: bool,
}

impl LockLines {
    fn item<W: Write + ?Sized>(&mut self, out: &mut W) -> Result<()> {
        let Some(nesting) = self.around.last_mut() else { return Ok(()) };
        let (is_divided, is_first) = (nesting.is_divided, nesting.is_empty);
        nesting.is_empty = false;
        match (is_first, is_divided) {
            (true, _) => {}
            (false, true) => out.write_all(b",")?,
            (false, false) => out.write_all(b", ")?,
        }
        if is_divided { self.line(out) } else { Ok(()) }
    }

    fn close<W: Write + ?Sized>(&mut self, out: &mut W, mark: &[u8]) -> Result<()> {
        let closed = self.around.pop();
        if closed.is_some_and(|nesting| nesting.is_divided && !nesting.is_empty) {
            self.line(out)?;
        }
        out.write_all(mark)
    }

    fn line<W: Write + ?Sized>(&self, out: &mut W) -> Result<()> {
        let depth = self.around.iter().filter(|nesting| nesting.is_divided).count();
        write!(out, "\n{:1$}", "", 2 * depth)
    }
}

impl Formatter for LockLines {
    fn begin_object<W: Write + ?Sized>(&mut self, out: &mut W) -> Result<()> {
        let is_divided = self.around.last().is_none_or(|nesting| nesting.divides_objects);
        self.around.push(Nesting { is_divided, divides_objects: false, is_empty: true });
        out.write_all(b"{")
    }

    fn end_object<W: Write + ?Sized>(&mut self, out: &mut W) -> Result<()> {
        self.close(out, b"}")
    }

    fn begin_object_key<W: Write + ?Sized>(&mut self, out: &mut W, _: bool) -> Result<()> {
        self.is_key = true;
        self.key.clear();
        self.item(out)
    }

    fn write_string_fragment<W: Write + ?Sized>(&mut self, out: &mut W, part: &str) -> Result<()> {
        if self.is_key {
            self.key.push_str(part);
        }
        out.write_all(part.as_bytes())
    }

    fn end_object_key<W: Write + ?Sized>(&mut self, _: &mut W) -> Result<()> {
        self.is_key = false;
        Ok(())
    }

    fn begin_object_value<W: Write + ?Sized>(&mut self, out: &mut W) -> Result<()> {
        out.write_all(b": ")
    }

    fn begin_array<W: Write + ?Sized>(&mut self, out: &mut W) -> Result<()> {
        let is_divided = match self.key.as_str() {
            "blocks" | "members" | "verified" => true,
            "variants" => self.around.len() == 1,
            _ => false,
        };
        let divides_objects = self.key == "blocks";
        self.around.push(Nesting { is_divided, divides_objects, is_empty: true });
        out.write_all(b"[")
    }

    fn begin_array_value<W: Write + ?Sized>(&mut self, out: &mut W, _: bool) -> Result<()> {
        self.item(out)
    }

    fn end_array<W: Write + ?Sized>(&mut self, out: &mut W) -> Result<()> {
        self.close(out, b"]")
    }
}
