//! Paths as URI references (RFC 3986).

/// A path as a URI.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Uri {
    /// Relative to the directory that the command ran in.
    Relative(String),
    /// `file:///…`.
    Absolute(String),
}

/// Returns the URI of a path whose parts are separated by `/`.
pub(super) fn from_path(path: &str) -> Uri {
    let bytes = path.as_bytes();
    // A drive of Windows: `C:/`.
    let drive = bytes.len() > 2 && bytes[0].is_ascii_alphabetic() && &bytes[1..3] == b":/";
    match path.strip_prefix('/') {
        Some(rest) => Uri::Absolute(format!("file:///{}", escaped(rest))),
        None if drive => Uri::Absolute(format!("file:///{}:{}", &path[..1], escaped(&path[2..]))),
        None => Uri::Relative(escaped(path.strip_prefix("./").unwrap_or(path))),
    }
}

/// Escapes every byte except unreserved ones (section 2.3) and `/` as `%XX`.
fn escaped(path: &str) -> String {
    let mut result = String::with_capacity(path.len());
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                result.push(char::from(byte));
            }
            byte => result.push_str(&format!("%{byte:02X}")),
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_path_is_taken_for_a_scheme_a_query_or_a_host() {
        let relative = |uri: &str| Uri::Relative(uri.to_string());
        let absolute = |uri: &str| Uri::Absolute(uri.to_string());
        assert_eq!(from_path("a b/c:d,e.frag"), relative("a%20b/c%3Ad%2Ce.frag"));
        assert_eq!(from_path("http:/x?y#z%20"), relative("http%3A/x%3Fy%23z%2520"));
        assert_eq!(from_path("./é/漢"), relative("%C3%A9/%E6%BC%A2"));
        assert_eq!(from_path("/tmp/a b"), absolute("file:///tmp/a%20b"));
        assert_eq!(from_path("C:/a:b"), absolute("file:///C:/a%3Ab"));
    }
}
