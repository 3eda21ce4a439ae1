//! The default format: a table of a block's members, indented by nesting, with rows for padding
//! and a summary line.
//!
//! Offsets are from the start of the block; those in an array are of its first element, with the
//! strides beside them.

use std::fmt;
use std::fmt::Write as _;

use anstyle::Style;
use unicode_width::UnicodeWidthStr;

use super::paint::{CAUTION, FAINT, HEADING, PLAIN, Paint, STRONG, TYPE};
use super::{EmitOptions, columns, expand, phrases};
use crate::ShaderLayout;
use crate::layout::measure::element_size;
use crate::layout::padding::{MemberOrGap, PaddingKind, PaddingOwner, in_text_order, tails};
use crate::layout::{BlockLayout, Leaf, MemberLayout, targets};
use crate::shape::{AddressSpace, Rules, Type};
use crate::source::Language;
use crate::text::escape::name;

const COLUMNS: usize = 7;
const TITLES: [&str; COLUMNS] = ["offset", "size", "align", "stride", "matrix", "type", "name"];
const NAME: usize = COLUMNS - 1;

/// About the bytes of a row, and of all that is no row: most tables are not moved as they grow.
const ROW: usize = 64;
const ROOM: usize = 512;

pub(super) fn shader(shader: &ShaderLayout, options: &EmitOptions) -> String {
    let paint = options.paint;
    let leaves: usize = shader.blocks.iter().map(|block| block.leaves.len()).sum();
    let mut text = String::with_capacity(ROOM + 2 * ROW * leaves + 2 * ROW * shader.blocks.len());
    text.push_str(&paint.text(STRONG, &name(&shader.title())));
    if let Some(stage) = shader.stage {
        text.push_str(&paint.text(FAINT, &format!(" ({})", stage.name())));
    }
    text.push('\n');
    if let Some(note) = targets::note(shader.assumed_target) {
        text.push_str(&paint.text(CAUTION, &format!("  {note}\n")));
    }
    if shader.blocks.is_empty() {
        text.push_str(&paint.text(FAINT, "  no blocks\n"));
    }
    for block in &shader.blocks {
        text.push('\n');
        text.push_str(&heading(block, shader.language, paint));
        let expanded = options.expand && expand::can_expand(block);
        let rows = if expanded {
            expanded_rows(block, shader.language)
        } else {
            rows(block, shader.language)
        };
        rows.write(paint, &mut text);
        footer(shader, block, &rows, paint, &mut text);
    }
    text
}

pub(super) fn heading(block: &BlockLayout, language: Language, paint: Paint) -> String {
    let mut facts = vec![(HEADING, phrases::block_name(block))];
    let mut fact = |style: Style, fact: &str| {
        if !fact.is_empty() {
            facts.push((style, fact.to_string()));
        }
    };
    if block.space == AddressSpace::Default {
        fact(CAUTION, "set one by one, no offsets (--gather lays them out as a block)");
        return columns::heading(&facts, paint);
    }
    fact(PLAIN, block.rules.name());
    if !block.rules_declared {
        fact(CAUTION, "rules not declared: the driver's offsets may differ");
    }
    fact(PLAIN, &phrases::slot(block, language));
    if !block.count.is_empty() {
        let buffers = phrases::buffers(block).map_or_else(
            || format!("buffers {}", phrases::dims(&block.count)),
            |n| phrases::numbered(n, "buffer"),
        );
        fact(PLAIN, &buffers);
    }
    fact(STRONG, &block.size.map(phrases::bytes).unwrap_or_default());
    columns::heading(&facts, paint)
}

fn footer(
    shader: &ShaderLayout,
    block: &BlockLayout,
    rows: &TableRows,
    paint: Paint,
    text: &mut String,
) {
    let mut line = |style: Style, line: &str| {
        if !line.is_empty() {
            text.push_str("  ");
            text.push_str(&paint.text(style, line));
            text.push('\n');
        }
    };
    line(STRONG, &columns::wrapped(&phrases::summary(block), columns::WIDTH - 4).join("\n    "));
    line(FAINT, phrases::reported_size(shader, block).unwrap_or_default());
    if rows.rows.iter().any(|row| row.inherited > 0) {
        line(FAINT, "offsets are those of element 0; element i lies i × stride further");
    }
    let opaque = phrases::opaque(block);
    if !opaque.is_empty() {
        line(FAINT, &format!("opaque, no bytes: {}", opaque.join(", ")));
    }
}

/// The lines of the table. Their cells are in one text, as a string for each would double the time.
#[derive(Default)]
struct TableRows {
    text: String,
    rows: Vec<TableRow>,
}

#[derive(Clone, Default)]
struct TableRow {
    /// Where the first cell starts, and each ends.
    start: usize,
    ends: [usize; COLUMNS],
    /// The characters of the stride cell that repeat the strides of enclosing arrays.
    inherited: usize,
    padding: bool,
    /// How naga reads the member, if that differs.
    caution: Option<String>,
}

fn rows(block: &BlockLayout, language: Language) -> TableRows {
    let count = 2 * block.leaves.len();
    let rows =
        TableRows { text: String::with_capacity(ROW * count), rows: Vec::with_capacity(count) };
    let mut table = BlockTable { rules: block.rules, language, leaves: block.leaves.iter(), rows };
    let scope = RowScope { base: 0, depth: 0, strides: &[], inherited: 0 };
    table.members(&block.members, block.size, (PaddingOwner::Block, None), &scope);
    table.rows
}

/// The enclosing structure or block during the walk.
struct RowScope<'a> {
    base: u64,
    depth: usize,
    strides: &'a [u64],
    /// The length of the strides in a cell.
    inherited: usize,
}

struct BlockTable<'a> {
    rules: Rules,
    language: Language,
    /// The remaining leaves, in the order in which the walk meets them.
    leaves: std::slice::Iter<'a, Leaf>,
    rows: TableRows,
}

impl BlockTable<'_> {
    fn members(
        &mut self,
        members: &[MemberLayout],
        whole: Option<u64>,
        owner: (PaddingOwner, Option<&str>),
        scope: &RowScope<'_>,
    ) {
        for one in in_text_order(members, whole) {
            match one {
                MemberOrGap::Member(member) => self.member(member, scope),
                MemberOrGap::Gap(gap) => {
                    let words = phrases::padding(gap.kind, owner.0, owner.1);
                    let offset = scope.base + gap.offset;
                    self.padding(offset, gap.size, &words, scope, scope.depth);
                }
            }
        }
    }

    /// Adds a row of padding in an array of the strides of `within`.
    fn padding(
        &mut self,
        offset: u64,
        size: u64,
        words: &str,
        within: &RowScope<'_>,
        depth: usize,
    ) {
        let row = TableRow { padding: true, inherited: within.inherited, ..TableRow::default() };
        self.rows.push(row, |column, text| match column {
            0 => write!(text, "{offset}"),
            1 => write!(text, "{size}"),
            3 => write!(text, "{}", phrases::Spaced(within.strides)),
            NAME => {
                fill_up(text, 2 * depth);
                write!(text, "-- {words}")
            }
            _ => Ok(()),
        });
    }

    fn member(&mut self, member: &MemberLayout, scope: &RowScope<'_>) {
        let number = |text: &mut String, n: Option<u64>| n.map_or(Ok(()), |n| write!(text, "{n}"));
        let mut strides = scope.strides.to_vec();
        strides.extend(&member.strides);
        let base = scope.base + member.offset.unwrap_or(0);
        let is_struct = matches!(member.ty.innermost(), Type::Struct(_));
        let leaf = if is_struct { None } else { self.leaves.next() };
        let caution = leaf.and_then(phrases::naga);
        let row = TableRow { inherited: scope.inherited, caution, ..TableRow::default() };
        let inherited = self.rows.push(row, |column, text| match column {
            0 => number(text, member.offset.map(|_| base)),
            1 => number(text, member.size),
            2 => number(text, member.align),
            3 => write!(text, "{}", phrases::Spaced(&strides)),
            4 => write_matrix(member, text),
            5 => write!(text, "{}", member.ty.innermost().spelled(self.language)),
            _ => {
                fill_up(text, 2 * scope.depth);
                text.push_str(&member.name);
                member.dims.iter().try_for_each(|len| write!(text, "{len}"))
            }
        });
        let inner = RowScope { base, depth: scope.depth + 1, strides: &strides, inherited };
        if is_struct {
            let whole = member.offset.map(|_| element_size(member, self.rules));
            let owner = (PaddingOwner::Structure, phrases::structure_name(&member.ty));
            self.members(&member.members, whole, owner, &inner);
        }
        for tail in member.offset.map(|_| tails(member, self.rules)).unwrap_or_default() {
            let words = match tail.owner {
                PaddingOwner::Member => format!("tail padding of {}", member.name),
                owner => phrases::padding(PaddingKind::Tail, owner, None),
            };
            let within = match tail.owner {
                PaddingOwner::Member => scope,
                _ => &inner,
            };
            self.padding(base + tail.offset, tail.size, &words, within, inner.depth);
        }
    }
}

/// Writes the matrix stride: `16`, or `16 rows` when the matrix is stored by rows.
fn write_matrix(member: &MemberLayout, text: &mut String) -> fmt::Result {
    let rows = if member.row_major { "rows" } else { "" };
    match member.matrix_stride {
        Some(stride) if member.row_major => write!(text, "{stride} {rows}"),
        Some(stride) => write!(text, "{stride}"),
        None => text.write_str(rows),
    }
}

fn expanded_rows(block: &BlockLayout, language: Language) -> TableRows {
    let mut rows = TableRows::default();
    expand::for_each(block, |element| {
        rows.push(TableRow::default(), |column, text| match column {
            0 => write!(text, "{}", element.offset),
            1 => write!(text, "{}", element_size(element.member, block.rules)),
            4 => write_matrix(element.member, text),
            5 => write!(text, "{}", element.member.ty.innermost().spelled(language)),
            NAME => write!(text, "{}", element.path),
            _ => Ok(()),
        });
    });
    rows
}

impl TableRows {
    /// Adds a row, each of whose cells `write` appends to the text; returns the length of the strides.
    fn push(&mut self, row: TableRow, write: impl Fn(usize, &mut String) -> fmt::Result) -> usize {
        let mut row = TableRow { start: self.text.len(), ..row };
        for (column, end) in row.ends.iter_mut().enumerate() {
            write(column, &mut self.text).expect("a text takes all");
            *end = self.text.len();
        }
        let strides = row.ends[3] - row.ends[2];
        self.rows.push(row);
        strides
    }

    fn cell(&self, row: &TableRow, column: usize) -> &str {
        let start = column.checked_sub(1).map_or(row.start, |before| row.ends[before]);
        &self.text[start..row.ends[column]]
    }

    fn write(&self, paint: Paint, text: &mut String) {
        // Two passes: the first for the widths, the second to write.
        let mut widths = [0; COLUMNS];
        for row in &self.rows {
            for (column, width) in widths.iter_mut().enumerate() {
                *width = (*width).max(columns(self.cell(row, column)));
            }
        }
        // Empty columns are left out, with their titles.
        let shown = widths.map(|width| width > 0);
        let shown = || (0..COLUMNS).filter(|&column| shown[column]);
        for column in shown() {
            widths[column] = widths[column].max(TITLES[column].len());
        }
        let heading = TableRow { padding: true, ..TableRow::default() };
        let heading = shown().map(|column| (&heading, column, TITLES[column]));
        write_row(heading, &widths, paint, text);
        for row in &self.rows {
            let cells = shown().map(|column| (row, column, self.cell(row, column)));
            write_row(cells, &widths, paint, text);
        }
    }
}

/// Appends a line of the cells of a row.
fn write_row<'a>(
    cells: impl Iterator<Item = (&'a TableRow, usize, &'a str)>,
    widths: &[usize; COLUMNS],
    paint: Paint,
    text: &mut String,
) {
    let start = text.len();
    let mut caution = None;
    for (row, column, content) in cells {
        text.push_str("  ");
        write_cell(row, (column, widths[column]), content, paint, text);
        caution = row.caution.as_ref();
    }
    if let Some(caution) = caution {
        text.push_str("  ");
        text.push_str(&paint.text(CAUTION, &format!("<- {caution}")));
    }
    text.truncate(start + text[start..].trim_end().len());
    text.push('\n');
}

/// Appends a cell padded to its column's width: numbers aligned right, text left.
fn write_cell(
    row: &TableRow,
    (column, width): (usize, usize),
    content: &str,
    paint: Paint,
    line: &mut String,
) {
    let fill = width - columns(content);
    let is_word = column >= 5;
    if !is_word {
        fill_up(line, fill);
    }
    match column {
        _ if paint == Paint::Plain => line.push_str(content),
        _ if row.padding => line.push_str(&paint.text(FAINT, content)),
        3 => {
            // What enclosing arrays give is faint, as it is repeated in each row below them.
            let (around, own) = content.split_at(row.inherited);
            line.push_str(&paint.text(FAINT, around));
            line.push_str(own);
        }
        5 => line.push_str(&paint.text(TYPE, content)),
        _ => line.push_str(content),
    }
    if is_word && column != NAME {
        fill_up(line, fill);
    }
}

/// Appends blanks; `extend` takes several times as long.
fn fill_up(line: &mut String, mut blanks: usize) {
    const BLANKS: &str = "                                ";
    while blanks > 0 {
        let some = blanks.min(BLANKS.len());
        line.push_str(&BLANKS[..some]);
        blanks -= some;
    }
}

/// The columns that a text takes; most texts are ASCII, whose printable characters take one each.
fn columns(text: &str) -> usize {
    match text.bytes().all(|byte| matches!(byte, b' '..=b'~')) {
        true => text.len(),
        false => text.width(),
    }
}

#[cfg(test)]
mod tests {
    use crate::examples;
    use crate::format::{EmitOptions, Format, Paint, document};
    use crate::layout::NagaPlace;
    use crate::shape::Rules;
    use crate::source::Language;

    fn table(blocks: Vec<crate::BlockLayout>) -> String {
        let shader = examples::shader("a.frag", Language::Glsl, blocks);
        document(&shader, &EmitOptions::new(Format::Table))
    }

    #[test]
    fn point_lights_are_a_table_with_their_padding() {
        assert_eq!(
            table(vec![examples::point_lights()]),
            "\
a.frag (fragment)

uniform PointLightBlock u_point_light_array · std140 · 6,160 bytes
  offset  size  align  stride  type        name
       0  6144     16      48  PointLight  data[128]
       0    12     16      48  vec3          pos
      12     4             48                -- hole
      16    12     16      48  vec3          color
      28     4      4      48  float         intensity
      32     4      4      48  float         constant
      36     4      4      48  float         linear
      40     4      4      48  float         quadratic
      44     4             48                -- tail padding of PointLight
    6144     4      4          int         actually_used_count
    6148    12                             -- tail padding
  6,160 bytes: 5,124 used, 1,036 padding (16.8 %)
  offsets are those of element 0; element i lies i × stride further
"
        );
    }

    #[test]
    fn padding_behind_the_structure_of_an_element_follows_its_members() {
        let text = "#version 460\n#extension GL_EXT_scalar_block_layout : require\n\
            struct S { double d; float f; };\n\
            layout(scalar, binding = 0) buffer B { S s[2]; float last; };\n";
        let source = crate::Source::new("a.frag", text);
        let shader = crate::layout(&source, &crate::Options::default());
        let text = document(&shader, &EmitOptions::new(Format::Table));
        let rows = text.lines().skip(4).take(5);
        let offsets: Vec<&str> = rows.filter_map(|row| row.split_whitespace().next()).collect();
        assert_eq!(offsets, ["0", "0", "8", "12", "28"], "{text}");
    }

    #[test]
    fn nested_arrays_matrices_and_what_naga_says_are_shown() {
        let mut block = examples::padded(Rules::Std140);
        block.leaves[2].naga =
            Some(NagaPlace { offset: 28, dims: vec![Some(7)], strides: vec![4] });
        block.rules_declared = false;
        let text = table(vec![block]);
        for line in [
            "uniform B · std140 · rules not declared: the driver's offsets may differ",
            "    832 bytes",
            "      32   112     16         16           float   w[7]  <- naga reads 28 stride 4",
            "      36    12                16                     -- tail padding of each element",
            "     144     4      4  288 96 16           float       a",
            "     720    96     16         48  16 rows  mat2x3  r[2]",
        ] {
            assert!(text.contains(line), "{line}\n{text}");
        }
    }

    #[test]
    fn loose_uniforms_have_only_types_and_names() {
        let text = table(vec![examples::loose()]);
        assert!(text.contains("\n  type   name\n  vec3   view_pos\n"), "{text}");
        assert!(text.contains("  opaque, no bytes: diffuse\n"), "{text}");
    }

    #[test]
    fn colours_change_no_letter() {
        let blocks = || vec![examples::padded(Rules::Std430), examples::particles()];
        let shader = examples::shader("a.frag", Language::Glsl, blocks());
        let options = EmitOptions { paint: Paint::Ansi, ..EmitOptions::new(Format::Table) };
        let mut text = document(&shader, &options);
        assert!(text.contains("\x1b["));
        while let Some(start) = text.find('\x1b') {
            let end = start + text[start..].find('m').expect("an escape ends in m");
            text.replace_range(start..=end, "");
        }
        let plain = table(blocks());
        let trimmed = |text: &str| text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
        assert_eq!(trimmed(&text), trimmed(&plain));
    }

    #[test]
    fn expanded_every_element_has_a_row() {
        let shader = examples::shader("a.frag", Language::Glsl, vec![examples::point_lights()]);
        let options = EmitOptions { expand: true, ..EmitOptions::new(Format::Table) };
        let text = document(&shader, &options);
        assert!(text.contains("     160    12  vec3   data[3].color\n"), "{text}");
        assert_eq!(text.matches("data[").count(), 128 * 6);
    }
}
