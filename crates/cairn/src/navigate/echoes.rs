//! Echoes that no wall of the given map explains: something new is that near, though an echo does not say where
//! on its arc. Until the map knows, the robot drives no faster than it can stop before any of it. What is heard
//! straight ahead counts even if a wall explains it: a shut door sounds like the posts beside it. What is heard to
//! come nearer is braked for as something that comes on meanwhile.

use super::caution::{Caution, slowed_to};
use super::navigator::Navigator;
use crate::avoid::GrownBox;
use crate::geometry::{Point2, Pose2, Twist2};
use crate::robot::Limits;

/// An echo comes from within this of the cone's axis, or is weak; walls beside the way are heard at the edge \[rad\].
const AXIAL_RAD: f64 = 0.175;
/// A sonar that looks this near to straight ahead or back hears what the robot would run into \[rad\].
const AHEAD_RAD: f64 = 0.2;
/// Points that an arc is told by.
const POINTS: i32 = 7;
/// Echoes from farther away are the map's business \[m\].
const NEAR_M: f64 = 2.0;
/// Nearer than this an arc is short enough to say where, and stands as an obstacle \[m\] ...
const PLACED_M: f64 = 0.6;
/// ... for this long, though a slanting face may fall silent meanwhile \[s\].
const REMEMBERED_S: f64 = 0.6;
/// Kept between the outline and an echo \[m\].
const KEPT_M: f64 = 0.04;
/// What is nearer to the robot's sides than this is beside it, not ahead \[m\].
const BESIDE_M: f64 = 0.01;
/// What comes may come on as fast as this \[m/s\],
const COMES_MPS: f64 = 0.3;
/// and what no wall explains as fast as this, until it is heard to stand or to come \[m/s\].
const MAY_COME_MPS: f64 = 0.15;

/// A point on the arc of an echo, world frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Echo {
    at: Point2,
    age_s: f64,
    placed: bool,
    /// How fast it may come nearer \[m/s\].
    comes_mps: f64,
}

impl Navigator {
    /// Takes note of what is heard now and not explained.
    pub(super) fn listen(&mut self, pose: Pose2, ranges_m: &[f64], dt_s: f64) {
        let robot_from_world = pose.inverse().turned();
        let outline = self.profile.footprint;
        self.echoes.retain_mut(|echo| {
            echo.age_s += dt_s;
            echo.placed && echo.age_s <= REMEMBERED_S && outline.distance(robot_from_world * echo.at) > 0.0
        });
        self.approach.pass(dt_s);
        let knows = self.map_given && self.pose_known;
        for (sonar, &range_m) in self.profile.sonars.iter().zip(ranges_m) {
            let heard = range_m >= sonar.min_range_m && range_m < sonar.max_range_m.min(NEAR_M);
            if !heard {
                continue;
            }
            let world_from_sonar = pose * sonar.pose;
            let explained = self.map.explains(world_from_sonar, sonar.beam_rad, range_m);
            let arc = |half_rad: f64| {
                (0..POINTS).map(move |i| {
                    let (sin, cos) =
                        (half_rad * (2.0 * f64::from(i) / f64::from(POINTS - 1) - 1.0)).sin_cos();
                    world_from_sonar * Point2::new(range_m * cos, range_m * sin)
                })
            };
            let middle = world_from_sonar * Point2::new(range_m, 0.0);
            if !explained {
                self.approach.hear(arc(sonar.beam_rad / 2.0), middle);
            }
            let comes = !explained && self.approach.is_near(middle);
            let along = sonar.pose.heading.sin().abs() <= AHEAD_RAD.sin();
            if comes || knows && (!explained || along) {
                let placed = range_m < PLACED_M && !explained;
                let comes_mps = match (explained, comes) {
                    (false, true) => COMES_MPS,
                    (false, false) if !self.approach.stands(middle) => MAY_COME_MPS,
                    _ => 0.0,
                };
                let half_rad = AXIAL_RAD.min(sonar.beam_rad / 2.0);
                self.echoes.extend(arc(half_rad).map(|at| Echo { at, age_s: 0.0, placed, comes_mps }));
            }
        }
        for (sonar, &range_m) in self.profile.sonars.iter().zip(ranges_m) {
            if range_m >= sonar.min_range_m && range_m < sonar.max_range_m {
                self.approach.look(pose * sonar.pose, sonar.beam_rad, range_m);
            }
        }
    }

    /// What is heard so near that it stands where it is heard, world frame.
    pub(super) fn heard_near(&self) -> impl Iterator<Item = Point2> + '_ {
        self.echoes.iter().filter(|echo| echo.placed).map(|echo| echo.at)
    }

    /// `twist`, no faster than can be stopped before what is heard ahead of it.
    pub(super) fn within_hearing(&self, pose: Pose2, twist: Twist2, dt_s: f64) -> (Twist2, Option<Caution>) {
        let robot_from_world = pose.inverse().turned();
        let heard = self.echoes.iter().map(|echo| (robot_from_world * echo.at, echo.comes_mps));
        let outline = self.profile.footprint;
        let body = GrownBox {
            half_length_m: outline.length_m / 2.0,
            half_width_m: outline.width_m / 2.0,
            growth_m: BESIDE_M,
        };
        let limits = &self.profile.limits;
        let caution = before_echoes(&body, limits, self.profile.drive.latency_s + dt_s, heard, twist);
        match caution {
            Some(Caution { speed_mps, .. }) => {
                (slowed_to(limits, self.commanded, twist, speed_mps, dt_s), caution)
            }
            None => (twist, None),
        }
    }
}

/// What `wanted` must be slowed to, along its own curvature, to stop before every one of `heard`, robot frame, each
/// with how fast it may come on meanwhile \[m/s\].
fn before_echoes(
    body: &GrownBox,
    limits: &Limits,
    delay_s: f64,
    heard: impl Iterator<Item = (Point2, f64)>,
    wanted: Twist2,
) -> Option<Caution> {
    let speed_mps = wanted.linear_mps.abs();
    if speed_mps == 0.0 {
        return None;
    }
    // Running back is running on in a mirror.
    let way = wanted.linear_mps.signum();
    let curvature = wanted.angular_radps / wanted.linear_mps * way;
    heard
        .map(|(point, comes_mps)| (Point2::new(point.x * way, point.y), comes_mps))
        .filter(|(point, _)| point.x > body.half_length_m)
        .map(|(point, comes_mps)| {
            let sight_m = (body.first_contact_m(point, curvature) - KEPT_M).max(0.0);
            // While the robot brakes it comes on: v·T + v²/2a + u·(T + v/a) = d.
            let late_s = delay_s + comes_mps / limits.linear_mps2;
            let cap_mps = limits.stoppable_mps((sight_m - comes_mps * delay_s).max(0.0), late_s);
            Caution { sight_m, speed_mps: cap_mps }
        })
        .filter(|caution| caution.speed_mps < speed_mps)
        .min_by(|a, b| a.speed_mps.total_cmp(&b.speed_mps))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits =
        Limits { linear_mps: 0.7, angular_radps: 2.4, linear_mps2: 0.3, angular_radps2: 1.7 };
    const BODY: GrownBox = GrownBox { half_length_m: 0.3, half_width_m: 0.25, growth_m: 0.01 };

    fn capped(wanted: Twist2, heard: &[(Point2, f64)]) -> Option<f64> {
        before_echoes(&BODY, &LIMITS, 0.2, heard.iter().copied(), wanted).map(|caution| caution.speed_mps)
    }

    #[test]
    fn the_robot_could_stop_before_an_echo_ahead_or_behind() {
        for way in [1.0, -1.0] {
            let v = capped(Twist2::new(0.6 * way, 0.3), &[(Point2::new(0.7 * way, 0.1), 0.0)]).unwrap();
            assert!(v > 0.2 && v * v / 0.6 + 0.2 * v <= 0.4, "{v}");
        }
    }

    #[test]
    fn before_what_comes_the_robot_stands_before_it_is_there() {
        let wanted = Twist2::new(0.7, 0.0);
        let v = capped(wanted, &[(Point2::new(1.0, 0.0), COMES_MPS)]).unwrap();
        let stops_s = 0.2 + v / LIMITS.linear_mps2;
        assert!(v > 0.15 && 0.2 * v + v * v / 0.6 + COMES_MPS * stops_s <= 0.7 - KEPT_M + 1e-9, "{v}");
        assert!(v < capped(wanted, &[(Point2::new(1.0, 0.0), 0.0)]).unwrap());
    }

    #[test]
    fn an_echo_beside_the_way_or_behind_it_slows_nothing_and_one_at_the_bumper_stops() {
        let wanted = Twist2::new(0.6, 0.0);
        for beside in [Point2::new(0.8, 0.3), Point2::new(0.1, 0.25), Point2::new(-0.5, 0.0)] {
            assert_eq!(capped(wanted, &[(beside, 0.0)]), None);
        }
        assert_eq!(capped(wanted, &[(Point2::new(0.33, 0.0), 0.0)]), Some(0.0));
    }
}
