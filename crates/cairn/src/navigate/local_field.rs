//! The cost-to-go field of what a lidar sees now, solved anew whenever asked: seconds to the goal.

use serde::{Deserialize, Serialize};

use super::error::NavigateError;
use crate::avoid::Guide;
use crate::geometry::{Point2, Pose2};
use crate::plan::{Field, GridPlanner, PlanOptions, Values};
use crate::robot::{Bound, Footprint, outside};
use crate::world::{Cell, GridGeometry};

/// What a metre costs near the points of a local map, and how far the field reaches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LocalFieldConfig {
    /// The robot's centre keeps this plus the inscribed radius from every point \[m\].
    pub clearance_m: f64,
    /// From there to full speed \[m\].
    pub comfort_m: f64,
    /// Speed where the robot nearly touches \[m/s\].
    pub near_mps: f64,
    /// Speed where nothing is near \[m/s\].
    pub open_mps: f64,
    /// How far around robot and goal the field reaches at first \[m\]; doubled while no way is found.
    pub margin_m: f64,
    /// A goal farther than this is headed for at this distance \[m\].
    pub reach_m: f64,
    /// What a metre costs where the centre must not be, when no way is left otherwise \[s/m\].
    pub desperate_s_per_m: f64,
}

impl Default for LocalFieldConfig {
    fn default() -> Self {
        Self {
            clearance_m: 0.04,
            comfort_m: 0.35,
            near_mps: 0.35,
            open_mps: 1.6,
            margin_m: 3.0,
            reach_m: 11.0,
            desperate_s_per_m: 30.0,
        }
    }
}

impl LocalFieldConfig {
    /// Checks every number, for a field over points in cells of `cell_m`.
    ///
    /// # Errors
    /// [`NavigateError::NavigatorValueOutOfRange`] names the first that is not usable.
    pub fn checked(&self, cell_m: f64) -> Result<(), NavigateError> {
        match outside(self.bounds(cell_m)) {
            Some((key, value, least, most)) => {
                let key = format!("lidar.field.{key}");
                Err(NavigateError::NavigatorValueOutOfRange { key, value, least, most })
            }
            None => Ok(()),
        }
    }

    /// Every setting with its least and greatest usable value, over points in cells of `cell_m`.
    fn bounds(&self, cell_m: f64) -> [Bound; 7] {
        [
            ("clearance_m", self.clearance_m, 0.0, 100.0 * cell_m),
            ("comfort_m", self.comfort_m, 1e-3, 200.0 * cell_m),
            ("near_mps", self.near_mps, 1e-3, 100.0),
            ("open_mps", self.open_mps, self.near_mps, 100.0),
            ("margin_m", self.margin_m, cell_m, 1000.0 * cell_m),
            ("reach_m", self.reach_m, cell_m, 4000.0 * cell_m),
            ("desperate_s_per_m", self.desperate_s_per_m, 1e-3, 1e6),
        ]
    }
}

/// Points of the way down the field that others may see straight.
const LOOKOUTS_M: [f64; 4] = [0.6, 1.2, 2.0, 3.0];
/// A straight look is priced this often \[m\].
const LOOK_STEP_M: f64 = 0.1;
/// Cells down the pointers that tell a direction.
const DOWN: usize = 6;

/// A field around robot and goal in the frame of the odometry.
#[derive(Debug, Default)]
pub struct LocalField {
    config: LocalFieldConfig,
    planner: GridPlanner,
    field: Option<Field>,
    costs: Vec<f32>,
    near: Vec<u8>,
    desperate: bool,
    lookouts: Vec<(Point2, f64)>,
}

impl Clone for LocalField {
    /// The same settings, with nothing solved yet.
    fn clone(&self) -> Self {
        Self::new(&self.config)
    }
}

/// How a distance becomes a price.
struct Kernel {
    /// Half the side of the square of cells that a point bears on.
    half: usize,
    /// For every cell of the square: 255 where the centre must not be, less with distance, 0 beyond.
    levels: Vec<u8>,
    /// Price of every level \[s/m\].
    prices: [f32; 256],
}

impl LocalField {
    /// With nothing solved.
    pub fn new(config: &LocalFieldConfig) -> Self {
        Self { config: *config, ..Self::default() }
    }

    /// Solves the field for `goal` on `points`, seen from `robot`; all in one frame \[m\], in cells of
    /// `resolution_m`. False if there is no way even through what must not be.
    pub fn solve(
        &mut self,
        points: &[Point2],
        resolution_m: f64,
        footprint: &Footprint,
        robot: Point2,
        goal: Point2,
    ) -> bool {
        let kernel = self.kernel(footprint, resolution_m);
        let away = goal - robot;
        let distance_m = away.norm();
        let goal = if distance_m > self.config.reach_m {
            robot + away * (self.config.reach_m / distance_m)
        } else {
            goal
        };
        let options = PlanOptions { threads: Some(1), ..PlanOptions::default() };
        for (widening, desperate) in [(1.0, false), (2.0, false), (1.0, true)] {
            let geometry = around(robot, goal, self.config.margin_m * widening, resolution_m);
            self.price(points, &geometry, &kernel, desperate);
            let Some(target) = nearest_open(&geometry, &self.costs, goal) else { continue };
            if let Some(field) = self.field.take() {
                self.planner.recycle(field);
            }
            let costs = self.planner.copied_f32(geometry, &self.costs);
            let Ok(field) = self.planner.plan_costs_f32(costs, &[target], &options) else {
                continue;
            };
            let reached = nearest_open(&geometry, &self.costs, robot).is_some_and(|c| field.is_reachable(c));
            self.field = Some(field);
            self.desperate = desperate;
            if reached {
                self.look_out(robot);
                return true;
            }
        }
        false
    }

    /// The field.
    pub fn field(&self) -> Option<&Field> {
        self.field.as_ref()
    }

    /// The way leads through what must not be, because no other was left.
    pub fn is_desperate(&self) -> bool {
        self.desperate
    }

    /// The points of the way that are headed for straight, nearest first.
    pub fn lookouts(&self) -> impl Iterator<Item = Point2> + '_ {
        self.lookouts.iter().map(|&(point, _)| point)
    }

    fn kernel(&self, footprint: &Footprint, resolution_m: f64) -> Kernel {
        let LocalFieldConfig { clearance_m, comfort_m, near_mps, open_mps, .. } = self.config;
        let blocked_m = footprint.inscribed_radius_m() + clearance_m;
        let far_m = blocked_m + comfort_m;
        let half = (far_m / resolution_m).ceil() as usize;
        let side = 2 * half + 1;
        let level = |i: usize| {
            let across = |k: usize| (k as f64 - half as f64) * resolution_m;
            let distance_m = across(i / side).hypot(across(i % side));
            let closeness = 1.0 - (distance_m - blocked_m) / comfort_m;
            if distance_m <= blocked_m { 255 } else { (closeness.clamp(0.0, 1.0) * 254.0) as u8 }
        };
        let levels = (0..side * side).map(level).collect();
        let mut prices = [f32::INFINITY; 256];
        for (level, price) in prices.iter_mut().enumerate().take(255) {
            let speed = open_mps + (near_mps - open_mps) * level as f64 / 254.0;
            *price = (1.0 / speed) as f32;
        }
        Kernel { half, levels, prices }
    }

    /// Prices every cell by its nearest point.
    fn price(&mut self, points: &[Point2], geometry: &GridGeometry, kernel: &Kernel, desperate: bool) {
        let (half, side) = (kernel.half, 2 * kernel.half + 1);
        let (rows, cols) = (geometry.rows + 2 * half, geometry.cols + 2 * half);
        self.near.clear();
        self.near.resize(rows * cols, 0);
        let corner = geometry.world_from_grid.position();
        for &point in points {
            let in_grid = point - corner;
            let col = (in_grid.x / geometry.resolution_m).floor() + half as f64;
            let row = (in_grid.y / geometry.resolution_m).floor() + half as f64;
            let inside = row >= half as f64
                && col >= half as f64
                && row < (geometry.rows + half) as f64
                && col < (geometry.cols + half) as f64;
            if !inside {
                continue;
            }
            let (row, col) = (row as usize - half, col as usize - half);
            for (k, levels) in kernel.levels.chunks_exact(side).enumerate() {
                let from = (row + k) * cols + col;
                for (held, &level) in self.near[from..from + side].iter_mut().zip(levels) {
                    *held = (*held).max(level);
                }
            }
        }
        let mut prices = kernel.prices;
        if desperate {
            prices[255] = self.config.desperate_s_per_m as f32;
        }
        self.costs.clear();
        for row in 0..geometry.rows {
            let from = (row + half) * cols + half;
            self.costs.extend(self.near[from..from + geometry.cols].iter().map(|&l| prices[usize::from(l)]));
        }
    }

    /// Picks points down the way from `robot`.
    fn look_out(&mut self, robot: Point2) {
        self.lookouts.clear();
        let Some(field) = &self.field else { return };
        let geometry = *field.geometry();
        let Some(mut cell) = nearest_open(&geometry, &self.costs, robot) else { return };
        let (mut along_m, mut next) = (0.0, 0);
        let to_go = |cell: Cell| field.cost_to_go(cell) * geometry.resolution_m;
        while let Some(down) = field.next(cell) {
            let diagonal = down.row != cell.row && down.col != cell.col;
            along_m += geometry.resolution_m * if diagonal { std::f64::consts::SQRT_2 } else { 1.0 };
            cell = down;
            if along_m >= LOOKOUTS_M[next] {
                self.lookouts.push((geometry.center(cell), to_go(cell)));
                next += 1;
                if next == LOOKOUTS_M.len() {
                    return;
                }
            }
        }
        self.lookouts.push((geometry.center(cell), to_go(cell)));
    }

    /// The guide of a robot that stands at `world_from_robot` in the frame of the field.
    pub fn seen_from(&self, world_from_robot: Pose2) -> Option<SeenField<'_>> {
        let field = self.field.as_ref()?;
        let Values::F32(values) = field.native() else { return None };
        let geometry = *field.geometry();
        let (sin, cos) = world_from_robot.heading.sin_cos();
        Some(SeenField { local: self, field, values, geometry, world_from_robot, sin, cos })
    }
}

/// A [`LocalField`] in the frame of the robot.
pub struct SeenField<'a> {
    local: &'a LocalField,
    field: &'a Field,
    values: &'a [f32],
    geometry: GridGeometry,
    world_from_robot: Pose2,
    sin: f64,
    cos: f64,
}

impl SeenField<'_> {
    fn in_world(&self, p: Point2) -> Point2 {
        let Pose2 { x, y, .. } = self.world_from_robot;
        Point2::new(x + self.cos * p.x - self.sin * p.y, y + self.sin * p.x + self.cos * p.y)
    }

    fn price_at(&self, point: Point2) -> f64 {
        cell_of(&self.geometry, point)
            .map_or(f64::INFINITY, |(row, col)| f64::from(self.local.costs[row * self.geometry.cols + col]))
    }

    /// Time over a straight line \[s\]; infinite through what must not be.
    fn straight_s(&self, from: Point2, to: Point2) -> f64 {
        let way = to - from;
        let length_m = way.dot(way).sqrt();
        let steps = (length_m / LOOK_STEP_M).ceil().max(1.0) as usize;
        let mut sum = 0.0;
        for i in 0..steps {
            let price = self.price_at(from + way * ((i as f64 + 0.5) / steps as f64));
            if price.is_infinite() {
                return price;
            }
            sum += price;
        }
        sum * length_m / steps as f64
    }

    /// The cells around a point, and the time to go over each.
    fn by_cells(&self, point: Point2) -> (f64, Option<Cell>) {
        let mut best = (f64::INFINITY, None);
        let GridGeometry { rows, cols, resolution_m, world_from_grid } = self.geometry;
        let Some((row, col)) = cell_of(&self.geometry, point) else { return best };
        let scale = resolution_m / self.field.unit();
        for r in row.saturating_sub(2)..(row + 3).min(rows) {
            let dy = world_from_grid.y + (r as f64 + 0.5) * resolution_m - point.y;
            for c in col.saturating_sub(2)..(col + 3).min(cols) {
                let index = r * cols + c;
                let value = f64::from(self.values[index]) * scale;
                if value < best.0 {
                    let dx = world_from_grid.x + (c as f64 + 0.5) * resolution_m - point.x;
                    let to_go = value + (dx * dx + dy * dy).sqrt() * f64::from(self.local.costs[index]);
                    if to_go < best.0 {
                        best = (to_go, Some(Cell::new(r, c)));
                    }
                }
            }
        }
        best
    }
}

impl Guide for SeenField<'_> {
    fn to_go(&self, point_in_robot: Point2) -> (f64, f64) {
        let point = self.in_world(point_in_robot);
        let (mut best_s, cell) = self.by_cells(point);
        let mut towards: Option<Point2> = None;
        for &(lookout, to_go_s) in &self.local.lookouts {
            // Nothing is gained where even the fastest straight way would be too slow.
            let away = lookout - point;
            let least_s = to_go_s + away.dot(away).sqrt() / self.local.config.open_mps;
            if least_s < best_s {
                let over_s = to_go_s + self.straight_s(point, lookout);
                if over_s < best_s {
                    (best_s, towards) = (over_s, Some(lookout));
                }
            }
        }
        let towards = towards.or_else(|| {
            let mut cell = cell?;
            for _ in 0..DOWN {
                cell = self.field.next(cell).unwrap_or(cell);
            }
            Some(self.geometry.center(cell))
        });
        let direction = towards.map_or(0.0, |to| {
            let away = to - point;
            if away.dot(away) > 0.0 { away.y.atan2(away.x) - self.world_from_robot.heading } else { 0.0 }
        });
        (best_s, direction)
    }

    fn price(&self, point_in_robot: Point2) -> f64 {
        self.price_at(self.in_world(point_in_robot))
    }
}

/// A grid of whole cells around two points.
fn around(a: Point2, b: Point2, margin_m: f64, resolution_m: f64) -> GridGeometry {
    let down = |x: f64, y: f64| ((x.min(y) - margin_m) / resolution_m).floor();
    let up = |x: f64, y: f64| ((x.max(y) + margin_m) / resolution_m).ceil();
    let (x, y) = (down(a.x, b.x), down(a.y, b.y));
    GridGeometry {
        rows: (up(a.y, b.y) - y).max(1.0) as usize,
        cols: (up(a.x, b.x) - x).max(1.0) as usize,
        resolution_m,
        world_from_grid: Pose2::new(x * resolution_m, y * resolution_m, 0.0),
    }
}

/// Row and column of a point in a grid that lies along the axes.
fn cell_of(geometry: &GridGeometry, point: Point2) -> Option<(usize, usize)> {
    let col = (point.x - geometry.world_from_grid.x) / geometry.resolution_m;
    let row = (point.y - geometry.world_from_grid.y) / geometry.resolution_m;
    let inside = row >= 0.0 && col >= 0.0 && row < geometry.rows as f64 && col < geometry.cols as f64;
    inside.then_some((row as usize, col as usize))
}

/// The cell of finite price nearest to a point.
fn nearest_open(geometry: &GridGeometry, costs: &[f32], point: Point2) -> Option<Cell> {
    let (row, col) = cell_of(geometry, point)?;
    let (row, col) = (row as i64, col as i64);
    let inside = |r: i64, c: i64| r >= 0 && c >= 0 && r < geometry.rows as i64 && c < geometry.cols as i64;
    let most = geometry.rows.max(geometry.cols) as i64;
    let mut best: Option<(f64, Cell)> = None;
    for ring in 0..most {
        if let Some((distance_m, cell)) = best
            && (ring - 1) as f64 * geometry.resolution_m > distance_m
        {
            return Some(cell);
        }
        for r in row - ring..=row + ring {
            let edge = (r - row).abs() == ring;
            let mut c = col - ring;
            while c <= col + ring {
                if inside(r, c) && costs[r as usize * geometry.cols + c as usize].is_finite() {
                    let cell = Cell::new(r as usize, c as usize);
                    let distance_m = geometry.center(cell).distance(point);
                    if best.is_none_or(|(least, _)| distance_m < least) {
                        best = Some((distance_m, cell));
                    }
                }
                c += if edge || ring == 0 { 1 } else { 2 * ring };
            }
        }
    }
    best.map(|(_, cell)| cell)
}
