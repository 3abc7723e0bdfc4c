use super::config::{CvmConfig, Shape};
use super::contact::GrownBox;
use super::disc::DiscObstacle;
use super::record::ArcInterval;
use crate::geometry::Point2;

/// Arc lengths at which the growth that covers a piece is raised \[m\].
const MILESTONES_M: [f64; 7] = [0.0, 0.05, 0.15, 0.4, 0.8, 1.4, 2.2];

/// Merged, disjoint intervals of curvature, each with the least free length in it.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeArcs {
    /// From right to left, without gaps.
    pub intervals: Vec<ArcInterval>,
}

impl FreeArcs {
    /// Free lengths of all arcs up to the tightest, cut into pieces of at most the configured step.
    ///
    /// `nearest_first` are obstacles in the robot frame with their distances from its centre \[m\],
    /// sorted, none of them inside `outline`.
    ///
    /// - Round robot: every piece has exactly the least first contact of the arcs in it, and pieces
    ///   end at the exact tangent curvatures where hit and free arcs meet.
    /// - Footprint: every piece has a lower bound of that least first contact: the first contact of
    ///   its middle arc with the outline grown by how far any arc of the piece can lie from it,
    ///   δ·(s²/2 + r·s) at arc length s for half a step δ and outline radius r.
    ///
    /// Both never promise more than there is.
    pub fn new(config: &CvmConfig, outline: &GrownBox, nearest_first: &[(f64, Point2)]) -> Self {
        let half_count = (config.max_curvature_per_m / config.curvature_step_per_m).ceil().max(1.0) as i32;
        let step = config.max_curvature_per_m / f64::from(half_count);
        let pieces = (-half_count..half_count).map(|i| (f64::from(i) * step, f64::from(i + 1) * step));
        let intervals = match config.shape {
            Shape::Footprint => pieces
                .map(|(lo, hi)| ArcInterval {
                    curvature_lo: lo,
                    curvature_hi: hi,
                    distance_m: Piece::new(lo, hi, outline, config.horizon_m).free_length_m(nearest_first),
                })
                .collect(),
            Shape::Disc => disc_intervals(config.horizon_m, pieces.collect(), outline, nearest_first),
        };
        Self { intervals: merged(intervals) }
    }
}

/// Neighbours of the same free length become one.
fn merged(pieces: Vec<ArcInterval>) -> Vec<ArcInterval> {
    let mut intervals: Vec<ArcInterval> = Vec::with_capacity(pieces.len());
    for piece in pieces {
        match intervals.last_mut() {
            Some(last) if last.distance_m == piece.distance_m => last.curvature_hi = piece.curvature_hi,
            _ => intervals.push(piece),
        }
    }
    intervals
}

/// A narrow fan of arcs and the outline that covers it.
struct Piece {
    curvature: f64,
    /// (arc length from, to, outline grown to cover the fan up to there, robot's turn at `from`).
    legs: Vec<Leg>,
    radius_m: f64,
    limit_m: f64,
}

struct Leg {
    from_m: f64,
    to_m: f64,
    outline: GrownBox,
    sin: f64,
    cos: f64,
    /// Where the robot's centre is at `from_m`.
    origin: Point2,
    /// Squared least and greatest distance of the outline from the centre of turning.
    ring: (f64, f64),
    /// Where the robot's centre is half-way, and the square of how far from there a point can be met.
    middle: Point2,
    reach_squared: f64,
}

impl Piece {
    fn new(lo: f64, hi: f64, outline: &GrownBox, limit_m: f64) -> Self {
        let curvature = (lo + hi) / 2.0;
        let half = (hi - lo) / 2.0;
        let body = outline.radius_m() - outline.growth_m;
        let mut ends: Vec<f64> = MILESTONES_M.iter().copied().filter(|&s| s < limit_m).collect();
        ends.push(limit_m);
        let center = Point2::new(0.0, 1.0 / curvature);
        let legs = ends
            .windows(2)
            .map(|ends| {
                let (from_m, to_m) = (ends[0], ends[1]);
                let outline = outline.grown(half * (to_m * to_m / 2.0 + body * to_m));
                let pose = crate::geometry::Twist2::new(1.0, curvature).displacement(from_m);
                let (sin, cos) = pose.heading.sin_cos();
                let near = (outline.distance(center) - outline.growth_m).max(0.0);
                let far =
                    outline.half_length_m.hypot(outline.half_width_m + center.y.abs()) + outline.growth_m;
                let ring = if center.y.is_finite() { (near * near, far * far) } else { (0.0, f64::INFINITY) };
                let middle = crate::geometry::Twist2::new(1.0, curvature).displacement((from_m + to_m) / 2.0);
                let reach_m = (to_m - from_m) / 2.0 + outline.radius_m();
                Leg {
                    from_m,
                    to_m,
                    outline,
                    sin,
                    cos,
                    origin: pose.position(),
                    ring,
                    middle: middle.position(),
                    reach_squared: reach_m * reach_m,
                }
            })
            .collect();
        Self { curvature, legs, radius_m: outline.radius_m(), limit_m }
    }

    fn free_length_m(&self, nearest_first: &[(f64, Point2)]) -> f64 {
        let mut free_m = self.limit_m;
        let center_y = 1.0 / self.curvature;
        let widest = self.legs.last().map_or((0.0, 0.0), |leg| leg.ring);
        let reach_m = self.legs.last().map_or(0.0, |leg| leg.outline.radius_m());
        for &(distance_m, point) in nearest_first {
            if distance_m - reach_m >= free_m {
                break;
            }
            let squared = point.x * point.x + (point.y - center_y) * (point.y - center_y);
            if squared < widest.0 || squared > widest.1 {
                continue;
            }
            free_m = self.contact_m(point, squared, free_m).min(free_m);
        }
        free_m
    }

    /// Lower bound of the first contact of any arc of the fan, as far as it is below `below_m`.
    ///
    /// `squared` is the point's squared distance from the centre of turning.
    fn contact_m(&self, point: Point2, squared: f64, below_m: f64) -> f64 {
        for leg in &self.legs {
            if leg.from_m >= below_m {
                break;
            }
            // The centre is nowhere farther from half-way than half the leg is long.
            let from_middle = point - leg.middle;
            if from_middle.dot(from_middle) > leg.reach_squared
                || squared < leg.ring.0
                || squared > leg.ring.1
            {
                continue;
            }
            let offset = point - leg.origin;
            let seen = Point2::new(
                leg.cos * offset.x + leg.sin * offset.y,
                -leg.sin * offset.x + leg.cos * offset.y,
            );
            let contact_m = leg.from_m + leg.outline.first_contact_m(seen, self.curvature);
            if contact_m <= leg.to_m {
                return contact_m;
            }
        }
        debug_assert!(self.radius_m > 0.0);
        f64::INFINITY
    }
}

/// The round robot: pieces cut where its exact tangents say hit and free arcs meet.
fn disc_intervals(
    limit_m: f64,
    pieces: Vec<(f64, f64)>,
    outline: &GrownBox,
    nearest_first: &[(f64, Point2)],
) -> Vec<ArcInterval> {
    struct Hit {
        lo: f64,
        hi: f64,
        least_m: f64,
    }
    let mut hits: Vec<Option<Hit>> = pieces.iter().map(|_| None).collect();
    let first = pieces.first().map_or(0.0, |p| p.0);
    let step = pieces.first().map_or(1.0, |p| p.1 - p.0);
    let index = |c: f64| (((c - first) / step).floor().max(0.0) as usize).min(pieces.len() - 1);
    for &(distance_m, center) in nearest_first {
        if distance_m - outline.growth_m >= limit_m {
            break;
        }
        let Some(disc) = DiscObstacle::new(center, outline.growth_m) else { continue };
        if disc.curvature_lo > pieces[pieces.len() - 1].1 || disc.curvature_hi < first {
            continue;
        }
        let (from, to) = (index(disc.curvature_lo), index(disc.curvature_hi));
        let nearest_possible_m = distance_m - outline.growth_m;
        for (i, hit) in hits.iter_mut().enumerate().take(to + 1).skip(from) {
            let (lo, hi) = (pieces[i].0.max(disc.curvature_lo), pieces[i].1.min(disc.curvature_hi));
            let hidden =
                hit.as_ref().is_some_and(|h| h.least_m <= nearest_possible_m && h.lo <= lo && h.hi >= hi);
            if lo > hi || hidden {
                continue;
            }
            let least_m = disc.least_contact_m(lo, hi);
            if least_m >= limit_m {
                continue;
            }
            *hit = Some(match hit.take() {
                None => Hit { lo, hi, least_m },
                Some(h) => Hit { lo: h.lo.min(lo), hi: h.hi.max(hi), least_m: h.least_m.min(least_m) },
            });
        }
    }
    let mut intervals = Vec::with_capacity(pieces.len());
    let mut push = |curvature_lo: f64, curvature_hi: f64, distance_m: f64| {
        if curvature_hi > curvature_lo {
            intervals.push(ArcInterval { curvature_lo, curvature_hi, distance_m });
        }
    };
    for (&(lo, hi), hit) in pieces.iter().zip(&hits) {
        match hit {
            None => push(lo, hi, limit_m),
            Some(h) => {
                push(lo, h.lo, limit_m);
                push(h.lo, h.hi, h.least_m);
                push(h.hi, hi, limit_m);
            }
        }
    }
    intervals
}
