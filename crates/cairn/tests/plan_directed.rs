//! Links that cost one thing there and another back, against Dijkstra's algorithm: every instruction
//! set, any number of threads, odd sizes, holes, moves that go one way only; to the bit.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use cairn::geometry::Pose2;
use cairn::plan::terrain::{AnyTerrainLinks, P3at, TerrainModel, Tobler};
use cairn::plan::{
    Cost, DirectionWeights, GridPlanner, MOVES, PlanError, PlanOptions, Simd, Values, plan_terrain,
    plan_weights_f32, plan_weights_u32,
};
use cairn::world::{Cell, Grid, GridGeometry};

/// A small repeatable source of numbers.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        self.0 >> 33
    }

    fn below(&mut self, most: usize) -> usize {
        (self.next() % most as u64) as usize
    }

    fn unit(&mut self) -> f64 {
        self.next() as f64 / (1_u64 << 31) as f64
    }

    fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }
}

fn geometry(rows: usize, cols: usize, resolution_m: f64) -> GridGeometry {
    GridGeometry { rows, cols, resolution_m, world_from_grid: Pose2::IDENTITY }
}

fn size(numbers: &mut Numbers) -> usize {
    numbers.one_of(&[1, 2, 15, 16, 17, 31, 33, 63, 64, 65, 66, 80, 127, 128, 129, 150])
}

/// Cost-to-go by the textbook's algorithm, and codes by their definition. `cost(cell, code)` is
/// `UNREACHABLE` where there is no such move.
fn by_dijkstra<C: Cost>(
    grid: &GridGeometry,
    goals: &[Cell],
    cost: impl Fn(usize, usize) -> C,
) -> (Vec<C>, Vec<i8>) {
    let neighbour = |at: usize, (down, right): (isize, isize)| {
        let Cell { row, col } = grid.cell(at);
        let row = row.checked_add_signed(down).filter(|&row| row < grid.rows)?;
        let col = col.checked_add_signed(right).filter(|&col| col < grid.cols)?;
        Some(row * grid.cols + col)
    };
    let mut values = vec![C::UNREACHABLE; grid.len()];
    let mut open = BinaryHeap::new();
    for &goal in goals {
        values[grid.index(goal)] = C::ZERO;
        open.push(Reverse((C::ZERO.key(), grid.index(goal))));
    }
    while let Some(Reverse((key, at))) = open.pop() {
        if values[at].key() < key {
            continue;
        }
        for (code, (down, right)) in MOVES.into_iter().enumerate() {
            let Some(from) = neighbour(at, (-down, -right)) else { continue };
            let cost = cost(from, code);
            let Some(sum) = values[at].plus(cost).filter(|_| cost < C::UNREACHABLE) else { continue };
            if sum < values[from] {
                values[from] = sum;
                open.push(Reverse((sum.key(), from)));
            }
        }
    }
    let mut codes = vec![-1; values.len()];
    for at in 0..values.len() {
        let is_best = |&code: &usize| {
            let Some(next) = neighbour(at, MOVES[code]) else { return false };
            let cost = cost(at, code);
            cost < C::UNREACHABLE && values[next] < values[at] && values[next].plus(cost) == Some(values[at])
        };
        let goal = values[at] == C::ZERO || values[at] == C::UNREACHABLE;
        codes[at] = if goal { -1 } else { (0..8).find(is_best).unwrap() as i8 };
    }
    (values, codes)
}

/// Asserts equality without printing thousands of numbers.
fn assert_same<T: PartialEq + std::fmt::Debug>(is: &[T], should_be: &[T], what: &str) {
    assert_eq!(is.len(), should_be.len(), "{what}");
    if let Some(at) = (0..should_be.len()).find(|&at| is[at] != should_be[at]) {
        panic!("{what}: at {at} is {:?}, should be {:?}", is[at], should_be[at]);
    }
}

fn every_way(base: &PlanOptions) -> Vec<PlanOptions> {
    let levels = Simd::ALL.into_iter().filter(|level| level.is_available());
    let with = |simd| {
        [1, 2, 3].map(|threads| PlanOptions { simd: Some(simd), threads: Some(threads), ..base.clone() })
    };
    levels.flat_map(with).collect()
}

/// Weights of one of several kinds: all alike, small, of all sizes; some moves missing, or all of one code.
fn weights(grid: &GridGeometry, numbers: &mut Numbers) -> Vec<u32> {
    let (kind, missing, lost_code) = (numbers.below(3), numbers.one_of(&[0.0, 0.1, 0.5]), numbers.below(16));
    let weight = |numbers: &mut Numbers| match kind {
        0 => 3,
        1 => 1 + numbers.below(9) as u32,
        _ => 1 + (50_000.0_f64).powf(numbers.unit()) as u32,
    };
    (0..8 * grid.len())
        .map(|at| {
            let none = numbers.unit() < missing || at / grid.len() == lost_code;
            if none { u32::MAX } else { weight(numbers) }
        })
        .collect()
}

fn goals(grid: &GridGeometry, numbers: &mut Numbers) -> Vec<Cell> {
    (0..1 + numbers.below(3)).map(|_| grid.cell(numbers.below(grid.len()))).collect()
}

#[test]
fn weights_equal_dijkstra_with_every_instruction_set_and_any_number_of_threads() {
    let mut numbers = Numbers(1);
    for _ in 0..60 {
        let grid = geometry(size(&mut numbers), size(&mut numbers), 1.0);
        let goals = goals(&grid, &mut numbers);
        let whole = weights(&grid, &mut numbers);
        let single: Vec<f32> =
            whole.iter().map(|&w| if w == u32::MAX { f32::INFINITY } else { w as f32 * 0.1 }).collect();
        let in_whole = by_dijkstra(&grid, &goals, |at, code| whole[code * grid.len() + at]);
        let in_single = by_dijkstra(&grid, &goals, |at, code| single[code * grid.len() + at]);
        for options in every_way(&PlanOptions::default()) {
            let what = format!("{} x {}, {options:?}", grid.rows, grid.cols);
            let weights = DirectionWeights::new(grid, &whole).unwrap();
            let field = plan_weights_u32(&weights, &goals, &options).unwrap();
            let Values::U32(is) = field.native() else { panic!("{what}: not u32") };
            assert_same(is, &in_whole.0, &what);
            assert_same(field.next_codes(), &in_whole.1, &what);
            let weights = DirectionWeights::new(grid, &single).unwrap();
            let field = plan_weights_f32(&weights, &goals, &options).unwrap();
            let Values::F32(is) = field.native() else { panic!("{what}: not f32") };
            assert_same(is, &in_single.0, &what);
            assert_same(field.next_codes(), &in_single.1, &what);
        }
    }
}

/// Heights of one of several kinds: hills, steps that tie, noise, a slope; with holes.
fn heights(grid: &GridGeometry, numbers: &mut Numbers) -> Grid<f32> {
    let (kind, holes) = (numbers.below(4), numbers.one_of(&[0.0, 0.0, 0.1, 0.4]));
    let (steepness, waves) = (numbers.one_of(&[0.05, 0.3, 1.0]), 4.0 + 30.0 * numbers.unit());
    let values = (0..grid.len()).map(|at| {
        let Cell { row, col } = grid.cell(at);
        let (x, y) = (col as f64 / waves, row as f64 / waves);
        let height = match kind {
            0 => (x.sin() * (1.3 * y).cos() + 0.3 * (3.7 * x + y).sin()) * waves,
            1 => numbers.below(3) as f64,
            2 => numbers.unit(),
            _ => (x - 0.7 * y) * waves,
        };
        let height = (height * steepness * grid.resolution_m) as f32;
        if numbers.unit() < holes { f32::NAN } else { height }
    });
    Grid::new(*grid, values.collect())
}

fn model(numbers: &mut Numbers) -> TerrainModel {
    let (climb, descent) = (numbers.one_of(&[0.3, 0.8, 1.5]), numbers.one_of(&[0.2, 0.5, 1.5]));
    let roll = numbers.one_of(&[0.3, 1.0, std::f64::consts::FRAC_PI_2]);
    let tobler = Tobler {
        max_climb_rad: climb,
        max_descent_rad: descent,
        max_roll_rad: roll,
        max_roughness: numbers.one_of(&[0.2, f64::INFINITY]),
        ..Tobler::default()
    };
    let p3at = P3at {
        max_climb_rad: climb,
        max_descent_rad: descent,
        max_roll_rad: roll,
        max_roughness: numbers.one_of(&[0.2, f64::INFINITY]),
        ..P3at::default()
    };
    numbers.one_of(&[
        TerrainModel::P3atEnergy(p3at),
        TerrainModel::P3atTime(p3at),
        TerrainModel::Tobler(tobler),
        TerrainModel::P3atEnergy(P3at::default()),
        TerrainModel::Tobler(Tobler::default()),
    ])
}

/// Costs of the eight moves out of each cell.
fn link_costs(links: &AnyTerrainLinks<'_>, cells: usize) -> Vec<[f32; 8]> {
    (0..cells)
        .map(|at| match links {
            AnyTerrainLinks::P3atEnergy(links) => links.costs_from(at),
            AnyTerrainLinks::P3atTime(links) => links.costs_from(at),
            AnyTerrainLinks::Tobler(links) => links.costs_from(at),
        })
        .collect()
}

/// A terrain with goals that can be entered, its model, and what its moves cost.
struct Terrain {
    elevation: Grid<f32>,
    roughness: Option<Grid<f32>>,
    model: TerrainModel,
    corner_cutting: bool,
    goals: Vec<Cell>,
    costs: Vec<[f32; 8]>,
}

fn terrain(numbers: &mut Numbers) -> Terrain {
    loop {
        let grid = geometry(size(numbers), size(numbers), numbers.one_of(&[0.1, 1.0, 30.0]));
        let elevation = heights(&grid, numbers);
        let rough =
            (0..grid.len()).map(|_| if numbers.below(40) == 0 { f32::NAN } else { numbers.unit() as f32 });
        let rough: Vec<f32> = rough.map(|rough| 0.3 * rough).collect();
        let roughness = (numbers.below(2) == 0).then(|| Grid::new(grid, rough));
        let (model, corner_cutting) = (model(numbers), numbers.below(2) == 0);
        let links = AnyTerrainLinks::new(&elevation, roughness.as_ref(), &model, corner_cutting).unwrap();
        let costs = link_costs(&links, grid.len());
        let open: Vec<usize> = (0..grid.len())
            .filter(|&at| match &links {
                AnyTerrainLinks::P3atEnergy(links) => !links.is_blocked(at),
                AnyTerrainLinks::P3atTime(links) => !links.is_blocked(at),
                AnyTerrainLinks::Tobler(links) => !links.is_blocked(at),
            })
            .collect();
        if !open.is_empty() {
            let goals = (0..1 + numbers.below(3)).map(|_| grid.cell(numbers.one_of(&open))).collect();
            return Terrain { elevation, roughness, model, corner_cutting, goals, costs };
        }
    }
}

#[test]
fn terrains_equal_dijkstra_with_every_instruction_set_and_any_number_of_threads() {
    let mut numbers = Numbers(2);
    for _ in 0..60 {
        let Terrain { elevation, roughness, model, corner_cutting, goals, costs } = terrain(&mut numbers);
        let grid = elevation.geometry;
        let (values, codes) = by_dijkstra(&grid, &goals, |at, code| costs[at][code]);
        for options in every_way(&PlanOptions { corner_cutting, ..PlanOptions::default() }) {
            let what = format!("{} x {}, {model:?}, {options:?}", grid.rows, grid.cols);
            let field = plan_terrain(&elevation, roughness.as_ref(), &model, &goals, &options).unwrap();
            let Values::F32(is) = field.native() else { panic!("{what}: not f32") };
            assert_same(is, &values, &what);
            assert_same(field.next_codes(), &codes, &what);
        }
    }
}

#[test]
fn a_field_for_one_start_is_the_whole_field_up_to_the_start_and_a_planner_forgets() {
    let mut numbers = Numbers(3);
    let mut planner = GridPlanner::default();
    for _ in 0..40 {
        let Terrain { elevation, roughness, model, corner_cutting, goals, .. } = terrain(&mut numbers);
        let grid = elevation.geometry;
        let start = grid.cell(numbers.below(grid.len()));
        let whole_options = PlanOptions { corner_cutting, ..PlanOptions::default() };
        let whole = plan_terrain(&elevation, roughness.as_ref(), &model, &goals, &whole_options).unwrap();
        for options in every_way(&PlanOptions { start: Some(start), ..whole_options }) {
            let field =
                planner.plan_terrain(&elevation, roughness.as_ref(), &model, &goals, &options).unwrap();
            for at in 0..grid.len() {
                let cell = grid.cell(at);
                let kept = whole.cost_to_go(cell) <= whole.cost_to_go(start);
                let cost = if kept { whole.cost_to_go(cell) } else { f64::INFINITY };
                assert_eq!(field.cost_to_go(cell), cost);
                assert_eq!(field.next(cell), whole.next(cell).filter(|_| kept));
            }
            assert_eq!(field.path(start), whole.path(start));
            planner.recycle(field);
        }
    }
}

/// A row of cells with all moves of cost 1 but those to the left, which cost `left`.
fn row_of(left: &[u32]) -> (GridGeometry, Vec<u32>) {
    let mut weights = vec![1; 8 * left.len()];
    weights[4 * left.len()..5 * left.len()].copy_from_slice(left);
    (geometry(1, left.len(), 1.0), weights)
}

#[test]
fn whole_weights_are_summed_in_u32_where_the_sums_fit_and_in_u64_where_not() {
    let half = u32::MAX / 2;
    for (left, fits) in [
        (vec![1, half, 1, 1], true),
        (vec![1, half, half, 1], false), // 2 half + 1 is "no way"
        (vec![1, half, half - 1, 1], true),
        (vec![1, u32::MAX - 1, u32::MAX, 1], true), // the far cells have no way
        (vec![u32::MAX - 1, 1, 1, 1], true),        // off the grid
        (vec![1, u32::MAX - 1, 1, 1], false),
    ] {
        let (grid, planes) = row_of(&left);
        let weights = DirectionWeights::new(grid, &planes).unwrap();
        for options in every_way(&PlanOptions::default()) {
            let field = plan_weights_u32(&weights, &[Cell::new(0, 0)], &options).unwrap();
            let mut sum = Some(0_u64);
            for (col, &weight) in left.iter().enumerate() {
                if col > 0 {
                    sum = sum.filter(|_| weight < u32::MAX).map(|sum| sum + u64::from(weight));
                }
                let cost = sum.map_or(f64::INFINITY, |sum| sum as f64);
                assert_eq!(field.cost_to_go(Cell::new(0, col)), cost, "{left:?}");
                assert_eq!(field.next_codes()[col], if col == 0 || sum.is_none() { -1 } else { 4 });
            }
            assert_eq!(matches!(field.native(), Values::U32(_)), fits, "{left:?}");
        }
    }
}

#[test]
fn single_weights_that_vanish_or_overflow_are_refused_by_name() {
    let plan = |left: [f32; 4]| {
        let mut planes = vec![1.0; 32];
        planes[16..20].copy_from_slice(&left);
        let weights = DirectionWeights::new(geometry(1, 4, 1.0), &planes).unwrap();
        plan_weights_f32(&weights, &[Cell::new(0, 0)], &PlanOptions::default())
    };
    let absorbed = plan([1.0, 1e9, 1.0, 1.0]).unwrap_err();
    assert!(matches!(absorbed, PlanError::LinkCostAbsorbed { row: 0, col: 2, .. }), "{absorbed}");
    let overflow = plan([1.0, 3e38, 1e38, 1.0]).unwrap_err();
    assert!(matches!(overflow, PlanError::CostToGoOverflow { row: 0, col: 2, .. }), "{overflow}");
    let kept = plan([1.0, 1e9, f32::INFINITY, 1.0]).unwrap();
    assert_eq!(kept.cost_to_go(Cell::new(0, 1)), 1e9);
}
