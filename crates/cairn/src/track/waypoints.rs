use serde::{Deserialize, Serialize};

use super::TrackError;
use crate::geometry::Point2;

/// Points nearer to each other than this are one \[m\].
const SAME_POINT_M: f64 = 1e-6;
/// A bend whose vertex lies this far off the chord over it, as a share of half the chord, is a corner:
/// a turn of about 29°.
const CORNER_SHARE: f64 = 0.25;

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

impl WaypointConfig {
    /// Checks both numbers.
    ///
    /// # Errors
    /// [`TrackError::TrackValueOutOfRange`] for a spacing that is not above 0, a corridor below 0.
    pub fn checked(&self) -> Result<(), TrackError> {
        let &Self { spacing_m, corridor_m } = self;
        check(spacing_m.is_finite() && spacing_m > SAME_POINT_M, "spacing_m", spacing_m, "above 0")?;
        check(corridor_m.is_finite() && corridor_m >= 0.0, "corridor_m", corridor_m, "of at least 0")
    }
}

impl Waypoints {
    /// `path` resampled at equal steps of at most `spacing_m` along it, stairs and all; where it
    /// bends sharply, the bend itself is a waypoint.
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
        config.checked()?;
        let &WaypointConfig { spacing_m, corridor_m } = config;
        let given = Self::as_given(path)?;
        let goal = given.points[given.last_index()];
        let vertices = straightened(&given.points, corridor_m, &is_clear);
        let mut points = spaced(&vertices, spacing_m, &is_clear);
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

/// Waypoints along `vertices`: those at which the path bends, and equal steps from each to the next.
fn spaced(vertices: &[Point2], spacing_m: f64, is_clear: &impl Fn(Point2, Point2) -> bool) -> Vec<Point2> {
    let mut points = vec![vertices[0]];
    let mut from = 0;
    for to in corners(vertices, spacing_m).into_iter().chain([vertices.len() - 1]) {
        append_steps(&mut points, &vertices[from..=to], spacing_m, is_clear);
        from = to;
    }
    points
}

/// Indices of the vertices at which the path bends as seen from a step away, not only in detail (the
/// stairs of a grid) and not only as a whole (a wide arc); of neighbours, the sharpest.
fn corners(vertices: &[Point2], spacing_m: f64) -> Vec<usize> {
    let mut along_m = vec![0.0];
    for pair in vertices.windows(2) {
        along_m.push(along_m[along_m.len() - 1] + pair[0].distance(pair[1]));
    }
    let last = vertices.len() - 1;
    let at = |s_m: f64| {
        let s_m = s_m.clamp(0.0, along_m[last]);
        let i = along_m.partition_point(|&before| before <= s_m).clamp(1, last.max(1));
        let side_m = along_m[i] - along_m[i - 1];
        vertices[i - 1] + (vertices[i] - vertices[i - 1]) * ((s_m - along_m[i - 1]) / side_m).min(1.0)
    };
    // How far the vertex lies from the chord over it, as a share of the chord's half length.
    let bend = |i: usize, reach_m: f64| {
        vertices[i].distance_to_segment(at(along_m[i] - reach_m), at(along_m[i] + reach_m)) / reach_m
    };
    let mut found: Vec<(usize, f64)> = Vec::new();
    for i in 1..last {
        let sharpness = bend(i, spacing_m).min(bend(i, spacing_m / 3.0));
        if sharpness < CORNER_SHARE {
            continue;
        }
        match found.last_mut() {
            Some(before) if along_m[i] - along_m[before.0] < spacing_m / 2.0 => {
                if sharpness > before.1 {
                    *before = (i, sharpness);
                }
            }
            _ => found.push((i, sharpness)),
        }
    }
    found.into_iter().map(|(i, _)| i).collect()
}

fn append_steps(
    points: &mut Vec<Point2>,
    vertices: &[Point2],
    spacing_m: f64,
    is_clear: &impl Fn(Point2, Point2) -> bool,
) {
    let length: f64 = vertices.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    // A billionth of a step forgives the rounding of a length that is a whole number of steps.
    let steps = (length / spacing_m - 1e-9).ceil().max(1.0);
    let mut since_last: Vec<Point2> = Vec::new();
    let mut next_m = length / steps;
    let mut done_m = 0.0;
    let mut step = 1.0;
    let mut keep = |since_last: &mut Vec<Point2>, point: Point2| {
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
            keep(&mut since_last, point);
            step += 1.0;
            next_m = length * (step / steps);
        }
        done_m += side_m;
        since_last.push(pair[1]);
    }
    if let Some(end) = since_last.pop() {
        keep(&mut since_last, end);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn path() -> impl Strategy<Value = Vec<Point2>> {
        let point = (-5.0..5.0f64, -5.0..5.0f64).prop_map(|(x, y)| Point2::new(x, y));
        prop::collection::vec(point, 1..20)
    }

    fn to_path(point: Point2, path: &[Point2]) -> f64 {
        let sides = path.windows(2).map(|side| point.distance_to_segment(side[0], side[1]));
        sides.fold(point.distance(path[0]), f64::min)
    }

    #[test]
    fn a_straight_way_is_cut_into_equal_steps_with_the_goal_exact() {
        let path = [Point2::new(0.0, 0.0), Point2::new(0.0, 0.0), Point2::new(1.0, 0.1 + 0.2)];
        let waypoints = Waypoints::resample(&path, 0.3, |_, _| true).expect("valid");
        assert_eq!(waypoints.len(), 5);
        assert_eq!((waypoints.at(0), waypoints.at(4), waypoints.at(9)), (path[0], path[2], path[2]));
        let even =
            waypoints.points().windows(2).all(|p| (p[0].distance(p[1]) - 1.09f64.sqrt() / 4.0).abs() < 1e-12);
        assert!(even);
    }

    #[test]
    fn turns_are_absolute_angles_between_segments() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, -1.0), (1.0, 0.0)].map(|(x, y)| Point2::new(x, y));
        let waypoints = Waypoints::as_given(&square).expect("valid");
        let turns = [0, 1, 2, 3, 4].map(|i| waypoints.turn_rad(i));
        let expected = [0.0, std::f64::consts::FRAC_PI_2, std::f64::consts::PI, 0.0, 0.0];
        assert!(turns.iter().zip(expected).all(|(turn, e)| (turn - e).abs() < 1e-12), "{turns:?}");
    }

    #[test]
    fn the_stairs_of_a_grid_path_come_out_straight_inside_the_corridor() {
        let stairs: Vec<Point2> =
            (0..80).map(|i| Point2::new(0.05 * f64::from(i), 0.05 * f64::from(i / 2))).collect();
        let config = WaypointConfig { spacing_m: 0.3, corridor_m: 0.1 };
        let waypoints = Waypoints::from_path(&stairs, &config, |_, _| true).expect("valid");
        let turn = (0..waypoints.len()).map(|i| waypoints.turn_rad(i)).fold(0.0, f64::max);
        assert!(turn < 0.03, "{turn}");
        let blocked = Waypoints::from_path(&stairs, &config, |_, _| false).expect("valid");
        assert!(stairs.iter().all(|vertex| blocked.points().iter().any(|p| p.distance(*vertex) < 1e-9)));
    }

    #[test]
    fn the_pointer_goes_forward_only_and_as_far_as_the_robot_is_nearer() {
        let line: Vec<Point2> = (0..10).map(|i| Point2::new(f64::from(i), 0.0)).collect();
        let waypoints = Waypoints::as_given(&line).expect("valid");
        let from = |index, x| waypoints.pointer_from(index, Point2::new(x, 3.0));
        assert_eq!([from(0, 0.4), from(0, 0.5), from(0, 0.6), from(0, 4.7), from(6, 1.0)], [0, 0, 1, 5, 6]);
        assert_eq!(from(0, 99.0), 9);
    }

    #[test]
    fn a_corner_is_a_waypoint_and_a_wide_bend_is_not() {
        let square = [(0.0, 0.0), (1.1, 0.0), (1.1, 0.7), (2.0, 1.0)].map(|(x, y)| Point2::new(x, y));
        let waypoints = Waypoints::resample(&square, 0.3, |_, _| true).expect("valid");
        assert!(square.iter().all(|corner| waypoints.points().contains(corner)), "{waypoints:?}");
        let steps: Vec<f64> = waypoints.points().windows(2).map(|p| p[0].distance(p[1])).collect();
        assert!(steps.iter().all(|&step| step > 0.2 && step <= 0.3 + 1e-9), "{steps:?}");

        let arc: Vec<Point2> = (0..=300)
            .map(|i| f64::from(i) * 0.01)
            .map(|a| Point2::new(f64::sin(a), 1.0 - f64::cos(a)))
            .collect();
        for spacing_m in [0.1, 0.3, 0.6, 1.0] {
            assert_eq!(corners(&arc, spacing_m), Vec::<usize>::new(), "{spacing_m}");
        }
    }

    #[test]
    fn paths_that_cannot_be_followed_are_refused_by_name() {
        let here = Point2::new(0.0, 0.0);
        let refused = |path: &[Point2], spacing_m, corridor_m| {
            let config = WaypointConfig { spacing_m, corridor_m };
            Waypoints::from_path(path, &config, |_, _| true).expect_err("refused")
        };
        assert_eq!(refused(&[], 0.3, 0.0), TrackError::PathEmpty);
        let bad = refused(&[here, Point2::new(f64::NAN, 0.0)], 0.3, 0.0);
        assert!(matches!(bad, TrackError::PathPointNotFinite { index: 1, .. }));
        for (spacing_m, corridor_m) in
            [(0.0, 0.0), (f64::NAN, 0.0), (-1.0, 0.0), (0.3, -0.1), (0.3, f64::NAN)]
        {
            assert!(matches!(
                refused(&[here], spacing_m, corridor_m),
                TrackError::TrackValueOutOfRange { .. }
            ));
        }
    }

    proptest! {
        #[test]
        fn waypoints_lie_on_the_path_from_start_to_goal_at_most_a_step_apart(
            path in path(), spacing_m in 0.05..2.0f64,
        ) {
            let waypoints = Waypoints::resample(&path, spacing_m, |_, _| true).expect("valid");
            prop_assert_eq!(waypoints.at(0), path[0]);
            prop_assert_eq!(waypoints.at(usize::MAX), path[path.len() - 1]);
            for pair in waypoints.points().windows(2) {
                let step = pair[0].distance(pair[1]);
                prop_assert!(step > SAME_POINT_M && step <= spacing_m * (1.0 + 1e-6));
            }
            for point in waypoints.points() {
                prop_assert!(to_path(*point, &path) < 1e-9);
            }
        }

        #[test]
        fn steps_never_cross_an_obstacle_that_the_path_goes_around(
            legs in prop::collection::vec((1.0..4.0f64, -0.2..0.6f64), 2..30),
            spacing_m in 0.1..4.0f64,
            corridor_m in 0.0..3.0f64,
        ) {
            let mut bearing = 0.0;
            let path: Vec<Point2> = legs
                .iter()
                .map(|&(radius, turn)| {
                    bearing += turn;
                    Point2::new(radius * f64::cos(bearing), radius * f64::sin(bearing))
                })
                .collect();
            let obstacle = Point2::new(0.0, 0.0);
            let clear = |a: Point2, b: Point2| obstacle.distance_to_segment(a, b) > 0.5;
            prop_assert!(path.windows(2).all(|side| clear(side[0], side[1])));
            let config = WaypointConfig { spacing_m, corridor_m };
            let waypoints = Waypoints::from_path(&path, &config, clear).expect("valid");
            for pair in waypoints.points().windows(2) {
                prop_assert!(clear(pair[0], pair[1]), "{:?}", pair);
            }
        }
    }
}
