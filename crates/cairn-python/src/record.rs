use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use cairn_record::{Entry, Log};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::convert::{Triple, pose_of};
use crate::errors::to_python;
use crate::navigate::Navigator;

/// Writes the log of a run on a thread of its own; wrapped by `cairn.record.Recorder`.
#[pyclass(module = "cairn._brain")]
pub struct Recorder {
    inner: cairn_record::Recorder,
}

#[pymethods]
impl Recorder {
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        let inner = cairn_record::Recorder::create(&path).map_err(|e| to_python(&e))?;
        Ok(Self { inner })
    }

    /// Puts a file beside the messages.
    fn attach(&self, py: Python<'_>, name: &str, media_type: &str, data: &[u8]) {
        let bytes = data.to_vec();
        py.detach(|| self.inner.attach(name, media_type, bytes));
    }

    /// Keeps every tick of the navigator from now on; its number comes back.
    fn follow(&mut self, name: &str, navigator: &mut Navigator) -> usize {
        let tap = self.inner.tap(name, navigator.inner.profile());
        let robot = tap.robot();
        navigator.tap = Some(tap);
        robot
    }

    /// Keeps the map as it is now and no more ticks of the navigator.
    #[staticmethod]
    fn leave(py: Python<'_>, navigator: &mut Navigator) {
        if let Some(tap) = navigator.tap.take() {
            let inner = &navigator.inner;
            py.detach(|| tap.end(inner));
        }
    }

    /// What the judge saw at the last tick of robot number `robot`.
    fn judged(
        &self,
        py: Python<'_>,
        robot: usize,
        time_s: f64,
        truth: Triple,
        clearance_m: f64,
    ) -> PyResult<()> {
        py.detach(|| self.inner.judged(robot, time_s, pose_of(truth), clearance_m))
            .and_then(|()| self.inner.check())
            .map_err(|e| to_python(&e))
    }

    /// Writes what is left and closes the file.
    fn finish(&mut self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.inner.finish()).map_err(|e| to_python(&e))
    }
}

/// Topic or name, time \[ns\] of a message, bytes.
type Entered<'py> = (String, Option<u64>, Bound<'py, PyBytes>);

/// What is in a log, in order: (topic, time [ns], bytes), and (name, None, bytes) for a file beside
/// the messages.
#[pyclass(module = "cairn._brain")]
pub struct LogReader {
    inner: Mutex<Log>,
}

impl LogReader {
    fn log(&self) -> MutexGuard<'_, Log> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl LogReader {
    #[new]
    #[pyo3(signature = (path, endings=None))]
    fn new(path: PathBuf, endings: Option<BTreeSet<String>>) -> PyResult<Self> {
        let log = Log::open(&path, endings).map_err(|e| to_python(&e))?;
        Ok(Self { inner: Mutex::new(log) })
    }

    /// Whether the log was read to an end that its writer put there.
    #[getter]
    fn complete(&self) -> bool {
        self.log().is_complete()
    }

    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__<'py>(&self, py: Python<'py>) -> PyResult<Option<Entered<'py>>> {
        let entry = py.detach(|| self.log().next_entry()).map_err(|e| to_python(&e))?;
        Ok(entry.map(|entry| match entry {
            Entry::Message { topic, time_ns, data } => (topic, Some(time_ns), PyBytes::new(py, &data)),
            Entry::Attachment { name, data } => (name, None, PyBytes::new(py, &data)),
        }))
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Recorder>()?;
    module.add_class::<LogReader>()
}
