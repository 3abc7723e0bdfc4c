//! What a lidar has seen around the robot and not seen through again: points, no walls, no prior.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::geometry::{Point2, Pose2};
use crate::robot::{Bound, Lidar};

/// How long a point stays on a [`LocalMap`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LocalMapConfig {
    /// Side of a cell; each holds one point, the mean of the returns in it \[m\].
    pub resolution_m: f64,
    /// Points farther than this from the robot are forgotten \[m\].
    pub reach_m: f64,
    /// A beam that ends at least this far behind a point has looked through it \[m\].
    pub through_m: f64,
    /// Beams farther off than this say nothing of what they look through \[m\].
    pub clear_range_m: f64,
    /// Scans that must look through a point in a row, less those that hit it, before it is gone.
    pub persistence: u8,
}

impl Default for LocalMapConfig {
    fn default() -> Self {
        Self { resolution_m: 0.05, reach_m: 12.0, through_m: 0.12, clear_range_m: 10.0, persistence: 6 }
    }
}

impl LocalMapConfig {
    /// Every setting with its least and greatest usable value.
    pub(crate) fn bounds(&self) -> [Bound; 5] {
        let cell_m = self.resolution_m;
        [
            ("resolution_m", cell_m, 0.005, 1.0),
            ("reach_m", self.reach_m, 8.0 * cell_m, 2000.0 * cell_m),
            ("through_m", self.through_m, 0.0, 100.0),
            ("clear_range_m", self.clear_range_m, 0.0, 1e4),
            ("persistence", f64::from(self.persistence), 1.0, 255.0),
        ]
    }
}

/// One cell: the mean of the returns in it.
#[derive(Clone, Copy, Debug)]
struct Slot {
    /// Which cell of the endless grid it stands for now.
    col: i32,
    row: i32,
    x: f32,
    y: f32,
    returns: u16,
    strength: u8,
    /// Number of the last scan that hit it.
    scan: u32,
    /// Number of the first.
    born: u32,
}

/// Nothing is in a slot of no strength, whatever it says.
const EMPTY: Slot = Slot { col: i32::MIN, row: 0, x: 0.0, y: 0.0, returns: 0, strength: 0, scan: 0, born: 0 };

/// A mean of more returns than this moves no slower.
const MOST_RETURNS: u16 = 24;

/// Directions of a lidar's beams in the robot frame.
#[derive(Clone, Debug)]
pub struct Beams {
    lidar: Lidar,
    directions: Vec<Point2>,
}

impl Beams {
    /// Of this lidar.
    pub fn new(lidar: &Lidar) -> Self {
        let direction = |beam: usize| {
            let angle = lidar.pose.heading + lidar.first_rad + beam as f64 * lidar.step_rad;
            Point2::new(angle.cos(), angle.sin())
        };
        Self { lidar: *lidar, directions: (0..lidar.beams).map(direction).collect() }
    }

    /// Where each beam ended, robot frame \[m\]; None without a return.
    pub fn ends(&self, ranges_m: &[f64]) -> Vec<Option<Point2>> {
        let from = self.lidar.pose.position();
        let within = self.lidar.min_range_m..self.lidar.max_range_m;
        self.directions
            .iter()
            .zip(ranges_m)
            .map(|(&direction, range)| within.contains(range).then(|| from + direction * *range))
            .collect()
    }

    /// Some beam looks at `point_in_robot`.
    pub fn looks_at(&self, point_in_robot: Point2) -> bool {
        self.beam_to(point_in_robot).0.is_some()
    }

    /// The beam that looks at `point_in_robot`, if one does, and the point's range \[m\].
    fn beam_to(&self, point_in_robot: Point2) -> (Option<usize>, f64) {
        let seen = self.lidar.pose.inverse() * point_in_robot;
        let Lidar { first_rad, step_rad, beams, .. } = self.lidar;
        // Once around from half a step before the first beam, in the direction in which they follow.
        let around_rad = step_rad.signum() * (seen.y.atan2(seen.x) - first_rad) + step_rad.abs() / 2.0;
        let beam = (around_rad.rem_euclid(TAU) / step_rad.abs()).floor();
        let inside = beam >= 0.0 && beam < beams as f64;
        (inside.then_some(beam as usize), seen.norm())
    }
}

/// Points around the robot in the frame of its odometry, at most one in a cell.
///
/// The grid is a torus that rolls with the robot: nothing is copied. A point appears with its first
/// return and disappears once beams have looked through it; where no beam looks (behind the robot,
/// behind other things) it stays.
#[derive(Clone, Debug)]
pub struct LocalMap {
    config: LocalMapConfig,
    slots: Vec<Slot>,
    /// Slots in use, oldest first.
    used: Vec<u32>,
    side: i32,
    scan: u32,
}

impl LocalMap {
    /// With nothing on it.
    pub fn new(config: &LocalMapConfig) -> Self {
        let cells = (2.0 * config.reach_m / config.resolution_m).ceil().clamp(16.0, 4096.0) as usize;
        let side = (cells + 2).next_power_of_two();
        Self {
            config: *config,
            slots: vec![EMPTY; side * side],
            used: Vec::new(),
            side: side as i32,
            scan: 0,
        }
    }

    /// Its settings.
    pub fn config(&self) -> &LocalMapConfig {
        &self.config
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.used.len()
    }

    /// Nothing was seen.
    pub fn is_empty(&self) -> bool {
        self.used.is_empty()
    }

    /// Every point, in the frame of the odometry \[m\].
    pub fn points(&self) -> impl Iterator<Item = Point2> + '_ {
        self.used.iter().map(|&i| point_of(&self.slots[i as usize]))
    }

    fn cell_of(&self, point: Point2) -> (i32, i32) {
        let cell = |metres: f64| (metres / self.config.resolution_m).floor() as i32;
        (cell(point.x), cell(point.y))
    }

    fn index(&self, (col, row): (i32, i32)) -> usize {
        let mask = self.side - 1;
        ((row & mask) * self.side + (col & mask)) as usize
    }

    /// The point nearest to `point` among those of its cell and the eight around \[m\].
    pub fn nearest(&self, point: Point2) -> Option<Point2> {
        let (col, row) = self.cell_of(point);
        let mut best: Option<(f64, Point2)> = None;
        for r in row.saturating_sub(1)..=row.saturating_add(1) {
            for c in col.saturating_sub(1)..=col.saturating_add(1) {
                let slot = &self.slots[self.index((c, r))];
                if slot.strength == 0 || slot.col != c || slot.row != r {
                    continue;
                }
                let held = point_of(slot);
                let offset = held - point;
                let squared = offset.dot(offset);
                if best.is_none_or(|(least, _)| squared < least) {
                    best = Some((squared, held));
                }
            }
        }
        best.map(|(_, held)| held)
    }

    /// For how many scans something has been in the cell of `point`; 0 where nothing is.
    pub fn age_at(&self, point: Point2) -> u32 {
        let (col, row) = self.cell_of(point);
        let slot = &self.slots[self.index((col, row))];
        let held = slot.strength > 0 && slot.col == col && slot.row == row;
        if held { self.scan.saturating_sub(slot.born) } else { 0 }
    }

    /// Adds one scan taken at `world_from_robot`; `ends` are [`Beams::ends`] of `ranges_m`. Returns
    /// that `skip` names (by beam) are not put on the map, and still look through what is there.
    pub fn integrate(
        &mut self,
        world_from_robot: Pose2,
        beams: &Beams,
        ranges_m: &[f64],
        ends: &[Option<Point2>],
        skip: impl Fn(usize) -> bool,
    ) {
        self.scan += 1;
        let reach = self.config.reach_m - 2.0 * self.config.resolution_m;
        for (beam, end) in ends.iter().enumerate() {
            if let Some(point_in_robot) = *end
                && point_in_robot.dot(point_in_robot) < reach * reach
                && !skip(beam)
            {
                self.hit(world_from_robot * point_in_robot);
            }
        }
        self.look_through(world_from_robot, beams, ranges_m);
    }

    fn hit(&mut self, point: Point2) {
        let (col, row) = self.cell_of(point);
        let index = self.index((col, row));
        let scan = self.scan;
        let slot = &mut self.slots[index];
        if slot.strength == 0 || slot.col != col || slot.row != row {
            if slot.strength == 0 {
                self.used.push(index as u32);
            }
            *slot = Slot {
                col,
                row,
                x: point.x as f32,
                y: point.y as f32,
                returns: 1,
                strength: 1,
                scan,
                born: scan,
            };
            return;
        }
        slot.returns = (slot.returns + 1).min(MOST_RETURNS);
        let share = 1.0 / f32::from(slot.returns);
        slot.x += (point.x as f32 - slot.x) * share;
        slot.y += (point.y as f32 - slot.y) * share;
        if slot.scan != scan {
            slot.strength = slot.strength.saturating_add(1).min(self.config.persistence.max(1));
            slot.scan = scan;
        }
    }

    /// Weakens every point that this scan looked through, and forgets what is far away.
    fn look_through(&mut self, world_from_robot: Pose2, beams: &Beams, ranges_m: &[f64]) {
        let robot_from_world = world_from_robot.inverse();
        let LocalMapConfig { reach_m, through_m, clear_range_m, .. } = self.config;
        let (slots, scan) = (&mut self.slots, self.scan);
        self.used.retain(|&i| {
            let slot = &mut slots[i as usize];
            if slot.scan == scan {
                return true;
            }
            let seen = robot_from_world * point_of(slot);
            if seen.x.abs() > reach_m || seen.y.abs() > reach_m {
                slot.strength = 0;
                return false;
            }
            let (Some(beam), range_m) = beams.beam_to(seen) else { return true };
            if range_m > clear_range_m {
                return true;
            }
            // The beams beside it must look through as well: no corner is lost by a grazing one.
            let (from, to) = (beam.saturating_sub(1), (beam + 2).min(ranges_m.len()));
            let through = ranges_m[from..to].iter().all(|&r| r > range_m + through_m);
            if through {
                slot.strength -= 1;
            }
            slot.strength > 0
        });
    }

    /// Forgets everything within `holds`.
    pub fn forget(&mut self, holds: impl Fn(Point2) -> bool) {
        let slots = &mut self.slots;
        self.used.retain(|&i| {
            let slot = &mut slots[i as usize];
            if holds(point_of(slot)) {
                slot.strength = 0;
            }
            slot.strength > 0
        });
    }
}

fn point_of(slot: &Slot) -> Point2 {
    Point2::new(f64::from(slot.x), f64::from(slot.y))
}
