use cairn::geometry::Point2;
use cairn::robot::Footprint;
use cairn::world::{Block, Circle, Touched, check_circles};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::convert::{Triple, pose_of};
use crate::errors::to_python;

/// Circles and boxes that stand: exact rays, exact contact.
#[pyclass(frozen, module = "cairn._brain")]
pub struct Shapes {
    inner: cairn::world::Shapes,
}

type Ranges<'py> = Bound<'py, PyArray1<f64>>;

/// Rows (x, y, radius) \[m\].
fn circles_of(rows: Option<&PyReadonlyArray2<'_, f64>>) -> PyResult<Vec<Circle>> {
    let Some(rows) = rows else { return Ok(Vec::new()) };
    if rows.as_array().ncols() != 3 {
        return Err(pyo3::exceptions::PyTypeError::new_err("circles: an array (n, 3) of x, y, radius"));
    }
    let circle = |row: [f64; 3]| Circle { centre: Point2::new(row[0], row[1]), radius_m: row[2] };
    Ok(rows.as_array().rows().into_iter().map(|r| circle([r[0], r[1], r[2]])).collect())
}

fn moving_of(rows: Option<&PyReadonlyArray2<'_, f64>>) -> PyResult<Vec<Circle>> {
    let circles = circles_of(rows)?;
    check_circles(&circles).map_err(|e| to_python(&e))?;
    Ok(circles)
}

fn outline_of((length_m, width_m): (f64, f64)) -> Footprint {
    Footprint { length_m, width_m }
}

#[pymethods]
impl Shapes {
    /// From circles (n, 3): x, y, radius; and boxes (m, 5): x, y, heading, length, width.
    #[new]
    fn new(circles: PyReadonlyArray2<'_, f64>, boxes: PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        if boxes.as_array().ncols() != 5 {
            let wanted = "boxes: an array (n, 5) of x, y, heading, length, width";
            return Err(pyo3::exceptions::PyTypeError::new_err(wanted));
        }
        let rows = boxes.as_array();
        let block = |r: numpy::ndarray::ArrayView1<'_, f64>| Block {
            pose: pose_of((r[0], r[1], r[2])),
            outline: outline_of((r[3], r[4])),
        };
        let blocks = rows.rows().into_iter().map(block).collect();
        let inner = cairn::world::Shapes::new(circles_of(Some(&circles))?, blocks);
        Ok(Self { inner: inner.map_err(|e| to_python(&e))? })
    }

    /// Ranges of a planar scanner at a pose.
    #[allow(clippy::too_many_arguments)]
    #[pyo3(signature = (pose, beams, first_rad, step_rad, max_range_m, moving=None))]
    fn scan<'py>(
        &self,
        py: Python<'py>,
        pose: Triple,
        beams: usize,
        first_rad: f64,
        step_rad: f64,
        max_range_m: f64,
        moving: Option<PyReadonlyArray2<'py, f64>>,
    ) -> PyResult<Ranges<'py>> {
        let moving = moving_of(moving.as_ref())?;
        let pose = pose_of(pose);
        let ranges = py.detach(|| self.inner.scan(pose, beams, first_rad, step_rad, max_range_m, &moving));
        Ok(ranges.into_pyarray(py))
    }

    /// (ranges, cosines of incidence) of rays from one point along world directions.
    fn cast<'py>(
        &self,
        py: Python<'py>,
        origin: (f64, f64),
        directions_rad: PyReadonlyArray1<'py, f64>,
        max_range_m: f64,
    ) -> (Ranges<'py>, Ranges<'py>) {
        let directions: Vec<f64> = directions_rad.as_array().to_vec();
        let from = Point2::new(origin.0, origin.1);
        let hits = py.detach(|| self.inner.cast(from, &directions, max_range_m));
        let (ranges, cosines): (Vec<f64>, Vec<f64>) =
            hits.into_iter().map(|hit| (hit.range_m, hit.cosine)).unzip();
        (ranges.into_pyarray(py), cosines.into_pyarray(py))
    }

    /// Least distance from an outline (length, width) at a pose to any shape.
    #[pyo3(signature = (pose, outline, moving=None))]
    fn clearance(
        &self,
        pose: Triple,
        outline: (f64, f64),
        moving: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<f64> {
        let moving = moving_of(moving.as_ref())?;
        Ok(self.inner.clearance_m(pose_of(pose), &outline_of(outline), &moving))
    }

    /// First of poses (n, 3) that touches: (number, `circle`, `box` or `moving`, which); or None.
    #[pyo3(signature = (poses, outline, moving=None))]
    fn first_touch(
        &self,
        poses: PyReadonlyArray2<'_, f64>,
        outline: (f64, f64),
        moving: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Option<(usize, &'static str, usize)>> {
        let rows = poses.as_array();
        if rows.ncols() != 3 {
            return Err(pyo3::exceptions::PyTypeError::new_err("poses: an array (n, 3) of x, y, heading"));
        }
        let poses: Vec<_> = rows.rows().into_iter().map(|r| pose_of((r[0], r[1], r[2]))).collect();
        let moving = moving_of(moving.as_ref())?;
        let touch = self.inner.first_touch(&poses, &outline_of(outline), &moving);
        Ok(touch.map(|touch| match touch.shape {
            Touched::Circle(which) => (touch.step, "circle", which),
            Touched::Block(which) => (touch.step, "box", which),
            Touched::Moving(which) => (touch.step, "moving", which),
        }))
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Shapes>()
}
