//! Detects lost messages from gaps in the sequence numbers of their publishers.

use std::collections::BTreeMap;

use clearance_monitor::SourceId;

/// Maximum number of tracked publishers.
const MOST: usize = 100;

/// Last sequence number of each publisher.
#[derive(Debug, Default)]
pub struct SequenceGaps(BTreeMap<SourceId, i64>);

impl SequenceGaps {
    /// Number of missing messages of a publisher directly before its message `number`. Messages before the first
    /// received one are not counted.
    pub fn missing_before(&mut self, publisher: SourceId, number: i64) -> u64 {
        if self.0.len() >= MOST && !self.0.contains_key(&publisher) {
            self.0.clear();
        }
        let last = self.0.entry(publisher).or_insert(number);
        let missing = number.saturating_sub(*last).saturating_sub(1);
        // a late message was counted as missing before
        *last = number.max(*last);
        u64::try_from(missing).unwrap_or(0)
    }

    /// Whether a publisher's message `number` arrives after a later message, or is a duplicate.
    pub fn is_overtaken(&mut self, publisher: SourceId, number: i64) -> bool {
        let is_overtaken = self.0.get(&publisher).is_some_and(|&last| number <= last);
        self.missing_before(publisher, number);
        is_overtaken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn publisher(number: u8) -> SourceId {
        SourceId([number; 16])
    }

    #[test]
    fn gaps_are_counted_for_each_publisher() {
        let mut sequence_gaps = SequenceGaps::default();
        let mut missing = |source, numbers: &[i64]| {
            numbers.iter().map(|&n| sequence_gaps.missing_before(publisher(source), n)).collect::<Vec<_>>()
        };
        assert_eq!(missing(1, &[700, 701, 705, 704, 706, 706, 708]), [0, 0, 3, 0, 0, 0, 1]);
        assert_eq!(missing(2, &[1, 3, i64::MIN, i64::MAX]), [0, 1, 0, i64::MAX as u64 - 4]);
        assert_eq!(missing(1, &[709]), [0]);
    }

    #[test]
    fn what_is_overtaken_is_known_for_each_publisher() {
        let mut sequence_gaps = SequenceGaps::default();
        let mut overtaken = |source, numbers: &[i64]| {
            numbers.iter().map(|&n| sequence_gaps.is_overtaken(publisher(source), n)).collect::<Vec<_>>()
        };
        assert_eq!(overtaken(1, &[7, 8, 10, 9, 10, 11]), [false, false, false, true, true, false]);
        assert_eq!(overtaken(2, &[i64::MAX, i64::MIN]), [false, true]);
        assert_eq!(overtaken(1, &[12]), [false]);
    }

    #[test]
    fn publishers_without_end_take_no_memory_without_end() {
        let mut sequence_gaps = SequenceGaps::default();
        for number in 0..=u8::MAX {
            assert_eq!(sequence_gaps.missing_before(publisher(number), 5), 0);
            assert!(sequence_gaps.0.len() <= MOST);
        }
    }
}
