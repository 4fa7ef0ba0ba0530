//! Services: requests in, answers out.

use std::io;
use std::sync::Arc;

use byteorder::LittleEndian;
use futures_lite::future;
use ros2_client::RmwRequestId;
use rustdds::GUID;

use super::Message;
use super::complaints::Complaints;
use super::peers::Peers;
use crate::node::names::FullName;

/// Bytes of an answer at most: the DDS library sends larger ones in fragments that nobody can read.
const LARGEST: usize = 65_000;

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

    /// Answers a request, as soon as its client can hear it. An answer too large to be sent is logged instead.
    pub async fn answer(&self, RequestId(id): RequestId, response: Response) {
        let size = size_of(&response);
        if size > LARGEST {
            self.complaints.warn(|| {
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

/// Bytes that a message takes.
fn size_of(message: &impl serde::Serialize) -> usize {
    let mut counter = Counter(0);
    // what can not be written is refused when it is sent
    let _ = cdr_encoding::to_writer::<_, LittleEndian, _>(&mut counter, message);
    counter.0
}

/// Counts what is written.
struct Counter(usize);

impl io::Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
