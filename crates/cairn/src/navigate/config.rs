use serde::{Deserialize, Serialize};

use super::caution::CautionConfig;
use super::keeping::KeepingConfig;
use super::lidar::LidarConfig;
use super::manoeuvre::ManoeuvreConfig;
use super::stall::StallConfig;
use super::trap::TrapConfig;
use crate::avoid::CvmConfig;
use crate::locate::{LocaliserConfig, MatchingConfig, OdometryConfig};
use crate::track::WaypointConfig;
use crate::world::{CostmapConfig, MappingConfig};

/// Everything about navigating that a user may set; every part's own table is inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NavigatorConfig {
    /// Kept between the footprint and everything on the map when planning and looking ahead \[m\].
    pub clearance_m: f64,
    /// Arrived when this near to the goal \[m\].
    pub arrival_m: f64,
    /// An intermediate goal counts as reached when this near \[m\].
    pub intermediate_reach_m: f64,
    /// An avoidance lasts at least this long, unless its goal is reached \[s\].
    pub least_avoidance_s: f64,
    /// The avoider takes over when the tracker's commands could not be stopped from for this long \[s\].
    pub unsafe_s: f64,
    /// Farther off the path than this, the pointers of the field are walked anew \[m\].
    pub off_path_m: f64,
    /// How far a start inside the margin may be from the nearest free place \[m\].
    pub escape_m: f64,
    /// Before a goal is refused, what the map did not show and was seen farther away than this is doubted \[m\],
    pub doubt_m: f64,
    /// and if that does not help, so is what stands nearer, down to this \[m\]:
    pub doubt_near_m: f64,
    /// so often in a task. What is really there is seen again on the way.
    pub doubts: u32,
    /// Plans from about the same place, without getting nearer to the goal, before giving up.
    pub fruitless_plans: u32,
    /// Side of a map cell when there is no map to begin with \[m\].
    pub resolution_m: f64,
    /// How far around robot and goal a map is taken to reach when there is none \[m\].
    pub open_margin_m: f64,
    /// Match ranges to the given map to correct the estimated pose.
    pub match_map: bool,
    /// Localise on the given map: find the pose where no start is given, notice when it is lost and
    /// find it again. Matching is part of it.
    pub localise: bool,
    /// Without a map, the robot stands until what it does not know of the gyro's bias takes it no farther
    /// from its goal than this \[m\],
    pub settle_drift_m: f64,
    /// or it knows the bias this well \[rad/s\],
    pub settle_radps: f64,
    /// but at most this long \[s\].
    pub settle_most_s: f64,
    /// How the field is walked; octile, whatever this says, where no map is given: what sonars have found so
    /// far is not sure enough to pass corners closely by.
    pub path_shape: PathShape,
    /// From a path to waypoints: close together is precise and slow, far apart is fast. The corridor is
    /// for octile paths; any-angle ones are straight where that costs nothing.
    pub waypoints: WaypointConfig,
    /// From occupancy to cost.
    pub costmap: CostmapConfig,
    /// From ranges to occupancy.
    pub mapping: MappingConfig,
    /// Where no map is given, echoes from farther away than this mark nothing either \[m\]: what is heard
    /// from afar closes every gap, and there is no map that knows better.
    pub unmapped_hit_range_m: f64,
    /// From wheels and gyroscope to a pose.
    pub odometry: OdometryConfig,
    /// From ranges and the given map to corrections of that pose.
    pub matching: MatchingConfig,
    /// From ranges and the given map to a pose, whatever was known of it.
    pub localiser: LocaliserConfig,
    /// The curvature velocity method; its latency is the profile's.
    pub avoidance: CvmConfig,
    /// Its weights while it takes the robot around something and back to a way planned on a map.
    pub on_way: WeightsOnWay,
    /// How careful to be where nothing has been seen yet.
    pub caution: CautionConfig,
    /// When a way is left for another one.
    pub keeping: KeepingConfig,
    /// Circles and dead ends.
    pub trap: TrapConfig,
    /// Held by what no sensor shows.
    pub stall: StallConfig,
    /// Turns and straight pieces out of a tight place.
    pub manoeuvre: ManoeuvreConfig,
    /// What gives the heading of (7) while going around something on a planned way.
    pub head_by: HeadBy,
    /// Driving by lidar where no map is given.
    pub lidar: LidarConfig,
}

/// How a field becomes a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PathShape {
    /// Straight wherever the robot fits and it costs no more than going from cell to cell.
    #[default]
    AnyAngle,
    /// From cell to cell in eight directions, down the pointers, as in the paper.
    Octile,
}

/// Where the curvature velocity method heads while it takes the robot around something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeadBy {
    /// To the next free waypoint, as in the paper.
    #[default]
    Waypoint,
    /// Down the cost-to-go field from where the robot is.
    Field,
}

/// Weights of (7) on a known way: what matters is to come back to it, not into side rooms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WeightsOnWay {
    /// a1: speed.
    pub speed_weight: f64,
    /// a2: free arc length.
    pub distance_weight: f64,
    /// a3: heading for the intermediate goal. The three sum to 1.
    pub heading_weight: f64,
}

impl Default for WeightsOnWay {
    fn default() -> Self {
        Self { speed_weight: 0.1, distance_weight: 0.2, heading_weight: 0.7 }
    }
}

impl Default for NavigatorConfig {
    fn default() -> Self {
        Self {
            clearance_m: 0.05,
            arrival_m: 0.1,
            intermediate_reach_m: 0.4,
            least_avoidance_s: 1.0,
            unsafe_s: 1.0,
            off_path_m: 0.6,
            escape_m: 1.0,
            doubt_m: 2.0,
            doubt_near_m: 0.6,
            doubts: 5,
            fruitless_plans: 4,
            resolution_m: 0.05,
            open_margin_m: 4.0,
            match_map: true,
            localise: false,
            settle_drift_m: 0.1,
            settle_radps: 1.5e-4,
            settle_most_s: 20.0,
            path_shape: PathShape::default(),
            waypoints: WaypointConfig::default(),
            costmap: CostmapConfig::default(),
            mapping: MappingConfig::default(),
            unmapped_hit_range_m: 2.0,
            odometry: OdometryConfig::default(),
            matching: MatchingConfig::default(),
            localiser: LocaliserConfig::default(),
            avoidance: CvmConfig { reverse_to_leave: true, ..CvmConfig::default() },
            on_way: WeightsOnWay::default(),
            caution: CautionConfig::default(),
            keeping: KeepingConfig::default(),
            trap: TrapConfig::default(),
            stall: StallConfig::default(),
            manoeuvre: ManoeuvreConfig::default(),
            head_by: HeadBy::default(),
            lidar: LidarConfig::default(),
        }
    }
}

impl NavigatorConfig {
    /// How a path of the shape that is asked for becomes waypoints.
    pub(super) fn spacing(&self) -> WaypointConfig {
        match self.path_shape {
            PathShape::AnyAngle => WaypointConfig { corridor_m: 0.0, ..self.waypoints },
            PathShape::Octile => self.waypoints,
        }
    }

    /// How the map is learnt where none is given.
    pub(super) fn unmapped(&self) -> MappingConfig {
        let sonar_hit_range_m = self.mapping.sonar_hit_range_m.min(self.unmapped_hit_range_m);
        MappingConfig { sonar_hit_range_m, ..self.mapping }
    }

    /// The first length that is not a finite number greater than zero.
    pub(super) fn bad_length(&self) -> Option<(&'static str, f64)> {
        [
            ("arrival_m", self.arrival_m),
            ("intermediate_reach_m", self.intermediate_reach_m),
            ("off_path_m", self.off_path_m),
            ("escape_m", self.escape_m),
            ("settle_radps", self.settle_radps),
            ("doubt_m", self.doubt_m),
            ("unmapped_hit_range_m", self.unmapped_hit_range_m),
            ("least_avoidance_s", self.least_avoidance_s),
            ("unsafe_s", self.unsafe_s),
            ("settle_drift_m", self.settle_drift_m),
            ("resolution_m", self.resolution_m),
            ("open_margin_m", self.open_margin_m),
            ("caution.creep_mps", self.caution.creep_mps),
            ("trap.region_radius_m", self.trap.region_radius_m),
            ("trap.loop_length_m", self.trap.loop_length_m),
            ("trap.progress_m", self.trap.progress_m),
            ("trap.patience_s", self.trap.patience_s),
            ("trap.stray_m", self.trap.stray_m),
            ("trap.detour_m", self.trap.detour_m),
            ("trap.detour_s", self.trap.detour_s),
            ("keeping.shut_s", self.keeping.shut_s),
            ("keeping.again_s", self.keeping.again_s),
            ("keeping.short_detour", self.keeping.short_detour),
            ("keeping.near_m", self.keeping.near_m),
            ("keeping.sure_s", self.keeping.sure_s),
            ("keeping.look_m", self.keeping.look_m),
            ("keeping.gain", self.keeping.gain),
            ("keeping.gain_share", self.keeping.gain_share),
            ("keeping.gain_s", self.keeping.gain_s),
            ("keeping.wait_s", self.keeping.wait_s),
            ("keeping.give_up", self.keeping.give_up),
            ("stall.window_s", self.stall.window_s),
            ("stall.spun_m", self.stall.spun_m),
            ("stall.turned_rad", self.stall.turned_rad),
            ("stall.held_s", self.stall.held_s),
            ("stall.back_off_m", self.stall.back_off_m),
            ("stall.back_off_mps", self.stall.back_off_mps),
            ("stall.silent_s", self.stall.silent_s),
            ("stall.wait_s", self.stall.wait_s),
            ("manoeuvre.stands_s", self.manoeuvre.stands_s),
            ("manoeuvre.stands_m", self.manoeuvre.stands_m),
            ("manoeuvre.stands_rad", self.manoeuvre.stands_rad),
            ("manoeuvre.reach_m", self.manoeuvre.reach_m),
            ("manoeuvre.gain", self.manoeuvre.gain),
            ("manoeuvre.mills_m", self.manoeuvre.mills_m),
            ("manoeuvre.mills_s", self.manoeuvre.mills_s),
            ("manoeuvre.clearance_m", self.manoeuvre.clearance_m),
            ("manoeuvre.least_clearance_m", self.manoeuvre.least_clearance_m),
            ("manoeuvre.speed_mps", self.manoeuvre.speed_mps),
            ("manoeuvre.turn_radps", self.manoeuvre.turn_radps),
            ("doubt_near_m", self.doubt_near_m),
        ]
        .into_iter()
        .find(|(_, value)| !(value.is_finite() && *value > 0.0))
    }
}
