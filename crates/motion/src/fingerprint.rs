//! Incremental hash of data too large to be written as text first.

use clearance_geometry::math::Pose;
use sha2::{Digest, Sha256};

/// SHA-256 over a sequence of texts and numbers; texts and lists are preceded by their lengths, so that different sequences have
/// different inputs.
#[derive(Debug, Default)]
pub struct Fingerprint(Sha256);

impl std::io::Write for Fingerprint {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.bytes(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Fingerprint {
    /// Adds a text, preceded by its length.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.count(text.len());
        self.bytes(text.as_bytes())
    }

    /// Adds bytes without their length.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.update(bytes);
        self
    }

    /// Adds a count.
    pub fn count(&mut self, count: usize) -> &mut Self {
        self.0.update((count as u64).to_le_bytes());
        self
    }

    /// Bit by bit.
    pub fn numbers(&mut self, numbers: &[f64]) -> &mut Self {
        self.count(numbers.len());
        for number in numbers {
            self.0.update(number.to_bits().to_le_bytes());
        }
        self
    }

    /// Adds indices without their number.
    pub fn indices(&mut self, indices: &[u32]) -> &mut Self {
        for index in indices {
            self.0.update(index.to_le_bytes());
        }
        self
    }

    /// Adds a pose as seven numbers, bit by bit.
    pub fn pose(&mut self, pose: &Pose) -> &mut Self {
        let (t, q) = (pose.translation.vector, pose.rotation.coords);
        self.numbers(&[t.x, t.y, t.z, q.x, q.y, q.z, q.w])
    }

    /// In hexadecimal digits.
    pub fn finish(self) -> String {
        let digit = |half: u8| char::from_digit(u32::from(half), 16).unwrap_or('0');
        self.0.finalize().iter().flat_map(|byte| [digit(byte >> 4), digit(byte & 15)]).collect()
    }
}
