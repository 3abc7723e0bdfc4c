use std::f64::consts::{PI, TAU};

use super::contact::GrownBox;
use super::record::Side;
use crate::geometry::{Point2, wrap_angle};

/// Headings that are looked at for a way out, per turn.
const HEADINGS: usize = 72;
const STEP_RAD: f64 = TAU / HEADINGS as f64;

/// A turn on the spot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    pub side: Side,
    /// How far to turn, positive \[rad\].
    pub angle_rad: f64,
    /// How far it could turn before a contact \[rad\].
    pub free_rad: f64,
    /// Whether the way wanted is free there.
    pub open: bool,
}

/// How far the outline can turn in place to one side before it meets an obstacle \[rad\].
pub(super) fn free_turn_rad(outline: &GrownBox, nearest_first: &[(f64, Point2)], side: Side) -> f64 {
    let radius_m = outline.radius_m();
    nearest_first
        .iter()
        .take_while(|(distance_m, _)| *distance_m <= radius_m)
        .map(|&(_, point)| outline.first_contact_turning_rad(point, side == Side::Left))
        .fold(f64::INFINITY, f64::min)
}

/// Where to turn: the heading nearest to the goal's with `wanted_m` of straight way free for
/// `corridor`, else the most open one. `outline` is what must not touch while turning. `keep` is the side the robot turns to already: it stays with it if that leads
/// to a free heading at all, so that it does not waver.
pub(super) fn choose_turn(
    outline: &GrownBox,
    corridor: &GrownBox,
    nearest_first: &[(f64, Point2)],
    goal_bearing_rad: f64,
    wanted_m: f64,
    keep: Option<Side>,
) -> Option<Turn> {
    let free = [Side::Left, Side::Right].map(|side| free_turn_rad(outline, nearest_first, side));
    let mut best: Option<((u8, f64), Turn)> = None;
    // The present heading, then a rose of headings from the goal's on.
    let ways = open_ways(corridor, nearest_first, goal_bearing_rad, wanted_m);
    for (i, open_m) in ways.into_iter().enumerate() {
        let heading = if i == 0 { 0.0 } else { rose_rad(goal_bearing_rad, i - 1) };
        for (side, free_rad) in [Side::Left, Side::Right].into_iter().zip(free) {
            let angle_rad = match side {
                Side::Left => heading.rem_euclid(TAU),
                Side::Right => (-heading).rem_euclid(TAU),
            };
            if angle_rad > free_rad {
                continue;
            }
            let other_side = keep.is_some_and(|k| k != side);
            let cost = wrap_angle(heading - goal_bearing_rad).abs() + 0.5 * angle_rad / PI;
            let rank = match (open_m >= wanted_m, other_side) {
                (true, false) => (0, cost),
                (true, true) => (1, cost),
                (false, _) => (2, -open_m + 1e-3 * cost + if other_side { 0.1 } else { 0.0 }),
            };
            if best.as_ref().is_none_or(|(r, _)| rank < *r) {
                let open = rank.0 < 2;
                best = Some((rank, Turn { side, angle_rad, free_rad, open }));
            }
        }
    }
    best.map(|(_, turn)| turn)
}

/// Heading `i` of the rose that begins at the goal's \[rad\].
fn rose_rad(goal_bearing_rad: f64, i: usize) -> f64 {
    wrap_angle(goal_bearing_rad + i as f64 * STEP_RAD)
}

/// Free way straight on, up to `wanted_m`, at the present heading and at every heading of the rose.
///
/// A point is asked only of the headings whose line passes within the corridor's radius of it.
fn open_ways(
    corridor: &GrownBox,
    nearest_first: &[(f64, Point2)],
    goal_bearing_rad: f64,
    wanted_m: f64,
) -> [f64; HEADINGS + 1] {
    let mut open_m = [wanted_m; HEADINGS + 1];
    let mut sines = [(0.0, 1.0); HEADINGS + 1];
    for (i, sine) in sines.iter_mut().enumerate().skip(1) {
        *sine = rose_rad(goal_bearing_rad, i - 1).sin_cos();
    }
    let radius_m = corridor.radius_m();
    for &(distance_m, point) in nearest_first {
        if distance_m - radius_m >= wanted_m {
            break;
        }
        let mut ask = |i: usize| {
            if distance_m - radius_m < open_m[i] {
                let (sin, cos) = sines[i];
                let seen = Point2::new(cos * point.x + sin * point.y, -sin * point.x + cos * point.y);
                open_m[i] = corridor.first_contact_m(seen, 0.0).min(open_m[i]);
            }
        };
        ask(0);
        if distance_m <= radius_m {
            (1..=HEADINGS).for_each(&mut ask);
            continue;
        }
        let from_goal = (point.y.atan2(point.x) - goal_bearing_rad) / STEP_RAD;
        let half = (radius_m / distance_m).asin() / STEP_RAD;
        let (from, to) = ((from_goal - half).floor() as i64, (from_goal + half).ceil() as i64);
        (from..=to.min(from + HEADINGS as i64 - 1))
            .for_each(|i| ask(1 + i.rem_euclid(HEADINGS as i64) as usize));
    }
    open_m
}
