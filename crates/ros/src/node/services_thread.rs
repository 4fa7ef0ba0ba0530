//! The services thread: descriptions, parameters, simulated time, the log on `/rosout`, discovery, and requests of
//! clients.

use std::sync::Arc;

use futures_lite::future;
use ros2_interfaces_jazzy_serde::std_msgs::msg::String as StringMessage;
use smol::channel::{Receiver, Sender};

use crate::clock::RosClock;
use crate::dds::log_line::LogLine;
use crate::dds::middleware::Middleware;
use crate::dds::quality::Quality;
use crate::dds::subscription::Subscription;
use crate::dds::type_name::TypeName;
use crate::logging;
use crate::monitor_events::monitor_event::MonitorEvent;
use crate::names::{FullName, Names};
use crate::node_error::NodeError;
use crate::parameters::parameter_store::ParameterStore;
use crate::recording::recorder_handle::RecorderHandle;
use crate::scene::loader_command::LoaderCommand;
use crate::services::enable_service::EnableService;
use crate::services::motion_services::MotionServices;
use crate::services::parameter_services::ParameterServices;
use crate::services::state_services::StateServices;
use crate::threading::mailbox;
use crate::topics::simulation_clock::{self, ClockInputs};

const STRING: TypeName = TypeName::new("std_msgs", "String");

/// Replaces the text of a description that cannot be decoded.
const UNREADABLE: &str = "(the message could not be decoded: is its text UTF-8?)";

/// Parts of the node that the services thread uses.
pub struct ServicesInputs {
    pub store: ParameterStore,
    pub recording: RecorderHandle,
    pub clock: Arc<RosClock>,
    pub motions: MotionServices,
    pub states: StateServices,
    pub enable: EnableService,
    pub commands: Sender<LoaderCommand>,
    /// Queue of the monitor for new descriptions; `None` if the robot was given on the command line.
    pub description_events: Option<mailbox::Sender<MonitorEvent>>,
    /// Receives a notice when a parameter changed.
    pub changes: Receiver<()>,
}

/// Services that are neither urgent nor slow, on one thread: descriptions, parameters, simulated time, warnings about
/// peers.
pub struct ServicesThread {
    inputs: ServicesInputs,
    middleware: Middleware,
    descriptions: Subscription<StringMessage>,
    semantics: Subscription<StringMessage>,
    parameters: ParameterServices,
    clock_topic: FullName,
    lines: mailbox::Receiver<LogLine>,
    /// Name of the node in the format of loggers.
    logger: String,
}

impl ServicesThread {
    pub fn open(middleware: &Middleware, names: &Names, inputs: ServicesInputs) -> Result<Self, NodeError> {
        let latched = |name| -> Result<_, NodeError> {
            Ok(middleware.subscription(&names.resolve(name)?, STRING, Quality::Latched)?)
        };
        let ServicesInputs { store, clock, .. } = &inputs;
        Ok(Self {
            descriptions: latched("robot_description")?,
            semantics: latched("robot_description_semantic")?,
            parameters: ParameterServices::open(middleware, names, store.clone(), Arc::clone(clock))?,
            clock_topic: names.resolve("/clock")?,
            middleware: middleware.clone(),
            lines: logging::open_rosout_queue(),
            logger: names.full_node_name().trim_start_matches('/').replace('/', "."),
            inputs,
        })
    }

    /// Serves requests and receives messages. Never returns.
    pub async fn run(self) {
        let follow_clock = async {
            let Self { middleware, clock_topic, inputs, .. } = &self;
            let ServicesInputs { clock, store, recording, changes, .. } = inputs;
            let topic = clock_topic;
            let followed =
                simulation_clock::follow(ClockInputs { middleware, topic, clock, store, recording, changes });
            if let Err(error) = followed.await {
                log::error!("simulated time can not be followed: {error}");
            }
        };
        let descriptions = self.forward(&self.descriptions, LoaderCommand::Description);
        let semantics = self.forward(&self.semantics, LoaderCommand::Semantic);
        let listen = future::zip(future::zip(descriptions, semantics), follow_clock);
        let tell = async {
            while let Some(line) = self.lines.receive().await {
                self.middleware.publish_log_line(
                    &self.logger,
                    &line,
                    self.inputs.clock.now().unwrap_or_default(),
                );
            }
        };
        let checks = future::zip(self.inputs.motions.serve(), self.inputs.states.serve());
        let serve = future::zip(self.parameters.serve(), checks);
        let serve = future::zip(future::zip(serve, self.inputs.enable.serve()), tell);
        let meet = Box::pin(self.middleware.watch_peers());
        future::zip(future::zip(listen, serve), meet).await;
    }

    /// Converts the descriptions on a topic to commands. The monitor is notified of a new one first, as the loader may
    /// be busy.
    async fn forward(&self, topic: &Subscription<StringMessage>, command: fn(String) -> LoaderCommand) {
        let mut last = None;
        loop {
            // a message that cannot be decoded is rejected like any other invalid robot description
            let received = topic.next_or_undecodable().await.map(|(StringMessage { data }, _)| data);
            let text = received.unwrap_or_else(|_| UNREADABLE.to_owned());
            if last.as_ref() != Some(&text) {
                if let Some(events) = &self.inputs.description_events {
                    // an error means that the receiver has ended
                    let _ = events.send(MonitorEvent::DescriptionReceived);
                }
                last = Some(text.clone());
            }
            if self.inputs.commands.send(command(text)).await.is_err() {
                return;
            }
        }
    }
}
