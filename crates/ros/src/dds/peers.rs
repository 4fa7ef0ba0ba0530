//! Discovery of other nodes, and detection of endpoints that can never exchange messages with this node.

use std::collections::{HashMap, HashSet};
use std::net::SocketAddr;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use futures_lite::{StreamExt, future};
use rustdds::{DomainParticipant, DomainParticipantStatusEvent, GUID, QosPolicies, StatusEvented};
use smol::Timer;

use crate::dds::first_request::FirstRequests;
use crate::dds::lock::lock;
use crate::dds::rtps::RtpsSocket;
use crate::dds::wakeup;
use crate::environment::Reach;
use crate::names::FullName;
use crate::threading::thread_priority::ThreadPriority;

/// Largest number of logged mismatches, so that a hostile network cannot use up the memory.
const MOST_WARNINGS: usize = 1000;

/// Largest number of addresses of a reader that messages are sent to. Otherwise a participant that announces thousands
/// could make this node flood other machines.
const MOST_ADDRESSES: usize = 16;

/// Largest number of characters of a type name that are logged.
const MOST_CHARACTERS: usize = 200;

/// Endpoints of this node, to be compared with the endpoints of other nodes.
pub struct Peers {
    /// The full name of the node.
    node: String,
    endpoints: Mutex<HashMap<GUID, Endpoint>>,
    /// DDS topics that this node reads reliably.
    reliably_read: Mutex<HashSet<String>>,
    /// Readers of other nodes that are matched with a writer of this node.
    matched_readers: Mutex<HashMap<GUID, MatchedReader>>,
    first_requests: Mutex<FirstRequests>,
    /// By writer of another node: the readers of this node whose quality of service it does not offer.
    incompatible_readers: Mutex<HashMap<GUID, HashSet<GUID>>>,
    socket: Option<RtpsSocket>,
}

/// Reader of another node that is matched with a writer of this node.
#[derive(Clone)]
pub struct MatchedReader {
    pub reader: GUID,
    pub writer: GUID,
    pub addresses: Vec<SocketAddr>,
    /// The DDS topic.
    topic: String,
}

impl MatchedReader {
    /// Whether this reader receives the responses for a client. The requests of Fast DDS name this reader; those of
    /// others name a writer of the same participant.
    pub fn is_of(&self, client: GUID) -> bool {
        if is_reader(client) { self.reader == client } else { self.reader.prefix == client.prefix }
    }

    pub fn is_on_loopback(&self) -> bool {
        !self.addresses.is_empty() && self.addresses.iter().all(|address| address.ip().is_loopback())
    }
}

/// Endpoint of this node.
struct Endpoint {
    name: String,
    dds_type: String,
    /// Quality of service that a subscription requests; `None` for a publisher.
    requested: Option<QosPolicies>,
}

impl Peers {
    pub fn new(reach: Reach, namespace: &str, node: &str) -> Self {
        Self {
            node: format!("{}/{node}", namespace.trim_end_matches('/')),
            endpoints: Mutex::default(),
            reliably_read: Mutex::default(),
            matched_readers: Mutex::default(),
            first_requests: Mutex::default(),
            incompatible_readers: Mutex::default(),
            socket: RtpsSocket::open(reach),
        }
    }

    /// Registers a publisher or subscription of this node, with the quality of service that a subscription requests.
    pub fn note(&self, guid: GUID, name: &FullName, dds_type: &str, requested: Option<QosPolicies>) {
        let endpoint = Endpoint { name: name.to_string(), dds_type: dds_type.to_owned(), requested };
        lock(&self.endpoints).insert(guid, endpoint);
    }

    /// Why no subscription of this node to a topic can receive from a publisher of this type and quality of service;
    /// `None` if one can, or if there is no subscription.
    pub fn why_unreceivable(&self, topic: &str, dds_type: &str, offered: &QosPolicies) -> Option<String> {
        let endpoints = lock(&self.endpoints);
        let subscriptions = || endpoints.values().filter(move |endpoint| endpoint.name == topic);
        let requested = || subscriptions().filter_map(|endpoint| endpoint.requested.as_ref());
        let of_another_type =
            |endpoint: &&Endpoint| endpoint.requested.is_some() && endpoint.dds_type != dds_type;
        if let Some(ours) = subscriptions().find(of_another_type) {
            return Some(other_type(topic, dds_type, &ours.dds_type));
        }
        if requested().any(|requested| offered.compliance_failure_wrt(requested).is_none()) {
            return None;
        }
        // any of the subscriptions, but always the same
        let requested = requested().map(in_words).max()?;
        Some(incompatible_publisher(topic, &in_words(offered), &requested))
    }

    /// Registers a DDS topic that this node reads reliably.
    pub fn note_reliably_read(&self, dds_topic: String) {
        lock(&self.reliably_read).insert(dds_topic);
    }

    /// Waits until the client's reader of responses is known. This may happen later than its first request; responses
    /// sent before are lost.
    pub async fn await_reader(&self, client: GUID, service: &FullName) {
        const PERIOD: Duration = Duration::from_millis(2);
        const PERIODS: usize = 500;
        // a writer that identifies the client does not identify its reader
        if !is_reader(client) {
            return;
        }
        for _ in 0..PERIODS {
            if lock(&self.matched_readers).contains_key(&client) {
                return;
            }
            Timer::after(PERIOD).await;
        }
        log::warn!("the response reader of a client of {service} is not discovered");
    }

    /// Readers of a DDS topic of this node.
    pub fn matched_readers(&self, topic: &str) -> Vec<MatchedReader> {
        lock(&self.matched_readers).values().filter(|matched| matched.topic == topic).cloned().collect()
    }

    /// Whether any of these readers can be reached beside the DDS library.
    pub fn reaches(&self, matched_readers: &[&MatchedReader]) -> bool {
        self.socket.is_some() && matched_readers.iter().any(|matched| !matched.addresses.is_empty())
    }

    /// Sends a message beside the DDS library, without retransmission.
    pub fn send(&self, message: &[u8], addresses: &[SocketAddr]) {
        if let Some(socket) = &self.socket {
            socket.send(message, addresses);
        }
    }

    /// Handles discovery events. Never returns.
    pub async fn watch(&self, participant: &DomainParticipant, priority: ThreadPriority) {
        let listener = participant.status_listener();
        let mut events = listener.as_async_status_stream();
        let mut logged = HashSet::new();
        while let Some(event) = self.next_event(wakeup::wait(priority, events.next())).await {
            self.note_event(participant, &event);
            self.send_first_requests();
            // DDS itself reports neither of the two
            if let Some(warning) = self.mismatch(&event).or_else(|| self.namesake(&event))
                && logged.len() < MOST_WARNINGS
                && logged.insert(warning.clone())
            {
                log::warn!("{warning}");
            }
        }
    }

    /// Waits for an event, and sends scheduled requests meanwhile.
    async fn next_event<Event>(&self, event: impl Future<Output = Option<Event>>) -> Option<Event> {
        let send_scheduled = async {
            loop {
                // the lock is released at the end of this statement
                let due = lock(&self.first_requests).next_due();
                match due {
                    Some(due) => drop(Timer::at(due).await),
                    None => future::pending().await,
                }
                self.send_first_requests();
            }
        };
        future::or(event, send_scheduled).await
    }

    fn send_first_requests(&self) {
        let due = lock(&self.first_requests).take_due(Instant::now());
        for (request, addresses) in due {
            self.send(&request, &addresses);
        }
    }

    fn note_event(&self, participant: &DomainParticipant, event: &DomainParticipantStatusEvent) {
        match *event {
            DomainParticipantStatusEvent::RemoteReaderMatched { local_writer, remote_reader } => {
                self.note_matched_reader(participant, local_writer, remote_reader);
            }
            DomainParticipantStatusEvent::ReaderLost { guid, .. } => {
                lock(&self.matched_readers).remove(&guid);
            }
            DomainParticipantStatusEvent::WriterLost { guid, .. } => {
                lock(&self.first_requests).lost(guid);
                lock(&self.incompatible_readers).remove(&guid);
            }
            // the library reports no separate event for the endpoints of a lost participant
            DomainParticipantStatusEvent::ParticipantLost { id, .. } => {
                lock(&self.matched_readers).retain(|reader, _| reader.prefix != id);
                lock(&self.incompatible_readers).retain(|writer, _| writer.prefix != id);
            }
            DomainParticipantStatusEvent::RemoteWriterMatched { local_reader, remote_writer } => {
                self.schedule_first_requests(participant, local_reader, remote_writer);
            }
            _ => {}
        }
    }

    fn note_matched_reader(&self, participant: &DomainParticipant, writer: GUID, reader: GUID) {
        let known = participant.discovered_readers();
        let peer = known.iter().find(|r| r.reader_proxy.remote_reader_guid == reader);
        let matched = MatchedReader {
            reader,
            writer,
            addresses: peer.map(|r| addresses(&r.reader_proxy.unicast_locator_list)).unwrap_or_default(),
            topic: peer.map(|r| r.subscription_topic_data.topic_name().clone()).unwrap_or_default(),
        };
        lock(&self.matched_readers).insert(reader, matched);
    }

    fn schedule_first_requests(&self, participant: &DomainParticipant, reader: GUID, writer: GUID) {
        let known = participant.discovered_writers();
        let Some(peer) = known.iter().find(|w| w.writer_proxy.remote_writer_guid == writer) else {
            return;
        };
        if lock(&self.reliably_read).contains(&peer.publication_topic_data.topic_name) {
            let addresses = addresses(&peer.writer_proxy.unicast_locator_list);
            lock(&self.first_requests).matched(reader, writer, addresses, Instant::now());
        }
    }

    /// Warning about another node with the same name: it publishes on a private topic on which this node publishes. On a
    /// topic that this node subscribes to, anybody may publish.
    fn namesake(&self, event: &DomainParticipantStatusEvent) -> Option<String> {
        let DomainParticipantStatusEvent::WriterDetected { writer } = event else { return None };
        let name = writer.topic_name.strip_prefix("rt")?;
        name.strip_prefix(&self.node)?.strip_prefix('/')?;
        let endpoints = lock(&self.endpoints);
        let is_ours =
            |guid: &GUID, endpoint: &Endpoint| endpoint.name == name && guid.entity_id.kind().is_writer();
        let mut ours =
            endpoints.iter().filter(|(guid, endpoint)| is_ours(guid, endpoint)).map(|(guid, _)| guid);
        let another = ours.next().is_some_and(|guid| guid.prefix != writer.guid.prefix);
        another.then(|| {
            format!(
                "another node is named {} too: both publish on the same topics and answer the same requests; give one of them another \
                 namespace (--ros-args -r __ns:=/NAME) or name (-r __node:=NAME)",
                self.node
            )
        })
    }

    /// Stores that `writer` is incompatible with `reader`. Returns whether all readers of the topic are: the node reads
    /// some topics with several qualities of service.
    fn note_incompatible(&self, endpoints: &HashMap<GUID, Endpoint>, reader: GUID, writer: GUID) -> bool {
        let Some(Endpoint { name, .. }) = endpoints.get(&reader) else { return true };
        let mut incompatible_readers = lock(&self.incompatible_readers);
        if incompatible_readers.len() >= MOST_WARNINGS && !incompatible_readers.contains_key(&writer) {
            return true;
        }
        let incompatible = incompatible_readers.entry(writer).or_default();
        incompatible.insert(reader);
        let mut readers =
            endpoints.iter().filter(|(guid, endpoint)| is_reader(**guid) && endpoint.name == *name);
        readers.all(|(guid, _)| incompatible.contains(guid))
    }

    fn mismatch(&self, event: &DomainParticipantStatusEvent) -> Option<String> {
        let endpoints = lock(&self.endpoints);
        let name = |guid: &GUID| endpoints.get(guid).map(|e| e.name.clone());
        match event {
            DomainParticipantStatusEvent::RemoteReaderQosIncompatible {
                local_writer,
                requested_qos,
                offered_qos,
                ..
            } => Some(format!(
                "a subscription of {} is incompatible with this node: it requests {}, but {} is offered",
                name(local_writer)?,
                in_words(requested_qos),
                in_words(offered_qos),
            )),
            DomainParticipantStatusEvent::RemoteWriterQosIncompatible {
                local_reader,
                remote_writer,
                requested_qos,
                offered_qos,
            } => {
                let name = name(local_reader)?;
                self.note_incompatible(&endpoints, *local_reader, *remote_writer)
                    .then(|| incompatible_publisher(&name, &in_words(offered_qos), &in_words(requested_qos)))
            }
            DomainParticipantStatusEvent::ReaderDetected { reader: peer }
            | DomainParticipantStatusEvent::WriterDetected { writer: peer } => {
                let name = peer.topic_name.strip_prefix("rt")?;
                let ours = endpoints.values().find(|e| e.name == name)?;
                (ours.dds_type != peer.type_name).then(|| other_type(name, &peer.type_name, &ours.dds_type))
            }
            _ => None,
        }
    }
}

fn incompatible_publisher(name: &str, offered: &str, requested: &str) -> String {
    format!(
        "a publisher of {name} is incompatible with this node: it offers {offered}, but this node requests \
         {requested}"
    )
}

fn other_type(name: &str, elsewhere: &str, here: &str) -> String {
    // the network gives it, in whatever length
    let elsewhere: String = elsewhere.escape_debug().take(MOST_CHARACTERS).collect();
    format!("{name} has the type {elsewhere} elsewhere, but {here} here: they cannot exchange messages")
}

/// Unicast IPv4 addresses at which an endpoint receives, at most `MOST_ADDRESSES`. Its locators also include shared
/// memory and other transports.
fn addresses<L: Copy + Into<SocketAddr>>(locators: &[L]) -> Vec<SocketAddr> {
    (locators.iter())
        .map(|locator| (*locator).into())
        .filter(|address: &SocketAddr| {
            let ip = address.ip();
            ip.is_ipv4() && !ip.is_unspecified() && !ip.is_multicast()
        })
        .take(MOST_ADDRESSES)
        .collect()
}

/// Whether an entity is a reader, by the last byte of its identifier (RTPS 9.3.1.2).
fn is_reader(entity: GUID) -> bool {
    matches!(entity.to_bytes()[15] & 0x3f, 0x04 | 0x07)
}

fn in_words(qos: &QosPolicies) -> String {
    use rustdds::policy::{Durability, Liveliness, Reliability};
    let reliability = match qos.reliability() {
        Some(Reliability::Reliable { .. }) => "reliable",
        Some(Reliability::BestEffort) | None => "best effort",
    };
    let durability = match qos.durability() {
        Some(Durability::Volatile) | None => "volatile",
        Some(_) => "transient local",
    };
    let limit = |what: &str, duration: rustdds::Duration| {
        #[expect(clippy::cast_precision_loss, reason = "milliseconds are logged")]
        let seconds = duration.to_nanoseconds() as f64 * 1e-9;
        let is_finite = duration != rustdds::Duration::INFINITE;
        if is_finite { format!(", a {what} of {seconds:.3} s") } else { String::new() }
    };
    let deadline = qos.deadline().map(|deadline| limit("deadline", deadline.0)).unwrap_or_default();
    let liveliness = match qos.liveliness() {
        None => String::new(),
        Some(Liveliness::Automatic { lease_duration }) => limit("lease", lease_duration),
        Some(Liveliness::ManualByParticipant { .. } | Liveliness::ManualByTopic { .. }) => {
            ", liveliness that is asserted by hand".to_owned()
        }
    };
    format!("{reliability}, {durability}{deadline}{liveliness}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entity(participant: u8, kind: u8) -> GUID {
        let mut bytes = [participant; 16];
        bytes[15] = kind;
        GUID::from_bytes(bytes)
    }

    #[test]
    fn incompatible_qualities_are_described() {
        use rustdds::QosPolicyBuilder;
        use rustdds::policy::{Deadline, Liveliness};
        let plain = QosPolicyBuilder::new().build();
        assert_eq!(in_words(&plain), "best effort, volatile");
        let deadline = Deadline(rustdds::Duration::from_millis(100));
        let timely = QosPolicyBuilder::new().deadline(deadline).build();
        assert!(in_words(&timely).ends_with(", a deadline of 0.100 s"), "{}", in_words(&timely));
        let lease_duration = rustdds::Duration::from_secs(2);
        let alive = QosPolicyBuilder::new().liveliness(Liveliness::Automatic { lease_duration }).build();
        assert!(in_words(&alive).ends_with(", a lease of 2.000 s"), "{}", in_words(&alive));
        let asserted =
            QosPolicyBuilder::new().liveliness(Liveliness::ManualByTopic { lease_duration }).build();
        assert!(in_words(&asserted).ends_with("asserted by hand"));
    }

    #[test]
    fn a_publisher_is_incompatible_if_no_reader_of_its_topic_can_receive_from_it() {
        const READER: u8 = 0x04;
        const WRITER: u8 = 0x03;
        let peers = Peers::new(Reach::Localhost, "/", "node");
        let of = |name: &str| Endpoint { name: name.to_owned(), dds_type: String::new(), requested: None };
        let endpoints = HashMap::from([
            (entity(1, READER), of("/octomap_binary")),
            (entity(2, READER), of("/octomap_binary")),
            (entity(3, READER), of("/joint_states")),
            (entity(3, WRITER), of("/octomap_binary")),
        ]);
        let is_unreadable = |reader, writer| {
            peers.note_incompatible(&endpoints, entity(reader, READER), entity(writer, WRITER))
        };
        assert!(!is_unreadable(1, 8) && !is_unreadable(1, 9));
        assert!(is_unreadable(2, 8) && is_unreadable(3, 8));
    }

    #[test]
    fn publishers_that_no_subscription_receives_from_are_named() {
        use rustdds::QosPolicyBuilder;
        use rustdds::policy::{Durability, Reliability};
        const READER: u8 = 0x04;
        let reliable = Reliability::Reliable { max_blocking_time: rustdds::Duration::ZERO };
        let qos = |reliability, durability| {
            QosPolicyBuilder::new().reliability(reliability).durability(durability).build()
        };
        let of = |name: &str, requested| Endpoint {
            name: name.to_owned(),
            dds_type: "Octomap".to_owned(),
            requested,
        };
        let (volatile, latched) = (Durability::Volatile, Durability::TransientLocal);
        let peers = Peers::new(Reach::Localhost, "/", "node");
        lock(&peers.endpoints).extend([
            (entity(1, READER), of("/octomap_binary", Some(qos(reliable, volatile)))),
            (entity(2, READER), of("/octomap_binary", Some(qos(reliable, latched)))),
            (entity(3, READER), of("/map", Some(qos(reliable, latched)))),
            (entity(4, 0x03), of("/state", None)),
        ]);
        let why =
            |topic: &str, kind: &str, offered: &QosPolicies| peers.why_unreceivable(topic, kind, offered);
        assert_eq!(why("/octomap_binary", "Octomap", &qos(reliable, volatile)), None);
        assert_eq!(why("/octomap_binary", "Octomap", &qos(reliable, latched)), None);
        assert_eq!(why("/state", "Float64", &qos(reliable, latched)), None, "this node publishes it");
        assert_eq!(why("/nothing", "Octomap", &qos(reliable, volatile)), None);
        let text = why("/map", "Octomap", &qos(reliable, volatile)).unwrap();
        assert!(
            text.contains("/map is incompatible") && text.contains("offers reliable, volatile"),
            "{text}"
        );
        let best_effort = qos(Reliability::BestEffort, latched);
        let text = why("/octomap_binary", "Octomap", &best_effort).unwrap();
        assert!(text.ends_with("this node requests reliable, volatile"), "{text}");
        let text = why("/octomap_binary", "Float64", &qos(reliable, latched)).unwrap();
        assert!(text.contains("has the type Float64 elsewhere, but Octomap here"), "{text}");
    }

    #[test]
    fn a_client_receives_by_its_own_reader_or_one_of_its_participant() {
        const READER: u8 = 0x04;
        const WRITER: u8 = 0x03;
        let addresses = vec![SocketAddr::from(([127, 0, 0, 1], 7411))];
        let (reader, writer) = (entity(5, READER), entity(1, WRITER));
        let matched = MatchedReader { reader, writer, addresses, topic: String::new() };
        assert!(matched.is_of(reader) && matched.is_of(entity(5, WRITER)));
        assert!(!matched.is_of(entity(6, READER)) && !matched.is_of(entity(6, WRITER)));
        assert!(matched.is_on_loopback());
        let across = SocketAddr::from(([192, 0, 2, 1], 7411));
        assert!(!MatchedReader { addresses: vec![across], ..matched.clone() }.is_on_loopback());
        assert!(!MatchedReader { addresses: Vec::new(), ..matched }.is_on_loopback());
    }
}
