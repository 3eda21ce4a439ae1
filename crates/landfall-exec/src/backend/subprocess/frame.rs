//! The message format between the processes: a header in postcard's encoding, which one program both
//! writes and reads, beside binary blobs.

use std::io::{self, Read, Write};

use serde::Serialize;
use serde::de::DeserializeOwned;

/// The start of every message. Anything else on stdout, such as a driver's prints, is skipped.
const MAGIC: [u8; 8] = *b"\x01lndfall";

/// A message, to be sent or received.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct WireFrame {
    /// The header in postcard's encoding.
    header: Vec<u8>,
    blobs: Vec<Vec<u8>>,
}

/// The index of a blob in its message.
pub(super) type Blob = usize;

impl WireFrame {
    /// Appends a blob and returns its index.
    pub(super) fn put(&mut self, bytes: Vec<u8>) -> Blob {
        self.blobs.push(bytes);
        self.blobs.len() - 1
    }

    /// Takes a blob out of the message; it can be taken once.
    pub(super) fn take(&mut self, blob: Blob) -> io::Result<Vec<u8>> {
        self.blobs
            .get_mut(blob)
            .map(std::mem::take)
            .ok_or_else(|| invalid("the message refers to data that it does not contain"))
    }

    pub(super) fn with(mut self, header: &impl Serialize) -> io::Result<WireFrame> {
        self.header = encode(header)?;
        Ok(self)
    }

    /// Parses the header.
    pub(super) fn header<T: DeserializeOwned>(&self) -> io::Result<T> {
        postcard::from_bytes(&self.header).map_err(io::Error::other)
    }

    pub(super) fn write(&self, to: &mut impl Write) -> io::Result<()> {
        // The magic number, the length of the header, the number of blobs and the length of each,
        // 64 bits in little-endian order; then the header and the blobs.
        to.write_all(&MAGIC)?;
        for length in [self.header.len(), self.blobs.len()] {
            to.write_all(&(length as u64).to_le_bytes())?;
        }
        for blob in &self.blobs {
            to.write_all(&(blob.len() as u64).to_le_bytes())?;
        }
        to.write_all(&self.header)?;
        for blob in &self.blobs {
            to.write_all(blob)?;
        }
        to.flush()
    }

    /// Reads the next message; `None` at the end of the stream.
    pub(super) fn read(from: &mut impl Read) -> io::Result<Option<WireFrame>> {
        // Up to the magic number: what precedes it was printed by a driver.
        let mut matched = 0;
        while matched < MAGIC.len() {
            let mut byte = [0];
            if from.read(&mut byte)? == 0 {
                return Ok(None);
            }
            matched = match byte[0] {
                byte if byte == MAGIC[matched] => matched + 1,
                // The first byte occurs nowhere else in the magic number.
                byte => usize::from(byte == MAGIC[0]),
            };
        }
        let header = length(from)?;
        let blobs = length(from)?;
        let lengths: io::Result<Vec<u64>> = (0..blobs).map(|_| length(from)).collect();
        let header = bytes(from, header)?;
        let blobs: io::Result<Vec<Vec<u8>>> =
            lengths?.into_iter().map(|length| bytes(from, length)).collect();
        Ok(Some(WireFrame { header, blobs: blobs? }))
    }
}

pub(super) fn encode(value: &impl Serialize) -> io::Result<Vec<u8>> {
    postcard::to_stdvec(value).map_err(io::Error::other)
}

fn length(from: &mut impl Read) -> io::Result<u64> {
    let mut eight = [0; 8];
    from.read_exact(&mut eight)?;
    Ok(u64::from_le_bytes(eight))
}

/// Reads `length` bytes, without allocating them ahead.
fn bytes(from: &mut impl Read, length: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length {
        Ok(bytes)
    } else {
        Err(invalid("the message is shorter than its header states"))
    }
}

pub(super) fn invalid(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_come_out_as_they_went_in_whatever_a_driver_prints_between() {
        let mut first = WireFrame::default();
        assert_eq!((first.put(vec![1, 2, 3]), first.put(Vec::new())), (0, 1));
        let first = first.with(&"first").unwrap();
        let second = WireFrame::default().with(&[2, 3]).unwrap();
        let mut stream = b"warning: \x01\x01lnd\n".to_vec();
        first.write(&mut stream).unwrap();
        stream.extend(b"deprecated \x01");
        second.write(&mut stream).unwrap();
        let mut from = &stream[..];
        let mut read = WireFrame::read(&mut from).unwrap().unwrap();
        assert_eq!(read, first);
        assert_eq!(read.header::<String>().unwrap(), "first");
        assert_eq!(read.take(0).unwrap(), [1, 2, 3]);
        assert!(read.take(2).is_err());
        assert_eq!(WireFrame::read(&mut from).unwrap().unwrap(), second);
        assert_eq!(WireFrame::read(&mut from).unwrap(), None);
    }

    #[test]
    fn a_message_that_breaks_off_is_an_error() {
        let mut frame = WireFrame::default();
        frame.put(vec![7; 100]);
        let mut stream = Vec::new();
        frame.with(&"cut").unwrap().write(&mut stream).unwrap();
        for cut in [8, 20, 60, stream.len() - 1] {
            assert!(WireFrame::read(&mut &stream[..cut]).is_err(), "{cut}");
        }
        // A length that no memory holds is not believed.
        stream[8..16].fill(0xFF);
        assert!(WireFrame::read(&mut &stream[..]).is_err());
    }
}
