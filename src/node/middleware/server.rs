//! Services: requests in, answers out.

use std::sync::Arc;

use futures_lite::future;
use ros2_client::RmwRequestId;
use rustdds::GUID;

use super::Message;
use super::complaints::Complaints;
use super::peers::Peers;
use crate::node::names::FullName;

/// Answers requests of one service.
pub struct Server<Request: Message, Response: Message> {
    inner: ros2_client::Server<Request, Response>,
    name: FullName,
    peers: Arc<Peers>,
    complaints: Complaints,
}

/// Names a request in its answer.
pub struct RequestId(pub(super) RmwRequestId);

impl<Request: Message + 'static, Response: Message + 'static> Server<Request, Response> {
    pub(super) fn new(
        inner: ros2_client::Server<Request, Response>,
        name: FullName,
        peers: Arc<Peers>,
    ) -> Self {
        Self { inner, name, peers, complaints: Complaints::default() }
    }

    /// The next request, waiting for it. What can not be decoded is logged and passed over.
    pub async fn next(&self) -> (RequestId, Request) {
        loop {
            // as of topics: a client that never rests must not starve what waits beside it
            future::yield_now().await;
            match self.inner.async_receive_request().await {
                Ok((id, request)) => return (RequestId(id), request),
                Err(error) => {
                    self.complaints.warn(|| format!("a request to {} could not be read: {error}", self.name));
                }
            }
        }
    }

    /// Answers a request, as soon as its client can hear it.
    pub async fn answer(&self, RequestId(id): RequestId, response: Response) {
        self.peers.await_reader(GUID::from(id.writer_gid), &self.name).await;
        if let Err(error) = self.inner.send_response(id, response) {
            log::warn!("an answer of {} was dropped: {error}", self.name);
        }
    }
}
