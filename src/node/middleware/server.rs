//! Services: requests in, answers out.

use std::sync::Arc;
use std::time::Duration;

use ros2_client::RmwRequestId;
use rustdds::GUID;
use smol::Timer;

use super::Message;
use super::peers::Peers;
use crate::node::names::FullName;

/// Answers requests of one service.
pub struct Server<Request: Message, Response: Message> {
    inner: ros2_client::Server<Request, Response>,
    name: FullName,
    peers: Arc<Peers>,
}

/// Names a request in its answer.
pub struct RequestId(RmwRequestId);

impl<Request: Message + 'static, Response: Message + 'static> Server<Request, Response> {
    pub(super) fn new(
        inner: ros2_client::Server<Request, Response>,
        name: FullName,
        peers: Arc<Peers>,
    ) -> Self {
        Self { inner, name, peers }
    }

    /// The next request, waiting for it. What can not be decoded is logged and passed over.
    pub async fn next(&self) -> (RequestId, Request) {
        loop {
            match self.inner.async_receive_request().await {
                Ok((id, request)) => return (RequestId(id), request),
                Err(error) => log::warn!("a request to {} could not be read: {error}", self.name),
            }
        }
    }

    /// Answers a request, as soon as its client can hear it.
    pub async fn answer(&self, RequestId(id): RequestId, response: Response) {
        self.await_reader(GUID::from(id.writer_gid)).await;
        if let Err(error) = self.inner.send_response(id, response) {
            log::warn!("an answer of {} was dropped: {error}", self.name);
        }
    }

    /// A client's reader of answers may become known here later than its first request; answers sent before are lost.
    async fn await_reader(&self, client: GUID) {
        const PERIOD: Duration = Duration::from_millis(2);
        const PERIODS: usize = 500;
        // Fast DDS names the reader of the answer in its requests; others name the writer, which says nothing
        if !is_reader(client) {
            return;
        }
        for _ in 0..PERIODS {
            if self.peers.has_reader(client) {
                return;
            }
            Timer::after(PERIOD).await;
        }
        log::warn!("a client of {} does not listen to answers", self.name);
    }
}

/// Whether an entity is a reader, by the last byte of its identifier (RTPS 9.3.1.2).
fn is_reader(entity: GUID) -> bool {
    matches!(entity.to_bytes()[15] & 0x3f, 0x04 | 0x07)
}
