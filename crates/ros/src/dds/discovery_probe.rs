//! Discovery probe: learns local Fast DDS participants early, so that `RustDDS` does not miss their first heartbeats.
//!
//! When Fast DDS discovers a participant, it sends at once how many endpoints there are to request (a HEARTBEAT of each
//! discovery writer), and repeats it a second later. `RustDDS` discards these messages in the first millisecond after
//! the discovery. A node, which always starts last, would then receive its joint states a second late, and its clients
//! would receive their responses a second late. Therefore a discovery probe is sent first: a participant without
//! endpoints, of which only the announcement exists. Each participant that discovers the probe announces itself to it.
//! The probe forwards these announcements to `RustDDS`, whose own announcement follows. The probe is never announced
//! again, so others remove it after its lease.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::thread;
use std::time::{Duration, Instant};

use crate::dds::rtps::{Entity, SubmessageKind, message, sequence_number};

/// Vendor identifier of eProsima, with which the identifiers of Fast DDS participants begin.
const FAST_DDS: [u8; 2] = [0x01, 0x0f];

/// Number of participants of one machine that the probe looks for. The forwarded announcements go to the ports of all
/// of them, since any may be that of our own participant.
const PARTICIPANTS: u16 = 16;

/// How long the probe waits for announcements. `RustDDS` receives the announcement of the probe too, and announces
/// itself some 10 ms later. A participant that responds to the probe after that is discovered a second late.
const PATIENCE: Duration = Duration::from_millis(60);

/// Largest announcement that is read (bytes); real ones are far shorter.
const LONGEST: usize = 4096;

/// Entities of discovery, by the last four bytes of their identifiers (DDSI-RTPS 2.5, table 9.2).
const ANY_READER: [u8; 4] = [0; 4];
const PARTICIPANT: [u8; 4] = [0, 0, 1, 0xc1];
const ANNOUNCER: [u8; 4] = [0, 1, 0, 0xc2];

/// Sends a discovery probe for `own`, a participant of that domain that was made just now. Does not wait for the probe
/// to end.
pub fn start_probe(own: Entity, domain: u16) {
    let run_probe = move || {
        if let Err(error) = run_probe(&own, &discovery_addresses(domain), PATIENCE) {
            log::debug!("participants are discovered a second later: {error}");
        }
    };
    // without a thread for the probe, local participants are discovered a second later
    let _ = thread::Builder::new().name("discovery_probe".to_owned()).spawn(run_probe);
}

fn run_probe(own: &Entity, addresses: &[SocketAddr], timeout: Duration) -> io::Result<()> {
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
    let announcement = announcement(&probe_id(own), socket.local_addr()?.port());
    let send = |message: &[u8]| addresses.iter().try_for_each(|to| socket.send_to(message, to).map(|_| ()));
    send(&announcement)?;
    let end = Instant::now() + timeout;
    let mut buffer = [0; LONGEST];
    loop {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Ok(());
        }
        socket.set_read_timeout(Some(left))?;
        match socket.recv(&mut buffer) {
            Ok(length) if is_announcement(&buffer[..length]) => send(&buffer[..length])?,
            Ok(_) => {}
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {}
            Err(error) => return Err(error),
        }
    }
}

/// Addresses at which participants of a domain on this machine receive discovery messages (DDSI-RTPS 2.5, 9.6.2.4). The
/// library does not publish which of these ports is its own.
fn discovery_addresses(domain: u16) -> Vec<SocketAddr> {
    // a domain that has no ports has no participants
    let port = |number: u16| 7410_u16.checked_add(domain.checked_mul(250)?)?.checked_add(2 * number);
    (0..PARTICIPANTS).filter_map(port).map(|port| SocketAddr::from((Ipv4Addr::LOCALHOST, port))).collect()
}

/// Identifier of the probe, which differs from those of all `RustDDS` participants: these begin with its vendor and are
/// random.
fn probe_id(own: &Entity) -> Entity {
    let mut discovery_probe = *own;
    for byte in &mut discovery_probe[2..12] {
        *byte = !*byte;
    }
    discovery_probe[12..].copy_from_slice(&PARTICIPANT);
    discovery_probe
}

/// Announcement of the participant `discovery_probe`: it receives discovery messages at this port of this machine, and
/// has no endpoints.
fn announcement(discovery_probe: &Entity, port: u16) -> Vec<u8> {
    const DATA: SubmessageKind = SubmessageKind { id: 0x15, flags: 0x04 };
    /// No extra flags, and no quality of service before the data.
    const BEFORE_DATA: [u8; 4] = [0, 0, 16, 0];
    /// Encapsulation of a parameter list.
    const LITTLE_END_FIRST: [u8; 4] = [0, 3, 0, 0];
    const SENTINEL: [u8; 4] = [1, 0, 0, 0];
    let locator = locator(port);
    let parameters: [(u16, &[u8]); 7] = [
        (0x15, &[2, 4, 0, 0]),                                   // protocol version
        (0x16, &[discovery_probe[0], discovery_probe[1], 0, 0]), // vendor
        (0x50, discovery_probe),                                 // participant
        (0x32, &locator),                                        // locator for discovery messages
        (0x31, &locator),                                        // locator for other messages
        (0x02, &[1, 0, 0, 0, 0, 0, 0, 0]),                       // lease: 1 s
        (0x58, &[3, 0, 0, 0]), // built-in endpoints: it sends and receives participant announcements
    ];
    let parameters = parameters.iter().flat_map(|&(id, value)| {
        // every value is at most as long as a locator
        let length = u8::try_from(value.len()).unwrap_or_default();
        [&id.to_le_bytes(), [length, 0].as_slice(), value].concat()
    });
    let parameters: Vec<u8> = parameters.collect();
    let body = [
        BEFORE_DATA.as_slice(),
        &ANY_READER,
        &ANNOUNCER,
        &sequence_number(1),
        &LITTLE_END_FIRST,
        &parameters,
        &SENTINEL,
    ]
    .concat();
    message(discovery_probe, &[0; 16], DATA, &body)
}

/// Locator of a port of this machine: kind UDP over IPv4, port, address in the last four of sixteen bytes.
fn locator(port: u16) -> [u8; 24] {
    let mut locator = [0; 24];
    locator[0] = 1;
    locator[4..6].copy_from_slice(&port.to_le_bytes());
    locator[20..].copy_from_slice(&Ipv4Addr::LOCALHOST.octets());
    locator
}

/// Whether a message is the announcement of a Fast DDS participant.
fn is_announcement(message: &[u8]) -> bool {
    message.len() > 20
        && message.starts_with(b"RTPS")
        && message[8..10] == FAST_DDS
        && message.windows(4).any(|bytes| bytes == ANNOUNCER)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: Entity = [1, 0x12, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 0, 0, 1, 0xc1];

    #[test]
    fn an_announcement_is_what_discovery_sends() {
        let discovery_probe = probe_id(&OWN);
        assert_eq!(discovery_probe[..3], [1, 0x12, !7]);
        let message = announcement(&discovery_probe, 0x1234);
        assert_eq!(message[..8], *b"RTPS\x02\x04\x01\x12");
        let data = &message[36..];
        assert_eq!(data[..2], [0x15, 0x05]);
        assert_eq!(usize::from(u16::from_le_bytes([data[2], data[3]])), data.len() - 4);
        assert_eq!(data[4..24], [[0, 0, 16, 0], ANY_READER, ANNOUNCER, [0; 4], [1, 0, 0, 0]].concat());
        // each parameter contains its length, up to the sentinel
        let (mut list, mut ids) = (&data[28..], Vec::new());
        while let [id, 0, length, 0, rest @ ..] = list {
            ids.push(*id);
            list = &rest[usize::from(*length)..];
        }
        assert_eq!(ids, [0x15, 0x16, 0x50, 0x32, 0x31, 0x02, 0x58, 0x01]);
        assert!(list.is_empty());
    }

    #[test]
    fn announcements_of_peers_are_forwarded() {
        let [participant, peer] = [(); 2].map(|()| UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap());
        let addresses = [participant.local_addr().unwrap()];
        // the thread is not joined
        thread::spawn(move || run_probe(&OWN, &addresses, Duration::from_secs(600)));
        let mut received = [0; LONGEST];
        participant.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let (length, discovery_probe) = participant.recv_from(&mut received).unwrap();
        assert!(!is_announcement(&received[..length]), "of no Fast DDS participant");
        let announcement = [b"RTPS\x02\x02\x01\x0f\x01\x0f".as_slice(), &[9; 24], &ANNOUNCER].concat();
        peer.send_to(b"noise", discovery_probe).unwrap();
        peer.send_to(&announcement, discovery_probe).unwrap();
        let length = participant.recv(&mut received).unwrap();
        assert_eq!(received[..length], announcement);
    }

    #[test]
    fn a_probe_stays_on_this_machine() {
        let ports = discovery_addresses(9);
        assert!(ports.iter().all(|address| address.ip().is_loopback()));
        assert_eq!((ports[0].port(), ports.len()), (9660, usize::from(PARTICIPANTS)));
        assert!(discovery_addresses(300).is_empty());
    }
}
