//! Out of a tight place by turns on the spot and straight pieces, forwards and backwards, that the true
//! outline fits: a search over place and heading near the robot.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};
use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::avoid::GrownBox;
use crate::geometry::{Point2, Pose2, Twist2, wrap_angle};

/// When a robot manoeuvres, and how.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ManoeuvreConfig {
    /// A robot under way that hardly moves for this long looks for a manoeuvre \[s\].
    pub stands_s: f64,
    /// It hardly moves while it stays within this \[m\] ...
    pub stands_m: f64,
    /// ... and within this \[rad\].
    pub stands_rad: f64,
    /// No leg leads farther away than this \[m\].
    pub reach_m: f64,
    /// Or while it mills about within this \[m\] ...
    pub mills_m: f64,
    /// ... for this long \[s\].
    pub mills_s: f64,
    /// What must be left to pay after it has fallen by this: metres of open ground.
    pub gain: f64,
    /// Kept between outline and obstacles, if there is a way that does, \[m\]
    pub clearance_m: f64,
    /// else this, unless the robot stands nearer already \[m\].
    pub least_clearance_m: f64,
    /// Greatest speed \[m/s\].
    pub speed_mps: f64,
    /// Greatest rate of turning \[rad/s\].
    pub turn_radps: f64,
    /// Manoeuvres from about one place before it is left to a new plan.
    pub most: u32,
}

impl Default for ManoeuvreConfig {
    fn default() -> Self {
        Self {
            stands_s: 2.0,
            stands_m: 0.08,
            stands_rad: 0.3,
            mills_m: 0.4,
            mills_s: 8.0,
            reach_m: 1.6,
            gain: 0.6,
            clearance_m: 0.06,
            least_clearance_m: 0.025,
            speed_mps: 0.2,
            turn_radps: 0.6,
            most: 3,
        }
    }
}

/// A piece of a manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Leg {
    /// On the spot, to this heading \[rad\].
    Turn {
        /// In the world frame \[rad\].
        heading_rad: f64,
        /// −1: to the right.
        side: f64,
    },
    /// Straight on, or back.
    Straight {
        /// Where it ends, with the heading it is driven at.
        to: Pose2,
        /// −1: backwards.
        direction: f64,
    },
}

/// Straight pieces are this long \[m\], and turns this far.
const STEP_M: f64 = 0.05;
const TURNS: i32 = 36;
const STEP_RAD: f64 = TAU / TURNS as f64;
/// Two poses nearer than this, at one heading, are one.
const SAME_M: f64 = 0.04;
/// Prices: of a metre backwards, of a radian, of another leg, of a step that nearly touches.
const BACK: f64 = 1.5;
const RADIAN: f64 = 0.25;
const LEG: f64 = 0.15;
const NEAR: f64 = 2.0;
/// Nearer than this beyond what must be kept costs more \[m\].
const SOFT_M: f64 = 0.05;
/// Poses looked at before it is given up.
const MOST: usize = 12_000;
/// Side of the squares that obstacles are sorted into \[m\].
const SQUARE_M: f64 = 0.25;

/// Obstacles around a place, to ask how near an outline is to them.
pub(super) struct Near {
    low: Point2,
    side: usize,
    squares: Vec<Vec<Point2>>,
    body: GrownBox,
}

impl Near {
    /// Points within `reach_m` of `center`, for this outline.
    pub fn new(
        points: impl IntoIterator<Item = Point2>,
        center: Point2,
        reach_m: f64,
        body: GrownBox,
    ) -> Self {
        let low = center - Point2::new(reach_m, reach_m);
        let side = (2.0 * reach_m / SQUARE_M).ceil().max(1.0) as usize;
        let mut near = Self { low, side, squares: vec![Vec::new(); side * side], body };
        for point in points {
            if let Some(square) = near.square(point) {
                near.squares[square].push(point);
            }
        }
        near
    }

    fn index(&self, point: Point2) -> (f64, f64) {
        let at = point - self.low;
        ((at.x / SQUARE_M).floor(), (at.y / SQUARE_M).floor())
    }

    fn square(&self, point: Point2) -> Option<usize> {
        let (col, row) = self.index(point);
        let inside = |i: f64| i >= 0.0 && i < self.side as f64;
        (inside(col) && inside(row)).then(|| row as usize * self.side + col as usize)
    }

    fn within(&self, center: Point2, radius_m: f64) -> impl Iterator<Item = Point2> + '_ {
        let reach = Point2::new(radius_m, radius_m);
        let (low, high) = (self.index(center - reach), self.index(center + reach));
        let range = move |low: f64, high: f64| {
            let last = self.side as f64 - 1.0;
            (low.clamp(0.0, last) as usize)..=(high.clamp(0.0, last) as usize)
        };
        range(low.1, high.1)
            .flat_map(move |row| range(low.0, high.0).map(move |col| row * self.side + col))
            .flat_map(move |square| self.squares[square].iter().copied())
    }

    /// From the outline at `pose` to the nearest point, up to `most_m` \[m\].
    pub fn clearance_m(&self, pose: Pose2, most_m: f64) -> f64 {
        let inverse = pose.inverse();
        let radius_m = self.body.half_length_m.hypot(self.body.half_width_m) + most_m;
        self.within(pose.position(), radius_m)
            .map(|point| self.body.distance(inverse * point))
            .fold(most_m, f64::min)
    }

    /// From `center` to the nearest point, up to `most_m` \[m\].
    pub fn distance_m(&self, center: Point2, most_m: f64) -> f64 {
        self.within(center, most_m).map(|point| point.distance(center)).fold(most_m, f64::min)
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Motion {
    None,
    Straight(i8),
    Turn(i8),
}

struct Node {
    pose: Pose2,
    parent: usize,
    motion: Motion,
}

struct Open {
    /// With what is thought to be left.
    rank: f64,
    cost: f64,
    node: usize,
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        other.rank.total_cmp(&self.rank).then(other.node.cmp(&self.node))
    }
}

/// A cheap manoeuvre from `start` to a pose that `accept` takes; None if there is none near.
///
/// `left` says what is thought to be left from a place \[m\]: it leads the search `[Hart68]` and need not be right.
/// The outline keeps `least_m` from every point; where it stands nearer at the start, it comes no nearer.
pub(super) fn find(
    near: &Near,
    start: Pose2,
    least_m: f64,
    reach_m: f64,
    left: impl Fn(Point2) -> f64,
    accept: impl Fn(Pose2) -> bool,
) -> Option<Vec<Leg>> {
    let soft_m = least_m + SOFT_M;
    let held_m = (near.clearance_m(start, least_m) - 1e-6).min(least_m);
    let key = |pose: Pose2, turn: i32| {
        let cell = |metres: f64| (metres / SAME_M).round() as i32;
        (cell(pose.x - start.x), cell(pose.y - start.y), turn.rem_euclid(TURNS))
    };
    let mut nodes = vec![Node { pose: start, parent: 0, motion: Motion::None }];
    let mut turns = vec![0i32];
    let mut best: HashMap<(i32, i32, i32), f64> = HashMap::new();
    let mut open = BinaryHeap::from([Open { rank: 0.0, cost: 0.0, node: 0 }]);
    best.insert(key(start, 0), 0.0);
    while let Some(Open { cost, node, .. }) = open.pop() {
        let (pose, motion, turn) = (nodes[node].pose, nodes[node].motion, turns[node]);
        if cost > best[&key(pose, turn)] + 1e-9 {
            continue;
        }
        if node > 0 && accept(pose) {
            return Some(legs(&nodes, node));
        }
        if nodes.len() > MOST {
            return None;
        }
        for next in [Motion::Straight(1), Motion::Straight(-1), Motion::Turn(1), Motion::Turn(-1)] {
            let (half, to, to_turn, mut price) = match next {
                Motion::Straight(way) => {
                    let to = pose.moved(Twist2::new(f64::from(way) * STEP_M, 0.0), 1.0);
                    (None, to, turn, STEP_M * if way < 0 { BACK } else { 1.0 })
                }
                Motion::Turn(side) => {
                    let at =
                        |turn: f64| Pose2::new(pose.x, pose.y, wrap_angle(start.heading + turn * STEP_RAD));
                    let to = turn + i32::from(side);
                    (Some(at(f64::from(turn + to) / 2.0)), at(f64::from(to)), to, RADIAN * STEP_RAD)
                }
                Motion::None => continue,
            };
            if to.position().distance(start.position()) > reach_m {
                continue;
            }
            let clear_m = |pose| near.clearance_m(pose, soft_m);
            let clearance_m = half.map_or(f64::INFINITY, clear_m).min(clear_m(to));
            if clearance_m < held_m {
                continue;
            }
            price += if motion != Motion::None && motion != next { LEG } else { 0.0 };
            price *= 1.0 + NEAR * ((soft_m - clearance_m) / SOFT_M).max(0.0);
            let reached = cost + price;
            let known = best.entry(key(to, to_turn)).or_insert(f64::INFINITY);
            if reached < *known - 1e-9 {
                *known = reached;
                nodes.push(Node { pose: to, parent: node, motion: next });
                turns.push(to_turn);
                let rank = reached + left(to.position());
                open.push(Open { rank, cost: reached, node: nodes.len() - 1 });
            }
        }
    }
    None
}

/// Steps of one kind in a row are one leg.
fn legs(nodes: &[Node], last: usize) -> Vec<Leg> {
    let mut way = Vec::new();
    let mut node = last;
    while node > 0 {
        way.push(node);
        node = nodes[node].parent;
    }
    way.reverse();
    let mut legs: Vec<Leg> = Vec::new();
    let mut before = Motion::None;
    for node in way {
        let Node { pose, motion, .. } = nodes[node];
        let leg = match motion {
            Motion::Straight(way) => Leg::Straight { to: pose, direction: f64::from(way) },
            Motion::Turn(side) => Leg::Turn { heading_rad: pose.heading, side: f64::from(side) },
            Motion::None => continue,
        };
        match legs.last_mut() {
            Some(same) if before == motion => *same = leg,
            _ => legs.push(leg),
        }
        before = motion;
    }
    legs
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: GrownBox = GrownBox { half_length_m: 0.313, half_width_m: 0.2525, growth_m: 0.0 };
    const LEAST_M: f64 = 0.03;

    /// A wall at x = 0.6 with a gap, and two along x from there on, as far apart.
    fn gap(gap_m: f64) -> Vec<Point2> {
        let beside = (0..=28).map(|i| (0.6 + 0.05 * f64::from(i), 0.0));
        let across = (0..=40).map(|i| (0.6, 0.05 * f64::from(i)));
        beside
            .chain(across)
            .flat_map(|(x, y)| [-1.0, 1.0].map(|side| Point2::new(x, side * (gap_m / 2.0 + y))))
            .collect()
    }

    fn through(gap_m: f64, start: Pose2) -> Option<Vec<Leg>> {
        let near = Near::new(gap(gap_m), start.position(), 2.5, BODY);
        find(&near, start, LEAST_M, 1.6, |at| (1.0 - at.x).max(0.0), |pose| pose.x > 1.0)
    }

    /// Every pose that the legs lead through.
    fn poses(start: Pose2, legs: &[Leg]) -> Vec<Pose2> {
        let mut all = vec![start];
        for leg in legs {
            let from = all[all.len() - 1];
            match *leg {
                Leg::Turn { heading_rad, side } => {
                    let by = (side * (heading_rad - from.heading)).rem_euclid(TAU) * side;
                    all.extend(
                        (1..=20).map(|i| Pose2::new(from.x, from.y, from.heading + by * f64::from(i) / 20.0)),
                    );
                }
                Leg::Straight { to, .. } => all.extend((1..=20).map(|i| {
                    let at = from.position() + (to.position() - from.position()) * (f64::from(i) / 20.0);
                    Pose2::new(at.x, at.y, from.heading)
                })),
            }
        }
        all
    }

    #[test]
    fn a_gap_of_two_hands_more_than_the_robot_is_passed_from_every_heading_without_a_touch() {
        for degrees in [0, 10, -20, 30, 75, 140, -110, 180] {
            let start = Pose2::new(0.1, 0.1, f64::from(degrees).to_radians());
            let legs = through(0.69, start).unwrap_or_else(|| panic!("no way in from {degrees}°"));
            let near = Near::new(gap(0.69), start.position(), 2.5, BODY);
            let least_m =
                poses(start, &legs).into_iter().map(|pose| near.clearance_m(pose, 1.0)).fold(1.0, f64::min);
            assert!(least_m > LEAST_M - 0.02, "from {degrees}°: {least_m}");
        }
    }

    #[test]
    fn a_robot_wedged_at_a_slant_backs_off_before_it_aligns() {
        let start = Pose2::new(0.36, 0.0, 0.35);
        let legs = through(0.69, start).expect("a way in");
        assert!(matches!(legs[0], Leg::Straight { direction, .. } if direction < 0.0), "{legs:?}");
        assert!(legs.iter().any(|leg| matches!(leg, Leg::Turn { side, .. } if *side < 0.0)), "{legs:?}");
    }

    #[test]
    fn a_gap_narrower_than_the_robot_is_not_passed() {
        assert_eq!(through(0.5, Pose2::new(0.0, 0.0, 0.0)), None);
    }

    #[test]
    fn one_question_has_one_answer() {
        let start = Pose2::new(0.0, 0.2, 1.0);
        assert_eq!(through(0.7, start), through(0.7, start));
    }
}
