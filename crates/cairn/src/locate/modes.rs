//! Where the weight of a set of poses is.

use super::beams::Poses;
use crate::geometry::{Pose2, wrap_angle};

/// Bins of position \[m\] and of heading.
const BIN_M: f32 = 0.5;
const BIN_HEADINGS: f32 = 16.0;
/// A mode reaches this far about its middle.
const MODE_M: f64 = 0.6;
const MODE_RAD: f64 = 0.45;
/// Lighter bins are not begun from.
const STARTS: usize = 8;

/// Poses around one place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mode {
    /// Mean, in the frame of the poses.
    pub pose: Pose2,
    pub covariance: [[f64; 3]; 3],
    /// Share of all weight.
    pub share: f64,
}

/// Weight by bin.
pub(super) struct Bins {
    /// (key, weight, one of its poses), by key.
    bins: Vec<(u64, f64, u32)>,
}

impl Bins {
    pub(super) fn new(poses: &Poses, weights: &[f64]) -> Self {
        let n = poses.len();
        let mut keys: Vec<(u64, u32)> = (0..n)
            .map(|i| {
                // Offset so that all of it is positive; far outside of any map is one bin.
                let part = |v: f32| ((v / BIN_M).floor() as i64 + (1 << 20)).clamp(0, (1 << 21) - 1) as u64;
                let turn = poses.heading[i] / std::f32::consts::TAU;
                let heading = ((turn - turn.floor()) * BIN_HEADINGS) as u64;
                (part(poses.x[i]) << 32 | part(poses.y[i]) << 8 | heading, i as u32)
            })
            .collect();
        keys.sort_unstable();
        let mut bins: Vec<(u64, f64, u32)> = Vec::new();
        for (key, i) in keys {
            let weight = weights[i as usize];
            match bins.last_mut() {
                Some(last) if last.0 == key => last.1 += weight,
                _ => bins.push((key, weight, i)),
            }
        }
        Self { bins }
    }

    /// How many bins carry weight that counts.
    pub(super) fn count(&self) -> usize {
        let least = 1e-3 / self.bins.len().max(1) as f64;
        self.bins.iter().filter(|(_, weight, _)| *weight > least).count()
    }
}

/// The heaviest mode, and the heaviest of the others.
pub(super) fn best_modes(poses: &Poses, weights: &[f64]) -> [Option<Mode>; 2] {
    let mut bins = Bins::new(poses, weights).bins;
    bins.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut modes: Vec<Mode> = Vec::new();
    for &(_, _, i) in bins.iter().take(STARTS) {
        let i = i as usize;
        let start = Pose2::new(f64::from(poses.x[i]), f64::from(poses.y[i]), f64::from(poses.heading[i]));
        let known = modes.iter().any(|mode| is_near(mode.pose, start));
        if known {
            continue;
        }
        let mut mode = around(poses, weights, start);
        if let Some(found) = mode {
            mode = around(poses, weights, found.pose).or(mode);
        }
        if let Some(mode) = mode.filter(|mode| !modes.iter().any(|other| is_near(other.pose, mode.pose))) {
            modes.push(mode);
        }
        if modes.len() == 3 {
            break;
        }
    }
    modes.sort_by(|a, b| b.share.total_cmp(&a.share));
    let mut modes = modes.into_iter();
    [modes.next(), modes.next()]
}

fn is_near(a: Pose2, b: Pose2) -> bool {
    a.position().distance(b.position()) < 1.5 * MODE_M
        && wrap_angle(a.heading - b.heading).abs() < 1.5 * MODE_RAD
}

/// Mean, covariance and share of the poses near `about`. None when there are none.
fn around(poses: &Poses, weights: &[f64], about: Pose2) -> Option<Mode> {
    let (mut sum, mut mean, mut square) = (0.0, [0.0; 3], [[0.0; 3]; 3]);
    for (i, &weight) in weights.iter().enumerate() {
        let (dx, dy) = (f64::from(poses.x[i]) - about.x, f64::from(poses.y[i]) - about.y);
        if dx * dx + dy * dy > MODE_M * MODE_M {
            continue;
        }
        let turn = wrap_angle(f64::from(poses.heading[i]) - about.heading);
        if turn.abs() > MODE_RAD {
            continue;
        }
        let off = [dx, dy, turn];
        sum += weight;
        for a in 0..3 {
            mean[a] += weight * off[a];
            for b in 0..3 {
                square[a][b] += weight * off[a] * off[b];
            }
        }
    }
    if sum <= 0.0 {
        return None;
    }
    let mean = mean.map(|m| m / sum);
    Some(Mode {
        pose: Pose2::new(about.x + mean[0], about.y + mean[1], about.heading + mean[2]),
        covariance: std::array::from_fn(|a| std::array::from_fn(|b| square[a][b] / sum - mean[a] * mean[b])),
        share: sum,
    })
}
