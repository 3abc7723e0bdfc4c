use super::support::{Dice, LIMITS, P3AT, block, drive, wall};
use crate::avoid::{BrakeReason, Cvm, CvmConfig, Shape, Why};
use crate::geometry::{Point2, Pose2, Twist2};

#[test]
fn an_empty_place_is_crossed_to_a_goal_in_any_direction() {
    for i in 0..12 {
        let angle = f64::from(i) * std::f64::consts::TAU / 12.0;
        let goal = Point2::new(4.0 * angle.cos(), 4.0 * angle.sin());
        let run = drive(&CvmConfig::default(), Pose2::IDENTITY, goal, &[], 40.0);
        assert!(run.arrived);
    }
}

#[test]
fn a_box_on_the_way_is_driven_round() {
    let obstacles = block((2.5, 0.0), 0.6, 0.6);
    for shape in [Shape::Footprint, Shape::Disc] {
        let config = CvmConfig { shape, ..CvmConfig::default() };
        let run = drive(&config, Pose2::IDENTITY, Point2::new(5.0, 0.0), &obstacles, 60.0);
        assert!(run.arrived && run.clearance_m > 0.0);
    }
}

#[test]
fn a_corridor_is_followed() {
    let mut obstacles = wall((-3.0, 0.8), (10.0, 0.8));
    obstacles.extend(wall((-3.0, -0.8), (10.0, -0.8)));
    obstacles.extend(wall((-3.0, -0.8), (-3.0, 0.8)));
    for heading in [-1.2, -0.5, 0.0, 0.7, 2.8] {
        let run = drive(
            &CvmConfig::default(),
            Pose2::new(0.0, 0.2, heading),
            Point2::new(8.0, 0.0),
            &obstacles,
            60.0,
        );
        assert!(run.arrived && run.clearance_m > 0.0);
    }
}

#[test]
fn a_door_of_one_metre_is_passed_from_many_sides() {
    let mut obstacles = wall((3.0, 0.5), (3.0, 4.0));
    obstacles.extend(wall((3.0, -0.5), (3.0, -4.0)));
    for (y, heading) in [(0.0, 0.0), (0.5, 0.0), (-0.8, 0.3), (1.2, -0.6), (1.5, 0.0), (-1.0, -1.0)] {
        let run = drive(
            &CvmConfig::default(),
            Pose2::new(0.5, y, heading),
            Point2::new(5.0, 0.0),
            &obstacles,
            90.0,
        );
        assert!(run.arrived && run.clearance_m > 0.0);
    }
}

#[test]
fn a_goal_behind_is_turned_to_from_rest_and_from_slow_driving() {
    let cvm = Cvm::new(&CvmConfig::default(), &LIMITS, &P3AT).unwrap();
    let rests = cvm.choose(Twist2::ZERO, 2.5, 4.0, &[], 0.1);
    assert!(matches!(rests.why, Why::TurningInPlace { .. }), "{:?}", rests.why);
    let slow = cvm.choose(Twist2::new(0.25, 0.2), 2.5, 4.0, &[], 0.1);
    assert_eq!(slow.why, Why::Braking { reason: BrakeReason::StopsToTurn });
}

#[test]
fn the_nearer_an_obstacle_the_slower_it_is_passed() {
    let cvm = Cvm::new(&CvmConfig::default(), &LIMITS, &P3AT).unwrap();
    let most_mps = |beside_m: f64| {
        let wall = wall((-3.0, 0.2525 + beside_m), (4.0, 0.2525 + beside_m));
        let record = cvm.choose(Twist2::new(0.2, 0.0), 0.0, 6.0, &wall, 2.0);
        record.candidates.iter().map(|c| c.twist.linear_mps).fold(0.0, f64::max)
    };
    let speeds = [0.1, 0.2, 0.3, 0.45].map(most_mps);
    assert!(speeds.windows(2).all(|pair| pair[0] < pair[1]), "{speeds:?}");
    assert!(speeds[0] <= 0.3 && speeds[3] <= 0.58, "{speeds:?}");
}

#[test]
fn a_robot_that_lags_behind_its_command_still_brakes_at_the_full_rate() {
    let cvm = Cvm::new(&CvmConfig::default(), &LIMITS, &P3AT).unwrap();
    let ahead = wall((0.75, -2.0), (0.75, 2.0));
    let (measured, pending) = (Twist2::new(0.6, 0.0), Twist2::new(0.5, 0.0));
    let record = cvm.choose_after(measured, Some(pending), 0.0, 5.0, &ahead, 0.1);
    assert!(matches!(record.why, Why::Braking { .. }), "{:?}", record.why);
    assert!((record.twist.linear_mps - 0.47).abs() < 1e-9, "{}", record.twist.linear_mps);
}

#[test]
fn posts_are_slalomed_without_a_touch() {
    let mut arrived = 0;
    for seed in 0..50 {
        let mut dice = Dice(seed);
        let mut obstacles = Vec::new();
        for _ in 0..18 {
            let (x, y) = (dice.between(1.2, 7.0), dice.between(-2.5, 2.5));
            obstacles.extend(block((x, y), dice.between(0.05, 0.4), dice.between(0.05, 0.4)));
        }
        let run = drive(&CvmConfig::default(), Pose2::IDENTITY, Point2::new(8.3, 0.0), &obstacles, 90.0);
        assert!(run.clearance_m > 0.035, "seed {seed}: {}", run.clearance_m);
        arrived += usize::from(run.arrived);
    }
    // The others circle in a local minimum, which is for the strategy to see.
    assert!(arrived >= 48, "{arrived} of 50 arrived");
}

#[test]
fn in_a_dead_end_it_turns_and_touches_nothing() {
    let mut obstacles = wall((-1.0, 0.7), (4.0, 0.7));
    obstacles.extend(wall((-1.0, -0.7), (4.0, -0.7)));
    obstacles.extend(wall((4.0, -0.7), (4.0, 0.7)));
    let run = drive(&CvmConfig::default(), Pose2::IDENTITY, Point2::new(6.0, 0.0), &obstacles, 60.0);
    assert!(run.clearance_m > 0.0 && run.count(|why| matches!(why, Why::TurningInPlace { .. })) > 0);
}
