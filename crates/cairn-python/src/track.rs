use std::cell::RefCell;

use cairn::fuzzy::FuzzyConfig;
use cairn::geometry::{Point2, Twist2};
use cairn::robot::Limits;
use cairn::track::{Stage, TrackerConfig, WaypointConfig, Waypoints};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::convert::{Triple, controller, points, pose_of};
use crate::errors::to_python;
use crate::robot::Profile;

/// A checked zero-order Sugeno system.
#[pyclass(frozen, module = "cairn._brain")]
struct FuzzySystem {
    inner: cairn::fuzzy::FuzzySystem,
}

#[pymethods]
impl FuzzySystem {
    #[new]
    fn new(text: &str) -> PyResult<Self> {
        let config: FuzzyConfig = controller(text)?;
        Ok(Self { inner: cairn::fuzzy::FuzzySystem::new(&config).map_err(|e| to_python(&e))? })
    }

    #[getter]
    fn input_names(&self) -> Vec<&str> {
        self.inner.input_names().collect()
    }

    #[getter]
    fn output_names(&self) -> Vec<&str> {
        self.inner.output_names().collect()
    }

    /// Outputs, memberships and rule strengths by name; values in order of input names.
    fn evaluate<'py>(&self, py: Python<'py>, values: Vec<f64>) -> PyResult<Bound<'py, PyAny>> {
        let evaluation = self.inner.evaluate(&values).map_err(|e| to_python(&e))?;
        Ok(pythonize::pythonize(py, &evaluation)?)
    }

    /// Output values (n, outputs) for input values (n, inputs).
    fn outputs<'py>(
        &self,
        py: Python<'py>,
        values: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let values = values.as_array();
        let rows: Vec<Vec<f64>> = values.rows().into_iter().map(|row| row.to_vec()).collect();
        let shape = [rows.len(), self.inner.output_names().len()];
        let outputs = py.detach(|| {
            rows.iter()
                .map(|row| self.inner.outputs(row))
                .collect::<Result<Vec<_>, _>>()
                .map(|rows| rows.concat())
        });
        outputs.map_err(|e| to_python(&e))?.into_pyarray(py).reshape(shape)
    }
}

/// The path tracker.
#[pyclass(module = "cairn._brain")]
struct Tracker {
    inner: cairn::track::Tracker,
    limits: Limits,
}

#[pymethods]
impl Tracker {
    #[new]
    #[pyo3(signature = (text, profile, cruise_mps=None))]
    fn new(text: &str, profile: &Profile, cruise_mps: Option<f64>) -> PyResult<Self> {
        let config: TrackerConfig = controller(text)?;
        let limits = profile.inner.limits;
        let mut inner = cairn::track::Tracker::new(&config, &limits)
            .and_then(|tracker| tracker.with_latency(profile.inner.drive.latency_s))
            .map_err(|e| to_python(&e))?;
        if let Some(cruise_mps) = cruise_mps {
            inner = inner.with_cruise(cruise_mps).map_err(|e| to_python(&e))?;
        }
        Ok(Self { inner, limits })
    }

    /// Takes up a path (n, 2), resampled when a spacing is given.
    fn follow(
        &mut self,
        points: PyReadonlyArray2<'_, f64>,
        spacing_m: Option<f64>,
        corridor_m: f64,
        is_clear: Option<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let points: Vec<Point2> =
            points.as_array().rows().into_iter().map(|p| Point2::new(p[0], p[1])).collect();
        let failure = RefCell::new(None);
        let clear = |from: Point2, to: Point2| match &is_clear {
            None => true,
            Some(callable) => callable
                .call1(((from.x, from.y), (to.x, to.y)))
                .and_then(|answer| answer.is_truthy())
                .unwrap_or_else(|error| {
                    failure.borrow_mut().get_or_insert(error);
                    false
                }),
        };
        let waypoints = match spacing_m {
            None => Waypoints::as_given(&points),
            Some(spacing_m) => {
                Waypoints::from_path(&points, &WaypointConfig { spacing_m, corridor_m }, clear)
            }
        };
        if let Some(error) = failure.into_inner() {
            return Err(error);
        }
        self.inner.follow(waypoints.map_err(|e| to_python(&e))?);
        Ok(())
    }

    fn clear(&mut self) {
        self.inner.clear();
    }

    #[getter]
    fn waypoints<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.inner.waypoints().map(|waypoints| points(py, waypoints.points())).transpose()
    }

    #[getter]
    fn index(&self) -> usize {
        self.inner.index()
    }

    #[setter]
    fn set_index(&mut self, index: usize) {
        self.inner.set_index(index);
    }

    fn advance_pointer(&mut self, x: f64, y: f64) {
        self.inner.advance_pointer(Point2::new(x, y));
    }

    fn step<'py>(
        &mut self,
        py: Python<'py>,
        pose: Triple,
        twist: (f64, f64),
        dt_s: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let record = self
            .inner
            .try_step(pose_of(pose), Twist2::new(twist.0, twist.1), dt_s)
            .map_err(|e| to_python(&e))?;
        Ok(pythonize::pythonize(py, &record)?)
    }

    fn overridden(&mut self, twist: (f64, f64)) {
        self.inner.overridden(Twist2::new(twist.0, twist.1));
    }

    /// (n, 8): time; x, y, heading; V, omega; commanded V, omega. Works on a copy of the tracker.
    fn rehearse<'py>(
        &self,
        py: Python<'py>,
        start: Triple,
        tick_s: f64,
        latency_s: f64,
        turn_share: f64,
        most_s: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let stage = Stage { tick_s, latency_s, turn_share, most_s };
        let moments = py
            .detach(|| {
                let mut tracker = self.inner.clone();
                cairn::track::rehearse(&mut tracker, &self.limits, &stage, pose_of(start))
            })
            .map_err(|e| to_python(&e))?;
        let flat: Vec<f64> = moments
            .iter()
            .flat_map(|moment| {
                let (pose, twist, command) = (moment.world_from_robot, moment.twist, moment.command);
                [
                    moment.time_s,
                    pose.x,
                    pose.y,
                    pose.heading,
                    twist.linear_mps,
                    twist.angular_radps,
                    command.linear_mps,
                    command.angular_radps,
                ]
            })
            .collect();
        flat.into_pyarray(py).reshape([moments.len(), 8])
    }

    fn look_ahead_system(&self) -> FuzzySystem {
        FuzzySystem { inner: self.inner.look_ahead().system().clone() }
    }

    fn tracker_system(&self) -> FuzzySystem {
        FuzzySystem { inner: self.inner.system().clone() }
    }
}

/// (n, 2): signed distance to the path, positive left, and the way along it, for positions (n, 2).
#[pyfunction]
fn deviations<'py>(
    py: Python<'py>,
    path: PyReadonlyArray2<'py, f64>,
    positions: PyReadonlyArray2<'py, f64>,
    reach_m: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let points = |array: &PyReadonlyArray2<'py, f64>| -> Vec<Point2> {
        array.as_array().rows().into_iter().map(|p| Point2::new(p[0], p[1])).collect()
    };
    let (path, positions) = (points(&path), points(&positions));
    let found =
        py.detach(|| cairn::track::deviations(&path, &positions, reach_m)).map_err(|e| to_python(&e))?;
    let flat: Vec<f64> = found.iter().flat_map(|d| [d.left_m, d.along_m]).collect();
    flat.into_pyarray(py).reshape([found.len(), 2])
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<FuzzySystem>()?;
    module.add_class::<Tracker>()?;
    module.add_function(wrap_pyfunction!(deviations, module)?)
}
