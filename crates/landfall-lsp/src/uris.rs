//! Paths of `file:` URIs, and URIs of paths (RFC 8089).

use std::path::{Path, PathBuf};

use gen_lsp_types::Uri;

/// The path of a `file:` URI; `None` for other schemes, whose documents are not of the file system.
pub fn path(uri: &Uri) -> Option<PathBuf> {
    let rest = uri.0.strip_prefix("file://")?;
    // An authority stands before the path; only the local host has files here.
    let (_, rest) = rest.split_at(rest.find('/')?);
    let text = String::from_utf8(decoded(rest.as_bytes())?).ok()?;
    let bytes = text.as_bytes();
    let has_drive = bytes.len() > 2 && bytes[1].is_ascii_alphabetic() && bytes[2] == b':';
    Some(PathBuf::from(if cfg!(windows) && has_drive { &text[1..] } else { &text }))
}

fn decoded(text: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text;
    while let [first, tail @ ..] = rest {
        if *first == b'%' {
            let digits = std::str::from_utf8(tail.get(..2)?).ok()?;
            bytes.push(u8::from_str_radix(digits, 16).ok()?);
            rest = &tail[2..];
        } else {
            bytes.push(*first);
            rest = tail;
        }
    }
    Some(bytes)
}

/// The `file:` URI of an absolute path.
pub fn uri(path: &Path) -> Uri {
    let text = path.to_string_lossy().replace('\\', "/");
    let mut uri = String::from("file://");
    if !text.starts_with('/') {
        uri.push('/');
    }
    for byte in text.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                uri.push(char::from(byte));
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    Uri(uri)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_that_of_its_uri() {
        for text in ["/a/b.frag", "/with space/ü%.wgsl", "/100%25"] {
            assert_eq!(path(&uri(Path::new(text))), Some(PathBuf::from(text)), "{text}");
        }
        let from = |text: &str| path(&Uri(text.to_string()));
        assert_eq!(from("file://localhost/a"), Some(PathBuf::from("/a")));
        for other in ["untitled:1", "git:/a.frag", "file://", "file:///%zz", "file:///%2"] {
            assert_eq!(from(other), None, "{other}");
        }
    }
}
