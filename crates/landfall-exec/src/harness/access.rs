//! Read and write access of storage blocks, by their qualifiers.
//!
//! Layouts do not record it, so it is read from the text between the end of the previous
//! declaration and the block's name, and from inside its braces.

use crate::harness::probe::plan::Access;
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::{Files, Language};

/// Returns whether any member of a block may be written.
pub(crate) fn writable(block: &BlockLayout, files: &Files, language: Language) -> bool {
    member_accesses(block, files, language).iter().any(|access| access.write)
}

/// Returns the access of each member of a block, in declaration order.
pub(crate) fn member_accesses(
    block: &BlockLayout,
    files: &Files,
    language: Language,
) -> Vec<Access> {
    let all = |access| vec![access; block.members.len()];
    let file = files.get(block.span.file);
    let Some(file) = file.filter(|_| block.space == AddressSpace::Storage) else {
        return all(Access { read: true, write: false });
    };
    let text = without_comments(&file.text);
    let at = (block.span.start as usize).min(text.len());
    let before = &text[..at];
    match language {
        Language::Glsl | Language::SpirV => {
            // The qualifiers are between the end of the declaration before it and its name, or
            // before the member's: GLSL 4.60 §4.10.
            let start = before.rfind([';', '}']).map_or(0, |end| end + 1);
            let inside = text[at..].split('}').next().unwrap_or("");
            let inside = inside.split_once('{').map_or("", |(_, inside)| inside);
            let of_member = |member: &MemberLayout| {
                let own = inside.split(';').find(|own| has_word(own, &member.name)).unwrap_or("");
                let says = |word: &str| has_word(&before[start..], word) || has_word(own, word);
                Access { read: !says("writeonly"), write: !says("readonly") }
            };
            block.members.iter().map(of_member).collect()
        }
        Language::Wgsl => {
            let instance = block.instance.as_deref().unwrap_or(&block.name);
            // `var<storage, read_write> name: T`: the instance follows the bracket.
            let declared = text.split("var<").skip(1).find(|rest| {
                let name = rest.split_once('>').map_or("", |(_, name)| name.trim_start());
                name.strip_prefix(instance)
                    .is_some_and(|rest| rest.trim_start().starts_with([':', '=']))
            });
            let access = declared.and_then(|rest| rest.split('>').next()).unwrap_or("");
            // Without an access mode, a variable in `storage` can only be read.
            all(Access { read: true, write: has_word(access, "read_write") })
        }
    }
}

fn has_word(text: &str, word: &str) -> bool {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|other| other == word)
}

/// Returns the text with its comments replaced by spaces, byte for byte.
fn without_comments(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut result = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let end = match &bytes[at..] {
            [b'/', b'/', ..] => memchr::memchr(b'\n', &bytes[at..]).map(|end| at + end),
            [b'/', b'*', ..] => {
                memchr::memmem::find(&bytes[at + 2..], b"*/").map(|end| at + end + 4)
            }
            _ => {
                result.push(bytes[at]);
                at += 1;
                continue;
            }
        }
        .unwrap_or(bytes.len());
        result.resize(end, b' ');
        at = end;
    }
    String::from_utf8(result).expect("whole comments were replaced by spaces")
}
