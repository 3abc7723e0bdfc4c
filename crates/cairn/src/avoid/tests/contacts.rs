use super::support::Dice;
use crate::avoid::{GrownBox, disc_first_contact, tangent_curvatures};
use crate::geometry::{Point2, Twist2};

/// First arc length at which `hits` holds, by marching in steps of `step_m`.
fn march(curvature: f64, up_to_m: f64, step_m: f64, hits: impl Fn(f64, f64, f64) -> bool) -> f64 {
    let count = (up_to_m / step_m) as usize;
    (0..=count)
        .map(|i| i as f64 * step_m)
        .find(|&s| {
            let pose = Twist2::new(1.0, curvature).displacement(s);
            hits(pose.x, pose.y, pose.heading)
        })
        .unwrap_or(f64::INFINITY)
}

fn box_gap(outline: &GrownBox, p: Point2, x: f64, y: f64, heading: f64) -> f64 {
    let (sin, cos) = heading.sin_cos();
    let (dx, dy) = (p.x - x, p.y - y);
    let (along, across) = (cos * dx + sin * dy, cos * dy - sin * dx);
    let (ex, ey) = (along.abs() - outline.half_length_m, across.abs() - outline.half_width_m);
    ex.max(0.0).hypot(ey.max(0.0)) - outline.growth_m
}

#[test]
fn the_first_contact_of_the_box_equals_marching_along_the_arc() {
    let mut dice = Dice(1);
    let mut hits = 0;
    for _ in 0..4000 {
        let outline = GrownBox {
            half_length_m: dice.between(0.05, 0.5),
            half_width_m: dice.between(0.05, 0.5),
            growth_m: dice.between(0.0, 0.2),
        };
        let p = Point2::new(dice.between(-1.5, 2.5), dice.between(-2.0, 2.0));
        let curvature = match dice.between(0.0, 10.0) as usize {
            0 => 0.0,
            1 => dice.between(-1e-5, 1e-5),
            _ => dice.between(-4.0, 4.0),
        };
        let exact = outline.first_contact_m(p, curvature);
        let step = 2e-3;
        let up_to = 3.0f64.min(std::f64::consts::TAU / curvature.abs().max(1e-9));
        let marched = march(curvature, up_to, step, |x, y, h| box_gap(&outline, p, x, y, h) <= 0.0);
        if marched.is_finite() {
            hits += 1;
            assert!(
                exact <= marched + 1e-9 && marched - exact <= 1.01 * step,
                "{outline:?} {p:?} {curvature} {exact} {marched}"
            );
        } else if exact <= up_to {
            // Marching may step over a graze: then the box is on the point there.
            let pose = Twist2::new(1.0, curvature).displacement(exact);
            let gap = box_gap(&outline, p, pose.x, pose.y, pose.heading);
            assert!(gap.abs() < 1e-7, "{outline:?} {p:?} {curvature} {exact}: gap {gap}");
        }
    }
    assert!(hits > 500);
}

#[test]
fn an_arc_hits_a_disc_exactly_between_its_tangent_curvatures() {
    let mut dice = Dice(2);
    for _ in 0..4000 {
        let center = Point2::new(dice.between(-3.0, 3.0), dice.between(-3.0, 3.0));
        let radius = dice.between(0.05, 0.8);
        let Some((lo, hi)) = tangent_curvatures(center, radius) else {
            assert!(center.norm() <= radius);
            continue;
        };
        for _ in 0..10 {
            let c = dice.between(lo - 1.0, hi + 1.0);
            let near_tangent = (c - lo).abs().min((c - hi).abs()) < 1e-9;
            let hit = disc_first_contact(center, radius, c).is_finite();
            // Straight ahead only what is ahead is met; a circle comes round.
            if !near_tangent && c.abs() > 1e-6 {
                assert_eq!(hit, lo < c && c < hi, "{center:?} {radius} {c} in {lo} {hi}");
            }
        }
    }
}

#[test]
fn the_published_example_touches_at_a_metre_and_a_half_straight_on() {
    let center = Point2::new(2.0, 0.0);
    let (lo, hi) = tangent_curvatures(center, 0.5).unwrap();
    assert!((hi - 0.266_666_7).abs() < 1e-6 && (lo + hi).abs() < 1e-12);
    assert!((disc_first_contact(center, 0.5, 0.0) - 1.5).abs() < 1e-12);
    assert!((disc_first_contact(center, 0.5, hi - 1e-12) - 1.837).abs() < 1e-3);
}

#[test]
fn turning_in_place_first_meets_a_point_where_marching_does() {
    let mut dice = Dice(3);
    for _ in 0..2000 {
        let outline =
            GrownBox { half_length_m: 0.313, half_width_m: 0.2525, growth_m: dice.between(0.0, 0.1) };
        let p = Point2::new(dice.between(-0.6, 0.6), dice.between(-0.6, 0.6));
        let left = dice.unit() < 0.5;
        let exact = outline.first_contact_turning_rad(p, left);
        let sign = if left { 1.0 } else { -1.0 };
        let step = 1e-3;
        let marched = (0..=6283)
            .map(|i| f64::from(i) * step)
            .find(|a| box_gap(&outline, p, 0.0, 0.0, sign * a) <= 0.0)
            .unwrap_or(f64::INFINITY);
        if marched.is_finite() {
            assert!(exact <= marched + 1e-9 && marched - exact <= 1.01 * step, "{p:?} {exact} {marched}");
        } else {
            assert!(
                exact > std::f64::consts::TAU - 1e-2
                    || box_gap(&outline, p, 0.0, 0.0, sign * exact).abs() < 1e-7
            );
        }
    }
}
