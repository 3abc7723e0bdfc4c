//! The tile solver against Dijkstra's algorithm on the grid's graph: every instruction set, any number
//! of threads, odd sizes, all kinds of grids; cost-to-go and policy to the bit.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use cairn::geometry::Pose2;
use cairn::plan::{
    Cost, Graph, MOVES, PlanError, PlanOptions, Simd, Values, graph_of_costs_f32, graph_of_costs_f64,
    graph_of_free, plan_costs_f32, plan_costs_f64, plan_free,
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
}

fn grid<T>(rows: usize, cols: usize, values: Vec<T>) -> Grid<T> {
    Grid::new(GridGeometry { rows, cols, resolution_m: 1.0, world_from_grid: Pose2::IDENTITY }, values)
}

/// Free cells of one of several kinds: scattered obstacles, walls with gaps, a comb, diagonals, rooms.
fn free_cells(rows: usize, cols: usize, numbers: &mut Numbers) -> Vec<bool> {
    let kind = numbers.below(6);
    let density = [0.0, 0.1, 0.3, 0.5][numbers.below(4)];
    let pitch = 2 + numbers.below(9);
    (0..rows * cols)
        .map(|at| {
            let (row, col) = (at / cols, at % cols);
            match kind {
                0 | 1 => numbers.unit() >= density,
                2 => row % pitch != 0 || numbers.unit() < 2.0 / cols as f64,
                3 => col % 2 == 0 || row == if col % 4 == 1 { 0 } else { rows - 1 }, // a serpentine
                4 => (row + col) % pitch != 0 || numbers.unit() < 0.05,
                _ => (row % 16 != 5 && col % 16 != 7) || numbers.unit() < 0.06,
            }
        })
        .collect()
}

fn size(numbers: &mut Numbers) -> usize {
    let edges = [1, 2, 15, 16, 17, 31, 33, 63, 64, 65, 66, 80, 127, 128, 129, 150];
    edges[numbers.below(edges.len())]
}

fn goals(free: &[bool], cols: usize, numbers: &mut Numbers) -> Vec<Cell> {
    let open: Vec<usize> = (0..free.len()).filter(|&at| free[at]).collect();
    let some = 1 + numbers.below(3);
    (0..some)
        .filter(|_| !open.is_empty())
        .map(|_| open[numbers.below(open.len())])
        .map(|at| Cell::new(at / cols, at % cols))
        .collect()
}

/// Cost-to-go by the textbook's algorithm, and codes by their definition. The links of a grid go both ways.
fn by_dijkstra<C: Cost>(graph: &Graph<C>, goals: &[Cell], cols: usize) -> (Vec<C>, Vec<i8>) {
    let (starts, targets, costs) = graph.to_csr();
    let mut values = vec![C::UNREACHABLE; starts.len() - 1];
    let mut open = BinaryHeap::new();
    for goal in goals {
        values[goal.row * cols + goal.col] = C::ZERO;
        open.push(Reverse((C::ZERO.key(), goal.row * cols + goal.col)));
    }
    while let Some(Reverse((key, at))) = open.pop() {
        if values[at].key() < key {
            continue;
        }
        for link in starts[at] as usize..starts[at + 1] as usize {
            let next = targets[link] as usize;
            let Some(cost) = values[at].plus(costs[link]) else { continue };
            if cost < values[next] {
                values[next] = cost;
                open.push(Reverse((cost.key(), next)));
            }
        }
    }
    let mut codes = vec![-1; values.len()];
    for (at, code) in codes.iter_mut().enumerate() {
        let (row, col) = ((at / cols) as isize, (at % cols) as isize);
        for link in starts[at] as usize..starts[at + 1] as usize {
            let (next, here) = (targets[link] as usize, values[at]);
            let ahead = values[next];
            if *code == -1 && ahead < here && ahead.plus(costs[link]) == Some(here) {
                let (down, right) = ((next / cols) as isize - row, (next % cols) as isize - col);
                *code = MOVES.iter().position(|&to| to == (down, right)).unwrap() as i8; // links are in order
            }
        }
    }
    (values, codes)
}

/// Asserts equality without printing thousands of numbers.
fn assert_same<T: PartialEq + std::fmt::Debug>(is: &[T], should_be: &[T], what: &str) {
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

#[test]
fn free_grids_equal_dijkstra_with_every_instruction_set_and_any_number_of_threads() {
    let mut numbers = Numbers(1);
    for _ in 0..120 {
        let (rows, cols) = (size(&mut numbers), size(&mut numbers));
        let free = grid(rows, cols, free_cells(rows, cols, &mut numbers));
        let goals = goals(&free.values, cols, &mut numbers);
        if goals.is_empty() {
            continue;
        }
        let base = PlanOptions { corner_cutting: numbers.below(2) == 1, ..PlanOptions::default() };
        let (values, codes) = by_dijkstra(&graph_of_free(&free, &base).unwrap(), &goals, cols);
        for options in every_way(&base) {
            let field = plan_free(&free, &goals, &options).unwrap();
            let what = format!("{rows} x {cols}, {options:?}");
            let Values::U32(is) = field.native() else { panic!("{what}: not u32") };
            assert_same(is, &values, &what);
            assert_same(field.next_codes(), &codes, &what);
        }
    }
}

fn cell_costs(free: &[bool], numbers: &mut Numbers) -> Vec<f64> {
    let kind = numbers.below(3);
    let cost = |numbers: &mut Numbers| match kind {
        0 => 1.0 + numbers.below(255) as f64,
        1 => 0.01 + numbers.unit(),
        _ => 10_f64.powf(4.0 * numbers.unit() - 2.0),
    };
    free.iter().map(|&free| if free { cost(numbers) } else { f64::INFINITY }).collect()
}

#[test]
fn cost_grids_equal_dijkstra_with_every_instruction_set_and_any_number_of_threads() {
    let mut numbers = Numbers(2);
    for _ in 0..80 {
        let (rows, cols) = (size(&mut numbers), size(&mut numbers));
        let free = free_cells(rows, cols, &mut numbers);
        let goals = goals(&free, cols, &mut numbers);
        if goals.is_empty() {
            continue;
        }
        let base = PlanOptions { corner_cutting: numbers.below(2) == 1, ..PlanOptions::default() };
        let double = grid(rows, cols, cell_costs(&free, &mut numbers));
        let single = grid(rows, cols, double.values.iter().map(|&cost| cost as f32).collect());
        let (values, codes) = by_dijkstra(&graph_of_costs_f32(&single, &base).unwrap(), &goals, cols);
        let in_double = by_dijkstra(&graph_of_costs_f64(&double, &base).unwrap(), &goals, cols);
        for options in every_way(&base) {
            let field = plan_costs_f32(&single, &goals, &options).unwrap();
            let what = format!("{rows} x {cols}, {options:?}");
            let Values::F32(is) = field.native() else { panic!("{what}: not f32") };
            assert_same(is, &values, &what);
            assert_same(field.next_codes(), &codes, &what);
            let field = plan_costs_f64(&double, &goals, &options).unwrap();
            let Values::F64(is) = field.native() else { panic!("{what}: not f64") };
            assert_same(is, &in_double.0, &what);
            assert_same(field.next_codes(), &in_double.1, &what);
        }
    }
}

#[test]
fn a_field_for_one_start_is_the_whole_field_up_to_the_start() {
    let mut numbers = Numbers(3);
    for _ in 0..120 {
        let (rows, cols) = (size(&mut numbers), size(&mut numbers));
        let free = grid(rows, cols, free_cells(rows, cols, &mut numbers));
        let goals = goals(&free.values, cols, &mut numbers);
        if goals.is_empty() {
            continue;
        }
        let start = Cell::new(numbers.below(rows), numbers.below(cols));
        let whole = plan_free(&free, &goals, &PlanOptions::default()).unwrap();
        for options in every_way(&PlanOptions { start: Some(start), ..PlanOptions::default() }) {
            let field = plan_free(&free, &goals, &options).unwrap();
            let most = whole.cost_to_go(start);
            for row in 0..rows {
                for col in 0..cols {
                    let cell = Cell::new(row, col);
                    let kept = whole.cost_to_go(cell) <= most;
                    let cost = if kept { whole.cost_to_go(cell) } else { f64::INFINITY };
                    assert_eq!(field.cost_to_go(cell), cost);
                    assert_eq!(field.next(cell), whole.next(cell).filter(|_| kept));
                }
            }
            assert_eq!(field.path(start), whole.path(start));
        }
    }
}

#[test]
fn a_planner_used_again_forgets_the_grid_before() {
    let mut numbers = Numbers(4);
    let mut planner = cairn::plan::GridPlanner::default();
    for _ in 0..60 {
        let (rows, cols) = (size(&mut numbers), size(&mut numbers));
        let free = grid(rows, cols, free_cells(rows, cols, &mut numbers));
        let goals = goals(&free.values, cols, &mut numbers);
        if goals.is_empty() {
            continue;
        }
        let options = PlanOptions::default();
        let field = planner.plan_free(&free, &goals, &options).unwrap();
        assert!(field == plan_free(&free, &goals, &options).unwrap());
        planner.recycle(field);
    }
}

#[test]
fn a_start_outside_the_grid_is_refused() {
    let options = PlanOptions { start: Some(Cell::new(0, 3)), ..PlanOptions::default() };
    let error = plan_free(&grid(2, 3, vec![true; 6]), &[Cell::new(0, 0)], &options).unwrap_err();
    assert!(matches!(error, PlanError::StartOutsideGrid { row: 0, col: 3, rows: 2, cols: 3 }), "{error}");
}

#[test]
fn long_thin_grids_equal_dijkstra_too() {
    let mut numbers = Numbers(5);
    for (rows, cols) in [(1, 9000), (3, 7000), (6500, 2), (7, 5000)] {
        let free = grid(rows, cols, (0..rows * cols).map(|_| numbers.below(40) > 0).collect());
        let costs =
            grid(rows, cols, cell_costs(&free.values, &mut numbers).into_iter().map(|c| c as f32).collect());
        let goals = goals(&free.values, cols, &mut numbers);
        let options = PlanOptions { corner_cutting: numbers.below(2) == 1, ..PlanOptions::default() };
        let (values, codes) = by_dijkstra(&graph_of_free(&free, &options).unwrap(), &goals, cols);
        let field = plan_free(&free, &goals, &options).unwrap();
        assert!(field.native() == &Values::U32(values));
        assert_same(field.next_codes(), &codes, "free");
        let (values, codes) = by_dijkstra(&graph_of_costs_f32(&costs, &options).unwrap(), &goals, cols);
        let field = plan_costs_f32(&costs, &goals, &options).unwrap();
        assert!(field.native() == &Values::F32(values));
        assert_same(field.next_codes(), &codes, "costs");
        let start = Cell::new(rows / 2, cols / 2);
        let some = plan_costs_f32(&costs, &goals, &PlanOptions { start: Some(start), ..options }).unwrap();
        assert_eq!(some.path(start), field.path(start));
    }
}
