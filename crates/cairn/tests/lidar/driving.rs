use super::scene::{Disc, drive, post, wall};
use super::support::Dice;
use cairn::avoid::Why;
use cairn::geometry::Point2;

/// Posts in a field, each at least so far from every other that the robot fits between.
fn field_of_posts(seed: u64) -> Vec<Disc> {
    let mut dice = Dice(seed);
    let mut posts: Vec<Disc> = Vec::new();
    while posts.len() < 28 {
        let new = post(dice.between(1.0, 6.5), dice.between(-2.5, 2.5));
        if posts.iter().all(|p| p.center.distance(new.center) > 0.8) {
            posts.push(new);
        }
    }
    posts
}

#[test]
fn fields_of_posts_are_crossed_fast_and_without_a_touch() {
    for seed in 0..10 {
        let gain = 0.85 + 0.03 * seed as f64;
        let run = drive(&field_of_posts(seed), Point2::new(8.0, 0.0), gain, 30.0);
        assert!(run.arrived && run.clearance_m > 0.0, "seed {seed}: {:.3} m", run.clearance_m);
        assert!(run.seconds < 11.0, "seed {seed}: {:.1} s", run.seconds);
    }
}

#[test]
fn an_open_place_is_crossed_without_detour_to_a_goal_in_any_direction() {
    for i in 0..8 {
        let angle = f64::from(i) * std::f64::consts::TAU / 8.0 + 0.2;
        let goal = Point2::new(5.0 * angle.cos(), 5.0 * angle.sin());
        let run = drive(&[post(20.0, 0.0)], goal, 1.0, 12.0);
        let length_m: f64 = run.path.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        assert!(run.arrived && length_m < 1.25 * 5.0, "{angle:.1} rad: {length_m:.2} m");
    }
}

#[test]
fn a_doorway_little_wider_than_the_robot_is_passed() {
    for side in [-1.0, 0.0, 0.8] {
        let mut posts = wall((3.0, 0.41), (3.0, 4.0));
        posts.extend(wall((3.0, -0.41), (3.0, -4.0)));
        let run = drive(&posts, Point2::new(6.0, side), 1.1, 20.0);
        assert!(run.arrived && run.clearance_m > 0.0, "{side}: {:.3} m", run.clearance_m);
    }
}

#[test]
fn a_corridor_too_narrow_to_turn_in_is_followed() {
    let mut posts = wall((1.0, 0.38), (6.0, 0.38));
    posts.extend(wall((1.0, -0.38), (6.0, -0.38)));
    let run = drive(&posts, Point2::new(8.0, 0.0), 0.9, 20.0);
    assert!(run.arrived && run.clearance_m > 0.0, "{:.3} m", run.clearance_m);
}

#[test]
fn a_dead_end_is_left_within_seconds() {
    let mut posts = wall((1.0, 1.2), (4.0, 1.2));
    posts.extend(wall((1.0, -1.2), (4.0, -1.2)));
    posts.extend(wall((4.0, -1.2), (4.0, 1.2)));
    let run = drive(&posts, Point2::new(6.0, 0.0), 1.0, 40.0);
    assert!(run.arrived && run.clearance_m > 0.0 && run.seconds < 20.0, "{:.1} s", run.seconds);
}

#[test]
fn out_of_a_dead_end_too_narrow_to_turn_in_it_backs() {
    // The end is hidden behind a post in the middle of the way until the robot is in.
    let mut posts = wall((1.0, 0.4), (3.0, 0.4));
    posts.extend(wall((1.0, -0.4), (3.0, -0.4)));
    posts.extend(wall((3.0, -0.4), (3.0, 0.4)));
    posts.extend(wall((1.0, 0.4), (1.0, 3.0)));
    posts.extend(wall((1.0, -0.4), (1.0, -3.0)));
    // It begins inside.
    for post in &mut posts {
        post.center.x -= 2.2;
    }
    let run = drive(&posts, Point2::new(4.0, 0.0), 1.0, 60.0);
    assert!(run.count(|why| matches!(why, Why::BackingOut { .. })) > 0);
    assert!(run.arrived && run.clearance_m > 0.0, "{:.3} m", run.clearance_m);
}

#[test]
fn the_same_world_gives_the_same_bits() {
    let posts = field_of_posts(3);
    let [one, other] = [(); 2].map(|()| drive(&posts, Point2::new(8.0, 0.0), 1.1, 30.0));
    assert_eq!(one.records, other.records);
}
