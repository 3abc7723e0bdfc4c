use cairn::geometry::{Point2, Pose2, wrap_angle};
use cairn::locate::{MapMatcher, MatchingConfig, Odometry, OdometryConfig, WheelTravel};

use crate::rooms::{Noise, Rooms, TICK_S, drive, p3at};

/// 16 × 10 m: a corridor 2 m wide with three rooms on each side, doors of 1 m.
fn office() -> Rooms {
    let mut rooms = Rooms::default().block(0.0, 0.0, 16.0, 10.0);
    for y in [4.0, 6.0] {
        for (x0, x1) in [(0.0, 2.0), (3.0, 7.5), (8.5, 13.0), (14.0, 16.0)] {
            rooms = rooms.block(x0, y - 0.05, x1, y + 0.05);
        }
    }
    for x in [5.0, 11.0] {
        rooms = rooms.block(x - 0.05, 0.0, x + 0.05, 3.95).block(x - 0.05, 6.05, x + 0.05, 10.0);
    }
    rooms.block(0.05, 0.05, 0.6, 1.4).block(9.0, 8.5, 10.6, 9.3).block(14.5, 7.0, 15.9, 7.8)
}

fn route() -> Vec<Pose2> {
    drive(
        &[
            (1.0, 5.0),
            (2.5, 5.0),
            (2.5, 2.0),
            (3.8, 2.0),
            (2.5, 2.6),
            (2.5, 5.0),
            (8.0, 5.0),
            (8.0, 8.0),
            (6.5, 8.0),
            (8.0, 7.4),
            (8.0, 5.0),
            (13.5, 5.0),
            (13.5, 2.0),
            (13.5, 5.0),
            (1.5, 5.0),
            (8.0, 5.0),
            (8.0, 2.0),
            (9.5, 2.0),
        ],
        0.5,
    )
}

struct Errors {
    worst_m: f64,
    last_m: f64,
    worst_rad: f64,
    path_m: f64,
}

/// Drives the route with wheels 2 % off in scale, a gyro that drifts 0.3°/min, and wheels that slip.
fn errors(walls: &Rooms, matched: bool, seed: u64) -> Errors {
    let profile = p3at();
    let known = office().surveyed(Point2::new(-0.5, -0.5), Point2::new(16.5, 10.5), 0.05);
    let matcher = MapMatcher::new(&MatchingConfig::default(), &known).unwrap();
    let poses = route();
    let mut odometry = Odometry::new(&OdometryConfig::default(), &profile.drive, poses[0]).unwrap();
    let mut noise = Noise(seed);
    let mut out = Errors { worst_m: 0.0, last_m: 0.0, worst_rad: 0.0, path_m: 0.0 };
    for pair in poses.windows(2) {
        let moved = pair[0].inverse() * pair[1];
        let (path, turn) = (moved.x.hypot(moved.y), moved.heading);
        let half = turn * profile.drive.effective_track_m / 2.0;
        let slip = |n: &mut Noise| 1.0 + 0.05 * n.normal();
        let wheels = WheelTravel {
            left_m: (path * 1.02 - half * 0.95) * slip(&mut noise),
            right_m: (path * 1.02 + half * 0.95) * slip(&mut noise),
        };
        let gyro = turn / TICK_S + (0.3f64 / 60.0).to_radians() + 0.3f64.to_radians() * noise.normal();
        odometry.predict(wheels, Some(gyro), TICK_S).unwrap();
        let ranges = walls.sense(pair[1], &profile, &mut noise);
        if matched {
            matcher.correct(&mut odometry, &profile, &ranges).unwrap();
        }
        let off = odometry.pose();
        out.last_m = off.position().distance(pair[1].position());
        out.worst_m = out.worst_m.max(out.last_m);
        out.worst_rad = out.worst_rad.max(wrap_angle(off.heading - pair[1].heading).abs());
        out.path_m += path;
    }
    out
}

fn with_boxes() -> Rooms {
    office()
        .block(4.5, 5.3, 5.0, 5.9)
        .block(10.0, 4.1, 10.6, 4.6)
        .block(11.9, 5.6, 12.4, 5.95)
        .block(3.4, 3.0, 4.0, 3.6)
        .block(6.0, 6.3, 6.6, 6.9)
        .block(5.5, 4.06, 6.3, 4.3)
        .block(14.9, 1.0, 15.4, 1.6)
}

#[test]
fn sonar_matched_to_the_map_keeps_a_drifting_robot_within_fifteen_centimetres() {
    for seed in 0..3 {
        let (matched, alone) = (errors(&office(), true, seed), errors(&office(), false, seed));
        assert!(matched.path_m > 55.0);
        assert!(matched.worst_m < 0.15, "seed {seed}: {}", matched.worst_m);
        assert!(matched.last_m < 0.06, "seed {seed}: {}", matched.last_m);
        assert!(matched.worst_rad < 2f64.to_radians(), "seed {seed}: {}", matched.worst_rad);
        assert!(alone.worst_m > 1.5 * matched.worst_m, "seed {seed}: alone {}", alone.worst_m);
    }
}

#[test]
fn boxes_the_map_does_not_show_do_not_pull_the_pose_away() {
    for seed in 0..3 {
        let matched = errors(&with_boxes(), true, seed);
        assert!(matched.worst_m < 0.2, "seed {seed}: {}", matched.worst_m);
    }
}

#[test]
fn a_correction_is_never_larger_than_its_bounds_and_silence_corrects_nothing() {
    let profile = p3at();
    let known = office().surveyed(Point2::new(-0.5, -0.5), Point2::new(16.5, 10.5), 0.05);
    let config = MatchingConfig::default();
    let matcher = MapMatcher::new(&config, &known).unwrap();
    let start = OdometryConfig { start_m: 0.3, start_rad: 0.1, ..OdometryConfig::default() };
    let mut noise = Noise(3);
    for k in 0..60 {
        let truth = Pose2::new(1.0 + 0.2 * f64::from(k), 5.0, 0.0);
        let off =
            Pose2::new(truth.x + 0.2 * noise.normal(), 5.0 + 0.2 * noise.normal(), 0.1 * noise.normal());
        let mut odometry = Odometry::new(&start, &profile.drive, off).unwrap();
        let ranges = office().sense(truth, &profile, &mut noise);
        let report = matcher.correct(&mut odometry, &profile, &ranges).unwrap();
        assert!(report.correction.position().norm() <= config.most_m + 1e-12);
        assert!(report.correction.heading.abs() <= config.most_rad + 1e-12);
        let moved = odometry.pose().position().distance(off.position());
        assert!((moved - report.correction.position().norm()).abs() < 1e-12);

        let (pose, covariance) = (odometry.pose(), odometry.covariance());
        for silent in [f64::INFINITY, f64::NAN] {
            let report = matcher.correct(&mut odometry, &profile, &[silent; 16]).unwrap();
            assert_eq!((report.used, report.rejected), (0, 0));
        }
        assert_eq!((odometry.pose(), odometry.covariance()), (pose, covariance));
    }
}

#[test]
fn a_robot_that_stands_a_little_off_is_brought_back_by_what_it_hears() {
    let profile = p3at();
    let known = office().surveyed(Point2::new(-0.5, -0.5), Point2::new(16.5, 10.5), 0.05);
    let matcher = MapMatcher::new(&MatchingConfig::default(), &known).unwrap();
    let start = OdometryConfig { start_m: 0.15, start_rad: 0.05, ..OdometryConfig::default() };
    let truth = Pose2::new(1.0, 5.0, 0.0);
    let mut odometry = Odometry::new(&start, &profile.drive, Pose2::new(1.1, 4.88, 0.03)).unwrap();
    let mut noise = Noise(5);
    for _ in 0..60 {
        let ranges = office().sense(truth, &profile, &mut noise);
        matcher.correct(&mut odometry, &profile, &ranges).unwrap();
    }
    assert!((odometry.pose().y - truth.y).abs() < 0.04, "{:?}", odometry.pose());
    assert!((odometry.pose().x - truth.x).abs() < 0.06, "{:?}", odometry.pose());
}
