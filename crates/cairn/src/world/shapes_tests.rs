use super::*;
use proptest::prelude::*;

fn circles() -> impl Strategy<Value = Vec<Circle>> {
    let one = (-4.0..4.0f64, -4.0..4.0f64, 0.03..0.8f64)
        .prop_map(|(x, y, radius_m)| Circle { centre: Point2::new(x, y), radius_m });
    proptest::collection::vec(one, 0..12)
}

fn blocks() -> impl Strategy<Value = Vec<Block>> {
    let one = (-4.0..4.0f64, -4.0..4.0f64, -3.2..3.2f64, 0.05..2.0f64, 0.05..2.0f64).prop_map(
        |(x, y, heading, length_m, width_m)| Block {
            pose: Pose2::new(x, y, heading),
            outline: Footprint { length_m, width_m },
        },
    );
    proptest::collection::vec(one, 0..5)
}

/// The point is inside a shape grown by `margin_m`.
fn holds(shapes: &Shapes, point: Point2, margin_m: f64) -> bool {
    shapes.circles.iter().any(|c| c.centre.distance(point) <= c.radius_m + margin_m)
        || shapes.blocks.iter().any(|b| b.outline.distance(b.pose.inverse() * point) <= margin_m)
}

proptest! {
    #[test]
    fn a_ray_ends_where_dense_marching_first_stands_in_a_shape(
        circles in circles(), blocks in blocks(), x in -4.0..4.0f64, y in -4.0..4.0f64, direction in -3.2..3.2f64,
    ) {
        let shapes = Shapes::new(circles, blocks).unwrap();
        let from = Point2::new(x, y);
        let hit = shapes.cast(from, &[direction], 10.0)[0];
        let unit = Point2::new(direction.cos(), direction.sin());
        let step_m = 1e-3;
        let marched = (0..10_000).map(|i| f64::from(i) * step_m).find(|&s| holds(&shapes, from + unit * s, 0.0));
        // Marching can step over the corner that the exact ray grazes, never the other way round.
        if let Some(s) = marched {
            prop_assert!(hit.range_m <= s + 1e-9);
        }
        if hit.range_m.is_finite() {
            prop_assert!(holds(&shapes, from + unit * hit.range_m, 1e-9));
            prop_assert!(hit.range_m == 0.0 || marched.is_none_or(|s| s >= hit.range_m - 1e-9));
        } else {
            prop_assert!(marched.is_none());
        }
    }

    #[test]
    fn a_scan_is_the_same_rays_cast_one_by_one(
        circles in circles(), blocks in blocks(), x in -4.0..4.0f64, y in -4.0..4.0f64, heading in -3.2..3.2f64,
        beams in 1usize..300, first in -7.0..7.0f64, step in prop_oneof![0.001..0.2f64, -0.2..-0.001f64], far in 0.5..12.0f64,
    ) {
        let shapes = Shapes::new(circles.clone(), blocks.clone()).unwrap();
        let pose = Pose2::new(x, y, heading);
        let angles: Vec<f64> = (0..beams).map(|i| pose.heading + first + i as f64 * step).collect();
        let one_by_one: Vec<f64> = shapes.cast(pose.position(), &angles, far).iter().map(|hit| hit.range_m).collect();
        prop_assert_eq!(&shapes.scan(pose, beams, first, step, far, &[]), &one_by_one);
        // A circle that moves is seen as one that stands.
        let still = Shapes::new(vec![], blocks).unwrap();
        prop_assert_eq!(still.scan(pose, beams, first, step, far, &circles), one_by_one);
    }

    #[test]
    fn an_outline_touches_exactly_where_its_clearance_is_zero_and_points_of_it_say_so(
        circles in circles(), blocks in blocks(), x in -4.0..4.0f64, y in -4.0..4.0f64, heading in -3.2..3.2f64,
        length_m in 0.2..1.5f64, width_m in 0.2..1.5f64,
    ) {
        let outline = Footprint { length_m, width_m };
        let pose = Pose2::new(x, y, heading);
        let shapes = Shapes::new(circles.clone(), blocks.clone()).unwrap();
        let clearance_m = shapes.clearance_m(pose, &outline, &[]);
        prop_assert_eq!(shapes.first_touch(&[pose], &outline, &[]).is_some(), clearance_m == 0.0);
        // The oracle: points filling the outline, and the shapes as sets of points.
        let n = 60;
        let point = |i: usize, j: usize| {
            let (u, v) = (i as f64 / n as f64 - 0.5, j as f64 / n as f64 - 0.5);
            pose * Point2::new(u * length_m, v * width_m)
        };
        let spacing = length_m.max(width_m) / n as f64;
        let sampled = (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))).map(|(i, j)| {
            let p = point(i, j);
            let circle = circles.iter().map(|c| (c.centre.distance(p) - c.radius_m).max(0.0));
            let block = blocks.iter().map(|b| b.outline.distance(b.pose.inverse() * p));
            circle.chain(block).fold(f64::INFINITY, f64::min)
        }).fold(f64::INFINITY, f64::min);
        if sampled.is_finite() {
            prop_assert!(clearance_m <= sampled + 1e-9 && sampled <= clearance_m + spacing);
        } else {
            prop_assert!(clearance_m.is_infinite());
        }
    }

    #[test]
    fn the_first_touch_of_a_way_is_the_first_pose_that_touches(
        circles in circles(), moving in circles(), x in -4.0..4.0f64, y in -4.0..4.0f64, heading in -3.2..3.2f64, drift in -0.2..0.2f64,
    ) {
        let outline = Footprint { length_m: 0.458, width_m: 0.416 };
        let poses: Vec<Pose2> = (0..20).map(|i| Pose2::new(x, y, heading) * Pose2::new(0.05 * f64::from(i), 0.0, 0.0)).collect();
        let at = |step: usize| -> Vec<Circle> {
            moving.iter().map(|c| Circle { centre: c.centre + Point2::new(drift * step as f64, 0.0), ..*c }).collect()
        };
        let all: Vec<Circle> = (0..poses.len()).flat_map(at).collect();
        let shapes = Shapes::new(circles, vec![]).unwrap();
        let expected = (0..poses.len()).find(|&i| shapes.clearance_m(poses[i], &outline, &at(i)) == 0.0);
        prop_assert_eq!(shapes.first_touch(&poses, &outline, &all).map(|touch| touch.step), expected);
    }
}

#[test]
fn a_post_straight_ahead_is_measured_to_its_near_side_and_met_head_on() {
    let post = Circle { centre: Point2::new(3.0, 0.0), radius_m: 0.075 };
    let shapes = Shapes::new(vec![post], vec![]).unwrap();
    let hit = shapes.cast(Point2::default(), &[0.0], 10.0)[0];
    assert!((hit.range_m - 2.925).abs() < 1e-12 && (hit.cosine - 1.0).abs() < 1e-12);
    assert_eq!(shapes.cast(Point2::default(), &[PI], 10.0)[0], NOTHING);
    assert_eq!(shapes.cast(Point2::default(), &[0.0], 2.9)[0], NOTHING);
}

#[test]
fn a_shape_that_is_none_is_refused_with_its_number_and_values() {
    let good = Circle { centre: Point2::default(), radius_m: 0.1 };
    let flat = Circle { radius_m: 0.0, ..good };
    let refused = Shapes::new(vec![good, flat], vec![]).unwrap_err();
    assert_eq!(refused, ShapeError::CircleNotUsable { index: 1, x_m: 0.0, y_m: 0.0, radius_m: 0.0 });
    let outline = Footprint { length_m: 1.0, width_m: f64::INFINITY };
    let refused = Shapes::new(vec![], vec![Block { pose: Pose2::IDENTITY, outline }]).unwrap_err();
    assert!(matches!(refused, ShapeError::BlockNotUsable { index: 0, width_m, .. } if width_m.is_infinite()));
    assert!(check_circles(&[Circle { centre: Point2::new(f64::NAN, 0.0), radius_m: 1.0 }]).is_err());
}
