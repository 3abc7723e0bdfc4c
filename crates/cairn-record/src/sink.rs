//! The thread that writes: events in, an MCAP file out.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::{Duration, Instant};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Attachment, McapError, WriteOptions, Writer};

use crate::json::JsonError;
use crate::recorder::Event;
use crate::robot::RobotLog;
use crate::ros::{Definition, Stamp};

/// The queue is looked at this often; waking a sleeping thread would cost the control loop more.
const POLL: Duration = Duration::from_millis(10);

/// A chunk is closed and handed to the system once it spans this much of the run, or of the day.
const CHUNK_NS: u64 = 400_000_000;
const CHUNK_WALL: Duration = Duration::from_millis(400);

#[derive(Debug, thiserror::Error)]
pub enum SinkError {
    #[error("{0}")]
    Mcap(#[from] McapError),
    #[error("{0}")]
    Json(#[from] JsonError),
    #[error("there is no robot number {0}")]
    NoRobot(usize),
}

/// Writes events to `file` until the last one.
pub fn run(file: File, events: &Receiver<Event>) -> Result<(), SinkError> {
    let mut sink = Sink::new(file)?;
    loop {
        match events.try_recv() {
            Ok(Event::Finish) | Err(TryRecvError::Disconnected) => return sink.finish(),
            Ok(event) => sink.take(event)?,
            Err(TryRecvError::Empty) => {
                sink.flush_if_due()?;
                std::thread::sleep(POLL);
            }
        }
    }
}

/// A channel of the file, with the number of its next message.
#[derive(Clone, Copy)]
pub struct Channel {
    id: u16,
    sequence: u32,
}

/// The file.
pub struct Output {
    writer: Writer<NoSeek<BufWriter<File>>>,
    channels: BTreeMap<String, Channel>,
    /// Of the chunk being filled: stamp of its first message, and when that was written.
    chunk: Option<(Stamp, Instant)>,
}

impl Output {
    /// Writes a ROS 2 message.
    pub fn ros(&mut self, topic: &str, kind: &Definition, at: Stamp, data: &[u8]) -> Result<(), McapError> {
        if !self.channels.contains_key(topic) {
            let schema = self.writer.add_schema(kind.name, "ros2msg", kind.full_text().as_bytes())?;
            self.add(topic, schema, "cdr")?;
        }
        self.put(topic, at, data)
    }

    /// Writes a message of our own, whose schema is in docs/decision-record.md.
    pub fn json(&mut self, topic: &str, kind: &str, at: Stamp, data: &[u8]) -> Result<(), McapError> {
        if !self.channels.contains_key(topic) {
            let schema = self.writer.add_schema(kind, "", &[])?;
            self.add(topic, schema, "json")?;
        }
        self.put(topic, at, data)
    }

    fn add(&mut self, topic: &str, schema: u16, encoding: &str) -> Result<(), McapError> {
        let id = self.writer.add_channel(schema, topic, encoding, &BTreeMap::new())?;
        self.channels.insert(topic.to_owned(), Channel { id, sequence: 0 });
        Ok(())
    }

    fn put(&mut self, topic: &str, at: Stamp, data: &[u8]) -> Result<(), McapError> {
        let Some(channel) = self.channels.get_mut(topic) else { return Ok(()) };
        channel.sequence = channel.sequence.wrapping_add(1);
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.sequence,
            log_time: at.0,
            publish_time: at.0,
        };
        self.chunk.get_or_insert_with(|| (at, Instant::now()));
        self.writer.write_to_known_channel(&header, data)
    }
}

fn nth(robots: &mut [RobotLog], number: usize) -> Result<&mut RobotLog, SinkError> {
    robots.get_mut(number).ok_or(SinkError::NoRobot(number))
}

/// What a robot is called in topics and frames: its name in letters, digits and underscores, with a
/// number where another robot is called so already. `Run` in Python follows the same rule.
fn topics_of(name: &str, robots: &[RobotLog]) -> String {
    let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let mut topics = plain.clone();
    let mut number = 1;
    while robots.iter().any(|other| other.takes(&topics, name)) {
        number += 1;
        topics = format!("{plain}_{number}");
    }
    topics
}

struct Sink {
    out: Output,
    robots: Vec<RobotLog>,
    latest: Stamp,
}

impl Sink {
    fn new(file: File) -> Result<Self, SinkError> {
        let writer = WriteOptions::new()
            .profile("ros2")
            .library(concat!("cairn ", env!("CARGO_PKG_VERSION")))
            .chunk_size(None)
            .disable_seeking(true) // a chunk reaches the file whole or not at all
            .compression_threads(0)
            .create(NoSeek::new(BufWriter::new(file)))?;
        let out = Output { writer, channels: BTreeMap::new(), chunk: None };
        Ok(Self { out, robots: Vec::new(), latest: Stamp(0) })
    }

    fn take(&mut self, event: Event) -> Result<(), SinkError> {
        let out = &mut self.out;
        match event {
            Event::Finish => {}
            Event::Attachment { name, media_type, bytes } => {
                let data = bytes.into();
                out.writer.attach(&Attachment { log_time: 0, create_time: 0, name, media_type, data })?;
                out.writer.flush()?;
            }
            Event::Robot { name, profile } => {
                let topics = topics_of(&name, &self.robots);
                self.robots.push(RobotLog::begin(&name, &topics, *profile, out)?);
            }
            Event::Told { robot, time_s, told } => nth(&mut self.robots, robot)?.told(time_s, &told, out)?,
            Event::Step { robot, step } => {
                self.latest = self.latest.max(nth(&mut self.robots, robot)?.step(*step, out)?);
            }
            Event::Judged { robot, time_s, truth, clearance_m } => {
                nth(&mut self.robots, robot)?.judged(time_s, truth, clearance_m, out)?;
            }
            Event::Map { robot, time_s, map } => nth(&mut self.robots, robot)?.map(time_s, &map, out)?,
        }
        self.flush_if_due()
    }

    fn flush_if_due(&mut self) -> Result<(), SinkError> {
        if let Some((first, since)) = self.out.chunk
            && (self.latest.0.saturating_sub(first.0) >= CHUNK_NS || since.elapsed() >= CHUNK_WALL)
        {
            self.out.chunk = None;
            self.out.writer.flush()?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(), SinkError> {
        for robot in &mut self.robots {
            robot.end(&mut self.out)?;
        }
        self.out.writer.finish()?;
        // The writer's own buffer, and what the system says of it.
        std::io::Write::flush(&mut self.out.writer.into_inner()).map_err(McapError::from)?;
        Ok(())
    }
}
