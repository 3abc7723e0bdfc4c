use super::scene::{Disc, drive, post, profile, scan, wall};
use cairn::geometry::{Point2, Pose2};
use cairn::locate::{ScanMatchConfig, match_scan};
use cairn::robot::Lidar;
use cairn::world::{Beams, LocalMap, LocalMapConfig};

fn room() -> Vec<Disc> {
    let mut posts = wall((-2.0, 2.0), (5.0, 2.0));
    posts.extend(wall((-2.0, -2.5), (5.0, -2.5)));
    posts.extend(wall((5.0, -2.5), (5.0, 2.0)));
    posts.push(post(2.0, 0.5));
    posts
}

fn seen(map: &mut LocalMap, world_from_robot: Pose2, discs: &[Disc]) {
    let beams = Beams::new(&profile().lidar.unwrap());
    let ranges = scan(&profile(), world_from_robot, discs);
    let ends = beams.ends(&ranges);
    map.integrate(world_from_robot, &beams, &ranges, &ends, |_| false);
}

#[test]
fn a_scan_finds_the_pose_it_was_taken_at_to_millimetres() {
    let mut map = LocalMap::new(&LocalMapConfig::default());
    seen(&mut map, Pose2::IDENTITY, &room());
    for (x, y, heading) in [(0.04, 0.02, 0.03), (-0.05, 0.03, -0.04), (0.0, -0.05, 0.05)] {
        let truth = Pose2::new(x, y, heading);
        let ends = Beams::new(&profile().lidar.unwrap()).ends(&scan(&profile(), truth, &room()));
        let config = ScanMatchConfig { prior_m: 0.1, prior_rad: 0.1, ..ScanMatchConfig::default() };
        let (pose, report) = match_scan(&config, &map, Pose2::IDENTITY, &ends, 0.0, 0.0);
        assert!(report.matched > 50);
        assert!(pose.position().distance(truth.position()) < 0.008, "{pose:?} {truth:?}");
        assert!((pose.heading - heading).abs() < 0.004, "{pose:?} {truth:?}");
    }
}

#[test]
fn with_nothing_to_hold_on_to_the_prediction_stays() {
    let map = LocalMap::new(&LocalMapConfig::default());
    let ends = Beams::new(&profile().lidar.unwrap()).ends(&scan(&profile(), Pose2::IDENTITY, &room()));
    let predicted = Pose2::new(1.0, 2.0, 0.3);
    let (pose, report) = match_scan(&ScanMatchConfig::default(), &map, predicted, &ends, 0.1, 0.1);
    assert_eq!((pose, report.matched), (predicted, 0));
}

#[test]
fn what_left_is_gone_once_it_was_looked_through_and_what_is_behind_stays() {
    let config = LocalMapConfig::default();
    let mut map = LocalMap::new(&config);
    let ahead = post(2.0, 0.5);
    for _ in 0..10 {
        seen(&mut map, Pose2::IDENTITY, &[ahead, post(4.0, 1.0), post(4.0, 0.5), post(4.0, 1.5)]);
    }
    let near = |map: &LocalMap, p: Point2| map.points().filter(|q| q.distance(p) < 0.12).count();
    assert!(near(&map, ahead.center) > 0);
    let turned = Pose2::new(0.0, 0.0, std::f64::consts::PI);
    for _ in 0..20 {
        seen(&mut map, turned, &[]);
    }
    assert!(near(&map, ahead.center) > 0, "it is behind: no beam looked there");
    for _ in 0..config.persistence {
        seen(&mut map, Pose2::IDENTITY, &wall((4.0, -3.0), (4.0, 3.0)));
    }
    assert_eq!(near(&map, ahead.center), 0);
}

#[test]
fn what_left_is_gone_on_every_side_of_a_lidar_that_looks_all_around_whichever_way_it_turns() {
    for (first_rad, step_rad) in [(0.0, 1.0), (-180.0, 1.0), (0.0, -1.0), (90.0, 1.0), (0.0, 2.0)] {
        let lidar = Lidar {
            beams: (360.0 / f64::abs(step_rad)) as usize,
            first_rad: f64::to_radians(first_rad),
            step_rad: f64::to_radians(step_rad),
            ..profile().lidar.unwrap()
        };
        let config = LocalMapConfig::default();
        let (mut map, beams) = (LocalMap::new(&config), Beams::new(&lidar));
        let mut look = |range_m: f64| {
            let ranges = vec![range_m; lidar.beams];
            map.integrate(Pose2::IDENTITY, &beams, &ranges, &beams.ends(&ranges), |_| false);
            map.len()
        };
        assert!(look(2.0) > 100);
        for _ in 0..config.persistence {
            look(f64::INFINITY);
        }
        assert_eq!(look(f64::INFINITY), 0, "from {first_rad} by {step_rad} degrees");
    }
}

#[test]
fn a_range_as_great_as_the_lidar_can_tell_is_no_return() {
    let lidar = Lidar { max_range_m: 5.0, ..profile().lidar.unwrap() };
    let ends = Beams::new(&lidar).ends(&[5.0, 4.999, f64::INFINITY]);
    assert_eq!(ends.iter().map(Option::is_some).collect::<Vec<_>>(), [false, true, false]);
}

#[test]
fn far_points_are_forgotten_as_the_robot_goes() {
    let config = LocalMapConfig::default();
    let mut map = LocalMap::new(&config);
    seen(&mut map, Pose2::IDENTITY, &[post(2.0, 0.0)]);
    assert!(!map.is_empty());
    seen(&mut map, Pose2::new(100.0, 0.0, 0.0), &[]);
    assert!(map.is_empty());
}

#[test]
fn a_turn_that_the_wheels_tell_wrongly_is_measured_and_the_robot_knows_where_it_is() {
    for gain in [0.85, 1.15] {
        let mut posts = room();
        posts.push(post(1.2, -0.5));
        posts.push(post(3.0, -0.8));
        let run = drive(&posts, Point2::new(4.0, -1.8), gain, 20.0);
        assert!(run.arrived && run.clearance_m > 0.0);
        assert!(run.drift_m < 0.05, "{:.3} m", run.drift_m);
        let (before, after) = ((gain - 1.0f64).abs(), (gain - run.turn_gain).abs());
        assert!(after < 0.7 * before, "{gain}: {:.3}", run.turn_gain);
    }
}
