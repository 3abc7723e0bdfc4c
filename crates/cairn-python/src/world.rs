use cairn::geometry::Pose2;
use cairn::robot::Footprint;
use cairn::world::{CostLayer, CostmapConfig, Grid};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::convert::{grid_of, occupancy_grid, settings};
use crate::errors::to_python;

// ---- grids and cost maps -------------------------------------------------------------------------

fn to_numpy(py: Python<'_>, grid: Grid<f32>) -> PyResult<Bound<'_, PyArray2<f32>>> {
    let shape = [grid.geometry.rows, grid.geometry.cols];
    grid.values.into_pyarray(py).reshape(shape)
}

/// Distance from cell centres to the nearest occupied cell's centre, or surface [m], float32.
#[pyfunction]
#[pyo3(signature = (occupied, resolution_m, *, surface))]
fn distance_to_occupied<'py>(
    py: Python<'py>,
    occupied: PyReadonlyArray2<'py, bool>,
    resolution_m: f64,
    surface: bool,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let grid = grid_of(&occupied, resolution_m, Pose2::IDENTITY);
    let distances = py.detach(|| match surface {
        true => cairn::world::distance_to_surface(&grid),
        false => cairn::world::distance_to_occupied(&grid),
    });
    to_numpy(py, distances)
}

/// Cost per metre of every cell for a robot of this outline, float32, inf blocked.
#[pyfunction]
fn costmap<'py>(
    py: Python<'py>,
    occupancy: PyReadonlyArray2<'py, u8>,
    resolution_m: f64,
    footprint: (f64, f64),
    config: Bound<'py, PyAny>,
    ground: Option<PyReadonlyArray2<'py, f32>>,
    layers: Vec<(String, PyReadonlyArray2<'py, f32>, f64)>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let config: CostmapConfig = settings(Some(&config), "costmap")?;
    let occupancy = occupancy_grid(&occupancy, resolution_m, Pose2::IDENTITY);
    let footprint = Footprint { length_m: footprint.0, width_m: footprint.1 };
    let ground: Option<Vec<f32>> = ground.map(|values| values.as_array().iter().copied().collect());
    let values: Vec<(String, Vec<f32>, f64)> = layers
        .iter()
        .map(|(name, values, weight)| (name.clone(), values.as_array().iter().copied().collect(), *weight))
        .collect();
    let costs = py.detach(|| {
        let layers: Vec<CostLayer> =
            values.iter().map(|(name, values, weight)| CostLayer { name, values, weight: *weight }).collect();
        cairn::world::costmap_with_layers(&occupancy, &footprint, &config, ground.as_deref(), &layers)
    });
    to_numpy(py, costs.map_err(|e| to_python(&e))?)
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(distance_to_occupied, module)?)?;
    module.add_function(wrap_pyfunction!(costmap, module)?)
}
