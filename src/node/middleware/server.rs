//! Services: requests in, answers out.

use std::sync::Arc;

use futures_lite::future;
use ros2_client::RmwRequestId;
use rustdds::GUID;

use super::Message;
use super::complaints::Complaints;
use super::peers::Peers;
use crate::node::cdr;
use crate::node::names::FullName;

/// Bytes of an answer at most. The DDS library sends larger ones in fragments that nobody can read, and does so already from 1.4 kB on
/// once a client of the service is across Ethernet, which is not known here.
const LARGEST: usize = 65_000;

/// Answers requests of one service.
pub struct Server<Request: Message, Response: Message> {
    inner: ros2_client::Server<Request, Response>,
    name: FullName,
    peers: Arc<Peers>,
    /// About requests.
    unread: Complaints,
    /// About answers.
    unsent: Complaints,
}

/// Names a request in its answer.
pub struct RequestId(pub(super) RmwRequestId);

impl<Request: Message + 'static, Response: Message + 'static> Server<Request, Response> {
    pub(super) fn new(
        inner: ros2_client::Server<Request, Response>,
        name: FullName,
        peers: Arc<Peers>,
    ) -> Self {
        Self { inner, name, peers, unread: Complaints::default(), unsent: Complaints::default() }
    }

    /// The next request, waiting for it. What can not be decoded is logged and passed over.
    pub async fn next(&self) -> (RequestId, Request) {
        loop {
            // as of topics: a client that never rests must not starve what waits beside it
            future::yield_now().await;
            match self.inner.async_receive_request().await {
                Ok((id, request)) => return (RequestId(id), request),
                Err(error) => {
                    self.unread.warn(|| format!("a request to {} could not be read: {error}", self.name));
                }
            }
        }
    }

    /// Answers a request, as soon as its client can hear it. An answer too large to be sent is logged instead.
    pub async fn answer(&self, RequestId(id): RequestId, response: Response) {
        let size = cdr::size_of(&response);
        if size > LARGEST {
            self.unsent.warn(|| {
                format!(
                    "an answer of {} has {size} bytes, of which only {LARGEST} can be sent: it was dropped; ask for less at a time",
                    self.name
                )
            });
            return;
        }
        self.peers.await_reader(GUID::from(id.writer_gid), &self.name).await;
        if let Err(error) = self.inner.send_response(id, response) {
            log::warn!("an answer of {} was dropped: {error}", self.name);
        }
    }
}
