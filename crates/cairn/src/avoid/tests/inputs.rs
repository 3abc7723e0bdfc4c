use super::support::{LIMITS, P3AT, block, wall};
use crate::avoid::{AvoidError, BrakeReason, Cvm, CvmConfig, Why};
use crate::geometry::{Point2, Twist2};

fn cvm() -> Cvm {
    Cvm::new(&CvmConfig::default(), &LIMITS, &P3AT).unwrap()
}

#[test]
fn weights_that_do_not_sum_to_one_are_refused() {
    let config = CvmConfig { speed_weight: 0.5, ..CvmConfig::default() };
    let refused = Cvm::new(&config, &LIMITS, &P3AT).unwrap_err();
    assert!(matches!(refused, AvoidError::AvoidanceWeightsNotOne { .. }));
}

#[test]
fn a_setting_out_of_range_is_refused_by_name() {
    let config = CvmConfig { horizon_m: f64::NAN, ..CvmConfig::default() };
    let refused = Cvm::new(&config, &LIMITS, &P3AT).unwrap_err();
    assert!(matches!(refused, AvoidError::AvoidanceValueOutOfRange { key, .. } if key == "horizon_m"));
}

#[test]
fn an_obstacle_that_is_not_a_number_is_refused_by_its_index_and_the_robot_stands() {
    let obstacles = [Point2::new(1.0, 0.0), Point2::new(f64::NAN, 0.0)];
    let refused = cvm().check(Twist2::ZERO, 0.0, 1.0, &obstacles, 0.1).unwrap_err();
    assert!(matches!(refused, AvoidError::AvoidanceObstacleNotFinite { index: 1, .. }));
    let record = cvm().choose(Twist2::new(0.5, 0.1), 0.0, 1.0, &obstacles, 0.1);
    assert_eq!(record.twist, Twist2::ZERO);
    assert!(matches!(record.why, Why::Braking { reason: BrakeReason::InputRefused { .. } }));
}

#[test]
fn an_empty_scene_is_one_interval_driven_straight_at_the_goal() {
    let record = cvm().choose(Twist2::new(0.7, 0.0), 0.0, 10.0, &[], 0.1);
    assert_eq!(record.intervals.len(), 1);
    assert_eq!(record.twist, Twist2::new(0.7, 0.0));
    assert_eq!(record.why, Why::BestArc);
}

#[test]
fn a_mirrored_scene_is_answered_with_the_mirrored_motion() {
    let obstacles = block((1.6, 0.3), 0.5, 0.4);
    let mirrored: Vec<Point2> = obstacles.iter().map(|p| Point2::new(p.x, -p.y)).collect();
    let one = cvm().choose(Twist2::new(0.3, 0.2), 0.4, 4.0, &obstacles, 0.1);
    let other = cvm().choose(Twist2::new(0.3, -0.2), -0.4, 4.0, &mirrored, 0.1);
    assert!((one.twist.linear_mps - other.twist.linear_mps).abs() < 1e-9);
    assert!((one.twist.angular_radps + other.twist.angular_radps).abs() < 1e-9);
}

#[test]
fn the_same_inputs_give_the_same_record() {
    let obstacles = block((1.2, 0.0), 0.5, 1.4);
    let choose = || cvm().choose(Twist2::new(0.2, 0.1), 0.1, 4.0, &obstacles, 0.1);
    assert_eq!(choose(), choose());
}

#[test]
fn facing_a_wall_at_rest_it_turns_in_place_and_keeps_the_side() {
    let obstacles = wall((0.55, -2.0), (0.55, 2.0));
    let first = cvm().choose(Twist2::ZERO, 0.0, 4.0, &obstacles, 0.1);
    let Why::TurningInPlace { direction, .. } = first.why else { panic!("{:?}", first.why) };
    assert_eq!(first.twist.linear_mps, 0.0);
    // The goal now a little to the other side: the side is kept.
    let side = first.twist.angular_radps.signum();
    let next = cvm().choose(Twist2::new(0.0, 0.3 * side), -0.1 * side, 4.0, &obstacles, 0.1);
    assert!(matches!(next.why, Why::TurningInPlace { direction: d, .. } if d == direction), "{:?}", next.why);
}

#[test]
fn walled_in_with_no_room_to_turn_it_stands_and_says_so() {
    let obstacles = block((0.0, 0.0), 0.626 + 0.16, 0.505 + 0.16);
    let record = cvm().choose(Twist2::ZERO, 0.0, 4.0, &obstacles, 0.1);
    assert_eq!(record.twist, Twist2::ZERO);
    assert!(matches!(record.why, Why::Braking { .. }), "{:?}", record.why);
}

#[test]
fn within_the_margin_of_a_post_it_leaves_and_gains_clearance() {
    for post in [Point2::new(0.0, 0.2525 + 0.05), Point2::new(-0.25, -0.2525 - 0.05)] {
        let record = cvm().choose(Twist2::ZERO, 0.0, 4.0, &[post], 0.1);
        assert!(matches!(record.why, Why::LeavingObstacle { .. }), "{:?}", record.why);
        assert!(record.twist != Twist2::ZERO);
    }
}

#[test]
fn the_record_stays_bounded_among_thousands_of_obstacles() {
    let obstacles: Vec<Point2> =
        (0..60).flat_map(|i| block((2.0, 0.0), 1.0 + 0.01 * f64::from(i), 2.0)).collect();
    let record = cvm().choose(Twist2::new(0.3, 0.0), 0.0, 4.0, &obstacles, 0.1);
    assert!(obstacles.len() > 4000 && record.intervals.len() <= 120);
    assert!(record.candidates.len() <= record.intervals.len());
}
