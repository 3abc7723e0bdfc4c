//! What the control loop sees of a log: a handle that takes values and returns at once.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use cairn::geometry::{Point2, Pose2};
use cairn::locate::WheelTravel;
use cairn::navigate::{Decision, Navigator, TickInput};
use cairn::robot::RobotProfile;
use cairn::world::{GridGeometry, Occupancy};

use crate::error::RecordError;
use crate::sink;

/// Ticks that may wait to be written; only a disk that stands still for so long holds the loop up.
const QUEUE: usize = 1024;

/// The map is kept this often \[s\] where it is no larger than [`MAP_CELLS`], larger ones more seldom.
const MAP_EVERY_S: f64 = 5.0;
const MAP_CELLS: f64 = 250_000.0;

/// A map as it was at one moment.
#[derive(Clone, Debug)]
pub struct MapSnapshot {
    /// Its grid.
    pub geometry: GridGeometry,
    /// Its cells, row-major.
    pub cells: Vec<Occupancy>,
}

/// Where a shared field came from: the field of `robot` as it was after `tick`.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct FieldSource {
    /// Whose.
    pub robot: String,
    /// Number of the tick after which it was taken; none, before the first.
    pub tick: Option<u64>,
}

/// Something a navigator was told between two ticks.
#[derive(Clone, Debug)]
pub enum Told {
    /// To drive to a point \[m\]; a field may have come with it, from a recorded navigator or not.
    Goal {
        /// The point, world frame.
        point: Point2,
        /// A field came with it.
        shared: bool,
        /// Whose it was, where that is known.
        source: Option<FieldSource>,
    },
    /// To explore.
    Explore,
    /// To end the task.
    Cancel,
}

/// One tick: what went in and what came out.
#[derive(Clone, Debug)]
pub struct Step {
    /// Readings, as [`TickInput::ranges_m`].
    pub ranges_m: Vec<f64>,
    /// Travel of both sides.
    pub wheels: WheelTravel,
    /// Turn rate \[rad/s\].
    pub gyro_radps: Option<f64>,
    /// Since the tick before \[s\].
    pub dt_s: f64,
    /// The pose, where it was given.
    pub world_from_robot: Option<Pose2>,
    /// All that was decided.
    pub decision: Arc<Decision>,
    /// The path, if it is another one than before.
    pub path: Option<Vec<Point2>>,
    /// The waypoints, if they are others.
    pub waypoints: Option<Vec<Point2>>,
    /// The map, now and then.
    pub map: Option<MapSnapshot>,
}

pub(crate) enum Event {
    Attachment { name: String, media_type: String, bytes: Vec<u8> },
    Robot { name: String, profile: Box<RobotProfile> },
    Told { robot: usize, time_s: f64, told: Told },
    Step { robot: usize, step: Box<Step> },
    Judged { robot: usize, time_s: f64, truth: Pose2, clearance_m: f64 },
    Map { robot: usize, time_s: f64, map: MapSnapshot },
    Finish,
}

/// Writes one log, on a thread of its own.
///
/// What was handed over is on its way to the disk within half a second, so a killed run loses less
/// than its last second.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    sender: SyncSender<Event>,
    thread: Option<JoinHandle<()>>,
    failure: Arc<Mutex<Option<RecordError>>>,
    robots: usize,
}

impl Recorder {
    /// Begins the log at `path`, replacing what is there.
    ///
    /// # Errors
    /// [`RecordError::LogUnwritable`].
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let unwritable = |error: &dyn std::fmt::Display| RecordError::LogUnwritable {
            path: path.display().to_string(),
            reason: error.to_string(),
        };
        let file = File::create(path).map_err(|e| unwritable(&e))?;
        let (sender, receiver) = sync_channel(QUEUE);
        let failure = Arc::new(Mutex::new(None));
        let (told, name) = (failure.clone(), path.display().to_string());
        let thread = std::thread::Builder::new()
            .name("cairn-record".to_owned())
            .spawn(move || {
                if let Err(error) = sink::run(file, &receiver) {
                    let error = RecordError::LogUnwritable { path: name, reason: error.to_string() };
                    *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                }
            })
            .map_err(|e| unwritable(&e))?;
        Ok(Self { path: path.to_owned(), sender, thread: Some(thread), failure, robots: 0 })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Puts `bytes` beside the messages.
    pub fn attach(&self, name: &str, media_type: &str, bytes: Vec<u8>) {
        self.send(Event::Attachment { name: name.to_owned(), media_type: media_type.to_owned(), bytes });
    }

    /// What keeps the ticks of the robot called `name`.
    pub fn tap(&mut self, name: &str, profile: &RobotProfile) -> Tap {
        let robot = self.robots;
        self.robots += 1;
        self.send(Event::Robot { name: name.to_owned(), profile: Box::new(profile.clone()) });
        Tap {
            sender: self.sender.clone(),
            robot,
            name: name.to_owned(),
            path: Vec::new(),
            waypoints: Vec::new(),
            map_due_s: f64::NEG_INFINITY,
            ticks: None,
            time_s: 0.0,
        }
    }

    /// What the judge saw at the last tick of `robot`, the number of its tap.
    ///
    /// # Errors
    /// [`RecordError::RecordedRobotUnknown`].
    pub fn judged(
        &self,
        robot: usize,
        time_s: f64,
        truth: Pose2,
        clearance_m: f64,
    ) -> Result<(), RecordError> {
        if robot >= self.robots {
            return Err(RecordError::RecordedRobotUnknown { number: robot, robots: self.robots });
        }
        self.send(Event::Judged { robot, time_s, truth, clearance_m });
        Ok(())
    }

    /// Whether all is well so far.
    ///
    /// # Errors
    /// [`RecordError::LogUnwritable`] once something could not be written.
    pub fn check(&self) -> Result<(), RecordError> {
        // Asked first: a writer that fails says why before it ends.
        let ended = self.thread.as_ref().is_some_and(JoinHandle::is_finished);
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match failure {
            Some(error) => Err(error),
            None if ended => Err(self.stopped()),
            None => Ok(()),
        }
    }

    /// Writes what is left, index and summary, and closes the file.
    ///
    /// # Errors
    /// [`RecordError::LogUnwritable`].
    pub fn finish(&mut self) -> Result<(), RecordError> {
        if let Some(thread) = self.thread.take() {
            self.send(Event::Finish);
            if thread.join().is_err() {
                return Err(self.stopped());
            }
        }
        self.check()
    }

    fn stopped(&self) -> RecordError {
        let path = self.path.display().to_string();
        RecordError::LogUnwritable { path, reason: "its writer stopped".to_owned() }
    }

    /// A writer that failed has said so in `failure`; nothing more can be sent to it then.
    fn send(&self, event: Event) {
        let _ = self.sender.send(event);
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        let _ = self.finish();
    }
}

/// Keeps the ticks of one navigator; costs it a few copies.
#[derive(Clone, Debug)]
pub struct Tap {
    sender: SyncSender<Event>,
    robot: usize,
    name: String,
    path: Vec<Point2>,
    waypoints: Vec<Point2>,
    map_due_s: f64,
    ticks: Option<u64>,
    time_s: f64,
}

impl Tap {
    /// Its number among the recorder's robots.
    pub fn robot(&self) -> usize {
        self.robot
    }

    /// The navigator's field as it is now, for [`Told::Goal`].
    pub fn field_source(&self) -> FieldSource {
        FieldSource { robot: self.name.clone(), tick: self.ticks }
    }

    /// The navigator was told something.
    pub fn told(&self, told: Told) {
        let _ = self.sender.send(Event::Told { robot: self.robot, time_s: self.time_s, told });
    }

    /// `navigator` has made `decision` of `input`.
    pub fn stepped(&mut self, input: &TickInput<'_>, navigator: &Navigator, decision: &Arc<Decision>) {
        let step = Step {
            ranges_m: input.ranges_m.to_vec(),
            wheels: input.wheels,
            gyro_radps: input.gyro_radps,
            dt_s: input.dt_s,
            world_from_robot: input.world_from_robot,
            decision: decision.clone(),
            path: changed(&mut self.path, navigator.path()),
            waypoints: changed(&mut self.waypoints, navigator.waypoints()),
            map: self.map_due(navigator, decision.time_s),
        };
        self.ticks = Some(decision.tick);
        self.time_s = decision.time_s;
        let _ = self.sender.send(Event::Step { robot: self.robot, step: Box::new(step) });
    }

    /// The last map, when all is over.
    pub fn end(&self, navigator: &Navigator) {
        let map = snapshot(navigator);
        let _ = self.sender.send(Event::Map { robot: self.robot, time_s: self.time_s, map });
    }

    fn map_due(&mut self, navigator: &Navigator, time_s: f64) -> Option<MapSnapshot> {
        if time_s < self.map_due_s {
            return None;
        }
        let map = snapshot(navigator);
        self.map_due_s = time_s + MAP_EVERY_S * (map.cells.len() as f64 / MAP_CELLS).max(1.0);
        Some(map)
    }
}

fn snapshot(navigator: &Navigator) -> MapSnapshot {
    let map = navigator.map();
    MapSnapshot { geometry: map.geometry(), cells: map.classes().to_vec() }
}

fn changed(known: &mut Vec<Point2>, now: &[Point2]) -> Option<Vec<Point2>> {
    (known.as_slice() != now).then(|| {
        known.clear();
        known.extend_from_slice(now);
        now.to_vec()
    })
}
