use std::sync::{Arc, PoisonError, RwLock};

use cairn::geometry::Point2;
use cairn::plan::{self, GridPlanner, NewCosts, PlanError, PlanOptions, Simd, Steps, Values};
use cairn::world::{Cell, Grid, GridGeometry};
use numpy::ndarray::ArrayView2;
use numpy::{Element, IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::convert::{Triple, points, pose_of};
use crate::errors::to_python;
use crate::pool::{take_back, with_planner};

/// Cost-to-go and next cell of every cell of a grid. `cairn.planning.Field` is its public face.
#[pyclass(frozen, module = "cairn._brain")]
pub struct GridField {
    /// There until it is dropped.
    field: RwLock<Option<Arc<plan::Field>>>,
}

/// Keeps the memory of arrays alive that were handed out: an update leaves it alone.
#[pyclass(frozen, module = "cairn._brain")]
struct FieldMemory(Option<Arc<plan::Field>>);

impl Drop for FieldMemory {
    fn drop(&mut self) {
        self.0.take().into_iter().for_each(take_back);
    }
}

impl Drop for GridField {
    fn drop(&mut self) {
        let field = self.field.get_mut().unwrap_or_else(PoisonError::into_inner);
        field.take().into_iter().for_each(take_back);
    }
}

#[pymethods]
impl GridField {
    /// Native cost of one straight step through cells of unit cost.
    #[getter]
    fn unit(&self) -> f64 {
        self.now().unit()
    }

    /// (rows, cols).
    #[getter]
    fn shape(&self) -> (usize, usize) {
        let geometry = *self.now().geometry();
        (geometry.rows, geometry.cols)
    }

    /// The goal cells.
    #[getter]
    fn goals(&self) -> Vec<(usize, usize)> {
        self.now().goals().iter().map(|cell| (cell.row, cell.col)).collect()
    }

    /// The solver's own array, not copied, read-only.
    fn native<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let field = self.now();
        Ok(match field.native() {
            Values::U32(values) => lend(py, &field, values)?.into_any(),
            Values::U64(values) => lend(py, &field, values)?.into_any(),
            Values::F32(values) => lend(py, &field, values)?.into_any(),
            Values::F64(values) => lend(py, &field, values)?.into_any(),
        })
    }

    /// Codes 0..7 or -1, not copied, read-only.
    fn next_node<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i8>>> {
        let field = self.now();
        lend(py, &field, field.next_codes())
    }

    /// Cost-to-go [cost x cells] times `scale`.
    fn cost_to_go<'py>(&self, py: Python<'py>, scale: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let field = self.now();
        let values = py.detach(|| field.costs_to_go(scale));
        values.into_pyarray(py).reshape([field.geometry().rows, field.geometry().cols])
    }

    /// The cells from `start` to a goal, or None.
    fn path<'py>(&self, py: Python<'py>, start: (i64, i64)) -> PyResult<Option<Bound<'py, PyArray2<i64>>>> {
        let field = self.now();
        let cell = start_in(&field, start)?;
        let cells = py.detach(|| field.path(cell));
        cells.map(|cells| cells_as_rows(py, &cells)).transpose()
    }

    /// The way from a point of the world to a goal point, or None.
    fn path_in_world<'py>(
        &self,
        py: Python<'py>,
        start: (f64, f64),
        goals: Vec<(f64, f64)>,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let field = self.now();
        let goals: Vec<Point2> = goals.into_iter().map(|(x, y)| Point2::new(x, y)).collect();
        let path = py.detach(|| field.path_in_world(Point2::new(start.0, start.1), &goals));
        path.map_err(|e| to_python(&e))?.map(|path| points(py, &path)).transpose()
    }

    /// Whether a straight segment has a cost in this field, so that there are any-angle paths.
    #[getter]
    fn prices_segments(&self) -> bool {
        self.now().crossed().is_some()
    }

    /// The cells that the way from `start` turns at when it goes straight wherever that is no dearer; None
    /// too if segments have no price.
    fn any_angle_path<'py>(
        &self,
        py: Python<'py>,
        start: (i64, i64),
    ) -> PyResult<Option<Bound<'py, PyArray2<i64>>>> {
        let field = self.now();
        let cell = start_in(&field, start)?;
        let Some((crossed, corner_cutting)) = field.crossed() else { return Ok(None) };
        let cells = py.detach(|| field.any_angle_path(cell, crossed, corner_cutting));
        cells.map(|cells| cells_as_rows(py, &cells)).transpose()
    }

    /// The points that the way turns at when it goes straight wherever that is no dearer; None too if
    /// segments have no price.
    fn any_angle_path_in_world<'py>(
        &self,
        py: Python<'py>,
        start: (f64, f64),
        goals: Vec<(f64, f64)>,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let field = self.now();
        let goals: Vec<Point2> = goals.into_iter().map(|(x, y)| Point2::new(x, y)).collect();
        let start = Point2::new(start.0, start.1);
        let Some((crossed, corner_cutting)) = field.crossed() else { return Ok(None) };
        let path = py.detach(|| field.any_angle_path_in_world(start, &goals, crossed, corner_cutting));
        path.map_err(|e| to_python(&e))?.map(|path| points(py, &path)).transpose()
    }

    /// Changes costs of cells; (solved anew, cells changed, cells forgotten, visits to tiles).
    fn update(
        &self,
        py: Python<'_>,
        cells: PyReadonlyArray2<'_, i64>,
        costs: NewCells<'_>,
        give_up: f64,
    ) -> PyResult<(bool, usize, usize, usize)> {
        let GridGeometry { rows, cols, .. } = *self.now().geometry();
        let cells = cells.as_array();
        let cells = cells.rows().into_iter().map(|cell| {
            let (row, col) = (cell[0], cell[1]);
            let outside = || to_python(&PlanError::CellOutsideGrid { row, col, rows, cols });
            cell_inside((row, col), rows, cols).ok_or_else(outside)
        });
        let cells: Vec<Cell> = cells.collect::<PyResult<_>>()?;
        let costs = match &costs {
            NewCells::Free(free) => NewCosts::Free(free.as_slice()?),
            NewCells::F32(costs) => NewCosts::F32(costs.as_slice()?),
            NewCells::F64(costs) => NewCosts::F64(costs.as_slice()?),
        };
        let update = py.detach(|| {
            let mut field = self.field.write().unwrap_or_else(PoisonError::into_inner);
            let field = field.as_mut().expect("a field until it is dropped");
            Arc::make_mut(field).update(&cells, costs, give_up)
        });
        let done = update.map_err(|e| to_python(&e))?;
        Ok((done.anew, done.changed, done.forgotten, done.visits))
    }
}

impl GridField {
    /// The field as it is now; updates to come do not change it.
    pub fn now(&self) -> Arc<plan::Field> {
        let field = self.field.read().unwrap_or_else(PoisonError::into_inner);
        field.clone().expect("a field until it is dropped")
    }
}

/// New costs of cells.
#[derive(FromPyObject)]
enum NewCells<'py> {
    Free(PyReadonlyArray1<'py, bool>),
    F32(PyReadonlyArray1<'py, f32>),
    F64(PyReadonlyArray1<'py, f64>),
}

fn cells_as_rows<'py>(py: Python<'py>, cells: &[Cell]) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let flat: Vec<i64> = cells.iter().flat_map(|cell| [cell.row as i64, cell.col as i64]).collect();
    flat.into_pyarray(py).reshape([cells.len(), 2])
}

fn start_in(field: &plan::Field, start: (i64, i64)) -> PyResult<Cell> {
    let GridGeometry { rows, cols, .. } = *field.geometry();
    let outside = || PlanError::StartOutsideGrid { row: start.0, col: start.1, rows, cols };
    cell_inside(start, rows, cols).ok_or_else(|| to_python(&outside()))
}

#[allow(unsafe_code)]
fn lend<'py, T: Element>(
    py: Python<'py>,
    field: &Arc<plan::Field>,
    values: &[T],
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let geometry = field.geometry();
    let view = ArrayView2::from_shape((geometry.rows, geometry.cols), values).expect("one value per cell");
    let owner = Bound::new(py, FieldMemory(Some(Arc::clone(field))))?;
    // SAFETY: `values` is memory of `field`, which `owner` keeps alive; shared, it never changes; the array
    // is made read-only before anyone sees it.
    let array = unsafe { PyArray2::borrow_from_array(&view, owner.into_any()) };
    array.readwrite().make_nonwriteable();
    Ok(array)
}

fn cell_inside((row, col): (i64, i64), rows: usize, cols: usize) -> Option<Cell> {
    let row = usize::try_from(row).ok().filter(|&row| row < rows)?;
    let col = usize::try_from(col).ok().filter(|&col| col < cols)?;
    Some(Cell::new(row, col))
}

/// (resolution [m], (x, y, yaw)) of a grid in the world.
pub type Place = (f64, Triple);

pub fn geometry_of<T: Element>(
    cells: &PyReadonlyArray2<'_, T>,
    (resolution_m, origin): Place,
) -> GridGeometry {
    let [rows, cols] = [cells.as_array().nrows(), cells.as_array().ncols()];
    GridGeometry { rows, cols, resolution_m, world_from_grid: pose_of(origin) }
}

pub fn cells_of(goals: Vec<(i64, i64)>, geometry: &GridGeometry) -> PyResult<Vec<Cell>> {
    let GridGeometry { rows, cols, .. } = *geometry;
    let cell = |(row, col)| {
        let outside = || to_python(&PlanError::GoalOutsideGrid { row, col, rows, cols });
        cell_inside((row, col), rows, cols).ok_or_else(outside)
    };
    if geometry.is_empty() { Ok(vec![Cell::new(0, 0)]) } else { goals.into_iter().map(cell).collect() }
}

/// (most threads, instruction set, the one start wanted), each None for the solver's choice.
pub type Means = (Option<usize>, Option<String>, Option<(i64, i64)>);

/// Options of a grid's planner; a start outside the grid is refused.
pub fn options_of(
    geometry: &GridGeometry,
    corner_cutting: bool,
    paper_steps: bool,
    (threads, simd, start): Means,
) -> PyResult<PlanOptions> {
    let simd = simd.map(|name| match name.as_str() {
        "avx512" => Simd::Avx512,
        "avx2" => Simd::Avx2,
        _ => Simd::Portable, // the body has checked the name
    });
    let GridGeometry { rows, cols, .. } = *geometry;
    let start = start.map(|(row, col)| {
        let outside = || to_python(&PlanError::StartOutsideGrid { row, col, rows, cols });
        cell_inside((row, col), rows, cols).ok_or_else(outside)
    });
    let steps = if paper_steps { Steps::Paper } else { Steps::Fine };
    Ok(PlanOptions { corner_cutting, steps, threads, simd, start: start.transpose()? })
}

pub fn solved(result: Result<plan::Field, PlanError>) -> PyResult<GridField> {
    result.map(|field| GridField { field: RwLock::new(Some(Arc::new(field))) }).map_err(|e| to_python(&e))
}

/// Plans on a bool grid, True free, in integer steps.
#[pyfunction]
fn plan_free(
    py: Python<'_>,
    free: PyReadonlyArray2<'_, bool>,
    goals: Vec<(i64, i64)>,
    place: Place,
    corner_cutting: bool,
    paper_steps: bool,
    means: Means,
) -> PyResult<GridField> {
    let geometry = geometry_of(&free, place);
    let goals = cells_of(goals, &geometry)?;
    let options = options_of(&geometry, corner_cutting, paper_steps, means)?;
    let rows = free.as_array();
    solved(py.detach(|| {
        with_planner(|planner| match rows.as_slice() {
            Some(cells) => planner.plan_free_cells(geometry, cells, &goals, &options),
            None => planner.plan_free(&Grid::new(geometry, rows.iter().copied().collect()), &goals, &options),
        })
    }))
}

type PlanCosts<T> = fn(&mut GridPlanner, Grid<T>, &[Cell], &PlanOptions) -> Result<plan::Field, PlanError>;

/// Plans on a grid of costs, copied into the planner's own memory where it can be.
fn plan_costs<T: Element + Copy + Sync>(
    py: Python<'_>,
    costs: &PyReadonlyArray2<'_, T>,
    goals: Vec<(i64, i64)>,
    place: Place,
    options: (bool, Means),
    copied: fn(&mut GridPlanner, GridGeometry, &[T]) -> Grid<T>,
    plan: PlanCosts<T>,
) -> PyResult<GridField> {
    let geometry = geometry_of(costs, place);
    let goals = cells_of(goals, &geometry)?;
    let (corner_cutting, means) = options;
    let options = options_of(&geometry, corner_cutting, false, means)?;
    let rows = costs.as_array();
    solved(py.detach(|| {
        with_planner(|planner| {
            let grid = match rows.as_slice() {
                Some(cells) => copied(planner, geometry, cells),
                None => Grid::new(geometry, rows.iter().copied().collect()),
            };
            plan(planner, grid, &goals, &options)
        })
    }))
}

/// Plans on a float32 grid of costs.
#[pyfunction]
fn plan_costs_f32(
    py: Python<'_>,
    costs: PyReadonlyArray2<'_, f32>,
    goals: Vec<(i64, i64)>,
    place: Place,
    corner_cutting: bool,
    means: Means,
) -> PyResult<GridField> {
    let (copied, plan) = (GridPlanner::copied_f32, GridPlanner::plan_costs_f32);
    plan_costs(py, &costs, goals, place, (corner_cutting, means), copied, plan)
}

/// Plans on a float64 grid of costs.
#[pyfunction]
fn plan_costs_f64(
    py: Python<'_>,
    costs: PyReadonlyArray2<'_, f64>,
    goals: Vec<(i64, i64)>,
    place: Place,
    corner_cutting: bool,
    means: Means,
) -> PyResult<GridField> {
    let (copied, plan) = (GridPlanner::copied_f64, GridPlanner::plan_costs_f64);
    plan_costs(py, &costs, goals, place, (corner_cutting, means), copied, plan)
}

/// The instruction sets that the solver has code for and this processor has, the widest first.
#[pyfunction]
fn simd_levels() -> Vec<String> {
    let there = Simd::ALL.into_iter().filter(|level| level.is_available());
    there.map(|level| level.to_string()).collect()
}

/// Row and column of the cells that hold points of the world; refuses points off the map.
#[pyfunction]
fn goal_cells(
    points: Vec<(f64, f64)>,
    rows: usize,
    cols: usize,
    place: Place,
) -> PyResult<Vec<(usize, usize)>> {
    let (resolution_m, origin) = place;
    let world_from_grid = pose_of(origin);
    let geometry = GridGeometry { rows, cols, resolution_m, world_from_grid };
    let cell = |(x_m, y_m)| match geometry.cell_at(Point2::new(x_m, y_m)) {
        Some(cell) => Ok((cell.row, cell.col)),
        None => Err(to_python(&PlanError::GoalOutsideMap { x_m, y_m, rows, cols, resolution_m })),
    };
    points.into_iter().map(cell).collect()
}

/// Row and column of the cell that holds a point of the world; refuses a point off the map.
#[pyfunction]
fn start_cell(point: (f64, f64), rows: usize, cols: usize, place: Place) -> PyResult<(usize, usize)> {
    let ((x_m, y_m), (resolution_m, origin)) = (point, place);
    let geometry = GridGeometry { rows, cols, resolution_m, world_from_grid: pose_of(origin) };
    match geometry.cell_at(Point2::new(x_m, y_m)) {
        Some(cell) => Ok((cell.row, cell.col)),
        None => Err(to_python(&PlanError::StartOutsideMap { x_m, y_m, rows, cols, resolution_m })),
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<GridField>()?;
    module.add_function(wrap_pyfunction!(plan_free, module)?)?;
    module.add_function(wrap_pyfunction!(plan_costs_f32, module)?)?;
    module.add_function(wrap_pyfunction!(plan_costs_f64, module)?)?;
    module.add_function(wrap_pyfunction!(simd_levels, module)?)?;
    module.add_function(wrap_pyfunction!(start_cell, module)?)?;
    module.add_function(wrap_pyfunction!(goal_cells, module)?)
}
