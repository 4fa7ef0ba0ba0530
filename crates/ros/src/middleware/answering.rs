//! How answers reach those who asked.
//!
//! `RustDDS` 0.15.1 spoils the fragments of answers (decision 18). What does not fit into a datagram goes beside it: in fragments of
//! our own, in the name of the library's writer, and under the number that its next sample will have. Then the library sends an
//! empty answer of that number which nobody asked for. Who has all fragments has that number already, and passes over
//! it; who lost one hears nothing, as if the answer had been lost.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use ros2_client::{Message, RmwRequestId};
use rustdds::GUID;
use smol::Timer;
use smol::lock::Mutex;

use super::decode_error_log::DecodeErrorLog;
use super::fragments::Answer;
use super::peers::{Hearer, Peers};
use crate::cdr;
use crate::names::FullName;

/// Bytes of an answer that the library sends in one piece on any common network.
const SHORT: usize = 1000;

/// The same where everybody who hears the answers is on the loopback network.
const SHORT_ON_LOOPBACK: usize = 65_000;

/// Bytes of an answer at most.
const LONGEST: usize = 64 << 20;

/// Datagrams sent without a pause.
const BURST: usize = 8;

/// Between two bursts.
const PAUSE: Duration = Duration::from_millis(1);

/// Nobody asks again for a fragment, so each is sent more than once.
const PASSES: usize = 3;

/// Bytes that receivers have room for while they do not come to read.
const ROOM: usize = 80_000;

/// Between two passes of more than that: what took a receiver's time may be over then.
const RESPITE: Duration = Duration::from_millis(20);

/// Answers of one service.
pub struct Answering {
    name: FullName,
    /// DDS topic of the answers.
    topic: String,
    peers: Arc<Peers>,
    /// One is sent at a time.
    numbers: Mutex<Numbers>,
    complaints: DecodeErrorLog,
}

/// Numbers of the samples of a writer.
#[derive(Default)]
struct Numbers {
    /// Samples that the library has written.
    written: i64,
    /// Whether fragments have taken the next number, and the library not yet.
    is_taken: bool,
}

impl Answering {
    /// Of a service with that full name, which nobody has answered yet.
    pub fn new(name: FullName, service: &str, peers: Arc<Peers>) -> Self {
        Self {
            topic: format!("rr{service}Reply"),
            name,
            peers,
            numbers: Mutex::default(),
            complaints: DecodeErrorLog::default(),
        }
    }

    /// Answers a request as soon as its client can hear it; `write` sends a sample by way of the library. What can not be sent is
    /// logged.
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
            // who has the fragments would pass over anything else of that number
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
        // without a stand-in nothing may be sent
        cdr::blank::<Response>()?;
        let client = GUID::from(id.writer_gid);
        let own: Vec<&Hearer> = hearers.iter().filter(|hearer| hearer.is_of(client)).collect();
        if !self.peers.reaches(&own) {
            return Err(format!("it has {size} bytes, and there is no way to send so many to its client"));
        }
        self.send_fragments(&own, id, numbers.written + 1, &bytes).await;
        numbers.is_taken = true;
        if let Err(why) = numbers.give_back(stand_in).await {
            // the answer is sent; the next one tries again
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
    /// Lets the library have the number that the fragments took. While its window is full it takes none.
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
