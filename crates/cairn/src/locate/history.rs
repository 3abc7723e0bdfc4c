//! The last readings, each with where it was taken seen from now: how well do they agree with a map,
//! all together, at a pose? Sets of poses forget places that look alike; this does not.

use std::collections::VecDeque;

use super::beams::{Poses, Scan, Tables, weigh};
use super::field::SurfaceField;
use super::matching::MapMatcher;
use super::scan::Explained;
use crate::geometry::{Pose2, wrap_angle};
use crate::robot::RobotProfile;

/// Readings kept, this far apart \[m\], \[rad\].
const FRAMES: usize = 24;
const EVERY_M: f64 = 0.25;
const EVERY_RAD: f64 = 0.3;
/// Places nearer to one another than this are one.
const APART_M: f64 = 0.6;
const APART_RAD: f64 = 0.5;

#[derive(Clone, Debug)]
struct Frame {
    begin_from_robot: Pose2,
    scan: Scan,
    /// As measured.
    ranges_m: Vec<f64>,
}

/// A pose, and how well all readings kept agree with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub pose: Pose2,
    /// Logarithm of the likelihood.
    pub score: f64,
    /// What the map explains there, once that was asked.
    pub explained: Explained,
}

impl Place {
    pub(super) fn is_near(&self, other: Pose2) -> bool {
        self.pose.position().distance(other.position()) < APART_M
            && wrap_angle(self.pose.heading - other.heading).abs() < APART_RAD
    }
}

/// Readings along the way, in a frame that begins at the first.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    frames: VecDeque<Frame>,
    now: Pose2,
    since_m: f64,
    since_rad: f64,
}

impl History {
    /// Poses that [`Self::refine`] weighs.
    pub(super) const REFINED_BY: usize = 3 * 2 * 27;

    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    pub(super) fn len(&self) -> usize {
        self.frames.len()
    }

    /// The robot has moved, `before_from_now`.
    pub(super) fn note(&mut self, before_from_now: Pose2) {
        self.now = self.now * before_from_now;
        self.since_m += before_from_now.x.hypot(before_from_now.y);
        self.since_rad += before_from_now.heading.abs();
    }

    pub(super) fn is_due(&self) -> bool {
        self.frames.is_empty() || self.since_m >= EVERY_M || self.since_rad >= EVERY_RAD
    }

    /// Keeps a reading taken now.
    pub(super) fn keep(&mut self, scan: Scan, ranges_m: &[f64]) {
        (self.since_m, self.since_rad) = (0.0, 0.0);
        if self.frames.len() == FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(Frame { begin_from_robot: self.now, scan, ranges_m: ranges_m.to_vec() });
    }

    /// Readings of frame `k` that can be used.
    pub(super) fn readings(&self, k: usize) -> usize {
        self.frames[k].scan.len()
    }

    /// Where the robot was when it took frame `k`, seen from where it was at frame `anchor`.
    pub(super) fn anchor_from(&self, anchor: usize, k: usize) -> Pose2 {
        self.frames[anchor].begin_from_robot.inverse() * self.frames[k].begin_from_robot
    }

    /// Where the robot is now, seen from where it was at frame `anchor`.
    pub(super) fn anchor_from_now(&self, anchor: usize) -> Pose2 {
        self.frames[anchor].begin_from_robot.inverse() * self.now
    }

    /// Adds to `sums` the logarithms of the likelihood of frame `k` where the robot was at `poses` then
    /// that it sees as `poses_from_then` now.
    pub(super) fn weigh(
        &self,
        k: usize,
        poses_from_then: Pose2,
        field: &SurfaceField,
        tables: &Tables,
        poses: &Poses,
        sums: &mut [f32],
    ) {
        let scan = &self.frames[k].scan;
        let (dx, dy) = (poses_from_then.x as f32, poses_from_then.y as f32);
        let mut then = Poses::default();
        for i in 0..poses.len() {
            let (sin, cos) = poses.heading[i].sin_cos();
            then.push(
                poses.x[i] + cos * dx - sin * dy,
                poses.y[i] + sin * dx + cos * dy,
                poses.heading[i] + poses_from_then.heading as f32,
            );
        }
        let mut logs = Vec::new();
        weigh(field, tables, scan, 0.0, &then, &mut logs);
        for (sum, log) in sums.iter_mut().zip(logs) {
            // A reading inside of things is as unlikely as one of nothing but strays, and no more: the
            // way there is known by odometry only.
            *sum += log.max(scan.len() as f32 * tables.stray());
        }
    }

    /// The best pose of now near `about`, and how well it agrees.
    pub(super) fn refine(&self, field: &SurfaceField, fine: &Tables, about: Pose2) -> Place {
        let mut best = Place { pose: about, score: f64::NEG_INFINITY, explained: Explained::default() };
        for (step_m, step_rad) in [(0.1, 0.09), (0.05, 0.045), (0.025, 0.022)] {
            for _ in 0..2 {
                let mut poses = Poses::default();
                for i in -1..=1 {
                    for j in -1..=1 {
                        for k in -1..=1 {
                            poses.push(
                                (best.pose.x + f64::from(i) * step_m) as f32,
                                (best.pose.y + f64::from(j) * step_m) as f32,
                                wrap_angle(best.pose.heading + f64::from(k) * step_rad) as f32,
                            );
                        }
                    }
                }
                let mut sums = vec![0.0; poses.len()];
                for k in 0..self.frames.len() {
                    let now_from_then = self.now.inverse() * self.frames[k].begin_from_robot;
                    self.weigh(k, now_from_then, field, fine, &poses, &mut sums);
                }
                for (i, &score) in sums.iter().enumerate() {
                    if f64::from(score) > best.score {
                        let (x, y) = (f64::from(poses.x[i]), f64::from(poses.y[i]));
                        let pose = Pose2::new(x, y, f64::from(poses.heading[i]));
                        best = Place { pose, score: f64::from(score), ..best };
                    }
                }
            }
        }
        best
    }

    /// How much of all readings the map explains for a robot that is at `world_from_now`.
    pub(super) fn explained(
        &self,
        matcher: &MapMatcher,
        profile: &RobotProfile,
        world_from_now: Pose2,
    ) -> Explained {
        let world_from_begin = world_from_now * self.now.inverse();
        self.frames.iter().fold(Explained::default(), |sum, frame| {
            sum + matcher.explained(world_from_begin * frame.begin_from_robot, profile, &frame.ranges_m)
        })
    }
}
