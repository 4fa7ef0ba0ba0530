//! Sends service responses to clients, also responses that are longer than a datagram.
//!
//! `RustDDS` 0.15.1 corrupts the fragments of responses (decision 18). So a response that does not fit into a datagram
//! is sent beside the library: in fragments made here, with the GUID of the library's writer and the sequence number of
//! its next sample. Then the library sends an empty response with that sequence number, to a request that no client
//! made. A client with all fragments already has that sequence number and discards the empty response. A client that
//! lost a fragment receives no response, as if the response had been lost.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use ros2_client::{Message, RmwRequestId};
use rustdds::GUID;
use smol::Timer;
use smol::lock::Mutex;

use crate::dds::cdr;
use crate::dds::decode_error_log::DecodeErrorLog;
use crate::dds::peers::{MatchedReader, Peers};
use crate::dds::response_fragments::LongResponse;
use crate::names::FullName;

/// Largest response (bytes) that the library sends in one datagram on any common network.
const SHORT: usize = 1000;

/// The same if all readers of the responses are on the loopback network.
const SHORT_ON_LOOPBACK: usize = 65_000;

/// Largest response (bytes).
const LONGEST: usize = 64 << 20;

/// Number of datagrams sent without a pause.
const BURST: usize = 8;

/// Pause between two bursts.
const PAUSE: Duration = Duration::from_millis(1);

/// Number of times that each fragment is sent: readers do not request a lost fragment again.
const PASSES: usize = 3;

/// Bytes that a receiver can buffer while it does not read.
const RECEIVE_BUFFER: usize = 80_000;

/// Pause between two passes of a longer response. A receiver that was busy may have time again after it.
const PASS_PAUSE: Duration = Duration::from_millis(20);

/// Sends the responses of one service.
pub struct ResponseSender {
    name: FullName,
    /// DDS topic of the responses.
    topic: String,
    peers: Arc<Peers>,
    /// The lock lets only one response be sent at a time.
    numbers: Mutex<Numbers>,
    decode_errors: DecodeErrorLog,
}

/// Sequence numbers of a writer's samples.
#[derive(Default)]
struct Numbers {
    /// Number of samples that the library has written.
    written: i64,
    /// Whether fragments have used the next sequence number and the library has not used it yet.
    is_reserved: bool,
}

impl ResponseSender {
    /// For the service with this full name, before any response was sent.
    pub fn new(name: FullName, service: &str, peers: Arc<Peers>) -> Self {
        Self {
            topic: format!("rr{service}Reply"),
            name,
            peers,
            numbers: Mutex::default(),
            decode_errors: DecodeErrorLog::default(),
        }
    }

    /// Sends the response to a request, as soon as the client's reader is known. `write` sends a sample through the
    /// library. A response that cannot be sent is logged.
    pub async fn send<Response, Fault>(
        &self,
        id: RmwRequestId,
        response: Response,
        write: impl Fn(RmwRequestId, Response) -> Result<(), Fault>,
    ) where
        Response: Message,
        Fault: fmt::Display,
    {
        let client = GUID::from(id.writer_gid);
        self.peers.await_reader(client, &self.name).await;
        let mut numbers = self.numbers.lock().await;
        if let Err(why) = self.send_next(id, response, &mut numbers, write).await {
            self.decode_errors.warn(|| format!("a response of {} was dropped: {why}", self.name));
        }
    }

    async fn send_next<Response, Fault>(
        &self,
        id: RmwRequestId,
        response: Response,
        numbers: &mut Numbers,
        write: impl Fn(RmwRequestId, Response) -> Result<(), Fault>,
    ) -> Result<(), String>
    where
        Response: Message,
        Fault: fmt::Display,
    {
        let send_empty = || write(RmwRequestId::default(), cdr::blank()?).map_err(|fault| fault.to_string());
        if numbers.is_reserved {
            // a client that has the fragments would discard any other sample with that sequence number
            numbers.release_number(send_empty).await?;
        }
        let size = cdr::size_of(&response);
        let matched_readers = self.peers.matched_readers(&self.topic);
        let short =
            if matched_readers.iter().all(MatchedReader::is_on_loopback) { SHORT_ON_LOOPBACK } else { SHORT };
        if size <= short {
            write(id, response).map_err(|fault| fault.to_string())?;
            numbers.written += 1;
            return Ok(());
        }
        if size > LONGEST {
            return Err(format!(
                "it has {size} bytes, of which only {LONGEST} can be sent; ask for less at a time"
            ));
        }
        let bytes = cdr::encode(&response)?;
        // fragments may be sent only if the empty response that follows them can be made
        cdr::blank::<Response>()?;
        let client = GUID::from(id.writer_gid);
        let own: Vec<&MatchedReader> =
            matched_readers.iter().filter(|matched| matched.is_of(client)).collect();
        if !self.peers.reaches(&own) {
            return Err(format!("it has {size} bytes, and there is no way to send so many to its client"));
        }
        self.send_fragments(&own, id, numbers.written + 1, &bytes).await;
        numbers.is_reserved = true;
        if let Err(why) = numbers.release_number(send_empty).await {
            // the response is sent; the next response tries again
            self.decode_errors.warn(|| format!("{} waits for clients that do not keep up: {why}", self.name));
        }
        Ok(())
    }

    async fn send_fragments(
        &self,
        matched_readers: &[&MatchedReader],
        id: RmwRequestId,
        number: i64,
        bytes: &[u8],
    ) {
        let request = (GUID::from(id.writer_gid).to_bytes(), id.sequence_number);
        let mut since_pause = 0;
        for (pass, matched) in
            (0..PASSES).flat_map(|pass| matched_readers.iter().map(move |matched| (pass, matched)))
        {
            if pass > 0 && bytes.len() > RECEIVE_BUFFER {
                Timer::after(PASS_PAUSE).await;
            }
            let response = LongResponse { writer: matched.writer.to_bytes(), number, request, bytes };
            for fragment in response.fragments(matched.reader.to_bytes()) {
                if since_pause >= BURST {
                    Timer::after(PAUSE).await;
                    since_pause = 0;
                }
                self.peers.send(&fragment, &matched.addresses);
                since_pause += matched.addresses.len();
            }
        }
    }
}

impl Numbers {
    /// Has the library use the sequence number that the fragments took, with an empty response. While its send window
    /// is full it accepts no sample, so this retries.
    async fn release_number(&mut self, send_empty: impl Fn() -> Result<(), String>) -> Result<(), String> {
        const TRIES: usize = 100;
        let mut written = send_empty();
        for _ in 1..TRIES {
            if written.is_ok() {
                break;
            }
            Timer::after(PAUSE).await;
            written = send_empty();
        }
        written?;
        *self = Self { written: self.written + 1, is_reserved: false };
        Ok(())
    }
}
