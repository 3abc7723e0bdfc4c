use std::sync::Arc;

use cairn::geometry::{Point2, Twist2};
use cairn::locate::WheelTravel;
use cairn::navigate::{NavigateError, NavigatorConfig, PAPER, TickInput, WorldField};
use cairn::track::TrackerConfig;
use cairn_record::{FieldSource, Tap, Told};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde::Serialize;

use crate::convert::{Triple, WorldParts, controller, occupancy_grid, points, pose_of, settings, triple};
use crate::errors::to_python;
use crate::robot::Profile;

/// The name that serde gives a unit variant.
fn name_of<T: Serialize>(py: Python<'_>, value: &T) -> PyResult<String> {
    pythonize::pythonize(py, value)?.extract()
}

/// A cost-to-go field laid over the world, to be shared between navigators.
#[pyclass(frozen, module = "cairn._brain")]
pub struct SharedField {
    inner: WorldField,
    /// Whose it is and of when, where that navigator is recorded.
    source: Option<FieldSource>,
}

#[pymethods]
impl SharedField {
    /// Cost still to pay from (x, y) in the world [m]: inf where no path leads on, None outside.
    fn cost_to_go_at(&self, x: f64, y: f64) -> Option<f64> {
        self.inner.cost_to_go(Point2::new(x, y))
    }

    /// Cost-to-go of every cell, float64 (rows, cols), inf where blocked or unreachable.
    fn cost_to_go<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let geometry = self.inner.geometry();
        let values = py.detach(|| self.inner.field.costs_to_go(geometry.resolution_m));
        values.into_pyarray(py).reshape([geometry.rows, geometry.cols])
    }

    /// Side of a cell [m].
    #[getter]
    fn resolution_m(&self) -> f64 {
        self.inner.geometry().resolution_m
    }

    /// (x, y, yaw) of the outer corner of cell (0, 0) in the world [m, m, rad].
    #[getter]
    fn origin(&self) -> Triple {
        triple(self.inner.geometry().world_from_grid)
    }
}

/// One tick's record. `to_dict` holds all of it.
#[pyclass(frozen, module = "cairn._brain")]
pub struct Decision {
    inner: Arc<cairn::navigate::Decision>,
}

#[pymethods]
impl Decision {
    #[getter]
    fn twist(&self) -> (f64, f64) {
        let Twist2 { linear_mps, angular_radps } = self.inner.twist;
        (linear_mps, angular_radps)
    }

    #[getter]
    fn pose(&self) -> Triple {
        triple(self.inner.pose)
    }

    #[getter]
    fn time_s(&self) -> f64 {
        self.inner.time_s
    }

    #[getter]
    fn mode(&self, py: Python<'_>) -> PyResult<String> {
        name_of(py, &self.inner.mode)
    }

    #[getter]
    fn event(&self, py: Python<'_>) -> PyResult<String> {
        name_of(py, &self.inner.event)
    }

    #[getter]
    fn reason(&self, py: Python<'_>) -> PyResult<String> {
        name_of(py, &self.inner.reason)
    }

    #[getter]
    fn sentence(&self) -> &str {
        &self.inner.sentence
    }

    /// {"cause": {"code": ..., and its numbers}, "remedy": ...} in the tick in which something went wrong.
    #[getter]
    fn recovery<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pythonize::pythonize(py, &self.inner.recovery)?)
    }

    /// "idle", "driving", "reached", "refused" or "cancelled".
    #[getter]
    fn goal_status(&self, py: Python<'_>) -> PyResult<String> {
        pythonize::pythonize(py, &self.inner.status)?.get_item("code")?.extract()
    }

    /// The whole record as plain dicts and lists.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pythonize::pythonize(py, &*self.inner)?)
    }
}

/// Plans, tracks, avoids and arrives; wrapped by `cairn.Navigator`.
#[pyclass(module = "cairn._brain")]
pub struct Navigator {
    pub inner: cairn::navigate::Navigator,
    /// Where its ticks are recorded, if they are.
    pub tap: Option<Tap>,
}

#[pymethods]
impl Navigator {
    #[new]
    fn new(
        profile: &Profile,
        controller_toml: &str,
        config: Option<Bound<'_, PyAny>>,
        map: Option<WorldParts<'_>>,
        start: Option<Triple>,
        ground: Option<PyReadonlyArray2<'_, f32>>,
    ) -> PyResult<Self> {
        let controller: TrackerConfig = controller(controller_toml)?;
        let config: NavigatorConfig = settings(config.as_ref(), "navigator")?;
        let world =
            map.map(|(cells, resolution_m, origin)| occupancy_grid(&cells, resolution_m, pose_of(origin)));
        let start = start.map(pose_of);
        let ground: Option<Vec<f32>> = ground.map(|costs| costs.as_array().iter().copied().collect());
        cairn::navigate::Navigator::new(profile.inner.clone(), &controller, config, world.as_ref(), start)
            .and_then(|navigator| match ground {
                Some(ground) => navigator.with_ground(ground),
                None => Ok(navigator),
            })
            .map(|inner| Self { inner, tap: None })
            .map_err(|e| to_python(&e))
    }

    /// Every setting with its default value, as plain dicts.
    #[staticmethod]
    fn default_config(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(pythonize::pythonize(py, &NavigatorConfig::default())?)
    }

    #[pyo3(signature = (x, y, field=None))]
    fn set_goal(&mut self, x: f64, y: f64, field: Option<&SharedField>) -> PyResult<()> {
        let point = Point2::new(x, y);
        let (shared, source) = (field.is_some(), field.and_then(|field| field.source.clone()));
        let field = field.map(|shared| shared.inner.clone());
        self.inner.set_goal(point, field).map_err(|e| to_python(&e))?;
        self.told(|| Told::Goal { point, shared, source });
        Ok(())
    }

    fn explore(&mut self) {
        self.inner.explore();
        self.told(|| Told::Explore);
    }

    fn cancel(&mut self) {
        self.inner.cancel();
        self.told(|| Told::Cancel);
    }

    #[pyo3(signature = (ranges, wheels, gyro, dt_s, world_from_robot=None))]
    fn step(
        &mut self,
        py: Python<'_>,
        ranges: PyReadonlyArray1<'_, f64>,
        wheels: (f64, f64),
        gyro: Option<f64>,
        dt_s: f64,
        world_from_robot: Option<Triple>,
    ) -> PyResult<Decision> {
        let ranges: Vec<f64> = ranges.as_array().to_vec();
        let (navigator, tap) = (&mut self.inner, &mut self.tap);
        let input = TickInput {
            ranges_m: &ranges,
            wheels: WheelTravel { left_m: wheels.0, right_m: wheels.1 },
            gyro_radps: gyro,
            dt_s,
            world_from_robot: world_from_robot.map(pose_of),
        };
        py.detach(|| {
            let decision = Arc::new(navigator.step(&input)?);
            if let Some(tap) = tap {
                tap.stepped(&input, navigator, &decision);
            }
            Ok(Decision { inner: decision })
        })
        .map_err(|e: NavigateError| to_python(&e))
    }

    #[getter]
    fn pose(&self) -> Triple {
        triple(self.inner.pose())
    }

    #[getter]
    fn mode(&self, py: Python<'_>) -> PyResult<String> {
        name_of(py, &self.inner.mode())
    }

    #[getter]
    fn path<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        points(py, self.inner.path())
    }

    #[getter]
    fn waypoints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        points(py, self.inner.waypoints())
    }

    #[getter]
    fn lidar_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        points(py, &self.inner.lidar_points())
    }

    #[getter]
    fn plan_count(&self) -> u32 {
        self.inner.plan_count()
    }

    #[getter]
    fn field(&self) -> Option<SharedField> {
        let source = self.tap.as_ref().map(Tap::field_source);
        self.inner.field().map(|field| SharedField { inner: field.clone(), source })
    }

    /// (uint8 (rows, cols), resolution [m], origin) of the map as it is now.
    fn map<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray2<u8>>, f64, Triple)> {
        let map = self.inner.map().occupancy();
        let geometry = map.geometry;
        let cells: Vec<u8> = map.values.iter().map(|&seen| seen as u8).collect();
        let cells = cells.into_pyarray(py).reshape([geometry.rows, geometry.cols])?;
        Ok((cells, geometry.resolution_m, triple(geometry.world_from_grid)))
    }
}

impl Navigator {
    fn told(&self, what: impl FnOnce() -> Told) {
        if let Some(tap) = &self.tap {
            tap.told(what());
        }
    }
}

/// Every transition of the four modes: (mode, event, next mode, reason).
#[pyfunction]
fn transitions(py: Python<'_>) -> PyResult<Vec<(String, String, String, String)>> {
    PAPER
        .iter()
        .map(|row| {
            let names = (name_of(py, &row.mode)?, name_of(py, &row.event)?);
            Ok((names.0, names.1, name_of(py, &row.next)?, name_of(py, &row.reason)?))
        })
        .collect()
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<SharedField>()?;
    module.add_class::<Decision>()?;
    module.add_class::<Navigator>()?;
    module.add_function(wrap_pyfunction!(transitions, module)?)
}
