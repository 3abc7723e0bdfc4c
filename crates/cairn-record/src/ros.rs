//! ROS 2 messages: their definitions as a log carries them, and how they are laid out.

use cairn::geometry::{Point2, Pose2, Twist2};
use cairn::robot::{Lidar, Sonar};
use cairn::world::Occupancy;

use crate::cdr::Cdr;
use crate::recorder::MapSnapshot;

/// A message type with those it is made of; every log carries the text, so any reader can decode it.
pub struct Definition {
    pub name: &'static str,
    text: &'static str,
    parts: &'static [&'static Definition],
}

impl Definition {
    /// The definition followed by those it needs, each once, as rosbag2 writes them.
    pub fn full_text(&self) -> String {
        let mut seen = Vec::new();
        self.collect(&mut seen);
        let mut text = self.text.to_owned();
        for part in seen {
            let name = part.name.replace("/msg/", "/");
            text.push_str(&format!("{}\nMSG: {name}\n{}", "=".repeat(80), part.text));
        }
        text
    }

    fn collect(&self, seen: &mut Vec<&'static Definition>) {
        for &part in self.parts {
            if !seen.iter().any(|known| known.name == part.name) {
                seen.push(part);
                part.collect(seen);
            }
        }
    }
}

macro_rules! definitions {
    ($($id:ident = $name:literal [$($part:ident),*] $text:literal;)*) => {
        $(pub static $id: Definition = Definition { name: $name, text: $text, parts: &[$(&$part),*] };)*
    };
}

definitions! {
    TIME = "builtin_interfaces/msg/Time" [] "int32 sec\nuint32 nanosec\n";
    HEADER = "std_msgs/msg/Header" [TIME] "builtin_interfaces/Time stamp\nstring frame_id\n";
    POINT = "geometry_msgs/msg/Point" [] "float64 x\nfloat64 y\nfloat64 z\n";
    QUATERNION = "geometry_msgs/msg/Quaternion" []
        "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n";
    VECTOR3 = "geometry_msgs/msg/Vector3" [] "float64 x\nfloat64 y\nfloat64 z\n";
    POSE = "geometry_msgs/msg/Pose" [POINT, QUATERNION]
        "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n";
    TWIST = "geometry_msgs/msg/Twist" [VECTOR3]
        "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n";
    POSE_COVARIANCE = "geometry_msgs/msg/PoseWithCovariance" [POSE]
        "geometry_msgs/Pose pose\nfloat64[36] covariance\n";
    TWIST_COVARIANCE = "geometry_msgs/msg/TwistWithCovariance" [TWIST]
        "geometry_msgs/Twist twist\nfloat64[36] covariance\n";
    POSE_STAMPED = "geometry_msgs/msg/PoseStamped" [HEADER, POSE]
        "std_msgs/Header header\ngeometry_msgs/Pose pose\n";
    POSE_COVARIANCE_STAMPED = "geometry_msgs/msg/PoseWithCovarianceStamped" [HEADER, POSE_COVARIANCE]
        "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n";
    TWIST_STAMPED = "geometry_msgs/msg/TwistStamped" [HEADER, TWIST]
        "std_msgs/Header header\ngeometry_msgs/Twist twist\n";
    TRANSFORM = "geometry_msgs/msg/Transform" [VECTOR3, QUATERNION]
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n";
    TRANSFORM_STAMPED = "geometry_msgs/msg/TransformStamped" [HEADER, TRANSFORM]
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n";
    TF = "tf2_msgs/msg/TFMessage" [TRANSFORM_STAMPED] "geometry_msgs/TransformStamped[] transforms\n";
    ODOMETRY = "nav_msgs/msg/Odometry" [HEADER, POSE_COVARIANCE, TWIST_COVARIANCE]
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n";
    PATH = "nav_msgs/msg/Path" [HEADER, POSE_STAMPED]
        "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n";
    MAP_META_DATA = "nav_msgs/msg/MapMetaData" [TIME, POSE]
        "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\ngeometry_msgs/Pose origin\n";
    OCCUPANCY_GRID = "nav_msgs/msg/OccupancyGrid" [HEADER, MAP_META_DATA]
        "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data\n";
    RANGE = "sensor_msgs/msg/Range" [HEADER]
        "uint8 ULTRASOUND=0\nuint8 INFRARED=1\nstd_msgs/Header header\nuint8 radiation_type\nfloat32 field_of_view\nfloat32 min_range\nfloat32 max_range\nfloat32 range\nfloat32 variance\n";
    LASER_SCAN = "sensor_msgs/msg/LaserScan" [HEADER]
        "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\nfloat32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\nfloat32[] intensities\n";
    LOG = "rcl_interfaces/msg/Log" [TIME]
        "byte DEBUG=10\nbyte INFO=20\nbyte WARN=30\nbyte ERROR=40\nbyte FATAL=50\nbuiltin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\nstring function\nuint32 line\n";
}

/// Nanoseconds since the run began.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stamp(pub u64);

impl Stamp {
    /// From seconds, to the microsecond: sums of ticks come out round.
    pub fn from_s(time_s: f64) -> Self {
        Self((time_s.max(0.0) * 1e6).round() as u64 * 1000)
    }
}

/// The frame of the map.
pub const MAP_FRAME: &str = "map";

const INFO: u8 = 20;
const WARN: u8 = 30;

fn time(cdr: &mut Cdr, at: Stamp) {
    cdr.i32((at.0 / 1_000_000_000) as i32).u32((at.0 % 1_000_000_000) as u32);
}

fn header(cdr: &mut Cdr, at: Stamp, frame: &str) {
    time(cdr, at);
    cdr.string(frame);
}

/// Position, then the quaternion of a turn about z.
fn pose(cdr: &mut Cdr, Pose2 { x, y, heading }: Pose2) {
    let (sin, cos) = (heading / 2.0).sin_cos();
    cdr.f64s([x, y, 0.0, 0.0, 0.0, sin, cos]);
}

fn twist(cdr: &mut Cdr, Twist2 { linear_mps, angular_radps }: Twist2) {
    cdr.f64s([linear_mps, 0.0, 0.0, 0.0, 0.0, angular_radps]);
}

/// (x, y, heading) among (x, y, z, roll, pitch, yaw).
fn covariance(cdr: &mut Cdr, planar: &[[f64; 3]; 3]) {
    let of = |axis: usize| [0, 1, 5].iter().position(|&known| known == axis);
    cdr.f64s((0..36).map(|i| match (of(i / 6), of(i % 6)) {
        (Some(row), Some(col)) => planar[row][col],
        _ => 0.0,
    }));
}

fn laid_out(write: impl FnOnce(&mut Cdr)) -> Vec<u8> {
    let mut cdr = Cdr::new();
    write(&mut cdr);
    cdr.finish()
}

pub fn pose_stamped(at: Stamp, world_from_robot: Pose2) -> Vec<u8> {
    laid_out(|cdr| {
        header(cdr, at, MAP_FRAME);
        pose(cdr, world_from_robot);
    })
}

pub fn pose_with_covariance(at: Stamp, world_from_robot: Pose2, planar: &[[f64; 3]; 3]) -> Vec<u8> {
    laid_out(|cdr| {
        header(cdr, at, MAP_FRAME);
        pose(cdr, world_from_robot);
        covariance(cdr, planar);
    })
}

pub fn odometry(
    at: Stamp,
    child: &str,
    world_from_robot: Pose2,
    planar: &[[f64; 3]; 3],
    measured: Twist2,
) -> Vec<u8> {
    laid_out(|cdr| {
        header(cdr, at, MAP_FRAME);
        cdr.string(child);
        pose(cdr, world_from_robot);
        covariance(cdr, planar);
        twist(cdr, measured);
        cdr.f64s([0.0; 36]);
    })
}

pub fn twist_stamped(at: Stamp, frame: &str, command: Twist2) -> Vec<u8> {
    laid_out(|cdr| {
        header(cdr, at, frame);
        twist(cdr, command);
    })
}

pub fn path(at: Stamp, points: &[Point2]) -> Vec<u8> {
    laid_out(|cdr| {
        header(cdr, at, MAP_FRAME);
        cdr.length(points.len());
        for (i, point) in points.iter().enumerate() {
            let leg = points
                .get(i + 1)
                .map(|&next| (*point, next))
                .or(i.checked_sub(1).map(|b| (points[b], *point)));
            let heading = leg.map_or(0.0, |(from, to)| (to.y - from.y).atan2(to.x - from.x));
            header(cdr, at, MAP_FRAME);
            pose(cdr, Pose2::new(point.x, point.y, heading));
        }
    })
}

/// (parent frame, child frame, `parent_from_child`) of each transform.
pub fn transforms(at: Stamp, all: &[(&str, &str, Pose2)]) -> Vec<u8> {
    laid_out(|cdr| {
        cdr.length(all.len());
        for &(parent, child, parent_from_child) in all {
            header(cdr, at, parent);
            cdr.string(child);
            pose(cdr, parent_from_child);
        }
    })
}

pub fn range(at: Stamp, frame: &str, sonar: &Sonar, range_m: f64) -> Vec<u8> {
    laid_out(|cdr| {
        header(cdr, at, frame);
        cdr.u8(0).f32(sonar.beam_rad).f32(sonar.min_range_m).f32(sonar.max_range_m);
        cdr.f32(range_m).f32(0.0);
    })
}

pub fn scan(at: Stamp, frame: &str, lidar: &Lidar, ranges_m: &[f64]) -> Vec<u8> {
    laid_out(|cdr| {
        header(cdr, at, frame);
        let last_rad = lidar.first_rad + lidar.step_rad * lidar.beams.saturating_sub(1) as f64;
        cdr.f32(lidar.first_rad).f32(last_rad).f32(lidar.step_rad).f32(0.0).f32(0.0);
        cdr.f32(lidar.min_range_m).f32(lidar.max_range_m).length(ranges_m.len());
        for &range_m in ranges_m {
            cdr.f32(range_m);
        }
        cdr.length(0);
    })
}

pub fn occupancy_grid(at: Stamp, map: &MapSnapshot) -> Vec<u8> {
    let geometry = &map.geometry;
    laid_out(|cdr| {
        header(cdr, at, MAP_FRAME);
        time(cdr, at);
        cdr.f32(geometry.resolution_m).length(geometry.cols).length(geometry.rows);
        pose(cdr, geometry.world_from_grid);
        cdr.bytes(map.cells.iter().map(|cell| match cell {
            Occupancy::Free => 0,
            Occupancy::Occupied => 100,
            Occupancy::Unknown => u8::MAX, // −1
        }));
    })
}

pub fn log(at: Stamp, warns: bool, name: &str, message: &str) -> Vec<u8> {
    laid_out(|cdr| {
        time(cdr, at);
        cdr.u8(if warns { WARN } else { INFO });
        cdr.string(name).string(message).string("").string("").u32(0);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_carries_every_type_it_needs_once() {
        let text = ODOMETRY.full_text();
        for part in ["std_msgs/Header", "geometry_msgs/Quaternion", "builtin_interfaces/Time"] {
            assert_eq!(text.matches(&format!("MSG: {part}\n")).count(), 1, "{part}");
        }
    }

    #[test]
    fn the_planar_covariance_lands_on_x_y_and_yaw() {
        let mut cdr = Cdr::new();
        covariance(&mut cdr, &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]);
        let bytes = cdr.finish();
        let at = |row: usize, col: usize| {
            let from = 4 + 8 * (6 * row + col);
            f64::from_le_bytes(bytes[from..from + 8].try_into().unwrap())
        };
        assert_eq!(
            (at(0, 0), at(0, 5), at(1, 1), at(5, 0), at(5, 5), at(2, 2)),
            (1.0, 3.0, 5.0, 7.0, 9.0, 0.0)
        );
    }

    #[test]
    fn sums_of_ticks_are_stamped_round() {
        let time_s = (0..73).fold(0.0, |sum, _| sum + 0.1);
        assert_eq!(Stamp::from_s(time_s), Stamp(7_300_000_000));
    }
}
