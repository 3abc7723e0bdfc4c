use std::sync::Arc;

use cairn::geometry::Point2;
use cairn::plan::{self, Cost, Engine, Graph, LayeredOptions, PlanError, PlanOptions, Steps, Values};
use cairn::world::{Cell, Grid, GridGeometry};
use numpy::ndarray::ArrayView2;
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Triple, grid_of, points, pose_of};
use crate::errors::to_python;

/// Cost-to-go and next cell of every cell of a grid. `cairn.planning.Field` is its public face.
#[pyclass(frozen, module = "cairn._brain")]
pub struct GridField {
    pub inner: Arc<plan::Field>,
}

#[pymethods]
impl GridField {
    /// Native cost of one straight step through cells of unit cost.
    #[getter]
    fn unit(&self) -> f64 {
        self.inner.unit()
    }

    /// The goal cells.
    #[getter]
    fn goals(&self) -> Vec<(usize, usize)> {
        self.inner.goals().iter().map(|cell| (cell.row, cell.col)).collect()
    }

    /// The solver's own array, not copied, read-only.
    fn native<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyAny> {
        let field = this.get();
        match field.inner.native() {
            Values::U32(values) => field.lend(this, values).into_any(),
            Values::U64(values) => field.lend(this, values).into_any(),
            Values::F32(values) => field.lend(this, values).into_any(),
            Values::F64(values) => field.lend(this, values).into_any(),
        }
    }

    /// Codes 0..7 or -1, not copied, read-only.
    fn next_node<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray2<i8>> {
        this.get().lend(this, this.get().inner.next_codes())
    }

    /// Cost-to-go [cost x cells] times `scale`.
    fn cost_to_go<'py>(&self, py: Python<'py>, scale: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let values = py.detach(|| self.inner.costs_to_go(scale));
        let geometry = self.inner.geometry();
        values.into_pyarray(py).reshape([geometry.rows, geometry.cols])
    }

    /// The cells from `start` to a goal, or None.
    fn path<'py>(&self, py: Python<'py>, start: (i64, i64)) -> PyResult<Option<Bound<'py, PyArray2<i64>>>> {
        let GridGeometry { rows, cols, .. } = *self.inner.geometry();
        let outside = || PlanError::StartOutsideGrid { row: start.0, col: start.1, rows, cols };
        let cell = cell_inside(start, rows, cols).ok_or_else(|| to_python(&outside()))?;
        let Some(cells) = py.detach(|| self.inner.path(cell)) else { return Ok(None) };
        let flat: Vec<i64> = cells.iter().flat_map(|cell| [cell.row as i64, cell.col as i64]).collect();
        Ok(Some(flat.into_pyarray(py).reshape([cells.len(), 2])?))
    }

    /// The way from a point of the world to a goal point, or None.
    fn path_in_world<'py>(
        &self,
        py: Python<'py>,
        start: (f64, f64),
        goals: Vec<(f64, f64)>,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let goals: Vec<Point2> = goals.into_iter().map(|(x, y)| Point2::new(x, y)).collect();
        let path = py.detach(|| self.inner.path_in_world(Point2::new(start.0, start.1), &goals));
        path.map_err(|e| to_python(&e))?.map(|path| points(py, &path)).transpose()
    }
}

impl GridField {
    #[allow(unsafe_code)]
    fn lend<'py, T: Element>(&self, owner: &Bound<'py, Self>, values: &[T]) -> Bound<'py, PyArray2<T>> {
        let geometry = self.inner.geometry();
        let view =
            ArrayView2::from_shape((geometry.rows, geometry.cols), values).expect("one value per cell");
        // SAFETY: `values` is memory of `inner`, which `owner` keeps alive and, being frozen, never changes;
        // the array is made read-only before anyone sees it.
        let array = unsafe { PyArray2::borrow_from_array(&view, owner.clone().into_any()) };
        array.readwrite().make_nonwriteable();
        array
    }
}

fn cell_inside((row, col): (i64, i64), rows: usize, cols: usize) -> Option<Cell> {
    let row = usize::try_from(row).ok().filter(|&row| row < rows)?;
    let col = usize::try_from(col).ok().filter(|&col| col < cols)?;
    Some(Cell::new(row, col))
}

/// (resolution [m], (x, y, yaw)) of a grid in the world.
type Place = (f64, Triple);

const CELLS: Place = (1.0, (0.0, 0.0, 0.0));

fn laid<T: Element + Copy>(cells: &PyReadonlyArray2<'_, T>, (resolution_m, origin): Place) -> Grid<T> {
    grid_of(cells, resolution_m, pose_of(origin))
}

fn cells_of(goals: Vec<(i64, i64)>, geometry: &GridGeometry) -> PyResult<Vec<Cell>> {
    let GridGeometry { rows, cols, .. } = *geometry;
    let cell = |(row, col)| {
        let outside = || to_python(&PlanError::GoalOutsideGrid { row, col, rows, cols });
        cell_inside((row, col), rows, cols).ok_or_else(outside)
    };
    if geometry.is_empty() { Ok(vec![Cell::new(0, 0)]) } else { goals.into_iter().map(cell).collect() }
}

fn options_of(corner_cutting: bool, paper_steps: bool, threads: Option<usize>) -> PlanOptions {
    PlanOptions { corner_cutting, steps: if paper_steps { Steps::Paper } else { Steps::Fine }, threads }
}

fn solved(result: Result<plan::Field, PlanError>) -> PyResult<GridField> {
    result.map(|field| GridField { inner: Arc::new(field) }).map_err(|e| to_python(&e))
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
    threads: Option<usize>,
) -> PyResult<GridField> {
    let grid = laid(&free, place);
    let goals = cells_of(goals, &grid.geometry)?;
    let options = options_of(corner_cutting, paper_steps, threads);
    solved(py.detach(|| plan::plan_free(&grid, &goals, &options)))
}

/// Plans on a float32 grid of costs.
#[pyfunction]
fn plan_costs_f32(
    py: Python<'_>,
    costs: PyReadonlyArray2<'_, f32>,
    goals: Vec<(i64, i64)>,
    place: Place,
    corner_cutting: bool,
    threads: Option<usize>,
) -> PyResult<GridField> {
    let grid = laid(&costs, place);
    let goals = cells_of(goals, &grid.geometry)?;
    let options = options_of(corner_cutting, false, threads);
    solved(py.detach(|| plan::plan_costs_f32(&grid, &goals, &options)))
}

/// Plans on a float64 grid of costs.
#[pyfunction]
fn plan_costs_f64(
    py: Python<'_>,
    costs: PyReadonlyArray2<'_, f64>,
    goals: Vec<(i64, i64)>,
    place: Place,
    corner_cutting: bool,
    threads: Option<usize>,
) -> PyResult<GridField> {
    let grid = laid(&costs, place);
    let goals = cells_of(goals, &grid.geometry)?;
    let options = options_of(corner_cutting, false, threads);
    solved(py.detach(|| plan::plan_costs_f64(&grid, &goals, &options)))
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

/// Costs of links, in the number type they came in.
#[derive(FromPyObject)]
enum LinkCosts<'py> {
    I64(PyReadonlyArray1<'py, i64>),
    U64(PyReadonlyArray1<'py, u64>),
    F32(PyReadonlyArray1<'py, f32>),
    F64(PyReadonlyArray1<'py, f64>),
}

/// A graph in the number type it is planned in.
enum AnyGraph {
    U64(Graph<u64>),
    F32(Graph<f32>),
    F64(Graph<f64>),
}

fn graph_of(
    indptr: PyReadonlyArray1<'_, i64>,
    indices: PyReadonlyArray1<'_, i64>,
    costs: LinkCosts<'_>,
) -> PyResult<AnyGraph> {
    let (indptr, indices) = (indptr.as_slice()?, indices.as_slice()?);
    let graph = match &costs {
        LinkCosts::I64(costs) => {
            Graph::from_signed_csr(indptr, indices, costs.as_slice()?).map(AnyGraph::U64)
        }
        LinkCosts::U64(costs) => Graph::from_csr(indptr, indices, costs.as_slice()?).map(AnyGraph::U64),
        LinkCosts::F32(costs) => Graph::from_csr(indptr, indices, costs.as_slice()?).map(AnyGraph::F32),
        LinkCosts::F64(costs) => Graph::from_csr(indptr, indices, costs.as_slice()?).map(AnyGraph::F64),
    };
    graph.map_err(|e| to_python(&e))
}

fn nodes_of(goals: Vec<i64>, nodes: usize) -> PyResult<Vec<usize>> {
    let node = |node| usize::try_from(node).map_err(|_| to_python(&PlanError::GoalNotANode { node, nodes }));
    goals.into_iter().map(node).collect()
}

fn pointers<'py>(py: Python<'py>, next: &[Option<u32>]) -> Bound<'py, PyArray1<i64>> {
    next.iter().map(|next| next.map_or(-1, i64::from)).collect::<Vec<_>>().into_pyarray(py)
}

/// (cost-to-go in the type it was planned in, next node or -1) of every node, by Dijkstra's algorithm.
#[pyfunction]
fn plan_graph<'py>(
    py: Python<'py>,
    indptr: PyReadonlyArray1<'py, i64>,
    indices: PyReadonlyArray1<'py, i64>,
    costs: LinkCosts<'py>,
    goals: Vec<i64>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyArray1<i64>>)> {
    fn planned<'py, C: Cost + Element>(
        py: Python<'py>,
        graph: &Graph<C>,
        goals: Vec<i64>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyArray1<i64>>)> {
        let goals = nodes_of(goals, graph.nodes())?;
        let field = py.detach(|| plan::plan_graph(graph, &goals)).map_err(|e| to_python(&e))?;
        let next = pointers(py, &field.next);
        Ok((field.cost_to_go.into_pyarray(py).into_any(), next))
    }
    match &graph_of(indptr, indices, costs)? {
        AnyGraph::U64(graph) => planned(py, graph, goals),
        AnyGraph::F32(graph) => planned(py, graph, goals),
        AnyGraph::F64(graph) => planned(py, graph, goals),
    }
}

/// The layered planner of the paper; the fields of `cairn.planning.LayeredResult` by name.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
fn plan_layered<'py>(
    py: Python<'py>,
    indptr: PyReadonlyArray1<'py, i64>,
    indices: PyReadonlyArray1<'py, i64>,
    costs: LinkCosts<'py>,
    goals: Vec<i64>,
    engine: &str,
    max_levels: Option<usize>,
    early_stop: bool,
    record_sequence: bool,
    record_walks: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let engine = match engine {
        "classical" => Engine::Classical,
        "phased" => Engine::Phased,
        "levelled" => Engine::Levelled,
        _ => Engine::InPlace, // the body has checked the name
    };
    let options = LayeredOptions { engine, max_levels, early_stop, record_sequence, record_walks };
    match &graph_of(indptr, indices, costs)? {
        AnyGraph::U64(graph) => layered(py, graph, goals, &options),
        AnyGraph::F32(graph) => layered(py, graph, goals, &options),
        AnyGraph::F64(graph) => layered(py, graph, goals, &options),
    }
}

fn layered<'py, C: Cost + Element>(
    py: Python<'py>,
    graph: &Graph<C>,
    goals: Vec<i64>,
    options: &LayeredOptions,
) -> PyResult<Bound<'py, PyDict>> {
    let goals = nodes_of(goals, graph.nodes())?;
    let plan = py.detach(|| plan::plan_layered(graph, &goals, options)).map_err(|e| to_python(&e))?;
    let result = PyDict::new(py);
    result.set_item("next_node", pointers(py, &plan.field.next))?;
    result.set_item("native", plan.field.cost_to_go.into_pyarray(py))?;
    result.set_item("layer", pointers(py, &plan.layer))?;
    result.set_item("layers", plan.layers)?;
    result.set_item("widest_layer", plan.widest_layer)?;
    result.set_item("greatest_rise", plan.greatest_rise)?;
    result.set_item("levels", plan.levels)?;
    result.set_item("max_levels", plan.max_levels)?;
    result.set_item("converged", plan.converged)?;
    result.set_item("operations", plan.operations)?;
    result.set_item("operations_worst_case", plan.operations_worst_case)?;
    result.set_item("operations_equation_4", plan.equation_4)?;
    result.set_item("operations_worst_case_equation_4", plan.equation_4_worst_case)?;
    let sequence = plan.sequence.map(|operations| {
        let triple = |op: &plan::layered::Operation| (op.level, op.layer, op.next_layer);
        operations.iter().map(triple).collect::<Vec<_>>()
    });
    result.set_item("sequence", sequence)?;
    let walks = plan.walks.map(|levels| PyArray2::from_vec2(py, &levels)).transpose();
    result.set_item("walks", walks.map_err(|e| pyo3::exceptions::PyValueError::new_err(e.to_string()))?)?;
    Ok(result)
}

type Csr<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyAny>);

fn csr<'py, C: Cost + Element>(py: Python<'py>, graph: Result<Graph<C>, PlanError>) -> PyResult<Csr<'py>> {
    let (indptr, indices, costs) = graph.map_err(|e| to_python(&e))?.to_csr();
    Ok((indptr.into_pyarray(py), indices.into_pyarray(py), costs.into_pyarray(py).into_any()))
}

/// The links of a bool grid as CSR arrays.
#[pyfunction]
fn graph_of_free<'py>(
    py: Python<'py>,
    free: PyReadonlyArray2<'py, bool>,
    corner_cutting: bool,
    paper_steps: bool,
) -> PyResult<Csr<'py>> {
    let (grid, options) = (laid(&free, CELLS), options_of(corner_cutting, paper_steps, None));
    csr(py, py.detach(|| plan::graph_of_free(&grid, &options)))
}

/// The links of a float32 cost grid as CSR arrays.
#[pyfunction]
fn graph_of_costs_f32<'py>(
    py: Python<'py>,
    costs: PyReadonlyArray2<'py, f32>,
    corner_cutting: bool,
) -> PyResult<Csr<'py>> {
    let (grid, options) = (laid(&costs, CELLS), options_of(corner_cutting, false, None));
    csr(py, py.detach(|| plan::graph_of_costs_f32(&grid, &options)))
}

/// The links of a float64 cost grid as CSR arrays.
#[pyfunction]
fn graph_of_costs_f64<'py>(
    py: Python<'py>,
    costs: PyReadonlyArray2<'py, f64>,
    corner_cutting: bool,
) -> PyResult<Csr<'py>> {
    let (grid, options) = (laid(&costs, CELLS), options_of(corner_cutting, false, None));
    csr(py, py.detach(|| plan::graph_of_costs_f64(&grid, &options)))
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<GridField>()?;
    module.add_function(wrap_pyfunction!(plan_free, module)?)?;
    module.add_function(wrap_pyfunction!(plan_costs_f32, module)?)?;
    module.add_function(wrap_pyfunction!(plan_costs_f64, module)?)?;
    module.add_function(wrap_pyfunction!(goal_cells, module)?)?;
    module.add_function(wrap_pyfunction!(plan_graph, module)?)?;
    module.add_function(wrap_pyfunction!(plan_layered, module)?)?;
    module.add_function(wrap_pyfunction!(graph_of_free, module)?)?;
    module.add_function(wrap_pyfunction!(graph_of_costs_f32, module)?)?;
    module.add_function(wrap_pyfunction!(graph_of_costs_f64, module)?)
}
