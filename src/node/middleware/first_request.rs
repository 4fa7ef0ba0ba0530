//! Asks Fast DDS writers at once for what they sent before they were known here.
//!
//! A reliable reader that meets a writer asks it for what it has. `RustDDS` asks with an ACKNACK of base 1 and count 0;
//! Fast DDS heeds neither, and comes with its next heartbeat, up to 3 s later. A client calls a service as soon as it
//! sees it, some 10 ms before `RustDDS` has met it, so that the first call of every client would take these 3 s (20 of 20
//! measured); a best-effort reader loses such calls altogether (19 of 20). A question of our own, sent beside the
//! library's, brings the answer in milliseconds.

use super::rtps::{Entity, message, sequence_number};

/// The vendor that needs it, as its participants' identifiers begin: eProsima.
const FAST_DDS: [u8; 2] = [0x01, 0x0f];

const ACKNACK: (u8, u8) = (0x06, 0);

/// What asks `writer` for its first sample, if it is a Fast DDS one, on behalf of our `reader`.
///
/// A new client's first request is sample 1. The ACKNACK asks for that and, without its final flag, wants an answer.
/// Fast DDS heeds only counts that grow, so it passes over `RustDDS`'s own next ACKNACK, which has this count too; that costs
/// nothing unless a packet is lost just then.
pub fn question(reader: &Entity, writer: &Entity) -> Option<Vec<u8>> {
    const COUNT: u32 = 1;
    // one bit, the first of its word
    const ONLY_THE_FIRST: [u32; 2] = [1, 1 << 31];
    if writer[..2] != FAST_DDS {
        return None;
    }
    let [length, bits] = ONLY_THE_FIRST.map(u32::to_le_bytes);
    let body =
        [&reader[12..], &writer[12..], &sequence_number(1), &length, &bits, &COUNT.to_le_bytes()].concat();
    Some(message(reader, writer, ACKNACK, &body))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_question_is_an_acknack() {
        let mut writer = [9; 16];
        assert_eq!(question(&[7; 16], &writer), None);

        writer[..2].copy_from_slice(&FAST_DDS);
        let asked = question(&[7; 16], &writer).unwrap();
        let acknack = &asked[36..];
        assert_eq!(acknack[..4], [0x06, 1, 28, 0]);
        assert_eq!(acknack.len(), 4 + 28);
        assert_eq!(acknack[4..12], [7, 7, 7, 7, 9, 9, 9, 9]);
        assert_eq!(acknack[12..24], [0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
        assert_eq!(acknack[24..], [0, 0, 0, 0x80, 1, 0, 0, 0]);
    }
}
