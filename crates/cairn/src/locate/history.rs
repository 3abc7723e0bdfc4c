//! The last readings, each with where it was taken seen from now: how well do they agree with a map,
//! all together, at this pose and at every other? Sets of poses forget places that look alike; this
//! does not.

use std::collections::VecDeque;

use super::beams::{Hearing, Poses, Scan, Tables, weigh};
use super::field::SurfaceField;
use crate::geometry::{Pose2, wrap_angle};

/// Readings kept, this far apart \[m\], \[rad\].
const FRAMES: usize = 24;
const EVERY_M: f64 = 0.25;
const EVERY_RAD: f64 = 0.3;
/// Poses of the lattice that are looked at by more than one reading.
const KEPT: usize = 20_000;
/// Places told apart and looked at closely.
const PLACES: usize = 8;
const APART_M: f64 = 0.6;
const APART_RAD: f64 = 0.5;

#[derive(Clone, Debug)]
struct Frame {
    begin_from_robot: Pose2,
    scan: Scan,
}

/// A pose in the map's frame, and how well all readings kept agree with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub pose: Pose2,
    /// Logarithm of the likelihood.
    pub score: f64,
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
    pub(super) fn clear(&mut self) {
        *self = Self::default();
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
    pub(super) fn keep(&mut self, scan: Scan) {
        (self.since_m, self.since_rad) = (0.0, 0.0);
        if self.frames.len() == FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(Frame { begin_from_robot: self.now, scan });
    }

    /// Adds the logarithms of the likelihood of frame `k` to `sums`.
    fn weigh(&self, k: usize, field: &SurfaceField, tables: &Tables, poses: &Poses, sums: &mut [f32]) {
        let frame = &self.frames[k];
        let now_from_then = self.now.inverse() * frame.begin_from_robot;
        let (dx, dy) = (now_from_then.x as f32, now_from_then.y as f32);
        let mut then = Poses::default();
        for i in 0..poses.len() {
            let (sin, cos) = poses.heading[i].sin_cos();
            then.push(
                poses.x[i] + cos * dx - sin * dy,
                poses.y[i] + sin * dx + cos * dy,
                poses.heading[i] + now_from_then.heading as f32,
            );
        }
        let mut logs = Vec::new();
        weigh(field, tables, &frame.scan, 0.0, &then, &mut logs);
        for (sum, log) in sums.iter_mut().zip(logs) {
            // A reading inside of things is as unlikely as one of nothing but strays, and no more: the
            // way there is known by odometry only.
            *sum += log.max(frame.scan.len() as f32 * tables.stray());
        }
    }

    /// The best pose near `about`, and how well it agrees.
    pub(super) fn refine(&self, field: &SurfaceField, fine: &Tables, about: Pose2) -> Place {
        let mut best = Place { pose: about, score: f64::NEG_INFINITY };
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
                    self.weigh(k, field, fine, &poses, &mut sums);
                }
                for (i, &score) in sums.iter().enumerate() {
                    if f64::from(score) > best.score {
                        let (x, y) = (f64::from(poses.x[i]), f64::from(poses.y[i]));
                        let pose = Pose2::new(x, y, f64::from(poses.heading[i]));
                        best = Place { pose, score: f64::from(score) };
                    }
                }
            }
        }
        best
    }

    /// The places of the whole lattice that agree best with all readings, best first.
    pub(super) fn survey(
        &self,
        field: &SurfaceField,
        hearing: &Hearing,
        fine: &Tables,
        lattice: &Poses,
        (pitch_m, turn_rad): (f64, f64),
    ) -> Vec<Place> {
        let Some(richest) = (0..self.frames.len()).max_by_key(|&k| self.frames[k].scan.len()) else {
            return Vec::new();
        };
        let tables = |k: usize| {
            let lever_m = (self.now.inverse() * self.frames[k].begin_from_robot).position().norm();
            Tables::new(hearing, (0.4 * pitch_m).hypot(0.3 * turn_rad * lever_m), 0.3 * turn_rad)
        };
        let mut sums = vec![0.0; lattice.len()];
        self.weigh(richest, field, &tables(richest), lattice, &mut sums);
        let mut order: Vec<u32> = (0..lattice.len() as u32).collect();
        let by_sum =
            |sums: &[f32], a: u32, b: u32| sums[b as usize].total_cmp(&sums[a as usize]).then(a.cmp(&b));
        if order.len() > KEPT {
            order.select_nth_unstable_by(KEPT, |&a, &b| by_sum(&sums, a, b));
            order.truncate(KEPT);
            order.sort_unstable();
        }
        let mut kept = Poses::default();
        let mut sums: Vec<f32> = order
            .iter()
            .map(|&i| {
                let i = i as usize;
                kept.push(lattice.x[i], lattice.y[i], lattice.heading[i]);
                sums[i]
            })
            .collect();
        for k in (0..self.frames.len()).filter(|&k| k != richest) {
            self.weigh(k, field, &tables(k), &kept, &mut sums);
        }
        let mut order: Vec<u32> = (0..kept.len() as u32).collect();
        order.sort_unstable_by(|&a, &b| by_sum(&sums, a, b));
        let mut places: Vec<Place> = Vec::new();
        for i in order.into_iter().map(|i| i as usize) {
            let (x, y) = (f64::from(kept.x[i]), f64::from(kept.y[i]));
            let pose = Pose2::new(x, y, f64::from(kept.heading[i]));
            if places.iter().all(|place| !place.is_near(pose)) {
                places.push(Place { pose, score: f64::from(sums[i]) });
            }
            if places.len() == PLACES {
                break;
            }
        }
        let mut places: Vec<Place> =
            places.iter().map(|place| self.refine(field, fine, place.pose)).collect();
        places.sort_by(|a, b| b.score.total_cmp(&a.score));
        places
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::Pose2;
    use crate::locate::history::History;
    use crate::locate::{MonteCarlo, MonteCarloConfig};
    use crate::robot::{Drive, Footprint, Limits, RobotProfile, Sonar};
    use crate::world::{Grid, GridGeometry, Occupancy, OccupancyGrid, raycast};

    fn robot() -> RobotProfile {
        let sonar = |k: i32| Sonar {
            pose: Pose2::new(0.0, 0.0, f64::from(k) * std::f64::consts::FRAC_PI_8),
            beam_rad: 0.05,
            min_range_m: 0.1,
            max_range_m: 5.0,
        };
        RobotProfile {
            name: "test".to_owned(),
            footprint: Footprint { length_m: 0.4, width_m: 0.4 },
            limits: Limits { linear_mps: 0.5, angular_radps: 1.0, linear_mps2: 0.5, angular_radps2: 1.0 },
            drive: Drive { effective_track_m: 0.4, latency_s: 0.0 },
            sonars: (0..16).map(sonar).collect(),
            lidar: None,
        }
    }

    /// A room of 6 × 4 m; with a cupboard it looks different from every pose.
    fn room(cupboard: bool) -> OccupancyGrid {
        let geometry =
            GridGeometry { rows: 80, cols: 120, resolution_m: 0.05, world_from_grid: Pose2::IDENTITY };
        let stands = |i: usize| {
            let (row, col) = (i / 120, i % 120);
            let wall = !(2..78).contains(&row) || !(2..118).contains(&col);
            wall || cupboard && row < 20 && (60..80).contains(&col)
        };
        let cells =
            (0..geometry.len()).map(|i| if stands(i) { Occupancy::Occupied } else { Occupancy::Free });
        Grid::new(geometry, cells.collect())
    }

    /// How far the truth is ahead of the best other place after a short drive.
    fn lead(cupboard: bool) -> f64 {
        let (robot, map) = (robot(), room(cupboard));
        let occupied =
            Grid::new(map.geometry, map.values.iter().map(|c| *c == Occupancy::Occupied).collect());
        let mut poses = MonteCarlo::new(&MonteCarloConfig::default(), &robot, &map, 1).unwrap();
        let (mut truth, step) = (Pose2::new(1.2, 2.6, -0.2), Pose2::new(0.15, 0.0, 0.05));
        let mut history = History::default();
        for _ in 0..16 {
            let ranges: Vec<f64> = robot
                .sonars
                .iter()
                .map(|sonar| {
                    let from = truth * sonar.pose;
                    raycast(&occupied, from.position(), from.heading, 5.0).unwrap_or(f64::INFINITY)
                })
                .collect();
            if history.is_due() {
                history.keep(poses.scan(&ranges));
            }
            truth = truth * step;
            history.note(step);
        }
        poses.spread(truth, 0.02, 0.01).unwrap();
        poses.compare(&history, f64::NEG_INFINITY).unwrap().unwrap()
    }

    #[test]
    fn the_truth_leads_where_every_place_looks_different_and_nothing_does_in_a_symmetric_room() {
        assert!(lead(true) > 4.0, "{}", lead(true));
        assert!(lead(false).abs() < 2.0, "{}", lead(false));
    }
}
