//! Service client: calls a service of another node, with a timeout.

use std::time::Duration;

use futures_lite::future;
use smol::Timer;

use crate::dds::{Message, wakeup};
use crate::names::FullName;
use crate::threading::thread_priority::ThreadPriority;

/// Client of one service.
pub struct Client<Request: Message, Response: Message> {
    inner: ros2_client::Client<Request, Response>,
    name: FullName,
    priority: ThreadPriority,
}

impl<Request: Message + 'static, Response: Message + 'static> Client<Request, Response> {
    pub(super) fn new(
        inner: ros2_client::Client<Request, Response>,
        name: FullName,
        priority: ThreadPriority,
    ) -> Self {
        Self { inner, name, priority }
    }

    /// Sends a request and waits at most `timeout` for the response. The error describes why there is none. A server
    /// that has not discovered this client yet may not receive the request: the caller has to send it again.
    pub async fn call(&self, request: Request, timeout: Duration) -> Result<Response, String> {
        let response = async {
            wakeup::wait(self.priority, self.inner.async_call_service(request))
                .await
                .map_err(|error| format!("{} was called in vain: {error}", self.name))
        };
        let timeout = async {
            Timer::after(timeout).await;
            Err(format!("{} did not answer within {timeout:?}", self.name))
        };
        future::or(response, timeout).await
    }
}
