use std::cell::RefCell;

use cairn::avoid::{AvoidError, Cvm, CvmConfig, Guide, Moving};
use cairn::geometry::{Point2, Pose2, Twist2};
use cairn::navigate::{LocalField, LocalFieldConfig};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::convert::{Triple, pose_of, settings};
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
        let obstacles = points_of(&obstacles);
        let current = Twist2::new(twist.0, twist.1);
        let record = py.detach(|| -> Result<_, AvoidError> {
            self.inner.check(current, goal_bearing_rad, goal_distance_m, &obstacles, dt_s)?;
            let pending = pending.map(|(linear, angular)| Twist2::new(linear, angular));
            let (bearing, distance) = (goal_bearing_rad, goal_distance_m);
            Ok(self.inner.choose_after(current, pending, bearing, distance, &obstacles, dt_s))
        });
        Ok(pythonize::pythonize(py, &record.map_err(|e| to_python(&e))?)?)
    }

    /// One choice guided by a field, as plain dicts and lists. Obstacles are (n, 2), moving things
    /// (k, 5): x, y, radius, velocity in x and y; the guide a `FieldGuide`, or anything like it.
    #[allow(clippy::too_many_arguments)]
    fn choose_guided<'py>(
        &self,
        py: Python<'py>,
        twist: (f64, f64),
        pending: (f64, f64),
        guide: &Bound<'py, PyAny>,
        obstacles: PyReadonlyArray2<'py, f64>,
        moving: PyReadonlyArray2<'py, f64>,
        goal_distance_m: f64,
        dt_s: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let obstacles = points_of(&obstacles);
        let [current, pending] = [twist, pending].map(|(linear, angular)| Twist2::new(linear, angular));
        let moving: Vec<Moving> = moving
            .as_array()
            .rows()
            .into_iter()
            .map(|row| Moving {
                center: Point2::new(row[0], row[1]),
                radius_m: row[2],
                velocity_mps: Point2::new(row[3], row[4]),
            })
            .collect();
        self.inner.check(current, 0.0, goal_distance_m, &obstacles, dt_s).map_err(|e| to_python(&e))?;
        let choose = |guide: &dyn Guide| {
            self.inner.choose_guided(current, pending, guide, &obstacles, &moving, goal_distance_m, dt_s)
        };
        let record = match guide.cast::<FieldGuide>() {
            Ok(guide) => {
                let guide = guide.get();
                py.detach(|| guide.asked(|seen| choose(seen)))
            }
            Err(_) => {
                let guide = PythonGuide { guide, failed: RefCell::new(None) };
                let record = choose(&guide);
                if let Some(error) = guide.failed.into_inner() {
                    return Err(error);
                }
                record
            }
        };
        Ok(pythonize::pythonize(py, &record)?)
    }
}

fn points_of(array: &PyReadonlyArray2<'_, f64>) -> Vec<Point2> {
    array.as_array().rows().into_iter().map(|p| Point2::new(p[0], p[1])).collect()
}

/// The field over points around a robot, seen from it. `cairn.avoidance.FieldGuide` is its public face.
#[pyclass(frozen, subclass, module = "cairn._brain")]
pub struct FieldGuide {
    field: LocalField,
    world_from_robot: Pose2,
    solved: bool,
}

impl FieldGuide {
    /// What a guide says; without a field, that no way is known.
    fn asked<T>(&self, ask: impl FnOnce(&dyn Guide) -> T) -> T {
        match self.field.seen_from(self.world_from_robot) {
            Some(seen) => ask(&seen),
            None => ask(&Nowhere),
        }
    }
}

#[pymethods]
impl FieldGuide {
    /// Solves the field: points (n, 2), pose and goal in one frame, in cells of `resolution_m`.
    #[new]
    fn new(
        py: Python<'_>,
        profile: &Profile,
        config: &Bound<'_, PyAny>,
        points: PyReadonlyArray2<'_, f64>,
        robot: Triple,
        goal: (f64, f64),
        resolution_m: f64,
    ) -> PyResult<Self> {
        let config: LocalFieldConfig = settings(Some(config), "lidar.field")?;
        config.checked(resolution_m).map_err(|e| to_python(&e))?;
        let (points, world_from_robot) = (points_of(&points), pose_of(robot));
        let (footprint, goal) = (profile.inner.footprint, Point2::new(goal.0, goal.1));
        let mut field = LocalField::new(&config);
        let solved =
            py.detach(|| field.solve(&points, resolution_m, &footprint, world_from_robot.position(), goal));
        Ok(Self { field, world_from_robot, solved })
    }

    /// Whether a way is known that keeps off every point.
    #[getter]
    fn has_way(&self) -> bool {
        self.solved && !self.field.is_desperate()
    }

    /// Time to go \[s\] and direction to leave in \[rad\], of a point in the robot frame.
    fn to_go(&self, point_in_robot: (f64, f64)) -> (f64, f64) {
        self.asked(|guide| guide.to_go(Point2::new(point_in_robot.0, point_in_robot.1)))
    }

    /// Time that a metre takes there \[s/m\].
    fn price(&self, point_in_robot: (f64, f64)) -> f64 {
        self.asked(|guide| guide.price(Point2::new(point_in_robot.0, point_in_robot.1)))
    }
}

/// Where nothing could be solved.
struct Nowhere;

impl Guide for Nowhere {
    fn to_go(&self, _: Point2) -> (f64, f64) {
        (f64::INFINITY, 0.0)
    }

    fn price(&self, _: Point2) -> f64 {
        f64::INFINITY
    }
}

/// A guide written in Python; its first error ends the choice.
struct PythonGuide<'a, 'py> {
    guide: &'a Bound<'py, PyAny>,
    failed: RefCell<Option<PyErr>>,
}

impl PythonGuide<'_, '_> {
    fn told<T>(
        &self,
        method: &str,
        point: Point2,
        read: impl FnOnce(Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Option<T> {
        if self.failed.borrow().is_some() {
            return None;
        }
        let told = self.guide.call_method1(method, ((point.x, point.y),)).and_then(read);
        told.map_err(|error| *self.failed.borrow_mut() = Some(error)).ok()
    }
}

impl Guide for PythonGuide<'_, '_> {
    fn to_go(&self, point_in_robot: Point2) -> (f64, f64) {
        self.told("to_go", point_in_robot, |told| told.extract::<(f64, f64)>())
            .unwrap_or_else(|| Nowhere.to_go(point_in_robot))
    }

    fn price(&self, point_in_robot: Point2) -> f64 {
        self.told("price", point_in_robot, |told| told.extract::<f64>()).unwrap_or(f64::INFINITY)
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<FieldGuide>()?;
    module.add_class::<CurvatureVelocity>()
}
