use serde::{Deserialize, Serialize};

use super::TrackError;
use crate::geometry::Point2;

/// Points nearer to each other than this are one \[m\].
const SAME_POINT_M: f64 = 1e-6;

/// The ordered nodes N_1 … N_final that the tracker drives along `[Maalouf06 §4]`, world frame \[m\].
///
/// Never empty; the first is the start and the last the goal, exactly; no two neighbours coincide.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Waypoints {
    points: Vec<Point2>,
}

/// How a planned path becomes waypoints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WaypointConfig {
    /// Greatest distance along the path from one waypoint to the next \[m\]. Close together: precise
    /// and slow; far apart: fast.
    pub spacing_m: f64,
    /// The path may be drawn straight as long as it stays this near to where it was \[m\]; 0 keeps
    /// every stair of a grid path.
    pub corridor_m: f64,
}

impl Default for WaypointConfig {
    fn default() -> Self {
        Self { spacing_m: 0.3, corridor_m: 0.1 }
    }
}

impl Waypoints {
    /// `path` resampled at equal steps of at most `spacing_m` along it, stairs and all.
    ///
    /// A step between two waypoints for which `is_clear(from, to)` does not hold follows the path's
    /// own vertices instead.
    ///
    /// # Errors
    /// [`TrackError`] for an empty path, a point that is not finite, a spacing that is not above 0.
    pub fn resample(
        path: &[Point2],
        spacing_m: f64,
        is_clear: impl Fn(Point2, Point2) -> bool,
    ) -> Result<Self, TrackError> {
        Self::from_path(path, &WaypointConfig { spacing_m, corridor_m: 0.0 }, is_clear)
    }

    /// As [`Self::resample`], after drawing the path straight inside a corridor around it, wherever
    /// `is_clear` holds along the straight line. This takes the stairs out of a path from cell to
    /// cell, whose 45° bends would otherwise look like curvature. `is_clear` may ask for more than
    /// free ground, such as a cost that does not rise.
    ///
    /// # Errors
    /// As [`Self::resample`], and for a corridor below 0.
    pub fn from_path(
        path: &[Point2],
        config: &WaypointConfig,
        is_clear: impl Fn(Point2, Point2) -> bool,
    ) -> Result<Self, TrackError> {
        let &WaypointConfig { spacing_m, corridor_m } = config;
        check(spacing_m.is_finite() && spacing_m > SAME_POINT_M, "spacing_m", spacing_m, "above 0")?;
        check(corridor_m.is_finite() && corridor_m >= 0.0, "corridor_m", corridor_m, "of at least 0")?;
        let given = Self::as_given(path)?;
        let goal = given.points[given.last_index()];
        let vertices = straightened(&given.points, corridor_m, &is_clear);
        let mut points = equally_spaced(&vertices, spacing_m, &is_clear);
        *points.last_mut().expect("at least the start") = goal;
        Ok(Self { points })
    }

    /// `points` themselves, without those that repeat the one before.
    ///
    /// # Errors
    /// [`TrackError::PathEmpty`], [`TrackError::PathPointNotFinite`].
    pub fn as_given(points: &[Point2]) -> Result<Self, TrackError> {
        if let Some(index) = points.iter().position(|point| !point.is_finite()) {
            return Err(TrackError::PathPointNotFinite { index, x: points[index].x, y: points[index].y });
        }
        let goal = *points.last().ok_or(TrackError::PathEmpty)?;
        let mut kept: Vec<Point2> = Vec::new();
        for &point in points {
            if kept.last().is_none_or(|last| last.distance(point) > SAME_POINT_M) {
                kept.push(point);
            }
        }
        *kept.last_mut().expect("at least the start") = goal;
        Ok(Self { points: kept })
    }

    /// The waypoints, start to goal, world frame \[m\].
    pub fn points(&self) -> &[Point2] {
        &self.points
    }

    /// Number of waypoints, at least 1.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Index of the goal.
    pub fn last_index(&self) -> usize {
        self.points.len() - 1
    }

    /// Waypoint `index`, or the goal beyond the end.
    pub fn at(&self, index: usize) -> Point2 {
        self.points[index.min(self.last_index())]
    }

    /// Distance along the waypoints from waypoint `index` to the goal \[m\].
    pub fn length_from_m(&self, index: usize) -> f64 {
        let rest = &self.points[index.min(self.last_index())..];
        rest.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }

    /// Absolute turn at waypoint `index`, in [0, π] \[rad\]; 0 at the ends and beyond.
    pub fn turn_rad(&self, index: usize) -> f64 {
        if index == 0 || index >= self.last_index() {
            return 0.0;
        }
        let arriving = self.points[index] - self.points[index - 1];
        let leaving = self.points[index + 1] - self.points[index];
        arriving.cross(leaving).atan2(arriving.dot(leaving)).abs()
    }

    /// The pointer rule: from `index` forward while `position` is nearer to the next waypoint.
    pub fn pointer_from(&self, mut index: usize, position: Point2) -> usize {
        index = index.min(self.last_index());
        while index < self.last_index()
            && position.distance(self.points[index + 1]) < position.distance(self.points[index])
        {
            index += 1;
        }
        index
    }
}

fn check(holds: bool, key: &str, value: f64, must_be: &str) -> Result<(), TrackError> {
    if holds {
        return Ok(());
    }
    Err(TrackError::TrackValueOutOfRange { key: key.to_owned(), value, must_be: must_be.to_owned() })
}

/// From each kept vertex to the farthest one in a row that can be reached straight: everything
/// between lies within the corridor, and the way is clear.
fn straightened(
    vertices: &[Point2],
    corridor_m: f64,
    is_clear: &impl Fn(Point2, Point2) -> bool,
) -> Vec<Point2> {
    if corridor_m == 0.0 || vertices.len() < 3 {
        return vertices.to_vec();
    }
    let last = vertices.len() - 1;
    let straight = |from: usize, to: usize| {
        let near = |v: &Point2| v.distance_to_segment(vertices[from], vertices[to]) <= corridor_m;
        vertices[from + 1..to].iter().all(near) && is_clear(vertices[from], vertices[to])
    };
    let mut kept = vec![vertices[0]];
    let mut from = 0;
    while from < last {
        let mut to = from + 1;
        while to < last && straight(from, to + 1) {
            to += 1;
        }
        kept.push(vertices[to]);
        from = to;
    }
    kept
}

fn equally_spaced(
    vertices: &[Point2],
    spacing_m: f64,
    is_clear: &impl Fn(Point2, Point2) -> bool,
) -> Vec<Point2> {
    let length: f64 = vertices.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    // A billionth of a step forgives the rounding of a length that is a whole number of steps.
    let steps = (length / spacing_m - 1e-9).ceil().max(1.0);
    let mut points = vec![vertices[0]];
    let mut since_last: Vec<Point2> = Vec::new();
    let mut next_m = length / steps;
    let mut done_m = 0.0;
    let mut step = 1.0;
    let keep = |points: &mut Vec<Point2>, since_last: &mut Vec<Point2>, point: Point2| {
        let from = *points.last().expect("starts with one");
        if !since_last.is_empty() && !is_clear(from, point) {
            points.append(since_last);
        }
        since_last.clear();
        if points.last().expect("starts with one").distance(point) > SAME_POINT_M {
            points.push(point);
        }
    };
    for pair in vertices.windows(2) {
        let side_m = pair[0].distance(pair[1]);
        while step < steps && next_m <= done_m + side_m {
            let point = pair[0] + (pair[1] - pair[0]) * ((next_m - done_m) / side_m);
            keep(&mut points, &mut since_last, point);
            step += 1.0;
            next_m = length * (step / steps);
        }
        done_m += side_m;
        since_last.push(pair[1]);
    }
    if let Some(goal) = since_last.pop() {
        keep(&mut points, &mut since_last, goal);
    }
    points
}
