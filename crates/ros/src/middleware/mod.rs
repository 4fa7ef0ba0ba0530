//! Wrapper of the ROS 2 client library: participants, topics, services, qualities of service. No other module uses that library.
//!
//! A new release of ros2-client, or another middleware, needs changes only here.

mod action_server;
mod announcement;
mod answering;
mod client;
mod decode_error_log;
mod discovery_probe;
mod first_request;
mod fragments;
mod peers;
mod publisher;
mod receive_thread_watch;
mod rtps;
mod server;
mod subscription;
mod wakeup;

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use log::Level;
use ros2_client::action::ActionServerQosPolicies;
use ros2_client::builtin_interfaces::Time as StampMessage;
use ros2_client::log::Log as LogMessage;
use ros2_client::qos::{Durability, History, Reliability, WhenFull};
use ros2_client::{
    ActionTypeName, Context, MessageTypeName, Name, Node, NodeName, NodeOptions, QosProfile, ServiceMapping,
};
use ros2_client::{RosoutRaw as _, ServiceTypeName};
use rustdds::policy::ResourceLimits;
use rustdds::{QosPolicies, QosPolicyBuilder, RTPSEntity, TopicKind};

pub use self::decode_error_log::DecodeErrorLog;
use self::peers::Peers;
use super::logging::Line;
use super::names::{FullName, NameError};
use super::thread_priority::ThreadPriority;
use clearance_monitor::{SourceId, Time};

pub use self::action_server::{ActionServer, CancelCode, GoalId, GoalInfo, GoalStatus, Standing};
pub use self::announcement::Announcement;
pub use self::client::Client;
pub use self::publisher::Publisher;
pub use self::receive_thread_watch::{deafness, heed, is_deaf};
pub use self::server::{RequestId, Server};
pub use self::subscription::{Origin, Subscription};
pub use ros2_client::Message;
pub use ros2_client::builtin_interfaces::Time as Stamp;

/// An operation that the middleware rejected, with the reason in words.
#[derive(Debug, thiserror::Error)]
#[error("{what}: {why}")]
pub struct MiddlewareError {
    what: String,
    why: String,
}

fn refused<E: std::fmt::Display>(what: impl Into<String>) -> impl FnOnce(E) -> MiddlewareError {
    move |why| MiddlewareError { what: what.into(), why: why.to_string() }
}

impl From<NameError> for MiddlewareError {
    fn from(error: NameError) -> Self {
        Self { what: "a name is wrong".to_owned(), why: error.to_string() }
    }
}

/// Quality of service of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Latest samples; lost samples are not sent again. A subscription of this kind receives from every publisher.
    BestEffort,
    /// Every sample is delivered. A publisher of this kind is compatible with every subscription.
    Reliable,
    /// Transient local: the last sample is kept for subscriptions that come later.
    Latched,
    /// As `Latched`, with a history of many samples: later subscriptions receive all of them.
    Kept,
    /// As `BestEffort`, for samples so large that only few may be held at a time.
    Bulk,
    /// As `Reliable`, for samples so large that only few may be held at a time.
    ReliableBulk,
    /// As `Latched`, for samples so large that only few may be held at a time.
    LatchedBulk,
}

impl Quality {
    /// Samples kept for each topic.
    const DEPTH: usize = 10;
    /// The same for `Kept`.
    const STORY: usize = 100;
    /// Number of large samples held for each topic, instead of the 64 that `RustDDS` holds of any.
    const BULK: i32 = 4;

    fn profile(self) -> QosProfile {
        // a subscriber that has stopped reading must never block the monitor: its samples are dropped instead
        let reliable = Reliability::Reliable { when_full: WhenFull::Fail };
        let base = QosProfile::subscription_default();
        match self {
            Self::BestEffort => base.history(History::KeepLast { depth: Self::DEPTH }),
            Self::Bulk => base.history(History::KeepLast { depth: 1 }),
            Self::ReliableBulk => base.reliability(reliable).history(History::KeepLast { depth: 1 }),
            Self::Kept => (base.reliability(reliable))
                .durability(Durability::TransientLocal)
                .history(History::KeepLast { depth: Self::STORY }),
            Self::Reliable => base.reliability(reliable).history(History::KeepLast { depth: Self::DEPTH }),
            Self::Latched | Self::LatchedBulk => (base.reliability(reliable))
                .durability(Durability::TransientLocal)
                .history(History::KeepLast { depth: 1 }),
        }
    }
}

/// One ROS node on the network.
#[derive(Clone)]
pub struct Middleware {
    node: Arc<Mutex<Node>>,
    context: Context,
    peers: Arc<Peers>,
    /// Priority of the library's threads, and of other threads while they call the library.
    priority: ThreadPriority,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // the guarded values are valid between any two statements
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Middleware {
    /// Joins the network under a node name.
    pub fn join(announcement: Announcement, namespace: &str, node: &str) -> Result<Self, MiddlewareError> {
        let (reach, priority) = (announcement.environment().reach, announcement.priority());
        let participant = announcement.heard();
        let _lent = priority.lend();
        let context =
            Context::from_domain_participant(participant).map_err(refused("cannot join the ROS network"))?;
        let name = NodeName::new(namespace, node)
            .map_err(refused(format!("'{namespace}' and '{node}' make no node name")))?;
        // the library's own parameter services support no descriptions or ranges; see `parameter_services`
        let options = NodeOptions::new().start_parameter_services(false);
        let peers = Arc::new(Peers::new(reach, namespace, node));
        let node = (context.new_node(name, options)).map_err(refused("cannot create the ROS node"))?;
        Ok(Self { node: Arc::new(Mutex::new(node)), context, peers, priority })
    }

    /// Leaves the network, so that peers notice at once. All endpoints have to be dropped before.
    ///
    /// `RustDDS` ends its sending thread when it drops the participant, even if the last messages are not sent yet. On a busy
    /// machine the messages that announce the end are lost, and peers keep the node until its lease expires. No call waits for that
    /// thread, so this function gives it time to send what the dropped endpoints queued.
    pub fn leave(self) {
        const GRACE: Duration = Duration::from_millis(100);
        std::thread::sleep(GRACE);
        drop(self);
    }

    /// Creates a topic that holds as many samples as its quality allows.
    fn topic(
        &self,
        node: &Node,
        name: &FullName,
        kind: MessageKind,
        quality: Quality,
    ) -> Result<rustdds::Topic, MiddlewareError> {
        let why = || format!("cannot create topic {name}");
        let profile = quality.profile();
        if !matches!(quality, Quality::Bulk | Quality::ReliableBulk | Quality::LatchedBulk) {
            let topic = node.create_topic(&name_of(name)?, kind.type_name(), &profile);
            return topic.map_err(refused(why()));
        }
        // the quality of service of the client library has no such limits
        let limits = ResourceLimits {
            max_samples: Quality::BULK,
            max_instances: Quality::BULK,
            max_samples_per_instance: Quality::BULK,
        };
        let limits = QosPolicyBuilder::new().resource_limits(limits).build();
        let policies = QosPolicies::from(&profile).modify_by(&limits);
        let (topic, type_name) = (format!("rt{name}"), kind.type_name().dds_msg_type());
        (self.context.domain_participant())
            .create_topic(topic, type_name, &policies, TopicKind::NoKey)
            .map_err(refused(why()))
    }

    /// Creates a publisher of messages of `kind`, such as `std_msgs/Bool`, under a full name.
    pub fn publisher<M: Message>(
        &self,
        name: &FullName,
        kind: MessageKind,
        quality: Quality,
    ) -> Result<Publisher<M>, MiddlewareError> {
        let _lent = self.priority.lend();
        let mut node = lock(&self.node);
        let profile = quality.profile();
        let topic = self.topic(&node, name, kind, quality)?;
        let inner = node
            .create_publisher(&topic, Some(profile))
            .map_err(refused(format!("cannot publish {name}")))?;
        self.peers.note(inner.guid(), name, &kind.type_name().dds_msg_type());
        Ok(Publisher { inner, name: name.clone(), priority: self.priority })
    }

    /// Creates a subscription to messages of `kind` under a full name.
    pub fn subscription<M: Message + 'static>(
        &self,
        name: &FullName,
        kind: MessageKind,
        quality: Quality,
    ) -> Result<Subscription<M>, MiddlewareError> {
        let _lent = self.priority.lend();
        let mut node = lock(&self.node);
        let profile = quality.profile();
        let topic = self.topic(&node, name, kind, quality)?;
        let inner = node
            .create_subscription(&topic, Some(profile))
            .map_err(refused(format!("cannot subscribe to {name}")))?;
        self.peers.note(inner.guid(), name, &kind.type_name().dds_msg_type());
        if !matches!(quality, Quality::BestEffort | Quality::Bulk) {
            self.peers.note_reliably_read(format!("rt{name}"));
        }
        Ok(Subscription {
            inner,
            name: name.clone(),
            complaints: DecodeErrorLog::default(),
            arrivals: Mutex::default(),
            priority: self.priority,
        })
    }

    /// Creates a server of the service type `package/kind` under a full name.
    pub fn server<Request, Response>(
        &self,
        name: &FullName,
        (package, kind): (&str, &str),
    ) -> Result<Server<Request, Response>, MiddlewareError>
    where
        Request: Message + Clone + 'static,
        Response: Message + 'static,
    {
        let _lent = self.priority.lend();
        let inner = lock(&self.node)
            .create_server(
                ServiceMapping::Enhanced,
                &name_of(name)?,
                &ServiceTypeName::new(package, kind),
                // a best-effort reader would lose requests that a client sends before its writer is known here
                Quality::Reliable.profile(),
                Quality::Reliable.profile(),
            )
            .map_err(refused(format!("cannot serve {name}")))?;
        self.peers.note_reliably_read(format!("rq{name}Request"));
        Ok(Server::new(inner, name.clone(), Arc::clone(&self.peers), self.priority))
    }

    /// Creates a client of a service of the type `package/kind` of another node.
    pub fn client<Request, Response>(
        &self,
        name: &FullName,
        (package, kind): (&str, &str),
    ) -> Result<Client<Request, Response>, MiddlewareError>
    where
        Request: Message + Clone + 'static,
        Response: Message + 'static,
    {
        let _lent = self.priority.lend();
        let inner = lock(&self.node)
            .create_client(
                ServiceMapping::Enhanced,
                &name_of(name)?,
                &ServiceTypeName::new(package, kind),
                Quality::Reliable.profile(),
                Quality::Reliable.profile(),
            )
            .map_err(refused(format!("cannot ask {name}")))?;
        self.peers.note_reliably_read(format!("rr{name}Reply"));
        Ok(Client::new(inner, name.clone(), self.priority))
    }

    /// Creates a server of the action type `package/kind` under a full name.
    pub fn action_server<Goal, Outcome, Progress>(
        &self,
        name: &FullName,
        (package, kind): (&str, &str),
    ) -> Result<ActionServer<Goal, Outcome, Progress>, MiddlewareError>
    where
        Goal: Message + Clone + 'static,
        Outcome: Message + Clone + 'static,
        Progress: Message + 'static,
    {
        let qualities = ActionServerQosPolicies {
            goal_service: Quality::Reliable.profile(),
            result_service: Quality::Reliable.profile(),
            cancel_service: Quality::Reliable.profile(),
            feedback_publisher: Quality::Reliable.profile(),
            status_publisher: Quality::Latched.profile(),
        };
        let kind = ActionTypeName::new(package, kind);
        let _lent = self.priority.lend();
        let inner = lock(&self.node)
            .create_action_server(ServiceMapping::Enhanced, &name_of(name)?, &kind, qualities)
            .map_err(refused(format!("cannot serve {name}")))?;
        for service in ["send_goal", "cancel_goal", "get_result"] {
            self.peers.note_reliably_read(format!("rq{name}/_action/{service}Request"));
        }
        Ok(ActionServer::new(inner, name.clone(), Arc::clone(&self.peers), self.priority))
    }

    /// Publishes a line of the log on `/rosout`, with the name of a logger.
    pub fn tell(&self, logger: &str, line: &Line, stamp: Time) {
        let writer = lock(&self.node).logging_handle().rosout_writer();
        let Some(writer) = writer.as_ref() else { return };
        let _lent = self.priority.lend();
        // a line that cannot be published is on stderr at least
        let _ = writer.publish(LogMessage {
            stamp: StampMessage::from_nanos(stamp.nanoseconds()),
            level: match line.level {
                Level::Error => LogMessage::ERROR,
                Level::Warn => LogMessage::WARN,
                Level::Info => LogMessage::INFO,
                Level::Debug | Level::Trace => LogMessage::DEBUG,
            },
            name: logger.to_owned(),
            msg: line.text.clone(),
            file: line.file.to_owned(),
            function: String::new(),
            line: line.line,
        });
    }

    /// Number of publishers of other nodes on a topic, as far as discovery knows them.
    pub fn publishers_elsewhere(&self, topic: &FullName) -> usize {
        let dds_topic = format!("rt{topic}");
        let participant = self.context.domain_participant();
        let own = participant.guid().prefix;
        (participant.discovered_writers().iter())
            .filter(|writer| writer.publication_topic_data.topic_name == dds_topic)
            .filter(|writer| writer.writer_proxy.remote_writer_guid.prefix != own)
            .count()
    }

    /// Whether this process sent the message.
    pub fn is_own(&self, source: SourceId) -> bool {
        self.context.domain_participant().guid().prefix == rustdds::GUID::from_bytes(source.0).prefix
    }

    /// Servers of a service in other nodes, as far as discovery knows them.
    pub fn servers_elsewhere(&self, service: &FullName) -> BTreeSet<SourceId> {
        let requests = format!("rq{service}Request");
        let participant = self.context.domain_participant();
        let own = participant.guid().prefix;
        (participant.discovered_readers().iter())
            .filter(|reader| reader.subscription_topic_data.topic_name() == &requests)
            .map(|reader| reader.reader_proxy.remote_reader_guid)
            .filter(|reader| reader.prefix != own)
            .map(|reader| SourceId(reader.to_bytes()))
            .collect()
    }

    /// Handles discovery of other nodes, and logs which of them can never exchange messages with this node, and why. Never returns.
    pub async fn meet_peers(&self) {
        self.peers.meet(&self.context.domain_participant(), self.priority).await;
    }
}

fn name_of(name: &FullName) -> Result<Name, MiddlewareError> {
    Name::parse(name.as_str()).map_err(refused(format!("'{name}' is no ROS name")))
}

/// The package and name of a message type.
#[derive(Clone, Copy, Debug)]
pub struct MessageKind(pub &'static str, pub &'static str);

impl MessageKind {
    fn type_name(self) -> MessageTypeName {
        MessageTypeName::new(self.0, self.1)
    }
}
