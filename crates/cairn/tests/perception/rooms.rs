//! Rooms of exact segments, sonars that miss smooth walls by incidence, and drives through them.

use cairn::geometry::{Point2, Pose2, Twist2};
use cairn::robot::{RobotProfile, Sonar};
use cairn::world::{Grid, GridGeometry, Occupancy, OccupancyGrid};

pub const TICK_S: f64 = 0.1;

pub fn p3at() -> RobotProfile {
    let text = include_str!("../../../../python/cairn/data/profiles/p3at.toml");
    let mut table: toml::Table = text.parse().expect("the shipped profile is TOML");
    table.retain(|key, _| {
        ["name", "footprint", "limits", "drive", "sonars", "lidar"]
            .iter()
            .any(|known| key.as_bytes() == known.as_bytes())
    });
    table.try_into().expect("the shipped profile is a profile")
}

/// splitmix64: the same numbers everywhere.
pub struct Noise(pub u64);

impl Noise {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

#[derive(Clone, Default)]
pub struct Rooms {
    pub walls: Vec<(Point2, Point2)>,
}

impl Rooms {
    pub fn wall(mut self, x0: f64, y0: f64, x1: f64, y1: f64) -> Self {
        self.walls.push((Point2::new(x0, y0), Point2::new(x1, y1)));
        self
    }

    /// A box (or a thick wall) by its corners.
    pub fn block(self, x0: f64, y0: f64, x1: f64, y1: f64) -> Self {
        self.wall(x0, y0, x1, y0).wall(x1, y0, x1, y1).wall(x1, y1, x0, y1).wall(x0, y1, x0, y0)
    }

    /// Range along one ray and whether it comes back.
    fn ray(&self, from: Point2, direction: f64) -> Option<(f64, bool)> {
        let u = Point2::new(direction.cos(), direction.sin());
        let mut best: Option<(f64, bool)> = None;
        for &(a, b) in &self.walls {
            let along = b - a;
            let det = u.cross(along);
            if det.abs() < 1e-12 {
                continue;
            }
            let t = (a - from).cross(along) / det;
            let s = (a - from).cross(u) / det;
            if t <= 0.0 || !(0.0..=1.0).contains(&s) || best.is_some_and(|(r, _)| r <= t) {
                continue;
            }
            let cos = det.abs() / along.norm();
            let to_end = s.min(1.0 - s) * along.norm();
            best = Some((t, cos >= 30f64.to_radians().cos() || to_end < 0.05));
        }
        best
    }

    /// Range along one beam; infinity when it meets nothing.
    pub fn beam(&self, from: Point2, direction: f64) -> f64 {
        self.ray(from, direction).map_or(f64::INFINITY, |(range_m, _)| range_m)
    }

    pub fn sonar(&self, world_from_sonar: Pose2, sonar: &Sonar) -> f64 {
        let mut range = f64::INFINITY;
        for k in 0..25 {
            let direction = world_from_sonar.heading + (f64::from(k) / 24.0 - 0.5) * sonar.beam_rad;
            if let Some((r, true)) = self.ray(world_from_sonar.position(), direction)
                && r < sonar.max_range_m
            {
                range = range.min(r.max(sonar.min_range_m));
            }
        }
        range
    }

    pub fn sense(&self, world_from_robot: Pose2, profile: &RobotProfile, noise: &mut Noise) -> Vec<f64> {
        profile
            .sonars
            .iter()
            .map(|sonar| self.sonar(world_from_robot * sonar.pose, sonar) * (1.0 + 0.01 * noise.normal()))
            .collect()
    }

    pub fn clearance(&self, p: Point2) -> f64 {
        self.walls.iter().map(|&(a, b)| p.distance_to_segment(a, b)).fold(f64::INFINITY, f64::min)
    }

    /// The map a surveyor would draw: cells a wall passes through are occupied, all others free.
    pub fn surveyed(&self, lo: Point2, hi: Point2, resolution_m: f64) -> OccupancyGrid {
        let geometry = GridGeometry {
            rows: ((hi.y - lo.y) / resolution_m).round() as usize,
            cols: ((hi.x - lo.x) / resolution_m).round() as usize,
            resolution_m,
            world_from_grid: Pose2::new(lo.x, lo.y, 0.0),
        };
        let mut grid = Grid::filled(geometry, Occupancy::Free);
        for &(a, b) in &self.walls {
            let steps = (a.distance(b) / resolution_m * 4.0).ceil() as usize;
            for k in 0..=steps {
                let p = a + (b - a) * (k as f64 / steps.max(1) as f64);
                if let Some(cell) = geometry.cell_at(p) {
                    let i = geometry.index(cell);
                    grid.values[i] = Occupancy::Occupied;
                }
            }
        }
        grid
    }
}

/// Poses at every tick of a drive along `corners`: straight at `speed_mps`, turns on the spot.
pub fn drive(corners: &[(f64, f64)], speed_mps: f64) -> Vec<Pose2> {
    let at = |k: usize| Point2::new(corners[k].0, corners[k].1);
    let mut pose = Pose2::new(corners[0].0, corners[0].1, (at(1) - at(0)).direction());
    let mut poses = vec![pose];
    for k in 1..corners.len() {
        loop {
            let off = pose.bearing_to(at(k));
            if off.abs() < 1e-9 {
                break;
            }
            pose = pose.moved(Twist2::new(0.0, off.clamp(-0.08, 0.08)), 1.0);
            poses.push(pose);
        }
        loop {
            let left = pose.position().distance(at(k));
            if left < 1e-6 {
                break;
            }
            pose = pose.moved(Twist2::new(left.min(speed_mps * TICK_S), 0.0), 1.0);
            if left <= speed_mps * TICK_S {
                pose = Pose2::new(at(k).x, at(k).y, pose.heading);
            }
            poses.push(pose);
            if left <= speed_mps * TICK_S {
                break;
            }
        }
    }
    poses
}
