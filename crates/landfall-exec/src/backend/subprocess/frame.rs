//! The message format between the processes: a value in postcard's encoding, which one program both
//! writes and reads.

use std::io::{self, Read, Write};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use landfall_interp::backend::as_bytes;

/// The start of every message. Anything else on stdout, such as a driver's prints, is skipped.
const MAGIC: [u8; 8] = *b"\x01lndfall";

/// A message, to be sent or received.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct WireFrame {
    /// Its value in postcard's encoding.
    body: Vec<u8>,
}

/// Bytes in a message.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Blob(#[serde(with = "as_bytes")] pub(super) Vec<u8>);

impl WireFrame {
    pub(super) fn new(value: &impl Serialize) -> io::Result<WireFrame> {
        Ok(WireFrame { body: encode(value)? })
    }

    /// Parses the value.
    pub(super) fn value<T: DeserializeOwned>(&self) -> io::Result<T> {
        postcard::from_bytes(&self.body).map_err(io::Error::other)
    }

    pub(super) fn write(&self, to: &mut impl Write) -> io::Result<()> {
        // The magic number, the length of the body, 64 bits in little-endian order, and the body.
        to.write_all(&MAGIC)?;
        to.write_all(&(self.body.len() as u64).to_le_bytes())?;
        to.write_all(&self.body)?;
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
        let mut length = [0; 8];
        from.read_exact(&mut length)?;
        let length = u64::from_le_bytes(length);
        // Not allocated ahead, as nothing vouches for the length.
        let mut body = Vec::new();
        from.take(length).read_to_end(&mut body)?;
        if body.len() as u64 != length {
            return Err(invalid("the message is shorter than it states"));
        }
        Ok(Some(WireFrame { body }))
    }
}

pub(super) fn encode(value: &impl Serialize) -> io::Result<Vec<u8>> {
    postcard::to_stdvec(value).map_err(io::Error::other)
}

pub(super) fn invalid(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_come_out_as_they_went_in_whatever_a_driver_prints_between() {
        let first = WireFrame::new(&("first", Blob(vec![1, 2, 3]))).unwrap();
        let second = WireFrame::new(&[2, 3]).unwrap();
        let mut stream = b"warning: \x01\x01lnd\n".to_vec();
        first.write(&mut stream).unwrap();
        stream.extend(b"deprecated \x01");
        second.write(&mut stream).unwrap();
        let mut from = &stream[..];
        let read = WireFrame::read(&mut from).unwrap().unwrap();
        assert_eq!(read, first);
        let (name, blob) = read.value::<(String, Blob)>().unwrap();
        assert_eq!((name.as_str(), &blob.0[..]), ("first", &[1, 2, 3][..]));
        assert!(read.value::<(String, Blob, Blob)>().is_err());
        assert_eq!(WireFrame::read(&mut from).unwrap().unwrap(), second);
        assert_eq!(WireFrame::read(&mut from).unwrap(), None);
    }

    #[test]
    fn a_message_that_breaks_off_is_an_error() {
        let mut stream = Vec::new();
        WireFrame::new(&Blob(vec![7; 100])).unwrap().write(&mut stream).unwrap();
        for cut in [8, 12, 60, stream.len() - 1] {
            assert!(WireFrame::read(&mut &stream[..cut]).is_err(), "{cut}");
        }
        // A length that no memory holds is not believed.
        stream[8..16].fill(0xFF);
        assert!(WireFrame::read(&mut &stream[..]).is_err());
    }
}
