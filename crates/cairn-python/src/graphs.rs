//! Planning on graphs, and the paper's layered planner.

use std::time::Instant;

use cairn::geometry::Pose2;
use cairn::plan::layered::{Task, Timed, Trace, Wait, play_out as play_out_of};
use cairn::plan::{
    self, Cost, Engine, Graph, GraphCost, LayeredOptions, PlanError, PlanOptions, Schedule, Steps,
};
use cairn::world::Grid;
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::grid_of;
use crate::errors::to_python;

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

/// (cost-to-go in the type it was planned in, next node or -1) of every node.
#[pyfunction]
fn plan_graph<'py>(
    py: Python<'py>,
    indptr: PyReadonlyArray1<'py, i64>,
    indices: PyReadonlyArray1<'py, i64>,
    costs: LinkCosts<'py>,
    goals: Vec<i64>,
    threads: Option<usize>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyArray1<i64>>)> {
    fn planned<'py, C: GraphCost + Element>(
        py: Python<'py>,
        graph: &Graph<C>,
        goals: Vec<i64>,
        threads: Option<usize>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyArray1<i64>>)> {
        let goals = nodes_of(goals, graph.nodes())?;
        let field = py.detach(|| plan::plan_graph(graph, &goals, threads)).map_err(|e| to_python(&e))?;
        let next = pointers(py, &field.next);
        Ok((field.cost_to_go.into_pyarray(py).into_any(), next))
    }
    match &graph_of(indptr, indices, costs)? {
        AnyGraph::U64(graph) => planned(py, graph, goals, threads),
        AnyGraph::F32(graph) => planned(py, graph, goals, threads),
        AnyGraph::F64(graph) => planned(py, graph, goals, threads),
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
    threads: Option<usize>,
    schedule: &str,
    record_trace: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let engine = match engine {
        "classical" => Engine::Classical,
        "phased" => Engine::Phased,
        "levelled" => Engine::Levelled,
        _ => Engine::InPlace, // the body has checked the name
    };
    let schedule = if schedule == "fronts" { Schedule::Fronts } else { Schedule::Wavefront };
    let options =
        LayeredOptions { engine, max_levels, early_stop, record_sequence, record_walks, threads, schedule };
    match &graph_of(indptr, indices, costs)? {
        AnyGraph::U64(graph) => layered(py, graph, goals, &options, record_trace),
        AnyGraph::F32(graph) => layered(py, graph, goals, &options, record_trace),
        AnyGraph::F64(graph) => layered(py, graph, goals, &options, record_trace),
    }
}

fn layered<'py, C: Cost + Element>(
    py: Python<'py>,
    graph: &Graph<C>,
    goals: Vec<i64>,
    options: &LayeredOptions,
    record_trace: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let goals = nodes_of(goals, graph.nodes())?;
    let began = Instant::now();
    let clock = || began.elapsed().as_nanos() as u64;
    let found = py.detach(|| {
        if record_trace {
            return plan::trace_layered(graph, &goals, options, &clock)
                .map(|(plan, trace)| (plan, Some(trace)));
        }
        plan::plan_layered(graph, &goals, options).map(|plan| (plan, None))
    });
    let (plan, trace) = found.map_err(|e| to_python(&e))?;
    let result = PyDict::new(py);
    result.set_item("trace", trace.map(|trace| trace_dict(py, &trace)).transpose()?)?;
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
    result.set_item("walks", walks.map_err(|e| PyValueError::new_err(e.to_string()))?)?;
    Ok(result)
}

/// The fields of `cairn.graphs.Trace` by name.
fn trace_dict<'py>(py: Python<'py>, trace: &Trace) -> PyResult<Bound<'py, PyDict>> {
    let of =
        |number: fn(&Timed) -> i64| trace.tasks.iter().map(number).collect::<Vec<i64>>().into_pyarray(py);
    let result = PyDict::new(py);
    result.set_item("level", of(|timed| i64::from(timed.task.level)))?;
    result.set_item("layer", of(|timed| i64::from(timed.task.layer)))?;
    result.set_item("thread", of(|timed| timed.thread as i64))?;
    result.set_item("begin_ns", of(|timed| timed.begin as i64))?;
    result.set_item("end_ns", of(|timed| timed.end as i64))?;
    let pairs = |waits: &Vec<Wait>| waits.iter().map(|wait| (wait.layer, wait.lag)).collect::<Vec<_>>();
    result.set_item("waits", trace.waits.iter().map(pairs).collect::<Vec<_>>())?;
    Ok(result)
}

type Times<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>);

/// Begin and end \[ns\] of the tasks of a trace when so many workers play a schedule out.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
fn play_out<'py>(
    py: Python<'py>,
    waits: Vec<Vec<(u32, u32)>>,
    schedule: &str,
    slope: usize,
    level: PyReadonlyArray1<'py, i64>,
    layer: PyReadonlyArray1<'py, i64>,
    duration_ns: PyReadonlyArray1<'py, i64>,
    workers: usize,
) -> PyResult<Times<'py>> {
    let wait = |(layer, lag)| Wait { layer, lag };
    let waits: Vec<Vec<Wait>> =
        waits.into_iter().map(|waits| waits.into_iter().map(wait).collect()).collect();
    let schedule = if schedule == "fronts" { Schedule::Fronts } else { Schedule::Wavefront };
    let tasks: Vec<(Task, u64)> =
        (level.as_slice()?.iter().zip(layer.as_slice()?).zip(duration_ns.as_slice()?))
            .map(|((&level, &layer), &took)| {
                (Task { level: level as u32, layer: layer as u32 }, took.max(0) as u64)
            })
            .collect();
    let times = py.detach(|| play_out_of(&waits, schedule, slope, &tasks, workers));
    let times = times.ok_or_else(|| PyValueError::new_err("not the tasks of whole levels, or no worker"))?;
    let side = |of: fn(&(u64, u64)) -> u64| times.iter().map(|time| of(time) as i64).collect::<Vec<_>>();
    Ok((side(|time| time.0).into_pyarray(py), side(|time| time.1).into_pyarray(py)))
}

type Csr<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyAny>);

fn csr<'py, C: Cost + Element>(py: Python<'py>, graph: Result<Graph<C>, PlanError>) -> PyResult<Csr<'py>> {
    let (indptr, indices, costs) = graph.map_err(|e| to_python(&e))?.to_csr();
    Ok((indptr.into_pyarray(py), indices.into_pyarray(py), costs.into_pyarray(py).into_any()))
}

fn cells<T: Element + Copy>(array: &PyReadonlyArray2<'_, T>) -> Grid<T> {
    grid_of(array, 1.0, Pose2::default())
}

/// The links of a bool grid as CSR arrays.
#[pyfunction]
fn graph_of_free<'py>(
    py: Python<'py>,
    free: PyReadonlyArray2<'py, bool>,
    corner_cutting: bool,
    paper_steps: bool,
) -> PyResult<Csr<'py>> {
    let steps = if paper_steps { Steps::Paper } else { Steps::Fine };
    let options = PlanOptions { corner_cutting, steps, ..PlanOptions::default() };
    let grid = cells(&free);
    csr(py, py.detach(|| plan::graph_of_free(&grid, &options)))
}

/// The links of a float32 cost grid as CSR arrays.
#[pyfunction]
fn graph_of_costs_f32<'py>(
    py: Python<'py>,
    costs: PyReadonlyArray2<'py, f32>,
    corner_cutting: bool,
) -> PyResult<Csr<'py>> {
    let options = PlanOptions { corner_cutting, ..PlanOptions::default() };
    let grid = cells(&costs);
    csr(py, py.detach(|| plan::graph_of_costs_f32(&grid, &options)))
}

/// The links of a float64 cost grid as CSR arrays.
#[pyfunction]
fn graph_of_costs_f64<'py>(
    py: Python<'py>,
    costs: PyReadonlyArray2<'py, f64>,
    corner_cutting: bool,
) -> PyResult<Csr<'py>> {
    let options = PlanOptions { corner_cutting, ..PlanOptions::default() };
    let grid = cells(&costs);
    csr(py, py.detach(|| plan::graph_of_costs_f64(&grid, &options)))
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(plan_graph, module)?)?;
    module.add_function(wrap_pyfunction!(plan_layered, module)?)?;
    module.add_function(wrap_pyfunction!(play_out, module)?)?;
    module.add_function(wrap_pyfunction!(graph_of_free, module)?)?;
    module.add_function(wrap_pyfunction!(graph_of_costs_f32, module)?)?;
    module.add_function(wrap_pyfunction!(graph_of_costs_f64, module)?)
}
