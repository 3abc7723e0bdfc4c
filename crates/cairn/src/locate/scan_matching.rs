//! A lidar scan laid on the points seen before: point to line, a few Gauss-Newton steps `[Censi08]`.

use serde::{Deserialize, Serialize};

use crate::geometry::{Point2, Pose2, wrap_angle};
use crate::robot::Bound;
use crate::world::LocalMap;

/// How far a scan may correct the pose that wheels and gyroscope predict.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ScanMatchConfig {
    /// Returns used at most; they are taken evenly.
    pub returns: usize,
    /// Gauss-Newton steps at most.
    pub steps: u32,
    /// A residual of this size counts half \[m\].
    pub robust_m: f64,
    /// How well one return is believed \[m\].
    pub sigma_m: f64,
    /// How well the prediction is believed: a constant part \[m\] ...
    pub prior_m: f64,
    /// ... and a share of the way driven.
    pub prior_per_m: f64,
    /// The same for the heading \[rad\] ...
    pub prior_rad: f64,
    /// ... and a share of the turn.
    pub prior_per_rad: f64,
    /// Fewer matched returns than this correct nothing.
    pub least_returns: usize,
}

impl Default for ScanMatchConfig {
    fn default() -> Self {
        Self {
            returns: 240,
            steps: 6,
            robust_m: 0.03,
            sigma_m: 0.02,
            prior_m: 0.003,
            prior_per_m: 0.1,
            prior_rad: 0.003,
            prior_per_rad: 0.25,
            least_returns: 12,
        }
    }
}

impl ScanMatchConfig {
    /// Every setting with its least and greatest usable value.
    pub(crate) fn bounds(&self) -> [Bound; 9] {
        [
            ("returns", self.returns as f64, 1.0, 1e6),
            ("steps", f64::from(self.steps), 1.0, 1e3),
            ("robust_m", self.robust_m, 1e-6, 10.0),
            ("sigma_m", self.sigma_m, 1e-6, 10.0),
            ("prior_m", self.prior_m, 1e-6, 10.0),
            ("prior_per_m", self.prior_per_m, 0.0, 100.0),
            ("prior_rad", self.prior_rad, 1e-6, 10.0),
            ("prior_per_rad", self.prior_per_rad, 0.0, 100.0),
            ("least_returns", self.least_returns as f64, 1.0, 1e6),
        ]
    }
}

/// What laying one scan on the map did to the pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ScanMatch {
    /// Returns that found a point.
    pub matched: usize,
    /// Mean absolute distance of those to their points' lines, after the correction \[m\].
    pub residual_m: f64,
    /// Moved by, in the frame of the odometry \[m\].
    pub moved_x_m: f64,
    /// The same, y \[m\].
    pub moved_y_m: f64,
    /// Turned by \[rad\].
    pub turned_rad: f64,
}

/// A return with the direction across the surface it came from, robot frame.
struct Return {
    point: Point2,
    normal: Point2,
}

/// Farther apart than this two neighbouring returns are not of one surface \[m\].
const GAP_M: f64 = 0.15;

/// The pose near `predicted` at which the returns of one scan lie on `map`; `driven_m` and
/// `turned_rad` are what the robot moved since the last scan.
///
/// `ends` are the returns by beam, robot frame \[m\]. In directions that the scan says nothing of (along a
/// corridor) the prediction stays.
pub fn match_scan(
    config: &ScanMatchConfig,
    map: &LocalMap,
    predicted: Pose2,
    ends: &[Option<Point2>],
    driven_m: f64,
    turned_rad: f64,
) -> (Pose2, ScanMatch) {
    let returns = chosen(config, ends, map.config().reach_m);
    let sigma_m = config.prior_m + config.prior_per_m * driven_m.abs();
    let sigma_rad = config.prior_rad + config.prior_per_rad * turned_rad.abs();
    let prior = [sigma_m.powi(-2), sigma_m.powi(-2), sigma_rad.powi(-2)];
    let belief = config.sigma_m.powi(-2);
    let mut pose = predicted;
    let mut report = ScanMatch::default();
    for _ in 0..config.steps {
        let off = [pose.x - predicted.x, pose.y - predicted.y, wrap_angle(pose.heading - predicted.heading)];
        let mut normal = [[prior[0], 0.0, 0.0], [0.0, prior[1], 0.0], [0.0, 0.0, prior[2]]];
        let mut right = [-prior[0] * off[0], -prior[1] * off[1], -prior[2] * off[2]];
        let (sin, cos) = pose.heading.sin_cos();
        let (mut matched, mut sum_m) = (0usize, 0.0);
        for seen in &returns {
            let arm =
                Point2::new(cos * seen.point.x - sin * seen.point.y, sin * seen.point.x + cos * seen.point.y);
            let at = Point2::new(pose.x + arm.x, pose.y + arm.y);
            let Some(held) = map.nearest(at) else { continue };
            let across = Point2::new(
                cos * seen.normal.x - sin * seen.normal.y,
                sin * seen.normal.x + cos * seen.normal.y,
            );
            let residual = across.dot(at - held);
            let share = residual / config.robust_m;
            let weight = belief / (1.0 + share * share);
            let jacobian = [across.x, across.y, across.y * arm.x - across.x * arm.y];
            for i in 0..3 {
                for j in 0..3 {
                    normal[i][j] += weight * jacobian[i] * jacobian[j];
                }
                right[i] -= weight * jacobian[i] * residual;
            }
            matched += 1;
            sum_m += residual.abs();
        }
        report.matched = matched;
        report.residual_m = if matched > 0 { sum_m / matched as f64 } else { 0.0 };
        if matched < config.least_returns {
            pose = predicted;
            break;
        }
        let Some(step) = solved(normal, right) else { break };
        pose = Pose2::new(pose.x + step[0], pose.y + step[1], wrap_angle(pose.heading + step[2]));
        if step[0].abs() + step[1].abs() < 1e-5 && step[2].abs() < 1e-5 {
            break;
        }
    }
    report.moved_x_m = pose.x - predicted.x;
    report.moved_y_m = pose.y - predicted.y;
    report.turned_rad = wrap_angle(pose.heading - predicted.heading);
    (pose, report)
}

/// Evenly chosen returns whose neighbours tell how their surface lies.
fn chosen(config: &ScanMatchConfig, ends: &[Option<Point2>], reach_m: f64) -> Vec<Return> {
    let stride = ends.len().div_ceil(config.returns.max(1)).max(1);
    let mut returns = Vec::with_capacity(ends.len() / stride + 1);
    for beam in (1..ends.len().saturating_sub(1)).step_by(stride) {
        let (Some(before), Some(point), Some(after)) = (ends[beam - 1], ends[beam], ends[beam + 1]) else {
            continue;
        };
        let gap = GAP_M * GAP_M;
        let (back, on) = (point - before, after - point);
        if back.dot(back) > gap || on.dot(on) > gap || point.dot(point) > reach_m * reach_m {
            continue;
        }
        let along = after - before;
        let length = along.norm();
        if length > 1e-6 {
            returns.push(Return { point, normal: Point2::new(-along.y / length, along.x / length) });
        }
    }
    returns
}

/// Solves a symmetric positive definite system of three equations.
fn solved(m: [[f64; 3]; 3], r: [f64; 3]) -> Option<[f64; 3]> {
    let minor = |a: usize, b: usize, c: usize, d: usize| m[a][b] * m[c][d] - m[a][d] * m[c][b];
    let cofactors = [minor(1, 1, 2, 2), minor(1, 2, 2, 0), minor(1, 0, 2, 1)];
    let determinant = m[0][0] * cofactors[0] + m[0][1] * cofactors[1] + m[0][2] * cofactors[2];
    if !(determinant.is_finite() && determinant > 0.0) {
        return None;
    }
    let replaced = |column: usize| {
        let mut n = m;
        for row in 0..3 {
            n[row][column] = r[row];
        }
        n[0][0] * (n[1][1] * n[2][2] - n[1][2] * n[2][1]) - n[0][1] * (n[1][0] * n[2][2] - n[1][2] * n[2][0])
            + n[0][2] * (n[1][0] * n[2][1] - n[1][1] * n[2][0])
    };
    let solution = [0, 1, 2].map(|column| replaced(column) / determinant);
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}
