//! Errors of the brain become the Python class of the same name in `cairn.errors`.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

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
