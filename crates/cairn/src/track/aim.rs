//! The point that the robot heads for: one step ahead along the way of waypoints, moving on with it.

use super::Waypoints;
use crate::geometry::Point2;

/// From this turn on, a waypoint is a corner of the way; less is a bend of a smooth one \[rad\].
const CORNER_RAD: f64 = 0.5;

/// Where the robot heads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// World frame \[m\].
    pub target: Point2,
    /// Way from there to the goal along the waypoints \[m\]; 0 where the target is the goal.
    pub left_m: f64,
}

impl Waypoints {
    /// Where a robot at `position` heads whose current node is N_i = `index`: as far beyond N_{i+1} as
    /// it is itself beyond N_i, counted in steps.
    ///
    /// Heading for N_{i+1} until it is passed and for N_{i+2} from then on, dR and dθ jump with every
    /// waypoint, and so does the wheel. A target that moves on with the robot stays one step ahead. It
    /// moves along a smooth curve through the waypoints, so that a bend is not cut from chord to chord;
    /// it waits at a corner until the pointer is there, so that no corner is cut either. Is the robot
    /// more than a step short of N_i, which was set then, it is N_{i+1}.
    pub fn aim(&self, index: usize, position: Point2) -> Aim {
        let last = self.last_index();
        let node = index.min(last);
        let beyond = self.share_of_step(node, position).max(0.0);
        let (mut from, mut share) = (node, beyond.min(1.0));
        if beyond == 0.0 && node > 0 && !self.is_corner(node) {
            let before = self.share_of_step(node - 1, position);
            if (0.0..1.0).contains(&before) {
                (from, share) = (node - 1, before);
            }
        }
        if from + 1 >= last || self.is_corner(from + 1) {
            share = 0.0;
        }
        let step_m = self.at(from + 1).distance(self.at(from + 2));
        Aim {
            target: self.between(from + 1, share),
            left_m: step_m * (1.0 - share) + self.length_from_m(from + 2),
        }
    }

    fn is_corner(&self, index: usize) -> bool {
        self.turn_rad(index) > CORNER_RAD
    }

    /// How far `position` is along the step from waypoint `index` to the next, as a share of it.
    fn share_of_step(&self, index: usize, position: Point2) -> f64 {
        let step = self.at(index + 1) - self.at(index);
        let length2 = step.dot(step);
        if length2 > 0.0 { (position - self.at(index)).dot(step) / length2 } else { 0.0 }
    }

    /// `share` of the way from waypoint `index` to the next, on the cubic that at each of the two runs
    /// as the way does there.
    fn between(&self, index: usize, share: f64) -> Point2 {
        let (a, b) = (self.at(index), self.at(index + 1));
        let step = b - a;
        let length_m = step.norm();
        if share == 0.0 {
            return a;
        }
        let along = |index: usize| {
            if index == 0 || index >= self.last_index() || self.is_corner(index) {
                return step;
            }
            let (arriving, leaving) =
                (self.at(index) - self.at(index - 1), self.at(index + 1) - self.at(index));
            let (before_m, after_m) = (arriving.norm(), leaving.norm());
            // The slope at the middle node of the parabola through three.
            let slope = arriving * (after_m / before_m) + leaving * (before_m / after_m);
            slope * (length_m / (before_m + after_m))
        };
        let (t, u) = (share, 1.0 - share);
        a + step * (t * t * (3.0 - 2.0 * t)) + along(index) * (t * u * u) - along(index + 1) * (t * t * u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(path: &[Point2], spacing_m: f64) -> Waypoints {
        Waypoints::resample(path, spacing_m, |_, _| true).expect("valid")
    }

    fn arc(radius_m: f64) -> Vec<Point2> {
        let at = |a: f64| Point2::new(radius_m * a.sin(), radius_m * (1.0 - a.cos()));
        (0..=2000).map(|i| at(f64::from(i) * 2e-3)).collect()
    }

    /// Every target of a robot that is driven along `path` exactly.
    fn targets(way: &Waypoints, path: &[Point2]) -> Vec<Point2> {
        let mut index = 0;
        let mut aims = Vec::new();
        for &place in path {
            index = way.pointer_from(index, place);
            aims.push(way.aim(index, place).target);
        }
        aims
    }

    #[test]
    fn on_a_straight_way_the_target_is_one_step_ahead_and_at_last_the_goal() {
        let way = cut(&[Point2::new(0.0, 0.0), Point2::new(3.0, 0.0)], 0.3);
        for i in 0..=300 {
            let x = f64::from(i) * 0.01;
            let place = Point2::new(x, 0.02);
            let aim = way.aim(way.pointer_from(0, place), place);
            assert!((aim.target.x - (x + 0.3).min(3.0)).abs() < 1e-9, "{x}: {aim:?}");
            assert!((aim.left_m - (2.7 - x).max(0.0)).abs() < 1e-9, "{x}: {aim:?}");
        }
    }

    #[test]
    fn round_a_circle_the_target_stays_on_it_at_one_distance() {
        for (radius_m, spacing_m) in [(1.0, 0.2), (1.5, 0.3), (3.0, 0.6)] {
            let path = arc(radius_m);
            let way = cut(&path, spacing_m);
            let inside = path.len() - (1000.0 * spacing_m / radius_m) as usize;
            let centre = Point2::new(0.0, radius_m);
            for (place, target) in path.iter().zip(targets(&way, &path)).take(inside).skip(300) {
                assert!((place.distance(target) / spacing_m - 1.0).abs() < 0.03, "{place:?} {target:?}");
                assert!((centre.distance(target) - radius_m).abs() < 1e-3 * radius_m, "{target:?}");
            }
        }
    }

    #[test]
    fn the_target_moves_on_without_a_jump() {
        let path: Vec<Point2> =
            (0..4000).map(|i| f64::from(i) * 3e-3).map(|x| Point2::new(x, x.sin())).collect();
        for spacing_m in [0.1, 0.2, 0.35] {
            let aims = targets(&cut(&path, spacing_m), &path);
            let moved = aims.windows(2).map(|pair| pair[0].distance(pair[1]));
            assert!(moved.fold(0.0, f64::max) < 0.02, "{spacing_m}");
        }
    }

    #[test]
    fn the_target_waits_at_a_corner_until_the_pointer_is_there() {
        let corner = Point2::new(1.2, 0.0);
        let way = cut(&[Point2::new(0.0, 0.0), corner, Point2::new(1.2, 1.2)], 0.3);
        let aim = |x: f64| {
            let place = Point2::new(x, 0.0);
            way.aim(way.pointer_from(0, place), place).target
        };
        assert!([0.91, 0.95, 1.04].iter().all(|&x| aim(x) == corner));
        assert_eq!(aim(1.06), Point2::new(1.2, 0.3));
    }

    #[test]
    fn a_node_that_was_set_far_ahead_is_headed_beyond() {
        let way = cut(&[Point2::new(0.0, 0.0), Point2::new(3.0, 0.0)], 0.3);
        assert_eq!(way.aim(6, Point2::new(0.2, 0.0)).target, way.at(7));
        assert_eq!(way.aim(99, Point2::new(0.2, 0.0)).target, way.at(10));
    }

    #[test]
    fn a_way_of_one_waypoint_is_its_goal() {
        let way = Waypoints::as_given(&[Point2::new(1.0, 2.0)]).expect("valid");
        let aim = way.aim(0, Point2::new(0.0, 0.0));
        assert_eq!((aim.target, aim.left_m), (Point2::new(1.0, 2.0), 0.0));
    }
}
