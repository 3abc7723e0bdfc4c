//! No chosen command's braking motion meets a seen obstacle: for every way of choosing, whatever the
//! latency. Closed loops ask it at every tick (`support::drive_by`); here it is asked of random states.

use super::common::Chosen;
use super::oracle::scene;
use super::support::{Asked, Dice, LIMITS, P3AT, Run, TICK_S, block, drive_by, towards, wall};
use crate::avoid::{Cvm, CvmConfig, Guide, Moving, Why};
use crate::geometry::{Point2, Pose2, Twist2};

/// A field without walls: straight to the goal, or first to where the robot must pass, both seen from it.
struct Ways {
    goal: Point2,
    over: Option<Point2>,
}

const S_PER_M: f64 = 2.0;

impl Guide for Ways {
    fn to_go(&self, point_in_robot: Point2) -> (f64, f64) {
        let next = self.over.unwrap_or(self.goal);
        let away = next - point_in_robot;
        (S_PER_M * (away.norm() + next.distance(self.goal)), away.y.atan2(away.x))
    }

    fn price(&self, _: Point2) -> f64 {
        S_PER_M
    }
}

fn configs() -> impl Iterator<Item = CvmConfig> {
    [0.0, 0.05, 0.1, 0.25].into_iter().map(|latency_s| CvmConfig { latency_s, ..CvmConfig::default() })
}

/// A twist that is likely, and one command before it that may be likewise.
fn motion(dice: &mut Dice, i: usize) -> (Twist2, Twist2) {
    match i % 4 {
        0 => (Twist2::ZERO, Twist2::ZERO),
        1 => (Twist2::new(0.0, dice.between(-0.8, 0.8)), Twist2::new(0.0, dice.between(-0.8, 0.8))),
        2 => (Twist2::new(dice.between(-0.15, 0.0), 0.0), Twist2::new(dice.between(-0.15, 0.0), 0.0)),
        _ => {
            let now = Twist2::new(dice.between(0.0, 0.7), dice.between(-1.2, 1.2));
            let (more_mps, more_radps) = (dice.between(-0.05, 0.05), dice.between(-0.2, 0.2));
            (now, Twist2::new((now.linear_mps + more_mps).max(0.0), now.angular_radps + more_radps))
        }
    }
}

/// Kinds of choice, how often each was made.
#[derive(Default, Debug)]
struct Counts {
    arcs: usize,
    turns: usize,
    backs: usize,
    leaves: usize,
    gives_way: usize,
    brakes: usize,
}

impl Counts {
    /// Counts a choice; false for one to brake, which may come too late in a state that nobody chose.
    fn count(&mut self, why: &Why) -> bool {
        let counter = match why {
            Why::BestArc => &mut self.arcs,
            Why::TurningInPlace { .. } => &mut self.turns,
            Why::BackingOut { .. } => &mut self.backs,
            Why::LeavingObstacle { .. } => &mut self.leaves,
            Why::GivingWay { .. } => &mut self.gives_way,
            Why::Braking { .. } => &mut self.brakes,
        };
        *counter += 1;
        !matches!(why, Why::Braking { .. })
    }
}

#[test]
fn by_the_paper_s_objective_no_braking_motion_meets_a_seen_obstacle_whatever_the_latency() {
    for config in configs() {
        let cvm = Cvm::new(&config, &LIMITS, &P3AT).unwrap();
        let (mut dice, mut counts) = (Dice(13), Counts::default());
        for i in 0..1200 {
            let scene = scene(&mut dice);
            let (now, pending) = motion(&mut dice, i);
            let record =
                cvm.choose_after(now, Some(pending), scene.bearing, scene.distance, &scene.obstacles, TICK_S);
            if counts.count(&record.why) {
                let chosen = Chosen {
                    now,
                    pending,
                    command: record.twist,
                    latency_s: config.latency_s,
                    tick_s: TICK_S,
                };
                let gap_m = chosen.least_gap_m(&LIMITS, &P3AT, &scene.obstacles);
                let least_m = if record.why == Why::BestArc { config.obstacle_radius_m } else { 0.0 };
                assert!(gap_m > least_m, "scene {i}: {gap_m:.3} m, {:?}, {chosen:?}", record.why);
            }
        }
        let Counts { arcs, turns, backs, .. } = counts;
        assert!(arcs > 300 && turns > 30 && backs > 10, "{counts:?}");
    }
}

#[test]
fn guided_by_a_field_no_braking_motion_meets_a_seen_obstacle_whatever_the_latency() {
    for config in configs() {
        let cvm = Cvm::new(&config, &LIMITS, &P3AT).unwrap();
        let (mut dice, mut counts) = (Dice(14), Counts::default());
        for i in 0..1200 {
            let scene = scene(&mut dice);
            let (now, pending) = motion(&mut dice, i);
            let (sin, cos) = scene.bearing.sin_cos();
            let guide = Ways { goal: Point2::new(cos, sin) * scene.distance, over: None };
            let thing = Moving {
                center: Point2::new(dice.between(1.0, 3.0), dice.between(-1.5, 1.5)),
                radius_m: 0.3,
                velocity_mps: Point2::new(dice.between(-0.5, 0.5), dice.between(-0.5, 0.5)),
            };
            let moving = if i % 3 == 0 { &[thing][..] } else { &[] };
            let record =
                cvm.choose_guided(now, pending, &guide, &scene.obstacles, moving, scene.distance, TICK_S);
            if counts.count(&record.why) {
                let chosen = Chosen {
                    now,
                    pending,
                    command: record.twist,
                    latency_s: config.latency_s,
                    tick_s: TICK_S,
                };
                let gap_m = chosen.least_gap_m(&LIMITS, &P3AT, &scene.obstacles);
                assert!(gap_m > 0.0, "scene {i}: {gap_m:.3} m, {:?}, {chosen:?}", record.why);
            }
        }
        let Counts { arcs, turns, backs, gives_way, .. } = counts;
        assert!(arcs > 300 && turns > 30 && backs > 10 && gives_way > 100, "{counts:?}");
    }
}

/// Before the opening of the sack.
const MOUTH: Point2 = Point2 { x: -1.2, y: 0.0 };

/// Posts, and a sack with the robot in it, its nose to the end and its opening behind.
fn places(seed: u64) -> Vec<Point2> {
    let mut dice = Dice(seed);
    let mut obstacles = wall((0.42, -0.375), (0.42, 0.375));
    obstacles.extend(wall((-0.6, 0.375), (0.42, 0.375)));
    obstacles.extend(wall((-0.6, -0.375), (0.42, -0.375)));
    for _ in 0..8 {
        let (x, y) = (dice.between(-4.0, 3.0), dice.between(-3.0, -1.2));
        obstacles.extend(block((x, y), dice.between(0.05, 0.4), dice.between(0.05, 0.4)));
    }
    obstacles
}

/// Out of the sack and on among the posts, held at every tick to a braking motion that touches nothing.
fn driven(seed: u64, latency_s: f64, guided: bool) -> Run {
    let config = CvmConfig { latency_s, ..CvmConfig::default() };
    let goal = Point2::new(-1.2 + 0.2 * seed as f64, 2.5);
    let by_objective = towards(goal);
    let choose = |cvm: &Cvm, asked: &Asked| {
        if !guided {
            return by_objective(cvm, asked);
        }
        let robot_from_world = asked.pose.inverse();
        let inside = asked.pose.x > MOUTH.x + 0.1;
        let guide = Ways { goal: robot_from_world * goal, over: inside.then(|| robot_from_world * MOUTH) };
        let goal_m = guide.goal.norm();
        cvm.choose_guided(asked.twist, asked.pending, &guide, asked.seen, &[], goal_m, TICK_S)
    };
    drive_by(&config, Pose2::IDENTITY, goal, &places(seed), 40.0, choose, |_, _, _| {})
}

#[test]
fn at_every_tick_of_every_drive_the_braking_motion_of_the_command_touches_nothing() {
    for guided in [false, true] {
        let (mut arrived, mut backed, mut turned) = (0, 0, 0);
        for seed in 0..6 {
            for latency_s in [0.0, 0.05, 0.1] {
                let run = driven(seed, latency_s, guided);
                assert!(run.clearance_m > 0.0, "seed {seed}, latency {latency_s}: {}", run.clearance_m);
                arrived += usize::from(run.arrived);
                backed += run.count(|why| matches!(why, Why::BackingOut { .. }));
                turned += run.count(|why| matches!(why, Why::TurningInPlace { .. }));
            }
        }
        assert!(backed > 100 && turned > 100, "guided {guided}: {backed} back, {turned} turns");
        // The guide here knows no walls; a real field's is for the tests of the lidar.
        assert!(guided || arrived >= 9, "{arrived} of 18 arrived");
    }
}

#[test]
fn a_command_that_comes_too_late_is_not_taken_for_one_in_time() {
    // The oracle itself: at 0.6 m/s a wall 0.7 m ahead of the bumper is stopped before, 0.55 m is not.
    let now = Twist2::new(0.6, 0.0);
    let gap_m = |ahead_m: f64| {
        let seen = wall((0.313 + ahead_m, -1.0), (0.313 + ahead_m, 1.0));
        let chosen = Chosen { now, pending: now, command: Twist2::ZERO, latency_s: 0.1, tick_s: TICK_S };
        chosen.least_gap_m(&LIMITS, &P3AT, &seen)
    };
    // 0.06 m in the latency, then 0.6² / 2a = 0.6 m.
    assert!((gap_m(0.7) - 0.04).abs() < 0.002 && gap_m(0.55) == 0.0, "{} {}", gap_m(0.7), gap_m(0.55));
}

#[test]
fn what_is_too_far_to_be_met_before_rest_changes_nothing_of_what_keeps_clear() {
    let mut dice = Dice(23);
    let (mut clear, mut met) = (0, 0);
    for _ in 0..2000 {
        let scene = scene(&mut dice);
        let cvm = Cvm::new(&CvmConfig::default(), &LIMITS, &P3AT).unwrap();
        let mut twist = || Twist2::new(dice.between(-0.2, 0.7), dice.between(-2.0, 2.0));
        let (pending, command) = (twist(), twist());
        let all = cvm.nearest_first(&scene.obstacles);
        let of_all = cvm.keeps_clear_of(scene.current, pending, command, &all, 0.1);
        assert_eq!(cvm.keeps_clear(scene.current, pending, command, &scene.obstacles, 0.1), of_all);
        if of_all { clear += 1 } else { met += 1 }
    }
    assert!(clear > 200 && met > 200, "{clear} clear, {met} not");
}

#[test]
fn a_robot_that_stands_nearer_than_anything_may_slide_along_or_leaves_but_comes_no_nearer() {
    let cvm = Cvm::new(&CvmConfig::default(), &LIMITS, &P3AT).unwrap();
    let beside = |gap_m: f64| {
        let y = P3AT.width_m / 2.0 + gap_m;
        (-20..=20).map(|i| Point2::new(0.05 * f64::from(i), y)).collect::<Vec<_>>()
    };
    for gap_m in [0.012, 0.02, 0.03] {
        let keeps = |command| cvm.keeps_off(Twist2::ZERO, Twist2::ZERO, command, &beside(gap_m), TICK_S);
        assert!([-0.1, 0.1].into_iter().all(|v| keeps(Twist2::new(v, 0.0))), "{gap_m}");
        assert!([-0.4, 0.4].into_iter().all(|w| !keeps(Twist2::new(0.0, w))), "{gap_m}");
        assert!(!keeps(Twist2::new(0.1, 0.3)), "{gap_m}");
    }
}
