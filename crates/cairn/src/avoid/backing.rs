//! Straight back, or on a wide arc, until there is room to turn. The paper's robot never reverses;
//! a box that stands nose to a wall cannot turn on the spot without it.

use super::contact::GrownBox;
use super::record::Side;
use super::turning::{choose_turn, free_turn_rad};
use crate::geometry::{Point2, Twist2};

/// Ways back, the straightest first \[1/m\].
const CURVATURES_PER_M: [f64; 5] = [0.0, 0.4, -0.4, 1.0, -1.0];
/// Where on its way back the robot looks for room to turn \[m\].
const STOPS_M: [f64; 13] = [0.0, 0.06, 0.12, 0.18, 0.25, 0.35, 0.45, 0.6, 0.75, 0.9, 1.1, 1.3, 1.5];
/// The way back is looked at this often \[m\].
const STRIDE_M: f64 = 0.02;
/// Way behind that must be clear beyond the place to turn: enough to stop there \[m\].
pub(super) const BEYOND_M: f64 = 0.08;
/// Room to turn that is asked for beyond the outline \[m\]: once there, the turn stays free.
pub(super) const EXTRA_ROOM_M: f64 = 0.05;

/// A way back to a place where the robot can turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WayBack {
    /// Of the arc as driven forward; driven backward it turns the other way \[1/m\].
    pub curvature_per_m: f64,
    /// To the place to turn \[m\]; 0: here.
    pub length_m: f64,
    /// What is clear behind, at least `length_m` \[m\].
    pub clear_m: f64,
}

/// What must stay true of every seen obstacle while the robot leaves or backs out.
///
/// Away from all, the body stays `least_m` off; what is nearer already must not come nearer.
#[derive(Clone, Debug)]
pub(super) struct Keep<'a> {
    body: GrownBox,
    points: &'a [(f64, Point2)],
    least_m: f64,
    /// Farther than this from the robot's centre nothing is nearer than `least_m`.
    near_m: f64,
    now_m: Vec<f64>,
}

/// Points at most this far from one that is kept are left out when places to turn are looked for:
/// less than the extra room there \[m\].
const THINNED_M: f64 = 0.02;

/// One point of every square that holds any: the nearest to the robot.
fn thinned(nearest_first: &[(f64, Point2)]) -> Vec<(f64, Point2)> {
    let side_m = THINNED_M / std::f64::consts::SQRT_2;
    let cell = |p: Point2| ((p.x / side_m).floor() as i64, (p.y / side_m).floor() as i64);
    let mut held = std::collections::HashSet::with_capacity(nearest_first.len());
    nearest_first.iter().copied().filter(|&(_, p)| held.insert(cell(p))).collect()
}

/// What a distance may fall by although it must not: rounding, and the curve of a straight wall.
const SLACK_M: f64 = 0.002;

impl<'a> Keep<'a> {
    pub fn new(body: GrownBox, nearest_first: &'a [(f64, Point2)], least_m: f64, reach_m: f64) -> Self {
        let reach_m = reach_m + body.radius_m() + least_m;
        let count = nearest_first.partition_point(|&(distance_m, _)| distance_m <= reach_m);
        let points = &nearest_first[..count];
        let now_m = points.iter().map(|&(_, p)| body.distance(p) - body.growth_m).collect();
        Self { body, points, least_m, near_m: body.radius_m() + least_m, now_m }
    }

    /// Whether it is so with the robot at `pose`, seen from where it stands now.
    pub fn holds(&self, robot_from_start: crate::geometry::Pose2, travelled_m: f64) -> bool {
        let reach_m = self.near_m + travelled_m;
        let robot_from_start = robot_from_start.turned();
        self.points.iter().zip(&self.now_m).take_while(|((d, _), _)| *d <= reach_m).all(
            |(&(_, p), &now_m)| {
                let then_m = self.body.distance(robot_from_start * p) - self.body.growth_m;
                then_m >= self.least_m.min(now_m - SLACK_M)
            },
        )
    }

    /// How far back the robot can run on an arc \[m\], at most `most_m`.
    fn clear_m(&self, curvature_per_m: f64, most_m: f64) -> f64 {
        let steps = (most_m / STRIDE_M).ceil() as usize;
        for i in 1..=steps {
            let length_m = i as f64 * STRIDE_M;
            let pose = Twist2::new(-1.0, -curvature_per_m).displacement(length_m);
            if !self.holds(pose.inverse(), length_m) {
                return length_m - STRIDE_M;
            }
        }
        most_m
    }
}

/// The straightest clear way back to the nearest place where the robot can turn to a heading with
/// `wanted_m` of free way, or at least turn about; `None` if there is none.
///
/// `outline` is what must turn freely there; `backing` says that the robot runs back already, so
/// that the place may be here.
pub(super) fn way_back(
    keep: &Keep,
    outline: &GrownBox,
    corridor: &GrownBox,
    nearest_first: &[(f64, Point2)],
    goal_bearing_rad: f64,
    wanted_m: f64,
    backing: bool,
) -> Option<WayBack> {
    let thinned = thinned(nearest_first);
    let nearest_first = &thinned[..];
    let most_m = STOPS_M[STOPS_M.len() - 1] + BEYOND_M;
    let room = outline.grown(EXTRA_ROOM_M);
    let can_turn_about = |points: &[(f64, Point2)]| points.iter().all(|&(d, _)| d > room.radius_m());
    let stuck_here = !can_turn_about(nearest_first);
    let mut roomy: Option<WayBack> = None;
    for curvature_per_m in CURVATURES_PER_M {
        let clear_m = keep.clear_m(curvature_per_m, most_m);
        for length_m in STOPS_M {
            let here = length_m == 0.0;
            if here && !backing {
                continue;
            }
            if !here && length_m + BEYOND_M > clear_m {
                break;
            }
            let pose = Twist2::new(-1.0, -curvature_per_m).displacement(length_m);
            let there_from_here = pose.inverse().turned();
            let reach_m = wanted_m + corridor.radius_m();
            let mut points: Vec<(f64, Point2)> = nearest_first
                .iter()
                .map(|&(_, p)| there_from_here * p)
                .map(|p| (p.norm(), p))
                .filter(|&(d, _)| d <= reach_m)
                .collect();
            points.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            let way = WayBack { curvature_per_m, length_m, clear_m };
            // Nothing to be found where it cannot turn at all.
            let turns = [Side::Left, Side::Right].map(|side| free_turn_rad(&room, &points, side));
            if turns[0].max(turns[1]) < 0.1 {
                continue;
            }
            let bearing_rad = goal_bearing_rad - pose.heading;
            let turn = choose_turn(&room, corridor, &points, bearing_rad, wanted_m, None);
            if turn.is_some_and(|turn| turn.open) {
                return Some(way);
            }
            if roomy.is_none() && stuck_here && can_turn_about(&points) {
                roomy = Some(way);
            }
        }
    }
    roomy
}
