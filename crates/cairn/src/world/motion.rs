//! Things that move, seen from scan to scan: round clusters of returns, followed.

use serde::{Deserialize, Serialize};

use super::LocalMap;
use crate::geometry::{Point2, Pose2};
use crate::robot::Bound;

/// What counts as a thing, and when it moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotionConfig {
    /// Neighbouring returns farther apart than this belong to different things \[m\].
    pub gap_m: f64,
    /// Wider clusters are walls \[m\].
    pub widest_m: f64,
    /// Fewer returns say nothing of a shape.
    pub least_returns: usize,
    /// A cluster this near to where a thing is expected is that thing \[m\].
    pub gate_m: f64,
    /// How fast the estimates of place and velocity follow what is seen, 0 to 1.
    pub follow: f64,
    /// Slower than this nothing moves \[m/s\].
    pub least_mps: f64,
    /// Seen at least this often before it counts as moving.
    pub least_scans: u32,
    /// Moved at least this far since it was first seen \[m\].
    pub least_way_m: f64,
    /// On the map its surface is never older than this \[s\].
    pub fresh_s: f64,
    /// Out of sight it is believed in for so long \[s\].
    pub memory_s: f64,
    /// Farther things are left alone \[m\].
    pub reach_m: f64,
}

impl Default for MotionConfig {
    fn default() -> Self {
        Self {
            gap_m: 0.3,
            widest_m: 1.6,
            least_returns: 4,
            gate_m: 0.6,
            follow: 0.45,
            least_mps: 0.2,
            least_scans: 4,
            least_way_m: 0.12,
            fresh_s: 0.45,
            memory_s: 1.0,
            reach_m: 12.0,
        }
    }
}

impl MotionConfig {
    /// Every setting with its least and greatest usable value.
    pub(crate) fn bounds(&self) -> [Bound; 11] {
        [
            ("gap_m", self.gap_m, 1e-3, 100.0),
            ("widest_m", self.widest_m, 1e-3, 100.0),
            ("least_returns", self.least_returns as f64, 1.0, 1e6),
            ("gate_m", self.gate_m, 1e-3, 100.0),
            ("follow", self.follow, 0.0, 1.0),
            ("least_mps", self.least_mps, 0.0, 100.0),
            ("least_scans", f64::from(self.least_scans), 1.0, 1e6),
            ("least_way_m", self.least_way_m, 0.0, 100.0),
            ("fresh_s", self.fresh_s, 0.0, 1e3),
            ("memory_s", self.memory_s, 0.0, 1e3),
            ("reach_m", self.reach_m, 0.0, 1e4),
        ]
    }
}

/// A thing followed from scan to scan, in the frame of the odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followed {
    /// Where its centre is believed to be \[m\].
    pub center: Point2,
    /// How fast it moves \[m/s\].
    pub velocity_mps: Point2,
    /// Radius of its disc \[m\].
    pub radius_m: f64,
    /// It moves.
    pub moves: bool,
    first: Point2,
    scans: u32,
    unseen_s: f64,
    fresh: f64,
}

/// Follows what moves.
#[derive(Clone, Debug)]
pub struct MotionWatch {
    config: MotionConfig,
    things: Vec<Followed>,
}

/// One run of neighbouring returns.
struct Cluster {
    center: Point2,
    radius_m: f64,
    /// Share of its returns that fall where nothing was a while ago.
    fresh: f64,
}

impl MotionWatch {
    /// With nothing followed.
    pub fn new(config: &MotionConfig) -> Self {
        Self { config: *config, things: Vec::new() }
    }

    /// Everything that moves.
    pub fn moving(&self) -> impl Iterator<Item = &Followed> + '_ {
        self.things.iter().filter(|thing| thing.moves)
    }

    /// Which returns, placed by `world_from_robot`, come from something that moves, `ahead_s` after
    /// the last scan.
    pub fn of_moving(&self, world_from_robot: Pose2, ends: &[Option<Point2>], ahead_s: f64) -> Vec<bool> {
        let expected: Vec<(Point2, f64)> = self
            .moving()
            .map(|thing| (thing.center + thing.velocity_mps * ahead_s, thing.radius_m + 0.2))
            .collect();
        let robot_from_world = world_from_robot.inverse();
        let expected: Vec<(Point2, f64)> =
            expected.into_iter().map(|(center, radius)| (robot_from_world * center, radius)).collect();
        ends.iter()
            .map(|end| end.is_some_and(|p| expected.iter().any(|&(c, r)| (p - c).dot(p - c) < r * r)))
            .collect()
    }

    /// Follows every thing into one more scan, taken at `world_from_robot`, `dt_s` after the last one.
    /// `map` holds what was seen before.
    pub fn step(&mut self, world_from_robot: Pose2, ends: &[Option<Point2>], map: &LocalMap, dt_s: f64) {
        let config = self.config;
        let fresh_scans = (config.fresh_s / dt_s).ceil() as u32;
        let clusters = self.clusters(world_from_robot, ends, map, fresh_scans);
        for thing in &mut self.things {
            thing.center = thing.center + thing.velocity_mps * dt_s;
            thing.unseen_s += dt_s;
        }
        let mut taken = vec![false; self.things.len()];
        for cluster in clusters {
            let nearest = self
                .things
                .iter()
                .enumerate()
                .filter(|&(i, _)| !taken[i])
                .map(|(i, thing)| (thing.center.distance(cluster.center), i))
                .filter(|&(distance_m, i)| distance_m < config.gate_m + self.things[i].unseen_s)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match nearest {
                Some((_, i)) => {
                    taken[i] = true;
                    self.things[i].seen(&cluster, &config, dt_s);
                }
                None => {
                    taken.push(true);
                    self.things.push(Followed {
                        center: cluster.center,
                        velocity_mps: Point2::default(),
                        radius_m: cluster.radius_m,
                        moves: false,
                        first: cluster.center,
                        scans: 1,
                        unseen_s: 0.0,
                        fresh: cluster.fresh,
                    });
                }
            }
        }
        self.things.retain(|thing| {
            let memory_s = if thing.moves { config.memory_s } else { 3.0 * dt_s };
            thing.unseen_s <= memory_s
        });
    }

    fn clusters(
        &self,
        world_from_robot: Pose2,
        ends: &[Option<Point2>],
        map: &LocalMap,
        fresh_scans: u32,
    ) -> Vec<Cluster> {
        let config = &self.config;
        let mut clusters = Vec::new();
        let mut run: Vec<Point2> = Vec::new();
        let mut close = |run: &mut Vec<Point2>| {
            let points = std::mem::take(run);
            let wide = match (points.first(), points.last()) {
                (Some(a), Some(b)) => a.distance(*b) > config.widest_m,
                _ => true,
            };
            if points.len() < config.least_returns || wide {
                return;
            }
            let Some((center, radius_m)) = disc_of(&points) else { return };
            let fresh = points.iter().filter(|&&p| map.age_at(world_from_robot * p) <= fresh_scans).count();
            clusters.push(Cluster {
                center: world_from_robot * center,
                radius_m,
                fresh: fresh as f64 / points.len() as f64,
            });
        };
        for end in ends {
            let near = end.filter(|p| p.dot(*p) < config.reach_m * config.reach_m);
            let joins = match (near, run.last()) {
                (Some(point), Some(last)) => point.distance(*last) < config.gap_m,
                (Some(_), None) => true,
                (None, _) => false,
            };
            if !joins {
                close(&mut run);
            }
            run.extend(near);
        }
        close(&mut run);
        clusters
    }
}

impl Followed {
    fn seen(&mut self, cluster: &Cluster, config: &MotionConfig, dt_s: f64) {
        self.scans += 1;
        self.unseen_s = 0.0;
        // Fast at first, then as configured: the optimal gains of the first scans are greater.
        let share = (2.0 / f64::from(self.scans)).max(config.follow).min(1.0);
        let off = cluster.center - self.center;
        self.center = self.center + off * share;
        self.velocity_mps = self.velocity_mps + off * (share * share / (2.0 - share) / dt_s);
        self.radius_m += (cluster.radius_m - self.radius_m) * 0.2;
        self.fresh += (cluster.fresh - self.fresh) * 0.3;
        let way_m = self.center.distance(self.first);
        let fast = self.velocity_mps.norm() >= config.least_mps;
        let begins = self.scans >= config.least_scans && way_m >= config.least_way_m && self.fresh > 0.75;
        self.moves = fast && (begins || (self.moves && self.fresh > 0.4));
    }
}

/// The disc whose edge the points lie on: least squares `[Kasa76]`; where they do not, None.
fn disc_of(points: &[Point2]) -> Option<(Point2, f64)> {
    let n = points.len() as f64;
    let mean = points.iter().fold(Point2::default(), |sum, &p| sum + p) * (1.0 / n);
    let (mut xx, mut xy, mut yy, mut xz, mut yz) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for &p in points {
        let Point2 { x, y } = p - mean;
        let z = x * x + y * y;
        (xx, xy, yy, xz, yz) = (xx + x * x, xy + x * y, yy + y * y, xz + x * z, yz + y * z);
    }
    let determinant = xx * yy - xy * xy;
    if determinant <= 1e-12 {
        return None;
    }
    let a = (xz * yy - yz * xy) / (2.0 * determinant);
    let b = (yz * xx - xz * xy) / (2.0 * determinant);
    let radius_m = (a * a + b * b + (xx + yy) / n).sqrt();
    let center = mean + Point2::new(a, b);
    // The robot looks at the near side of a disc of a size that things have.
    let near_side = center.norm() > mean.norm();
    let off = points.iter().map(|p| (p.distance(center) - radius_m).powi(2)).sum::<f64>() / n;
    (near_side && (0.05..=1.0).contains(&radius_m) && off.sqrt() < 0.02).then_some((center, radius_m))
}
