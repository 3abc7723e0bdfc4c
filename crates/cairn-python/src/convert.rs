//! Conversions that several rooms need.

use cairn::geometry::{Point2, Pose2, wrap_angle};
use cairn::world::{Grid, GridGeometry, Occupancy, OccupancyGrid};
use numpy::{Element, IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use serde::de::DeserializeOwned;

use crate::errors::{InputError, to_python};

/// (x, y, heading) \[m, m, rad\].
pub type Triple = (f64, f64, f64);
/// Cells (rows, cols), resolution \[m\], origin (x, y, yaw).
pub type WorldParts<'py> = (PyReadonlyArray2<'py, u8>, f64, Triple);

pub fn pose_of((x, y, heading): Triple) -> Pose2 {
    // Not Pose2::new: a heading that is no number must arrive as it is, to be refused by name.
    Pose2 { x, y, heading: wrap_angle(heading) }
}

pub fn triple(pose: Pose2) -> Triple {
    (pose.x, pose.y, pose.heading)
}

/// (n, 2) of points \[m\].
pub fn points<'py>(py: Python<'py>, points: &[Point2]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flat: Vec<f64> = points.iter().flat_map(|p| [p.x, p.y]).collect();
    flat.into_pyarray(py).reshape([points.len(), 2])
}

/// A grid of an array's cells, laid into the world.
pub fn grid_of<T: Element + Copy>(
    cells: &PyReadonlyArray2<'_, T>,
    resolution_m: f64,
    world_from_grid: Pose2,
) -> Grid<T> {
    let cells = cells.as_array();
    let geometry = GridGeometry { rows: cells.nrows(), cols: cells.ncols(), resolution_m, world_from_grid };
    let values = cells.as_slice().map_or_else(|| cells.iter().copied().collect(), <[T]>::to_vec);
    Grid::new(geometry, values)
}

/// An occupancy grid from uint8 cells: 0 free, 1 occupied, anything else unknown.
pub fn occupancy_grid(
    cells: &PyReadonlyArray2<'_, u8>,
    resolution_m: f64,
    world_from_grid: Pose2,
) -> OccupancyGrid {
    let Grid { geometry, values } = grid_of(cells, resolution_m, world_from_grid);
    let known = |cell| match cell {
        0 => Occupancy::Free,
        1 => Occupancy::Occupied,
        _ => Occupancy::Unknown,
    };
    Grid::new(geometry, values.into_iter().map(known).collect())
}

/// The settings given, over the defaults.
pub fn settings<T: DeserializeOwned + Default>(given: Option<&Bound<'_, PyAny>>, part: &str) -> PyResult<T> {
    given.map_or_else(
        || Ok(T::default()),
        |given| {
            pythonize::depythonize(given).map_err(|error| {
                to_python(&InputError::SettingsInvalid { part: part.to_owned(), reason: error.to_string() })
            })
        },
    )
}

/// A controller or a fuzzy system from its text.
pub fn controller<T: DeserializeOwned>(text: &str) -> PyResult<T> {
    toml::from_str(text)
        .map_err(|error| to_python(&InputError::ControllerUnreadable { reason: error.to_string() }))
}
