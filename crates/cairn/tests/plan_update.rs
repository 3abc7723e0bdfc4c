//! A field repaired against the same field solved anew: cost-to-go and policy to the bit.

use cairn::geometry::Pose2;
use cairn::plan::{Field, NewCosts, PlanError, PlanOptions, plan_costs_f32, plan_costs_f64, plan_free};
use cairn::world::{Cell, Grid, GridGeometry};

struct Numbers(u64);

impl Numbers {
    fn below(&mut self, most: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) % most as u64) as usize
    }
}

fn grid<T>(rows: usize, cols: usize, values: Vec<T>) -> Grid<T> {
    Grid::new(GridGeometry { rows, cols, resolution_m: 1.0, world_from_grid: Pose2::IDENTITY }, values)
}

fn size(numbers: &mut Numbers) -> usize {
    [1, 5, 63, 64, 65, 130, 200, 257][numbers.below(8)]
}

/// A few cells, a block, a line or cells here and there.
fn some_cells(rows: usize, cols: usize, numbers: &mut Numbers) -> Vec<Cell> {
    let (row, col) = (numbers.below(rows), numbers.below(cols));
    let (high, wide) = match numbers.below(4) {
        0 => (1, 1),
        1 => (1 + numbers.below(12), 1 + numbers.below(12)),
        2 => (1, 1 + numbers.below(90)),
        _ => (1 + numbers.below(90), 1),
    };
    let mut cells = Vec::new();
    for row in row..(row + high).min(rows) {
        cells.extend((col..(col + wide).min(cols)).map(|col| Cell::new(row, col)));
    }
    if numbers.below(4) == 0 {
        cells.extend((0..1 + numbers.below(30)).map(|_| Cell::new(numbers.below(rows), numbers.below(cols))));
    }
    cells
}

fn assert_same(is: &Field, should_be: &Field, what: &str) {
    let GridGeometry { rows, cols, .. } = *is.geometry();
    for row in 0..rows {
        for col in 0..cols {
            let cell = Cell::new(row, col);
            let (cost, anew) = (is.cost_to_go(cell), should_be.cost_to_go(cell));
            assert!(cost == anew, "{what}: {cell:?} costs {cost}, should cost {anew}");
            let (next, anew) = (is.next(cell), should_be.next(cell));
            assert!(next == anew, "{what}: {cell:?} leads to {next:?}, should lead to {anew:?}");
        }
    }
    assert!(is == should_be, "{what}");
}

#[test]
fn a_repaired_free_field_is_the_field_solved_anew() {
    let mut numbers = Numbers(1);
    for round in 0..60 {
        let (rows, cols) = (size(&mut numbers), size(&mut numbers));
        let density = [0, 10, 30, 45][numbers.below(4)];
        let mut free = grid(rows, cols, (0..rows * cols).map(|_| numbers.below(100) >= density).collect());
        let goals: Vec<Cell> =
            (0..1 + numbers.below(2)).map(|_| Cell::new(numbers.below(rows), numbers.below(cols))).collect();
        goals.iter().for_each(|goal| free.values[goal.row * cols + goal.col] = true);
        let options = PlanOptions { corner_cutting: numbers.below(2) == 1, ..PlanOptions::default() };
        let mut field = plan_free(&free, &goals, &options).unwrap();
        for change in 0..12 {
            let mut cells = some_cells(rows, cols, &mut numbers);
            cells.retain(|cell| !goals.contains(cell));
            let kind = numbers.below(4);
            let to: Vec<bool> =
                cells.iter().map(|_| [true, false, numbers.below(2) == 0][kind.min(2)]).collect();
            let update = field.update(&cells, NewCosts::Free(&to), f64::INFINITY).unwrap();
            assert!(!update.anew);
            for (cell, &to) in cells.iter().zip(&to) {
                free.values[cell.row * cols + cell.col] = to;
            }
            let anew = plan_free(&free, &goals, &options).unwrap();
            assert_same(&field, &anew, &format!("round {round}, change {change}, {rows} x {cols}"));
        }
    }
}

#[test]
fn a_repaired_cost_field_is_the_field_solved_anew() {
    let mut numbers = Numbers(2);
    for round in 0..50 {
        let (rows, cols) = (size(&mut numbers), size(&mut numbers));
        let cost = |numbers: &mut Numbers| match numbers.below(8) {
            0 => f64::INFINITY,
            1 => 0.01 * (1 + numbers.below(100)) as f64,
            _ => (1 + numbers.below(255)) as f64,
        };
        let mut costs = grid(rows, cols, (0..rows * cols).map(|_| cost(&mut numbers)).collect());
        let goals = vec![Cell::new(numbers.below(rows), numbers.below(cols))];
        costs.values[goals[0].row * cols + goals[0].col] = 3.0;
        let options = PlanOptions { corner_cutting: numbers.below(2) == 1, ..PlanOptions::default() };
        let single =
            |costs: &Grid<f64>| grid(rows, cols, costs.values.iter().map(|&cost| cost as f32).collect());
        let mut field = plan_costs_f32(single(&costs), &goals, &options).unwrap();
        let mut double = plan_costs_f64(&costs, &goals, &options).unwrap();
        for change in 0..8 {
            let mut cells = some_cells(rows, cols, &mut numbers);
            cells.retain(|cell| !goals.contains(cell) || numbers.below(2) == 0);
            let same = cost(&mut numbers);
            let kind = numbers.below(3);
            let to: Vec<f64> = cells
                .iter()
                .map(|cell| match kind {
                    0 => same,
                    1 => cost(&mut numbers),
                    _ => costs.values[cell.row * cols + cell.col] * [0.5, 2.0][numbers.below(2)],
                })
                .zip(&cells)
                .map(|(to, cell)| if goals.contains(cell) && to.is_infinite() { 1.0 } else { to })
                .collect();
            let to_single: Vec<f32> = to.iter().map(|&to| to as f32).collect();
            assert!(!field.update(&cells, NewCosts::F32(&to_single), f64::INFINITY).unwrap().anew);
            double.update(&cells, NewCosts::F64(&to), f64::INFINITY).unwrap();
            for (cell, &to) in cells.iter().zip(&to) {
                costs.values[cell.row * cols + cell.col] = to;
            }
            let what = format!("round {round}, change {change}, {rows} x {cols}");
            assert_same(&field, &plan_costs_f32(single(&costs), &goals, &options).unwrap(), &what);
            assert_same(&double, &plan_costs_f64(&costs, &goals, &options).unwrap(), &what);
        }
    }
}

#[test]
fn a_repair_that_takes_too_much_is_a_new_solution() {
    let free = grid(200, 200, vec![true; 200 * 200]);
    let mut field = plan_free(&free, &[Cell::new(0, 0)], &PlanOptions::default()).unwrap();
    let cells: Vec<Cell> = (1..200).map(|col| Cell::new(1, col)).collect();
    let update = field.update(&cells, NewCosts::Free(&[false; 199]), 0.1).unwrap();
    assert!(update.anew);
    let mut changed = free.clone();
    cells.iter().for_each(|cell| changed.values[cell.row * 200 + cell.col] = false);
    assert_same(&field, &plan_free(&changed, &[Cell::new(0, 0)], &PlanOptions::default()).unwrap(), "anew");
}

#[test]
fn a_change_that_is_refused_leaves_the_field_as_it_was() {
    let goals = [Cell::new(0, 0)];
    let costs = grid(1, 5, vec![1.0_f32; 5]);
    let mut field = plan_costs_f32(&costs, &goals, &PlanOptions::default()).unwrap();
    let before = field.clone();
    let cell = Cell::new(0, 2);
    for (bad, name) in [(f32::NAN, "NaN"), (-1.0, "negative"), (0.0, "zero"), (3e38, "dear")] {
        let cells = [Cell::new(0, 1), cell];
        let refused = field.update(&cells, NewCosts::F32(&[3e38, bad]), 0.1).unwrap_err();
        assert!(field == before, "{name}: {refused}");
    }
    let refused = field.update(&[cell], NewCosts::F32(&[1e-9]), 0.1);
    assert!(refused.is_ok(), "{refused:?}");
    assert!(matches!(
        field.update(&[goals[0]], NewCosts::F32(&[f32::INFINITY]), 0.1).unwrap_err(),
        PlanError::GoalBlocked { row: 0, col: 0 }
    ));
    assert!(matches!(
        field.update(&[Cell::new(1, 0)], NewCosts::F32(&[1.0]), 0.1).unwrap_err(),
        PlanError::CellOutsideGrid { row: 1, col: 0, rows: 1, cols: 5 }
    ));
    assert!(matches!(
        field.update(&[cell], NewCosts::Free(&[true]), 0.1).unwrap_err(),
        PlanError::FieldNotUpdatable { .. }
    ));
    assert!(matches!(
        field.update(&[cell], NewCosts::F32(&[]), 0.1).unwrap_err(),
        PlanError::UpdateLengthMismatch { cells: 1, costs: 0 }
    ));
}
