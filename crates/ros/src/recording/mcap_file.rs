//! Reader of MCAP recordings. It reads untrusted files step by step and never holds a whole file in memory.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use clearance_files::input_files;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ros2_interfaces_jazzy_serde::std_msgs::msg::String as StringMessage;

use crate::dds::cdr;
use crate::recording::step::RecordStep;

/// Private name of the topic that contains the steps.
pub const STEPS: &str = "recording";

/// Largest record (bytes) that is read: the largest attached file, plus room for its description.
const LARGEST_RECORD: usize = (512 << 20) + (1 << 20);

/// Bytes that are read at once at most. The length of a record in the file is not trusted: memory grows with the
/// contents of the file, and with those of a compressed chunk up to [`LARGEST_RECORD`].
const BYTES_AT_ONCE: usize = 1 << 20;

/// Limits for one step: number of its messages, and their total size (bytes).
const MESSAGES_OF_A_STEP: usize = 100_000;
const BYTES_OF_A_STEP: usize = 1 << 30;

/// Limits for schemas: their number, and the size of one (bytes).
const MOST_SCHEMAS: usize = 1000;
const BYTES_OF_A_SCHEMA: usize = 1 << 20;

/// Error: a recording cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {why}", file.display())]
pub struct ReadError {
    file: PathBuf,
    why: String,
}

impl ReadError {
    pub fn new(file: &Path, why: impl Into<String>) -> Self {
        Self { file: file.to_owned(), why: why.into() }
    }
}

/// A message as it is stored in the file.
#[derive(Clone, Debug)]
pub struct RawMessage {
    pub topic: String,
    /// Full name of the message type.
    pub kind: String,
    pub schema: Vec<u8>,
    pub log_time: u64,
    pub data: Vec<u8>,
}

impl RawMessage {
    /// Time of the message (s since 1970), as text.
    pub fn time(&self) -> String {
        format!("{}.{:09}", self.log_time / 1_000_000_000, self.log_time % 1_000_000_000)
    }
}

/// Entry of a recording, in file order.
#[derive(Debug)]
pub enum Entry {
    Attachment {
        name: String,
        data: Vec<u8>,
    },
    /// A step, the messages that precede it, and the raw message that contains the step.
    RecordStep {
        step: Box<RecordStep>,
        messages: Vec<RawMessage>,
        itself: RawMessage,
    },
}

/// Reader of a recording, from its beginning to its end.
pub struct RecordingFile {
    path: PathBuf,
    file: File,
    reader: LinearReader,
    schemas: HashMap<u16, (String, Vec<u8>)>,
    /// By channel: topic and schema.
    channels: HashMap<u16, (String, u16)>,
    /// Messages that precede the next step, and their total size (bytes).
    messages: Vec<RawMessage>,
    bytes: usize,
    at_end: bool,
    /// Whether the footer was read, which every complete file has.
    has_footer: bool,
    is_cut_off: bool,
}

impl RecordingFile {
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let file = input_files::open(path).map_err(|e| ReadError { file: e.file, why: e.reason })?;
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_validate_chunk_crcs(true)
            .with_record_length_limit(LARGEST_RECORD);
        Ok(Self {
            path: path.to_owned(),
            file,
            reader: LinearReader::new_with_options(options),
            schemas: HashMap::new(),
            channels: HashMap::new(),
            messages: Vec::new(),
            bytes: 0,
            at_end: false,
            has_footer: false,
            is_cut_off: false,
        })
    }

    /// Whether the file ends before its footer.
    #[must_use]
    pub fn is_cut_off(&self) -> bool {
        self.is_cut_off
    }

    pub fn error(&self, why: impl Into<String>) -> ReadError {
        ReadError { file: self.path.clone(), why: why.into() }
    }

    /// Returns the next entry; `None` at the end, also of a file that was cut off.
    pub fn next(&mut self) -> Result<Option<Entry>, ReadError> {
        loop {
            let Some(record) = self.next_record()? else {
                self.is_cut_off |= !self.has_footer;
                return Ok(None);
            };
            self.has_footer |= matches!(record, Record::Footer(_));
            if let Some(entry) = self.note(record)? {
                return Ok(Some(entry));
            }
        }
    }

    fn next_record(&mut self) -> Result<Option<Record<'static>>, ReadError> {
        loop {
            let wanted = match self.reader.next_event() {
                None => return Ok(None),
                Some(Ok(LinearReadEvent::ReadRequest(wanted))) => wanted,
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    match lengths_fit(opcode, data) {
                        None => {
                            return Err(self.error("is damaged: a record is shorter than the lengths in it"));
                        }
                        Some(false) => continue,
                        Some(true) => {}
                    }
                    let record = mcap::parse_record(opcode, data).map(Record::into_owned);
                    return record.map(Some).map_err(|error| damaged(&self.path, &error));
                }
                // a cut-off file may be missing anything at its end
                Some(Err(_)) if self.at_end => {
                    self.is_cut_off = true;
                    return Ok(None);
                }
                Some(Err(mcap::McapError::BadMagic)) => {
                    return Err(self.error("is no MCAP file"));
                }
                Some(Err(error)) => return Err(damaged(&self.path, &error)),
            };
            let space = self.reader.insert(wanted.min(BYTES_AT_ONCE));
            let read = self.file.read(space);
            let read = read.map_err(|error| ReadError { file: self.path.clone(), why: error.to_string() })?;
            self.reader.notify_read(read);
            self.at_end = read == 0;
        }
    }

    fn note(&mut self, record: Record<'static>) -> Result<Option<Entry>, ReadError> {
        match record {
            Record::Schema { header, data } => {
                if data.len() > BYTES_OF_A_SCHEMA || self.schemas.len() >= MOST_SCHEMAS {
                    return Err(self.error("its schemas are too many or too large"));
                }
                self.schemas.insert(header.id, (header.name, data.into_owned()));
            }
            Record::Channel(channel) => {
                self.channels.insert(channel.id, (channel.topic, channel.schema_id));
            }
            Record::Attachment { header, data, .. } => {
                return Ok(Some(Entry::Attachment { name: header.name, data: data.into_owned() }));
            }
            Record::Message { header, data } => {
                let (topic, schema) = (self.channels.get(&header.channel_id))
                    .ok_or_else(|| self.error(format!("channel {} is not declared", header.channel_id)))?;
                let (kind, schema) = self.schemas.get(schema).cloned().unwrap_or_default();
                let (topic, data) = (topic.clone(), data.into_owned());
                let is_step = topic.rsplit('/').next() == Some(STEPS) && kind == "std_msgs/msg/String";
                let message = RawMessage { topic, kind, schema, log_time: header.log_time, data };
                if is_step {
                    return self.step(message).map(Some);
                }
                self.bytes += message.data.len() + message.schema.len();
                if self.messages.len() >= MESSAGES_OF_A_STEP || self.bytes > BYTES_OF_A_STEP {
                    return Err(self.error(format!(
                        "too many messages stand in it without one on a topic '{STEPS}': it is no recording of clearance"
                    )));
                }
                self.messages.push(message);
            }
            _ => {}
        }
        Ok(None)
    }

    fn step(&mut self, itself: RawMessage) -> Result<Entry, ReadError> {
        let wrong = |why: String| self.error(format!("{}: {why}", itself.topic));
        let text: StringMessage = cdr::decode(&itself.data).map_err(wrong)?;
        let step = serde_json::from_str(&text.data)
            .map_err(|error| wrong(format!("is no step of this version of clearance: {error}")))?;
        self.bytes = 0;
        Ok(Entry::RecordStep { step: Box::new(step), messages: std::mem::take(&mut self.messages), itself })
    }
}

/// Whether a record is of a kind that is read; `None` when it is shorter than the lengths in it.
///
/// `mcap` reserves memory for a text before it reads it, up to 4 GiB, and panics at an attachment without a checksum.
fn lengths_fit(opcode: u8, body: &[u8]) -> Option<bool> {
    match opcode {
        op::FOOTER | op::MESSAGE => {}
        op::SCHEMA => {
            after_texts(body.get(2..)?, 2)?;
        }
        op::CHANNEL => {
            let (length, rest) = after_texts(body.get(4..)?, 2)?.split_first_chunk()?;
            let mut metadata = rest.get(..usize::try_from(u32::from_le_bytes(*length)).ok()?)?;
            while !metadata.is_empty() {
                metadata = after_texts(metadata, 2)?;
            }
        }
        op::ATTACHMENT => {
            // the length of the data, and the checksum behind it
            after_texts(body.get(16..)?, 2)?.get(..8 + 4)?;
        }
        _ => return Some(false),
    }
    Some(true)
}

/// Remaining bytes after `count` texts, each of which begins with its length.
fn after_texts(bytes: &[u8], count: usize) -> Option<&[u8]> {
    (0..count).try_fold(bytes, |bytes, _| {
        let (length, rest) = bytes.split_first_chunk()?;
        rest.get(usize::try_from(u32::from_le_bytes(*length)).ok()?..)
    })
}

fn damaged(path: &Path, error: &mcap::McapError) -> ReadError {
    ReadError { file: path.to_owned(), why: format!("is damaged: {error}") }
}
