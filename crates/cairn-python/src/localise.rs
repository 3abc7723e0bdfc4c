use cairn::geometry::Pose2;
use cairn::locate::{
    LocaliseState, LocaliserConfig, MatchingConfig, MonteCarloConfig, OdometryConfig, PoseEstimate,
    WheelTravel,
};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;

use crate::convert::{Triple, WorldParts, occupancy_grid, pose_of, settings, triple};
use crate::errors::to_python;
use crate::robot::Profile;

type Particles<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);

fn estimate_of<'py>(py: Python<'py>, estimate: Option<PoseEstimate>) -> PyResult<Option<Bound<'py, PyAny>>> {
    estimate.map(|estimate| Ok(pythonize::pythonize(py, &estimate)?)).transpose()
}

fn particles_of<'py>(py: Python<'py>, particles: &[(Pose2, f64)]) -> PyResult<Particles<'py>> {
    let flat: Vec<f64> = particles.iter().flat_map(|(p, _)| [p.x, p.y, p.heading]).collect();
    let weights: Vec<f64> = particles.iter().map(|(_, weight)| *weight).collect();
    Ok((flat.into_pyarray(py).reshape([particles.len(), 3])?, weights.into_pyarray(py)))
}

/// A set of poses on a known map; wrapped by `cairn.localisation.MonteCarlo`.
#[pyclass(module = "cairn._brain")]
pub struct MonteCarlo {
    inner: cairn::locate::MonteCarlo,
}

#[pymethods]
impl MonteCarlo {
    #[new]
    fn new(
        map: WorldParts<'_>,
        profile: &Profile,
        seed: u64,
        config: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let config: MonteCarloConfig = settings(config.as_ref(), "monte_carlo")?;
        let (cells, resolution_m, origin) = map;
        let map = occupancy_grid(&cells, resolution_m, pose_of(origin));
        cairn::locate::MonteCarlo::new(&config, &profile.inner, &map, seed)
            .map(|inner| Self { inner })
            .map_err(|e| to_python(&e))
    }

    /// Every setting with its default value.
    #[staticmethod]
    fn default_config(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(pythonize::pythonize(py, &MonteCarloConfig::default())?)
    }

    fn spread(&mut self, pose: Triple, sigma_m: f64, sigma_rad: f64) -> PyResult<()> {
        self.inner.spread(pose_of(pose), sigma_m, sigma_rad).map_err(|e| to_python(&e))
    }

    fn search(&mut self, py: Python<'_>, ranges_m: PyReadonlyArray1<'_, f64>) -> PyResult<usize> {
        let ranges_m: Vec<f64> = ranges_m.as_array().to_vec();
        py.detach(|| self.inner.search(&ranges_m)).map_err(|e| to_python(&e))
    }

    fn predict(&mut self, before_from_now: Triple) -> PyResult<()> {
        self.inner.predict(pose_of(before_from_now)).map_err(|e| to_python(&e))
    }

    fn update(&mut self, py: Python<'_>, ranges_m: PyReadonlyArray1<'_, f64>) -> PyResult<usize> {
        let ranges_m: Vec<f64> = ranges_m.as_array().to_vec();
        py.detach(|| self.inner.update(&ranges_m)).map_err(|e| to_python(&e))
    }

    #[getter]
    fn is_due(&self) -> bool {
        self.inner.is_due()
    }

    fn estimate<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        estimate_of(py, self.inner.estimate())
    }

    fn particles<'py>(&self, py: Python<'py>) -> PyResult<Particles<'py>> {
        particles_of(py, &self.inner.particles())
    }

    fn likelihood(&self, pose: Triple, ranges_m: PyReadonlyArray1<'_, f64>) -> PyResult<f64> {
        self.inner.likelihood(pose_of(pose), &ranges_m.as_array().to_vec()).map_err(|e| to_python(&e))
    }
}

/// A pose kept on a known map, found and found again; wrapped by `cairn.localisation.Localiser`.
#[pyclass(module = "cairn._brain")]
pub struct Localiser {
    inner: cairn::locate::Localiser,
    odometry: cairn::locate::Odometry,
    profile: cairn::robot::RobotProfile,
}

#[pymethods]
impl Localiser {
    #[new]
    fn new(
        map: WorldParts<'_>,
        profile: &Profile,
        start: Option<Triple>,
        config: Option<Bound<'_, PyAny>>,
        matching: Option<Bound<'_, PyAny>>,
        odometry: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let config: LocaliserConfig = settings(config.as_ref(), "localiser")?;
        let matching: MatchingConfig = settings(matching.as_ref(), "matching")?;
        let odometry: OdometryConfig = settings(odometry.as_ref(), "odometry")?;
        let (cells, resolution_m, origin) = map;
        let map = occupancy_grid(&cells, resolution_m, pose_of(origin));
        let at = start.map(pose_of).unwrap_or_default();
        let odometry =
            cairn::locate::Odometry::new(&odometry, &profile.inner.drive, at).map_err(|e| to_python(&e))?;
        let inner = cairn::locate::Localiser::new(&config, &matching, &profile.inner, &map, start.is_some())
            .map_err(|e| to_python(&e))?;
        Ok(Self { inner, odometry, profile: profile.inner.clone() })
    }

    /// Every setting with its default value.
    #[staticmethod]
    fn default_config(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(pythonize::pythonize(py, &LocaliserConfig::default())?)
    }

    fn step<'py>(
        &mut self,
        py: Python<'py>,
        ranges_m: PyReadonlyArray1<'py, f64>,
        wheels_m: (f64, f64),
        gyro_radps: Option<f64>,
        dt_s: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let ranges_m: Vec<f64> = ranges_m.as_array().to_vec();
        let wheels = WheelTravel { left_m: wheels_m.0, right_m: wheels_m.1 };
        let Self { inner, odometry, profile } = self;
        odometry.predict(wheels, gyro_radps, dt_s).map_err(|e| to_python(&e))?;
        let report =
            py.detach(|| inner.correct(odometry, profile, &ranges_m, dt_s)).map_err(|e| to_python(&e))?;
        Ok(pythonize::pythonize(py, &report)?)
    }

    fn set_pose(&mut self, pose: Triple) -> PyResult<()> {
        self.odometry.set_pose(pose_of(pose)).map_err(|e| to_python(&e))?;
        self.inner.believe();
        Ok(())
    }

    fn forget(&mut self) {
        self.inner.forget();
    }

    #[getter]
    fn is_found(&self) -> bool {
        self.inner.state() == LocaliseState::Tracking
    }

    /// (path scale, gyro scale, gyro bias [rad/s]) as learnt so far.
    #[getter]
    fn learnt(&self) -> Triple {
        let odometry = &self.odometry;
        (odometry.path_scale(), odometry.gyro_scale(), odometry.gyro_bias_radps())
    }

    #[getter]
    fn pose(&self) -> Triple {
        triple(self.odometry.pose())
    }

    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.odometry.covariance().as_flattened().to_pyarray(py).reshape([3, 3])
    }

    fn particles<'py>(&self, py: Python<'py>) -> PyResult<Particles<'py>> {
        particles_of(py, &self.inner.monte_carlo().particles())
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<MonteCarlo>()?;
    module.add_class::<Localiser>()
}
