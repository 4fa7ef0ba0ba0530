//! Service `~/enable`: turns checking off and on.

use serde::{Deserialize, Serialize};

use crate::dds::Message;
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::server::Server;
use crate::dds::type_name::TypeName;
use crate::monitor_events::monitor_event::MonitorEvent;
use crate::names::Names;
use crate::threading::mailbox;
use crate::threading::mailbox::Sender;

/// Request of `std_srvs/srv/SetBool`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SetBoolRequest {
    data: bool,
}

/// Response of `std_srvs/srv/SetBool`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SetBoolResponse {
    success: bool,
    message: String,
}

impl Message for SetBoolRequest {}
impl Message for SetBoolResponse {}

/// Forwards requests to the monitor.
pub struct EnableService {
    server: Server<SetBoolRequest, SetBoolResponse>,
    events: Sender<MonitorEvent>,
}

impl EnableService {
    pub fn open(
        middleware: &Middleware,
        names: &Names,
        events: Sender<MonitorEvent>,
    ) -> Result<Self, MiddlewareError> {
        let server =
            middleware.server(&names.resolve_service("~/enable")?, TypeName::new("std_srvs", "SetBool"))?;
        Ok(Self { server, events })
    }

    /// Serves requests until the node ends. The response is sent after the monitor has applied the request: no result
    /// with the old setting is published after it.
    pub async fn serve(&self) {
        loop {
            let (id, SetBoolRequest { data }) = self.server.next().await;
            let (applied, is_applied) = mailbox::bounded(1);
            let sent = self.events.send(MonitorEvent::Enabled(data, applied)).is_ok();
            let success = sent && is_applied.receive().await.is_some();
            let message = match (success, data) {
                (false, _) => "the monitor has ended",
                (true, true) => "checking is enabled",
                (true, false) => "checking is disabled: the state is UNKNOWN until it is enabled again",
            };
            self.server.respond(id, SetBoolResponse { success, message: message.to_owned() }).await;
        }
    }
}
