//! One array of ranges as points around the robot that surfaces of the map should be near to.

use std::ops::Range;

use super::field::{STEP_M, SurfaceField};
use super::monte_carlo::MonteCarloConfig;
use crate::robot::RobotProfile;

/// Points at most this far apart stand for the arc of a cone \[m\].
const ARC_M: f64 = 0.3;
const MOST_ARC_POINTS: usize = 5;
/// A beam is free up to this near its end, with its share of the range \[m\].
const END_M: f32 = 0.15;
const END_PER_RANGE: f32 = 0.05;
/// Spheres a beam is followed with.
const SPHERES: usize = 6;
/// Particles weighed at a time: what is looked up of them stays in the nearest cache.
const BLOCK: usize = 64;

#[derive(Clone, Debug)]
struct Beam {
    origin: (f32, f32),
    axis: (f32, f32),
    free_m: f32,
    /// Where it ended: points of [`Scan::ends`].
    ends: Range<usize>,
    /// Row of [`Tables`].
    table: usize,
}

/// What one array of ranges says, in the robot's frame.
#[derive(Clone, Debug)]
pub(super) struct Scan {
    beams: Vec<Beam>,
    ends: Vec<(f32, f32)>,
}

impl Scan {
    /// The readings of `ranges_m` that can be used: sonars, then lidar beams.
    pub(super) fn new(hearing: &MonteCarloConfig, profile: &RobotProfile, ranges_m: &[f64]) -> Self {
        let mut scan = Self { beams: Vec::new(), ends: Vec::new() };
        for (sonar, &range_m) in profile.sonars.iter().zip(ranges_m) {
            if range_m > sonar.min_range_m && range_m < sonar.max_range_m.min(hearing.sonar_range_m) {
                let origin = (sonar.pose.x, sonar.pose.y);
                let table = Tables::of_sonar(range_m);
                scan.add(origin, sonar.pose.heading, sonar.beam_rad, range_m, table);
            }
        }
        let Some(lidar) = &profile.lidar else { return scan };
        let given = ranges_m.get(profile.sonars.len()..).unwrap_or(&[]);
        let used = hearing.lidar_beams.clamp(1, given.len().max(1));
        for k in 0..used {
            let beam = k * given.len() / used;
            let range_m = given.get(beam).copied().unwrap_or(f64::NAN);
            if range_m > lidar.min_range_m && range_m < lidar.max_range_m {
                let heading = lidar.pose.heading + lidar.first_rad + beam as f64 * lidar.step_rad;
                scan.add((lidar.pose.x, lidar.pose.y), heading, 0.0, range_m, Tables::LIDAR);
            }
        }
        scan
    }

    fn add(&mut self, origin: (f64, f64), heading: f64, beam_rad: f64, range_m: f64, table: usize) {
        // The edges of a cone answer weakly: its inner nine tenths.
        let arc_rad = 0.9 * beam_rad;
        let points = ((arc_rad * range_m / ARC_M).ceil() as usize + 1).clamp(1, MOST_ARC_POINTS);
        let points = if beam_rad > 0.0 { points.max(3) } else { 1 };
        let from = self.ends.len();
        for k in 0..points {
            let part = if points == 1 { 0.0 } else { k as f64 / (points - 1) as f64 - 0.5 };
            let (sin, cos) = (heading + part * arc_rad).sin_cos();
            self.ends.push(((origin.0 + range_m * cos) as f32, (origin.1 + range_m * sin) as f32));
        }
        let (sin, cos) = heading.sin_cos();
        self.beams.push(Beam {
            origin: (origin.0 as f32, origin.1 as f32),
            axis: (cos as f32, sin as f32),
            free_m: range_m as f32 * (1.0 - END_PER_RANGE) - END_M,
            ends: from..self.ends.len(),
            table,
        });
    }

    /// How many readings can be used.
    pub(super) fn len(&self) -> usize {
        self.beams.len()
    }
}

/// Logarithms of likelihoods by rounded distance, one row for sonar echoes of each half metre and one
/// for lidar beams.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    rows: Vec<[f32; 256]>,
    /// Of a reading that the map does not explain.
    stray: f32,
}

impl Tables {
    const LIDAR: usize = 0;
    const SONARS: usize = 16;

    /// Logarithm of the likelihood of a reading that the map does not explain.
    pub(super) fn stray(&self) -> f32 {
        self.stray
    }

    fn of_sonar(range_m: f64) -> usize {
        1 + ((range_m / 0.5) as usize).min(Self::SONARS - 1)
    }

    /// Tables that forgive errors of `slack_m` and `slack_rad` of the pose itself.
    pub(super) fn new(hearing: &MonteCarloConfig, slack_m: f64, slack_rad: f64) -> Self {
        let row = |sigma_m: f64, range_m: f64| {
            let sigma_m = sigma_m.hypot(slack_m).hypot(slack_rad * range_m);
            std::array::from_fn(|step| {
                // The middle of what rounds to this step.
                let away = (step as f64 + 0.5) * f64::from(STEP_M) / sigma_m;
                let hit = (1.0 - hearing.stray) * (-0.5 * away * away).exp() + hearing.stray;
                (hearing.independence * hit.ln()) as f32
            })
        };
        let sonars = (0..Self::SONARS).map(|k| {
            let range_m = 0.5 * (k as f64 + 0.5);
            row(hearing.sonar_m + hearing.sonar_m_per_m * range_m, range_m)
        });
        Self {
            rows: std::iter::once(row(hearing.lidar_m, 2.0)).chain(sonars).collect(),
            stray: (hearing.independence * hearing.stray.ln()) as f32,
        }
    }
}

/// Poses in the map's frame, each coordinate in an array of its own.
#[derive(Clone, Debug, Default)]
pub(super) struct Poses {
    pub x: Vec<f32>,
    pub y: Vec<f32>,
    pub heading: Vec<f32>,
}

impl Poses {
    pub(super) fn len(&self) -> usize {
        self.x.len()
    }

    /// Some of them.
    pub(super) fn part(&self, range: Range<usize>) -> Self {
        Self {
            x: self.x[range.clone()].to_vec(),
            y: self.y[range.clone()].to_vec(),
            heading: self.heading[range].to_vec(),
        }
    }

    pub(super) fn push(&mut self, x: f32, y: f32, heading: f32) {
        self.x.push(x);
        self.y.push(y);
        self.heading.push(heading);
    }
}

/// Logarithm of the likelihood of `scan` at each of `poses`, up to a constant, into `out`.
///
/// A reading is as likely as the nearest surface is near to where it ended; when its axis meets a
/// surface well before, it is only as likely as a stray one. Poses where something stands within
/// `radius_m` are ruled out: minus infinity.
pub(super) fn weigh(
    field: &SurfaceField,
    tables: &Tables,
    scan: &Scan,
    radius_m: f32,
    poses: &Poses,
    out: &mut Vec<f32>,
) {
    out.clear();
    out.resize(poses.len(), 0.0);
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has what the function was compiled for.
        #[allow(unsafe_code)]
        unsafe {
            weigh_avx2(field, tables, scan, radius_m, poses, out);
        }
        return;
    }
    weigh_blocks::<OneByOne>(field, tables, scan, radius_m, poses, out);
}

/// The same operations in the same order, eight at a time: the same bits.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn weigh_avx2(
    field: &SurfaceField,
    tables: &Tables,
    scan: &Scan,
    radius_m: f32,
    poses: &Poses,
    out: &mut [f32],
) {
    weigh_blocks::<Gathered>(field, tables, scan, radius_m, poses, out);
}

/// How [`SurfaceField::near`] is read at many places.
trait Look {
    fn near(field: &SurfaceField, index: &[i32; BLOCK], near: &mut [i32; BLOCK]);
}

struct OneByOne;

impl Look for OneByOne {
    #[inline(always)]
    fn near(field: &SurfaceField, index: &[i32; BLOCK], near: &mut [i32; BLOCK]) {
        for (near, &index) in near.iter_mut().zip(index) {
            *near = i32::from(field.near_at(index));
        }
    }
}

#[cfg(target_arch = "x86_64")]
struct Gathered;

#[cfg(target_arch = "x86_64")]
impl Look for Gathered {
    #[inline(always)]
    #[allow(unsafe_code)]
    fn near(field: &SurfaceField, index: &[i32; BLOCK], near: &mut [i32; BLOCK]) {
        use std::arch::x86_64::{
            __m256i, _mm256_and_si256, _mm256_i32gather_epi32, _mm256_loadu_si256, _mm256_set1_epi32,
            _mm256_storeu_si256,
        };
        let cells = field.near_cells();
        for (near, index) in near.chunks_exact_mut(8).zip(index.chunks_exact(8)) {
            // SAFETY: only `weigh_avx2` looks this way. Indices come from `SurfaceField::index`, so
            // they are cells, and behind the last cell there are three bytes more.
            unsafe {
                let at = _mm256_loadu_si256(index.as_ptr().cast::<__m256i>());
                let four = _mm256_i32gather_epi32::<1>(cells.as_ptr().cast::<i32>(), at);
                let one = _mm256_and_si256(four, _mm256_set1_epi32(0xff));
                _mm256_storeu_si256(near.as_mut_ptr().cast::<__m256i>(), one);
            }
        }
    }
}

/// What is looked up of some particles.
struct Block {
    cos: [f32; BLOCK],
    sin: [f32; BLOCK],
    x: [f32; BLOCK],
    y: [f32; BLOCK],
    log: [f32; BLOCK],
    index: [i32; BLOCK],
    nearest: [i32; BLOCK],
    near: [i32; BLOCK],
    gone: [f32; BLOCK],
    hit: [f32; BLOCK],
}

#[inline(always)]
fn weigh_blocks<L: Look>(
    field: &SurfaceField,
    tables: &Tables,
    scan: &Scan,
    radius_m: f32,
    poses: &Poses,
    out: &mut [f32],
) {
    let room = (radius_m / STEP_M) as u8;
    let mut block = Block {
        cos: [0.0; BLOCK],
        sin: [0.0; BLOCK],
        x: [0.0; BLOCK],
        y: [0.0; BLOCK],
        log: [0.0; BLOCK],
        index: [0; BLOCK],
        nearest: [0; BLOCK],
        near: [0; BLOCK],
        gone: [0.0; BLOCK],
        hit: [0.0; BLOCK],
    };
    for start in (0..poses.len()).step_by(BLOCK) {
        let n = BLOCK.min(poses.len() - start);
        // Blocks are always full: what is left over of the one before is weighed again for nothing.
        block.x[..n].copy_from_slice(&poses.x[start..start + n]);
        block.y[..n].copy_from_slice(&poses.y[start..start + n]);
        for i in 0..n {
            (block.sin[i], block.cos[i]) = poses.heading[start + i].sin_cos();
            let at = field.index(block.x[i], block.y[i]);
            let stands = field.is_open(at) && field.near_at(at) >= room;
            block.log[i] = if stands { 0.0 } else { f32::NEG_INFINITY };
        }
        for beam in &scan.beams {
            block.nearest_to_ends::<L>(field, &scan.ends[beam.ends.clone()]);
            block.follow::<L>(field, beam);
            let table = &tables.rows[beam.table];
            let met = i32::from(field.met());
            for i in 0..BLOCK {
                block.hit[i] = table[(block.nearest[i] & 0xff) as usize];
            }
            for i in 0..BLOCK {
                let blocked = (block.gone[i] < beam.free_m) & (block.near[i] <= met);
                block.log[i] += if blocked { tables.stray } else { block.hit[i] };
            }
        }
        out[start..start + n].copy_from_slice(&block.log[..n]);
    }
}

impl Block {
    /// How near the nearest surface is to the nearest of `ends`.
    #[inline(always)]
    fn nearest_to_ends<L: Look>(&mut self, field: &SurfaceField, ends: &[(f32, f32)]) {
        self.nearest = [i32::from(u8::MAX); BLOCK];
        for &(ex, ey) in ends {
            for i in 0..BLOCK {
                self.index[i] = field.index(
                    self.x[i] + self.cos[i] * ex - self.sin[i] * ey,
                    self.y[i] + self.sin[i] * ex + self.cos[i] * ey,
                );
            }
            L::near(field, &self.index, &mut self.near);
            for i in 0..BLOCK {
                self.nearest[i] = self.nearest[i].min(self.near[i]);
            }
        }
    }

    /// Follows the axis of a beam from sphere to sphere of free space until it meets a surface.
    #[inline(always)]
    fn follow<L: Look>(&mut self, field: &SurfaceField, beam: &Beam) {
        let ((ox, oy), (ux, uy)) = (beam.origin, beam.axis);
        let met = i32::from(field.met());
        self.gone = [0.0; BLOCK];
        for _ in 0..SPHERES {
            for i in 0..BLOCK {
                let (fx, fy) = (ox + self.gone[i] * ux, oy + self.gone[i] * uy);
                self.index[i] = field.index(
                    self.x[i] + self.cos[i] * fx - self.sin[i] * fy,
                    self.y[i] + self.sin[i] * fx + self.cos[i] * fy,
                );
            }
            L::near(field, &self.index, &mut self.near);
            let mut under_way = false;
            for i in 0..BLOCK {
                // What has met a surface stays there.
                let step = if self.near[i] <= met { 0.0 } else { self.near[i] as f32 * STEP_M };
                self.gone[i] += step;
                under_way |= (step > 0.0) & (self.gone[i] < beam.free_m);
            }
            if !under_way {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;
    use crate::world::{Grid, GridGeometry, Occupancy, SplitMix};

    /// A hall of 6 × 5 m with a post.
    fn hall() -> SurfaceField {
        let geometry =
            GridGeometry { rows: 100, cols: 120, resolution_m: 0.05, world_from_grid: Pose2::IDENTITY };
        let stands = |i: usize| {
            let (row, col) = (i / 120, i % 120);
            !(2..98).contains(&row)
                || !(2..118).contains(&col)
                || (30..36).contains(&row) && (50..54).contains(&col)
        };
        let cells =
            (0..geometry.len()).map(|i| if stands(i) { Occupancy::Occupied } else { Occupancy::Free });
        SurfaceField::new(&Grid::new(geometry, cells.collect()))
    }

    fn poses(n: usize, seed: u64) -> Poses {
        let mut random = SplitMix::new(seed);
        let mut poses = Poses::default();
        for _ in 0..n {
            let [x, y, turn] = [0; 3].map(|_| random.unit() as f32);
            poses.push(8.0 * x - 1.0, 7.0 * y - 1.0, std::f32::consts::TAU * turn - std::f32::consts::PI);
        }
        poses
    }

    fn scan(range_m: f64) -> Scan {
        let mut scan = Scan { beams: Vec::new(), ends: Vec::new() };
        for k in 0..16 {
            let heading = f64::from(k) * 0.39;
            let range_m = range_m + 0.1 * f64::from(k % 5);
            scan.add(
                (0.2, 0.1),
                heading,
                if k % 2 == 0 { 0.52 } else { 0.0 },
                range_m,
                Tables::of_sonar(range_m),
            );
        }
        scan
    }

    #[test]
    fn eight_at_a_time_and_one_by_one_give_the_same_bits() {
        let (field, tables) = (hall(), Tables::new(&MonteCarloConfig::default(), 0.0, 0.0));
        for n in [1, 63, 64, 65, 1000] {
            let (poses, scan) = (poses(n, 7), scan(1.3));
            let mut any = Vec::new();
            weigh(&field, &tables, &scan, 0.1, &poses, &mut any);
            let mut plain = vec![0.0; n];
            weigh_blocks::<OneByOne>(&field, &tables, &scan, 0.1, &poses, &mut plain);
            let bits = |logs: &[f32]| logs.iter().map(|log| log.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&any), bits(&plain), "{n}");
        }
    }

    #[test]
    fn a_pose_in_a_wall_or_off_the_map_is_impossible_and_no_other_is_less_likely_than_strays() {
        let (field, tables, scan) = (hall(), Tables::new(&MonteCarloConfig::default(), 0.0, 0.0), scan(2.0));
        let poses = poses(2000, 3);
        let mut logs = Vec::new();
        weigh(&field, &tables, &scan, 0.0, &poses, &mut logs);
        let least = scan.len() as f32 * tables.stray() - 1e-3;
        for (i, &log) in logs.iter().enumerate() {
            let stands = field.is_open(field.index(poses.x[i], poses.y[i]));
            assert_eq!(log == f32::NEG_INFINITY, !stands);
            assert!(!stands || (least..=1e-3).contains(&log), "{log}");
        }
    }
}
