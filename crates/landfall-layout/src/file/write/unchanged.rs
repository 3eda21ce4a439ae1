//! Whether a file has the bytes already that are to be written to it.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The bytes that are compared at a time: a large file is not read beyond the first difference.
const COMPARED: usize = 1 << 16;

/// Whether a file has these bytes and no others.
pub(super) fn holds(path: &Path, bytes: &[u8]) -> io::Result<bool> {
    let mut file = File::open(path)?;
    let mut old = vec![0; bytes.len().min(COMPARED)];
    for part in bytes.chunks(COMPARED) {
        let old = &mut old[..part.len()];
        file.read_exact(old)?;
        if old != part {
            return Ok(false);
        }
    }
    Ok(file.read(&mut [0])? == 0)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::*;
    use super::COMPARED;

    #[test]
    fn only_a_file_of_other_bytes_is_written_again() {
        let folder = std::env::temp_dir().join(format!("landfall-again-{}", partial_name()));
        fs::create_dir_all(&folder).expect("temporary files can be written");
        let (path, writer) = (folder.join("file"), FileWriter::new([folder.join("input")]));
        let mut bytes = vec![0u8; COMPARED + 2];
        for len in [0, 1, COMPARED - 1, COMPARED, COMPARED + 1, COMPARED + 2, COMPARED + 1] {
            assert_eq!(writer.write(&path, &bytes[..len]).ok(), Some(Written::Changed));
            assert_eq!(writer.write(&path, &bytes[..len]).ok(), Some(Written::Unchanged));
        }
        bytes[COMPARED] = 1;
        assert_eq!(writer.write(&path, &bytes[..=COMPARED]).ok(), Some(Written::Changed));
        assert_eq!(fs::read(&path).ok().as_deref(), Some(&bytes[..=COMPARED]));
        fs::remove_dir_all(&folder).expect("the folder of this test");
    }
}
