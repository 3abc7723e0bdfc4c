use cairn::robot::RobotProfile;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::errors::to_python;

/// A robot profile, checked: outline, limits, wheels and sensors.
#[pyclass(frozen, module = "cairn._brain")]
pub struct Profile {
    pub inner: RobotProfile,
}

#[pymethods]
impl Profile {
    /// Reads a profile from TOML text.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        let inner: RobotProfile = toml::from_str(text).map_err(|e| PyValueError::new_err(e.to_string()))?;
        Ok(Self { inner: inner.validated().map_err(|e| to_python(&e))? })
    }

    /// The profile as plain dicts and lists, keyed as in the file.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pythonize::pythonize(py, &self.inner)?)
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Profile>()
}
