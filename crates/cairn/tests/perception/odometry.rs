use cairn::geometry::{Point2, Pose2, Twist2, wrap_angle};
use cairn::locate::{Odometry, OdometryConfig, OdometryError, WheelTravel};
use proptest::prelude::*;

use crate::rooms::{Noise, TICK_S, p3at};

fn odometry(config: &OdometryConfig) -> Odometry {
    Odometry::new(config, &p3at().drive, Pose2::IDENTITY).unwrap()
}

/// What perfect wheels show for a path and a turn.
fn wheels(path_m: f64, turn_rad: f64) -> WheelTravel {
    let half = turn_rad * p3at().drive.effective_track_m / 2.0;
    WheelTravel { left_m: path_m - half, right_m: path_m + half }
}

#[test]
fn perfect_wheels_and_gyro_follow_the_exact_arc() {
    for with_gyro in [false, true] {
        let mut o = odometry(&OdometryConfig::default());
        let twist = Twist2::new(0.5, 0.4);
        let mut truth = Pose2::IDENTITY;
        for _ in 0..200 {
            truth = truth.moved(twist, TICK_S);
            let gyro = with_gyro.then_some(twist.angular_radps);
            o.predict(wheels(0.5 * TICK_S, 0.4 * TICK_S), gyro, TICK_S).unwrap();
        }
        assert!(o.pose().position().distance(truth.position()) < 1e-9);
        assert!(wrap_angle(o.pose().heading - truth.heading).abs() < 1e-9);
        assert!((o.twist().linear_mps - 0.5).abs() < 1e-12 && (o.twist().angular_radps - 0.4).abs() < 1e-12);
        assert!((o.path_m() - 10.0).abs() < 1e-9);
    }
}

#[test]
fn a_robot_at_rest_does_not_turn_by_a_drifting_gyro_and_learns_its_bias() {
    let mut o = odometry(&OdometryConfig::default());
    let mut noise = Noise(1);
    for _ in 0..600 {
        o.predict(WheelTravel::default(), Some(0.004 + 0.003 * noise.normal()), TICK_S).unwrap();
    }
    assert_eq!(o.pose(), Pose2::IDENTITY);
    assert!((o.gyro_bias_radps() - 0.004).abs() < 0.0006, "{}", o.gyro_bias_radps());
}

#[test]
fn a_gyro_that_turns_while_the_wheels_stand_is_believed_over_them() {
    let mut o = odometry(&OdometryConfig::default());
    for _ in 0..10 {
        o.predict(WheelTravel::default(), Some(0.5), TICK_S).unwrap();
    }
    assert!((o.pose().heading - 0.5).abs() < 0.05, "{}", o.pose().heading);
}

#[test]
fn wheels_that_slip_in_a_turn_are_corrected_by_the_gyro() {
    let mut o = odometry(&OdometryConfig::default());
    for _ in 0..100 {
        o.predict(wheels(0.0, 0.05 * 1.2), Some(0.5), TICK_S).unwrap();
    }
    assert!(wrap_angle(o.pose().heading - 5.0).abs() < 0.15, "{}", o.pose().heading);
}

/// Noise drawn exactly as the settings say; without the gyro the heading is the wheels' alone.
/// The noise of each tick alone: encoders and gyro neither too long nor too short, wheels that slip as told.
fn with_scales_known() -> OdometryConfig {
    OdometryConfig {
        path_scale: 0.0,
        gyro_scale: 0.0,
        slip_gain: 0.0,
        slip_veer_radpm: 0.0,
        ..OdometryConfig::default()
    }
}

fn monte_carlo(with_gyro: bool) -> (Odometry, [[f64; 3]; 3]) {
    let c = OdometryConfig { gyro_bias_walk: 0.0, ..with_scales_known() };
    let (path, turn) = (0.05, 0.02);
    let mut expected = odometry(&c);
    let mut truth_model = Vec::new();
    let mut noise = Noise(9);
    let runs = 1500;
    for run in 0..=runs {
        let mut o = odometry(&c);
        let bias = if run == 0 { 0.0 } else { c.gyro_bias_radps * noise.normal() };
        for _ in 0..50 {
            let wheels_var = c.encoder_turn_rad2_per_rad * turn + c.encoder_turn_rad2_per_m * path;
            let gyro_var = c.gyro_rad2_per_s * TICK_S + c.gyro_rad2_per_rad * turn;
            let draw = if run == 0 { 0.0 } else { 1.0 };
            let by_wheels = turn + draw * noise.normal() * wheels_var.sqrt();
            let by_gyro = turn + draw * (bias * TICK_S + noise.normal() * gyro_var.sqrt());
            let slip = c.path_m2_per_rad * turn;
            let along = path + draw * noise.normal() * (c.path_m2_per_m * path + slip).sqrt();
            let aside = draw * noise.normal() * (c.sideways_m2_per_m * path + slip).sqrt();
            let before = o.pose();
            o.predict(wheels(along, by_wheels), with_gyro.then_some(by_gyro / TICK_S), TICK_S).unwrap();
            let after = o.pose();
            let mean = (before.heading + wrap_angle(after.heading - before.heading) / 2.0).sin_cos();
            let moved = Pose2::new(after.x - aside * mean.0, after.y + aside * mean.1, after.heading);
            // set_pose would reset the covariance, which only the noiseless run is read for.
            if run > 0 {
                o.set_pose(moved).unwrap();
            }
        }
        if run == 0 {
            expected = o;
        } else {
            let (p, q) = (o.pose(), expected.pose());
            truth_model.push([p.x - q.x, p.y - q.y, wrap_angle(p.heading - q.heading)]);
        }
    }
    let mut sample = [[0.0; 3]; 3];
    for e in &truth_model {
        for i in 0..3 {
            for j in 0..3 {
                sample[i][j] += e[i] * e[j] / f64::from(runs);
            }
        }
    }
    (expected, sample)
}

#[test]
fn the_covariance_is_that_of_many_drives_with_the_stated_noise() {
    for with_gyro in [false, true] {
        let (o, sample) = monte_carlo(with_gyro);
        let p = o.covariance();
        for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
            let (stated, seen, scale) = (p[i][j], sample[i][j], (p[i][i] * p[j][j]).sqrt());
            assert!(
                (stated - seen).abs() < 0.12 * scale,
                "gyro {with_gyro}, entry {i} {j}: {stated} against {seen}"
            );
        }
    }
}

#[test]
fn what_is_not_a_number_is_refused_by_name_and_changes_nothing() {
    let mut o = odometry(&OdometryConfig::default());
    o.predict(wheels(0.1, 0.01), Some(0.1), TICK_S).unwrap();
    let before = (o.pose(), o.covariance());
    let nan = f64::NAN;
    for (left_m, right_m, gyro, dt_s, expected) in [
        (nan, 0.0, None, 0.1, "wheels.left_m"),
        (0.0, f64::INFINITY, None, 0.1, "wheels.right_m"),
        (0.0, 0.0, Some(nan), 0.1, "gyro_radps"),
        (0.0, 0.0, None, nan, "dt_s"),
    ] {
        let error = o.predict(WheelTravel { left_m, right_m }, gyro, dt_s).unwrap_err();
        assert!(matches!(error, OdometryError::OdometryInputNotFinite { ref name, .. } if name == expected));
    }
    assert!(o.predict(WheelTravel::default(), None, 0.0).is_err());
    assert!(o.set_pose(Pose2 { x: nan, ..Pose2::IDENTITY }).is_err());
    assert_eq!((o.pose(), o.covariance()), before);
    let broken = OdometryConfig { rest_s: -1.0, ..OdometryConfig::default() };
    assert!(Odometry::new(&broken, &p3at().drive, Pose2::IDENTITY).is_err());
}

proptest! {
    #[test]
    fn the_covariance_stays_symmetric_and_positive_semidefinite_and_grows(
        ticks in proptest::collection::vec((-0.07..0.07f64, -0.2..0.2f64, -2.0..2.0f64, any::<bool>()), 1..80),
    ) {
        // A scale that is not known goes with the sign of the turn: turning back takes its error back.
        let mut o = odometry(&with_scales_known());
        for (path, turn, gyro, has_gyro) in ticks {
            let heading_before = o.covariance()[2][2];
            o.predict(wheels(path, turn), has_gyro.then_some(gyro), TICK_S).unwrap();
            let p = o.covariance();
            prop_assert!(p[2][2] >= heading_before - 1e-15);
            prop_assert_eq!([p[0][1], p[0][2], p[1][2]], [p[1][0], p[2][0], p[2][1]]);
            // All leading minors, and every 2×2 one.
            let det3 = p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1])
                - p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0])
                + p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
            let size = p[0][0].max(p[1][1]).max(p[2][2]);
            prop_assert!(det3 >= -1e-9 * size.powi(3));
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                prop_assert!(p[i][i] >= 0.0 && p[i][i] * p[j][j] - p[i][j] * p[j][i] >= -1e-12 * size * size);
            }
        }
    }

    #[test]
    fn a_new_pose_is_taken_as_given(x in -50.0..50.0f64, y in -50.0..50.0f64, heading in -3.1..3.1f64) {
        let mut o = odometry(&OdometryConfig { start_m: 0.1, ..OdometryConfig::default() });
        o.predict(wheels(0.3, 0.2), Some(1.0), TICK_S).unwrap();
        o.set_pose(Pose2::new(x, y, heading)).unwrap();
        prop_assert_eq!(o.pose().position(), Point2::new(x, y));
        prop_assert!((o.covariance()[0][0] - 0.01).abs() < 1e-12);
    }
}
