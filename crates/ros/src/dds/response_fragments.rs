//! Fragments of a long service response (RTPS 2.5, section 9.4.5.5, `DATA_FRAG`).

use crate::dds::rtps::{Entity, SubmessageKind, message, sequence_number};

/// Bytes of the response in a fragment. With all headers, a fragment fits into a datagram of any common network.
const FRAGMENT: u16 = 1024;

/// The flag means that inline parameters follow: they identify the request.
const DATA_FRAG: SubmessageKind = SubmessageKind { id: 0x16, flags: 2 };

/// Serialized response of a service.
pub struct LongResponse<'a> {
    /// Writer of the response, and the sequence number of the response among its samples.
    pub writer: Entity,
    pub number: i64,
    /// Writer of the request, and the sequence number of the request.
    pub request: (Entity, i64),
    pub bytes: &'a [u8],
}

impl LongResponse<'_> {
    /// The RTPS messages that carry the response to a reader.
    pub fn fragments(&self, reader: Entity) -> impl Iterator<Item = Vec<u8>> {
        let head = self.head(&reader);
        let request_identity = self.request_identity();
        let size = u32::try_from(self.bytes.len()).expect("no response has four gigabytes");
        (1_u32..).zip(self.bytes.chunks(usize::from(FRAGMENT))).map(move |(index, part)| {
            let [count, length] = [1, FRAGMENT].map(u16::to_le_bytes);
            let body = [
                head.as_slice(),
                &index.to_le_bytes(),
                &count,
                &length,
                &size.to_le_bytes(),
                &request_identity,
                part,
            ]
            .concat();
            message(&self.writer, &reader, DATA_FRAG, &body)
        })
    }

    /// Beginning of all fragments, up to the sequence number.
    fn head(&self, reader: &Entity) -> Vec<u8> {
        // no extra flags; the parameters begin 28 bytes after this field
        const FLAGS_AND_OFFSET: [u8; 4] = [0, 0, 28, 0];
        [FLAGS_AND_OFFSET.as_slice(), &reader[12..], &self.writer[12..], &sequence_number(self.number)]
            .concat()
    }

    /// Identity of the request, as parameters of every fragment. It is repeated under the identifier of the standard
    /// (DDS-RPC,
    /// 7.8.2) and under the identifier that Fast DDS used before it. Then follows the end of the list.
    fn request_identity(&self) -> Vec<u8> {
        const IDENTIFIERS: [u16; 2] = [0x0083, 0x800f];
        const LENGTH: u16 = 24;
        const SENTINEL: [u8; 4] = [1, 0, 0, 0];
        let (entity, number) = self.request;
        let named = IDENTIFIERS.map(|identifier| {
            let header = [identifier, LENGTH].map(u16::to_le_bytes);
            [header.as_flattened(), entity.as_slice(), &sequence_number(number)].concat()
        });
        [named.concat().as_slice(), &SENTINEL].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fragments_contain_the_whole_response_and_identify_its_request() {
        let bytes: Vec<u8> = (0..2500_u32).map(|i| i.to_le_bytes()[0]).collect();
        let response = LongResponse { writer: [7; 16], number: 5, request: ([9; 16], 3), bytes: &bytes };
        let fragments: Vec<Vec<u8>> = response.fragments([9; 16]).collect();
        assert_eq!(fragments.len(), 3);
        let request_identity = [[9; 16].as_slice(), &[0, 0, 0, 0, 3, 0, 0, 0]].concat();
        let mut carried = Vec::new();
        for (index, fragment) in (1..).zip(&fragments) {
            assert!(fragment.len() < 1200);
            let submessage = &fragment[36..];
            assert_eq!(submessage[..2], [0x16, 3]);
            assert_eq!(usize::from(u16::from_le_bytes([submessage[2], submessage[3]])), submessage.len() - 4);
            // extra flags, bytes to the parameters; reader, writer; sequence number
            assert_eq!(submessage[4..16], [0, 0, 28, 0, 9, 9, 9, 9, 7, 7, 7, 7]);
            assert_eq!(submessage[16..24], [0, 0, 0, 0, 5, 0, 0, 0]);
            // number of the fragment, number of fragments in the message, their length; total length
            assert_eq!(submessage[24..36], [index, 0, 0, 0, 1, 0, 0, 4, 0xc4, 9, 0, 0]);
            assert_eq!(submessage[36..40], [0x83, 0, 24, 0]);
            assert_eq!(submessage[40..64], request_identity);
            assert_eq!(submessage[64..68], [0x0f, 0x80, 24, 0]);
            assert_eq!(submessage[68..92], request_identity);
            assert_eq!(submessage[92..96], [1, 0, 0, 0]);
            carried.extend_from_slice(&submessage[96..]);
        }
        assert_eq!(carried, bytes);
    }
}
