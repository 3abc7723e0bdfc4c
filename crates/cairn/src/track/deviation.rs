//! How far off a path a drive was: the measure of tracking, against the continuous path.

use serde::Serialize;

use super::TrackError;
use crate::geometry::Point2;

/// Progress may fall back this far from one position to the next \[m\].
const BACK_M: f64 = 0.3;

/// One position of a drive, measured against a path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// Distance to the path, positive to the left of it \[m\].
    pub left_m: f64,
    /// Length of the path up to its nearest point \[m\].
    pub along_m: f64,
}

/// Every position of a drive against the polyline `path`, world frame \[m\].
///
/// The nearest point is sought from a little before the last one up to `reach_m` farther along, so
/// that where a path crosses itself the robot is not taken for being on the other branch.
///
/// # Errors
/// [`TrackError::PathEmpty`] for a path without two points, [`TrackError::PathPointNotFinite`],
/// [`TrackError::TrackValueOutOfRange`] when `reach_m` is not above 0.
pub fn deviations(path: &[Point2], positions: &[Point2], reach_m: f64) -> Result<Vec<Deviation>, TrackError> {
    if path.len() < 2 {
        return Err(TrackError::PathEmpty);
    }
    if !(reach_m.is_finite() && reach_m > 0.0) {
        let (key, must_be) = ("reach_m".to_owned(), "above 0".to_owned());
        return Err(TrackError::TrackValueOutOfRange { key, value: reach_m, must_be });
    }
    for points in [path, positions] {
        if let Some(index) = points.iter().position(|point| !point.is_finite()) {
            return Err(TrackError::PathPointNotFinite { index, x: points[index].x, y: points[index].y });
        }
    }
    let mut along_m = vec![0.0];
    for side in path.windows(2) {
        along_m.push(along_m[along_m.len() - 1] + side[0].distance(side[1]));
    }
    let mut reached_m = 0.0;
    Ok(positions
        .iter()
        .map(|&position| {
            let first = along_m.partition_point(|&s| s <= reached_m - BACK_M).saturating_sub(1);
            let mut best: Option<(f64, Deviation)> = None;
            for i in first..path.len() - 1 {
                if along_m[i] > reached_m + reach_m {
                    break;
                }
                let (distance_m, found) = to_side(position, path[i], path[i + 1], along_m[i]);
                // A tie is a corner: the side that is being left keeps its sign.
                if best.is_none_or(|(least_m, _)| distance_m < least_m) {
                    best = Some((distance_m, found));
                }
            }
            let (_, found) = best.expect("the window holds a side");
            reached_m = f64::max(reached_m, found.along_m);
            found
        })
        .collect())
}

fn to_side(position: Point2, from: Point2, to: Point2, from_m: f64) -> (f64, Deviation) {
    let (side, offset) = (to - from, position - from);
    let length_m = side.norm();
    if length_m == 0.0 {
        let distance_m = offset.norm();
        return (distance_m, Deviation { left_m: distance_m, along_m: from_m });
    }
    let share = (offset.dot(side) / (length_m * length_m)).clamp(0.0, 1.0);
    let distance_m = (offset - side * share).norm();
    let left_m = if side.cross(offset) < 0.0 { -distance_m } else { distance_m };
    (distance_m, Deviation { left_m, along_m: from_m + share * length_m })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(points: &[(f64, f64)]) -> Vec<Point2> {
        points.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    #[test]
    fn deviation_is_the_signed_distance_to_a_line() {
        let path = points(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)]);
        let found = deviations(&path, &points(&[(0.5, 0.1), (1.5, -0.2), (1.9, 1.0), (2.0, 2.5)]), 2.0);
        let found = found.expect("valid");
        let expected = [(0.1, 0.5), (-0.2, 1.5), (0.1, 3.0), (0.5, 4.0)];
        for (found, (left_m, along_m)) in found.iter().zip(expected) {
            assert!((found.left_m - left_m).abs() < 1e-12 && (found.along_m - along_m).abs() < 1e-12);
        }
    }

    #[test]
    fn where_a_path_crosses_itself_the_robot_stays_on_its_branch() {
        // Down through the origin, round, and across: near the crossing the other branch is nearer.
        let path = points(&[(0.0, 3.0), (0.0, -3.0), (-3.0, -3.0), (-3.0, 0.0), (3.0, 0.0)]);
        let drive: Vec<Point2> = (0..=60).map(|i| Point2::new(0.2, 3.0 - 0.1 * f64::from(i))).collect();
        let found = deviations(&path, &drive, 1.0).expect("valid");
        assert!(found.iter().all(|d| (d.left_m - 0.2).abs() < 1e-9), "{found:?}");
    }

    #[test]
    fn what_cannot_be_measured_is_refused_by_name() {
        let path = points(&[(0.0, 0.0), (1.0, 0.0)]);
        assert_eq!(deviations(&path[..1], &path, 1.0), Err(TrackError::PathEmpty));
        let bad = points(&[(0.0, f64::NAN)]);
        assert!(matches!(deviations(&path, &bad, 1.0), Err(TrackError::PathPointNotFinite { .. })));
        assert!(matches!(deviations(&path, &path, 0.0), Err(TrackError::TrackValueOutOfRange { .. })));
    }
}
