//! A lidar's scan matched to a known map, and how well a map explains what was measured.

use super::matching::{MapMatcher, MatchReport};
use super::odometry::Odometry;
use crate::geometry::{Point2, Pose2, wrap_angle};
use crate::robot::RobotProfile;
use crate::world::{Grid, raycast, sonar_echo};

/// Beams used of a scan, evenly spread.
const BEAMS: usize = 72;
/// Standard deviation of a beam's end from the map's surface: half a cell, and the map's own errors.
const SIGMA_M: f64 = 0.04;
/// A beam that the map explains ends within this of its surface \[m\].
const EXPLAINED_M: f64 = 0.15;
/// How likely a reading is, against one that the map explains: shorter than the map has it, and longer.
const SHORT: f64 = 0.12;
const THROUGH_WALLS: f64 = 0.01;

/// How many readings the map explains at a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Explained {
    /// Readings that are as the map predicts them.
    pub explained: usize,
    /// Readings that cannot be at that pose, if the map is right: through walls.
    pub contradicted: usize,
    /// Readings that could be judged.
    pub judged: usize,
}

impl std::ops::Add for Explained {
    type Output = Self;

    fn add(self, more: Self) -> Self {
        Self {
            explained: self.explained + more.explained,
            contradicted: self.contradicted + more.contradicted,
            judged: self.judged + more.judged,
        }
    }
}

impl Explained {
    /// Share of the readings that are as the map predicts them; 0 of none.
    pub fn share(&self) -> f64 {
        self.explained as f64 / self.judged.max(1) as f64
    }

    /// Logarithm of the likelihood of all of them: what the map does not show is there now and then,
    /// what goes through its walls hardly ever. Readings share their errors: each counts as
    /// `independence` of one.
    pub fn log_likelihood(&self, independence: f64) -> f64 {
        let others = self.judged - self.explained - self.contradicted;
        independence * (others as f64 * SHORT.ln() + self.contradicted as f64 * THROUGH_WALLS.ln())
    }

    /// More readings cannot be than `sigmas` of chance leave room for, where `share` of them are of a
    /// right pose (Poisson).
    pub fn is_contradicted(&self, share: f64, sigmas: f64) -> bool {
        let expected = share * self.judged as f64;
        self.contradicted as f64 > expected + sigmas * (expected.sqrt() + 0.75)
    }

    /// Share of the readings that cannot be; 0 of none.
    pub fn share_contradicted(&self) -> f64 {
        self.contradicted as f64 / self.judged.max(1) as f64
    }
}

impl MapMatcher {
    /// An extended Kalman update of `odometry` by each beam of the lidar that ends near a surface of
    /// the map: the signed distance of its end from that surface should be zero.
    pub(super) fn correct_by_lidar(
        &self,
        odometry: &mut Odometry,
        profile: &RobotProfile,
        ranges_m: &[f64],
        report: &mut MatchReport,
    ) {
        let c = &self.config;
        let before = odometry.pose();
        let mut ends = Vec::with_capacity(BEAMS);
        for (_, range_m, beam) in lidar_beams(profile, ranges_m) {
            let end = before * beam * Point2::new(range_m, 0.0);
            match self.field.signed(end).filter(|(away_m, _)| away_m.abs() <= c.gate_m) {
                Some((away_m, out)) => ends.push((end, away_m, out)),
                None => report.rejected += 1,
            }
        }
        let close = ends.iter().filter(|(_, away_m, _)| away_m.abs() <= c.close_m).count();
        let sure = close as f64 > c.close_share * ends.len() as f64;
        let gate_m = if sure { c.close_m } else { c.gate_m };
        for (end, away_m, out) in ends {
            let steepness = out.norm();
            if away_m.abs() > gate_m || steepness < 0.5 {
                report.rejected += 1;
                continue;
            }
            let u = out * (1.0 / steepness);
            let arm = end - before.position();
            let h = [u.x, u.y, u.y * arm.x - u.x * arm.y];
            let pose = odometry.pose();
            let moved = h[0] * (pose.x - before.x)
                + h[1] * (pose.y - before.y)
                + h[2] * wrap_angle(pose.heading - before.heading);
            odometry.update_pose(h, -away_m - moved, SIGMA_M * SIGMA_M / c.independence);
            report.used += 1;
        }
    }

    /// How much of `ranges_m` the map explains for a robot at `world_from_robot`.
    ///
    /// A reading that is shorter than the map predicts may come from something the map does not show.
    /// One that is longer, or none at all before a wall that must answer, contradicts the pose.
    pub fn explained(&self, world_from_robot: Pose2, profile: &RobotProfile, ranges_m: &[f64]) -> Explained {
        let c = &self.config;
        let mut found = Explained::default();
        for (sonar, &range_m) in profile.sonars.iter().zip(ranges_m) {
            if range_m.is_nan() || range_m <= sonar.min_range_m {
                continue;
            }
            let from = world_from_robot * sonar.pose;
            let farthest_m = c.range_m.min(sonar.max_range_m);
            let within_m = c.close_m + 0.5 * c.noise_m_per_m * range_m.min(farthest_m);
            if range_m >= farthest_m {
                // Only a face before it is sure to have been heard, and not from its limit.
                let silent = sonar_echo(&self.walls, from, 0.5 * sonar.beam_rad, 0.7 * farthest_m, c.rays);
                if silent.is_some_and(|echo| echo.on_face) {
                    found.judged += 1;
                    found.contradicted += 1;
                }
                continue;
            }
            let echo = sonar_echo(&self.walls, from, sonar.beam_rad, range_m + c.gate_m, c.rays);
            found.judged += 1;
            found.explained +=
                usize::from(echo.is_some_and(|echo| (echo.range_m - range_m).abs() <= within_m));
            let before_m = range_m - 2.0 * within_m;
            found.contradicted +=
                usize::from(echo.is_some_and(|echo| echo.range_m < before_m && echo.on_face));
        }
        for (_, range_m, beam) in lidar_beams(profile, ranges_m) {
            let from = world_from_robot * beam;
            found.judged += 1;
            let within_m = EXPLAINED_M + 0.01 * range_m;
            let near = self
                .field
                .signed(from * Point2::new(range_m, 0.0))
                .is_some_and(|(away_m, _)| away_m.abs() <= within_m);
            let reaches = reaches(&self.walls, from, range_m - 2.0 * within_m);
            found.explained += usize::from(near && reaches);
            found.contradicted += usize::from(!reaches);
        }
        found
    }
}

/// Nothing of the map stands in the first `way_m` of a beam.
fn reaches(walls: &Grid<bool>, from: Pose2, way_m: f64) -> bool {
    way_m <= 0.0 || raycast(walls, from.position(), from.heading, way_m).is_none()
}

/// (number, range, `robot_from_beam`) of the usable ones of up to [`BEAMS`] beams.
fn lidar_beams<'a>(
    profile: &'a RobotProfile,
    ranges_m: &'a [f64],
) -> impl Iterator<Item = (usize, f64, Pose2)> + 'a {
    let given = ranges_m.get(profile.sonars.len()..).unwrap_or(&[]);
    profile.lidar.iter().flat_map(move |lidar| {
        let used = BEAMS.min(given.len());
        (0..used).filter_map(move |k| {
            let i = k * given.len() / used;
            let range_m = given[i];
            let heading = lidar.pose.heading + lidar.first_rad + i as f64 * lidar.step_rad;
            (range_m > lidar.min_range_m && range_m < lidar.max_range_m)
                .then(|| (i, range_m, Pose2::new(lidar.pose.x, lidar.pose.y, heading)))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_through_walls_speaks_more_against_a_pose_than_what_no_map_shows() {
        let of = |explained, contradicted| Explained { explained, contradicted, judged: 100 };
        assert_eq!(of(100, 0).log_likelihood(0.4), 0.0);
        assert!(of(80, 0).log_likelihood(0.4) < of(90, 0).log_likelihood(0.4));
        assert!(of(80, 20).log_likelihood(0.4) < 2.0 * of(80, 0).log_likelihood(0.4));
        assert_eq!((of(80, 4) + of(60, 2)).judged, 200);
        assert_eq!((of(80, 4) + of(60, 2)).share(), 0.7);
    }

    #[test]
    fn the_share_that_chance_may_contradict_shrinks_with_the_number_of_readings() {
        let of = |judged: usize, percent: usize| Explained {
            contradicted: judged * percent / 100,
            judged,
            explained: 0,
        };
        assert!(!of(50, 6).is_contradicted(0.01, 2.0));
        assert!(of(600, 6).is_contradicted(0.01, 2.0));
        assert!(!of(600, 1).is_contradicted(0.01, 2.0));
        assert!(!Explained::default().is_contradicted(0.01, 2.0));
    }
}
