//! Wrapper of the ROS 2 client library: participants, topics, services, qualities of service. No other module uses that
//! library.
//!
//! A new release of ros2-client, or another middleware, needs changes only here.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use ros2_client::RosoutRaw as _;
use ros2_client::action::ActionServerQosPolicies;
use ros2_client::{Context, Name, Node, NodeName, NodeOptions, ServiceMapping};
use rustdds::policy::ResourceLimits;
use rustdds::{QosPolicies, QosPolicyBuilder, RTPSEntity, TopicKind};

use crate::dds::Message;
use crate::dds::action_server::ActionServer;
use crate::dds::announcement::Announcement;
use crate::dds::client::Client;
use crate::dds::decode_error_log::DecodeErrorLog;
use crate::dds::lock::lock;
use crate::dds::log_line::LogLine;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::middleware_error::error_with;
use crate::dds::peers::Peers;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::server::Server;
use crate::dds::subscription::Subscription;
use crate::dds::type_name::TypeName;
use crate::names::FullName;
use crate::threading::thread_priority::ThreadPriority;
use clearance_monitor::{SourceId, Time};

/// One ROS node on the network.
#[derive(Clone)]
pub struct Middleware {
    node: Arc<Mutex<Node>>,
    context: Context,
    peers: Arc<Peers>,
    /// Priority of the library's threads, and of other threads while they call the library.
    priority: ThreadPriority,
}

impl Middleware {
    /// Joins the network under a node name.
    pub fn join(announcement: Announcement, namespace: &str, node: &str) -> Result<Self, MiddlewareError> {
        let (reach, priority) = (announcement.environment().reach, announcement.priority());
        let participant = announcement.discovered();
        let _lent = priority.lend();
        let context = Context::from_domain_participant(participant)
            .map_err(error_with("cannot join the ROS network"))?;
        let name = NodeName::new(namespace, node)
            .map_err(error_with(format!("'{namespace}' and '{node}' make no node name")))?;
        // the library's own parameter services support no descriptions or ranges; see `parameter_services`
        let options = NodeOptions::new().start_parameter_services(false);
        let peers = Arc::new(Peers::new(reach, namespace, node));
        let node = (context.new_node(name, options)).map_err(error_with("cannot create the ROS node"))?;
        Ok(Self { node: Arc::new(Mutex::new(node)), context, peers, priority })
    }

    /// Leaves the network, so that peers notice at once. All endpoints have to be dropped before.
    ///
    /// `RustDDS` ends its sending thread when it drops the participant, even if the last messages are not sent yet. On
    /// a busy machine the messages that announce the end are lost, and peers keep the node until its lease expires. No
    /// call waits for that thread, so this function gives it time to send what the dropped endpoints queued.
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
        kind: TypeName,
        quality: Quality,
    ) -> Result<rustdds::Topic, MiddlewareError> {
        let why = || format!("cannot create topic {name}");
        let profile = quality.profile();
        let Some(limit) = quality.limit() else {
            let topic = node.create_topic(&name_of(name)?, kind.of_message(), &profile);
            return topic.map_err(error_with(why()));
        };
        // the quality of service of the client library has no such limits
        let limits =
            ResourceLimits { max_samples: limit, max_instances: limit, max_samples_per_instance: limit };
        let limits = QosPolicyBuilder::new().resource_limits(limits).build();
        let policies = QosPolicies::from(&profile).modify_by(&limits);
        let (topic, type_name) = (format!("rt{name}"), kind.of_message().dds_msg_type());
        (self.context.domain_participant())
            .create_topic(topic, type_name, &policies, TopicKind::NoKey)
            .map_err(error_with(why()))
    }

    /// Creates a publisher of messages of `kind`, such as `std_msgs/Bool`, under a full name.
    pub fn publisher<M: Message>(
        &self,
        name: &FullName,
        kind: TypeName,
        quality: Quality,
    ) -> Result<Publisher<M>, MiddlewareError> {
        let _lent = self.priority.lend();
        let mut node = lock(&self.node);
        let profile = quality.profile();
        let topic = self.topic(&node, name, kind, quality)?;
        let inner = node
            .create_publisher(&topic, Some(profile))
            .map_err(error_with(format!("cannot publish {name}")))?;
        self.peers.note(inner.guid(), name, &kind.of_message().dds_msg_type(), None);
        Ok(Publisher { inner, name: name.clone(), priority: self.priority })
    }

    /// Creates a subscription to messages of `kind` under a full name.
    pub fn subscription<M: Message + 'static>(
        &self,
        name: &FullName,
        kind: TypeName,
        quality: Quality,
    ) -> Result<Subscription<M>, MiddlewareError> {
        let _lent = self.priority.lend();
        let mut node = lock(&self.node);
        let profile = quality.profile();
        let topic = self.topic(&node, name, kind, quality)?;
        let requested = QosPolicies::from(&profile);
        let inner = node
            .create_subscription(&topic, Some(profile))
            .map_err(error_with(format!("cannot subscribe to {name}")))?;
        self.peers.note(inner.guid(), name, &kind.of_message().dds_msg_type(), Some(requested));
        if !matches!(quality, Quality::BestEffort | Quality::Bulk) {
            self.peers.note_reliably_read(format!("rt{name}"));
        }
        Ok(Subscription {
            inner,
            name: name.clone(),
            decode_errors: DecodeErrorLog::default(),
            sequence_gaps: Mutex::default(),
            priority: self.priority,
        })
    }

    /// Creates a server of the service type `kind` under a full name.
    pub fn server<Request, Response>(
        &self,
        name: &FullName,
        kind: TypeName,
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
                &kind.of_service(),
                // a best-effort reader would lose requests that a client sends before its writer is known here
                Quality::Reliable.profile(),
                Quality::Reliable.profile(),
            )
            .map_err(error_with(format!("cannot serve {name}")))?;
        self.peers.note_reliably_read(format!("rq{name}Request"));
        Ok(Server::new(inner, name.clone(), Arc::clone(&self.peers), self.priority))
    }

    /// Creates a client of a service of the type `kind` of another node.
    pub fn client<Request, Response>(
        &self,
        name: &FullName,
        kind: TypeName,
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
                &kind.of_service(),
                Quality::Reliable.profile(),
                Quality::Reliable.profile(),
            )
            .map_err(error_with(format!("cannot ask {name}")))?;
        self.peers.note_reliably_read(format!("rr{name}Reply"));
        Ok(Client::new(inner, name.clone(), self.priority))
    }

    /// Creates a server of the action type `kind` under a full name.
    pub fn action_server<Goal, Outcome, Progress>(
        &self,
        name: &FullName,
        kind: TypeName,
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
        let kind = kind.of_action();
        let _lent = self.priority.lend();
        let inner = lock(&self.node)
            .create_action_server(ServiceMapping::Enhanced, &name_of(name)?, &kind, qualities)
            .map_err(error_with(format!("cannot serve {name}")))?;
        for service in ["send_goal", "cancel_goal", "get_result"] {
            self.peers.note_reliably_read(format!("rq{name}/_action/{service}Request"));
        }
        Ok(ActionServer::new(inner, name.clone(), Arc::clone(&self.peers), self.priority))
    }

    /// Publishes a line of the log on `/rosout`, with the name of a logger.
    pub fn publish_log_line(&self, logger: &str, line: &LogLine, stamp: Time) {
        let writer = lock(&self.node).logging_handle().rosout_writer();
        let Some(writer) = writer.as_ref() else { return };
        let _lent = self.priority.lend();
        // a line that cannot be published is on stderr at least
        let _ = writer.publish(line.to_message(logger, stamp));
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

    /// Publishers of other nodes from which no subscription of this node to these topics can receive, as far as
    /// discovery knows them: the reasons, sorted.
    pub fn unreceivable_publishers(&self, topics: &[FullName]) -> Vec<String> {
        let participant = self.context.domain_participant();
        let own = participant.guid().prefix;
        let why = |writer: &rustdds::discovery::DiscoveredWriterData| {
            let data = &writer.publication_topic_data;
            let name = data.topic_name.strip_prefix("rt")?;
            let is_elsewhere = writer.writer_proxy.remote_writer_guid.prefix != own;
            if !is_elsewhere || !topics.iter().any(|topic| topic.as_str() == name) {
                return None;
            }
            self.peers.why_unreceivable(name, &data.type_name, &data.qos())
        };
        let reasons: BTreeSet<String> = participant.discovered_writers().iter().filter_map(why).collect();
        reasons.into_iter().collect()
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

    /// Handles discovery of other nodes, and logs which of them can never exchange messages with this node, and why.
    /// Never returns.
    pub async fn watch_peers(&self) {
        self.peers.watch(&self.context.domain_participant(), self.priority).await;
    }
}

fn name_of(name: &FullName) -> Result<Name, MiddlewareError> {
    Name::parse(name.as_str()).map_err(error_with(format!("'{name}' is no ROS name")))
}
