//! Sends service responses to clients, also responses that are longer than a datagram.
//!
//! `RustDDS` 0.15.1 corrupts the fragments of responses (decision 18). So a response that does not fit into a datagram is sent
//! beside the library: in fragments made here, with the GUID of the library's writer and the sequence number of its next sample.
//! Then the library sends an empty response with that sequence number, to a request that no client made. A client with all
//! fragments already has that sequence number and discards the empty response. A client that lost a fragment receives no response,
//! as if the response had been lost.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use ros2_client::{Message, RmwRequestId};
use rustdds::GUID;
use smol::Timer;
use smol::lock::Mutex;

use crate::dds::cdr;
use crate::dds::decode_error_log::DecodeErrorLog;
use crate::dds::peers::{Hearer, Peers};
use crate::dds::response_fragments::Answer;
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
const ROOM: usize = 80_000;

/// Pause between two passes of a longer response. A receiver that was busy may have time again after it.
const RESPITE: Duration = Duration::from_millis(20);

/// Sends the responses of one service.
pub struct Answering {
    name: FullName,
    /// DDS topic of the responses.
    topic: String,
    peers: Arc<Peers>,
    /// The lock lets only one response be sent at a time.
    numbers: Mutex<Numbers>,
    complaints: DecodeErrorLog,
}

/// Sequence numbers of a writer's samples.
#[derive(Default)]
struct Numbers {
    /// Number of samples that the library has written.
    written: i64,
    /// Whether fragments have used the next sequence number and the library has not used it yet.
    is_taken: bool,
}

impl Answering {
    /// For the service with this full name, before any response was sent.
    pub fn new(name: FullName, service: &str, peers: Arc<Peers>) -> Self {
        Self {
            topic: format!("rr{service}Reply"),
            name,
            peers,
            numbers: Mutex::default(),
            complaints: DecodeErrorLog::default(),
        }
    }

    /// Sends the response to a request, as soon as the client's reader is known. `write` sends a sample through the library. A
    /// response that cannot be sent is logged.
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
            self.complaints.warn(|| format!("an answer of {} was dropped: {why}", self.name));
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
        let stand_in = || write(RmwRequestId::default(), cdr::blank()?).map_err(|fault| fault.to_string());
        if numbers.is_taken {
            // a client that has the fragments would discard any other sample with that sequence number
            numbers.give_back(stand_in).await?;
        }
        let size = cdr::size_of(&response);
        let hearers = self.peers.hearers(&self.topic);
        let short = if hearers.iter().all(Hearer::is_on_loopback) { SHORT_ON_LOOPBACK } else { SHORT };
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
        let own: Vec<&Hearer> = hearers.iter().filter(|hearer| hearer.is_of(client)).collect();
        if !self.peers.reaches(&own) {
            return Err(format!("it has {size} bytes, and there is no way to send so many to its client"));
        }
        self.send_fragments(&own, id, numbers.written + 1, &bytes).await;
        numbers.is_taken = true;
        if let Err(why) = numbers.give_back(stand_in).await {
            // the response is sent; the next response tries again
            self.complaints.warn(|| format!("{} waits for clients that do not keep up: {why}", self.name));
        }
        Ok(())
    }

    async fn send_fragments(&self, hearers: &[&Hearer], id: RmwRequestId, number: i64, bytes: &[u8]) {
        let asked = (GUID::from(id.writer_gid).to_bytes(), id.sequence_number);
        let mut since_pause = 0;
        for (pass, hearer) in (0..PASSES).flat_map(|pass| hearers.iter().map(move |hearer| (pass, hearer))) {
            if pass > 0 && bytes.len() > ROOM {
                Timer::after(RESPITE).await;
            }
            let answer = Answer { writer: hearer.writer.to_bytes(), number, asked, bytes };
            for fragment in answer.fragments(hearer.reader.to_bytes()) {
                if since_pause >= BURST {
                    Timer::after(PAUSE).await;
                    since_pause = 0;
                }
                self.peers.send(&fragment, &hearer.addresses);
                since_pause += hearer.addresses.len();
            }
        }
    }
}

impl Numbers {
    /// Has the library use the sequence number that the fragments took, with an empty response. While its send window is full it
    /// accepts no sample, so this retries.
    async fn give_back(&mut self, stand_in: impl Fn() -> Result<(), String>) -> Result<(), String> {
        const TRIES: usize = 100;
        let mut written = stand_in();
        for _ in 1..TRIES {
            if written.is_ok() {
                break;
            }
            Timer::after(PAUSE).await;
            written = stand_in();
        }
        written?;
        *self = Self { written: self.written + 1, is_taken: false };
        Ok(())
    }
}
