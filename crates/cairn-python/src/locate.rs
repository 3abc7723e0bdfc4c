use cairn::geometry::{Point2, Pose2};
use cairn::locate::{MatchingConfig, OdometryConfig, WheelTravel};
use cairn::world::MappingConfig;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;

use crate::convert::{Triple, WorldParts, grid_of, occupancy_grid, points, pose_of, settings, triple};
use crate::errors::to_python;
use crate::robot::Profile;

// ---- ray casting ---------------------------------------------------------------------------------

/// Distance along each ray to the first occupied cell [m], inf where none within max_range_m.
#[pyfunction]
fn raycast<'py>(
    py: Python<'py>,
    occupied: PyReadonlyArray2<'py, bool>,
    resolution_m: f64,
    origin: Triple,
    from_points: PyReadonlyArray2<'py, f64>,
    directions_rad: PyReadonlyArray1<'py, f64>,
    max_range_m: f64,
) -> Bound<'py, PyArray1<f64>> {
    let grid = grid_of(&occupied, resolution_m, pose_of(origin));
    let (from, directions) = (from_points.as_array(), directions_rad.as_array());
    let rays: Vec<_> =
        from.rows().into_iter().zip(directions).map(|(p, d)| (Point2::new(p[0], p[1]), *d)).collect();
    let ranges: Vec<f64> = py.detach(|| {
        let cast = |&(p, d): &(Point2, f64)| cairn::world::raycast(&grid, p, d, max_range_m);
        rays.iter().map(|ray| cast(ray).unwrap_or(f64::INFINITY)).collect()
    });
    ranges.into_pyarray(py)
}

/// The range a sonar at each pose (x, y, heading) is expected to measure [m], inf for no echo.
#[pyfunction]
fn sonar_ranges<'py>(
    py: Python<'py>,
    occupied: PyReadonlyArray2<'py, bool>,
    resolution_m: f64,
    origin: Triple,
    world_from_sonar: PyReadonlyArray2<'py, f64>,
    beam_rad: f64,
    max_range_m: f64,
) -> Bound<'py, PyArray1<f64>> {
    let grid = grid_of(&occupied, resolution_m, pose_of(origin));
    let poses: Vec<Pose2> =
        world_from_sonar.as_array().rows().into_iter().map(|p| pose_of((p[0], p[1], p[2]))).collect();
    let ranges: Vec<f64> = py.detach(|| {
        poses.iter().map(|&pose| cairn::world::sonar_range(&grid, pose, beam_rad, max_range_m)).collect()
    });
    ranges.into_pyarray(py)
}

// ---- mapping -------------------------------------------------------------------------------------

/// Log-odds occupancy from sonar cones and lidar beams; wrapped by `cairn.mapping.OccupancyMap`.
#[pyclass(module = "cairn._brain")]
pub struct OccupancyMap {
    inner: cairn::world::OccupancyMap,
}

#[pymethods]
impl OccupancyMap {
    #[new]
    fn new(
        resolution_m: f64,
        prior: Option<WorldParts<'_>>,
        config: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let config: MappingConfig = settings(config.as_ref(), "mapping")?;
        match prior {
            None => cairn::world::OccupancyMap::new(&config, resolution_m),
            Some((cells, resolution_m, origin)) => cairn::world::OccupancyMap::from_occupancy(
                &config,
                &occupancy_grid(&cells, resolution_m, pose_of(origin)),
            ),
        }
        .map(|inner| Self { inner })
        .map_err(|e| to_python(&e))
    }

    /// Every setting with its default value.
    #[staticmethod]
    fn default_config(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(pythonize::pythonize(py, &MappingConfig::default())?)
    }

    fn integrate(
        &mut self,
        py: Python<'_>,
        profile: &Profile,
        world_from_robot: Triple,
        ranges_m: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let ranges_m: Vec<f64> = ranges_m.as_array().iter().copied().collect();
        py.detach(|| self.inner.integrate(pose_of(world_from_robot), &profile.inner, &ranges_m))
            .map_err(|e| to_python(&e))
    }

    fn classes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        let classes: Vec<u8> = self.inner.classes().iter().map(|class| *class as u8).collect();
        classes.into_pyarray(py).reshape(self.shape())
    }

    fn probabilities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        self.inner.probabilities().values.into_pyarray(py).reshape(self.shape())
    }

    fn unmapped<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.inner.unmapped().values.into_pyarray(py).reshape(self.shape())
    }

    fn occupied_near<'py>(
        &self,
        py: Python<'py>,
        center: (f64, f64),
        radius_m: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        points(py, &self.inner.occupied_near(Point2::new(center.0, center.1), radius_m))
    }

    fn unmapped_near<'py>(
        &self,
        py: Python<'py>,
        center: (f64, f64),
        radius_m: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        points(py, &self.inner.unmapped_near(Point2::new(center.0, center.1), radius_m))
    }

    fn clear_disc(&mut self, center: (f64, f64), radius_m: f64) {
        self.inner.clear_disc(Point2::new(center.0, center.1), radius_m);
    }

    #[getter]
    fn revision(&self) -> u64 {
        self.inner.revision()
    }

    #[getter]
    fn resolution_m(&self) -> f64 {
        self.inner.geometry().resolution_m
    }

    #[getter]
    fn origin(&self) -> Triple {
        triple(self.inner.geometry().world_from_grid)
    }
}

impl OccupancyMap {
    fn shape(&self) -> [usize; 2] {
        let geometry = self.inner.geometry();
        [geometry.rows, geometry.cols]
    }
}

// ---- odometry and matching -----------------------------------------------------------------------

/// Encoders and gyro fused into a pose; wrapped by `cairn.odometry.Odometry`.
#[pyclass(module = "cairn._brain")]
pub struct Odometry {
    inner: cairn::locate::Odometry,
}

#[pymethods]
impl Odometry {
    #[new]
    fn new(profile: &Profile, start: Triple, config: Option<Bound<'_, PyAny>>) -> PyResult<Self> {
        let config: OdometryConfig = settings(config.as_ref(), "odometry")?;
        cairn::locate::Odometry::new(&config, &profile.inner.drive, pose_of(start))
            .map(|inner| Self { inner })
            .map_err(|e| to_python(&e))
    }

    /// Every setting with its default value.
    #[staticmethod]
    fn default_config(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(pythonize::pythonize(py, &OdometryConfig::default())?)
    }

    fn predict(&mut self, wheels_m: (f64, f64), gyro_radps: Option<f64>, dt_s: f64) -> PyResult<()> {
        let wheels = WheelTravel { left_m: wheels_m.0, right_m: wheels_m.1 };
        self.inner.predict(wheels, gyro_radps, dt_s).map_err(|e| to_python(&e))
    }

    fn set_pose(&mut self, pose: Triple) -> PyResult<()> {
        self.inner.set_pose(pose_of(pose)).map_err(|e| to_python(&e))
    }

    #[getter]
    fn pose(&self) -> Triple {
        triple(self.inner.pose())
    }

    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.inner.covariance().as_flattened().to_pyarray(py).reshape([3, 3])
    }

    #[getter]
    fn twist(&self) -> (f64, f64) {
        let twist = self.inner.twist();
        (twist.linear_mps, twist.angular_radps)
    }

    #[getter]
    fn gyro_bias_radps(&self) -> f64 {
        self.inner.gyro_bias_radps()
    }

    #[getter]
    fn path_m(&self) -> f64 {
        self.inner.path_m()
    }

    #[getter]
    fn effective_track_m(&self) -> (f64, f64) {
        self.inner.effective_track_m()
    }

    #[getter]
    fn veer_radpm(&self) -> f64 {
        self.inner.veer_radpm()
    }

    #[getter]
    fn path_scale(&self) -> f64 {
        self.inner.path_scale()
    }

    #[getter]
    fn gyro_scale(&self) -> f64 {
        self.inner.gyro_scale()
    }
}

/// Small pose corrections from sonar against a known map; wrapped by `cairn.odometry.MapMatcher`.
#[pyclass(frozen, module = "cairn._brain")]
pub struct MapMatcher {
    inner: cairn::locate::MapMatcher,
}

#[pymethods]
impl MapMatcher {
    #[new]
    fn new(prior: WorldParts<'_>, config: Option<Bound<'_, PyAny>>) -> PyResult<Self> {
        let config: MatchingConfig = settings(config.as_ref(), "matching")?;
        let (cells, resolution_m, origin) = prior;
        cairn::locate::MapMatcher::new(&config, &occupancy_grid(&cells, resolution_m, pose_of(origin)))
            .map(|inner| Self { inner })
            .map_err(|e| to_python(&e))
    }

    /// Every setting with its default value.
    #[staticmethod]
    fn default_config(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(pythonize::pythonize(py, &MatchingConfig::default())?)
    }

    fn correct<'py>(
        &self,
        py: Python<'py>,
        odometry: &mut Odometry,
        profile: &Profile,
        ranges_m: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let ranges_m: Vec<f64> = ranges_m.as_array().iter().copied().collect();
        let report = py
            .detach(|| self.inner.correct(&mut odometry.inner, &profile.inner, &ranges_m))
            .map_err(|e| to_python(&e))?;
        Ok(pythonize::pythonize(py, &report)?)
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(raycast, module)?)?;
    module.add_function(wrap_pyfunction!(sonar_ranges, module)?)?;
    module.add_class::<OccupancyMap>()?;
    module.add_class::<Odometry>()?;
    module.add_class::<MapMatcher>()
}
