//! A search of the whole map by all of the last readings together: a lattice of poses, weighed by some
//! readings, halved, weighed by more. A little of it each tick.

use std::sync::Arc;

use super::beams::{Poses, Tables};
use super::field::SurfaceField;
use super::history::{History, Place};
use super::matching::MapMatcher;
use super::monte_carlo::MonteCarloConfig;
use super::scan::Explained;
use crate::geometry::Pose2;
use crate::robot::RobotProfile;

/// Readings times poses that are weighed in one tick.
const PER_TICK: usize = 1_600_000;
/// All of the lattice is weighed by frames that have this many readings together.
const AT_FIRST: usize = 36;
/// Poses of the lattice that are looked at by more frames, and the least of them by all.
const KEPT: usize = 20_000;
const LEAST: usize = 2_000;
/// Frames after which the worse half is left out.
const HALVED_AFTER: usize = 4;
/// Places told apart and looked at closely.
const PLACES: usize = 40;
/// Of these, what the map explains is asked by so many frames in one tick …
const JUDGED_PER_TICK: usize = 48;
/// … and only where they agree about as well as the best.
const JUDGED_BEHIND: f64 = 25.0;

/// Poses between which a robot that may be anywhere is looked for.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    pub poses: Poses,
    pub pitch_m: f64,
    pub turn_rad: f64,
}

/// What a search found: poses of now in the world.
#[derive(Clone, Debug)]
pub(super) struct Surveyed {
    /// Places that agree best with all readings, best first.
    pub places: Vec<Place>,
    /// The best place near to the pose that was asked for.
    pub own: Place,
}

impl Surveyed {
    /// The best place that is not near to the pose that was asked for.
    pub(super) fn elsewhere(&self) -> Option<Place> {
        self.places.iter().copied().find(|place| !place.is_near(self.own.pose))
    }

    /// How much better the best place agrees than all others: a difference of logarithms.
    pub(super) fn lead(&self) -> f64 {
        match &self.places[..] {
            [best, next, ..] => best.score - next.score,
            _ => f64::INFINITY,
        }
    }
}

/// What a search looks at the map with.
pub(super) struct Seeing<'a> {
    pub field: &'a SurfaceField,
    pub config: &'a MonteCarloConfig,
    pub fine: &'a Tables,
    pub matcher: &'a MapMatcher,
    pub profile: &'a RobotProfile,
    pub world_from_map: Pose2,
}

/// A search under way.
#[derive(Clone, Debug)]
pub(super) struct Survey {
    history: History,
    lattice: Arc<Lattice>,
    /// Looked at closely in any case.
    starts: Vec<Pose2>,
    /// The frame whose pose is looked for: those before and after it are near.
    anchor: usize,
    /// Frames, nearest to the anchor first.
    order: Vec<usize>,
    /// Frames done, and poses done by the one under way.
    frame: usize,
    pose: usize,
    /// Poses left; all of the lattice while None.
    kept: Option<Poses>,
    sums: Vec<f32>,
    /// Where to look closely, the pose asked for first.
    rough: Vec<Pose2>,
    /// What was found there, how many of them were judged, and whether all were looked at.
    places: Vec<Place>,
    is_refined: bool,
    judged: usize,
    /// Of the frames that weigh all of the lattice.
    at_first: usize,
    /// Robot's motion since the search began.
    begin_from_now: Pose2,
}

impl Survey {
    /// A search by all that `history` keeps, near `starts` in any case (poses of now in the map's frame).
    /// None where it keeps nothing.
    pub(super) fn new(history: &History, lattice: Arc<Lattice>, starts: &[Pose2]) -> Option<Self> {
        let frames = history.len();
        let anchor = frames.checked_sub(1)? / 2;
        let mut order: Vec<usize> = (0..frames).collect();
        order.sort_by_key(|k| (k.abs_diff(anchor), *k));
        let mut readings = 0;
        let enough = order.iter().position(|&k| {
            readings += history.readings(k);
            readings >= AT_FIRST
        });
        Some(Self {
            starts: starts.to_vec(),
            sums: vec![0.0; lattice.poses.len()],
            history: history.clone(),
            anchor,
            at_first: enough.map_or(frames, |k| k + 1).min(3),
            order,
            frame: 0,
            pose: 0,
            kept: None,
            rough: Vec::new(),
            places: Vec::new(),
            is_refined: false,
            judged: 0,
            lattice,
            begin_from_now: Pose2::IDENTITY,
        })
    }

    /// The robot has moved, `before_from_now`.
    pub(super) fn note(&mut self, before_from_now: Pose2) {
        self.begin_from_now = self.begin_from_now * before_from_now;
    }

    /// Poses that are looked at.
    pub(super) fn poses(&self) -> usize {
        self.lattice.poses.len()
    }

    /// Goes on for a tick. At the end: the places that agree best with all readings, and the one near to
    /// `about`.
    pub(super) fn advance(&mut self, seeing: &Seeing<'_>, about: Pose2) -> Option<Surveyed> {
        let mut left = PER_TICK;
        while let Some(&k) = self.order.get(self.frame) {
            let anchor_from_then = self.history.anchor_from(self.anchor, k);
            let tables = self.forgiving(seeing.config, anchor_from_then);
            let readings = self.history.readings(k).max(1);
            let poses = self.kept.as_ref().unwrap_or(&self.lattice.poses);
            let upto = (self.pose + left / readings).min(poses.len());
            let part = poses.part(self.pose..upto);
            let sums = &mut self.sums[self.pose..upto];
            self.history.weigh(k, anchor_from_then, seeing.field, &tables, &part, sums);
            left -= (upto - self.pose) * readings;
            if upto < poses.len() {
                self.pose = upto;
                return None;
            }
            (self.frame, self.pose) = (self.frame + 1, 0);
            self.halve();
        }
        if !self.is_refined {
            if self.rough.is_empty() {
                let about = seeing.world_from_map.inverse() * about * self.begin_from_now.inverse();
                self.rough = self.starts_with(about);
            }
            let readings: usize = (0..self.history.len()).map(|k| self.history.readings(k)).sum();
            let at_once = (PER_TICK / (readings.max(1) * History::REFINED_BY)).max(1);
            let next = (self.places.len() + at_once).min(self.rough.len());
            for about in &self.rough[self.places.len()..next] {
                self.places.push(self.history.refine(seeing.field, seeing.fine, *about));
            }
            self.is_refined = next == self.rough.len();
            if self.is_refined {
                self.sift();
            }
            return None;
        }
        let at_once = (JUDGED_PER_TICK / self.history.len().max(1)).max(1);
        let next = (self.judged + at_once).min(self.places.len());
        for place in &mut self.places[self.judged..next] {
            let world_from_robot = seeing.world_from_map * place.pose;
            place.explained = self.history.explained(seeing.matcher, seeing.profile, world_from_robot);
            place.score = place.explained.log_likelihood(seeing.config.independence);
        }
        self.judged = next;
        (next == self.places.len()).then(|| self.surveyed(seeing.world_from_map))
    }

    /// Tables that forgive what the lattice is apart, seen from the anchor.
    fn forgiving(&self, config: &MonteCarloConfig, anchor_from_then: Pose2) -> Tables {
        let Lattice { pitch_m, turn_rad, .. } = *self.lattice;
        let lever_m = anchor_from_then.position().norm();
        Tables::new(config, (0.4 * pitch_m).hypot(0.3 * turn_rad * lever_m), 0.3 * turn_rad)
    }

    /// After some frames: goes on with the better poses only.
    fn halve(&mut self) {
        let poses = self.kept.as_ref().unwrap_or(&self.lattice.poses);
        let most = match self.frame.checked_sub(self.at_first) {
            None => return,
            Some(0) => KEPT,
            Some(more) if more % HALVED_AFTER == 0 => (poses.len() / 2).max(LEAST),
            Some(_) => return,
        };
        let mut best: Vec<u32> = (0..poses.len() as u32).collect();
        if best.len() > most {
            let sums = &self.sums;
            best.select_nth_unstable_by(most, |&a, &b| by_sum(sums, a, b));
            best.truncate(most);
            best.sort_unstable();
        }
        let mut kept = Poses::default();
        for &i in &best {
            let i = i as usize;
            kept.push(poses.x[i], poses.y[i], poses.heading[i]);
        }
        self.sums = best.iter().map(|&i| self.sums[i as usize]).collect();
        self.kept = Some(kept);
    }

    /// The pose asked for, those to begin at in any case, and the best of the lattice.
    fn starts_with(&self, about: Pose2) -> Vec<Pose2> {
        let poses = self.kept.as_ref().unwrap_or(&self.lattice.poses);
        let anchor_from_begin = self.history.anchor_from_now(self.anchor);
        let mut order: Vec<u32> = (0..poses.len() as u32).collect();
        order.sort_unstable_by(|&a, &b| by_sum(&self.sums, a, b));
        let mut found: Vec<Place> = Vec::new();
        for i in order.into_iter().map(|i| i as usize) {
            let (x, y) = (f64::from(poses.x[i]), f64::from(poses.y[i]));
            let pose = Pose2::new(x, y, f64::from(poses.heading[i])) * anchor_from_begin;
            if found.iter().all(|place| !place.is_near(pose)) {
                found.push(Place { pose, score: 0.0, explained: Explained::default() });
            }
            if found.len() == PLACES {
                break;
            }
        }
        let best = found.iter().map(|place| place.pose);
        std::iter::once(about).chain(self.starts.iter().copied()).chain(best).collect()
    }

    /// Of the places looked at closely: the first, and each other one that agrees about as well as the
    /// best and is not near to a better one.
    fn sift(&mut self) {
        let own = self.places[0];
        self.places.sort_by(|a, b| b.score.total_cmp(&a.score));
        let least = self.places[0].score - JUDGED_BEHIND;
        let mut places = vec![own];
        for place in self.places.iter().filter(|place| place.score >= least) {
            if places.iter().all(|better| !better.is_near(place.pose)) {
                places.push(*place);
            }
        }
        self.places = places;
    }

    fn surveyed(&self, world_from_map: Pose2) -> Surveyed {
        let mut places = self.places.clone();
        for place in &mut places {
            place.pose = world_from_map * place.pose * self.begin_from_now;
        }
        let own = places[0];
        places.sort_by(|a, b| b.score.total_cmp(&a.score));
        Surveyed { places, own }
    }
}

fn by_sum(sums: &[f32], a: u32, b: u32) -> std::cmp::Ordering {
    sums[b as usize].total_cmp(&sums[a as usize]).then(a.cmp(&b))
}

#[cfg(test)]
mod tests {
    use crate::geometry::Pose2;
    use crate::locate::history::History;
    use crate::locate::{MapMatcher, MatchingConfig, MonteCarlo, MonteCarloConfig};
    use crate::robot::{Drive, Footprint, Limits, RobotProfile, Sonar};
    use crate::world::{Grid, GridGeometry, Occupancy, OccupancyGrid, raycast};

    fn robot() -> RobotProfile {
        let sonar = |k: i32| Sonar {
            pose: Pose2::new(0.0, 0.0, f64::from(k) * std::f64::consts::FRAC_PI_8),
            beam_rad: 0.05,
            min_range_m: 0.1,
            max_range_m: 5.0,
        };
        RobotProfile {
            name: "test".to_owned(),
            footprint: Footprint { length_m: 0.4, width_m: 0.4 },
            limits: Limits { linear_mps: 0.5, angular_radps: 1.0, linear_mps2: 0.5, angular_radps2: 1.0 },
            drive: Drive { effective_track_m: 0.4, latency_s: 0.0 },
            sonars: (0..16).map(sonar).collect(),
            lidar: None,
        }
    }

    /// A room of 6 × 4 m; with a cupboard it looks different from every pose.
    fn room(cupboard: bool) -> OccupancyGrid {
        let geometry =
            GridGeometry { rows: 80, cols: 120, resolution_m: 0.05, world_from_grid: Pose2::IDENTITY };
        let stands = |i: usize| {
            let (row, col) = (i / 120, i % 120);
            let wall = !(2..78).contains(&row) || !(2..118).contains(&col);
            wall || cupboard && row < 20 && (60..80).contains(&col)
        };
        let cells =
            (0..geometry.len()).map(|i| if stands(i) { Occupancy::Occupied } else { Occupancy::Free });
        Grid::new(geometry, cells.collect())
    }

    /// How far the truth is ahead of the best other place after a short drive.
    fn lead(cupboard: bool) -> f64 {
        let (robot, map) = (robot(), room(cupboard));
        let occupied =
            Grid::new(map.geometry, map.values.iter().map(|c| *c == Occupancy::Occupied).collect());
        let mut poses = MonteCarlo::new(&MonteCarloConfig::default(), &robot, &map, 1).unwrap();
        let (mut truth, step) = (Pose2::new(1.2, 2.6, -0.2), Pose2::new(0.15, 0.0, 0.05));
        let mut history = History::default();
        for _ in 0..16 {
            let ranges: Vec<f64> = robot
                .sonars
                .iter()
                .map(|sonar| {
                    let from = truth * sonar.pose;
                    raycast(&occupied, from.position(), from.heading, 5.0).unwrap_or(f64::INFINITY)
                })
                .collect();
            if history.is_due() {
                history.keep(poses.scan(&ranges), &ranges);
            }
            truth = truth * step;
            history.note(step);
        }
        let matcher = MapMatcher::new(&MatchingConfig::default(), &map).unwrap();
        let mut survey = poses.survey(&history, &[]).unwrap().unwrap();
        let found = (0..1000).find_map(|_| poses.advance(&mut survey, &matcher, truth)).unwrap();
        found.elsewhere().map_or(f64::INFINITY, |best| found.own.score - best.score)
    }

    #[test]
    fn the_truth_leads_where_every_place_looks_different_and_nothing_does_in_a_symmetric_room() {
        assert!(lead(true) > 4.0, "{}", lead(true));
        assert!(lead(false).abs() < 2.0, "{}", lead(false));
    }
}
