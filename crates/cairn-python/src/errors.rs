//! Errors of the brain become the Python class of the same name in `cairn.errors`.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

/// What the bindings themselves refuse.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize)]
pub enum InputError {
    /// The text of a controller or a fuzzy system is not TOML, or has keys that do not belong.
    #[error("{reason}")]
    ControllerUnreadable {
        /// Where and why.
        reason: String,
    },
    /// The text of a profile is not TOML, or its keys are not those of a profile.
    #[error("{reason}")]
    ProfileUnreadable {
        /// Where and why.
        reason: String,
    },
    /// Settings have a key that does not belong, or a value of the wrong type.
    #[error("{part}: {reason}")]
    SettingsInvalid {
        /// Of what part.
        part: String,
        /// Which and why.
        reason: String,
    },
}

/// Raises the variant of `error` as `cairn.errors.<Variant>`, its fields as attributes.
///
/// Every error enum of the brain derives `Serialize`, so that a variant with fields arrives here
/// as `{"Variant": {field: value}}` and one without as `"Variant"`.
pub fn to_python<E: std::error::Error + Serialize>(error: &E) -> PyErr {
    Python::attach(|py| raise(py, error).unwrap_or_else(|failure| failure))
}

fn raise<E: std::error::Error + Serialize>(py: Python<'_>, error: &E) -> PyResult<PyErr> {
    let value = pythonize::pythonize(py, error)?;
    let (name, fields) = match value.cast::<PyDict>() {
        Ok(tagged) => {
            let (name, fields) = tagged.iter().next().expect("an enum variant has one tag");
            (name.extract::<String>()?, fields.cast_into::<PyDict>().ok())
        }
        Err(_) => (value.extract::<String>()?, None),
    };
    let class = py.import("cairn.errors")?.getattr(name.as_str())?;
    Ok(PyErr::from_value(class.call((error.to_string(),), fields.as_ref())?))
}
