use std::f64::consts::TAU;

use super::config::{CvmConfig, Shape};
use super::contact::{GrownBox, turn_order};
use super::disc::{DiscObstacle, tangent_curvatures};
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
        Fan::new(config, outline).free_arcs(nearest_first)
    }
}

/// All arcs in pieces, and what covers each piece: made once for a robot, asked every tick.
#[derive(Clone, Debug)]
pub(super) struct Fan {
    outline: GrownBox,
    limit_m: f64,
    ends: Vec<(f64, f64)>,
    /// Empty for the round robot, whose contacts are exact.
    pieces: Vec<Piece>,
    /// The widest outline of any piece is inside this radius \[m\].
    reach_m: f64,
}

impl Fan {
    pub fn new(config: &CvmConfig, outline: &GrownBox) -> Self {
        let half_count = (config.max_curvature_per_m / config.curvature_step_per_m).ceil().max(1.0) as i32;
        let step = config.max_curvature_per_m / f64::from(half_count);
        let ends: Vec<(f64, f64)> =
            (-half_count..half_count).map(|i| (f64::from(i) * step, f64::from(i + 1) * step)).collect();
        let pieces: Vec<Piece> = match config.shape {
            Shape::Disc => Vec::new(),
            Shape::Footprint => {
                ends.iter().map(|&(lo, hi)| Piece::new(lo, hi, outline, config.horizon_m)).collect()
            }
        };
        let reach_m = pieces.iter().map(|piece| piece.reach_m).fold(0.0, f64::max);
        Self { outline: *outline, limit_m: config.horizon_m, ends, pieces, reach_m }
    }

    /// Free lengths among `nearest_first`, as [`FreeArcs::new`] tells them.
    pub fn free_arcs(&self, nearest_first: &[(f64, Point2)]) -> FreeArcs {
        let intervals = if self.pieces.is_empty() {
            disc_intervals(self.limit_m, &self.ends, &self.outline, nearest_first)
        } else {
            let free_m = self.free_lengths(nearest_first);
            let pieces = self.ends.iter().zip(free_m);
            pieces
                .map(|(&(curvature_lo, curvature_hi), distance_m)| ArcInterval {
                    curvature_lo,
                    curvature_hi,
                    distance_m,
                })
                .collect()
        };
        FreeArcs { intervals: merged(intervals) }
    }

    /// The same, and every piece as (rightmost, leftmost curvature, free length).
    pub fn free_arcs_and_pieces(&self, nearest_first: &[(f64, Point2)]) -> (FreeArcs, Vec<(f64, f64, f64)>) {
        let arcs = self.free_arcs(nearest_first);
        let mut next = arcs.intervals.iter().peekable();
        let pieces = self.ends.iter().map(|&(lo, hi)| {
            // Of the round robot a piece may hold several intervals; the shortest counts.
            let mut least_m = f64::INFINITY;
            while let Some(arc) = next.peek() {
                least_m = least_m.min(arc.distance_m);
                if arc.curvature_hi > hi {
                    break;
                }
                let ends_here = arc.curvature_hi >= hi;
                next.next();
                if ends_here {
                    break;
                }
            }
            (lo, hi, least_m)
        });
        let pieces = pieces.collect();
        (arcs, pieces)
    }

    /// Free length of every piece \[m\]. An obstacle is asked only of the pieces between the tangents
    /// of a disc that holds the widest outline: no arc of another piece comes near it.
    fn free_lengths(&self, nearest_first: &[(f64, Point2)]) -> Vec<f64> {
        let mut frontiers: Vec<Frontier> =
            self.pieces.iter().map(|piece| Frontier::new(piece, self.limit_m)).collect();
        // A few points first: then most of the others are seen to lie beyond.
        self.shorten(&mut frontiers, nearest_first.iter().step_by(FIRST));
        self.shorten(&mut frontiers, nearest_first.iter());
        frontiers.into_iter().map(|frontier| frontier.free_m).collect()
    }

    fn shorten<'a>(
        &self,
        frontiers: &mut [Frontier],
        nearest_first: impl Iterator<Item = &'a (f64, Point2)>,
    ) {
        let (first, last) = (self.ends[0].0, self.ends[self.ends.len() - 1].1);
        let per_step = self.pieces.len() as f64 / (last - first);
        let mut farthest_m = self.limit_m;
        for (i, &(distance_m, point)) in nearest_first.enumerate() {
            if i % 64 == 0 {
                farthest_m = frontiers.iter().map(|frontier| frontier.free_m).fold(0.0, f64::max);
            }
            if distance_m - self.reach_m >= farthest_m {
                break;
            }
            let (mut from, mut to) = (0, self.pieces.len());
            if let Some((lo, hi)) = tangent_curvatures(point, self.reach_m) {
                if lo > last || hi < first {
                    continue;
                }
                from = ((lo - first) * per_step - 1.0).max(0.0) as usize;
                to = (((hi - first) * per_step + 2.0) as usize).min(self.pieces.len());
            }
            for (piece, frontier) in self.pieces[from..to].iter().zip(&mut frontiers[from..to]) {
                if distance_m - piece.reach_m < frontier.free_m && !frontier.is_beyond(point) {
                    let contact_m = piece.contact_m(point, frontier.free_m);
                    if contact_m < frontier.free_m {
                        *frontier = Frontier::new(piece, contact_m);
                    }
                }
            }
        }
    }
}

/// Every so many points are asked first.
const FIRST: usize = 16;

/// How far a piece is free as known so far, and where the robot's outline is then.
struct Frontier {
    free_m: f64,
    sin: f64,
    cos: f64,
    origin: Point2,
    /// From the centre to the front line of the widest outline, and to the rear \[m\]; infinite where
    /// no line says anything: after a quarter turn, or where the robot turns about a point inside it.
    front_m: f64,
    /// From the centre to the line along the inner side \[m\].
    beside_m: f64,
    /// 1 where the robot turns left, −1 right.
    side: f64,
    /// How far the centre of turning lies to that side: beyond it the lines run the other way \[m\].
    center_m: f64,
    /// Squared least and greatest distance of the widest outline from the centre of turning.
    ring: (f64, f64),
}

impl Frontier {
    fn new(piece: &Piece, free_m: f64) -> Self {
        let pose = crate::geometry::Twist2::new(1.0, piece.curvature).displacement(free_m);
        let (sin, cos) = pose.heading.sin_cos();
        // The widest outline of the way so far is that of its last leg.
        let widest = piece.legs.iter().rev().find(|leg| leg.from_m < free_m).unwrap_or(&piece.legs[0]);
        let center_m = 1.0 / piece.curvature.abs();
        let beside_m = widest.outline.half_width_m + widest.outline.growth_m;
        let useful = free_m < 1.5 * center_m && center_m > beside_m;
        let lines = [widest.outline.half_length_m + widest.outline.growth_m, beside_m];
        let [front_m, beside_m] = if useful { lines } else { [f64::INFINITY; 2] };
        let side = piece.curvature.signum();
        Self {
            free_m,
            sin,
            cos,
            origin: pose.position(),
            front_m,
            beside_m,
            side,
            center_m,
            ring: widest.ring,
        }
    }

    /// Driving that far does not meet the point: it is ahead of the front line at the end of the free
    /// way, or behind the rear line at its beginning; or it lies beyond the inner side, not ahead of
    /// the centre at the beginning or not behind it at the end: a circle about the centre of turning
    /// is never nearer to the side than where it passes the robot's centre. Or it is outside the ring
    /// about the centre of turning that the outline sweeps.
    fn is_beyond(&self, point: Point2) -> bool {
        let inward = self.side * point.y;
        let squared = point.x * point.x + (inward - self.center_m) * (inward - self.center_m);
        if squared < self.ring.0 || squared > self.ring.1 {
            return true;
        }
        if inward < self.center_m && (point.x < -self.front_m || (point.x <= 0.0 && inward > self.beside_m)) {
            return true;
        }
        let offset = point - self.origin;
        let x = self.cos * offset.x + self.sin * offset.y;
        let inward = self.side * (-self.sin * offset.x + self.cos * offset.y);
        inward < self.center_m && (x > self.front_m || (x >= 0.0 && inward > self.beside_m))
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
#[derive(Clone, Debug)]
struct Piece {
    curvature: f64,
    legs: Vec<Leg>,
    /// Everything that an arc of the piece sweeps is within this of its centre line \[m\].
    reach_m: f64,
}

#[derive(Clone, Debug)]
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
    /// Order of the turn over the whole leg, and a little.
    most: f64,
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
                let turn_rad = (to_m - from_m) * curvature.abs() + 1e-9;
                let most =
                    if turn_rad < TAU { turn_order(turn_rad.sin(), turn_rad.cos()) } else { f64::INFINITY };
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
                    most,
                }
            })
            .collect::<Vec<Leg>>();
        let reach_m = legs.last().map_or(0.0, |leg| leg.outline.radius_m());
        Self { curvature, legs, reach_m }
    }

    /// Lower bound of the first contact of any arc of the fan, as far as it is below `below_m`.
    fn contact_m(&self, point: Point2, below_m: f64) -> f64 {
        let from_center_y = point.y - 1.0 / self.curvature;
        let squared = point.x * point.x + from_center_y * from_center_y;
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
            let contact_m = leg.from_m + leg.outline.first_contact_up_to_m(seen, self.curvature, leg.most);
            if contact_m <= leg.to_m {
                return contact_m;
            }
        }
        f64::INFINITY
    }
}

/// The round robot: pieces cut where its exact tangents say hit and free arcs meet.
fn disc_intervals(
    limit_m: f64,
    pieces: &[(f64, f64)],
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
