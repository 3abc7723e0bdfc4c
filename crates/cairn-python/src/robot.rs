use cairn::robot::{Drive, Footprint, Lidar, Limits, RobotProfile, Sonar};
use pyo3::prelude::*;
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::errors::{InputError, to_python};

/// A robot profile, checked: outline, limits, wheels and sensors.
#[pyclass(frozen, subclass, module = "cairn._brain")]
pub struct Profile {
    pub inner: RobotProfile,
}

/// The whole file: what the brain needs, and the tables that only the body reads.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProfileFile {
    name: String,
    footprint: Footprint,
    limits: Limits,
    drive: Drive,
    #[serde(default)]
    sonars: Vec<Sonar>,
    #[serde(default)]
    lidar: Option<Lidar>,
    #[serde(default, rename = "physics")]
    _physics: IgnoredAny,
    #[serde(default, rename = "noise")]
    _noise: IgnoredAny,
}

#[pymethods]
impl Profile {
    /// Reads a profile from TOML text; `[physics]` and `[noise]` are the body's and not looked at.
    #[new]
    fn new(text: &str) -> PyResult<Self> {
        let file: ProfileFile = toml::from_str(text)
            .map_err(|e| to_python(&InputError::ProfileUnreadable { reason: e.to_string() }))?;
        let ProfileFile { name, footprint, limits, drive, sonars, lidar, .. } = file;
        let inner = RobotProfile { name, footprint, limits, drive, sonars, lidar };
        Ok(Self { inner: inner.validated().map_err(|e| to_python(&e))? })
    }

    /// Reads a profile from TOML text.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        Self::new(text)
    }

    /// The profile as plain dicts and lists, keyed as in the file.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pythonize::pythonize(py, &self.inner)?)
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Profile>()
}
