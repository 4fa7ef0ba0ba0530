//! Messages as bytes: CDR with the four bytes before it that say so.

use std::io;

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Plain CDR, little end first.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// A message as it goes over the wire.
pub fn encode<M: Serialize>(message: &M) -> Result<Vec<u8>, String> {
    let mut bytes = HEADER.to_vec();
    cdr_encoding::to_writer::<_, LittleEndian, _>(&mut bytes, message).map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// Bytes that a message takes; of one that can not be written, those before the fault.
pub fn size_of(message: &impl Serialize) -> usize {
    let mut counter = Counter(HEADER.len());
    let _ = cdr_encoding::to_writer::<_, LittleEndian, _>(&mut counter, message);
    counter.0
}

/// Counts what is written.
struct Counter(usize);

impl io::Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A message out of a stranger's bytes.
pub fn decode<M: DeserializeOwned>(bytes: &[u8]) -> Result<M, String> {
    let body = bytes.strip_prefix(&HEADER).ok_or("is not plain CDR, little end first")?;
    let decoded = cdr_encoding::from_bytes::<M, LittleEndian>(body);
    decoded.map(|(message, _)| message).map_err(|error| error.to_string())
}
