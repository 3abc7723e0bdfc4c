//! The any-angle finish: an eight-direction path shortened by line of sight, never made dearer.
//!
//! Path smoothing after the search (as [Nash07] describes it), but not greedy: of all ways over some
//! of the path's points, dynamic programming finds the cheapest among the segments that it tries, and
//! again on what is left, until nothing changes.
//!
//! The rule, in f64: a segment may take the place of a stretch of the path if it may pass and the most
//! that it costs (see [`Toll`](super::sight::Toll)) is no more than the stretch costs, where 1e-12 of it
//! and four units in the last place of the path's cost are left to rounding. Of equally cheap ways the
//! one of fewer segments is taken.

use super::sight::{Ground, Sight, Vertex};
use super::{Field, PlanError};
use crate::geometry::Point2;
use crate::world::Cell;

/// How many links back a segment may begin: all up to 16, then ever fewer. Measured against every
/// number up to the length of the path, this loses a fiftieth of the gain at a hundredth of the time.
/// After n rounds a segment spans up to 232ⁿ links, so that a few rounds see everything.
const LOOK_BACK: [usize; 27] =
    [232, 186, 149, 119, 95, 76, 61, 49, 39, 31, 25, 20, 16, 15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2];

/// The indices of the points of `path` that its cheapest any-angle form keeps, both ends among them.
///
/// Each link of `path` must be one that may pass.
pub fn shortened<G: Ground>(path: &[Vertex], sight: &Sight<'_, G>) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..path.len()).collect();
    let mut links = path
        .windows(2)
        .map(|link| sight.toll(link[0], link[1], f64::INFINITY).map_or(f64::INFINITY, |toll| toll.most))
        .collect();
    loop {
        let points: Vec<Vertex> = kept.iter().map(|&index| path[index]).collect();
        let (chosen, costs) = round(&points, links, sight);
        let done = chosen.len() == kept.len();
        kept = chosen.into_iter().map(|index| kept[index]).collect();
        links = costs;
        if done {
            return kept;
        }
    }
}

/// The cheapest way to a point that has been found.
#[derive(Clone, Copy)]
struct Best {
    cost: f64,
    segments: u32,
    from: usize,
    /// Cost of the last segment.
    link: f64,
}

impl Best {
    /// What rounding may have done to it and to one that it is compared with.
    fn slack(&self) -> f64 {
        1e-12 * self.link + 4.0 * f64::EPSILON * self.cost
    }

    /// Cheaper, or as cheap with fewer segments.
    fn beats(&self, other: &Self) -> bool {
        let slack = self.slack();
        self.cost < other.cost - slack || (self.cost <= other.cost + slack && self.segments < other.segments)
    }
}

/// Which of `points` to keep, and the cost of each link between those; `links` are the costs as it is.
fn round<G: Ground>(points: &[Vertex], links: Vec<f64>, sight: &Sight<'_, G>) -> (Vec<usize>, Vec<f64>) {
    let mut best: Vec<Best> = Vec::with_capacity(points.len());
    best.push(Best { cost: 0.0, segments: 0, from: 0, link: 0.0 });
    for to in 1..points.len() {
        let before = best[to - 1];
        let link = links[to - 1];
        let mut found = Best { cost: before.cost + link, segments: before.segments + 1, from: to - 1, link };
        for &back in LOOK_BACK.iter().filter(|&&back| back <= to) {
            let from = to - back;
            let Best { cost, segments, .. } = best[from];
            let candidate = |link| Best { cost: cost + link, segments: segments + 1, from, link };
            let least = if sight.ground.is_uniform() { points[from].distance(points[to]) } else { 0.0 };
            if !candidate(least).beats(&found) {
                continue;
            }
            // `found` costs no more than the stretch that the segment would replace.
            let limit = found.cost + found.slack() - cost;
            let toll = sight.toll(points[from], points[to], limit);
            if let Some(better) = toll.map(|toll| candidate(toll.most)).filter(|it| it.beats(&found)) {
                found = better;
            }
        }
        best.push(found);
    }
    let mut kept = vec![points.len() - 1];
    let mut costs = Vec::new();
    while let Some(&last) = kept.last().filter(|&&last| last > 0) {
        costs.push(best[last].link);
        kept.push(best[last].from);
    }
    kept.reverse();
    costs.reverse();
    (kept, costs)
}

/// What a field was solved on, as far as its paths need to know.
#[derive(Clone, Copy, Debug)]
pub enum Crossed<'a> {
    /// Free and blocked cells: which are free, as far as a path can get, is in the field itself.
    Free,
    /// Costs in single precision, row-major.
    F32(&'a [f32]),
    /// Costs in double precision, row-major.
    F64(&'a [f64]),
}

/// Costs of a grid of so many columns.
struct Priced<'a, C> {
    costs: &'a [C],
    cols: usize,
}

impl<C: Copy + Into<f64>> Ground for Priced<'_, C> {
    fn cost(&self, row: usize, col: usize) -> f64 {
        self.costs.get(row * self.cols + col).map_or(f64::INFINITY, |&cost| cost.into())
    }
}

/// Cells that have a way to a goal. A segment that starts in one and crosses none but free cells never
/// leaves them, so they serve for all free cells.
struct Reachable<'a>(&'a Field);

impl Ground for Reachable<'_> {
    fn cost(&self, row: usize, col: usize) -> f64 {
        if self.0.is_reachable(Cell::new(row, col)) { 1.0 } else { f64::INFINITY }
    }

    fn is_uniform(&self) -> bool {
        true
    }
}

impl Field {
    /// The cells of [`path`](Self::path) that a robot turns at when it goes straight wherever that is
    /// no dearer, both ends included; None where there is no way.
    ///
    /// `corner_cutting` as the field was solved with.
    pub fn any_angle_path(
        &self,
        start: Cell,
        crossed: Crossed<'_>,
        corner_cutting: bool,
    ) -> Option<Vec<Cell>> {
        let cells = self.path(start)?;
        let vertices: Vec<Vertex> = cells.iter().copied().map(Vertex::Centre).collect();
        let kept = self.shortened(&vertices, crossed, corner_cutting);
        Some(kept.into_iter().map(|index| cells[index]).collect())
    }

    /// The points of [`path_in_world`](Self::path_in_world) that a robot turns at when it goes straight
    /// wherever that is no dearer, both ends included; None where there is no way.
    ///
    /// Where corners may be cut and the straight way from the start to the centre of the second cell
    /// would clip a blocked one, the centre of the first is a point too; at the goal likewise.
    ///
    /// # Errors
    /// [`PlanError::StartOutsideMap`].
    pub fn any_angle_path_in_world(
        &self,
        start_in_world: Point2,
        goals_in_world: &[Point2],
        crossed: Crossed<'_>,
        corner_cutting: bool,
    ) -> Result<Option<Vec<Point2>>, PlanError> {
        let Some(points) = self.path_in_world(start_in_world, goals_in_world)? else { return Ok(None) };
        let geometry = self.geometry();
        let cells = geometry.cell_at(start_in_world).and_then(|first| self.path(first)).unwrap_or_default();
        let (&[_, .., goal], &[first, .., last]) = (&points[..], &cells[..]) else { return Ok(Some(points)) };
        let grid_from_world = geometry.world_from_grid.inverse();
        let vertex = |point: Point2, cell: Cell| {
            if point == geometry.center(cell) {
                return Vertex::Centre(cell);
            }
            let in_grid = grid_from_world * point;
            Vertex::point(in_grid.x / geometry.resolution_m, in_grid.y / geometry.resolution_m)
        };
        let mut path: Vec<(Point2, Vertex)> = vec![(start_in_world, vertex(start_in_world, first))];
        path.extend(cells.iter().map(|&cell| (geometry.center(cell), Vertex::Centre(cell))));
        path.push((goal, vertex(goal, last)));
        let cols = geometry.cols;
        let clear = |a: Vertex, b: Vertex| match crossed {
            Crossed::Free => passes(&Reachable(self), a, b, corner_cutting),
            Crossed::F32(costs) => passes(&Priced { costs, cols }, a, b, corner_cutting),
            Crossed::F64(costs) => passes(&Priced { costs, cols }, a, b, corner_cutting),
        };
        // The first and the last centre stand aside, as in `path_in_world`, where they can.
        let last = path.len() - 2;
        if clear(path[last - 1].1, path[last + 1].1) {
            path.remove(last);
        }
        if clear(path[0].1, path[2].1) {
            path.remove(1);
        }
        let vertices: Vec<Vertex> = path.iter().map(|&(_, vertex)| vertex).collect();
        let kept = self.shortened(&vertices, crossed, corner_cutting);
        Ok(Some(kept.into_iter().map(|index| path[index].0).collect()))
    }

    fn shortened(&self, path: &[Vertex], crossed: Crossed<'_>, corner_cutting: bool) -> Vec<usize> {
        let cols = self.geometry().cols;
        match crossed {
            Crossed::Free => shortened(path, &Sight { ground: &Reachable(self), corner_cutting }),
            Crossed::F32(costs) => {
                shortened(path, &Sight { ground: &Priced { costs, cols }, corner_cutting })
            }
            Crossed::F64(costs) => {
                shortened(path, &Sight { ground: &Priced { costs, cols }, corner_cutting })
            }
        }
    }
}

fn passes<G: Ground>(ground: &G, a: Vertex, b: Vertex, corner_cutting: bool) -> bool {
    Sight { ground, corner_cutting }.toll(a, b, f64::INFINITY).is_some()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geometry::Pose2;
    use crate::plan::{PlanOptions, plan_costs_f64, plan_free};
    use crate::world::{Grid, GridGeometry};

    fn geometry(rows: usize, cols: usize) -> GridGeometry {
        GridGeometry { rows, cols, resolution_m: 1.0, world_from_grid: Pose2::IDENTITY }
    }

    fn cost_of<G: Ground>(path: &[Vertex], sight: &Sight<'_, G>) -> f64 {
        path.windows(2).map(|link| sight.toll(link[0], link[1], f64::INFINITY).unwrap().cost).sum()
    }

    proptest! {
        #[test]
        fn what_is_shortened_is_no_dearer_and_cannot_be_shortened_again(
            rows in 1usize..40, cols in 1usize..40, seed: u64, blocked in 0u64..5, most in 1u64..9,
            corner_cutting: bool,
        ) {
            let mut state = seed | 1;
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                state >> 33
            };
            let mut costs: Vec<f64> = (0..rows * cols)
                .map(|_| if next() % 10 < blocked { f64::INFINITY } else { (1 + next() % most) as f64 })
                .collect();
            costs[0] = 1.0;
            let grid = Grid::new(geometry(rows, cols), costs);
            let options = PlanOptions { corner_cutting, ..PlanOptions::default() };
            let field = plan_costs_f64(&grid, &[Cell::new(0, 0)], &options).unwrap();
            let ground = Priced { costs: &grid.values, cols };
            let sight = Sight { ground: &ground, corner_cutting };
            let starts = (0..rows * cols).map(|i| grid.geometry.cell(i)).filter(|&cell| field.is_reachable(cell));
            for start in starts.step_by(7) {
                let whole: Vec<Vertex> = field.path(start).unwrap().into_iter().map(Vertex::Centre).collect();
                let short: Vec<Vertex> = shortened(&whole, &sight).into_iter().map(|i| whole[i]).collect();
                prop_assert_eq!((short.first(), short.last()), (whole.first(), whole.last()));
                prop_assert!(cost_of(&short, &sight) <= cost_of(&whole, &sight) * (1.0 + 1e-11));
                prop_assert_eq!(shortened(&short, &sight), (0..short.len()).collect::<Vec<_>>());
                let cells = field.any_angle_path(start, Crossed::F64(&grid.values), corner_cutting).unwrap();
                prop_assert_eq!(cells.into_iter().map(Vertex::Centre).collect::<Vec<_>>(), short);
            }
        }
    }

    #[test]
    fn on_an_open_grid_every_path_becomes_one_segment() {
        let grid = Grid::filled(geometry(700, 1500), true);
        let field = plan_free(&grid, &[Cell::new(3, 5)], &PlanOptions::default()).unwrap();
        for start in [(3, 6), (4, 6), (699, 1499), (0, 1499), (699, 0), (333, 1234)] {
            let start = Cell::new(start.0, start.1);
            let path = field.any_angle_path(start, Crossed::Free, false).unwrap();
            assert_eq!(path, [start, Cell::new(3, 5)]);
        }
        assert_eq!(field.any_angle_path(Cell::new(3, 5), Crossed::Free, false).unwrap(), [Cell::new(3, 5)]);
    }

    #[test]
    fn costs_too_few_are_walls_not_a_panic() {
        let grid = Grid::filled(geometry(6, 9), 2.0_f64);
        let field = plan_costs_f64(&grid, &[Cell::new(0, 0)], &PlanOptions::default()).unwrap();
        let start = Cell::new(5, 8);
        let path = field.any_angle_path(start, Crossed::F64(&grid.values[..9]), false).unwrap();
        assert_eq!((path[0], *path.last().unwrap()), (start, Cell::new(0, 0)));
    }
}
