use super::support::{Dice, LIMITS, P3AT, block, drive_by, towards, wall};
use crate::avoid::{AvoidanceRecord, Cvm, CvmConfig, Why};
use crate::geometry::{Point2, Pose2, Twist2};

fn cvm() -> Cvm {
    Cvm::new(&CvmConfig::default(), &LIMITS, &P3AT).unwrap()
}

/// A wall across the way, `gap_m` before the bumper.
fn nose_to_wall(gap_m: f64) -> Vec<Point2> {
    wall((0.313 + gap_m, -1.5), (0.313 + gap_m, 1.5))
}

fn step(pose: Pose2, twist: Twist2, wanted: Twist2) -> (Pose2, Twist2) {
    let next = LIMITS.reachable(twist, wanted, 0.02);
    let mean = Twist2::new(
        (twist.linear_mps + next.linear_mps) / 2.0,
        (twist.angular_radps + next.angular_radps) / 2.0,
    );
    (pose.moved(mean, 0.02), next)
}

/// Drives from rest; calls `look` with every record, pose and twist.
fn drive(
    config: &CvmConfig,
    goal: Point2,
    obstacles: &[Point2],
    seconds: f64,
    look: impl FnMut(&AvoidanceRecord, Pose2, Twist2),
) -> Pose2 {
    drive_by(config, Pose2::IDENTITY, goal, obstacles, seconds, towards(goal), look).pose
}

#[test]
fn nose_to_a_wall_it_backs_out_slowly_and_then_turns() {
    for gap_m in [0.04, 0.055, 0.08, 0.11, 0.14] {
        let (mut backed, mut turned_at) = (0, None);
        let goal = Point2::new(0.0, 3.0);
        let obstacles = nose_to_wall(gap_m);
        let end = drive(&CvmConfig::default(), goal, &obstacles, 60.0, |record, pose, twist| {
            backed += usize::from(matches!(record.why, Why::BackingOut { .. }));
            if matches!(record.why, Why::TurningInPlace { .. }) && turned_at.is_none() {
                turned_at = Some(pose.x);
            }
            assert!(twist.linear_mps >= -0.15 - 1e-9);
            let back = pose.inverse();
            let clearance_m = obstacles.iter().map(|&p| P3AT.distance(back * p)).fold(9.0, f64::min);
            assert!(clearance_m >= gap_m.min(0.055) - 0.005, "gap {gap_m}: {clearance_m}");
        });
        assert!(backed > 0, "gap {gap_m}: never backed");
        assert!(turned_at.is_some_and(|x| x < -0.02), "gap {gap_m}: turned at {turned_at:?}");
        assert!(end.position().distance(goal) < 0.25, "gap {gap_m}: ended at {end:?}");
    }
}

#[test]
fn out_of_a_box_canyon_it_backs_until_it_can_turn_about() {
    // A sack 0.75 m wide and 1 m deep, its opening behind the robot: too narrow to turn in.
    let mut obstacles = wall((0.42, -0.375), (0.42, 0.375));
    obstacles.extend(wall((-0.6, 0.375), (0.42, 0.375)));
    obstacles.extend(wall((-0.6, -0.375), (0.42, -0.375)));
    let goal = Point2::new(-1.2, 2.5);
    let mut least_m = f64::INFINITY;
    let end = drive(&CvmConfig::default(), goal, &obstacles, 60.0, |_, pose, _| {
        let back = pose.inverse();
        least_m = obstacles.iter().map(|&p| P3AT.distance(back * p)).fold(least_m, f64::min);
    });
    assert!(end.position().distance(goal) < 0.25, "{end:?}");
    assert!(least_m > 0.05, "{least_m}");
}

#[test]
fn walled_in_behind_too_it_does_not_back() {
    let mut obstacles = nose_to_wall(0.08);
    obstacles.extend(wall((-0.313 - 0.08, -1.5), (-0.313 - 0.08, 1.5)));
    let record = cvm().choose(Twist2::ZERO, 1.5, 3.0, &obstacles, 0.1);
    assert!(!matches!(record.why, Why::BackingOut { .. }), "{:?}", record.why);
    assert!(record.twist.linear_mps >= 0.0);
}

#[test]
fn without_leave_to_back_out_no_command_runs_backward() {
    let config = CvmConfig { back_out: false, ..CvmConfig::default() };
    drive(&config, Point2::new(0.0, 3.0), &nose_to_wall(0.05), 20.0, |record, _, _| {
        assert!(record.twist.linear_mps >= 0.0 && !matches!(record.why, Why::BackingOut { .. }));
    });
}

#[test]
fn with_way_ahead_it_never_backs_from_rest() {
    for gap_m in [0.8, 1.2, 2.0] {
        let record = cvm().choose(Twist2::ZERO, 0.0, 5.0, &nose_to_wall(gap_m), 0.1);
        assert!(!matches!(record.why, Why::BackingOut { .. }), "{:?}", record.why);
    }
}

#[test]
fn backing_out_and_then_stopping_never_comes_near_what_is_seen() {
    let mut dice = Dice(31);
    let mut backed = 0;
    for i in 0..1500 {
        let mut obstacles = nose_to_wall(dice.between(0.04, 0.16));
        for _ in 0..3 {
            let (x, y) = (dice.between(-1.8, 0.2), dice.between(-0.9, 0.9));
            obstacles.extend(block((x, y), dice.between(0.05, 0.3), dice.between(0.05, 0.3)));
        }
        obstacles.retain(|&p| P3AT.distance(p) > 0.037);
        let moving = i % 2 == 0;
        let current = Twist2::new(if moving { dice.between(-0.15, 0.0) } else { 0.0 }, 0.0);
        let pending = if moving { current } else { Twist2::ZERO };
        let bearing = dice.between(-3.0, 3.0);
        let record = cvm().choose_after(current, Some(pending), bearing, 3.0, &obstacles, 0.1);
        if !matches!(record.why, Why::BackingOut { .. }) {
            continue;
        }
        backed += 1;
        assert!(record.twist.linear_mps >= -0.15 - 1e-12 && record.twist.linear_mps <= 0.0);
        let now_m: Vec<f64> = obstacles.iter().map(|&p| P3AT.distance(p)).collect();
        // The braking motion in small steps, by code of its own.
        let (mut pose, mut twist) = (Pose2::IDENTITY, current);
        for k in 0..100 {
            let wanted = match k {
                0..=4 => pending,
                5..=9 => record.twist,
                _ => Twist2::ZERO,
            };
            let held_curvature = k >= 10 && twist.linear_mps.abs() > 1e-6;
            let before = twist;
            (pose, twist) = step(pose, twist, wanted);
            if held_curvature {
                let share = twist.linear_mps / before.linear_mps;
                twist.angular_radps = before.angular_radps * share;
            }
            let back = pose.inverse();
            for (&p, now_m) in obstacles.iter().zip(&now_m) {
                let least_m = (0.035 + 0.02_f64).min(now_m - 0.002) - 0.004;
                assert!(P3AT.distance(back * p) >= least_m, "scene {i}: {}", P3AT.distance(back * p));
            }
        }
    }
    assert!(backed > 200, "{backed}");
}
