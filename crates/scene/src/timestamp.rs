//! Time stamp of messages and transforms, in nanoseconds.

/// A point in time: nanoseconds since the Unix epoch, or since the start of a simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Time(i64);

impl Time {
    /// The stamp of a message that was never stamped.
    pub const ZERO: Self = Self(0);

    /// The time that is this number of nanoseconds after the epoch of its clock.
    #[must_use]
    pub const fn from_nanoseconds(nanoseconds: i64) -> Self {
        Self(nanoseconds)
    }

    /// Nanoseconds since the epoch of its clock.
    #[must_use]
    pub const fn nanoseconds(self) -> i64 {
        self.0
    }

    /// Seconds from `earlier` to this time; negative if this time is before it.
    #[must_use]
    pub fn seconds_since(self, earlier: Self) -> f64 {
        // a difference of two i64 needs 65 bits; f64 keeps microseconds over 285 years
        let nanoseconds = i128::from(self.0) - i128::from(earlier.0);
        #[expect(clippy::cast_precision_loss, reason = "rounds to less than a microsecond")]
        let nanoseconds = nanoseconds as f64;
        nanoseconds * 1e-9
    }
}
