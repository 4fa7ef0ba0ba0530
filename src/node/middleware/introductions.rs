//! Has the endpoints of Fast DDS participants asked for as soon as they are met.
//!
//! Fast DDS tells a participant that it meets how many endpoints there are to ask for (a HEARTBEAT of each of discovery's writers) within
//! the millisecond in which `RustDDS` hears of that participant for the first time and knows no such writers yet. The next one comes a
//! second later: so late a node would hear its joint states, and others its answers. So `RustDDS` is told from here that there is one
//! endpoint, that there are two, and so on; it asks for each number, and Fast DDS passes over questions about more than there are.
//! What is told is as old as can be: whatever the participant itself said before counts for more.

use std::net::{Ipv4Addr, SocketAddr};

use super::rtps::{Entity, message_of, sequence_number};

/// The vendor that needs it, as its participants' identifiers begin: eProsima.
const FAST_DDS: [u8; 2] = [0x01, 0x0f];

const HEARTBEAT: (u8, u8) = (0x07, 0);

/// Of each reader of discovery, and its writer, the last four bytes: publications and subscriptions (DDSI-RTPS 2.5, table 9.2).
const DISCOVERY: [([u8; 4], [u8; 4]); 2] =
    [([0, 0, 3, 0xc7], [0, 0, 3, 0xc2]), ([0, 0, 4, 0xc7], [0, 0, 4, 0xc2])];

/// Participants of one machine of which each could be this one.
const PARTICIPANTS: u16 = 32;

/// Endpoints of a kind that are asked for at once: what tells of more would not fit into a datagram of Ethernet.
const ENDPOINTS: i32 = 40;

/// What tells our participant `own` that `peer` has endpoints, if it is a Fast DDS one.
pub fn reminders(own: &Entity, peer: &Entity) -> Vec<Vec<u8>> {
    if peer[..2] != FAST_DDS {
        return Vec::new();
    }
    let reminder = |(reader, writer): ([u8; 4], [u8; 4])| {
        let of = |last: i32| {
            let range = [1, last].map(|number| sequence_number(number.into())).concat();
            // the number of the heartbeat, which has to grow
            [reader.as_slice(), &writer, &range, &last.to_le_bytes()].concat()
        };
        message_of(peer, own, HEARTBEAT, (1..=ENDPOINTS).map(of))
    };
    DISCOVERY.map(reminder).into()
}

/// Where participants of a domain on this machine hear discovery (DDSI-RTPS 2.5, 9.6.2.4): which of these ports is ours, the library keeps
/// to itself.
pub fn addresses(domain: u16) -> Vec<SocketAddr> {
    // a domain that has no ports has no participants
    let port = |number: u16| 7410_u16.checked_add(domain.checked_mul(250)?)?.checked_add(2 * number);
    (0..PARTICIPANTS).filter_map(port).map(|port| SocketAddr::from((Ipv4Addr::LOCALHOST, port))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reminder_has_a_heartbeat_for_each_number_of_endpoints() {
        let mut peer = [9; 16];
        assert!(reminders(&[7; 16], &peer).is_empty());
        peer[..2].copy_from_slice(&FAST_DDS);
        let told = reminders(&[7; 16], &peer);
        assert_eq!(told.len(), 2);
        assert_eq!(told[0][6..20], [[0x01, 0x0f].as_slice(), &peer[..12]].concat());
        let heartbeats: Vec<_> = told[0][36..].chunks(32).collect();
        assert_eq!(heartbeats.len(), 40);
        for (heartbeat, last) in heartbeats.into_iter().zip(1_u8..) {
            assert_eq!(heartbeat[..4], [0x07, 1, 28, 0]);
            assert_eq!(heartbeat[4..12], [0, 0, 3, 0xc7, 0, 0, 3, 0xc2]);
            let range = [[0, 0, 0, 0, 1, 0, 0, 0], [0, 0, 0, 0, last, 0, 0, 0]].concat();
            assert_eq!(heartbeat[12..], [range.as_slice(), &[last, 0, 0, 0]].concat());
        }
        assert!(told.iter().all(|message| message.len() < 1400));
    }

    #[test]
    fn nothing_leaves_the_machine() {
        let ports = addresses(9);
        assert!(ports.iter().all(|address| address.ip().is_loopback()));
        assert_eq!((ports[0].port(), ports.len()), (9660, usize::from(PARTICIPANTS)));
        // a domain without ports
        assert!(addresses(300).is_empty());
    }
}
