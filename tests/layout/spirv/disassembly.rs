//! The text of `spirv-dis` (Debian package `spirv-tools`) as a reader of decorations that shares no code
//! with the crate or with the tests.

use std::collections::HashMap;
use std::io::Write as _;
use std::process::{Command, Stdio};

use landfall_layout::MemberLayout;
use landfall_layout::shape::ArrayLen;

use super::{BLOCKS, laid_out, random_module};
use crate::support::generate::{COMMON, VULKAN};
use crate::support::sample::sample;

/// Runs a program of `spirv-tools` from standard input to standard output.
pub fn tool(program: &str, arguments: &[&str], input: &[u8]) -> Vec<u8> {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap_or_else(|error| {
        panic!("cannot run {program} ({error}): install the Debian package `spirv-tools`")
    });
    let mut stdin = child.stdin.take().expect("it is piped");
    let input = input.to_vec();
    let writer = std::thread::spawn(move || drop(stdin.write_all(&input)));
    let output = child.wait_with_output().expect("it ends");
    writer.join().expect("it does not panic");
    let log = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program}: {log}");
    output.stdout
}

/// The lines of a disassembly by what they say of an id: `OpMemberDecorate %5 0 Offset 16`.
#[derive(Default)]
struct Text<'t> {
    /// The words after the opcode, by the opcode and the first words that tell lines apart.
    facts: HashMap<Vec<&'t str>, &'t str>,
    /// The right side of `%5 = …`.
    results: HashMap<&'t str, Vec<&'t str>>,
}

impl<'t> Text<'t> {
    fn of(text: &'t str) -> Text<'t> {
        let mut found = Text::default();
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                [id, "=", right @ ..] => drop(found.results.insert(id, right.to_vec())),
                [before @ .., last] if !before.is_empty() => {
                    found.facts.insert(before.to_vec(), last);
                    found.facts.insert(words.clone(), last);
                }
                _ => {}
            }
        }
        found
    }

    fn number(&self, key: &[&'t str]) -> Option<u64> {
        self.facts.get(key)?.parse().ok()
    }

    /// The structure of a name.
    fn structure(&self, name: &str) -> Option<&'t str> {
        let quoted = format!("\"{name}\"");
        let is_structure = |id: &str| self.results.get(id).is_some_and(|r| r[0] == "OpTypeStruct");
        let named = |(key, last): (&Vec<&'t str>, &&'t str)| match key.as_slice() {
            ["OpName", id] if **last == *quoted => Some(*id),
            _ => None,
        };
        self.facts.iter().filter_map(named).find(|id| is_structure(id))
    }

    /// Holds the members of a structure to its decorations; returns how many numbers agree.
    fn hold(&self, structure: &'t str, members: &[MemberLayout], block: &str) -> usize {
        let types = &self.results[structure][1..];
        assert_eq!(types.len(), members.len(), "{block}");
        let mut numbers = 0;
        for (index, (member, ty)) in members.iter().zip(types).enumerate() {
            let place = format!("{block}.{}", member.name);
            let index: &'t str = Box::leak(index.to_string().into_boxed_str());
            let of_member = |what| self.number(&["OpMemberDecorate", structure, index, what]);
            assert_eq!(
                self.facts[&vec!["OpMemberName", structure, index]],
                format!("\"{}\"", member.name)
            );
            assert_eq!(of_member("Offset"), member.offset, "{place}");
            assert_eq!(of_member("MatrixStride"), member.matrix_stride, "{place}");
            let by_rows = vec!["OpMemberDecorate", structure, index, "RowMajor"];
            assert_eq!(self.facts.contains_key(&by_rows), member.row_major, "{place}");
            let mut ty: &'t str = ty;
            for (len, stride) in member.dims.iter().zip(&member.strides) {
                assert_eq!(
                    self.number(&["OpDecorate", ty, "ArrayStride"]),
                    Some(*stride),
                    "{place}"
                );
                let array = &self.results[ty];
                let length = array.get(2).map(|length| self.results[length][2]);
                let ours = match len {
                    ArrayLen::Fixed(len) => Some(len.to_string()),
                    ArrayLen::Runtime | ArrayLen::Override(_) => None,
                };
                assert_eq!(length.map(str::to_string), ours, "{place}");
                ty = array[1];
                numbers += 1;
            }
            numbers += 1;
            if !member.members.is_empty() {
                numbers += self.hold(ty, &member.members, &place);
            }
        }
        numbers
    }
}

#[test]
fn decorations_in_the_text_of_spirv_dis_are_the_numbers_that_are_reported() {
    let mut numbers = 0;
    for (seed, diet) in sample(100..110, 10).flat_map(|seed| [(seed, &COMMON), (seed, &VULKAN)]) {
        let (_, words) = random_module(seed, diet);
        let text = tool("spirv-dis", &["--raw-id", "--no-header", "-"], &super::bytes(&words));
        let text = String::from_utf8(text).expect("names of GLSL are ASCII");
        let text = Text::of(&text);
        let shader = laid_out(&words);
        assert_eq!(shader.blocks.len(), BLOCKS);
        for block in &shader.blocks {
            let structure = text.structure(&block.name).expect("it is named in the text");
            numbers += text.hold(structure, &block.members, &block.name);
        }
    }
    assert!(numbers > 1_000, "{numbers} numbers were compared");
}
