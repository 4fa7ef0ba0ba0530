//! Services: requests in, answers out.

use std::sync::Arc;

use futures_lite::future;
use ros2_client::RmwRequestId;

use super::Message;
use super::answering::Answering;
use super::decode_error_log::DecodeErrorLog;
use super::peers::Peers;
use super::wakeup;
use crate::names::FullName;
use crate::thread_priority::ThreadPriority;

/// Answers requests of one service.
pub struct Server<Request: Message, Response: Message> {
    inner: ros2_client::Server<Request, Response>,
    name: FullName,
    answering: Answering,
    unread: DecodeErrorLog,
    priority: ThreadPriority,
}

/// Names a request in its answer.
pub struct RequestId(pub(super) RmwRequestId);

impl<Request: Message + 'static, Response: Message + 'static> Server<Request, Response> {
    pub(super) fn new(
        inner: ros2_client::Server<Request, Response>,
        name: FullName,
        peers: Arc<Peers>,
        priority: ThreadPriority,
    ) -> Self {
        let answering = Answering::new(name.clone(), name.as_str(), peers);
        Self { inner, name, answering, unread: DecodeErrorLog::default(), priority }
    }

    /// The next request, waiting for it. What can not be decoded is logged and passed over.
    pub async fn next(&self) -> (RequestId, Request) {
        loop {
            // as of topics: a client that never rests must not starve what waits beside it
            future::yield_now().await;
            match wakeup::wait(self.priority, self.inner.async_receive_request()).await {
                Ok((id, request)) => return (RequestId(id), request),
                Err(error) => {
                    self.unread.warn(|| format!("a request to {} could not be read: {error}", self.name));
                }
            }
        }
    }

    /// Answers a request, as soon as its client can hear it.
    pub async fn answer(&self, RequestId(id): RequestId, response: Response) {
        let write = |id, response| {
            let _lent = self.priority.lend();
            self.inner.send_response(id, response)
        };
        self.answering.send(id, response, write).await;
    }
}
