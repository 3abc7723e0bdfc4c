//! Is the way to the next waypoints free, and where does it become free again? `[Maalouf06 §6]`

use serde::Serialize;

use crate::geometry::Point2;

/// What was seen on the way to the next waypoints.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WayAhead {
    /// Index of the last waypoint whose segment was looked at.
    pub looked_to: usize,
    /// First waypoint whose segment is not free.
    pub blocked: Option<Blocked>,
    /// First waypoint beyond the blocked one that is free; None if none remains, or nothing blocks.
    pub free_beyond: Option<usize>,
}

/// A segment of the way that the footprint cannot sweep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Blocked {
    /// The waypoint that the segment leads to.
    pub waypoint: usize,
    /// The obstacle nearest to the segment, in the world frame \[m\].
    pub obstacle: Point2,
    /// From the segment to that obstacle \[m\].
    pub distance_m: f64,
}

/// How far to look, and how wide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Look at this many waypoints at least: the paper's three.
    pub waypoints: usize,
    /// And at this length of the way at least: stopping distance and footprint \[m\].
    pub length_m: f64,
    /// An obstacle nearer than this to a segment blocks it \[m\].
    pub half_width_m: f64,
    /// A waypoint with an obstacle nearer than this is not free \[m\].
    pub free_radius_m: f64,
}

/// Looks along the segments from `position` over `waypoints[next..]`.
///
/// `obstacles` are the occupied places that the plan did not know, in the world frame like the rest.
pub fn look_ahead(
    position: Point2,
    waypoints: &[Point2],
    next: usize,
    obstacles: &[Point2],
    look: &Look,
) -> WayAhead {
    let mut seen = WayAhead { looked_to: next.min(waypoints.len().saturating_sub(1)), ..WayAhead::default() };
    let mut from = position;
    let mut length_m = 0.0;
    for (index, &to) in waypoints.iter().enumerate().skip(next) {
        seen.looked_to = index;
        let nearest = obstacles
            .iter()
            .map(|&obstacle| (obstacle.distance_to_segment(from, to), obstacle))
            .filter(|(distance_m, _)| *distance_m < look.half_width_m)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance_m, obstacle)) = nearest {
            seen.blocked = Some(Blocked { waypoint: index, obstacle, distance_m });
            seen.free_beyond = first_free(waypoints, index, obstacles, look.free_radius_m);
            return seen;
        }
        length_m += from.distance(to);
        from = to;
        if index + 1 >= next + look.waypoints && length_m >= look.length_m {
            break;
        }
    }
    seen
}

/// The first waypoint from `first` on that keeps `free_radius_m` from every obstacle.
pub fn first_free(
    waypoints: &[Point2],
    first: usize,
    obstacles: &[Point2],
    free_radius_m: f64,
) -> Option<usize> {
    (first..waypoints.len())
        .find(|&i| obstacles.iter().all(|&obstacle| obstacle.distance(waypoints[i]) >= free_radius_m))
}

/// Length of a polyline \[m\].
pub(super) fn length_m(path: &[Point2]) -> f64 {
    path.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOK: Look = Look { waypoints: 3, length_m: 1.2, half_width_m: 0.3, free_radius_m: 0.4 };

    fn straight() -> Vec<Point2> {
        (0..20).map(|i| Point2::new(f64::from(i) * 0.3, 0.0)).collect()
    }

    #[test]
    fn an_obstacle_beside_the_swept_width_does_not_block() {
        let seen = look_ahead(Point2::new(0.0, 0.0), &straight(), 1, &[Point2::new(0.6, 0.31)], &LOOK);
        assert_eq!((seen.blocked, seen.looked_to), (None, 4));
    }

    #[test]
    fn an_obstacle_on_the_third_waypoint_blocks_and_the_first_free_one_beyond_is_named() {
        let seen = look_ahead(Point2::new(0.0, 0.0), &straight(), 1, &[Point2::new(0.9, 0.05)], &LOOK);
        assert_eq!(seen.blocked.unwrap().waypoint, 3);
        assert_eq!(seen.free_beyond, Some(5));
    }

    #[test]
    fn an_obstacle_beyond_the_look_is_not_yet_seen() {
        let seen = look_ahead(Point2::new(0.0, 0.0), &straight(), 1, &[Point2::new(2.4, 0.0)], &LOOK);
        assert_eq!(seen.blocked, None);
    }

    #[test]
    fn an_obstacle_on_the_destination_leaves_no_free_waypoint() {
        let way = [Point2::new(0.0, 0.0), Point2::new(0.3, 0.0), Point2::new(0.6, 0.0)];
        let seen = look_ahead(Point2::new(0.0, 0.0), &way, 1, &[Point2::new(0.6, 0.1)], &LOOK);
        assert!(seen.blocked.is_some());
        assert_eq!(seen.free_beyond, None);
    }
}
