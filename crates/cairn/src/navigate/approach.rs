//! What comes nearer: an echo from where the sonars looked through a moment ago is from something that moved there.

use std::collections::VecDeque;

use crate::geometry::{Point2, Pose2};

/// A look proves nothing before it is this old, \[s\],
const FROM_S: f64 = 0.35;
/// and is forgotten after this \[s\].
const UNTIL_S: f64 = 1.6;
/// What was heard this long ago where it is now stands \[s\].
const STANDS_S: f64 = 0.6;
/// Ranges differ by more than chance allows from this on: a share of the range, and a length \[m\].
const SHORT_BY: f64 = 0.02;
const SHORT_BY_M: f64 = 0.03;
/// What came is minded for this long after it was last heard to \[s\], this far around \[m\].
const MINDED_S: f64 = 1.5;
const AROUND_M: f64 = 0.6;

/// A cone that was empty up to a range.
#[derive(Clone, Copy, Debug)]
struct Look {
    age_s: f64,
    sonar_from_world: Pose2,
    cos_half: f64,
    range_m: f64,
    slack_m: f64,
}

/// The sonars' last looks, and where something came since.
#[derive(Clone, Debug, Default)]
pub(super) struct Approach {
    looks: VecDeque<Look>,
    came: Vec<(Point2, f64)>,
}

impl Approach {
    /// Time goes on.
    pub fn pass(&mut self, dt_s: f64) {
        for look in &mut self.looks {
            look.age_s += dt_s;
        }
        while self.looks.front().is_some_and(|look| look.age_s > UNTIL_S) {
            self.looks.pop_front();
        }
        self.came.retain_mut(|(_, age_s)| {
            *age_s += dt_s;
            *age_s <= MINDED_S
        });
    }

    /// A sonar heard an echo: nothing that answers was nearer in its cone.
    pub fn look(&mut self, world_from_sonar: Pose2, beam_rad: f64, range_m: f64) {
        self.looks.push_back(Look {
            age_s: 0.0,
            sonar_from_world: world_from_sonar.inverse(),
            cos_half: (beam_rad / 2.0).cos(),
            range_m,
            slack_m: SHORT_BY * range_m + SHORT_BY_M,
        });
    }

    /// Notes whether what is heard at `arc`, all of it, was free a moment ago; world frame.
    pub fn hear(&mut self, arc: impl IntoIterator<Item = Point2> + Clone, middle: Point2) {
        if arc.into_iter().all(|point| self.was_free(point)) {
            self.came.retain(|(place, _)| place.distance(middle) > AROUND_M / 2.0);
            self.came.push((middle, 0.0));
        }
    }

    fn was_free(&self, point: Point2) -> bool {
        self.looked(point, FROM_S).any(|(look, far_m)| far_m < look.range_m - look.slack_m)
    }

    /// Whether what is heard at `middle` was heard there a while ago too: it stands; world frame.
    pub fn stands(&self, middle: Point2) -> bool {
        self.looked(middle, STANDS_S).any(|(look, far_m)| (far_m - look.range_m).abs() <= look.slack_m)
    }

    /// Looks at least so old in whose cone a point lies, and how far away in it.
    fn looked(&self, point: Point2, least_s: f64) -> impl Iterator<Item = (&Look, f64)> {
        self.looks.iter().take_while(move |look| look.age_s >= least_s).filter_map(move |look| {
            let at = look.sonar_from_world * point;
            let far_m = at.norm();
            (at.x >= look.cos_half * far_m).then_some((look, far_m))
        })
    }

    /// Whether something came near `point`, world frame.
    pub fn is_near(&self, point: Point2) -> bool {
        self.came.iter().any(|(place, _)| place.distance(point) <= AROUND_M)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEAM_RAD: f64 = std::f64::consts::FRAC_PI_6;
    const DT_S: f64 = 0.1;

    /// Whether anything is heard to come in two seconds, by five sonars that look ahead.
    fn heard(robot: impl Fn(f64) -> Pose2, range_m: impl Fn(f64, Pose2) -> f64) -> bool {
        let mut approach = Approach::default();
        (0..20).any(|tick| {
            let time_s = DT_S * f64::from(tick);
            approach.pass(DT_S);
            let sonars = [-40.0, -20.0, 0.0, 20.0, 40.0_f64]
                .map(|degrees| robot(time_s) * Pose2::new(0.0, 0.0, degrees.to_radians()));
            let echoes = sonars.map(|sonar| (sonar, range_m(time_s, sonar)));
            let came = echoes.iter().any(|&(sonar, range)| {
                let arc = (-3..=3).map(|i| {
                    let (sin, cos) = (BEAM_RAD / 6.0 * f64::from(i)).sin_cos();
                    sonar * Point2::new(range * cos, range * sin)
                });
                let middle = sonar * Point2::new(range, 0.0);
                approach.hear(arc, middle);
                approach.is_near(middle)
            });
            for (sonar, range) in echoes {
                approach.look(sonar, BEAM_RAD, range);
            }
            came
        })
    }

    /// The range of a wall along y at `x_m`, off by up to 1 %.
    fn wall(x_m: f64, sonar: Pose2, time_s: f64) -> f64 {
        let error = 0.01 * (37.0 * time_s + 5.0 * sonar.heading).sin();
        let nearest_rad = (sonar.heading.abs() - BEAM_RAD / 2.0).max(0.0);
        (x_m - sonar.x) / nearest_rad.cos() * (1.0 + error)
    }

    #[test]
    fn a_wall_that_comes_is_heard_to_come_whether_the_robot_stands_or_drives() {
        for speed_mps in [0.0, 0.5] {
            let robot = |time_s: f64| Pose2::new(speed_mps * time_s, 0.0, 0.0);
            assert!(heard(robot, |time_s, sonar| wall(3.0 - 0.2 * time_s, sonar, time_s)));
        }
    }

    #[test]
    fn a_wall_that_stands_or_goes_is_not_heard_to_come_however_the_robot_moves() {
        let motions: [fn(f64) -> Pose2; 3] = [
            |_| Pose2::IDENTITY,
            |time_s| Pose2::new(0.6 * time_s, 0.0, 0.0),
            |time_s| Pose2::new(0.2 * time_s, 0.0, 0.3 * (3.0 * time_s).sin()),
        ];
        for motion in motions {
            assert!(!heard(motion, |time_s, sonar| wall(2.0, sonar, time_s)));
            assert!(!heard(motion, |time_s, sonar| wall(2.0 + 0.3 * time_s, sonar, time_s)));
        }
    }

    #[test]
    fn what_is_heard_where_it_was_before_stands_and_what_comes_does_not() {
        let stands = |speed_mps: f64, comes_mps: f64| {
            let mut approach = Approach::default();
            (0..15).fold(false, |_, tick| {
                let time_s = DT_S * f64::from(tick);
                approach.pass(DT_S);
                let sonar = Pose2::new(speed_mps * time_s, 0.0, 0.0);
                let range = wall(3.0 - comes_mps * time_s, sonar, time_s);
                let stands = approach.stands(sonar * Point2::new(range, 0.0));
                approach.look(sonar, BEAM_RAD, range);
                stands
            })
        };
        assert!(stands(0.0, 0.0) && stands(0.6, 0.0));
        assert!(!stands(0.0, 0.25) && !stands(0.6, 0.25));
    }

    #[test]
    fn what_came_is_forgotten_after_a_while() {
        let mut approach = Approach::default();
        approach.came.push((Point2::new(1.0, 0.0), 0.0));
        assert!(approach.is_near(Point2::new(1.2, 0.3)) && !approach.is_near(Point2::new(1.2, 0.8)));
        (0..16).for_each(|_| approach.pass(DT_S));
        assert!(!approach.is_near(Point2::new(1.0, 0.0)));
    }
}
