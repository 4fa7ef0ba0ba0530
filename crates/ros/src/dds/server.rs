//! Service server: receives requests and sends responses.

use std::sync::Arc;

use futures_lite::future;
use ros2_client::RmwRequestId;

use crate::dds::decode_error_log::DecodeErrorLog;
use crate::dds::peers::Peers;
use crate::dds::response_sender::ResponseSender;
use crate::dds::{Message, wakeup};
use crate::names::FullName;
use crate::threading::thread_priority::ThreadPriority;

/// Server of one service.
pub struct Server<Request: Message, Response: Message> {
    inner: ros2_client::Server<Request, Response>,
    name: FullName,
    response_sender: ResponseSender,
    decode_errors: DecodeErrorLog,
    priority: ThreadPriority,
}

/// Identifies the request that a response belongs to.
pub struct RequestId(pub(super) RmwRequestId);

impl<Request: Message + 'static, Response: Message + 'static> Server<Request, Response> {
    pub(super) fn new(
        inner: ros2_client::Server<Request, Response>,
        name: FullName,
        peers: Arc<Peers>,
        priority: ThreadPriority,
    ) -> Self {
        let response_sender = ResponseSender::new(name.clone(), name.as_str(), peers);
        Self { inner, name, response_sender, decode_errors: DecodeErrorLog::default(), priority }
    }

    /// Waits for the next request. A request that cannot be decoded is logged and skipped.
    pub async fn next(&self) -> (RequestId, Request) {
        loop {
            // as for topics: a client that sends without pause must not starve the futures beside it
            future::yield_now().await;
            match wakeup::wait(self.priority, self.inner.async_receive_request()).await {
                Ok((id, request)) => return (RequestId(id), request),
                Err(error) => {
                    self.decode_errors
                        .warn(|| format!("a request to {} could not be read: {error}", self.name));
                }
            }
        }
    }

    /// Sends the response to a request, as soon as the client's reader is known.
    pub async fn respond(&self, RequestId(id): RequestId, response: Response) {
        let write = |id, response| {
            let _lent = self.priority.lend();
            self.inner.send_response(id, response)
        };
        self.response_sender.send(id, response, write).await;
    }
}
