//! Where the robot is on a known map, whatever was known at the start: odometry matched to the map as
//! long as the map explains what is measured, and a set of poses that challenges it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::field::SurfaceField;
use super::history::{History, Place};
use super::matching::{MapMatcher, MatchReport, MatchingConfig, MatchingError};
use super::monte_carlo::{LocaliseError, MonteCarlo, MonteCarloConfig, PoseEstimate};
use super::odometry::Odometry;
use super::survey::{Survey, Surveyed};
use crate::geometry::{Pose2, wrap_angle};
use crate::robot::RobotProfile;
use crate::world::OccupancyGrid;

/// Places of a search that the next one looks at in any case.
const KEPT: usize = 12;
/// A pose that was searched for has proven itself after this way and turn.
const TRIAL: f64 = 6.0;

/// When a pose is believed, doubted and given up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LocaliserConfig {
    /// Of everything drawn.
    pub seed: u64,
    /// Standard deviation of a start that was told \[m\].
    pub start_m: f64,
    /// The same of its heading \[rad\].
    pub start_rad: f64,
    /// What the map explains is averaged over about this time \[s\].
    pub fit_s: f64,
    /// When the map explains a smaller share of the readings than this …
    pub lost_fit: f64,
    /// … and contradicts a greater share than this, or three times this share whatever it explains, the
    /// pose is lost; and none is believed at which it contradicts so many. Things that no map shows make
    /// readings shorter; only a wrong pose makes them go through walls.
    pub lost_contradicted: f64,
    /// A pose that was searched for is believed only when the map explains this share of the last
    /// readings there …
    pub found_fit: f64,
    /// … or this one where the robot has a lidar …
    pub found_fit_lidar: f64,
    /// … and contradicts no more of them than chance would have it where this share is contradicted at a
    /// right pose …
    pub found_contradicted: f64,
    /// … after this way and turn since the search began, metres plus radians …
    pub found_way: f64,
    /// … and when all of them together are likelier there than at any other place of the map by this
    /// difference of logarithms, twice in a row, or by twice this.
    pub found_lead: f64,
    /// The set of poses is of one mind when this share of its weight is around one place …
    pub found_share: f64,
    /// … and that is known this well \[m\].
    pub found_sigma_m: f64,
    /// When the map explains less than this at the pose, the last readings are searched for elsewhere …
    pub doubt_fit: f64,
    /// … and the pose is given up where they are likelier by this than at the pose; by twice this if the map
    /// hardly contradicts it there.
    pub doubt_lead: f64,
    /// A set of poses of one mind corrects the pose when it is elsewhere by more than this \[m\] …
    pub jump_m: f64,
    /// … or this \[rad\] …
    pub jump_rad: f64,
    /// … and the map explains this much more there.
    pub jump_fit: f64,
    /// The set of poses.
    pub monte_carlo: MonteCarloConfig,
}

impl Default for LocaliserConfig {
    fn default() -> Self {
        Self {
            seed: 1,
            start_m: 0.15,
            start_rad: 0.07,
            fit_s: 1.5,
            lost_fit: 0.4,
            lost_contradicted: 0.08,
            found_fit: 0.65,
            found_fit_lidar: 0.75,
            found_contradicted: 0.01,
            found_share: 0.9,
            found_sigma_m: 0.25,
            found_way: 2.0,
            found_lead: 10.0,
            doubt_fit: 0.6,
            doubt_lead: 14.0,
            jump_m: 0.1,
            jump_rad: 0.06,
            jump_fit: 0.1,
            monte_carlo: MonteCarloConfig::default(),
        }
    }
}

impl LocaliserConfig {
    fn check(&self) -> Result<(), LocaliseError> {
        for (key, value, least, most) in [
            ("start_m", self.start_m, 0.0, 100.0),
            ("start_rad", self.start_rad, 0.0, 10.0),
            ("fit_s", self.fit_s, 1e-3, 1e3),
            ("lost_fit", self.lost_fit, 0.0, 1.0),
            ("lost_contradicted", self.lost_contradicted, 0.0, 1.0),
            ("found_fit", self.found_fit, 0.0, 1.0),
            ("found_fit_lidar", self.found_fit_lidar, 0.0, 1.0),
            ("found_contradicted", self.found_contradicted, 0.0, 1.0),
            ("found_share", self.found_share, 0.0, 1.0),
            ("found_sigma_m", self.found_sigma_m, 0.0, 100.0),
            ("found_way", self.found_way, 0.0, 1e3),
            ("found_lead", self.found_lead, 0.0, 1e6),
            ("doubt_fit", self.doubt_fit, 0.0, 1.0),
            ("doubt_lead", self.doubt_lead, 0.0, 1e6),
            ("jump_m", self.jump_m, 0.0, 100.0),
            ("jump_rad", self.jump_rad, 0.0, 10.0),
            ("jump_fit", self.jump_fit, 0.0, 1.0),
        ] {
            if !(value >= least && value <= most) {
                let key = key.to_owned();
                return Err(LocaliseError::LocaliseValueOutOfRange { key, value, least, most });
            }
        }
        Ok(())
    }
}

/// Whether the pose is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LocaliseState {
    /// The map explains what is measured at the pose.
    Tracking,
    /// It does not, or nothing was known at the start: the whole map is searched.
    Searching,
}

/// What one tick did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LocaliseReport {
    /// Whether the pose is known.
    pub state: LocaliseState,
    /// Share of the readings that the map explains at the pose, over the last while.
    pub fit: f64,
    /// Share of the readings that cannot be at the pose, if the map is right.
    pub contradicted: f64,
    /// As `fit`, at the heaviest place of the set of poses.
    pub candidate_fit: f64,
    /// The heaviest place of the set of poses.
    pub candidate: Option<PoseEstimate>,
    /// Poses looked at by a search of the whole map that began in this tick; 0 without one.
    pub searched: usize,
    /// How much likelier the last readings are, all together, at the best place than at any other (while
    /// the pose is believed: at it than at any other), where a search of the whole map ended in this
    /// tick: a difference of logarithms.
    pub lead: Option<f64>,
    /// The pose was moved to the candidate: by (x, y, heading), world frame.
    pub jump: Option<Pose2>,
    /// What matching readings to the map did.
    pub matching: Option<MatchReport>,
}

/// Share of readings explained, averaged over the last while.
#[derive(Clone, Copy, Debug, Default)]
struct Fit {
    value: f64,
    contradicted: f64,
    seen_s: f64,
}

impl Fit {
    /// Too few readings say nothing.
    const LEAST: usize = 3;

    fn add(&mut self, explained: super::scan::Explained, dt_s: f64, over_s: f64) {
        if explained.judged < Self::LEAST {
            return;
        }
        self.seen_s += dt_s;
        let share = explained.explained as f64 / explained.judged as f64;
        // A plain mean at first.
        let gain = (dt_s / over_s).max(dt_s / self.seen_s).min(1.0);
        self.value += gain * (share - self.value);
        let against = explained.contradicted as f64 / explained.judged as f64;
        self.contradicted += gain * (against - self.contradicted);
    }

    fn has_lasted(&self, for_s: f64) -> bool {
        self.seen_s >= for_s
    }
}

/// Keeps a pose on a known map, finds it when nothing is known, and notices when it is wrong.
///
/// [`MapMatcher`] corrects the pose a little at each tick. A set of poses ([`MonteCarlo`]) is weighed
/// beside it: where the map explains more at its heaviest place, the pose goes there. When the map
/// explains too little at the pose, all of the map is searched, and the pose is only moved to what has
/// proven itself on the way.
#[derive(Clone, Debug)]
pub struct Localiser {
    config: LocaliserConfig,
    matcher: MapMatcher,
    monte_carlo: MonteCarlo,
    state: LocaliseState,
    fit: Fit,
    candidate_fit: Fit,
    /// Pose after the last tick.
    last: Option<Pose2>,
    /// Metres and radians since the pose was believed, doubted or given up.
    way: f64,
    /// What was measured on that way.
    history: History,
    /// A search of the whole map under way, and the readings kept since it began.
    survey: Option<Survey>,
    news: usize,
    /// Places that were best in the last search, best first, where the robot would be by now.
    best: Vec<Pose2>,
    /// The first of them was the best by far in so many searches one after another.
    wins: u32,
    /// The map explains too little at the pose.
    doubts: bool,
    /// The pose was searched for, and has yet to prove itself.
    on_trial: bool,
    lead: Option<f64>,
    /// There was a pose before this search.
    had_pose: bool,
    begun: bool,
}

/// Why a localiser was refused: one of its parts.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize)]
#[serde(untagged)]
pub enum LocaliserError {
    /// The set of poses, the map or the profile.
    #[error(transparent)]
    Localise(#[from] LocaliseError),
    /// The matcher.
    #[error(transparent)]
    Matching(#[from] MatchingError),
}

impl Localiser {
    /// A localiser on `map`. `knows_start`: the odometry begins at a pose that is about right;
    /// otherwise the robot may be anywhere.
    ///
    /// # Errors
    /// [`LocaliserError`] names the setting, or what is wrong with the map or the profile.
    pub fn new(
        config: &LocaliserConfig,
        matching: &MatchingConfig,
        profile: &RobotProfile,
        map: &OccupancyGrid,
        knows_start: bool,
    ) -> Result<Self, LocaliserError> {
        config.check()?;
        let field = Arc::new(SurfaceField::new(map));
        let mut monte_carlo = MonteCarlo::on(&config.monte_carlo, profile, map, field.clone(), config.seed)?;
        // Where there is no room for a search, that is said now, and not once it is needed.
        monte_carlo.lattice()?;
        Ok(Self {
            matcher: MapMatcher::on(matching, map, field)?,
            monte_carlo,
            state: if knows_start { LocaliseState::Tracking } else { LocaliseState::Searching },
            fit: Fit::default(),
            candidate_fit: Fit::default(),
            last: None,
            way: 0.0,
            history: History::default(),
            survey: None,
            news: 0,
            best: Vec::new(),
            wins: 0,
            doubts: false,
            on_trial: false,
            lead: None,
            had_pose: false,
            begun: false,
            config: LocaliserConfig {
                found_fit: if profile.lidar.is_some() { config.found_fit_lidar } else { config.found_fit },
                ..*config
            },
        })
    }

    /// Whether the pose is known.
    pub fn state(&self) -> LocaliseState {
        self.state
    }

    /// The set of poses.
    pub fn monte_carlo(&self) -> &MonteCarlo {
        &self.monte_carlo
    }

    /// Forgets the pose: the robot may be anywhere.
    pub fn forget(&mut self) {
        self.state = LocaliseState::Searching;
        self.had_pose = false;
        self.begun = false;
    }

    /// The pose of the odometry was set from outside; the set of poses begins around it.
    pub fn believe(&mut self) {
        self.state = LocaliseState::Tracking;
        self.begun = false;
    }

    /// One tick: corrects `odometry`, whose pose is of now, by `ranges_m` taken at it.
    ///
    /// While searching, the pose of the odometry is not moved until one is found: it is then the old
    /// one, carried on by wheels and gyroscope.
    ///
    /// # Errors
    /// [`LocaliserError`] when there are not as many ranges as sensors.
    pub fn correct(
        &mut self,
        odometry: &mut Odometry,
        profile: &RobotProfile,
        ranges_m: &[f64],
        dt_s: f64,
    ) -> Result<LocaliseReport, LocaliserError> {
        self.monte_carlo.check(ranges_m)?;
        let now = odometry.pose();
        let motion = self.last.map_or(Pose2::IDENTITY, |last| last.inverse() * now);
        let mut searched = 0;
        if self.begun {
            self.monte_carlo.predict(motion)?;
            self.history.note(motion);
            if let Some(survey) = &mut self.survey {
                survey.note(motion);
            }
            for place in &mut self.best {
                *place = *place * motion;
            }
            self.way += motion.x.hypot(motion.y) + motion.heading.abs();
        } else {
            self.begin(now, ranges_m)?;
        }
        self.lead = None;
        let tracking = self.state == LocaliseState::Tracking;
        if (!tracking || self.doubts || self.on_trial) && self.history.is_due() {
            self.history.keep(self.monte_carlo.scan(ranges_m), ranges_m);
            self.news += 1;
        }
        let matching = if tracking { Some(self.matcher.correct(odometry, profile, ranges_m)?) } else { None };
        if self.monte_carlo.is_due() {
            self.monte_carlo.update(ranges_m)?;
        }

        let pose = odometry.pose();
        let candidate = self.monte_carlo.estimate();
        self.fit.add(self.matcher.explained(pose, profile, ranges_m), dt_s, self.config.fit_s);
        if let Some(candidate) = candidate {
            let explained = self.matcher.explained(candidate.pose, profile, ranges_m);
            self.candidate_fit.add(explained, dt_s, self.config.fit_s);
        }
        let found = self.survey(odometry.pose(), &mut searched)?;
        let jump = match self.state {
            LocaliseState::Tracking => self.track(odometry, candidate, found, ranges_m)?,
            LocaliseState::Searching => self.seek(odometry, found, ranges_m)?,
        };
        self.last = Some(odometry.pose());
        Ok(LocaliseReport {
            state: self.state,
            fit: self.fit.value,
            contradicted: self.fit.contradicted,
            candidate_fit: self.candidate_fit.value,
            candidate,
            searched,
            lead: self.lead,
            jump,
            matching,
        })
    }

    /// The set of poses begins anew: around the pose, or at nothing until a search has found places.
    fn begin(&mut self, pose: Pose2, ranges_m: &[f64]) -> Result<(), LocaliserError> {
        self.begun = true;
        self.clear();
        self.candidate_fit = Fit::default();
        if self.state == LocaliseState::Searching {
            self.monte_carlo.forget();
            return Ok(());
        }
        self.fit = Fit::default();
        self.monte_carlo.spread(pose, self.config.start_m, self.config.start_rad)?;
        self.monte_carlo.update(ranges_m)?; // what was told is only about right
        Ok(())
    }

    /// The pose is believed: does the set of poses know better? Does the map still explain it?
    fn track(
        &mut self,
        odometry: &mut Odometry,
        candidate: Option<PoseEstimate>,
        found: Option<Surveyed>,
        ranges_m: &[f64],
    ) -> Result<Option<Pose2>, LocaliserError> {
        let c = self.config;
        let pose = odometry.pose();
        let known = self.fit.has_lasted(0.5 * c.fit_s) && self.candidate_fit.has_lasted(0.5 * c.fit_s);
        if let Some(candidate) = candidate.filter(|candidate| known && self.is_elsewhere(pose, candidate)) {
            let better = self.candidate_fit.value - self.fit.value;
            if better >= c.jump_fit
                && candidate.share >= c.found_share
                && candidate.sigma_m() <= c.found_sigma_m
            {
                return Ok(Some(self.jump(odometry, &candidate)));
            }
            if better <= -c.jump_fit {
                // It is the set of poses that has gone astray.
                self.monte_carlo.spread(pose, c.start_m, c.start_rad)?;
                self.candidate_fit = Fit::default();
            }
        }
        if let Some(found) = found {
            let lead = found.elsewhere().map_or(f64::INFINITY, |best| found.own.score - best.score);
            self.lead = Some(lead);
            let own = found.own.explained;
            // A pose that was kept until now, and at which no reading goes through a wall, has that for it: things
            // that no map shows may be likelier echoes at another place.
            let refuted = own.share_contradicted() > 0.5 * c.lost_contradicted;
            let enough = if refuted { c.doubt_lead } else { 2.0 * c.doubt_lead };
            if lead < -enough && self.is_proven(&found) {
                return self.move_to(odometry, found.places[0]);
            }
            let against = if self.on_trial {
                own.is_contradicted(c.found_contradicted, 4.0)
            } else {
                own.share_contradicted() > c.lost_contradicted
            };
            let wrong = against && (self.on_trial || lead < -c.doubt_lead);
            if wrong {
                self.state = LocaliseState::Searching;
                self.had_pose = !self.on_trial;
                (self.on_trial, self.doubts) = (false, false);
                self.fit = Fit::default();
                self.monte_carlo.gather(&found.places);
                self.candidate_fit = Fit::default();
                return Ok(None);
            }
            let proven = lead > 2.0 * c.found_lead || self.way > 4.0 * TRIAL;
            if self.on_trial && self.way > TRIAL && proven {
                self.clear();
            }
        }
        let against = self.fit.contradicted > 0.5 * c.lost_contradicted;
        let enough = c.doubt_fit + if self.doubts { 0.1 } else { 0.0 };
        let doubts = known && !self.on_trial && (against || self.fit.value < enough);
        if doubts != self.doubts {
            self.clear();
            self.doubts = doubts;
        }
        // At rest there is nothing new to weigh: it may take a little longer.
        let judged = self.fit.has_lasted(if self.way > 0.5 { c.fit_s } else { 4.0 * c.fit_s });
        let astray = |fit: Fit| {
            fit.contradicted > c.lost_contradicted
                && (fit.value < c.lost_fit || fit.contradicted > 3.0 * c.lost_contradicted)
        };
        if judged && astray(self.fit) && astray(self.candidate_fit) {
            self.state = LocaliseState::Searching;
            self.had_pose = true;
            self.fit = Fit::default();
            self.begin(pose, ranges_m)?;
        }
        Ok(None)
    }

    /// The pose is lost: has one been found? Was the old one right after all?
    fn seek(
        &mut self,
        odometry: &mut Odometry,
        found: Option<Surveyed>,
        ranges_m: &[f64],
    ) -> Result<Option<Pose2>, LocaliserError> {
        let c = self.config;
        if let Some(found) = found {
            self.lead = Some(found.lead());
            if self.is_proven(&found) {
                return self.move_to(odometry, found.places[0]);
            }
            self.monte_carlo.gather(&found.places);
            self.candidate_fit = Fit::default();
        }
        // Something stood in the way of its eyes, or an unmapped wall: the old pose was right.
        let old = self.had_pose && self.fit.has_lasted(2.0 * c.fit_s);
        if old && self.fit.value >= c.found_fit && self.fit.contradicted < 0.3 * c.lost_contradicted {
            self.state = LocaliseState::Tracking;
            self.begin(odometry.pose(), ranges_m)?;
        }
        Ok(None)
    }

    /// Searches all of the map by the last readings, a little each tick.
    fn survey(&mut self, pose: Pose2, searched: &mut usize) -> Result<Option<Surveyed>, LocaliserError> {
        let first = self.state == LocaliseState::Searching && self.best.is_empty() && self.news > 0;
        if self.survey.is_none() && (first || self.news >= 2 && self.history.len() >= 4) {
            self.news = 0;
            self.survey = self.monte_carlo.survey(&self.history, &self.best)?;
            *searched += self.survey.as_ref().map_or(0, Survey::poses);
        }
        let Some(survey) = &mut self.survey else { return Ok(None) };
        let found = self.monte_carlo.advance(survey, &self.matcher, pose);
        if let Some(found) = &found {
            self.survey = None;
            let again = self.best.first().is_some_and(|best| found.places[0].is_near(*best));
            let leads = found.lead() >= self.config.found_lead;
            self.wins = if !leads {
                0
            } else if again {
                self.wins + 1
            } else {
                1
            };
            self.best = found.places.iter().take(KEPT).map(|place| place.pose).collect();
        }
        Ok(found)
    }

    /// The best place may be vouched for: all that was measured on the way is likelier there than at
    /// any other place, and as the map has it.
    fn is_proven(&self, found: &Surveyed) -> bool {
        let c = self.config;
        let wins = self.wins >= 2 || found.lead() > 2.0 * c.found_lead;
        let all = found.places[0].explained;
        self.way >= c.found_way
            && found.lead() >= c.found_lead
            && wins
            && all.share() >= c.found_fit
            && !all.is_contradicted(c.found_contradicted, 2.0)
    }

    fn clear(&mut self) {
        self.way = 0.0;
        self.history.clear();
        self.survey = None;
        (self.news, self.wins) = (0, 0);
        (self.doubts, self.on_trial) = (false, false);
        self.best.clear();
    }

    /// Believes a place that was searched for.
    fn move_to(&mut self, odometry: &mut Odometry, place: Place) -> Result<Option<Pose2>, LocaliserError> {
        let before = odometry.pose();
        let variances = [0.0025, 0.0025, 0.0009];
        let covariance =
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { variances[i] } else { 0.0 }));
        odometry.relocate(place.pose, &covariance);
        self.state = LocaliseState::Tracking;
        (self.doubts, self.on_trial, self.way) = (false, true, 0.0);
        self.fit = Fit::default();
        self.candidate_fit = Fit::default();
        self.monte_carlo.spread(place.pose, 0.1, 0.05)?;
        Ok(Some(difference(place.pose, before)))
    }

    fn is_elsewhere(&self, pose: Pose2, candidate: &PoseEstimate) -> bool {
        candidate.pose.position().distance(pose.position()) > self.config.jump_m
            || wrap_angle(candidate.pose.heading - pose.heading).abs() > self.config.jump_rad
    }

    fn jump(&mut self, odometry: &mut Odometry, candidate: &PoseEstimate) -> Pose2 {
        let before = odometry.pose();
        odometry.relocate(candidate.pose, &candidate.covariance);
        self.fit = self.candidate_fit;
        difference(candidate.pose, before)
    }
}

fn difference(now: Pose2, before: Pose2) -> Pose2 {
    Pose2::new(now.x - before.x, now.y - before.y, now.heading - before.heading)
}
