use cairn::avoid::{AvoidError, Cvm, CvmConfig};
use cairn::geometry::{Point2, Twist2};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::convert::settings;
use crate::errors::to_python;
use crate::robot::Profile;

/// The curvature velocity method for one robot. `cairn.avoidance.Cvm` is its public face.
#[pyclass(frozen, module = "cairn._brain")]
pub struct CurvatureVelocity {
    inner: Cvm,
}

#[pymethods]
impl CurvatureVelocity {
    /// For a robot of this profile; `config` holds settings that differ from their defaults.
    #[new]
    fn new(profile: &Profile, config: &Bound<'_, PyAny>) -> PyResult<Self> {
        let config: CvmConfig = settings(Some(config), "avoidance")?;
        let robot = &profile.inner;
        let inner = Cvm::new(&config, &robot.limits, &robot.footprint).map_err(|e| to_python(&e))?;
        Ok(Self { inner })
    }

    /// All settings.
    fn config<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pythonize::pythonize(py, self.inner.config())?)
    }

    /// One choice, as plain dicts and lists. Obstacles are an (n, 2) array.
    #[allow(clippy::too_many_arguments)]
    fn choose<'py>(
        &self,
        py: Python<'py>,
        twist: (f64, f64),
        pending: Option<(f64, f64)>,
        goal_bearing_rad: f64,
        goal_distance_m: f64,
        obstacles: PyReadonlyArray2<'py, f64>,
        dt_s: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let obstacles: Vec<Point2> =
            obstacles.as_array().rows().into_iter().map(|p| Point2::new(p[0], p[1])).collect();
        let current = Twist2::new(twist.0, twist.1);
        let record = py.detach(|| -> Result<_, AvoidError> {
            self.inner.check(current, goal_bearing_rad, goal_distance_m, &obstacles, dt_s)?;
            let pending = pending.map(|(linear, angular)| Twist2::new(linear, angular));
            let (bearing, distance) = (goal_bearing_rad, goal_distance_m);
            Ok(self.inner.choose_after(current, pending, bearing, distance, &obstacles, dt_s))
        });
        Ok(pythonize::pythonize(py, &record.map_err(|e| to_python(&e))?)?)
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<CurvatureVelocity>()
}
