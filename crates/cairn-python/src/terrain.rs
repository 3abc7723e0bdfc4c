//! Planning over terrain and on moves that cost one thing there and another back.

use cairn::geometry::Pose2;
use cairn::plan::terrain::{
    AnyTerrainLinks, LinkCost, P3at, P3atEnergyLinks, P3atTimeLinks, TerrainModel, Tobler, ToblerLinks,
};
use cairn::plan::{Cost, DirectionWeights, Field, GridPlanner, PlanError, PlanOptions, terrain};
use cairn::world::{Cell, Grid, GridGeometry};
use numpy::ndarray::ArrayView3;
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::convert::{grid_of, triple};
use crate::errors::{InputError, to_python};
use crate::plan::{GridField, Means, cells_of, geometry_of, options_of, solved};
use crate::pool::with_planner;

pub fn model_of(model: &Bound<'_, PyAny>) -> PyResult<TerrainModel> {
    let model: TerrainModel = pythonize::depythonize(model).map_err(|error| {
        to_python(&InputError::SettingsInvalid {
            part: "terrain model".to_owned(),
            reason: error.to_string(),
        })
    })?;
    model.check().map_err(|e| to_python(&e))?;
    Ok(model)
}

fn grid(cells: &PyReadonlyArray2<'_, f32>, cell_size_m: f64) -> Grid<f32> {
    grid_of(cells, cell_size_m, Pose2::IDENTITY)
}

/// The field of an elevation grid, in the unit of the model.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
fn plan_terrain(
    py: Python<'_>,
    elevation: PyReadonlyArray2<'_, f32>,
    roughness: Option<PyReadonlyArray2<'_, f32>>,
    cell_size_m: f64,
    model: &Bound<'_, PyAny>,
    goals: Vec<(i64, i64)>,
    corner_cutting: bool,
    means: Means,
) -> PyResult<GridField> {
    let model = model_of(model)?;
    let geometry = geometry_of(&elevation, (cell_size_m, triple(Pose2::IDENTITY)));
    let goals = cells_of(goals, &geometry)?;
    let options = options_of(&geometry, corner_cutting, false, means)?;
    let roughness = roughness.map(|roughness| grid(&roughness, cell_size_m));
    let cells = elevation.as_array();
    solved(py.detach(|| {
        with_planner(|planner| {
            let elevation = match cells.as_slice() {
                Some(heights) => planner.copied_f32(geometry, heights),
                None => Grid::new(geometry, cells.iter().copied().collect()),
            };
            let field = planner.plan_terrain(&elevation, roughness.as_ref(), &model, &goals, &options);
            planner.keep_f32(elevation);
            field
        })
    }))
}

/// Cost of a way over terrain, a list of cells.
#[pyfunction]
fn terrain_path_cost(
    py: Python<'_>,
    elevation: PyReadonlyArray2<'_, f32>,
    roughness: Option<PyReadonlyArray2<'_, f32>>,
    cell_size_m: f64,
    model: &Bound<'_, PyAny>,
    path: Vec<(i64, i64)>,
    corner_cutting: bool,
) -> PyResult<f32> {
    let model = model_of(model)?;
    let elevation = grid(&elevation, cell_size_m);
    let roughness = roughness.map(|roughness| grid(&roughness, cell_size_m));
    let GridGeometry { rows, cols, .. } = elevation.geometry;
    let cells = path.into_iter().enumerate().map(|(index, (row, col))| {
        let outside = || to_python(&PlanError::PathOutsideGrid { index, row, col, rows, cols });
        let cell = usize::try_from(row).ok().zip(usize::try_from(col).ok());
        cell.map(|(row, col)| Cell::new(row, col)).ok_or_else(outside)
    });
    let path = cells.collect::<PyResult<Vec<Cell>>>()?;
    py.detach(|| terrain::terrain_path_cost(&elevation, roughness.as_ref(), &model, &path, corner_cutting))
        .map_err(|e| to_python(&e))
}

/// Roughness of every cell of an elevation grid.
#[pyfunction]
fn terrain_roughness<'py>(
    py: Python<'py>,
    elevation: PyReadonlyArray2<'py, f32>,
    cell_size_m: f64,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let elevation = grid(&elevation, cell_size_m);
    let roughness = py.detach(|| terrain::roughness_of(&elevation)).map_err(|e| to_python(&e))?;
    roughness.values.into_pyarray(py).reshape([elevation.geometry.rows, elevation.geometry.cols])
}

/// Bit k: the move with code k out of a cell is allowed.
#[pyfunction]
fn terrain_moves<'py>(
    py: Python<'py>,
    elevation: PyReadonlyArray2<'py, f32>,
    roughness: Option<PyReadonlyArray2<'py, f32>>,
    cell_size_m: f64,
    model: &Bound<'py, PyAny>,
    corner_cutting: bool,
) -> PyResult<Bound<'py, PyArray2<u8>>> {
    let model = model_of(model)?;
    let elevation = grid(&elevation, cell_size_m);
    let roughness = roughness.map(|roughness| grid(&roughness, cell_size_m));
    let links = AnyTerrainLinks::new(&elevation, roughness.as_ref(), &model, corner_cutting);
    let allowed = links.map_err(|e| to_python(&e))?.into_allowed();
    allowed.into_pyarray(py).reshape([elevation.geometry.rows, elevation.geometry.cols])
}

/// Costs of moves with these rises \[m\], all straight or all diagonal, between cells of one roughness.
#[pyfunction]
fn terrain_link_costs<'py>(
    py: Python<'py>,
    rises_m: PyReadonlyArray1<'py, f32>,
    roughness: f32,
    cell_size_m: f64,
    model: &Bound<'py, PyAny>,
    diagonal: bool,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    fn costs<M: LinkCost>(model: M, rises: &[f32], rough: f32, diagonal: bool) -> Vec<f32> {
        let cost = |&rise: &f32| match diagonal {
            true => model.link::<true>(rise, rough, rough),
            false => model.link::<false>(rise, rough, rough),
        };
        rises.iter().map(cost).collect()
    }
    let model = model_of(model)?;
    let rises = rises_m.as_slice()?;
    let found = match &model {
        TerrainModel::P3atEnergy(p) => {
            costs(P3atEnergyLinks::new(p, cell_size_m), rises, roughness, diagonal)
        }
        TerrainModel::P3atTime(p) => costs(P3atTimeLinks::new(p, cell_size_m), rises, roughness, diagonal),
        TerrainModel::Tobler(p) => costs(ToblerLinks::new(p, cell_size_m), rises, roughness, diagonal),
    };
    Ok(found.into_pyarray(py))
}

/// Parameters of a model with their defaults.
#[pyfunction]
fn terrain_defaults<'py>(py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyAny>> {
    let model = match kind {
        "tobler" => TerrainModel::Tobler(Tobler::default()),
        "p3at_time" => TerrainModel::P3atTime(P3at::default()),
        _ => TerrainModel::P3atEnergy(P3at::default()),
    };
    Ok(pythonize::pythonize(py, &model)?)
}

/// Refuses a model with unusable parameters.
#[pyfunction]
fn terrain_check(model: &Bound<'_, PyAny>) -> PyResult<()> {
    model_of(model).map(|_| ())
}

/// The planes of (8, rows, cols) weights, one after the other.
fn planes<T: Element + Copy>(weights: ArrayView3<'_, T>) -> (GridGeometry, Vec<T>) {
    let (_, rows, cols) = weights.dim();
    let geometry = GridGeometry { rows, cols, resolution_m: 1.0, world_from_grid: Pose2::IDENTITY };
    let planes = weights.as_slice().map_or_else(|| weights.iter().copied().collect(), <[T]>::to_vec);
    (geometry, planes)
}

type PlanWeights<T> =
    fn(&mut GridPlanner, &DirectionWeights<'_, T>, &[Cell], &PlanOptions) -> Result<Field, PlanError>;

/// The field of a grid with one cost per move.
fn plan_weights<T: Cost + Element>(
    py: Python<'_>,
    weights: &PyReadonlyArray3<'_, T>,
    goals: Vec<(i64, i64)>,
    means: Means,
    plan: PlanWeights<T>,
) -> PyResult<GridField> {
    let (geometry, planes) = planes(weights.as_array());
    let goals = cells_of(goals, &geometry)?;
    let options = options_of(&geometry, false, false, means)?;
    let weights = DirectionWeights::new(geometry, &planes).map_err(|e| to_python(&e))?;
    solved(py.detach(|| with_planner(|planner| plan(planner, &weights, &goals, &options))))
}

/// The field of a grid with one float32 cost per move.
#[pyfunction]
fn plan_weights_f32(
    py: Python<'_>,
    weights: PyReadonlyArray3<'_, f32>,
    goals: Vec<(i64, i64)>,
    means: Means,
) -> PyResult<GridField> {
    plan_weights(py, &weights, goals, means, GridPlanner::plan_weights_f32)
}

/// The field of a grid with one uint32 cost per move.
#[pyfunction]
fn plan_weights_u32(
    py: Python<'_>,
    weights: PyReadonlyArray3<'_, u32>,
    goals: Vec<(i64, i64)>,
    means: Means,
) -> PyResult<GridField> {
    plan_weights(py, &weights, goals, means, GridPlanner::plan_weights_u32)
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(plan_terrain, module)?)?;
    module.add_function(wrap_pyfunction!(terrain_path_cost, module)?)?;
    module.add_function(wrap_pyfunction!(terrain_roughness, module)?)?;
    module.add_function(wrap_pyfunction!(terrain_moves, module)?)?;
    module.add_function(wrap_pyfunction!(terrain_link_costs, module)?)?;
    module.add_function(wrap_pyfunction!(terrain_defaults, module)?)?;
    module.add_function(wrap_pyfunction!(terrain_check, module)?)?;
    module.add_function(wrap_pyfunction!(plan_weights_f32, module)?)?;
    module.add_function(wrap_pyfunction!(plan_weights_u32, module)?)
}
