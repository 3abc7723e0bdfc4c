use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use cairn::geometry::Point2;
use cairn::locate::WheelTravel;
use cairn::navigate::{Decision, Mode, NavigateError, TickInput};
use cairn_record::Recorder;
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::convert::pose_of;
use crate::errors::to_python;
use crate::navigate::Navigator;

/// Parts of a tick, as [`cairn::navigate::TickPart`], then what recording it took.
const COLUMNS: usize = 7;

/// Times, and what the ticks did, row by row.
type Done = (Vec<f64>, Vec<f64>);

/// One row per tick.
type Table<'py> = Bound<'py, PyArray2<f64>>;

/// Drives a navigator with recorded inputs and times every part of every tick on this thread.
///
/// Arrays have one row per tick; NaN stands for a gyroscope or a pose that was not there. `goals` are
/// (tick before which it was given, x, y). With `record`, everything is logged there meanwhile.
/// Returns times [ns], (ticks, 7): locate, map, keep, mode, act, record, log; and (ticks, 4): the
/// command (V, ω), whether a plan was made, and the mode's number.
#[pyfunction]
#[pyo3(signature = (navigator, ranges, wheels, gyro, dt_s, poses, goals, record=None))]
#[allow(clippy::too_many_arguments)] // one per kind of measurement, as recorded
pub fn time_ticks<'py>(
    py: Python<'py>,
    navigator: &mut Navigator,
    ranges: PyReadonlyArray2<'py, f64>,
    wheels: PyReadonlyArray2<'py, f64>,
    gyro: PyReadonlyArray1<'py, f64>,
    dt_s: PyReadonlyArray1<'py, f64>,
    poses: PyReadonlyArray2<'py, f64>,
    goals: Vec<(usize, f64, f64)>,
    record: Option<PathBuf>,
) -> PyResult<(Table<'py>, Table<'py>)> {
    let (ranges, wheels, poses) = (ranges.as_array(), wheels.as_array(), poses.as_array());
    let (gyro, dt_s) = (gyro.as_array(), dt_s.as_array());
    let ticks = ranges.nrows();
    let rows: Vec<Vec<f64>> = ranges.rows().into_iter().map(|row| row.to_vec()).collect();
    let inputs: Vec<TickInput<'_>> = (0..ticks)
        .map(|i| TickInput {
            ranges_m: &rows[i],
            wheels: WheelTravel { left_m: wheels[[i, 0]], right_m: wheels[[i, 1]] },
            gyro_radps: Some(gyro[i]).filter(|rate| !rate.is_nan()),
            dt_s: dt_s[i],
            world_from_robot: (!poses[[i, 0]].is_nan())
                .then(|| pose_of((poses[[i, 0]], poses[[i, 1]], poses[[i, 2]]))),
        })
        .collect();
    let mut recorder = record.map(|path| Recorder::create(&path)).transpose().map_err(|e| to_python(&e))?;
    let mut tap = recorder.as_mut().map(|recorder| recorder.tap("robot", navigator.inner.profile()));
    let inner = &mut navigator.inner;
    let (times, done): Done = py
        .detach(|| -> Result<Done, NavigateError> {
            let mut times = Vec::with_capacity(ticks * COLUMNS);
            let mut done = Vec::with_capacity(ticks * 4);
            for (i, input) in inputs.iter().enumerate() {
                for &(_, x, y) in goals.iter().filter(|goal| goal.0 == i) {
                    inner.set_goal(Point2::new(x, y), None)?;
                }
                let mut last = Instant::now();
                let mut took = || {
                    let now = Instant::now();
                    let ns = now.duration_since(last).as_nanos() as f64;
                    last = now;
                    ns
                };
                let decision: Decision = inner.step_probed(input, |_| times.push(took()))?;
                let (twist, planned, mode) = (decision.twist, decision.plan.is_some(), decision.mode);
                took();
                if let Some(tap) = &mut tap {
                    tap.stepped(input, inner, &Arc::new(decision));
                }
                times.push(took());
                let mode = match mode {
                    Mode::Stop => 0.0,
                    Mode::PathPlanning => 1.0,
                    Mode::PathTracking => 2.0,
                    Mode::ObstacleAvoidance => 3.0,
                };
                done.extend([twist.linear_mps, twist.angular_radps, f64::from(u8::from(planned)), mode]);
            }
            Ok((times, done))
        })
        .map_err(|e| to_python(&e))?;
    drop(tap);
    if let Some(mut recorder) = recorder {
        py.detach(|| recorder.finish()).map_err(|e| to_python(&e))?;
    }
    Ok((times.into_pyarray(py).reshape([ticks, COLUMNS])?, done.into_pyarray(py).reshape([ticks, 4])?))
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(time_ticks, module)?)
}
