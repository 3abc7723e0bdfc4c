//! Memory that plans leave behind for the next plan: fresh pages cost as much as a solution.

use std::sync::{Arc, Mutex, PoisonError};

use cairn::plan::{Field, GridPlanner};
use pyo3::prelude::*;

/// The planner that nobody uses just now.
static IDLE: Mutex<Option<GridPlanner>> = Mutex::new(None);

fn idle() -> std::sync::MutexGuard<'static, Option<GridPlanner>> {
    IDLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Does something with a planner that may have memory already.
pub fn with_planner<R>(job: impl FnOnce(&mut GridPlanner) -> R) -> R {
    let mut planner = idle().take().unwrap_or_default();
    let result = job(&mut planner);
    idle().get_or_insert(planner);
    result
}

/// Takes a field's arrays back if nobody else holds it.
pub fn take_back(field: Arc<Field>) {
    let Some(field) = Arc::into_inner(field) else { return };
    if let Some(planner) = idle().as_mut() {
        planner.recycle(field);
    }
}

/// Gives the memory kept from one plan to the next back to the system.
#[pyfunction]
fn release_memory() {
    let planner = idle().take();
    drop(planner);
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(release_memory, module)?)
}
