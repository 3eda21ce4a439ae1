//! The bytes of a block as text: 16 in a line, each four named by what lies there.

use landfall_layout::BlockLayout;
use landfall_layout::layout::byte::{ByteOwner, owner_of_byte};

/// Lines of a map; a larger block is cut.
const MAX_LINES: u64 = 16;

/// Bytes of a line, and of each cell in it.
const LINE: u64 = 16;
const CELL: u64 = 4;

/// Characters of a cell.
const WIDTH: usize = 15;

/// Draws the map of a block; empty for one without bytes.
pub fn memory_map(block: &BlockLayout) -> String {
    let size = block.size.unwrap_or_default();
    let mut text = String::new();
    for line in 0..size.div_ceil(LINE).min(MAX_LINES) {
        let cells = (0..LINE / CELL).map(|cell| line * LINE + cell * CELL);
        let cells: Vec<String> = cells.filter(|at| *at < size).map(|at| cell(block, at)).collect();
        text.push_str(format!("{:>5}  {}", line * LINE, cells.concat()).trim_end());
        text.push('\n');
    }
    if size > LINE * MAX_LINES {
        text.push_str(&format!("       … to {size}\n"));
    }
    text
}

/// What lies in four bytes, by the first of them that is not padding.
fn cell(block: &BlockLayout, at: u64) -> String {
    let owners = (at..at + CELL).map(|byte| owner_of_byte(block, byte));
    let path = owners.into_iter().find_map(|owner| match owner {
        ByteOwner::Component { path, .. } => Some(path),
        ByteOwner::Padding { .. } | ByteOwner::Beyond { .. } | ByteOwner::Loose => None,
    });
    let name = path.unwrap_or_else(|| "·".to_string());
    // The end of a long path tells most.
    let long = name.chars().count().saturating_sub(WIDTH - 2);
    let name: String = match long {
        0 => name,
        long => std::iter::once('…').chain(name.chars().skip(long + 1)).collect(),
    };
    format!("{name:WIDTH$}")
}

#[cfg(test)]
mod tests {
    use landfall_layout::{Options, Source, layout};

    use super::*;

    #[test]
    fn each_four_bytes_are_named_by_their_component() {
        let text = "#version 450\nstruct Light { vec3 pos; vec3 colour_of_the_light; };\n\
            layout(std140) uniform B { Light a; float power; } b;\nvoid main() {}\n";
        let shader = layout(&Source::new("a.frag", text), &Options::default());
        // By the rules of std140: a vec3 is aligned to 16, a structure's size is a multiple of it.
        let expected = "    0  a.pos.x        a.pos.y        a.pos.z        ·\n   \
                        16  …_the_light.x  …_the_light.y  …_the_light.z  ·\n   \
                        32  power          ·              ·              ·\n";
        assert_eq!(memory_map(&shader.blocks[0]), expected);
    }
}
