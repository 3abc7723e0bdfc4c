//! Reads a log from its beginning, as far as it goes: a killed run's file has no end.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read;
use std::path::Path;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};

use crate::error::RecordError;

/// Nothing in a log is longer \[bytes\]: a length that says so was overwritten.
const LONGEST: usize = 1 << 30;

/// One thing out of a log.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A message.
    Message {
        /// Where it was published.
        topic: String,
        /// When \[ns since the run began\].
        time_ns: u64,
        /// As it lies in the file: CDR or JSON.
        data: Vec<u8>,
    },
    /// A file put beside the messages.
    Attachment {
        /// Its name.
        name: String,
        /// Its content.
        data: Vec<u8>,
    },
}

/// A log being read.
pub struct Log {
    path: String,
    file: File,
    /// How much of the file is still to be read \[bytes\].
    left: u64,
    reader: LinearReader,
    wanted: Option<BTreeSet<String>>,
    channels: BTreeMap<u16, Option<String>>,
    complete: bool,
    over: bool,
}

impl Log {
    /// Opens a log; with `ends`, only messages whose topics end with one of them come out.
    ///
    /// # Errors
    /// [`RecordError::LogUnreadable`]: no such file, or it is no MCAP file.
    pub fn open(path: &Path, ends: Option<BTreeSet<String>>) -> Result<Self, RecordError> {
        let name = path.display().to_string();
        let unreadable = |reason: String| RecordError::LogUnreadable { path: name.clone(), reason };
        let mut file = File::open(path).map_err(|e| unreadable(e.to_string()))?;
        let mut magic = Vec::new();
        (&mut file).take(8).read_to_end(&mut magic).map_err(|e| unreadable(e.to_string()))?;
        if magic != mcap::MAGIC {
            return Err(unreadable("it is not an MCAP file".to_owned()));
        }
        let left =
            file.metadata().map_err(|e| unreadable(e.to_string()))?.len().saturating_sub(magic.len() as u64);
        let options =
            LinearReaderOptions::default().with_record_length_limit(LONGEST).with_validate_chunk_crcs(true);
        let mut reader = LinearReader::new_with_options(options);
        reader.insert(magic.len()).copy_from_slice(&magic);
        reader.notify_read(magic.len());
        Ok(Self {
            path: name,
            file,
            left,
            reader,
            wanted: ends,
            channels: BTreeMap::new(),
            complete: false,
            over: false,
        })
    }

    /// Whether the end was reached and the file has one.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// The next entry; None at the end, also where a killed writer left off.
    ///
    /// # Errors
    /// [`RecordError::LogUnreadable`]: what is in the file does not belong there.
    pub fn next_entry(&mut self) -> Result<Option<Entry>, RecordError> {
        while !self.over {
            let record = match self.reader.next_event() {
                None => {
                    (self.over, self.complete) = (true, true);
                    break;
                }
                Some(Err(McapError::UnexpectedEof)) => {
                    self.over = true;
                    break;
                }
                Some(Err(error)) => return Err(unreadable(&self.path, &error)),
                // A writer that was killed left off inside a record; or its length was overwritten.
                Some(Ok(LinearReadEvent::ReadRequest(count))) if count as u64 > self.left => {
                    self.over = true;
                    break;
                }
                Some(Ok(LinearReadEvent::ReadRequest(count))) => {
                    let read =
                        self.file.read(self.reader.insert(count)).map_err(|e| unreadable(&self.path, &e))?;
                    self.left = self.left.saturating_sub(read as u64);
                    self.reader.notify_read(read);
                    continue;
                }
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    parse_record(opcode, data).map_err(|e| unreadable(&self.path, &e))?
                }
            };
            match record {
                Record::Channel(channel) => {
                    let ends = |end: &String| channel.topic.ends_with(end.as_str());
                    let wanted = self.wanted.as_ref().is_none_or(|wanted| wanted.iter().any(ends));
                    self.channels.insert(channel.id, wanted.then_some(channel.topic));
                }
                Record::Message { header, data } => {
                    if let Some(Some(topic)) = self.channels.get(&header.channel_id) {
                        return Ok(Some(Entry::Message {
                            topic: topic.clone(),
                            time_ns: header.log_time,
                            data: data.into_owned(),
                        }));
                    }
                }
                Record::Attachment { header, data, .. } => {
                    return Ok(Some(Entry::Attachment { name: header.name, data: data.into_owned() }));
                }
                _ => {}
            }
        }
        Ok(None)
    }
}

fn unreadable(path: &str, error: &dyn std::fmt::Display) -> RecordError {
    RecordError::LogUnreadable { path: path.to_owned(), reason: error.to_string() }
}
