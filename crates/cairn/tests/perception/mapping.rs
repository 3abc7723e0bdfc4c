use cairn::geometry::{Point2, Pose2};
use cairn::world::{MappingConfig, MappingError, Occupancy, OccupancyMap};

use crate::rooms::{Noise, Rooms, drive, p3at};

/// Half the robot's width and five centimetres.
const PASSAGE_M: f64 = 0.505 / 2.0 + 0.05;

fn mapped(rooms: &Rooms, poses: &[Pose2], mut map: OccupancyMap, seed: u64) -> OccupancyMap {
    let profile = p3at();
    let mut noise = Noise(seed);
    for &pose in poses {
        map.integrate(pose, &profile, &rooms.sense(pose, &profile, &mut noise)).unwrap();
    }
    map
}

fn fresh() -> OccupancyMap {
    OccupancyMap::new(&MappingConfig::default(), 0.05).unwrap()
}

/// Share of the cells the robot's footprint passed over that are marked occupied.
fn wrongly_occupied(rooms: &Rooms, map: &OccupancyMap, poses: &[Pose2], within_m: f64) -> f64 {
    let grid = map.occupancy();
    let (mut wrong, mut all) = (0, 0);
    for (i, class) in grid.values.iter().enumerate() {
        let p = grid.geometry.center(grid.geometry.cell(i));
        if poses.iter().any(|q| q.position().distance(p) < within_m) && rooms.clearance(p) > 0.1 {
            all += 1;
            wrong += usize::from(*class == Occupancy::Occupied);
        }
    }
    wrong as f64 / all as f64
}

/// Share of the wall points near the drive with an occupied cell within 0.1 m.
fn recovered(rooms: &Rooms, map: &OccupancyMap, poses: &[Pose2], within_m: f64) -> f64 {
    let (mut found, mut all) = (0, 0);
    for &(a, b) in &rooms.walls {
        let steps = (a.distance(b) / 0.05) as usize;
        for k in 0..steps {
            let p = a + (b - a) * (k as f64 / steps as f64);
            if poses.iter().any(|q| q.position().distance(p) < within_m) {
                all += 1;
                found += usize::from(!map.occupied_near(p, 0.1).is_empty());
            }
        }
    }
    found as f64 / all as f64
}

/// Width of the gap left free across a door at x in a wall along y, within 0.15 m of it.
fn gap_m(map: &OccupancyMap, x: f64, y0: f64, y1: f64) -> f64 {
    let grid = map.occupancy();
    let (mut best, mut run) = (0.0f64, 0.0);
    let mut y = y0;
    while y < y1 {
        let blocked = (-3..=3)
            .any(|k| grid.at_point(Point2::new(x + 0.05 * f64::from(k), y)) == Some(&Occupancy::Occupied));
        run = if blocked { 0.0 } else { run + 0.01 };
        best = best.max(run);
        y += 0.01;
    }
    best
}

/// A corridor 2 m wide with a wall across at x = 5 that has a door of 1 m.
fn door() -> Rooms {
    Rooms::default().block(-1.0, -1.0, 11.0, 1.0).block(4.95, -1.0, 5.05, -0.5).block(4.95, 0.5, 5.05, 1.0)
}

fn surveyed(rooms: &Rooms) -> OccupancyMap {
    let grid = rooms.surveyed(Point2::new(-4.0, -5.0), Point2::new(13.0, 5.0), 0.05);
    OccupancyMap::from_occupancy(&MappingConfig::default(), &grid).unwrap()
}

fn occupied_count(grid: &cairn::world::Grid<bool>) -> usize {
    grid.values.iter().filter(|here| **here).count()
}

#[test]
fn a_door_of_one_metre_stays_passable_in_a_map_made_by_driving_through_it() {
    for (seed, offset) in [(1, 0.0), (2, 0.15), (3, -0.1), (4, 0.05)] {
        let poses = drive(&[(0.0, offset), (10.0, 0.0)], 0.5);
        let map = mapped(&door(), &poses, fresh(), seed);
        let gap = gap_m(&map, 5.0, -0.6, 0.6);
        assert!(gap >= 2.0 * PASSAGE_M, "offset {offset}: {gap:.2} m are left");
        assert_eq!(wrongly_occupied(&door(), &map, &poses, 0.35), 0.0);
        assert!(recovered(&door(), &map, &poses, 1.2) > 0.95);
    }
}

#[test]
fn an_unknown_door_has_opened_while_the_robot_is_still_half_a_metre_before_it() {
    for (seed, offset) in [(1, 0.0), (2, 0.15)] {
        let poses: Vec<_> =
            drive(&[(0.0, offset), (10.0, 0.0)], 0.5).into_iter().filter(|p| p.x <= 4.5).collect();
        let gap = gap_m(&mapped(&door(), &poses, fresh(), seed), 5.0, -0.6, 0.6);
        assert!(gap >= 2.0 * PASSAGE_M, "offset {offset}: {gap:.2} m are open");
    }
}

#[test]
fn a_door_of_the_known_map_is_never_closed_by_echoes_of_its_jambs() {
    let profile = p3at();
    for (seed, offset) in [(1, 0.0), (2, 0.15), (3, -0.1)] {
        let (mut map, mut noise) = (surveyed(&door()), Noise(seed));
        for pose in drive(&[(0.0, offset), (10.0, 0.0)], 0.5) {
            map.integrate(pose, &profile, &door().sense(pose, &profile, &mut noise)).unwrap();
            let gap = gap_m(&map, 5.0, -0.6, 0.6);
            assert!(gap >= 2.0 * PASSAGE_M, "at {pose:?}: {gap:.2} m are open");
        }
        assert!(occupied_count(&map.unmapped()) <= 6);
    }
}

#[test]
fn walls_of_the_known_map_outlast_a_drive_past_them_with_a_pose_that_is_off() {
    let rooms = Rooms::default().block(-3.0, -0.8, 12.0, 0.8);
    let profile = p3at();
    let before = surveyed(&rooms);
    for off_m in [0.0, 0.1] {
        let (mut map, mut noise) = (before.clone(), Noise(1));
        for pose in drive(&[(0.0, 0.0), (9.0, 0.0), (0.0, 0.0)], 0.5) {
            let believed = Pose2::new(pose.x, pose.y + off_m, pose.heading);
            map.integrate(believed, &profile, &rooms.sense(pose, &profile, &mut noise)).unwrap();
        }
        let lost = before
            .classes()
            .iter()
            .zip(map.classes())
            .filter(|(was, is)| **was == Occupancy::Occupied && **is != Occupancy::Occupied)
            .count();
        assert_eq!(lost, 0, "{off_m} m off");
    }
}

#[test]
fn a_box_on_the_way_is_seen_from_well_over_a_metre_and_clears_within_two_seconds_of_being_taken_away() {
    let profile = p3at();
    for (width, y, size) in
        [(1.6, 0.0, 0.5), (2.0, 0.3, 0.4), (2.4, -0.4, 0.6), (8.0, 0.0, 0.4), (1.6, 0.0, 0.8)]
    {
        let empty = Rooms::default().block(-3.0, -width / 2.0, 12.0, width / 2.0);
        let rooms = empty.clone().block(6.0, y - size / 2.0, 6.0 + size, y + size / 2.0);
        for mut map in [fresh(), surveyed(&empty)] {
            let mut noise = Noise(1);
            let mut seen_from_m = 0.0f64;
            for pose in drive(&[(0.0, 0.0), (4.7, 0.0)], 0.5) {
                map.integrate(pose, &profile, &rooms.sense(pose, &profile, &mut noise)).unwrap();
                if map.unmapped_near(Point2::new(6.0, y), 0.15).len() >= 2 {
                    seen_from_m = seen_from_m.max(6.0 - pose.x);
                }
            }
            assert!(seen_from_m >= 1.5, "corridor {width} m, box at {y}: seen from {seen_from_m:.2} m");
            assert!(map.unmapped_near(Point2::new(6.0, y), 0.15).len() >= 2, "and it stays seen");
            for _ in 0..20 {
                let pose = Pose2::new(4.2, 0.0, 0.0);
                map.integrate(pose, &profile, &empty.sense(pose, &profile, &mut noise)).unwrap();
            }
            assert!(map.unmapped_near(Point2::new(6.0, y), 0.3).is_empty(), "corridor {width} m, box at {y}");
        }
    }
}

#[test]
fn the_same_readings_give_the_same_map_to_the_bit() {
    let poses = drive(&[(0.0, 0.0), (3.0, 0.3)], 0.5);
    let (a, b) = (mapped(&door(), &poses, fresh(), 7), mapped(&door(), &poses, fresh(), 7));
    assert_eq!(a.probabilities(), b.probabilities());
    assert_eq!((a.occupancy(), a.revision()), (b.occupancy(), b.revision()));
}

#[test]
fn a_map_that_grows_keeps_what_it_knew_and_its_cells_stay_on_multiples_of_the_resolution() {
    let profile = p3at();
    let mut map = fresh();
    assert_eq!(map.geometry().len(), 0);
    let mut noise = Noise(1);
    let rooms = door();
    let here = Pose2::new(0.0, 0.0, 0.4);
    for _ in 0..10 {
        map.integrate(here, &profile, &rooms.sense(here, &profile, &mut noise)).unwrap();
    }
    let known = map.occupied_near(Point2::new(0.0, 0.0), 3.0);
    assert!(!known.is_empty());
    let revision = map.revision();
    for (x, y) in [(40.0, 3.0), (-30.0, -25.0), (0.0, 60.0)] {
        map.integrate(Pose2::new(x, y, 1.0), &profile, &[f64::INFINITY; 16]).unwrap();
    }
    assert_eq!(map.occupied_near(Point2::new(0.0, 0.0), 3.0).len(), known.len());
    assert!(map.revision() > revision);
    let origin = map.geometry().world_from_grid;
    for v in [origin.x / 0.05, origin.y / 0.05] {
        assert!((v - v.round()).abs() < 1e-9);
    }
}

#[test]
fn what_was_not_measured_says_nothing() {
    let mut map = surveyed(&door());
    let before = map.probabilities();
    map.integrate(Pose2::new(3.0, 0.0, 0.0), &p3at(), &[f64::NAN; 16]).unwrap();
    assert_eq!((map.probabilities(), map.revision()), (before, 0));
}

#[test]
fn one_echo_neither_closes_a_door_nor_frees_a_wall_of_the_known_map() {
    let profile = p3at();
    for sonar in 0..16 {
        for range in [0.3, 0.8, 1.3, 2.0, 2.9, 4.0, f64::INFINITY] {
            let mut map = surveyed(&door());
            let mut ranges = [f64::NAN; 16];
            ranges[sonar] = range;
            map.integrate(Pose2::new(4.0, 0.1, 0.2), &profile, &ranges).unwrap();
            assert_eq!(map.occupancy(), surveyed(&door()).occupancy(), "sonar {sonar}, {range} m");
        }
    }
}

#[test]
fn the_ground_the_robot_stands_on_is_free_but_walls_of_the_known_map_stay() {
    let mut map = surveyed(&door());
    let profile = p3at();
    let box_ahead = Rooms::default().block(1.0, -0.3, 1.5, 0.3);
    let mut noise = Noise(1);
    for _ in 0..20 {
        map.integrate(Pose2::IDENTITY, &profile, &box_ahead.sense(Pose2::IDENTITY, &profile, &mut noise))
            .unwrap();
    }
    assert!(!map.unmapped_near(Point2::new(1.0, 0.0), 0.2).is_empty());
    map.clear_disc(Point2::new(1.0, 0.0), 1.2);
    assert!(map.unmapped_near(Point2::new(1.0, 0.0), 1.2).is_empty());
    assert!(!map.occupied_near(Point2::new(1.0, 1.0), 0.2).is_empty());
}

#[test]
fn a_lidar_draws_a_room_in_a_few_scans_and_forgets_a_box_that_left() {
    let mut profile = p3at();
    profile.sonars.clear();
    profile.lidar = Some(cairn::robot::Lidar {
        pose: Pose2::new(0.1, 0.0, 0.0),
        beams: 720,
        first_rad: -std::f64::consts::PI,
        step_rad: std::f64::consts::TAU / 720.0,
        min_range_m: 0.1,
        max_range_m: 12.0,
    });
    let lidar = profile.lidar.unwrap();
    let empty = Rooms::default().block(-3.0, -2.0, 4.0, 2.5);
    let full = empty.clone().block(1.5, 0.5, 2.0, 1.0);
    let pose = Pose2::new(-0.5, 0.2, 0.3);
    let scan = |rooms: &Rooms| -> Vec<f64> {
        (0..720)
            .map(|k| {
                let at = pose * lidar.pose;
                let heading = at.heading + lidar.first_rad + f64::from(k) * lidar.step_rad;
                rooms.beam(at.position(), heading)
            })
            .collect()
    };
    let mut map = fresh();
    for _ in 0..4 {
        map.integrate(pose, &profile, &scan(&full)).unwrap();
    }
    assert!(recovered(&empty, &map, &[pose], 2.5) > 0.95);
    let in_box = Point2::new(1.6, 0.6);
    assert!(map.occupied_near(in_box, 0.25).len() > 5);
    for _ in 0..12 {
        map.integrate(pose, &profile, &scan(&empty)).unwrap();
    }
    assert!(map.occupied_near(in_box, 0.4).is_empty());
}

#[test]
fn wrong_input_is_refused_by_name_and_changes_nothing() {
    let (mut map, profile) = (fresh(), p3at());
    let nowhere = Pose2 { x: f64::NAN, ..Pose2::IDENTITY };
    assert!(matches!(
        map.integrate(nowhere, &profile, &[1.0; 16]),
        Err(MappingError::MappingPoseNotFinite { .. })
    ));
    assert!(matches!(
        map.integrate(Pose2::IDENTITY, &profile, &[1.0; 15]),
        Err(MappingError::MappingRangeCount { given: 15, expected: 16 })
    ));
    let mut ranges = [1.0; 16];
    ranges[3] = -0.5;
    assert!(matches!(
        map.integrate(Pose2::IDENTITY, &profile, &ranges),
        Err(MappingError::MappingRangeNegative { index: 3, .. })
    ));
    map.integrate(Pose2::IDENTITY, &profile, &[1.0; 16]).unwrap();
    let before = map.probabilities();
    for far in [1e7, 1e300] {
        assert!(matches!(
            map.integrate(Pose2::new(far, 0.0, 0.0), &profile, &[1.0; 16]),
            Err(MappingError::MappingTooLarge { .. })
        ));
    }
    assert_eq!(map.probabilities(), before);
    let config = MappingConfig { ceiling: f64::NAN, ..MappingConfig::default() };
    assert!(matches!(
        OccupancyMap::new(&config, 0.05),
        Err(MappingError::MappingValueOutOfRange { key, .. }) if key == "ceiling"
    ));
    assert!(OccupancyMap::new(&MappingConfig::default(), 0.0).is_err());
}

#[test]
fn the_changes_that_are_told_lead_from_one_map_to_the_next() {
    let rooms = Rooms::default().block(-3.0, -2.0, 4.0, 3.0).block(1.0, 0.5, 1.4, 1.0);
    let poses = drive(&[(-2.0, -1.0), (0.0, -1.0), (3.0, -1.0), (3.0, 2.0)], 0.5);
    let plan = Rooms::default().block(-3.0, -2.0, 4.0, 3.0); // without the block inside
    let prior = plan.surveyed(Point2::new(-4.0, -3.0), Point2::new(5.0, 4.0), 0.05);
    let profile = p3at();
    let mut noise = Noise(5);
    let mut told = 0;
    for mut map in [OccupancyMap::from_occupancy(&MappingConfig::default(), &prior).unwrap(), fresh()] {
        let mut followed = map.occupancy();
        for &pose in &poses {
            map.integrate(pose, &profile, &rooms.sense(pose, &profile, &mut noise)).unwrap();
            match map.take_changes() {
                None => followed = map.occupancy(), // the grid grew
                Some(changes) => {
                    told += changes.len();
                    for (cell, now) in changes {
                        let index = followed.geometry.index(cell);
                        assert_ne!(followed.values[index], now);
                        followed.values[index] = now;
                    }
                    assert_eq!(followed, map.occupancy());
                }
            }
        }
    }
    assert!(told > 50, "{told}");
}

#[test]
fn what_was_felt_stands_whatever_is_heard_until_it_is_forgotten() {
    let rooms = Rooms::default().block(-3.0, -2.0, 4.0, 2.0);
    let poses = vec![Pose2::new(-1.0, 0.0, 0.0); 30];
    let felt = Point2::new(0.02, 0.02);
    for mut map in [mapped(&rooms, &poses, fresh(), 1), {
        let prior = rooms.surveyed(Point2::new(-4.0, -3.0), Point2::new(5.0, 3.0), 0.05);
        OccupancyMap::from_occupancy(&MappingConfig::default(), &prior).unwrap()
    }] {
        let at = |map: &OccupancyMap| *map.occupancy().at_point(felt).unwrap();
        assert_eq!(at(&map), Occupancy::Free);
        map.feel([felt]);
        assert_eq!((at(&map), map.felt().len()), (Occupancy::Occupied, 1));
        let mut map = mapped(&rooms, &poses, map, 2);
        assert_eq!(at(&map), Occupancy::Occupied);
        // A map that grows moves its cells.
        let far = vec![Pose2::new(-2.0, -1.0, 3.0); 3];
        map = mapped(&rooms, &far, map, 3);
        assert_eq!(at(&map), Occupancy::Occupied);
        map.forget_unmapped(Point2::new(50.0, 0.0), 1.0);
        assert_eq!(at(&map), Occupancy::Occupied);
        assert_eq!(map.forget_felt(), 1);
        assert_eq!(at(&mapped(&rooms, &poses, map, 4)), Occupancy::Free);
    }
}
