//! RTPS messages (OMG DDSI-RTPS 2.5) with identifiers of the DDS library, and the UDP socket that sends them.

use std::net::{Ipv4Addr, SocketAddr, UdpSocket};

use crate::environment::Reach;

/// GUID of a reader or writer: twelve bytes of its participant, of which two are the vendor's, and four of its own.
pub type Entity = [u8; 16];

/// Socket that sends RTPS messages.
pub struct RtpsSocket(UdpSocket);

impl RtpsSocket {
    /// Opens the socket; `None` when that fails.
    pub fn open(reach: Reach) -> Option<Self> {
        let address = match reach {
            // from this address nothing can be sent to another machine
            Reach::Localhost => Ipv4Addr::LOCALHOST,
            Reach::Subnet => Ipv4Addr::UNSPECIFIED,
        };
        match UdpSocket::bind((address, 0)) {
            Ok(socket) => Some(Self(socket)),
            Err(error) => {
                log::warn!("first calls of services will take seconds, and long responses are lost: {error}");
                None
            }
        }
    }

    pub fn send(&self, message: &[u8], addresses: &[SocketAddr]) {
        for address in addresses {
            // some of a peer's addresses may be unreachable
            if let Err(error) = self.0.send_to(message, address) {
                log::debug!("{address}: {error}");
            }
        }
    }
}

/// Kind of a submessage, with its flags.
#[derive(Clone, Copy, Debug)]
pub struct SubmessageKind {
    pub id: u8,
    pub flags: u8,
}

/// One submessage from one participant to another, all of it in little-endian order: header, `INFO_DST`, submessage.
///
/// # Panics
///
/// When the submessage does not fit into a datagram.
pub fn message(from: &Entity, to: &Entity, kind: SubmessageKind, body: &[u8]) -> Vec<u8> {
    const LITTLE_END_FIRST: u8 = 1;
    let length = u16::try_from(body.len()).expect("a submessage is shorter than a datagram");
    [
        b"RTPS".as_slice(),
        &[2, 4],
        &from[..2],
        &from[..12],
        &[0x0e, LITTLE_END_FIRST, 12, 0],
        &to[..12],
        &[kind.id, kind.flags | LITTLE_END_FIRST],
        &length.to_le_bytes(),
        body,
    ]
    .concat()
}

/// A sequence number as the protocol encodes it: the upper half first.
pub fn sequence_number(number: i64) -> [u8; 8] {
    let mut bytes = number.to_le_bytes();
    bytes.rotate_left(4);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_contains_sender_and_receiver() {
        let sent = message(&[7; 16], &[9; 16], SubmessageKind { id: 0x06, flags: 2 }, &[5; 300]);
        let (header, rest) = sent.split_at(20);
        assert_eq!(header, [b"RTPS\x02\x04\x07\x07".as_slice(), &[7; 12]].concat());
        let (destination, submessage) = rest.split_at(16);
        assert_eq!(destination, [[0x0e, 1, 12, 0].as_slice(), &[9; 12]].concat());
        assert_eq!(submessage, [[0x06, 3, 0x2c, 1].as_slice(), &[5; 300]].concat());
    }

    #[test]
    fn the_upper_half_of_a_number_comes_first() {
        assert_eq!(sequence_number(0x0102_0304_0506_0708), [4, 3, 2, 1, 8, 7, 6, 5]);
    }
}
