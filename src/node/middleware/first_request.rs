//! Asks Fast DDS writers at once for what they sent before they were known here.
//!
//! A reliable reader that meets a writer asks it for what it has. `RustDDS` asks with an ACKNACK of base 1 and count 0;
//! Fast DDS heeds neither, and comes with its next heartbeat, up to 3 s later. A client calls a service as soon as it
//! sees it, some 10 ms before `RustDDS` has met it, so that the first call of every client would take these 3 s (20 of 20
//! measured); a best-effort reader loses such calls altogether (19 of 20). A question of our own, sent beside the
//! library's, brings the answer in milliseconds.

use std::net::{Ipv4Addr, SocketAddr, UdpSocket};

use rustdds::GUID;

use crate::node::environment::Reach;

/// The vendor that needs it, as its participants' identifiers begin: eProsima.
const FAST_DDS: [u8; 2] = [0x01, 0x0f];
/// `RustDDS`, in whose name this is sent.
const RUST_DDS: [u8; 2] = [0x01, 0x12];

/// Sends the question.
pub struct FirstRequest {
    socket: UdpSocket,
}

impl FirstRequest {
    /// `None` when there is no socket for it; then the first calls take longer.
    pub fn new(reach: Reach) -> Option<Self> {
        let address = match reach {
            // from here nothing can be sent to another machine
            Reach::Localhost => Ipv4Addr::LOCALHOST,
            Reach::Subnet => Ipv4Addr::UNSPECIFIED,
        };
        match UdpSocket::bind((address, 0)) {
            Ok(socket) => Some(Self { socket }),
            Err(error) => {
                log::warn!("the first calls of services will take seconds: {error}");
                None
            }
        }
    }

    /// Asks `writer`, if it is a Fast DDS one, on behalf of our `reader`.
    pub fn send(&self, reader: GUID, writer: GUID, addresses: impl Iterator<Item = SocketAddr>) {
        let (reader, writer) = (reader.to_bytes(), writer.to_bytes());
        if writer[..2] != FAST_DDS {
            return;
        }
        let message = ask_for_first_sample(&reader, &writer);
        for address in addresses {
            // what does not arrive is asked for by the library's own means later
            if let Err(error) = self.socket.send_to(&message, address) {
                log::debug!("{address}: {error}");
            }
        }
    }
}

/// An RTPS message: header, `INFO_DST`, and an ACKNACK that asks for sample 1 and wants an answer (no final flag).
///
/// A new client's first request is sample 1. Fast DDS heeds only counts that grow, so it passes over `RustDDS`'s own next
/// ACKNACK, which has this count too; that costs nothing unless a packet is lost just then.
fn ask_for_first_sample(reader: &[u8; 16], writer: &[u8; 16]) -> Vec<u8> {
    let (reader_prefix, reader_id) = reader.split_at(12);
    let (writer_prefix, writer_id) = writer.split_at(12);
    // sequence number 1 as two words, then a set of one bit, which is the first of its word; then the count
    let numbers: [u32; 5] = [0, 1, 1, 1 << 31, 1];
    [
        b"RTPS".as_slice(),
        &[2, 4],
        &RUST_DDS,
        reader_prefix,
        // INFO_DST, little-endian, 12 bytes long
        &[0x0e, 1, 12, 0],
        writer_prefix,
        // ACKNACK, little-endian, 28 bytes long
        &[0x06, 1, 28, 0],
        reader_id,
        writer_id,
        numbers.map(u32::to_le_bytes).as_flattened(),
    ]
    .concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_is_rtps() {
        let message = ask_for_first_sample(&[7; 16], &[9; 16]);
        let (header, rest) = message.split_at(20);
        assert_eq!(header, [b"RTPS\x02\x04\x01\x12".as_slice(), &[7; 12]].concat());
        let (destination, acknack) = rest.split_at(16);
        assert_eq!(destination, [[0x0e, 1, 12, 0].as_slice(), &[9; 12]].concat());
        assert_eq!(acknack[..4], [0x06, 1, 28, 0]);
        assert_eq!(acknack.len(), 4 + 28);
        assert_eq!(acknack[4..12], [7, 7, 7, 7, 9, 9, 9, 9]);
        assert_eq!(acknack[12..24], [0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
        assert_eq!(acknack[24..], [0, 0, 0, 0x80, 1, 0, 0, 0]);
    }
}
