//! The Python face of the brain. Convert, release the GIL, call, map errors; no mathematics.

use pyo3::prelude::*;

mod avoid;
mod bench;
mod convert;
mod errors;
mod graphs;
mod localise;
mod locate;
mod navigate;
mod plan;
mod pool;
mod record;
mod robot;
mod shapes;
mod terrain;
mod ticks;
mod track;
mod world;

#[pymodule]
fn _brain(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    robot::register(module)?;
    world::register(module)?;
    shapes::register(module)?;
    plan::register(module)?;
    pool::register(module)?;
    terrain::register(module)?;
    bench::register(module)?;
    graphs::register(module)?;
    track::register(module)?;
    avoid::register(module)?;
    locate::register(module)?;
    localise::register(module)?;
    navigate::register(module)?;
    record::register(module)?;
    ticks::register(module)?;
    Ok(())
}
