//! Saves the part of a recording that shows a difference, to be used as a test.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use mcap::Attachment;
use mcap::records::MessageHeader;

use crate::recording::mcap_file::{Entry, RawMessage, ReadError, RecordingFile};
use crate::recording::recorder::{complete, mcap_writer, with_causes};
use crate::recording::step::RecordStep;

/// Copies a recording up to its result number `last` (counted from 1). Of the earlier results it keeps the last `kept`,
/// and those that the loader used. Everything else is copied completely.
pub fn save_part(from: &Path, to: &Path, last: u64, kept: u64) -> Result<(), ReadError> {
    let mut source = RecordingFile::open(from)?;
    let failed = |error: mcap::McapError| ReadError::new(to, with_causes(&error));
    let mut copy = RecordingCopy::create(to)?;
    let (mut results, mut is_part) = (0, false);
    // the last result that was left out: the next loader step depends on the robot's position in it
    let mut before: Option<Vec<RawMessage>> = None;
    while let Some(entry) = source.next()? {
        match entry {
            Entry::Attachment { name, data } => {
                copy.attachment(name, data).map_err(failed)?;
            }
            Entry::RecordStep { step, mut messages, itself } => {
                messages.push(itself);
                let is_result = matches!(*step, RecordStep::JointState { .. } | RecordStep::Heartbeat { .. });
                results += u64::from(is_result);
                if is_result && results.saturating_add(kept) < last {
                    is_part = true;
                    leave_out_speed(&mut messages);
                    before = Some(messages);
                    continue;
                }
                if is_part && is_result {
                    leave_out_speed(&mut messages);
                }
                let before = before.take_if(|_| is_result || matches!(*step, RecordStep::Pass { .. }));
                for message in before.iter().flatten().chain(&messages) {
                    copy.message(message).map_err(failed)?;
                }
            }
        }
        if results >= last {
            break;
        }
    }
    copy.complete().map_err(|why| ReadError::new(to, why))
}

/// Removes the allowed speed: it depends on more results than a part contains.
fn leave_out_speed(answer: &mut Vec<RawMessage>) {
    let is_number = |message: &RawMessage| message.kind == "std_msgs/msg/Float64";
    let distance = answer.iter().position(is_number);
    let mut place = 0;
    answer.retain(|message| {
        place += 1;
        !is_number(message) || distance == Some(place - 1)
    });
}

/// File to which entries of recordings are copied.
pub struct RecordingCopy {
    mcap: mcap::Writer<BufWriter<File>>,
    channels: BTreeMap<(String, String), u16>,
    written: u32,
}

impl RecordingCopy {
    /// Creates a new file.
    pub fn create(path: &Path) -> Result<Self, ReadError> {
        let file = File::create_new(path).map_err(|error| ReadError::new(path, error.to_string()))?;
        let mcap = mcap_writer(file).map_err(|error| ReadError::new(path, with_causes(&error)))?;
        Ok(Self { mcap, channels: BTreeMap::new(), written: 0 })
    }

    /// Completes the file, and writes what is still in memory.
    pub fn complete(self) -> Result<(), String> {
        complete(self.mcap)
    }

    pub fn attachment(&mut self, name: String, data: Vec<u8>) -> mcap::McapResult<()> {
        let media_type = "application/octet-stream".to_owned();
        self.mcap.attach(&Attachment { log_time: 0, create_time: 0, name, media_type, data: data.into() })
    }

    pub fn message(&mut self, message: &RawMessage) -> mcap::McapResult<()> {
        let RawMessage { topic, kind, schema, log_time, data } = message;
        let key = (topic.clone(), kind.clone());
        let channel_id = if let Some(channel) = self.channels.get(&key) {
            *channel
        } else {
            let schema = self.mcap.add_schema(kind, "ros2msg", schema)?;
            let channel = self.mcap.add_channel(schema, topic, "cdr", &BTreeMap::new())?;
            self.channels.insert(key, channel);
            channel
        };
        let header = MessageHeader {
            channel_id,
            sequence: self.written,
            log_time: *log_time,
            publish_time: *log_time,
        };
        self.written = self.written.wrapping_add(1);
        self.mcap.write_to_known_channel(&header, data)
    }
}
