use super::scene::{Disc, drive, post, wall};
use cairn::avoid::Why;
use cairn::geometry::Point2;

fn crossing(x: f64, from_y: f64, speed_mps: f64) -> Disc {
    let velocity_mps = Point2::new(0.0, speed_mps);
    Disc { center: Point2::new(x, from_y), radius_m: 0.4, velocity_mps }
}

/// Walls far to the sides, so that there is something to hold on to.
fn hall() -> Vec<Disc> {
    let mut posts = wall((-2.0, 6.0), (12.0, 6.0));
    posts.extend(wall((-2.0, -6.0), (12.0, -6.0)));
    posts
}

#[test]
fn what_crosses_the_way_is_not_touched_whenever_it_comes() {
    let mut gave_way = 0;
    for start in 0..6 {
        let mut discs = hall();
        discs.push(crossing(4.0, -1.5 - 0.6 * f64::from(start), 0.9));
        let run = drive(&discs, Point2::new(9.0, 0.0), 1.0, 30.0);
        assert!(run.arrived && run.clearance_m > 0.0, "start {start}: {:.3} m", run.clearance_m);
        gave_way += run.count(|why| matches!(why, Why::GivingWay { .. }));
    }
    assert!(gave_way > 0);
}

#[test]
fn what_comes_head_on_is_made_way_for() {
    let mut discs = hall();
    let velocity_mps = Point2::new(-1.0, 0.0);
    discs.push(Disc { center: Point2::new(7.0, 0.1), radius_m: 0.4, velocity_mps });
    let run = drive(&discs, Point2::new(9.0, 0.0), 1.0, 30.0);
    assert!(run.arrived && run.clearance_m > 0.0, "{:.3} m", run.clearance_m);
}

#[test]
fn what_stands_still_is_not_taken_for_moving() {
    let mut discs = hall();
    discs.extend([post(2.0, 0.6), post(3.5, -0.7), post(5.0, 0.5), post(5.4, -1.2)]);
    discs.push(Disc { center: Point2::new(7.0, 0.3), radius_m: 0.4, velocity_mps: Point2::default() });
    let run = drive(&discs, Point2::new(9.0, 0.0), 1.15, 30.0);
    assert!(run.arrived && run.clearance_m > 0.0);
    assert_eq!(run.count(|why| matches!(why, Why::GivingWay { .. })), 0);
}
