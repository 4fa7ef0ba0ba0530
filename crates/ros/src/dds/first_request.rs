//! Requests samples that a Fast DDS writer sent before `RustDDS` knew that writer.
//!
//! A client calls a service as soon as it has discovered it, some 10 ms before `RustDDS` has discovered the client's
//! writer, and `RustDDS` discards what comes from an unknown writer. A reliable reader then requests the sample again.
//! The library's own ACKNACK (base 1, count 0) does not make Fast DDS resend; its next heartbeat follows 3 s later. So
//! this module sends its own requests in addition.
//!
//! One request is not enough. Fast DDS ignores an ACKNACK for a sample that it is still sending (status `UNDERWAY`, up
//! to some milliseconds after the write), but records its count. It then ignores `RustDDS`'s next ACKNACK too, since
//! that has the same count. The call takes two heartbeat periods, 6 s (4 % to 8 % of new clients). So the request is
//! repeated with growing counts.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use rustdds::GUID;

use crate::dds::rtps::{Entity, SubmessageKind, message, sequence_number};

/// Vendor identifier of eProsima, with which the GUIDs of Fast DDS participants begin.
const FAST_DDS: [u8; 2] = [0x01, 0x0f];

const ACKNACK: SubmessageKind = SubmessageKind { id: 0x06, flags: 0 };

/// Intervals before each request (ms); the first one starts at the match. They exceed the 5 ms in which Fast DDS
/// collects requests.
///
/// Each request makes Fast DDS ignore one request of `RustDDS`, which matters only if a packet is lost soon after. So
/// there are few.
const INTERVALS: [u64; 4] = [0, 10, 40, 200];

/// Largest number of writers with outstanding requests, so that a hostile network cannot use up the memory.
const CAPACITY: usize = 1000;

/// A matched writer whose first samples may have been discarded.
#[derive(Debug)]
struct Match {
    reader: GUID,
    writer: GUID,
    addresses: Vec<SocketAddr>,
    /// When the next request is due.
    due: Instant,
    /// Requests sent so far.
    sent: usize,
}

/// The schedule of requests to recently matched writers.
#[derive(Debug, Default)]
pub struct FirstRequests(Vec<Match>);

impl FirstRequests {
    /// Schedules requests to `writer`, if it is one of Fast DDS, on behalf of our `reader`.
    pub fn matched(&mut self, reader: GUID, writer: GUID, addresses: Vec<SocketAddr>, now: Instant) {
        if writer.to_bytes()[..2] == FAST_DDS && !addresses.is_empty() && self.0.len() < CAPACITY {
            self.0.push(Match { reader, writer, addresses, due: now, sent: 0 });
        }
    }

    /// Drops the requests to a writer that is gone.
    pub fn lost(&mut self, writer: GUID) {
        self.0.retain(|matched| matched.writer != writer);
    }

    /// When the next request is due.
    pub fn next_due(&self) -> Option<Instant> {
        self.0.iter().map(|matched| matched.due).min()
    }

    /// Takes the messages that are due now, with their destinations.
    pub fn take_due(&mut self, now: Instant) -> Vec<(Vec<u8>, Vec<SocketAddr>)> {
        let mut due = Vec::new();
        for matched in &mut self.0 {
            if matched.due <= now {
                let request = request(&matched.reader.to_bytes(), &matched.writer.to_bytes(), matched.sent);
                due.push((request, matched.addresses.clone()));
                matched.sent += 1;
                // the interval counts from now, also after a late request
                let interval = INTERVALS.get(matched.sent).copied().unwrap_or_default();
                matched.due = now + Duration::from_millis(interval);
            }
        }
        self.0.retain(|matched| matched.sent < INTERVALS.len());
        due
    }
}

/// The request of this index in the schedule: an ACKNACK for sample 1, the first request of a new client.
fn request(reader: &Entity, writer: &Entity, index: usize) -> Vec<u8> {
    // bitmap of a sequence number set with only the first element
    const ONLY_THE_FIRST: [u8; 8] = [1, 0, 0, 0, 0, 0, 0, 0x80];
    // the library's first ACKNACK has count 0
    let count = u32::try_from(index).unwrap_or(u32::MAX).saturating_add(1);
    let body =
        [&reader[12..], &writer[12..], &sequence_number(1), &ONLY_THE_FIRST, &count.to_le_bytes()].concat();
    message(reader, writer, ACKNACK, &body)
}

#[cfg(test)]
mod tests {
    use super::*;

    const READER: Entity = [7; 16];

    fn fast_dds() -> Entity {
        let mut writer = [9; 16];
        writer[..2].copy_from_slice(&FAST_DDS);
        writer
    }

    fn address() -> Vec<SocketAddr> {
        vec![SocketAddr::from(([127, 0, 0, 1], 7411))]
    }

    #[test]
    fn a_request_is_an_acknack_whose_count_grows() {
        for (index, count) in (0..INTERVALS.len()).zip(1..) {
            let request = request(&READER, &fast_dds(), index);
            let acknack = &request[36..];
            assert_eq!(acknack[..4], [0x06, 1, 28, 0]);
            assert_eq!(acknack.len(), 4 + 28);
            assert_eq!(acknack[4..12], [7, 7, 7, 7, 9, 9, 9, 9]);
            assert_eq!(acknack[12..24], [0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
            assert_eq!(acknack[24..], [0, 0, 0, 0x80, count, 0, 0, 0]);
        }
    }

    #[test]
    fn requests_are_repeated_until_the_schedule_or_the_writer_ends() {
        let (mut requests, start) = (FirstRequests::default(), Instant::now());
        let (reader, writer) = (GUID::from_bytes(READER), GUID::from_bytes(fast_dds()));
        requests.matched(reader, GUID::from_bytes([9; 16]), address(), start);
        requests.matched(reader, writer, Vec::new(), start);
        assert_eq!(requests.next_due(), None, "others resend without it, and nothing is sent to nowhere");

        requests.matched(reader, writer, address(), start);
        let mut times = Vec::new();
        while let Some(due) = requests.next_due() {
            assert!(
                requests
                    .take_due(due.checked_sub(Duration::from_micros(1)).expect("a time after the start"))
                    .is_empty()
            );
            assert_eq!(requests.take_due(due).len(), 1);
            times.push(due - start);
        }
        let expected = INTERVALS.iter().scan(0, |sum, interval| {
            *sum += interval;
            Some(Duration::from_millis(*sum))
        });
        assert_eq!(times, expected.collect::<Vec<_>>());

        requests.matched(reader, writer, address(), start);
        requests.lost(writer);
        assert_eq!(requests.next_due(), None);
    }

    #[test]
    fn late_requests_keep_their_distance() {
        let (mut requests, start) = (FirstRequests::default(), Instant::now());
        requests.matched(GUID::from_bytes(READER), GUID::from_bytes(fast_dds()), address(), start);
        let late = start + Duration::from_secs(1);
        assert_eq!(requests.take_due(late).len(), 1);
        assert_eq!(requests.next_due(), Some(late + Duration::from_millis(INTERVALS[1])));
    }

    #[test]
    fn the_number_of_outstanding_requests_is_bounded() {
        let (mut requests, start) = (FirstRequests::default(), Instant::now());
        for number in 0..2 * u32::try_from(CAPACITY).unwrap() {
            let mut writer = fast_dds();
            writer[2..6].copy_from_slice(&number.to_le_bytes());
            requests.matched(GUID::from_bytes(READER), GUID::from_bytes(writer), address(), start);
        }
        assert_eq!(requests.take_due(start).len(), CAPACITY);
    }
}
